//! A graph that changes voxels of a 3-D image and traces it, and the graph that holds two layouts against each other.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::collections::HashMap;
use std::fmt::Write as _;

use common::{Project, repository};
use glam::IVec3;
use raxel_gpu::Validation;
use raxel_oracle::Oracle;
use raxel_oracle::camera::Pinhole;
use raxel_runtime::camera::Camera;
use raxel_runtime::{Options, Session};
use raxel_world::World;

/// Voxels in the corners of a box of 192 x 64 x 320, whose mips are odd or one texel wide before they are all one texel.
const WORLD: &str = include_str!("fixtures/voxel_set/corners.toml");

const SIZE: [i32; 3] = [192, 64, 320];
const ORIGIN: [i32; 3] = [-64, 128, 0];

const FILL: &str = r"#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
uniform usampler3D voxels;
layout(r16ui) uniform writeonly uimage3D live;
void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (all(lessThan(texel, imageSize(live)))) imageStore(live, texel, texelFetch(voxels, texel, 0));
}
";

const SET: &str = include_str!("fixtures/voxel_set/set.comp");

const TRACE: &str = include_str!("fixtures/voxel_set/trace.comp");

fn graph() -> String {
    let [x, y, z] = SIZE;
    let mips = 1 + SIZE.into_iter().max().unwrap().ilog2();
    let mut text = format!(
        r#"
name = "set"
present = "hit"
[targets.hit]
format = "rgba32i"
[targets.voxels]
source = "world.texture3d"
[targets.live]
format = "r16ui"
size = [{x}, {y}, {z}]
mips = "full"
[buffers.world]
source = "world.texture3d"
[[passes]]
name = "fill"
shader = "fill.comp"
dispatch = {{ threads = "live" }}
bind = {{ voxels = "voxels", live = {{ target = "live", mip = 0 }} }}
[[passes]]
name = "set"
shader = "set.comp"
dispatch = {{ groups = [49, 16, 81] }}
bind = {{ world = "world", world_texels = {{ target = "live", mip = 0 }} }}
"#
    );
    for mip in 1..mips {
        writeln!(
            text,
            r#"[[passes]]
name = "mip{mip}"
shader = "voxel_mip.comp"
dispatch = {{ threads = "live", mip = {mip} }}
bind = {{ fine = {{ target = "live", mip = {} }}, coarse = {{ target = "live", mip = {mip} }} }}"#,
            mip - 1
        )
        .unwrap();
    }
    text.push_str(
        r#"
[[passes]]
name = "trace"
shader = "trace.comp"
dispatch = { threads = "hit" }
bind = { world = "world", world_voxels = "live", outHit = "hit" }
[passes.push]
view_to_world = "camera.view_to_world"
camera_cell = "camera.cell"
camera_frac = "camera.frac"
tan_half_fov = "camera.tan_half_fov"
"#,
    );
    text
}

/// The world after the pass `set`.
fn edited(world: &World) -> World {
    let mut voxels: HashMap<IVec3, u16> = world.voxels().collect();
    for z in 0..SIZE[2] as u32 {
        for y in 0..SIZE[1] as u32 {
            for x in 0..SIZE[0] as u32 {
                let cell = IVec3::from_array(ORIGIN) + IVec3::new(x as i32, y as i32, z as i32);
                let sum = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
                match sum.wrapping_mul(2_654_435_761) >> 20 {
                    1 => drop(voxels.insert(cell, 1 + 40_000 * (x & 1) as u16)),
                    3001.. => drop(voxels.remove(&cell)),
                    _ => {}
                }
            }
        }
    }
    // A shader may set materials that the world's file does not have, up to 65,535.
    let mut materials = world.materials().to_vec();
    materials.resize(40_002, materials[1].clone());
    World::from_voxels(materials, voxels)
}

#[test]
fn voxels_set_in_an_image_are_traced_exactly() {
    let project = Project::empty();
    project.write("graphs/set.toml", graph()).write("worlds/corners.toml", WORLD);
    project.write("shaders/fill.comp", FILL).write("shaders/set.comp", SET).write("shaders/trace.comp", TRACE);
    let mip = std::fs::read(repository().join("shaders/voxel_mip.comp")).expect("a shader that is shipped");
    project.write("shaders/voxel_mip.comp", mip);
    let size = [211, 160];
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/set.toml")),
        world: Some(project.path("worlds/corners.toml")),
        size,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let world = session.world().voxels().clone();
    let edited = edited(&world);
    assert!(edited.solids() > world.solids() + 500, "{} voxels", edited.solids());
    let oracle = Oracle::new(&edited);
    let mut hits = 0;
    for (position, yaw, pitch) in
        [([20.5, 160.25, 400.0], 0.0, 0.0), ([-300.0, 300.0, 160.5], -1.5, -0.5), ([31.9, 150.1, 100.7], 2.5, 0.1)]
    {
        let mut camera = Camera::at(position);
        (camera.fov, camera.yaw, camera.pitch) = (1.0, yaw, pitch);
        session.set_camera(camera);
        session.frame().expect("a frame");
        let found = session.read_target("hit").expect("the target");
        let found: Vec<[i32; 4]> = found.bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let pinhole = Pinhole {
            cell: camera.cell,
            frac: camera.frac,
            view_to_world: camera.view_to_world(),
            tan_half_fov: camera.tan_half_fov(f64::from(size[0]) / f64::from(size[1])),
        };
        for (found, ray) in found.iter().zip(pinhole.rays(size)) {
            let expected = oracle.first_hit(&ray).hit.map_or([0, 0, 0, -1], |hit| {
                let [x, y, z] = hit.voxel;
                [x, y, z, (hit.face + 8 * u32::from(hit.material)) as i32]
            });
            assert_eq!(*found, expected, "{ray:?}");
            hits += usize::from(expected[3] >= 0);
        }
    }
    assert!(hits > 2000, "{hits} hits");
    assert_eq!(session.device().log().take(), []);
}

#[test]
fn two_layouts_of_a_world_differ_nowhere() {
    let size = [160, 90];
    let mut session = Session::open(Options {
        project: Some(repository().into()),
        graph: Some("graphs/examples/two_layouts.toml".into()),
        world: Some("worlds/valley.toml".into()),
        size,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    session.frame().expect("a frame");
    let difference = session.read_target("difference").expect("the target");
    assert!(difference.bytes.iter().all(|byte| *byte == 0));
    let picture = session.read_presented().expect("the picture").rgba;
    let (left, right): (Vec<_>, Vec<_>) =
        picture.chunks_exact(4).zip(0..).partition(|(_, i)| i % size[0] < size[0] / 2);
    assert!(left.iter().all(|(pixel, _)| pixel[..3] != [0; 3]), "the world");
    assert!(right.iter().all(|(pixel, _)| pixel[..3] == [0; 3]), "the difference");
    assert_eq!(session.device().log().take(), []);
}
