//! The buffer that follows edits, against the buffer of the same world encoded from the beginning.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod scenes;

use raxel_edit::Edits;
use raxel_layouts::{LiveTree64, Patch};
use raxel_oracle::port::Tree64;
use raxel_oracle::{FAR, Oracle, Ray, sets};
use raxel_world::World;
use scenes::{Random, scene, world};

/// Writes patches as a frame does, over words that are poisoned where no patch is due.
fn patch(words: &mut [u32], patches: &[Patch]) -> usize {
    for (i, patch) in patches.iter().enumerate() {
        let range = patch.at..patch.at + patch.words.len();
        for other in &patches[..i] {
            let theirs = other.at..other.at + other.words.len();
            assert!(range.end <= theirs.start || theirs.end <= range.start, "two patches overlap");
        }
        words[range].copy_from_slice(&patch.words);
    }
    patches.iter().map(|patch| patch.words.len()).sum()
}

fn trace(words: &[u32], world: &World, seed: u64) -> usize {
    let oracle = Oracle::new(world);
    let tree = Tree64::new(words);
    let mut hits = 0;
    for set in sets::ALL.iter().filter(|set| !set.is_of_tiles()) {
        for ray in set.rays(world, 150, seed) {
            let ray = Ray { t_max: FAR, ..ray };
            let (found, exact) = (tree.trace(&ray), oracle.first_hit(&ray).hit);
            let found = found.map(|hit| (hit.voxel, hit.face, hit.material as u16));
            assert_eq!(found, exact.map(|hit| (hit.voxel, hit.face, hit.material)), "{} {ray:?}", set.name);
            hits += usize::from(exact.is_some());
        }
    }
    hits
}

#[test]
fn a_buffer_that_follows_edits_is_traced_as_the_world_itself() {
    let (base, scene) = (world(), scene());
    let mut edits = Edits::default();
    let mut current = base.with_chunks(&scene.materials, []);
    let (mut live, mut words) = LiveTree64::new(&current, u64::MAX).unwrap();
    assert_eq!(words.len(), live.capacity());
    let mut random = Random(31);
    let (mut hits, mut written) = (0, 0);
    for round in 0..120 {
        let change = match random.next(5) {
            0 => edits.undo(&base).unwrap().unwrap_or_default(),
            _ => edits.apply(&[random.operation()], &scene, &base).unwrap(),
        };
        current = current.with_chunks(&scene.materials, change.after());
        let patches = live.update(&current, change.after()).expect("it fits");
        written += patch(&mut words, &patches);
        if round % 3 == 0 {
            hits += trace(&words, &current, round);
        }
    }
    assert!(hits > 10_000, "{hits}");
    assert!(written < 120 * words.len() / 4, "{written} words of {} were written", words.len());
}

#[test]
fn what_does_not_fit_is_made_anew() {
    let scene = scene();
    let small = World::from_voxels(scene.materials.clone(), [(glam::IVec3::ZERO, 1)]);
    let far = small.with_chunks(
        &[],
        World::from_voxels(scene.materials.clone(), [(glam::IVec3::splat(5000), 2)])
            .chunks()
            .map(|(pos, chunk)| (pos, Some(chunk.clone()))),
    );
    let (mut live, _) = LiveTree64::new(&small, u64::MAX).unwrap();
    assert_eq!(live.update(&far, far.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone())))), None);
    let (_, words) = LiveTree64::new(&far, u64::MAX).unwrap();
    trace(&words, &far, 1);
    // A buffer that is too small is refused, with both numbers.
    let error = LiveTree64::new(&far, 500).unwrap_err().to_string();
    assert!(error.contains("500 bytes"), "{error}");
    // At the ends of the range of coordinates, and without a voxel.
    for at in [i32::MIN, i32::MAX] {
        let world = World::from_voxels(scene.materials.clone(), [(glam::IVec3::splat(at), 1)]);
        let (_, words) = LiveTree64::new(&world, u64::MAX).unwrap();
        trace(&words, &world, 2);
    }
    let empty = World::empty().with_chunks(&scene.materials, []);
    let (mut live, mut words) = LiveTree64::new(&empty, u64::MAX).unwrap();
    patch(&mut words, &live.update(&small, small.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone())))).unwrap());
    trace(&words, &small, 3);
}
