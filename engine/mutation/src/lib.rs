//! Plants faults in Rust sources, all in one build, and says which of them no test notices. docs/mutation.md tells how to run it.

pub mod build;
pub mod groups;
pub mod plant;
pub mod run;
