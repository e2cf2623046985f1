//! Instances in the graphs that people use: seen exactly, lit as their voxels would be if they were built in, and gone without a trace when they go.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use common::Project;
use raxel::world::{Material, World, vox};
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

/// An instance that moves hardly changes the light far from it. So faces there keep their samples, and take their turn as rarely as at rest.
#[test]
fn faces_far_from_a_mover_keep_their_light() {
    let project = Project::shipped();
    let graph = lifted(&project, "light/face_cache.toml", "tree", "");
    let listed = |z: f64, step: f32| {
        let files = "floor = { albedo = [0.6, 0.6, 0.55] }\n[models]\ntree = { file = \"models/tree.vox\" }";
        let tree = "[[instances]]\nmodel = \"tree\"\nposition = [12, 2, 12]\nslide = { param = \"away\", along = [0, 1000, 0] }\n";
        let build = [
            cuboid("floor", [0, 0, 0], [32, 2, 240], ""),
            cuboid("floor", [0, 2, 200], [32, 14, 201], ""),
            cuboid("floor", [0, 2, 1], [1, 14, 32], ""),
            tree.to_owned(),
        ];
        scenes::world(&project, files, &build, [28.0, 16.0, z + 16.0], [10.0, 4.0, z], 50.0);
        // A face with 8 samples knows its light too badly to wait for its turn.
        let mut session = open(&project, graph, SIZE, &[("error", 0.05)]);
        session.pin("queue").unwrap();
        let mut sum = 0;
        for frame in 0..64_u8 {
            session.set_param("away", Value::F32(step * f32::from(frame))).unwrap();
            frames(&mut session, 1);
            let bytes = session.read_buffer("queue", 0..4).unwrap();
            sum += if frame < 32 { 0 } else { u32::from_le_bytes(bytes.try_into().unwrap()) };
        }
        sum
    };
    // A tenth of a voxel in a frame.
    let [near, near_at_rest] = [1e-4, 0.0].map(|step| listed(12.0, step));
    let [far, far_at_rest] = [1e-4, 0.0].map(|step| listed(212.0, step));
    let counts = format!("{near} beside the mover, at rest {near_at_rest}; {far} far from it, at rest {far_at_rest}");
    assert!(near > 2 * near_at_rest && far < 3 * far_at_rest / 2, "{counts}");
}

/// Faces at the shadow of a mover forget as those beside it do, and no others.
#[test]
fn faces_at_the_shadow_of_a_mover_forget_sooner() {
    let project = Project::shipped();
    let graph = lifted(&project, "light/face_cache.toml", "tree", "");
    let late = |z: f64, strength: f32| {
        let files = "floor = { albedo = [0.6, 0.6, 0.55] }\n[models]\ntree = { file = \"models/tree.vox\" }";
        let tree = "[[instances]]\nmodel = \"tree\"\nposition = [12, 102, 180]\nslide = { param = \"away\", along = [0, 1000, 0] }\n";
        let build = [cuboid("floor", [0, 0, 0], [32, 2, 360], ""), tree.to_owned()];
        scenes::world(&project, files, &build, [28.0, 16.0, z + 16.0], [10.0, 2.0, z], 50.0);
        let sun = [("sun_elevation", 45.0), ("sun_azimuth", 0.0), ("sun_strength", strength)];
        let mut session = open(&project, graph, SIZE, &sun);
        session.pin("queue").unwrap();
        for frame in 0..8_u8 {
            session.set_param("away", Value::F32(1e-4 * f32::from(frame))).unwrap();
            frames(&mut session, 1);
        }
        let mut words = |from: u64, count: u64| {
            let bytes = session.read_buffer("queue", from..from + 4 * count).unwrap();
            bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect::<Vec<_>>()
        };
        let count = words(0, 1)[0];
        words(60, u64::from(count)).into_iter().filter(|entry| entry >> 28 & 1 != 0).count()
    };
    // 100 voxels above the floor, so the shadow is 100 voxels north or south of the mover.
    let counts = [80.0, 180.0, 280.0].map(|z| late(z, 5.0));
    assert!(
        counts[1] == 0 && (counts[0] > 0) != (counts[2] > 0),
        "late entries north of the mover, below it and south of it: {counts:?}"
    );
    assert_eq!([80.0, 280.0].map(|z| late(z, 0.0)), [0, 0], "there is no sun");
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
        // An instance far away, so that the same shaders run in all of these worlds.
        let away = "[[instances]]\nposition = [1000, 2, 10]\nmodel = \"tree\"\n";
        basin(&project, &format!("{models}{away}"), [16.0, 40.0, 27.0], [16.0, 4.0, 12.0]);
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

/// A block of one material as a model.
fn block(project: &Project, name: &str, size: [i32; 3], material: Material) {
    let [x, y, z] = size;
    let voxels = (0..x * y * z).map(|i| (glam::IVec3::new(i % x, i / x % y, i / (x * y)), 1));
    let world = World::from_voxels(vec![Material::air(), material], voxels);
    project.write(format!("worlds/models/{name}.vox").as_str(), vox::export(&world).unwrap());
}

/// A floor and a wall of glass of five voxels, and models: a red post and a pane of green glass.
fn glass_wall(project: &Project, models: &str) {
    block(project, "post", [3, 10, 3], Material::matt("red", [0.7, 0.1, 0.05]));
    let green = Material { roughness: 0.02, transparency: 0.9, ..Material::matt("green", [0.4, 0.9, 0.5]) };
    block(project, "pane", [14, 12, 3], green);
    let build =
        [cuboid("floor", [0, 0, 0], [40, 2, 40], ""), cuboid("glass", [2, 2, 18], [38, 18, 23], ""), models.to_owned()];
    let materials = "floor = { albedo = [0.6, 0.6, 0.55] }
glass = { albedo = [0.95, 0.8, 0.5], roughness = 0.02, transparency = 0.9 }
[models]
post = { file = \"models/post.vox\" }
pane = { file = \"models/pane.vox\" }";
    scenes::world(project, materials, &build, [20.2, 12.4, 46.3], [19.9, 6.1, 10.2], 50.0);
}

/// The kinds of models: as an instance, and in the world's voxels.
const KINDS: [&str; 2] = ["[[instances]]\nposition", "[[build]]\nop = \"model\"\norigin"];

/// Whether two texels have the same colours but for this part of them.
fn near(a: &[f32; 4], b: &[f32; 4], off: f32) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() <= off * b[c].abs() + 1e-4)
}

/// The target `gloss` of a graph after some frames.
fn gloss(project: &Project, graph: &str) -> Vec<[f32; 4]> {
    let mut session = open(project, graph, SIZE, &[("clouds", 0.0)]);
    session.pin("gloss").unwrap();
    frames(&mut session, 4);
    session.read_target("gloss").unwrap().floats()
}

/// Behind a pane of the world, in it and before it, an instance is seen as the same voxels would be.
#[test]
fn instances_are_seen_behind_panes_and_in_them() {
    let project = Project::shipped();
    for place in [[12, 2, 10], [20, 2, 20], [28, 2, 30]] {
        let [moving, built, empty] = [KINDS[0], KINDS[1], ""].map(|kind| {
            let model = if kind.is_empty() { String::new() } else { format!("{kind} = {place:?}\nmodel = \"post\"\n") };
            glass_wall(&project, &model);
            gloss(&project, "graphs/beauty_glass.toml")
        });
        let alike = moving.iter().zip(&built).filter(|(a, b)| near(a, b, 0.05)).count();
        let seen = moving.iter().zip(&empty).filter(|(a, b)| !near(a, b, 0.1)).count();
        eprintln!("{place:?}: {alike} of {} alike, {seen} other than without", moving.len());
        assert!(alike > moving.len() * 9 / 10 && seen > moving.len() / 50, "{place:?}: {alike} alike, {seen} seen");
    }
}

/// Clear voxels of an instance let light through as those of the world do: what is behind them, and sunlight with their colours.
#[test]
fn panes_of_instances_let_light_through() {
    let project = Project::shipped();
    let of = |kind: &str, graph: &str, target: &str| {
        glass_wall(&project, &format!("{kind} = [20, 2, 32]\nmodel = \"pane\"\n"));
        let sun = [("clouds", 0.0), ("sun_azimuth", 110.0), ("sun_elevation", 60.0)];
        let mut session = open(&project, graph, SIZE, &sun);
        session.pin(target).unwrap();
        frames(&mut session, 4);
        session.read_target(target).unwrap().floats()
    };
    for (graph, target) in [("beauty", "gloss"), ("beauty_glass", "gloss"), ("beauty_glass", "stained")] {
        let [moving, built] = KINDS.map(|kind| of(kind, &format!("graphs/{graph}.toml"), target));
        let off = error(&moving, &built);
        eprintln!("{graph}, {target}: {off} off");
        assert!(off < 0.1, "{graph}, {target}: {off} off");
        // Green light.
        let lit = moving.iter().filter(|texel| texel[1] > 1.2 * texel[0] && texel[1] > 0.02).count();
        assert!(graph == "beauty" || lit > 10, "{graph}, {target}: {lit} pixels have green light");
    }
}

/// The path tracer of glass shows panes of instances as those of the world, also where they are turned by a hair.
#[test]
fn the_tracer_of_glass_passes_panes_of_instances() {
    let project = Project::shipped();
    let light = |models: &str| {
        glass_wall(&project, models);
        frames(&mut open(&project, "graphs/light/views/glass.toml", SIZE, &[("sun_azimuth", 190.0)]), 48)
    };
    let built = light(&format!("{} = [20, 2, 32]\nmodel = \"pane\"\n", KINDS[1]));
    let empty = light("");
    for more in ["", "yaw = 0.01\n"] {
        let moving = light(&format!("{} = [20, 2, 32]\nmodel = \"pane\"\n{more}", KINDS[0]));
        let (off, without) = (error(&moving, &built), error(&empty, &built));
        eprintln!("{more:?}: {off} off, {without} without");
        assert!(off < 0.05 && without > 0.1, "{more:?}: {off} off, {without} without");
    }
}

/// A beam of the sun is bent by the surface of water, and so is the edge of a shadow on its bed: `beauty` has it where the path tracer has it.
#[test]
fn shadows_of_instances_go_on_below_the_surface_of_water() {
    let project = Project::shipped();
    block(&project, "board", [10, 1, 10], Material::matt("red", [0.7, 0.1, 0.05]));
    let light = |models: &str, graph: &str, target: &str, count: u32| {
        let build = [
            cuboid("wall", [0, 0, 0], [64, 14, 64], ""),
            cuboid("water", [2, 2, 2], [62, 12, 62], ""),
            "[[build]]\nop = \"box\"\nmode = \"subtract\"\nmin = [2, 12, 2]\nmax = [62, 14, 62]\n".to_owned(),
            models.to_owned(),
        ];
        let materials = "wall = { albedo = [0.6, 0.6, 0.6] }
water = { albedo = [0.9, 0.95, 0.97], roughness = 0.02, transparency = 0.95 }
[models]
board = { file = \"models/board.vox\" }";
        scenes::world(&project, materials, &build, [32.2, 52.4, 32.3], [32.1, 2.0, 32.0], 32.0);
        let params =
            [("clouds", 0.0), ("mist", 0.0), ("sky_strength", 0.1), ("sun_azimuth", 90.0), ("sun_elevation", 35.0)];
        let params: Vec<_> =
            params.into_iter().filter(|(name, _)| graph.contains("beauty") || name.starts_with('s')).collect();
        let mut session = open(&project, graph, SIZE, &params);
        session.pin(target).unwrap();
        frames(&mut session, count);
        session.read_target(target).unwrap().floats()
    };
    // An instance far away, so that the same shaders run.
    let away = format!("{} = [1000, 8, 32]\nmodel = \"board\"\n", KINDS[0]);
    let runs = [("graphs/beauty.toml", "average", 24), ("graphs/light/views/glass.toml", "radiance", 48)];
    let without = runs.map(|(graph, target, count)| light(&away, graph, target, count));
    // Above the water beside the view, and in the water.
    for place in [[55, 30, 32], [36, 8, 32]] {
        let model = format!("{} = {place:?}\nmodel = \"board\"\n", KINDS[0]);
        // Not the board itself, which has little blue.
        let dark = |a: &[f32; 4], b: &[f32; 4]| a[2] < 0.62 * b[2] && a[2] > 0.45 * a[0];
        let [found, truth] = [0, 1].map(|i| -> Vec<bool> {
            let (graph, target, count) = runs[i];
            let with = light(&model, graph, target, count);
            with.iter().zip(&without[i]).map(|(a, b)| dark(a, b)).collect()
        });
        let count = |of: &dyn Fn(bool, bool) -> bool| found.iter().zip(&truth).filter(|(a, b)| of(**a, **b)).count();
        let (both, either) = (count(&|a, b| a && b), count(&|a, b| a || b));
        eprintln!("{place:?}: {both} of {either}");
        assert!(
            both > 60 && 10 * both > 7 * either,
            "{place:?}: {both} of {either} pixels in either shadow are in both"
        );
    }
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
