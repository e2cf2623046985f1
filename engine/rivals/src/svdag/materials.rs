//! The materials of the voxels of chunks, apart from their places: a sequence for each chunk in the order in which a walk over its part of
//! the graph meets its voxels, as in Dado et al., "Geometry and attribute compression for voxel scenes" (2016), in packed blocks. Equal
//! blocks are stored once.

use std::collections::HashMap;

use raxel_world::Chunk;
use raxel_world::MaterialIndex;
use rayon::prelude::*;

use super::geometry::blocks_in_order;
use raxel_layouts::Packing;

/// Voxels of a block.
const BLOCK: usize = 64;
/// A chunk's link, or a block's, if all is of the material in its low half.
const UNIFORM: u32 = 0x8000_0000;
/// Where a block's kind is.
const KIND_SHIFT: u32 = 28;
/// Words that a block's address can reach.
pub(super) const MAX_WORDS: usize = 1 << KIND_SHIFT;

/// A block of several materials: its kind, and its words as [`Packing`] has them.
type Packed = (u32, Vec<u32>);

/// A sequence of blocks: of one material, or by index in a list of different ones.
enum Block {
    Uniform(MaterialIndex),
    Packed(u32),
}

/// The materials of a set of chunks.
pub(super) struct Materials {
    /// Of every chunk: the only material, or where its sequence begins in `blocks`.
    chunks: Vec<Result<MaterialIndex, usize>>,
    blocks: Vec<Block>,
    packed: Vec<Packed>,
    /// Word of each packed block.
    places: Vec<u32>,
    words: usize,
}

impl Materials {
    pub(crate) fn of(chunks: &[&Chunk]) -> Self {
        let order = blocks_in_order();
        let mut of_chunk = Vec::with_capacity(chunks.len());
        let (mut blocks, mut packed) = (Vec::new(), Vec::new());
        let mut known: HashMap<Packed, u32> = HashMap::new();
        // A few chunks at a time: packed in parallel, made one in turn.
        for some in chunks.chunks(256) {
            let sequences: Vec<Option<Vec<Result<MaterialIndex, Packed>>>> =
                some.par_iter().map(|chunk| chunk.uniform().is_none().then(|| sequence(chunk, &order))).collect();
            for (chunk, sequence) in some.iter().zip(sequences) {
                let Some(sequence) = sequence else {
                    of_chunk.push(chunk.uniform().ok_or(0));
                    continue;
                };
                of_chunk.push(Err(blocks.len()));
                blocks.extend(sequence.into_iter().map(|block| match block {
                    Ok(material) => Block::Uniform(material),
                    Err(block) => Block::Packed(*known.entry(block).or_insert_with_key(|block| {
                        packed.push(block.clone());
                        packed.len() as u32 - 1
                    })),
                }));
            }
        }
        let mut words = blocks.len();
        let mut places = Vec::with_capacity(packed.len());
        for (_, block) in &packed {
            places.push(words as u32);
            words += block.len();
        }
        Self { chunks: of_chunk, blocks, packed, places, words }
    }

    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// The material entry of an instance of a chunk: one material, or the word of its first block from the first word of all.
    pub(crate) fn link(&self, chunk: usize) -> u32 {
        match self.chunks[chunk] {
            Ok(material) => UNIFORM | u32::from(material),
            Err(first) => first as u32,
        }
    }

    /// Writes the blocks' words, then the packed blocks.
    pub(crate) fn write(&self, words: &mut [u32]) {
        for (word, block) in words.iter_mut().zip(&self.blocks) {
            *word = match block {
                Block::Uniform(material) => UNIFORM | u32::from(*material),
                Block::Packed(index) => self.packed[*index as usize].0 << KIND_SHIFT | self.places[*index as usize],
            };
        }
        for ((_, block), &place) in self.packed.iter().zip(&self.places) {
            words[place as usize..][..block.len()].copy_from_slice(block);
        }
    }
}

/// The blocks of one chunk.
fn sequence(chunk: &Chunk, order: &[usize]) -> Vec<Result<MaterialIndex, Packed>> {
    let materials: Vec<MaterialIndex> = order.iter().flat_map(|&block| chunk.block_materials(block)).collect();
    materials.chunks(BLOCK).map(pack).collect()
}

/// A block of one material, or packed.
fn pack(materials: &[MaterialIndex]) -> Result<MaterialIndex, Packed> {
    if materials.iter().all(|material| *material == materials[0]) {
        return Ok(materials[0]);
    }
    let packing = Packing::of(materials.iter().copied());
    let mut words = vec![0; packing.words()];
    packing.write(materials.iter().copied(), &mut words);
    Err((packing.kind, words))
}
