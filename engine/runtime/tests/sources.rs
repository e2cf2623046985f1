//! Sources in sessions: a part of a world's buffer is written between frames. On a real device with the validation layer on.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use project::{TestProject, red, red_after_frame};
use raxel_runtime::execute::WriteError;
use raxel_world::layout::Layout;

/// 4³ voxels without the four at y = z = 3.
const BOX_WITHOUT_AN_EDGE: &str = r##"name = "box"
[materials]
red = { albedo = "#ff0000" }
[[build]]
op = "box"
min = [0, 0, 0]
max = [4, 4, 3]
material = "red"
[[build]]
op = "box"
min = [0, 0, 3]
max = [4, 3, 4]
material = "red"
"##;

#[test]
fn a_world_that_is_written_in_part_shows_in_the_next_frame() {
    let project = TestProject::new();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", BOX_WITHOUT_AN_EDGE);
    let mut session = project.open_graph("graphs/world.toml");
    assert_eq!(red_after_frame(&mut session), 60.0);
    assert_eq!(session.frame().unwrap().dispatched, 0);

    // The same box without the opposite edge: its bytes differ in a few places.
    let limits = raxel_runtime::sources::layout_limits(session.device());
    let now = Layout::Tree64.encode(session.world().voxels(), limits).unwrap().words;
    let other = {
        let cells = (4..64).map(|cell| glam::IVec3::new(cell % 4, cell / 4 % 4, cell / 16));
        let materials = session.world().voxels().materials().to_vec();
        let world = raxel_world::World::from_voxels(materials, cells.map(|cell| (cell, 1)));
        Layout::Tree64.encode(&world, limits).unwrap().words
    };
    assert_eq!(now.len(), other.len());
    let version = session.source("world.tree64").unwrap().version();
    let changed: Vec<usize> = (0..now.len()).filter(|at| now[*at] != other[*at]).collect();
    assert!((1..now.len() / 2).contains(&changed.len()), "{changed:?}");
    for at in changed {
        session.write_source("world.tree64", 4 * at as u64, &other[at].to_le_bytes()).unwrap();
    }
    assert_eq!(session.frame().unwrap().dispatched, 1);
    assert_eq!(red(&mut session), 0.0);
    assert_ne!(session.source("world.tree64").unwrap().version(), version);
    assert_eq!(session.frame().unwrap().dispatched, 0);

    // A layout that nothing binds is not there.
    let missing = session.write_source("world.svo", 0, &[0; 4]);
    assert_eq!(missing, Err(WriteError::NotThere { name: "world.svo".to_owned() }));
    project::assert_silent(&session);
}
