//! Fuzz targets of every parser and protocol: each is a function of some bytes, which may be anything, that panics when a promise is broken.
//!
//! `tests/replay.rs` runs the corpus and mutations of it with fixed seeds, with every other test. docs/fuzzing.md explains their use.

mod bounds;
mod check;
mod mutate;
mod projects;
mod target;
mod targets;

pub use bounds::alone;
pub use mutate::Mutation;
pub use target::Target;

/// Every target, in order of name.
pub const TARGETS: &[Target] = &[
    targets::demo::TARGET,
    targets::pictures::EXR,
    targets::graph::TARGET,
    targets::pictures::PNG,
    targets::project::TARGET,
    targets::save::TARGET,
    targets::shader_text::TARGET,
    targets::spirv::TARGET,
    targets::vox::TARGET,
    targets::world::TARGET,
    targets::world_whole::TARGET,
    targets::zarr::TARGET,
];

/// The target of that name.
pub fn find(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}
