//! The cube that a world is put in, and the materials behind the header.

use raxel_world::Material;
use raxel_world::World;

use super::{Layout, LayoutError};

/// Words of a material: albedo, roughness, metallic, emission, transparency, one unused.
pub const MATERIAL_WORDS: u32 = 8;

/// Largest cube: 2³⁰ voxels a side.
pub(super) const MAX_LOG2_SIZE: u32 = 30;

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
        let span = (0..3).map(|i| (bounds.max[i] - low[i]).cast_unsigned()).max().unwrap_or(1);
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

impl Extent {
    /// Widens the box of the solid voxels to whole chunks of `edge` voxels, a power of two of at most 64. That of an empty world stays empty.
    pub fn round_out(&mut self, edge: i32) {
        self.bounds_min = self.bounds_min.map(|min| min & -edge);
        self.bounds_last = self.bounds_last.map(|last| last | (edge - 1));
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
pub fn buffer(header: &impl bytemuck::NoUninit, materials: &[Material], words: usize) -> Vec<u32> {
    let mut buffer = Vec::with_capacity(words);
    buffer.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(header)));
    buffer.extend(material_words(materials));
    buffer.resize(words, 0);
    buffer
}
