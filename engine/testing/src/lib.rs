//! Helpers that the tests of several crates share. A helper that only one crate needs stays in that crate's tests. A helper for its
//! unit tests stays there, too: they would see the crate's types twice, once as compiled for the test and once as this crate knows
//! them.

mod child;
mod display;
mod folder;
#[cfg(feature = "light")]
pub mod path_tracer;
mod project;
mod random;
#[cfg(feature = "stream")]
mod reachable_set;
#[cfg(feature = "stream")]
mod union;
#[cfg(feature = "stream")]
mod words;

pub use child::{LIMIT, Running, Said, line, output, read_all};
pub use display::{Display, eventually};
pub use folder::{Folder, copy, files, repository};
pub use project::Project;
pub use random::Random;
#[cfg(feature = "stream")]
pub use reachable_set::ReachableSet;
#[cfg(feature = "stream")]
pub use union::union;
#[cfg(feature = "stream")]
pub use words::Words;
