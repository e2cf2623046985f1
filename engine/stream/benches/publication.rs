//! How long it takes from a change of one chunk to the publication that shows it, among tens of thousands of other tiles.
//! `cargo bench -p raxel-stream --bench publication`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a bench")]

use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::IVec3;
use raxel_stream::{PoolMemory, StreamOptions, Streamer, StreamingRange, View};
use raxel_testing::Words;
use raxel_world::random::{SplitMix64, mix};
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(300);
const WORDS: u32 = 64 << 20;
const LAMP_WORDS: u32 = 16 << 20;

fn memory(words: u32) -> (Arc<dyn PoolMemory>, u32) {
    (Words::new(words), words)
}

/// A few blocks in every tile; in one of four, one of them gives off light.
struct Quick(Vec<Material>);

impl Quick {
    fn chunk(level: u32, pos: ChunkPos) -> Content {
        let seed = [level.cast_signed(), pos.x, pos.y, pos.z]
            .iter()
            .fold(3, |seed, c| mix(seed ^ u64::from(c.cast_unsigned())));
        let mut random = SplitMix64::new(seed);
        let mut dense = DenseChunk::default();
        for _ in 0..4 {
            dense.apply(random.below(4096) as usize, u64::MAX, Mode::Add, 1);
        }
        if random.below(4) == 0 {
            dense.apply(random.below(4096) as usize, 1, Mode::Add, 2);
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

fn publication(c: &mut Criterion) {
    let lamp = Material { emission: 2.0, ..Material::matt("lamp", [1.0; 3]) };
    let source = Arc::new(Quick(vec![Material::air(), Material::matt("stone", [0.5; 3]), lamp]));
    let settings = StreamSettings { near: 1024, far: 65_536, ..StreamSettings::default() };
    let options = StreamOptions { workers: 2, complete: false, upload: None, poison: false };
    let reach = StreamingRange::of(&settings, [-1024, 1024]);
    let lamps = Some(memory(LAMP_WORDS));
    let streamer = Streamer::with_lamps(source, memory(WORDS), lamps, reach, View::at(IVec3::ZERO), options);
    let take = || {
        let taken = streamer.take();
        taken.iter().for_each(|publication| streamer.released(publication.version));
        taken.is_some()
    };
    while !streamer.is_settled() || streamer.has_pending() {
        take();
        std::thread::sleep(Duration::from_millis(1));
    }
    let stats = streamer.stats();
    println!("{} tiles, {} lamps", stats.live, stats.lights);
    let mut group = c.benchmark_group("publication");
    group.sample_size(50);
    let mut n = 0;
    group.bench_function("one chunk", |b| {
        b.iter(|| {
            n += 1;
            let number = streamer.changed(&[ChunkPos::new(n % 16 - 8, n / 16 % 16 - 8, n / 256 % 16 - 8)]);
            let taken = streamer.take_with(number, PATIENCE).expect("the chunk is made");
            assert!(taken.changes >= number);
            streamer.released(taken.version);
        });
    });
    group.finish();
}

criterion_group!(benches, publication);
criterion_main!(benches);
