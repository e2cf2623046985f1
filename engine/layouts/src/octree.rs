//! Layout `octree`: see `shaders/include/raxel/internal/layouts/octree.glsl` for the format.

use raxel_world::{Bits, child_cell};

use super::hashed_chunks::{Form, HashedChunksHeader};
use super::live::Patch;
use super::parts::Octant;
use super::{Edits, Encoding, Layout, hashed_chunks};

pub(super) static ENCODING: Encoding = Encoding {
    has_set: true,
    edits: Edits::HashedChunks(&FORM),
    ..Encoding::new("octree", HashedChunksHeader::block, |world, limits, access| {
        hashed_chunks::encode(world, &FORM, limits.buffer_bytes, access)
    })
};

/// Chunks have 2^5 voxels a side: depths 0 (the chunk) to 5 (voxels).
const DEPTHS: u32 = 5;
/// Nodes of a chunk, empty ones included, one word each.
const CHUNK_WORDS: usize = first_node(DEPTHS + 1);
/// Depth of nodes of 4³ voxels: the blocks of a chunk.
const BLOCKS: u32 = 3;
/// Bits of a node all of whose voxels are solid and of one material: the mask of all children, and the bit that marks such nodes.
const FILLED: u32 = 0x1ff;

/// Index in a chunk of the first node of a depth: 1 + 8 + … + 8^(depth − 1).
const fn first_node(depth: u32) -> usize {
    ((1usize << (3 * depth)) - 1) / 7
}

static FORM: Form = Form { layout: Layout::new(&ENCODING), chunk_words: CHUNK_WORDS, fill, rewrite, most_parts: 128 };

/// Writes the nodes of a chunk: its voxels, then each depth from the one below.
fn fill(octant: &Octant, nodes: &mut [u32]) {
    let voxels = &mut nodes[first_node(DEPTHS)..];
    for (cell, material) in octant.voxels() {
        voxels[morton(cell)] = u32::from(material) << 16 | FILLED;
    }
    for depth in (0..DEPTHS).rev() {
        let (here, below) = nodes[first_node(depth)..].split_at_mut(1 << (3 * depth));
        for (node, children) in here.iter_mut().zip(below.chunks_exact(8)) {
            *node = parent(children);
        }
    }
}

/// The nodes in some 4³ blocks of a chunk, and those above them.
fn rewrite(octant: &Octant, blocks: &[u32]) -> Vec<Patch> {
    let nodes: Vec<([u32; 64], [u32; 8], u32)> = blocks.iter().map(|&block| block_nodes(octant, block)).collect();
    let mut patches = Vec::new();
    for (&block, (voxels, _, _)) in blocks.iter().zip(&nodes) {
        append(&mut patches, first_node(DEPTHS) + 64 * block as usize, voxels);
    }
    for (&block, (_, pairs, _)) in blocks.iter().zip(&nodes) {
        append(&mut patches, first_node(BLOCKS + 1) + 8 * block as usize, pairs);
    }
    for (&block, (_, _, node)) in blocks.iter().zip(&nodes) {
        append(&mut patches, first_node(BLOCKS) + block as usize, &[*node]);
    }
    for depth in (0..BLOCKS).rev() {
        let mut above: Vec<u32> = blocks.iter().map(|block| block >> (3 * (BLOCKS - depth))).collect();
        above.dedup();
        for index in above {
            append(&mut patches, first_node(depth) + index as usize, &[node(octant, depth, index)]);
        }
    }
    patches
}

/// Adds words to the last patch where they go on from it.
fn append(patches: &mut Vec<Patch>, at: usize, words: &[u32]) {
    match patches.last_mut() {
        Some(last) if last.at + last.words.len() == at => last.words.extend_from_slice(words),
        _ => patches.push(Patch { at, words: words.to_vec() }),
    }
}

/// The nodes in a 4³ block: its voxels, its eighths and itself.
fn block_nodes(octant: &Octant, block: u32) -> ([u32; 64], [u32; 8], u32) {
    let at = octant.block(block);
    let mut voxels = [0; 64];
    for (bit, material) in Bits(octant.chunk.mask(at)).zip(octant.chunk.block_materials(at)) {
        voxels[morton(child_cell(bit))] = u32::from(material) << 16 | FILLED;
    }
    let pairs = std::array::from_fn(|i| parent(&voxels[8 * i..][..8]));
    (voxels, pairs, parent(&pairs))
}

/// A node above the 4³ blocks, from the blocks in it.
fn node(octant: &Octant, depth: u32, index: u32) -> u32 {
    let count = 1 << (3 * (BLOCKS - depth));
    let blocks = count * index..count * (index + 1);
    let mask_of = |block: u32| octant.chunk.mask(octant.block(block));
    let Some(first) = blocks.clone().find(|block| mask_of(*block) != 0) else { return 0 };
    let material = block_nodes(octant, first).2 >> 16;
    let filled = |block: u32| {
        let at = octant.block(block);
        octant.chunk.mask(at) == u64::MAX && octant.chunk.block_materials(at).all(|of| u32::from(of) == material)
    };
    if blocks.clone().all(filled) {
        return material << 16 | FILLED;
    }
    let child = |i: u32| (0..count / 8).any(|k| mask_of(blocks.start + count / 8 * i + k) != 0);
    (0..8).fold(material << 16, |node, i| node | u32::from(child(i)) << i)
}

/// A node from its eight children: their mask, and the material of the first one.
fn parent(children: &[u32]) -> u32 {
    let mask = children.iter().enumerate().fold(0, |mask, (i, &child)| mask | u32::from(child != 0) << i);
    let first = children.iter().find(|child| **child != 0).map_or(0, |child| child >> 16);
    let alike = children.iter().all(|&child| child == first << 16 | FILLED);
    if alike { first << 16 | FILLED } else { first << 16 | mask }
}

/// Index of a cell (0…31) at the depth of voxels: its bits interleaved, x lowest. [`unmorton`] is its inverse.
fn morton(cell: [u32; 3]) -> usize {
    (0..DEPTHS).fold(0, |index, bit| {
        let digit = |axis: usize| (cell[axis] >> bit & 1) as usize;
        index | (digit(0) | digit(1) << 1 | digit(2) << 2) << (3 * bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::unmorton;

    #[test]
    fn depths_begin_where_the_ones_above_end() {
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(first_node), [0, 1, 9, 73, 585, 4681, 37449]);
        assert_eq!(morton([31, 0, 0]), 0b001_001_001_001_001);
        assert_eq!(morton([1, 2, 4]), 0b100_010_001);
        assert!((0..4096).all(|index| morton(unmorton(index)) == index as usize));
    }

    #[test]
    fn nodes_are_filled_only_when_all_their_voxels_are_alike() {
        let voxel = 7 << 16 | FILLED;
        assert_eq!(parent(&[voxel; 8]), voxel);
        let mut children = [voxel; 8];
        children[3] = 9 << 16 | FILLED;
        assert_eq!(parent(&children), 7 << 16 | 0xff);
        children[0] = 0;
        assert_eq!(parent(&children), 7 << 16 | 0xfe);
        assert_eq!(parent(&[7 << 16 | 0xff; 8]), 7 << 16 | 0xff);
        assert_eq!(parent(&[0; 8]), 0);
    }
}
