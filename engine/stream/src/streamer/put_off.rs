//! Tiles that the source did not have when they were asked for, and when they are asked for again.

use std::collections::{BTreeMap, HashSet};
use std::time::{Duration, Instant};

use raxel_world::Unavailable;

use crate::reach::TileKey;

/// How long a tile waits after the first time; twice as long after each time that follows.
const FIRST: Duration = Duration::from_millis(500);
/// The longest that it waits.
const LONGEST: Duration = Duration::from_secs(30);
/// So many times are often.
const OFTEN: u32 = 4;

#[derive(Default)]
pub(super) struct PutOff {
    tiles: BTreeMap<TileKey, Waiting>,
    /// Why the last one was not there.
    reason: Option<Unavailable>,
    /// When the next of those is due that were left out last.
    next: Option<Instant>,
}

struct Waiting {
    times: u32,
    until: Instant,
}

impl PutOff {
    /// Notes that a tile was not there. Says whether that was so often.
    pub(super) fn add(&mut self, key: TileKey, reason: Unavailable, now: Instant) -> bool {
        let waiting = self.tiles.entry(key).or_insert(Waiting { times: 0, until: now });
        let pause = FIRST.saturating_mul(1 << waiting.times.min(16)).min(LONGEST);
        *waiting = Waiting { times: waiting.times + 1, until: now + pause };
        let (times, until) = (waiting.times, waiting.until);
        self.reason = Some(reason);
        self.next = Some(self.next.map_or(until, |next| next.min(until)));
        times >= OFTEN
    }

    /// It is there now.
    pub(super) fn remove(&mut self, key: TileKey) {
        self.tiles.remove(&key);
    }

    /// Forgets tiles that nobody wants any more.
    pub(super) fn retain(&mut self, wanted: impl Fn(&TileKey) -> bool) {
        self.tiles.retain(|key, _| wanted(key));
    }

    /// Whether one that was left out has waited long enough. True once.
    pub(super) fn is_due(&mut self, now: Instant) -> bool {
        self.next.take_if(|next| *next <= now).is_some()
    }

    /// The tiles that are not to be asked for at a time.
    pub(super) fn at(&mut self, now: Instant) -> HashSet<TileKey> {
        let waiting = || self.tiles.iter().filter(|(_, waiting)| waiting.until > now);
        self.next = waiting().map(|(_, waiting)| waiting.until).min();
        waiting().map(|(key, _)| *key).collect()
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Why the last one was not there, if there are any.
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
        let mut put_off = PutOff::default();
        assert!(!put_off.is_due(start) && put_off.reason().is_none());
        put_off.add(key(1), why.clone(), start);
        put_off.add(key(2), why.clone(), start);
        assert_eq!((put_off.len(), put_off.reason()), (2, Some(&why)));
        assert_eq!(put_off.at(start).len(), 2);
        assert!(!put_off.is_due(start + FIRST / 2));
        // Only once: whoever asks then asks for all that are due.
        assert!(put_off.is_due(start + FIRST) && !put_off.is_due(start + FIRST));
        assert!(put_off.at(start + FIRST).is_empty());
        put_off.remove(key(1));
        assert!(!put_off.add(key(2), why.clone(), start + FIRST));
        assert!(put_off.at(start + 2 * FIRST).contains(&key(2)) && put_off.at(start + 3 * FIRST).is_empty());
        assert!(!put_off.add(key(2), why.clone(), start) && put_off.add(key(2), why.clone(), start));
        (0..40).for_each(|_| assert!(put_off.add(key(2), why.clone(), start)));
        assert!(put_off.at(start + LONGEST).is_empty());
        put_off.retain(|key| key.pos.x != 2);
        assert_eq!((put_off.len(), put_off.reason()), (0, None));
    }
}
