//! The prepared exact tracer against the one in fractions, and against brute force.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod brute;

use brute::Verdict;
use glam::IVec3;
use proptest::prelude::*;
use raxel_oracle::sets::{self, RaySet};
use raxel_oracle::{Oracle, exact, scenes};
use raxel_world::World;

fn agree(world: &World, rays: usize, seed: u64) -> (usize, usize) {
    let oracle = Oracle::new(world);
    let (mut hits, mut ties) = (0, 0);
    for set in sets::ALL {
        for ray in set.rays(world, rays, seed) {
            let (fast, slow) = (oracle.first_hit(&ray), exact::first_hit(world, &ray));
            assert_eq!(fast, slow, "{} {ray:?}", set.name);
            hits += usize::from(fast.hit.is_some());
            ties += usize::from(fast.tie);
        }
    }
    (hits, ties)
}

#[test]
fn both_exact_tracers_agree_on_every_scene_near_and_far() {
    for scene in scenes::ALL {
        for corner in [IVec3::new(-13, 5, -40), IVec3::new(i32::MIN, 1 << 30, i32::MAX - 600)] {
            let (hits, ties) = agree(&scene.world(corner, 7), 300, 5);
            assert!(ties > 50 && (hits > 200 || scene.name == "corners"), "{}: {hits} hits, {ties} ties", scene.name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn both_exact_tracers_agree_on_random_worlds(
        seed in any::<u64>(),
        size in 1i32..40,
        one_in in 1u64..400,
        corner in prop::array::uniform3(prop_oneof![-100i32..100, Just(i32::MIN), Just(i32::MAX - 39), any::<i32>()]),
        away in prop::option::of(prop::array::uniform3(-20_000i32..20_000)),
    ) {
        let mut random = sets::Random::new(seed);
        // Far enough away for cubes larger than chunks to be stepped over, near enough for the slow one, which does not.
        let alone = away.map(|away| (IVec3::from_array([0, 1, 2].map(|i| corner[i].saturating_add(away[i]))), 1));
        let mut voxels: Vec<(IVec3, u16)> = alone.into_iter().collect();
        for cell in (0..size * size * size).map(|i| IVec3::new(i % size, i / size % size, i / size / size)) {
            if random.below(one_in) == 0 {
                let at = [0, 1, 2].map(|i| corner[i].saturating_add(cell[i]));
                voxels.push((IVec3::from_array(at), 1 + random.below(3) as u16));
            }
        }
        agree(&World::from_voxels(scenes::materials(), voxels), 60, seed);
    }
}

#[test]
fn both_exact_tracers_agree_with_brute_force() {
    for name in ["sparse", "menger", "checkerboard"] {
        let world = scenes::Scene::find(name).expect("a scene").world(IVec3::new(-9, 3, 2), 5);
        let oracle = Oracle::new(&world);
        let mut hits = 0;
        for set in ["pinhole", "incoherent", "edges", "lattice", "faces", "inside", "zeros"] {
            let mut unsure = 0;
            for ray in RaySet::find(set).expect("a set").rays(&world, 120, 11) {
                let voxel = oracle.first_hit(&ray).hit.map(|hit| hit.voxel);
                assert_eq!(voxel, exact::first_hit(&world, &ray).hit.map(|hit| hit.voxel), "{name} {set} {ray:?}");
                match brute::first_hit(&world, &ray) {
                    Verdict::Miss => assert_eq!(voxel, None, "{name} {set} {ray:?}"),
                    Verdict::Hit(expected) => {
                        hits += 1;
                        assert_eq!(voxel, Some(expected), "{name} {set} {ray:?}");
                    }
                    Verdict::Unsure(either, or_none) => {
                        unsure += 1;
                        assert!(
                            voxel.map_or(or_none, |v| either.contains(&v)),
                            "{name} {set} {ray:?}: {voxel:?} {either:?}"
                        );
                    }
                }
            }
            // Rays from faces and through edges are never sure; the others nearly always are.
            assert!(
                unsure < 12 || !["pinhole", "incoherent"].contains(&set),
                "{name} {set}: unsure of {unsure} of 120"
            );
        }
        assert!(hits > 40, "{name}: brute force is sure of {hits} hits");
    }
}

/// Run with `cargo test --release -p raxel-oracle --test oracle -- --ignored --nocapture` for rays a second on one core.
#[test]
#[ignore = "a measurement"]
fn speed() {
    for scene in scenes::ALL {
        let world = scene.world(IVec3::ZERO, 7);
        let oracle = Oracle::new(&world);
        for set in ["pinhole", "incoherent", "edges", "far"] {
            let rays = RaySet::find(set).expect("a set").rays(&world, 100_000, 3);
            let start = std::time::Instant::now();
            let hits = rays.iter().filter(|ray| oracle.first_hit(ray).hit.is_some()).count();
            let fast = rays.len() as f64 / start.elapsed().as_secs_f64();
            let start = std::time::Instant::now();
            let few = &rays[..5000];
            let same = few.iter().filter(|ray| exact::first_hit(&world, ray).hit.is_some()).count();
            let slow = few.len() as f64 / start.elapsed().as_secs_f64();
            println!("{:13} {set:11} {fast:10.0} rays/s, in fractions {slow:9.0}; {hits} hits ({same})", scene.name);
        }
    }
}
