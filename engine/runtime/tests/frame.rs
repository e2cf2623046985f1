//! The promises of a session about its frames: they allocate nothing, a refused plan leaves the old one running, tickets do not wait, the
//! output is the window's extent scaled.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::time::Duration;

use project::{COUNT, COUNT_GRAPH, Project, Sessions, assert_silent, box_demo, box_world, red};
use raxel_execute::Progress;
use raxel_graph::checked::Value;
use raxel_runtime::{FrameError, Options, Session};

/// Shows its own param where a condition holds.
const CONDITIONAL: &str = include_str!("fixtures/frame/conditional.toml");

const GAIN: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
layout(push_constant) uniform PC { float gain; } pc;
void main() { imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(pc.gain)); }
";

const DEMO: &str = include_str!("fixtures/frame/run.demo.toml");

fn allocations(session: &mut Session) -> u64 {
    // The first frames may reserve what later ones use.
    for _ in 0..4 {
        session.frame().unwrap();
    }
    let counted = allocation_counter::measure(|| {
        for _ in 0..8 {
            assert!(session.poll_reload().is_empty());
            session.frame().unwrap();
        }
    });
    counted.count_total
}

#[test]
fn a_frame_of_a_session_allocates_nothing() {
    let project = Project::filled();
    project.write("graphs/count.toml", COUNT_GRAPH);
    project.write("shaders/count.comp", COUNT);
    let mut session = project.open_graph("graphs/count.toml");
    session.pin("sum").unwrap();
    session.set_push("count", "add", Value::F32(2.0)).unwrap();
    assert_eq!(allocations(&mut session), 0, "a history, a pin and an override");

    project.write("graphs/conditional.toml", CONDITIONAL);
    project.write("shaders/gain.comp", GAIN);
    project.write("worlds/box.toml", box_world(2));
    project.write("worlds/run.demo.toml", DEMO);
    let mut session = project.open_demo("worlds/run.demo.toml");
    assert_eq!(allocations(&mut session), 0, "a demo that moves the camera and a param");
    assert!(matches!(session.param("gain"), Ok(Value::F32(gain)) if gain > 0.0), "the demo drives");
}

#[test]
fn a_refused_plan_leaves_the_old_one_running_and_is_said_once() {
    let project = Project::filled();
    let mut session = project.open();
    session.frame().unwrap();
    // No device has images of a million texels a side.
    session.resize(1_000_000, 1_000_000);
    let Err(FrameError::Plan { diagnostics, .. }) = session.frame() else { panic!("it cannot be planned") };
    assert!(!diagnostics.is_empty());
    assert!(session.is_refused());
    for _ in 0..3 {
        let report = session.frame().expect("the plan before runs");
        assert!(report.dispatched + report.skipped == 1);
    }
    let picture = session.read_presented().unwrap();
    assert_eq!((picture.width, picture.height), (16, 16));
    // Another size that cannot be is another mistake.
    session.resize(2_000_000, 1);
    assert!(matches!(session.frame(), Err(FrameError::Plan { .. })));
    // Shaders get the extent of the computed picture, for the same camera.
    session.frame().unwrap();
    session.resize(24, 8);
    session.frame().unwrap();
    assert!(!session.is_refused());
    let picture = session.read_presented().unwrap();
    assert_eq!((picture.width, picture.height), (24, 8));
    assert_eq!(red(&mut session), 0.25);
    assert_silent(&session);
}

#[test]
fn a_condition_that_turns_makes_another_plan() {
    let project = Project::filled();
    project.write("graphs/conditional.toml", CONDITIONAL);
    project.write("shaders/gain.comp", GAIN);
    let mut session = project.open_graph("graphs/conditional.toml");
    session.frame().unwrap();
    assert_eq!(red(&mut session), 0.5);
    session.set_param("on", Value::Bool(false)).unwrap();
    session.frame().unwrap();
    assert_eq!(red(&mut session), 0.0, "what a pass that is off would write is at its init");
    session.set_param("on", Value::Bool(true)).unwrap();
    session.frame().unwrap();
    assert_eq!(red(&mut session), 0.5);
}

#[test]
fn a_demo_turns_conditions_too() {
    let project = Project::filled();
    project.write("graphs/conditional.toml", CONDITIONAL);
    project.write("shaders/gain.comp", GAIN);
    project.write("worlds/box.toml", box_world(2));
    let demo =
        box_demo(0.5).replace("world.toml", "conditional.toml") + "[tracks.on]\nkeys = [[0.0, true], [1.0, false]]\n";
    project.write("worlds/run.demo.toml", &demo);
    let mut session = project.open_demo("worlds/run.demo.toml");
    session.frame().unwrap();
    assert_eq!(red(&mut session), 0.5);
    session.seek(2.0);
    session.frame().unwrap();
    assert_eq!(red(&mut session), 0.0);
}

#[test]
fn tickets_hold_the_frame_they_were_asked_in_and_never_wait() {
    let project = Project::filled();
    project.write("graphs/count.toml", COUNT_GRAPH);
    project.write("shaders/count.comp", COUNT);
    let mut session = project.open_graph("graphs/count.toml");
    let mut tickets = Vec::new();
    for _ in 0..4 {
        session.frame().unwrap();
        let waits = session.device().waits();
        tickets.push((session.request_texels("sum", 0, 0, 0).unwrap(), session.request_picture().unwrap()));
        let _ = tickets[0].0.poll().unwrap();
        assert_eq!(session.device().waits(), waits, "nothing was waited for");
    }
    assert_eq!(session.wait_picture(Duration::from_secs(60)).unwrap(), Progress::Done);
    // The copies follow the frame; the blocking read is behind all of them.
    let last = session.read_target("sum");
    assert!(last.is_err() || last.is_ok_and(|texels| texels.floats()[0][0] == 4.0));
    session.wait().unwrap();
    for (frame, (texels, picture)) in tickets.iter().enumerate() {
        let texels = texels.poll().unwrap().expect("the device is idle");
        assert_eq!(texels.floats()[0][0], (frame + 1) as f32);
        assert_eq!(picture.poll().unwrap().expect("the device is idle").rgba.len(), 16 * 16 * 4);
    }
    // Eight are out; dropped, they make room.
    assert!(session.request_picture().is_err());
    tickets.clear();
    session.request_picture().unwrap();
    assert_silent(&session);
}

#[test]
fn the_output_is_the_window_scaled() {
    let project = Project::filled();
    let mut session = Project::open_with(Options { size: [64, 32], scale: 0.5, ..project.options() });
    assert_eq!(session.size(), [32, 16]);
    session.frame().unwrap();
    let picture = session.read_presented().unwrap();
    assert_eq!((picture.width, picture.height), (32, 16));
    session.resize(128, 64);
    session.frame().unwrap();
    assert_eq!(session.size(), [64, 32]);
    session.set_scale(2.0);
    session.frame().unwrap();
    let picture = session.read_presented().unwrap();
    assert_eq!((picture.width, picture.height), (256, 128));
    assert_silent(&session);
}

#[test]
fn a_plan_prepared_before_another_one_ran_brings_no_old_contents_back() {
    let project = Project::filled();
    project.write("graphs/count.toml", COUNT_GRAPH);
    project.write("shaders/count.comp", COUNT);
    let (sender, built) = std::sync::mpsc::channel();
    // The waker must be shareable; a sender alone is not on every version of Rust.
    let sender = std::sync::Mutex::new(sender);
    let mut session = Project::open_with(Options {
        graph: Some("graphs/count.toml".into()),
        waker: Some(std::sync::Arc::new(move || {
            let _ = sender.lock().unwrap().send(());
        })),
        ..project.options()
    });
    for _ in 0..5 {
        session.frame().unwrap();
    }
    assert_eq!(red(&mut session), 5.0);
    // An edit is prepared for what runs now, and not taken yet.
    project.write("shaders/count.comp", COUNT.replace("pc.add)", "pc.add * 1.0)"));
    built.recv_timeout(Duration::from_secs(60)).expect("the edit is built");
    // Another size, and back: the sum starts again.
    session.resize(24, 24);
    session.frame().unwrap();
    session.resize(16, 16);
    for _ in 0..2 {
        session.frame().unwrap();
    }
    assert_eq!(red(&mut session), 2.0);
    let events = session.poll_reload();
    let reloaded = |event: &_| matches!(event, raxel_runtime::reload::ReloadEvent::Reloaded(_));
    assert_eq!(events.iter().filter(|event| reloaded(event)).count(), 1, "{events:#?}");
    session.frame().unwrap();
    assert_eq!(red(&mut session), 3.0, "it goes on from what ran last");
    assert_silent(&session);
}
