//! Buffers that follow edits, read by their formats alone, hold the voxels of the world that was edited.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::IVec3;
use raxel_layouts::{Layout, LayoutError, LiveLayout};
use raxel_world::random::SplitMix64;
use raxel_world::{Chunk, ChunkPos, DenseChunk, World};

use crate::decode::{self, Voxels};
use crate::palette;

const FOLLOWING: [Layout; 3] = [Layout::TREE64, Layout::OCTREE, raxel_rivals::CHUNK_TABLE];

/// Materials of all worlds here.
const MATERIALS: u64 = 40;

/// Words of the header that all layouts begin with.
const COMMON: usize = 12;

type Change = (ChunkPos, Option<Arc<Chunk>>);

/// A world that is edited, and a buffer that follows.
struct Followed {
    layout: Layout,
    world: World,
    live: LiveLayout,
    words: Vec<u32>,
}

impl Followed {
    fn new(layout: Layout, world: World, limit: u64) -> Result<Self, LayoutError> {
        let (live, words) = LiveLayout::new(layout, &world, limit)?;
        assert!(4 * words.len() as u64 <= limit, "{layout:?}: {} words for {limit} bytes", words.len());
        let followed = Self { layout, world, live, words };
        followed.check();
        Ok(followed)
    }

    /// Gives the words that were written behind the header; `None` if the world no longer fits.
    fn follow(&mut self, changes: &[Change]) -> Option<usize> {
        let written = self.write(changes)?;
        self.check();
        Some(written)
    }

    fn write(&mut self, changes: &[Change]) -> Option<usize> {
        self.world = self.world.with_chunks(&[], changes.iter().cloned());
        let patches = self.live.update(&self.world, changes.iter().cloned())?;
        let mut ranges: Vec<_> = patches.iter().map(|patch| (patch.at, patch.at + patch.words.len())).collect();
        ranges.sort_unstable();
        assert!(ranges.windows(2).all(|pair| pair[0].1 <= pair[1].0), "{:?}: patches overlap", self.layout);
        for patch in &patches {
            self.words[patch.at..][..patch.words.len()].copy_from_slice(&patch.words);
        }
        Some(patches.iter().filter(|patch| patch.at > 0).map(|patch| patch.words.len()).sum())
    }

    fn check(&self) {
        let (layout, words, world) = (self.layout, &self.words, &self.world);
        // Cubes begin at a chunk, and have whole levels of a tree of 4³.
        assert!(words[..3].iter().all(|origin| origin % 64 == 0) && words[3] % 2 == 0 && words[3] >= 6, "{layout:?}");
        let found = match layout.name() {
            "tree64" => decode::tree64(words),
            "octree" => decode::octree(words),
            _ => decode::chunk_table(words),
        };
        let voxels: Voxels = world.voxels().map(|(cell, material)| (cell.to_array(), material)).collect();
        assert!(found == voxels, "{layout:?}: other voxels");
        let fresh = layout.encode(world, u64::MAX).expect("it fits").words;
        assert_eq!(words[4..COMMON], fresh[4..COMMON], "{layout:?}: bounds and materials");
        if layout == Layout::TREE64 {
            let nodes = |words: &[u32]| words[COMMON + 1] - nodes_above(world, words);
            assert_eq!((nodes(words), words[COMMON + 2]), (nodes(&fresh), fresh[COMMON + 2]), "nodes and leaves");
        } else {
            assert_eq!(words[COMMON + 3], fresh[COMMON + 3], "{layout:?}: different chunks");
        }
    }

    fn positions(&self) -> Vec<ChunkPos> {
        self.world.chunks().map(|(pos, _)| pos).collect()
    }

    /// The smallest corner of the cube, and its edge.
    fn cube(&self) -> ([i64; 3], i64) {
        ([0, 1, 2].map(|i| i64::from(self.words[i].cast_signed())), 1 << self.words[3])
    }
}

/// Nodes from the root down to the chunks in the cube of a header.
fn nodes_above(world: &World, words: &[u32]) -> u32 {
    let of_level = |level: u32| {
        let cell = |pos: ChunkPos| {
            let corner = pos.origin().to_array();
            [0, 1, 2].map(|i| (i64::from(corner[i]) - i64::from(words[i].cast_signed())) >> level)
        };
        world.chunks().map(|(pos, _)| cell(pos)).collect::<BTreeSet<_>>().len() as u32
    };
    (6..=words[3]).step_by(2).map(of_level).sum::<u32>().max(1)
}

/// A coordinate in a chunk: half of them at borders of chunks and of what layouts divide chunks into.
fn coordinate(random: &mut SplitMix64) -> u32 {
    const BORDERS: [u32; 8] = [0, 3, 4, 15, 16, 31, 32, 63];
    if random.below(2) == 0 { BORDERS[random.index(8)] } else { random.below(64) as u32 }
}

/// Some voxels, or a box of them, of some materials or none.
fn edited(random: &mut SplitMix64, chunk: Option<&Arc<Chunk>>) -> Option<Arc<Chunk>> {
    let mut dense = DenseChunk::default();
    chunk.iter().for_each(|chunk| dense.unpack(chunk));
    let solid = random.below(3) > 0;
    let material = |random: &mut SplitMix64| if solid { 1 + random.below(MATERIALS) as u16 } else { 0 };
    if random.below(3) > 0 {
        for _ in 0..=random.below(3) {
            let [x, y, z] = [0; 3].map(|_| coordinate(random));
            dense.set(x, y, z, material(random));
        }
    } else {
        // At corners of blocks of 4³ as often as not: full blocks, and full nodes where the box is large.
        let mask = if random.below(2) == 0 { !3 } else { !0 };
        let low = [0; 3].map(|_| coordinate(random) & mask);
        let most = if random.below(8) == 0 { 30 } else { 9 };
        let size = [0; 3].map(|_| (4 + random.below(most) as u32) & mask);
        let (one, mixed) = (material(random), random.below(2) == 0);
        let end = |i: usize| (low[i] + size[i]).min(64);
        for (x, y) in (low[0]..end(0)).flat_map(|x| (low[1]..end(1)).map(move |y| (x, y))) {
            for z in low[2]..end(2) {
                dense.set(x, y, z, if mixed { material(random) } else { one });
            }
        }
    }
    Chunk::pack(&dense).map(Arc::new)
}

/// One of few places, so that what stands there is edited again.
fn place(random: &mut SplitMix64) -> ChunkPos {
    ChunkPos::new(random.below(3) as i32 - 1, 0, random.below(2) as i32 - 1)
}

/// The changes of an update: several chunks, some of them twice. They are edited, copied, moved, emptied, or changed into themselves.
fn changes(random: &mut SplitMix64, world: &World) -> Vec<Change> {
    let mut changes: Vec<Change> = Vec::new();
    for _ in 0..=random.below(3) {
        let (pos, other) = (place(random), place(random));
        let latest = |of: ChunkPos| {
            let changed = changes.iter().rev().find(|(pos, _)| *pos == of).map(|(_, chunk)| chunk.clone());
            changed.unwrap_or_else(|| world.chunk(of).cloned())
        };
        let (here, there) = (latest(pos), latest(other));
        match random.below(12) {
            0 => changes.extend([(pos, there), (other, here)]),
            1 => changes.extend([(other, here), (pos, None)]),
            2 => changes.push((pos, there)),
            3 => changes.push((pos, None)),
            4 => changes.push((pos, here)),
            _ => changes.push((pos, edited(random, here.as_ref()))),
        }
    }
    changes
}

#[test]
fn a_buffer_holds_the_voxels_of_the_world_after_every_edit() {
    for (seed, layout) in (5..).zip(FOLLOWING) {
        let mut random = SplitMix64::new(seed);
        let empty = World::from_voxels(palette(MATERIALS as usize), []);
        let mut followed = Followed::new(layout, empty, u64::MAX).expect("it fits");
        for round in 0..75 {
            let mut all = changes(&mut random, &followed.world);
            if round % 25 == 24 {
                // A chunk without a gap, then nothing at all.
                all.push((place(&mut random), Some(Arc::new(Chunk::full(7)))));
                followed.follow(&all).expect("it fits");
                all = followed.positions().into_iter().map(|pos| (pos, None)).collect();
            }
            followed.follow(&all).expect("it fits");
        }
    }
}

/// A world with another palette is encoded again. An update without changes writes no voxel.
#[test]
fn a_change_that_changes_nothing_writes_no_voxel() {
    for layout in FOLLOWING {
        let mut random = SplitMix64::new(11);
        let world = row(&mut random, 3);
        let mut followed = Followed::new(layout, world, u64::MAX).expect("it fits");
        let same: Vec<Change> = followed.world.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))).collect();
        // `tree64` writes the nodes above all chunks with every edit.
        let above =
            if layout == Layout::TREE64 { 4 * nodes_above(&followed.world, &followed.words) as usize } else { 0 };
        assert_eq!(followed.follow(&same), Some(above), "{layout:?}");
        assert_eq!(followed.follow(&[(ChunkPos::new(9, 0, 0), None)]), Some(above), "{layout:?}");
        let more = World::from_shared(palette(MATERIALS as usize + 1), BTreeMap::new());
        assert_eq!(followed.live.update(&more, []), None, "{layout:?}");
    }
}

/// Edits within 256 voxels of the world fit, and everything in the cube of the header; nothing else does.
#[test]
fn a_buffer_follows_edits_around_the_world_as_far_as_its_cube_reaches() {
    let one = |cell| {
        let world = World::from_voxels(palette(MATERIALS as usize), [(cell, 1)]);
        world.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))).next().expect("a voxel")
    };
    let corners = [[0, 0, 0], [-70, 500, 63], [i32::MIN, i32::MAX - 300, 5], [i32::MAX - 200, i32::MIN + 300, -1]];
    // With the second the span is 1024 exactly, from the first corner.
    let sizes = [[0; 3], [0, 511, 0], [190, 0, 0], [0, 0, 700], [500; 3]];
    for layout in FOLLOWING {
        for (corner, size) in corners.into_iter().flat_map(|corner| sizes.map(|size| (corner, size))) {
            let far: [i32; 3] = std::array::from_fn(|i| i32::saturating_add(corner[i], size[i]));
            let voxels = [corner, far].map(|cell| (IVec3::from_array(cell), 2));
            let world = World::from_voxels(palette(MATERIALS as usize), voxels);
            let new = || Followed::new(layout, world.clone(), u64::MAX).expect("it fits");
            let (origin, edge) = new().cube();
            let span = (0..3)
                .map(|i| i64::from(far[i]) + 257 - ((i64::from(corner[i]) - 256).max(i64::from(i32::MIN)) & !63))
                .max();
            let span = span.expect("three axes");
            assert!(span <= edge && (edge == 64 || edge / 4 < span), "{layout:?}: {edge} for {span}");
            for axis in 0..3 {
                assert!(origin[axis] + edge <= 1 << 31, "{origin:?}");
                // The farthest cells that must fit, the last that do, and the first that do not.
                let (first, last) = (origin[axis], origin[axis] + edge - 1);
                let low = (i64::from(corner[axis]) - 256).max(i64::from(i32::MIN));
                let high = (i64::from(far[axis]) + 256).min(i64::from(i32::MAX));
                for (at, fits) in
                    [(low, true), (high, true), (first, true), (last, true), (first - 1, false), (last + 1, false)]
                {
                    let Ok(at) = i32::try_from(at) else { continue };
                    let mut cell = IVec3::from_array(corner);
                    cell[axis] = at;
                    let mut followed = new();
                    assert_eq!(followed.follow(&[one(cell)]).is_some(), fits, "{layout:?} {corner:?}: {cell}");
                    assert!(new().follow(&[(one(cell).0, None)]).is_some(), "{layout:?}: nothing at {cell}");
                }
            }
        }
    }
}

/// So wide that no cube holds it with a margin, and one too wide for any.
#[test]
fn a_world_that_fills_its_cube_is_encoded_without_a_margin() {
    for layout in FOLLOWING {
        let wide = |low: i32, high: i32| {
            let voxels = [(IVec3::splat(low), 1), (IVec3::splat(high), 2)];
            LiveLayout::new(layout, &World::from_voxels(palette(2), voxels), u64::MAX)
        };
        let (_, words) = wide(-(1 << 29), (1 << 29) - 1).expect("it fits");
        assert_eq!([words[0].cast_signed(), words[1].cast_signed()], [-(1 << 29); 2], "{layout:?}");
        assert_eq!(words[3], 30, "{layout:?}");
        assert!(matches!(wide(-(1 << 29) - 1, 1 << 29), Err(LayoutError::TooWide { limit: 0x4000_0000, .. })));
    }
}

/// Bytes of the smallest buffer that is taken.
fn least(layout: Layout, world: &World) -> u64 {
    match LiveLayout::new(layout, world, 0).map(|_| ()) {
        Err(LayoutError::TooLarge { bytes, limit: 0, .. }) => bytes,
        other => panic!("{layout:?} in no bytes: {other:?}"),
    }
}

/// Bytes of a 32³ chunk in a hash table.
fn bytes_of_block(layout: Layout) -> u64 {
    if layout == Layout::OCTREE { 4 * 37_449 } else { 4 * 16_400 }
}

/// A chunk of random voxels, as many in each of its eighths.
fn scattered(random: &mut SplitMix64) -> Arc<Chunk> {
    let mut dense = DenseChunk::default();
    for i in 0..160_u32 {
        let eighth = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| 32 * bit);
        let [x, y, z] = eighth.map(|corner| corner + random.below(32) as u32);
        dense.set(x, y, z, 1 + random.below(MATERIALS) as u16);
    }
    Arc::new(Chunk::pack(&dense).expect("voxels"))
}

fn row(random: &mut SplitMix64, chunks: i32) -> World {
    let chunks = (0..chunks).map(|x| (ChunkPos::new(x, 0, 0), scattered(random)));
    World::new(palette(MATERIALS as usize), chunks.collect::<Vec<_>>())
}

/// A buffer with little room to spare takes any number of edits if each leaves the world as large as it was.
#[test]
fn what_edits_free_is_used_again() {
    for layout in FOLLOWING {
        let mut random = SplitMix64::new(3);
        let world = row(&mut random, 5);
        // As much as one chunk takes, and some more for `tree64`, whose blocks leave gaps.
        let room = if layout == Layout::TREE64 { 32_000 } else { 8 * bytes_of_block(layout) };
        let limit = least(layout, &world) + room;
        let mut followed = Followed::new(layout, world, limit).expect("it fits");
        for round in 0..120 {
            let pos = ChunkPos::new(random.below(5) as i32, 0, 0);
            // Emptied and filled again, replaced as a whole, or by the chunk beside it.
            if round % 3 == 0 {
                followed.write(&[(pos, None)]).expect("it fits");
            }
            let beside = followed.world.chunk(ChunkPos::new(4 - pos.x, 0, 0)).cloned();
            let next = if round % 5 == 0 { beside } else { None };
            let next = next.unwrap_or_else(|| scattered(&mut random));
            followed.write(&[(pos, Some(next))]).unwrap_or_else(|| panic!("{layout:?}: no room in round {round}"));
        }
        followed.check();
    }
}

/// The nodes above all chunks move when they need more room, and give up the room that they had.
#[test]
fn nodes_above_all_chunks_grow_and_give_up_what_they_had() {
    let mut random = SplitMix64::new(8);
    let world = row(&mut random, 1);
    let chunk = world.chunks().next().expect("one").1.clone();
    let limit = least(Layout::TREE64, &world) + 16 * 1_800;
    let mut followed = Followed::new(Layout::TREE64, world, limit).expect("it fits");
    let places: Vec<ChunkPos> = (0..800).map(|i| ChunkPos::new(i % 10, i / 10 % 10, i / 100)).collect();
    for some in places.chunks(40) {
        followed.write(&some.iter().map(|pos| (*pos, Some(chunk.clone()))).collect::<Vec<_>>()).expect("it fits");
    }
    followed.check();
    followed.follow(&places.iter().skip(3).map(|pos| (*pos, None)).collect::<Vec<_>>()).expect("it fits");
}

/// Besides its world, a buffer has the room that its limit leaves, up to a quarter of the world and some more.
#[test]
fn a_buffer_has_the_room_that_its_limit_leaves() {
    for layout in [Layout::OCTREE, raxel_rivals::CHUNK_TABLE] {
        let mut random = SplitMix64::new(21);
        let world = row(&mut random, 4);
        let (least, block) = (least(layout, &world), bytes_of_block(layout));
        let error = LiveLayout::new(layout, &world, least - 1).expect_err("one byte less");
        assert_eq!(error, LayoutError::TooLarge { layout: layout.name(), bytes: least, limit: least - 1 });
        // Bytes that the limit leaves, and how many blocks more there are: 64 and a quarter of 32 at most.
        for (spare, blocks) in [(0, 0), (block - 1, 0), (block, 1), (10 * block, 10), (200 * block, 72)] {
            let mut followed = Followed::new(layout, world.clone(), least + spare).expect("it fits");
            assert_eq!(4 * followed.words.len() as u64, least + blocks * block, "{layout:?}");
            let one_voxel = |i: i32| {
                let cell = IVec3::new(64 * (i % 4) + i % 32, 64 * (1 + i / 4 % 4), 64 * (i / 16));
                let world = World::from_voxels(palette(1), [(cell, 1)]);
                world.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))).collect::<Vec<Change>>()
            };
            let taken = (0..80).take_while(|i| followed.write(&one_voxel(*i)).is_some()).count() as u64;
            assert_eq!(taken, blocks, "{layout:?}: {spare} bytes to spare");
        }
    }
}

/// If a tree does not fit, the error has the number of bytes that are enough. A tree without a limit has room for a quarter more and 4 MiB.
#[test]
fn a_tree_says_how_much_it_needs() {
    let mut random = SplitMix64::new(34);
    let far = |random: &mut SplitMix64| ChunkPos::new(random.below(9_000) as i32, random.below(9_000) as i32, 0);
    let scattered_far: Vec<_> = (0..60).map(|_| (far(&mut random), scattered(&mut random))).collect();
    let worlds = [row(&mut random, 1), row(&mut random, 40), World::new(palette(MATERIALS as usize), scattered_far)];
    for world in worlds {
        let mut limit = least(Layout::TREE64, &world);
        assert!(LiveLayout::new(Layout::TREE64, &world, limit - 1).is_err());
        let mut refused = 0;
        let followed = loop {
            match Followed::new(Layout::TREE64, world.clone(), limit) {
                Ok(followed) => break followed,
                Err(LayoutError::TooLarge { bytes, limit: of, .. }) => {
                    assert!(bytes > limit && of == limit, "{bytes} bytes do not fit into {limit}");
                    limit = bytes;
                    refused += 1;
                }
                Err(error) => panic!("{error}"),
            }
        };
        assert!(refused < 2, "a buffer of as many bytes as were asked for is refused");
        let fresh = 4 * Layout::TREE64.encode(&world, u64::MAX).expect("it fits").words.len() as u64;
        let (_, words) = LiveLayout::new(Layout::TREE64, &world, u64::MAX).expect("it fits");
        let room = 4 * words.len() as u64 - fresh;
        assert!((4 << 20..=(4 << 20) + fresh / 2 + 4096).contains(&room), "{room} bytes of room for {fresh}");
        assert!(room > (4 << 20) + fresh / 8, "{room} bytes of room for {fresh}");
        drop(followed);
    }
}
