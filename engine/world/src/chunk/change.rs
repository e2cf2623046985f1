//! Chunks after a few of their blocks have changed, made from the chunks before.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::{BLOCKS, Bits, Chunk, Packed, firsts};
use crate::material::{AIR, MaterialIndex};

/// Materials that the indices of a chunk can number.
const MOST_INDEXED: usize = 256;

/// The voxels of a 4³ block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockVoxels {
    /// Which are solid.
    pub mask: u64,
    /// Their materials; air where nothing is solid.
    pub materials: [MaterialIndex; 64],
}

impl BlockVoxels {
    /// A block of air.
    pub const EMPTY: Self = Self { mask: 0, materials: [AIR; 64] };

    /// Sets a voxel, by the bit that it has in masks; air empties it.
    pub fn set(&mut self, bit: u32, material: MaterialIndex) {
        self.materials[bit as usize] = material;
        self.mask = self.mask & !(1 << bit) | u64::from(material != AIR) << bit;
    }

    fn solids(&self) -> impl Iterator<Item = MaterialIndex> + '_ {
        Bits(self.mask).map(|bit| self.materials[bit as usize])
    }
}

impl Chunk {
    /// The voxels of a block, by its index.
    pub fn block(&self, block: usize) -> BlockVoxels {
        let mut voxels = BlockVoxels { mask: self.mask(block), ..BlockVoxels::EMPTY };
        for (bit, material) in Bits(voxels.mask).zip(self.block_materials(block)) {
            voxels.materials[bit as usize] = material;
        }
        voxels
    }

    /// A chunk, or air, after some of its blocks have changed, by their indices. `None` when no voxel is solid. It takes about as long as a
    /// copy of the chunk does.
    #[allow(clippy::large_stack_arrays, reason = "it goes into its box at once")]
    pub fn with_blocks(before: Option<&Self>, changed: &BTreeMap<usize, BlockVoxels>) -> Option<Self> {
        let mut masks = before.map_or_else(|| Box::new([0; BLOCKS]), |chunk| chunk.masks.clone());
        for (block, voxels) in changed {
            masks[*block] = voxels.mask;
        }
        let (firsts, solids) = firsts(&masks);
        if solids == 0 {
            return None;
        }
        let materials = spliced(before, changed, solids as usize).unwrap_or_else(|| {
            let materials = masks.iter().enumerate().flat_map(|(block, _)| {
                let new = changed.get(&block);
                let old = before.filter(|_| new.is_none());
                let old = old.into_iter().flat_map(move |chunk| chunk.block_materials(block));
                new.into_iter().flat_map(BlockVoxels::solids).chain(old)
            });
            Packed::from_plain(materials.collect())
        });
        Some(Self { hash: OnceLock::new(), masks, firsts, materials, solids })
    }
}

/// The materials, with those of unchanged blocks copied. `None` where there may be too many for an index.
#[expect(clippy::cast_possible_truncation, reason = "this palette has at most 256 entries")]
fn spliced(before: Option<&Chunk>, changed: &BTreeMap<usize, BlockVoxels>, solids: usize) -> Option<Packed> {
    let uniform;
    let (known, old): (&[MaterialIndex], Option<&[u8]>) = match before.map(|chunk| &chunk.materials) {
        None => (&[], None),
        Some(Packed::Uniform(material)) => {
            uniform = [*material];
            (&uniform, None)
        }
        Some(Packed::Indexed { palette, indices }) => (palette, Some(indices)),
        Some(Packed::Plain(_)) => return None,
    };
    let mut palette = known.to_vec();
    for material in changed.values().flat_map(BlockVoxels::solids) {
        if let Err(at) = palette.binary_search(&material) {
            palette.insert(at, material);
        }
    }
    if palette.len() > MOST_INDEXED {
        return None;
    }
    let index_of = |palette: &[MaterialIndex], material| palette.binary_search(&material).unwrap_or(0) as u8;

    let translated: Vec<u8> = known.iter().map(|material| index_of(&palette, *material)).collect();
    let same = palette.len() == known.len();
    let mut indices: Vec<u8> = Vec::with_capacity(solids);
    let copy = |indices: &mut Vec<u8>, from: usize, to: usize| match old {
        Some(old) if same => indices.extend_from_slice(&old[from..to]),
        Some(old) => indices.extend(old[from..to].iter().map(|index| translated[usize::from(*index)])),
        None => indices.resize(indices.len() + (to - from), translated.first().copied().unwrap_or(0)),
    };
    let mut copied = 0;
    for (block, voxels) in changed {
        if let Some(chunk) = before {
            let first = chunk.first(*block) as usize;
            copy(&mut indices, copied, first);
            copied = first + chunk.mask(*block).count_ones() as usize;
        }
        indices.extend(voxels.solids().map(|material| index_of(&palette, material)));
    }
    if let Some(chunk) = before {
        copy(&mut indices, copied, chunk.solids as usize);
    }

    // Only materials that a changed block had may have gone.
    let mut gone: Vec<MaterialIndex> = Vec::new();
    for block in changed.keys() {
        let old = before.into_iter().flat_map(|chunk| chunk.block_materials(*block));
        for material in old {
            if !gone.contains(&material) {
                gone.push(material);
            }
        }
    }
    gone.retain(|material| !indices.contains(&index_of(&palette, *material)));
    if !gone.is_empty() {
        let left: Vec<MaterialIndex> = palette.iter().copied().filter(|material| !gone.contains(material)).collect();
        let translated: Vec<u8> = palette.iter().map(|material| index_of(&left, *material)).collect();
        indices.iter_mut().for_each(|index| *index = translated[usize::from(*index)]);
        palette = left;
    }
    Some(match palette[..] {
        [material] => Packed::Uniform(material),
        _ => Packed::Indexed { palette: palette.into(), indices: indices.into() },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dense::DenseChunk;
    use crate::random::SplitMix64;

    /// Changes chunks of every storage of materials, a few voxels at a time, and compares them with chunks packed from all their voxels.
    #[test]
    fn changed_blocks_leave_the_bytes_that_packing_all_voxels_does() {
        let mut random = SplitMix64::new(11);
        for materials in [1, 2, 3, 255, 256, 257, 400] {
            let mut dense = DenseChunk::default();
            let mut chunk: Option<Chunk> = None;
            for round in 0..61 {
                let mut changed = BTreeMap::new();
                let count = if round == 20 { 3000 } else { 1 + random.below(9) };
                for _ in 0..count {
                    let block = random.index(BLOCKS);
                    let bit = random.below(64) as u32;
                    // Later, all are taken away again one by one: materials go, until one of them is left, and then nothing.
                    let material = if round > 40 { AIR } else { random.below(materials + 1) as MaterialIndex };
                    let voxels = changed
                        .entry(block)
                        .or_insert_with(|| chunk.as_ref().map_or(BlockVoxels::EMPTY, |chunk| chunk.block(block)));
                    voxels.set(bit, material);
                }
                if round > 40 {
                    for block in (0..BLOCKS).filter(|block| block % 20 == round - 41) {
                        changed.insert(block, BlockVoxels::EMPTY);
                    }
                }
                for (block, voxels) in &changed {
                    dense.apply(*block, u64::MAX, crate::dense::Mode::Subtract, AIR);
                    for bit in Bits(voxels.mask) {
                        dense.apply(*block, 1 << bit, crate::dense::Mode::Add, voxels.materials[bit as usize]);
                    }
                }
                chunk = Chunk::with_blocks(chunk.as_ref(), &changed);
                let packed = Chunk::pack(&dense);
                assert!(chunk == packed, "{materials} materials, round {round}");
                let hashes = [&chunk, &packed].map(|chunk| chunk.as_ref().map(Chunk::content_hash));
                assert_eq!(hashes[0], hashes[1], "{materials} materials, round {round}");
            }
            assert_eq!(chunk, None, "{materials}");
        }
    }

    #[test]
    fn a_full_chunk_stays_of_one_material_until_another_comes_and_again_when_that_goes() {
        let full = Chunk::full(7);
        let mut voxels = full.block(9);
        voxels.set(5, 3);
        let two = Chunk::with_blocks(Some(&full), &BTreeMap::from([(9, voxels)])).unwrap();
        assert_eq!((two.uniform(), two.block_uniform(9), two.block_uniform(10)), (None, None, Some(7)));
        voxels.set(5, 7);
        let one = Chunk::with_blocks(Some(&two), &BTreeMap::from([(9, voxels)])).unwrap();
        assert!(one == full && one.uniform() == Some(7));
    }
}
