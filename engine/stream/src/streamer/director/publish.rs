//! Makes publications, and counts the wanted tiles that they do not have.

use std::sync::{Arc, PoisonError};

use raxel_layouts::Tree64Header;
use raxel_layouts::lights::HEADER_WORDS;
use raxel_world::ChunkPos;

use super::{Director, StreamError};
use crate::cube::Cube;
use crate::publication::{Missing, MissingTiles, Publication};
use crate::reach::TileKey;
use crate::tile_directory::{Placed, Written};

impl Director {
    /// Whether the director may publish now. `pending` is the last publication if no frame has taken it: a new one replaces it only to show an
    /// edit that it does not show.
    pub(super) fn may_follow(&self, pending: Option<&Publication>) -> bool {
        !self.changes.are_held() && pending.is_none_or(|pending| pending.changes < self.changes.whole())
    }

    /// Counts the tiles that are wanted now and missing from the newest publication.
    pub(super) fn count_unseen(&mut self) {
        let tiles = self.missing.iter().chain(&self.unpublished).copied().collect();
        let missing_tiles = MissingTiles { cell: self.view.cell, shown: self.shown.clone(), tiles };
        let Missing { tiles, holes } = missing_tiles.in_view(&self.view).unwrap_or_default();
        (self.stats.missing_in_view, self.stats.holes_in_view) = (tiles, holes);
        let shown = |key: &&TileKey| key.level == 0 && self.shown.wants(self.view.cell, **key, 0);
        self.stats.missing_chunks = self.missing.iter().filter(shown).count();
        *self.missing_tiles.lock().unwrap_or_else(PoisonError::into_inner) = Some(missing_tiles);
    }

    /// Makes a publication if one is due, and reports the figures.
    pub(super) fn publish(&mut self) {
        let listed = !self.complete || self.lamps.is_whole();
        let settled = self.missing.is_empty() && self.changes.are_made() && self.lamps.again().is_empty() && listed;
        let (may_follow, view_is_known) = {
            let state = self.shared.state();
            (self.may_follow(state.pending.as_deref()), state.view_serial == self.view_serial)
        };
        let due = self.changed && if self.complete { settled } else { may_follow };
        if due {
            self.changes.show();
            self.make_publication();
        }
        // The table of lamps may have found no room just now.
        let settled = settled && !(self.complete && self.lamps.lacks_table());
        self.stats.wanted = self.wanted;
        self.stats.missing = self.missing.len();
        self.stats.near = self.reach.near();
        self.stats.unavailable = self.backoff.len();
        self.stats.unlisted = self.lamps.left_out();
        let mut state = self.shared.state();
        state.stats = self.stats;
        state.looked = self.view_serial;
        state.unavailable = self.backoff.reason().cloned();
        // Callers that wake up here find the figures of this turn.
        if settled && !self.changed && view_is_known && state.view_serial == self.view_serial {
            state.settled = self.view_serial;
            self.shared.settled.notify_all();
        }
    }

    /// Whether a tile is shown. The world ends where its file ends it, also where tiles beyond are loaded.
    fn is_shown(&self, key: TileKey) -> bool {
        key.level == 0 || key.level < self.whole.top() || self.shown.wants(self.view.cell, key, 0)
    }

    /// Updates a tile in the directory.
    pub(super) fn place(&mut self, key: TileKey) {
        let tile = self.tiles.get(&key).filter(|_| self.is_shown(key));
        self.directory.set(key, tile.map(|tile| &tile.live));
    }

    /// Makes a publication, if the pool has room for its directory.
    pub(super) fn make_publication(&mut self) {
        // Which of the coarsest tiles are shown follows from the camera.
        let coarsest = TileKey { level: self.whole.top().max(1), pos: ChunkPos::new(i32::MIN, i32::MIN, i32::MIN) };
        for (key, tile) in self.tiles.range(coarsest..) {
            let shown = self.shown.wants(self.view.cell, *key, 0);
            self.directory.set(*key, shown.then_some(&tile.live));
        }
        let placed = self.directory.write(&self.shared.pool, self.version + 1);
        for Written { block, version } in self.directory.given_up() {
            // It was written for a publication that failed, so that no frame reaches it.
            if version > self.version {
                self.shared.pool.free(block);
            } else {
                self.retire(Some(block));
            }
        }
        let Some(Placed { root, nodes, bounds, live, words }) = placed else {
            self.room.refuse_directory();
            return;
        };
        self.room.place_directory();
        self.shared.state().budget.spend(4 * words);
        let lights = self.publish_lamps();
        self.shared.pool.flush();
        self.version += 1;
        self.changed = false;
        self.unpublished.clear();
        self.missing_tiles = Arc::default();
        self.count_unseen();
        self.stats.publications += 1;
        self.stats.written += 4 * words;
        self.stats.live = live;
        let Cube { origin, log2_size } = *self.directory.cube();
        let header = Tree64Header {
            origin,
            log2_size,
            bounds_min: bounds[0],
            material_count: self.shared.source.materials().len() as u32,
            bounds_last: bounds[1],
            materials_at: 0,
            root,
            node_count: nodes as u32,
            leaf_count: 0,
            unused: 0,
        };
        self.shown_changes = self.shown_changes.max(self.changes.whole());
        let publication = Publication {
            version: self.version,
            header,
            lights,
            changes: self.shown_changes,
            stats: self.stats,
            missing_tiles: self.missing_tiles.clone(),
        };
        self.shared.state().pending = Some(Arc::new(publication));
        self.shared.published.notify_all();
    }

    /// Writes the table of the lamps that are shown. Returns the header of the list.
    fn publish_lamps(&mut self) -> Option<[u32; HEADER_WORDS]> {
        let pool = &self.shared.lamps.as_ref()?.pool;
        let bytes = 4 * self.lamps.publish(pool, self.directory.lights(), self.version + 1);
        pool.flush();
        self.shared.state().budget.spend(bytes);
        self.stats.written += bytes;
        let header = self.lamps.header();
        self.stats.lights = u64::from(header[0]);
        Some(header)
    }

    /// Some lamps found no room. A window goes on without them; a caller that waits for a complete world gets an error.
    pub(super) fn refuse_lamps(&mut self) {
        let shared = self.shared.clone();
        if let Some(lamps) = shared.lamps.as_ref().filter(|_| self.complete) {
            // The lamps that were given up become free once a frame takes a publication without them.
            if self.changed && self.lamps.waits_for_more_than(self.version) {
                self.make_publication();
            }
            let error = StreamError::TooManyLamps { bytes: lamps.pool.capacity() };
            shared.state().error = Some((self.view_serial, error));
            shared.settled.notify_all();
        }
    }

    /// Tries again to list lamps that found no room. Their tiles are made again, after the missing tiles.
    pub(super) fn list_again(&mut self) {
        let Some(lamps) = &self.shared.lamps else { return };
        // For a complete world the director tries all of them, and reports an error if they still do not fit. A window tries those that fit.
        let room = if self.complete { u64::MAX } else { lamps.pool.spare_words() };
        self.ask_again |= self.lamps.list_again(room);
        self.changed |= self.lamps.try_table_again();
    }
}
