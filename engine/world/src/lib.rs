//! Voxel worlds: what they are, how files build them, how models come in and go out, and how the GPU sees them.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

pub mod build;
mod chunk;
mod dense;
pub mod file;
pub mod generate;
pub mod instances;
pub mod layout;
pub mod lights;
mod material;
mod orientation;
pub mod random;
mod side;
mod tile;
pub mod vox;
mod world;

pub use chunk::{
    BLOCKS, Bits, BlockVoxels, CHUNK_EDGE, CHUNK_VOXELS, Chunk, block_cell, block_index, child_cell, child_index,
    voxel_index,
};
pub use dense::{DenseChunk, Mode};
pub use file::{
    Aim, CameraHint, Loaded, OnGeneratorChange, OpenSource, SaveSettings, StreamSettings, Streamed, load, load_with,
    schema,
};
pub use material::{AIR, MAX_MATERIALS, Material, MaterialIndex, linear_from_srgb, srgb_from_linear};
pub use orientation::{Orientation, Placement};
pub use side::Side;
pub use tile::{Cause, ChunkSource, Content, MAX_LEVEL, Unavailable, cell_edge, reduce};
pub use world::{Bounds, ChunkPos, Info, MaterialInfo, World};
