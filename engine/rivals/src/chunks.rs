//! Layout `chunks`: see `shaders/include/raxel/rivals/internal/layouts/chunks.glsl` for the format.

use raxel_world::World;
use rayon::prelude::*;

use raxel_layouts::parts::{Octant, Parts};
use raxel_layouts::{
    ADDRESSABLE, Access, Encoded, Encoding, Extent, Layout, LayoutError, MATERIAL_WORDS, buffer, check_size,
    layout_header,
};

/// A list of 32³ flat chunks that is searched linearly.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding = Encoding {
    has_set: true,
    ..Encoding::new("chunks", ChunksHeader::block, |world, limits, access| encode(world, limits.buffer_bytes, access))
};

/// Voxels along an edge of one of this layout's chunks.
const EDGE: i32 = 32;
/// Words of the voxels of a chunk: two voxels a word.
const VOXEL_WORDS: usize = 32 * 32 * 32 / 2;
/// Words of a chunk in the list: its key in front, and its entry.
const LIST_WORDS: usize = 5;

layout_header! {
    /// Header of the layout `chunks`. Addresses (`…_at`) count words from the first word behind the header.
    ChunksHeader {
        /// Address of the list: a key of each chunk, then for each x, y, z in chunks, and the address of its voxels.
        chunks_at: u32,
        /// Chunks.
        chunk_count: u32,
        /// Address of the first voxel.
        voxels_at: u32,
        /// Chunks of voxels: equal chunks share them.
        voxel_chunks: u32,
    }
}

fn encode(world: &World, limit: u64, access: Access) -> Result<Encoded, LayoutError> {
    let layout = LAYOUT;
    let mut extent = Extent::of(world, layout)?;
    let Parts { distinct, uses } = Parts::octants(world, &extent).for_access(access);
    if access == Access::Write {
        extent.round_out(EDGE);
    }
    let corner = extent.origin.map(|origin| origin / EDGE);
    let list = uses.iter().map(|(cell, part)| ([0, 1, 2].map(|i| corner[i] + cell[i].cast_signed()), part));

    let chunks_at = MATERIAL_WORDS as usize * world.materials().len();
    let voxels_at = chunks_at + LIST_WORDS * uses.len();
    let words = ChunksHeader::WORDS as usize + voxels_at + VOXEL_WORDS * distinct.len();
    let bytes = check_size(layout, 4 * words as u64, limit.min(ADDRESSABLE))?;

    let header = ChunksHeader {
        chunks_at: chunks_at as u32,
        chunk_count: uses.len() as u32,
        voxels_at: voxels_at as u32,
        voxel_chunks: distinct.len() as u32,
        ..ChunksHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let (front, voxels) = buffer.split_at_mut(ChunksHeader::WORDS as usize + voxels_at);
    let (keys, entries) = front[ChunksHeader::WORDS as usize + chunks_at..].split_at_mut(uses.len());
    for (((pos, part), key), entry) in list.zip(keys).zip(entries.chunks_exact_mut(LIST_WORDS - 1)) {
        // The search compares keys: ten bits of each coordinate.
        let [x, y, z] = pos.map(i32::cast_unsigned);
        *key = x & 1023 | (y & 1023) << 10 | (z & 1023) << 20;
        entry.copy_from_slice(&[x, y, z, (voxels_at + VOXEL_WORDS * part) as u32]);
    }
    voxels.par_chunks_exact_mut(VOXEL_WORDS).zip(&distinct).for_each(|(words, octant)| {
        fill(octant, bytemuck::cast_slice_mut(words));
    });
    let attribute_bytes = 4 * u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

/// Writes the voxels of a chunk.
fn fill(octant: &Octant, voxels: &mut [u16]) {
    for ([x, y, z], material) in octant.voxels() {
        voxels[(x | y << 5 | z << 10) as usize] = material;
    }
}
