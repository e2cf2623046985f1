//! The CPU port of the tree64 tracer against the exact tracer.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use glam::IVec3;
use proptest::prelude::*;
use raxel_layouts::Layout;
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::scenes::{self, Scene};
use raxel_oracle::sets::{self, RaySet};
use raxel_oracle::{Hit, Ray, exact};
use raxel_world::World;

fn compare(world: &World, rays: &[Ray]) -> Errors {
    let buffer = Layout::TREE64.encode(world, u64::MAX).expect("small").words;
    let tree = Tree64::new(&buffer);
    let mut errors = Errors::default();
    for ray in rays {
        let (answer, found) = (exact::first_hit(world, ray), tree.trace(ray));
        let before = errors.wrong();
        errors.add(ray, &answer, found.as_ref());
        assert_eq!(errors.wrong(), before, "{ray:?}\nexact {answer:?}\nfound {found:?}");
    }
    errors
}

fn check_scene(name: &str) {
    let scene = Scene::find(name).expect("a scene");
    for corner in [IVec3::new(-13, 5, -40), IVec3::new(1 << 30, -(1 << 30) - 7, i32::MAX - 600)] {
        let world = scene.world(corner, 7);
        for set in sets::ALL {
            let errors = compare(&world, &set.rays(&world, 1500, 42));
            assert!(errors.t_error < 1e-5, "{} {}: t is off by {}", scene.name, set.name, errors.t_error);
            if set.name == "invalid" {
                assert_eq!(errors.hits, 0);
            } else if !["corners", "dust"].contains(&name) && set.name != "range-end-tiles" {
                // Rays to the sun begin at surfaces, and little stands in the way of hills.
                let least = if set.name.starts_with("parallel") { 0 } else { 10 };
                assert!(errors.hits > least, "{} {}: {errors:?}", scene.name, set.name);
            }
        }
    }
}

#[test]
fn port_is_exact_on_sparse() {
    check_scene("sparse");
}

#[test]
fn port_is_exact_on_a_checkerboard() {
    check_scene("checkerboard");
}

#[test]
fn port_is_exact_on_a_diagonal_plane() {
    check_scene("diagonal");
}

#[test]
fn port_is_exact_on_a_solid_cube() {
    check_scene("solid");
}

#[test]
fn port_is_exact_on_far_corners() {
    check_scene("corners");
}

#[test]
fn port_is_exact_on_a_menger_sponge() {
    check_scene("menger");
}

#[test]
fn port_is_exact_on_hills() {
    check_scene("hills");
}

#[test]
fn port_is_exact_on_dust() {
    check_scene("dust");
}

#[test]
fn port_is_exact_on_gravel() {
    check_scene("gravel");
}

#[test]
fn port_is_exact_on_rubble() {
    check_scene("rubble");
}

#[test]
fn port_is_exact_on_a_slope() {
    check_scene("slope");
}

#[test]
fn port_is_exact_on_terrain() {
    check_scene("terrain");
}

/// Every scene must be hit by rays of the ordinary sets, and the lattice set must meet ties: the tests above compare something.
#[test]
fn sets_hit_and_meet_ties() {
    let world = Scene::find("hills").expect("a scene").world(IVec3::ZERO, 1);
    for (name, hits, ties) in [("pinhole", 300, 0), ("lattice", 200, 300), ("inside", 700, 0), ("far", 50, 0)] {
        let errors = compare(&world, &RaySet::find(name).expect("a set").rays(&world, 2000, 3));
        assert!(errors.hits >= hits && errors.ties >= ties, "{name}: {errors:?}");
    }
}

#[test]
fn moving_ray_and_world_moves_the_hit() {
    let scene = Scene::find("hills").expect("a scene");
    let here = scene.world(IVec3::ZERO, 1);
    let by = [i32::MAX - 100, i32::MIN + 20, 123_456_789];
    let there = scene.world(IVec3::from_array(by), 1);
    let buffers = [&here, &there].map(|world| Layout::TREE64.encode(world, u64::MAX).expect("small").words);
    for set in ["pinhole", "lattice", "edges"] {
        for ray in RaySet::find(set).expect("a set").rays(&here, 3000, 9) {
            let Some(moved) = ray.moved(by) else { continue };
            let first = Tree64::new(&buffers[0]).trace(&ray);
            let second = Tree64::new(&buffers[1]).trace(&moved);
            // The tree's cells and the steps differ, but hits must be equal to the bit.
            let expected =
                first.map(|hit| (std::array::from_fn(|i| hit.voxel[i] + by[i]), hit.face, hit.t.to_bits(), hit.uv));
            assert_eq!(second.map(|hit| (hit.voxel, hit.face, hit.t.to_bits(), hit.uv)), expected, "{ray:?}");
        }
    }
}

/// A ray may count as free up to any time before its hit, and one that hits nothing up to any time at all.
#[test]
fn rays_may_begin_anywhere_before_their_hit() {
    for (name, corner) in
        [("hills", IVec3::new(-13, 5, -40)), ("menger", IVec3::ZERO), ("corners", IVec3::splat(-(1 << 20)))]
    {
        let world = Scene::find(name).expect("a scene").world(corner, 7);
        let buffer = Layout::TREE64.encode(&world, u64::MAX).expect("small").words;
        let tree = Tree64::new(&buffer);
        let mut random = sets::Random::new(3);
        let (mut hits, mut fewer_steps) = (0, 0);
        for set in sets::ALL {
            for ray in set.rays(&world, 600, 9) {
                let whole = tree.trace(&ray);
                let share = random.below(1025) as f32 / 1024.0;
                let up_to = [share, 1.0, 1.0 - share * 1e-6].map(|share| match &whole {
                    Some(hit) => hit.t * share,
                    None => share * 1000.0 / ray.dir.iter().fold(0.0, |most, d| d.abs().max(most)),
                });
                for t_free in up_to {
                    let found = tree.trace_from(&ray, t_free);
                    let place =
                        |hit: Hit| (hit.voxel, hit.face, hit.material, hit.t.to_bits(), hit.uv.map(f32::to_bits));
                    assert_eq!(found.map(place), whole.map(place), "{name} {} {t_free} {ray:?}", set.name);
                    hits += u32::from(found.is_some());
                    fewer_steps += u32::from(found.zip(whole).is_some_and(|(found, whole)| found.steps < whole.steps));
                }
            }
        }
        assert!(hits > 2000 && fewer_steps * 8 > hits, "{name}: {hits} hits, {fewer_steps} of them with fewer steps");
    }
}

/// The cube's 48 symmetries: permute the axes, then mirror some of them.
fn symmetries() -> impl Iterator<Item = ([usize; 3], [bool; 3])> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    orders.into_iter().flat_map(|order| (0..8).map(move |bits| (order, [0, 1, 2].map(|i| bits >> i & 1 == 1))))
}

#[test]
fn turned_and_mirrored_worlds_are_hit_alike() {
    let scene = Scene::find("hills").expect("a scene");
    let here = scene.world(IVec3::new(-30, 7, 3), 1);
    let words = Layout::TREE64.encode(&here, u64::MAX).expect("small").words;
    let tree = Tree64::new(&words);
    let rays: Vec<Ray> = ["pinhole", "edges", "faces", "lattice", "tiny"]
        .iter()
        .flat_map(|set| RaySet::find(set).expect("a set").rays(&here, 150, 21))
        .collect();
    for (order, mirrored) in symmetries() {
        let cell = |c: [i32; 3]| [0, 1, 2].map(|i| if mirrored[i] { -1 - c[order[i]] } else { c[order[i]] });
        let voxels = here.voxels().map(|(voxel, material)| (IVec3::from_array(cell(voxel.to_array())), material));
        let there = World::from_voxels(here.materials().to_vec(), voxels);
        let turned_words = Layout::TREE64.encode(&there, u64::MAX).expect("small").words;
        for ray in &rays {
            let frac = [0, 1, 2].map(|i| if mirrored[i] { 1.0 - ray.frac[order[i]] } else { ray.frac[order[i]] });
            let dir = [0, 1, 2].map(|i| if mirrored[i] { -ray.dir[order[i]] } else { ray.dir[order[i]] });
            let turned = Ray::new(cell(ray.cell), frac, dir);
            let (first, second) = (tree.trace(ray), Tree64::new(&turned_words).trace(&turned));
            let expected = first.map(|hit| (cell(hit.voxel), hit.t.to_bits()));
            assert_eq!(second.map(|hit| (hit.voxel, hit.t.to_bits())), expected, "{order:?} {mirrored:?} {ray:?}");
            // The order of the axes decides between the two faces of an edge.
            if let (Some(first), Some(second), false) = (first, second, exact::first_hit(&here, ray).tie) {
                let face = (0..3)
                    .find(|&i| order[i] as u32 == first.face / 2)
                    .map_or(6, |i| 2 * i as u32 + (first.face & 1 ^ u32::from(mirrored[i])));
                assert_eq!(second.face, face, "{order:?} {mirrored:?} {ray:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn port_is_exact_on_random_worlds(
        seed in any::<u64>(),
        size in 1i32..40,
        one_in in 1u64..400,
        corner in prop::array::uniform3(prop_oneof![-100i32..100, Just(i32::MIN), Just(i32::MAX - 39), any::<i32>()]),
    ) {
        let mut random = sets::Random::new(seed);
        let mut voxels = Vec::new();
        for cell in (0..size * size * size).map(|i| IVec3::new(i % size, i / size % size, i / size / size)) {
            if random.below(one_in) == 0 {
                let at = [0, 1, 2].map(|i| corner[i].saturating_add(cell[i]));
                voxels.push((IVec3::from_array(at), 1 + random.below(3) as u16));
            }
        }
        let world = World::from_voxels(scenes::materials(), voxels);
        for set in sets::ALL {
            compare(&world, &set.rays(&world, 60, seed));
        }
    }
}
