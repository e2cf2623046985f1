//! Rays over the pool against the exact tracer over the voxels that are resident, while tiles come and go.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, RwLock};
use std::time::{Duration, Instant};

use glam::IVec3;
use raxel_layouts::{TileBlock, Tree64Header};
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::sets::RayTargets;
use raxel_oracle::{Oracle, sets};
use raxel_stream::{Publication, Stats, StreamError, StreamOptions, Streamer, StreamingRange, TileKey, View};
use raxel_testing::{ReachableSet, Words, union};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Mode, Unavailable, World, voxel_index};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);

fn materials() -> Vec<Material> {
    std::iter::once(Material::air()).chain((1..6).map(|n| Material::matt(format!("m{n}"), [0.5; 3]))).collect()
}

/// Balls, boxes and dust of five materials over some thousand voxels.
fn scattered_world(seed: u64) -> World {
    let mut random = SplitMix64::new(seed);
    let mut chunks: BTreeMap<ChunkPos, DenseChunk> = BTreeMap::new();
    for _ in 0..400 {
        let mut at = |range: u64| random.below(range) as i32;
        let centre = IVec3::new(at(2400) - 1200, at(400) - 200, at(2400) - 1200);
        let (size, material, dust) = (4 + at(36), 1 + at(5) as u16, at(3) == 0);
        let reach = size + 1;
        for y in -reach..=reach {
            for z in -reach..=reach {
                for x in -reach..=reach {
                    let inside =
                        if dust { (x * 7 + y * 13 + z * 29) % 31 == 0 } else { x * x + y * y + z * z < size * size };
                    let cell = centre + IVec3::new(x, y, z);
                    if inside && (cell.x & 15 != 3) {
                        let chunk = chunks.entry(ChunkPos::of_cell(cell)).or_default();
                        let material = if cell.y & 1 == 0 { material } else { 1 };
                        chunk.set((cell.x & 63) as u32, (cell.y & 63) as u32, (cell.z & 63) as u32, material);
                    }
                }
            }
        }
    }
    // Some chunks that are all of one material.
    for n in 0..20 {
        let mut full = DenseChunk::default();
        full.fill(1 + n % 5);
        chunks.insert(ChunkPos::new(random.below(30) as i32 - 15, -2, random.below(30) as i32 - 15), full);
    }
    let packed = chunks.iter().filter_map(|(pos, dense)| Some((*pos, Content::pack(dense).to_chunk()?)));
    World::new(materials(), packed)
}

/// Wrong rays, and hits.
fn judge(words: &[u32], world: &World, rays: usize, seed: u64) -> u64 {
    let (tree, oracle) = (Tree64::new(words), Oracle::new(world));
    let targets = RayTargets::of(world);
    let mut errors = Errors::default();
    for set in sets::ALL {
        for ray in set.block(&targets, seed, 0, rays) {
            let (answer, found) = (oracle.first_hit(&ray), tree.trace(&ray));
            let before = errors.wrong();
            errors.add(&ray, &answer, found.as_ref());
            assert_eq!(errors.wrong(), before, "{} {ray:?}\nexact {answer:?}\nfound {found:?}", set.name);
        }
    }
    errors.hits
}

fn settings(near: u32, far: u32) -> StreamSettings {
    StreamSettings { near, far, ..StreamSettings::default() }
}

fn options(complete: bool) -> StreamOptions {
    StreamOptions { workers: 2, complete, upload: None, poison: true }
}

/// Tiles that a directory of level 0 alone reaches, by walking down its nodes.
fn resident(words: &[u32]) -> Vec<TileKey> {
    let (header, body) = words.split_at(16);
    let header: &Tree64Header = bytemuck::from_bytes(bytemuck::cast_slice(header));
    ReachableSet::of(header, body).chunks.into_iter().map(|(pos, _)| TileKey { level: 0, pos }).collect()
}

/// Remembers what tiles of a world are: coarse ones take long, and are asked for again and again.
struct Remembered {
    world: World,
    tiles: Mutex<BTreeMap<TileKey, Content>>,
    given_up: Mutex<Vec<TileKey>>,
}

impl Remembered {
    fn new(seed: u64) -> Arc<Self> {
        Arc::new(Self { world: scattered_world(seed), tiles: Mutex::default(), given_up: Mutex::default() })
    }
}

impl Remembered {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let key = TileKey { level, pos };
        if let Some(known) = self.tiles.lock().unwrap().get(&key) {
            return known.clone();
        }
        let content = if level == 0 {
            self.world.tile(0, pos)
        } else {
            let mut dense = DenseChunk::default();
            for child in 0..64 {
                let cell = raxel_world::child_cell(child);
                let [x, y, z] = cell.map(|c| c as i32);
                let below = self.chunk(level - 1, ChunkPos::new(4 * pos.x + x, 4 * pos.y + y, 4 * pos.z + z));
                raxel_world::reduce(&below, cell, &mut dense);
            }
            Content::pack(&dense)
        };
        self.tiles.lock().unwrap().insert(key, content.clone());
        content
    }
}

impl ChunkProvider for Remembered {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }

    fn on_evicted(&self, level: u32, pos: ChunkPos) {
        self.given_up.lock().unwrap().push(TileKey { level, pos });
    }
}

/// Ways from place to place: steps, jumps, and far away.
fn path(seed: u64, steps: usize) -> Vec<IVec3> {
    let mut random = SplitMix64::new(seed);
    let mut camera = IVec3::new(0, 30, 0);
    (0..steps)
        .map(|step| {
            let mut by = |range: u64| random.below(2 * range + 1) as i32 - range as i32;
            camera = match step % 5 {
                4 => IVec3::new(by(1200), by(250), by(1200)),
                _ => camera + IVec3::new(by(120), by(40), by(120)),
            };
            camera
        })
        .collect()
}

#[test]
fn complete_worlds_are_exact_at_every_level() {
    let source = Remembered::new(3);
    for (near, far, steps) in [(200, 200, 20), (64, 256, 8), (64, 600, 4)] {
        let reach = StreamingRange::of(&settings(near, far), [-300, 300]);
        let memory = Words::new(1 << 22);
        let view = View::at(IVec3::ZERO);
        let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 22, reach.clone(), view, options(true));
        let mut hits = 0;
        let mut now: Option<Arc<Publication>> = None;
        for (step, camera) in path(u64::from(far), steps).into_iter().enumerate() {
            streamer.follow(View::at(camera));
            streamer.wait(PATIENCE).unwrap();
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
                now = Some(taken);
            }
            let world = union(&*source, &reach.tiles(camera)).unwrap();
            let publication = now.as_ref().unwrap();
            hits += judge(&memory.frame(publication), &world, 64, step as u64);
            // Rays end where the cells do, not the tiles.
            let (bounds, header) = (world.bounds().unwrap(), publication.header);
            let cell = raxel_world::cell_edge(reach.top());
            for i in 0..3 {
                let beyond = [
                    bounds.min[i] - i64::from(header.bounds_min[i]),
                    i64::from(header.bounds_last[i]) + 1 - bounds.max[i],
                ];
                assert!(
                    beyond.iter().all(|beyond| (0..cell).contains(beyond)),
                    "{beyond:?} on axis {i}, {near} to {far}"
                );
            }
        }
        assert!(hits > 1000, "{hits} hits of {near} to {far}");
        let given_up = std::mem::take(&mut *source.given_up.lock().unwrap());
        assert_eq!(given_up.len() as u64, streamer.stats().dropped, "the source is told of each");
    }
}

#[test]
fn every_publication_of_a_flight_is_exact() {
    let source = Arc::new(scattered_world(5));
    let reach = StreamingRange::of(&settings(256, 256), [-300, 300]);
    let memory = Words::new(1 << 22);
    let view = View::at(IVec3::ZERO);
    let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 22, reach, view, options(false));
    let mut random = SplitMix64::new(9);
    // Frames that the device has not finished: each reads the publication that was the newest when it was submitted.
    let mut in_flight: VecDeque<Arc<Publication>> = VecDeque::new();
    let (mut publications, mut hits) = (0, 0);
    for (step, camera) in path(11, 400).into_iter().enumerate() {
        streamer.follow(View::at(camera));
        if random.below(3) == 0 {
            std::thread::sleep(Duration::from_millis(random.below(6)));
        }
        // Most steps take what there is; some wait, so that a slow machine publishes often enough, too.
        let until = Instant::now() + Duration::from_secs(60);
        while step % 4 == 0 && !streamer.has_pending() && !streamer.is_settled() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        if let Some(taken) = streamer.take() {
            in_flight.push_back(taken);
            publications += 1;
        }
        while in_flight.len() > 3 || (in_flight.len() > 1 && random.below(4) == 0) {
            in_flight.pop_front();
            streamer.released(in_flight[0].version);
        }
        if step % 4 == 0 && !in_flight.is_empty() {
            // The oldest one is the one that would be overwritten first.
            let words = memory.frame(&in_flight[0]);
            let world = union(&*source, &resident(&words)).unwrap();
            hits += judge(&words, &world, 24, step as u64);
        }
    }
    let stats = streamer.stats();
    assert!(publications > 50 && hits > 1000, "{publications} publications, {hits} hits, {stats:?}");
    assert_eq!(stats.pool.failed, 0, "{stats:?}");
    assert!(stats.dropped > 100, "{stats:?}");
}

#[test]
fn a_frame_brings_no_more_than_its_bytes_and_all_of_it_arrives() {
    const UPLOAD: u64 = 40 << 10;
    let source = Arc::new(scattered_world(8));
    let (reach, view) = (StreamingRange::of(&settings(256, 256), [-300, 300]), View::at(IVec3::ZERO));
    let bytes = |tile: &TileKey| {
        let content = ChunkProvider::try_chunk(&*source, tile.level, tile.pos).unwrap();
        TileBlock::of(&content, tile.level).map_or(0, |block| 4 * u64::from(block.words()))
    };
    let largest = reach.tiles(IVec3::ZERO).iter().map(bytes).max().unwrap();
    let load = |upload| {
        let options = StreamOptions { upload, ..options(false) };
        let streamer = Streamer::new(source.clone(), Words::new(1 << 22), 1 << 22, reach.clone(), view, options);
        let mut directory = 0;
        while !streamer.is_settled() || streamer.has_pending() {
            if upload.is_some() {
                streamer.follow(view);
            }
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
                directory = directory.max(16 * u64::from(taken.header.node_count));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        (streamer.stats(), directory)
    };
    let (free, _) = load(None);
    assert_eq!(free.most_written, free.written, "nothing says when a frame begins");
    let (stats, directory) = load(Some(UPLOAD));
    // The last write of a frame may begin while a byte is left; directories do not wait, and nothing bounds their number.
    assert!(stats.most_written <= UPLOAD + largest + 4 * directory, "{stats:?} {largest} {directory}");
    assert!(stats.written > 4 * stats.most_written, "{stats:?}");
    assert_eq!((stats.missing, stats.live), (0, free.live));
}

#[test]
fn a_still_camera_over_a_complete_world_publishes_nothing() {
    let reach = StreamingRange::of(&settings(128, 512), [-300, 300]);
    let memory = Words::new(1 << 21);
    let streamer = Streamer::new(Remembered::new(1), memory, 1 << 21, reach, View::at(IVec3::ZERO), options(false));
    let settle = || loop {
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
        }
        if streamer.is_settled() && streamer.stats().missing == 0 {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    settle();
    while streamer.take().is_some() {
        settle();
    }
    let before = streamer.stats();
    for turn in 0..50 {
        // A camera that moves inside its chunk wants nothing else.
        streamer.follow(View::at(IVec3::new(turn, 0, 0)));
        std::thread::sleep(Duration::from_millis(2));
        assert!(streamer.take().is_none());
    }
    let after = streamer.stats();
    // The directory of the version before may be released late; nothing else changes.
    assert!(after.pool.used <= before.pool.used, "{after:?}");
    assert_eq!(Stats { pool: before.pool, ..after }, before);
    // On a border and back, nothing is loaded twice.
    for _ in 0..20 {
        for x in [63, 64] {
            streamer.follow(View::at(IVec3::new(x, 0, 0)));
            settle();
        }
    }
    let loaded = streamer.stats().made;
    for _ in 0..20 {
        for x in [63, 64] {
            streamer.follow(View::at(IVec3::new(x, 0, 0)));
            settle();
        }
    }
    assert_eq!(streamer.stats().made, loaded);
}

#[test]
fn a_pool_that_is_too_small_shrinks_what_is_near_or_says_so() {
    let source = Arc::new(scattered_world(2));
    let reach = StreamingRange::of(&settings(512, 512), [-300, 300]);
    let words = 90_000;
    let wanted = Streamer::estimate(&*source, &reach, IVec3::ZERO, &|_| 0).pool;
    assert!(wanted > 4 * words, "{wanted}");
    let memory = Words::new(words as u32);
    let view = View::at(IVec3::ZERO);
    let streamer = Streamer::new(source.clone(), memory.clone(), words as u32, reach.clone(), view, options(false));
    let mut hits = 0;
    for step in 0..600 {
        streamer.follow(View::at(IVec3::new(step - 300, 0, 2 * step - 600)));
        std::thread::sleep(Duration::from_millis(1));
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
            if hits == 0 || step % 8 == 0 {
                let seen = memory.frame(&taken);
                hits += judge(&seen, &union(&*source, &resident(&seen)).unwrap(), 16, step as u64);
            }
        }
    }
    assert!(hits > 0, "nothing was seen");
    let stats = streamer.stats();
    assert!(stats.near < reach.near() && stats.near >= 1, "{stats:?}");
    assert!(stats.pool.peak <= stats.pool.capacity, "never more than there is: {stats:?}");
    // If pictures must be complete, half a world counts as none.
    let memory = Words::new(words as u32);
    let streamer = Streamer::new(source, memory, words as u32, reach, view, options(true));
    assert!(matches!(streamer.wait(PATIENCE), Err(StreamError::NoRoom { .. })));
}

/// A world whose chunks are changed while it is streamed.
struct Edited {
    world: World,
    chunks: RwLock<BTreeMap<ChunkPos, Content>>,
}

impl Edited {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        if level == 0
            && let Some(content) = self.chunks.read().unwrap().get(&pos)
        {
            return content.clone();
        }
        self.world.tile(level, pos)
    }
}

impl ChunkProvider for Edited {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

#[test]
fn changed_chunks_are_made_anew_and_no_others() {
    let source = Arc::new(Edited { world: scattered_world(4), chunks: RwLock::default() });
    let reach = StreamingRange::of(&settings(200, 200), [-300, 300]);
    let memory = Words::new(1 << 21);
    let view = View::at(IVec3::ZERO);
    let streamer = Streamer::new(source.clone(), memory.clone(), 1 << 21, reach.clone(), view, options(true));
    streamer.wait(PATIENCE).unwrap();
    let mut random = SplitMix64::new(4);
    for step in 0..40 {
        let made = streamer.stats().made;
        let mut touched = BTreeSet::new();
        for _ in 0..=random.below(5) {
            let mut at = || random.below(4) as i32 - 2;
            let pos = ChunkPos::new(at(), at(), at());
            let mut dense = DenseChunk::default();
            source.chunk(0, pos).unpack(&mut dense);
            for _ in 0..200 {
                let [x, y, z] = [0; 3].map(|_| random.below(64) as u32);
                let (block, bit) = voxel_index(x, y, z);
                let mode = if random.below(2) == 0 { Mode::Add } else { Mode::Subtract };
                dense.apply(block, 1 << bit, mode, 1 + random.below(5) as u16);
            }
            source.chunks.write().unwrap().insert(pos, Content::pack(&dense));
            touched.insert(pos);
        }
        streamer.changed(&touched.iter().copied().collect::<Vec<_>>());
        streamer.wait(PATIENCE).unwrap();
        let taken = streamer.take().expect("something has changed");
        streamer.released(taken.version);
        assert_eq!(streamer.stats().made - made, touched.len() as u64);
        assert_eq!(taken.changes, step + 1, "the publication has all of it");
        let world = union(&*source, &reach.tiles(IVec3::ZERO)).unwrap();
        judge(&memory.frame(&taken), &world, 32, step);
    }
}
