//! Skies and materials of `graphs/rivals/light/pbr_sky.toml`. Its tables are made only when the sun moves. The sky in closed form is near a march through the
//! same air, and skylight is the mean of the sky. Surfaces are near a path tracer of the same materials.

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use std::f64::consts::PI;

use common::Project;
use raxel::execute::PassOutcome;
use raxel::{DebugTarget, Options, Session, Validation, Value};
use raxel_measure::light::Bench;

const GRAPH: &str = "graphs/rivals/light/pbr_sky.toml";

/// A floor, a wall, a block of gold, a block of steel and one with a coat, in the open.
const WORLD: &str = include_str!("fixtures/skies/open.toml");

fn project() -> Project {
    let project = Project::shipped();
    project.write("worlds/test.toml", WORLD);
    project
}

fn open(project: &Project, graph: &str, size: [u32; 2]) -> Session {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path("worlds/test.toml")),
        size,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{graph}: {error}"));
    session.set_debug_target(DebugTarget::resource("radiance")).unwrap();
    session
}

fn frame(session: &mut Session) {
    session.frame().unwrap();
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

fn set(session: &mut Session, name: &str, value: f32) {
    session.set_param(name, Value::F32(value)).unwrap();
}

/// Names of the passes that the last frame has dispatched.
fn ran(session: &Session) -> Vec<String> {
    let plan = session.plan().unwrap();
    let passes = plan.passes.iter().zip(session.outcomes());
    let ran = passes.filter(|(_, outcome)| *outcome == PassOutcome::Dispatched);
    ran.map(|(pass, _)| plan.graph.pass(pass.pass).name.clone()).collect()
}

#[test]
fn tables_are_made_when_the_sun_moves_and_at_no_other_time() {
    let project = project();
    let mut session = open(&project, GRAPH, [32, 18]);
    let tables = ["transmittance", "scattered", "sky_view", "sky_map", "ambient", "kept"];
    let made = |session: &mut Session| -> Vec<String> {
        frame(session);
        let ran = ran(session);
        assert!(ran.iter().any(|name| name == "shade"), "{ran:?}");
        ran.into_iter().filter(|name| tables.contains(&name.as_str())).collect()
    };
    assert_eq!(made(&mut session), tables);
    assert!(made(&mut session).is_empty());
    set(&mut session, "sun_elevation", 33.0);
    // The air around the Earth is the same for each sun.
    assert_eq!(made(&mut session), ["sky_view", "sky_map", "ambient"]);
    assert!(made(&mut session).is_empty());
    // The tables are as seen from the sun: a turn of it changes only what each of the six faces gets of them.
    set(&mut session, "sun_azimuth", 100.0);
    assert_eq!(made(&mut session), ["ambient"]);
    session.set_param("sky", Value::U32(1)).unwrap();
    assert_eq!(made(&mut session), ["sky_map", "ambient"]);
    set(&mut session, "exposure", 2.0);
    assert!(made(&mut session).is_empty());
}

const GROUND: f64 = 6360.0;

fn densities(height: f64) -> [f64; 3] {
    [(-height / 8.0).exp(), (-height / 1.2).exp(), (1.0 - (height - 25.0).abs() / 15.0).max(0.0)]
}

/// Green light, per km: scattering by air and haze, and the loss.
fn lost([rayleigh, mie, ozone]: [f64; 3]) -> f64 {
    13.558e-3 * rayleigh + 4.44e-3 * mie + 1.881e-3 * ozone
}

fn radius(start: f64, cosine: f64, t: f64) -> f64 {
    (start * start + t * t + 2.0 * start * t * cosine).sqrt()
}

fn to_top(start: f64, cosine: f64) -> f64 {
    -start * cosine + (start * start * (cosine * cosine - 1.0) + 6460.0 * 6460.0).sqrt()
}

/// Share of sunlight that reaches a place, by 200 steps.
fn through(start: f64, cosine: f64) -> f64 {
    if cosine < 0.0 && start * start * (cosine * cosine - 1.0) + GROUND * GROUND >= 0.0 {
        return 0.0;
    }
    let size = to_top(start, cosine) / 200.0;
    let depth: f64 =
        (0..200).map(|i| lost(densities(radius(start, cosine, (f64::from(i) + 0.5) * size) - GROUND))).sum();
    (-depth * size).exp()
}

/// Green radiance of the sky from light that was scattered once, for a sun with the irradiance pi: 400 steps.
fn marched(dir: [f64; 3], sun: [f64; 3]) -> f64 {
    let (start, cosine) = (GROUND + 0.3, dir[0] * sun[0] + dir[1] * sun[1] + dir[2] * sun[2]);
    let g: f64 = 0.8;
    let rayleigh = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
    let mie = 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + cosine * cosine)
        / (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
    let size = to_top(start, dir[1]) / 400.0;
    let (mut clear, mut light) = (1.0, 0.0);
    for i in 0..400 {
        let t = (f64::from(i) + 0.5) * size;
        let at = [t * dir[0], start + t * dir[1], t * dir[2]];
        let r = (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]).sqrt();
        let density = densities(r - GROUND);
        let sunlit = through(r, (at[0] * sun[0] + at[1] * sun[1] + at[2] * sun[2]) / r);
        let sent = sunlit * (13.558e-3 * density[0] * rayleigh + 3.996e-3 * density[1] * mie);
        let loss = (-lost(density) * size).exp();
        light += clear * sent * (1.0 - loss) / lost(density);
        clear *= loss;
    }
    PI * light
}

/// The direction of a texel of the sky's table, with the sun over +x, as `rx_sky_view_direction` has it.
fn direction(x: usize, y: usize) -> [f64; 3] {
    let (around, s) = (PI * x as f64 / 191.0, 2.0 * y as f64 / 107.0 - 1.0);
    let above = 0.5 * PI * s.signum() * s * s;
    [above.cos() * around.cos(), above.sin(), above.cos() * around.sin()]
}

#[test]
fn the_sky_in_closed_form_is_near_a_march_through_the_same_air() {
    let project = project();
    let mut session = open(&project, GRAPH, [32, 18]);
    session.pin("sky_map").unwrap();
    session.set_param("sky", Value::U32(1)).unwrap();
    set(&mut session, "sun_strength", 1.0);
    for (elevation, within) in [(60.0, 0.03), (25.0, 0.03), (8.0, 0.08)] {
        set(&mut session, "sun_elevation", elevation);
        frame(&mut session);
        let sky = session.read_target("sky_map").unwrap().floats();
        let e = f64::from(elevation).to_radians();
        let sun = [e.cos(), e.sin(), 0.0];
        let (mut error, mut sum) = (0.0, 0.0);
        for y in (56..108).step_by(5) {
            for x in (0..192).step_by(19) {
                let dir = direction(x, y);
                let truth = marched(dir, sun);
                // Weighed by what a level floor gets from there.
                let weight = dir[1] * (1.0 - dir[1] * dir[1]).sqrt();
                error += weight * (f64::from(sky[192 * y + x][1]) - truth).abs();
                sum += weight * truth;
            }
        }
        assert!(error / sum < within, "{elevation} degrees: off by {} of the light", error / sum);
    }
}

#[test]
fn skylight_on_a_face_is_the_mean_of_the_sky() {
    let project = project();
    let mut session = open(&project, GRAPH, [32, 18]);
    for name in ["sky_map", "ambient"] {
        session.pin(name).unwrap();
    }
    frame(&mut session);
    let sky = session.read_target("sky_map").unwrap().floats();
    let bytes = session.read_buffer("ambient", 0..96).unwrap();
    let up = f64::from(f32::from_le_bytes(bytes[16 * 3 + 4..][..4].try_into().unwrap()));
    // The integral over the table's own texels; the far half of the sky is the mirror image of this one.
    let (mut light, mut whole) = (0.0, 0.0);
    for y in 54..108 {
        for x in 0..192 {
            let (dir, s) = (direction(x, y), 2.0 * y as f64 / 107.0 - 1.0);
            let solid = s * (1.0 - dir[1] * dir[1]).sqrt() * if x == 0 || x == 191 { 0.5 } else { 1.0 };
            light += solid * dir[1] * f64::from(sky[192 * y + x][1]);
            whole += solid * dir[1];
        }
    }
    assert!((up * whole / light - 1.0).abs() < 0.01, "{up} where {} is the mean", light / whole);
}

fn rel_mse(found: &[[f32; 4]], truth: &[[f32; 4]]) -> f64 {
    let pairs = found.iter().zip(truth).flat_map(|(a, b)| (0..3).map(|c| (f64::from(a[c]), f64::from(b[c]))));
    let sum: f64 = pairs.map(|(a, b)| (a - b) * (a - b) / (b * b + 0.01)).sum();
    sum / (3 * truth.len()) as f64
}

#[test]
fn surfaces_are_near_a_path_tracer_of_the_same_materials() {
    let project = project();
    let size = [48, 27];
    let light = |graph: &str, frames: u32, sky: Option<u32>| {
        let mut session = open(&project, graph, size);
        if let Some(sky) = sky {
            session.set_param("sky", Value::U32(sky)).unwrap();
        }
        (0..frames).for_each(|_| frame(&mut session));
        // Rows of sky are left out: what lies below the horizon is haze in one and ground in the other.
        session.read_target("radiance").unwrap().floats().split_off(48 * 9)
    };
    let truth = light("graphs/light/views/glass.toml", 300, None);
    let ours = rel_mse(&light(GRAPH, 32, None), &truth);
    let seeds = rel_mse(&light("graphs/rivals/light/pbr_sky_seed.toml", 32, Some(3)), &truth);
    assert!(ours < 0.05, "relMSE {ours}");
    assert!(seeds > 5.0 * ours, "relMSE {seeds} of the original's formulas, {ours} of ours");
}

#[test]
fn the_judge_compares_it_under_its_own_sky() {
    let project = project();
    let scene = scenes::scene();
    let mut bench = Bench::new(scenes::effort(&project, [48, 32], 8, 64));
    let references = bench.references(&scene).unwrap();
    let outcome = bench.system(GRAPH, &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    let judged = outcome.still.last().unwrap().judged;
    // Without bounces; under another sky it would be several times as much.
    assert!(judged.error < 0.03, "{judged:?}");
}

/// A slit roof over a floor: shafts of light in thick mist.
const SHAFTS: &str = include_str!("fixtures/skies/shafts.toml");

/// A session that holds the air of `graph` as a mean of frames, and the same by a march.
fn air(project: &Project, graph: &str) -> Session {
    for (name, text) in [
        ("graphs/air.toml", include_str!("fixtures/skies/air.toml")),
        ("graphs/lamps.toml", include_str!("fixtures/skies/lamps.toml")),
        ("shaders/air_mean.comp", include_str!("fixtures/skies/air_mean.comp")),
        ("shaders/air_march.comp", include_str!("fixtures/skies/air_march.comp")),
        ("shaders/lamps_march.comp", include_str!("fixtures/skies/lamps_march.comp")),
        ("shaders/air_sum.comp", include_str!("fixtures/skies/air_sum.comp")),
    ] {
        project.write(name, text);
    }
    // A pixel for each column of slices, so that both look along the same ray.
    let mut session = open(project, graph, [40, 24]);
    session.set_debug_target(DebugTarget::resource("mean")).unwrap();
    for name in ["marched", "place", "hit"] {
        session.pin(name).unwrap();
    }
    // The march knows no shadows of clouds.
    set(&mut session, "clouds", 0.0);
    session
}

/// The mean over the air and the result of the march, where slices are seen: of each, its column and itself.
fn pairs(session: &mut Session) -> Vec<([usize; 2], [f32; 4], [f32; 4])> {
    let [found, truth] = ["mean", "marched"].map(|name| session.read_target(name).unwrap().floats());
    let [places, hits] = ["place", "hit"].map(|name| session.read_target(name).unwrap().floats());
    // The slice behind a surface is not seen, and a pixel is looked through at another place in each frame: its neighbours count.
    let seen = |slice: usize, [x, y]: [usize; 2]| {
        let end = 8.0 * (f32::exp2(9.0 * (slice + 1) as f32 / 32.0) - 1.0);
        let around =
            (y.max(1) - 1..=(y + 1).min(23)).flat_map(|y| (x.max(1) - 1..=(x + 1).min(39)).map(move |x| 40 * y + x));
        around.into_iter().all(|pixel| hits[pixel][3] < 0.0 || end < places[pixel][2])
    };
    let texels = (0..24).flat_map(|y| (0..1280).map(move |x| (x, y)));
    let seen = texels.filter(|(x, y)| seen(x / 40, [x % 40, *y]));
    let pairs: Vec<_> = seen.map(|(x, y)| ([x % 40, y], found[1280 * y + x], truth[1280 * y + x])).collect();
    assert!(pairs.len() > 1280 * 24 / 8, "{}", pairs.len());
    pairs
}

#[test]
fn the_air_is_near_a_march() {
    let project = project();
    let slats = (-3..9).map(|i| {
        let x = 8 * i;
        format!("[[build]]\nop = \"box\"\nmin = [{x}, 20, -30]\nmax = [{}, 22, 50]\nmaterial = \"floor\"\n", x + 5)
    });
    project.write("worlds/test.toml", slats.fold(SHAFTS.to_owned(), |text, slat| text + &slat));
    let mut session = air(&project, "graphs/air.toml");
    // Thin air under a high sun; mist that is twenty times as thick, and a low one. A part of the error is noise.
    for (elevation, mist, most) in [(50.0, 0.6, 0.01), (24.0, 12.0, 0.02)] {
        set(&mut session, "sun_elevation", elevation);
        set(&mut session, "mist", mist);
        for _ in 0..128 {
            frame(&mut session);
        }
        let pairs = pairs(&mut session);
        for channel in 0..4 {
            let off: f64 = pairs.iter().map(|(_, a, b)| f64::from((a[channel] - b[channel]).abs())).sum();
            let all: f64 = pairs.iter().map(|(_, _, b)| f64::from(b[channel])).sum();
            eprintln!("sun {elevation}, mist {mist}, channel {channel}: {}", off / all);
            assert!(off < most * all, "sun at {elevation}, mist {mist}, channel {channel}: {}", off / all);
        }
    }
}

/// Lamps light the mist before and beside them, walls throw shadows into it, and one behind a wall sends nothing through it. Without a lamp, no light is added.
#[test]
fn lamps_light_the_mist_as_a_march_says() {
    let project = project();
    let lamp = |[x, y, z]: [i32; 3]| {
        let max = [x + 1, y + 1, z + 1];
        format!("[[build]]\nop = \"box\"\nmin = {:?}\nmax = {max:?}\nmaterial = \"lamp\"\n", [x, y, z])
    };
    // A lamp in the open, one that a board hides from a part of the air, and one behind a wall.
    let board = |min: [i32; 3], max: [i32; 3]| {
        format!("[[build]]\nop = \"box\"\nmin = {min:?}\nmax = {max:?}\nmaterial = \"floor\"\n")
    };
    let build = [
        lamp([4, 8, 24]),
        lamp([22, 6, 14]),
        board([18, 4, 10], [19, 12, 20]),
        lamp([12, 6, -22]),
        board([-40, 0, -20], [80, 40, -18]),
    ];
    let materials = "[materials]\nlamp = { albedo = [1.0, 0.7, 0.4], emission = 40.0 }";
    project.write("worlds/test.toml", SHAFTS.replace("[materials]", materials) + &build.concat());
    let mut session = air(&project, "graphs/lamps.toml");
    // Even mist: it is as thick as on its floor up to there. Neither sun nor sky.
    for (name, value) in [("mist", 20.0), ("mist_floor", 400.0), ("sun_strength", 0.0), ("sky_strength", 0.0)] {
        set(&mut session, name, value);
    }
    for _ in 0..160 {
        frame(&mut session);
    }
    let found = pairs(&mut session);
    let sum = |of: &dyn Fn(f32, f32) -> f32| {
        found.iter().map(|(_, light, truth)| f64::from(of(light[0], truth[0]))).sum::<f64>()
    };
    let (light, truth) = (sum(&|light, _| light), sum(&|_, truth| truth));
    let off = sum(&|light, truth| (light - truth).abs());
    eprintln!("mean {}, off {}", light / truth, off / truth);
    assert!(
        truth > 0.0 && (light / truth - 1.0).abs() < 0.03 && off < 0.1 * truth,
        "mean {}, off {}",
        light / truth,
        off / truth
    );
    // The same in each part of the picture.
    let parts = |which: usize| {
        let mut parts = [0.0; 6];
        for pair in &found {
            parts[pair.0[0] * 3 / 40 + 3 * (pair.0[1] * 2 / 24)] += f64::from([pair.1, pair.2][which][0]);
        }
        parts
    };
    for (part, (found, truth)) in parts(0).into_iter().zip(parts(1)).enumerate() {
        eprintln!("part {part}: {}", found / truth);
        assert!((found - truth).abs() < 0.1 * truth, "part {part}: {found} of {truth}");
    }
    // The light of lamps leaves the mist at once when they are switched off, and darkness is exact.
    session.pin("air").unwrap();
    set(&mut session, "lamp_strength", 0.0);
    frame(&mut session);
    let dark = session.read_target("air").unwrap().floats();
    assert!(dark.iter().all(|texel| texel[..3] == [0.0; 3]));
}
