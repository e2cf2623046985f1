//! Makes the models that move, in `worlds/models`: `carousel`, `horse`, `wheel`, `gondola` and `sailboat` of `worlds/fair.toml`, and `bird`
//! of `worlds/flock.toml`.
//!
//! `cargo run --release -p raxel-generate --example fair -- worlds/models`

#![expect(clippy::cast_possible_truncation, reason = "the fair is some hundred voxels wide")]

use std::process::ExitCode;

use raxel_generate::{Ball, Box3, Cylinder, Operation, Shape, Solid, build};
use raxel_world::{Bounds, Material, Mode, linear_from_srgb, vox};

const WOOD: u16 = 1;
const RED: u16 = 2;
const CREAM: u16 = 3;
const GOLD: u16 = 4;
const BULB: u16 = 5;
const COAT: u16 = 6;
const STEEL: u16 = 7;
const BLUE: u16 = 8;

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("usage: fair FOLDER");
        return ExitCode::from(2);
    };
    let models = [
        ("carousel", carousel()),
        ("horse", horse()),
        ("wheel", wheel()),
        ("gondola", gondola()),
        ("sailboat", sailboat()),
        ("bird", bird()),
    ];
    for (name, parts) in models {
        let path = format!("{folder}/{name}.vox");
        let bytes = (build(materials(), &parts).map_err(|e| e.to_string()))
            .and_then(|(world, _)| vox::export(&world).map_err(|e| e.to_string()));
        if let Err(error) = bytes.and_then(|bytes| std::fs::write(&path, bytes).map_err(|e| e.to_string())) {
            eprintln!("{path}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// It flies towards −Z, its wings raised a little.
fn bird() -> Vec<Operation> {
    vec![
        cuboid([0, 0, -3], [1, 1, 3], COAT, Mode::Add),
        cuboid([-1, 0, 2], [2, 1, 4], STEEL, Mode::Add),
        cuboid([0, 0, -4], [1, 1, -3], GOLD, Mode::Add),
        cuboid([-2, 0, -2], [3, 1, 1], COAT, Mode::Add),
        cuboid([-4, 1, -1], [-2, 2, 1], COAT, Mode::Add),
        cuboid([3, 1, -1], [5, 2, 1], COAT, Mode::Add),
        cuboid([-5, 2, 0], [-4, 3, 2], STEEL, Mode::Add),
        cuboid([5, 2, 0], [6, 3, 2], STEEL, Mode::Add),
    ]
}

fn materials() -> Vec<Material> {
    let matt = |name: &str, [r, g, b]: [u8; 3]| Material::matt(name, [r, g, b].map(linear_from_srgb));
    vec![
        Material::air(),
        matt("wood", [134, 92, 58]),
        matt("red", [186, 48, 44]),
        matt("cream", [236, 224, 196]),
        Material { metallic: 1.0, roughness: 0.5, ..matt("gold", [226, 176, 74]) },
        Material { emission: 3.0, ..matt("bulb", [255, 214, 138]) },
        matt("coat", [224, 226, 230]),
        matt("steel", [120, 134, 152]),
        matt("blue", [52, 98, 168]),
    ]
}

/// Everything turns about the centre of the voxel at the origin.
fn carousel() -> Vec<Operation> {
    let mut parts = vec![
        cylinder(1, [0, 0, 0], 23.5, 23.5, 2, WOOD, Mode::Add),
        cylinder(1, [0, 1, 0], 23.5, 23.5, 1, RED, Mode::Paint),
        cylinder(1, [0, 1, 0], 21.5, 21.5, 1, WOOD, Mode::Paint),
        cylinder(1, [0, 2, 0], 4.5, 4.5, 24, CREAM, Mode::Add),
        cylinder(1, [0, 26, 0], 24.5, 3.0, 11, CREAM, Mode::Add),
        cylinder(1, [0, 25, 0], 24.5, 24.5, 1, GOLD, Mode::Add),
        cuboid([0, 37, 0], [1, 42, 1], GOLD, Mode::Add),
    ];
    // Stripes on the roof, mirrors and bulbs around.
    for [low, high] in [[[-4, 26, -30], [5, 40, 31]], [[-30, 26, -4], [31, 40, 5]]] {
        parts.push(cuboid(low, high, RED, Mode::Paint));
    }
    for [low, high] in [[[-2, 5, -6], [3, 22, 7]], [[-6, 5, -2], [7, 22, 3]]] {
        parts.push(cuboid(low, high, RED, Mode::Paint));
    }
    for i in 0..16 {
        let (x, z) = on_circle(24.0, i, 16);
        parts.push(cuboid([x, 24, z], [x + 1, 25, z + 1], BULB, Mode::Add));
    }
    parts
}

/// Looks along −Z. Its pole goes through the voxel at the origin.
fn horse() -> Vec<Operation> {
    let mut parts = vec![
        cuboid([-1, 4, -4], [2, 8, 5], COAT, Mode::Add),
        cuboid([-1, 7, -6], [2, 12, -3], COAT, Mode::Add),
        cuboid([-1, 10, -9], [2, 13, -5], COAT, Mode::Add),
        cuboid([0, 8, -4], [1, 13, -2], GOLD, Mode::Add),
        cuboid([0, 3, 5], [1, 8, 6], GOLD, Mode::Add),
        cuboid([-2, 6, -1], [3, 9, 3], RED, Mode::Add),
        cuboid([0, -3, 0], [1, 26, 1], GOLD, Mode::Add),
    ];
    for (x, z, bend) in [(-1, -4, -1), (1, -3, -2), (-1, 4, 1), (1, 3, 0)] {
        parts.push(cuboid([x, 2, z], [x + 1, 4, z + 1], COAT, Mode::Add));
        parts.push(cuboid([x, 0, z + bend], [x + 1, 2, z + bend + 1], WOOD, Mode::Add));
    }
    parts
}

/// Turns about Z.
fn wheel() -> Vec<Operation> {
    let mut parts = vec![cylinder(2, [0, 0, -6], 3.5, 3.5, 13, GOLD, Mode::Add)];
    for z in [-4, 4] {
        parts.push(cylinder(2, [0, 0, z], 30.5, 30.5, 1, STEEL, Mode::Add));
        parts.push(cylinder(2, [0, 0, z], 28.0, 28.0, 1, STEEL, Mode::Subtract));
        for i in 0..16 {
            for step in 3..29 {
                let (x, y) = on_circle(f64::from(step), i, 16);
                parts.push(cuboid([x, y, z], [x + 1, y + 1, z + 1], if i % 2 == 0 { STEEL } else { RED }, Mode::Add));
            }
            let (x, y) = on_circle(30.0, 2 * i + 1, 32);
            parts.push(cuboid([x, y, z], [x + 1, y + 1, z + 1], BULB, Mode::Add));
        }
    }
    // Between the rims hang eight gondolas.
    for i in 0..8 {
        let (x, y) = on_circle(29.0, i, 8);
        parts.push(cuboid([x, y, -4], [x + 1, y + 1, 5], STEEL, Mode::Add));
    }
    parts
}

/// Hangs from the voxel at the origin.
fn gondola() -> Vec<Operation> {
    vec![
        cuboid([-3, -9, -2], [4, -4, 3], BLUE, Mode::Add),
        cuboid([-2, -8, -1], [3, -4, 2], BLUE, Mode::Subtract),
        cuboid([-3, -4, -2], [4, -3, 3], CREAM, Mode::Add),
        cuboid([-2, -4, -1], [3, -3, 2], CREAM, Mode::Subtract),
        cuboid([-1, -8, -1], [0, -6, 2], WOOD, Mode::Add),
        cuboid([0, -4, -2], [1, 0, -1], STEEL, Mode::Add),
        cuboid([0, -4, 2], [1, 0, 3], STEEL, Mode::Add),
        cuboid([-3, 0, -2], [4, 1, 3], CREAM, Mode::Add),
    ]
}

/// Floats with the voxel at the origin on the water, and looks along −Z.
fn sailboat() -> Vec<Operation> {
    vec![
        ball([0.0, 2.0, 0.0], [4.2, 4.5, 10.5], WOOD, Mode::Add),
        ball([0.0, 2.5, 0.0], [3.2, 3.6, 9.4], WOOD, Mode::Subtract),
        cuboid([-9, 3, -16], [10, 9, 17], WOOD, Mode::Subtract),
        cuboid([-4, 2, -11], [5, 3, 12], CREAM, Mode::Paint),
        cuboid([-3, 0, 1], [4, 1, 3], CREAM, Mode::Add),
        cuboid([0, -1, -1], [1, 19, 0], WOOD, Mode::Add),
        cylinder(1, [0, 4, 4], 5.0, 0.5, 14, RED, Mode::Add),
        cuboid([-9, 3, -3], [0, 19, 12], RED, Mode::Subtract),
        cuboid([1, 3, -3], [10, 19, 12], RED, Mode::Subtract),
        cuboid([0, 4, 0], [1, 18, 1], CREAM, Mode::Paint),
    ]
}

/// The voxel of the i-th of `count` places on a circle about the origin.
fn on_circle(radius: f64, i: i32, count: i32) -> (i64, i64) {
    let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
    ((radius * angle.cos()).round() as i64, (radius * angle.sin()).round() as i64)
}

fn part(shape: impl Shape + 'static, material: u16, mode: Mode) -> Operation {
    Operation::Solid(Solid { shape: Box::new(shape), mode, materials: vec![material] })
}

fn cuboid(min: [i64; 3], max: [i64; 3], material: u16, mode: Mode) -> Operation {
    part(Box3 { bounds: Bounds { min, max }, shell: None }, material, mode)
}

/// Along an axis, about the centre of the voxel `base`.
fn cylinder(
    axis: usize,
    base: [i64; 3],
    radius: f64,
    top_radius: f64,
    height: i64,
    material: u16,
    mode: Mode,
) -> Operation {
    let base = std::array::from_fn(|i| base[i] as f64 + if i == axis { 0.0 } else { 0.5 });
    part(Cylinder { axis, base, radius, top_radius, height }, material, mode)
}

fn ball(centre: [f64; 3], radius: [f64; 3], material: u16, mode: Mode) -> Operation {
    part(Ball { centre: centre.map(|c| c + 0.5), radius, shell: None }, material, mode)
}
