//! The common part of the layouts `chunk_table` and `octree`: chunks of one size in a hash table. See
//! `shaders/include/raxel/internal/hashed_chunks.glsl`.

mod live;

pub use live::LiveHashedChunks;
use raxel_world::World;
use rayon::prelude::*;

use super::block::layout_header;
use super::header::{Extent, MATERIAL_WORDS, buffer};
use super::live::Patch;
use super::parts::{Octant, Parts};
use super::table::Table;
use super::{ADDRESSABLE, Access, Encoded, Layout, LayoutError, check_size};

/// Chunks have 2^5 voxels a side.
const LOG2_EDGE: u32 = 5;

layout_header! {
    /// Header of the layouts `chunk_table` and `octree`. Addresses (`…_at`) count words from the first word behind the header.
    HashedChunksHeader {
        /// Address of the hash table of chunks.
        table_at: u32,
        /// The table has 2^`log2_slots` slots.
        log2_slots: u32,
        /// Address of the first chunk.
        chunks_at: u32,
        /// Different chunks: equal chunks share them.
        chunk_count: u32,
    }
}

/// A layout's part of a chunk.
pub struct Form {
    /// The layout.
    pub layout: Layout,
    /// Words of a chunk.
    pub chunk_words: usize,
    /// Writes a chunk over zeros.
    pub fill: fn(&Octant, &mut [u32]),
    /// Gives the words of a chunk that depend on some of its 4³ blocks, which are sorted and numbered as in [`Octant::block`]. No two
    /// patches overlap.
    pub rewrite: fn(&Octant, &[u32]) -> Vec<Patch>,
    /// Most changed blocks that are rewritten one by one. With more of them, it is faster to write the whole chunk.
    pub most_parts: usize,
}

/// Puts a world into 32³ chunks. All of them count as geometry: in both layouts, the same words hold the places of voxels and their
/// materials.
pub fn encode(world: &World, form: &Form, limit: u64, access: Access) -> Result<Encoded, LayoutError> {
    let &Form { layout, chunk_words, fill, .. } = form;
    let mut extent = Extent::of(world, layout)?;
    let parts = Parts::octants(world, &extent).for_access(access);
    if access == Access::Write {
        extent.round_out(1 << LOG2_EDGE);
    }
    let cells = parts.uses.iter().map(|&(cell, index)| (cell, index as u32));
    let table = Table::new(cells, LOG2_EDGE, extent.log2_size);

    let table_at = MATERIAL_WORDS as usize * world.materials().len();
    let chunks_at = table_at + table.words();
    let words = HashedChunksHeader::WORDS as usize + chunks_at + chunk_words * parts.distinct.len();
    let bytes = check_size(layout, 4 * words as u64, limit.min(ADDRESSABLE))?;

    let header = HashedChunksHeader {
        table_at: table_at as u32,
        log2_slots: table.log2_slots(),
        chunks_at: chunks_at as u32,
        chunk_count: parts.distinct.len() as u32,
        ..HashedChunksHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let (front, chunks) = buffer.split_at_mut(HashedChunksHeader::WORDS as usize + chunks_at);
    let slots = &mut front[HashedChunksHeader::WORDS as usize + table_at..];
    table.write(slots, LOG2_EDGE, |index| (chunks_at + chunk_words * index as usize) as u32);
    chunks.par_chunks_exact_mut(chunk_words).zip(&parts.distinct).for_each(|(words, octant)| fill(octant, words));

    let attribute_bytes = 4 * u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}
