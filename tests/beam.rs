//! Beams save steps of their tile's rays, and change no hit. graphs/bench/beam.toml and graphs/bench/packet.toml give the bits of
//! graphs/bench/hit.toml. Tiles of packets use shared memory if the device has no subgroups for them. The bits are those of the oracle, for any
//! camera and for the thinnest things. For more cameras than the usual ones:
//!
//! ```sh
//! RAXEL_BEAM_CAMERAS=200 cargo test --release --test beam
//! ```

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::Project;
use glam::{DMat3, DQuat, DVec3, IVec3, Mat3, Mat4, Vec3};
use raxel::world::{MaterialIndex, World, vox};
use raxel::{Camera, Options, Session, Validation, Value};
use raxel_layouts::Layout;
use raxel_oracle::camera::Pinhole;
use raxel_oracle::sets::Random;
use raxel_oracle::{Oracle, scenes};
use raxel_rivals as rivals;
use rayon::prelude::*;

/// Pictures of many tiles, of one, and of parts of some.
const SIZES: [[u32; 2]; 6] = [[129, 3], [95, 57], [7, 5], [161, 90], [16, 16], [31, 203]];

/// The place and the layout of a scene. A world holds the origin of the coordinates, or all of its coordinates are large.
const PLACES: [(&str, [i32; 3], Layout); 6] = [
    ("thin", [0, 0, 0], Layout::TREE64),
    ("thin", [-(1 << 30), 1 << 29, (1 << 30) - 200], Layout::TREE64),
    ("thin", [-111, -37, -70], rivals::BRICKMAP),
    ("thin", [1 << 30, -(1 << 30), 5], rivals::SVDAG),
    ("corners", [-3, 1000, -(1 << 30)], Layout::TREE64),
    ("corners", [-200, -100, -156], rivals::BRICKMAP),
];

/// Dust, a sloping plane one voxel thick, straight ones with gaps of one voxel between them, and rods.
fn thin() -> Vec<(IVec3, MaterialIndex)> {
    let scene = |name: &str, corner: [i32; 3]| {
        let world = scenes::Scene::find(name).expect("a scene").world(IVec3::from_array(corner), 5);
        world.voxels().collect::<Vec<_>>()
    };
    let mut voxels =
        [scene("sparse", [0, 0, 0]), scene("diagonal", [120, 7, 3]), scene("gravel", [9, 110, 90])].concat();
    for (a, b) in (0..40).flat_map(|a| (0..40).map(move |b| (a, b))) {
        voxels.push((IVec3::new(130 + a, 90, 60 + b), 1));
        voxels.push((IVec3::new(130, 95 + a, 60 + b), 2));
        voxels.push((IVec3::new(132, 95 + a, 60 + b), 3));
        if a == 0 {
            voxels.push((IVec3::new(100, 20 + b, 150), 1));
            voxels.push((IVec3::new(60 + b, 70, 170), 2));
        }
    }
    voxels
}

fn project() -> Project {
    let project = Project::shipped();
    let corners = scenes::Scene::find("corners").expect("a scene").world(IVec3::ZERO, 1);
    for (name, voxels) in [("thin", thin()), ("corners", corners.voxels().collect())] {
        let world = World::from_voxels(scenes::materials(), voxels);
        project.write(format!("worlds/models/{name}.vox").as_str(), vox::export(&world).expect("a small world"));
    }
    for (number, (name, origin, _)) in PLACES.iter().enumerate() {
        let build = format!("[[build]]\nop = \"model\"\nmodel = \"scene\"\norigin = {origin:?}\n");
        let text = format!("name = \"{name}\"\n[models.scene]\nfile = \"models/{name}.vox\"\n{build}");
        project.write(&format!("worlds/{number}.toml"), text);
    }
    project.write("worlds/empty.toml", "name = \"empty\"\n");
    project
}

/// Packets on a device that has no subgroups for them: a tile talks through shared memory.
fn packets_by_shared_memory(project: &Project) {
    let path = "graphs/bench/packet.toml";
    let graph = std::fs::read_to_string(project.path(path)).expect("it is shipped");
    let line = "shader   = \"packet.comp\"\n";
    assert_eq!(graph.matches(line).count(), 1);
    let define = "defines  = { RX_TILE_BY_SHARED_MEMORY = \"1\" }\n";
    let graph = graph.replace(line, &format!("{line}{define}"));
    project.write(path, graph);
}

/// A camera that may roll and stand on its head.
#[derive(Clone, Copy, Debug)]
struct View {
    cell: IVec3,
    frac: Vec3,
    /// View space to world space.
    turn: Mat3,
    /// Vertical, degrees.
    fov: f64,
}

/// A graph over a world.
struct Pictures {
    session: Session,
    passes: Vec<String>,
}

impl Pictures {
    fn open(project: &Project, graph: &str, world: &str, layout: Layout) -> Self {
        let pinned: &[&str] = if graph == "beam" { &["hit", "beams_8"] } else { &["hit"] };
        let options = Options {
            project: Some(project.root().into()),
            graph: Some(project.path(&common::graph_in(common::TRACERS, graph))),
            world: Some(project.path(&format!("worlds/{world}.toml"))),
            layout: Some(layout),
            pinned: pinned.iter().map(|&name| name.to_owned()).collect(),
            validation: Validation::Required,
            ..Options::default()
        };
        let session = Session::open(options).unwrap_or_else(|error| panic!("{graph} over {world}: {error}"));
        let warnings = session.warnings();
        assert!(warnings.is_empty() || world == "empty", "{graph} over {world}: {warnings:?}");
        // Those of the file: raxel makes others for queues.
        let passes = session.graph().passes.iter().filter(|pass| !pass.made).map(|pass| pass.name.clone()).collect();
        Self { session, passes }
    }

    /// Voxel and face of every pixel.
    fn look(&mut self, view: &View, size: [u32; 2]) -> Vec<[i32; 4]> {
        self.session.resize(size[0], size[1]);
        let camera = Camera { cell: view.cell, frac: view.frac, fov: view.fov.to_radians(), ..Camera::default() };
        self.session.set_camera(camera);
        let columns = Mat4::from_mat3(view.turn).to_cols_array_2d();
        for pass in &self.passes {
            self.session.set_push(pass, "view_to_world", Value::Mat4(columns)).expect("a member");
        }
        self.session.frame().unwrap_or_else(|error| panic!("{view:?}: {error}"));
        let hits = self.session.read_target("hit").expect("a target").integers().expect("integers");
        let messages = self.session.device().log().take();
        assert!(messages.is_empty(), "{view:?}: {messages:#?}");
        hits.iter().map(|hit| hit.map(u32::cast_signed)).collect()
    }

    /// The reach of beams of tiles that see something, as a share of the way to the nearest voxel: the sum, and the number of tiles.
    fn shares(&mut self, view: &View, size: [u32; 2], hits: &[[i32; 4]]) -> [f64; 2] {
        let depths = self.session.read_target("beams_8").expect("a target");
        let [across, width] = [depths.width as usize, size[0] as usize];
        let mut nearest = vec![f64::INFINITY; depths.floats().len()];
        for (i, hit) in hits.iter().enumerate().filter(|(_, hit)| hit[3] >= 0) {
            let (x, y) = (i % width / 8, i / width / 8);
            let way = (IVec3::from_slice(hit) - view.cell).as_dvec3() + 0.5 - view.frac.as_dvec3();
            if let Some(nearest) = nearest.get_mut(y * across + x).filter(|_| x < across) {
                *nearest = nearest.min(-way.dot(view.turn.z_axis.as_dvec3()));
            }
        }
        let seen = nearest.iter().zip(depths.floats()).filter(|(nearest, _)| nearest.is_finite() && **nearest > 4.0);
        seen.fold([0.0; 2], |[sum, count], (nearest, depth)| [sum + f64::from(depth[0]) / nearest, count + 1.0])
    }
}

/// The hits of the rays, in the form of the target `hit`.
fn exact(oracle: &Oracle, view: &View, size: [u32; 2]) -> Vec<[i32; 4]> {
    let camera = Camera { fov: view.fov.to_radians(), ..Camera::default() };
    let pinhole = Pinhole {
        cell: view.cell,
        frac: view.frac,
        view_to_world: Mat4::from_mat3(view.turn),
        tan_half_fov: camera.tan_half_fov(f64::from(size[0]) / f64::from(size[1])),
    };
    let hit = |ray: &_| {
        let found = oracle.first_hit(ray).hit;
        found.map_or([0, 0, 0, -1], |hit| [hit.voxel[0], hit.voxel[1], hit.voxel[2], hit.face as i32])
    };
    pinhole.rays(size).par_iter().map(hit).collect()
}

/// Cameras by where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Anywhere within the bounds.
    Within,
    /// In a solid voxel.
    Solid,
    /// On a corner of the lattice, looking at another.
    Lattice,
    /// Looking exactly along an axis, from the centre of a voxel, an edge or a corner.
    Along,
    /// Some sizes of the world away.
    Outside,
    /// So far away that a voxel is less than a pixel.
    Far,
    /// Farther than beams reach.
    Beyond,
    /// Almost half of all directions.
    Wide,
}

const KINDS: [Kind; 8] =
    [Kind::Within, Kind::Solid, Kind::Lattice, Kind::Along, Kind::Outside, Kind::Far, Kind::Beyond, Kind::Wide];

/// Places and directions for cameras over a world.
struct Cameras<'w> {
    random: Random,
    world: &'w World,
    solids: Vec<IVec3>,
}

impl Cameras<'_> {
    fn signed(&mut self) -> f64 {
        f64::from(2.0 * self.random.unit() - 1.0)
    }

    fn fraction(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.random.unit()))
    }

    fn cell(&mut self) -> IVec3 {
        let bounds = self.world.bounds().expect("voxels");
        let size = bounds.size();
        IVec3::from_array(std::array::from_fn(|i| bounds.min.map(|c| c as i32)[i] + self.random.below(size[i]) as i32))
    }

    fn solid(&mut self) -> IVec3 {
        self.solids[self.random.below(self.solids.len() as u64) as usize]
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.signed(), self.signed(), self.signed());
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    /// Looks along a direction, rolled by any angle.
    fn towards(&mut self, dir: DVec3) -> Mat3 {
        let roll = self.signed() * std::f64::consts::PI;
        let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, dir.normalize()) * DQuat::from_rotation_z(roll);
        DMat3::from_quat(turn).as_mat3()
    }

    /// Looks from a cell to the same place in a solid voxel.
    fn at_something(&mut self, cell: IVec3) -> Mat3 {
        let way = self.solid() - cell;
        self.towards(if way == IVec3::ZERO { DVec3::X } else { way.as_dvec3() })
    }

    fn take(&mut self, kind: Kind) -> View {
        let bounds = self.world.bounds().expect("voxels").size().map(|size| size as f64);
        let radius = DVec3::from_array(bounds).length() * 0.5;
        let fov = [0.7, 20.0, 60.0, 100.0][self.random.below(4) as usize];
        let view = |cell, frac, turn| View { cell, frac, turn, fov };
        match kind {
            Kind::Within => {
                let cell = self.cell();
                view(cell, self.fraction(), self.at_something(cell))
            }
            Kind::Solid => {
                let dir = self.direction();
                view(self.solid(), self.fraction(), self.towards(dir))
            }
            Kind::Lattice => {
                let cell = self.cell();
                view(cell, Vec3::ZERO, self.at_something(cell))
            }
            Kind::Along => {
                // A turn by quarters, its zeros exact.
                let quarter = |random: &mut Random| random.below(4) as f64 * std::f64::consts::FRAC_PI_2;
                let [x, y, z] = std::array::from_fn(|_| quarter(&mut self.random));
                let turn = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
                let turn = Mat3::from_cols_array(&turn.to_cols_array().map(|c| c.round() as f32));
                let frac = Vec3::from_array(std::array::from_fn(|_| self.random.below(2) as f32 * 0.5));
                // Back from something solid, so that there is something to see.
                let back = (turn.z_axis * self.random.below(90) as f32).as_ivec3();
                view(self.solid() + back, frac, turn)
            }
            Kind::Outside | Kind::Far | Kind::Beyond => {
                let [least, most] = match kind {
                    Kind::Outside => [1.1 * radius, 4.0 * radius],
                    Kind::Far => [2000.0, 9000.0],
                    _ => [30_000.0, 400_000.0],
                };
                let (target, dir) = (self.solid(), self.direction());
                let distance = least + (most - least) * (0.5 + 0.5 * self.signed());
                let spread = [0.5, 3.0][self.random.below(2) as usize];
                let fov = (2.0 * (spread * radius / distance).atan()).to_degrees();
                let offset = (dir * -distance).round();
                View { cell: target + offset.as_ivec3(), frac: self.fraction(), turn: self.towards(dir), fov }
            }
            Kind::Wide => {
                let cell = self.cell();
                let fov = [150.0, 178.0, 178.0][self.random.below(3) as usize];
                View { cell, frac: self.fraction(), turn: self.at_something(cell), fov }
            }
        }
    }
}

/// Cameras of each kind over each world.
fn count() -> u64 {
    std::env::var("RAXEL_BEAM_CAMERAS").ok().and_then(|text| text.parse().ok()).unwrap_or(8)
}

#[test]
fn beams_lose_and_change_no_hit() {
    let project = project();
    let mut wrong = Vec::new();
    let mut rays = 0;
    for (number, (name, origin, layout)) in PLACES.iter().enumerate() {
        let [mut plain, mut beams] =
            ["hit", "beam"].map(|graph| Pictures::open(&project, graph, &number.to_string(), *layout));
        // Packets walk one layout.
        if number == 0 && !plain.session.device().capabilities().traces_packets() {
            packets_by_shared_memory(&project);
        }
        let mut packets =
            (*layout == Layout::TREE64).then(|| Pictures::open(&project, "packet", &number.to_string(), *layout));
        let world = plain.session.world().clone();
        let world = world.voxels();
        let oracle = Oracle::new(world);
        let solids = world.voxels().map(|(cell, _)| cell).collect();
        let mut cameras = Cameras { random: Random::new(number as u64), world, solids };
        let (mut ahead, mut tiles) = (0.0, 0.0);
        for kind in KINDS {
            let (mut begun, mut seen, mut hits) = (0.0, 0.0, 0);
            for i in 0..count() {
                let size = match kind {
                    Kind::Far if i == 0 => [643, 361],
                    // The sides of a strip look almost across.
                    Kind::Wide if i % 2 == 0 => SIZES[0],
                    _ => SIZES[i as usize % SIZES.len()],
                };
                let view = cameras.take(kind);
                let expected = exact(&oracle, &view, size);
                let differ = |found: &[[i32; 4]]| found.iter().zip(&expected).filter(|(a, b)| a != b).count();
                let told = || format!("{name} at {origin:?} in {}, {kind:?} {i}, {size:?}: {view:?}", layout.name());
                let (without, with) = (differ(&plain.look(&view, size)), differ(&beams.look(&view, size)));
                if without + with > 0 {
                    wrong.push(format!("{without} rays without beams, {with} with: {}", told()));
                }
                let in_packets = packets.as_mut().map_or(0, |packets| differ(&packets.look(&view, size)));
                if in_packets > 0 {
                    wrong.push(format!("{in_packets} rays in packets: {}", told()));
                }
                let [sum, count] = beams.shares(&view, size, &expected);
                (begun, seen) = (begun + sum, seen + count);
                (rays, hits) = (rays + expected.len(), hits + expected.iter().filter(|hit| hit[3] >= 0).count());
            }
            assert!(hits > 0, "{name}, {kind:?}: nothing in sight");
            match kind {
                Kind::Beyond => assert!(begun <= 0.0, "{name} at {origin:?}: there are beams beyond their reach"),
                Kind::Within | Kind::Lattice | Kind::Along => (ahead, tiles) = (ahead + begun, tiles + seen),
                _ => {}
            }
        }
        // Beams that go nowhere would lose nothing either.
        let share = ahead / tiles;
        assert!(
            share > 0.75,
            "{name} at {origin:?}: beams go {share:.2} of the way to the nearest voxel of their tile"
        );
    }
    println!("{rays} rays");
    assert!(wrong.is_empty(), "{} pictures are wrong\n{}", wrong.len(), wrong[..wrong.len().min(20)].join("\n"));
}

#[test]
fn there_is_nothing_in_an_empty_world() {
    let project = project();
    for layout in [Layout::TREE64, rivals::BRICKMAP, rivals::SVDAG] {
        let mut beams = Pictures::open(&project, "beam", "empty", layout);
        for cell in [IVec3::ZERO, IVec3::splat(-300), IVec3::splat(40)] {
            let view = View { cell, frac: Vec3::splat(0.5), turn: Mat3::IDENTITY, fov: 60.0 };
            assert!(beams.look(&view, [40, 30]).iter().all(|hit| *hit == [0, 0, 0, -1]), "{}", layout.name());
        }
    }
}
