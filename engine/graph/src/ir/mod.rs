//! What the phases hand on: the checked graph, the plan, and the types that both are made of.

pub mod checked;
pub(crate) mod index;
mod input;
pub mod plan;
pub mod size;
pub(crate) mod subresources;
pub mod supply;
pub mod value;
