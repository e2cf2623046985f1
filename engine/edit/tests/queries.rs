//! Queries over an edited world: rays against the exact oracle, boxes and motions against plain loops.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod scenes;

use std::collections::BTreeMap;

use glam::IVec3;
use raxel_edit::query::{cast, collide, histogram, overlaps};
use raxel_edit::{EditError, Edits};
use raxel_oracle::sets;
use raxel_oracle::{Oracle, Ray};
use raxel_world::{AIR, Bounds, World};
use scenes::{Random, scene, world};

fn edited() -> World {
    let (base, scene) = (world(), scene());
    let mut edits = Edits::default();
    let mut random = Random(7);
    for _ in 0..150 {
        edits.apply(&[random.operation()], &scene, &base).unwrap();
    }
    base.with_chunks(&scene.materials, edits.positions().map(|pos| (pos, edits.chunk(pos, &base).unwrap())))
}

#[test]
fn rays_hit_what_the_oracle_says() {
    let world = edited();
    let oracle = Oracle::new(&world);
    let (mut hits, mut misses) = (0, 0);
    for set in sets::ALL {
        for ray in set.rays(&world, 3000, 11) {
            let exact = oracle.first_hit(&ray).hit;
            let found = cast(&world, &ray, 1e5).unwrap();
            // A hit beyond the reach is a miss here, and so is a ray whose origin is far outside.
            let Some(exact) = exact else {
                assert_eq!(found.map(|hit| hit.exact), None, "{} {ray:?}", set.name);
                misses += 1;
                continue;
            };
            if let Some(found) = found {
                assert_eq!(found.exact, exact, "{} {ray:?}", set.name);
            } else {
                let away = (0..3).map(|i| f64::from(exact.voxel[i]) - f64::from(ray.cell[i]));
                let distance = away.map(|d| d * d).sum::<f64>().sqrt();
                assert!(distance > 1e5 - 2.0, "{} {ray:?}: nothing, but {exact:?}", set.name);
                continue;
            }
            hits += 1;
        }
    }
    assert!(hits > 5000 && misses > 300, "{hits} hits, {misses} misses");
}

#[test]
fn a_reach_ends_a_ray_and_the_front_cell_is_empty() {
    let world = World::from_voxels(scenes::materials(), [(IVec3::new(10, 0, 0), 1), (IVec3::new(0, 0, 0), 2)]);
    let ray = Ray::new([1, 0, 0], [0.5; 3], [1.0, 0.0, 0.0]);
    let hit = cast(&world, &ray, 9.0).unwrap().unwrap();
    assert_eq!((hit.exact.voxel, hit.exact.face, hit.front()), ([10, 0, 0], 0, [9, 0, 0]));
    assert!((hit.distance - 8.5).abs() < 1e-9);
    assert_eq!(cast(&world, &ray, 8.4), Ok(None));
    let inside = cast(&world, &Ray::new([0; 3], [0.5; 3], [0.0, 1.0, 0.0]), 1.0).unwrap().unwrap();
    assert_eq!((inside.exact.face, inside.front(), inside.distance), (6, [0; 3], 0.0));
    assert_eq!(cast(&world, &Ray::new([0; 3], [f32::NAN; 3], [0.0, 1.0, 0.0]), 1.0), Ok(None));
    // A ray into nothing ends, also one that never leaves the range of coordinates soon.
    assert_eq!(cast(&world, &Ray::new([0, 5, 0], [0.5; 3], [-1.0, 1e-3, 2e-5]), f64::INFINITY), Ok(None));
}

#[test]
fn boxes_are_counted_and_motions_stop_where_loops_say() {
    let world = edited();
    let mut random = Random(9);
    for _ in 0..40 {
        let min: [i64; 3] = std::array::from_fn(|_| random.next(150) as i64 - 60);
        let max: [i64; 3] = std::array::from_fn(|i| min[i] + 1 + random.next(90) as i64);
        let mut expected = BTreeMap::new();
        for x in min[0]..max[0] {
            for y in min[1]..max[1] {
                for z in min[2]..max[2] {
                    let cell = IVec3::new(x as i32, y as i32, z as i32);
                    *expected.entry(world.voxel(cell)).or_insert(0_u64) += 1;
                }
            }
        }
        assert_eq!(histogram(&world, &Bounds { min, max }).unwrap(), expected);
    }
    let all = Bounds { min: [-(1 << 31); 3], max: [1 << 31; 3] };
    assert!(matches!(histogram(&world, &all), Err(EditError::TooLarge { .. })));

    let solid = |corners: [[i64; 3]; 2]| {
        let cells = |axis: usize| corners[0][axis].div_euclid(256)..(corners[1][axis] + 255).div_euclid(256);
        cells(0)
            .any(|x| cells(1).any(|y| cells(2).any(|z| world.voxel(IVec3::new(x as i32, y as i32, z as i32)) != AIR)))
    };
    let (mut stops, mut free) = (0, 0);
    for _ in 0..4000 {
        let min: [i64; 3] = std::array::from_fn(|_| random.next(140 * 256) as i64 - 50 * 256);
        let max: [i64; 3] = std::array::from_fn(|i| min[i] + 1 + random.next(3 * 256) as i64);
        assert_eq!(overlaps(&world, [min, max]), Ok(solid([min, max])));
        if solid([min, max]) {
            continue;
        }
        let motion: [i64; 3] = std::array::from_fn(|_| random.next(20 * 256) as i64 - 10 * 256);
        let collision = collide(&world, [min, max], motion).unwrap();
        let mut corners = [min, max];
        for axis in [1, 0, 2] {
            let moved = collision.moved[axis];
            assert!(moved.abs() <= motion[axis].abs() && moved * motion[axis] >= 0);
            // It is free all the way, and one step farther it would not be.
            let mut swept = corners;
            swept[usize::from(moved > 0)][axis] += moved;
            assert!(!solid(swept));
            if collision.stopped[axis] {
                swept[usize::from(motion[axis] > 0)][axis] += motion[axis].signum();
                assert!(solid(swept), "{axis} {corners:?} {motion:?} {collision:?}");
                stops += 1;
            } else {
                assert_eq!(moved, motion[axis]);
                free += 1;
            }
            corners.iter_mut().for_each(|corner| corner[axis] += moved);
        }
    }
    assert!(stops > 100 && free > 100, "{stops} {free}");
}
