//! Layout `chunk_table`: see `shaders/include/raxel/rivals/internal/layouts/chunk_table.glsl` for the format.

use raxel_world::{Bits, child_cell};

use raxel_layouts::hashed_chunks::Form;
use raxel_layouts::parts::{Octant, unmorton};
use raxel_layouts::{Edits, Encoding, HashedChunksHeader, Layout, Patch, hashed_chunks};

/// Flat 32³ chunks with occupancy masks in a hash table.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding = Encoding {
    has_set: true,
    edits: Edits::HashedChunks(&FORM),
    ..Encoding::new("chunk_table", HashedChunksHeader::block, |world, limits, access| {
        hashed_chunks::encode(world, &FORM, limits.buffer_bytes, access)
    })
};

/// Words of the masks in front of a chunk: 64 bits for each of its eight 16³ nodes.
const MASK_WORDS: usize = 16;
/// Words of a chunk: its masks, then 32³ voxels, two a word.
const CHUNK_WORDS: usize = MASK_WORDS + 32 * 32 * 32 / 2;

static FORM: Form = Form { layout: Layout::new(&ENCODING), chunk_words: CHUNK_WORDS, fill, rewrite, most_parts: 32 };

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
