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
