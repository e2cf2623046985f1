//! Lists of rays through a world on the device, without a graph: for judging tracers by the exact one, and for programs that ask where
//! a ray goes. A [`Tracer`] is the GLSL of one layout; a [`Stream`] carries rays to the device and hits back, in two slots, so that the
//! device traces one part of a list while the host looks at the hits of the part before.
//!
//! ```no_run
//! use std::sync::Arc;
//!
//! use raxel_diagnostics::MemoryFiles;
//! use raxel_gpu::{Device, DeviceOptions};
//! use raxel_oracle::Ray;
//! use raxel_measure::rays::{Method, Stream, Tracer};
//! use raxel_world::World;
//! use raxel_layouts::Layout;
//!
//! let device = Device::new(&DeviceOptions::default())?;
//! let mut tracer = Tracer::new(&device, Arc::new(MemoryFiles::default()), &Method::of(Layout::TREE64))?;
//! let world = tracer.upload(&World::empty())?;
//! let rays = vec![Ray::new([0; 3], [0.5; 3], [0.0, 0.0, -1.0]); 1000];
//! let traced = Stream::new(&device)?.trace_all(&mut tracer, &world, &rays)?;
//! assert!(traced.iter().all(|hit| hit.hit().is_none()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod masks;
mod stream;
mod tracer;
mod words;

pub use error::RayError;
pub use stream::{Stream, Traced};
pub use tracer::{DeviceWorld, Method, Tracer};
pub use words::{HitWords, OnwardRay, RayWords, State, VoxelEdit, Work, bounced};
