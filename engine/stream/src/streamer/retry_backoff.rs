//! Decides when the director asks again for tiles that the source did not have.

use std::collections::{BTreeMap, HashSet};
use std::time::{Duration, Instant};

use raxel_world::Unavailable;

use crate::reach::TileKey;

/// How long the director waits after a tile was missing once. It waits twice as long after each further time.
const FIRST: Duration = Duration::from_millis(500);
/// The longest wait for one tile.
const LONGEST: Duration = Duration::from_secs(30);
/// A tile that was missing this many times fails a world that must be complete.
const OFTEN: u32 = 4;

#[derive(Default)]
pub(super) struct RetryBackoff {
    tiles: BTreeMap<TileKey, Waiting>,
    /// Why the source did not have the last of them.
    reason: Option<Unavailable>,
    /// When the first tile that [`Self::at`] returned last may be asked for again.
    next: Option<Instant>,
}

struct Waiting {
    times: u32,
    /// `None`: it need not wait.
    until: Option<Instant>,
}

impl RetryBackoff {
    /// Counts that the source did not have a tile. Returns whether it has failed often enough to give up on it.
    pub(super) fn add(&mut self, key: TileKey, reason: Unavailable, now: Instant) -> bool {
        let waiting = self.tiles.entry(key).or_insert(Waiting { times: 0, until: None });
        let pause = FIRST.saturating_mul(1 << waiting.times.min(16)).min(LONGEST);
        let (times, until) = (waiting.times + 1, now + pause);
        *waiting = Waiting { times, until: Some(until) };
        self.reason = Some(reason);
        self.next = Some(self.next.map_or(until, |next| next.min(until)));
        times >= OFTEN
    }

    /// Lets every tile be asked for at once, as if it had never been missing.
    pub(super) fn start_over(&mut self) {
        self.tiles.values_mut().for_each(|waiting| *waiting = Waiting { times: 0, until: None });
        self.next = None;
    }

    /// The source has the tile now.
    pub(super) fn remove(&mut self, key: TileKey) {
        self.tiles.remove(&key);
    }

    /// Forgets tiles that are no longer wanted.
    pub(super) fn retain(&mut self, wanted: impl Fn(&TileKey) -> bool) {
        self.tiles.retain(|key, _| wanted(key));
    }

    /// Whether a tile that [`Self::at`] returned has waited long enough. Returns true once.
    pub(super) fn is_due(&mut self, now: Instant) -> bool {
        self.next.take_if(|next| *next <= now).is_some()
    }

    /// The tiles that must still wait at a time.
    pub(super) fn at(&mut self, now: Instant) -> HashSet<TileKey> {
        let waiting = || self.tiles.iter().filter(|(_, waiting)| waiting.until > Some(now));
        self.next = waiting().filter_map(|(_, waiting)| waiting.until).min();
        waiting().map(|(key, _)| *key).collect()
    }

    /// The number of tiles that the source did not have.
    pub(super) fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Why the source did not have the last of them; `None` when all have come.
    pub(super) fn reason(&self) -> Option<&Unavailable> {
        self.reason.as_ref().filter(|_| !self.tiles.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::{Cause, ChunkPos};

    use super::*;

    #[test]
    fn tiles_wait_longer_each_time() {
        let key = |x| TileKey { level: 0, pos: ChunkPos::new(x, 0, 0) };
        let (start, why) = (Instant::now(), Unavailable::new(0, ChunkPos::new(1, 0, 0), Cause::Failing, "busy"));
        let mut backoff = RetryBackoff::default();
        assert!(!backoff.is_due(start) && backoff.reason().is_none());
        backoff.add(key(1), why.clone(), start);
        backoff.add(key(2), why.clone(), start);
        assert_eq!((backoff.len(), backoff.reason()), (2, Some(&why)));
        assert_eq!(backoff.at(start).len(), 2);
        assert!(!backoff.is_due(start + FIRST / 2));
        // Only once: the director then asks for all that are due.
        assert!(backoff.is_due(start + FIRST) && !backoff.is_due(start + FIRST));
        assert!(backoff.at(start + FIRST).is_empty());
        backoff.remove(key(1));
        assert!(!backoff.add(key(2), why.clone(), start + FIRST));
        assert!(backoff.at(start + 2 * FIRST).contains(&key(2)) && backoff.at(start + 3 * FIRST).is_empty());
        assert!(!backoff.add(key(2), why.clone(), start) && backoff.add(key(2), why.clone(), start));
        (0..40).for_each(|_| assert!(backoff.add(key(2), why.clone(), start)));
        assert!(backoff.at(start + LONGEST).is_empty());
        backoff.start_over();
        assert!(backoff.at(start).is_empty() && backoff.reason() == Some(&why));
        assert!(!backoff.add(key(2), why.clone(), start), "it was missing once");
        backoff.retain(|key| key.pos.x != 2);
        assert_eq!((backoff.len(), backoff.reason()), (0, None));
    }
}
