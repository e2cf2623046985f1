//! A chunk being built: every voxel has its place, and operations work on whole 4³ blocks through masks.

use raxel_language::Keys;
use serde::{Deserialize, Serialize};

use crate::chunk::{BLOCKS, Bits, CHUNK_VOXELS, Chunk, voxel_index};
use crate::material::{AIR, MaterialIndex};

/// A working copy of 64³ voxels: masks mark the solid ones, `voxels` is only meaningful where they do.
pub struct DenseChunk {
    masks: Box<[u64; BLOCKS]>,
    voxels: Box<[MaterialIndex]>,
}

/// The effect of an operation on the voxels that it covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Keys)]
pub enum Mode {
    /// Sets them to its material.
    Add,
    /// Empties them.
    Subtract,
    /// Gives the solid ones its material.
    Paint,
}

impl Default for DenseChunk {
    fn default() -> Self {
        let masks = vec![0; BLOCKS].into_boxed_slice().try_into().expect("it is that long");
        Self { masks, voxels: vec![AIR; CHUNK_VOXELS].into() }
    }
}

impl DenseChunk {
    /// Empties all voxels.
    #[inline]
    pub fn clear(&mut self) {
        self.masks.fill(0);
    }

    /// Makes every voxel solid and of one material.
    #[inline]
    pub fn fill(&mut self, material: MaterialIndex) {
        self.masks.fill(u64::MAX);
        self.voxels.fill(material);
    }

    /// Takes over the voxels of a packed chunk.
    pub fn unpack(&mut self, chunk: &Chunk) {
        *self.masks = *chunk.masks();
        for (block, mask) in chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0) {
            let voxels = &mut self.voxels[block * 64..][..64];
            for (bit, material) in Bits(*mask).zip(chunk.block_materials(block)) {
                voxels[bit as usize] = material;
            }
        }
    }

    /// Occupancy of every block.
    #[inline]
    pub fn masks(&self) -> &[u64; BLOCKS] {
        &self.masks
    }

    /// The 64 voxels of a block; meaningful where its mask is set.
    #[inline]
    pub fn block(&self, block: usize) -> &[MaterialIndex] {
        &self.voxels[block * 64..][..64]
    }

    /// Applies a mode to the voxels of a block that `mask` covers.
    #[inline]
    pub fn apply(&mut self, block: usize, mask: u64, mode: Mode, material: MaterialIndex) {
        let covered = match mode {
            Mode::Add => {
                self.masks[block] |= mask;
                mask
            }
            Mode::Subtract => {
                self.masks[block] &= !mask;
                return;
            }
            Mode::Paint => mask & self.masks[block],
        };
        let voxels = &mut self.voxels[block * 64..][..64];
        if self.masks[block] & !covered == 0 {
            // No other voxel of the block is solid; those that are empty have no material.
            voxels.fill(material);
        } else {
            Bits(covered).for_each(|bit| voxels[bit as usize] = material);
        }
    }

    /// Sets one voxel by chunk-local coordinates in 0…63; air empties it.
    #[inline]
    pub fn set(&mut self, x: u32, y: u32, z: u32, material: MaterialIndex) {
        let (block, bit) = voxel_index(x, y, z);
        let mode = if material == AIR { Mode::Subtract } else { Mode::Add };
        self.apply(block, 1 << bit, mode, material);
    }
}
