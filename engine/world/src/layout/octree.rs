//! Layout `octree`: see `shaders/include/raxel/octree.glsl` for the format.

use super::parts::Octant;
use super::{Access, Encoded, Layout, LayoutError, hashed_chunks};
use crate::world::World;

/// Chunks have 2^5 voxels a side: depths 0 (the chunk) to 5 (voxels).
const DEPTHS: u32 = 5;
/// Nodes of a chunk, empty ones included, one word each.
const CHUNK_WORDS: usize = first_node(DEPTHS + 1);
/// Bits of a node all of whose voxels are solid and of one material: the mask of all children, and the bit that says so.
const FILLED: u32 = 0x1ff;

/// Index in a chunk of the first node of a depth: 1 + 8 + … + 8^(depth − 1).
const fn first_node(depth: u32) -> usize {
    ((1usize << (3 * depth)) - 1) / 7
}

pub(super) fn encode(world: &World, limit: u64, access: Access) -> Result<Encoded, LayoutError> {
    hashed_chunks::encode(world, Layout::Octree, limit, access, CHUNK_WORDS, fill)
}

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

/// A node from its eight children: their mask, and the material of the first one.
fn parent(children: &[u32]) -> u32 {
    let mask = children.iter().enumerate().fold(0, |mask, (i, &child)| mask | u32::from(child != 0) << i);
    let first = children.iter().find(|child| **child != 0).map_or(0, |child| child >> 16);
    let alike = children.iter().all(|&child| child == first << 16 | FILLED);
    if alike { first << 16 | FILLED } else { first << 16 | mask }
}

/// Index of a cell (0…31) at the depth of voxels: its bits interleaved, x lowest.
fn morton(cell: [u32; 3]) -> usize {
    (0..DEPTHS).fold(0, |index, bit| {
        let digit = |axis: usize| (cell[axis] >> bit & 1) as usize;
        index | (digit(0) | digit(1) << 1 | digit(2) << 2) << (3 * bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_begin_where_the_ones_above_end() {
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(first_node), [0, 1, 9, 73, 585, 4681, 37449]);
        assert_eq!(morton([31, 0, 0]), 0b001_001_001_001_001);
        assert_eq!(morton([1, 2, 4]), 0b100_010_001);
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
