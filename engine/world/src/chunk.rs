//! 64³ voxels as a flattened 64-tree: one occupancy mask for each 4³ block, and the materials of the solid voxels packed in the same order.
//! One byte a solid voxel (none when all are of one material), and none for empty space around them.

mod change;

use std::hash::{Hash, Hasher};
use std::sync::OnceLock;

pub use change::BlockVoxels;

use crate::dense::DenseChunk;
use crate::material::{AIR, MaterialIndex};
use crate::world::Bounds;

/// Voxels along an edge of a chunk.
pub const CHUNK_EDGE: i32 = 64;
/// 4³ blocks of a chunk.
pub const BLOCKS: usize = 4096;
/// Voxels of a chunk.
pub const CHUNK_VOXELS: usize = 64 * BLOCKS;

/// Index of a child among the 64 of a tree node, from its coordinates in 0…3: `x + 4z + 16y`, so that a horizontal slice is 16
/// neighbouring bits.
#[inline]
pub const fn child_index(x: u32, y: u32, z: u32) -> u32 {
    x | z << 2 | y << 4
}

/// Coordinates in 0…3 of a child index: the inverse of [`child_index`].
#[inline]
pub const fn child_cell(index: u32) -> [u32; 3] {
    [index & 3, index >> 4, index >> 2 & 3]
}

/// Index of a 4³ block in its chunk, from block coordinates in 0…15. Tree order: the 64 blocks of one 16³ node are neighbours.
#[inline]
pub const fn block_index(x: u32, y: u32, z: u32) -> usize {
    (child_index(x >> 2, y >> 2, z >> 2) << 6 | child_index(x & 3, y & 3, z & 3)) as usize
}

/// Block coordinates in 0…15 of a block index: the inverse of [`block_index`].
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "a chunk has 4096 blocks")]
pub const fn block_cell(index: usize) -> [u32; 3] {
    let [nx, ny, nz] = child_cell(index as u32 >> 6);
    let [x, y, z] = child_cell(index as u32 & 63);
    [nx << 2 | x, ny << 2 | y, nz << 2 | z]
}

/// Block and bit of a voxel, from chunk-local coordinates in 0…63.
#[inline]
pub const fn voxel_index(x: u32, y: u32, z: u32) -> (usize, u32) {
    (block_index(x >> 2, y >> 2, z >> 2), child_index(x & 3, y & 3, z & 3))
}

/// An immutable chunk with at least one solid voxel. Equal content is equal bytes.
#[derive(Clone)]
pub struct Chunk {
    /// Computed on request: a chunk that is edited or streamed never needs it.
    hash: OnceLock<u64>,
    masks: Box<[u64; BLOCKS]>,
    firsts: Box<[u32; BLOCKS]>,
    materials: Packed,
    solids: u32,
}

/// Materials of the solid voxels in tree order.
#[derive(Clone, PartialEq, Eq)]
enum Packed {
    /// All the same.
    Uniform(MaterialIndex),
    /// At most 256 of them: palette ascending.
    Indexed { palette: Box<[MaterialIndex]>, indices: Box<[u8]> },
    /// More.
    Plain(Box<[MaterialIndex]>),
}

impl Chunk {
    /// Packs a working copy. `None` when it has no solid voxel.
    pub fn pack(dense: &DenseChunk) -> Option<Self> {
        let masks = Box::new(*dense.masks());
        let (firsts, solids) = firsts(&masks);
        if solids == 0 {
            return None;
        }
        let materials = Packed::of_blocks(dense, solids as usize);
        Some(Self { hash: OnceLock::new(), masks, firsts, materials, solids })
    }

    /// From the occupancy of every block and the materials of the solid voxels in tree order. `None` when it has no solid voxel, or
    /// when there are not as many materials as solid voxels.
    pub fn from_parts(masks: &[u64; BLOCKS], materials: Vec<MaterialIndex>) -> Option<Self> {
        let masks = Box::new(*masks);
        let (firsts, solids) = firsts(&masks);
        if solids == 0 || solids as usize != materials.len() {
            return None;
        }
        Some(Self { hash: OnceLock::new(), masks, firsts, materials: Packed::from_plain(materials), solids })
    }

    /// The same with materials as [`Chunk::indexed`] gives them.
    pub fn from_indexed(masks: &[u64; BLOCKS], palette: &[MaterialIndex], indices: &[u8]) -> Option<Self> {
        let of_index = |index: &u8| palette.get(usize::from(*index)).copied();
        let is_used = |index: usize| u8::try_from(index).is_ok_and(|index| indices.contains(&index));
        let most = indices.iter().fold(0, |most, index| most.max(*index));
        let sorted = palette.is_sorted_by(|a, b| a < b);
        // As packing leaves it: equal content is equal bytes.
        if palette.len() < 2 || !sorted || usize::from(most) + 1 != palette.len() || !(0..palette.len()).all(is_used) {
            let masked = || masks.iter().map(|mask| mask.count_ones() as usize).sum();
            let plain = match palette {
                [material] if indices.is_empty() => vec![*material; masked()],
                _ => indices.iter().map(of_index).collect::<Option<_>>()?,
            };
            return Self::from_parts(masks, plain);
        }
        let masks = Box::new(*masks);
        let (firsts, solids) = firsts(&masks);
        let materials = Packed::Indexed { palette: palette.into(), indices: indices.into() };
        (solids as usize == indices.len()).then_some(Self { hash: OnceLock::new(), masks, firsts, materials, solids })
    }

    /// A chunk whose voxels are all solid, of one material.
    pub fn full(material: MaterialIndex) -> Self {
        static ALL: [u64; BLOCKS] = [u64::MAX; BLOCKS];
        Self::from_parts(&ALL, vec![material; CHUNK_VOXELS]).expect("it has as many materials as solid voxels")
    }

    /// A hash of the content.
    pub fn content_hash(&self) -> u64 {
        *self.hash.get_or_init(|| {
            self.masks.iter().copied().chain(self.materials.words()).fold(0, |hash: u64, word| {
                // The mixing step of FxHash; chunks with equal hashes are compared in full.
                (hash.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95)
            })
        })
    }

    /// Number of solid voxels, 1…262 144.
    #[inline]
    pub fn solids(&self) -> u32 {
        self.solids
    }

    /// Occupancy of every 4³ block, in the order of [`block_index`]; bits in the order of [`child_index`].
    #[inline]
    pub fn masks(&self) -> &[u64; BLOCKS] {
        &self.masks
    }

    /// Occupancy of one block, by [`block_index`].
    #[inline]
    pub fn mask(&self, block: usize) -> u64 {
        self.masks[block]
    }

    /// Occupancy of one 16³ node (0…63, by [`child_index`]): which of its 64 blocks have solids.
    #[inline]
    pub fn node_mask(&self, node: usize) -> u64 {
        let blocks = &self.masks[node * 64..][..64];
        blocks.iter().enumerate().fold(0, |mask, (i, &block)| mask | u64::from(block != 0) << i)
    }

    /// Occupancy of the chunk: which of its 64 nodes have solids.
    #[inline]
    pub fn root_mask(&self) -> u64 {
        (0..64).fold(0, |mask, node| mask | u64::from(self.node_mask(node) != 0) << node)
    }

    /// How many solids stand before the first one of a block, in tree order: the index of its first material.
    #[inline]
    pub fn first(&self, block: usize) -> u32 {
        self.firsts[block]
    }

    /// Material of the n-th solid voxel in tree order, `n < solids()`.
    #[inline]
    pub fn material(&self, n: u32) -> MaterialIndex {
        match &self.materials {
            Packed::Uniform(material) => *material,
            Packed::Indexed { palette, indices } => palette[indices[n as usize] as usize],
            Packed::Plain(materials) => materials[n as usize],
        }
    }

    /// Materials of the solid voxels of a block, in the order of the set bits of its mask.
    #[inline]
    pub fn block_materials(&self, block: usize) -> impl Iterator<Item = MaterialIndex> + '_ {
        let first = self.first(block);
        (first..first + self.mask(block).count_ones()).map(|n| self.material(n))
    }

    /// The materials of the solid voxels in tree order: those that there are, ascending, and an index into them for each voxel, or none where
    /// there is only one. `None` when there are more than 256.
    #[inline]
    pub fn indexed(&self) -> Option<(&[MaterialIndex], &[u8])> {
        match &self.materials {
            Packed::Uniform(material) => Some((std::slice::from_ref(material), &[])),
            Packed::Indexed { palette, indices } => Some((palette, indices)),
            Packed::Plain(_) => None,
        }
    }

    /// The only material of the solids of a block, if there is only one.
    #[inline]
    pub fn block_uniform(&self, block: usize) -> Option<MaterialIndex> {
        let count = self.mask(block).count_ones() as usize;
        if count == 0 {
            return None;
        }
        let first = self.first(block) as usize;
        match &self.materials {
            Packed::Uniform(material) => Some(*material),
            Packed::Indexed { palette, indices } => {
                let of_block = &indices[first..first + count];
                let index = of_block[0];
                let same = match <&[u8; 64]>::try_from(of_block) {
                    Ok(full) => *full == [index; 64],
                    // Without a branch for each voxel.
                    Err(_) => of_block.iter().fold(0, |different, other| different | (index ^ other)) == 0,
                };
                same.then(|| palette[usize::from(index)])
            }
            Packed::Plain(materials) => {
                let of_block = &materials[first..first + count];
                of_block.iter().all(|material| *material == of_block[0]).then_some(of_block[0])
            }
        }
    }

    /// The only material of all solids, if there is only one.
    pub fn uniform(&self) -> Option<MaterialIndex> {
        match self.materials {
            Packed::Uniform(material) => Some(material),
            _ => None,
        }
    }

    /// Whether `test` may hold for the material of a voxel in it. Never false if it does; with more than 256 materials, always true.
    pub fn may_have_material(&self, mut test: impl FnMut(MaterialIndex) -> bool) -> bool {
        match &self.materials {
            Packed::Uniform(material) => test(*material),
            Packed::Indexed { palette, .. } => palette.iter().any(|material| test(*material)),
            Packed::Plain(_) => true,
        }
    }

    /// Material at chunk-local coordinates in 0…63, or air.
    #[inline]
    pub fn voxel(&self, x: u32, y: u32, z: u32) -> MaterialIndex {
        let (block, bit) = voxel_index(x, y, z);
        let mask = self.mask(block);
        if mask >> bit & 1 == 0 {
            return AIR;
        }
        self.material(self.first(block) + (mask & ((1 << bit) - 1)).count_ones())
    }

    /// Every solid voxel in tree order, with chunk-local coordinates.
    pub fn iter(&self) -> impl Iterator<Item = ([u32; 3], MaterialIndex)> + '_ {
        self.masks.iter().enumerate().filter(|(_, mask)| **mask != 0).flat_map(move |(block, &mask)| {
            let [bx, by, bz] = block_cell(block);
            Bits(mask).zip(self.block_materials(block)).map(move |(bit, material)| {
                let [x, y, z] = child_cell(bit);
                ([bx << 2 | x, by << 2 | y, bz << 2 | z], material)
            })
        })
    }

    /// Adds the voxels of each material to `counts`, which is long enough for every material.
    pub(crate) fn count_materials(&self, counts: &mut [u64]) {
        match &self.materials {
            Packed::Uniform(material) => counts[*material as usize] += u64::from(self.solids),
            Packed::Indexed { palette, indices } => {
                let mut of_index = [0u64; 256];
                indices.iter().for_each(|&index| of_index[index as usize] += 1);
                palette.iter().zip(of_index).for_each(|(&material, count)| counts[material as usize] += count);
            }
            Packed::Plain(materials) => materials.iter().for_each(|&material| counts[material as usize] += 1),
        }
    }

    /// Box around its solids, in chunk-local coordinates.
    pub fn bounds(&self) -> Bounds {
        // Columns of each axis that have a solid, as bits 0…63.
        let mut occupied = [0u64; 3];
        for (block, &mask) in self.masks.iter().enumerate().filter(|(_, mask)| **mask != 0) {
            let [bx, by, bz] = block_cell(block);
            for i in 0..4 {
                occupied[0] |= u64::from(mask & 0x1111_1111_1111_1111 << i != 0) << (bx * 4 + i);
                occupied[1] |= u64::from(mask & 0xffff << (16 * i) != 0) << (by * 4 + i);
                occupied[2] |= u64::from(mask & 0x000f_000f_000f_000f << (4 * i) != 0) << (bz * 4 + i);
            }
        }
        Bounds {
            min: occupied.map(|bits| bits.trailing_zeros().into()),
            max: occupied.map(|bits| i64::from(bits.ilog2()) + 1),
        }
    }

    /// Bytes that it takes in main memory.
    pub fn bytes(&self) -> u64 {
        let materials = match &self.materials {
            Packed::Uniform(_) => 0,
            Packed::Indexed { palette, indices } => palette.len() * 2 + indices.len(),
            Packed::Plain(materials) => materials.len() * 2,
        };
        (size_of::<Self>() + size_of::<[u64; BLOCKS]>() + size_of::<[u32; BLOCKS]>() + materials) as u64
    }
}

/// For each block, how many solids stand before it; and how many there are.
fn firsts(masks: &[u64; BLOCKS]) -> (Box<[u32; BLOCKS]>, u32) {
    let mut firsts = Box::new([0u32; BLOCKS]);
    let mut solids = 0;
    for (first, mask) in firsts.iter_mut().zip(masks) {
        *first = solids;
        solids += mask.count_ones();
    }
    (firsts, solids)
}

impl PartialEq for Chunk {
    fn eq(&self, other: &Self) -> bool {
        let differ = self.hash.get().zip(other.hash.get()).is_some_and(|(hash, other)| hash != other);
        !differ && self.solids == other.solids && self.masks == other.masks && self.materials == other.materials
    }
}

impl Eq for Chunk {}

impl std::fmt::Debug for Chunk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Chunk({} solids)", self.solids)
    }
}

impl Hash for Chunk {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.content_hash());
    }
}

impl Packed {
    /// The content in words, for hashing.
    fn words(&self) -> Box<dyn Iterator<Item = u64> + '_> {
        let of_bytes = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        let of_materials =
            |materials: &[u16]| materials.iter().fold(0, |word, &material| word << 16 | u64::from(material));
        match self {
            Self::Uniform(material) => Box::new(std::iter::once(u64::from(*material))),
            Self::Indexed { palette, indices } => {
                Box::new(palette.chunks(4).map(of_materials).chain(indices.chunks(8).map(of_bytes)))
            }
            Self::Plain(materials) => Box::new(materials.chunks(4).map(of_materials)),
        }
    }

    /// Of a working copy with `solids` solids. Most blocks are of one material, and full.
    #[expect(clippy::cast_possible_truncation, reason = "materials have 16 bits, and this palette at most 256 entries")]
    fn of_blocks(dense: &DenseChunk, solids: usize) -> Self {
        let mut seen = vec![0u64; (1 << MaterialIndex::BITS) / 64];
        let mut see = |material: MaterialIndex| seen[usize::from(material / 64)] |= 1 << (material % 64);
        let mut uniform = [None; BLOCKS];
        let blocks = || dense.masks().iter().enumerate().filter(|(_, mask)| **mask != 0);
        for (block, mask) in blocks() {
            let voxels = dense.block(block);
            let first = voxels[mask.trailing_zeros() as usize];
            see(first);
            // Mostly those that are empty were given the same material as well, and all can be compared at once.
            let same = voxels.iter().fold(0, |different, material| different | (material ^ first)) == 0
                || *mask != u64::MAX && Bits(*mask).all(|bit| voxels[bit as usize] == first);
            if same {
                uniform[block] = Some(first);
            } else {
                Bits(*mask).for_each(|bit| see(voxels[bit as usize]));
            }
        }
        let words = seen.iter().enumerate().filter(|(_, word)| **word != 0);
        let palette: Box<[MaterialIndex]> = words
            .flat_map(|(at, word)| Bits(*word).map(move |bit| (64 * at) as MaterialIndex + bit as MaterialIndex))
            .collect();
        if let [material] = palette[..] {
            return Self::Uniform(material);
        }
        if palette.len() > 256 {
            let solids =
                blocks().flat_map(|(block, mask)| Bits(*mask).map(move |bit| dense.block(block)[bit as usize]));
            return Self::Plain(solids.collect());
        }
        let mut index_of = vec![0u8; 1 << MaterialIndex::BITS];
        palette.iter().enumerate().for_each(|(index, &material)| index_of[usize::from(material)] = index as u8);
        let mut indices = Vec::with_capacity(solids);
        for (block, mask) in blocks() {
            if let Some(material) = uniform[block] {
                indices.resize(indices.len() + mask.count_ones() as usize, index_of[usize::from(material)]);
            } else {
                let voxels = dense.block(block);
                indices.extend(Bits(*mask).map(|bit| index_of[usize::from(voxels[bit as usize])]));
            }
        }
        Self::Indexed { palette, indices: indices.into() }
    }

    #[expect(clippy::cast_possible_truncation, reason = "materials have 16 bits, and this palette at most 256 entries")]
    fn from_plain(plain: Vec<MaterialIndex>) -> Self {
        let first = plain[0];
        if plain.iter().all(|&material| material == first) {
            return Self::Uniform(first);
        }
        let mut seen = vec![false; *plain.iter().max().expect("a chunk has solids") as usize + 1];
        for &material in &plain {
            seen[material as usize] = true;
        }
        let palette: Box<[MaterialIndex]> =
            seen.iter().enumerate().filter(|(_, seen)| **seen).map(|(material, _)| material as MaterialIndex).collect();
        if palette.len() > 256 {
            return Self::Plain(plain.into());
        }
        let mut index_of = vec![0u8; seen.len()];
        palette.iter().enumerate().for_each(|(index, &material)| index_of[material as usize] = index as u8);
        Self::Indexed { palette, indices: plain.iter().map(|&material| index_of[material as usize]).collect() }
    }
}

/// The set bits of a mask, ascending.
#[derive(Clone, Debug)]
pub struct Bits(pub u64);

impl Iterator for Bits {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        if self.0 == 0 {
            return None;
        }
        let bit = self.0.trailing_zeros();
        self.0 &= self.0 - 1;
        Some(bit)
    }
}
