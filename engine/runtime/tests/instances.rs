//! Instances on the device: every ray hits what whole numbers say, of the world, of models on its lattice and of models turned in any way.
//! On a real device with the validation layer on.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(clippy::float_cmp, reason = "values are compared with the very ones that were written")]

mod project;

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use glam::IVec3;
use project::{Project, Sessions, assert_silent};
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_graph::checked::Value;
use raxel_layouts::instances::{Frame, Pose, Rotation};
use raxel_oracle::instances::{Scene, SceneHit};
use raxel_oracle::sets::{self, Random};
use raxel_oracle::{Lattice, Ray};
use raxel_runtime::session::Validation;
use raxel_runtime::{OpenError, Options, Session};
use raxel_world::{Material, World, vox};
use raxel_worldfile::Loaded;

const RAYS: usize = sets::ALL.len() * 256;

/// Traces the rays of a file, and from each hit one more ray outwards.
/// The graph; `"RAYS"` is their number.
const GRAPH: &str = include_str!("fixtures/instances/instances.toml");

const SHADER: &str = include_str!("fixtures/instances/trace.comp");

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

#[test]
fn every_ray_hits_what_whole_numbers_say() {
    for (seed, origin) in [[0, 0, 0], [-999_999_000, 5, 1_000_003], [-63, 70, 130]].into_iter().enumerate() {
        let seed = seed as u64;
        let project = project(origin, seed, &random_instances(origin, seed));
        let loaded = load(&project);
        let frames = loaded.instances.frames(|_| None);
        let rays = rays_for(&loaded, &frames);
        assert_eq!(rays.len(), RAYS);
        fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
        let mut session = open(&project);
        let found = hits(&mut session);
        let [world, lattice, free] = judge(&session, &frames, &rays, &found);
        assert!(world > 300 && lattice > 150 && free > 300, "{world} {lattice} {free} of {RAYS}");
        assert_silent(&session);
    }
}

#[test]
fn thousands_of_them_are_exact() {
    let instances = r#"[[instances]]
model = "crate"
position = [-200, -3, -200]
yaw = 30
count = [32, 1, 32]
step = [12.5, 0, 12.75]
[[instances]]
model = "crate"
position = [-200, 20, -200]
count = [32, 3, 32]
step = [13, 15, 14]
"#;
    let project = project([0; 3], 9, instances);
    let loaded = load(&project);
    assert_eq!(loaded.instances.list.len(), 4096);
    let frames = loaded.instances.frames(|_| None);
    assert!(frames[..1024].iter().all(|frame| matches!(frame.turn, Rotation::Free(_))));
    // From above all of them, at one of them.
    let mut random = Random::new(12);
    let rays: Vec<Ray> = (0..RAYS)
        .map(|_| {
            let target = frames[random.below(4096) as usize].cell;
            let mut around = |range: i32| random.below(range as u64) as i32 - range / 2;
            let cell = [target[0] + around(600), 320 + around(200), target[2] + around(600)];
            let dir = std::array::from_fn(|axis| (target[axis] - cell[axis]) as f32 + around(7) as f32 / 3.0);
            Ray::new(cell, [random.unit(), random.unit(), random.unit()], dir)
        })
        .collect();
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    let found = hits(&mut session);
    let [_, lattice, free] = judge_some(&session, &frames, &rays, &found);
    assert!(lattice > 100 && free > 3, "{lattice} {free}");
    assert_silent(&session);
}

#[test]
fn params_move_them_and_nothing_runs_while_they_stand() {
    let instances = r#"[[instances]]
model = "crate"
position = [-20, 3, 4]
slide = { param = "tide", along = [0.0, 0.5, 0.0] }
[[instances]]
model = "crate"
position = [30, 3, 4]
turn = { param = "spin", about = [0.5, 0.0, 0.5] }
[[instances]]
model = "mast"
position = [1, 20, 4]
turn = { param = "wind", axis = "z", default = 10 }
"#;
    let project = project([0; 3], 9, instances);
    let loaded = load(&project);
    let of = |tide: f64, spin: f64| {
        let value = move |param: &str| match param {
            "tide" => Some(tide),
            "spin" => Some(spin),
            _ => None,
        };
        loaded.instances.frames(value)
    };
    let places = [(0.0, 0), (7.0, 0), (8.0, 90), (8.0, 33), (0.0, 0)];
    let frames: Vec<_> = places.iter().map(|&(tide, spin)| of(tide, f64::from(spin))).collect();
    assert!(frames[2][..2].iter().all(|frame| matches!(frame.turn, Rotation::Quarter(_))));
    assert!(matches!(frames[1][0].turn, Rotation::Free(_)));
    let rays = rays_for(&loaded, &frames[0]);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    for ((tide, spin), frames) in places.into_iter().zip(&frames) {
        session.set_param("tide", Value::F32(tide as f32)).unwrap();
        session.set_param("spin", Value::I32(spin)).unwrap();
        let found = hits(&mut session);
        judge(&session, frames, &rays, &found);
        assert_eq!(session.frame().unwrap().dispatched, 0);
    }
    assert_silent(&session);
}

/// Puts the first instances where a buffer says, one record a thread, and traces the rays of a file two frames long.
const POSE_SHADER: &str = include_str!("fixtures/instances/pose.comp");

const POSE_PASS: &str = r#"
[params.kind]
type = "u32"
default = 0
range = [0, 3]
[params.wrong]
type = "u32"
default = 0
range = [0, 2]
[buffers.wanted]
source = "file.data/wanted.bin"
[buffers.poses]
source = "world.poses"
[[passes]]
name = "pose"
shader = "pose.comp"
dispatch = { threads = [64, 1, 1] }
bind = { poses = "poses", Wanted = "wanted" }
push = { kind = "param.kind", wrong = "param.wrong" }
"#;

/// The words that the shader reads, and the same as the file of a world would say it: a cell, a place in it, three angles.
fn wanted(count: usize, seed: u64) -> (Vec<u8>, Vec<Pose>) {
    let mut random = Random::new(seed);
    let mut words = Vec::new();
    let mut poses = Vec::new();
    for i in 0..count {
        let cell: [i32; 3] = std::array::from_fn(|_| random.below(70) as i32 - 35);
        let free = i % 2 == 1;
        let place: [f32; 3] = std::array::from_fn(|_| if free { random.unit() * 3.0 - 1.0 } else { 0.0 });
        let turn: [f32; 3] =
            std::array::from_fn(|_| if free { random.unit() * 700.0 - 350.0 } else { 90.0 * random.below(4) as f32 });
        words.extend(cell.map(i32::cast_unsigned));
        words.extend(place.map(f32::to_bits));
        words.push(std::f32::consts::FRAC_1_SQRT_2.to_bits());
        words.extend(turn.map(f32::to_bits));
        words.extend([0, 0]);
        let position = std::array::from_fn(|axis| f64::from(cell[axis]) + f64::from(place[axis]));
        poses.push(Pose::new(position, turn.map(f64::from)));
    }
    (words.into_iter().flat_map(u32::to_le_bytes).collect(), poses)
}

/// A world of 60 instances whose first 48 a shader puts elsewhere, the file and the poses; and the graph's text without the pass.
fn posed(seed: u64) -> (Project, Loaded, Vec<Pose>) {
    let project = project([0; 3], seed, &random_instances([0; 3], seed));
    let (bytes, poses) = wanted(48, seed + 100);
    fs::write(project.path("data/wanted.bin"), bytes).unwrap();
    project.write("graphs/instances.toml", format!("{GRAPH}{POSE_PASS}").replace("\"RAYS\"", &RAYS.to_string()));
    project.write("shaders/pose.comp", POSE_SHADER);
    let loaded = load(&project);
    (project, loaded, poses)
}

#[test]
fn shaders_move_them_two_frames_later_and_exactly() {
    let (project, loaded, poses) = posed(3);
    let home = loaded.instances.frames(|_| None);
    let own: Vec<Option<Pose>> = poses.iter().copied().map(Some).collect();
    let away = loaded.instances.frames_with(&own, |_| None);
    assert!(away[..48].iter().any(|frame| matches!(frame.turn, Rotation::Quarter(_))));
    assert_eq!(away[48..], home[48..]);
    // A turn about Z by a quarter, from a quaternion of `f32`, is one of whole numbers.
    let turned: Vec<_> = poses
        .iter()
        .map(|pose| Some(Pose { rotation: Pose::new([0.0; 3], [0.0, 0.0, 90.0]).rotation, ..*pose }))
        .collect();
    let turned = loaded.instances.frames_with(&turned, |_| None);
    let rays = rays_for(&loaded, &home);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    let expect = |session: &mut Session, frames: &[Frame], name: &str| {
        let found = hits(session);
        assert!(session.instance_frames() == frames, "{name}");
        judge_some(session, frames, &rays, &found);
    };
    expect(&mut session, &home, "nothing is written");
    for (kind, before, after) in [(1, &home, &away), (3, &away, &turned), (2, &turned, &home), (1, &home, &away)] {
        session.set_param("kind", Value::U32(kind)).unwrap();
        expect(&mut session, before, "written");
        expect(&mut session, before, "on its way");
        expect(&mut session, after, "there");
        expect(&mut session, after, "and there it stays");
        assert_eq!(
            session.frame().unwrap().dispatched,
            0,
            "a pass that has written what it would write again is not run"
        );
    }
    // Another beginning has no past.
    session.reset();
    session.set_param("kind", Value::U32(0)).unwrap();
    for _ in 0..4 {
        expect(&mut session, &home, "from the start");
    }
    assert!(session.take_messages().is_empty());
    assert_silent(&session);
}

#[test]
fn what_is_wrong_with_poses_of_shaders_is_said_once_and_left_out() {
    let (project, loaded, poses) = posed(5);
    let own: Vec<Option<Pose>> = poses.iter().copied().map(Some).collect();
    let away = loaded.instances.frames_with(&own, |_| None);
    let rays = rays_for(&loaded, &away);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    // Without the memo the pass writes them in every frame.
    let mut session = Project::open_with(Options { memo: false, ..options(&project) });
    session.set_param("kind", Value::U32(1)).unwrap();
    let mut run = |wrong: u32| -> Vec<String> {
        session.set_param("wrong", Value::U32(wrong)).unwrap();
        let mut said = Vec::new();
        for _ in 0..4 {
            let found = hits(&mut session);
            let frames = session.instance_frames();
            judge_some(&session, &frames, &rays, &found);
            said.extend(session.take_messages());
        }
        assert!(session.instance_frames() == away);
        said.iter().map(|message| format!("{}: {}", message.code, message.message)).collect()
    };
    let said = run(1);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("RX0475: passes have written poses that are wrong: the pose of instance 1 has a number"),
        "{said:?}"
    );
    // 48 writers of 401 poses each: all but 16,384 are lost, and the same pose again is no other one.
    let said = run(2);
    assert_eq!(said, ["RX0476: passes have written 2864 more poses than the 16384 that one frame can take"]);
    assert_eq!(run(0), [""; 0]);
    assert_silent(&session);
}

#[test]
fn a_param_that_the_graph_lacks_is_named() {
    let instances =
        "[[instances]]\nmodel = \"dot\"\nposition = [0, 0, 0]\nslide = { param = \"tides\", along = [0, 1, 0] }\n";
    let project = project([0; 3], 9, instances);
    let Err(OpenError::Project { diagnostics, .. }) = Session::open(options(&project)) else { panic!("it opens") };
    let found =
        diagnostics.iter().find(|found| found.code.as_str() == "RX0447").unwrap_or_else(|| panic!("{diagnostics:#?}"));
    assert_eq!(
        found.message,
        "instances of `worlds/test.toml` are moved by `tides`, which is not a param of the graph"
    );
    assert_eq!(found.help, ["did you mean `tide`?"]);
}

#[test]
fn the_flock_flies() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let mut session = Project::open_with(Options {
        project: Some(root.clone()),
        graph: Some(root.join("graphs/examples/flock.toml")),
        world: Some(root.join("worlds/flock.toml")),
        size: [96, 54],
        validation: Validation::Required,
        ..Options::default()
    });
    let home = session.instance_frames();
    assert_eq!(home.len(), 512);
    let mut places = Vec::new();
    for _ in 0..8 {
        session.frame().unwrap();
        places.push(session.instance_frames());
    }
    assert!(places[1] == home, "not before the third frame");
    let [before, after] = [&places[5], &places[7]];
    for ((frame, before), home) in after.iter().zip(before).zip(&home) {
        assert!(frame != before && frame != home, "every bird flies on");
        // About a voxel in a thirtieth of a second.
        assert!((0..3).all(|axis| (frame.cell[axis] - before.cell[axis]).abs() <= 3), "{frame:?} {before:?}");
    }
    assert!(session.take_messages().is_empty());
    assert_silent(&session);
}
