//! Headers of the layouts, the materials behind them, and the cube that a world is put in.

use super::block::{BlockMember, GlslType, WORDS_STRIDE, header};
use super::{Layout, LayoutError};
use crate::material::Material;
use crate::world::World;

/// Words of a material: albedo, roughness, metallic, emission, transparency, one unused.
pub const MATERIAL_WORDS: u32 = 8;

/// Largest cube: 2³⁰ voxels a side.
const MAX_LOG2_SIZE: u32 = 30;

header! {
    /// Header of the layout `tree64`. Addresses count from the first word behind the header, in units of what they point to: words,
    /// nodes of four words, leaves of two.
    Tree64Header {
        /// Smallest corner of the root's cube, in voxels.
        origin: [i32; 3],
        /// The cube has 2^`log2_size` voxels a side; even, at least 6.
        log2_size: u32,
        /// Smallest coordinates of solid voxels.
        bounds_min: [i32; 3],
        /// Materials, air included.
        material_count: u32,
        /// Largest coordinates of solid voxels.
        bounds_last: [i32; 3],
        /// Word of the first material.
        materials_at: u32,
        /// Address of the root node.
        root: u32,
        /// Nodes in the buffer.
        node_count: u32,
        /// Leaves in the buffer.
        leaf_count: u32,
        /// Always 0: the nodes behind begin at a multiple of their size.
        unused: u32,
    }
}

header! {
    /// Header of the layout `chunks`. Addresses (`…_at`) count words from the first word behind the header.
    ChunksHeader {
        /// Smallest corner of a cube around the world, in voxels.
        origin: [i32; 3],
        /// The cube has 2^`log2_size` voxels a side.
        log2_size: u32,
        /// Smallest coordinates of solid voxels.
        bounds_min: [i32; 3],
        /// Materials, air included.
        material_count: u32,
        /// Largest coordinates of solid voxels.
        bounds_last: [i32; 3],
        /// Address of the first material.
        materials_at: u32,
        /// Address of the list: a key of each chunk, then for each x, y, z in chunks, and the address of its voxels.
        chunks_at: u32,
        /// Chunks.
        chunk_count: u32,
        /// Address of the first voxel.
        voxels_at: u32,
        /// Chunks of voxels: equal chunks share them.
        voxel_chunks: u32,
    }
}

/// The cube that a layout puts a world in, and the box of its solid voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Smallest corner of the cube: multiples of 64.
    pub origin: [i32; 3],
    /// The cube has 2^`log2_size` voxels a side: a power of 4, at least 64.
    pub log2_size: u32,
    /// Smallest coordinates of solid voxels.
    pub bounds_min: [i32; 3],
    /// Largest coordinates of solid voxels; below `bounds_min` in an empty world.
    pub bounds_last: [i32; 3],
}

impl Extent {
    /// The smallest cube of whole 64-tree levels around all chunks of a world.
    pub fn of(world: &World, layout: Layout) -> Result<Self, LayoutError> {
        let Some(bounds) = world.bounds() else {
            return Ok(Self { origin: [0; 3], log2_size: 6, bounds_min: [0; 3], bounds_last: [-1; 3] });
        };
        let low = bounds.min.map(|min| min & !63);
        let span = (0..3).map(|i| (bounds.max[i] - low[i]) as u64).max().unwrap_or(1);
        let log2_size = (6..=MAX_LOG2_SIZE)
            .step_by(2)
            .find(|log2| span <= 1 << log2)
            .ok_or_else(|| LayoutError::TooWide { layout: layout.name(), span, limit: 1 << MAX_LOG2_SIZE })?;
        Ok(Self {
            // The cube may not reach beyond the largest coordinate.
            origin: low.map(|low| low.min((1 << 31) - (1 << log2_size)) as i32),
            log2_size,
            bounds_min: bounds.min.map(|min| min as i32),
            bounds_last: bounds.max.map(|max| (max - 1) as i32),
        })
    }
}

/// Materials as words, in palette order.
pub(super) fn material_words(materials: &[Material]) -> Vec<u32> {
    let words = |m: &Material| {
        let [r, g, b] = m.albedo;
        [r, g, b, m.roughness, m.metallic, m.emission, m.transparency, 0.0].map(f32::to_bits)
    };
    materials.iter().flat_map(words).collect()
}

/// A buffer of `words` words that begins with a header and the materials; the rest is 0.
pub(super) fn buffer(header: &impl bytemuck::NoUninit, materials: &[Material], words: usize) -> Vec<u32> {
    let mut buffer = Vec::with_capacity(words);
    buffer.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(header)));
    buffer.extend(material_words(materials));
    buffer.resize(words, 0);
    buffer
}
