//! Promises of lighting systems besides their light: they come to rest, light of removed things goes, and their limits are reported.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use std::collections::{BTreeMap, BTreeSet};

use common::Project;
use raxel::world::{World, vox};
use raxel::{Options, Session, Validation, Value};
use raxel_edit::{Brush, Operation};
use raxel_graph::plan::{Lifetime, ResourceDesc};
use raxel_measure::light::{Bench, Effort, Scene};
use scenes::{DARK, cuboid, effort, frames, open, scene, systems, world};

/// Mean luminance of a picture.
fn luminance(texels: &[[f32; 4]]) -> f64 {
    let of =
        |texel: &[f32; 4]| 0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2]);
    texels.iter().map(of).sum::<f64>() / texels.len() as f64
}

/// A closed room of 12 × 8 × 12 with a lamp of 2 × 2 voxels in its ceiling, which the camera does not see.
fn room(project: &Project) {
    let materials = "wall = { albedo = [0.7, 0.6, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 30.0 }";
    let build = [
        cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"),
        cuboid("wall", [3, 0, 3], [5, 4, 5], ""),
        cuboid("lamp", [6, 7, 6], [8, 8, 8], ""),
    ];
    world(project, materials, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
}

/// Means of the light in each of some frames.
fn means(session: &mut Session, count: u32) -> Vec<f64> {
    (0..count).map(|_| luminance(&frames(session, 1))).collect()
}

/// Without slots, paths go on as if there were no cache: the light is the same.
/// Their buffers, pictures not counted: samples of as many items as there are pixels are small here. Of those of `hash_cache`, 32 MiB are samples of one frame.
#[test]
fn caches_of_light_take_the_memory_that_is_said() {
    let project = Project::shipped();
    room(&project);
    for (system, most) in [("face_cache", 59.5), ("hash_cache", 68.5), ("surface_cache", 50.5), ("surface_f32", 64.5)] {
        let session = open(&project, &common::graph_in(common::LIGHT, system), [16, 9], &[]);
        // All can be read here, those of passes for other worlds included, which this room does not count.
        let plan = session.plan().unwrap();
        let used = |id| plan.passes.iter().any(|p| plan.graph.pass(p.pass).accesses.iter().any(|a| a.resource == id));
        let kept = plan.resources.iter().filter(|resource| {
            let persistent = resource.lifetime == Lifetime::Persistent && used(resource.resource);
            matches!(resource.desc, ResourceDesc::Buffer(_)) && persistent
        });
        let mib = kept.map(|resource| resource.memory.size).sum::<u64>() as f64 / f64::from(1 << 20);
        assert!(mib > 0.9 * most && mib <= most, "{system}: {mib} MiB");
    }
}

#[test]
fn a_hash_cache_without_room_loses_no_light() {
    let project = Project::shipped();
    room(&project);
    let light = || {
        let mut session = open(&project, "graphs/rivals/light/hash_cache.toml", [48, 27], &DARK);
        session.set_param("tile", Value::I32(1)).unwrap();
        luminance(&frames(&mut session, 48))
    };
    let roomy = light();
    let slots = "RX_FACE_LOG2_SLOTS = 20u";
    project.edit("shaders/include/raxel/light/face_slots.glsl", slots, "RX_FACE_LOG2_SLOTS = 5u");
    let full = light();
    // Two bounces are a third of the light here.
    assert!((full / roomy - 1.0).abs() < 0.05, "{full} with 32 slots, {roomy} with 2^20");
}

/// The statistics of `face_cache`: slots that are taken, pixels without one, faces and cells in sight.
fn table(session: &mut Session) -> [u32; 3] {
    let mut word = |buffer: &str, at: u64| {
        u32::from_le_bytes(session.read_buffer(buffer, at..at + 4).unwrap().try_into().unwrap())
    };
    [word("cache", 44), word("queue", 48), word("queue", 12)]
}

/// Hills of steps that are narrower than a pixel, with room in the table for a part of what the picture sees.
fn steps(project: &Project, room: u32) {
    let build: Vec<String> =
        (0..48).map(|i| cuboid("wall", [0, -1, 4 * i], [192, (i * 5 % 9) + i / 4, 4 * i + 2], "")).collect();
    world(project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [96.5, 60.5, 260.5], [96.0, 0.0, 60.0], 60.0);
    project.edit(
        "shaders/light/face_cache/fit.glsl",
        "#define FIT_ROOM (RX_FACE_SLOTS / 32u * 9u)",
        &format!("#define FIT_ROOM {room}u"),
    );
}

const SKY: [(&str, f32); 2] = [("sun_strength", 0.0), ("sky_strength", 1.0)];

/// Far faces share slots as far as they must, and the light is the same.
#[test]
fn a_view_of_more_faces_than_there_is_room_for_is_kept_in_cells() {
    const SIZE: [u32; 2] = [128, 72];
    let project = Project::shipped();
    let light = |room: u32| {
        steps(&project, room);
        let mut session = open(&project, "graphs/light/face_cache.toml", SIZE, &SKY);
        for name in ["queue", "cache"] {
            session.pin(name).unwrap();
        }
        // Whole faces, however narrow, unless there is no room.
        session.set_param("grain", Value::F32(0.0)).unwrap();
        frames(&mut session, 1);
        let first = table(&mut session);
        let mean = luminance(&frames(&mut session, 63));
        let last = table(&mut session);
        project.edit(
            "shaders/light/face_cache/fit.glsl",
            &format!("#define FIT_ROOM {room}u"),
            "#define FIT_ROOM (RX_FACE_SLOTS / 32u * 9u)",
        );
        (mean, first, last)
    };
    let (exact, [_, _, faces], _) = light(1 << 20);
    assert!(faces > 3000, "{faces} faces in sight");
    let (shared, first, last) = light(1500);
    for [used, lost, seen] in [first, last] {
        assert!(lost == 0 && seen > 200 && seen < 2250 && used < 3000, "{used} slots, {seen} in sight, {lost} lost");
    }
    assert!((shared / exact - 1.0).abs() < 0.02, "{shared} in cells, {exact} on faces");
}

/// A camera that jumps between views takes the slots of the faces that it has left.
#[test]
fn faces_that_have_left_the_picture_give_their_slots_to_others() {
    const ROOM: u32 = 600;
    let project = Project::shipped();
    steps(&project, ROOM);
    let mut session = open(&project, "graphs/light/face_cache.toml", [128, 72], &SKY);
    for name in ["queue", "cache"] {
        session.pin(name).unwrap();
    }
    let mut most = 0;
    let mut all = 0;
    for i in 0..12 {
        let camera = *session.camera();
        // To and fro along the hills, by more than the picture shows.
        let cell = camera.cell + glam::IVec3::new(if i % 4 < 2 { 400 } else { -400 }, 0, 0) / 4;
        session.set_camera(raxel::Camera { cell, ..camera });
        for _ in 0..2 {
            frames(&mut session, 1);
            let [used, lost, seen] = table(&mut session);
            assert_eq!(lost, 0, "jump {i}");
            most = most.max(used);
            all += seen;
        }
    }
    assert!(all > 8 * ROOM, "{all}");
    assert!(most <= 2 * ROOM, "{most} slots are taken");
    // The number is that of the words in the table.
    let keys = session.read_buffer("cache", 656..656 + (4 << 20)).unwrap();
    let taken = keys.chunks_exact(4).filter(|word| word[3] >> 2 != 0).count();
    assert_eq!(taken as u32, table(&mut session)[0]);
}

/// A cell may hold faces of both sides of a thin wall: what pixels see alone counts.
#[test]
fn cells_of_a_dark_room_keep_no_light_of_outside() {
    let project = Project::shipped();
    let build = [
        cuboid("wall", [0, 0, 0], [12, 8, 12], "shell = 1"),
        // Ledges outside, of all directions, in the cells of the walls.
        cuboid("wall", [12, 0, 3], [14, 6, 5], ""),
        cuboid("wall", [-2, 3, 3], [0, 4, 9], ""),
        cuboid("wall", [2, 8, 2], [6, 10, 6], ""),
    ];
    world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [1.5, 4.5, 10.5], [8.0, 1.0, 4.0], 60.0);
    let bright = [("sun_strength", 1000.0), ("sky_strength", 1000.0)];
    let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &bright);
    session.set_param("grain", Value::F32(64.0)).unwrap();
    let texels = frames(&mut session, 16);
    assert!(texels.iter().all(|texel| texel[..3] == [0.0; 3]), "{:?}", texels.iter().find(|texel| texel[0] > 0.0));
}

/// The session's lamp, taken out by an edit.
fn take_lamp(session: &mut Session) {
    let lamp = Operation::sphere([7.0, 7.5, 7.0], 1.0, Brush::Subtract);
    assert!(session.edit(&[lamp]).unwrap() > 0);
}

/// Frames until so little is left of the light of a lamp that an edit has removed, as the pages of these systems claim.
const GONE_AFTER: [(&str, usize); 6] =
    [("face_cache", 2), ("surface_f32", 2), ("gi_svgf", 10), ("hash_cache", 10), ("many_lamps", 10), ("ddgi", 10)];

#[test]
fn light_of_a_lamp_that_an_edit_takes_out_goes_and_comes_back() {
    let project = Project::shipped();
    room(&project);
    for (system, most) in GONE_AFTER {
        let mut session = open(&project, &common::graph_in(common::LIGHT, system), [24, 14], &DARK);
        let before = *means(&mut session, 24).last().unwrap();
        assert!(before > 0.1, "{system}: {before}");
        take_lamp(&mut session);
        let after = means(&mut session, most as u32);
        assert!(*after.last().unwrap() < 0.05 * before, "{system}: of {before}, {after:?} are left");
        assert!(session.undo().unwrap());
        let again = *means(&mut session, 24).last().unwrap();
        assert!((again / before - 1.0).abs() < 0.25, "{system}: {again} after an undo, {before} before");
    }
}

/// Path tracers go on for as long as one looks, and the texels of `surface_cache` have their ticks.
const RESTLESS: [&str; 5] = ["reference", "reference_centre", "wavefront", "wavefront_sorted", "surface_cache"];

#[test]
fn a_still_camera_under_still_light_stops_working() {
    let project = Project::shipped();
    room(&project);
    for graph in systems(&project) {
        let name = graph.rsplit('/').next().unwrap().trim_end_matches(".toml");
        if RESTLESS.contains(&name) {
            continue;
        }
        let mut session = open(&project, &graph, [16, 9], &DARK);
        frames(&mut session, 513);
        let done = frames(&mut session, 1);
        assert_eq!(session.frame().unwrap().dispatched, 0, "{graph}");
        assert_eq!(frames(&mut session, 1), done, "{graph}");
        // A change wakes it.
        session.set_param("sky_strength", Value::F32(0.5)).unwrap();
        assert!(session.frame().unwrap().dispatched > 0, "{graph}");
    }
}

/// Texels keep the same light as whole faces: of a lamp in a closed room, and of a sun and a sky over it.
#[test]
fn texels_of_floats_have_the_light_of_whole_faces() {
    let project = Project::shipped();
    let light = |graph: &str, params: &[(&str, f32)], texels_from: Option<f32>| {
        let mut session = open(&project, graph, [48, 27], params);
        if let Some(pixels) = texels_from {
            session.set_param("texels_from", Value::F32(pixels)).unwrap();
        }
        let mean = luminance(&frames(&mut session, 128));
        let given = texels_from.map(|_| {
            let bytes =
                session.read_buffer("unwrapped", 4 * (1_048_576 + 65_536)..4 * (1_048_576 + 65_536 + 1)).unwrap();
            u32::from_le_bytes(bytes[..4].try_into().unwrap())
        });
        (mean, given)
    };
    let open_land = [("sun_strength", 2.0), ("sky_strength", 0.5), ("sun_elevation", 50.0)];
    for (lit_by, params) in [("a lamp", &DARK[..]), ("sun and sky", &open_land)] {
        if lit_by == "a lamp" {
            room(&project);
        } else {
            let build = [cuboid("wall", [0, 0, 0], [16, 1, 16], ""), cuboid("wall", [5, 1, 5], [8, 6, 8], "")];
            world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [14.5, 9.5, 18.5], [7.0, 1.0, 6.0], 50.0);
        }
        let (whole, _) = light("graphs/light/face_cache.toml", params, None);
        let (texels, given) = light("graphs/rivals/light/surface_f32.toml", params, Some(1.0));
        assert!(given.unwrap() > 20, "{lit_by}: only {given:?} faces have texels");
        assert!((texels / whole - 1.0).abs() < 0.04, "{lit_by}: {texels} in texels, {whole} on whole faces");
        let (far, given) = light("graphs/rivals/light/surface_f32.toml", params, Some(1000.0));
        assert_eq!(given, Some(0), "{lit_by}: no face is a thousand pixels wide");
        assert!((far / whole - 1.0).abs() < 0.04, "{lit_by}: {far} without texels, {whole} on whole faces");
    }
}

/// Lamps of three colours and powers on both sides of a wall, most of them hidden from most places.
fn lamps(project: &Project) {
    let materials = "wall = { albedo = [0.5, 0.5, 0.5] }\nred = { albedo = [1.0, 0.4, 0.3], emission = 6.0 }\n\
                     blue = { albedo = [0.3, 0.5, 1.0], emission = 3.0 }\nwhite = { albedo = [1.0, 1.0, 1.0], emission = 1.0 }";
    let mut build = vec![cuboid("wall", [-2, -1, -2], [26, 0, 26], ""), cuboid("wall", [11, 0, 4], [13, 6, 20], "")];
    for i in 0..12 {
        let (x, z) = (1 + i * 7 % 23, 2 + i * 11 % 21);
        let height = 1 + i % 3;
        build.push(cuboid(["red", "blue", "white"][i as usize % 3], [x, height, z], [x + 1, height + 1, z + 1], ""));
    }
    world(project, materials, &build, [12.0, 16.0, 30.0], [12.0, 0.0, 11.0], 55.0);
}

#[test]
fn points_on_lamps_that_are_used_again_add_no_light_and_take_none() {
    let project = Project::shipped();
    lamps(&project);
    project.write(
        "graphs/light/raw.toml",
        "extends = \"../rivals/light/many_lamps.toml\"\nname = \"raw\"\n[params.rounds]\ndefault = 0\n[params.reused]\ndefault = 20\n",
    );
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(Effort { pan: 8, lag: 12, ..effort(&project, [64, 40], 32, 128) });
    let references = bench.references(&scene).unwrap();
    let outcome = bench.system("graphs/light/raw.toml", &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    let moving = outcome.pan.unwrap().judged;
    for judged in outcome.still.iter().map(|point| &point.judged).chain([&moving]) {
        assert!(judged.bias2.abs() <= 4.0 * judged.bias2_se, "{judged:?}");
    }
    // All of the light: its mean differs from the reference's by no more than the noise of both.
    let part = outcome.mean / references.about.mean - 1.0;
    assert!(part.abs() < 0.01, "{part}");
    let noise: Vec<f64> = outcome.still.iter().map(|point| point.judged.noise).collect();
    assert!(noise.windows(2).all(|pair| pair[1] < pair[0]), "{noise:?}");
    assert!(outcome.lag.as_ref().unwrap().to_5_percent.is_some_and(|frames| frames <= 10), "{:?}", outcome.lag);
}

/// Smoothing asks for the variance of a mean. A pixel that has seen little light does not know its own variance. Without its neighbours' variance
/// it stayed dark beside them, and bias² was twice as large here.
#[test]
fn smoothing_does_not_leave_pixels_dark_that_have_been_unlucky() {
    let project = Project::shipped();
    lamps(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 16, 128));
    let references = bench.references(&scene).unwrap();
    let variance = std::fs::read_to_string(project.path("shaders/rivals/light/gi/variance.comp")).unwrap();
    let [with, without] = ["i < 9", "i < 0"].map(|turns| {
        project.write("shaders/rivals/light/gi/variance.comp", variance.replace("i < 9", turns));
        let outcome = bench.system("graphs/rivals/light/many_lamps.toml", &scene, &references).unwrap();
        (outcome.still[0].judged, outcome.mean / references.about.mean - 1.0)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(with.0.error < 0.7 * without.0.error, "{with:?} {without:?}");
}

/// Lists of lamps that are known to light a place: the same light as by power alone, with less noise.
#[test]
fn lamps_that_are_known_add_no_light_and_take_none() {
    let project = Project::shipped();
    lamps(&project);
    project.write(
        "graphs/light/known.toml",
        "extends = \"face_cache.toml\"\nname = \"known\"\n[params.smooth]\ndefault = false\n[params.grain]\ndefault = 0.0\n",
    );
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 32, 256));
    let references = bench.references(&scene).unwrap();
    let sum = "known_sum += known_share(words[k]);";
    let [with, without] = [sum, "known_sum += 0.0;"].map(|text| {
        project.edit("shaders/light/face_cache/known_lamps.glsl", sum, text);
        let outcome = bench.system("graphs/light/known.toml", &scene, &references).unwrap();
        project.edit("shaders/light/face_cache/known_lamps.glsl", text, sum);
        (outcome.mean / references.about.mean - 1.0, outcome.still.last().unwrap().judged.noise)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(with.0.abs() < 0.02 && (with.0 - without.0).abs() < 0.015, "{with:?} {without:?}");
    assert!(with.1 < 0.85 * without.1, "{with:?} {without:?}");
}

/// Three lamps over a floor, and under it a sealed cellar with thousands of them, which take nearly all draws by power.
fn cellar(project: &Project) {
    let materials = "wall = { albedo = [0.5, 0.5, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 6.0 }";
    let mut build = vec![
        cuboid("wall", [-2, -8, -2], [50, 0, 50], ""),
        cuboid("lamp", [0, -6, 0], [48, -5, 48], ""),
        "[[build]]\nop = \"box\"\nmode = \"subtract\"\nmin = [0, -5, 0]\nmax = [48, -3, 48]\n".to_owned(),
        cuboid("wall", [23, 0, 14], [25, 7, 34], ""),
    ];
    for [x, y, z] in [[14, 2, 20], [30, 4, 16], [36, 1, 33]] {
        build.push(cuboid("lamp", [x, y, z], [x + 1, y + 1, z + 1], ""));
    }
    world(project, materials, &build, [24.0, 26.0, 60.0], [24.0, 0.0, 24.0], 50.0);
}

/// Faces share found lamps with the faces around them, among thousands of lamps that no face sees. The light is the same as by power alone, with a
/// fraction of the error.
#[test]
fn lamps_that_are_found_among_thousands_are_known_to_a_region() {
    let project = Project::shipped();
    cellar(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 24, 256));
    let references = bench.references(&scene).unwrap();
    let file = "shaders/light/face_cache/known_lamps.glsl";
    let cells = ("i < KNOWN_EACH / 4u && lists;", "i < 0u;");
    let regions = ("size < REGION_SIZES && lists;", "size < 0u;");
    let [both, no_regions, neither] = [&[][..], &[regions], &[cells, regions]].map(|left_out| {
        for (text, other) in left_out {
            project.edit(file, text, other);
        }
        let outcome = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        for (text, other) in left_out {
            project.edit(file, other, text);
        }
        (outcome.mean / references.about.mean - 1.0, outcome.still.last().unwrap().judged)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(both.0.abs() < 0.04, "{both:?}");
    assert!(both.1.error < 0.8 * no_regions.1.error, "{both:?} {no_regions:?}");
    assert!(both.1.error < 0.3 * neither.1.error, "{both:?} {neither:?}");
}

/// The light of lamps that are drawn alike, to compare drawing them by their power with: the same light, with more noise where lamps
/// differ.
#[test]
fn lamps_that_are_drawn_alike_give_the_same_light() {
    let project = Project::shipped();
    lamps(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 32, 128));
    let references = bench.references(&scene).unwrap();
    let [by_power, alike] = ["reference_centre", "views/even_lamps"].map(|graph| {
        let outcome = bench.system(&common::graph_in(common::LIGHT, graph), &scene, &references).unwrap();
        [outcome.still[0].judged, outcome.still.last().unwrap().judged]
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(alike[1].bias2.abs() <= 4.0 * alike[1].bias2_se, "{alike:?}");
    // A frame has 1.26 times the noise here.
    assert!(alike[0].noise > 1.1 * by_power[0].noise, "{alike:?} {by_power:?}");
}

/// Slats over a dark floor, under the sun alone. A camera that has come past the slats sees the same as a still one in its first frame. Half
/// shadows have less noise than one ray a pixel leaves.
#[test]
fn shadows_keep_their_edges_while_the_camera_moves() {
    let project = Project::shipped();
    let slats = (-8..12).map(|i| cuboid("floor", [5 * i, 4, -20], [5 * i + 2, 6, 20], ""));
    let build: Vec<String> = std::iter::once(cuboid("floor", [-60, -1, -40], [80, 0, 40], "")).chain(slats).collect();
    world(&project, "floor = { albedo = [0.1, 0.1, 0.1] }", &build, [10.5, 26.0, 34.5], [10.0, 0.0, 4.0], 50.0);
    let scene = Scene { params: vec![("sky_strength".to_owned(), 0.0)], ..scene() };
    let mut bench = Bench::new(Effort { pan: 8, ..effort(&project, [96, 54], 1, 32) });
    let references = bench.references(&scene).unwrap();
    let brute = bench.system("graphs/light/reference_centre.toml", &scene, &references).unwrap();
    let outcome = bench.system("graphs/rivals/light/sun_history.toml", &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    let (still, moving) = (outcome.still[0].judged, outcome.pan.unwrap().judged);
    assert!(moving.error < 1.5 * still.error, "{moving:?} {still:?}");
    assert!(still.noise < 0.5 * brute.still[0].judged.noise, "{still:?} {:?}", brute.still[0]);
}

/// While lamps change a little in each frame, old samples count less, so faces get twice as many new ones.
#[test]
fn faces_get_more_samples_while_light_changes() {
    let project = Project::shipped();
    room(&project);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &DARK);
    session.set_param("paths", Value::F32(0.1)).unwrap();
    session.pin("queue").unwrap();
    let mut listed = |change: f32| {
        let mut sum = 0;
        for frame in 0..24_u8 {
            session.set_param("lamp_strength", Value::F32(1.0 + change * f32::from(frame))).unwrap();
            frames(&mut session, 1);
            let bytes = session.read_buffer("queue", 0..4).unwrap();
            // The number of faces in sight is known from the second frame on.
            sum += if frame < 8 { 0 } else { u32::from_le_bytes(bytes.try_into().unwrap()) };
        }
        sum
    };
    let [changing, still] = [listed(0.02), listed(0.0)];
    assert!(changing > 3 * still / 2, "{changing} and {still}");
}

#[test]
fn faces_that_know_their_light_take_their_turn_less_often() {
    let project = Project::shipped();
    room(&project);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &DARK);
    session.pin("queue").unwrap();
    // Samples that are listed, and those that all faces in sight would have, by their width.
    let listed = |session: &mut Session, count: u32| {
        frames(session, count);
        let bytes = session.read_buffer("queue", 0..12).unwrap();
        [0, 8].map(|at| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
    };
    let [first, all] = listed(&mut session, 1);
    assert!(first >= all && all > 100, "{first} of {all}");
    let seen = u32::from_le_bytes(session.read_buffer("queue", 12..16).unwrap().try_into().unwrap());
    assert!(all > 3 * seen / 2, "{seen} faces, most of them wide, would have {all} samples");
    let [later, all] = listed(&mut session, 47);
    assert!(later > 0 && later < all / 2, "{later} of {all}");
    // Their cached light is stale.
    session.set_param("lamp_strength", Value::F32(0.25)).unwrap();
    let [changed, all] = listed(&mut session, 1);
    assert!(changed >= all, "{changed} of {all}");
}

/// The light that sunny faces send on changes fast near a shadow that moves. So old samples of faces there hardly count, and those of all others do.
#[test]
fn faces_near_a_moving_shadow_forget_sooner() {
    let project = Project::shipped();
    let build = [cuboid("wall", [-60, 0, -60], [60, 3, 60], ""), cuboid("wall", [0, 3, 0], [2, 12, 2], "")];
    world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [1.5, 20.5, 30.5], [0.0, 3.0, 0.0], 60.0);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &[("sun_elevation", 30.0)]);
    session.pin("queue").unwrap();
    // Entries of the list, and those of faces that are late.
    let late = |session: &mut Session, degrees: f32| {
        for step in 0..12u8 {
            session.set_param("sun_azimuth", Value::F32(200.0 + degrees * f32::from(step))).unwrap();
            frames(session, 1);
        }
        let mut words = |from: u64, count: u64| {
            let bytes = session.read_buffer("queue", from..from + 4 * count).unwrap();
            bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect::<Vec<_>>()
        };
        let count = words(0, 1)[0];
        let entries = words(60, u64::from(count));
        (entries.len(), entries.iter().filter(|entry| *entry >> 28 & 1 != 0).count())
    };
    let (entries, still) = late(&mut session, 0.0);
    assert!(entries > 0 && still == 0, "{still} of {entries} under a sun that stands still");
    let (entries, moving) = late(&mut session, 0.5);
    assert!(moving > 0 && moving < entries / 2, "{moving} of {entries} under a sun that moves");
}

#[test]
fn first_hits_by_way_of_half_resolution_change_no_byte() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/menger.toml"), project.path("worlds/test.toml")).unwrap();
    // Sides that 2 does not divide.
    let light = |graph: &str| frames(&mut open(&project, graph, [61, 35], &[]), 3);
    assert_eq!(light("graphs/rivals/light/halfres.toml"), light("graphs/rivals/light/sun_history.toml"));
}

/// The place of a path in its queue changes only the time.
#[test]
fn sorting_rays_changes_no_byte() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/menger.toml"), project.path("worlds/test.toml")).unwrap();
    let mut sessions = ["wavefront", "wavefront_sorted"]
        .map(|name| open(&project, &common::graph_in(common::LIGHT, name), [61, 35], &[]));
    let [light, sorted] = sessions.each_mut().map(|session| frames(session, 3));
    assert_eq!(light, sorted);
    // There is a pass more in each of the 12 rounds.
    let [passes, sorted] = sessions.each_mut().map(|session| session.frame().unwrap().dispatched);
    assert!(sorted >= passes + 12, "{sorted} and {passes} dispatches");
}

/// Faces of one plane share their noise: less of it in a few frames, and in the end the light that each has found itself.
#[test]
fn faces_of_a_plane_share_noise_and_not_light() {
    let project = Project::shipped();
    room(&project);
    let bench = |frames: u32| {
        let mut bench = Bench::new(effort(&project, [64, 36], frames, 512));
        let scene = scene();
        let references = bench.references(&scene).unwrap();
        let shared = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        let own = "shaders/light/face_cache/soften.comp";
        project.edit(own, "soft[slot] = soft_pack(result);", "soft[slot] = soft_pack(own.rgb);");
        let alone = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        project.edit(own, "soft[slot] = soft_pack(own.rgb);", "soft[slot] = soft_pack(result);");
        assert_eq!(bench.complaints(), &[] as &[String]);
        [shared, alone].map(|outcome| outcome.still.last().unwrap().judged)
    };
    let [shared, alone] = bench(4);
    assert!(shared.noise < 0.6 * alone.noise, "{shared:?} {alone:?}");
    let [shared, alone] = bench(256);
    assert!(shared.noise < alone.noise && shared.error < 1.25 * alone.error, "{shared:?} {alone:?}");
}

/// A face is kept in quarters from a width in pixels on that grows with the noise of samples, and as a whole below it.
#[test]
fn wide_faces_are_kept_in_quarters_where_there_is_little_noise() {
    const SIZE: [u32; 2] = [96, 54];
    const QUARTERS: f32 = 4.0;
    let project = Project::shipped();
    // The noise of samples, and the numbers of faces wider than the param: kept as a whole, and in quarters.
    let kept = |camera: [f64; 3], params: &[(&str, f32)]| {
        let mut session = open(&project, "graphs/light/face_cache.toml", SIZE, params);
        for name in ["queue", "hit", "place", "slot"] {
            session.pin(name).unwrap();
        }
        session.set_param("quarters", Value::F32(QUARTERS)).unwrap();
        frames(&mut session, 40);
        let noise = f32::from_le_bytes(session.read_buffer("queue", 40..44).unwrap().try_into().unwrap());
        let threshold = f64::from(QUARTERS * (16.0 * noise).max(1.0));
        let hits = session.read_target("hit").unwrap().integers().unwrap();
        let slots = session.read_target("slot").unwrap().integers().unwrap();
        let places = session.read_target("place").unwrap().floats();
        let mut faces = BTreeMap::new();
        for ((hit, slot), place) in hits.iter().zip(&slots).zip(&places) {
            let face = hit[3] >> 16 & 7;
            if hit[3] == u32::MAX || slot[0] == u32::MAX {
                continue;
            }
            let quarter = usize::from(place[0] >= 0.5) + 2 * usize::from(place[1] >= 0.5);
            let voxel = [hit[0] as i32, hit[1] as i32, hit[2] as i32];
            let slots: &mut [BTreeSet<u32>; 4] = faces.entry((voxel, face)).or_default();
            slots[quarter].insert(slot[0]);
        }
        let mut wide = [0, 0];
        for ((voxel, face), slots) in &faces {
            let axis = (face >> 1) as usize;
            let along = |i: usize| {
                let middle = if i == axis { f64::from(face & 1) } else { 0.5 };
                f64::from(voxel[i]) + middle - camera[i]
            };
            let square: f64 = (0..3).map(|i| along(i).powi(2)).sum();
            let width = 0.5 * f64::from(SIZE[1]) / (30_f64.to_radians().tan() * square.sqrt());
            // Widths so close to the limit that the shader's floats may decide otherwise.
            if (width / threshold - 1.0).abs() < 1e-3 {
                continue;
            }
            let all: BTreeSet<_> = slots.iter().flatten().collect();
            let parts = slots.iter().filter(|slots| !slots.is_empty()).count();
            assert!(slots.iter().all(|slots| slots.len() <= 1), "a part of {voxel:?} {face} has {slots:?}");
            let quartered = width >= threshold;
            assert_eq!(
                all.len(),
                if quartered { parts } else { 1 },
                "{voxel:?} {face}: {width} px of {threshold}, {slots:?}"
            );
            if width >= f64::from(QUARTERS) && parts > 1 {
                wide[usize::from(quartered)] += 1;
            }
        }
        (noise, wide)
    };
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    let camera = [16.5, 4.5, 30.5];
    world(&project, wall, &[cuboid("wall", [0, 0, 0], [32, 1, 32], "")], camera, [16.0, 0.0, 16.0], 60.0);
    let (noise, [whole, quarters]) = kept(camera, &[("sun_strength", 0.0), ("sky_strength", 1.0)]);
    assert!(noise > 0.0 && noise < 1.0 / 16.0, "{noise}");
    assert!(whole == 0 && quarters > 50, "{whole} whole, {quarters} in quarters");
    room(&project);
    let (noise, [whole, _]) = kept([1.5, 4.5, 11.5], &DARK);
    assert!(noise > 1.0 / 16.0 && whole > 50, "{noise}, {whole} whole");
}

/// Without lamps, paths of a picture end early, with the same light.
#[test]
fn paths_that_end_early_lose_no_light() {
    let project = Project::shipped();
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    // A yard that is seen from within, lit by the sky and a high sun.
    let build = [
        cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"),
        "[[build]]\nop = \"box\"\nmin = [3, 8, 3]\nmax = [10, 9, 10]\nmode = \"subtract\"\n".to_owned(),
    ];
    world(&project, wall, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
    let light = || {
        let params = [("sun_strength", 2.0), ("sky_strength", 1.0), ("sun_elevation", 75.0)];
        let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &params);
        session.pin("queue").unwrap();
        let light = luminance(&frames(&mut session, 128));
        let lamps = session.read_buffer("queue", 44..48).unwrap();
        (light, u32::from_le_bytes(lamps.try_into().unwrap()))
    };
    let (long, lamps) = light();
    assert_eq!(lamps, 0);
    let update = "name     = \"update\"\n";
    project.edit("graphs/light/face_cache.toml", update, &format!("{update}defines  = {{ SHORT_PATHS = 1 }}\n"));
    let (short, _) = light();
    assert!((short / long - 1.0).abs() < 0.03, "{short} by short paths, {long} by long ones");
    assert!((short - long).abs() > 0.0, "no path ended earlier");
}

/// Light of paths in a lamp's room. Half of the long paths end at each place, and a lottery picks some of the rays to lamps that would
/// bring little light.
#[test]
fn paths_and_rays_that_are_left_out_lose_no_light() {
    let project = Project::shipped();
    room(&project);
    let light = || {
        let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &DARK);
        luminance(&frames(&mut session, 160))
    };
    let shipped = light();
    project.edit("shaders/light/face_cache/update.comp", "#define PATH_DEEP 5u\n", "");
    project.edit("shaders/light/face_cache/update.comp", "#define PATH_LAMP_LEAST (0.3 * queue.bright)\n", "");
    let all = light();
    assert!((shipped / all - 1.0).abs() < 0.03, "{shipped} as shipped, {all} by all paths and rays");
    assert!((shipped - all).abs() > 0.0, "none was left out");
}

/// Without slots, faces show only their sunlight and their own emission. This room has neither, and nothing goes wrong.
#[test]
fn a_face_cache_without_room_shows_no_light_that_it_does_not_know() {
    let project = Project::shipped();
    room(&project);
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u", "RX_FACE_PROBES = 0u");
    let full = frames(&mut open(&project, "graphs/light/face_cache.toml", [48, 27], &DARK), 24);
    assert!(full.iter().all(|texel| texel[..3] == [0.0; 3]), "{full:?}");
}

/// Averages go on until they show their goal, from above and from below: within a thousandth, where averages of few bits stop at
/// hundredths. The sky has one radiance, so there is no noise.
#[test]
fn averages_reach_what_they_are_to_show() {
    let project = Project::shipped();
    let sky = "return strength * rx_sky(dir, sun);";
    project.edit("shaders/include/raxel/light/environment.glsl", sky, "return vec3(strength);");
    let floor = cuboid("floor", [-40, 0, -40], [40, 1, 40], "");
    world(&project, "floor = { albedo = [0.5, 0.5, 0.5] }", &[floor], [0.5, 9.5, 0.5], [0.6, 0.0, 0.4], 50.0);
    for system in ["face_cache", "surface_f32", "gi_svgf", "hash_cache"] {
        let params = [("sun_strength", 0.0), ("sky_strength", 0.2)];
        let mut session = open(&project, &common::graph_in(common::LIGHT, system), [12, 7], &params);
        // Without noise, faces would take their turn seldom.
        if system == "face_cache" {
            session.set_param("rarely", Value::I32(1)).unwrap();
        }
        for before in [0.25, 0.16] {
            session.set_param("sky_strength", Value::F32(before)).unwrap();
            frames(&mut session, 32);
            session.set_param("sky_strength", Value::F32(0.2)).unwrap();
            for texel in frames(&mut session, 480) {
                let away = texel[..3].iter().map(|channel| (channel / 0.1 - 1.0).abs()).fold(0.0, f32::max);
                assert!(away < 1e-3, "{system}, from {before}: {texel:?} is {away} away from 0.1");
            }
        }
    }
}

/// The world of docs/light/beauty.md around a model that raxel does not ship. raxel names the missing file, and any model of its size
/// becomes a hall with windows and lamps.
#[test]
fn a_solid_model_is_hollowed_out_and_lit_from_inside() {
    let project = Project::shipped();
    let page = std::fs::read_to_string(common::repository().join("docs/light/church.toml")).unwrap();
    project.write("worlds/test.toml", page);
    let missing = project.raxel(&["check", "worlds/test.toml"]).exits(3).stdout;
    assert!(missing.contains("error[RX0001]: `worlds/church.vox` does not exist"), "{missing}");

    // Up to where the street begins.
    let block = (0..124 * 24 * 64).map(|i| (glam::IVec3::new(i % 124, i / 124 % 24, i / (124 * 24)), 1));
    let block = World::from_voxels(raxel_oracle::scenes::materials(), block);
    project.write("worlds/church.vox", vox::export(&block).unwrap());
    let only = |param: &str, value: f32| {
        let mut params = vec![("sun_strength", 0.0), ("sky_strength", 0.0), ("lamp_strength", 0.0)];
        params.extend([("sun_azimuth", 165.0), ("sun_elevation", 42.0)]);
        params.retain(|(name, _)| *name != param);
        params.push((param, value));
        let texels = frames(&mut open(&project, "graphs/light/reference.toml", [32, 18], &params), 64);
        let lit = texels.iter().filter(|texel| texel[1] > 0.0).count();
        (lit * 100 / texels.len(), luminance(&texels))
    };
    // Of a solid block, the camera would see nothing at all.
    for (source, strength) in [("sun_strength", 14.0), ("sky_strength", 1.0), ("lamp_strength", 1.0)] {
        let (percent, light) = only(source, strength);
        assert!(percent > 50 && light > 1e-3, "{source}: {light} in {percent} % of the pixels");
    }
}

/// If a world is larger than the box of all keys on an axis, the box lies around the camera on that axis.
#[test]
fn faces_of_a_wide_or_high_world_keep_light_wherever_the_camera_is() {
    let project = Project::shipped();
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    let sky = [("sun_strength", 0.0), ("sky_strength", 1.0)];
    let light = |graph: &str, build: &[String], [x, y]: [i32; 2]| {
        let [x, y] = [x, y].map(f64::from);
        world(&project, wall, build, [x + 8.0, y + 9.5, 20.5], [x + 8.0, y, 8.0], 60.0);
        luminance(&frames(&mut open(&project, graph, [48, 27], &sky), 32))
    };
    let floor = |[x, y]: [i32; 2]| cuboid("wall", [x, y, 0], [x + 16, y + 1, 16], "");
    let (wide, high) = ([[-70_001, 0], [0, 0], [70_000, 0]], [[0, -3_000], [0, 0], [0, 5_000]]);
    for graph in ["graphs/light/face_cache.toml", "graphs/rivals/light/surface_f32.toml"] {
        let alone = light(graph, &[floor([0, 0])], [0, 0]);
        for places in [wide, high] {
            for at in places {
                let among = light(graph, &places.map(floor), at);
                assert!((among / alone - 1.0).abs() < 0.01, "{graph}: {among} at {at:?}, {alone} in a small world");
            }
        }
    }
}

#[test]
fn cubes_of_an_octree_are_where_the_voxels_are() {
    let project = Project::shipped();
    let [mut cubes, mut exact] = ["graphs/rivals/light/views/octree_view.toml", "graphs/inspect.toml"].map(|graph| {
        Session::open(Options {
            project: Some(project.root().into()),
            graph: Some(graph.into()),
            world: Some("worlds/menger.toml".into()),
            size: [96, 54],
            pinned: vec![if graph.ends_with("inspect.toml") { "hit" } else { "empty" }.to_owned()],
            validation: Validation::Required,
            ..Options::default()
        })
        .unwrap()
    });
    exact.frame().unwrap();
    let hit: Vec<bool> =
        exact.read_target("hit").unwrap().integers().unwrap().iter().map(|texel| texel[1] != 7).collect();
    let mut met = |level: u32| -> Vec<bool> {
        cubes.set_param("level", Value::U32(level)).unwrap();
        cubes.frame().unwrap();
        let texels = cubes.read_target("empty").unwrap();
        texels.integers().unwrap().iter().map(|texel| texel[0] != 6).collect()
    };
    let voxels = met(0);
    // The view's steps are those of floats: a ray along an edge may go on the other side of it.
    let other = voxels.iter().zip(&hit).filter(|(a, b)| a != b).count();
    assert!(other <= hit.len() / 200, "{other} of {} rays", hit.len());
    // A cube holds its voxels, so what a voxel hides its cube hides too.
    let mut before = voxels;
    for level in [1, 3, 5] {
        let now = met(level);
        let lost = before.iter().zip(&now).filter(|(smaller, larger)| **smaller && !**larger).count();
        assert!(lost <= hit.len() / 200, "level {level}: {lost} rays meet nothing");
        assert!(now.iter().filter(|met| **met).count() < hit.len(), "some rays meet nothing at all");
        before = now;
    }
}

#[test]
fn references_are_made_once_for_what_they_follow_from() {
    let project = Project::shipped();
    room(&project);
    let scene = scene();
    let run = |paths: u32| {
        let mut bench = Bench::new(Effort { keep: true, ..effort(&project, [16, 9], 1, paths) });
        bench.references(&scene).unwrap()
    };
    let (made, again) = (run(16), run(16));
    assert!(!made.about.kept && again.about.kept);
    assert_eq!((made.halves, &made.about.hashes), (again.halves, &again.about.hashes));
    assert_eq!((made.about.dark, made.about.paths), (again.about.dark, again.about.paths));
    // Another effort, another voxel, another shader: another reference.
    assert!(!run(32).about.kept && run(32).about.kept);
    project.edit("worlds/test.toml", "max = [5, 4, 5]", "max = [5, 5, 5]");
    assert!(!run(16).about.kept && run(16).about.kept);
    project.edit(
        "shaders/light/reference.comp",
        "const uint MOST_VERTICES = 256u;",
        "const uint MOST_VERTICES = 255u;",
    );
    assert!(!run(16).about.kept && run(16).about.kept);
    // A broken reference is made again.
    let folder = project.path(".raxel/cache/light");
    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 4, "{files:?}");
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() - 4]).unwrap();
    }
    assert!(!run(16).about.kept && run(16).about.kept);
}

/// The messages of a session about full tables by its last frame, which has ended.
fn full(session: &mut Session, count: u32) -> Vec<String> {
    frames(session, count);
    session.wait().unwrap();
    session.take_messages().into_iter().map(|said| format!("{}: {}", said.code, said.message)).collect()
}

/// Tables of 2^20 slots are large enough for a room. In a table without a place for any key, a message has the number of pixels whose face
/// has no slot, or of samples that were dropped.
#[test]
fn full_tables_are_said_with_what_they_lack() {
    let project = Project::shipped();
    room(&project);
    let systems = [
        ("face_cache", "pixels show only sunlight and emission, for their faces found no slot in the table: "),
        ("surface_cache", "pixels show only emission, for their faces found no slot in the table: "),
        ("surface_f32", "pixels show only sunlight and emission, for their faces found no slot in the table: "),
        ("hash_cache", "samples of light were not kept, for their cells found no slot in the table: "),
    ];
    let said = |system: &str| {
        let mut session = open(&project, &common::graph_in(common::LIGHT, system), [48, 27], &DARK);
        let said = full(&mut session, 6);
        (said, session.counted().len())
    };
    for (system, _) in systems {
        assert_eq!(said(system), (Vec::new(), 0), "{system}");
    }
    // No slot may hold a key.
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u", "RX_FACE_PROBES = 0u");
    for (system, says) in systems {
        let (said, now) = said(system);
        let [said] = &said[..] else { panic!("{system}: {said:?}") };
        let count = said.strip_prefix("RX0411: ").and_then(|said| said.strip_prefix(says));
        let count: u32 = count.and_then(|count| count.parse().ok()).unwrap_or_else(|| panic!("{system}: {said}"));
        // All 1,296 pixels of the picture, which all see faces.
        let expected = if system == "hash_cache" { 1..=4 * 1296 } else { 600..=1296 };
        assert!(expected.contains(&count) && now == 1, "{system}: {count}, {now} now");
    }
}

/// With two blocks of texels, faces that are seen take them from each other.
#[test]
fn texels_that_faces_in_sight_take_from_each_other_are_said() {
    let project = Project::shipped();
    room(&project);
    let said = || {
        let mut session = open(&project, "graphs/rivals/light/surface_f32.toml", [48, 27], &DARK);
        session.set_param("texels_from", Value::F32(1.0)).unwrap();
        full(&mut session, 6)
    };
    assert!(said().is_empty());
    project.edit("shaders/light/unwrapped.glsl", "const uint BLOCKS = 65536u;", "const uint BLOCKS = 2u;");
    let said = said();
    let says = "RX0411: faces in sight lost their texels to others in sight, and begin anew: ";
    assert!(matches!(&said[..], [one] if one.starts_with(says)), "{said:?}");
}

/// Air in a closed room gets no light from outside, and a polished face mirrors none.
#[test]
fn a_closed_room_without_a_lamp_is_black() {
    let project = Project::shipped();
    let materials = "wall = { albedo = [0.7, 0.6, 0.5] }\npolished = { albedo = [0.7, 0.6, 0.5], roughness = 0.1 }";
    let build = [cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"), cuboid("polished", [3, 0, 3], [5, 4, 5], "")];
    world(&project, materials, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
    for graph in ["graphs/beauty.toml", "graphs/beauty_glass.toml"] {
        let mut session = open(&project, graph, [48, 27], &[]);
        session.pin("seen").unwrap();
        frames(&mut session, 3);
        let seen = session.read_target("seen").unwrap().floats();
        let lit = seen.iter().filter(|texel| texel[..3] != [0.0; 3]).count();
        assert_eq!(lit, 0, "{graph}: pixels with light");
    }
}

/// A camera in water sees a lit ceiling through the surface; beyond Snell's window the surface mirrors the dark ground.
#[test]
fn a_camera_in_water_sees_through_the_surface_within_snells_window() {
    let project = Project::shipped();
    let materials = "water = { albedo = [0.3, 0.6, 0.7], transparency = 0.9, roughness = 0.05 }
mud = { albedo = [0.05, 0.05, 0.05] }
lamp = { albedo = [1.0, 1.0, 1.0], emission = 1.0 }";
    let build = [
        cuboid("mud", [-40, -1, -40], [40, 0, 40], ""),
        cuboid("water", [-40, 0, -40], [40, 10, 40], ""),
        cuboid("lamp", [-40, 20, -40], [40, 21, 40], ""),
    ];
    let light = |look_at: [f64; 3]| {
        world(&project, materials, &build, [0.5, 5.5, 0.5], look_at, 10.0);
        let mut session = open(&project, "graphs/beauty.toml", [48, 27], &DARK);
        session.pin("seen").unwrap();
        frames(&mut session, 2);
        luminance(&session.read_target("seen").unwrap().floats())
    };
    let (within, beyond) = (light([0.5, 30.5, 2.5]), light([30.5, 15.5, 2.5]));
    assert!(within > 0.4 && within < 1.0 && beyond > 0.0, "{within} within, {beyond} beyond");
    assert!(within > 2.0 * beyond, "{within} within, {beyond} beyond");
}

/// A slanted ray crosses many cells of a thick pane: sunlight still comes through.
#[test]
fn a_low_sun_shines_through_a_pane_of_five_voxels() {
    let project = Project::shipped();
    let materials = "floor = { albedo = [0.7, 0.6, 0.5] }\nglass = { albedo = [0.9, 0.4, 0.3], transparency = 0.9 }";
    let build = [cuboid("floor", [-60, -1, -60], [60, 0, 60], ""), cuboid("glass", [-60, 8, -60], [60, 13, 60], "")];
    world(&project, materials, &build, [0.5, 6.5, 0.5], [4.5, 0.0, 4.5], 60.0);
    let mut session = open(&project, "graphs/beauty_glass.toml", [48, 27], &[("sun_elevation", 25.0)]);
    session.pin("stained").unwrap();
    frames(&mut session, 2);
    let lit = session.read_target("stained").unwrap().floats().iter().filter(|texel| texel[0] > 0.0).count();
    assert!(lit > 48 * 27 * 9 / 10, "{lit} pixels have sunlight");
}
