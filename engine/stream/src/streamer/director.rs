//! Decides which tiles to load and which to give up.

mod publish;
mod room;

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use raxel_world::{Cause, ChunkPos, Unavailable};

use super::changes::Changes;
use super::light_table::LightTable;
use super::retry_backoff::RetryBackoff;
use super::threads::planted;
use super::worker::{Made, MadeLamps, Unmade};
use super::{Job, Shared, StreamError};
use crate::cube::Cube;
use crate::pool::{PoolBlock, PoolStats};
use crate::publication::{MissingTiles, Stats};
use crate::reach::{StreamingRange, TileKey};
use crate::tile_directory::{LiveTile, TileDirectory};
use crate::view::View;
use room::{Reaction, Room};

/// How many tiles beyond the wanted range stay loaded, so that a camera that crosses a border to and fro loads nothing twice.
const SLACK: i32 = 2;
/// The shortest range of level 0, in tiles, however little memory there is.
const LEAST_NEAR: i32 = 1;
/// Above this use of the pool, in percent, the range of level 0 shrinks.
const FULL: u64 = 85;
/// Below this use of the pool, in percent, the range of level 0 may grow again.
const ROOMY: u64 = 65;
/// The longest time between two turns of the director.
const TURN: Duration = Duration::from_millis(32);

pub(super) struct Director {
    shared: Arc<Shared>,
    complete: bool,
    /// The range that the world file wants to be shown.
    shown: StreamingRange,
    /// The same range, with the tiles around it that may be shown soon.
    whole: StreamingRange,
    /// The part of `whole` that the pool has room for.
    reach: StreamingRange,
    view: View,
    view_serial: u64,
    moves: u64,
    /// The coarsest tile that the camera is in: it decides where the world ends.
    horizon: TileKey,
    tiles: BTreeMap<TileKey, Tile>,
    /// The number of wanted tiles.
    wanted: usize,
    /// The wanted tiles that are not there.
    missing: HashSet<TileKey>,
    /// Tiles that are there, but in no publication yet.
    unpublished: HashSet<TileKey>,
    /// The wanted tiles that the newest publication does not have.
    missing_tiles: Arc<Mutex<Option<MissingTiles>>>,
    changes: Changes,
    /// Publications show every change up to this one.
    shown_changes: u64,
    /// Tiles that the source did not have, and when to ask for them again.
    backoff: RetryBackoff,
    /// Blocks of tiles and directories, each with the first version that no longer reaches it.
    retired: VecDeque<(u64, PoolBlock)>,
    version: u64,
    directory: TileDirectory,
    lamps: LightTable,
    room: Room,
    /// The reachable tiles have changed since the last publication.
    changed: bool,
    /// The jobs of the workers no longer match the missing tiles.
    ask_again: bool,
    stats: Stats,
}

/// The events since the last turn of the director.
struct News {
    made: Vec<Made>,
    changed: BTreeMap<ChunkPos, u64>,
    released: u64,
    moved: bool,
}

struct Tile {
    live: Arc<LiveTile>,
    block: Option<PoolBlock>,
    lamps: MadeLamps,
}

impl Director {
    pub(super) fn new(shared: Arc<Shared>, reach: StreamingRange, complete: bool) -> Self {
        let view = shared.state().view;
        let whole = reach.loaded(complete);
        let cube = Cube::around(view.cell, &whole);
        Self {
            shared,
            complete,
            shown: reach,
            reach: whole.clone(),
            whole,
            view,
            view_serial: 0,
            moves: 0,
            horizon: TileKey::of_cell(0, view.cell),
            tiles: BTreeMap::new(),
            wanted: 0,
            missing: HashSet::new(),
            unpublished: HashSet::new(),
            missing_tiles: Arc::default(),
            changes: Changes::default(),
            shown_changes: 0,
            backoff: RetryBackoff::default(),
            retired: VecDeque::new(),
            version: 0,
            directory: TileDirectory::new(cube),
            lamps: LightTable::default(),
            room: Room::default(),
            changed: true,
            ask_again: false,
            stats: Stats::default(),
        }
    }

    pub(super) fn run(mut self) {
        loop {
            let Some(News { made, changed, released, moved }) = self.wait() else { return };
            assert!(!planted("director"), "a planted fault");
            self.free(released);
            made.into_iter().for_each(|made| self.take(made));
            let higher = self.note_changes(&changed);
            if !changed.is_empty() {
                self.changes.hold();
            }
            if moved || higher {
                self.update_wanted();
            }
            match self.room.react() {
                Some(Reaction::AskAgain) => self.ask_again = true,
                Some(Reaction::MakeRoom) => self.on_pool_full(),
                None => {}
            }
            if self.lamps.take_refused() {
                self.refuse_lamps();
            }
            if std::mem::take(&mut self.ask_again) || moved || !changed.is_empty() {
                self.ask();
            }
            self.publish();
        }
    }

    /// Sleeps until there is something to do. Returns `None` when the streamer stops.
    fn wait(&mut self) -> Option<News> {
        let shared = self.shared.clone();
        let mut state = shared.state();
        loop {
            if shared.stop.load(Ordering::Acquire) {
                return None;
            }
            let looks = state.view_serial != self.view_serial;
            let can_publish = self.changed
                && self.may_follow(state.pending.as_deref())
                && !self.complete
                && !self.room.is_unanswered();
            let is_free = self.retired.front().is_some_and(|(version, _)| *version <= state.released);
            let can_free = is_free || self.lamps.can_free(state.released);
            let due = self.backoff.is_due(Instant::now());
            let anew = std::mem::take(&mut state.ask_anew);
            if anew {
                self.backoff.start_over();
            }
            self.ask_again |= due || anew;
            if looks || !state.made.is_empty() || can_publish || can_free || due || anew {
                self.view = state.view;
                self.view_serial = state.view_serial;
                let moved = std::mem::replace(&mut self.moves, state.moves) != state.moves;
                self.changes.observe(state.changes);
                return Some(News {
                    made: std::mem::take(&mut state.made),
                    changed: std::mem::take(&mut state.changed),
                    released: state.released,
                    moved,
                });
            }
            state = shared.news.wait_timeout(state, TURN).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn free(&mut self, released: u64) {
        while self.retired.front().is_some_and(|(version, _)| *version <= released) {
            if let Some((_, block)) = self.retired.pop_front() {
                self.shared.pool.free(block);
            }
            self.ask_again |= self.room.block_freed();
        }
        if self.lamps.can_free(released)
            && let Some(lamps) = &self.shared.lamps
        {
            self.lamps.free(&lamps.pool, released);
            self.list_again();
        }
    }

    /// Gives up a block that publications up to the last one may reach. It is freed once no frame uses them.
    fn retire(&mut self, block: Option<PoolBlock>) {
        if let Some(block) = block {
            self.retired.push_back((self.version + 1, block));
        }
    }

    /// Gives up a tile that publications may reach.
    fn retire_tile(&mut self, key: TileKey, tile: Option<Tile>) {
        self.lamps.forget(key);
        if let Some(tile) = tile {
            self.retire(tile.block);
            self.lamps.retire(self.version + 1, tile.lamps.block);
        }
    }

    fn slack(&self) -> i32 {
        if self.complete { 0 } else { SLACK }
    }

    fn take(&mut self, made: Made) {
        let Made { key, tile, lamps, bytes, outdated } = made;
        self.stats.written += bytes;
        let known = self.changes.forget(key);
        let (live, block) = match tile {
            Ok(made) => made,
            Err(why) => {
                match why {
                    Unmade::NoRoom => {
                        self.room.refuse_tile();
                        self.ask_again = true;
                    }
                    Unmade::Unavailable(reason) => self.back_off(key, reason),
                }
                if let Some(known) = known
                    && self.tiles.contains_key(&key)
                {
                    self.changes.note(key, known);
                }
                self.lamps.unmade(key);
                return;
            }
        };
        self.backoff.remove(key);
        self.stats.made += 1;
        if !self.reach.wants(self.view.cell, key, self.slack()) {
            // No publication has ever reached the tile, so that its blocks are free at once.
            if let Some(block) = block {
                self.shared.pool.free(block);
            }
            if let (Some(block), Some(lamps)) = (lamps.block, &self.shared.lamps) {
                lamps.pool.free(block);
            }
            return;
        }
        // The new tile replaces the old one even if it is stale again already: where edits never stop, each result is still shown.
        if let Some(number) = outdated {
            self.changes.note(key, number);
            self.ask_again = true;
        }
        if self.missing.remove(&key) {
            self.unpublished.insert(key);
        }
        let left_out = lamps.left_out;
        let before = self.tiles.insert(key, Tile { live: Arc::new(live), block, lamps });
        self.place(key);
        self.retire_tile(key, before);
        if left_out > 0 {
            self.lamps.leave_out(key, left_out);
        }
        self.changed = true;
    }

    /// Delays the next request for a tile that the source does not have. A caller that waits for a complete world gets an error when the tile
    /// was missing often, and at once when the source panicked: it would panic again.
    fn back_off(&mut self, key: TileKey, reason: Unavailable) {
        let often = self.backoff.add(key, reason.clone(), Instant::now());
        if self.complete && (often || reason.cause == Cause::Panicked) {
            let error = StreamError::Unavailable { missing: self.backoff.len(), reason };
            self.shared.state().error = Some((self.view_serial, error));
            self.shared.settled.notify_all();
        }
    }

    /// Marks the tiles of changed chunks as stale, with the coarser tiles around them. Returns whether a chunk lies so high or so deep that more
    /// tiles are wanted now.
    fn note_changes(&mut self, chunks: &BTreeMap<ChunkPos, u64>) -> bool {
        let wanted = self.whole.clone();
        // The lamps of a chunk depend on the voxels beyond its faces, too. A worker that makes the chunk now notices by itself if it has
        // missed it.
        let follows =
            |key: &TileKey, face: u32| self.tiles.get(key).is_some_and(|tile| tile.lamps.sides >> (face ^ 1) & 1 == 1);
        let beside = chunks
            .iter()
            .flat_map(|(pos, number)| (0..6).map(|face| (TileKey { level: 0, pos: pos.beside(face) }, face, *number)));
        let lamps: Vec<(TileKey, u64)> =
            beside.filter(|(key, face, _)| follows(key, *face)).map(|(key, _, number)| (key, number)).collect();
        lamps.into_iter().for_each(|(key, number)| self.changes.note(key, number));
        for (pos, number) in chunks {
            let mut key = TileKey { level: 0, pos: *pos };
            let low = key.origin()[1];
            for reach in [&mut self.shown, &mut self.whole, &mut self.reach] {
                reach.include([low, low + TileKey::edge(0)]);
            }
            loop {
                let known = self.tiles.contains_key(&key) || self.missing.contains(&key);
                if known {
                    self.changes.note(key, *number);
                }
                if key.level == self.reach.top() {
                    break;
                }
                key = key.parent();
            }
        }
        self.whole != wanted
    }

    /// Finds the tiles that are wanted from where the camera is now, and gives up those that no longer are.
    fn update_wanted(&mut self) {
        if !self.directory.cube().suits(self.view.cell, &self.whole) {
            self.directory.clear(Cube::around(self.view.cell, &self.whole));
            self.tiles.keys().copied().collect::<Vec<_>>().into_iter().for_each(|key| self.place(key));
            self.changed = true;
        }
        let horizon = TileKey::of_cell(self.whole.top(), self.view.cell);
        let passed = std::mem::replace(&mut self.horizon, horizon) != horizon;
        self.changed |= passed && !self.complete && self.whole.top() > 0;
        let PoolStats { used, capacity, .. } = self.shared.pool.stats();
        if !self.complete && self.reach.near() < self.whole.near() && used * 100 < capacity * ROOMY {
            self.reach = self.whole.with_near(self.reach.near() + 1);
        }
        self.drop_unwanted(self.slack());
        self.list_again();
        let tiles = self.reach.tiles(self.view.cell);
        self.wanted = tiles.len();
        self.missing = tiles.into_iter().filter(|tile| !self.tiles.contains_key(tile)).collect();
        self.backoff.retain(|key| self.missing.contains(key) || self.changes.concern(key));
        self.count_unseen();
    }

    fn drop_unwanted(&mut self, slack: i32) {
        let (reach, cell) = (&self.reach, self.view.cell);
        let gone: Vec<TileKey> = self.tiles.keys().copied().filter(|key| !reach.wants(cell, *key, slack)).collect();
        for key in gone {
            let tile = self.tiles.remove(&key);
            self.place(key);
            self.unpublished.remove(&key);
            self.changes.forget(key);
            self.shared.source.on_evicted(key.level, key.pos);
            self.retire_tile(key, tile);
            self.stats.dropped += 1;
            self.changed = true;
        }
    }

    /// The pool is full: the workers get no more jobs until a block is freed, and the director evicts dispensable tiles.
    fn on_pool_full(&mut self) {
        self.ask_again = false;
        self.shared.state().jobs.clear();
        if self.complete || self.reach.near() <= LEAST_NEAR {
            if !self.complete {
                // Tiles beyond the wanted range go first.
                self.drop_unwanted(0);
            }
            // Blocks that were given up become free once a frame takes a publication without them.
            if self.changed && self.retired.iter().any(|(version, _)| *version > self.version) {
                self.make_publication();
            }
            let error = StreamError::NoRoom { bytes: self.shared.pool.capacity() };
            self.shared.state().error = Some((self.view_serial, error));
            self.shared.settled.notify_all();
        } else if self.retired.is_empty() || self.room.lacks_directory() {
            self.shrink();
        }
    }

    /// Shortens the range of level 0 by a tile, and gives up every tile beyond it at once, to make room.
    fn shrink(&mut self) {
        self.reach = self.whole.with_near(self.reach.near() - 1);
        self.drop_unwanted(0);
        let (reach, cell) = (&self.reach, self.view.cell);
        self.missing.retain(|key| reach.wants(cell, *key, 0));
        self.wanted = self.reach.tiles(self.view.cell).len();
        if self.retired.is_empty() {
            self.room.want_less();
            self.ask_again = true;
        }
    }

    /// Gives the workers a new queue of jobs, the most urgent last.
    fn ask(&mut self) {
        let PoolStats { used, capacity, .. } = self.shared.pool.stats();
        let roomy = used * 100 <= capacity * FULL;
        if !self.complete && !roomy && self.reach.near() > LEAST_NEAR && self.retired.is_empty() {
            self.shrink();
        }
        self.room.asked();
        let waiting = self.backoff.at(Instant::now());
        let mut state = self.shared.state();
        let idle = |key: &TileKey| {
            !waiting.contains(key)
                && !state.in_work.contains_key(key)
                && !state.made.iter().any(|made| made.key == *key)
        };
        // A user sees that an edited tile is stale, so that it comes first: chunks before the coarser tiles around them.
        let stale: Vec<TileKey> = self.changes.tiles().filter(idle).collect();
        let top = self.whole.top();
        let mut jobs: Vec<((u8, f64), TileKey)> = self
            .missing
            .iter()
            .filter(|key| idle(key) && !self.changes.concern(key))
            .map(|key| (self.view.urgency(*key, top, self.shown.wants(self.view.cell, *key, 0)), *key))
            .collect();
        jobs.sort_unstable_by(|((a_turn, a), a_key), ((b_turn, b), b_key)| {
            b_turn.cmp(a_turn).then_with(|| b.total_cmp(a)).then_with(|| b_key.cmp(a_key))
        });
        let relisted = self.lamps.again().iter().copied().filter(|key| idle(key) && !self.changes.concern(key));
        let missing = relisted.chain(jobs.into_iter().map(|(_, key)| key)).map(|key| Job { key, stale: false });
        state.jobs = missing.chain(stale.iter().rev().map(|key| Job { key: *key, stale: true })).collect();
        let work = !state.jobs.is_empty();
        drop(state);
        if work {
            self.shared.work.notify_all();
        }
    }
}
