//! Threads that cannot start, that panic and that are waited for.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_world::{ChunkPos, ChunkProvider, Content, Material, Unavailable};
use raxel_worldfile::StreamSettings;

use super::*;
use crate::{PoolMemory, Publication, StreamOptions, Streamer, StreamingRange, View};

const PATIENCE: Duration = Duration::from_secs(120);

/// Every chunk is full, or the source panics.
struct Rock {
    materials: Vec<Material>,
    panics: AtomicBool,
}

impl ChunkProvider for Rock {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn try_chunk(&self, _: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        assert!(!self.panics.load(Ordering::Relaxed) || pos.x != 0, "no chunk at zero");
        Ok(Content::Full(1))
    }
}

/// Memory that panics when a directory is flushed, on request.
#[derive(Default)]
struct Nowhere {
    panics: AtomicBool,
}

impl PoolMemory for Nowhere {
    fn write(&self, _: u32, _: &[u32]) {}

    fn flush(&self) {
        assert!(!self.panics.load(Ordering::Relaxed), "the device is gone");
    }
}

struct World {
    source: Arc<Rock>,
    memory: Arc<Nowhere>,
    streamer: Streamer,
}

fn world(complete: bool, spawn: Spawn<'_>) -> World {
    let rock =
        Rock { materials: vec![Material::air(), Material::matt("rock", [0.5; 3])], panics: AtomicBool::new(false) };
    let (source, memory) = (Arc::new(rock), Arc::new(Nowhere::default()));
    let settings = StreamSettings { near: 64, far: 64, ..StreamSettings::default() };
    let (reach, view) = (StreamingRange::of(&settings, [-64, 128]), View::at(IVec3::splat(30)));
    let options = StreamOptions { workers: 2, complete, upload: None, poison: false };
    let place = (memory.clone() as Arc<dyn PoolMemory>, 1 << 16);
    let streamer = Streamer::spawned_by(spawn, source.clone(), place, None, reach, view, options);
    World { source, memory, streamer }
}

/// Takes publications until a streamer has ended; gives the last of them.
fn until_ended(streamer: &Streamer) -> Option<Arc<Publication>> {
    let (began, mut last) = (Instant::now(), None);
    while streamer.ended().is_none() {
        assert!(began.elapsed() < PATIENCE, "it goes on");
        last = streamer.take().or(last);
        std::thread::yield_now();
    }
    last
}

/// Takes publications until all wanted tiles are shown.
fn settle(streamer: &Streamer) {
    let began = Instant::now();
    while !streamer.is_settled() || streamer.has_pending() {
        assert!(began.elapsed() < PATIENCE && streamer.ended().is_none(), "{:?}", streamer.ended());
        drop(streamer.take().inspect(|taken| streamer.released(taken.version)));
        std::thread::yield_now();
    }
}

/// A limit on how long a call may take that waits for nothing: far more than a busy machine needs, far less than [`PATIENCE`].
fn at_once<T>(call: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let value = call();
    assert!(began.elapsed() < PATIENCE / 4, "it waited for {:?}", began.elapsed());
    value
}

#[test]
fn a_thread_that_cannot_start_ends_the_streamer_whichever_it_is() {
    for refused in 0..3 {
        let started = AtomicU32::new(0);
        let failing = |name: &str, run: Run| {
            if started.fetch_add(1, Ordering::Relaxed) == refused {
                return Err(std::io::Error::other("no more threads"));
            }
            spawn(name, run)
        };
        let World { streamer, .. } = world(true, &failing);
        let thread = ["stream director", "stream worker 1", "stream worker 2"][refused as usize].to_owned();
        let expected = StreamError::NotStarted { thread, reason: "no more threads".to_owned() };
        assert_eq!(streamer.ended(), Some(&expected));
        assert_eq!(at_once(|| streamer.wait(PATIENCE)), Err(expected));
        assert!(at_once(|| streamer.take_with(1, PATIENCE)).is_none());
    }
}

#[test]
fn a_director_that_panics_wakes_those_who_wait_and_leaves_the_last_publication() {
    let World { memory, streamer, .. } = world(false, &spawn);
    settle(&streamer);
    memory.panics.store(true, Ordering::Relaxed);
    let before = streamer.stats().publications;
    // The change is published, which panics.
    let number = streamer.changed(&[ChunkPos::new(0, 0, 0)]);
    let waited = at_once(|| streamer.take_with(number, PATIENCE));
    assert!(until_ended(&streamer).or(waited).is_none() && streamer.stats().publications == before);
    let ended = streamer.ended().unwrap();
    assert_eq!(ended.to_string(), "the thread `stream director` has ended: it panicked: the device is gone");
    assert_eq!(at_once(|| streamer.wait(PATIENCE)).as_ref(), Err(ended));
}

#[test]
fn who_waits_for_a_director_hears_of_its_panic_in_the_same_call() {
    let World { memory, streamer, .. } = world(true, &spawn);
    streamer.wait(PATIENCE).unwrap();
    memory.panics.store(true, Ordering::Relaxed);
    streamer.follow(View::at(IVec3::new(700, 30, 30)));
    let error = at_once(|| streamer.wait(PATIENCE)).unwrap_err();
    assert!(matches!(&error, StreamError::Ended { thread, .. } if thread == "stream director"), "{error}");
}

#[test]
fn a_source_that_panics_is_without_one_chunk() {
    let World { source, streamer, .. } = world(false, &spawn);
    settle(&streamer);
    streamer.follow(View::at(IVec3::new(700, 30, 30)));
    settle(&streamer);
    source.panics.store(true, Ordering::Relaxed);
    streamer.follow(View::at(IVec3::splat(30)));
    let began = Instant::now();
    while streamer.unavailable().is_none() {
        assert!(began.elapsed() < PATIENCE, "nothing is said");
        std::thread::yield_now();
    }
    let said = streamer.unavailable().unwrap().to_string();
    assert!(
        said.starts_with("the chunk at 0, ") && said.ends_with("is unavailable: it panicked: no chunk at zero"),
        "{said}"
    );
    // It is asked again.
    source.panics.store(false, Ordering::Relaxed);
    settle(&streamer);
    assert_eq!((streamer.unavailable(), streamer.ended()), (None, None));
}

#[test]
fn who_waits_for_all_chunks_hears_of_one_that_panics_at_the_first() {
    let World { source, streamer, .. } = world(true, &spawn);
    streamer.wait(PATIENCE).unwrap();
    streamer.follow(View::at(IVec3::new(700, 30, 30)));
    streamer.wait(PATIENCE).unwrap();
    source.panics.store(true, Ordering::Relaxed);
    streamer.follow(View::at(IVec3::splat(30)));
    let error = streamer.wait(PATIENCE).unwrap_err();
    assert!(
        matches!(&error, StreamError::Unavailable { missing: 1.., .. }) && error.to_string().contains("panicked"),
        "{error}"
    );
}
