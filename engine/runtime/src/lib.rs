//! Sessions: open a project, run its graph over its world, drive it by params and demos, and swap in every edit while it runs.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! ```no_run
//! use raxel_graph::checked::Value;
//! use raxel_runtime::{Options, Session};
//!
//! let mut session = Session::open(Options { watch: true, ..Options::default() })?;
//! session.set_param("exposure", Value::F32(2.0))?;
//! session.set_push("primary", "fog", Value::F32(0.0))?;
//! for _ in 0..60 {
//!     for event in session.poll_reload() {
//!         println!("{event:?}");
//!     }
//!     session.frame()?;
//! }
//! let depth = session.read_target("depth")?.floats();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod build;
mod build_error;
pub mod builtins;
mod editing;
pub mod load;
pub mod manifest;
pub mod present;
pub mod project;
mod recording_files;
pub mod reload;
pub mod runner;
pub mod session;
pub mod sources;
pub mod world;

pub use build::{fits, holds_on};
pub use build_error::BuildError;
pub use editing::{SavedWorld, Saves};
pub use raxel_graph::plan::Observe;
pub use raxel_timeline::{self as timeline, camera, clock, debug_target, inputs, params, take};
pub use session::{EditFailure, FrameError, ManifestDefaults, OpenError, Options, ReadError, Session};
