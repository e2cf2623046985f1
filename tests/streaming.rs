//! Streamed worlds in a session: every picture equals that of the exact tracer over the wanted tiles.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "streaming/lamps.rs"]
mod lamps;

use std::path::PathBuf;

use common::{Display, Project, Run, RunRaxel, command, output};
use glam::IVec3;
use raxel::{Camera, Options, Session, Validation, Value};
use raxel_edit::{Brush, Operation};
use raxel_layouts::Layout;
use raxel_oracle::Oracle;
use raxel_oracle::camera::Pinhole;
use raxel_rivals as rivals;
use raxel_runtime::{OpenError, Saves};
use raxel_stream::streaming_range;
use raxel_stream::{TileKey, union};
use rayon::prelude::*;

const SIZE: [u32; 2] = [95, 57];
const MISS: [i32; 4] = [0, 0, 0, -1];

/// A small part of the shipped endless world, far enough for two levels above the voxels.
fn project() -> Project {
    let project = Project::shipped();
    project.edit("worlds/frontier.toml", "near       = 384", "near = 128");
    project.edit("worlds/frontier.toml", "far        = 24576", "far = 1000");
    project.edit("worlds/frontier.toml", "\"256 MiB\"", "\"100 MiB\"");
    project
}

fn options(project: &Project, graph: &str) -> Options {
    let path = |path: String| -> Option<PathBuf> { Some(project.path(&path)) };
    Options {
        project: Some(project.root().into()),
        graph: path(format!("graphs/{graph}.toml")),
        world: path("worlds/frontier.toml".to_owned()),
        size: SIZE,
        validation: Validation::Required,
        ..Options::default()
    }
}

fn open(project: &Project, graph: &str, pinned: &[&str]) -> Session {
    let pinned = pinned.iter().map(|name| (*name).to_owned()).collect();
    let session =
        Session::open(Options { pinned, ..options(project, graph) }).unwrap_or_else(|error| panic!("{error}"));
    assert!(session.warnings().is_empty(), "{:?}", session.warnings());
    session
}

fn silent(session: &Session) {
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// A camera's view of the tiles that it wants.
fn exact(session: &Session, camera: &Camera) -> Vec<[i32; 4]> {
    let streamed = session.world().streamed().expect("it is streamed");
    let tiles = session.world().tiles().expect("it is streamed");
    exact_of(session, camera, &streaming_range(streamed, tiles).tiles(camera.cell))
}

/// A camera's view of some tiles.
fn exact_of(session: &Session, camera: &Camera, shown: &[TileKey]) -> Vec<[i32; 4]> {
    let world = union(&**session.world().tiles().expect("it is streamed"), shown).unwrap();
    let pinhole = Pinhole {
        cell: camera.cell,
        frac: camera.frac,
        view_to_world: camera.view_to_world(),
        tan_half_fov: camera.tan_half_fov(f64::from(SIZE[0]) / f64::from(SIZE[1])),
    };
    let oracle = Oracle::new(&world);
    let hit = |ray: &_| {
        let Some(hit) = oracle.first_hit(ray).hit else { return MISS };
        let [x, y, z] = hit.voxel;
        [x, y, z, (hit.face + 8 * u32::from(hit.material)).cast_signed()]
    };
    pinhole.rays(SIZE).par_iter().map(hit).collect()
}

fn hits(session: &mut Session) -> Vec<[i32; 4]> {
    let texels = session.read_target("hit").unwrap().integers().expect("integers");
    texels.iter().map(|hit| hit.map(u32::cast_signed)).collect()
}

/// Near the origin, further on, turned about, at the other end of the world and back.
fn cameras(first: &Camera) -> Vec<Camera> {
    let mut cameras = vec![*first];
    let mut at = |cell: [i32; 3], yaw: f64, pitch: f64| {
        cameras.push(Camera { cell: IVec3::from_array(cell), yaw, pitch, ..*first });
    };
    at([130, 150, -200], 2.0, -0.3);
    at([130, 150, -200], 5.0, -0.8);
    at([1 << 29, 260, -(1 << 29) - 77], 1.0, -0.4);
    at([40, 160, 60], 0.5, -1.2);
    cameras
}

#[test]
fn pictures_of_a_streamed_world_are_exact_wherever_the_camera_goes() {
    let project = project();
    let mut session = open(&project, "bench/first_hit", &["hit"]);
    for (number, camera) in cameras(&session.camera().clone()).into_iter().enumerate() {
        session.set_camera(camera);
        session.frame().unwrap_or_else(|error| panic!("{error}"));
        let (found, expected) = (hits(&mut session), exact(&session, &camera));
        let wrong = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(wrong, 0, "camera {number}: {wrong} of {} pixels", found.len());
        let land = expected.iter().filter(|hit| **hit != MISS).count();
        assert!(land * 4 > expected.len(), "camera {number} sees {land} voxels");
        silent(&session);
    }
    let stats = session.stream().expect("it is bound").stats();
    assert_eq!((stats.missing, stats.pool.failed), (0, 0), "{stats:?}");
    assert!(stats.dropped > 0, "{stats:?}");
}

/// Generation of the light, and the serial of the world that it is for.
fn light_state(session: &mut Session) -> [u32; 2] {
    let bytes = session.read_buffer("state", 0..16).unwrap();
    [0, 12].map(|at| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn light_is_kept_while_land_is_loaded() {
    let project = project();
    let mut session = open(&project, "light/face_cache", &["state"]);
    let frame = |session: &mut Session| session.frame().unwrap_or_else(|error| panic!("{error}"));
    frame(&mut session);
    let before = light_state(&mut session);
    for _ in 0..3 {
        let camera = *session.camera();
        session.set_camera(Camera { cell: camera.cell + IVec3::new(64, 0, 0), ..camera });
        frame(&mut session);
    }
    let after = light_state(&mut session);
    assert!(after[1] > before[1], "nothing was loaded: {before:?}, {after:?}");
    assert_eq!(after[0], before[0], "light began anew");
    // An edit is another matter, as soon as it is shown.
    let edit = Operation::set(session.camera().cell.to_array(), 1);
    assert_eq!(session.edit(&[edit]).unwrap(), 1);
    frame(&mut session);
    let edited = light_state(&mut session);
    assert_eq!(edited[0], after[0] + 1, "an edit did not reach the light");
    frame(&mut session);
    assert_eq!(light_state(&mut session)[0], edited[0], "it reached it twice");
    // So is another sun.
    session.set_param("sun_elevation", Value::F32(70.0)).unwrap();
    frame(&mut session);
    assert!(light_state(&mut session)[0] > edited[0]);
    silent(&session);
}

/// The number of pixels that see a voxel. Every pixel equals its exact ray.
fn assert_exact(session: &mut Session) -> usize {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let camera = *session.camera();
    let (found, expected) = (hits(session), exact(session, &camera));
    let wrong = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
    assert_eq!(wrong, 0, "{wrong} of {} pixels", found.len());
    silent(session);
    expected.iter().filter(|hit| **hit != MISS).count()
}

/// A crater where the camera looks, a tower that is higher than all land, and a tree.
fn dig_and_build(session: &Session) -> [Vec<Operation>; 2] {
    let [x, y, z] = session.pick([47, 40], 4096.0).unwrap().expect("land").exact.voxel;
    let stone = session.scene().material("stone").expect("it is in the file");
    let tower = Operation::Cylinder {
        axis: 1,
        base: [x + 20, y, z - 30].map(|c| i64::from(c) << 8),
        radius: 6 << 8,
        height: 600,
        brush: Brush::Add(stone),
    };
    let tree = Operation::Model {
        model: "tree".to_owned(),
        orientation: raxel::world::Orientation::quarter_turns(1).to_vox(),
        position: [x - 12, y + 20, z],
        mode: raxel::world::Mode::Add,
    };
    [vec![Operation::sphere([x, y, z].map(f64::from), 14.0, Brush::Subtract)], vec![tower, tree]]
}

#[test]
fn edits_of_a_streamed_world_are_seen_exactly_and_saved() {
    let project = project();
    project.edit("worlds/frontier.toml", "[camera]", "[save]\npath = \"saves/frontier\"\n\n[camera]");
    let open = |saves: Saves| {
        let pinned = vec!["hit".to_owned()];
        Session::open(Options { saves, pinned, ..options(&project, "bench/first_hit") })
    };
    let mut session = open(Saves::Write).unwrap_or_else(|error| panic!("{error}"));
    assert_exact(&mut session);
    let before = hits(&mut session);
    for step in dig_and_build(&session) {
        assert!(session.edit(&step).unwrap() > 0);
        let shown = hits(&mut session);
        assert_exact(&mut session);
        assert!(hits(&mut session) != shown, "it is seen");
    }
    let (edited, camera) = (hits(&mut session), *session.camera());
    // From far away as well: there, the edited chunks are cells of coarser levels.
    session.set_camera(Camera { cell: camera.cell + IVec3::new(-300, 200, 500), ..camera });
    assert!(assert_exact(&mut session) > 1000);
    session.set_camera(camera);
    assert!(session.undo().unwrap() && session.undo().unwrap() && !session.undo().unwrap());
    assert_exact(&mut session);
    assert!(hits(&mut session) == before, "undone");
    assert!(session.redo().unwrap() && session.redo().unwrap());
    assert_exact(&mut session);
    assert!(hits(&mut session) == edited, "done again");
    drop(session);

    // Saved edits are there the next time, but only in sessions that ask for them.
    let mut session = open(Saves::Read).unwrap_or_else(|error| panic!("{error}"));
    assert_exact(&mut session);
    assert!(hits(&mut session) == edited, "saved");
    drop(session);
    let saved = project.raxel(&["world", "save", "worlds/frontier.toml"]).exits(0);
    assert!(saved.stdout.contains("6 edits"), "two, taken back, and done again: {}", saved.stdout);
    project.raxel(&["world", "verify", "worlds/frontier.toml"]).exits(0);
    let mut session = open(Saves::Ignore).unwrap_or_else(|error| panic!("{error}"));
    assert_exact(&mut session);
    assert!(hits(&mut session) == before, "not asked for");
    drop(session);

    // Another land below: refused, unless the file says that the edits stay as they are.
    project.edit("worlds/frontier.toml", "amplitude = 330.0", "amplitude = 300.0");
    let refused = open(Saves::Read).err().expect("it is other land").to_string();
    assert!(refused.contains("built otherwise"), "{refused}");
    project.edit("worlds/frontier.toml", "\"saves/frontier\"", "\"saves/frontier\"\non_generator_change = \"keep\"");
    let mut session = open(Saves::Read).unwrap_or_else(|error| panic!("{error}"));
    assert_exact(&mut session);
}

#[test]
fn a_demo_edits_a_streamed_world_at_its_times() {
    let project = project();
    project.write("worlds/short.demo.toml", include_str!("fixtures/streaming/edits.demo.toml"));
    let demo = Some(project.path("worlds/short.demo.toml"));
    let pinned = vec!["hit".to_owned()];
    let open = || {
        let options = Options {
            demo: demo.clone(),
            world: None,
            graph: None,
            step: Some(0.25),
            pinned: pinned.clone(),
            ..options(&project, "bench/first_hit")
        };
        Session::open(options).unwrap_or_else(|error| panic!("{error}"))
    };
    let mut session = open();
    let mut seen = Vec::new();
    for _ in 0..4 {
        assert_exact(&mut session);
        seen.push(hits(&mut session));
    }
    let changes: Vec<usize> = (1..seen.len()).filter(|frame| seen[*frame] != seen[frame - 1]).collect();
    assert_eq!(changes.len(), 2, "{changes:?}");
    assert!(seen[0] == seen[3], "all of it was restored");
}

#[test]
fn what_was_seen_before_changes_no_picture() {
    let project = project();
    let picture = |session: &mut Session| session.read_presented().unwrap().rgba;
    let mut first = open(&project, "primary", &[]);
    let cameras = cameras(&first.camera().clone());
    let pictures: Vec<Vec<u8>> = cameras
        .iter()
        .map(|camera| {
            first.set_camera(*camera);
            first.reset();
            first.frame().unwrap_or_else(|error| panic!("{error}"));
            picture(&mut first)
        })
        .collect();
    let mut other = open(&project, "primary", &[]);
    for (camera, expected) in cameras.iter().zip(&pictures).rev() {
        other.set_camera(*camera);
        other.reset();
        other.frame().unwrap_or_else(|error| panic!("{error}"));
        assert!(picture(&mut other) == *expected, "{camera:?}");
    }
    silent(&first);
}

#[test]
fn a_still_camera_dispatches_and_publishes_nothing() {
    let project = project();
    let mut session = open(&project, "bench/first_hit", &["hit"]);
    session.frame().unwrap();
    session.frame().unwrap();
    let before = session.stream().expect("it is bound").stats();
    for _ in 0..5 {
        let report = session.frame().unwrap();
        assert_eq!(report.dispatched, 0, "{report:?}");
    }
    let after = session.stream().expect("it is bound").stats();
    assert_eq!((after.publications, after.written), (before.publications, before.written));
    silent(&session);
}

#[test]
fn a_live_world_comes_into_view_and_no_frame_waits_for_it() {
    let project = project();
    let options = Options { step: None, pinned: vec!["hit".to_owned()], ..options(&project, "bench/first_hit") };
    let mut session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
    let until = std::time::Instant::now() + std::time::Duration::from_secs(120);
    let camera = *session.camera();
    loop {
        session.frame().unwrap_or_else(|error| panic!("{error}"));
        let stream = session.stream().expect("it is bound");
        if stream.is_settled() && !stream.has_news() {
            break;
        }
        assert!(std::time::Instant::now() < until, "{:?}", stream.stats());
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    // Also the tiles that are there before they are wanted, up to the horizon.
    let (streamed, source) = (session.world().streamed().unwrap(), session.world().tiles().unwrap());
    let reach = streaming_range(streamed, source);
    let mut shown = reach.loaded(false).tiles(camera.cell);
    shown.retain(|tile| tile.level < reach.top() || reach.wants(camera.cell, *tile, 0));
    assert!(hits(&mut session) == exact_of(&session, &camera, &shown));
    silent(&session);
}

#[test]
fn what_a_streamed_world_cannot_do_is_said() {
    let project = project();
    let refused = |options: Options| Session::open(options).err().expect("it cannot open").to_string();
    for layout in rivals::LAYOUTS.iter().copied().filter(|layout| *layout != Layout::TREE64) {
        let options = Options { layout: Some(layout), ..options(&project, "bench/first_hit") };
        let Err(OpenError::Project { diagnostics, .. }) = Session::open(options) else { panic!("{layout:?} opens") };
        let whole = format!("`world.{}` needs the whole world", layout.name());
        assert!(!diagnostics.is_empty(), "{layout:?}");
        // A layout with an image is bound in two places.
        for found in &diagnostics {
            assert!(found.code.as_str() == "RX0342" && found.message.contains(&whole), "{found:?}");
            // The user of the world, and the streamed world.
            let files: Vec<&str> = found.labels.iter().map(|label| &*label.span.file).collect();
            assert_eq!(files, ["graphs/bench/first_hit.toml", "worlds/frontier.toml"]);
        }
    }
    project.edit("worlds/frontier.toml", "gpu_memory =", "cpu_memory = \"64 KiB\"\ngpu_memory =");
    let message = refused(options(&project, "bench/first_hit"));
    assert!(message.contains("RX0470") && message.contains("`cpu_memory` is 64.0 KiB"), "{message}");
    project.edit("worlds/frontier.toml", "\"64 KiB\"", "0");
    project.edit("worlds/frontier.toml", "\"100 MiB\"", "\"1 MiB\"");
    let needed = |step: Option<f64>| -> f64 {
        let message = refused(Options { step, ..options(&project, "bench/first_hit") });
        assert!(message.contains("RX0341") && message.contains("there are 1.0 MiB"), "{message}");
        let number = message.split("takes about ").nth(1).and_then(|text| text.split(' ').next());
        number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{message}"))
    };
    // A window loads tiles beyond the horizon as well.
    let (picture, window) = (needed(Some(0.1)), needed(None));
    assert!(window > 1.2 * picture, "{picture} MiB, {window} MiB");
}

/// Land in cells of 4 voxels is nearly where it is in single ones, and nothing of the ground is missing.
#[test]
fn coarser_land_lies_where_the_land_is() {
    let project = project();
    let depths = |near: u32| {
        project.edit("worlds/frontier.toml", "near = 128", &format!("near = {near}"));
        project.edit("worlds/frontier.toml", "far = 1000", "far = 512");
        let mut session = open(&project, "bench/first_hit", &["hit", "depth"]);
        session.frame().unwrap_or_else(|error| panic!("{error}"));
        project.edit("worlds/frontier.toml", &format!("near = {near}"), "near = 128");
        project.edit("worlds/frontier.toml", "far = 512", "far = 1000");
        let depths: Vec<f32> = session.read_target("depth").unwrap().floats().iter().map(|texel| texel[0]).collect();
        let found = hits(&mut session);
        depths.into_iter().zip(found).map(|(depth, hit)| (hit != MISS).then_some(depth)).collect::<Vec<_>>()
    };
    let (full, coarse) = (depths(512), depths(128));
    let (mut ground, mut far, mut close, mut gone) = (0, 0, [0; 2], 0);
    let width = SIZE[0] as usize;
    for (at, (full_depth, coarse)) in full.iter().zip(&coarse).enumerate() {
        let Some(full_depth) = full_depth else { continue };
        ground += 1;
        let around = [at.wrapping_sub(1), at + 1, at.wrapping_sub(width), at + width];
        let silhouette = around.iter().any(|at| full.get(*at).is_none_or(Option::is_none));
        gone += usize::from(coarse.is_none() && !silhouette);
        // Within `near`, there are single voxels in both.
        let cell = if *full_depth < 128.0 { 0.0 } else { 4.0 };
        far += usize::from(cell > 0.0);
        let is_close = coarse.is_some_and(|coarse| (coarse - full_depth).abs() <= cell + 1e-3);
        close[usize::from(cell > 0.0)] += usize::from(is_close);
    }
    println!("{close:?} of {ground} pixels with ground, {far} far away");
    assert_eq!(gone, 0, "sky where ground is");
    // Along a ray that grazes the land, a cell that is a little too high is met far too early.
    assert!(far > 500 && (close[0] + close[1]) * 100 >= 85 * ground, "{close:?} of {ground}, {far} far");
}

/// On devices whose memory the host cannot write, tiles go through staging memory; here, because it is asked for.
#[test]
fn tiles_that_go_through_staging_memory_give_the_same_pictures() {
    let project = project();
    // A ring of the smallest size, far smaller than the world.
    project.edit("worlds/frontier.toml", "gpu_memory =", "upload = \"64 KiB\"\ngpu_memory =");
    project.write("worlds/short.demo.toml", include_str!("fixtures/streaming/flight.demo.toml"));
    let pictures = |folder: &str, uploads: &str, parts: &[&str]| {
        let frames = format!("{folder}/%04d.png");
        let film = ["render", "worlds/short.demo.toml", "--validate", "--fps", "4", "--size", "95x57", "-o", &frames];
        for part in parts {
            let arguments = [&film[..], &["--shard", part]].concat();
            let mut command = common::command(project.root(), &arguments);
            let run: common::Run = common::output(command.env("RAXEL_UPLOADS", uploads)).into();
            run.exits(0);
        }
        (0..4).map(|n| std::fs::read(project.path(&format!("{folder}/{n:04}.png"))).unwrap()).collect::<Vec<_>>()
    };
    let [direct, staged] = [pictures("direct", "", &["1/1"]), pictures("staged", "staged", &["1/1"])];
    assert!(direct == staged, "the pictures differ");
    // The edit is in the first part, and seen in both.
    assert!(pictures("parts", "", &["1/2", "2/2"]) == direct, "the parts of the film differ from the whole");
    assert!(direct[0] != direct[3]);
}

#[test]
fn a_flight_is_measured() {
    let project = project();
    let arguments = ["bench", "stream", "graphs/bench/first_hit.toml", "--world", "worlds/frontier.toml"];
    let short = ["--seconds", "1", "--speed", "200", "--size", "48x27", "--edits", "6", "--format", "json"];
    let run = project.raxel(&[&arguments[..], &short].concat()).exits(0);
    let result = run.json().pop().expect("a line");
    assert_eq!(result["reason"], "bench-stream");
    let frames = result["live"]["frames"].as_array().expect("frames");
    assert!(frames.len() > 2 && frames.len() == result["resident"]["frames"].as_array().unwrap().len());
    assert!(frames.iter().map(|frame| frame["bytes"].as_u64().unwrap()).sum::<u64>() > 0);
    let resident = result["resident"]["frames"].as_array().unwrap();
    assert!(resident.iter().all(|frame| frame["missing"] == 0), "complete before each frame");
    // Each frame says where it was, and what its passes took.
    for way in ["live", "resident"] {
        let passes = result[way]["passes"].as_array().expect("passes").len();
        let frames = result[way]["frames"].as_array().unwrap();
        assert!(passes > 0 && frames[0]["part"] == "straight" && frames[0]["since"] == frames[0]["time"]);
        for frame in frames {
            let took = frame["passes"].as_array().expect("passes");
            let most = took.iter().map(|pass| pass.as_f64().unwrap()).fold(0.0, f64::max);
            let device = frame["device"].as_f64().expect("the device has a clock");
            assert!(took.len() <= passes && most > 0.0 && most <= device * 1.001, "{frame}");
            assert!(frame["milliseconds"].as_f64() >= frame["submitted"].as_f64(), "{frame}");
        }
    }
    for kind in ["small", "large"] {
        let edits = result["edits"][kind].as_array().expect("edits");
        assert!(!edits.is_empty() && edits.len() <= 6 && edits.iter().all(|edit| edit["frames"].as_u64() > Some(0)));
    }
    let many = &result["edits"]["many"];
    assert!(many["chunks"].as_u64() == Some(200) && many["frames"].as_u64() == Some(3), "{many}");
    let kept = &result["kept"];
    assert!(kept["bytes"].as_u64() <= kept["most"].as_u64() && kept["chunks"].as_u64() > Some(0), "{kept}");
    assert!(kept["found"].as_u64() > Some(0), "the sample around the first camera is not made twice: {kept}");
    assert!(result["pool"][1].as_u64() <= result["pool"][2].as_u64());
    // The same for people: parts of the path in their order, then frames from the longest on.
    let run = project.raxel(&[&arguments[..], &short[..6], &["--edits", "0"]].concat()).exits(0);
    let at = |text: &str| run.stdout.find(text).unwrap_or_else(|| panic!("no `{text}` in\n{}", run.stdout));
    assert!(
        at("part, ms") < at("longest frames, loading")
            && at("longest frames, loading") < at("longest frames, resident")
    );
    let listed = run.stdout[at("longest frames, loading")..at("longest frames, resident")].lines().skip(2);
    let listed: Vec<f64> = listed.map(|line| line.split_whitespace().next().unwrap().parse().unwrap()).collect();
    assert!(!listed.is_empty() && listed.len() <= 5 && listed.is_sorted_by(|a, b| a >= b), "{listed:?}");
    // A world that is whole has nothing to measure.
    let whole = project.raxel(&["bench", "stream", "graphs/bench/first_hit.toml", "--world", "worlds/menger.toml"]);
    assert!(whole.stderr.contains("is not streamed"), "{}", whole.stderr);
    // A verb that needs every voxel reports why it cannot have them.
    let export = project.raxel(&["world", "export", "worlds/frontier.toml", "-o", "a.vox"]);
    assert!(export.code != 0 && export.stderr.contains("RX0343"), "{}", export.stderr);
    assert!(export.stderr.contains("[stream]\n"), "the line is shown: {}", export.stderr);
}

#[test]
fn a_flight_says_once_what_passes_count() {
    let project = project();
    let run = || {
        let arguments = ["bench", "stream", "graphs/light/face_cache.toml", "--world", "worlds/frontier.toml"];
        let short = ["--seconds", "1", "--speed", "8", "--size", "16x9", "--edits", "0", "--format", "short"];
        project.raxel(&[&arguments[..], &short].concat()).exits(0).stderr
    };
    assert!(!run().contains("RX0411"));
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u;", "RX_FACE_PROBES = 0u;");
    let said = run();
    assert_eq!(said.matches("their faces found no slot in the table: ").count(), 1, "{said}");
}

/// A thread that cannot start, one that panics, and a source that panics. A variable plants them in builds with debug assertions.
#[cfg(debug_assertions)]
#[test]
fn a_streaming_thread_that_fails_is_an_error_at_once() {
    const SCENE: [&str; 5] = ["graphs/bench/first_hit.toml", "--world", "worlds/frontier.toml", "--size", "32x18"];
    let project = project();
    let run = |fault: &str, arguments: &[&str], stdin: &str| -> Run {
        project.write("requests", stdin);
        let requests = std::fs::File::open(project.path("requests")).unwrap();
        let arguments = [arguments, &SCENE[..]].concat();
        output(command(project.root(), &arguments).env("RAXEL_FAULT_STREAM", fault).stdin(requests)).into()
    };
    let faults = [
        ("spawn", "RX0344", "the thread `stream director` cannot start: a planted fault"),
        ("director", "RX0344", "the thread `stream director` has ended: it panicked: a planted fault"),
        ("worker", "RX0344", "has ended: it panicked: a planted fault"),
        ("source", "RX0451", "is unavailable: it panicked: a planted fault"),
    ];
    for (fault, code, text) in faults {
        let film = run(fault, &["render", "--frames", "2", "-o", "a-{frame}.png"], "").exits(3);
        assert!(film.stderr.contains(code) && film.stderr.contains(text), "{fault}: {}", film.stderr);
        assert!(!project.path("a-0.png").exists(), "{fault}: a picture was written");
    }
    // By program: every step is refused with the reason, and the session goes on.
    let steps = "{\"do\":\"step\"}\n{\"do\":\"step\"}\n{\"do\":\"info\"}\n{\"do\":\"quit\"}\n";
    let control = run("director", &["control"], steps).exits(0);
    let refused =
        |line: &&str| line.contains("\"ok\":false") && line.contains("the thread `stream director` has ended");
    assert_eq!(control.stdout.lines().filter(refused).count(), 2, "{}", control.stdout);
    assert!(control.stdout.lines().filter(|line| line.contains("\"ok\":true")).count() >= 2, "{}", control.stdout);
    // While frames run: a flight stops, a window says it once and goes on with its picture.
    let flight = run("director", &["bench", "stream"], "").exits(3);
    assert!(flight.stderr.contains("RX0344"), "{}", flight.stderr);
    let display = Display::start();
    let mut window = command(project.root(), &[&["run"][..], &SCENE, &["--frames", "30"]].concat());
    let window: Run = output(window.env("RAXEL_FAULT_STREAM", "worker").env("DISPLAY", &display.name)).into();
    let window = window.exits(0);
    assert_eq!(window.stderr.matches("RX0344").count(), 1, "{}", window.stderr);
}
