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
const RAYS: &str = "#version 460
#include <raxel/random.glsl>
#ifdef SCALED
#include <raxel/world.glsl>
#endif
#include <raxel/micro.glsl>
layout(local_size_x = 8, local_size_y = 8) in;
#ifndef SCALED
uniform usampler3D micro;
#endif
layout(rgba32i) uniform writeonly iimage2D outVoxel;
layout(rgba32f) uniform writeonly image2D outPlace;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint seed = rx_hash(uint(pixel.x) + rx_hash(uint(pixel.y)));
    ivec3 cell = ivec3(0);
    uvec3 parts = uvec3(0u);
    vec3 dir = rx_random_direction(seed);
    uint kind = uint(pixel.x) & 7u;
    for (int i = 0; i < 3; ++i) {
        cell[i] = int(rx_random(seed) * 32.0) - 10;
        // In steps of 2^-22, which 4 times as much is exact for; or on corners of micro-voxels.
        parts[i] = kind == 0u ? uint(rx_random(seed) * 5.0) << 20 : uint(rx_random(seed) * 4194304.0);
        if (kind == 1u && rx_random(seed) < 0.5) dir[i] = 0.0;
        if (kind < 3u) dir[i] = sign(dir[i]) * float(1 + (uint(rx_random(seed) * 3.0)));
        if (kind == 1u && rx_random(seed) < 0.3) dir[i] = 0.0;
    }
    RxHit hit;
#ifdef SCALED
    uvec3 whole = min(parts >> 20, uvec3(3u));
    RxRay ray = rx_ray(4 * cell + ivec3(whole), vec3(parts - (whole << 20)) / 1048576.0, dir);
    bool found = rx_trace(ray, hit);
#else
    RxRay ray = rx_micro_ray(rx_ray(cell, vec3(parts) / 4194304.0, dir));
    bool found = rx_trace_micro(micro, ivec3(0), ray, hit);
#endif
    imageStore(outVoxel, pixel, found ? ivec4(hit.voxel, int(hit.face)) : ivec4(-1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(-1.0));
}
";

/// Few, many, all or no micro-voxels of a cell, by its place.
const FILL: &str = "#version 460
#include <raxel/random.glsl>
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(rg32ui) uniform writeonly uimage3D outMicro;
void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, imageSize(outMicro)))) return;
    uint seed = rx_hash(uint(cell.x + 64 * (cell.y + 64 * cell.z)));
    uvec2 few = uvec2(rx_hash(seed) & rx_hash(seed + 1u), rx_hash(seed + 2u) & rx_hash(seed + 3u));
    few &= uvec2(rx_hash(seed + 4u), rx_hash(seed + 5u)) & uvec2(rx_hash(seed + 6u), rx_hash(seed + 7u));
    uint kind = seed % 16u;
    uvec2 bits = kind == 0u ? uvec2(0xffffffffu) : kind == 1u ? uvec2(seed, ~seed) : kind < 5u ? few : uvec2(0u);
    imageStore(outMicro, cell, uvec4(bits, 0u, 0u));
}
";

fn graph(world: bool) -> String {
    let [x, y, z] = CELLS;
    let sources = if world {
        "[buffers.world]\nsource = \"world.tree64\"\n".to_owned()
    } else {
        format!(
            "[targets.micro]\nformat = \"rg32ui\"\nsize = [{x}, {y}, {z}]\n[[passes]]\nname = \"fill\"\n\
             shader = \"fill.comp\"\ndispatch = {{ threads = \"micro\" }}\nbind = {{ outMicro = \"micro\" }}\n"
        )
    };
    let (bind, defines) = if world { ("world = \"world\"", "SCALED = 1") } else { ("micro = \"micro\"", "") };
    format!(
        "name = \"rays\"\npresent = \"place\"\n[targets.voxel]\nformat = \"rgba32i\"\n[targets.place]\nformat = \"rgba32f\"\n{sources}\
         [[passes]]\nname = \"rays\"\nshader = \"rays.comp\"\ndispatch = {{ threads = \"place\" }}\ndefines = {{ {defines} }}\n\
         bind = {{ {bind}, outVoxel = \"voxel\", outPlace = \"place\" }}\n"
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
    let world = "name = \"test\"\n[models]\nmicro = { file = \"micro.vox\" }\n[camera]\nposition = [0.0, 0.0, 90.0]\nlook_at = [0.0, 0.0, 0.0]\n\
                 [[build]]\nop = \"model\"\nmodel = \"micro\"\nanchor = \"origin\"\n";
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
