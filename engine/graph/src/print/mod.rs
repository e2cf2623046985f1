//! Printers of plans: text for people, JSON for programs, DOT and Mermaid for pictures; and dumps of the phases.

mod dot;
mod dump;
mod json;
mod mermaid;
mod text;
mod words;

pub use dot::dot;
pub(crate) use dump::After;
pub use dump::Phase;
pub use json::json;
pub use mermaid::mermaid;
pub use text::text;
