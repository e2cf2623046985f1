//! Layout `chunk_table`: see `shaders/include/raxel/chunk_table.glsl` for the format.

use rayon::prelude::*;

use super::block::{BlockMember, GlslType, WORDS_STRIDE, header};
use super::header::{Extent, MATERIAL_WORDS, buffer};
use super::parts::{Octant, Parts};
use super::table::Table;
use super::{Encoded, Layout, LayoutError, check_size};
use crate::world::World;

/// Words of the masks in front of a chunk: 64 bits for each of its eight 16³ nodes.
const MASK_WORDS: usize = 16;
/// Words of a chunk: its masks, then 32³ voxels, two a word.
const CHUNK_WORDS: usize = MASK_WORDS + 32 * 32 * 32 / 2;
/// Chunks have 2^5 voxels a side.
const LOG2_EDGE: u32 = 5;

header! {
    /// Header of the layout `chunk_table`. Addresses (`…_at`) count words from the first word behind the header.
    ChunkTableHeader {
        /// Smallest corner of a cube around the world, in voxels.
        origin: [i32; 3],
        /// The cube has 2^`log2_size` voxels a side.
        log2_size: u32,
        /// Smallest coordinates of solid voxels.
        bounds_min: [i32; 3],
        /// Materials, air included.
        material_count: u32,
        /// Largest coordinates of solid voxels.
        bounds_last: [i32; 3],
        /// Address of the first material.
        materials_at: u32,
        /// Address of the hash table.
        table_at: u32,
        /// The table has 2^`log2_slots` slots.
        log2_slots: u32,
        /// Address of the first chunk.
        chunks_at: u32,
        /// Chunks of voxels: equal chunks share them.
        chunk_count: u32,
    }
}

pub(super) fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = Layout::ChunkTable;
    let extent = Extent::of(world, layout)?;
    let parts = Parts::octants(world, &extent);
    let cells = parts.uses.iter().map(|&(cell, index)| (cell, index as u32));
    let table = Table::new(cells, LOG2_EDGE, extent.log2_size);

    let materials_at = 0;
    let table_at = MATERIAL_WORDS as usize * world.materials().len();
    let chunks_at = table_at + table.words();
    let words = ChunkTableHeader::WORDS as usize + chunks_at + CHUNK_WORDS * parts.distinct.len();
    // Addresses are 32 bits wide and count words.
    let bytes = check_size(layout, 4 * words as u64, limit.min(4 << 32))?;

    let header = ChunkTableHeader {
        origin: extent.origin,
        log2_size: extent.log2_size,
        bounds_min: extent.bounds_min,
        material_count: world.materials().len() as u32,
        bounds_last: extent.bounds_last,
        materials_at,
        table_at: table_at as u32,
        log2_slots: table.log2_slots(),
        chunks_at: chunks_at as u32,
        chunk_count: parts.distinct.len() as u32,
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let (front, chunks) = buffer.split_at_mut(ChunkTableHeader::WORDS as usize + chunks_at);
    let slots = &mut front[ChunkTableHeader::WORDS as usize + table_at..];
    table.write(slots, LOG2_EDGE, |index| (chunks_at + CHUNK_WORDS * index as usize) as u32);
    chunks.par_chunks_exact_mut(CHUNK_WORDS).zip(&parts.distinct).for_each(|(words, octant)| fill(octant, words));

    // A voxel's halfword says both whether it is solid and what it is made of, so voxels count as geometry.
    let attribute_bytes = 4 * u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

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
