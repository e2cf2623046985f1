//! A small world with a model, and random operations on it.

#![allow(dead_code, reason = "each test uses a part")]

use std::sync::Arc;

use glam::IVec3;
use raxel_edit::{Brush, Operation, Scene};
use raxel_world::random::mix;
use raxel_world::{Bounds, Material, MaterialIndex, Mode, Orientation, World};

/// Materials of the world besides air.
pub(crate) const MATERIALS: u16 = 5;

pub(crate) fn materials() -> Vec<Material> {
    std::iter::once(Material::air())
        .chain((1..=MATERIALS).map(|i| Material::matt(format!("m{i}"), [f32::from(i) / 8.0; 3])))
        .collect()
}

/// Rough ground over a few chunks.
pub(crate) fn world() -> World {
    let ground = (-40..100).flat_map(|x| (-40..100).map(move |z| (x, z))).flat_map(|(x, z)| {
        let top = (mix((x / 7 * 1000 + z / 5) as u64) % 30) as i32 - 10;
        (top - 12..top).map(move |y| (IVec3::new(x, y, z), 1 + (mix((x ^ y ^ z) as u64) % 4) as MaterialIndex))
    });
    World::from_voxels(materials(), ground)
}

/// The world's materials and one model without symmetries.
pub(crate) fn scene() -> Scene {
    let voxels = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0], [0, 0, 70], [-5, 1, 0]];
    let voxels = voxels.iter().enumerate().map(|(i, cell)| (IVec3::from_array(*cell), 1 + (i % 2) as MaterialIndex));
    let model = World::from_voxels(materials(), voxels);
    Scene::new(&materials(), &[("post".to_owned(), Arc::new(model))])
}

/// Random numbers that are the same each time.
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn next(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_add(1);
        mix(self.0) % below
    }

    fn cell(&mut self) -> [i32; 3] {
        std::array::from_fn(|_| self.next(200) as i32 - 70)
    }

    fn material(&mut self) -> MaterialIndex {
        1 + self.next(u64::from(MATERIALS)) as MaterialIndex
    }

    fn brush(&mut self) -> Brush {
        match self.next(3) {
            0 => Brush::Add(self.material()),
            1 => Brush::Subtract,
            _ => Brush::Paint(self.material()),
        }
    }

    fn bounds(&mut self, most: u64) -> Bounds {
        let min = self.cell().map(i64::from);
        let size: [i64; 3] = std::array::from_fn(|_| 1 + self.next(most) as i64);
        Bounds { min, max: std::array::from_fn(|i| min[i] + size[i]) }
    }

    fn position(&mut self) -> [i64; 3] {
        self.cell().map(|c| i64::from(c) * 256 + self.next(256) as i64)
    }

    /// Any operation but `Put`.
    pub(crate) fn operation(&mut self) -> Operation {
        match self.next(48) {
            47 => Operation::Box { bounds: self.bounds(150), brush: self.brush() },
            0..30 => {
                Operation::Set { cell: self.cell(), material: self.next(u64::from(MATERIALS) + 1) as MaterialIndex }
            }
            30..34 => Operation::Box { bounds: self.bounds(24), brush: self.brush() },
            34..38 => Operation::Sphere {
                center: self.position(),
                radius: 1 + self.next(12 * 256) as u32,
                brush: self.brush(),
            },
            38..41 => Operation::Cylinder {
                axis: self.next(3) as u8,
                base: self.position(),
                radius: 1 + self.next(12 * 256) as u32,
                height: 1 + self.next(80) as u32,
                brush: self.brush(),
            },
            41..44 => Operation::Model {
                model: "post".to_owned(),
                orientation: self.rotation(),
                position: self.cell(),
                mode: [Mode::Add, Mode::Subtract, Mode::Paint][self.next(3) as usize],
            },
            _ => Operation::Restore { bounds: self.bounds(50) },
        }
    }

    fn rotation(&mut self) -> u8 {
        let all: Vec<u8> =
            (0..128).filter(|byte| Orientation::from_vox(*byte).is_some_and(|o| o.is_rotation())).collect();
        all[self.next(all.len() as u64) as usize]
    }
}
