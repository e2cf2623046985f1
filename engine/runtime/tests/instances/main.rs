//! Instances on the device: every ray hits what whole numbers say, of the world, of models on its lattice and of models turned in any way.
//! On a real device with the validation layer on.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(clippy::float_cmp, reason = "values are compared with the very ones that were written")]

#[path = "../project/mod.rs"]
mod project;

mod params;
mod poses;
mod rays;

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use glam::IVec3;
use project::{Project, Sessions};
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_layouts::instances::Frame;
use raxel_oracle::instances::{Scene, SceneHit};
use raxel_oracle::sets::Random;
use raxel_oracle::{Lattice, Ray, sets};
use raxel_runtime::{Options, Session};
use raxel_world::{Material, World, vox};
use raxel_worldfile::Loaded;

const RAYS: usize = sets::ALL.len() * 256;

/// Traces the rays of a file, and from each hit one more ray outwards.
/// The graph; `"RAYS"` is their number.
const GRAPH: &str = include_str!("../fixtures/instances/instances.toml");
const SHADER: &str = include_str!("../fixtures/instances/trace.comp");

/// A project with three models, and a world of random instances about `origin`.
fn project(origin: [i32; 3], seed: u64, instances: &str) -> Project {
    let project = Project::filled();
    project.write("graphs/instances.toml", GRAPH.replace("\"RAYS\"", &RAYS.to_string()));
    project.write("shaders/trace.comp", SHADER);
    project.write("data/rays.bin", "\0".repeat(48));
    let mut random = Random::new(seed);
    fs::create_dir_all(project.path("worlds")).unwrap();
    // A small dense one, a thin one that is longer than 64 voxels, and one voxel.
    let mut model = |name: &str, size: [i32; 3], share: u64| {
        let cells = (0..size[0] * size[1] * size[2])
            .map(|i| IVec3::new(i % size[0], i / size[0] % size[1], i / size[0] / size[1]));
        let mut solid = Vec::new();
        for cell in cells {
            if random.below(100) < share {
                solid.push((cell, 1 + random.below(2) as u16));
            }
        }
        let materials =
            vec![Material::air(), Material::matt("a", [0.2, 0.5, 0.1]), Material::matt("b", [0.9, 0.1, 0.3])];
        let bytes = vox::export(&World::from_voxels(materials, solid)).expect("a small model");
        fs::write(project.path(&format!("worlds/{name}.vox")), bytes).unwrap();
    };
    model("crate", [9, 7, 12], 60);
    model("mast", [3, 110, 2], 90);
    model("dot", [1, 1, 1], 100);
    let [x, y, z] = origin;
    let mut text = format!(
        r##"name = "test"
[models.crate]
file = "crate.vox"
[models.mast]
file = "mast.vox"
[models.dot]
file = "dot.vox"
[materials]
stone = {{ albedo = "#808080" }}
[[build]]
op = "menger"
level = 3
origin = {:?}
material = "stone"
[[build]]
op = "model"
model = "crate"
origin = {:?}
"##,
        [x - 13, y - 10, z - 13],
        [x + 20, y, z + 3]
    );
    text.push_str(instances);
    project.write("worlds/test.toml", &text);
    project
}

/// Random instances: a third on the lattice, some of them in each other's and the world's voxels.
fn random_instances(origin: [i32; 3], seed: u64) -> String {
    let mut random = Random::new(seed);
    let mut text = String::new();
    for i in 0..60 {
        let at: [i32; 3] = std::array::from_fn(|axis| origin[axis] + random.below(70) as i32 - 35);
        let model = ["crate", "mast", "dot"][random.below(3) as usize];
        let [x, y, z] = at;
        let _ = write!(text, "[[instances]]\nmodel = \"{model}\"\n");
        let quarter = |random: &mut Random| 90 * random.below(4) as i32;
        let _ = if i % 3 == 0 {
            let turns = [quarter(&mut random), quarter(&mut random), quarter(&mut random)];
            write!(text, "position = [{x}, {y}, {z}]\nyaw = {}\npitch = {}\nroll = {}\n", turns[0], turns[1], turns[2])
        } else if i % 3 == 1 {
            let mut angle = || random.unit() * 720.0 - 360.0;
            write!(
                text,
                "position = [{x}.3, {y}.75, {z}]\nyaw = {}\npitch = {}\nroll = {}\n",
                angle(),
                angle(),
                angle()
            )
        } else {
            // Turned by quarter turns, but half a voxel off: the planes of both lattices are parallel.
            write!(text, "position = [{x}.5, {y}.0, {z}.5]\nyaw = {}\n", quarter(&mut random))
        };
    }
    text
}

fn bytes(rays: &[Ray]) -> Vec<u8> {
    let words = rays.iter().flat_map(|ray| {
        let [x, y, z] = ray.cell.map(i32::cast_unsigned);
        let ([fx, fy, fz], [dx, dy, dz]) = (ray.frac.map(f32::to_bits), ray.dir.map(f32::to_bits));
        [x, y, z, ray.t_max.to_bits(), fx, fy, fz, 0, dx, dy, dz, 0]
    });
    words.flat_map(u32::to_le_bytes).collect()
}

fn open(project: &Project) -> Session {
    Project::open_with(options(project))
}

fn options(project: &Project) -> Options {
    Options {
        graph: Some(PathBuf::from("graphs/instances.toml")),
        world: Some(PathBuf::from("worlds/test.toml")),
        watch: false,
        ..project.options()
    }
}

/// The hits on the device, a ray a row of 24 words.
fn hits(session: &mut Session) -> Vec<[u32; 24]> {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let bytes = session.read_buffer("hits", 0..(RAYS * 96) as u64).unwrap();
    let words: Vec<u32> = bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    words.chunks_exact(24).map(|row| row.try_into().unwrap()).collect()
}

/// Seconds of the first hit, in lengths of the direction.
fn seconds(ray: &Ray, hit: &SceneHit) -> f64 {
    let lattice = Lattice::of(ray).expect("it hit");
    hit.time.numerator as f64 / hit.time.denominator as f64 / 2.0 / f64::from(1 << 24)
        * (-f64::from(lattice.exponent)).exp2()
}

/// Holds the hits of a frame to the exact tracer; gives how many were of the world, on the lattice and free.
fn judge(session: &Session, frames: &[Frame], rays: &[Ray], found: &[[u32; 24]]) -> [usize; 3] {
    let loaded = session.world().loaded();
    let scene = Scene::new(loaded.world.clone(), &loaded.instances, frames);
    let oracle = scene.oracle();
    let mut kinds = [0; 3];
    for (ray, row) in rays.iter().zip(found) {
        let expected = oracle.first_hit(ray);
        let t = expected.map(|hit| seconds(ray, &hit));
        // A hit at the very end of a ray may be on either side of it by rounding.
        if t.is_some_and(|t| ray.t_max < raxel_oracle::FAR && (t / f64::from(ray.t_max) - 1.0).abs() < 1e-6) {
            continue;
        }
        let Some(hit) = expected.filter(|_| t.is_some_and(|t| t <= f64::from(ray.t_max))) else {
            assert_eq!(row[3], 0, "nothing is hit by {ray:?}, but {row:?}; {expected:?}");
            continue;
        };
        let instance = hit.instance.map_or(u32::MAX, |index| index as u32);
        let [x, y, z] = hit.voxel.map(i32::cast_unsigned);
        assert_eq!(
            (row[3], row[7], [row[0], row[1], row[2]], row[8], row[10]),
            (1, instance, [x, y, z], hit.face, u32::from(hit.material)),
            "{ray:?}: {row:?} is not {hit:?}"
        );
        let (t, seen) = (seconds(ray, &hit), f64::from(f32::from_bits(row[11])));
        assert!((seen - t).abs() <= 6e-7 * t || t < 1e-36, "{ray:?}: t is {seen}, not {t}");
        let free = row[12] == 1;
        kinds[if hit.instance.is_none() { 0 } else { 1 + usize::from(free) }] += 1;
        // The cell is solid in the model, and its face is the one that the ray came in by.
        if let Some(index) = hit.instance {
            let model = &loaded.instances.models[loaded.instances.list[index].model];
            let cell = IVec3::new(row[4].cast_signed(), row[5].cast_signed(), row[6].cast_signed());
            assert_eq!(u32::from(model.materials[usize::from(model.voxels.voxel(cell))]), row[10], "{row:?}");
            if !free && hit.face < 6 {
                let step = |face: u32| {
                    let mut step = [0_i64; 3];
                    step[(face / 2) as usize] = if face & 1 == 1 { 1 } else { -1 };
                    step
                };
                let (anchor, frame) = (loaded.instances.list[index].anchor, &frames[index]);
                let from_anchor: [i64; 3] = std::array::from_fn(|i| i64::from(cell[i]) - anchor[i]);
                let here = frame.place(from_anchor).unwrap();
                assert_eq!(here.map(|c| (c as i32).cast_unsigned()), [x, y, z]);
                let beside = frame.place(std::array::from_fn(|i| from_anchor[i] + step(row[9])[i])).unwrap();
                assert_eq!(std::array::from_fn::<_, 3, _>(|i| beside[i] - here[i]), step(hit.face), "{row:?}");
            }
        }
        // A ray that left the face is not caught by the voxel that it left, and it does not begin inside of its model.
        if row[13] == 1 && row[14] == row[7] {
            assert_ne!([row[16], row[17], row[18]], [row[4], row[5], row[6]], "{ray:?} {row:?}");
        }
        let normal: f32 = [row[20], row[21], row[22]].iter().map(|n| f32::from_bits(*n).powi(2)).sum();
        assert!(hit.face == 6 || (normal - 1.0).abs() < 1e-5, "{row:?}");
    }
    kinds
}

/// The same for every sixteenth ray: the exact tracer asks each instance.
fn judge_some(session: &Session, frames: &[Frame], rays: &[Ray], found: &[[u32; 24]]) -> [usize; 3] {
    let rays: Vec<Ray> = rays.iter().step_by(16).copied().collect();
    let found: Vec<_> = found.iter().step_by(16).copied().collect();
    judge(session, frames, &rays, &found)
}

/// The world of a project as its file says it.
fn load(project: &Project) -> Loaded {
    let files = DiskFiles::new(&project.path("")).unwrap();
    let loaded = raxel_worldfile::load("worlds/test.toml", &files, &mut SourceMap::default());
    loaded.unwrap_or_else(|errors| panic!("{errors:#?}")).0
}

/// Every set of rays, aimed at the world and at where instances are.
fn rays_for(loaded: &Loaded, frames: &[Frame]) -> Vec<Ray> {
    let near = frames.iter().map(|frame| (IVec3::from_array(frame.cell), 1));
    let all = World::from_voxels(loaded.world.materials().to_vec(), loaded.world.voxels().chain(near));
    sets::ALL.iter().flat_map(|set| set.rays(&all, 256, 5)).collect()
}
