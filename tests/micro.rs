//! Micro-voxels (`<raxel/micro.glsl>`): rays meet them as they meet the voxels of a world that is 4 times as large, to the last bit.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::Project;
use glam::IVec3;
use raxel::world::{World, vox};
use raxel::{DebugTarget, Options, Session, Validation};

/// Cells of the texture, along each axis.
const CELLS: [u32; 3] = [16, 12, 10];
const SIZE: [u32; 2] = [256, 256];

/// Rays from in and around the texture: to all sides, along axes, through corners and edges. With SCALED, the world is met, and each ray is one of a
/// world that is 4 times as large.
const RAYS: &str = include_str!("fixtures/micro/rays.comp");

/// Few, many, all or no micro-voxels of a cell, by its place.
const FILL: &str = include_str!("fixtures/micro/fill.comp");

fn graph(world: bool) -> String {
    let [x, y, z] = CELLS;
    let sources = if world {
        "[buffers.world]\nsource = \"world.tree64\"\n".to_owned()
    } else {
        format!(
            r#"[targets.micro]
format = "rg32ui"
size = [{x}, {y}, {z}]
[[passes]]
name = "fill"
shader = "fill.comp"
dispatch = {{ threads = "micro" }}
bind = {{ outMicro = "micro" }}
"#
        )
    };
    let (bind, defines) = if world { ("world = \"world\"", "SCALED = 1") } else { ("micro = \"micro\"", "") };
    format!(
        r#"name = "rays"
present = "place"
[targets.voxel]
format = "rgba32i"
[targets.place]
format = "rgba32f"
{sources}[[passes]]
name = "rays"
shader = "rays.comp"
dispatch = {{ threads = "place" }}
defines = {{ {defines} }}
bind = {{ {bind}, outVoxel = "voxel", outPlace = "place" }}
"#
    )
}

fn open(project: &Project, name: &str) -> Session {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(&format!("graphs/{name}.toml"))),
        world: Some(project.path("worlds/test.toml")),
        size: SIZE,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{name}: {error}"));
    for target in ["voxel", "place"] {
        session.pin(target).unwrap();
    }
    session.set_debug_target(DebugTarget::resource("place")).unwrap();
    session
}

fn rays(session: &mut Session) -> (Vec<u8>, Vec<u8>) {
    session.frame().unwrap();
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    (session.read_target("voxel").unwrap().bytes, session.read_target("place").unwrap().bytes)
}

#[test]
fn rays_meet_micro_voxels_as_they_meet_the_voxels_of_a_larger_world() {
    let project = Project::shipped();
    project.write("shaders/rays.comp", RAYS).write("shaders/fill.comp", FILL);
    project.write("graphs/micro.toml", graph(false)).write("graphs/scaled.toml", graph(true));
    let world = include_str!("fixtures/micro/model.toml");
    let one = World::from_voxels(raxel_oracle::scenes::materials(), [(IVec3::ZERO, 1)]);
    project.write("worlds/test.toml", world).write("worlds/micro.vox", vox::export(&one).unwrap());

    let mut session = open(&project, "micro");
    session.pin("micro").unwrap();
    let small = rays(&mut session);
    let texels: Vec<u8> = (0..CELLS[2]).flat_map(|z| session.read_texels("micro", 0, 0, z).unwrap().bytes).collect();
    let words: Vec<u32> = texels.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    let [x, y, _] = CELLS;
    let mut voxels = Vec::new();
    for (i, cell) in words.chunks_exact(2).enumerate() {
        let i = i as u32;
        let corner = 4 * IVec3::new((i % x) as i32, (i / x % y) as i32, (i / (x * y)) as i32);
        for bit in 0..64 {
            if cell[bit >> 5] >> (bit & 31) & 1 != 0 {
                voxels.push((corner + IVec3::new(bit as i32 & 3, bit as i32 >> 4, bit as i32 >> 2 & 3), 1));
            }
        }
    }
    assert!(voxels.len() > 5000, "{} of {} words", voxels.len(), words.len());
    let large = World::from_voxels(raxel_oracle::scenes::materials(), voxels);
    project.write("worlds/micro.vox", vox::export(&large).unwrap());
    let large = rays(&mut open(&project, "scaled"));

    let hits = small.0.chunks_exact(16).filter(|hit| hit[15] == 0).count();
    let all = (SIZE[0] * SIZE[1]) as usize;
    assert!(hits > all / 20 && hits < all, "{hits} of {all} rays meet something");
    let differ = small.0.chunks_exact(16).zip(large.0.chunks_exact(16)).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "of {all} rays meet another voxel or face");
    let differ = small.1.chunks_exact(16).zip(large.1.chunks_exact(16)).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "of {all} rays meet it elsewhere");
}
