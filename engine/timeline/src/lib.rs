//! The state that a session shows at each moment: its clock, its camera, its params, its inputs, its debug target, and demos, which set all
//! of these.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! A demo is a world, a graph and a timeline of camera keys, param tracks, inputs, changes of graph and debug target, edits of the world,
//! captions and checks. It is a function of the time alone, so that a window, a headless run and any part of a sharded run agree.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod camera;
mod check;
pub mod clock;
mod curve;
pub mod debug_target;
mod demo;
mod demo_inputs;
mod edits;
pub mod inputs;
pub mod params;
mod read;
pub mod take;

pub use curve::Interpolation;
pub use demo::{
    CameraKey, Caption, CaptionEdge, CaptionText, Check, Claim, DebugTargetKey, Demo, GraphKey, Looked, Track,
    TrackKeys,
};
pub use demo_inputs::{
    ButtonKeys, CursorKeys, DemoInputs, GamepadButtonKeys, KeyboardKeys, StickKeys, TriggerKeys, WheelKeys,
};
pub use edits::{EditKey, operations};
pub use read::{read, schema};
