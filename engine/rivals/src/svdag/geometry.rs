//! The solid voxels of chunks as a directed acyclic graph. Equal subtrees are stored once (Kämpe, Sintorn and Assarsson,
//! "High resolution sparse voxel DAGs", 2013). Built from the leaves upwards, one height at a time over all chunks.

use std::collections::HashMap;
use std::hash::Hash;

use raxel_world::{BLOCKS, Chunk, block_index};
use rayon::prelude::*;

use raxel_layouts::parts::child_of;

/// Words of a leaf: the mask of its 4³ voxels.
const LEAF_WORDS: usize = 2;
/// Bits of a node's first word below its number of voxels: the mask of its children.
const VOXELS_SHIFT: u32 = 8;
/// No child.
const NONE: u32 = u32::MAX;

/// Index of a leaf, or of a node of the height below.
type Id = u32;

/// A node of one height: its children, in the order of octree children.
type Node = [Id; 8];

/// The different subtrees of a set of chunks.
pub(super) struct Geometry {
    leaves: Vec<u64>,
    /// Different nodes of 2³, 2⁴, 2⁵ and 2⁶ voxels a side.
    heights: [Vec<Node>; 4],
    /// Solid voxels of each of those nodes.
    voxels: [Vec<u32>; 4],
    /// Word of each leaf (first), and of each of those nodes.
    places: [Vec<u32>; 5],
    /// The topmost node of every chunk.
    roots: Vec<Id>,
    words: usize,
}

impl Geometry {
    pub(crate) fn of(chunks: &[&Chunk]) -> Self {
        let order = blocks_in_order();
        let masks = |chunk: &Chunk| order.iter().map(|&block| chunk.mask(block)).collect::<Vec<u64>>();
        let leaves = distinct(chunks, |chunk| masks(chunk).into_iter().filter(|mask| *mask != 0));
        let leaf_ids = ids(&leaves);
        let mut below: Vec<Vec<Id>> = (chunks.par_iter())
            .map(|chunk| masks(chunk).iter().map(|mask| leaf_ids.get(mask).copied().unwrap_or(NONE)).collect())
            .collect();

        let mut heights: [Vec<Node>; 4] = std::array::from_fn(|_| Vec::new());
        for nodes in &mut heights {
            *nodes = distinct(&below, |ids| ids.chunks_exact(8).map(node).filter(|node| *node != [NONE; 8]));
            let ids = ids(nodes);
            below = (below.par_iter())
                .map(|children| children.chunks_exact(8).map(|c| ids.get(&node(c)).copied().unwrap_or(NONE)).collect())
                .collect();
        }
        let roots = below.into_iter().map(|of_chunk| of_chunk[0]).collect();

        let mut voxels: [Vec<u32>; 4] = std::array::from_fn(|_| Vec::new());
        let mut places: [Vec<u32>; 5] = std::array::from_fn(|_| Vec::new());
        let mut words = 0;
        // From the top down: this usually puts a node near its children.
        for height in (0..4).rev() {
            for node in &heights[height] {
                places[height + 1].push(words as u32);
                words += 1 + children(node).count();
            }
        }
        places[0] = (0..leaves.len()).map(|i| (words + LEAF_WORDS * i) as u32).collect();
        words += LEAF_WORDS * leaves.len();
        for height in 0..4 {
            let of_child = |id: Id| match height {
                0 => leaves[id as usize].count_ones(),
                _ => voxels[height - 1][id as usize],
            };
            voxels[height] = heights[height].iter().map(|node| children(node).map(of_child).sum()).collect();
        }
        Self { leaves, heights, voxels, places, roots, words }
    }

    /// Words of all nodes and leaves.
    pub(crate) fn words(&self) -> usize {
        // An empty world has one empty node.
        self.words.max(1)
    }

    pub(crate) fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// Leaves included.
    pub(crate) fn node_count(&self) -> usize {
        self.leaves.len() + self.heights.iter().map(Vec::len).sum::<usize>()
    }

    /// Word of the topmost node of a chunk, from the first node.
    pub(crate) fn root(&self, chunk: usize) -> u32 {
        self.places[4][self.roots[chunk] as usize]
    }

    /// Writes everything; `at` is the address of the words.
    pub(crate) fn write(&self, words: &mut [u32], at: usize) {
        for height in 0..4 {
            for ((node, &voxels), &place) in
                self.heights[height].iter().zip(&self.voxels[height]).zip(&self.places[height + 1])
            {
                let place = place as usize;
                let mask = (0..8).filter(|&i| node[i] != NONE).fold(0, |mask, i| mask | 1 << i);
                words[place] = mask | voxels << VOXELS_SHIFT;
                for (word, child) in words[place + 1..].iter_mut().zip(children(node)) {
                    *word = at as u32 + self.places[height][child as usize];
                }
            }
        }
        for (leaf, &place) in self.leaves.iter().zip(&self.places[0]) {
            let place = place as usize;
            words[place..place + LEAF_WORDS].copy_from_slice(&[*leaf as u32, (leaf >> 32) as u32]);
        }
    }
}

fn node(ids: &[Id]) -> Node {
    std::array::from_fn(|i| ids[i])
}

fn children(node: &Node) -> impl Iterator<Item = Id> {
    node.iter().copied().filter(|id| *id != NONE)
}

/// The different values of all sources, ascending: the same in any order in which threads find them.
fn distinct<'a, S: Sync, T: Copy + Ord + Send, I: Iterator<Item = T>>(
    sources: &'a [S],
    values: impl Fn(&'a S) -> I + Sync,
) -> Vec<T> {
    let sorted = |mut values: Vec<T>| {
        values.sort_unstable();
        values.dedup();
        values
    };
    let merged = sources.par_iter().fold(Vec::new, |mut known: Vec<T>, source| {
        // Duplicates go when they are as many as the known values, so that memory stays near that of the distinct ones.
        let before = known.len();
        known.extend(values(source));
        if known.len() > 2 * before.max(1 << 16) { sorted(known) } else { known }
    });
    merged.map(sorted).reduce(Vec::new, |mut a, b| {
        a.extend(b);
        sorted(a)
    })
}

fn ids<T: Copy + Eq + Hash>(values: &[T]) -> HashMap<T, Id> {
    values.iter().copied().zip(0..).collect()
}

/// Blocks of a chunk in the order in which the graph's leaves are met.
pub(super) fn blocks_in_order() -> Vec<usize> {
    (0..BLOCKS as u32)
        .map(|path| {
            let digits = (0..4).rev().map(|level| path >> (3 * level) & 7);
            let [x, y, z] = digits.fold([0; 3], child_of);
            block_index(x, y, z)
        })
        .collect()
}
