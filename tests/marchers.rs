//! The marchers of graphs/rivals/march all end. Exact ones hit the voxels of the oracle. The others fail as docs/rivals/marchers.md says,
//! and no more. The page quotes what `the_marchers_are_as_wrong_as_their_page_says` prints.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::fmt::Write;

use common::Project;
use glam::{DVec3, IVec3};
use raxel::world::{World, vox};
use raxel::{Camera, Options, Session, Validation, Value};
use raxel_layouts::Layout;
use raxel_oracle::camera::Pinhole;
use raxel_oracle::{Oracle, scenes};
use raxel_rivals as rivals;
use rayon::prelude::*;

/// A picture with odd sides: the last row and column have squares of 2 x 2 of their own.
const SIZE: [u32; 2] = [95, 57];

/// A miss.
const MISS: [i32; 4] = [0, 0, 0, -1];

/// Small scenes side by side: dust, a plane one voxel thick across all axes, a sponge, hills.
fn models() -> World {
    let place = |name: &str, corner: [i32; 3]| {
        let world = scenes::Scene::find(name).expect("a scene").world(IVec3::from_array(corner), 3);
        world.voxels().collect::<Vec<_>>()
    };
    let voxels = [
        place("sparse", [0, 0, 0]),
        place("diagonal", [110, 10, 0]),
        place("menger", [30, 20, 120]),
        place("hills", [100, 0, 100]),
    ];
    World::from_voxels(scenes::materials(), voxels.concat())
}

/// A project with the shipped graphs and two worlds: `near`, and `far`, which is the same, moved.
struct Bench {
    project: Project,
}

const FAR: [i32; 3] = [1 << 30, -(1 << 29), (1 << 30) - 64];

impl Bench {
    fn new() -> Self {
        let project = Project::shipped();
        project.write("worlds/models/scenes.vox", vox::export(&models()).expect("a small world"));
        let world = |name: &str, origin: [i32; 3]| {
            let build = format!("[[build]]\nop = \"model\"\nmodel = \"scenes\"\norigin = {origin:?}\n");
            let text = format!("name = \"{name}\"\n[models.scenes]\nfile = \"models/scenes.vox\"\n{build}");
            project.write(&format!("worlds/{name}.toml"), text);
        };
        world("near", [0; 3]);
        world("far", FAR);
        Self { project }
    }

    fn open(&self, graph: &str, world: &str) -> Marcher {
        self.open_over(graph, world, None)
    }

    fn open_over(&self, graph: &str, world: &str, layout: Option<Layout>) -> Marcher {
        let options = Options {
            project: Some(self.project.root().into()),
            graph: Some(self.project.path(&common::graph_in(common::TRACERS, graph))),
            world: Some(self.project.path(&format!("worlds/{world}.toml"))),
            layout,
            size: SIZE,
            pinned: ["hit", "depth", "steps"].map(str::to_owned).to_vec(),
            validation: Validation::Required,
            ..Options::default()
        };
        let session = Session::open(options).unwrap_or_else(|error| panic!("{graph}: {error}"));
        assert!(session.warnings().is_empty(), "{graph}: {:?}", session.warnings());
        // A .vox file says nothing of where it lies.
        let corner = |world: &World| world.bounds().expect("voxels").min.map(|c| c as i32);
        let [here, there] = [&models(), session.world().voxels()].map(|world| IVec3::from_array(corner(world)));
        Marcher { name: graph.to_owned(), session, moved: there - here }
    }
}

/// A graph that runs over a world.
struct Marcher {
    name: String,
    session: Session,
    /// Where its world has the origin of the scenes.
    moved: IVec3,
}

#[derive(Debug, PartialEq)]
struct Found {
    hits: Vec<[i32; 4]>,
    /// Bits of `f32`.
    depths: Vec<u32>,
    steps: u64,
}

impl Marcher {
    fn frame(&mut self) -> Found {
        let name = &self.name;
        self.session.frame().unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut read = |target: &str| self.session.read_target(target).expect(target);
        let hits = read("hit").integers().expect("integers");
        let depths = read("depth").floats().iter().map(|texel| texel[0].to_bits()).collect();
        let steps = read("steps").integers().expect("integers").iter().map(|texel| u64::from(texel[0])).sum();
        let messages = self.session.device().log().take();
        assert!(messages.is_empty(), "{name}: {messages:#?}");
        Found { hits: hits.iter().map(|hit| hit.map(u32::cast_signed)).collect(), depths, steps }
    }

    /// A camera of the scenes.
    fn look(&mut self, camera: &Camera) -> Found {
        self.session.set_camera(Camera { cell: camera.cell + self.moved, ..*camera });
        self.frame()
    }
}

fn camera(position: [f64; 3], target: [f64; 3], fov: f64) -> Camera {
    let mut camera = Camera::at(position);
    camera.look_at(target);
    camera.fov = fov.to_radians();
    camera
}

/// Over all, from among the dust, through the plane, along the hills, into the sponge, from 20,000 and 900,000 voxels away, and at the
/// wall of the sponge's tunnel, in the same block of 4^3.
fn cameras() -> Vec<Camera> {
    vec![
        camera([-120.3, 190.7, 320.1], [90.0, 10.0, 80.0], 45.0),
        camera([48.2, 47.9, 51.3], [110.0, 20.0, 110.0], 80.0),
        camera([160.4, 62.2, 47.7], [125.0, 25.0, 15.0], 60.0),
        camera([101.5, 33.3, 181.2], [180.0, 20.0, 101.0], 70.0),
        camera([43.5, 33.5, 160.2], [43.5, 33.5, 120.0], 50.0),
        camera([12_000.0, 9_000.0, 14_000.0], [90.0, 20.0, 80.0], 0.7),
        camera([-600_000.0, 500_000.0, -550_000.0], [90.0, 20.0, 80.0], 0.015),
        camera([39.3, 29.6, 125.7], [36.0, 28.0, 128.0], 100.0),
    ]
}

/// The hits of a camera's rays over a session's world, in the form of the target `hit`.
fn exact(over: &Marcher, camera: &Camera) -> Vec<[i32; 4]> {
    let pinhole = Pinhole {
        cell: camera.cell + over.moved,
        frac: camera.frac,
        view_to_world: camera.view_to_world(),
        tan_half_fov: camera.tan_half_fov(f64::from(SIZE[0]) / f64::from(SIZE[1])),
    };
    let oracle = Oracle::new(over.session.world().voxels());
    let hit = |ray: &_| {
        let Some(hit) = oracle.first_hit(ray).hit else { return MISS };
        let [x, y, z] = hit.voxel;
        [x, y, z, (hit.face + 8 * u32::from(hit.material)).cast_signed()]
    };
    pinhole.rays(SIZE).par_iter().map(hit).collect()
}

#[test]
fn what_is_exact_hits_what_the_oracle_hits() {
    let bench = Bench::new();
    for world in ["near", "far"] {
        let mut all: Vec<Marcher> = ["first_hit", "halfres", "raymask"].map(|graph| bench.open(graph, world)).into();
        for (number, camera) in cameras().into_iter().enumerate() {
            let expected = exact(&all[0], &camera);
            let hits = expected.iter().filter(|hit| **hit != MISS).count();
            assert!(hits * 20 > expected.len(), "camera {number} sees {hits} voxels");
            let found: Vec<Found> = all.iter_mut().map(|marcher| marcher.look(&camera)).collect();
            for (marcher, found_) in all.iter().zip(&found) {
                let wrong = expected.iter().zip(&found_.hits).filter(|(a, b)| a != b).count();
                assert_eq!(wrong, 0, "{} over {world}, camera {number}", marcher.name);
                assert_eq!(found_.depths, found[0].depths, "{} over {world}, camera {number}", marcher.name);
            }
        }
    }
}

/// Graphs leave the layout open: the empty space around a cell is described differently, and the hits are the same.
#[test]
fn marchers_go_over_every_layout() {
    let bench = Bench::new();
    let camera = &cameras()[2];
    for (graph, wrong) in [("halfres", 0), ("stackless", 5)] {
        let expected = exact(&bench.open(graph, "near"), camera);
        for &layout in rivals::LAYOUTS {
            let found = bench.open_over(graph, "near", Some(layout)).look(camera);
            let differ = expected.iter().zip(&found.hits).filter(|(a, b)| a != b).count();
            assert!(differ <= wrong, "{graph} over {} differs in {differ} pixels", layout.name());
        }
    }
}

/// The gain of the pass at half resolution and the masks: fewer looks, those of the bundles included.
#[test]
fn bundles_and_masks_save_steps() {
    let bench = Bench::new();
    let camera = &cameras()[0];
    let steps = bench.open_over("first_hit", "near", Some(rivals::BRICKMAP)).look(camera).steps;
    for graph in ["halfres", "raymask"] {
        let fewer = bench.open_over(graph, "near", Some(rivals::BRICKMAP)).look(camera).steps;
        assert!(fewer < steps, "{graph} looks {fewer} times, without it {steps}");
    }
}

/// Rays of some cameras.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: usize,
    hits: usize,
    /// Nothing is found where something is hit.
    missed: usize,
    /// Those and other voxels.
    wrong_voxel: usize,
    wrong_face: usize,
    steps: u64,
}

impl Tally {
    fn add(&mut self, expected: &[[i32; 4]], found: &Found) {
        self.rays += expected.len();
        self.steps += found.steps;
        for (a, b) in expected.iter().zip(&found.hits) {
            self.hits += usize::from(*a != MISS);
            self.missed += usize::from(*a != MISS && *b == MISS);
            if a[..3] != b[..3] || (a[3] < 0) != (b[3] < 0) {
                self.wrong_voxel += 1;
            } else if a[3] != b[3] {
                self.wrong_face += 1;
            }
        }
    }

    fn ppm(self, wrong: usize) -> f64 {
        wrong as f64 / self.rays as f64 * 1e6
    }
}

/// Cameras by their difficulty. The first four are easy. The fifth has ties: it looks along an axis from the centre of a voxel, so rays
/// pass edges. The sixth needs precision.
const KINDS: [std::ops::Range<usize>; 3] = [0..4, 4..5, 5..6];

type Ppm = std::ops::RangeInclusive<f64>;

/// The wrong rays of each marcher from each kind of camera, in ppm. The least is the error on its page.
const WRONG: &[(&str, [Ppm; 3])] = &[
    ("fixed", [10_000.0..=80_000.0, 20_000.0..=200_000.0, 5_000.0..=80_000.0]),
    ("rollback", [5_000.0..=50_000.0, 10_000.0..=100_000.0, 2_000.0..=50_000.0]),
    ("dda", [0.0..=100.0, 2_000.0..=50_000.0, 50.0..=20_000.0]),
    ("stackless", [0.0..=100.0, 2_000.0..=50_000.0, 50.0..=20_000.0]),
    ("stack", [0.0..=100.0, 2_000.0..=50_000.0, 50.0..=20_000.0]),
    ("raymask_seed", [500.0..=5_000.0, 500.0..=5_000.0, 500.0..=5_000.0]),
    ("first_hit", [0.0..=0.0, 0.0..=0.0, 0.0..=0.0]),
    ("halfres", [0.0..=0.0, 0.0..=0.0, 0.0..=0.0]),
    ("raymask", [0.0..=0.0, 0.0..=0.0, 0.0..=0.0]),
];

#[test]
fn the_marchers_are_as_wrong_as_their_page_says() {
    let bench = Bench::new();
    let cameras = cameras();
    let over = bench.open("first_hit", "near");
    let expected: Vec<Vec<[i32; 4]>> = cameras.iter().map(|camera| exact(&over, camera)).collect();
    let (mut table, mut surprises) = (String::new(), Vec::new());
    for (name, ranges) in WRONG {
        let mut marcher = bench.open(name, "near");
        let tallies = KINDS.map(|kind| {
            let mut tally = Tally::default();
            for number in kind {
                tally.add(&expected[number], &marcher.look(&cameras[number]));
            }
            tally
        });
        let wrong = tallies.map(|tally| tally.ppm(tally.wrong_voxel));
        let [near, aligned, far] = wrong;
        let face = tallies[0].ppm(tallies[0].wrong_face);
        let steps = tallies[0].steps as f64 / tallies[0].rays as f64;
        let _ = writeln!(table, "| `{name}` | {near:.0} | {face:.0} | {aligned:.0} | {far:.0} | {steps:.1} |");
        let exact = ranges.iter().all(|range| *range.end() == 0.0);
        let fits = wrong.iter().zip(ranges).all(|(wrong, range)| range.contains(wrong))
            && !(exact && tallies.iter().any(|tally| tally.wrong_face != 0));
        // Samples miss thin things, and incomplete masks miss some, but the marchers find most hits.
        let most = match *name {
            "fixed" | "rollback" => 10,
            "raymask_seed" => 50,
            _ => 100,
        };
        let fits = fits && tallies.iter().all(|tally| tally.missed * most < tally.hits);
        surprises.extend((!fits).then(|| format!("{name}: {wrong:?} ppm, {tallies:?}")));
    }
    println!("{table}");
    assert!(surprises.is_empty(), "{surprises:#?}");
}

#[test]
fn the_page_has_numbers_that_are_in_range() {
    let page = std::fs::read_to_string(common::repository().join("docs/rivals/marchers.md")).expect("the page");
    for (name, ranges) in WRONG {
        let start = format!("| `{name}` | ");
        let rows = page.lines().filter_map(|line| line.strip_prefix(&start)?.strip_suffix(" |"));
        let cells: Vec<f64> = rows.flat_map(|row| row.split(" | ")).filter_map(|cell| cell.parse().ok()).collect();
        let [near, _, aligned, far, _] = cells[..] else { panic!("{name}: {cells:?}") };
        for (number, range) in [near, aligned, far].iter().zip(ranges) {
            assert!(range.contains(number), "{name}: the page says {number}, expected is {range:?}");
        }
    }
}

/// The diagonal plane has no hole; steps of a quarter of a voxel find some, and shorter ones fewer.
#[test]
fn samples_slip_through_the_corners_of_a_thin_plane() {
    let bench = Bench::new();
    // Straight at the plane from its empty side, with nothing behind.
    let middle = DVec3::new(130.0, 30.0, 20.0);
    let camera = camera((middle + DVec3::new(40.3, 39.9, 40.1)).to_array(), middle.to_array(), 12.0);
    let expected = exact(&bench.open("first_hit", "near"), &camera);
    assert!(expected.iter().all(|hit| *hit != MISS), "{}", expected.iter().filter(|hit| **hit == MISS).count());
    let wrong = |step: &str| {
        let pass = format!("[[passes]]\nname = \"first_hit\"\ndefines = {{ RX_MARCH_STEP = \"{step}\" }}\n");
        bench.project.write("graphs/bench/steps.toml", format!("extends = \"../rivals/march/fixed.toml\"\n{pass}"));
        let found = bench.open("steps", "near").look(&camera);
        expected.iter().zip(&found.hits).filter(|(a, b)| a[..3] != b[..3]).count()
    };
    let [coarse, usual, fine] = ["1.0", "0.25", "0.03"].map(wrong);
    assert!(coarse > usual && usual > fine && fine > 0, "{coarse} {usual} {fine}");
}

#[test]
fn rays_that_are_none_end_and_hit_nothing() {
    let bench = Bench::new();
    let turned = |value: [f32; 3]| {
        let column = [value[0], value[1], value[2], 0.0];
        Value::Mat4([[0.0; 4], [0.0; 4], column, [0.0, 0.0, 0.0, 1.0]])
    };
    for (name, ..) in WRONG {
        let mut marcher = bench.open(name, "near");
        let passes: Vec<String> = marcher.session.graph().passes.iter().map(|pass| pass.name.clone()).collect();
        let view = camera([43.5, 33.5, 300.0], [43.5, 33.5, 0.0], 50.0);
        let mut with = |member: &str, value: Value| {
            for pass in passes.iter().filter(|pass| *pass != "bake") {
                marcher.session.set_push(pass, member, value).expect(member);
            }
            let found = marcher.look(&view);
            for pass in &passes {
                marcher.session.unset_push(pass, member);
            }
            found
        };
        let none = |found: Found| found.hits.iter().all(|hit| *hit == MISS);
        for direction in [[0.0; 3], [f32::NAN, 0.0, 1.0], [0.0, f32::INFINITY, 1.0], [1.0e-42, 0.0, 0.0]] {
            assert!(none(with("view_to_world", turned(direction))), "{name} hits something along {direction:?}");
        }
        assert!(none(with("camera_frac", Value::Vec3([f32::NAN, 0.5, 0.5]))), "{name} hits something from a NaN");
        // Two components are zero, and the ray lies in a plane between voxels.
        let straight = marcher_hit(&with("view_to_world", turned([0.0, 0.0, 1.0])));
        assert_eq!(straight, exact_straight(&marcher, view.cell), "{name}");
    }
}

/// All pixels have the same ray.
fn marcher_hit(found: &Found) -> [i32; 4] {
    assert!(found.hits.iter().all(|hit| *hit == found.hits[0]));
    found.hits[0]
}

/// The first voxel along -Z from a cell of the scenes.
fn exact_straight(over: &Marcher, cell: IVec3) -> [i32; 4] {
    let cell = cell + over.moved;
    let material = |z| over.session.world().voxels().voxel(IVec3::new(cell.x, cell.y, z));
    let z = (cell.z - 300..cell.z).rev().find(|z| material(*z) != 0).expect("the sponge");
    [cell.x, cell.y, z, 5 + 8 * i32::from(material(z))]
}
