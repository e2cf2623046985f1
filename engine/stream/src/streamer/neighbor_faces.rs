//! Caches the outermost voxels of chunks, which the lamps of the chunk next to them depend on. Generating the whole neighbour again would take
//! longer than all other work for an edited chunk.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use raxel_world::{ChunkPos, Side};

/// Faces in the cache, of 512 bytes each. The cache drops all of them when it is full.
const MOST: usize = 1 << 14;

/// The outermost voxels of chunks, by the position of the chunk and the face.
#[derive(Default)]
pub(super) struct NeighborFaceCache(Mutex<Known>);

/// Consistent at each unlock: only code of this file runs while it is locked.
#[derive(Default)]
struct Known {
    sides: HashMap<(ChunkPos, u32), Arc<Side>>,
    /// Faces that are being made, by a number of their own: at most one for each thread.
    making: HashMap<u64, Making>,
    /// The number of the last face that was begun.
    begun: u64,
}

/// A face that is being made.
struct Making {
    pos: ChunkPos,
    /// The chunk has changed since then, so that the face may show its old voxels.
    stale: bool,
}

/// Removes the entry of a face that is being made, also when `make` panics.
struct Begun<'s> {
    cache: &'s NeighborFaceCache,
    number: u64,
}

impl Drop for Begun<'_> {
    fn drop(&mut self) {
        self.cache.known().making.remove(&self.number);
    }
}

impl NeighborFaceCache {
    /// The cached face of a chunk, or the one that `make` returns. `make` also decides whether to cache it: a face that could not be loaded
    /// is not cached.
    pub(super) fn get(&self, pos: ChunkPos, face: u32, make: impl FnOnce() -> (Side, bool)) -> Arc<Side> {
        let begun = {
            let mut known = self.known();
            if let Some(side) = known.sides.get(&(pos, face)) {
                return side.clone();
            }
            known.begun += 1;
            let number = known.begun;
            known.making.insert(number, Making { pos, stale: false });
            Begun { cache: self, number }
        };
        let (side, keep) = make();
        let side = Arc::new(side);
        let mut known = self.known();
        if keep && known.making.get(&begun.number).is_some_and(|making| !making.stale) {
            if known.sides.len() >= MOST {
                known.sides.clear();
            }
            known.sides.insert((pos, face), side.clone());
        }
        drop(known);
        side
    }

    /// Drops the faces of chunks that have changed.
    pub(super) fn changed(&self, chunks: &[ChunkPos]) {
        let mut known = self.known();
        for pos in chunks {
            known.making.values_mut().filter(|making| making.pos == *pos).for_each(|making| making.stale = true);
            for face in 0..6 {
                known.sides.remove(&(*pos, face));
            }
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::Content;

    use super::*;

    #[test]
    fn a_side_is_made_once_until_its_chunk_changes() {
        let faces = NeighborFaceCache::default();
        let [here, there] = [0, 1].map(|x| ChunkPos::new(x, 0, 0));
        let side = |content: &Content| (Side::of(content, 2), true);
        let [air, rock] = [Content::Empty, Content::Full(1)];
        let is_rock = |side: Arc<Side>| side.is_solid([3; 3], 2);
        assert!(is_rock(faces.get(here, 2, || side(&rock))));
        assert!(is_rock(faces.get(here, 2, || unreachable!())));
        assert!(!is_rock(faces.get(here, 3, || side(&air))) && !is_rock(faces.get(there, 2, || side(&air))));
        faces.changed(&[here]);
        // Faces of the chunk before a change are not kept.
        let before = faces.get(here, 2, || {
            faces.changed(&[here]);
            side(&rock)
        });
        assert!(is_rock(before) && !is_rock(faces.get(here, 2, || side(&air))));
        assert!(!is_rock(faces.get(here, 2, || unreachable!())) && !is_rock(faces.get(there, 2, || unreachable!())));
        // Faces that could not be read are not kept either.
        faces.changed(&[there]);
        assert!(!is_rock(faces.get(there, 2, || (Side::of(&air, 2), false))));
        assert!(is_rock(faces.get(there, 2, || side(&rock))));
    }

    #[test]
    fn what_is_kept_stays_bounded_over_a_long_flight_with_edits() {
        let faces = NeighborFaceCache::default();
        let side = || (Side::of(&Content::Full(1), 2), true);
        for step in 0..50_000 {
            let here = ChunkPos::new(step, 0, 0);
            faces.get(here, 2, side);
            faces.changed(&[here, ChunkPos::new(step, 1, 0)]);
            faces.get(here, 2, side);
            if step % 1000 == 0 {
                // A source may panic, and the note of it goes as well.
                let panics =
                    std::panic::AssertUnwindSafe(|| faces.get(ChunkPos::new(step, 2, 0), 2, || panic!("none")));
                assert!(std::panic::catch_unwind(panics).is_err());
            }
        }
        let known = faces.known();
        assert!(known.sides.len() <= MOST && known.making.is_empty() && known.begun > 50_000);
        // All that can grow is named here.
        let Known { sides: _, making: _, begun: _ } = &*known;
    }
}
