//! Demos: a world, a graph and a timeline of camera keys, param tracks, inputs, changes of graph and debug target, edits of the world, captions and
//! checks.
//!
//! What a demo shows is a function of the time alone, so that a window, a headless run and any part of a sharded run agree.

mod check;
mod curve;
mod demo;
mod edits;
mod inputs;
mod read;

pub use curve::Interpolation;
pub use demo::{
    CameraKey, Caption, CaptionText, Check, Claim, DebugTargetKey, Demo, GraphKey, Looked, Place, Track, TrackKeys,
};
pub use edits::{EditKey, operations};
pub use inputs::{ButtonKeys, CursorKeys, DemoInputs, KeyboardKeys, WheelKeys};
pub use read::{read, schema};
