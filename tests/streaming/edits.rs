//! Edits of streamed worlds, by a program and by a demo.

use glam::IVec3;
use raxel::{Camera, Options, Session};
use raxel_edit::{Brush, Operation};
use raxel_runtime::Saves;

use crate::common::RunRaxel;
use crate::{assert_exact, hits, options, project};

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
    project.write("worlds/short.demo.toml", include_str!("../fixtures/streaming/edits.demo.toml"));
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
