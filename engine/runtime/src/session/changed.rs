//! Where the world has changed since the last frame: `world.changed_min` and `world.changed_max`.

use std::sync::Arc;

use raxel_world::{Bounds, Chunk, ChunkPos, World};

use crate::world::NOWHERE;

/// No voxel is larger; a box that ends here ends nowhere.
const EVERYWHERE: Bounds = Bounds { min: [-(1 << 31); 3], max: [(1 << 31) - 1; 3] };

/// The changes since the last frame ran.
#[derive(Clone, Copy, Debug)]
pub(super) struct Changed {
    /// The box around all changes; `None`: nothing.
    bounds: Option<Bounds>,
    /// More than the list can hold.
    everywhere: bool,
    /// The publication of a streamed world that the last frame showed.
    version: u64,
}

impl Changed {
    /// Before the first frame.
    pub(super) fn new() -> Self {
        Self { bounds: None, everywhere: true, version: 0 }
    }

    /// Another world, or another beginning.
    pub(super) fn everything(&mut self) {
        self.everywhere = true;
    }

    /// The publication of a streamed world that the next frame shows, 0 for worlds that are not streamed.
    pub(super) fn publication(&mut self, version: u64) {
        self.everywhere |= self.version != version;
        self.version = version;
    }

    /// Chunks that are to become others, and the world in which they are not yet.
    pub(super) fn note(&mut self, before: &World, changes: &[(ChunkPos, Option<Arc<Chunk>>)]) {
        for (pos, after) in changes {
            let here = difference(*pos, before.chunk(*pos).map(|chunk| &**chunk), after.as_deref());
            self.bounds = self.bounds.into_iter().chain(here).reduce(Bounds::union);
        }
    }

    /// The box; empty at the origin when nothing has changed.
    pub(super) fn bounds(&self) -> Bounds {
        if self.everywhere { EVERYWHERE } else { self.bounds.unwrap_or(NOWHERE) }
    }

    /// A frame has run.
    pub(super) fn shown(&mut self) {
        *self = Self { bounds: None, everywhere: false, version: self.version };
    }
}

/// A box around the blocks of 4³ voxels in which two chunks at a position differ.
fn difference(pos: ChunkPos, before: Option<&Chunk>, after: Option<&Chunk>) -> Option<Bounds> {
    let corner = pos.origin().to_array().map(i64::from);
    let mask = |chunk: Option<&Chunk>, block: usize| chunk.map_or(0, |chunk| chunk.mask(block));
    let materials = |chunk: Option<&Chunk>, block: usize| {
        chunk.into_iter().flat_map(move |chunk| chunk.block_materials(block)).collect::<Vec<_>>()
    };
    let mut found: Option<Bounds> = None;
    for z in 0..16 {
        for y in 0..16 {
            for x in 0..16 {
                let block = raxel_world::block_index(x, y, z);
                let same = mask(before, block) == mask(after, block)
                    && (mask(before, block) == 0 || materials(before, block) == materials(after, block));
                if !same {
                    let at = [x, y, z].map(|at| 4 * i64::from(at));
                    let min = std::array::from_fn(|i| corner[i] + at[i]);
                    let here = Bounds { min, max: min.map(|cell| cell + 4) };
                    found = found.into_iter().chain([here]).reduce(Bounds::union);
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_world::{Material, World};

    use super::*;

    fn of(voxels: &[([i32; 3], u16)]) -> World {
        let materials = (0..4).map(|i| Material::matt(format!("m{i}"), [0.5; 3])).collect();
        World::from_voxels(materials, voxels.iter().map(|(cell, material)| (IVec3::from_array(*cell), *material)))
    }

    fn changes(before: &World, after: &World) -> Vec<(ChunkPos, Option<Arc<Chunk>>)> {
        let gone = before.chunks().filter(|(pos, _)| after.chunk(*pos).is_none()).map(|(pos, _)| (pos, None));
        after.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))).chain(gone).collect()
    }

    #[test]
    fn a_box_is_around_every_voxel_that_is_another_one() {
        let before = of(&[([0, 0, 0], 1), ([10, 20, 30], 1), ([-1, 5, 5], 2), ([70, 0, 0], 3)]);
        let mut changed = Changed::new();
        assert_eq!(changed.bounds(), EVERYWHERE, "nothing was shown yet");
        changed.shown();
        assert_eq!(changed.bounds(), NOWHERE);
        changed.note(&before, &changes(&before, &before));
        assert_eq!(changed.bounds(), NOWHERE, "the same chunks");
        // Another material, a voxel less, a chunk less.
        let painted = of(&[([0, 0, 0], 1), ([10, 20, 30], 2), ([-1, 5, 5], 2), ([70, 0, 0], 3)]);
        changed.note(&before, &changes(&before, &painted));
        assert_eq!(changed.bounds(), Bounds { min: [8, 20, 28], max: [12, 24, 32] });
        let dug = of(&[([10, 20, 30], 2), ([-1, 5, 5], 2), ([70, 0, 0], 3)]);
        changed.note(&painted, &changes(&painted, &dug));
        assert_eq!(changed.bounds(), Bounds { min: [0, 0, 0], max: [12, 24, 32] }, "both edits of a frame");
        changed.shown();
        let less = of(&[([10, 20, 30], 2), ([70, 0, 0], 3)]);
        changed.note(&dug, &changes(&dug, &less));
        assert_eq!(changed.bounds(), Bounds { min: [-4, 4, 4], max: [0, 8, 8] });
        changed.publication(7);
        assert_eq!(changed.bounds(), EVERYWHERE);
        changed.shown();
        changed.publication(7);
        assert_eq!(changed.bounds(), NOWHERE);
    }
}
