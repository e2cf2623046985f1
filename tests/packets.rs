//! `graphs/primary.toml` finds what pixels see in one of two ways, by what the device can do (`device.packets`). Both give the same bits.

mod common;

use common::Project;
use glam::{IVec3, Vec3};
use raxel::{Camera, Options, Session, Validation};

const TARGETS: [&str; 4] = ["color", "hit", "depth", "place"];

/// The shipped graph over a world, and whether it traces packets.
fn open(project: &Project, world: &str) -> (Session, bool) {
    let session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/primary.toml")),
        world: Some(project.path(&format!("worlds/{world}.toml"))),
        pinned: TARGETS.map(str::to_owned).into(),
        size: [93, 55],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{world}: {error}"));
    let plan = session.plan().expect("it is open");
    let names: Vec<&str> = plan.passes.iter().map(|pass| plan.graph.pass(pass.pass).name.as_str()).collect();
    let packets = names.contains(&"packets");
    let ways = [names.contains(&"packets_rest"), names.contains(&"trace_found"), !names.contains(&"trace")];
    assert_eq!(ways, [packets; 3], "one way as a whole, and not the other: {names:?}");
    (session, packets)
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
    // Where packets are traced, the other way is that without; elsewhere it is packets.
    let graph = std::fs::read_to_string(other.path("graphs/primary.toml")).unwrap();
    let swapped = graph.replace("\"!device.packets\"", "\"\"").replace("\"device.packets\"", "\"!device.packets\"");
    let swapped = swapped.replace("= \"\"", "= \"device.packets\"");
    // A tile then has no subgroup of 32, and talks through shared memory.
    let shader = "shader   = \"packet.comp\"\n";
    assert_eq!(swapped.matches(shader).count(), 1);
    let slow = format!("{shader}defines  = {{ RX_TILE_BY_SHARED_MEMORY = \"1\" }}\n");
    other.write("graphs/primary.toml", swapped.replace(shader, &slow));
    for world in ["menger", "monument"] {
        let ((mut a, packets), (mut b, in_other)) = (open(&own, world), open(&other, world));
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

#[test]
fn a_world_that_is_too_large_or_in_another_layout_has_no_packets() {
    let project = Project::shipped();
    project.write("worlds/wide.toml", "name = \"wide\"\n[materials]\na = { albedo = \"#808080\" }\n[[build]]\nop = \"box\"\nmaterial = \"a\"\nmin = [0, 0, 0]\nmax = [4200, 2, 2]\n");
    assert!(!open(&project, "wide").1);
    project.edit("graphs/primary.toml", "\"world.tree64\"", "\"world.chunks\"");
    assert!(!open(&project, "menger").1);
}
