//! Run time against error: the only crate above the runtime that needs the oracle. Nothing that draws a frame depends on it.

pub mod bench;
pub mod rays;
pub mod reload;
pub mod stress;
