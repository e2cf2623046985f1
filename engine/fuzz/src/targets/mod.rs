//! The targets, one a file.

pub(crate) mod demo;
pub(crate) mod graph;
pub(crate) mod pictures;
pub(crate) mod project;
pub(crate) mod save;
pub(crate) mod shader_text;
pub(crate) mod spirv;
pub(crate) mod vox;
pub(crate) mod world;
pub(crate) mod world_whole;
pub(crate) mod zarr;
