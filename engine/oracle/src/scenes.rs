//! Small worlds that are hard on tracers. All seeded, all deterministic.

use glam::IVec3;
use raxel_world::{MAX_MATERIALS, Material, World};

use crate::sets::Random;

/// A scene's name and how it is built.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name.
    pub name: &'static str,
    /// The faults that it is made to find.
    pub about: &'static str,
    /// Voxels along an edge of its cube.
    pub size: i32,
    solid: Solid,
}

/// The solid cells of a scene, and their material.
#[derive(Clone, Copy, Debug)]
enum Solid {
    /// Cell by cell.
    Cells(fn(IVec3, &mut Random) -> u16),
    /// So many voxels at random places.
    Random(u32),
    /// One voxel in each corner.
    Corners,
    /// So many boxes of random sizes at random places.
    Boxes(u32),
    /// For each x and z the lowest and one past the highest y of the ground.
    Ground(fn(i32, i32) -> [i32; 2]),
}

/// Every scene.
#[expect(clippy::cast_possible_truncation, reason = "random numbers are below what they were asked for")]
pub const ALL: &[Scene] = &[
    Scene {
        name: "dust",
        about: "0.01 % of the voxels at random: rays pass far through nothing",
        size: 192,
        solid: Solid::Random(708),
    },
    Scene {
        name: "sparse",
        about: "one voxel in 500 at random: rays pass many edges before they hit",
        size: 96,
        solid: Solid::Cells(|_, random| if random.below(500) == 0 { 1 + random.below(3) as u16 } else { 0 }),
    },
    Scene {
        name: "gravel",
        about: "2 % of the voxels at random: solids touch by edges and corners",
        size: 64,
        solid: Solid::Cells(|_, random| if random.below(50) == 0 { 1 + random.below(3) as u16 } else { 0 }),
    },
    Scene {
        name: "motley",
        about: "3 % of the voxels at random in materials of all numbers: layouts pack them in many ways",
        size: 40,
        solid: Solid::Cells(|_, random| if random.below(33) == 0 { any_material(random) } else { 0 }),
    },
    Scene {
        name: "rubble",
        about: "three of four voxels at random: what is left out behind others is beside all patterns of neighbours",
        size: 24,
        solid: Solid::Cells(|_, random| u16::from(random.below(4) != 0)),
    },
    Scene {
        name: "checkerboard",
        about: "every other voxel: each edge and corner of the lattice is one of a solid",
        size: 24,
        solid: Solid::Cells(|c, _| u16::from((c.x + c.y + c.z) & 1 == 0)),
    },
    Scene {
        name: "diagonal",
        about: "a plane one voxel thick: a tracer that slips through an edge sees the other side",
        size: 40,
        solid: Solid::Cells(|c, _| u16::from(c.x + c.y + c.z == 60)),
    },
    Scene {
        name: "slope",
        about: "a plane of steps, x + y + 2z: rows of edges in three directions",
        size: 48,
        solid: Solid::Cells(|c, _| u16::from((c.x + c.y + 2 * c.z - 96).abs() < 2)),
    },
    Scene { name: "solid", about: "a full cube: filled nodes, starts inside", size: 72, solid: Solid::Cells(|_, _| 2) },
    Scene {
        name: "boxes",
        about: "boxes of all sizes: faces on the borders of nodes and off them, full nodes beside empty ones",
        size: 96,
        solid: Solid::Boxes(90),
    },
    Scene {
        name: "cubes",
        about: "two full cubes of 64³, which are nodes where the scene is at an end of the coordinates: filled nodes of filled nodes",
        size: 128,
        solid: Solid::Cells(|c, _| u16::from(c.x >> 6 == c.y >> 6 && c.x >> 6 == c.z >> 6)),
    },
    Scene {
        name: "corners",
        about: "single voxels in the corners of a large box: long steps over nothing",
        size: 256,
        solid: Solid::Corners,
    },
    Scene {
        name: "menger",
        about: "a Menger sponge of three levels: holes of all sizes",
        size: 27,
        solid: Solid::Cells(|c, _| {
            let hole = |k: i32| c.to_array().iter().filter(|c| **c / k % 3 == 1).count() >= 2;
            u16::from(!hole(1) && !hole(3) && !hole(9))
        }),
    },
    Scene {
        name: "hills",
        about: "a shell of ground three voxels thick in two materials: what games look like",
        size: 80,
        solid: Solid::Ground(|x, z| {
            let (x, z) = (x as f32 * 0.13, z as f32 * 0.11);
            let height = (20.0 + 9.0 * x.sin() * z.cos() + 4.0 * (2.3 * x + z).sin()) as i32;
            [height - 2, height + 1]
        }),
    },
    Scene {
        name: "terrain",
        about: "the same, half a thousand voxels wide: long rays over ground",
        size: 512,
        solid: Solid::Ground(|x, z| {
            // Whole numbers, so that the ground is the same everywhere: ridges of five sizes, each half as high.
            let ridge = |at: i32, size: i32| (at.rem_euclid(2 * size) - size).abs();
            let height: i32 = (0..5)
                .map(|i| 96 >> i)
                .map(|size| ridge(x + z / 2 + size, size) + ridge(z - x / 3, size) * 2 / 3)
                .sum::<i32>();
            [height / 2 - 2, height / 2 + 1]
        }),
    },
];

impl Scene {
    /// The scene of that name.
    pub fn find(name: &str) -> Option<&'static Scene> {
        ALL.iter().find(|scene| scene.name == name)
    }

    /// Builds it with its smallest corner at `corner`, from where `size` voxels must be in the range of `i32`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "random numbers are below what they were asked for"
    )]
    pub fn world(&self, corner: IVec3, seed: u64) -> World {
        let mut random = Random::new(seed);
        let mut voxels = Vec::new();
        let mut put = |x: i32, y: i32, z: i32, material: u16| {
            if material != 0 {
                voxels.push((corner + IVec3::new(x, y, z), material));
            }
        };
        match self.solid {
            Solid::Cells(solid) => {
                for (y, z, x) in cells(self.size) {
                    put(x, y, z, solid(IVec3::new(x, y, z), &mut random));
                }
            }
            Solid::Random(count) => {
                for _ in 0..count {
                    let [x, y, z] = [0, 1, 2].map(|_| random.below(self.size as u64) as i32);
                    put(x, y, z, 1 + random.below(3) as u16);
                }
            }
            Solid::Corners => {
                let side = |bit: i32| if bit & 1 == 1 { self.size - 1 } else { 0 };
                (0..8).for_each(|i| put(side(i), side(i >> 1), side(i >> 2), 1));
            }
            Solid::Boxes(count) => {
                for number in 0..count {
                    let [low, end] = random_box(self.size, &mut random);
                    let material = 1 + (number % 3) as u16;
                    for (y, z) in (low.y..end.y).flat_map(|y| (low.z..end.z).map(move |z| (y, z))) {
                        (low.x..end.x).for_each(|x| put(x, y, z, material));
                    }
                }
            }
            Solid::Ground(ground) => {
                for (z, x) in (0..self.size).flat_map(|z| (0..self.size).map(move |x| (z, x))) {
                    let [low, high] = ground(x, z);
                    for y in low.max(0)..high.min(self.size) {
                        put(x, y, z, if y + 1 == high { 1 } else { 2 });
                    }
                }
            }
        }
        let last = voxels.iter().map(|(_, material)| usize::from(*material)).max();
        let mut materials = materials();
        materials.resize(materials.len().max(last.map_or(0, |last| last + 1)), Material::matt("test", [0.5; 3]));
        World::from_voxels(materials, voxels)
    }
}

/// One of all materials that a world can have, as often a small number as a large one: layouts pack numbers by their bits.
#[expect(clippy::cast_possible_truncation, reason = "random numbers are below what they were asked for")]
fn any_material(random: &mut Random) -> u16 {
    let bits = random.below(17);
    1 + random.below((1 << bits).min(MAX_MATERIALS as u64)) as u16
}

/// A box within a cube: each edge as often short as long, and nothing shorter than a voxel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "edges are a few voxels long")]
fn random_box(size: i32, random: &mut Random) -> [IVec3; 2] {
    let mut edge = || {
        let most = 1_u64 << (1 + random.below(5));
        let long = 1 + random.below(most) as i32;
        let low = random.below((size - long) as u64) as i32;
        [low, low + long]
    };
    let ([x, to_x], [y, to_y], [z, to_z]) = (edge(), edge(), edge());
    [IVec3::new(x, y, z), IVec3::new(to_x, to_y, to_z)]
}

fn cells(size: i32) -> impl Iterator<Item = (i32, i32, i32)> {
    (0..size).flat_map(move |y| (0..size).flat_map(move |z| (0..size).map(move |x| (y, z, x))))
}

/// Air and three materials.
pub fn materials() -> Vec<Material> {
    let mut materials = vec![Material::air()];
    materials.extend([[0.8, 0.3, 0.2], [0.2, 0.6, 0.3], [0.3, 0.4, 0.8]].map(|albedo| Material::matt("test", albedo)));
    materials
}
