//! Edits that shaders write: made once, two frames later, even if some records are wrong.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::fs;
use std::path::Path;

use raxel_edit::{Brush, Operation, Steps};
use raxel_graph::checked::Value;
use raxel_runtime::session::Validation;
use raxel_runtime::{Options, Saves, Session};
use raxel_testing::{Project, repository};
use raxel_world::Bounds;

fn options(project: &Path, graph: &str, world: &str) -> Options {
    Options {
        project: Some(project.to_owned()),
        graph: Some(project.join(graph)),
        world: Some(project.join(world)),
        size: [96, 54],
        saves: Saves::Ignore,
        validation: Validation::Required,
        ..Options::default()
    }
}

fn open(options: Options) -> Session {
    Session::open(options).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a frame; gives how many passes it dispatched.
fn frame(session: &mut Session) -> u32 {
    session.frame().unwrap_or_else(|error| panic!("{error}")).dispatched
}

fn silent(session: &Session) {
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// A project with some of the shipped files, and others.
fn project(files: &[(&str, String)]) -> Project {
    let project = Project::empty();
    for shipped in [
        "shaders/examples/drill.comp",
        "shaders/examples/see_copy.comp",
        "graphs/examples/drill.toml",
        "worlds/menger.toml",
        "worlds/models/tree.vox",
        "worlds/models/pine.vox",
        "worlds/models/vein.vox",
        "worlds/models/mushroom.vox",
        "worlds/models/hut.vox",
    ] {
        project.copy_file(shipped);
    }
    for (path, text) in files {
        project.write(path, text);
    }
    project
}

/// A world that a shader drills a hole into.
fn drilled() -> Session {
    open(options(repository(), "graphs/examples/drill.toml", "worlds/quarry.toml"))
}

#[test]
fn shaders_edit_the_world_two_frames_later_and_once() {
    let mut session = drilled();
    frame(&mut session);
    let before = session.read_presented().unwrap();
    let solids = |session: &Session| session.world().voxels().solids();
    let whole = solids(&session);
    frame(&mut session);
    assert_eq!((session.edit_steps(), solids(&session)), (Steps { undo: 0, redo: 0 }, whole), "not yet");
    assert!(session.read_presented().unwrap() == before);
    // A frame whose passes need not run writes nothing again: each hole is dug once.
    frame(&mut session);
    let after_one = solids(&session);
    assert_eq!(session.edit_steps(), Steps { undo: 1, redo: 0 });
    assert!(after_one < whole);
    assert!(session.read_presented().unwrap() != before, "it is seen");
    frame(&mut session);
    assert_eq!((session.edit_steps(), solids(&session)), (Steps { undo: 1, redo: 0 }, after_one));
    // The ray goes on through the hole.
    frame(&mut session);
    assert_eq!(session.edit_steps(), Steps { undo: 2, redo: 0 });
    assert!(solids(&session) < after_one);
    session.set_param("drill", Value::Bool(false)).unwrap();
    for _ in 0..4 {
        frame(&mut session);
    }
    let steps = session.edit_steps();
    assert_eq!(frame(&mut session), 0, "it is off");
    assert_eq!(session.edit_steps(), steps);
    for _ in 0..steps.undo {
        assert!(session.undo().unwrap());
    }
    frame(&mut session);
    assert_eq!(solids(&session), whole);
    assert!(session.read_presented().unwrap() == before);
    assert!(session.take_messages().is_empty());
    silent(&session);
}

#[test]
fn what_shaders_do_is_the_same_in_every_run() {
    let run = || {
        let mut session = drilled();
        (0..9).for_each(|_| _ = frame(&mut session));
        (session.world().voxels().solids(), session.read_presented().unwrap())
    };
    assert!(run() == run());
}

#[test]
fn shaders_edit_a_streamed_world() {
    let land = fs::read_to_string(repository().join("worlds/frontier.toml")).unwrap();
    let near = land.replace("near       = 384", "near = 128").replace("far        = 24576", "far = 1000");
    assert!(near.contains("near = 128") && near.contains("far = 1000"));
    let project = project(&[("worlds/land.toml", near.replace("256 MiB", "100 MiB"))]);
    let mut session = open(options(project.root(), "graphs/examples/drill.toml", "worlds/land.toml"));
    session.set_param("radius", Value::F32(9.0)).unwrap();
    let mut pictures = Vec::new();
    for _ in 0..5 {
        frame(&mut session);
        pictures.push(session.read_presented().unwrap().rgba);
    }
    let changes: Vec<usize> = (1..5).filter(|frame| pictures[*frame] != pictures[frame - 1]).collect();
    assert_eq!((changes, session.edit_steps()), (vec![2, 4], Steps { undo: 2, redo: 0 }));
    assert!(session.take_messages().is_empty());
    silent(&session);
}

#[test]
fn wrong_and_too_many_edits_of_shaders_are_said_once_and_the_others_are_made() {
    let shader = include_str!("fixtures/collected/many.comp");
    let graph = include_str!("fixtures/collected/many.toml");
    let project = project(&[("shaders/many.comp", shader.to_owned()), ("graphs/many.toml", graph.to_owned())]);
    let options = options(project.root(), "graphs/many.toml", "worlds/menger.toml");
    let mut session = open(options.clone());
    let mut said = Vec::new();
    let mut run = |session: &mut Session, frames: usize| -> Vec<String> {
        for _ in 0..frames {
            frame(session);
            said.extend(session.take_messages());
        }
        said.drain(..).map(|message| format!("{}: {}", message.code, message.message)).collect()
    };
    let messages = run(&mut session, 4);
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].starts_with("RX0440: passes have written edits that cannot be made"), "{messages:?}");
    let bounds = |y: [i64; 2]| Bounds { min: [0, y[0], 0], max: [64, y[1], 1] };
    let made = |session: &Session| session.region(&bounds([300, 2000])).unwrap().get(&1).copied();
    assert_eq!(made(&session), Some(100));
    assert_eq!(session.region(&bounds([-600, -400])).unwrap().get(&1), None);
    session.set_param("wanted", Value::U32(50_000)).unwrap();
    let messages = run(&mut session, 4);
    assert_eq!(messages.len(), 1, "what is still wrong is not said again: {messages:?}");
    assert!(messages[0].starts_with("RX0441: passes have written 45906 more edits than the 4096"), "{messages:?}");
    assert!(made(&session).unwrap() > 4000);
    silent(&session);

    // A block that is laid out otherwise is refused when it is compiled.
    let other = "buffer RxEdits { uint count; uint records[]; } edits;
        void rx_edit_set(ivec3 c, uint m) { edits.count = m; }
        void rx_edit_sphere(ivec3 c, float r, uint o, uint m) {}
        const uint RX_EDIT_ADD = 1u;";
    let other = shader.replace("#include <raxel/edits.glsl>", other);
    project.write("shaders/many.comp", other);
    let refused = Session::open(options).err().expect("it is laid out otherwise").to_string();
    assert!(refused.contains("is not laid out as `world.edits`"), "{refused}");
}

#[test]
fn layouts_that_follow_edits_show_what_those_that_are_made_anew_show() {
    let shipped = fs::read_to_string(repository().join("graphs/examples/drill.toml")).unwrap();
    let run = |layout: &str| -> Vec<Vec<u8>> {
        let graph = shipped.replace("world.tree64", &format!("world.{layout}"));
        assert!(layout == "tree64" || graph != shipped);
        let project = project(&[("graphs/follow.toml", graph)]);
        let mut session = open(options(project.root(), "graphs/follow.toml", "worlds/menger.toml"));
        session.set_param("reach", Value::F32(1000.0)).unwrap();
        session.set_param("radius", Value::F32(20.0)).unwrap();
        let mut pictures = Vec::new();
        for round in 0..12 {
            if round == 8 {
                assert!(session.undo().unwrap());
            }
            frame(&mut session);
            pictures.push(session.read_presented().unwrap().rgba);
        }
        assert!(session.edit_steps().undo >= 3 && session.take_messages().is_empty());
        silent(&session);
        pictures
    };
    // As it is encoded again after each edit.
    let anew = run("svo");
    assert!(anew[0] != anew[2] && anew[2] != anew[4], "the hole is seen");
    for layout in ["tree64", "octree", "chunk_table"] {
        assert!(run(layout) == anew, "{layout}");
    }
}

#[test]
fn pixels_that_cannot_see_an_edit_are_kept_and_right() {
    let see = fs::read_to_string(repository().join("shaders/examples/changed_see.comp")).unwrap();
    let always = see.replace("if (shown &&", "if (false &&");
    assert!(see != always);
    let start = |see: &str| {
        let mut files = vec![("shaders/examples/changed_see.comp", see.to_owned())];
        for shipped in
            ["graphs/examples/changed.toml", "shaders/examples/changed.glsl", "shaders/examples/changed_view.comp"]
        {
            files.push((shipped, fs::read_to_string(repository().join(shipped)).unwrap()));
        }
        let project = project(&files);
        (open(options(project.root(), "graphs/examples/changed.toml", "worlds/menger.toml")), project)
    };
    let ((mut kept, _kept_files), (mut full, _full_files)) = (start(&see), start(&always));
    let all = 96 * 54;
    // Runs a frame of both, which must look the same; returns the number of pixels that were computed again.
    let mut both = |act: &dyn Fn(&mut Session)| -> u32 {
        let [_, picture] = [&mut kept, &mut full].map(|session| {
            act(session);
            frame(session);
            session.read_presented().unwrap()
        });
        assert!(kept.read_presented().unwrap() == picture);
        u32::from_le_bytes(kept.read_buffer("count", 0..4).unwrap().try_into().unwrap())
    };
    assert_eq!(both(&|_| ()), all, "nothing was shown yet");
    both(&|_| ());
    both(&|_| ());
    let mut some = 0;
    for round in 0..24_i64 {
        // At the surface that the camera sees, behind it, and beside the picture.
        let at = [7 * round % 60, 5 * round % 70 + 20, 240 - 9 * round % 60].map(|c| 256 * c);
        let brush = [Brush::Subtract, Brush::Add(1), Brush::Subtract][(round % 3) as usize];
        let edit = Operation::Sphere { center: at, radius: 256 * (2 + round as u32 % 7), brush };
        let made = both(&|session| {
            session.edit(std::slice::from_ref(&edit)).unwrap();
        });
        assert!(made < all / 2, "{made} of {all} pixels for a ball");
        some += made;
        assert_eq!(both(&|_| ()), 0, "nothing has changed");
    }
    assert!(some > 0, "no edit was seen");
    // Two at once, back again, and with another camera in the same frame.
    both(&|session| assert!(session.undo().unwrap() && session.undo().unwrap()));
    let moved = both(&|session| {
        assert!(session.undo().unwrap());
        let camera = *session.camera();
        session.set_camera(raxel_runtime::camera::Camera { yaw: camera.yaw + 0.1, ..camera });
    });
    assert_eq!(moved, all);
    assert_eq!(both(&|session| session.reset()), all, "another beginning");
    silent(&kept);
    silent(&full);
}
