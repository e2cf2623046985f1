//! Printers of plans: text for people, JSON for programs, DOT and Mermaid for pictures.

mod dot;
mod json;
mod mermaid;
mod text;
pub(crate) mod words;

pub use dot::dot;
pub use json::json;
pub use mermaid::mermaid;
pub use text::text;

use crate::ir::plan::Plan;

/// Bytes that the targets and buffers of a plan take, those that share memory once. What comes from outside does not count.
pub fn allocated(plan: &Plan) -> u64 {
    words::memory(plan).allocated
}
