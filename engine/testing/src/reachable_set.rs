//! The words of a buffer that a frame can reach: the reference for every word that it may read.
#![expect(clippy::cast_possible_wrap, reason = "cells of a directory's cube have 32 bits")]

use std::ops::Range;

use raxel_layouts::{TileNode, Tree64Header};
use raxel_world::ChunkPos;

/// Everything of a directory of chunks. Places are in words behind the header.
#[derive(Clone, Debug, Default)]
pub struct ReachableSet {
    /// The nodes above the chunks, and those of the chunks: the root, and for each node above the chunks its children.
    pub nodes: Vec<Range<u32>>,
    /// The chunks that have a node, in the order of their paths from the root.
    pub chunks: Vec<(ChunkPos, TileNode)>,
}

impl ReachableSet {
    /// Walks down from the root of a header through the words behind it. For worlds of single voxels: of coarse tiles it would take the
    /// cells for chunks.
    ///
    /// # Panics
    /// When an upper node does not belong to a directory, or is outside of the words.
    pub fn of(header: &Tree64Header, body: &[u32]) -> Self {
        let mut reached = Self::default();
        reached.nodes.push(4 * header.root..4 * header.root + 4);
        let mut open = vec![(header.root, header.log2_size >> 1, [0i32; 3])];
        while let Some((at, height, corner)) = open.pop() {
            let at = 4 * at as usize;
            let node = TileNode([body[at], body[at + 1], body[at + 2], body[at + 3]]);
            if height == 3 {
                let [x, y, z] = [0, 1, 2].map(|i| (header.origin[i] >> 6) + corner[i]);
                reached.chunks.push((ChunkPos::new(x, y, z), node));
                continue;
            }
            assert_eq!(node.filled_material(), None, "a node above the chunks is filled");
            let (mask, first) = (node.mask(), node.0[2]);
            reached.nodes.push(4 * first..4 * (first + mask.count_ones()));
            // The last is looked at first.
            for child in (0..64).rev().filter(|child| mask >> child & 1 == 1) {
                let cell = raxel_world::child_cell(child).map(|c| (c << (2 * (height - 4))) as i32);
                let rank = (mask & ((1 << child) - 1)).count_ones();
                open.push((first + rank, height - 1, std::array::from_fn(|i| corner[i] + cell[i])));
            }
        }
        reached
    }
}
