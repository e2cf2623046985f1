//! Period rays on the device have the same hits as 64-bit integers: one by one and with refilled lanes, from inside, outside and far
//! outside the world, through edges and corners.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::{Project, SUBGROUP_OF_64};
use glam::IVec3;
use raxel::world::{World, vox};
use raxel::{Options, Session, Validation};
use raxel_diagnostics::DiskFiles;
use raxel_oracle::period::{PeriodHit, PeriodRay};
use raxel_oracle::sets::Random;
use raxel_oracle::{Oracle, scenes};
use rayon::prelude::*;

/// A row of the targets.
const ROW: usize = 64;
const ROWS: usize = 160;

/// Each way to trace the rays of a file, a ray a pixel; one is by subgroups of 64.
const GRAPH: &str = include_str!("fixtures/period/period.toml");

const RAYS: &str = r"
struct Packed { ivec3 cell; uint octant; vec3 first; uint a; vec3 period; uint b; };
layout(std430) readonly buffer Rays { Packed rays[]; };
RxPeriodRay ray_of(uint i) { return RxPeriodRay(rays[i].cell, rays[i].octant, rays[i].first, rays[i].period); }
";

const PLAIN: &str = include_str!("fixtures/period/plain.comp");

const REFILL: &str = include_str!("fixtures/period/refill.comp");

fn rays(world: &World, seed: u64) -> Vec<PeriodRay> {
    let bounds = world.bounds().expect("voxels");
    let mut random = Random::new(seed);
    let ray = |i: usize| {
        let around: i64 = [0, 0, 3, 40, 700, 6000][i % 6];
        let cell = std::array::from_fn(|axis| {
            let low = bounds.min[axis] - around;
            (low + random.below((bounds.max[axis] + around - low) as u64) as i64) as i32
        });
        // Every other ray has few different periods, and so passes through edges and corners.
        let coarse = i % 4 < 2;
        let period: [u32; 3] = std::array::from_fn(|_| match random.below(9) {
            0 => 1 << 24,
            1 => 4096 + random.below(1 << 24) as u32 % ((1 << 24) - 4096),
            _ if coarse => 4096 + 1024 * random.below(12) as u32,
            _ => 4096 + random.below(60_000) as u32,
        });
        let first = std::array::from_fn(|axis| {
            let step = if coarse && period[axis].is_multiple_of(1024) { 1024 } else { 1 };
            step * (1 + random.below(u64::from(period[axis] / step)) as u32)
        });
        PeriodRay { cell, octant: random.below(8) as u32, first, period }
    };
    let mut all: Vec<PeriodRay> = (0..ROW * ROWS).map(ray).collect();
    // Rays without a direction hit nothing.
    all[17].period = [0; 3];
    all
}

fn bytes(rays: &[PeriodRay]) -> Vec<u8> {
    let words = rays.iter().flat_map(|ray| {
        let [x, y, z] = ray.cell.map(i32::cast_unsigned);
        let float = |words: [u32; 3]| words.map(|word| (word as f32).to_bits());
        let ([fx, fy, fz], [px, py, pz]) = (float(ray.first), float(ray.period));
        [x, y, z, ray.octant, fx, fy, fz, 0, px, py, pz, 0]
    });
    words.flat_map(u32::to_le_bytes).collect()
}

fn texel(hit: Option<&PeriodHit>) -> [i32; 4] {
    hit.map_or([0, 0, 0, -1], |hit| {
        let [x, y, z] = hit.voxel;
        [x, y, z, (hit.face + 8 * u32::from(hit.material)) as i32]
    })
}

#[test]
fn they_hit_what_whole_numbers_say() {
    let project = Project::shipped();
    project.write("graphs/period.toml", GRAPH);
    for (name, text) in [("plain", PLAIN), ("refill", REFILL)] {
        project.write(&format!("shaders/{name}.comp"), text.replace("RAYS", RAYS));
    }
    project.write("shaders/subgroup_of_64.glsl", SUBGROUP_OF_64);
    let include = "#include <raxel/refill.glsl>";
    let by_64 = REFILL.replace(include, &format!("#include \"subgroup_of_64.glsl\"\n{include}"));
    project.write("shaders/refill_by_64.comp", by_64.replace("RAYS", RAYS));
    let places = [
        ("hills", [0, 0, 0]),
        ("menger", [-(1 << 30), 1 << 29, (1 << 30) - 400]),
        ("gravel", [-111, -37, -70]),
        ("diagonal", [-3, 1000, 65]),
    ];
    for (number, (name, origin)) in places.into_iter().enumerate() {
        let scene = scenes::Scene::find(name).expect("a scene").world(IVec3::ZERO, 5);
        project.write(format!("worlds/models/{name}.vox").as_str(), vox::export(&scene).expect("a small world"));
        let build = format!("[[build]]\nop = \"model\"\nmodel = \"scene\"\norigin = {origin:?}\n");
        project.write(
            "worlds/here.toml",
            format!("name = \"{name}\"\n[models.scene]\nfile = \"models/{name}.vox\"\n{build}"),
        );
        project.write("data/rays.bin", "");
        let open = || {
            let options = Options {
                project: Some(project.root().into()),
                graph: Some(project.path("graphs/period.toml")),
                world: Some(project.path("worlds/here.toml")),
                validation: Validation::Required,
                pinned: ["plain", "refilled", "refilled_by_64", "place"].map(str::to_owned).to_vec(),
                ..Options::default()
            };
            Session::open(options).unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        // The rays depend on where the world lies.
        let loaded = raxel_worldfile::load(
            "worlds/here.toml",
            &DiskFiles::new(project.root()).unwrap(),
            &mut raxel::SourceMap::default(),
        );
        let world = loaded.unwrap().0.world;
        let rays = rays(&world, number as u64);
        std::fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();

        let mut session = open();
        session.frame().unwrap_or_else(|error| panic!("{name}: {error}"));
        let oracle = Oracle::new(&world);
        let exact: Vec<Option<PeriodHit>> =
            rays.par_iter().map(|ray| if ray.period == [0; 3] { None } else { ray.first_hit(&oracle) }).collect();
        let hits = exact.iter().flatten().count();
        let inside = exact.iter().flatten().filter(|hit| hit.face == 6).count();
        assert!(hits > 800 && inside > 10 && hits - inside > 700 && hits < rays.len() - 800, "{name}: {hits} {inside}");
        for target in ["plain", "refilled", "refilled_by_64"] {
            let found = session.read_target(target).expect("a target").integers().expect("integers");
            for ((ray, exact), found) in rays.iter().zip(&exact).zip(found) {
                assert_eq!(found.map(u32::cast_signed), texel(exact.as_ref()), "{name}, {target}: {ray:?}");
            }
        }
        let places = session.read_target("place").expect("a target");
        for ((ray, exact), place) in rays.iter().zip(&exact).zip(places.floats()) {
            let Some(hit) = exact else { continue };
            let time = hit.time as f64 / 4096.0;
            assert!((f64::from(place[0]) - time).abs() <= 1e-6 * time, "{ray:?}: {place:?} at {time}");
            // The place in the voxel along the axes of the face.
            let within = |axis: usize| {
                let sign = if ray.octant >> axis & 1 == 1 { -1 } else { 1 };
                let planes = f64::from((hit.voxel[axis] - ray.cell[axis]) * sign);
                let share = (hit.time as f64 - f64::from(ray.first[axis])) / f64::from(ray.period[axis]) + 1.0 - planes;
                if sign < 0 { 1.0 - share } else { share }
            };
            let axes = [[1, 2], [0, 2], [0, 1], [0, 1]][(hit.face / 2) as usize];
            for (uv, axis) in place[1..3].iter().zip(axes) {
                assert!((f64::from(*uv) - within(axis)).abs() < 2e-3, "{ray:?}: {place:?} against {}", within(axis));
            }
        }
        let messages = session.device().log().take();
        assert!(messages.is_empty(), "{name}: {messages:#?}");
    }
}
