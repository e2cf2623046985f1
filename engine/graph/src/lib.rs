//! The render-graph compiler: a TOML file in, an immutable plan out. No GPU; no I/O but the files it is given.

mod alias;
mod barriers;
pub mod checked;
mod cull;
mod describe;
mod lifetimes;
mod limits;
pub mod memory;
mod order;
pub mod plan;
mod planner;
mod region;
pub mod sizes;

pub use memory::EstimatedMemory;
pub use planner::plan;
