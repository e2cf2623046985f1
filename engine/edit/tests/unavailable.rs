//! Edits of a world whose chunks are unavailable for a while: an edit does not change unavailable chunks.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::IVec3;
use raxel_edit::query::{cast, collide, histogram, overlaps};
use raxel_edit::{ChunkCache, EditError, EditedChunks, Edits, Operation, Scene, Steps};
use raxel_ray::Ray;
use raxel_world::random::SplitMix64;
use raxel_world::{Bounds, Cause, ChunkPos, ChunkProvider, Content, Material, Unavailable, World};

/// All of one material, when it is there.
struct Failing {
    materials: Vec<Material>,
    there: AtomicBool,
}

fn busy(level: u32, pos: ChunkPos) -> Unavailable {
    Unavailable::new(level, pos, Cause::Failing, "the store is busy")
}

impl ChunkProvider for Failing {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        if self.there.load(Ordering::Relaxed) { Ok(Content::Full(1)) } else { Err(busy(level, pos)) }
    }
}

#[test]
fn what_is_not_there_is_not_changed() {
    let materials = vec![Material::air(), Material::matt("stone", [0.5; 3])];
    let failing = Arc::new(Failing { materials: materials.clone(), there: AtomicBool::new(false) });
    let source = EditedChunks::new(failing.clone(), materials.clone());
    let scene = Scene::new(&materials, &[]);
    let mut edits = Edits::default();
    let hole = [Operation::Set { cell: [3, 70, -5], material: 0 }];
    let refused = edits.apply(&hole, &scene, source.unedited()).unwrap_err();
    assert_eq!(refused, EditError::Unavailable(busy(0, ChunkPos::new(0, 1, -1))));
    assert!(edits.is_empty() && edits.steps() == Steps { undo: 0, redo: 0 });

    failing.there.store(true, Ordering::Relaxed);
    let change = edits.apply(&hole, &scene, source.unedited()).unwrap();
    source.change(&change);
    let pos = ChunkPos::new(0, 1, -1);
    let solids = |content: Content| content.to_chunk().map_or(0, |chunk| chunk.solids());
    assert_eq!(source.try_chunk(0, pos).map(solids), Ok(64 * 64 * 64 - 1));

    // Edited chunks need the store no more; those around them do.
    failing.there.store(false, Ordering::Relaxed);
    assert_eq!(source.try_chunk(0, pos).map(solids), Ok(64 * 64 * 64 - 1));
    let deeper = [Operation::Set { cell: [3, 69, -5], material: 0 }];
    assert_eq!(edits.apply(&deeper, &scene, source.unedited()).unwrap().chunks.len(), 1);
    assert!(
        source.try_chunk(1, ChunkPos::new(0, 0, -1)).is_err() && source.try_chunk(0, ChunkPos::new(1, 1, -1)).is_err()
    );
}

/// A world without some of its chunks.
struct Holes {
    world: World,
    holes: Vec<ChunkPos>,
}

impl ChunkProvider for Holes {
    fn materials(&self) -> &[Material] {
        self.world.materials()
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        let tile = |chunk: ChunkPos| [chunk.x, chunk.y, chunk.z].map(|c| c >> (2 * level));
        if self.holes.iter().any(|hole| tile(*hole) == [pos.x, pos.y, pos.z]) {
            return Err(busy(level, pos));
        }
        Ok(self.world.tile(level, pos))
    }
}

/// An answer is the one of the whole world, or it names a chunk that is a hole. Gives whether it was an answer.
fn judge<T: PartialEq + std::fmt::Debug>(found: Result<T, Unavailable>, whole: &T, holes: &[ChunkPos]) -> bool {
    match found {
        Ok(found) => {
            assert_eq!(&found, whole);
            true
        }
        Err(unavailable) => {
            assert!(unavailable.level == 0 && holes.contains(&unavailable.pos), "{unavailable}");
            assert!(unavailable.to_string().contains("the store is busy"), "{unavailable}");
            false
        }
    }
}

#[test]
fn every_answer_is_exact_or_names_a_chunk_that_is_unavailable() {
    let mut random = SplitMix64::new(22);
    let materials = vec![Material::air(), Material::matt("stone", [0.5; 3]), Material::matt("clay", [0.2; 3])];
    let mut answers = [[0, 0]; 4];
    for _ in 0..5 {
        let mut cell = || IVec3::from_array(std::array::from_fn(|_| random.below(256) as i32 - 128));
        let cells: Vec<(IVec3, u16)> = (0..6000).map(|n| (cell(), 1 + (n & 1))).collect();
        let world = World::from_voxels(materials.clone(), cells);
        let holes: Vec<ChunkPos> = (0..=random.below(4))
            .map(|_| {
                let [x, y, z] = std::array::from_fn(|_| random.below(4) as i32 - 2);
                ChunkPos::new(x, y, z)
            })
            .collect();
        let source = Arc::new(Holes { world: world.clone(), holes: holes.clone() });
        let source = EditedChunks::new(Arc::new(ChunkCache::new(source, 1 << 20)), materials.clone());
        let mut note = |query: usize, answered: bool| answers[query][usize::from(answered)] += 1;
        // Around the holes, too.
        for x in -3..3 {
            for y in -3..3 {
                for z in -3..3 {
                    let pos = ChunkPos::new(x, y, z);
                    let found = raxel_edit::Base::try_chunk(&source, pos);
                    assert_eq!(found.is_err(), holes.contains(&pos), "{pos:?}");
                    judge(found, &world.chunk(pos).cloned(), &holes);
                }
            }
        }
        for _ in 0..100 {
            let cell = std::array::from_fn(|_| random.below(300) as i32 - 150);
            let unit = |random: &mut SplitMix64| random.below(2001) as f32 / 1000.0 - 1.0;
            let ray = Ray::new(cell, [0.5; 3], std::array::from_fn(|_| unit(&mut random)));
            let reach = random.below(400) as f64;
            note(0, judge(cast(&source, &ray, reach), &cast(&world, &ray, reach).unwrap(), &holes));
            let min: [i64; 3] = std::array::from_fn(|_| random.below(70_000) as i64 - 35_000);
            let corners = [min, min.map(|c| c + 2000)];
            let motion = std::array::from_fn(|_| random.below(20_000) as i64 - 10_000);
            note(1, judge(collide(&source, corners, motion), &collide(&world, corners, motion).unwrap(), &holes));
            note(2, judge(overlaps(&source, corners), &overlaps(&world, corners).unwrap(), &holes));
            let min: [i64; 3] = std::array::from_fn(|_| random.below(250) as i64 - 125);
            let bounds = Bounds { min, max: min.map(|c| c + 1 + random.below(40) as i64) };
            let counted = histogram(&source, &bounds).map_err(|error| match error {
                EditError::Unavailable(unavailable) => unavailable,
                error => panic!("{error}"),
            });
            let touches = bounds.chunk_ranges();
            let touches = |hole: &ChunkPos| {
                let at = [hole.x, hole.y, hole.z];
                (0..3).all(|axis| touches[axis].contains(&i64::from(at[axis])))
            };
            assert_eq!(counted.is_err(), holes.iter().any(touches));
            note(3, judge(counted, &histogram(&world, &bounds).unwrap(), &holes));
        }
    }
    // The test would pass with sources that never answer, or have no holes.
    assert!(answers.iter().all(|[refused, answered]| *refused > 10 && *answered > 100), "{answers:?}");
}

#[test]
fn a_hit_in_front_of_an_unavailable_chunk_is_exact() {
    let materials = vec![Material::air(), Material::matt("stone", [0.5; 3])];
    let world = World::from_voxels(materials, [(IVec3::new(60, 5, 5), 1), (IVec3::new(130, 5, 5), 1)]);
    let source = Holes { world, holes: vec![ChunkPos::new(1, 0, 0)] };
    let source = EditedChunks::new(Arc::new(source), vec![Material::air(); 2]);
    let along = |cell, x| Ray::new(cell, [0.5; 3], [x, 0.0, 0.0]);
    let voxel = |ray: &Ray, reach| cast(&source, ray, reach).map(|hit| hit.map(|hit| hit.exact.voxel));
    assert_eq!(voxel(&along([0, 5, 5], 1.0), 1e3), Ok(Some([60, 5, 5])));
    assert_eq!(voxel(&along([61, 5, 5], 1.0), 1e3).unwrap_err().pos, ChunkPos::new(1, 0, 0));
    assert_eq!(voxel(&along([61, 5, 5], 1.0), 2.0), Ok(None), "the ray ends before the chunk");
    assert_eq!(voxel(&along([200, 5, 5], -1.0), 1e3), Ok(Some([130, 5, 5])));
}

#[test]
fn a_step_that_cannot_be_undone_now_can_be_undone_later() {
    let materials = vec![Material::air(), Material::matt("stone", [0.5; 3])];
    let failing = Arc::new(Failing { materials: materials.clone(), there: AtomicBool::new(true) });
    let source = EditedChunks::new(failing.clone(), materials.clone());
    let (scene, mut edits) = (Scene::new(&materials, &[]), Edits::default());
    edits.apply(&[Operation::Set { cell: [3, 70, -5], material: 0 }], &scene, source.unedited()).unwrap();
    failing.there.store(false, Ordering::Relaxed);
    assert!(edits.undo(source.unedited()).is_err() && edits.steps() == Steps { undo: 1, redo: 0 });
    assert!(edits.clear(source.unedited()).is_err() && edits.positions().len() == 1);
    failing.there.store(true, Ordering::Relaxed);
    assert!(edits.undo(source.unedited()).unwrap().is_some() && edits.is_empty());
}
