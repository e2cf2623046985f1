//! Loads and unloads tiles: one thread decides, workers make.
//!
//! Only the director knows the tiles. Through [`SharedState`] it gives the workers a queue of the missing tiles, and gets the tiles that they
//! have made. Frames lock only the shared state, and only to read or write a few words.

mod changes;
mod director;
mod listed;
mod neighbor_faces;
mod retry_backoff;
mod threads;
mod worker;

use std::collections::{BTreeMap, HashSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use raxel_world::layout::TileBlock;
use raxel_world::lights::LightPowers;
use raxel_world::{ChunkPos, ChunkSource, Content, Unavailable};

use crate::pool::{Pool, PoolMemory};
use crate::publication::{Publication, Stats};
use crate::reach::{Reach, TileKey};
use crate::upload_budget::UploadBudget;
use crate::view::View;
use director::Director;
use neighbor_faces::NeighborFaceCache;
use threads::Spawn;
use worker::Made;

/// How a streamer works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamOptions {
    /// Threads that make tiles, at least 1.
    pub workers: usize,
    /// What is there follows from the camera alone: publications are made when everything that is wanted is there, and nothing else is
    /// kept. For pictures that must not depend on the time.
    pub complete: bool,
    /// Bytes that a frame brings to the pool, about, unless the world is complete. Edits do not wait for the next frame, but count.
    pub upload: Option<u64>,
    /// Freed blocks are overwritten with nonsense.
    pub poison: bool,
}

/// Why a streamer cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamError {
    /// What is wanted does not fit the pool.
    #[error("the world around the camera takes more than the {bytes} bytes of the pool")]
    NoRoom {
        /// Bytes of the pool.
        bytes: u64,
    },
    /// The lamps of what is wanted do not fit the list.
    #[error("the lamps around the camera take more than the {bytes} bytes of their list")]
    TooManyLamps {
        /// Bytes of the list.
        bytes: u64,
    },
    /// It took too long until everything that is wanted was there.
    #[error("after {seconds} s, {missing} chunks are still missing")]
    TimedOut {
        /// Tiles that are missing.
        missing: usize,
        /// Seconds waited.
        seconds: u64,
    },
    /// The source does not have a tile, however often it is asked.
    #[error("{} missing: {reason}", if *.missing == 1 { "a chunk is".to_owned() } else { format!("{missing} chunks are") })]
    Unavailable {
        /// Tiles that it did not have when it was asked; others may not have been asked for yet.
        missing: usize,
        /// What the source says.
        reason: Unavailable,
    },
    /// The system has no thread for it. Nothing is loaded.
    #[error("the thread `{thread}` cannot start: {reason}")]
    NotStarted {
        /// The thread.
        thread: String,
        /// What the system says.
        reason: String,
    },
    /// One of its threads is no more. Nothing is loaded from then on; what was published stays.
    #[error("the thread `{thread}` has ended: {reason}")]
    Ended {
        /// The thread.
        thread: String,
        /// The words of its panic.
        reason: String,
    },
}

/// Keeps the tiles around a camera in a pool.
pub struct Streamer {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared {
    source: Arc<dyn ChunkSource>,
    pool: Pool,
    /// Where the lamps of tiles go, if anything gives off light and somebody wants to know.
    lamps: Option<Lamps>,
    neighbor_faces: NeighborFaceCache,
    state: Mutex<SharedState>,
    /// There is work.
    work: Condvar,
    /// There is something for the director.
    news: Condvar,
    /// A frame may bring more.
    allowed: Condvar,
    /// There is a publication to take.
    published: Condvar,
    /// Everything that is wanted is there, or cannot be.
    settled: Condvar,
    /// The threads are to return.
    stop: AtomicBool,
    /// Why there are no threads any more. Set once; whoever waits for a thread looks here first.
    ended: OnceLock<StreamError>,
}

/// The pool of lamps, and which materials are some.
struct Lamps {
    pool: Pool,
    powers: LightPowers,
}

/// What the director, the workers and the frames exchange.
struct SharedState {
    view: View,
    /// The view when `view_serial` was last counted up.
    considered: View,
    /// How often something has changed so that the director should look.
    view_serial: u64,
    /// How often that was not a change of chunks alone: other tiles may be wanted.
    moves: u64,
    /// The view whose missing tiles are known.
    looked: u64,
    /// Chunks that the source answers anew, with the number of the first change since the director looked.
    changed: BTreeMap<ChunkPos, u64>,
    /// How often somebody has said so.
    changes: u64,
    /// What is missing, the most urgent last.
    jobs: Vec<Job>,
    in_work: HashSet<TileKey>,
    made: Vec<Made>,
    budget: UploadBudget,
    /// For a frame to take.
    pending: Option<Arc<Publication>>,
    /// Versions below this one are reached by no frame that has not finished.
    released: u64,
    /// The view whose tiles are all there and published.
    settled: u64,
    /// How the last attempt for a view ended.
    error: Option<(u64, StreamError)>,
    /// What the source says of a tile that it does not have.
    unavailable: Option<Unavailable>,
    stats: Stats,
}

/// A tile to be made.
#[derive(Clone, Copy)]
struct Job {
    key: TileKey,
    /// It is in the pool as it was before an edit.
    stale: bool,
}

impl Shared {
    /// Locks the shared state. A thread that panics while it holds the lock ends the streamer, so that no thread goes on with half-changed
    /// state. Frames then still read what is complete by itself: a publication and the figures.
    fn state(&self) -> MutexGuard<'_, SharedState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stops every thread, and wakes whoever waits for one. The first reason stays.
    fn end(&self, reason: StreamError) {
        let _ = self.ended.set(reason);
        self.stop();
    }

    fn stop(&self) {
        self.stop.store(true, Ordering::Release);
        // While this thread holds the lock, no other thread is between its check of `stop` and its wait.
        drop(self.state());
        for sleepers in [&self.work, &self.news, &self.allowed, &self.published, &self.settled] {
            sleepers.notify_all();
        }
    }
}

impl Streamer {
    /// Starts to load what a view wants into a buffer of so many words. The buffer shows an empty world until the header of the first
    /// publication is written to it.
    pub fn new(
        source: Arc<dyn ChunkSource>,
        memory: Arc<dyn PoolMemory>,
        words: u32,
        reach: Reach,
        view: View,
        options: StreamOptions,
    ) -> Self {
        Self::with_lamps(source, (memory, words), None, reach, view, options)
    }

    /// The same with a buffer for the list of lamps, of so many words. It is left empty where no material gives off light.
    pub fn with_lamps(
        source: Arc<dyn ChunkSource>,
        (memory, words): (Arc<dyn PoolMemory>, u32),
        lamps: Option<(Arc<dyn PoolMemory>, u32)>,
        reach: Reach,
        view: View,
        options: StreamOptions,
    ) -> Self {
        Self::spawned_by(&threads::spawn, source, (memory, words), lamps, reach, view, options)
    }

    fn spawned_by(
        spawn: Spawn<'_>,
        source: Arc<dyn ChunkSource>,
        (memory, words): (Arc<dyn PoolMemory>, u32),
        lamps: Option<(Arc<dyn PoolMemory>, u32)>,
        reach: Reach,
        view: View,
        options: StreamOptions,
    ) -> Self {
        let pool = Pool::new(memory, words, source.materials(), options.poison);
        let lamps = lamps.and_then(|(memory, words)| {
            let pool = Pool::of_lamps(memory, words, options.poison);
            Some(Lamps { pool, powers: LightPowers::of(source.materials())? })
        });
        let state = SharedState {
            view,
            considered: view,
            view_serial: 1,
            moves: 1,
            looked: 0,
            changed: BTreeMap::new(),
            changes: 0,
            jobs: Vec::new(),
            in_work: HashSet::new(),
            made: Vec::new(),
            budget: UploadBudget::new(options.upload.filter(|_| !options.complete), Instant::now()),
            pending: None,
            released: 0,
            settled: 0,
            error: None,
            unavailable: None,
            stats: Stats::default(),
        };
        let shared = Arc::new(Shared {
            source,
            pool,
            lamps,
            neighbor_faces: NeighborFaceCache::default(),
            state: Mutex::new(state),
            work: Condvar::new(),
            news: Condvar::new(),
            allowed: Condvar::new(),
            published: Condvar::new(),
            settled: Condvar::new(),
            stop: AtomicBool::new(false),
            ended: OnceLock::new(),
        });
        let director = Director::new(shared.clone(), reach, options.complete);
        let mut threads = vec![threads::start(&shared, "stream director".to_owned(), spawn, move |_| director.run())];
        for number in 1..=options.workers.max(1) {
            let name = format!("stream worker {number}");
            threads.push(threads::start(&shared, name, spawn, |shared| worker::run(shared)));
        }
        Self { shared, threads: threads.into_iter().flatten().collect() }
    }

    /// Why no thread of it runs any more: nothing new is loaded or published from then on. It does not begin again.
    pub fn ended(&self) -> Option<&StreamError> {
        self.shared.ended.get()
    }

    /// Bytes that the pool takes for what a camera wants, about, and those that `packed` gives for the same tiles: a sample of the columns
    /// around it is made, as far as the source has it.
    pub fn estimate(
        source: &dyn ChunkSource,
        reach: &Reach,
        camera: glam::IVec3,
        packed: &dyn Fn(&Content) -> u64,
    ) -> [u64; 2] {
        /// Columns of each level that are looked at.
        const COLUMNS: u64 = 12;
        let mut random = raxel_world::random::SplitMix64::new(0x5eed);
        let mut columns = std::collections::BTreeMap::<(u32, i32, i32), Vec<TileKey>>::new();
        for tile in reach.tiles(camera) {
            columns.entry((tile.level, tile.pos.x, tile.pos.z)).or_default().push(tile);
        }
        let mut bytes = [0.0; 2];
        let ask = |tile: &TileKey| threads::caught(|| source.try_chunk(tile.level, tile.pos)).ok()?.ok();
        'levels: for level in 0..=reach.top() {
            let of_level: Vec<&Vec<TileKey>> =
                columns.range((level, i32::MIN, i32::MIN)..=(level, i32::MAX, i32::MAX)).map(|(_, c)| c).collect();
            let looked_at = COLUMNS.min(of_level.len() as u64);
            let mut found = [0u64; 2];
            for _ in 0..looked_at {
                for tile in of_level[random.below(of_level.len() as u64) as usize] {
                    let Some(content) = ask(tile) else { break 'levels };
                    let words = TileBlock::of(&content, tile.level).map_or(0, |block| u64::from(block.words()));
                    // Its node, in two directories at a time.
                    found[0] += 4 * (words + 8);
                    found[1] += packed(&content);
                }
            }
            if looked_at > 0 {
                let share = of_level.len() as f64 / looked_at as f64;
                (0..2).for_each(|kind| bytes[kind] += found[kind] as f64 * share);
            }
        }
        [Pool::bytes_for(bytes[0] as u64, source.materials().len()), bytes[1] as u64]
    }

    /// Tells where the camera is at the start of a frame. Takes a microsecond; nothing waits.
    pub fn follow(&self, view: View) {
        let mut state = self.shared.state();
        state.view = view;
        state.budget.frame(Instant::now());
        self.shared.allowed.notify_all();
        if !state.considered.is_near(&view) {
            state.considered = view;
            state.view_serial += 1;
            state.moves += 1;
            self.shared.news.notify_one();
        }
    }

    /// Tells that the source now answers otherwise for these chunks, and for the coarser tiles around them. Their tiles are made anew, and
    /// shown when they are; no other one is touched. Gives a number that [`Publication::changes`] reaches when all of it is shown. Changes are
    /// shown in order, several of them at once where they come faster than they can be made.
    pub fn changed(&self, chunks: &[ChunkPos]) -> u64 {
        self.shared.neighbor_faces.changed(chunks);
        let mut state = self.shared.state();
        state.changes += 1;
        let number = state.changes;
        for pos in chunks {
            state.changed.entry(*pos).or_insert(number);
        }
        state.view_serial += 1;
        self.shared.news.notify_one();
        state.changes
    }

    /// The newest publication that was not taken yet. Whoever takes it writes its header to the start of the buffer before the next frame,
    /// and says by [`Streamer::released`] when the frames before have finished.
    pub fn take(&self) -> Option<Arc<Publication>> {
        let taken = self.shared.state().pending.take();
        if taken.is_some() {
            self.shared.news.notify_one();
        }
        taken
    }

    /// The same, after a wait for one that shows the change of a number, which [`Streamer::changed`] has given. It gives what there is when
    /// that takes longer than `patience`, or [`Streamer::ended`].
    pub fn take_with(&self, number: u64, patience: Duration) -> Option<Arc<Publication>> {
        let until = Instant::now() + patience;
        let mut state = self.shared.state();
        while state.pending.as_ref().is_none_or(|publication| publication.changes < number) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || self.ended().is_some() {
                break;
            }
            state = self.shared.published.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        drop(state);
        self.take()
    }

    /// Whether [`Streamer::take`] has something to give.
    pub fn has_pending(&self) -> bool {
        self.shared.state().pending.is_some()
    }

    /// Every frame that could reach publications below this version has finished: what only they reach is free.
    pub fn released(&self, version: u64) {
        let mut state = self.shared.state();
        if state.released < version {
            state.released = version;
            self.shared.news.notify_one();
        }
    }

    /// Waits until all that is wanted is there and published; for whoever makes pictures that must be complete.
    pub fn wait(&self, timeout: Duration) -> Result<(), StreamError> {
        let until = Instant::now() + timeout;
        let mut state = self.shared.state();
        loop {
            if let Some(ended) = self.ended() {
                return Err(ended.clone());
            }
            let serial = state.view_serial;
            if state.settled == serial {
                return Ok(());
            }
            if let Some((of, error)) = &state.error
                && *of == serial
            {
                return Err(error.clone());
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(StreamError::TimedOut { missing: state.stats.missing, seconds: timeout.as_secs() });
            }
            state = self.shared.settled.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Tries again after [`StreamError::NoRoom`], when a publication was taken and released meanwhile.
    pub fn retry(&self) {
        let mut state = self.shared.state();
        state.view_serial += 1;
        state.moves += 1;
        self.shared.news.notify_one();
    }

    /// Whether all that is wanted is there and published.
    pub fn is_settled(&self) -> bool {
        let state = self.shared.state();
        state.settled == state.view_serial
    }

    /// Whether what [`Streamer::stats`] says is missing is what the newest view misses.
    pub fn has_looked(&self) -> bool {
        let state = self.shared.state();
        state.looked == state.view_serial
    }

    /// What the source says, when there are tiles that it does not have; they are asked for again after a while.
    pub fn unavailable(&self) -> Option<Unavailable> {
        self.shared.state().unavailable.clone()
    }

    /// How it is doing.
    pub fn stats(&self) -> Stats {
        let (used, peak, failed) = self.shared.pool.usage();
        let (stats, most_written) = {
            let state = self.shared.state();
            (state.stats, state.budget.most())
        };
        Stats { most_written, pool: [used, peak, self.shared.pool.capacity()], failed, ..stats }
    }

    /// What it asks for tiles.
    pub fn source(&self) -> &Arc<dyn ChunkSource> {
        &self.shared.source
    }
}

impl Drop for Streamer {
    fn drop(&mut self) {
        self.shared.stop();
        for thread in self.threads.drain(..) {
            // Its panics are caught: what it had to say stands in `ended`.
            let _ = thread.join();
        }
    }
}
