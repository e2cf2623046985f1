//! Several worlds in one shader, and worlds that a shader has written, against the exact tracer.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::sync::Arc;

use glam::IVec3;
use raxel_diagnostics::MemoryFiles;
use raxel_gpu::{Device, DeviceOptions, Validation};
use raxel_layouts::Layout;
use raxel_measure::rays::{HitWords, Method, Stream, Tracer};
use raxel_oracle::metrics::Errors;
use raxel_oracle::scenes::{self, Scene};
use raxel_oracle::{Oracle, Ray, sets};
use raxel_rivals as rivals;
use raxel_world::World;
use rayon::prelude::*;

/// A device with the validation layer, and the slots for rays.
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

    /// A tracer whose `rx_march` is this text.
    fn tracer(&self, layout: Layout, march: &str, defines: &[&str]) -> Tracer {
        let files = MemoryFiles::new([("shaders/include/raxel/rivals/march.glsl", march)]);
        let made = Tracer::with_defines(&self.device, Arc::new(files), &Method::of(layout), defines);
        made.unwrap_or_else(|error| panic!("{} {defines:?}: {error}", layout.name()))
    }

    fn close(self) {
        drop(self.stream);
        assert_eq!(self.device.log().take(), [], "the validation layer is silent");
    }
}

/// Holds what a device found against the exact hits.
fn check(what: &str, world: &World, rays: &[Ray], found: &[HitWords]) -> Errors {
    assert_eq!(rays.len(), found.len());
    let oracle = Oracle::new(world);
    let errors: Errors = rays
        .par_iter()
        .zip(found)
        .map(|(ray, words)| {
            let mut errors = Errors::default();
            let (answer, hit) = (oracle.first_hit(ray), words.hit());
            let wrong = errors.add(ray, &answer, words.outcome(hit.as_ref()));
            assert_eq!(wrong, None, "{what} {ray:?}\nexact {answer:?}\nfound {words:?}");
            errors
        })
        .reduce(Errors::default, Errors::and);
    assert!(errors.t_error < 1e-5, "{what}: t is off by {}", errors.t_error);
    errors
}

/// Every ray goes through all three worlds. A `t_max` of 1e37, 2e37 or 3e37 selects the hit that counts; all of them mean no end.
const THREE_WORLDS: &str = include_str!("fixtures/worlds/three_worlds.glsl");

/// The twelve lines of the affine plane of order 3: of nine layouts, each pair stands together in exactly one of them.
fn triples() -> Vec<[Layout; 3]> {
    let nine: Vec<Layout> = rivals::LAYOUTS.iter().copied().filter(|layout| layout.window().is_none()).collect();
    assert_eq!(nine.len(), 9, "the plane has nine points");
    let at = |x: usize, y: usize| nine[x % 3 + 3 * (y % 3)];
    let rows = (0..3).flat_map(|slope| (0..3).map(move |start| (slope, start)));
    let mut lines: Vec<[Layout; 3]> = rows.map(|(slope, start)| [0, 1, 2].map(|x| at(x, start + slope * x))).collect();
    lines.extend((0..3).map(|x| [0, 1, 2].map(|y| at(x, y))));
    lines
}

/// Each pair of layouts, and some layouts three times, over three worlds that have nothing in common.
#[test]
fn three_worlds_in_a_shader_are_each_traced_exactly() {
    let corner = IVec3::new(1 << 30, i32::MIN + 64, -(1 << 24));
    let worlds = ["hills", "menger", "gravel"].map(|name| Scene::find(name).expect("a scene").world(corner, 3));
    let mut lab = Lab::open();
    let same = [Layout::TREE64, rivals::TEXTURE3D, rivals::BVH, Layout::FLAT64].map(|layout| [layout; 3]);
    for layouts in triples().into_iter().chain(same) {
        let [_, pine, oak] = layouts.map(|layout| layout.name().to_uppercase());
        let defines = [format!("RX_LAYOUT_{pine}_pine"), format!("RX_LAYOUT_{oak}_oak")];
        let mut tracer = lab.tracer(layouts[0], THREE_WORLDS, &defines.each_ref().map(String::as_str));
        let [_, pine, oak] = [0, 1, 2].map(|i| tracer.upload_as(layouts[i], &worlds[i]).expect("a small world"));
        let on_device = tracer.upload(&worlds[0]).expect("a small world").with("pine", pine).with("oak", oak);
        for (world, t_max) in worlds.iter().zip([1.0e37, 2.0e37, 3.0e37]) {
            let rays: Vec<Ray> = sets::ALL.iter().flat_map(|set| set.rays(world, 60, 5)).collect();
            let rays: Vec<Ray> = rays.into_iter().map(|ray| Ray { t_max, ..ray }).collect();
            let found = lab.stream.trace_all(&mut tracer, &on_device, &rays).expect("the device traces");
            let what = format!("{:?}, {t_max}", layouts.map(Layout::name));
            let errors = check(&what, world, &rays, &found);
            assert!(errors.hits * 4 > errors.rays, "{what}: {errors:?}");
        }
    }
    lab.close();
}

/// A "ray" sets the voxel of its cell: `t_max` is the material. The answer, whether there was room, has the form of a hit.
const SETTER: &str = "
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RxHit(ray.cell, 0u, 0u, 0.0, vec2(0.0), 0u);
    return rx_set(ray.cell, uint(ray.t_max));
}
";

fn edit((cell, material): (IVec3, u16)) -> Ray {
    Ray { t_max: f32::from(material), ..Ray::new(cell.to_array(), [0.5; 3], [1.0, 0.0, 0.0]) }
}

/// Chunks of 32³, or what there is of them.
fn chunk_of(cell: IVec3) -> IVec3 {
    cell >> 5
}

/// Thousands of threads at once add, remove and change voxels all over the chunks of a world. Neighbouring threads change neighbours
/// in a word. Then the copy equals the edited world, for every ray.
#[test]
fn what_a_shader_has_set_is_traced_exactly() {
    let mut lab = Lab::open();
    for (name, corner) in
        [("hills", IVec3::new(-13, 5, -40)), ("sparse", IVec3::new(1 << 20, -77, 0)), ("solid", IVec3::ZERO)]
    {
        let world = Scene::find(name).expect("a scene").world(corner, 3);
        let chunks: std::collections::BTreeSet<[i32; 3]> =
            world.voxels().map(|(cell, _)| chunk_of(cell).to_array()).collect();
        let chunks: Vec<[i32; 3]> = chunks.into_iter().collect();
        let mut random = sets::Random::new(9);
        let mut edits = std::collections::HashMap::new();
        for i in 0..4000u64 {
            let chunk = IVec3::from_array(chunks[random.below(chunks.len() as u64) as usize]) * 32;
            let first = chunk + IVec3::from_array(std::array::from_fn(|_| random.below(32) as i32));
            // Runs along x: all air, or all of one material, or mixed.
            let material = [0, 1, 3][(i % 3) as usize];
            for x in 0..(1 + random.below(6) as i32).min(32 - (first.x & 31)) {
                edits.insert(first + IVec3::new(x, 0, 0), if i % 5 == 0 { (x % 3) as u16 } else { material });
            }
        }
        let edits: Vec<(IVec3, u16)> = edits.into_iter().collect();
        let mut voxels: std::collections::HashMap<IVec3, u16> = world.voxels().collect();
        voxels.extend(edits.iter().copied());
        let edited = World::from_voxels(world.materials().to_vec(), voxels.into_iter().filter(|(_, m)| *m != 0));
        let rays: Vec<Ray> = sets::ALL.iter().flat_map(|set| set.rays(&edited, 150, 5)).collect();

        // Cells without a chunk, and outside of the cube.
        let nowhere: Vec<Ray> = [[900, 0, 0], [0, -70_000, 0], [i32::MAX, i32::MIN, 0]]
            .map(|by: [i32; 3]| edit((corner.wrapping_add(IVec3::from_array(by)), 1)))
            .to_vec();
        for layout in [rivals::CHUNKS, rivals::CHUNK_TABLE, Layout::OCTREE] {
            let what = format!("{} {name}", layout.name());
            let mut setter = lab.tracer(layout, SETTER, &["RX_WRITE_world"]);
            let mut tracer =
                lab.tracer(layout, "bool rx_march(RxRay ray, out RxHit hit) { return rx_trace(ray, hit); }", &[]);
            let copy = setter.upload_writable(&world).expect("a small world");
            let before = lab.stream.trace_all(&mut tracer, &copy, &rays).expect("the device traces");
            check(&format!("{what} before"), &world, &rays, &before);
            let set = lab.stream.trace_all(&mut setter, &copy, &edits.iter().copied().map(edit).collect::<Vec<_>>());
            assert!(set.expect("the device sets").iter().all(|set| set.hit().is_some()), "{what}: room everywhere");
            let refused = lab.stream.trace_all(&mut setter, &copy, &nowhere).expect("the device sets");
            assert!(refused.iter().all(|set| set.hit().is_none()), "{what}: {refused:?}");
            let after = lab.stream.trace_all(&mut tracer, &copy, &rays).expect("the device traces");
            let errors = check(&what, &edited, &rays, &after);
            assert!(errors.hits * 4 > errors.rays, "{what}: {errors:?}");
            let changed = before.iter().zip(&after).filter(|(a, b)| a.voxel != b.voxel).count();
            assert!(changed * 50 > rays.len(), "{what}: only {changed} rays see the difference");
        }
    }
    lab.close();
}

/// Of many threads that set one voxel, one wins, and neighbours in its word are not touched.
#[test]
fn threads_may_set_the_same_voxel() {
    let mut lab = Lab::open();
    let world = World::from_voxels(scenes::materials(), [(IVec3::ZERO, 1)]);
    let cells: Vec<IVec3> = (0..16).map(|x| IVec3::new(x, 3, 3)).collect();
    let edits: Vec<Ray> = (0..8192u32).map(|i| edit((cells[i as usize % 15], 1 + (i / 15 % 3) as u16))).collect();
    let looks: Vec<Ray> = cells.iter().map(|cell| Ray::new(cell.to_array(), [0.5; 3], [0.0, 1.0, 0.0])).collect();
    for layout in [rivals::CHUNKS, rivals::CHUNK_TABLE, Layout::OCTREE] {
        let mut setter = lab.tracer(layout, SETTER, &["RX_WRITE_world"]);
        let mut tracer =
            lab.tracer(layout, "bool rx_march(RxRay ray, out RxHit hit) { return rx_trace(ray, hit); }", &[]);
        let copy = setter.upload_writable(&world).expect("a small world");
        let set = lab.stream.trace_all(&mut setter, &copy, &edits).expect("the device sets");
        assert!(set.iter().all(|set| set.hit().is_some()), "{}", layout.name());
        let found = lab.stream.trace_all(&mut tracer, &copy, &looks).expect("the device traces");
        let materials: Vec<u32> = found.iter().map(|hit| hit.hit().map_or(0, |hit| hit.material)).collect();
        assert!(materials[..15].iter().all(|m| (1..=3).contains(m)), "{}: {materials:?}", layout.name());
        assert_eq!(materials[15], 0, "{}", layout.name());
    }
    lab.close();
}
