//! `raxel bench` and `raxel stress`: the measurements of `raxel-measure`, as tables, charts and files.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod bench;
pub mod stress;
