//! The parts that encoders iterate over: the distinct chunks of a world, or their 32³ octants, and the places of each.

use std::collections::HashMap;
use std::sync::Arc;

use raxel_world::MaterialIndex;
use raxel_world::World;
use raxel_world::{Bits, Chunk, block_index, child_cell, child_index};

use super::Access;
use super::header::Extent;

/// Equal parts are one. Cells count parts (64 or 32 voxels a side) from the corner of the world's cube.
pub struct Parts<T> {
    /// The different ones.
    pub distinct: Vec<T>,
    /// Cell and index in `distinct` of every part with solids.
    pub uses: Vec<([u32; 3], usize)>,
}

impl<T: Copy> Parts<T> {
    /// The parts to store for an access: where voxels will be written, equal parts are stored separately.
    #[must_use]
    pub fn for_access(self, access: Access) -> Self {
        match access {
            Access::Read => self,
            Access::Write => Self {
                distinct: self.uses.iter().map(|&(_, index)| self.distinct[index]).collect(),
                uses: self.uses.iter().zip(0..).map(|(&(cell, _), index)| (cell, index)).collect(),
            },
        }
    }
}

impl<'a> Parts<&'a Chunk> {
    /// The chunks of a world.
    pub fn chunks(world: &'a World, extent: &Extent) -> Self {
        let mut known: HashMap<*const Chunk, usize> = HashMap::new();
        let mut distinct: Vec<&Chunk> = Vec::new();
        let uses = world
            .chunks()
            .map(|(pos, chunk)| {
                let index = *known.entry(Arc::as_ptr(chunk)).or_insert_with(|| {
                    distinct.push(chunk);
                    distinct.len() - 1
                });
                let pos = [pos.x, pos.y, pos.z];
                (std::array::from_fn(|i| (pos[i] - (extent.origin[i] >> 6)).cast_unsigned()), index)
            })
            .collect();
        Self { distinct, uses }
    }
}

/// 32³ voxels: an eighth of a chunk.
#[derive(Clone, Copy)]
pub struct Octant<'a> {
    /// The chunk.
    pub chunk: &'a Chunk,
    /// Bit 0 x, bit 1 y, bit 2 z.
    pub number: u32,
}

impl<'a> Parts<Octant<'a>> {
    /// The octants of the chunks of a world.
    pub fn octants(world: &'a World, extent: &Extent) -> Self {
        let chunks = Parts::chunks(world, extent);
        let mut distinct = Vec::new();
        let of_chunk: Vec<[Option<usize>; 8]> = (chunks.distinct.iter())
            .map(|&chunk| {
                std::array::from_fn(|number| {
                    let octant = Octant { chunk, number: number as u32 };
                    octant.is_solid().then(|| {
                        distinct.push(octant);
                        distinct.len() - 1
                    })
                })
            })
            .collect();
        let octants = |&(cell, chunk): &([u32; 3], usize)| {
            let here = of_chunk[chunk].into_iter().zip(0..8);
            here.filter_map(move |(index, number)| Some((child_of(cell, number), index?)))
        };
        let uses = chunks.uses.iter().flat_map(octants).collect();
        Self { distinct, uses }
    }
}

impl Octant<'_> {
    /// Whether it has a solid voxel.
    pub fn is_solid(&self) -> bool {
        self.node_masks().iter().any(|mask| *mask != 0)
    }

    /// Index in the chunk of one of its 512 blocks of 4³ voxels, numbered in Morton order.
    pub fn block(&self, number: u32) -> usize {
        let corner = octant_cell(self.number).map(|c| c << 3);
        let [x, y, z] = unmorton(number);
        block_index(corner[0] + x, corner[1] + y, corner[2] + z)
    }

    /// The blocks in which two octants of one number differ, as [`Self::block`] numbers them, sorted.
    pub(crate) fn different_blocks(&self, other: &Octant) -> Vec<u32> {
        let differ = |&number: &u32| {
            let at = self.block(number);
            let (mask, theirs) = (self.chunk.mask(at), other.chunk.mask(at));
            mask != theirs || (mask != 0 && !self.chunk.block_materials(at).eq(other.chunk.block_materials(at)))
        };
        (0..512).filter(differ).collect()
    }

    /// Which 4³ blocks of its eight 16³ nodes have solids; nodes as octants of the octant, bits in the order of `child_index`.
    pub fn node_masks(&self) -> [u64; 8] {
        std::array::from_fn(|node| {
            let [x, y, z] = child_of(octant_cell(self.number), node as u32);
            self.chunk.node_mask(child_index(x, y, z) as usize)
        })
    }

    /// Every solid voxel with its cell in the octant, 0…31.
    pub fn voxels(&self) -> impl Iterator<Item = ([u32; 3], MaterialIndex)> + '_ {
        let corner = octant_cell(self.number).map(|c| c << 3);
        let blocks = (0..512).map(move |i| [i & 7, i >> 3 & 7, i >> 6]);
        blocks.flat_map(move |[x, y, z]| {
            let block = block_index(corner[0] + x, corner[1] + y, corner[2] + z);
            Bits(self.chunk.mask(block)).zip(self.chunk.block_materials(block)).map(move |(bit, material)| {
                let local = child_cell(bit);
                ([x << 2 | local[0], y << 2 | local[1], z << 2 | local[2]], material)
            })
        })
    }
}

/// The only material of a 16³ node (0…63), if there is only one.
pub(crate) fn uniform_node(chunk: &Chunk, node: usize) -> Option<MaterialIndex> {
    let mut found = None;
    for bit in Bits(chunk.node_mask(node)) {
        let material = chunk.block_uniform(node * 64 + bit as usize)?;
        if *found.get_or_insert(material) != material {
            return None;
        }
    }
    found
}

/// Whether all occupied blocks of a 16³ node (0…63) are full.
pub(crate) fn has_full_leaves(chunk: &Chunk, node: usize) -> bool {
    chunk.masks()[node * 64..][..64].iter().all(|&mask| mask == 0 || mask == u64::MAX)
}

/// The material of a 16³ node (0…63) all of whose occupied blocks are full and of that one material.
pub(crate) fn filled_node(chunk: &Chunk, node: usize) -> Option<MaterialIndex> {
    if has_full_leaves(chunk, node) { uniform_node(chunk, node) } else { None }
}

/// Cell in 0…1 of one of the eight children of an octree node.
pub fn octant_cell(number: u32) -> [u32; 3] {
    [number & 1, number >> 1 & 1, number >> 2]
}

/// The cell at a place of the Morton order: every third bit is a bit of x, then of y, then of z.
pub fn unmorton(index: u32) -> [u32; 3] {
    std::array::from_fn(|axis| (0..10).fold(0, |c, bit| c | (index >> (3 * bit + axis as u32) & 1) << bit))
}

/// Cell of a child of an octree node, in its own size.
pub fn child_of(cell: [u32; 3], number: u32) -> [u32; 3] {
    let child = octant_cell(number);
    std::array::from_fn(|i| cell[i] << 1 | child[i])
}

/// Octree path of a cell: its child numbers from the top, three bits each.
pub fn octree_path(cell: [u32; 3]) -> u128 {
    (0..32).rev().fold(0, |path, bit| {
        let digit = |axis: usize| u128::from(cell[axis] >> bit & 1);
        path << 3 | digit(0) | digit(1) << 1 | digit(2) << 2
    })
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;
    use crate::Layout;
    use raxel_world::Material;

    #[test]
    fn octants_hold_the_voxels_of_their_chunks() {
        let voxels = [[-1, 70, 3], [-33, 64, 3], [40, 100, -200]].map(|cell| (IVec3::from_array(cell), 1));
        let world = World::from_voxels(vec![Material::air(); 2], voxels);
        let extent = Extent::of(&world, Layout::OCTREE).expect("small");
        let octants = Parts::octants(&world, &extent);
        assert_eq!((octants.uses.len(), octants.distinct.len()), (3, 3));
        let mut found: Vec<[i32; 3]> = (octants.uses.iter())
            .flat_map(|&(cell, index)| {
                let corner: [i32; 3] = std::array::from_fn(|i| extent.origin[i] + 32 * cell[i] as i32);
                let voxels = octants.distinct[index].voxels().collect::<Vec<_>>();
                voxels.into_iter().map(move |(local, _)| std::array::from_fn(|i| corner[i] + local[i] as i32))
            })
            .collect();
        let mut expected = voxels.map(|(cell, _)| cell.to_array()).to_vec();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }
}
