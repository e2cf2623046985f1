//! Sessions over files that have mistakes from the beginning: nothing runs until they are mended.

mod project;

use std::path::Path;
use std::time::{Duration, Instant};

use project::{Project, Sessions, assert_silent, box_demo, box_world, fill, red_after_frame};
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{ManifestDefaults, OpenError, Options, Session};

const PATIENCE: Duration = Duration::from_secs(60);

/// A demo of a world that a graph counts the voxels of, beside the graph that fills.
fn project() -> Project {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", box_world(2));
    project.write("worlds/gain.demo.toml", box_demo(3.0));
    project
}

fn waiting(options: Options) -> Session {
    let session = Project::open_with(Options { wait: true, ..options });
    assert!(session.is_waiting());
    session
}

/// The next event.
fn event(session: &mut Session) -> ReloadEvent {
    let until = Instant::now() + PATIENCE;
    let mut events = Vec::new();
    while events.is_empty() && Instant::now() < until {
        events = session.wait_reload(PATIENCE);
    }
    assert_eq!(events.len(), 1, "{events:?}");
    events.remove(0)
}

/// The mistakes of the next event, with the file that each is in.
fn mistakes(session: &mut Session) -> String {
    match event(session) {
        ReloadEvent::NotOpened(OpenError::Project { diagnostics, texts }) => {
            raxel_diagnostics::render::human(&diagnostics, &texts, false)
        }
        other => panic!("{other:?}"),
    }
}

fn assert_opened(session: &mut Session) {
    let event = event(session);
    assert!(matches!(event, ReloadEvent::Opened) && !session.is_waiting(), "{event:?}");
}

#[test]
fn every_kind_of_file_is_waited_for() {
    let demo = Some(Path::new("worlds/gain.demo.toml").to_owned());
    // A file, its mistake, the message about it, and the mended file.
    let kinds = [
        ("raxel.toml", "graph = \"nowhere.toml\"\n", "graphs/nowhere.toml", "graph = \"world.toml\"\n".to_owned()),
        ("worlds/gain.demo.toml", "world = 1\n", "worlds/gain.demo.toml", box_demo(3.0)),
        ("graphs/world.toml", "name = \"world\"\npresent = \n", "graphs/world.toml", project::WORLD_GRAPH.to_owned()),
        (
            "shaders/world.comp",
            "#version 460\nvoid main() { x }\n",
            "shaders/world.comp",
            project::WORLD_SHADER.to_owned(),
        ),
        ("worlds/box.toml", "name = \"box\"\n[[build]]\nop = \"bax\"\n", "worlds/box.toml", box_world(2)),
    ];
    for (path, wrong, said, mended) in kinds {
        let project = project();
        project.write(path, wrong);
        let options = Options { demo: demo.clone(), manifest: Some(ManifestDefaults::default()), ..project.options() };
        assert!(matches!(Session::open(options.clone()), Err(OpenError::Project { .. })), "{path}: nobody waits");
        let mut session = waiting(options);
        let found = mistakes(&mut session);
        assert!(found.contains(said), "{path}: {found}");
        // Nothing runs, but the session answers requests.
        session.frame().unwrap();
        assert_eq!((session.read_presented().unwrap().width, session.params().len()), (16, 0), "{path}");
        assert!(session.world().path.is_none() && session.demo().is_none() && session.is_waiting(), "{path}");
        project.write(path, &mended);
        assert_opened(&mut session);
        session.frame().unwrap();
        assert_eq!(session.read_target("color").unwrap().floats()[0][..2], [8.0, 3.0], "{path}");
        // From here on it is a session as any other: edits are followed.
        project.write("worlds/gain.demo.toml", box_demo(5.0));
        assert!(matches!(event(&mut session), ReloadEvent::Reloaded(_)), "{path}");
        session.frame().unwrap();
        assert_eq!(session.read_target("color").unwrap().floats()[0][1].to_bits(), 5.0_f32.to_bits(), "{path}");
        assert_silent(&session);
    }
}

#[test]
fn a_missing_file_and_other_mistakes_are_told_once_each() {
    let project = Project::filled();
    std::fs::remove_file(project.path("shaders/fill.comp")).unwrap();
    let mut session = waiting(project.options());
    let device = session.device().id();
    assert!(mistakes(&mut session).contains("shaders/fill.comp"));
    project.write("shaders/fill.comp", fill("vec4(0.25"));
    let found = mistakes(&mut session);
    assert!(found.contains("shaders/fill.comp") && !found.contains("no such file"), "{found}");
    // Files that no graph uses, and the same mistakes again, are no news.
    project.write("shaders/other.comp", "");
    assert!(session.wait_reload(Duration::from_secs(2)).is_empty());
    session.resize(24, 8);
    project.write("shaders/fill.comp", fill("vec4(0.75)"));
    assert_opened(&mut session);
    assert_eq!((session.size(), session.device().id()), ([24, 8], device), "window and device are as they were");
    assert_eq!(red_after_frame(&mut session).to_bits(), 0.75_f32.to_bits());
    assert_silent(&session);
}

#[test]
fn the_manifest_is_read_again_and_says_what_is_opened_then() {
    let project = project();
    project.write("raxel.toml", "demo = \"gian.demo.toml\"\n");
    let manifest = Some(ManifestDefaults { demo: true, size: true, scale: true });
    let options = Options { manifest, ..project.options() };
    let mut session = waiting(options.clone());
    assert!(mistakes(&mut session).contains("raxel.toml:1:"));
    project.write("raxel.toml", "demo = \"gain.demo.toml\"\nsize = [40, 20]\nscale = 0.5\n");
    assert_opened(&mut session);
    assert_eq!(session.demo().unwrap().file, "worlds/gain.demo.toml");
    // A window keeps its size; a session that opens at once has the manifest's.
    assert_eq!((session.viewport().window(), session.size()), ([16, 16], [8, 8]));
    assert_eq!(Project::open_with(options.clone()).viewport().window(), [40, 20]);
    // A named file is opened, for any manifest.
    let named = Options { graph: Some(Path::new("graphs/fill.toml").to_owned()), ..options };
    assert!(Project::open_with(named).demo().is_none());
}

#[test]
fn what_no_edit_can_mend_is_told_as_it_is() {
    let project = Project::filled();
    project.write("shaders/fill.comp", "wrong");
    let mut options = project.options();
    options.debug_target.resource = "depth".to_owned();
    let mut session = waiting(options);
    mistakes(&mut session);
    project.write("shaders/fill.comp", fill("vec4(0.5)"));
    let event = event(&mut session);
    assert!(matches!(event, ReloadEvent::NotOpened(OpenError::DebugTarget(_))), "{event:?}");
    assert!(session.is_waiting());
    assert_eq!(red_after_frame(&mut session).to_bits(), 0.0_f32.to_bits(), "the session is whole");
}
