//! A model at one or more places.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_world::MaterialIndex;
use raxel_world::Mode;
use raxel_world::Placement;
use raxel_world::{Bounds, ChunkPos, World};

use crate::{Draft, chunk_ranges};

/// A model, where it stands, and what its materials become.
pub struct Placed {
    /// Its voxels.
    pub model: Arc<World>,
    /// Palette index in the world being built, by the model's palette index.
    pub materials: Arc<[MaterialIndex]>,
    /// Where it stands; a later one wins over an earlier one.
    pub placements: Vec<Placement>,
    /// Add, subtract or paint.
    pub mode: Mode,
}

/// The parts of placements that touch a chunk: index of the placement, position of the part in the model.
pub(crate) type Touching = BTreeMap<ChunkPos, Vec<(usize, ChunkPos)>>;

impl Placed {
    /// A box of voxels after a placement.
    pub fn placed_bounds(bounds: &Bounds, placement: &Placement) -> Bounds {
        let a = placement.cell(bounds.min);
        let b = placement.cell(bounds.max.map(|m| m - 1));
        Bounds {
            min: std::array::from_fn(|i| a[i].min(b[i])),
            max: std::array::from_fn(|i| a[i].max(b[i]).saturating_add(1)),
        }
    }

    /// Chunks that are touched, each with the placements; `None` when they are more than `limit`.
    pub(crate) fn touching(&self, limit: u64) -> Option<Touching> {
        let boxes: Vec<_> = (self.model.chunks())
            .map(|(pos, chunk)| (pos, chunk.bounds().moved(pos.origin().to_array().map(i64::from))))
            .collect();
        let mut touching = Touching::new();
        let mut count = 0;
        for (index, placement) in self.placements.iter().enumerate() {
            for (part, bounds) in &boxes {
                let [xs, ys, zs] = chunk_ranges(&Self::placed_bounds(bounds, placement));
                for y in ys {
                    for z in zs.clone() {
                        for x in xs.clone() {
                            count += 1;
                            touching.entry(ChunkPos::of_range([x, y, z])).or_default().push((index, *part));
                        }
                    }
                }
                // A part touches at most eight chunks, so this is soon enough; scattered small models share their chunks.
                if touching.len() as u64 > limit || count > 16 * limit {
                    return None;
                }
            }
        }
        Some(touching)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cell is inside the chunk, whose coordinates are below 64"
    )]
    pub(crate) fn apply(&self, draft: &mut Draft<'_>, touching: &Touching) {
        let Some(parts) = touching.get(&draft.pos) else { return };
        let origin = draft.pos.origin().to_array().map(i64::from);
        for (index, part) in parts {
            let placement = &self.placements[*index];
            let Some(chunk) = self.model.chunk(*part) else { continue };
            let from = part.origin().to_array().map(i64::from);
            for (local, material) in chunk.iter() {
                let cell = placement.cell(std::array::from_fn(|i| from[i] + i64::from(local[i])));
                let local: [i64; 3] = std::array::from_fn(|i| cell[i] - origin[i]);
                if local.iter().all(|l| (0..64).contains(l)) {
                    let (block, bit) = raxel_world::voxel_index(local[0] as u32, local[1] as u32, local[2] as u32);
                    draft.chunk.apply(block, 1 << bit, self.mode, self.materials[material as usize]);
                }
            }
        }
    }
}
