//! `raxel bench light` on new scenes, in motion, in any world, and for films.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use common::{Project, Run, RunRaxel};
use raxel_measure::light::{Bench, CameraMotion, Effort, Epsilon, Motion, REFERENCE, Scene};
use scenes::{cuboid, effort, scene, world};
use serde_json::Value;

/// A system without noise that shows the azimuth of the sun: of this frame, or of the frame before.
const ECHO: &str = include_str!("fixtures/judge/echo.toml");

const ECHO_SHADER: &str = include_str!("fixtures/judge/echo.comp");

/// Writes the system; `shown` is `azimuth / 360.0` or `before`.
fn echo(project: &Project, name: &str, shown: &str) {
    let shader = format!("{name}.comp");
    project.write(&format!("graphs/{name}.toml"), ECHO.replace("echo.comp", &shader));
    project.write(&format!("shaders/{shader}"), ECHO_SHADER.replace("SHOWN", shown));
}

/// A floor, a wall and a lamp.
fn yard(project: &Project) {
    let materials = "stone = { albedo = [0.5, 0.5, 0.5] }\nlamp = { albedo = [1.0, 0.9, 0.8], emission = 6.0 }";
    let build = [
        cuboid("stone", [-8, -1, -8], [32, 0, 32], ""),
        cuboid("stone", [0, 0, 0], [24, 9, 1], ""),
        cuboid("lamp", [4, 1, 4], [6, 2, 6], ""),
    ];
    world(project, materials, &build, [12.0, 9.0, 30.0], [12.0, 2.0, 8.0], 55.0);
}

fn judged(run: &Run, reason: &str) -> Vec<Value> {
    run.json().into_iter().filter(|value| value["reason"] == reason).collect()
}

#[test]
fn random_scenes_are_judged_by_one_command() {
    let project = Project::shipped();
    let quick = ["--size=32x18", "--frames=2", "--pan=2", "--lag=0", "--paths=16", "--format=json", "--validate"];
    let seed = ["bench", "light", "face_cache", "--seed=7", "--count=4", "-o", "out"];
    let run = project.raxel(&[&seed[..], &quick].concat()).exits(0);
    let rows = judged(&run, "judged");
    assert_eq!(rows.len(), 8);
    let scenes = ["room-7-0", "street-7-0", "cave-7-0", "land-7-0"];
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["scene"], scenes[i / 2]);
        assert_eq!(row["system"], ["reference_centre", "face_cache"][i % 2]);
        assert!(row["pan"]["error"].is_f64() && row["still"][0]["not_finite"] == 0, "{row:#}");
    }
    for reference in judged(&run, "reference") {
        let [mean, epsilon] = ["mean", "epsilon"].map(|key| reference[key].as_f64().unwrap());
        assert!(mean > 0.0, "{reference:#}");
        // Of one half and of the other, so nearly: the mean is that of both.
        assert!((epsilon / (mean / 3.0).powi(2) - 1.0).abs() < 1e-9, "{reference:#}");
    }
    // The figures over all of them are those of the rows.
    let figures = judged(&run, "over-random-scenes");
    assert_eq!(figures.len(), 2);
    let errors: Vec<f64> = rows
        .iter()
        .filter(|row| row["system"] == "face_cache")
        .map(|row| {
            let last = row["still"].as_array().unwrap().last().unwrap();
            last["error"].as_f64().unwrap().max(last["error_se"].as_f64().unwrap())
        })
        .collect();
    let error = &figures[1]["error"];
    assert_eq!((&figures[1]["system"], &error["scenes"]), (&"face_cache".into(), &4.into()));
    let worst = errors.iter().copied().fold(0.0, f64::max);
    assert!((error["worst"].as_f64().unwrap() / worst - 1.0).abs() < 1e-9);
    let mean = (errors.iter().map(|error| error.ln()).sum::<f64>() / 4.0).exp();
    assert!((error["mean"].as_f64().unwrap() / mean - 1.0).abs() < 1e-9);

    let json: Value = serde_json::from_slice(&std::fs::read(project.path("out/results.json")).unwrap()).unwrap();
    assert_eq!(json["over_random_scenes"].as_array().unwrap(), &figures);
    assert!(std::fs::read_to_string(project.path("out/results.csv")).unwrap().contains(",epsilon,"));
    // The printed scenes are those of the run, and a user can open them.
    let printed = project.raxel(&["bench", "light", "--seed=7", "--count=4", "--print-scenes"]).exits(0);
    for scene in scenes {
        let path = format!(".raxel/cache/light/worlds/{scene}.toml");
        let text = std::fs::read_to_string(project.path(&path)).unwrap();
        assert!(printed.stdout.contains(&text), "{scene}");
        project.raxel(&["check", "graphs/light/face_cache.toml", "--world", &path]).exits(0);
    }
}

/// Params move by their rate, and end where the references were made.
#[test]
fn what_moves_ends_where_the_reference_was_made() {
    let project = Project::shipped();
    yard(&project);
    echo(&project, "now", "azimuth / 360.0");
    echo(&project, "late", "before");
    let moving = |rate: f32| {
        let motion = Motion { camera: CameraMotion::By([0.0; 3]), params: vec![("sun_azimuth".to_owned(), rate)] };
        Scene { motion, set: vec![("sun_azimuth".to_owned(), "180".to_owned())], ..scene() }
    };
    let mut bench = Bench::new(Effort { pan: 3, ..effort(&project, [16, 9], 2, 16) });
    let references = bench.references(&moving(60.0)).unwrap();
    let mut run = |graph: &str, rate: f32| {
        let outcome = bench.system(graph, &moving(rate), &references).unwrap();
        let pan = outcome.pan.unwrap();
        assert!(pan.voxels.abs() < f64::EPSILON);
        (outcome.still.last().unwrap().judged.bias2, pan.judged.bias2)
    };
    let (still, now) = run("graphs/now.toml", 60.0);
    assert!((still - now).abs() < 1e-12, "{still} {now}");
    // A degree a frame at 60 degrees a second. A value that is a frame late is a degree behind, or ahead for a sun that goes back.
    let (settled, behind) = run("graphs/late.toml", 60.0);
    let (_, ahead) = run("graphs/late.toml", -60.0);
    assert!((settled - still).abs() < 1e-12, "{settled} {still}");
    assert!((behind - still) * (ahead - still) < 0.0, "{behind} {still} {ahead}");
    assert_eq!(bench.complaints(), &[] as &[String]);
}

/// Brute force averages until something moves: in motion, its last frame is as the first frame of a still camera. So the params that move instances
/// reach it, and end where they stand.
#[test]
fn instances_move_in_systems_that_lack_their_params() {
    let project = Project::shipped();
    yard(&project);
    let text = std::fs::read_to_string(project.path("worlds/test.toml")).unwrap();
    // The param has no default: a graph that binds instances needs it.
    let instance = r#"
[models]
thing = { file = "models/bird.vox" }
[[instances]]
model = "thing"
position = [12.0, 4.0, 12.0]
slide = { param = "glide", along = [1.0, 0.0, 0.0] }
"#;
    project.write("worlds/test.toml", text + instance);
    let command = |more: &[&str]| {
        let all = [
            "bench",
            "light",
            "graphs/light/reference_centre.toml",
            "--world=worlds/test.toml",
            "--size=32x18",
            "--frames=4",
        ];
        project.raxel(&[&all[..], &["--pan=4", "--paths=256", "--format=json"], more].concat())
    };
    let run = command(&["--move", "glide=120", "--set", "glide=3", "--move", "camera=0,0,0"]).exits(0);
    let [row] = &judged(&run, "judged")[..] else { panic!("{}", run.stdout) };
    let [first, last, moving] =
        [&row["still"][0], &row["still"][2], &row["pan"]].map(|at| at["error"].as_f64().unwrap());
    assert!((moving - first).abs() < 1e-9 && moving > 1.2 * last, "{row:#}");
    let still = command(&["--set", "glide=3", "--move", "camera=0,0,0"]).exits(0);
    let standing = judged(&still, "judged")[0]["pan"]["error"].as_f64().unwrap();
    assert!((standing - last).abs() < 1e-9, "{standing} {row:#}");
    // With the thing elsewhere, the light is another.
    let elsewhere = command(&["--set", "glide=-9"]).exits(0);
    let hash = |run: &Run| judged(run, "reference")[0]["hashes"].clone();
    assert_ne!(hash(&run), hash(&elsewhere));
    let unknown = command(&["--move", "glid=1"]).exits(2);
    assert!(unknown.stderr.contains("did you mean `glide`?"), "{}", unknown.stderr);
}

/// No voxel of a streamed world is in memory for long, so its reference is known by its files.
#[test]
fn streamed_worlds_have_references_of_their_own() {
    let project = Project::shipped();
    let text = |albedo: &str| {
        format!(
            r#"[stream]
near = 64
far = 64
gpu_memory = "16 MiB"
[camera]
position = [0.0, 40.0, 0.0]
pitch = -40.0
[materials]
earth = {{ albedo = "{albedo}" }}
[[build]]
op = "terrain"
amplitude = 20.0
layers = [{{ material = "earth" }}]
"#
        )
    };
    let run = |albedo: &str| {
        project.write("worlds/test.toml", text(albedo));
        let scene = Scene { epsilon: Epsilon::Mean, ..scene() };
        let mut bench = Bench::new(Effort { keep: true, pan: 2, ..effort(&project, [16, 9], 1, 16) });
        let references = bench.references(&scene).unwrap();
        let outcome = bench.system(REFERENCE, &scene, &references).unwrap();
        // The way is looked for in tiles that are made when they are asked for.
        assert!(outcome.pan.unwrap().voxels > 0.5);
        references.about
    };
    let (bright, again, dark) = (run("#ffffff"), run("#ffffff"), run("#404040"));
    assert!(!bright.kept && again.kept && !dark.kept);
    assert!(dark.mean < 0.9 * bright.mean, "{dark:?} {bright:?}");
}

const FLIGHT: &str = include_str!("fixtures/judge/flight.demo.toml");

#[test]
fn frames_of_a_film_are_compared_with_their_moments() {
    let project = Project::shipped();
    yard(&project);
    echo(&project, "now", "azimuth / 360.0");
    echo(&project, "late", "before");
    project.write("worlds/flight.demo.toml", FLIGHT);
    let film = |more: &[&str]| {
        let all = ["bench", "light", "--film=worlds/flight.demo.toml", "--every=0.25", "--size=64x36"];
        let run = project.raxel(&[&all[..], &["--settle=20", "--format=json", "--validate"], more].concat()).exits(0);
        judged(&run, "bench-light-film")
    };
    let films = film(&["graphs/now.toml", "graphs/late.toml", "-o", "out"]);
    let [now, late] = &films[..] else { panic!("{films:#?}") };
    let moments = |film: &Value| film["moments"].as_array().unwrap().clone();
    // Seconds 0.25, 0.5, 0.75: one a second would be at the end, where no frame is.
    assert_eq!(moments(now).iter().map(|moment| moment["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 4, 6]);
    for key in ["film", "stopped", "brightness"] {
        assert!(moments(now).iter().all(|moment| moment[key] == 0.0), "{now:#}");
    }
    // A frame late is too dark while the azimuth grows, and right after a stop.
    for moment in moments(late) {
        assert!(moment["film"].as_f64().unwrap() > 0.02 && moment["stopped"] == 0.0, "{moment:#}");
        assert!(moment["brightness"].as_f64().unwrap() < -0.02, "{moment:#}");
    }
    let csv = std::fs::read_to_string(project.path("out/film.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7, "{csv}");
    assert!(csv.starts_with("graph,second,frame,flip,flip_stopped,brightness"));
    // They are the pictures that `raxel render` makes.
    for (name, settle) in [("film.png", "0"), ("settled.png", "20")] {
        let all = ["render", "worlds/flight.demo.toml", "--at=0.5s", "--size=64x36", "--settle", settle, "-o", name];
        project.edit("worlds/flight.demo.toml", "now.toml", "late.toml");
        project.raxel(&all).exits(0);
        project.edit("worlds/flight.demo.toml", "late.toml", "now.toml");
    }
    let compared = project.raxel(&["compare", "settled.png", "film.png", "--format=json"]).exits(1).json();
    let [rendered, filmed] = [&compared[0]["flip"], &moments(late)[1]["film"]].map(|flip| flip.as_f64().unwrap());
    assert!((rendered - filmed).abs() < 1e-6, "{rendered} {filmed}");
}

#[test]
fn bad_input_is_told() {
    let project = Project::shipped();
    yard(&project);
    echo(&project, "now", "azimuth / 360.0");
    project.write("worlds/still.demo.toml", "world = \"test.toml\"\ngraph = \"now.toml\"\nduration = 4.0\n");
    project.write("worlds/flight.demo.toml", FLIGHT);
    project.write("worlds/broken.toml", "build = 3\n");
    for (arguments, code, said) in [
        (&["--seed=1", "--kinds=forest"][..], 2, "possible values: room, street, cave, land"),
        (&["--seed=1", "--count=0"], 2, "0 is not in 1..=10000"),
        (&["--seed=one"], 2, "invalid digit"),
        (&["--count=3"], 2, "--seed"),
        (&["--print-scenes"], 2, "--seed"),
        (&["--camera=1,2,3"], 2, "`--camera` and `--look-at` need `--world`"),
        (&["--world=worlds/missing.toml"], 3, "worlds/missing.toml"),
        (&["--world=worlds/broken.toml"], 3, "worlds/broken.toml:1:9"),
        (&["--world=worlds/test.toml", "--camera=tower"], 2, "has no camera `tower`"),
        (&["--set", "sun_azimuth"], 2, "has no `=`"),
        (&["--set", "sun_azimut=3"], 2, "did you mean `sun_azimuth`?"),
        (&["--move", "camera=1,2"], 2, "has not three numbers"),
        (&["--move", "sun_azimuth=fast"], 2, "`fast` is not a number"),
        (&["--move", "smooth=1"], 2, "`smooth` is not one number"),
        (&["--epsilon=0"], 2, "write `mean`, or a number above 0"),
        (&["--film=worlds/test.toml"], 2, "is no demo"),
        (&["--film=worlds/missing.demo.toml"], 3, "worlds/missing.demo.toml"),
        (&["--film=worlds/still.demo.toml"], 3, "no camera keys, tracks, inputs or edits"),
        (&["--film=worlds/flight.demo.toml"], 2, "no moment comes 1 s after its start"),
        (&["--film=worlds/flight.demo.toml", "--seed=1"], 2, "cannot be used with"),
        (&["--settle=3"], 2, "--film"),
    ] {
        let system = if arguments.iter().any(|argument| argument.starts_with("--film")) {
            "graphs/now.toml"
        } else {
            "face_cache"
        };
        let run = project.raxel(&[&["bench", "light", system], arguments].concat()).exits(code);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
    }
    // A value that does not fit is reported for the system that has the param.
    let wrong = [
        "bench",
        "light",
        "face_cache",
        "--world=worlds/test.toml",
        "--set=sun_azimuth=999",
        "--size=8x8",
        "--paths=16",
    ];
    let run = project.raxel(&wrong).exits(3);
    assert!(run.stderr.contains("`sun_azimuth` is 999; it must be in 0…360"), "{}", run.stderr);
}
