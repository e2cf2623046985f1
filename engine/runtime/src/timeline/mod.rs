//! Demos: a world, a graph and a timeline of camera keys, param tracks, changes of graph and debug target, edits of the world, captions and
//! checks.
//!
//! What a demo shows is a function of the time alone, so that a window, a headless run and any part of a sharded run agree.

mod check;
mod curve;
mod demo;
mod edits;
mod read;
mod schema;

pub use curve::Interpolation;
pub use demo::{CameraKey, Caption, CaptionText, Check, Claim, DebugTargetKey, Demo, Direction, GraphKey, Track};
pub use edits::EditKey;
pub use read::read;
pub use schema::schema;
