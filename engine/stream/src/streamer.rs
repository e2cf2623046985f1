//! Loads and unloads tiles: one thread, the director, decides which; worker threads make them.
//!
//! Only the director knows the tiles. Through [`SharedState`] it gives the workers a queue of the missing tiles, and gets the tiles that they
//! have made. Frames lock only the shared state, and only to read or write a few words.

mod changes;
mod director;
mod light_table;
mod neighbor_faces;
mod retry_backoff;
mod threads;
mod worker;

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use raxel_layouts::TileBlock;
use raxel_layouts::lights::LightPowers;
use raxel_world::{Cause, ChunkPos, ChunkProvider, Content, Unavailable};

use crate::pool::{Pool, PoolMemory};
use crate::publication::{Publication, Stats};
use crate::reach::{StreamingRange, TileKey};
use crate::upload_budget::UploadBudget;
use crate::view::View;
use director::Director;
use neighbor_faces::NeighborFaceCache;
use threads::Spawn;
use worker::Made;

/// Bytes that the tiles around a camera take, estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Estimate {
    /// In a pool on the device.
    pub pool: u64,
    /// In the cache of chunks in main memory.
    pub packed: u64,
}

/// How a streamer works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamOptions {
    /// Threads that make tiles, at least 1.
    pub workers: usize,
    /// The loaded tiles depend on the camera alone: the streamer publishes only when every wanted tile is there, and keeps no other tile. For
    /// pictures that must not depend on timing.
    pub complete: bool,
    /// Bytes that a frame may upload to the pool, about; no limit for a complete world. Edits do not wait for the next frame, but count.
    pub upload: Option<u64>,
    /// Overwrites freed blocks with a pattern, so that a read of one shows.
    pub poison: bool,
}

/// Why a streamer cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamError {
    /// The wanted tiles do not fit the pool.
    #[error("the world around the camera takes more than the {bytes} bytes of the pool")]
    NoRoom {
        /// Bytes of the pool.
        bytes: u64,
    },
    /// The lamps of the wanted tiles do not fit the list.
    #[error("the lamps around the camera take more than the {bytes} bytes of their list")]
    TooManyLamps {
        /// Bytes of the list.
        bytes: u64,
    },
    /// The wanted tiles did not arrive in time.
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
        /// The source's reason.
        reason: Unavailable,
    },
    /// The system has no thread for it. Nothing is loaded.
    #[error("the thread `{thread}` cannot start: {reason}")]
    NotStarted {
        /// The thread.
        thread: String,
        /// The system's reason.
        reason: String,
    },
    /// One of its threads has ended. Nothing is loaded from then on; the last publication stays.
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
    source: Arc<dyn ChunkProvider>,
    pool: Pool,
    /// The lamps of tiles; `None` if no material gives off light, or nothing reads the list.
    lamps: Option<Lamps>,
    neighbor_faces: NeighborFaceCache,
    state: Mutex<SharedState>,
    /// There is work.
    work: Condvar,
    /// The director has something to do.
    news: Condvar,
    /// A new frame has begun, so that workers may upload more.
    allowed: Condvar,
    /// A publication waits to be taken.
    published: Condvar,
    /// Every wanted tile is published, or the director has an error.
    settled: Condvar,
    /// Tells the threads to return.
    stop: AtomicBool,
    /// Why the threads have ended. Set once; a caller that waits for a thread checks this first.
    ended: OnceLock<StreamError>,
}

/// The pool of lamps, and the power of each material.
struct Lamps {
    pool: Pool,
    powers: LightPowers,
}

/// The state that the director, the workers and the frames share.
struct SharedState {
    view: View,
    /// The view for which the camera last woke the director.
    considered: View,
    /// Number of updates for the director: new views and changed chunks.
    view_serial: u64,
    /// Number of updates that changed more than chunks: other tiles may be wanted since.
    moves: u64,
    /// The `view_serial` whose missing tiles are counted in `stats`.
    looked: u64,
    /// Chunks that changed since the director last took them, with the number of the first change of each.
    changed: BTreeMap<ChunkPos, u64>,
    /// Number of the last change of chunks.
    changes: u64,
    /// Tiles that workers should make, the most urgent last.
    jobs: Vec<Job>,
    /// Tiles that workers are making, each with the first change since its worker began. The worker may have read the chunks before it.
    in_work: HashMap<TileKey, Option<u64>>,
    made: Vec<Made>,
    budget: UploadBudget,
    /// The newest publication, until a frame takes it.
    pending: Option<Arc<Publication>>,
    /// Every frame that could reach a version below this one has finished.
    released: u64,
    /// The last `view_serial` whose tiles are all published.
    settled: u64,
    /// The last error, and the `view_serial` that it is about.
    error: Option<(u64, StreamError)>,
    /// Why the source does not have a tile; `None` when none is missing for that reason.
    unavailable: Option<Unavailable>,
    /// A caller begins to wait: the director asks at once for tiles that the source did not have.
    ask_anew: bool,
    stats: Stats,
}

/// A tile to be made.
#[derive(Clone, Copy)]
struct Job {
    key: TileKey,
    /// The pool has the tile as it was before an edit.
    stale: bool,
}

impl Shared {
    /// Locks the shared state. A thread that panics while it holds the lock ends the streamer, so that no thread goes on with half-changed
    /// state. Frames then still read the parts that are complete by themselves: a publication and the figures.
    fn state(&self) -> MutexGuard<'_, SharedState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stops every thread and wakes all waiting threads. Only the first reason is kept.
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
    /// Starts to load the tiles that a view wants into a buffer of `words` words. The buffer shows an empty world until a frame writes the header
    /// of the first publication to it.
    pub fn new(
        source: Arc<dyn ChunkProvider>,
        memory: Arc<dyn PoolMemory>,
        words: u32,
        reach: StreamingRange,
        view: View,
        options: StreamOptions,
    ) -> Self {
        Self::with_lamps(source, (memory, words), None, reach, view, options)
    }

    /// As [`Self::new`], with a second buffer and its number of words, for the list of lamps. The list stays empty if no material gives off
    /// light.
    pub fn with_lamps(
        source: Arc<dyn ChunkProvider>,
        (memory, words): (Arc<dyn PoolMemory>, u32),
        lamps: Option<(Arc<dyn PoolMemory>, u32)>,
        reach: StreamingRange,
        view: View,
        options: StreamOptions,
    ) -> Self {
        Self::spawned_by(&threads::spawn, source, (memory, words), lamps, reach, view, options)
    }

    fn spawned_by(
        spawn: Spawn<'_>,
        source: Arc<dyn ChunkProvider>,
        (memory, words): (Arc<dyn PoolMemory>, u32),
        lamps: Option<(Arc<dyn PoolMemory>, u32)>,
        reach: StreamingRange,
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
            in_work: HashMap::new(),
            made: Vec::new(),
            budget: UploadBudget::new(options.upload.filter(|_| !options.complete), Instant::now()),
            pending: None,
            released: 0,
            settled: 0,
            error: None,
            unavailable: None,
            ask_anew: false,
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

    /// Why its threads have ended; `None` while they run. After that it loads and publishes nothing, and does not start again.
    pub fn ended(&self) -> Option<&StreamError> {
        self.shared.ended.get()
    }

    /// Estimates the memory for the tiles that a camera wants; `packed` gives the bytes of one in main memory. It makes a sample of the columns of
    /// tiles around the camera, as far as the source has them.
    pub fn estimate(
        source: &dyn ChunkProvider,
        reach: &StreamingRange,
        camera: glam::IVec3,
        packed: &dyn Fn(&Content) -> u64,
    ) -> Estimate {
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
        Estimate { pool: Pool::bytes_for(bytes[0] as u64, source.materials().len()), packed: bytes[1] as u64 }
    }

    /// Sets the camera at the start of a frame. Takes about a microsecond and never waits.
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

    /// Reports that these chunks of the source have changed. The streamer makes their tiles again, and the coarser tiles around them, and no
    /// others. Returns the number of this change: a publication shows all of it once its [`Publication::changes`] is at least this number.
    /// Changes are shown in order, several at once if they come faster than tiles can be made.
    pub fn changed(&self, chunks: &[ChunkPos]) -> u64 {
        self.shared.neighbor_faces.changed(chunks);
        let mut state = self.shared.state();
        state.changes += 1;
        let number = state.changes;
        let lamps = self.shared.lamps.is_some();
        for (tile, outdated) in &mut state.in_work {
            if outdated.is_none() && chunks.iter().any(|pos| tile.reads(*pos, lamps)) {
                *outdated = Some(number);
            }
        }
        for pos in chunks {
            state.changed.entry(*pos).or_insert(number);
        }
        state.view_serial += 1;
        self.shared.news.notify_one();
        state.changes
    }

    /// Takes the newest publication, if it was not taken yet. The caller writes its header to the start of the buffer before the next frame, and
    /// calls [`Streamer::released`] when the frames before have finished.
    pub fn take(&self) -> Option<Arc<Publication>> {
        let taken = self.shared.state().pending.take();
        if taken.is_some() {
            self.shared.news.notify_one();
        }
        taken
    }

    /// As [`Self::take`], but first waits for a publication that shows the change with this number (see [`Streamer::changed`]). After `patience`,
    /// or once the streamer has [`ended`](Streamer::ended), it takes the newest one there is.
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

    /// Whether a publication waits for [`Streamer::take`].
    pub fn has_pending(&self) -> bool {
        self.shared.state().pending.is_some()
    }

    /// Reports that every frame that could reach publications below this version has finished. The streamer may then reuse the blocks that only
    /// they reach.
    pub fn released(&self, version: u64) {
        let mut state = self.shared.state();
        if state.released < version {
            state.released = version;
            self.shared.news.notify_one();
        }
    }

    /// Waits until every wanted tile is published, for pictures that must be complete. Asks at once for tiles that failed an earlier wait.
    pub fn wait(&self, timeout: Duration) -> Result<(), StreamError> {
        let until = Instant::now() + timeout;
        let mut state = self.shared.state();
        // A source that panicked would panic again.
        let passes = |error: &StreamError| matches!(error, StreamError::Unavailable { reason, .. } if reason.cause != Cause::Panicked);
        if state.error.take_if(|(_, error)| passes(error)).is_some() {
            state.ask_anew = true;
            self.shared.news.notify_one();
        }
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

    /// Tries again after [`StreamError::NoRoom`]. The caller has taken and released a publication since.
    pub fn retry(&self) {
        let mut state = self.shared.state();
        state.view_serial += 1;
        state.moves += 1;
        self.shared.news.notify_one();
    }

    /// Whether every wanted tile is published.
    pub fn is_settled(&self) -> bool {
        let state = self.shared.state();
        state.settled == state.view_serial
    }

    /// Whether the missing tiles in [`Streamer::stats`] are counted for the newest view.
    pub fn has_looked(&self) -> bool {
        let state = self.shared.state();
        state.looked == state.view_serial
    }

    /// The reason why the source does not have a wanted tile; `None` if it has all of them. The streamer asks for such tiles again later.
    pub fn unavailable(&self) -> Option<Unavailable> {
        self.shared.state().unavailable.clone()
    }

    /// Figures about its tiles and its pool.
    pub fn stats(&self) -> Stats {
        let (stats, most_written) = {
            let state = self.shared.state();
            (state.stats, state.budget.most())
        };
        Stats { most_written, pool: self.shared.pool.stats(), ..stats }
    }

    /// The source of its tiles.
    pub fn source(&self) -> &Arc<dyn ChunkProvider> {
        &self.shared.source
    }
}

impl Drop for Streamer {
    fn drop(&mut self) {
        self.shared.stop();
        for thread in self.threads.drain(..) {
            // The thread catches its own panics and puts the reason into `ended`.
            let _ = thread.join();
        }
    }
}
