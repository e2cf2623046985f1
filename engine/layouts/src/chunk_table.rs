//! Layout `chunk_table`: see `shaders/include/raxel/chunk_table.glsl` for the format.

use super::hashed_chunks::Form;
use super::live::Patch;
use super::parts::{Octant, unmorton};
use super::{Access, Encoded, Layout, LayoutError, hashed_chunks};
use raxel_world::World;
use raxel_world::{Bits, child_cell};

/// Words of the masks in front of a chunk: 64 bits for each of its eight 16³ nodes.
const MASK_WORDS: usize = 16;
/// Words of a chunk: its masks, then 32³ voxels, two a word.
const CHUNK_WORDS: usize = MASK_WORDS + 32 * 32 * 32 / 2;

pub(super) const FORM: Form =
    Form { layout: Layout::ChunkTable, chunk_words: CHUNK_WORDS, fill, rewrite, most_parts: 32 };

pub(super) fn encode(world: &World, limit: u64, access: Access) -> Result<Encoded, LayoutError> {
    hashed_chunks::encode(world, &FORM, limit, access)
}

/// Writes the masks and voxels of a chunk.
fn fill(octant: &Octant, words: &mut [u32]) {
    let (masks, voxels) = words.split_at_mut(MASK_WORDS);
    masks.copy_from_slice(&mask_words(octant));
    let voxels: &mut [u16] = bytemuck::cast_slice_mut(voxels);
    for ([x, y, z], material) in octant.voxels() {
        voxels[(x | y << 5 | z << 10) as usize] = material;
    }
}

fn mask_words(octant: &Octant) -> [u32; MASK_WORDS] {
    let masks = octant.node_masks();
    std::array::from_fn(|i| (masks[i / 2] >> (32 * (i % 2))) as u32)
}

/// The masks, and the rows of four voxels in some 4³ blocks of a chunk.
fn rewrite(octant: &Octant, blocks: &[u32]) -> Vec<Patch> {
    let mut patches = vec![Patch { at: 0, words: mask_words(octant).to_vec() }];
    for &block in blocks {
        let mut rows = [[0_u32; 2]; 16];
        let at = octant.block(block);
        for (bit, material) in Bits(octant.chunk.mask(at)).zip(octant.chunk.block_materials(at)) {
            let [x, y, z] = child_cell(bit);
            rows[(y | z << 2) as usize][x as usize / 2] |= u32::from(material) << (16 * (x & 1));
        }
        let [x, y, z] = unmorton(block).map(|c| 4 * c);
        for (row, words) in (0..).zip(rows) {
            let voxel = x | (y + (row & 3)) << 5 | (z + (row >> 2)) << 10;
            patches.push(Patch { at: MASK_WORDS + voxel as usize / 2, words: words.to_vec() });
        }
    }
    patches
}
