//! The command line as its users and their scripts see it: exit codes, stdout and stderr, JSON, bad files.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

#[path = "../common/mod.rs"]
mod common;

mod check;
mod plans;
mod projects;
mod words;
