//! Compares the path tracer that judges lighting with another one: `raxel_testing::path_tracer` runs on the CPU, in `f64`. The two share only the
//! voxels and the definitions of sun, sky, lamps and surfaces.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use std::ops::Range;

use common::Project;
use raxel::Value;
use raxel_oracle::Oracle;
use raxel_testing::path_tracer::{Estimate, Light, PathTracer, View};
use scenes::{cuboid, frames, open, world};

const SIZE: [u32; 2] = [32, 18];
/// Pixels of a region: 4 × 3 of them in a picture.
const REGION: [u32; 2] = [8, 6];
/// The means of all regions and channels of a scene, and of the whole picture, must agree within this number of standard errors. They are 40
/// numbers a scene, so chance refuses one scene in 40,000.
const DEVIATIONS: f64 = 5.0;

/// A scene, and the part of the light that it compares.
struct Scene {
    name: &'static str,
    materials: &'static str,
    build: Vec<String>,
    camera: [[f64; 3]; 2],
    light: Light,
    /// Paths a pixel of the twin. If paths meet lamps by chance, more are needed.
    paths: u32,
    /// Standard error of the whole picture's mean, as a share of it: what would be seen is five times as much.
    sharp: f64,
}

const DAY: Light =
    Light { sun_azimuth: 215.0, sun_elevation: 32.0, sun_strength: 2.3, sky_strength: 0.6, lamp_strength: 1.0 };

fn scenes() -> [Scene; 3] {
    let yard = vec![
        cuboid("clay", [-12, -1, -12], [12, 0, 12], ""),
        cuboid("chalk", [-4, 0, -4], [0, 6, 0], ""),
        cuboid("moss", [0, 3, -4], [6, 4, 3], ""),
        cuboid("black", [5, 0, 2], [6, 3, 3], ""),
    ];
    let cell = vec![
        cuboid("chalk", [-1, -1, -1], [13, 9, 11], "shell = 1"),
        cuboid("clay", [-1, 0, 0], [0, 8, 10], "mode = \"paint\""),
        cuboid("moss", [12, 0, 0], [13, 8, 10], "mode = \"paint\""),
        cuboid("chalk", [3, 0, 2], [6, 4, 5], ""),
        cuboid("lamp", [4, 7, 3], [8, 8, 7], ""),
    ];
    let cloister = vec![
        cuboid("chalk", [-1, -1, -1], [15, 9, 13], "shell = 1"),
        hole([14, 2, 3], [15, 7, 9]),
        hole([3, 8, 2], [7, 9, 6]),
        cuboid("clay", [9, 0, 4], [11, 5, 6], ""),
        cuboid("lamp", [0, 3, 9], [1, 6, 12], ""),
        cuboid("ember", [4, 0, 9], [7, 1, 11], ""),
    ];
    let materials = r"clay = { albedo = [0.7, 0.35, 0.2] }
chalk = { albedo = [0.85, 0.83, 0.8] }
moss = { albedo = [0.2, 0.5, 0.25] }
black = { albedo = [0.0, 0.0, 0.0] }
lamp = { albedo = [1.0, 0.9, 0.7], emission = 8.0 }
ember = { albedo = [0.9, 0.3, 0.1], emission = 3.0 }";
    [
        // Sun and sky over steps, under a roof and beside black.
        Scene {
            name: "yard",
            materials,
            build: yard,
            camera: [[9.5, 8.5, 11.5], [0.5, 1.0, -1.0]],
            light: DAY,
            paths: 1024,
            sharp: 0.001,
        },
        // One lamp and many bounces.
        Scene {
            name: "cell",
            materials,
            build: cell,
            camera: [[1.5, 5.5, 9.5], [8.0, 3.0, 2.0]],
            light: Light { sun_strength: 0.0, sky_strength: 0.0, ..DAY },
            paths: 2048,
            sharp: 0.005,
        },
        // All at once: a low sun through a window, the sky through the roof, two kinds of lamps.
        Scene {
            name: "cloister",
            materials,
            build: cloister,
            camera: [[2.5, 4.5, 7.5], [13.0, 3.0, 4.0]],
            light: Light {
                sun_azimuth: 80.0,
                sun_elevation: 11.0,
                sun_strength: 6.0,
                sky_strength: 1.5,
                lamp_strength: 0.7,
            },
            paths: 2048,
            sharp: 0.005,
        },
    ]
}

fn hole(min: [i32; 3], max: [i32; 3]) -> String {
    format!("[[build]]\nop = \"box\"\nmode = \"subtract\"\nmin = {min:?}\nmax = {max:?}\n")
}

/// The mean of some pixels and its variance.
fn mean(pixels: &[Estimate], columns: Range<u32>, rows: Range<u32>, channel: usize) -> [f64; 2] {
    let part: Vec<&Estimate> = rows
        .flat_map(|y| columns.clone().map(move |x| (y * SIZE[0] + x) as usize))
        .map(|pixel| &pixels[pixel])
        .collect();
    let n = part.len() as f64;
    let sum = |of: fn(&Estimate) -> [f64; 3]| part.iter().map(|pixel| of(pixel)[channel]).sum::<f64>();
    [sum(|pixel| pixel.mean) / n, sum(|pixel| pixel.variance) / (n * n)]
}

/// The largest distance of two pictures in standard errors, over the regions and as a whole; and the standard error of the whole as a
/// share of its mean.
fn apart(ours: &[Estimate], theirs: &[Estimate]) -> (f64, f64, f64) {
    let deviation = |columns: &Range<u32>, rows: &Range<u32>, channel: usize| {
        let [a, b] = [ours, theirs].map(|pixels| mean(pixels, columns.clone(), rows.clone(), channel));
        let se = (a[1] + b[1]).sqrt();
        // Texels without noise in both, like the sky without its disc, may still differ by the rounding of `f32`.
        ((a[0] - b[0]).abs() / (se + 2e-5 * a[0]), se / a[0].max(1e-9))
    };
    let (mut regions, mut whole, mut share) = (0.0_f64, 0.0_f64, 0.0_f64);
    for channel in 0..3 {
        for x in (0..SIZE[0]).step_by(REGION[0] as usize) {
            for y in (0..SIZE[1]).step_by(REGION[1] as usize) {
                regions = regions.max(deviation(&(x..x + REGION[0]), &(y..y + REGION[1]), channel).0);
            }
        }
        let (away, se) = deviation(&(0..SIZE[0]), &(0..SIZE[1]), channel);
        (whole, share) = (whole.max(away), share.max(se));
    }
    (regions, whole, share)
}

#[test]
fn another_path_tracer_sees_the_same_light() {
    let project = Project::shipped();
    for scene in scenes() {
        world(&project, scene.materials, &scene.build, scene.camera[0], scene.camera[1], 65.0);
        let light = scene.light;
        let params = [
            ("sun_azimuth", light.sun_azimuth),
            ("sun_elevation", light.sun_elevation),
            ("sun_strength", light.sun_strength),
            ("sky_strength", light.sky_strength),
            ("lamp_strength", light.lamp_strength),
        ];
        let params = params.map(|(name, value)| (name, value as f32));
        let mut session = open(&project, "graphs/light/reference.toml", SIZE, &params);
        for name in ["sum", "squares"] {
            session.pin(name).unwrap();
        }
        session.set_param("paths", Value::I32(8)).unwrap();
        frames(&mut session, 64);
        let [sums, squares] = ["sum", "squares"].map(|name| session.read_target(name).unwrap().floats());
        let shader: Vec<Estimate> = (sums.iter().zip(&squares))
            .map(|(sum, square)| {
                let n = f64::from(sum[3]);
                let mean = [0, 1, 2].map(|i| f64::from(sum[i]) / n);
                let variance = [0, 1, 2].map(|i| (f64::from(square[i]) / n - mean[i] * mean[i]).max(0.0) / (n - 1.0));
                Estimate { mean, variance }
            })
            .collect();

        let camera = *session.camera();
        let rotation = camera.rotation();
        let view = View {
            cell: camera.cell.to_array(),
            frac: camera.frac.to_array(),
            axes: [rotation.x_axis, rotation.y_axis, rotation.z_axis],
            tan_half_fov: camera.tan_half_fov(f64::from(SIZE[0]) / f64::from(SIZE[1])).to_array().map(f64::from),
        };
        let oracle = Oracle::new(session.world().voxels());
        let seen = |light: Light| PathTracer::new(&oracle, light).picture(&view, SIZE, scene.paths, 1);
        let (regions, whole, share) = apart(&shader, &seen(light));
        eprintln!("{}: regions {regions:.2}, whole {whole:.2} deviations, {share:.5} of the mean", scene.name);
        assert!(regions < DEVIATIONS && whole < DEVIATIONS, "{}: {regions} {whole}", scene.name);
        assert!(share < scene.sharp, "{}: {share} is too noisy", scene.name);

        // A slightly different light is noticed.
        let more = 1.0 + 2.0 * DEVIATIONS * scene.sharp;
        let other = seen(Light {
            sun_strength: light.sun_strength * more,
            sky_strength: light.sky_strength * more,
            lamp_strength: light.lamp_strength * more,
            ..light
        });
        let (_, whole, _) = apart(&shader, &other);
        assert!(whole > DEVIATIONS, "{}: {more} times the light is {whole} deviations away", scene.name);
    }
}
