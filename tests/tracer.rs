//! Compares the GLSL tracers of every layout on a device with the exact tracer: hits must be equal, ties included.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::sync::Arc;

use common::Project;
use glam::IVec3;
use raxel::world::vox;
use raxel::{Options, Session};
use raxel_diagnostics::MemoryFiles;
use raxel_gpu::{Device, DeviceOptions, Validation};
use raxel_layouts::Layout;
use raxel_measure::rays::{HitWords, Method, State, Stream, Tracer};
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::scenes::{self, Scene};
use raxel_oracle::{Hit, Oracle, Ray, sets};
use raxel_rivals as rivals;
use raxel_world::World;
use rayon::prelude::*;

/// A device with the validation layer, and the two slots for rays.
struct Lab {
    device: Arc<Device>,
    stream: Stream,
}

impl Lab {
    fn open() -> Self {
        let device = Device::new(&DeviceOptions { device: None, validation: Validation::Required })
            .expect("a Vulkan device with the validation layer: mesa-vulkan-drivers and vulkan-validationlayers");
        let stream = Stream::new(&device).expect("memory for rays");
        Self { device, stream }
    }

    /// The tracer of a layout, as the binary brings it along.
    fn tracer(&self, layout: Layout) -> Tracer {
        Tracer::new(&self.device, Arc::new(MemoryFiles::default()), &Method::of(layout)).expect("the shader compiles")
    }

    /// Traces rays through a world.
    fn trace(&mut self, tracer: &mut Tracer, world: &World, rays: &[Ray]) -> Vec<HitWords> {
        let world = tracer.upload(world).expect("a small world");
        self.stream.trace_all(tracer, &world, rays).expect("the device traces")
    }

    fn close(self) {
        drop(self.stream);
        assert_eq!(self.device.log().take(), [], "the validation layer is silent");
    }
}

/// Every layout in every scene and set. The default one gets more rays than the others.
#[test]
fn every_layout_hits_what_the_oracle_hits() {
    let mut lab = Lab::open();
    let mut tracers: Vec<Tracer> = rivals::LAYOUTS.iter().map(|&layout| lab.tracer(layout)).collect();
    for (number, scene) in scenes::ALL.iter().enumerate() {
        // Every other scene lies far from the origin.
        let corner =
            if number % 2 == 0 { IVec3::new(-13, 5, -40) } else { IVec3::new(1 << 30, i32::MIN + 64, -(1 << 24)) };
        let world = scene.world(corner, 3);
        let buffer = Layout::TREE64.encode(&world, u64::MAX).expect("a small world").words;
        let oracle = Oracle::new(&world);
        for tracer in &mut tracers {
            let rays_a_set = if tracer.method().layout == Layout::TREE64 { 1000 } else { 100 };
            let rays: Vec<(&str, Ray)> = sets::ALL
                .iter()
                .flat_map(|s| s.rays(&world, rays_a_set, 77).into_iter().map(|ray| (s.name, ray)))
                .collect();
            let plain: Vec<Ray> = rays.iter().map(|(_, ray)| *ray).collect();
            let found = lab.trace(tracer, &world, &plain);
            let place = format!("{} {}", tracer.method(), scene.name);
            let errors: Errors = rays
                .par_iter()
                .zip(&found)
                .map(|((set, ray), words)| {
                    let mut errors = Errors::default();
                    let (answer, hit) = (oracle.first_hit(ray), words.hit());
                    let wrong = errors.add(ray, &answer, words.outcome(hit.as_ref()));
                    assert_eq!(wrong, None, "{place} {set} {ray:?}\nexact {answer:?}\nfound {words:?}");
                    if let Some(hit) = hit {
                        assert_eq!(words.looked_up, hit.material, "{place} {set} {ray:?}");
                        // The port finds the same place on the face, but for the rounding of one division.
                        let port = Tree64::new(&buffer).trace(ray).expect("the port hits what the device hits");
                        let off = [0, 1].map(|i| (port.uv[i] - hit.uv[i]).abs());
                        assert!(off.iter().all(|off| *off < 1e-6), "{place} {set} {ray:?}\n{port:?}\n{hit:?}");
                        // And it steps over the same blocks.
                        let same_steps = tracer.method().layout != Layout::TREE64 || port.steps == hit.steps;
                        assert!(same_steps, "{place} {set} {ray:?}\n{port:?}\n{hit:?}");
                    }
                    errors
                })
                .reduce(Errors::default, Errors::and);
            assert_eq!(errors.rays as usize, sets::ALL.len() * rays_a_set);
            assert!(errors.hits * 20 > errors.rays, "{place}: {errors:?}");
            assert!(errors.t_error < 1e-5, "{place}: t is off by {}", errors.t_error);
        }
    }
    drop(tracers);
    lab.close();
}

/// A list longer than the slots is traced whole and in order, part by part.
#[test]
fn long_lists_go_in_parts() {
    let mut lab = Lab::open();
    lab.stream = Stream::with_capacity(&lab.device, 300).expect("memory");
    let world = Scene::find("hills").expect("a scene").world(IVec3::ZERO, 1);
    let rays = sets::RaySet::find("pinhole").expect("a set").rays(&world, 1000, 5);
    let mut tracer = lab.tracer(Layout::TREE64);
    let on_device = tracer.upload(&world).expect("a small world");
    let (mut next, mut parts) = (0, 0);
    let oracle = Oracle::new(&world);
    lab.stream
        .trace(&mut tracer, &on_device, &rays, |part| {
            assert_eq!((part.range.start, part.range.len()), (next, part.hits.len()));
            assert!(part.hits.len() <= 300 && part.seconds.is_some() == (parts > 0));
            for (ray, words) in rays[part.range.clone()].iter().zip(part.hits) {
                assert_eq!(words.hit().map(|hit| hit.voxel), oracle.first_hit(ray).hit.map(|hit| hit.voxel));
            }
            (next, parts) = (part.range.end, parts + 1);
            Ok::<_, raxel_measure::rays::RayError>(())
        })
        .expect("the device traces");
    assert_eq!((next, parts), (1000, 4));
    assert_eq!(lab.stream.trace_all(&mut tracer, &on_device, &[] as &[Ray]).expect("nothing to do"), []);
    drop(tracer);
    lab.close();
}

/// Pieces half a million voxels apart. A layout can skip everything between them.
#[test]
fn rays_cross_wide_empty_space() {
    let mut lab = Lab::open();
    let mut voxels = Vec::new();
    for (piece, material) in [(IVec3::new(-260_000, 40, 7), 1), (IVec3::new(270_000, -3000, 199), 2)] {
        for i in 0..27 * 27 {
            voxels.push((piece + IVec3::new(i % 3, i / 3 % 27, i / 81), material));
        }
    }
    let world = World::from_voxels(scenes::materials(), voxels);
    let across = |i: i32| {
        let from = [-259_990, 40 + i % 27, 7 + i / 27 % 9];
        let to = [270_000, -3000 + i * 7 % 30, 199 + i * 5 % 12];
        Ray::new(from, [0.5, 0.25, 0.75], [0, 1, 2].map(|a| (to[a] - from[a]) as f32))
    };
    let oracle = Oracle::new(&world);
    let rays: Vec<Ray> = (0..400).map(across).collect();
    // The layout `chunks` would take 17,000 steps of a linear search.
    // No device has a dense image of it, and a layout with a window does not hold it.
    let any_width = |layout: &&Layout| **layout != rivals::CHUNKS && !layout.has_image() && layout.window().is_none();
    for &layout in rivals::LAYOUTS.iter().filter(any_width) {
        let mut errors = Errors::default();
        for (ray, words) in rays.iter().zip(lab.trace(&mut lab.tracer(layout), &world, &rays)) {
            errors.add(ray, &oracle.first_hit(ray), words.hit().as_ref());
            assert_eq!(errors.wrong(), 0, "{} {ray:?} {words:?}", layout.name());
            assert!(words.state() != State::Hit || words.steps < 400, "{}: {} steps", layout.name(), words.steps);
        }
        assert!(errors.hits > 100, "{}: {errors:?}", layout.name());
    }
}

/// Rays that begin in every voxel of boxes of 1, 2, 4, … 4096 materials hit the material that is there.
#[test]
fn voxels_are_of_their_materials() {
    let mut lab = Lab::open();
    let materials = vec![raxel_world::Material::matt("any", [0.5; 3]); 4097];
    let mut voxels = Vec::new();
    for (slab, count) in (0..).zip([1, 2, 4, 16, 17, 256, 257, 4096]) {
        for i in 0..16 * 20 * 30 {
            let cell = IVec3::new(16 * slab + i % 16 - 70, i / 16 % 20 + 5, i / 320 - 9);
            voxels.push((cell, 1 + (i * 7 % count) as u16));
        }
    }
    let world = World::from_voxels(materials, voxels.iter().copied());
    let rays: Vec<Ray> = voxels.iter().map(|(cell, _)| Ray::new(cell.to_array(), [0.5; 3], [1.0, 0.0, 0.0])).collect();
    for &layout in rivals::LAYOUTS {
        for ((cell, material), words) in voxels.iter().zip(lab.trace(&mut lab.tracer(layout), &world, &rays)) {
            let found = (words.state(), words.material, words.looked_up);
            assert_eq!(found, (State::Hit, u32::from(*material), u32::from(*material)), "{} {cell}", layout.name());
        }
    }
}

#[test]
fn rays_end_at_t_max() {
    let mut lab = Lab::open();
    let world = Scene::find("hills").expect("a scene").world(IVec3::ZERO, 1);
    let rays = sets::RaySet::find("pinhole").expect("a set").rays(&world, 2000, 5);
    for &layout in rivals::LAYOUTS {
        let mut tracer = lab.tracer(layout);
        let free = lab.trace(&mut tracer, &world, &rays);
        let reached: Vec<(Ray, f32)> =
            rays.iter().zip(&free).filter(|(_, hit)| hit.hit().is_some()).map(|(r, h)| (*r, h.t)).collect();
        assert!(reached.len() > 300);
        for (factor, hits) in [(0.999, false), (1.0, true), (1.001, true)] {
            let cut: Vec<Ray> = reached.iter().map(|(ray, t)| Ray { t_max: t * factor, ..*ray }).collect();
            assert!(
                lab.trace(&mut tracer, &world, &cut).iter().all(|hit| hit.hit().is_some() == hits),
                "{} {factor}",
                layout.name()
            );
        }
    }
}

/// Asks `rx_trace_from` in place of `rx_trace`: of a ray that hits, from a time before its hit; of one that misses, from any time.
const FROM_ANYWHERE: &str = r"
bool rx_march(RxRay ray, out RxHit hit) {
    uvec3 bits = floatBitsToUint(ray.frac) ^ floatBitsToUint(ray.dir).zxy;
    float share = float(((bits.x * 747796405u + bits.y) * 2891336453u + bits.z) >> 22) / 1023.0;
    vec3 size = abs(ray.dir);
    float any = 1000.0 / max(size.x, max(size.y, size.z));
    bool found = rx_trace(ray, hit);
    return rx_trace_from(ray, (found ? hit.t : any) * share, hit);
}
";

/// A ray that counts as free up to some time before its hit hits the same, to the bit.
#[test]
fn rays_may_begin_anywhere_before_their_hit() {
    let mut lab = Lab::open();
    let library = Arc::new(MemoryFiles::new([("shaders/include/raxel/rivals/march.glsl", FROM_ANYWHERE)]));
    let world = Scene::find("menger").expect("a scene").world(IVec3::new(-13, 5, -(1 << 24)), 3);
    let rays: Vec<Ray> = sets::ALL.iter().flat_map(|set| set.rays(&world, 200, 8)).collect();
    for &layout in rivals::LAYOUTS {
        let whole = lab.trace(&mut lab.tracer(layout), &world, &rays);
        let mut from_anywhere =
            Tracer::new(&lab.device, library.clone(), &Method::of(layout)).expect("the shader compiles");
        let found = lab.trace(&mut from_anywhere, &world, &rays);
        let mut fewer_steps = 0;
        for ((ray, whole), found) in rays.iter().zip(&whole).zip(&found) {
            let same = |hit: Hit| Hit { steps: 0, ..hit };
            assert_eq!(found.hit().map(same), whole.hit().map(same), "{} {ray:?}", layout.name());
            fewer_steps += usize::from(found.steps < whole.steps);
        }
        assert!(fewer_steps * 40 > rays.len(), "{}: {fewer_steps} of {} rays", layout.name(), rays.len());
    }
    lab.close();
}

#[test]
fn an_empty_world_is_hit_nowhere() {
    let mut lab = Lab::open();
    let hills = Scene::find("hills").expect("a scene").world(IVec3::ZERO, 1);
    let rays = sets::RaySet::find("pinhole").expect("a set").rays(&hills, 300, 5);
    for &layout in rivals::LAYOUTS {
        let hits = lab.trace(&mut lab.tracer(layout), &World::empty(), &rays);
        assert!(hits.iter().all(|hit| hit.state() == State::Miss), "{}", layout.name());
    }
    lab.close();
}

/// Looks up cells all over the cube: one an invocation, and all of them by each invocation after a ray.
const LOOK_UPS: &str = include_str!("fixtures/tracer/look_ups.toml");

const FRESH: &str = include_str!("fixtures/tracer/fresh.comp");

const AFTER: &str = include_str!("fixtures/tracer/after.comp");

/// Cell i of 4096 in 256³ from 64 on, in any order.
const CELL: &str = r"
ivec3 cell(uint i) {
    uint hash = i * 0x9e3779b9u;
    hash = (hash ^ (hash >> 15)) * 0x85ebca6bu;
    hash ^= hash >> 13;
    return ivec3(64) + ivec3(hash & 255u, (hash >> 8) & 255u, (hash >> 16) & 255u);
}
";

/// A tracer's cache of its hit speeds up look-ups, and changes no answer. The world begins at 64, so that places in its cube differ from
/// coordinates.
#[test]
fn look_ups_after_a_hit_give_what_look_ups_before_it_give() {
    let project = Project::shipped();
    for (name, text) in [("fresh", FRESH), ("after", AFTER)] {
        project.write(&format!("shaders/{name}.comp"), text.replace("CELL", CELL));
    }
    let scene = Scene::find("menger").expect("a scene").world(IVec3::ZERO, 5);
    project.write("worlds/models/menger.vox", vox::export(&scene).expect("a small world"));
    let build = "[[build]]\nop = \"model\"\nmodel = \"scene\"\norigin = [70, 70, 70]\n";
    project
        .write("worlds/here.toml", format!("name = \"menger\"\n[models.scene]\nfile = \"models/menger.vox\"\n{build}"));
    // `texture3d` keeps nothing, and wants an image besides.
    for layout in rivals::LAYOUTS.iter().filter(|layout| layout.name() != "texture3d") {
        project.write("graphs/look_ups.toml", LOOK_UPS.replace("LAYOUT", layout.name()));
        let options = Options {
            project: Some(project.root().into()),
            graph: Some(project.path("graphs/look_ups.toml")),
            world: Some(project.path("worlds/here.toml")),
            validation: raxel::Validation::Required,
            ..Options::default()
        };
        let mut session = Session::open(options).unwrap_or_else(|error| panic!("{}: {error}", layout.name()));
        session.frame().unwrap_or_else(|error| panic!("{}: {error}", layout.name()));
        let pixels = session.read_target("other").expect("a target").integers().expect("integers");
        let hits = pixels.iter().filter(|pixel| pixel[0] == 1).count();
        let other: u32 = pixels.iter().map(|pixel| pixel[1]).sum();
        assert!(hits > 40 && other == 0, "{}: {hits} hits, {other} look-ups differ", layout.name());
        assert_eq!(session.device().log().take(), [], "{}: the validation layer is silent", layout.name());
    }
}
