//! What a window and a program do with a session: they list its files, write values into them, keep presets, change keys of demos, and compare
//! pictures.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod demo;
pub mod demo_keys;
pub mod display;
pub mod files;
pub mod kept;
pub mod presets;
pub mod recording;
pub mod tracks;
pub mod write_back;
pub mod writes;
