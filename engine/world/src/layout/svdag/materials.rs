//! What the voxels of chunks are made of, apart from where they are: a sequence for each chunk in the order in which a walk over its
//! part of the graph meets its voxels, as in Dado et al., "Geometry and attribute compression for voxel scenes" (2016), whose
//! blocks with small palettes are used too. Equal blocks are stored once.

use std::collections::HashMap;

use rayon::prelude::*;

use super::geometry::blocks_in_order;
use crate::chunk::Chunk;
use crate::material::MaterialIndex;

/// Voxels of a block.
const BLOCK: usize = 64;
/// A chunk's link, or a block's, if all is of the material in its low half.
const UNIFORM: u32 = 0x8000_0000;
/// Where a block's kind is: the bits of an index are 2^kind, and kind 4 has materials in place of indices.
const KIND_SHIFT: u32 = 28;
/// Words that a block's address can reach.
pub(super) const MAX_WORDS: usize = 1 << KIND_SHIFT;

/// A block of several materials: its kind, then its palette of 2^(2^kind) materials two a word, then an index a voxel.
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
    pub fn of(chunks: &[&Chunk]) -> Self {
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

    pub fn words(&self) -> usize {
        self.words
    }

    /// What an instance of a chunk says about its materials: one, or the word of its first block from the first word of all.
    pub fn link(&self, chunk: usize) -> u32 {
        match self.chunks[chunk] {
            Ok(material) => UNIFORM | u32::from(material),
            Err(first) => first as u32,
        }
    }

    /// Writes the blocks' words, then the packed blocks.
    pub fn write(&self, words: &mut [u32]) {
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
    let mut palette = materials.to_vec();
    palette.sort_unstable();
    palette.dedup();
    if let [only] = palette[..] {
        return Ok(only);
    }
    let kind = match palette.len() {
        0..=2 => 0,
        3..=4 => 1,
        5..=16 => 2,
        _ => 4,
    };
    let mut words = Vec::new();
    let bits = 1 << kind;
    if kind == 4 {
        palette.clear();
    } else {
        palette.resize(1 << bits, 0);
    }
    words.extend(palette.chunks(2).map(|pair| u32::from(pair[0]) | u32::from(pair[1]) << 16));
    let value = |material: &MaterialIndex| match kind {
        4 => u32::from(*material),
        _ => palette.iter().position(|of_palette| of_palette == material).unwrap_or(0) as u32,
    };
    let a_word = 32 / bits;
    let values = |some: &[MaterialIndex]| {
        some.iter().map(value).enumerate().fold(0, |word, (i, value)| word | value << (bits * i))
    };
    words.extend(materials.chunks(a_word).map(values));
    Err((kind, words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_take_as_few_bits_as_their_materials_need() {
        assert_eq!(pack(&[9; 64]), Ok(9));
        assert_eq!(pack(&[9]), Ok(9));
        let two: Vec<u16> = (0..64).map(|i| 5 + u16::from(i % 2 == 0) * 300).collect();
        assert_eq!(pack(&two), Err((0, vec![5 | 305 << 16, 0x5555_5555, 0x5555_5555])));
        let words =
            |materials: u16| pack(&(0..64).map(|i| i % materials).collect::<Vec<_>>()).map_err(|(_, w)| w.len());
        assert_eq!([3, 4, 5, 16, 17, 64].map(words), [Err(6), Err(6), Err(16), Err(16), Err(32), Err(32)]);
        // The last block of a chunk is as long as it is.
        assert_eq!(pack(&[1, 2, 3]), Err((1, vec![1 | 2 << 16, 3, 0b10_01_00])));
    }
}
