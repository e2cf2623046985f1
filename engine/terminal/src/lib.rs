//! Pieces that the verbs of the command line share: arguments, the console, failures and their exit codes, sessions as the command line
//! asks for them, and projects that are read without a device.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod args;
pub mod cache;
pub mod console;
pub mod device;
pub mod failure;
pub mod offline;
pub mod prints;
pub mod program;
pub mod session;
pub mod trace;
