//! Lum (docs/rivals/light/lum.md): light that probes hand on, its first frame, fog, and instances drawn into copies of blocks
//! (`views/lum_requests.toml`). In `views/lum_live.toml`, models leave no trail, the params switch grass, waves and smoke, the wind moves the grass, and
//! the same frames give the same bytes.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use common::Project;
use raxel::{DebugTarget, Options, Session, Validation, Value};
use scenes::cuboid;

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

/// Counts the voxels in which the copy differs from the world's file and its grass: those of boats, and those of sparks.
const COUNT: &str = include_str!("fixtures/lum/count.comp");

#[test]
fn models_and_sparks_are_drawn_into_the_world_and_leave_no_trail() {
    let project = Project::shipped();
    project
        .write("shaders/rivals/light/lum/count.comp", COUNT)
        .write("graphs/rivals/light/views/counted.toml", include_str!("fixtures/lum/counted.toml"));
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

const LUM: &str = "graphs/rivals/light/lum.toml";
const REQUESTS: &str = "graphs/rivals/light/views/lum_requests.toml";
const WALL: &str = "wall = { albedo = [0.7, 0.6, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 40.0 }";

fn brightest(texels: &[[f32; 4]]) -> f32 {
    texels.iter().flat_map(|texel| &texel[..3]).fold(0.0, |a, b| a.max(*b))
}

/// A corridor of 384 voxels, three times as long as the rays of probes. Its walls reflect light only at the visible end.
fn corridor(project: &Project, lamp: bool) {
    let soot = "soot = { albedo = [0.0, 0.0, 0.0] }\n";
    let mut build =
        vec![cuboid("soot", [0, 0, 0], [384, 32, 32], "shell = 1"), cuboid("wall", [0, 0, 0], [1, 32, 32], "")];
    if lamp {
        build.push(cuboid("lamp", [380, 1, 1], [383, 31, 31], ""));
    }
    scenes::world(project, &format!("{soot}{WALL}"), &build, [12.5, 16.5, 16.5], [0.5, 16.5, 16.5], 60.0);
}

/// Rays of probes end after 128 voxels. There they take over the light of the probe. So a dark corridor of any length stays dark, and light goes on.
#[test]
fn probes_hand_on_the_light_of_what_is_far_away() {
    let project = Project::shipped();
    corridor(&project, false);
    let dark = scenes::frames(&mut scenes::open(&project, LUM, [16, 9], &[("sun_strength", 0.0)]), 24);
    assert!(brightest(&dark) == 0.0, "sky in a closed corridor: {}", brightest(&dark));
    // Ten bits would round this little light away.
    corridor(&project, true);
    let float = include_str!("fixtures/lum/float.toml");
    project.write("graphs/rivals/light/float.toml", float);
    let mut session = scenes::open(&project, "graphs/rivals/light/float.toml", [16, 9], &scenes::DARK);
    let early = brightest(&scenes::frames(&mut session, 1));
    let late = brightest(&scenes::frames(&mut session, 63));
    assert!(early == 0.0 && late > 0.0, "{early} in the first frame, {late} later");
}

/// A field that begins black takes a hundred frames to half of its light.
#[test]
fn the_field_does_not_begin_black() {
    let project = Project::shipped();
    let floor = cuboid("wall", [-64, 0, -64], [64, 16, 64], "");
    scenes::world(&project, WALL, &[floor], [0.5, 24.5, 0.5], [8.0, 16.0, 8.0], 60.0);
    for graph in [LUM, "graphs/rivals/light/lum_f32.toml"] {
        let mut session = scenes::open(&project, graph, [16, 9], &[]);
        let mut mean = |count| {
            let texels = scenes::frames(&mut session, count);
            texels.iter().map(|texel| f64::from(texel[1])).sum::<f64>() / texels.len() as f64
        };
        let (first, later) = (mean(4), mean(124));
        assert!(later > 0.0 && first > 0.6 * later, "{graph}: {first} in the fourth frame, {later} later");
    }
}

/// Thicker fog shows less of a lamp, whose own light is far above that of the field; without thickness there is none.
#[test]
fn fog_lies_between_the_eye_and_what_it_sees() {
    let project = Project::shipped();
    scenes::world(
        &project,
        WALL,
        &[cuboid("wall", [0, 0, 0], [64, 32, 32], "shell = 1"), cuboid("lamp", [60, 8, 8], [63, 24, 24], "")],
        [4.5, 16.5, 16.5],
        [63.5, 16.5, 16.5],
        20.0,
    );
    for graph in [LUM, "graphs/rivals/light/lum_f32.toml"] {
        let mut session = scenes::open(&project, graph, [16, 9], &scenes::DARK);
        let clear = brightest(&scenes::frames(&mut session, 8));
        session.set_param("fog", Value::Bool(true)).unwrap();
        let mut of = |thickness: f32| {
            session.set_param("fog_thickness", Value::F32(thickness)).unwrap();
            brightest(&scenes::frames(&mut session, 2))
        };
        let (none, thin, thick) = (of(0.0), of(0.01), of(0.1));
        // The field goes on changing a little.
        assert!((none / clear - 1.0).abs() < 1e-2, "{graph}: {none} for {clear}");
        assert!(thin < 0.8 * clear && thin > 0.4 * clear, "{graph}: {thin} for {clear}");
        assert!(thick < 0.3 * thin, "{graph}: {thick} for {thin}");
    }
}

/// A world with a hut, as a model in its voxels or as an instance, in a place and at an angle.
fn with_hut(project: &Project, instance: bool, position: [f64; 3], angles: &str) {
    let floor = cuboid("wall", [-40, 0, -40], [40, 2, 40], "");
    let hut = if instance {
        format!("[[instances]]\nmodel = \"hut\"\nposition = {position:?}\n{angles}\n")
    } else {
        format!("[[build]]\nop = \"model\"\nmodel = \"hut\"\norigin = {:?}\n", position.map(|c| c as i32))
    };
    // A mast, so that the world is as high in all cases.
    let mast = cuboid("wall", [-40, 2, -40], [-39, 60, -39], "");
    let models = "[models]\nhut = { file = \"models/hut.vox\" }\n".to_owned();
    scenes::world(project, WALL, &[models, floor, mast, hut], [30.5, 24.5, 30.5], [0.0, 6.0, 0.0], 60.0);
}

/// The hits of the pixels, with places and materials, and their light after some frames.
fn seen(session: &mut Session) -> (Vec<u8>, Vec<u8>, Vec<[f32; 4]>) {
    let light = scenes::frames(session, 3);
    (session.read_target("hit").unwrap().bytes, session.read_target("place").unwrap().bytes, light)
}

/// The number of voxels of instances in the copied blocks.
fn drawn(session: &mut Session) -> usize {
    let bytes = session.read_buffer("work", 0..16).unwrap();
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    let voxels = session.read_buffer("blocks", 0..u64::from(4 * word(&bytes[..4]))).unwrap();
    voxels.chunks_exact(4).filter(|voxel| word(voxel) >> 16 != 0).count()
}

fn open_requests(project: &Project) -> Session {
    let mut session = scenes::open(project, REQUESTS, [64, 36], &[]);
    for name in ["hit", "place", "work", "blocks"] {
        session.pin(name).unwrap();
    }
    session
}

/// An instance on the lattice is drawn where a model of the world's file would be: every ray of every pass meets the same.
#[test]
fn a_request_is_as_good_as_a_model_in_the_file() {
    let project = Project::shipped();
    with_hut(&project, false, [3.0, 2.0, -5.0], "");
    let in_file = seen(&mut open_requests(&project));
    with_hut(&project, true, [3.0, 2.0, -5.0], "");
    let mut session = open_requests(&project);
    let requested = seen(&mut session);
    assert!(in_file.0 == requested.0, "other voxels are seen");
    assert!(in_file.1 == requested.1, "they are seen elsewhere");
    let same = in_file.2.iter().zip(&requested.2).filter(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits)).count();
    assert_eq!(same, in_file.2.len(), "their light is another");
    assert!(drawn(&mut session) > 500);
}

/// At any place and turn, also in the air, an instance covers about as many voxels as its model has. It leaves nothing at its old place, and its parts
/// outside of the world are not drawn.
#[test]
fn requests_are_drawn_at_any_place_and_leave_no_trail() {
    let project = Project::shipped();
    with_hut(&project, true, [3.0, 2.0, -5.0], "");
    let count = |session: &mut Session| {
        scenes::frames(session, 2);
        drawn(session)
    };
    let voxels = count(&mut open_requests(&project));
    let all = voxels as f64;
    with_hut(&project, true, [3.25, 30.5, -5.75], "yaw = 27\npitch = 40\nroll = -10");
    let turned = count(&mut open_requests(&project)) as f64;
    // Walls of one voxel that lie askew miss some middles of cells.
    assert!((turned / all - 1.0).abs() < 0.15, "{turned} for {all}");
    with_hut(&project, true, [38.0, 2.0, -5.0], "");
    let cut = count(&mut open_requests(&project)) as f64;
    assert!(cut > 0.2 * all && cut < 0.9 * all, "{cut} for {all}");

    let slide = "slide = { param = \"sail\", along = [1, 0, 0], default = 0.0 }";
    with_hut(&project, true, [3.0, 2.0, -5.0], slide);
    let mut session = open_requests(&project);
    let first = seen(&mut session);
    session.set_param("sail", Value::F32(12.0)).unwrap();
    let moved = seen(&mut session);
    assert!(first.0 != moved.0 && drawn(&mut session) == voxels);
    session.set_param("sail", Value::F32(0.0)).unwrap();
    let back = seen(&mut session);
    assert!(first.0 == back.0 && first.1 == back.1, "a trail is left");
}

#[test]
fn requests_without_room_are_named() {
    let project = Project::shipped();
    with_hut(&project, true, [3.0, 2.0, -5.0], "");
    project.edit(REQUESTS, "size = { count = 1024, stride = 4 }", "size = { count = 2, stride = 4 }");
    let mut session = open_requests(&project);
    scenes::frames(&mut session, 4);
    let counted = session.counted();
    assert!(counted.len() == 1 && format!("{counted:?}").contains("all slots are taken"), "{counted:?}");
    // Blocks with a slot are drawn.
    assert!(drawn(&mut session) > 0);
}
