//! The 3-D image of a world in sessions: bound, shown, read back, replaced with its world, refused when no device could hold it. On a real
//! device with the validation layer on: no message may come.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::time::Duration;

use project::{Project, Sessions};
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{OpenError, Options, Session};

const GRAPH: &str = include_str!("fixtures/volume/volume.toml");

/// Extent of mip 1, its texel (1, 1, 1), material of a voxel by the layout's own look-up.
const SAMPLED: &str = include_str!("fixtures/volume/sampled.comp");

/// Number of texels of mip 2 that are not empty, counted through a storage image.
const STORED: &str = include_str!("fixtures/volume/stored.comp");

fn volume(edge: u32) -> Project {
    let project = Project::filled();
    project.write("graphs/volume.toml", GRAPH);
    project.write("shaders/sampled.comp", SAMPLED);
    project.write("shaders/stored.comp", STORED);
    project.write("worlds/box.toml", project::box_world(edge));
    project
}

fn open(project: &Project) -> Session {
    let options = Options { graph: Some("graphs/volume.toml".into()), pinned: vec!["sum".into()], ..project.options() };
    Project::open_with(options)
}

/// Integers of a slice.
fn slice(session: &mut Session, name: &str, mip: u32, layer: u32) -> Vec<u32> {
    let texels = session.read_texels(name, 0, mip, layer).unwrap_or_else(|error| panic!("{error}"));
    texels.integers().expect("an integer format").iter().map(|texel| texel[0]).collect()
}

#[test]
fn passes_read_the_image_and_it_follows_its_world() {
    let project = volume(5);
    let mut session = open(&project);
    session.frame().unwrap();
    // 64 voxels in mip 0, 7 mips; 2 x 2 x 2 cubes of 4 voxels are not empty.
    assert_eq!(project::texel(&mut session), [32.0, 1.0, 7.0, 0.0]);
    assert_eq!(slice(&mut session, "sum", 0, 0)[0], 8);

    assert_eq!(slice(&mut session, "voxels", 1, 2)[2 + 2 * 32], 1, "the plan knows its mips and slices");

    // It can be shown: slice 4 of mip 0 has 5 x 5 voxels, slice 5 none.
    session.set_debug_target_text("voxels,layer=4").unwrap();
    session.frame().unwrap();
    let texels = slice(&mut session, "voxels", 0, 4);
    assert_eq!((texels.len(), texels.iter().filter(|texel| **texel == 1).count()), (64 * 64, 25));
    assert!(slice(&mut session, "voxels", 0, 5).iter().all(|texel| *texel == 0));
    assert_eq!(slice(&mut session, "voxels", 6, 0), [1]);
    let shown = session.read_presented().unwrap();
    assert!(shown.rgba.chunks_exact(4).any(|pixel| pixel != &shown.rgba[..4]), "two colours");
    session.set_debug_target_text("color").unwrap();

    // Another world, another image, of another size.
    project.write("worlds/box.toml", project::box_world(70));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(reloaded.rebuilt.world && !reloaded.rebuilt.graph);
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [64.0, 1.0, 8.0, 0.0]);
    assert_eq!(slice(&mut session, "sum", 0, 0)[0], 18 * 18 * 18);
    // And another of the same size.
    project.write("worlds/box.toml", project::box_world(66));
    assert!(matches!(session.wait_reload(Duration::from_secs(60)).as_slice(), [ReloadEvent::Reloaded(_)]));
    session.frame().unwrap();
    assert_eq!(slice(&mut session, "sum", 0, 0)[0], 17 * 17 * 17);
    // An unchanged pass is not run again.
    let report = session.frame().unwrap();
    assert_eq!((report.dispatched, report.skipped), (0, 2), "{report:?}");
    project::assert_silent(&session);
}

#[test]
fn any_graph_can_have_its_world_so() {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", project::box_world(4));
    let options =
        Options { graph: Some("graphs/world.toml".into()), layout: Some(raxel_rivals::TEXTURE3D), ..project.options() };
    let mut session = Project::open_with(options);
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [64.0, 1.0, 0.0, 0.0]);
    assert_eq!(session.read_texels("world_voxels", 0, 0, 0).unwrap().width, 64);
    project::assert_silent(&session);
}

#[test]
fn a_world_that_no_image_can_hold_is_refused_with_both_numbers() {
    let project = volume(5);
    // Two voxels, 70,000 apart.
    let far = "[[build]]\nop = \"box\"\nmin = [70000, 0, 0]\nmax = [70001, 1, 1]\nmaterial = \"red\"\n";
    project.write("worlds/box.toml", &(project::box_world(1) + far));
    let options = Options { graph: Some("graphs/volume.toml".into()), ..project.options() };
    let Err(OpenError::Project { diagnostics, .. }) = Session::open(options) else { panic!("it opens") };
    assert!(!diagnostics.is_empty());
    for diagnostic in &diagnostics {
        assert_eq!(diagnostic.code.as_str(), "RX0407");
        let message = &diagnostic.message;
        assert!(message.contains("70016 voxels wide") && message.contains("`texture3d` holds at most"), "{message}");
        assert_eq!(&*diagnostic.labels[0].span.file, "graphs/volume.toml");
    }
}
