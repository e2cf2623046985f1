//! Run time against error: the only crate above the runtime that needs the oracle. Nothing that draws a frame depends on it.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! * [`mod@bench`]: graphs × layouts × worlds × cameras, each timed on the device and judged ray by ray: `raxel bench`
//! * [`stress`]: tracers held to the exact one, in as many rays as one likes: `raxel stress`
//! * [`light`]: lighting systems held to a converged path tracer: `raxel bench light`
//! * [`rays`]: lists of rays through a world on the device, without a graph, for `stress` and tests
//! * [`save_latency`]: the time from a save to the picture that shows it: `raxel bench reload`
//! * [`demo`]: times of a demo's frames and of their passes: `raxel bench --demo`
//! * [`flight`]: frame times while a world is loaded around a moving camera: `raxel bench stream`

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod bench;
pub mod demo;
pub mod flight;
pub mod light;
pub mod rays;
pub mod save_latency;
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "sets, instances and cells of a set of rays are few and small, and rays are 32-bit floats"
)]
pub mod stress;
mod times;

pub use times::Times;
