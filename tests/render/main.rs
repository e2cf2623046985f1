//! `raxel render` on a real device: bytes that repeat, every kind of output, and its errors.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

#[path = "../common/mod.rs"]
mod common;

mod files;
mod frames;
mod mistakes;
mod scenes;
mod shaders;

use std::path::Path;

use common::{Run, raxel};

/// A quick picture of the shipped graph that needs no big world.
const MENGER: [&str; 6] = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "96x54"];

fn menger(more: &[&str]) -> Run {
    raxel(&[&MENGER[..], more].concat())
}

fn decoded(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}
