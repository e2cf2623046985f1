//! Which tiles are stale, since which change, and how long publications wait for them.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::reach::TileKey;

/// How long a publication waits for the rest of an edit, so that one edit appears in one frame.
const WHOLE_EDIT: Duration = Duration::from_millis(100);

/// Changes are numbered from 1.
#[derive(Default)]
pub(super) struct Changes {
    /// Tiles that are to be made anew.
    stale: BTreeMap<TileKey, Stale>,
    /// The last change that was observed.
    last: u64,
    /// Until when publications wait for chunks that are to be made anew, and the last change whose chunks they wait for.
    held: Option<(Instant, u64)>,
}

/// A tile that is not what its source says it is.
#[derive(Clone, Copy)]
pub(super) struct Stale {
    /// The first change that is not in it.
    since: u64,
    /// It is on its way to a worker, or with one.
    asked: bool,
    /// The first change since then: what the worker makes may be without it, and is made once more.
    again: Option<u64>,
}

impl Stale {
    fn new(since: u64) -> Self {
        Self { since, asked: false, again: None }
    }
}

impl Changes {
    /// Observes the number of the last change. The caller calls [`Self::note`] for every tile that changed.
    pub(super) fn observe(&mut self, last: u64) {
        self.last = last;
    }

    /// A tile is without a change.
    pub(super) fn note(&mut self, key: TileKey, number: u64) {
        let stale = self.stale.entry(key).or_insert_with(|| Stale::new(number));
        if stale.asked {
            stale.again.get_or_insert(number);
        }
    }

    /// Whether a tile is to be made anew.
    pub(super) fn concern(&self, key: &TileKey) -> bool {
        self.stale.contains_key(key)
    }

    /// Whether none is.
    pub(super) fn are_made(&self) -> bool {
        self.stale.is_empty()
    }

    /// Tiles that are to be made anew, chunks first.
    pub(super) fn tiles(&self) -> impl Iterator<Item = TileKey> {
        self.stale.keys().copied()
    }

    /// Workers are asked for a tile: whoever makes it from now on has all that has changed.
    pub(super) fn asked(&mut self, key: TileKey) {
        if let Some(stale) = self.stale.get_mut(&key) {
            (stale.asked, stale.again) = (true, None);
        }
    }

    /// A tile came from a worker, or is given up; what was known of it.
    pub(super) fn forget(&mut self, key: TileKey) -> Option<Stale> {
        self.stale.remove(&key)
    }

    /// It was not made after all.
    pub(super) fn unmade(&mut self, key: TileKey, known: Stale) {
        self.stale.insert(key, Stale::new(known.since));
    }

    /// It was made: gives whether it has to be made once more.
    pub(super) fn made(&mut self, key: TileKey, known: Option<Stale>) -> bool {
        let again = known.and_then(|stale| stale.again);
        if let Some(number) = again {
            self.stale.insert(key, Stale::new(number));
        }
        again.is_some()
    }

    /// The last change that is whole in what was made. Coarse tiles do not count: what is seen of them is far away.
    pub(super) fn whole(&self) -> u64 {
        let chunks = self.stale.iter().take_while(|(key, _)| key.level == 0);
        chunks.map(|(_, stale)| stale.since - 1).min().unwrap_or(self.last)
    }

    /// Publications wait for the rest of all changes up to now, if there is any and they do not wait already.
    pub(super) fn hold(&mut self) {
        if !self.are_held() {
            self.hold_anew();
        }
    }

    /// A publication is made: what came meanwhile is waited for in turn; an edit that takes too long is shown in parts.
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
