//! A long flight over real land: memory stays within its bounds, and stays the same.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_stream::{PoolMemory, Reach, StreamOptions, Streamer, View};
use raxel_world::{StreamSettings, Streamed};

/// Bytes of the pool: less than what is near takes, so that it is full on the way.
const POOL: usize = 12 << 20;

struct Words(Mutex<Vec<u32>>);

impl PoolMemory for Words {
    fn write(&self, at: u32, words: &[u32]) {
        self.0.lock().unwrap()[at as usize..][..words.len()].copy_from_slice(words);
    }
}

fn frontier() -> Streamed {
    let files = DiskFiles::new(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))).unwrap();
    let loaded = raxel_world::file::load("worlds/frontier.toml", &files, &mut SourceMap::default());
    loaded.unwrap_or_else(|error| panic!("{error:?}")).0.stream.expect("it is streamed")
}

/// With `near` = 1024 and `far` = 65536, as a GPU would have it.
#[test]
fn what_is_near_and_far_of_the_shipped_land_fits_256_mib() {
    let streamed = frontier();
    let settings = StreamSettings { near: 1024, far: 65_536, ..streamed.settings };
    let reach = Reach::of(&settings, streamed.generator.height_range().unwrap());
    let at = IVec3::new(40, 170, 60);
    let [bytes, _] = Streamer::estimate(&*streamed.generator, &reach, at, &|_| 0);
    // It was 128.1 MiB when it was measured.
    assert!(bytes < 136 << 20, "{bytes}");
}

/// Bytes of the process, as far as the system says.
fn resident() -> Option<u64> {
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split_whitespace().nth(1)?.parse().ok()?;
    Some(4096 * pages)
}

/// An hour at 64 voxels a second, as fast as tiles come: straight on, with a turn every 2,000 voxels. `RAXEL_FLIGHT_TILES` ends it after so
/// many tiles.
#[test]
#[ignore = "takes minutes"]
fn an_hour_of_flight_takes_no_more_memory_than_its_first_minutes() {
    let streamed = frontier();
    let settings = StreamSettings { near: 256, far: 4096, ..streamed.settings };
    let reach = Reach::of(&settings, streamed.generator.height_range().unwrap());
    let memory = Arc::new(Words(Mutex::new(vec![0; POOL / 4])));
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: false };
    let streamer =
        Streamer::new(streamed.generator.clone(), memory, (POOL / 4) as u32, reach, View::at(IVec3::ZERO), options);
    let most: u64 = std::env::var("RAXEL_FLIGHT_TILES").ok().and_then(|tiles| tiles.parse().ok()).unwrap_or(u64::MAX);
    let (mut at, mut samples) = ([0.5f64, 0.5], Vec::new());
    let began = Instant::now();
    for step in 0..3600 {
        let turn = f64::from(step / 31) * 2.4;
        at = [at[0] + 64.0 * turn.cos(), at[1] + 64.0 * turn.sin()];
        streamer.follow(View::at(IVec3::new(at[0] as i32, 170, at[1] as i32)));
        let until = Instant::now() + Duration::from_secs(120);
        while !streamer.is_settled() || streamer.has_pending() {
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
            }
            let stats = streamer.stats();
            assert!(stats.pool[1] <= stats.pool[2], "over budget: {stats:?}");
            assert!(Instant::now() < until, "second {step}: {stats:?}");
            std::thread::sleep(Duration::from_micros(200));
        }
        if step % 60 == 59 {
            let stats = streamer.stats();
            samples.push(resident().unwrap_or(0));
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
    let (early, late) = (samples[samples.len() / 6], samples[samples.len() - 1]);
    assert!(late <= early + early / 50 + (1 << 20), "{early} bytes, then {late}: {samples:?}");
}
