//! A session driven by names: conditions, clock, size, debug targets, demos. On a real device with the validation layer on: no
//! message may come.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use project::{Project, Sessions};
use raxel_graph::checked::Value;
use raxel_runtime::{FrameError, Observe, Options};

#[test]
fn a_condition_switches_a_pass_and_the_plan_follows() {
    let project = Project::filled();
    let graph =
        project::FILL_GRAPH.to_owned() + "when = \"param.paint\"\n[params.paint]\ntype = \"bool\"\ndefault = true\n";
    project.write("graphs/fill.toml", &graph);
    let mut session = project.open();
    assert_eq!(project::red_after_frame(&mut session), 0.25);
    session.set_param("paint", Value::Bool(false)).unwrap();
    assert_eq!(project::red_after_frame(&mut session), 0.0);
    assert_eq!(session.plan().unwrap().culled.len(), 1);
    session.set_param("paint", Value::Bool(true)).unwrap();
    assert_eq!(project::red_after_frame(&mut session), 0.25);
    project::assert_silent(&session);
}

#[test]
fn the_clock_stops_steps_and_starts_over() {
    let project = Project::filled();
    project.write("shaders/count.comp", project::COUNT);
    let time = project::COUNT_GRAPH.replace("param.add", "frame.index").replace("\"f32\", from", "\"u32\", from");
    project.write("graphs/count.toml", &time);
    project.write("shaders/count.comp", project::COUNT.replace("float add", "uint add"));
    let mut session = project.open_graph("graphs/count.toml");
    // 0 + 1 + 2
    for sum in [0.0, 1.0, 3.0] {
        assert_eq!(project::red_after_frame(&mut session), sum);
    }
    // While the time stands, frames are counted: 3 + 3, then 6 + 4.
    let before = session.clock().now().unwrap();
    session.pause(true);
    assert_eq!(project::red_after_frame(&mut session), 6.0);
    let held = session.clock().now().unwrap();
    assert_eq!((held.index, held.time, held.delta), (3, before.time, 0.0));
    session.step();
    assert_eq!(project::red_after_frame(&mut session), 10.0);
    let stepped = session.clock().now().unwrap();
    assert_eq!((stepped.index, stepped.time > held.time), (4, true));
    session.pause(false);
    session.reset();
    for sum in [0.0, 1.0] {
        assert_eq!(project::red_after_frame(&mut session), sum);
    }
    project::assert_silent(&session);
}

#[test]
fn size_and_debug_target_change_between_frames() {
    let project = Project::filled();
    project.write("shaders/count.comp", project::COUNT);
    project.write("graphs/count.toml", project::COUNT_GRAPH);
    let mut session = project.open_graph("graphs/count.toml");
    session.frame().unwrap();
    session.resize(40, 24);
    session.frame().unwrap();
    let picture = session.read_presented().unwrap();
    assert_eq!((picture.width, picture.height), (40, 24));
    // A minimised window has no area; nothing changes.
    session.resize(0, 0);
    session.frame().unwrap();
    assert_eq!(session.size(), [40, 24]);
    session.set_debug_target_text("sum@1,after=count").unwrap();
    session.frame().unwrap();
    assert!(session.set_debug_target_text("sum@2").is_err());
    assert!(session.set_debug_target_text("sum,mip=1").is_err());
    assert_eq!(session.debug_target().to_string(), "sum@1,after=count");
    // A size that no device has is an error, and the session goes on.
    session.resize(1 << 24, 8);
    assert!(matches!(session.frame(), Err(FrameError::Plan { .. })));
    session.resize(16, 16);
    session.frame().unwrap();
    project::assert_silent(&session);
}

#[test]
fn pinned_resources_can_be_read_whatever_is_shown() {
    let project = Project::filled();
    let second = project::FILL_GRAPH
        .replace("[targets.color]", "[targets.other]\nformat = \"rgba32f\"\n[targets.color]")
        + "[[passes]]\nname = \"second\"\nshader = \"fill.comp\"\ndispatch = { threads = \"other\" }\nbind = { outColor = \"other\" }\n";
    project.write("graphs/fill.toml", &second);
    let mut session = Project::open_with(Options { observe: Observe::Shown, ..project.options() });
    session.frame().unwrap();
    assert!(session.read_target("other").is_err(), "it is culled");
    assert!(session.pin("othr").unwrap_err().to_string().contains("`other`"));
    session.pin("other").unwrap();
    session.frame().unwrap();
    assert_eq!(session.read_target("other").unwrap().floats()[0][0], 0.25);
    let wrong = Options { pinned: vec!["nothing".into()], ..project.options() };
    assert!(matches!(raxel_runtime::Session::open(wrong), Err(raxel_runtime::OpenError::DebugTarget(_))));
    project::assert_silent(&session);
}

/// A demo whose camera and whose one track move.
fn demo() -> (Project, raxel_runtime::Session) {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", project::box_world(4));
    let demo = include_str!("fixtures/drive/drive.demo.toml");
    project.write("worlds/box.demo.toml", demo);
    let options = Options { step: Some(0.5), demo: Some("worlds/box.demo.toml".into()), ..project.options() };
    let session = Project::open_with(options);
    (project, session)
}

#[test]
fn a_demo_drives_until_the_user_takes_over() {
    let (_project, mut session) = demo();
    for gain in [0.0, 0.5, 1.0] {
        session.frame().unwrap();
        assert_eq!(project::texel(&mut session)[1], gain);
    }
    assert_eq!(session.camera().position().x, 1.0);
    session.take_over();
    session.frame().unwrap();
    assert_eq!((project::texel(&mut session)[1], session.camera().position().x), (1.0, 1.0));
    assert_eq!(session.param("gain").unwrap(), Value::F32(1.0));
    session.hand_back();
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session)[1], 2.0);
    project::assert_silent(&session);
}

#[test]
fn a_param_that_is_released_follows_the_user_and_the_camera_the_demo() {
    let (_project, mut session) = demo();
    session.frame().unwrap();
    session.release_param(Some("gain"));
    session.set_param("gain", Value::F32(7.0)).unwrap();
    session.frame().unwrap();
    assert_eq!((project::texel(&mut session)[1], session.camera().position().x), (7.0, 0.5));
    session.frame().unwrap();
    assert_eq!((project::texel(&mut session)[1], session.camera().position().x), (7.0, 1.0));
    session.release_param(None);
    session.frame().unwrap();
    assert_eq!((project::texel(&mut session)[1], session.camera().position().x), (1.5, 1.5));
    project::assert_silent(&session);
}

#[test]
fn a_world_that_no_buffer_can_hold_is_refused_with_both_numbers() {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH.replace("tree64", "chunks"));
    project.write("shaders/world.comp", project::WORLD_SHADER);
    // A maze of 3000 × 3000 voxels lies in more than 8000 chunks of 32³, no two of them alike: more than the 128 MiB that software
    // devices bind.
    let world = project::box_world(1)
        .replace("op = \"box\"", "op = \"maze\"")
        .replace("min = [0, 0, 0]\nmax = [1, 1, 1]", "cells = [600, 600]");
    project.write("worlds/box.toml", &world);
    let options = Options { graph: Some("graphs/world.toml".into()), ..project.options() };
    let Err(raxel_runtime::OpenError::Project { diagnostics, .. }) = raxel_runtime::Session::open(options) else {
        panic!("it opens")
    };
    let [diagnostic] = diagnostics.as_slice() else { panic!("{diagnostics:#?}") };
    assert_eq!(diagnostic.code.as_str(), "RX0407");
    assert!(diagnostic.message.contains("134217728"), "{}", diagnostic.message);
    assert_eq!(&*diagnostic.labels[0].span.file, "graphs/world.toml");
}
