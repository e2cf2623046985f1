//! The front end: graph files and shaders in, a checked graph or diagnostics out. Shaders go through the real compiler.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod clocks;
mod errors;
mod extends;
mod files;
mod happy;
mod loops;
mod modules;
mod mutations;
mod schema;
mod shared_blocks;
mod supplied;
mod variants;
