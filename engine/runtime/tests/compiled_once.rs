//! A shader is compiled once, for any values that it branches on, and the next edit releases the memory of the last one. lavapipe compiles
//! a shader again for each dispatch where it can fold those values in, and keeps the result as executable pages of the process: these are
//! counted. Nothing here depends on time.
#![cfg(target_os = "linux")]

mod project;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_runtime::Options;

/// A pass that branches on a block and on push constants, and is so large that lavapipe gains by folding them in.
const GRAPH: &str = "graphs/rivals/light/pbr_sky.toml";

/// One test must not count the pages of the other.
static ALONE: Mutex<()> = Mutex::new(());

/// Executable pages that come from no file: what drivers compiled, as pieces.
fn compiled_pieces() -> usize {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    maps.lines()
        .filter(|line| line.split_whitespace().nth(1) == Some("r-xp") && line.split_whitespace().count() == 5)
        .count()
}

#[test]
fn frames_compile_nothing_again() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut session = Project::open_with(Options {
        project: Some(root),
        graph: Some(GRAPH.into()),
        world: Some("worlds/pool.toml".into()),
        size: [32, 18],
        watch: false,
        ..Project::filled().options()
    });
    let frames = |session: &mut raxel_runtime::Session, count: usize| {
        for _ in 0..count {
            session.frame().unwrap();
        }
        session.read_target("color").unwrap();
    };
    frames(&mut session, 4);
    let before = compiled_pieces();
    frames(&mut session, 40);
    assert_eq!(compiled_pieces(), before, "a shader was compiled again for other values");
    assert_silent(&session);
}

/// Edits that do not change a shader make a plan and its objects again, and release the old ones. Everything that is
/// made on a device holds it.
#[test]
fn edits_leave_nothing_behind() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let project = Project::filled();
    let mut session = project.open();
    let mut objects = Vec::new();
    for edit in 0..12 {
        project.write("graphs/fill.toml", format!("{}# {edit}\n", project::FILL_GRAPH));
        let mut waits = 0;
        while session.wait_reload(Duration::from_secs(10)).is_empty() {
            waits += 1;
            assert!(waits < 30, "edit {edit} was not seen");
        }
        session.frame().unwrap();
        session.read_target("color").unwrap();
        objects.push(Arc::strong_count(session.device()));
    }
    // The first edits make what every frame in flight reads back into.
    let largest = |part: &[usize]| part.iter().copied().max().unwrap_or_default();
    let (first, second) = objects.split_at(6);
    assert!(largest(second) <= largest(first), "objects on the device, after each edit: {objects:?}");
    assert_silent(&session);
}
