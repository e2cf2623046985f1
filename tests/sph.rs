//! Water of particles (`graphs/light/views/sph.toml`). It stays in its box, comes to rest at its level and its density, and gains no energy. Every run
//! has the same bytes.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::Project;
use raxel::{DebugTarget, Options, Session, Validation, Value};

const COUNT: usize = 1200;
const BOX: [f64; 3] = [12.0, 16.0, 8.0];
const GRAVITY: f64 = 30.0;

/// The shipped graph with fewer particles in a smaller box.
fn open(project: &Project) -> Session {
    let text = format!(
        r#"extends = "sph.toml"
name = "small"
[targets.walls]
size = [12, 16, 8]
[buffers.particles]
size = {{ count = {COUNT}, stride = 32 }}
"#
    );
    project.write("graphs/light/views/small.toml", text);
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/light/views/small.toml")),
        world: Some(project.path("worlds/tank.toml")),
        size: [16, 9],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let warnings: Vec<_> = session.warnings().iter().map(|warning| &warning.message).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
    session.set_debug_target(DebugTarget::resource("particles")).unwrap();
    session
}

#[derive(Clone, Copy, Debug)]
struct Particle {
    at: [f64; 3],
    density: f64,
    speed: [f64; 3],
}

fn bytes(session: &mut Session, ticks: u32) -> Vec<u8> {
    for _ in 0..ticks {
        session.frame().unwrap();
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    session.read_buffer("particles", 0..32 * COUNT as u64).unwrap()
}

fn particles(session: &mut Session, ticks: u32) -> Vec<Particle> {
    let read = |words: &[u8], i: usize| f64::from(f32::from_le_bytes(words[4 * i..][..4].try_into().unwrap()));
    let particle = |words: &[u8]| Particle {
        at: [0, 1, 2].map(|i| read(words, i)),
        density: read(words, 3),
        speed: [4, 5, 6].map(|i| read(words, i)),
    };
    bytes(session, ticks).chunks_exact(32).map(particle).collect()
}

fn square(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum()
}

fn energy(particles: &[Particle]) -> f64 {
    particles.iter().map(|p| 0.5 * square(p.speed) + GRAVITY * p.at[1]).sum()
}

fn all_are_in_the_box(particles: &[Particle], when: u32) {
    for p in particles {
        assert!(p.at.iter().chain(&p.speed).all(|c| c.is_finite()), "{p:?} after {when} ticks");
        assert!((0..3).all(|i| (0.0..=BOX[i]).contains(&p.at[i])), "{p:?} after {when} ticks");
    }
}

#[test]
fn water_stays_in_its_box_and_comes_to_rest_at_its_level() {
    let project = Project::shipped();
    let mut session = open(&project);
    let first = particles(&mut session, 1);
    let start = energy(&first);
    let mut last = first;
    for ticks in (50..=1000).step_by(50) {
        last = particles(&mut session, if ticks == 50 { 49 } else { 50 });
        all_are_in_the_box(&last, ticks);
        let now = energy(&last);
        assert!(now <= start * 1.001, "{now} after {ticks} ticks, {start} at the start");
    }
    // Falling water has 20.
    let moving = (last.iter().map(|p| square(p.speed)).sum::<f64>() / COUNT as f64).sqrt();
    // Two particles a voxel.
    let level = COUNT as f64 / 2.0 / (BOX[0] * BOX[2]);
    let mut heights: Vec<f64> = last.iter().map(|p| p.at[1]).collect();
    heights.sort_by(f64::total_cmp);
    let top = heights[COUNT * 99 / 100];
    let within: Vec<f64> = last.iter().filter(|p| p.at[1] < level - 1.7).map(|p| p.density).collect();
    let mean = within.iter().sum::<f64>() / within.len() as f64;
    assert!((top - level).abs() < 1.0, "the water stands at {top}, not at {level}");
    assert!((mean - 1.0).abs() < 0.03, "density {mean}");
    assert!(moving < 1.0, "{moving} voxels a second");
}

#[test]
fn the_same_ticks_are_the_same_bytes() {
    let project = Project::shipped();
    let run = || bytes(&mut open(&project), 45);
    let first = run();
    assert!(first.chunks_exact(32).any(|particle| particle != &first[..32]));
    assert!(first == run());
}

#[test]
fn without_gravity_and_pressure_nothing_moves() {
    let project = Project::shipped();
    let mut session = open(&project);
    session.set_param("gravity", Value::F32(0.0)).unwrap();
    session.set_param("pressure", Value::F32(0.0)).unwrap();
    let first = particles(&mut session, 1);
    let mut places: Vec<[u64; 3]> = first.iter().map(|p| p.at.map(f64::to_bits)).collect();
    let mut later: Vec<[u64; 3]> = particles(&mut session, 20).iter().map(|p| p.at.map(f64::to_bits)).collect();
    places.sort_unstable();
    later.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), COUNT, "each has a place of its own");
    assert!(places == later);
}

/// The number of water voxels in the box by density, and in the copy of the world, and the number in which the two disagree.
const COUNT_WATER: &str = include_str!("fixtures/sph/count_water.comp");

#[test]
fn the_water_is_in_the_voxels_of_a_copy_of_the_world() {
    let project = Project::shipped();
    project.write("shaders/count_water.comp", COUNT_WATER).write(
        "graphs/light/views/counted.toml",
        format!(
            r#"extends = "sph.toml"
name = "counted"
[params.voxels]
default = true
[targets.walls]
size = [12, 16, 8]
[buffers.particles]
size = {{ count = {COUNT}, stride = 32 }}
[buffers.tally]
size = 16
clear = 0
[[passes]]
name = "count"
shader = "count_water.comp"
dispatch = {{ threads = "walls" }}
bind = {{ world = "wet", walls = "walls", field = "field", Tally = "tally" }}
"#
        ),
    );
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/light/views/counted.toml")),
        world: Some(project.path("worlds/tank.toml")),
        size: [32, 18],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    session.pin("tally").unwrap();
    let mut counts = |ticks: u32| {
        for _ in 0..ticks {
            session.frame().unwrap();
        }
        let messages = session.device().log().take();
        assert!(messages.is_empty(), "{messages:#?}");
        let bytes = session.read_buffer("tally", 0..16).unwrap();
        [0, 1, 2].map(|i| u32::from_le_bytes(bytes[4 * i..][..4].try_into().unwrap()))
    };
    // Two particles a voxel. Fallen water leaves nothing at its old place.
    for (ticks, after) in [(2, "2 ticks"), (40, "42")] {
        let [wet, water, wrong] = counts(ticks);
        assert!((COUNT as u32 / 4..COUNT as u32).contains(&wet), "{wet} wet voxels after {after}");
        assert_eq!((water, wrong), (wet, 0), "after {after}");
    }
}

/// The water as micro-voxels has the volume of the water as cubes.
#[test]
fn micro_voxels_follow_the_density() {
    let project = Project::shipped();
    let text = std::fs::read_to_string(project.path("graphs/light/views/sph_micro.toml")).unwrap();
    drop(open(&project));
    project
        .write("graphs/light/views/sph_micro.toml", text.replace("extends = \"sph.toml\"", "extends = \"small.toml\""));
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/light/views/sph_micro.toml")),
        world: Some(project.path("worlds/tank.toml")),
        size: [16, 9],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    for target in ["micro", "field"] {
        session.pin(target).unwrap();
    }
    session.set_debug_target(DebugTarget::resource("color")).unwrap();
    for _ in 0..40 {
        session.frame().unwrap();
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    let mut slices = |name: &str, count: u32| -> Vec<_> {
        (0..count).map(|z| session.read_texels(name, 0, 0, z).unwrap()).collect()
    };
    let bits: u32 = slices("micro", 8).iter().flat_map(|slice| &slice.bytes).map(|byte| byte.count_ones()).sum();
    let cubes = slices("field", 16).iter().flat_map(raxel::Texels::floats).filter(|texel| texel[0] > 0.5).count();
    let (micro, cubes) = (f64::from(bits) / 64.0, cubes as f64 / 8.0);
    assert!(cubes > 200.0 && (micro / cubes - 1.0).abs() < 0.1, "{micro} voxels of micro-voxels, {cubes} of cubes");
}
