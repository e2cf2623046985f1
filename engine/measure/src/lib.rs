//! Run time against error: the only crate above the runtime that needs the oracle. Nothing that draws a frame depends on it.
//!
//! * [`bench`]: graphs × layouts × worlds × cameras, each timed on the device and judged ray by ray: `raxel bench`
//! * [`stress`]: tracers held to the exact one, in as many rays as one likes: `raxel stress`
//! * [`light`]: lighting systems held to a converged path tracer: `raxel bench light`
//! * [`rays`]: lists of rays through a world on the device, without a graph: what `stress` and tests trace with
//! * [`save_latency`]: the time from a save to the picture that shows it: `raxel bench reload`
//! * [`demo`]: times of a demo's frames and of their passes: `raxel bench --demo`
//! * [`flight`]: frame times while a world is loaded around a moving camera: `raxel bench stream`

pub mod bench;
pub mod demo;
pub mod flight;
pub mod light;
pub mod rays;
pub mod save_latency;
pub mod stress;
mod times;

pub use times::Times;
