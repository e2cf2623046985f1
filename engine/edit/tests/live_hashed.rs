//! Chunks in a hash table that follow edits in place, against those of the same world encoded from the beginning: the same nodes.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod scenes;

use std::collections::{BTreeMap, BTreeSet};

use raxel_edit::Edits;
use raxel_layouts::{HashedChunksHeader, Layout, LiveLayout, Patch};
use raxel_world::World;
use scenes::{Random, scene, world};

/// Level of a chunk of 32³ voxels in the table.
const CHUNK_LEVEL: u32 = 5;

/// The addresses of chunks, by their corner in the world, and the larger cubes of the table.
fn read(words: &[u32]) -> (HashedChunksHeader, BTreeMap<[i32; 3], usize>, BTreeSet<[u32; 4]>) {
    let base = HashedChunksHeader::WORDS as usize;
    let header: HashedChunksHeader = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[..base]));
    let (mut chunks, mut cubes) = (BTreeMap::new(), BTreeSet::new());
    let slots = words[base + header.table_at as usize..].chunks_exact(4).take(1 << header.log2_slots);
    for slot in slots.filter(|slot| slot[3] != u32::MAX) {
        let (level, x) = (slot[0] >> 27, slot[0] & 0x7ff_ffff);
        if level == CHUNK_LEVEL {
            let corner = std::array::from_fn(|i| header.origin[i] + 32 * [x, slot[1], slot[2]][i] as i32);
            assert_eq!(chunks.insert(corner, base + slot[3] as usize), None, "twice in the table: {corner:?}");
        } else {
            cubes.insert([level, x, slot[1], slot[2]]);
        }
    }
    (header, chunks, cubes)
}

/// Writes patches as a frame does. No two may overlap. Returns the number of words.
fn patch(words: &mut [u32], patches: &[Patch]) -> usize {
    let mut ranges: Vec<_> = patches.iter().map(|patch| (patch.at, patch.at + patch.words.len())).collect();
    ranges.sort_unstable();
    assert!(ranges.windows(2).all(|pair| pair[0].1 <= pair[1].0), "two patches overlap");
    for patch in patches {
        words[patch.at..patch.at + patch.words.len()].copy_from_slice(&patch.words);
    }
    patches.iter().map(|patch| patch.words.len()).sum()
}

/// Every chunk of the buffer has the words that a fresh encoding has for it.
fn compare(layout: Layout, words: &[u32], world: &World) {
    let fresh = layout.encode(world, u64::MAX).unwrap().words;
    let (header, chunks, cubes) = read(words);
    let (expected, fresh_chunks, _) = read(&fresh);
    assert_eq!((header.bounds_min, header.bounds_last), (expected.bounds_min, expected.bounds_last));
    assert_eq!(chunks.keys().collect::<Vec<_>>(), fresh_chunks.keys().collect::<Vec<_>>());
    let size = (fresh.len() - HashedChunksHeader::WORDS as usize - expected.chunks_at as usize)
        / (expected.chunk_count as usize).max(1);
    for (corner, at) in &chunks {
        let theirs = &fresh[fresh_chunks[corner]..][..size];
        let wrong = words[*at..][..size].iter().zip(theirs).position(|(a, b)| a != b);
        assert_eq!(wrong, None, "{layout:?} {corner:?}");
    }
    // The larger cubes are those that have a chunk.
    let mut around = BTreeSet::new();
    for corner in chunks.keys() {
        for level in (CHUNK_LEVEL + 3..header.log2_size).step_by(3) {
            let cube: [u32; 3] = std::array::from_fn(|i| (corner[i] - header.origin[i]) as u32 >> level);
            around.insert([level, cube[0], cube[1], cube[2]]);
        }
    }
    assert_eq!(cubes, around);
}

#[test]
fn after_thousands_of_edits_every_node_is_what_a_fresh_encoding_has() {
    for layout in [Layout::OCTREE, raxel_rivals::CHUNK_TABLE] {
        let (base, scene) = (world(), scene());
        let mut edits = Edits::default();
        let mut current = base.with_chunks(&scene.materials, []);
        let (mut live, mut words) = LiveLayout::new(layout, &current, u64::MAX).unwrap();
        compare(layout, &words, &current);
        let mut random = Random(77);
        let (mut written, mut anew) = (0, 0);
        for round in 1..=2000 {
            let change = match random.next(5) {
                0 => edits.undo(&base).unwrap().unwrap_or_default(),
                _ => edits.apply(&[random.operation()], &scene, &base).unwrap(),
            };
            current = current.with_chunks(&scene.materials, change.after());
            if let Some(patches) = live.update(&current, change.after()) {
                written += patch(&mut words, &patches);
            } else {
                anew += 1;
                (live, words) = LiveLayout::new(layout, &current, u64::MAX).unwrap();
            }
            if round % 100 == 0 {
                compare(layout, &words, &current);
            }
        }
        assert!(anew < 20, "{layout:?} was made anew {anew} times");
        assert!(written < 2000 * words.len() / 20, "{written} words of {} were written", words.len());
    }
}

#[test]
fn one_voxel_writes_one_node_a_depth_and_its_block() {
    let scene = scene();
    let current = world().with_chunks(&scene.materials, []);
    let (mut live, mut words) = LiveLayout::new(Layout::OCTREE, &current, u64::MAX).unwrap();
    let mut edits = Edits::default();
    let set = |material| raxel_edit::Operation::Set { cell: [5, 3, 5], material };
    let mut world = current.clone();
    for material in [3, 0, 2, 0] {
        let change = edits.apply(&[set(material)], &scene, &current).unwrap();
        world = world.with_chunks(&scene.materials, change.after());
        let patches = live.update(&world, change.after()).unwrap();
        // 64 voxels and eight nodes of 2³ in the block, the block, three nodes above it; and the header.
        assert!(patch(&mut words, &patches) <= 64 + 8 + 1 + 3 + HashedChunksHeader::WORDS as usize);
        compare(Layout::OCTREE, &words, &world);
    }
}

#[test]
fn what_does_not_fit_is_made_anew() {
    let scene = scene();
    let small = World::from_voxels(scene.materials.clone(), [(glam::IVec3::ZERO, 1)]);
    let far = World::from_voxels(scene.materials.clone(), [(glam::IVec3::splat(5000), 2)]);
    let both = small.with_chunks(&[], far.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))));
    let (mut live, _) = LiveLayout::new(Layout::OCTREE, &small, u64::MAX).unwrap();
    assert_eq!(live.update(&both, far.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone())))), None);
    // Without room for a second chunk.
    let tight = 4 * (u64::from(HashedChunksHeader::WORDS) + 8 * 6 + 4 * 2048 + 37449 + 100);
    let (mut live, _) = LiveLayout::new(Layout::OCTREE, &small, tight).unwrap();
    let beside = World::from_voxels(scene.materials.clone(), [(glam::IVec3::ZERO, 1), (glam::IVec3::splat(40), 2)]);
    assert_eq!(live.update(&beside, beside.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone())))), None);
    let error = LiveLayout::new(Layout::OCTREE, &small, 500).unwrap_err().to_string();
    assert!(error.contains("500 bytes"), "{error}");
    // At the ends of the range of coordinates, and from a world without a voxel.
    for at in [i32::MIN, i32::MAX] {
        let world = World::from_voxels(scene.materials.clone(), [(glam::IVec3::splat(at), 1)]);
        let (_, words) = LiveLayout::new(Layout::OCTREE, &world, u64::MAX).unwrap();
        compare(Layout::OCTREE, &words, &world);
    }
    let empty = World::empty().with_chunks(&scene.materials, []);
    let (mut live, mut words) = LiveLayout::new(Layout::OCTREE, &empty, u64::MAX).unwrap();
    patch(&mut words, &live.update(&small, small.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone())))).unwrap());
    compare(Layout::OCTREE, &words, &small);
    let gone = small.with_chunks(&[], small.chunks().map(|(pos, _)| (pos, None)));
    patch(&mut words, &live.update(&gone, small.chunks().map(|(pos, _)| (pos, None))).unwrap());
    assert!(read(&words).1.is_empty() && read(&words).2.is_empty());
}
