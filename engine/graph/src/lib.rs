//! The render-graph compiler: a TOML file in, an immutable plan out. No GPU; no I/O but the files it is given.
//!
//! - `front` reads the file and its shaders, and reports every mistake: parse → extends → resolve → reflect → check.
//! - `ir` holds the data between the phases: the checked graph ([`checked`]) and the plan ([`plan`](mod@plan)).
//! - `back` makes the plan: sizes → unroll → cull → order → lifetimes → varies → alias → barriers.
//! - [`print`](mod@print) shows a plan as text, JSON, DOT or Mermaid.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod back;
mod front;
mod ir;
pub mod print;

pub use back::{EstimatedMemory, Phase, dump, plan};
pub use front::schema::schema;
pub use front::{Compiled, Replace, compile, compile_with};
pub use ir::supply::{Catalog, FileContents, FileImage, ImageRequest, Refusal, SourceLayout};
pub use ir::value::ValueType;
pub use ir::{checked, plan, size};
