//! A source that lacks some of its tiles for a while. The other tiles are shown at once, the missing ones when they arrive.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_oracle::port::Tree64;
use raxel_stream::{Publication, StreamError, StreamOptions, Streamer, StreamingRange, View};
use raxel_testing::Words;
use raxel_world::{Cause, ChunkPos, ChunkProvider, Content, Material, Unavailable, World};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);
const WORDS: u32 = 1 << 18;

/// A world that fails for some chunks, this number of times each.
struct Failing {
    world: World,
    left: Mutex<BTreeMap<ChunkPos, u32>>,
    /// How long each of the others takes.
    pause: Duration,
}

fn failing(chunks: &[(ChunkPos, u32)]) -> Arc<Failing> {
    slowly_failing(chunks, Duration::ZERO)
}

/// A voxel in each of 27 chunks.
fn slowly_failing(chunks: &[(ChunkPos, u32)], pause: Duration) -> Arc<Failing> {
    let at = |i: i32| 64 * (i - 1) + 9;
    let voxels = (0..27).map(|i| (IVec3::new(at(i % 3), at(i / 3 % 3), at(i / 9)), 1));
    let world = World::from_voxels(vec![Material::air(), Material::matt("stone", [0.5; 3])], voxels);
    Arc::new(Failing { world, left: Mutex::new(chunks.iter().copied().collect()), pause })
}

impl ChunkProvider for Failing {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        if let Some(left) = self.left.lock().unwrap().get_mut(&pos).filter(|left| **left > 0) {
            *left -= 1;
            return Err(Unavailable::new(level, pos, Cause::Failing, "the store is busy"));
        }
        std::thread::sleep(self.pause);
        Ok(self.world.tile(level, pos))
    }
}

fn stream(source: &Arc<Failing>, complete: bool) -> (Streamer, Arc<Words>) {
    let words = Words::new(WORDS);
    let settings = StreamSettings { near: 64, far: 64, ..StreamSettings::default() };
    let reach = StreamingRange::of(&settings, [-64, 128]);
    let options = StreamOptions { workers: 2, complete, upload: None, poison: true };
    let view = View::at(IVec3::splat(30));
    (Streamer::new(source.clone(), words.clone(), WORDS, reach, view, options), words)
}

/// Chunks whose voxel is in what a frame sees.
fn seen(words: &Words, publication: &Publication) -> Vec<ChunkPos> {
    let mut words = words.all();
    words[..publication.words().len()].copy_from_slice(publication.words());
    let tree = Tree64::new(&words);
    let positions = (-1..=1).flat_map(|z| (-1..=1).flat_map(move |y| (-1..=1).map(move |x| ChunkPos::new(x, y, z))));
    positions.filter(|pos| tree.material((pos.origin() + IVec3::splat(9)).to_array()) == 1).collect()
}

#[test]
fn what_fails_for_a_while_is_there_in_the_end() {
    let source = failing(&[(ChunkPos::new(0, 0, 0), 2), (ChunkPos::new(1, 1, 0), 1)]);
    let (streamer, words) = stream(&source, true);
    streamer.wait(PATIENCE).unwrap();
    let publication = streamer.take().unwrap();
    assert_eq!(seen(&words, &publication).len(), 27);
    assert_eq!((streamer.stats().unavailable, streamer.unavailable()), (0, None));
}

#[test]
fn what_fails_for_good_is_an_error_of_whoever_needs_all() {
    let source = failing(&[(ChunkPos::new(0, 0, 0), u32::MAX)]);
    let (streamer, _) = stream(&source, true);
    let error = streamer.wait(PATIENCE).unwrap_err();
    assert!(matches!(&error, StreamError::Unavailable { missing: 1.., .. }), "{error}");
    assert_eq!(error.to_string(), "a chunk is missing: the chunk at 0, 0, 0 is unavailable: the store is busy");
    // It is asked for again when the camera has moved.
    source.left.lock().unwrap().clear();
    streamer.follow(View::at(IVec3::splat(95)));
    streamer.wait(PATIENCE).unwrap();
}

#[test]
fn whoever_waits_again_asks_the_source_again() {
    let broken = ChunkPos::new(0, 0, 0);
    let source = failing(&[(broken, u32::MAX)]);
    let (streamer, words) = stream(&source, true);
    streamer.wait(PATIENCE).unwrap_err();
    let before = source.left.lock().unwrap()[&broken];
    streamer.wait(PATIENCE).unwrap_err();
    assert_eq!(before - source.left.lock().unwrap()[&broken], 4);
    // The source has it again, and the camera has not moved.
    source.left.lock().unwrap().insert(broken, 2);
    streamer.wait(PATIENCE).unwrap();
    assert_eq!(seen(&words, &streamer.take().unwrap()).len(), 27);
}

#[test]
fn what_was_not_asked_for_yet_is_not_called_missing() {
    // It is asked for four times in 3.5 seconds, and the others take longer.
    let source = slowly_failing(&[(ChunkPos::new(0, 0, 0), u32::MAX)], Duration::from_millis(400));
    let (streamer, _) = stream(&source, true);
    let error = streamer.wait(PATIENCE).unwrap_err();
    assert!(matches!(&error, StreamError::Unavailable { missing: 1, .. }), "{error}");
}

#[test]
fn frames_go_on_without_what_fails() {
    let broken = ChunkPos::new(0, 0, 0);
    let source = failing(&[(broken, u32::MAX)]);
    let (streamer, words) = stream(&source, false);
    let until = Instant::now() + PATIENCE;
    let mut last = Vec::new();
    let mut follow = |wanted: usize| {
        while last.len() != wanted || (streamer.unavailable().is_some() == (wanted == 27)) {
            assert!(Instant::now() < until, "{} of {wanted} chunks are seen", last.len());
            if let Some(publication) = streamer.take() {
                last = seen(&words, &publication);
                streamer.released(publication.version);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        last.clone()
    };
    let without = follow(26);
    assert!(!without.contains(&broken));
    assert_eq!(&*streamer.unavailable().expect("a chunk is missing").reason, "the store is busy");
    assert!(!streamer.is_settled() && streamer.stats().unavailable == 1);
    source.left.lock().unwrap().clear();
    follow(27);
    assert_eq!(streamer.unavailable(), None);
    streamer.wait(PATIENCE).unwrap();
}
