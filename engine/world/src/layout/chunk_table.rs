//! Layout `chunk_table`: see `shaders/include/raxel/chunk_table.glsl` for the format.

use super::parts::Octant;
use super::{Access, Encoded, Layout, LayoutError, hashed_chunks};
use crate::world::World;

/// Words of the masks in front of a chunk: 64 bits for each of its eight 16³ nodes.
const MASK_WORDS: usize = 16;
/// Words of a chunk: its masks, then 32³ voxels, two a word.
const CHUNK_WORDS: usize = MASK_WORDS + 32 * 32 * 32 / 2;

pub(super) fn encode(world: &World, limit: u64, access: Access) -> Result<Encoded, LayoutError> {
    hashed_chunks::encode(world, Layout::ChunkTable, limit, access, CHUNK_WORDS, fill)
}

/// Writes the masks and voxels of a chunk.
fn fill(octant: &Octant, words: &mut [u32]) {
    let (masks, voxels) = words.split_at_mut(MASK_WORDS);
    for (words, mask) in masks.chunks_exact_mut(2).zip(octant.node_masks()) {
        words[0] = mask as u32;
        words[1] = (mask >> 32) as u32;
    }
    let voxels: &mut [u16] = bytemuck::cast_slice_mut(voxels);
    for ([x, y, z], material) in octant.voxels() {
        voxels[(x | y << 5 | z << 10) as usize] = material;
    }
}
