//! Instances in the graphs that people use: seen exactly, lit as their voxels would be if they were built in, and gone without a trace when they go.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use common::Project;
use raxel::{DebugTarget, Options, Session, Validation, Value};
use scenes::{cuboid, frames, open};

const SIZE: [u32; 2] = [64, 36];

/// A floor with two walls, and what stands on it: models in the world's voxels, or instances.
fn yard(project: &Project, models: &str) {
    let build = [
        cuboid("floor", [0, 0, 0], [32, 2, 32], ""),
        cuboid("floor", [0, 2, 0], [32, 14, 1], ""),
        cuboid("wall", [0, 2, 1], [1, 14, 32], ""),
        models.to_owned(),
    ];
    let files = "[models]\ntree = { file = \"models/tree.vox\" }\nlantern = { file = \"models/lantern_warm.vox\" }";
    let materials = format!("floor = {{ albedo = [0.6, 0.6, 0.55] }}\nwall = {{ albedo = [0.7, 0.2, 0.1] }}\n{files}");
    scenes::world(project, &materials, &build, [28.0, 16.0, 28.0], [10.0, 4.0, 10.0], 50.0);
}

/// Trees, turned by quarter turns, where `instances` says in either way.
fn trees(instances: bool) -> String {
    let one = |x: i32, z: i32, turn: i32| {
        if instances {
            format!("[[instances]]\nmodel = \"tree\"\nposition = [{x}, 2, {z}]\nyaw = {turn}\n")
        } else {
            format!("[[build]]\nop = \"model\"\nmodel = \"tree\"\norigin = [{x}, 2, {z}]\nrotation = {turn}\n")
        }
    };
    [one(8, 8, 0), one(18, 9, 90), one(9, 20, 180)].concat()
}

/// An instance that the param `away` lifts out of sight, in a graph over another that has the param.
fn lifted(project: &Project, base: &str, model: &str, more: &str) -> &'static str {
    let slide = "slide = { param = \"away\", along = [0, 1000, 0] }";
    yard(project, &format!("[[instances]]\nmodel = \"{model}\"\nposition = [12, 2, 12]\n{slide}\n{more}"));
    project.write(
        "graphs/test.toml",
        format!(
            r#"extends = "{base}"
name = "test"
[params.away]
type = "f32"
default = 0.0
range = [0.0, 1.0]
"#
        ),
    );
    "graphs/test.toml"
}

/// Mean luminance of each of 4 × 3 parts of a picture.
fn parts(texels: &[[f32; 4]]) -> [f64; 12] {
    let (width, height) = (SIZE[0] as usize, SIZE[1] as usize);
    let mut sums = [0.0; 12];
    for (index, texel) in texels.iter().enumerate() {
        let part = (index / width) * 3 / height * 4 + (index % width) * 4 / width;
        sums[part] += (f64::from(texel[0]) + f64::from(texel[1]) + f64::from(texel[2])) / 3.0;
    }
    sums.map(|sum| sum * 12.0 / (width * height) as f64)
}

/// The largest relative error of a part.
fn error(of: &[[f32; 4]], truth: &[[f32; 4]]) -> f64 {
    let parts = parts(of).into_iter().zip(parts(truth));
    parts.map(|(a, b)| (a - b).abs() / b.max(1e-3)).fold(0.0, f64::max)
}

/// The first hits of `graph`: their depths.
fn depths(project: &Project, graph: &str) -> Vec<[f32; 4]> {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path("worlds/test.toml")),
        size: SIZE,
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap();
    assert_eq!(session.warnings(), []);
    session.pin("depth").unwrap();
    session.set_debug_target(DebugTarget::resource("depth")).unwrap();
    session.frame().unwrap();
    assert_eq!(session.device().log().take(), []);
    session.read_texels("depth", 0, 0, 0).unwrap().floats()
}

#[test]
fn instances_on_the_lattice_are_seen_as_if_they_were_built_in() {
    let project = Project::shipped();
    for graph in ["graphs/primary.toml", "graphs/inspect.toml"] {
        let [moving, built, empty] = [trees(true), trees(false), String::new()].map(|models| {
            yard(&project, &models);
            depths(&project, graph)
        });
        assert!(moving == built, "{graph}");
        assert!(moving != empty, "{graph}");
    }
}

/// On models that are not turned, the same numbers draw the same paths: the reference gives the very same light.
#[test]
fn the_reference_lights_instances_as_if_they_were_built_in() {
    let project = Project::shipped();
    let [moving, built, empty] = [trees(true), trees(false), String::new()].map(|models| {
        let straight = ["yaw", "rotation"].map(|key| [90, 180].map(|turn| format!("{key} = {turn}\n"))).concat();
        yard(&project, &straight.iter().fold(models, |models, turn| models.replace(turn, "")));
        frames(&mut open(&project, "graphs/light/reference_centre.toml", SIZE, &[]), 2)
    });
    assert!(moving == built);
    assert!(moving != empty);
}

/// No lamp is drawn on an instance, so rays that meet it count in full.
#[test]
fn lamps_give_the_same_light_as_instances() {
    let project = Project::shipped();
    let [moving, built] = ["[[instances]]\nposition", "[[build]]\nop = \"model\"\norigin"].map(|kind| {
        yard(&project, &format!("{kind} = [12, 2, 12]\nmodel = \"lantern\"\n"));
        let mut session = open(&project, "graphs/light/reference_centre.toml", SIZE, &scenes::DARK);
        session.set_param("paths", Value::I32(16)).unwrap();
        frames(&mut session, 24)
    });
    let lit: f64 = parts(&built).iter().sum();
    assert!(lit > 0.01, "{lit}");
    let mean = parts(&moving).iter().sum::<f64>() / lit;
    assert!((mean - 1.0).abs() < 0.05, "{mean}");
}

/// Turned in any way, and with a lamp among them.
#[test]
fn face_cache_lights_instances_as_the_reference_does() {
    let project = Project::shipped();
    let turned = "[[instances]]\nmodel = \"tree\"\nposition = [9.3, 2.2, 9.1]\nyaw = 31\nroll = 8\n";
    yard(&project, &(trees(true).replace("[8, 2, 8]", "[22, 2, 4]") + turned));
    let truth = {
        let mut session = open(&project, "graphs/light/reference_centre.toml", SIZE, &[]);
        session.set_param("paths", Value::I32(16)).unwrap();
        frames(&mut session, 12)
    };
    let cached = frames(&mut open(&project, "graphs/light/face_cache.toml", SIZE, &[]), 160);
    let off = error(&cached, &truth);
    assert!(off < 0.05, "{off}");
}

/// Lamps on instances are drawn as those of the world are: the same light, with as little noise, and none behind a wall.
#[test]
fn lamps_on_instances_have_no_more_noise_than_built_ones() {
    let project = Project::shipped();
    let graph = "graphs/light/face_cache.toml";
    let light = |models: &str, graph: &str, count: u32| {
        yard(&project, models);
        let mut session = open(&project, graph, SIZE, &scenes::DARK);
        if graph.contains("reference") {
            session.set_param("paths", Value::I32(16)).unwrap();
        }
        frames(&mut session, count)
    };
    let [moving, built] = ["[[instances]]\nposition", "[[build]]\nop = \"model\"\norigin"]
        .map(|kind| format!("{kind} = [12, 2, 12]\nmodel = \"lantern\"\n"));
    let truth = light(&built, "graphs/light/reference_centre.toml", 96);
    let square = |of: &[[f32; 4]]| {
        let off = of.iter().zip(&truth).map(|(a, b)| f64::from(a[0] - b[0]).powi(2) / (f64::from(b[0]).powi(2) + 1e-6));
        off.sum::<f64>() / truth.len() as f64
    };
    let [moving, built] = [moving, built].map(|models| light(&models, graph, 16));
    eprintln!(
        "worst part {} of an instance, {} built in; relMSE {} and {}",
        error(&moving, &truth),
        error(&built, &truth),
        square(&moving),
        square(&built)
    );
    assert!(error(&moving, &truth) < 0.06, "{}", error(&moving, &truth));
    assert!(square(&moving) < 1.5 * square(&built), "{} of an instance, {} built in", square(&moving), square(&built));

    // Turned in any way, it gives the same light.
    let turned = "[[instances]]\nposition = [12.3, 2.4, 12.2]\nyaw = 31\nroll = 8\nmodel = \"lantern\"\n";
    let (found, truth) = (light(turned, graph, 48), light(turned, "graphs/light/reference_centre.toml", 96));
    assert!(error(&found, &truth) < 0.06, "{}", error(&found, &truth));

    // A lantern in a wall.
    let hidden = "[[instances]]\nposition = [12, 5, 0]\nmodel = \"lantern\"\n";
    let dark = light(hidden, graph, 4);
    assert!(dark.iter().all(|texel| texel[..3] == [0.0; 3]));
}

/// A lantern that is carried away leaves no light after ten frames, and one that comes lights at once.
#[test]
fn a_lantern_that_goes_takes_its_light_along() {
    let project = Project::shipped();
    let graph = lifted(&project, "light/face_cache.toml", "lantern", "");
    let mut session = open(&project, graph, SIZE, &scenes::DARK);
    let mean = |texels: &[[f32; 4]]| parts(texels).iter().sum::<f64>();
    let here = mean(&frames(&mut session, 48));
    session.set_param("away", Value::F32(1.0)).unwrap();
    let left = mean(&frames(&mut session, 10)) / here;
    assert!(left < 0.05, "{left} of the light is left");
    session.set_param("away", Value::F32(0.0)).unwrap();
    let back = mean(&frames(&mut session, 10)) / here;
    assert!((back - 1.0).abs() < 0.1, "{back} of the light is back");
}

#[test]
fn what_goes_leaves_no_light_and_no_shadow() {
    let project = Project::shipped();
    for (model, params) in [("tree", &[][..]), ("lantern", &scenes::DARK[..])] {
        let graph = lifted(&project, "light/face_cache.toml", model, "");
        let mut session = open(&project, graph, SIZE, params);
        let here = frames(&mut session, 48);
        session.set_param("away", Value::F32(1.0)).unwrap();
        let gone = frames(&mut session, 192);
        let mut without = open(&project, graph, SIZE, &[params, &[("away", 1.0)]].concat());
        let truth = frames(&mut without, 192);
        let apart = |of: &[[f32; 4]]| -> f64 {
            parts(of).into_iter().zip(parts(&truth)).map(|(a, b)| (a - b).abs()).sum::<f64>()
        };
        let (before, after) = (apart(&here), apart(&gone));
        assert!(before > 0.0 && after < 0.1 * before, "{model}: {after} of {before}");
    }
}

/// A basin of water with a model in it, in the world's voxels or as an instance.
fn basin(project: &Project, model: &str, position: [f64; 3], look_at: [f64; 3]) {
    let build = [
        cuboid("wall", [0, 0, 0], [32, 26, 32], ""),
        cuboid("water", [2, 2, 2], [30, 24, 30], ""),
        "[[build]]\nop = \"box\"\nmode = \"subtract\"\nmin = [2, 24, 2]\nmax = [30, 26, 30]\n".to_owned(),
        model.to_owned(),
    ];
    let materials = "wall = { albedo = [0.6, 0.6, 0.6] }
water = { albedo = [0.5, 0.8, 0.9], roughness = 0.02, transparency = 0.9 }
[models]
tree = { file = \"models/tree.vox\" }";
    scenes::world(project, materials, &build, position, look_at, 60.0);
}

/// An instance under water is where the same voxels would be, seen from above.
#[test]
fn instances_are_seen_through_water() {
    let project = Project::shipped();
    let gloss = |models: &str| {
        basin(&project, models, [16.0, 40.0, 27.0], [16.0, 4.0, 12.0]);
        let mut session = open(&project, "graphs/beauty.toml", SIZE, &[("clouds", 0.0)]);
        session.pin("gloss").unwrap();
        frames(&mut session, 4);
        session.read_target("gloss").unwrap().floats()
    };
    let [moving, built] = ["[[instances]]\nposition", "[[build]]\nop = \"model\"\norigin"]
        .map(|kind| gloss(&format!("{kind} = [12, 2, 10]\nmodel = \"tree\"\n")));
    let empty = gloss("");
    let near = |a: &[f32; 4], b: &[f32; 4], off: f32| (0..3).all(|c| (a[c] - b[c]).abs() <= off * b[c].abs() + 1e-4);
    let alike = moving.iter().zip(&built).filter(|(a, b)| near(a, b, 0.02)).count();
    let seen = moving.iter().zip(&empty).filter(|(a, b)| !near(a, b, 0.1)).count();
    assert!(alike > moving.len() * 9 / 10 && seen > moving.len() / 20, "{alike} alike, {seen} other than without");
}

/// The path tracer of glass and water shows instances in water as it shows the same voxels.
#[test]
fn the_tracer_of_glass_shows_instances_in_water() {
    let project = Project::shipped();
    let kinds = ["[[instances]]\nposition", "[[build]]\nop = \"model\"\norigin"];
    let light = |models: &str| {
        basin(&project, models, [16.0, 40.0, 27.0], [16.0, 4.0, 12.0]);
        frames(&mut open(&project, "graphs/light/views/glass.toml", SIZE, &[]), 24)
    };
    let [moving, built] = kinds.map(|kind| light(&format!("{kind} = [12, 2, 10]\nmodel = \"tree\"\n")));
    let empty = light("");
    eprintln!("{} off, {} without", error(&moving, &built), error(&empty, &built));
    assert!(
        error(&moving, &built) < 0.05 && error(&empty, &built) > 0.1,
        "{} {}",
        error(&moving, &built),
        error(&empty, &built)
    );
}

/// A world without instances runs no pass and binds no buffer for them.
#[test]
fn worlds_without_instances_pay_nothing() {
    let project = Project::shipped();
    for graph in ["graphs/primary.toml", "graphs/inspect.toml", "graphs/light/reference.toml", "graphs/beauty.toml"] {
        for (models, pays) in [(trees(false), false), (trees(true), true)] {
            yard(&project, &models);
            let session = Session::open(Options {
                project: Some(project.root().into()),
                graph: Some(project.path(graph)),
                world: Some(project.path("worlds/test.toml")),
                size: SIZE,
                validation: Validation::Required,
                ..Options::default()
            })
            .unwrap();
            assert_eq!(session.warnings(), [], "{graph}");
            let plan = session.plan().unwrap();
            let bound = |pass: &raxel_graph::checked::Pass| {
                pass.accesses.iter().any(|access| {
                    let name = &plan.graph.resource(access.resource).name;
                    ["instances", "poses"].contains(&name.as_str())
                })
            };
            assert_eq!(
                plan.graph.passes.iter().enumerate().any(|(at, pass)| {
                    plan.passes.iter().any(|planned| planned.pass.0 as usize == at) && bound(pass)
                }),
                pays,
                "{graph}"
            );
        }
    }
}

/// RX0449.
#[test]
fn a_graph_that_leaves_instances_out_says_so() {
    let project = Project::shipped();
    yard(&project, &trees(true));
    let session = open(&project, &common::graph_in(common::LIGHT, "hash_cache"), SIZE, &[]);
    let codes: Vec<&str> = session.warnings().iter().map(|warning| warning.code.as_str()).collect();
    assert_eq!(codes, ["RX0449"]);
    yard(&project, &trees(false));
    let session = open(&project, &common::graph_in(common::LIGHT, "hash_cache"), SIZE, &[]);
    assert_eq!(session.warnings(), []);
}
