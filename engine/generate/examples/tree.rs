//! Makes `worlds/models/tree.vox` and `worlds/models/pine.vox`.
//!
//! `cargo run --release -p raxel-generate --example tree -- worlds/models`

use std::process::ExitCode;

use raxel_generate::{Ball, Cylinder, Operation, Shape, Solid, build};
use raxel_world::{Material, Mode, World, linear_from_srgb, vox};

const TRUNK: u16 = 1;
const LEAVES: u16 = 2;
const SUNNY: u16 = 3;

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("usage: tree FOLDER");
        return ExitCode::from(2);
    };
    for (name, materials, parts) in [("tree", tree_materials(), tree()), ("pine", pine_materials(), pine())] {
        let path = format!("{folder}/{name}.vox");
        let bytes = (build(materials, &parts).map_err(|e| e.to_string()))
            .and_then(|(world, _): (World, _)| vox::export(&world).map_err(|e| e.to_string()));
        if let Err(error) = bytes.and_then(|bytes| std::fs::write(&path, bytes).map_err(|e| e.to_string())) {
            eprintln!("{path}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn matt(name: &str, [r, g, b]: [u8; 3]) -> Material {
    Material::matt(name, [r, g, b].map(linear_from_srgb))
}

fn tree_materials() -> Vec<Material> {
    vec![Material::air(), matt("trunk", [104, 74, 50]), matt("leaves", [74, 118, 46]), matt("sunny", [108, 152, 58])]
}

fn pine_materials() -> Vec<Material> {
    vec![Material::air(), matt("trunk", [84, 62, 46]), matt("needles", [38, 82, 58]), matt("tips", [58, 106, 70])]
}

/// A trunk with roots under a crown of four clumps, lighter where the sun falls.
fn tree() -> Vec<Operation> {
    let clumps = [
        ([0.0, 13.0, 0.0], [5.2, 4.2, 5.2]),
        ([3.0, 11.0, 1.5], [3.4, 2.8, 3.4]),
        ([-3.0, 10.5, -2.0], [3.4, 2.6, 3.2]),
        ([-1.0, 10.0, 3.5], [3.0, 2.4, 2.8]),
    ];
    let mut parts = vec![part(cone(0.0, 1.9, 1.2, 10), TRUNK), part(cone(0.0, 2.6, 2.0, 1), TRUNK)];
    parts.extend(clumps.map(|(centre, radius)| part(ball(centre, radius), LEAVES)));
    parts.extend(clumps.map(|(centre, radius)| {
        let lit = centre.map(|c| c + 1.2);
        let shape = ball([lit[0], lit[1] + 1.6, lit[2]], radius.map(|r| r * 0.8));
        Operation::Solid(Solid { shape: Box::new(shape), mode: Mode::Paint, materials: vec![SUNNY] })
    }));
    parts
}

/// Four skirts of needles, each with lighter tips.
fn pine() -> Vec<Operation> {
    let mut parts = vec![part(cone(0.0, 1.3, 1.0, 6), TRUNK)];
    for (foot, radius, height) in [(4.0, 5.0, 6), (8.0, 4.2, 6), (12.0, 3.3, 6), (16.0, 2.3, 6)] {
        parts.push(part(cone(foot, radius, 0.6, height), LEAVES));
        parts.push(Operation::Solid(Solid {
            shape: Box::new(cone(foot, radius, radius, 1)),
            mode: Mode::Paint,
            materials: vec![SUNNY],
        }));
    }
    parts
}

fn part(shape: impl Shape + 'static, material: u16) -> Operation {
    Operation::Solid(Solid { shape: Box::new(shape), mode: Mode::Add, materials: vec![material] })
}

fn cone(foot: f64, radius: f64, top_radius: f64, height: i64) -> Cylinder {
    Cylinder { axis: 1, base: [0.5, foot, 0.5], radius, top_radius, height }
}

fn ball(centre: [f64; 3], radius: [f64; 3]) -> Ball {
    Ball { centre: centre.map(|c| c + 0.5), radius, shell: None }
}
