//! What moves in Lum's world (`graphs/rivals/light/views/lum_live.toml`): models that are drawn into the voxels leave no trail, grass, waves and smoke are there
//! when they are asked for, the wind moves the grass, and the same frames give the same bytes.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::Project;
use raxel::runtime::debug_target::DebugTarget;
use raxel::{Options, Session, Validation, Value};

const SIZE: [u32; 2] = [64, 36];
/// Material of cells of grass and of sparks, as in `shaders/rivals/light/lum/matter.glsl`.
const GRASS: u32 = 0xfff0;
const SPARK: u32 = 0xfff1;
/// Voxels of `worlds/models/boat.vox`, and how many boats sail.
const BOAT: f64 = 279.0;
const BOATS: f64 = 2.0;

fn open(project: &Project, graph: &str, pinned: &[&str]) -> Session {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path("worlds/meadow.toml")),
        size: SIZE,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{graph}: {error}"));
    let warnings: Vec<_> = session.warnings().iter().map(|warning| &warning.message).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
    for name in pinned {
        session.pin(name).unwrap();
    }
    session.set_debug_target(DebugTarget::resource("radiance")).unwrap();
    session
}

fn frames(session: &mut Session, count: u32) {
    for _ in 0..count {
        session.frame().unwrap();
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// Material of what each pixel sees; `None` for the sky.
fn materials(session: &mut Session) -> Vec<Option<u32>> {
    let texels = session.read_target("hit").unwrap();
    let words = texels.bytes.chunks_exact(16).map(|texel| i32::from_le_bytes(texel[12..].try_into().unwrap()));
    words.map(|word| (word >= 0).then_some(word as u32 & 0xffff)).collect()
}

/// Counts the voxels of the world in which the copy is not what the world's file and its grass say: of boats, and of sparks.
const COUNT: &str = "#version 460
#define LIVE
#include <raxel/world.glsl>
#include <raxel/world/still.glsl>
#include \"matter.glsl\"
#include \"live/still.glsl\"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430) buffer Counts { uint counts[4]; };
layout(push_constant) uniform Push { ivec3 world_min; uint grass; ivec3 world_max; } push;
void main() {
    ivec3 cell = push.world_min + ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, push.world_max))) return;
    uint now = rx_material(cell), still = still_cell(cell, push.grass);
    if (now == GRASS_CELL) atomicAdd(counts[2], 1u);
    if (now != still) atomicAdd(counts[now == SPARK ? 1 : 0], 1u);
    if (now != still && now == 0u) atomicAdd(counts[3], 1u);
}
";

#[test]
fn models_and_sparks_are_drawn_into_the_world_and_leave_no_trail() {
    let project = Project::shipped();
    project.write("shaders/rivals/light/lum/count.comp", COUNT).write(
        "graphs/rivals/light/views/counted.toml",
        "extends = \"lum_live.toml\"\nname = \"counted\"\n[buffers.counts]\nsize = 16\nclear = 0\n\
         [[passes]]\nname = \"count\"\nbefore = \"see\"\nshader = \"rivals/light/lum/count.comp\"\ndispatch = { threads = \"world\" }\n\
         bind = { world = \"live\", still = \"world\", Counts = \"counts\" }\n\
         push = { world_min = \"world.min\", world_max = \"world.max\", grass = \"material.grass\" }\n",
    );
    let mut session = open(&project, "graphs/rivals/light/views/counted.toml", &["counts"]);
    let counts = |session: &mut Session, count| -> Vec<f64> {
        frames(session, count);
        let bytes = session.read_buffer("counts", 0..16).unwrap();
        bytes.chunks_exact(4).map(|word| f64::from(u32::from_le_bytes(word.try_into().unwrap()))).collect()
    };
    let mut grass = None;
    for more in [1, 1, 6, 40] {
        let found = counts(&mut session, more);
        // A turned model covers as many voxels as it has, more or less.
        assert!((found[0] / (BOATS * BOAT) - 1.0).abs() < 0.15, "{found:?}");
        assert!(found[1] > 0.0 && found[1] <= 28.0, "{found:?}");
        assert!(found[3] == 0.0, "nothing of the world is missing: {found:?}");
        // Sparks may fly through grass.
        let first = *grass.get_or_insert(found[2]);
        assert!(found[2] > 1000.0 && (found[2] - first).abs() <= 28.0, "{found:?} after {first}");
    }
}

#[test]
fn blades_waves_and_smoke_are_there_when_they_are_asked_for() {
    let project = Project::shipped();
    let mut session = open(&project, "graphs/rivals/light/views/lum_live.toml", &["hit", "fine", "radiance"]);
    frames(&mut session, 2);
    let seen = materials(&mut session);
    let share =
        |seen: &[Option<u32>], of: u32| seen.iter().filter(|m| **m == Some(of)).count() as f64 / seen.len() as f64;
    assert!(share(&seen, GRASS) > 0.15, "{} of the picture is grass", share(&seen, GRASS));
    assert!(share(&seen, SPARK) > 0.0);
    let water =
        session.world().voxels().materials().iter().position(|material| material.name == "water").unwrap() as u32;
    let tilt = |session: &mut Session| {
        let seen = materials(session);
        let normals = session.read_target("fine").unwrap().floats();
        let wet = normals.iter().zip(&seen).filter(|(n, m)| **m == Some(water) && n[1] > 0.5);
        wet.map(|(n, _)| n[0].abs().max(n[2].abs())).fold(0.0, f32::max)
    };
    assert!(share(&seen, water) > 0.03 && tilt(&mut session) > 0.05);

    let light = session.read_target("radiance").unwrap().floats();
    assert!(light.iter().all(|texel| texel.iter().all(|c| c.is_finite() && *c >= 0.0)));
    // A calm without grass and smoke.
    session.set_param("waves", Value::F32(0.0)).unwrap();
    session.set_param("blades", Value::U32(0)).unwrap();
    frames(&mut session, 1);
    assert!(tilt(&mut session) < 1e-3, "calm water is level");
    let grass_left = share(&materials(&mut session), GRASS);
    assert!(
        grass_left < 0.1 * share(&seen, GRASS),
        "{grass_left}: only where rays have passed as many cells as they may"
    );
}

#[test]
fn the_wind_moves_the_grass_and_the_same_frames_are_the_same_bytes() {
    let project = Project::shipped();
    let picture = |count: u32| {
        let mut session = open(&project, "graphs/rivals/light/views/lum_live.toml", &["radiance", "wind"]);
        frames(&mut session, count);
        let wind = session.read_target("wind").unwrap().bytes;
        (session.read_target("radiance").unwrap().bytes, wind)
    };
    let (first, early) = picture(3);
    assert!(first == picture(3).0, "the same frames give the same bytes");
    let (later, late) = picture(12);
    assert!(first != later && early != late);
}
