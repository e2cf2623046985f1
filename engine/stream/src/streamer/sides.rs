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

#[derive(Default)]
struct Known {
    sides: HashMap<(ChunkPos, u32), Arc<Side>>,
    /// When chunks last changed, in changes.
    changed: HashMap<ChunkPos, u64>,
    now: u64,
}

impl Sides {
    /// The side of a chunk, or what `make` says that it is; what that does not have is not kept.
    pub(super) fn get(&self, pos: ChunkPos, face: u32, make: impl FnOnce() -> (Side, bool)) -> Arc<Side> {
        let before = {
            let known = self.known();
            if let Some(side) = known.sides.get(&(pos, face)) {
                return side.clone();
            }
            known.now
        };
        let (side, keep) = make();
        let side = Arc::new(side);
        let mut known = self.known();
        // It may have been made of what the chunk was before.
        if keep && known.changed.get(&pos).is_none_or(|changed| *changed <= before) {
            if known.sides.len() >= MOST {
                known.sides.clear();
            }
            known.sides.insert((pos, face), side.clone());
        }
        side
    }

    /// Chunks are no longer what they were.
    pub(super) fn changed(&self, chunks: &[ChunkPos]) {
        let mut known = self.known();
        known.now += 1;
        let now = known.now;
        for pos in chunks {
            known.changed.insert(*pos, now);
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
}
