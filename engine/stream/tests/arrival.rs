//! The order of arrival at a new place: something everywhere, then the tiles in the picture, then the rest.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use glam::{DVec3, IVec3};
use raxel_oracle::port::Tree64;
use raxel_stream::{Missing, StreamOptions, Streamer, StreamingRange, TileKey, View};
use raxel_testing::Words;
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);
const WORDS: u32 = 1 << 21;

/// Posts on a plane, one for each chunk, as they are at every level. It notes its requests.
struct Posts {
    materials: Vec<Material>,
    asked: Mutex<Vec<TileKey>>,
}

impl Posts {
    fn new() -> Arc<Self> {
        let materials = vec![Material::air(), Material::matt("post", [0.5; 3])];
        Arc::new(Self { materials, asked: Mutex::default() })
    }

    /// A post is a cube of 8 voxels at the corner of its chunk.
    fn is_solid(cell: IVec3) -> bool {
        (0..8).contains(&cell.y) && cell.x & 63 < 8 && cell.z & 63 < 8
    }
}

impl Posts {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        self.asked.lock().unwrap().push(TileKey { level, pos });
        let shift = 2 * level;
        // A cell is solid where a post reaches into it.
        let (each, wide) = ((64 >> shift).max(1), (8 >> shift).max(1));
        let mut dense = DenseChunk::default();
        if pos.y == 0 {
            for x in (0..64).filter(|x| x % each < wide) {
                for z in (0..64).filter(|z| z % each < wide) {
                    for y in 0..wide {
                        let (block, bit) = raxel_world::voxel_index(x, y, z);
                        dense.apply(block, 1 << bit, Mode::Add, 1);
                    }
                }
            }
        }
        Content::pack(&dense)
    }
}

impl ChunkProvider for Posts {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

fn reach() -> StreamingRange {
    StreamingRange::of(&StreamSettings { near: 256, far: 256 * 16, ..StreamSettings::default() }, [0, 64])
}

fn view(cell: IVec3) -> View {
    View { forward: DVec3::new(0.6, 0.0, -0.8), half_angle: 0.6, ..View::at(cell) }
}

#[test]
fn coarse_tiles_come_first_and_what_is_seen_before_what_is_not() {
    let source = Posts::new();
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 1, complete: true, upload: None, poison: true };
    let streamer = Streamer::new(source.clone(), memory, WORDS, reach(), view(IVec3::ZERO), options);
    for at in [[0, 20, 0], [100_000, 20, -40_000]].map(IVec3::from_array) {
        streamer.follow(view(at));
        streamer.wait(PATIENCE).unwrap();
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
        }
        let asked = std::mem::take(&mut *source.asked.lock().unwrap());
        assert_eq!(asked.len(), reach().tiles(at).len());
        let turn = |tile: &TileKey| (tile.level < reach().top(), !view(at).sees(*tile));
        assert!(asked.iter().map(turn).is_sorted(), "{asked:?}");
        assert!(asked.iter().any(|tile| turn(tile) == (true, false)), "some are seen");
        assert!(asked.iter().any(|tile| turn(tile) == (true, true)), "some are not");
    }
}

#[test]
fn the_world_ends_where_the_file_says_whatever_is_loaded_beyond() {
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let memory = Words::new(WORDS);
    let streamer = Streamer::new(Posts::new(), memory, WORDS, reach(), view(IVec3::ZERO), options);
    let edge = TileKey::edge(reach().top()) as i32;
    for step in [0, 1, 2, 1, 0] {
        let at = IVec3::new(step * edge + 40, 20, 0);
        streamer.follow(view(at));
        let (until, mut shown) = (Instant::now() + PATIENCE, None);
        while !streamer.is_settled() || streamer.has_pending() {
            assert!(Instant::now() < until, "{:?}", streamer.stats());
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
                shown = Some(taken);
            }
        }
        let ends = reach().tiles(at).into_iter().map(|tile| tile.origin()[0]).min();
        assert_eq!(shown.map(|shown| i64::from(shown.header.bounds_min[0])), ends, "step {step}");
    }
}

#[test]
fn a_place_without_holes_has_something_wherever_a_voxel_is() {
    let source = Posts::new();
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let streamer = Streamer::new(source, memory.clone(), WORDS, reach(), view(IVec3::ZERO), options);
    let mut random = SplitMix64::new(2);
    let (mut coarse, mut finest) = (0, 0);
    for jump in 0..6 {
        let at = IVec3::new(50_000 * jump, 20, -30_000 * jump);
        streamer.follow(view(at));
        let until = Instant::now() + PATIENCE;
        // Until all is there, with any publications on the way.
        while !streamer.is_settled() || streamer.has_pending() {
            assert!(Instant::now() < until, "{:?}", streamer.stats());
            let Some(taken) = streamer.take() else {
                std::thread::yield_now();
                continue;
            };
            streamer.released(taken.version);
            if !streamer.has_looked() || taken.stats.holes_in_view > 0 {
                continue;
            }
            *(if taken.stats.missing_in_view > 0 { &mut coarse } else { &mut finest }) += 1;
            let mut words = memory.all();
            words[..taken.words().len()].copy_from_slice(taken.words());
            let tree = Tree64::new(&words);
            for _ in 0..200 {
                let mut by = |range: i32| random.below(2 * range as u64) as i32 - range;
                let cell = IVec3::new((at.x + by(4000)) & !63, 0, (at.z + by(4000)) & !63) + IVec3::new(3, 5, 6);
                assert!(Posts::is_solid(cell));
                let top = TileKey::of_cell(reach().top(), cell);
                if view(at).sees(top) && reach().wants(at, top, 0) {
                    assert_eq!(tree.material(cell.to_array()), 1, "{cell} from {at}: {:?}", taken.stats);
                }
            }
        }
    }
    assert!(finest >= 1, "{coarse} coarse, {finest} complete");
}

/// Tiles around the wanted ones are loaded at every level: a camera that crosses a border, when all was there before, misses nothing.
#[test]
fn what_comes_near_is_there_before_it_is_missed() {
    let source = Posts::new();
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: true };
    let mut at = IVec3::new(20, 20, 20);
    let streamer = Streamer::new(source, memory, WORDS, reach(), view(at), options);
    let until = Instant::now() + PATIENCE;
    let pause = || {
        assert!(Instant::now() < until, "{:?}", streamer.stats());
        std::thread::sleep(Duration::from_millis(1));
    };
    let mut random = SplitMix64::new(4);
    for step in 0..60 {
        while !streamer.is_settled() || streamer.has_pending() {
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
            }
            pause();
        }
        let made = streamer.stats().made;
        let by = [IVec3::X, IVec3::NEG_X, IVec3::Z, IVec3::NEG_Z][random.below(4) as usize];
        at += 64 * by;
        streamer.follow(view(at));
        while !streamer.has_looked() {
            pause();
        }
        let stats = streamer.stats();
        assert_eq!(stats.missing_in_view, 0, "step {step} to {at}, {} made since: {stats:?}", stats.made - made);
    }
    assert!(streamer.stats().dropped > 100, "{:?}", streamer.stats());
}

/// Makes no more tiles than allowed.
struct Paced {
    posts: Arc<Posts>,
    left: Mutex<usize>,
    more: Condvar,
}

impl Paced {
    fn allow(&self, tiles: usize) {
        *self.left.lock().unwrap() = tiles;
        self.more.notify_all();
    }

    fn made(&self) -> u64 {
        self.posts.asked.lock().unwrap().len() as u64
    }
}

impl Paced {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let mut left = self.more.wait_while(self.left.lock().unwrap(), |left| *left == 0).unwrap();
        *left -= 1;
        self.posts.chunk(level, pos)
    }
}

impl ChunkProvider for Paced {
    fn materials(&self) -> &[Material] {
        self.posts.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

/// Lets workers go that wait for a tile, before the streamer waits for them.
struct Open(Arc<Paced>);

impl Drop for Open {
    fn drop(&mut self) {
        self.0.allow(usize::MAX);
    }
}

/// A flight of a frame for each 16 voxels, straight on, half a turn, and back, in many directions: borders of several axes follow each other
/// closely. Between two frames, the source makes twice the number of tiles that the flight needs on average.
#[test]
fn a_flight_misses_nothing_in_view() {
    const STEP: f64 = 16.0;
    const TILES: usize = 8;
    /// Frames of each straight part, and of half a turn.
    const LEG: u32 = 120;
    const TURN: u32 = 8;
    let source = Arc::new(Paced { posts: Posts::new(), left: Mutex::new(usize::MAX), more: Condvar::new() });
    let memory = Words::new(WORDS);
    let options = StreamOptions { workers: 1, complete: false, upload: None, poison: true };
    let mut at = DVec3::new(20.0, 20.0, 20.0);
    let streamer = Streamer::new(source.clone(), memory, WORDS, reach(), view(at.as_ivec3()), options);
    let _open = Open(source.clone());
    let mut seen = None;
    let mut take = || {
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
            seen = Some(taken);
        }
        seen.clone()
    };
    let until = Instant::now() + PATIENCE;
    let pause = || {
        assert!(Instant::now() < until, "{:?}", streamer.stats());
        std::thread::yield_now();
    };
    while !streamer.is_settled() || streamer.has_pending() {
        take();
        pause();
    }
    let legs = (0..5).flat_map(|way| {
        let yaw = 0.15 + 1.3 * f64::from(way);
        let turn = (0..TURN).map(move |n| (yaw + std::f64::consts::PI * f64::from(n) / f64::from(TURN), 0.0));
        let straight = |yaw| (0..LEG).map(move |_| (yaw, STEP));
        straight(yaw).chain(turn).chain(straight(yaw + std::f64::consts::PI))
    });
    for (step, (yaw, by)) in legs.enumerate() {
        let forward = DVec3::new(yaw.cos(), 0.0, yaw.sin());
        at += by * forward;
        let view = View { forward, velocity: 16.0 * by * forward, half_angle: 0.6, ..View::at(at.floor().as_ivec3()) };
        streamer.follow(view);
        while !streamer.has_looked() {
            pause();
        }
        let seen = take().expect("the first place is there");
        assert_eq!(
            seen.missing_in_view(&view),
            Some(Missing::default()),
            "step {step} at {at}: {:?}",
            streamer.stats()
        );

        let before = source.made();
        source.allow(TILES);
        let mut is_shown = || {
            let (made, shown) = (source.made(), take().map_or(0, |seen| seen.stats.made));
            let all = made == before + TILES as u64 && shown == made;
            (all || streamer.is_settled()) && !streamer.has_pending()
        };
        while !is_shown() {
            pause();
        }
        source.allow(0);
    }
    assert!(source.made() > 4000, "{}", source.made());
}
