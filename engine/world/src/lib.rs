//! Voxels: chunks of them, their materials, tiles of worlds without end, and models as .vox files.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod chunk;
mod dense;
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
pub use material::{AIR, MAX_MATERIALS, Material, MaterialIndex, linear_from_srgb, srgb_from_linear};
pub use orientation::{Orientation, Placement};
pub use side::Side;
pub use tile::{Cause, ChunkProvider, Content, MAX_LEVEL, Unavailable, cell_edge, reduce};
pub use world::{Bounds, ChunkPos, Info, MaterialInfo, World};
