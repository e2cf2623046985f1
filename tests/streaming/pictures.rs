//! Pictures while land is loaded, seen again or coarser.

use glam::IVec3;
use raxel::{Camera, Options, Session, Value};
use raxel_edit::Operation;
use raxel_stream::streaming_range;

use crate::{MISS, SIZE, cameras, common, exact, exact_of, hits, open, options, project, silent};

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
    project.write("worlds/short.demo.toml", include_str!("../fixtures/streaming/flight.demo.toml"));
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
