//! Demos: a world, a graph and a timeline of camera keys, param tracks and changes of the debug target.
//!
//! What a demo shows is a function of the time alone, so that a window, a headless run and any part of a sharded run agree.

mod check;
mod curve;
mod demo;
mod read;
mod schema;

pub use curve::Interpolation;
pub use demo::{CameraKey, DebugTargetKey, Demo, Direction, Place, Track};
pub use read::read;
pub use schema::schema;
