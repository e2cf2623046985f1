//! A long flight over real land: memory stays within its bounds, and stays the same.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_stream::{StreamOptions, Streamer, StreamingRange, View};
use raxel_testing::Words;
use raxel_world::random::{SplitMix64, mix};
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable};
use raxel_worldfile::{StreamSettings, Streamed};

/// Bytes of the pools: less than the near tiles take, so that the pools are full on the way.
const LAND: u32 = 12 << 20;
const QUICK: u32 = 4 << 20;

fn frontier() -> Streamed {
    let files = DiskFiles::new(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))).unwrap();
    let loaded = raxel_worldfile::load("worlds/frontier.toml", &files, &mut SourceMap::default());
    loaded.unwrap_or_else(|error| panic!("{error:?}")).0.stream.expect("it is streamed")
}

/// With `near` = 1024 and `far` = 65536, as a GPU would have it.
#[test]
fn what_is_near_and_far_of_the_shipped_land_fits_256_mib() {
    let streamed = frontier();
    let settings = StreamSettings { near: 1024, far: 65_536, ..streamed.settings };
    let reach = StreamingRange::of(&settings, streamed.generator.height_range().unwrap());
    let at = IVec3::new(40, 170, 60);
    let bytes = Streamer::estimate(&*streamed.generator, &reach, at, &|_| 0).pool;
    // It was 128.1 MiB when it was measured.
    assert!(bytes < 136 << 20, "{bytes}");
}

/// Bytes of the process.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").expect("the system says what a process takes");
    let pages: u64 = text.split_whitespace().nth(1).and_then(|pages| pages.parse().ok()).expect("a number of pages");
    4096 * pages
}

/// Flies straight on, with a turn every 2,000 voxels, as fast as tiles come. Each second of the flight begins when all its tiles are there.
/// The pool is smaller than they are together. The flight ends after this number of tiles. Gives the memory of the process after each
/// minute; flights take turns, so that it is of one of them.
fn fly(
    source: Arc<dyn ChunkProvider>,
    reach: StreamingRange,
    pool: u32,
    height: i32,
    seconds: u32,
    most: u64,
) -> Vec<u64> {
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let memory = Words::new(pool / 4);
    // As many threads as the bound on memory assumes. Each thread keeps the memory of its largest tile, and the more threads there are, the
    // later each one meets it.
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(8);
    let options = StreamOptions { workers, complete: false, upload: None, poison: false };
    let streamer = Streamer::new(source, memory, pool / 4, reach, View::at(IVec3::ZERO), options);
    let (mut at, mut samples) = ([0.5f64, 0.5], Vec::new());
    let began = Instant::now();
    for step in 0..seconds {
        let turn = f64::from(step / 31) * 2.4;
        at = [at[0] + 64.0 * turn.cos(), at[1] + 64.0 * turn.sin()];
        streamer.follow(View::at(IVec3::new(at[0] as i32, height, at[1] as i32)));
        let until = Instant::now() + Duration::from_secs(120);
        while !streamer.is_settled() || streamer.has_pending() {
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
            }
            let stats = streamer.stats();
            assert!(stats.pool.peak <= stats.pool.capacity, "over budget: {stats:?}");
            assert!(Instant::now() < until, "second {step}: {stats:?}");
            std::thread::sleep(Duration::from_micros(200));
        }
        if step % 60 == 59 {
            let stats = streamer.stats();
            samples.push(resident());
            println!(
                "{step:>5} s: {} tiles, {:?}, near {}, {} MiB",
                stats.made,
                stats.pool,
                stats.near,
                samples[samples.len() - 1] >> 20
            );
            if stats.made >= most {
                break;
            }
        }
    }
    println!("{:?} in {:.0} s", streamer.stats(), began.elapsed().as_secs_f64());
    samples
}

/// No more at the end than after the first sixth.
fn takes_no_more(samples: &[u64]) {
    let (early, late) = (samples[samples.len() / 6], samples[samples.len() - 1]);
    assert!(late <= early + early / 50 + (1 << 20), "{early} bytes, then {late}: {samples:?}");
}

/// The shipped land, through a pool that is too small for it.
fn fly_over_land(seconds: u32, most: u64) -> Vec<u64> {
    let streamed = frontier();
    let settings = StreamSettings { near: 256, far: 4096, ..streamed.settings };
    let reach = StreamingRange::of(&settings, streamed.generator.height_range().unwrap());
    fly(streamed.generator, reach, LAND, 170, seconds, most)
}

/// A tile that found no room, while room was made by what others gave up, is asked for again.
#[test]
fn a_flight_through_too_little_memory_has_everything_everywhere() {
    fly_over_land(120, u64::MAX);
}

/// An hour at 64 voxels a second. `RAXEL_FLIGHT_TILES` ends it after this number of tiles.
#[test]
#[ignore = "takes minutes"]
fn an_hour_of_flight_takes_no_more_memory_than_its_first_minutes() {
    let most = std::env::var("RAXEL_FLIGHT_TILES").ok().and_then(|tiles| tiles.parse().ok());
    takes_no_more(&fly_over_land(3600, most.unwrap_or(u64::MAX)));
}

/// Things that are quick to make: small ones in five materials, different in every tile; some tiles are empty, and some full.
struct Quick(Vec<Material>);

impl Quick {
    fn chunk(level: u32, pos: ChunkPos) -> Content {
        let seed = [level.cast_signed(), pos.x, pos.y, pos.z]
            .iter()
            .fold(3, |seed, c| mix(seed ^ u64::from(c.cast_unsigned())));
        let mut random = SplitMix64::new(seed);
        match random.below(8) {
            0..=2 => return Content::Empty,
            3 => return Content::Full(1 + random.below(5) as u16),
            _ => {}
        }
        let mut dense = DenseChunk::default();
        for _ in 0..40 {
            dense.apply(random.below(4096) as usize, u64::MAX, Mode::Add, 1 + random.below(5) as u16);
            dense.apply(random.below(4096) as usize, random.bits(), Mode::Add, 1 + random.below(5) as u16);
        }
        Content::pack(&dense)
    }
}

impl ChunkProvider for Quick {
    fn materials(&self) -> &[Material] {
        &self.0
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(Self::chunk(level, pos))
    }
}

/// A flight of a million tiles.
#[test]
#[ignore = "takes minutes"]
fn a_million_tiles_take_no_more_memory_than_the_first_of_them() {
    let materials = vec![Material::air(); 6];
    let reach = StreamingRange::of(&StreamSettings { near: 512, far: 2048, ..StreamSettings::default() }, [-256, 256]);
    takes_no_more(&fly(Arc::new(Quick(materials)), reach, QUICK, 0, u32::MAX, 1_000_000));
}
