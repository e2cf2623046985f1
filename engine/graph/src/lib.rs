//! The render-graph compiler: a TOML file in, an immutable plan out. No GPU; no I/O but the files it is given.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod alias;
mod barriers;
mod check;
pub mod checked;
mod compile;
mod cull;
mod describe;
mod extends;
mod imply;
mod index;
mod lifetimes;
mod limits;
pub mod memory;
mod model;
mod order;
mod parse;
pub mod plan;
mod planner;
mod poison;
pub mod print;
mod queues;
mod reflect;
mod resolve;
mod schema;
pub mod sizes;
mod subresources;
mod supply;
mod unroll;
mod updates;
mod value;
mod varies;

pub use compile::{Compiled, Replace, compile, compile_with};
pub use memory::EstimatedMemory;
pub use planner::{dump, plan};
pub use schema::schema;
pub use supply::{Catalog, FileContents, FileImage, ImageRequest, Refusal, SourceLayout};
pub use value::ValueType;
