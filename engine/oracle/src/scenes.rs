//! Small worlds that are hard on tracers. All seeded, all deterministic.

use glam::IVec3;
use raxel_world::{Material, World};

use crate::sets::Random;

/// A scene's name and how it is built.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name.
    pub name: &'static str,
    /// What it is made to find.
    pub about: &'static str,
    solid: fn(IVec3, &mut Random) -> u16,
    size: i32,
}

/// Every scene.
pub const ALL: &[Scene] = &[
    Scene {
        name: "sparse",
        about: "one voxel in 500 at random: rays pass many edges before they hit",
        solid: |_, random| if random.below(500) == 0 { 1 + random.below(3) as u16 } else { 0 },
        size: 96,
    },
    Scene {
        name: "checkerboard",
        about: "every other voxel: each edge and corner of the lattice is one of a solid",
        solid: |c, _| u16::from((c.x + c.y + c.z) & 1 == 0),
        size: 24,
    },
    Scene {
        name: "diagonal",
        about: "a plane one voxel thick: a tracer that slips through an edge sees the other side",
        solid: |c, _| u16::from(c.x + c.y + c.z == 60),
        size: 40,
    },
    Scene { name: "solid", about: "a full cube: filled nodes, starts inside", solid: |_, _| 2, size: 72 },
    Scene {
        name: "corners",
        about: "single voxels in the corners of a large box: long steps over nothing",
        solid: |c, _| u16::from(c.to_array().iter().all(|c| *c == 0 || *c == 255)),
        size: 256,
    },
    Scene {
        name: "menger",
        about: "a Menger sponge of three levels: holes of all sizes",
        solid: |c, _| {
            let hole = |k: i32| c.to_array().iter().filter(|c| **c / k % 3 == 1).count() >= 2;
            u16::from(!hole(1) && !hole(3) && !hole(9))
        },
        size: 27,
    },
    Scene {
        name: "hills",
        about: "a shell of ground three voxels thick in two materials: what games look like",
        solid: |c, _| {
            let (x, z) = (c.x as f32 * 0.13, c.z as f32 * 0.11);
            let height = (20.0 + 9.0 * x.sin() * z.cos() + 4.0 * (2.3 * x + z).sin()) as i32;
            if c.y == height {
                1
            } else if (height - 2..height).contains(&c.y) {
                2
            } else {
                0
            }
        },
        size: 80,
    },
];

impl Scene {
    /// The scene of that name.
    pub fn find(name: &str) -> Option<&'static Scene> {
        ALL.iter().find(|scene| scene.name == name)
    }

    /// Builds it with its smallest corner at `corner`.
    pub fn world(&self, corner: IVec3, seed: u64) -> World {
        let mut random = Random::new(seed);
        let mut voxels = Vec::new();
        for y in 0..self.size {
            for z in 0..self.size {
                for x in 0..self.size {
                    let cell = IVec3::new(x, y, z);
                    let material = (self.solid)(cell, &mut random);
                    if material != 0 {
                        voxels.push((corner + cell, material));
                    }
                }
            }
        }
        World::from_voxels(materials(), voxels)
    }
}

/// Air and three materials.
pub fn materials() -> Vec<Material> {
    let mut materials = vec![Material::air()];
    materials.extend([[0.8, 0.3, 0.2], [0.2, 0.6, 0.3], [0.3, 0.4, 0.8]].map(|albedo| Material::matt("test", albedo)));
    materials
}
