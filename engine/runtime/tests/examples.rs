//! The examples of clocks and of what stands still, as a session runs them.

#![allow(missing_docs, reason = "a test")]

use raxel_runtime::session::{Options, Session, Validation};

fn open(graph: &str, step: f64) -> Session {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let graph = Some(format!("{root}/graphs/examples/{graph}.toml").into());
    let world = Some(format!("{root}/worlds/menger.toml").into());
    let options = Options {
        project: Some(root.into()),
        graph,
        world,
        size: [48, 27],
        step: Some(step),
        validation: Validation::Required,
        ..Options::default()
    };
    Session::open(options).unwrap_or_else(|error| panic!("{error}"))
}

/// Bytes of a target when the frame at `seconds` has been drawn.
fn run_until(session: &mut Session, target: &str, fps: u32, seconds: u32) -> Vec<u8> {
    while session.clock().now().is_none_or(|now| now.index < u64::from(fps * seconds)) {
        session.frame().unwrap_or_else(|error| panic!("{error}"));
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    session.read_target(target).unwrap_or_else(|error| panic!("{error}")).bytes
}

#[test]
fn waves_do_not_depend_on_the_frame_rate() {
    let mut of_rates = Vec::new();
    for fps in [30, 60, 144] {
        let mut session = open("clock", 1.0 / f64::from(fps));
        session.pin("height").unwrap_or_else(|error| panic!("{error}"));
        of_rates.push([1, 3].map(|seconds| run_until(&mut session, "height", fps, seconds)));
        // A paused clock leaves nothing to do.
        session.pause(true);
        for _ in 0..2 {
            session.frame().unwrap_or_else(|error| panic!("{error}"));
        }
        let report = session.frame().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(report.dispatched, 0, "{report:?}");
    }
    assert!(of_rates[0][0] != of_rates[0][1], "the waves move");
    assert!(of_rates.iter().all(|rate| *rate == of_rates[0]), "30, 60 and 144 frames a second differ");
}

#[test]
fn samples_are_taken_until_nothing_has_moved_for_a_while() {
    let mut session = open("still", 1.0 / 60.0);
    session.pin("sum").unwrap_or_else(|error| panic!("{error}"));
    let samples = |session: &mut Session| {
        let dispatched = session.frame().unwrap_or_else(|error| panic!("{error}")).dispatched;
        let texels = session.read_target("sum").unwrap_or_else(|error| panic!("{error}"));
        (dispatched, texels.floats()[0][3])
    };
    for frame in 1..=128_u8 {
        assert_eq!(samples(&mut session), (2, f32::from(frame)));
    }
    // Then it is good, and frames dispatch nothing although the time goes on.
    assert_eq!([samples(&mut session), samples(&mut session)], [(0, 128.0); 2]);
    // Any change starts over: the camera, a param, the cursor, the size.
    let mut camera = *session.camera();
    camera.yaw += 0.1;
    session.set_camera(camera);
    assert_eq!([samples(&mut session), samples(&mut session)], [(2, 1.0), (2, 2.0)]);
    session.set_param_text("aperture", "0.2").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!([samples(&mut session), samples(&mut session)], [(2, 1.0), (2, 2.0)]);
    session.set_cursor(Some([3, 4]));
    assert_eq!([samples(&mut session), samples(&mut session)], [(2, 1.0), (2, 2.0)]);
    session.resize(40, 20);
    assert_eq!([samples(&mut session), samples(&mut session)], [(2, 1.0), (2, 2.0)]);
}
