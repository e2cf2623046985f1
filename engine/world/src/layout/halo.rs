//! The halo of a world: its 4³ blocks of voxels that are occupied or touch an occupied one, as a 64-tree of masks.
//!
//! A point of a block outside the halo is at least 4 voxels from every solid voxel, along some axis. So a bundle of rays that stays
//! within 4 voxels of such points can be moved on at once, and nothing is missed (`shaders/include/raxel/beam.glsl`).

use std::collections::HashMap;

use rayon::prelude::*;

use super::header::Extent;
use super::tree64::{Node, QUAD, fill_upper, path, upper_nodes};
use crate::chunk::{Bits, Chunk, block_cell, block_index};
use crate::world::{ChunkPos, World};

/// Blocks along an edge of a chunk, and with those around it.
const EDGE: usize = 16;
const WIDE: usize = EDGE + 2;

/// Words of a mask.
const MASK_WORDS: usize = 2;

/// Masks of a chunk's 16³ nodes: which of their blocks are in the halo.
type Masks = [u64; 64];

/// The halo, ready to be written.
pub(super) struct Halo {
    levels: u32,
    /// Chunks in the order of their paths from the root, with the index of their masks.
    chunks: Vec<(u128, usize)>,
    distinct: Vec<Masks>,
    /// Occupied nodes of each distinct one, added up.
    firsts: Vec<usize>,
    masks: usize,
}

impl Halo {
    /// Works out the halo of a world.
    pub fn of(world: &World, extent: &Extent) -> Self {
        let levels = (extent.log2_size - 6) / 2;
        let side = 1i64 << (extent.log2_size - 6);
        let origin = extent.origin.map(|c| i64::from(c >> 6));
        let mut places: Vec<[i64; 3]> = world
            .chunks()
            .flat_map(|(pos, chunk)| {
                around(chunk).map(move |by| [0, 1, 2].map(|i| i64::from([pos.x, pos.y, pos.z][i]) + by[i]))
            })
            // Nothing outside the tree's cube is looked up.
            .filter(|place| (0..3).all(|i| (0..side).contains(&(place[i] - origin[i]))))
            .collect();
        places.par_sort_unstable();
        places.dedup();
        let mut found: Vec<(u128, Masks)> = places
            .into_par_iter()
            .map(|place| place.map(|c| c as i32))
            .map(|[x, y, z]| (path(ChunkPos::new(x, y, z), extent), dilated(world, [x, y, z])))
            .collect();
        found.par_sort_unstable_by_key(|(path, _)| *path);

        let mut known: HashMap<Masks, usize> = HashMap::new();
        let (mut distinct, mut firsts, mut masks) = (Vec::new(), Vec::new(), 0);
        let chunks = found
            .into_iter()
            .map(|(path, chunk)| {
                let index = *known.entry(chunk).or_insert_with(|| {
                    distinct.push(chunk);
                    firsts.push(masks);
                    masks += chunk.iter().filter(|mask| **mask != 0).count();
                    distinct.len() - 1
                });
                (path, index)
            })
            .collect();
        Self { levels, chunks, distinct, firsts, masks }
    }

    /// Its size in words, over [`QUAD`].
    pub fn quads(&self) -> usize {
        upper_nodes(&self.chunks, self.levels) + self.masks.div_ceil(2)
    }

    /// Writes it: the nodes from the root down to the chunks, then masks of 16³ voxels. `words_at` is the address of `words`.
    pub fn fill(&self, words: &mut [u32], words_at: usize) {
        let (upper, masks) = words.split_at_mut(QUAD * upper_nodes(&self.chunks, self.levels));
        let masks_at = (words_at + upper.len()) / MASK_WORDS;
        let pairs = masks.as_chunks_mut::<2>().0;
        let all = self.distinct.iter().flatten().filter(|mask| **mask != 0);
        pairs.iter_mut().zip(all).for_each(|(pair, mask)| *pair = [*mask as u32, (*mask >> 32) as u32]);
        let chunks = self.chunks.iter().map(|&(path, index)| {
            let occupied = self.distinct[index].iter().enumerate();
            let mask = occupied.fold(0, |all, (node, mask)| all | u64::from(*mask != 0) << node);
            (path, Node { mask, children: (masks_at + self.firsts[index]) as u32, material: 0 })
        });
        fill_upper(chunks.collect(), self.levels, upper, words_at);
    }
}

/// Steps to the chunks that the halo of a chunk reaches, itself included.
fn around(chunk: &Chunk) -> impl Iterator<Item = [i64; 3]> + use<> {
    let (low, high) = chunk.bounds();
    let range = |axis: usize| -i64::from(low[axis] < 4)..=i64::from(high[axis] >= 60);
    let ranges = [range(0), range(1), range(2)];
    let [xs, ys, zs] = ranges;
    xs.flat_map(move |x| {
        let zs = zs.clone();
        ys.clone().flat_map(move |y| zs.clone().map(move |z| [x, y, z]))
    })
}

/// The halo in the chunk at a place.
fn dilated(world: &World, [x, y, z]: [i32; 3]) -> Masks {
    // Bit x + 1 of row (y + 1, z + 1): whether the block is occupied.
    let mut rows = [[0u32; WIDE]; WIDE];
    for (dx, dy, dz) in (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)) {
        let Some(chunk) = world.chunk(ChunkPos::new(x + dx, y + dy, z + dz)) else { continue };
        let first = |d: i32| if d < 0 { EDGE - 1 } else { 0 };
        let last = |d: i32| if d > 0 { 0 } else { EDGE - 1 };
        if (dx, dy, dz) == (0, 0, 0) {
            for node in Bits(chunk.root_mask()) {
                for bit in Bits(chunk.node_mask(node as usize)) {
                    let [bx, by, bz] = block_cell(node as usize * 64 + bit as usize);
                    rows[by as usize + 1][bz as usize + 1] |= 2 << bx;
                }
            }
            continue;
        }
        for by in first(dy)..=last(dy) {
            for bz in first(dz)..=last(dz) {
                for bx in first(dx)..=last(dx) {
                    if chunk.mask(block_index(bx as u32, by as u32, bz as u32)) != 0 {
                        let at = |b: usize, d: i32| (b as i32 + 1 + 16 * d) as usize;
                        rows[at(by, dy)][at(bz, dz)] |= 1 << at(bx, dx);
                    }
                }
            }
        }
    }
    for row in rows.iter_mut().flatten() {
        *row = *row | *row << 1 | *row >> 1;
    }
    let mut masks = [0u64; 64];
    for y in 0..EDGE {
        let layer: [u32; WIDE] = std::array::from_fn(|z| rows[y][z] | rows[y + 1][z] | rows[y + 2][z]);
        for z in 0..EDGE {
            let row = (layer[z] | layer[z + 1] | layer[z + 2]) >> 1;
            for x in (0..EDGE as u32).step_by(4) {
                let block = block_index(x, y as u32, z as u32);
                masks[block >> 6] |= u64::from(row >> x & 15) << (block & 63);
            }
        }
    }
    masks
}
