//! The stale tiles, the changes that made them stale, and the time that publications wait for them.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::reach::TileKey;

/// How long a publication waits for the rest of an edit, so that one edit appears in one frame.
const WHOLE_EDIT: Duration = Duration::from_millis(100);

/// Changes are numbered from 1.
#[derive(Default)]
pub(super) struct Changes {
    /// Tiles to be rebuilt, each with the first change that is not in it.
    stale: BTreeMap<TileKey, u64>,
    /// The last change that was observed.
    last: u64,
    /// The end of the time in which publications wait for chunks that are being rebuilt, and the last change whose chunks they wait for.
    held: Option<(Instant, u64)>,
}

impl Changes {
    /// Observes the number of the last change. The caller calls [`Self::note`] for every tile that changed.
    pub(super) fn observe(&mut self, last: u64) {
        self.last = last;
    }

    /// Notes that a tile lacks a change.
    pub(super) fn note(&mut self, key: TileKey, number: u64) {
        self.stale.entry(key).or_insert(number);
    }

    /// Whether a tile is to be made again.
    pub(super) fn concern(&self, key: &TileKey) -> bool {
        self.stale.contains_key(key)
    }

    /// Whether none is.
    pub(super) fn are_made(&self) -> bool {
        self.stale.is_empty()
    }

    /// Tiles to be rebuilt, chunks first.
    pub(super) fn tiles(&self) -> impl Iterator<Item = TileKey> {
        self.stale.keys().copied()
    }

    /// A tile came from a worker, or is given up. Returns the first change that was not in it.
    pub(super) fn forget(&mut self, key: TileKey) -> Option<u64> {
        self.stale.remove(&key)
    }

    /// The last change all of whose chunks are made. Coarse tiles do not count, because they are only seen from afar.
    pub(super) fn whole(&self) -> u64 {
        let chunks = self.stale.iter().take_while(|(key, _)| key.level == 0);
        chunks.map(|(_, since)| since - 1).min().unwrap_or(self.last)
    }

    /// Publications wait for the rest of all changes up to now, if there is any and they do not wait already.
    pub(super) fn hold(&mut self) {
        if !self.are_held() {
            self.hold_anew();
        }
    }

    /// A publication is made. The next one waits for later changes in turn; an edit that takes too long is shown in parts.
    pub(super) fn show(&mut self) {
        let whole = self.held.is_none_or(|(_, number)| self.whole() >= number);
        self.held = None;
        if whole {
            self.hold_anew();
        }
    }

    fn hold_anew(&mut self) {
        let unmade = self.whole() < self.last;
        self.held = unmade.then(|| (Instant::now() + WHOLE_EDIT, self.last));
    }

    /// Whether publications wait for the rest of an edit.
    pub(super) fn are_held(&self) -> bool {
        self.held.is_some_and(|(until, number)| self.whole() < number && Instant::now() < until)
    }
}
