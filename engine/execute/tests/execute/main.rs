//! The executor on a real device, under the validation layer with synchronization validation. Without a driver these tests fail.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(clippy::float_cmp, reason = "values are chosen to be exact")]
#![allow(clippy::format_push_string, reason = "files are put together as they read")]

mod allocation;
mod bindings;
mod blocks;
mod clocks;
mod frames;
mod hang;
mod interpreter;
mod kept;
mod lab;
mod lists;
mod loops;
mod observed;
mod random;
mod random_shaders;
mod shown;
mod sources;
