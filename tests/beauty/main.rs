//! The picture of `graphs/beauty.toml` beside its light: land around finite worlds, clouds, the night, sharpening and the grade.

#![allow(clippy::float_cmp, reason = "levels and kinds of land are exact")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../light/scenes.rs"]
mod scenes;

mod exposure;
mod lamps;
mod panes;
mod shadows;
mod surroundings;

use common::Project;
use raxel::Session;
use scenes::{cuboid, frames, world};

const BEAUTY: &str = "graphs/beauty.toml";
const SIZE: [u32; 2] = [48, 27];

const MATERIALS: &str = "black = { albedo = [0.0, 0.0, 0.0] }
lawn = { albedo = [0.2, 0.5, 0.1] }
stone = { albedo = [0.6, 0.6, 0.6] }
polished = { albedo = [0.9, 0.9, 0.9], roughness = 0.05, metallic = 1.0 }
lamp = { albedo = [1.0, 0.9, 0.8], emission = 30.0 }";

fn luminance(texel: &[f32; 4]) -> f64 {
    0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2])
}

fn mean(texels: &[[f32; 4]]) -> f64 {
    texels.iter().map(luminance).sum::<f64>() / texels.len() as f64
}

/// The texels of a target after `count` frames.
fn after(session: &mut Session, target: &str, count: u32) -> Vec<[f32; 4]> {
    session.pin(target).unwrap();
    frames(session, count);
    session.read_target(target).unwrap().floats()
}

fn at(texels: &[[f32; 4]], x: u32, y: u32) -> [f32; 4] {
    texels[(y * SIZE[0] + x) as usize]
}

/// A lawn of 80 × 80 with its top at y = 3, seen from above its centre towards its edge and beyond.
fn lawn(project: &Project, more: &[String]) {
    let build = [vec![cuboid("lawn", [-40, 0, -40], [40, 3, 40], "")], more.to_vec()].concat();
    world(project, MATERIALS, &build, [0.5, 20.5, 0.5], [0.5, 6.0, -40.0], 60.0);
}

/// All layers of a target.
fn layers(session: &mut Session, target: &str, count: u32) -> Vec<[f32; 4]> {
    (0..count).flat_map(|layer| session.read_texels(target, 0, 0, layer).unwrap().floats()).collect()
}
