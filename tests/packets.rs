//! `graphs/primary.toml` finds first hits in one of two ways, depending on the device (`device.packets`). `graphs/bench/sun.toml` does so for rays to the sun.
//! Both ways give the same bits.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::{Project, SUBGROUP_OF_64};
use glam::{IVec3, Vec3};
use raxel::{Camera, Options, Session, Validation, Value};

const TARGETS: [&str; 4] = ["color", "hit", "depth", "place"];

/// A shipped graph over a world.
fn open_graph(project: &Project, graph: &str, world: &str, pinned: &[&str]) -> Session {
    Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path(&format!("worlds/{world}.toml"))),
        pinned: pinned.iter().map(|target| (*target).to_owned()).collect(),
        size: [93, 55],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{graph} over {world}: {error}"))
}

/// Whether each of these passes runs.
fn runs<const N: usize>(session: &Session, passes: [&str; N]) -> [bool; N] {
    let plan = session.plan().expect("it is open");
    passes.map(|name| plan.passes.iter().any(|pass| plan.graph.pass(pass.pass).name == name))
}

/// The graph that raxel opens with over a world, and whether it traces packets.
fn open(project: &Project, world: &str) -> (Session, bool) {
    let session = open_graph(project, "graphs/primary.toml", world, &TARGETS);
    let [packets, rest, found, one_by_one] = runs(&session, ["packets", "packets_rest", "trace_found", "trace"]);
    assert_eq!([rest, found, !one_by_one], [packets; 3], "one way as a whole, and not the other");
    (session, packets)
}

/// The graph with defines more for the pass of a shader.
fn defined(graph: &str, shader: &str, defines: &str) -> String {
    let line = format!("shader   = \"{shader}\"\n");
    assert_eq!(graph.matches(&line).count(), 1, "{shader}");
    graph.replace(&line, &format!("{line}defines  = {{ {defines} }}\n"))
}

/// The graph that goes the other way: where packets are traced that without them, elsewhere packets.
fn swapped(graph: &str) -> String {
    let swapped = graph.replace("\"!device.packets\"", "\"\"").replace("\"device.packets\"", "\"!device.packets\"");
    swapped.replace("= \"\"", "= \"device.packets\"")
}

/// For packets on a device that has none: a tile then has no subgroup of 32, and talks through shared memory.
const SLOW: &str = "RX_TILE_BY_SHARED_MEMORY = \"1\"";

/// Lets a shader of packets run by half of a subgroup of 64, on any device.
fn by_half_of_64(project: &Project, shader: &str, include: &str) {
    project.write("shaders/subgroup_of_64.glsl", SUBGROUP_OF_64);
    project.edit(shader, include, &format!("#include \"subgroup_of_64.glsl\"\n{include}"));
}

fn look(session: &mut Session, camera: &Camera) -> [Vec<u8>; 4] {
    session.set_camera(*camera);
    session.frame().unwrap_or_else(|error| panic!("{camera:?}: {error}"));
    let texels = TARGETS.map(|target| session.read_target(target).expect("it is pinned").bytes);
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{camera:?}: {messages:#?}");
    texels
}

#[test]
fn both_ways_give_the_same_bits() {
    let [own, other] = [Project::shipped(), Project::shipped()];
    let graph = std::fs::read_to_string(other.path("graphs/primary.toml")).unwrap();
    other.write("graphs/primary.toml", defined(&swapped(&graph), "packet.comp", SLOW));
    same_bits(&own, &other);
}

#[test]
fn half_of_a_subgroup_of_64_gives_the_same_bits() {
    let [own, other] = [Project::shipped(), Project::shipped()];
    let graph = std::fs::read_to_string(other.path("graphs/primary.toml")).unwrap();
    other.write("graphs/primary.toml", swapped(&graph));
    by_half_of_64(&other, "shaders/packet.comp", "#include <raxel/packet.glsl>");
    same_bits(&own, &other);
}

/// The shipped graph of two projects over worlds.
fn same_bits(own: &Project, other: &Project) {
    for world in ["menger", "monument"] {
        let ((mut a, packets), (mut b, in_other)) = (open(own, world), open(other, world));
        assert_eq!(packets, a.device().capabilities().traces_packets());
        assert_ne!(packets, in_other);
        let first = *a.camera();
        let bounds = a.world().voxels().bounds().expect("it is not empty");
        let solid = a.world().voxels().voxels().next().expect("it is not empty").0;
        let at = |cell: IVec3, frac: Vec3, yaw: f64, pitch: f64| Camera { cell, frac, yaw, pitch, ..first };
        let outside = IVec3::from_array(bounds.min.map(|min| min as i32 - 40));
        for camera in [
            first,
            at(solid, Vec3::splat(0.5), 0.3, 0.1),
            at(outside, Vec3::new(0.25, 0.0, 0.75), 2.4, -0.6),
            // Along an axis, through corners of voxels.
            at(first.cell, Vec3::ZERO, 0.0, 0.0),
            at(first.cell, Vec3::splat(0.5), 0.0, -std::f64::consts::FRAC_PI_2),
        ] {
            let (a, b) = (look(&mut a, &camera), look(&mut b, &camera));
            for (target, (a, b)) in TARGETS.iter().zip(a.iter().zip(&b)) {
                let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
                assert_eq!((a.len(), differ), (b.len(), 0), "{target} of {world}, {camera:?}");
            }
        }
    }
}

/// Compares what `see_tiles` leaves for each pixel with the pixel's own ray: 0 where both are the same, 1 where they are not, 2 where the ray is left to `see`.
const JUDGE: &str = include_str!("fixtures/packets/judge.comp");

#[test]
fn tiles_of_the_face_cache_see_what_rays_within_pixels_see() {
    let project = Project::shipped();
    project.write("shaders/judge.comp", JUDGE);
    project.write("graphs/tiles.toml", include_str!("fixtures/packets/tiles.toml"));
    let mut session = open_graph(&project, "graphs/tiles.toml", "menger", &["judged"]);
    for frame in 0..6 {
        session.frame().unwrap_or_else(|error| panic!("frame {frame}: {error}"));
        let texels = session.read_target("judged").expect("it is pinned").bytes;
        let count = |kind: u32| texels.chunks_exact(4).filter(|texel| **texel == kind.to_le_bytes()).count();
        assert_eq!(count(1), 0, "frame {frame}");
        // Tiles leave those with too many voxels.
        assert!(count(0) > 1000, "frame {frame}: {} pixels by tiles, {} left", count(0), count(2));
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

#[test]
fn a_pass_has_the_subgroups_that_it_asks_for_where_the_device_has_them() {
    let project = Project::shipped();
    project.write(
        "shaders/subgroup.comp",
        r"#version 460
#extension GL_KHR_shader_subgroup_basic : require
layout(local_size_x = 32) in;
layout(r32ui) uniform writeonly uimage2D outSize;
void main() { imageStore(outSize, ivec2(gl_GlobalInvocationID.xy), uvec4(gl_SubgroupSize)); }
",
    );
    for size in [4, 8, 16, 32, 64, 128] {
        let (path, target) = ("graphs/subgroup.toml", format!("size_{size}"));
        let graph = format!(
            r#"name = "subgroup"
present = "{target}"
[targets.{target}]
format = "r32ui"
[[passes]]
name = "size"
shader = "subgroup.comp"
subgroup = {size}
dispatch = {{ threads = "{target}" }}
bind = {{ outSize = "{target}" }}
"#
        );
        project.write(path, graph);
        let mut session = open_graph(&project, path, "menger", &[&target]);
        session.frame().unwrap_or_else(|error| panic!("{error}"));
        let texels = session.read_target(&target).expect("it is pinned").bytes;
        let able = session.device().capabilities();
        let expected = if able.asks_for_subgroups_of(size) { size } else { able.subgroup_size };
        assert_eq!(texels[..4], expected.to_le_bytes(), "{size}, {able:?}");
        let messages = session.device().log().take();
        assert!(messages.is_empty(), "{messages:#?}");
    }
}

#[test]
fn rays_to_the_sun_end_alike_in_tiles_and_one_by_one() {
    let [own, other] = [Project::shipped(), Project::shipped()];
    let graph = std::fs::read_to_string(own.path(SUN)).unwrap();
    own.write(SUN, defined(&graph, "sun_tiles.comp", FAR));
    other.write(SUN, defined(&swapped(&graph), "sun_tiles.comp", &format!("{SLOW}, {FAR}")));
    same_sun(&own, &other);
}

#[test]
fn rays_to_the_sun_end_alike_by_half_of_a_subgroup_of_64() {
    let [own, other] = [Project::shipped(), Project::shipped()];
    let graph = std::fs::read_to_string(own.path(SUN)).unwrap();
    own.write(SUN, defined(&graph, "sun_tiles.comp", FAR));
    other.write(SUN, defined(&swapped(&graph), "sun_tiles.comp", FAR));
    by_half_of_64(&other, "shaders/sun_tiles.comp", "#include <raxel/parallel.glsl>");
    same_sun(&own, &other);
}

const SUN: &str = "graphs/bench/sun.toml";
/// In so small a picture the rays of a tile are far apart; they are traced together all the same.
const FAR: &str = r#"RX_PARALLEL_NEAR = "1.0e9", RX_PARALLEL_AREA = "1.0e9", RX_PARALLEL_LEAVES = "1024u""#;

/// The sun of two projects over worlds.
fn same_sun(own: &Project, other: &Project) {
    for world in ["menger", "monument"] {
        let mut sessions = [own, other].map(|project| open_graph(project, SUN, world, &["sun"]));
        let ways = sessions.each_ref().map(|session| runs(session, ["sun_tiles", "sun_rest", "sun"]));
        assert!(ways.contains(&[true, true, false]) && ways.contains(&[false, false, true]), "{ways:?}");
        // From the side, from above, along an axis nearly, and low.
        for [azimuth, elevation] in [[215.0, 32.0], [0.0, 90.0], [90.0, 0.001], [300.0, 4.0]] {
            let [a, b] = sessions.each_mut().map(|session| {
                session.set_param("sun_azimuth", Value::F32(azimuth)).unwrap();
                session.set_param("sun_elevation", Value::F32(elevation)).unwrap();
                session.frame().unwrap_or_else(|error| panic!("{error}"));
                session.read_target("sun").expect("it is pinned").bytes
            });
            let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count();
            assert_eq!((a.len(), differ), (b.len(), 0), "{world}, sun at {azimuth}, {elevation}");
            let seen = a.iter().map(|&texel| usize::from(texel == 1)).sum::<usize>();
            assert!(
                elevation < 30.0 || (100..a.len()).contains(&seen),
                "{world}: seen from {seen} of {} pixels",
                a.len()
            );
        }
        for session in &sessions {
            let messages = session.device().log().take();
            assert!(messages.is_empty(), "{messages:#?}");
        }
    }
}

#[test]
fn a_world_that_is_too_large_or_in_another_layout_has_no_packets() {
    let project = Project::shipped();
    project.write(
        "worlds/wide.toml",
        r##"name = "wide"
[materials]
a = { albedo = "#808080" }
[[build]]
op = "box"
material = "a"
min = [0, 0, 0]
max = [4200, 2, 2]
"##,
    );
    assert!(!open(&project, "wide").1);
    project.edit("graphs/primary.toml", "\"world.tree64\"", "\"world.chunks\"");
    assert!(!open(&project, "menger").1);
}
