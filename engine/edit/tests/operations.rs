//! Operations against a plain array of voxels, against a replay from the beginning, and against their own undo.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod scenes;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::IVec3;
use raxel_edit::{Brush, EditError, Edits, MOST_CHUNKS, Operation, Overlay, Scene, Steps};
use raxel_world::{AIR, Bounds, Chunk, ChunkPos, MaterialIndex, Mode, Orientation, Placement, World};
use scenes::{Random, scene, world};

/// The same edits, voxel by voxel, as their documentation reads.
struct Plain {
    base: World,
    scene: Scene,
    voxels: BTreeMap<[i32; 3], MaterialIndex>,
}

impl Plain {
    fn get(&self, cell: [i32; 3]) -> MaterialIndex {
        self.voxels.get(&cell).copied().unwrap_or_else(|| self.base.voxel(IVec3::from_array(cell)))
    }

    fn brush(&mut self, cell: [i32; 3], brush: Brush) {
        match brush {
            Brush::Add(material) => _ = self.voxels.insert(cell, material),
            Brush::Subtract => _ = self.voxels.insert(cell, AIR),
            Brush::Paint(material) if self.get(cell) != AIR => _ = self.voxels.insert(cell, material),
            Brush::Paint(_) => {}
        }
    }

    fn each(bounds: &Bounds, mut each: impl FnMut([i32; 3])) {
        for x in bounds.min[0]..bounds.max[0] {
            for y in bounds.min[1]..bounds.max[1] {
                for z in bounds.min[2]..bounds.max[2] {
                    each([x, y, z].map(|c| c as i32));
                }
            }
        }
    }

    fn apply(&mut self, operation: &Operation) {
        // Distance of a voxel's centre from a position, in 1/256 voxel.
        let away = |cell: i32, from: i64| i128::from(cell) * 256 + 128 - i128::from(from);
        let bounds = operation.bounds(&self.scene).unwrap().unwrap();
        match operation {
            Operation::Set { cell, material } => _ = self.voxels.insert(*cell, *material),
            Operation::Box { brush, .. } => Self::each(&bounds, |cell| self.brush(cell, *brush)),
            Operation::Sphere { center, radius, brush } => Self::each(&bounds, |cell| {
                let d2: i128 = (0..3).map(|i| away(cell[i], center[i]).pow(2)).sum();
                if d2 <= i128::from(*radius).pow(2) {
                    self.brush(cell, *brush);
                }
            }),
            Operation::Cylinder { axis, base, radius, brush, .. } => Self::each(&bounds, |cell| {
                let across = (0..3).filter(|i| *i != usize::from(*axis));
                let d2: i128 = across.map(|i| away(cell[i], base[i]).pow(2)).sum();
                if d2 <= i128::from(*radius).pow(2) {
                    self.brush(cell, *brush);
                }
            }),
            Operation::Model { model, orientation, position, mode } => {
                let model = self.scene.model(model).unwrap().clone();
                let turn = Orientation::from_vox(*orientation).unwrap();
                let placement = Placement { turn, to: position.map(i64::from) };
                for (cell, material) in model.voxels.voxels() {
                    let cell = placement.cell(cell.to_array().map(i64::from)).map(|c| c as i32);
                    let material = model.materials[usize::from(material)];
                    self.brush(
                        cell,
                        match mode {
                            Mode::Add => Brush::Add(material),
                            Mode::Subtract => Brush::Subtract,
                            Mode::Paint => Brush::Paint(material),
                        },
                    );
                }
            }
            Operation::Restore { .. } => Self::each(&bounds, |cell| _ = self.voxels.remove(&cell)),
            Operation::Put { .. } => unreachable!("not made by the generator"),
        }
    }
}

/// Every chunk that differs from the base or was touched, as the edits have it.
fn all(edits: &Edits, base: &World) -> BTreeMap<ChunkPos, Option<Arc<Chunk>>> {
    edits.positions().map(|pos| (pos, edits.chunk(pos, base).unwrap())).collect()
}

#[test]
fn operations_do_what_they_say_voxel_by_voxel() {
    let (base, scene) = (world(), scene());
    let mut plain = Plain { base: base.clone(), scene: scene.clone(), voxels: BTreeMap::new() };
    let mut edits = Edits::default();
    let mut random = Random(1);
    for _ in 0..120 {
        let operation = random.operation();
        plain.apply(&operation);
        edits.apply(&[operation], &scene, &base).unwrap();
    }
    let edited =
        base.with_chunks(&scene.materials, edits.positions().map(|pos| (pos, edits.chunk(pos, &base).unwrap())));
    for (cell, material) in &plain.voxels {
        assert_eq!(edited.voxel(IVec3::from_array(*cell)), *material, "{cell:?}");
    }
    // And nothing else changed.
    let expected: BTreeMap<[i32; 3], MaterialIndex> = (base.voxels())
        .map(|(cell, _)| cell.to_array())
        .chain(plain.voxels.keys().copied())
        .map(|cell| (cell, plain.get(cell)))
        .filter(|(_, material)| *material != AIR)
        .collect();
    let found: BTreeMap<_, _> = edited.voxels().map(|(cell, material)| (cell.to_array(), material)).collect();
    assert!(found == expected);
    // The figures that were kept up to date equal those of a world that is counted from scratch.
    let anew = World::new(scene.materials.clone(), edited.chunks().map(|(pos, chunk)| (pos, chunk.clone())));
    assert_eq!((edited.bounds(), edited.counts()), (anew.bounds(), anew.counts()));
    assert_eq!(edited, anew);
}

#[test]
fn ten_thousand_operations_equal_a_replay_and_undo_gives_the_base_back() {
    let (base, scene) = (world(), scene());
    let mut random = Random(2);
    let operations: Vec<Operation> = (0..10_000).map(|_| random.operation()).collect();
    let mut edits = Edits::default();
    // With steps back and forth, which leave everything as it was.
    for (index, step) in operations.chunks(10).enumerate() {
        edits.apply(step, &scene, &base).unwrap();
        if index % 50 == 0 {
            let before = all(&edits, &base);
            let undone = edits.undo(&base).unwrap().unwrap();
            assert!(!undone.chunks.is_empty());
            let redone = edits.redo(&base).unwrap().unwrap();
            assert_eq!(undone.chunks.len(), redone.chunks.len());
            assert!(all(&edits, &base) == before);
        }
    }
    let mut replay = Edits::default();
    for operations in operations.chunks(97) {
        replay.replay(operations, &scene, &base).unwrap();
    }
    let (ours, theirs) = (all(&edits, &base), all(&replay, &base));
    assert_eq!(ours.len(), theirs.len());
    assert!(ours == theirs);
    assert_eq!((edits.steps(), replay.steps()), (Steps { undo: 1000, redo: 0 }, Steps { undo: 0, redo: 0 }));
    while edits.undo(&base).unwrap().is_some() {}
    assert!(edits.is_empty(), "every chunk is the base's again");
    while edits.redo(&base).unwrap().is_some() {}
    assert!(all(&edits, &base) == theirs);
}

#[test]
fn undo_is_an_operation_too() {
    let (base, scene) = (world(), scene());
    let mut random = Random(3);
    let (mut edits, mut replay) = (Edits::default(), Edits::default());
    for _ in 0..200 {
        let operation = random.operation();
        let change = match random.next(4) {
            0 => edits.undo(&base).unwrap().unwrap_or_default(),
            1 => edits.redo(&base).unwrap().unwrap_or_default(),
            _ => edits.apply(&[operation], &scene, &base).unwrap(),
        };
        replay.replay(&[change.as_put()], &scene, &base).unwrap();
        assert!(all(&edits, &base) == all(&replay, &base));
    }
}

#[test]
fn a_billion_voxels_are_whole_chunks_of_one_content() {
    let (base, scene) = (World::empty(), scene());
    let mut edits = Edits::default();
    let bounds = Bounds { min: [0; 3], max: [1024; 3] };
    let change = edits.apply(&[Operation::Box { bounds, brush: Brush::Add(2) }], &scene, &base).unwrap();
    assert_eq!(change.chunks.len(), 4096);
    let first = change.chunks[0].after.clone().unwrap();
    assert!(change.chunks.iter().all(|chunk| Arc::ptr_eq(chunk.after.as_ref().unwrap(), &first)));
    assert!(edits.history_bytes() < 2 << 20, "{}", edits.history_bytes());
    let change = edits.apply(&[Operation::Box { bounds, brush: Brush::Subtract }], &scene, &base).unwrap();
    assert!(change.chunks.iter().all(|chunk| chunk.after.is_none()));
    assert_eq!(edits.overlay(ChunkPos::new(3, 4, 5)), Ok(Overlay::Edited(None)));
}

#[test]
fn what_cannot_be_done_is_refused_and_changes_nothing() {
    let (base, scene) = (world(), scene());
    let mut edits = Edits::default();
    let around = |min: i64, max: i64| Bounds { min: [min; 3], max: [max; 3] };
    let add = Brush::Add(1);
    let sphere = |radius: f64| Operation::sphere([0.0; 3], radius, add);
    let model = |model: &str, orientation| Operation::Model {
        model: model.to_owned(),
        orientation,
        position: [0; 3],
        mode: Mode::Add,
    };
    // The byte of a mirror image, and of no orientation.
    let mirror = (0..128).find(|byte| Orientation::from_vox(*byte).is_some_and(|o| !o.is_rotation())).unwrap();
    let cases: Vec<(Operation, &str)> = vec![
        (Operation::set([0; 3], 99), "material 99; the world has 8"),
        (Operation::Box { bounds: around(0, 10), brush: Brush::Paint(0) }, "material 0"),
        (Operation::Box { bounds: around(5, 5), brush: add }, "covers nothing"),
        (Operation::Restore { bounds: around(9, 5) }, "covers nothing"),
        (Operation::Box { bounds: around(0, 1 << 40), brush: add }, "voxel coordinates are"),
        (Operation::Box { bounds: around(0, 4096), brush: add }, "reaches over 262144 chunks"),
        (
            Operation::Box { bounds: around(-(1 << 31), 1 << 31), brush: Brush::Subtract },
            "one edit may reach over 32768",
        ),
        (sphere(5000.0), "radius of 5000 voxels; 4096"),
        (sphere(f64::INFINITY), "4096 is the largest"),
        (sphere(0.0), "radius is 0"),
        (sphere(f64::NAN), "radius is 0"),
        (Operation::sphere([f64::MAX, 0.0, 0.0], 1.0, add), "voxel coordinates are"),
        (Operation::sphere([2_147_483_640.0, 0.0, 0.0], 20.0, add), "voxel coordinates are"),
        (Operation::Cylinder { axis: 3, base: [0; 3], radius: 256, height: 1, brush: add }, "no axis 3"),
        (Operation::Cylinder { axis: 1, base: [0; 3], radius: 256, height: 0, brush: add }, "height is 0"),
        (Operation::Cylinder { axis: 1, base: [0; 3], radius: 256, height: u32::MAX, brush: add }, "voxel coordinates"),
        (model("tower", 4), "no model of that name"),
        (model("post", mirror), "24 rotations"),
        (model("post", 255), "24 rotations"),
    ];
    for (operation, expected) in cases {
        let error = edits.apply(&[Operation::set([1; 3], 1), operation.clone()], &scene, &base).unwrap_err();
        assert!(error.to_string().contains(expected), "{operation:?}: {error}");
        assert!(edits.is_empty() && edits.steps() == Steps { undo: 0, redo: 0 });
    }
    // Many at once count together.
    let half =
        Operation::Box { bounds: Bounds { min: [0; 3], max: [64, 64, 64 * MOST_CHUNKS as i64 / 2 + 1] }, brush: add };
    let error = edits.apply(&[half.clone(), half], &scene, &base).unwrap_err();
    assert!(matches!(error, EditError::TooLarge { .. }));
    // At the very ends of the range everything works.
    for at in [i32::MIN, i32::MAX] {
        edits.apply(&[Operation::set([at; 3], 1)], &scene, &base).unwrap();
        edits
            .apply(&[Operation::Box { bounds: around(i64::from(at), i64::from(at) + 1), brush: add }], &scene, &base)
            .unwrap();
        assert_eq!(edits.chunk(ChunkPos::of_cell(IVec3::splat(at)), &base).unwrap().unwrap().solids(), 1);
    }
}

/// Four chunks of noise in three materials.
fn noise(scene: &Scene) -> World {
    let dense = |n: u64| 1 + (raxel_world::random::mix(n) % 3) as u16;
    let cells = (0..4 << 18).map(|n: i32| IVec3::new(n & 63, n >> 6 & 63, n >> 12));
    World::from_voxels(
        scene.materials.clone(),
        cells.map(|cell| (cell, dense(cell.as_u64vec3().dot([1, 64, 4096].into())))),
    )
}

/// Undoes all steps and makes them again, through the states that they left.
fn back_and_forth(edits: &mut Edits, states: &[BTreeMap<ChunkPos, Option<Arc<Chunk>>>], base: &World) {
    for state in states.iter().rev().skip(1) {
        assert!(edits.undo(base).unwrap().is_some() && all(edits, base) == *state);
    }
    assert!(edits.undo(base).unwrap().is_none() && edits.is_empty());
    for state in &states[1..] {
        assert!(edits.redo(base).unwrap().is_some() && all(edits, base) == *state);
    }
}

#[test]
fn steps_that_were_packed_are_undone_and_made_again() {
    let scene = scene();
    let base = noise(&scene);
    let mut edits = Edits::default();
    let mut states = vec![all(&edits, &base)];
    // Each takes 2 MiB until it is packed.
    for step in 0..48 {
        let corner = |chunk: i64| [step, 7, 64 * chunk + 9];
        let cut = |chunk: i64| Operation::Box {
            bounds: Bounds { min: corner(chunk), max: corner(chunk).map(|c| c + 1) },
            brush: Brush::Subtract,
        };
        edits.apply(&(0..4).map(cut).collect::<Vec<_>>(), &scene, &base).unwrap();
        states.push(all(&edits, &base));
    }
    assert!(edits.history_bytes() > 32 << 20, "they are kept as whole chunks");
    assert!(edits.history_bytes() < 90 << 20, "{}", edits.history_bytes());
    back_and_forth(&mut edits, &states, &base);
}

#[test]
fn steps_of_single_voxels_take_few_bytes_and_are_undone_and_made_again() {
    let scene = scene();
    let base = noise(&scene);
    let mut edits = Edits::default();
    let mut states = vec![all(&edits, &base)];
    // Voxels of noise and of air around it, some set twice in a step, between them a few whole boxes.
    for step in 0..48i32 {
        let set = |n: i32| Operation::Set {
            cell: [(11 * n + step / 2) & 63, (7 * n) & 63, 97 * n - 64],
            material: if (n + step) % 3 == 0 { AIR } else { 1 + ((n + step) % 4) as MaterialIndex },
        };
        let sets: Vec<Operation> = (0..9).chain(3..6).map(set).collect();
        let cut =
            Operation::Box { bounds: Bounds { min: [0; 3], max: [5; 3] }, brush: Brush::Add(1 + step as u16 / 12) };
        let operations = if step % 12 == 11 { vec![cut] } else { sets };
        edits.apply(&operations, &scene, &base).unwrap();
        states.push(all(&edits, &base));
    }
    // The boxes are kept as whole chunks, twice 300 kB each at most.
    assert!(edits.history_bytes() < 4 * 700_000, "{}", edits.history_bytes());
    back_and_forth(&mut edits, &states, &base);
    // A step that was undone and then edited over is gone.
    assert!(edits.undo(&base).unwrap().is_some());
    edits.apply(&[Operation::set([1, 2, 3], 2)], &scene, &base).unwrap();
    assert!(edits.redo(&base).unwrap().is_none() && edits.undo(&base).unwrap().is_some());
    assert!(all(&edits, &base) == states[47]);
}
