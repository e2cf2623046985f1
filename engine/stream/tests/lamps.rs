//! The list of lamps of a streamed world against the lamps of what is shown, while tiles come and go.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, RwLock};
use std::time::Duration;

use glam::IVec3;
use raxel_layouts::lights::{HEADER_WORDS, LIGHT_WORDS, lights};
use raxel_stream::{PoolMemory, Publication, StreamError, StreamOptions, Streamer, StreamingRange, TileKey, View};
use raxel_testing::{Words, union};
use raxel_world::random::SplitMix64;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, Material, Unavailable, World};
use raxel_worldfile::StreamSettings;

const PATIENCE: Duration = Duration::from_secs(120);
const WORDS: u32 = 1 << 21;
const ROOMY: u32 = 1 << 22;

fn materials() -> Vec<Material> {
    let lamp = |emission| Material { emission, ..Material::matt("lamp", [1.0; 3]) };
    vec![Material::air(), Material::matt("stone", [0.5; 3]), lamp(2.0), lamp(9.0)]
}

/// Boxes of stone with veins of lamps, across the borders of chunks and tiles, and all of it within a cube of 1,024 voxels.
fn world(seed: u64) -> World {
    let mut random = SplitMix64::new(seed);
    let mut chunks: BTreeMap<ChunkPos, DenseChunk> = BTreeMap::new();
    let mut set = |cell: IVec3, material: u16| {
        let [x, y, z] = (cell & 63).to_array().map(|c| c as u32);
        chunks.entry(ChunkPos::of_cell(cell)).or_default().set(x, y, z, material);
    };
    for _ in 0..120 {
        let mut below = |n: u64| random.below(n) as i32;
        let corner = IVec3::from_array([0; 3].map(|_| below(980) - 512));
        let size = IVec3::from_array([0; 3].map(|_| 2 + below(28)));
        let kind = below(4);
        for y in 0..size.y {
            for z in 0..size.z {
                for x in 0..size.x {
                    let lit = match kind {
                        0 => true,
                        1 => false,
                        _ => (x * 5 + y * 3 + z) % 7 == 0,
                    };
                    set(corner + IVec3::new(x, y, z), if lit { 2 + (kind as u16 & 1) } else { 1 });
                }
            }
        }
    }
    let packed = chunks.iter().filter_map(|(pos, dense)| Some((*pos, Content::pack(dense).to_chunk()?)));
    World::new(materials(), packed)
}

fn options(complete: bool) -> StreamOptions {
    StreamOptions { workers: 2, complete, upload: None, poison: true }
}

fn reach(near: u32, far: u32) -> StreamingRange {
    StreamingRange::of(&StreamSettings { near, far, ..StreamSettings::default() }, [-512, 512])
}

/// A face of a cell that is listed: corner, length of its sides, face, material.
type Listed = ([i32; 3], i32, u32, u32);

/// The lamps that a frame can draw, with the probability of each.
fn listed(memory: &Words, publication: &Publication) -> BTreeMap<Listed, f64> {
    let words = memory.all();
    let [count, power, groups_at, groups] = publication.lights.expect("lamps are asked for");
    let at = |word: usize| words[HEADER_WORDS + word];
    let number = |word: usize| f64::from(f32::from_bits(at(word)));
    let mut found: BTreeMap<Listed, f64> = BTreeMap::new();
    let mut drawn = vec![0.0; groups as usize];
    let table = 4 * groups_at as usize;
    for group in 0..groups as usize {
        let stays = number(table + 4 * group + 2);
        drawn[group] += stays / f64::from(groups);
        drawn[at(table + 4 * group + 3) as usize] += (1.0 - stays) / f64::from(groups);
    }
    for (group, drawn) in drawn.iter().enumerate() {
        let (first, lights) = (at(table + 4 * group), at(table + 4 * group + 1));
        for light in first..first + lights {
            let word = LIGHT_WORDS * light as usize;
            let stays = number(word + 5);
            for (of, part) in [(light, stays), (at(word + 6), 1.0 - stays)] {
                assert!((first..first + lights).contains(&of), "a lamp of another group");
                let word = LIGHT_WORDS * of as usize;
                let voxel = [0, 1, 2].map(|i| at(word + i).cast_signed());
                let kind = at(word + 3);
                let key = (voxel, 1 << (2 * (kind >> 19)), kind >> 16 & 7, kind & 0xffff);
                *found.entry(key).or_default() += drawn * part / f64::from(lights);
                // In proportion to power and area.
                assert!(number(word + 7) > 0.0 && f64::from(f32::from_bits(power)) > 0.0);
            }
        }
    }
    assert_eq!(found.len(), count as usize, "every lamp once");
    let power_of =
        |(_, edge, _, material): &Listed| f64::from(materials()[*material as usize].emission) * f64::from(edge * edge);
    let total: f64 = found.keys().map(power_of).sum();
    for (light, drawn) in &found {
        let share = power_of(light) / total;
        assert!((drawn - share).abs() < 1e-6 + 1e-4 * share, "{light:?}: {drawn} for {share}");
    }
    assert!((f64::from(f32::from_bits(power)) - total).abs() <= 1e-5 * total);
    found
}

/// The unit faces of the listed lamps.
fn unit_faces(listed: impl Iterator<Item = Listed>) -> BTreeSet<([i32; 3], u32)> {
    let mut faces = BTreeSet::new();
    for (voxel, edge, face, _) in listed {
        let axis = (face >> 1) as usize;
        for a in 0..edge {
            for b in 0..edge {
                let mut at = voxel;
                at[axis] += if face & 1 == 1 { edge - 1 } else { 0 };
                at[(axis + 1) % 3] += a;
                at[(axis + 2) % 3] += b;
                assert!(faces.insert((at, face)), "{at:?} is listed twice");
            }
        }
    }
    faces
}

#[test]
fn the_list_of_a_streamed_world_is_that_of_the_same_world_with_bounds() {
    let source = Arc::new(world(1));
    let expected: BTreeSet<Listed> = lights(&source)
        .iter()
        .map(|light| (light.voxel.to_array(), 1, light.face, u32::from(light.material)))
        .collect();
    assert!(expected.len() > 20_000, "{}", expected.len());
    let (memory, lamps) = (Words::new(WORDS), Words::new(ROOMY));
    let streamer = Streamer::with_lamps(
        source,
        (memory, WORDS),
        Some((lamps.clone(), ROOMY)),
        reach(1024, 1024),
        View::at(IVec3::ZERO),
        options(true),
    );
    streamer.wait(PATIENCE).unwrap();
    let taken = streamer.take().unwrap();
    assert_eq!(listed(&lamps, &taken).into_keys().collect::<BTreeSet<_>>(), expected);
    assert_eq!((streamer.stats().lights, streamer.stats().unlisted), (expected.len() as u64, 0));
}

/// With coarse tiles, every lamp that can be seen is listed, and nothing that is not there. Faces between two cells may be listed, too:
/// no ray reaches them.
#[test]
fn what_is_listed_is_what_is_shown_at_every_level() {
    let source = Arc::new(world(2));
    let reach = reach(64, 64 * 16);
    let (memory, lamps) = (Words::new(WORDS), Words::new(ROOMY));
    let streamer = Streamer::with_lamps(
        source.clone(),
        (memory, WORDS),
        Some((lamps.clone(), ROOMY)),
        reach.clone(),
        View::at(IVec3::ZERO),
        options(true),
    );
    let (mut levels, mut last) = (BTreeSet::new(), None);
    for camera in [[0, 0, 0], [200, -100, 90], [210, -90, 100], [-300, 40, 300]].map(IVec3::from_array) {
        streamer.follow(View::at(camera));
        streamer.wait(PATIENCE).unwrap();
        // If no other tile is wanted, nothing is published: the last publication is right here as well.
        last = streamer.take().or(last);
        let taken = last.clone().expect("a publication of the first place");
        streamer.released(taken.version);
        let shown = union(&*source, &reach.tiles(camera)).unwrap();
        let listed = listed(&lamps, &taken);
        levels.extend(listed.keys().map(|(_, edge, _, _)| *edge));
        for (voxel, edge, _, material) in listed.keys() {
            let far = IVec3::from_array(*voxel) + IVec3::splat(edge - 1);
            assert_eq!(u32::from(shown.voxel(IVec3::from_array(*voxel))), *material, "{voxel:?} of {edge}");
            assert_eq!(u32::from(shown.voxel(far)), *material, "{voxel:?} of {edge}");
        }
        let faces = unit_faces(listed.into_keys());
        let seen = lights(&shown);
        assert!(seen.len() > 1000);
        // The end of the world also cuts off the lamps.
        let inside = |cell: IVec3, face: u32| {
            let mut beyond = cell.to_array();
            beyond[(face >> 1) as usize] += if face & 1 == 1 { 1 } else { -1 };
            let beyond = IVec3::from_array(beyond);
            (0..=reach.top()).any(|level| reach.wants(camera, TileKey::of_cell(level, beyond), 0))
        };
        for light in seen.iter().filter(|light| inside(light.voxel, light.face)) {
            assert!(faces.contains(&(light.voxel.to_array(), light.face)), "{light:?} from {camera}");
        }
    }
    assert_eq!(levels, BTreeSet::from([1, 4, 16]));
}

/// A world whose chunks are changed while it is streamed.
struct Edited {
    world: World,
    chunks: RwLock<BTreeMap<ChunkPos, Content>>,
}

impl Edited {
    fn whole(&self) -> World {
        let chunks = self.chunks.read().unwrap();
        let positions: BTreeSet<ChunkPos> =
            self.world.chunks().map(|(pos, _)| pos).chain(chunks.keys().copied()).collect();
        let content = |pos: ChunkPos| chunks.get(&pos).cloned().unwrap_or_else(|| self.world.tile(0, pos));
        World::new(materials(), positions.into_iter().filter_map(|pos| Some((pos, content(pos).to_chunk()?))))
    }
}

impl Edited {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let edited = self.chunks.read().unwrap().get(&pos).filter(|_| level == 0).cloned();
        edited.unwrap_or_else(|| self.world.tile(level, pos))
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
fn an_edit_lists_the_lamps_that_it_lays_bare_and_no_longer_those_that_it_covers() {
    let source = Arc::new(Edited { world: world(3), chunks: RwLock::default() });
    let (memory, lamps) = (Words::new(WORDS), Words::new(ROOMY));
    let streamer = Streamer::with_lamps(
        source.clone(),
        (memory, WORDS),
        Some((lamps.clone(), ROOMY)),
        reach(1024, 1024),
        View::at(IVec3::ZERO),
        options(true),
    );
    streamer.wait(PATIENCE).unwrap();
    let mut random = SplitMix64::new(5);
    let positions: Vec<ChunkPos> = source.world.chunks().map(|(pos, _)| pos).collect();
    let mut last = streamer.take();
    for step in 0..30 {
        let pos = positions[random.below(positions.len() as u64) as usize];
        let mut dense = DenseChunk::default();
        source.chunk(0, pos).unpack(&mut dense);
        // A slab of the chunk at one of its faces, of air, stone or lamps.
        let (face, material) = (random.below(6) as u32, random.below(4) as u16);
        for a in 0..64 {
            for b in 0..64 {
                let mut at = [a, b, a ^ b];
                at[(face >> 1) as usize] = if face & 1 == 1 { 63 } else { 0 };
                at[(face as usize / 2 + 1) % 3] = a;
                at[(face as usize / 2 + 2) % 3] = b;
                dense.set(at[0], at[1], at[2], material);
            }
        }
        source.chunks.write().unwrap().insert(pos, Content::pack(&dense));
        streamer.changed(&[pos]);
        streamer.wait(PATIENCE).unwrap();
        last = streamer.take().or(last);
        let taken = last.clone().expect("a publication of the world before the edits");
        streamer.released(taken.version);
        let expected: BTreeSet<Listed> = lights(&source.whole())
            .iter()
            .map(|light| (light.voxel.to_array(), 1, light.face, u32::from(light.material)))
            .collect();
        let found: BTreeSet<Listed> = listed(&lamps, &taken).into_keys().collect();
        assert!(found == expected, "step {step}: {} lamps where there are {}", found.len(), expected.len());
    }
}

#[test]
fn more_lamps_than_there_is_room_for_are_left_out_or_refused() {
    let source = Arc::new(world(4));
    let all = lights(&source).len() as u64;
    // Half of it is for lights: six in ten of them.
    let small = (all * LIGHT_WORDS as u64 * 12 / 10) as u32;
    let (memory, lamps) = (Words::new(WORDS), Words::new(small));
    let stream = |complete| {
        let lamps = Some((lamps.clone() as Arc<dyn PoolMemory>, small));
        let view = View::at(IVec3::ZERO);
        Streamer::with_lamps(source.clone(), (memory.clone(), WORDS), lamps, reach(1024, 1024), view, options(complete))
    };
    let streamer = stream(true);
    assert!(matches!(streamer.wait(PATIENCE), Err(StreamError::TooManyLamps { .. })));
    drop(streamer);
    // A window goes on with some of them.
    let streamer = stream(false);
    let until = std::time::Instant::now() + PATIENCE;
    let mut last = None;
    while last.is_none() || !streamer.is_settled() || streamer.has_pending() {
        assert!(std::time::Instant::now() < until, "{:?}", streamer.stats());
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
            last = Some(taken);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let some = listed(&lamps, &last.unwrap());
    let stats = streamer.stats();
    assert!(!some.is_empty() && stats.lights == some.len() as u64 && stats.lights < all, "{stats:?}");
    assert!(stats.unlisted > 0, "{stats:?}");
    // Elsewhere there are fewer lamps, and the left ones come back to the list.
    streamer.follow(View::at(IVec3::new(1400, 0, 0)));
    while streamer.stats().unlisted > 0 || !streamer.is_settled() || streamer.has_pending() {
        assert!(std::time::Instant::now() < until, "{:?}", streamer.stats());
        if let Some(taken) = streamer.take() {
            streamer.released(taken.version);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(streamer.stats().lights > 0, "{:?}", streamer.stats());
}

/// A room of air with one chunk full of lamps, more than there is room for, and one with a few.
fn many_and_few() -> (Arc<Edited>, ChunkPos) {
    let [many, few] = [ChunkPos::new(1, 0, 0), ChunkPos::new(-2, 0, 0)];
    let mut dense = DenseChunk::default();
    (0..64u32.pow(3)).filter(|n| n % 3 == 0).for_each(|n| dense.set(n & 63, n >> 6 & 63, n >> 12, 2));
    let mut lamp = DenseChunk::default();
    lamp.set(20, 20, 20, 3);
    let chunks = [(many, dense), (few, lamp)].map(|(pos, dense)| (pos, Content::pack(&dense)));
    let world = World::new(materials(), std::iter::empty());
    (Arc::new(Edited { world, chunks: RwLock::new(BTreeMap::from(chunks)) }), few)
}

#[test]
fn a_tile_whose_lamps_do_not_fit_is_not_made_again_until_they_do() {
    let (source, few) = many_and_few();
    let (memory, lamps, words) = (Words::new(WORDS), Words::new(1 << 14), 1 << 14);
    let lamps = Some((lamps as Arc<dyn PoolMemory>, words));
    let view = View::at(IVec3::ZERO);
    let streamer = Streamer::with_lamps(source.clone(), (memory, WORDS), lamps, reach(256, 256), view, options(false));
    let until = std::time::Instant::now() + PATIENCE;
    let settle = || {
        while !streamer.is_settled() || streamer.has_pending() {
            assert!(std::time::Instant::now() < until, "{:?}", streamer.stats());
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        streamer.stats()
    };
    let before = settle();
    assert_eq!((before.unlisted, before.lights), (1, 6), "{before:?}");
    // Each of these changes the table of lamps, and gives the room of the one before back.
    for step in 0..20 {
        let mut lamp = DenseChunk::default();
        lamp.set(20, 20 + step % 2, 20, 2 + (step % 2) as u16);
        source.chunks.write().unwrap().insert(few, Content::pack(&lamp));
        streamer.changed(&[few]);
        settle();
    }
    let after = settle();
    assert_eq!((after.made - before.made, after.unlisted), (20, 1), "the edited chunk alone: {after:?}");
    // As many as there is room for.
    let mut dense = DenseChunk::default();
    (0..50).for_each(|n| dense.set(n, 0, 0, 2));
    let many = ChunkPos::new(1, 0, 0);
    source.chunks.write().unwrap().insert(many, Content::pack(&dense));
    streamer.changed(&[many]);
    let fits = settle();
    assert_eq!((fits.unlisted, fits.lights), (0, 6 + 50 * 4 + 2), "{fits:?}");
}

/// Tiles that are rebuilt because there is room for their lamps wait for frames, like all that no edit has changed.
#[test]
fn lamps_that_come_back_to_the_list_wait_for_frames() {
    const UPLOAD: u64 = 8 << 10;
    let source = Arc::new(world(6));
    let all = lights(&source).len() as u64;
    let small = (all * LIGHT_WORDS as u64) as u32;
    let (memory, lamps) = (Words::new(WORDS), Words::new(small));
    let lamps = Some((lamps as Arc<dyn PoolMemory>, small));
    let options = StreamOptions { upload: Some(UPLOAD), ..options(false) };
    // All of it is near enough from both places, so that moving drops nothing.
    let streamer =
        Streamer::with_lamps(source.clone(), (memory, WORDS), lamps, reach(1024, 1024), View::at(IVec3::ZERO), options);
    let until = std::time::Instant::now() + PATIENCE;
    let (mut at, mut directory) = (IVec3::ZERO, 0);
    let mut settle = |to: IVec3| {
        at = to;
        loop {
            streamer.follow(View::at(at));
            if let Some(taken) = streamer.take() {
                streamer.released(taken.version);
                let groups = taken.lights.map_or(0, |lights| 16 * u64::from(lights[3]));
                directory = directory.max(16 * u64::from(taken.header.node_count) + groups);
            }
            if streamer.has_looked() && streamer.is_settled() && !streamer.has_pending() {
                break;
            }
            assert!(std::time::Instant::now() < until, "{:?}", streamer.stats());
            std::thread::sleep(Duration::from_millis(1));
        }
        streamer.stats()
    };
    let before = settle(IVec3::ZERO);
    assert!(before.unlisted > 0, "{before:?}");
    // Half of the world goes, and with it half of the lamps.
    let after = settle(IVec3::new(1024, 0, 0));
    assert!(after.unlisted < before.unlisted && after.made > before.made, "{before:?} {after:?}");
    let powers = raxel_layouts::lights::LightPowers::of(&materials()).unwrap();
    let bytes = |(pos, chunk): (ChunkPos, &Arc<raxel_world::Chunk>)| {
        let content = Content::of(chunk.clone());
        let lamps = raxel_layouts::lights::TileLights::of(&content, (0, pos), &powers, |face| {
            Arc::new(raxel_world::Side::of(&Content::Empty, face))
        });
        let block = raxel_layouts::TileBlock::of(&content, 0).map_or(0, |block| block.words());
        4 * u64::from(lamps.words() + block)
    };
    let largest = source.chunks().map(bytes).max().unwrap();
    assert!(after.most_written <= UPLOAD + 2 * largest + 2 * directory, "{after:?} {largest} {directory}");
}

/// The chunk that is held back once, who hears that it was asked for, and who says when to go on.
type Hold = (ChunkPos, Sender<()>, Receiver<()>);

/// The content of a chunk when its lamps are looked for, and its content when another chunk is changed meanwhile.
struct Held {
    edited: Edited,
    /// The chunk is given in its state at the time of the request, on a signal of the other side.
    held: Mutex<Option<Hold>>,
}

impl Held {
    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        let content = self.edited.chunk(level, pos);
        let held = self.held.lock().unwrap().take_if(|(of, ..)| level == 0 && *of == pos);
        if let Some((_, asked, go_on)) = held {
            asked.send(()).unwrap();
            go_on.recv_timeout(PATIENCE).unwrap();
        }
        content
    }
}

impl ChunkProvider for Held {
    fn materials(&self) -> &[Material] {
        self.edited.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }
}

#[test]
fn a_second_edit_beside_a_chunk_that_is_being_made_counts_for_its_lamps() {
    let [lit, beside] = [ChunkPos::new(0, 0, 0), ChunkPos::new(1, 0, 0)];
    let one = |x: u32, material: u16| {
        let mut dense = DenseChunk::default();
        dense.set(x, 7, 7, material);
        Content::pack(&dense)
    };
    let world = World::new(materials(), std::iter::empty());
    let chunks = RwLock::new(BTreeMap::from([(lit, one(5, 1))]));
    let source = Arc::new(Held { edited: Edited { world, chunks }, held: Mutex::new(None) });
    let (memory, lamps) = (Words::new(WORDS), Words::new(ROOMY));
    let lamp_memory = Some((lamps.clone() as Arc<dyn PoolMemory>, ROOMY));
    let (view, two) = (View::at(IVec3::ZERO), options(true));
    let streamer = Streamer::with_lamps(source.clone(), (memory, WORDS), lamp_memory, reach(128, 128), view, two);
    streamer.wait(PATIENCE).unwrap();
    let set = |pos: ChunkPos, content: Content| {
        source.edited.chunks.write().unwrap().insert(pos, content);
        streamer.changed(&[pos]);
    };
    let (asked, was_asked) = channel();
    let (go, go_on) = channel();
    *source.held.lock().unwrap() = Some((beside, asked, go_on));
    // A lamp at the border. Whether its face is bare is asked of the chunk beside it, which is air at that moment.
    set(lit, one(63, 2));
    was_asked.recv_timeout(PATIENCE).unwrap();
    set(beside, one(0, 1));
    while !streamer.has_looked() {
        std::thread::sleep(Duration::from_millis(1));
    }
    go.send(()).unwrap();
    streamer.wait(PATIENCE).unwrap();
    let taken = streamer.take().unwrap();
    let faces: BTreeSet<u32> = listed(&lamps, &taken).into_keys().map(|(_, _, face, _)| face).collect();
    assert_eq!(faces, BTreeSet::from([0, 2, 3, 4, 5]), "the stone beside it covers one");
}
