//! Another graph, world or demo of the project is opened in place of what runs. On a real device with the validation layer on: no message may
//! come.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::time::Duration;

use project::{COUNT, COUNT_GRAPH, Project, Sessions, WORLD_GRAPH, WORLD_SHADER, box_demo, box_world, red_after_frame};
use raxel_edit::{Operation, Steps};
use raxel_runtime::reload::{ProjectFile, ReloadEvent};
use raxel_runtime::{Options, Saves, Session};

fn project() -> Project {
    let project = Project::filled();
    for (path, text) in [
        ("graphs/world.toml", WORLD_GRAPH.to_owned()),
        ("graphs/count.toml", COUNT_GRAPH.to_owned()),
        ("shaders/world.comp", WORLD_SHADER.to_owned()),
        ("shaders/count.comp", COUNT.to_owned()),
        ("worlds/box.toml", box_world(2)),
        ("worlds/large.toml", box_world(4)),
        ("worlds/box.demo.toml", box_demo(0.25)),
    ] {
        project.write(path, &text);
    }
    project
}

fn open(project: &Project, saves: Saves) -> Session {
    Project::open_with(Options {
        graph: Some("graphs/world.toml".into()),
        world: Some("worlds/box.toml".into()),
        saves,
        ..project.options()
    })
}

/// Opens a file, and returns its event.
#[track_caller]
fn opened(session: &mut Session, file: ProjectFile) -> ReloadEvent {
    assert!(session.open_file(file));
    told(session)
}

/// The one event that comes.
#[track_caller]
fn told(session: &mut Session) -> ReloadEvent {
    let mut events = session.wait_reload(Duration::from_secs(60));
    assert_eq!(events.len(), 1, "{events:#?}");
    events.remove(0)
}

fn graph(name: &str) -> ProjectFile {
    ProjectFile::Graph(format!("graphs/{name}.toml"))
}

fn world(name: &str) -> ProjectFile {
    ProjectFile::World(format!("worlds/{name}.toml"))
}

#[test]
fn graph_world_and_demo_take_the_place_of_what_runs() {
    let project = project();
    let mut session = open(&project, Saves::Ignore);
    assert_eq!(red_after_frame(&mut session), 8.0);
    let runs = |session: &Session| {
        (session.graph_path().to_owned(), session.world().path.clone().unwrap_or_default(), session.demo().is_some())
    };
    let is = |graph: &str, world: &str, demo| (format!("graphs/{graph}.toml"), format!("worlds/{world}.toml"), demo);
    // A graph begins at its first frame, over the same world and with the same camera.
    let camera = *session.camera();
    let ReloadEvent::Reloaded(reloaded) = opened(&mut session, graph("count")) else { panic!() };
    assert!(reloaded.opened && reloaded.diagnostics.is_empty(), "{reloaded:#?}");
    assert_eq!((reloaded.changed, runs(&session)), (vec!["graphs/count.toml".to_owned()], is("count", "box", false)));
    assert_eq!((red_after_frame(&mut session), red_after_frame(&mut session)), (1.0, 2.0));
    assert_eq!(*session.camera(), camera);
    opened(&mut session, graph("world"));
    let ReloadEvent::Reloaded(reloaded) = opened(&mut session, world("large")) else { panic!() };
    assert!(reloaded.opened);
    assert_eq!((red_after_frame(&mut session), runs(&session)), (64.0, is("world", "large", false)));
    assert_eq!(*session.camera(), session.world().first_camera());
    // A demo brings its graph and its world, and drives.
    opened(&mut session, graph("fill"));
    opened(&mut session, ProjectFile::Demo("worlds/box.demo.toml".to_owned()));
    assert_eq!((red_after_frame(&mut session), project::texel(&mut session)[1]), (8.0, 0.25));
    assert_eq!((runs(&session), session.demo_drives()), (is("world", "box", true), true));
    // A graph ends it.
    opened(&mut session, graph("fill"));
    assert_eq!((red_after_frame(&mut session), runs(&session)), (0.25, is("fill", "box", false)));
    // An edit of what runs now is no opening.
    project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
    let ReloadEvent::Reloaded(reloaded) = told(&mut session) else { panic!() };
    assert!(!reloaded.opened);
    assert_eq!(red_after_frame(&mut session), 0.5);
    project::assert_silent(&session);
}

#[test]
fn what_is_wrong_leaves_the_last_picture_until_it_is_mended() {
    let project = project();
    project.write("graphs/broken.toml", WORLD_GRAPH.replace("world.tree64", "world.tree46"));
    project.write("worlds/broken.demo.toml", box_demo(0.5).replace("tracks.gain", "tracks.gone"));
    let mut session = open(&project, Saves::Ignore);
    red_after_frame(&mut session);
    for (file, said) in [
        (graph("broken"), "world.tree46"),
        (graph("missing"), "graphs/missing.toml"),
        (world("missing"), "worlds/missing.toml"),
        (ProjectFile::Demo("worlds/broken.demo.toml".to_owned()), "gone"),
    ] {
        let ReloadEvent::Failed(failed) = opened(&mut session, file) else { panic!() };
        assert!(failed.diagnostics.iter().any(|found| found.message.contains(said)), "{failed:#?}");
        assert_eq!((session.graph_path(), session.demo().is_none()), ("graphs/world.toml", true));
        assert_eq!(red_after_frame(&mut session), 8.0);
    }
    // The last one is followed: it runs when it is right.
    project.write("worlds/broken.demo.toml", box_demo(0.5));
    let ReloadEvent::Reloaded(reloaded) = told(&mut session) else { panic!() };
    assert!(reloaded.opened && session.demo_drives());
    assert_eq!((red_after_frame(&mut session), project::texel(&mut session)[1]), (8.0, 0.5));
    project::assert_silent(&session);
}

#[test]
fn edits_stay_with_their_world() {
    let project = project();
    let saved = |edge| box_world(edge) + "[save]\npath = \"saves/box\"\n";
    project.write("worlds/box.toml", saved(2));
    let mut session = open(&project, Saves::Write);
    assert!(session.warnings().is_empty(), "{:#?}", session.warnings());
    session.edit(&[Operation::set([1, 1, 1], 0)]).unwrap();
    assert_eq!(red_after_frame(&mut session), 7.0);
    // Under another graph they are there, and can be undone.
    opened(&mut session, graph("fill"));
    opened(&mut session, graph("world"));
    assert_eq!((red_after_frame(&mut session), session.edit_steps()), (7.0, Steps { undo: 1, redo: 0 }));
    // Another world does not have them, a demo begins without them, and the save has them.
    opened(&mut session, world("large"));
    assert_eq!((red_after_frame(&mut session), session.edit_steps()), (64.0, Steps { undo: 0, redo: 0 }));
    opened(&mut session, ProjectFile::Demo("worlds/box.demo.toml".to_owned()));
    assert_eq!(red_after_frame(&mut session), 8.0);
    let ReloadEvent::Reloaded(reloaded) = opened(&mut session, world("box")) else { panic!() };
    assert_eq!((red_after_frame(&mut session), reloaded.diagnostics.len()), (7.0, 0), "{:#?}", reloaded.diagnostics);
    project::assert_silent(&session);
}
