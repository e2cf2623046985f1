//! Makes `worlds/models/monument.vox`: a temple of eight pillars around a crystal.
//!
//! `cargo run --release -p raxel-generate --example monument -- worlds/models/monument.vox`

use std::process::ExitCode;

use raxel_generate::{Ball, Box3, Cylinder, Operation, Shape, Solid, build};
use raxel_world::{Bounds, Material, Mode, linear_from_srgb, vox};

const MARBLE: u16 = 1;
const STONE: u16 = 2;
const SLATE: u16 = 3;
const GOLD: u16 = 4;
const CRYSTAL: u16 = 5;
const EMBER: u16 = 6;
const POOL: u16 = 7;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: monument FILE.vox");
        return ExitCode::from(2);
    };
    let world = match build(materials(), &temple()) {
        Ok((world, _)) => world,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let written = vox::export(&world).map_err(|e| e.to_string()).and_then(|bytes| {
        let count = bytes.len();
        std::fs::write(&path, bytes).map(|()| count).map_err(|e| e.to_string())
    });
    match written {
        Ok(bytes) => {
            eprintln!("{path}: {} voxels, {bytes} bytes", world.solids());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn materials() -> Vec<Material> {
    let matt = |name: &str, [r, g, b]: [u8; 3]| Material::matt(name, [r, g, b].map(linear_from_srgb));
    vec![
        Material::air(),
        matt("marble", [226, 221, 209]),
        matt("stone", [150, 142, 132]),
        matt("slate", [70, 76, 88]),
        Material { metallic: 1.0, roughness: 0.25, ..matt("gold", [232, 178, 72]) },
        Material { emission: 4.0, roughness: 0.1, ..matt("crystal", [92, 214, 255]) },
        Material { emission: 2.5, ..matt("ember", [255, 148, 48]) },
        Material { transparency: 0.6, roughness: 0.05, ..matt("pool", [52, 122, 150]) },
    ]
}

/// Everything stands about the origin of the plane.
fn temple() -> Vec<Operation> {
    let mut all = Vec::new();
    // Four steps up to a floor, with an inlay and a pool.
    for step in 0..4 {
        let half = 48 - 3 * step;
        let material = if step % 2 == 0 { STONE } else { MARBLE };
        all.push(solid(block([-half, 2 * step, -half], [half, 2 * step + 2, half]), Mode::Add, material));
    }
    all.push(solid(disc(7, 37.0, 1), Mode::Paint, SLATE));
    all.push(solid(disc(7, 34.5, 1), Mode::Paint, MARBLE));
    all.push(solid(disc(6, 20.0, 2), Mode::Subtract, 0));
    all.push(solid(disc(6, 20.0, 1), Mode::Add, POOL));
    all.push(solid(disc(4, 20.0, 2), Mode::Paint, SLATE));
    all.push(solid(disc(6, 9.0, 5), Mode::Add, STONE));
    all.push(solid(disc(11, 7.0, 3), Mode::Add, GOLD));

    // Eight pillars on a circle, with plinths, golden collars and braziers between them.
    let ring = [[30, 0], [21, 21], [0, 30], [-21, 21], [-30, 0], [-21, -21], [0, -30], [21, -21]];
    for [x, z] in ring {
        let at = [f64::from(x), 8.0, f64::from(z)];
        all.push(solid(
            block([i64::from(x) - 5, 8, i64::from(z) - 5], [i64::from(x) + 5, 11, i64::from(z) + 5]),
            Mode::Add,
            STONE,
        ));
        all.push(solid(cone([at[0], 11.0, at[2]], 4.0, 3.2, 34), Mode::Add, MARBLE));
        all.push(solid(cone([at[0], 12.0, at[2]], 4.6, 4.6, 1), Mode::Add, GOLD));
        all.push(solid(cone([at[0], 42.0, at[2]], 3.4, 5.5, 3), Mode::Add, GOLD));
    }
    for [x, z] in [[39, 39], [-39, 39], [39, -39], [-39, -39]] {
        let at = [f64::from(x), 6.0, f64::from(z)];
        all.push(solid(cone(at, 4.0, 2.0, 8), Mode::Add, SLATE));
        all.push(solid(cone([at[0], 14.0, at[2]], 2.5, 4.5, 3), Mode::Add, GOLD));
        all.push(solid(ball([at[0], 17.0, at[2]], [3.2, 4.5, 3.2]), Mode::Add, EMBER));
    }

    // A ring beam that carries a dome, open to the sky and to the sides.
    all.push(solid(disc(45, 37.0, 5), Mode::Add, MARBLE));
    all.push(solid(disc(50, 38.0, 1), Mode::Add, SLATE));
    all.push(solid(disc(45, 27.0, 6), Mode::Subtract, 0));
    let dome = Ball { centre: [0.0, 51.0, 0.0], radius: [33.0, 30.0, 33.0], shell: Some(3.0) };
    all.push(solid(dome, Mode::Add, MARBLE));
    all.push(solid(disc(12, 26.5, 39), Mode::Subtract, 0));
    all.push(solid(block([-3, 51, -40], [3, 76, 40]), Mode::Paint, GOLD));
    all.push(solid(block([-40, 51, -3], [40, 76, 3]), Mode::Paint, GOLD));
    all.push(solid(disc(70, 11.0, 20), Mode::Subtract, 0));
    all.push(solid(disc(78, 13.0, 2), Mode::Add, GOLD));
    all.push(solid(disc(77, 11.0, 4), Mode::Subtract, 0));

    // The crystal: a double cone that floats over the pool and through the opening.
    all.push(solid(disc(6, 9.0, 5), Mode::Add, STONE));
    all.push(solid(disc(11, 7.0, 3), Mode::Add, GOLD));
    all.push(solid(cone([0.0, 17.0, 0.0], 0.6, 7.0, 22), Mode::Add, CRYSTAL));
    all.push(solid(cone([0.0, 39.0, 0.0], 7.0, 0.6, 58), Mode::Add, CRYSTAL));
    all
}

fn solid(shape: impl Shape + 'static, mode: Mode, material: u16) -> Operation {
    Operation::Solid(Solid { shape: Box::new(shape), mode, materials: vec![material] })
}

fn block(min: [i64; 3], max: [i64; 3]) -> Box3 {
    Box3 { bounds: Bounds { min, max }, shell: None }
}

/// A flat cylinder about the centre, at a height.
fn disc(y: i64, radius: f64, height: i64) -> Cylinder {
    Cylinder { axis: 1, base: [0.0, y as f64, 0.0], radius, top_radius: radius, height }
}

fn cone(base: [f64; 3], radius: f64, top_radius: f64, height: i64) -> Cylinder {
    Cylinder { axis: 1, base, radius, top_radius, height }
}

fn ball(centre: [f64; 3], radius: [f64; 3]) -> Ball {
    Ball { centre, radius, shell: None }
}
