//! Promises of lighting systems besides their light: they come to rest, light of removed things goes, and their limits are reported.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../light/scenes.rs"]
mod scenes;

mod caches;
mod faces;
mod lamps;
mod paths;
mod scene;

use common::Project;
use scenes::{cuboid, world};

/// Mean luminance of a picture.
fn luminance(texels: &[[f32; 4]]) -> f64 {
    let of =
        |texel: &[f32; 4]| 0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2]);
    texels.iter().map(of).sum::<f64>() / texels.len() as f64
}

/// A closed room of 12 × 8 × 12 with a lamp of 2 × 2 voxels in its ceiling, which the camera does not see.
fn room(project: &Project) {
    let materials = "wall = { albedo = [0.7, 0.6, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 30.0 }";
    let build = [
        cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"),
        cuboid("wall", [3, 0, 3], [5, 4, 5], ""),
        cuboid("lamp", [6, 7, 6], [8, 8, 8], ""),
    ];
    world(project, materials, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
}
