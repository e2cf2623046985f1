//! Light by the book. Scenes with light in closed form test the path tracer that judges lighting systems. Every system in graphs/light and
//! graphs/rivals/light must keep the rules for all: no light through walls, no light that stays, no NaN.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use std::f64::consts::{FRAC_PI_2, PI};

use common::{Project, RunRaxel};
use raxel::{Options, Session, Validation, Value};
use raxel_measure::light::{Bench, Effort, REFERENCE};
use scenes::{DARK, cuboid, effort, frames, open, scene, systems, world};

/// The path tracer's result after `count` frames of `paths` paths, and a Z-test for each channel of each pixel that must show `truth`, at a
/// significance of 0.01 over all of them (Šidák), which 99.75 % must pass.
fn known(session: &mut Session, count: u32, paths: i32, truth: f64) -> Mean {
    for name in ["sum", "squares"] {
        session.pin(name).unwrap();
    }
    session.set_param("paths", Value::I32(paths)).unwrap();
    let light = frames(session, count);
    let found = estimates(session);
    // Two-sided 1 − (1 − 0.01)^(1 / 1152): 8.7·10⁻⁶, at 4.45 standard errors.
    let wrong = found.iter().filter(|[mean, se]| (mean - truth).abs() > 4.45 * se + 1e-5 * truth).count();
    assert!(wrong as f64 <= 0.0025 * found.len() as f64, "{wrong} of {} are not {truth}", found.len());
    mean(&light)
}

/// Narrows the view to this number of degrees, so that all pixels see the same point.
fn narrow(session: &mut Session, degrees: f64) {
    session.set_camera(raxel::Camera { fov: degrees.to_radians(), ..*session.camera() });
}

/// A mean over pixels with its standard error.
#[derive(Debug)]
struct Mean {
    mean: f64,
    se: f64,
}

/// All channels of all pixels are independent estimates of one value: paths of different pixels have nothing in common.
fn mean(texels: &[[f32; 4]]) -> Mean {
    let pixels: Vec<f64> =
        texels.iter().map(|texel| texel[..3].iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0).collect();
    let n = pixels.len() as f64;
    let mean = pixels.iter().sum::<f64>() / n;
    let variance = pixels.iter().map(|pixel| (pixel - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Mean { mean, se: (variance / n).sqrt() }
}

impl Mean {
    /// Within `within` of the truth, and within chance: a deviation of 4 standard errors happens once in 16,000 times.
    #[track_caller]
    fn is(&self, truth: f64, within: f64) {
        let away = (self.mean - truth).abs();
        assert!(4.0 * self.se <= within * truth, "{self:?} is too noisy for {within} of {truth}");
        assert!(away <= within * truth && away <= 4.0 * self.se + 1e-5 * truth, "{self:?} is not {truth}");
    }
}

/// A sky of the same radiance everywhere instead of the project's.
fn even_sky(project: &Project) {
    let text = "return strength * rx_sky(dir, sun);";
    project.edit("shaders/include/raxel/light/environment.glsl", text, "return vec3(strength);");
}

/// A closed box whose walls all reflect p and give off p e: everything in it has the radiance p e / (1 − p).
fn furnace(project: &Project, albedo: f64, emission: f64) -> f64 {
    let wall = format!("wall = {{ albedo = [{albedo}, {albedo}, {albedo}], emission = {emission:?} }}");
    let walls = cuboid("wall", [-1, -1, -1], [7, 6, 8], "shell = 1");
    world(project, &wall, &[walls], [2.5, 2.5, 5.5], [4.0, 2.0, 0.0], 70.0);
    albedo * emission / (1.0 - albedo)
}

#[test]
fn a_closed_furnace_glows_evenly() {
    let project = Project::shipped();
    for (albedo, emission, count) in [(0.5, 2.0, 32), (0.9, 0.25, 448)] {
        let truth = furnace(&project, albedo, emission);
        let mut session = open(&project, REFERENCE, [24, 16], &DARK);
        known(&mut session, count, 16, truth).is(truth, 0.002);
    }
}

#[test]
fn a_white_body_in_an_even_sky_cannot_be_seen() {
    let project = Project::shipped();
    even_sky(&project);
    let white = "white = { albedo = [1.0, 1.0, 1.0] }";
    world(&project, white, &[cuboid("white", [0, 0, 0], [4, 4, 4], "")], [9.0, 8.0, 10.0], [2.0, 2.0, 2.0], 40.0);
    let params = [("sun_strength", 0.0), ("sky_strength", 1.0)];
    for texel in frames(&mut open(&project, REFERENCE, [24, 16], &params), 2) {
        assert!(texel[..3].iter().all(|channel| (channel - 1.0).abs() < 1e-6), "{texel:?}");
    }
    // In a corner, light goes to and fro.
    let walls = [
        cuboid("white", [0, 0, 0], [9, 1, 9], ""),
        cuboid("white", [0, 1, 0], [1, 9, 9], ""),
        cuboid("white", [1, 1, 0], [9, 9, 1], ""),
    ];
    world(&project, white, &walls, [6.5, 6.5, 6.5], [1.5, 1.5, 1.5], 50.0);
    mean(&frames(&mut open(&project, REFERENCE, [24, 16], &params), 64)).is(1.0, 0.01);
}

/// A lamp of 16 × 16 faces, 12 above a floor: the form factor from the point below its centre (Howell, configuration B-4, four times).
#[test]
fn a_lamp_lights_the_floor_by_its_form_factor() {
    let project = Project::shipped();
    // The lamp itself reflects next to nothing.
    let materials = "floor = { albedo = [0.5, 0.5, 0.5] }\nlamp = { albedo = [0.01, 0.01, 0.01], emission = 600.0 }";
    let build = [cuboid("floor", [-20, -1, -20], [20, 0, 20], ""), cuboid("lamp", [-8, 12, -8], [8, 13, 8], "")];
    world(&project, materials, &build, [0.01, 11.0, 0.01], [0.01, 0.0, 0.02], 1.0);
    let side = 8.0 / 12.0;
    let root = f64::hypot(1.0, side);
    let form = 4.0 / (2.0 * PI) * 2.0 * (side / root) * (side / root).atan();
    let truth = 0.5 * 6.0 * form;
    known(&mut open(&project, REFERENCE, [24, 16], &DARK), 32, 16, truth).is(truth, 0.005);
}

/// Below an even sky, at the foot of a long black wall.
#[test]
fn a_wall_takes_its_share_of_the_sky() {
    let project = Project::shipped();
    even_sky(&project);
    let materials = "floor = { albedo = [0.5, 0.5, 0.5] }\nblack = { albedo = [0.0, 0.0, 0.0] }";
    let (height, distance) = (8, 6.0);
    let build = [cuboid("floor", [-2, -1, -8], [20, 0, 8], ""), cuboid("black", [-1, 0, -600], [0, height, 600], "")];
    world(&project, materials, &build, [distance, 10.0, 0.01], [distance, 0.0, 0.02], 1.0);
    let irradiance = FRAC_PI_2 * (1.0 + distance / f64::hypot(distance, f64::from(height)));
    let mut session = open(&project, REFERENCE, [24, 16], &[("sun_strength", 0.0), ("sky_strength", 1.0)]);
    narrow(&mut session, 0.1);
    let truth = 0.5 / PI * irradiance;
    known(&mut session, 8, 16, truth).is(truth, 0.005);
}

/// The sun in the zenith behind the straight edge of a roof: a circle's segment of its disc is seen.
#[test]
fn a_penumbra_is_the_visible_part_of_the_disc() {
    let project = Project::shipped();
    let materials = "floor = { albedo = [0.5, 0.5, 0.5] }\nblack = { albedo = [0.0, 0.0, 0.0] }";
    let height = 400;
    // The roof's edge is above x = 0; what lies half a radius of the disc's picture beyond it sees more than half of the disc.
    let offset = 0.5 * f64::from(height) * 0.267_f64.to_radians().tan();
    let floor = cuboid("floor", [-8, -1, -8], [8, 0, 8], "");
    let roof = cuboid("black", [-40, height, -40], [0, height + 1, 40], "");
    let light = |build: &[String]| {
        world(&project, materials, build, [offset, 300.0, 0.01], [offset, 0.0, 0.02], 1.0);
        let zenith = [("sky_strength", 0.0), ("sun_elevation", 90.0), ("sun_strength", 1.0)];
        let mut session = open(&project, REFERENCE, [24, 16], &zenith);
        narrow(&mut session, 0.005);
        mean(&frames(&mut session, 64))
    };
    let (all, part) = (light(std::slice::from_ref(&floor)), light(&[floor.clone(), roof]));
    let segment = (0.5_f64.acos() - 0.5 * 0.75_f64.sqrt()) / PI;
    Mean { mean: part.mean / all.mean, se: part.se / all.mean }.is(1.0 - segment, 0.005);
}

/// The disc's irradiance does not depend on how it is sampled: all of it, seen from an open floor.
#[test]
fn the_sun_has_the_irradiance_that_is_asked_for() {
    let project = Project::shipped();
    world(
        &project,
        "floor = { albedo = [0.5, 0.5, 0.5] }",
        &[cuboid("floor", [-8, -1, -8], [8, 0, 8], "")],
        [0.0, 9.0, 0.01],
        [0.0, 0.0, 0.02],
        20.0,
    );
    let strength = 2.0;
    let params = [("sky_strength", 0.0), ("sun_elevation", 90.0), ("sun_strength", strength)];
    // The zenith's colour is (1, 0.93, 0.8); E = strength π, L = albedo E / π.
    for texel in frames(&mut open(&project, REFERENCE, [8, 8], &params), 4) {
        for (channel, color) in texel.iter().zip([1.0, 0.93, 0.8]) {
            assert!((channel - 0.5 * strength * color).abs() < 1e-4, "{texel:?}");
        }
    }
}

/// Mean and standard error of each channel of each pixel, from the sums of a session of the path tracer.
fn estimates(session: &mut Session) -> Vec<[f64; 2]> {
    let [sums, squares] = ["sum", "squares"].map(|name| session.read_target(name).unwrap().floats());
    let channel = |sum: f32, square: f32, n: f64| {
        let mean = f64::from(sum) / n;
        [mean, ((f64::from(square) / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()]
    };
    let pixel =
        |(sum, square): (&[f32; 4], &[f32; 4])| [0, 1, 2].map(|i| channel(sum[i], square[i], f64::from(sum[3])));
    sums.iter().zip(&squares).flat_map(pixel).collect()
}

/// References of 48 × 27 pixels that are kept: a Z-test for each channel of each pixel at a significance of 0.01 over all of them (Šidák),
/// which 99.75 % must pass. Other devices give other bytes and the same light. `RAXEL_WRITE_LIGHT=1` rewrites them.
#[test]
fn the_path_tracer_gives_the_light_that_is_kept() {
    let project = Project::shipped();
    for scene in ["valley", "menger"] {
        std::fs::copy(project.path(&format!("worlds/{scene}.toml")), project.path("worlds/test.toml")).unwrap();
        let path = common::repository().join(format!("tests/light/{scene}.f32"));
        let write = std::env::var_os("RAXEL_WRITE_LIGHT").is_some();
        let mut session = open(&project, REFERENCE, [48, 27], &[]);
        for name in ["sum", "squares"] {
            session.pin(name).unwrap();
        }
        session.set_param("paths", Value::I32(4)).unwrap();
        session.set_param("seed", Value::U32(if write { 1000 } else { 1001 })).unwrap();
        frames(&mut session, if write { 256 } else { 32 });
        let found = estimates(&mut session);
        if write {
            let bytes = found.iter().flatten().flat_map(|number| (*number as f32).to_le_bytes());
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, bytes.collect::<Vec<u8>>()).unwrap();
            continue;
        }
        let kept = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let kept: Vec<f64> =
            kept.chunks_exact(4).map(|word| f64::from(f32::from_le_bytes(word.try_into().unwrap()))).collect();
        assert_eq!(kept.len(), 2 * found.len());
        // Two-sided 1 − (1 − 0.01)^(1 / 3888): 2.6·10⁻⁶, at 4.7 standard errors. Texels without noise in both may differ by rounding.
        let away = |(kept, found): (&[f64], &[f64; 2])| {
            (kept[0] - found[0]).abs() > 4.7 * f64::hypot(kept[1], found[1]) + 1e-4 * kept[0].abs()
        };
        let wrong = kept.chunks_exact(2).zip(&found).filter(|pair| away(*pair)).count();
        assert!(wrong as f64 <= 0.0025 * found.len() as f64, "{scene}: {wrong} of {}", found.len());
        let bias = kept
            .chunks_exact(2)
            .zip(&found)
            .map(|(kept, found)| (found[0] - kept[0]) / f64::hypot(kept[1], found[1]).max(1e-3))
            .sum::<f64>();
        // The sum of independent deviations, each of at most one standard error, over all channels of a pixel together.
        let spread = (3.0 * found.len() as f64).sqrt();
        assert!(bias.abs() < 4.0 * spread, "{scene}: {bias} where {spread} is one standard error");
    }
}

/// Systems that claim neither to interpolate nor to merge. The pages of the other systems name the sources of their false light.
const TIGHT: [&str; 7] =
    ["reference", "reference_centre", "face_cache", "surface_f32", "gi_svgf", "hash_cache", "many_lamps"];

#[test]
fn no_light_comes_through_walls() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/light/leak.toml"), project.path("worlds/test.toml")).unwrap();
    for graph in TIGHT.map(|name| common::graph_in(common::LIGHT, name)) {
        let mut session = open(&project, &graph, [32, 18], &[("sun_strength", 1000.0), ("sky_strength", 1000.0)]);
        let brightest = frames(&mut session, 6).iter().flat_map(|texel| texel[..3].to_vec()).fold(0.0, f32::max);
        assert!(brightest == 0.0, "{graph}: {brightest}");
    }
}

/// Unusual worlds: nothing, one voxel, a lamp as bright as the sun, mirrors, black metal; cameras inside of them.
fn hostile_worlds() -> Vec<(&'static str, String)> {
    let at = |position: &str| format!("[camera]\nposition = {position}\nlook_at = [2.5, 2.0, 2.5]\n[materials]\n");
    let head = at("[7.5, 6.0, 9.5]");
    let voxel = "[[build]]\nop = \"box\"\nmin = [2, 2, 2]\nmax = [3, 3, 3]\nmaterial = \"m\"\n";
    let floor = "[[build]]\nop = \"box\"\nmin = [-9, -1, -9]\nmax = [9, 0, 9]\nmaterial = \"m\"\n";
    let stone = "m = { albedo = [0.5, 0.5, 0.5] }\n";
    let lamp = "m = { albedo = [1.0, 0.9, 0.5], emission = 1000000.0 }\n";
    vec![
        ("nothing", head.clone()),
        ("one voxel", format!("{head}{stone}{voxel}")),
        ("one lamp of 10^6", format!("{head}{lamp}{voxel}")),
        ("a floor of lamps", format!("{head}{lamp}{floor}")),
        (
            "a mirror of black metal",
            format!("{head}m = {{ albedo = [0.0, 0.0, 0.0], roughness = 0.0, metallic = 1.0 }}\n{floor}{voxel}"),
        ),
        (
            "matt metal",
            format!("{head}m = {{ albedo = [1.0, 1.0, 1.0], roughness = 1.0, metallic = 1.0 }}\n{floor}{voxel}"),
        ),
        ("a black lamp", format!("{head}m = {{ albedo = [0.0, 0.0, 0.0], emission = 5.0 }}\n{voxel}")),
        ("a camera in stone", format!("{}{stone}{voxel}", at("[2.5, 2.5, 2.25]"))),
        ("a camera in a lamp", format!("{}{lamp}{voxel}", at("[2.5, 2.5, 2.25]"))),
    ]
}

#[test]
fn whatever_the_world_light_is_a_number() {
    let project = Project::shipped();
    let suns: [&[(&str, f32)]; 2] = [&[], &[("sun_strength", 0.0), ("sky_strength", 0.0), ("sun_elevation", -10.0)]];
    for graph in
        systems(&project).into_iter().chain(["beauty", "beauty_glass"].map(|name| format!("graphs/{name}.toml")))
    {
        for (name, text) in hostile_worlds() {
            project.write("worlds/test.toml", format!("name = \"test\"\n{text}"));
            let mut session = open(&project, &graph, [18, 10], &[]);
            for sun in suns {
                for (param, value) in sun {
                    session.set_param(param, Value::F32(*value)).unwrap();
                }
                let wrong = frames(&mut session, 3)
                    .iter()
                    .filter(|texel| !texel.iter().all(|c| c.is_finite() && *c >= 0.0))
                    .count();
                assert_eq!(wrong, 0, "{graph} over {name} with {sun:?}");
            }
        }
    }
}

#[test]
fn a_param_that_is_no_number_is_refused() {
    let project = Project::shipped();
    furnace(&project, 0.5, 1.0);
    let mut session = open(&project, REFERENCE, [8, 8], &[]);
    for value in [f32::NAN, f32::INFINITY] {
        session.set_param("sun_strength", Value::F32(value)).unwrap_err();
    }
    session.set_param_text("sky_strength", "nan").unwrap_err();
}

/// The whole judge over small scenes. Brute force has no bias, its error falls with one over the frames, and a repeated command gives the
/// same bytes.
#[test]
fn the_judge_finds_no_bias_in_the_path_tracer_itself() {
    let project = Project::shipped();
    furnace(&project, 0.5, 1.0);
    // A red lamp in one corner instead of even walls.
    project.edit(
        "worlds/test.toml",
        "[materials]\n",
        "[materials]\nlamp = { albedo = [1.0, 0.5, 0.3], emission = 8.0 }\n",
    );
    project.edit("worlds/test.toml", "emission = 1.0", "emission = 0.0");
    let text = std::fs::read_to_string(project.path("worlds/test.toml")).unwrap();
    project.write("worlds/test.toml", text + &cuboid("lamp", [0, 4, 0], [2, 5, 1], ""));
    let scene = scene();
    let mut bench = Bench::new(Effort { pan: 3, lag: 2, ..effort(&project, [48, 32], 16, 64) });
    let references = bench.references(&scene).unwrap();
    assert_eq!(references.about.hashes, bench.references(&scene).unwrap().about.hashes, "same command, same bytes");
    assert_ne!(references.about.hashes[0], references.about.hashes[1]);
    let part = references.about.noise / references.about.forecast;
    assert!((0.2..1.5).contains(&part), "{:?}", references.about);
    let outcome = bench.system(REFERENCE, &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert_eq!(outcome.still.iter().map(|point| point.frame).collect::<Vec<_>>(), [1, 2, 4, 8, 16]);
    for point in &outcome.still {
        let judged = point.judged;
        assert!(judged.bias2.abs() <= 4.0 * judged.bias2_se, "{point:?}");
        assert!((judged.error - judged.bias2 - judged.noise).abs() < 1e-9, "{point:?}");
    }
    let (first, last) = (&outcome.still[0].judged, &outcome.still[4].judged);
    assert!((6.0..60.0).contains(&(first.noise / last.noise)), "{first:?} {last:?}");
    assert!(outcome.frame_ms > 0.0 && outcome.flip.unwrap() < 0.5 && outcome.flicker > 0.0);
    // The path tracer starts over with each motion and at the switch.
    let pan = outcome.pan.unwrap();
    assert!(pan.voxels > 0.0 && pan.judged.noise > last.noise, "{pan:?}");
    let lag = outcome.lag.unwrap();
    assert_eq!((lag.to_5_percent, lag.to_1_percent), (Some(1), Some(1)), "{lag:?}");
}

#[test]
fn the_verb_writes_tables_and_charts_and_says_what_is_not_there() {
    let project = Project::shipped();
    let quick = ["bench", "light", "--size", "16x9", "--frames", "4", "--paths", "16"];
    let run = |more: &[&str]| project.raxel(&[&quick[..], more].concat());
    let rows =
        run(&["sun_history", "--scenes", "room,worlds/menger.toml", "-o", "out", "--format", "json"]).exits(0).json();
    let of = |reason: &str| rows.iter().filter(|row| row["reason"] == reason).count();
    assert_eq!((of("reference"), of("judged")), (2, 4), "two scenes, each with the path tracer and one system");
    let read = |name: &str| std::fs::read_to_string(project.path(&format!("out/{name}"))).unwrap();
    let results: serde_json::Value = serde_json::from_str(&read("results.json")).unwrap();
    assert!(results["formula"].as_str().unwrap().starts_with("relMSE = "));
    assert_eq!(results["rows"].as_array().unwrap().len(), 4);
    // Pictures after 1, 2 and 4 frames for each row, under a head.
    assert_eq!(read("results.csv").lines().count(), 1 + 4 * 3);
    for chart in ["light-room.svg", "light-menger.svg"] {
        let svg = read(chart);
        assert!(svg.ends_with("</svg>\n") && svg.contains(">sun_history<"), "{chart}");
    }
    assert!(run(&["--scenes", "rom"]).exits(3).stderr.contains("did you mean `room`?"));
    assert!(run(&["sun_histori", "--scenes", "room"]).exits(3).stderr.contains("did you mean `sun_history`?"));
    run(&["--scenes", "room", "--goal", "0"]).exits(2);
    // A graph without light is refused with a message, and the others are judged all the same.
    let refused = run(&["graphs/inspect.toml", "--scenes", "room"]).exits(3);
    assert!(refused.stderr.contains("it has no target `radiance` of floats"), "{}", refused.stderr);
}

#[test]
fn the_verb_says_what_passes_count() {
    let project = Project::shipped();
    let run = || {
        let quick = ["--scenes", "room", "--size", "16x9", "--frames", "2", "--paths", "16", "--format", "short"];
        project.raxel(&[&["bench", "light", "face_cache"], &quick[..]].concat()).exits(0).stderr
    };
    assert!(!run().contains("RX0411"));
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u;", "RX_FACE_PROBES = 0u;");
    let said = run();
    assert!(said.contains("RX0411") && said.contains("their faces found no slot in the table: "), "{said}");
}

/// Points of 2^8 in four pairs, for two seeds; the light that a number draws.
const SAMPLER: &str = include_str!("fixtures/light/sampler.comp");

#[test]
fn points_are_stratified_and_lamps_are_drawn_by_their_power() {
    let project = Project::shipped();
    let materials =
        "dim = { albedo = [1.0, 1.0, 1.0], emission = 1.0 }\nbright = { albedo = [1.0, 1.0, 1.0], emission = 20.0 }";
    let build = [cuboid("dim", [0, 0, 0], [3, 1, 1], ""), cuboid("bright", [9, 0, 0], [10, 1, 1], "")];
    world(&project, materials, &build, [5.0, 5.0, 9.0], [5.0, 0.0, 0.0], 60.0);
    project
        .write("shaders/sampler.comp", SAMPLER)
        .write("graphs/sampler.toml", include_str!("fixtures/light/sampler.toml"));
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/sampler.toml")),
        world: Some(project.path("worlds/test.toml")),
        size: [8, 8],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap();
    session.frame().unwrap();
    let words: Vec<u32> = session
        .read_buffer("results", 0..294_912)
        .unwrap()
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
        .collect();
    for (number, set) in words[..8192].chunks_exact(4 * 256).enumerate() {
        // One of 256 points in each of the 2^a by 2^(8-a) boxes, for any a: a (0, 8, 2)-net in base 2.
        for a in 0..=8 {
            let mut boxes = [0; 256];
            for point in set.chunks_exact(4) {
                let [x, y] = [u64::from(point[0]), u64::from(point[1])];
                boxes[((x << a >> 32) << (8 - a) | y << (8 - a) >> 32) as usize] += 1;
            }
            assert!(boxes.iter().all(|count| *count == 1), "set {number}, {a} bits along x: {boxes:?}");
        }
        // Heights over the face and turns around it are even: cos² and the angle are the numbers themselves.
        let mut heights = [0; 16];
        for point in set.chunks_exact(4) {
            heights[((f32::from_bits(point[2]) * 16.0) as usize).min(15)] += 1;
            assert!(f32::from_bits(point[2]) > 0.0 && f32::from_bits(point[3]).is_finite());
        }
        assert!(heights.iter().all(|count| (15..=17).contains(count)), "{heights:?}");
    }
    let sets: Vec<&[u32]> = words[..8192].chunks_exact(1024).collect();
    assert!((1..8).all(|other| sets[0] != sets[other]), "pairs and seeds differ");
    // Three dim voxels in a row have 14 bare faces, the bright one 6 of twenty times their power.
    let mut drawn = [0.0_f64; 20];
    words[8192..].iter().for_each(|index| drawn[*index as usize] += 1.0 / 65536.0);
    for (light, part) in drawn.iter().enumerate() {
        let power: f64 = if light < 14 { 1.0 } else { 20.0 };
        assert!((part - power / 134.0).abs() < 2e-3 * power.sqrt(), "light {light}: {part}");
    }
}
