//! Light by the book: the path tracer that lighting systems are judged by is held to scenes whose light is known in closed form, and every
//! system that claims it to no light through walls.

mod common;

use std::f64::consts::{FRAC_PI_2, PI};

use common::Project;
use raxel::measure::light::{Bench, Effort, REFERENCE, Scene};
use raxel::runtime::debug_target::DebugTarget;
use raxel::{Options, Session, Validation, Value};

/// Materials and operations of a world, and where its camera stands and looks.
fn world(project: &Project, materials: &str, build: &[String], position: [f64; 3], look_at: [f64; 3], fov: f64) {
    let text = format!(
        "name = \"test\"\n[camera]\nposition = {position:?}\nlook_at = {look_at:?}\nfov = {fov:?}\n[materials]\n{materials}\n{}",
        build.concat()
    );
    project.write("worlds/test.toml", text);
}

fn cuboid(material: &str, min: [i32; 3], max: [i32; 3], more: &str) -> String {
    format!("[[build]]\nop = \"box\"\nmin = {min:?}\nmax = {max:?}\nmaterial = \"{material}\"\n{more}\n")
}

fn open(project: &Project, graph: &str, size: [u32; 2], params: &[(&str, f32)]) -> Session {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path("worlds/test.toml")),
        size,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{graph}: {error}"));
    session.pin("radiance").unwrap();
    session.set_debug_target(DebugTarget::resource("radiance")).unwrap();
    for (name, value) in params {
        session.set_param(name, Value::F32(*value)).unwrap();
    }
    session
}

fn frames(session: &mut Session, count: u32) -> Vec<[f32; 4]> {
    for _ in 0..count {
        session.frame().unwrap();
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    session.read_target("radiance").unwrap().floats()
}

/// Narrows the view to so many degrees, so that all pixels see the same point.
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
    /// Within so much of the truth, and within what chance allows: a deviation of 4 standard errors happens once in 16,000 times.
    #[track_caller]
    fn is(&self, truth: f64, within: f64) {
        let away = (self.mean - truth).abs();
        assert!(4.0 * self.se <= within * truth, "{self:?} is too noisy for {within} of {truth}");
        assert!(away <= within * truth && away <= 4.0 * self.se + 1e-5 * truth, "{self:?} is not {truth}");
    }
}

const DARK: [(&str, f32); 2] = [("sun_strength", 0.0), ("sky_strength", 0.0)];

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
    for (albedo, emission, count, within) in [(0.5, 2.0, 512, 0.002)] {
        let truth = furnace(&project, albedo, emission);
        let mut session = open(&project, REFERENCE, [24, 16], &DARK);
        session.set_param("paths", Value::I32(4)).unwrap();
        mean(&frames(&mut session, count / 4)).is(truth, within);
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

/// A lamp of 16 × 16 faces, 12 above a floor: the form factor from the point below its middle (Howell, configuration B-4, four times).
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
    let light = frames(&mut open(&project, REFERENCE, [24, 16], &DARK), 512);
    mean(&light).is(0.5 * 6.0 * form, 0.005);
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
    let light = frames(&mut session, 128);
    mean(&light).is(0.5 / PI * irradiance, 0.005);
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

/// Systems that neither interpolate nor merge, and say so: others' pages say where light comes from that is not there.
const TIGHT: [&str; 4] = ["reference", "reference_centre", "face_cache", "gi_svgf"];

#[test]
fn no_light_comes_through_walls() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/light/leak.toml"), project.path("worlds/test.toml")).unwrap();
    for graph in TIGHT.map(|name| format!("graphs/light/{name}.toml")) {
        let mut session = open(&project, &graph, [32, 18], &[("sun_strength", 1000.0), ("sky_strength", 1000.0)]);
        let brightest = frames(&mut session, 6).iter().flat_map(|texel| texel[..3].to_vec()).fold(0.0, f32::max);
        assert!(brightest == 0.0, "{graph}: {brightest}");
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

/// The whole judge over small scenes: brute force has no bias, its error goes down as one over the frames, and the same command gives the
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
    let scene =
        Scene { name: "test".to_owned(), world: "worlds/test.toml".to_owned(), camera: None, params: Vec::new() };
    let effort = Effort {
        project: project.root().to_owned(),
        device: None,
        validation: Validation::Required,
        size: [48, 32],
        frames: 16,
        pan: 3,
        lag: 2,
        most_paths: 64,
        goal: 1e-9,
    };
    let mut bench = Bench::new(effort);
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
    // The path tracer starts anew with each motion and at the switch.
    let pan = outcome.pan.unwrap();
    assert!(pan.voxels > 0.0 && pan.judged.noise > last.noise, "{pan:?}");
    let lag = outcome.lag.unwrap();
    assert_eq!((lag.to_5_percent, lag.to_1_percent), (Some(1), Some(1)), "{lag:?}");
}
