//! Data between the phases: the checked graph, the plan, and the types of both.

pub mod checked;
pub(crate) mod index;
mod input;
pub mod plan;
pub mod size;
pub(crate) mod subresources;
pub mod supply;
pub mod value;
