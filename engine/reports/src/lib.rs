//! `raxel bench` and `raxel stress`: what `raxel-measure` measures, as tables, charts and files.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod bench;
pub mod stress;
