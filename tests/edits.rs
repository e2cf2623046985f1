//! Edits of a running session: the picture is exactly that of the newest voxels, and nothing is computed without need.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, Severity};
use raxel_edit::{Brush, Operation, Steps};
use raxel_execute::FrameReport;
use raxel_layouts::Layout;
use raxel_rivals as rivals;
use raxel_runtime::session::Validation;
use raxel_runtime::{EditFailure, OpenError, Options, Saves, Session};
use raxel_testing::Project;
use raxel_world::Bounds;

const SIZE: [u32; 2] = [96, 54];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn monument() -> Options {
    Options {
        project: Some(root()),
        world: Some("worlds/monument.toml".into()),
        size: SIZE,
        pinned: vec!["hit".to_owned()],
        validation: Validation::Required,
        ..Options::default()
    }
}

fn open(options: Options) -> Session {
    Session::open(options).unwrap_or_else(|error| panic!("{error}"))
}

fn frame(session: &mut Session) -> FrameReport {
    session.frame().unwrap_or_else(|error| panic!("{error}"))
}

/// Every pixel shows the voxel that the exact ray through it hits. Gives how many hit one.
fn assert_exact(session: &mut Session) -> usize {
    let hits = session.read_target("hit").unwrap();
    let mut solid = 0;
    for (index, texel) in hits.integers().unwrap().iter().enumerate() {
        let pixel = [index as i32 % SIZE[0] as i32, index as i32 / SIZE[0] as i32];
        let exact = session.pick(pixel, 1e6).unwrap().map(|hit| hit.exact.voxel);
        let shown = (texel[3] != u32::MAX).then(|| [texel[0], texel[1], texel[2]].map(|c| c as i32));
        assert_eq!(shown, exact, "pixel {pixel:?}");
        solid += usize::from(exact.is_some());
    }
    let messages = session.device().log().messages();
    assert!(messages.is_empty(), "{messages:#?}");
    solid
}

/// The texel at the centre of the picture.
fn middle(session: &Session) -> [f64; 3] {
    let hit = session.pick([48, 27], 1e6).unwrap().expect("something is in the middle");
    hit.exact.voxel.map(|c| f64::from(c) + 0.5)
}

#[test]
fn the_next_frame_shows_an_edit_exactly_and_undo_takes_it_back() {
    let mut session = open(monument());
    frame(&mut session);
    assert!(assert_exact(&mut session) > 1000);
    let before = session.read_presented().unwrap();
    let lawn = session.scene().material("lawn").unwrap();
    let at = middle(&session);
    let hole = Operation::sphere(at, 14.0, Brush::Subtract);
    let ball = Operation::sphere([at[0], at[1] + 20.0, at[2]], 9.0, Brush::Add(lawn));
    let tree = Operation::Model {
        model: "tree".to_owned(),
        orientation: raxel_world::Orientation::quarter_turns(1).to_vox(),
        position: [at[0] as i32 + 20, at[1] as i32, at[2] as i32 + 20],
        mode: raxel_world::Mode::Add,
    };
    for step in [vec![hole], vec![ball, tree]] {
        assert!(session.edit(&step).unwrap() > 0);
        assert!(frame(&mut session).dispatched > 0);
        assert_exact(&mut session);
    }
    assert!(session.read_presented().unwrap() != before);
    assert_eq!(session.edit_steps(), Steps { undo: 2, redo: 0 });
    assert!(session.undo().unwrap() && session.undo().unwrap() && !session.undo().unwrap());
    frame(&mut session);
    assert!(session.read_presented().unwrap() == before);
    assert!(session.redo().unwrap());
    frame(&mut session);
    assert_exact(&mut session);
    // An edit without a changed voxel counts as no change, so the still frame dispatches nothing.
    assert_eq!(session.edit(&[Operation::sphere([at[0], at[1], at[2]], 3.0, Brush::Subtract)]).unwrap(), 0);
    assert_eq!(frame(&mut session).dispatched, 0);
}

#[test]
fn after_the_first_edit_only_what_changed_is_written() {
    let mut session = open(monument());
    frame(&mut session);
    let at = middle(&session);
    session.edit(&[Operation::sphere(at, 3.0, Brush::Subtract)]).unwrap();
    frame(&mut session);
    let (source, plan) = (session.source("world.tree64").unwrap(), session.plan().unwrap().clone());
    let mut seen = 0;
    for n in 0..12 {
        let n = f64::from(n);
        let version = source.version();
        let changed = session.edit(&[Operation::sphere([at[0] + n, at[1], at[2]], 5.0, Brush::Subtract)]).unwrap();
        frame(&mut session);
        assert_eq!(source.version() != version, changed > 0);
        seen += usize::from(changed > 0);
    }
    assert!(seen > 4, "{seen}");
    assert_exact(&mut session);
    assert!(
        std::ptr::eq(&raw const *session.source("world.tree64").unwrap(), &raw const *source),
        "the buffer is the same"
    );
    assert!(std::sync::Arc::ptr_eq(session.plan().unwrap(), &plan), "the plan is the same");
    // Far beyond what the buffer was made for, another one takes its place.
    let lawn = session.scene().material("lawn").unwrap();
    session.edit(&[Operation::set([3000, 0, 0], lawn)]).unwrap();
    frame(&mut session);
    assert!(!std::ptr::eq(&raw const *session.source("world.tree64").unwrap(), &raw const *source));
    assert_exact(&mut session);
}

#[test]
fn every_layout_follows_edits() {
    for layout in [rivals::CHUNKS, Layout::OCTREE, rivals::BRICKMAP, rivals::TEXTURE3D] {
        // Only these two graphs leave the choice of the layout open.
        let graph = Some("graphs/inspect.toml".into());
        let mut session = open(Options { layout: Some(layout), graph, pinned: Vec::new(), ..monument() });
        frame(&mut session);
        let before = session.read_presented().unwrap();
        let at = middle(&session);
        session.edit(&[Operation::sphere(at, 12.0, Brush::Subtract)]).unwrap();
        frame(&mut session);
        let after = session.read_presented().unwrap();
        assert!(after != before, "{}", layout.name());
        session.undo().unwrap();
        frame(&mut session);
        assert!(session.read_presented().unwrap() == before, "{}", layout.name());
        let messages = session.device().log().messages();
        assert!(messages.is_empty(), "{messages:#?}");
    }
}

#[test]
fn what_cannot_be_edited_is_refused_and_the_picture_stays() {
    let mut session = open(monument());
    frame(&mut session);
    let before = session.read_presented().unwrap();
    let all = raxel_world::Bounds { min: [-(1 << 31); 3], max: [1 << 31; 3] };
    for operation in [
        Operation::Box { bounds: all, brush: Brush::Add(1) },
        Operation::set([0; 3], 60_000),
        Operation::Restore { bounds: all },
        Operation::sphere([f64::NAN, 0.0, 0.0], 4.0, Brush::Subtract),
        Operation::sphere([0.0; 3], f64::NAN, Brush::Subtract),
    ] {
        let error = session.edit(&[operation]).unwrap_err();
        assert!(matches!(error, EditFailure::Refused(_)), "{error}");
        assert_eq!(error.into_diagnostics()[0].code.as_str(), "RX0350");
    }
    assert_eq!(frame(&mut session).dispatched, 0);
    assert!(session.read_presented().unwrap() == before);
}

/// raxel takes back an edit that finds no room on the device, and only that edit. A failed undo takes back only its own step.
#[test]
fn an_edit_an_undo_and_a_redo_that_find_no_room_leave_the_steps_as_they_were() {
    let project = project();
    let graph = |layout: &str| {
        let text = fs::read_to_string(root().join("graphs/inspect.toml")).unwrap();
        project.write("graphs/inspect.toml", text.replace("world.tree64", layout));
    };
    graph("world.tree64");
    let options = field(project.root(), Saves::Ignore);
    let mut session = open(Options { graph: Some("graphs/inspect.toml".into()), watch: true, poll: true, ..options });
    let far = [1_000_000, 0, 0];
    let near = |n: i32| Operation::set([n, 20, 0], 1);
    let swap = |session: &mut Session, layout: &str| {
        graph(layout);
        let events = (0..40).map(|_| session.wait_reload(Duration::from_millis(500))).find(|events| !events.is_empty());
        assert!(events.is_some(), "{layout}");
        frame(session);
    };
    let seen = |session: &Session| {
        let bounds = raxel_world::Bounds { min: [0, 20, 0], max: [4, 21, 1] };
        session.region(&bounds).unwrap().get(&1).copied().unwrap_or_default()
    };
    session.edit(&[near(0)]).unwrap();
    session.edit(&[near(1), Operation::set(far, 1)]).unwrap();
    session.edit(&[near(2), Operation::set(far, raxel_world::AIR)]).unwrap();
    frame(&mut session);

    // An image is as large as the world: it has room for the third step, and not for the second.
    swap(&mut session, "world.texture3d");
    let error = session.undo().unwrap_err();
    assert!(error.to_string().contains("texture3d"), "{error}");
    assert_eq!((session.edit_steps(), seen(&session)), (Steps { undo: 3, redo: 0 }, 3));
    let error = session.edit(&[near(3), Operation::set(far, 1)]).unwrap_err();
    assert!(matches!(error, EditFailure::TooLarge { .. }), "{error}");
    assert_eq!((session.edit_steps(), seen(&session)), (Steps { undo: 3, redo: 0 }, 3));
    assert!(!session.redo().unwrap());
    session.edit(&[near(3)]).unwrap();
    frame(&mut session);

    // Once there is room again, all steps are there.
    swap(&mut session, "world.tree64");
    for left in [3, 2, 1] {
        assert!(session.undo().unwrap());
        assert_eq!(seen(&session), left);
    }
    assert!(session.undo().unwrap() && session.redo().unwrap());
    swap(&mut session, "world.texture3d");
    let error = session.redo().unwrap_err();
    assert!(error.to_string().contains("texture3d"), "{error}");
    assert_eq!((session.edit_steps(), seen(&session)), (Steps { undo: 1, redo: 3 }, 1));
}

/// A project in a folder of its own with the shipped graph, over a small world that is saved.
fn project() -> Project {
    let project = Project::empty();
    project.copy_file("graphs/primary.toml").copy_folder("shaders");
    write_world(&project, "");
    project
}

fn write_world(project: &Project, more: &str) {
    let world = format!(
        r##"name = "field"
[camera]
position = [40, 40, 40]
look_at = [0, 0, 0]
[materials]
soil = {{ albedo = "#806040" }}
lamp = {{ albedo = "#ffffff", emission = 4 }}
[save]
path = "saves/field"
[[build]]
op = "box"
min = [-32, -8, -32]
max = [32, 0, 32]
material = "soil"
{more}"##
    );
    project.write("worlds/field.toml", world);
}

fn field(folder: &Path, saves: Saves) -> Options {
    Options {
        project: Some(folder.to_owned()),
        size: SIZE,
        pinned: vec!["hit".to_owned()],
        validation: Validation::Required,
        saves,
        ..Options::default()
    }
}

#[test]
fn edits_are_saved_and_come_back() {
    let project = project();
    let mut session = open(field(project.root(), Saves::Write));
    frame(&mut session);
    let [soil, lamp] = ["soil", "lamp"].map(|name| session.scene().material(name).unwrap());
    assert!(!session.world().voxels().has_emission());
    session.edit(&[Operation::sphere([0.0, 0.0, 0.0], 12.0, Brush::Subtract)]).unwrap();
    session.edit(&[Operation::sphere([8.0, 9.0, 0.0], 5.0, Brush::Add(lamp))]).unwrap();
    assert!(session.world().voxels().has_emission(), "facts follow edits");
    session.edit(&[Operation::sphere([-8.0, 9.0, 0.0], 5.0, Brush::Add(soil))]).unwrap();
    session.undo().unwrap();
    frame(&mut session);
    assert_exact(&mut session);
    let picture = session.read_presented().unwrap();
    assert_eq!(session.world().bounds(), Bounds { min: [-32, -8, -32], max: [32, 14, 32] });

    // Another window has it open: it shows the same, and says that it saves nothing.
    let mut second = open(field(project.root(), Saves::Write));
    assert!(second.warnings().iter().any(|warning| warning.code.as_str() == "RX0352"), "{:?}", second.warnings());
    frame(&mut second);
    assert!(second.read_presented().unwrap() == picture);
    second.edit(&[Operation::set([0, 30, 0], soil)]).unwrap();
    drop(second);

    // As a power cut would leave it, before any checkpoint, and after one.
    for checkpoint in [false, true] {
        if checkpoint {
            session.checkpoint();
        }
        let mut reader = open(field(project.root(), Saves::Read));
        assert_eq!(reader.warnings(), []);
        frame(&mut reader);
        assert!(reader.read_presented().unwrap() == picture, "checkpoint: {checkpoint}");
    }
    assert!(session.take_messages().is_empty());
    drop(session);
    let mut ignored = open(field(project.root(), Saves::Ignore));
    frame(&mut ignored);
    assert!(ignored.read_presented().unwrap() != picture);

    // The looks of a material may change, the built voxels may not.
    let code = || match Session::open(field(project.root(), Saves::Write)) {
        Ok(_) => "opened".to_owned(),
        Err(OpenError::Project { diagnostics, .. }) => {
            let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
            let found = |error: &Diagnostic| {
                let place = &error.labels.first().expect("what the world's file says is at fault").span;
                let file = std::fs::read_to_string(project.path(&place.file)).unwrap();
                format!("{} at {}", error.code, &file[place.range.clone()])
            };
            errors.map(found).collect()
        }
        Err(error) => error.to_string(),
    };
    assert_eq!(code(), "opened");
    write_world(&project, "[[build]]\nop = \"box\"\nmin = [0, 0, 0]\nmax = [4, 4, 4]\nmaterial = \"soil\"\n");
    assert_eq!(code(), "RX0353 at \"saves/field\"");
}

#[test]
fn a_changed_world_file_keeps_the_edits_that_still_fit() {
    let project = project();
    let mut session = open(Options { watch: true, poll: true, ..field(project.root(), Saves::Ignore) });
    frame(&mut session);
    let soil = session.scene().material("soil").unwrap();
    session.edit(&[Operation::sphere([-20.0, 9.0, 0.0], 5.0, Brush::Add(soil))]).unwrap();
    frame(&mut session);
    let edited = session.world().voxels().solids();
    write_world(&project, "[[build]]\nop = \"box\"\nmin = [70, 0, 0]\nmax = [74, 4, 4]\nmaterial = \"soil\"\n");
    let mut events = Vec::new();
    for _ in 0..40 {
        events.extend(session.wait_reload(Duration::from_millis(500)));
        if !events.is_empty() {
            break;
        }
    }
    assert_eq!(events.len(), 1, "{events:?}");
    assert_eq!(session.world().voxels().solids(), edited + 64);
    frame(&mut session);
    assert_exact(&mut session);
    // And it can still be undone.
    session.undo().unwrap();
    frame(&mut session);
    assert_exact(&mut session);
}

#[test]
fn edits_of_a_demo_are_a_function_of_time() {
    let project = project();
    let demo = include_str!("fixtures/edits/edits.demo.toml");
    let path = project.path("worlds/field.demo.toml");
    fs::write(&path, demo).unwrap();
    let options = || Options { demo: Some(path.clone()), step: Some(0.1), ..field(project.root(), Saves::Write) };
    let mut whole = open(options());
    let mut pictures = Vec::new();
    let mut dispatched = Vec::new();
    for _ in 0..40 {
        dispatched.push(frame(&mut whole).dispatched);
        pictures.push(whole.read_presented().unwrap());
    }
    assert_exact(&mut whole);
    assert!(!project.path("saves").exists(), "a demo saves nothing");
    let mut different = pictures.clone();
    different.dedup();
    assert_eq!(different.len(), 4, "before, and after each time");
    // Frames between two edits run nothing.
    assert!(dispatched.iter().filter(|count| **count > 0).count() <= 8, "{dispatched:?}");
    // Parts that begin anywhere, also going back, show the same.
    let mut part = open(options());
    for index in [35_usize, 20, 2, 16, 14, 31] {
        part.seek(index as f64 * 0.1);
        frame(&mut part);
        assert!(part.read_presented().unwrap() == pictures[index], "frame {index}");
    }
    // A mistake is reported at its place.
    for (from, to, code) in [
        ("\"lamp\"", "\"lampp\"", "RX0301"),
        ("time = 3\n", "time = 1\n", "RX0406"),
        ("radius = 9.5", "radius = 9000", "RX0014"),
        ("size = [8, 20, 8]", "size = [100000, 100000, 8]", "RX0350"),
        ("op = \"restore\"", "op = \"model\"", "RX0013"),
    ] {
        fs::write(&path, demo.replace(from, to)).unwrap();
        let Err(OpenError::Project { diagnostics, .. }) = Session::open(options()) else { panic!("{to} is accepted") };
        let found: Vec<String> = diagnostics.iter().map(|diagnostic| diagnostic.code.to_string()).collect();
        assert!(found.contains(&code.to_owned()), "{to}: {diagnostics:?}");
    }
}
