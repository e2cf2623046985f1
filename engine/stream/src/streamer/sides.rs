//! The outermost voxels of chunks beside those that have lamps at a border. To make a whole chunk once more for them takes longer than
//! everything else that there is to do for a chunk that was edited.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use raxel_world::{ChunkPos, Side};

/// Sides that are kept, of 512 bytes each; with more, all of them are dropped.
const MOST: usize = 1 << 14;

/// Sides of chunks by where these lie and by the face.
#[derive(Default)]
pub(super) struct Sides(Mutex<Known>);

/// Whole at each unlock: no code of others runs while it is locked.
#[derive(Default)]
struct Known {
    sides: HashMap<(ChunkPos, u32), Arc<Side>>,
    /// Sides that are being made, by a number: at most one for each thread.
    making: HashMap<u64, Making>,
    /// How many were ever begun.
    begun: u64,
}

/// A side that is being made.
struct Making {
    pos: ChunkPos,
    /// The chunk has changed since it was begun: the side may be of what the chunk was before.
    stale: bool,
}

/// Takes the note of a side that is being made back, however the making ends.
struct Begun<'s> {
    sides: &'s Sides,
    number: u64,
}

impl Drop for Begun<'_> {
    fn drop(&mut self) {
        self.sides.known().making.remove(&self.number);
    }
}

impl Sides {
    /// The side of a chunk, or what `make` says that it is; what that does not have is not kept.
    pub(super) fn get(&self, pos: ChunkPos, face: u32, make: impl FnOnce() -> (Side, bool)) -> Arc<Side> {
        let begun = {
            let mut known = self.known();
            if let Some(side) = known.sides.get(&(pos, face)) {
                return side.clone();
            }
            known.begun += 1;
            let number = known.begun;
            known.making.insert(number, Making { pos, stale: false });
            Begun { sides: self, number }
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

    /// Chunks are no longer what they were.
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
        let sides = Sides::default();
        let [here, there] = [0, 1].map(|x| ChunkPos::new(x, 0, 0));
        let side = |content: &Content| (Side::of(content, 2), true);
        let [air, rock] = [Content::Empty, Content::Full(1)];
        let is_rock = |side: Arc<Side>| side.is_solid([3; 3], 2);
        assert!(is_rock(sides.get(here, 2, || side(&rock))));
        assert!(is_rock(sides.get(here, 2, || unreachable!())));
        assert!(!is_rock(sides.get(here, 3, || side(&air))) && !is_rock(sides.get(there, 2, || side(&air))));
        sides.changed(&[here]);
        // What was made of the chunk as it was before a change is not kept.
        let before = sides.get(here, 2, || {
            sides.changed(&[here]);
            side(&rock)
        });
        assert!(is_rock(before) && !is_rock(sides.get(here, 2, || side(&air))));
        assert!(!is_rock(sides.get(here, 2, || unreachable!())) && !is_rock(sides.get(there, 2, || unreachable!())));
        // Nor is what could not be had.
        sides.changed(&[there]);
        assert!(!is_rock(sides.get(there, 2, || (Side::of(&air, 2), false))));
        assert!(is_rock(sides.get(there, 2, || side(&rock))));
    }

    #[test]
    fn what_is_kept_stays_bounded_over_a_long_flight_with_edits() {
        let sides = Sides::default();
        let side = || (Side::of(&Content::Full(1), 2), true);
        for step in 0..50_000 {
            let here = ChunkPos::new(step, 0, 0);
            sides.get(here, 2, side);
            sides.changed(&[here, ChunkPos::new(step, 1, 0)]);
            sides.get(here, 2, side);
            if step % 1000 == 0 {
                // A source may panic, and the note of it goes as well.
                let panics =
                    std::panic::AssertUnwindSafe(|| sides.get(ChunkPos::new(step, 2, 0), 2, || panic!("none")));
                assert!(std::panic::catch_unwind(panics).is_err());
            }
        }
        let known = sides.known();
        assert!(known.sides.len() <= MOST && known.making.is_empty() && known.begun > 50_000);
        // All that can grow is named here.
        let Known { sides: _, making: _, begun: _ } = &*known;
    }
}
