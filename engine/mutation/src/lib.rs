//! Plants faults in Rust sources, all in one build, and lists the faults that no test notices. docs/mutation.md explains how to run it.

pub mod build;
pub mod groups;
pub mod plant;
pub mod run;
