//! Lamps: which are known, and how they are drawn.

use raxel::Session;
use raxel_edit::{Brush, Operation};
use raxel_measure::light::{Bench, Effort, Scene};

use crate::common::{LIGHT, Project, graph_in};
use crate::scenes::{DARK, cuboid, effort, frames, open, scene, world};
use crate::{luminance, room};

/// Means of the light in each of some frames.
fn means(session: &mut Session, count: u32) -> Vec<f64> {
    (0..count).map(|_| luminance(&frames(session, 1))).collect()
}

/// The session's lamp, taken out by an edit.
fn take_lamp(session: &mut Session) {
    let lamp = Operation::sphere([7.0, 7.5, 7.0], 1.0, Brush::Subtract);
    assert!(session.edit(&[lamp]).unwrap() > 0);
}

/// Frames until so little is left of the light of a lamp that an edit has removed, as the pages of these systems claim.
const GONE_AFTER: [(&str, usize); 6] =
    [("face_cache", 2), ("surface_f32", 2), ("gi_svgf", 10), ("hash_cache", 10), ("many_lamps", 10), ("ddgi", 10)];

#[test]
fn light_of_a_lamp_that_an_edit_takes_out_goes_and_comes_back() {
    let project = Project::shipped();
    room(&project);
    for (system, most) in GONE_AFTER {
        let mut session = open(&project, &graph_in(LIGHT, system), [24, 14], &DARK);
        let before = *means(&mut session, 24).last().unwrap();
        assert!(before > 0.1, "{system}: {before}");
        take_lamp(&mut session);
        let after = means(&mut session, most as u32);
        assert!(*after.last().unwrap() < 0.05 * before, "{system}: of {before}, {after:?} are left");
        assert!(session.undo().unwrap());
        let again = *means(&mut session, 24).last().unwrap();
        assert!((again / before - 1.0).abs() < 0.25, "{system}: {again} after an undo, {before} before");
    }
}

/// Lamps of three colours and powers on both sides of a wall, most of them hidden from most places.
fn lamps(project: &Project) {
    let materials = r"wall = { albedo = [0.5, 0.5, 0.5] }
red = { albedo = [1.0, 0.4, 0.3], emission = 6.0 }
blue = { albedo = [0.3, 0.5, 1.0], emission = 3.0 }
white = { albedo = [1.0, 1.0, 1.0], emission = 1.0 }";
    let mut build = vec![cuboid("wall", [-2, -1, -2], [26, 0, 26], ""), cuboid("wall", [11, 0, 4], [13, 6, 20], "")];
    for i in 0..12 {
        let (x, z) = (1 + i * 7 % 23, 2 + i * 11 % 21);
        let height = 1 + i % 3;
        build.push(cuboid(["red", "blue", "white"][i as usize % 3], [x, height, z], [x + 1, height + 1, z + 1], ""));
    }
    world(project, materials, &build, [12.0, 16.0, 30.0], [12.0, 0.0, 11.0], 55.0);
}

#[test]
fn points_on_lamps_that_are_used_again_add_no_light_and_take_none() {
    let project = Project::shipped();
    lamps(&project);
    project.write(
        "graphs/light/raw.toml",
        r#"extends = "../rivals/light/many_lamps.toml"
name = "raw"
[params.rounds]
default = 0
[params.reused]
default = 20
"#,
    );
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(Effort { pan: 8, lag: 12, ..effort(&project, [64, 40], 32, 128) });
    let references = bench.references(&scene).unwrap();
    let outcome = bench.system("graphs/light/raw.toml", &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    let moving = outcome.pan.unwrap().judged;
    for judged in outcome.still.iter().map(|point| &point.judged).chain([&moving]) {
        assert!(judged.bias2.abs() <= 4.0 * judged.bias2_se, "{judged:?}");
    }
    // All of the light: its mean differs from the reference's by no more than the noise of both.
    let part = outcome.mean / references.about.mean - 1.0;
    assert!(part.abs() < 0.01, "{part}");
    let noise: Vec<f64> = outcome.still.iter().map(|point| point.judged.noise).collect();
    assert!(noise.windows(2).all(|pair| pair[1] < pair[0]), "{noise:?}");
    assert!(outcome.lag.as_ref().unwrap().to_5_percent.is_some_and(|frames| frames <= 10), "{:?}", outcome.lag);
}

/// Smoothing asks for the variance of a mean. A pixel that has seen little light does not know its own variance. Without its neighbours' variance
/// it stayed dark beside them, and bias² was twice as large here.
#[test]
fn smoothing_does_not_leave_pixels_dark_that_have_been_unlucky() {
    let project = Project::shipped();
    lamps(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 16, 128));
    let references = bench.references(&scene).unwrap();
    let variance = std::fs::read_to_string(project.path("shaders/rivals/light/gi/variance.comp")).unwrap();
    let [with, without] = ["i < 9", "i < 0"].map(|turns| {
        project.write("shaders/rivals/light/gi/variance.comp", variance.replace("i < 9", turns));
        let outcome = bench.system("graphs/rivals/light/many_lamps.toml", &scene, &references).unwrap();
        (outcome.still[0].judged, outcome.mean / references.about.mean - 1.0)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(with.0.error < 0.7 * without.0.error, "{with:?} {without:?}");
}

/// Lists of lamps that are known to light a place: the same light as by power alone, with less noise.
#[test]
fn lamps_that_are_known_add_no_light_and_take_none() {
    let project = Project::shipped();
    lamps(&project);
    project.write(
        "graphs/light/known.toml",
        r#"extends = "face_cache.toml"
name = "known"
[params.smooth]
default = false
[params.grain]
default = 0.0
"#,
    );
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 32, 256));
    let references = bench.references(&scene).unwrap();
    let sum = "known_sum += known_share(words[k]);";
    let [with, without] = [sum, "known_sum += 0.0;"].map(|text| {
        project.edit("shaders/light/face_cache/known_lamps.glsl", sum, text);
        let outcome = bench.system("graphs/light/known.toml", &scene, &references).unwrap();
        project.edit("shaders/light/face_cache/known_lamps.glsl", text, sum);
        (outcome.mean / references.about.mean - 1.0, outcome.still.last().unwrap().judged.noise)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(with.0.abs() < 0.02 && (with.0 - without.0).abs() < 0.015, "{with:?} {without:?}");
    assert!(with.1 < 0.85 * without.1, "{with:?} {without:?}");
}

/// Three lamps over a floor, and under it a sealed cellar with thousands of them, which take nearly all draws by power.
fn cellar(project: &Project) {
    let materials = "wall = { albedo = [0.5, 0.5, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 6.0 }";
    let mut build = vec![
        cuboid("wall", [-2, -8, -2], [50, 0, 50], ""),
        cuboid("lamp", [0, -6, 0], [48, -5, 48], ""),
        "[[build]]\nop = \"box\"\nmode = \"subtract\"\nmin = [0, -5, 0]\nmax = [48, -3, 48]\n".to_owned(),
        cuboid("wall", [23, 0, 14], [25, 7, 34], ""),
    ];
    for [x, y, z] in [[14, 2, 20], [30, 4, 16], [36, 1, 33]] {
        build.push(cuboid("lamp", [x, y, z], [x + 1, y + 1, z + 1], ""));
    }
    world(project, materials, &build, [24.0, 26.0, 60.0], [24.0, 0.0, 24.0], 50.0);
}

/// Faces share found lamps with the faces around them, among thousands of lamps that no face sees. The light is the same as by power alone, with a
/// fraction of the error.
#[test]
fn lamps_that_are_found_among_thousands_are_known_to_a_region() {
    let project = Project::shipped();
    cellar(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 24, 256));
    let references = bench.references(&scene).unwrap();
    let file = "shaders/light/face_cache/known_lamps.glsl";
    let cells = ("i < KNOWN_EACH / 4u && lists;", "i < 0u;");
    let regions = ("size < REGION_SIZES && lists;", "size < 0u;");
    let [both, no_regions, neither] = [&[][..], &[regions], &[cells, regions]].map(|left_out| {
        for (text, other) in left_out {
            project.edit(file, text, other);
        }
        let outcome = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        for (text, other) in left_out {
            project.edit(file, other, text);
        }
        (outcome.mean / references.about.mean - 1.0, outcome.still.last().unwrap().judged)
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(both.0.abs() < 0.04, "{both:?}");
    assert!(both.1.error < 0.8 * no_regions.1.error, "{both:?} {no_regions:?}");
    assert!(both.1.error < 0.3 * neither.1.error, "{both:?} {neither:?}");
}

/// The light of lamps that are drawn alike, to compare drawing them by their power with: the same light, with more noise where lamps
/// differ.
#[test]
fn lamps_that_are_drawn_alike_give_the_same_light() {
    let project = Project::shipped();
    lamps(&project);
    let dark = DARK.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let scene = Scene { params: dark, ..scene() };
    let mut bench = Bench::new(effort(&project, [64, 40], 32, 128));
    let references = bench.references(&scene).unwrap();
    let [by_power, alike] = ["reference_centre", "views/even_lamps"].map(|graph| {
        let outcome = bench.system(&graph_in(LIGHT, graph), &scene, &references).unwrap();
        [outcome.still[0].judged, outcome.still.last().unwrap().judged]
    });
    assert_eq!(bench.complaints(), &[] as &[String]);
    assert!(alike[1].bias2.abs() <= 4.0 * alike[1].bias2_se, "{alike:?}");
    // A frame has 1.26 times the noise here.
    assert!(alike[0].noise > 1.1 * by_power[0].noise, "{alike:?} {by_power:?}");
}
