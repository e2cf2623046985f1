//! From a checked graph to an immutable plan. No GPU, no I/O; `raxel-graphfile` makes checked graphs from files.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! - `ir` holds the data: the checked graph ([`checked`]) and the plan ([`plan`](mod@plan)).
//! - `back` makes the plan: sizes → unroll → cull → order → lifetimes → varies → alias → barriers.
//! - [`print`](mod@print) shows a plan as text, JSON, DOT or Mermaid.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod back;
mod ir;
pub mod print;

pub use back::{EstimatedMemory, Need, Phase, dump, local_size, needs, plan, rarely_met};
pub use ir::index::index32;
pub use ir::supply::{Catalog, FileContents, FileImage, ImageRequest, Plays, Refusal, Sound, SourceLayout, Video};
pub use ir::value::ValueType;
pub use ir::{checked, plan, size, supply, value};
