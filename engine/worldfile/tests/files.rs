//! World files: their contents, and everything that can be wrong with them.

mod project;

use std::collections::BTreeSet;

use project::{MATERIALS, Project};
use proptest::prelude::*;
use raxel_diagnostics::{Diagnostic, Severity};
use raxel_layouts::instances::Pose;
use raxel_world::{Material, World, srgb_from_linear, vox};
use raxel_worldfile::{Aim, schema};
use serde_json::Value;

/// One line a diagnostic: severity, code, place as line and text, message, help.
fn lines(text: &str, found: &[Diagnostic]) -> String {
    let line = |d: &Diagnostic| {
        let place = d.labels.first().map(|label| {
            let range = label.span.range.clone();
            format!(" {}: `{}`", text[..range.start].matches('\n').count() + 1, &text[range])
        });
        let kind = if d.severity == Severity::Error { "" } else { "warning " };
        let first = format!("{kind}{}{} {}", d.code, place.unwrap_or_default(), d.message);
        let lines: Vec<&str> = std::iter::once(first.as_str()).chain(d.help.iter().map(String::as_str)).collect();
        lines.join("\n    ")
    };
    found.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn errors(text: &str) -> String {
    let found = Project::with_world(text).load().expect_err(text);
    assert!(found.iter().any(Diagnostic::is_error));
    lines(text, &found)
}

#[test]
fn a_world_says_what_it_is() {
    let text = include_str!("fixtures/files/hall.toml");
    let (loaded, warnings) = Project::with_world(text).load().expect("it is right");
    assert_eq!(warnings, []);
    assert_eq!((loaded.name.as_str(), loaded.about.as_deref()), ("hall", Some("a hall")));
    assert_eq!(loaded.files, ["worlds/test.toml", "worlds/models/arrow.vox"]);
    let camera = loaded.camera.expect("it has one");
    assert_eq!((camera.position, camera.fov), ([1.0, 2.5, 3.0], Some(70.0)));
    assert_eq!(camera.aim, Aim::Angles { yaw: 90.0, pitch: 0.0 });
    let materials = loaded.world.materials();
    let names: Vec<_> = materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["air", "wall", "arrow.red", "arrow.lit"], "a model's materials come once");
    let wall = [(0xff, 0), (0x80, 1), (0, 2)].map(|(byte, i)| (byte, srgb_from_linear(materials[1].albedo[i])));
    assert!(wall.iter().all(|(written, read)| written == read), "{wall:?}");
    assert!((materials[3].emission - 2.5).abs() < 1e-6);
    assert!(loaded.world.has_emission());
    assert!(!loaded.world.has_transparency(), "no voxel is made of `wall`");
}

#[test]
fn every_mistake_at_once() {
    let text = include_str!("fixtures/files/mistakes.toml");
    insta::assert_snapshot!(errors(text));
}

#[test]
fn too_much_is_an_error_before_anything_is_built() {
    let cases = [
        "[[build]]\nop = \"box\"\nmaterial = \"a\"\nmin = [-2147483648, -2147483648, -2147483648]\nmax = [2147483648, 2147483648, 2147483648]",
        "[[build]]\nop = \"box\"\nmaterial = \"a\"\nmin = [2147483640, 0, 0]\nsize = [9, 1, 1]",
        "[[build]]\nop = \"sphere\"\nmaterial = \"a\"\ncenter = [0, 0, 0]\nradius = 1e9",
        "[[build]]\nop = \"menger\"\nmaterial = \"a\"\nlevel = 12",
        "[[build]]\nop = \"terrain\"\nmin = [0, 0]\nsize = [100000, 100000]\namplitude = 300\nlayers = [{ material = \"a\" }]",
        "[[build]]\nop = \"terrain\"\nmin = [2000000000, 0]\nsize = [64, 64]\namplitude = 30\nfrequency = 0.5\nlayers = [{ material = \"a\" }]",
        "[[build]]\nop = \"maze\"\nmaterial = \"a\"\ncells = [1000, 1000]\ncell = 4000",
        "[[build]]\nop = \"model\"\nmodel = \"arrow\"\norigin = [2147483647, 0, 0]",
        "[[build]]\nop = \"scatter\"\nmodel = \"arrow\"\ncenter = [0, 0]\nsize = [1000000, 1000000]\ndensity = 0.5",
    ];
    let found: Vec<String> = cases.iter().map(|case| errors(&format!("{MATERIALS}{case}"))).collect();
    insta::assert_snapshot!(found.join("\n"));
}

#[test]
fn a_broken_model_is_named_where_it_is_declared() {
    let text = format!("{MATERIALS}[[build]]\nop = \"model\"\nmodel = \"arrow\"");
    let mut project = Project::with_world(&text);
    project.0.insert("worlds/models/arrow.vox".to_owned(), b"VOX \x96\0\0\0MAI".to_vec());
    let found = project.load().expect_err("a broken model");
    insta::assert_snapshot!(lines(&text, &found));
}

#[test]
fn warnings_come_with_the_world() {
    let text = format!(
        r#"{MATERIALS}[[build]]
op = "box"
material = "a"
min = [0, 0, 0]
size = [20, 1, 20]
[[build]]
op = "scatter"
model = "arrow"
min = [0, 0]
size = [20, 20]
count = 50
min_spacing = 12"#
    );
    let (loaded, found) = Project::with_world(&text).load().expect("a world");
    assert!(loaded.world.solids() > 400);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].code.as_str(), found[0].severity), ("RX0310", Severity::Warning));
    let (_, found) = Project::with_world("name = \"nothing\"").load().expect("an empty world");
    assert_eq!(found[0].code.as_str(), "RX0311");
}

#[test]
fn no_text_makes_the_reader_panic() {
    for text in [
        "",
        "\0",
        "build = 3",
        "[[build]]",
        "build = [1, [], {}]",
        "materials = []\nmodels = 3\ncamera = 1",
        "[materials]\na = 1\n[models]\nb = 2",
    ] {
        let _ = Project::with_world(text).load();
    }
    let mut project = Project::with_world("");
    project.0.insert("worlds/test.toml".to_owned(), vec![0xff, 0xfe, 0]);
    assert_eq!(project.load().expect_err("not UTF-8")[0].code.as_str(), "RX0003");
}

/// Keys that the reader asks for, from its help about a key that is unlike all of them.
fn keys_read(text: &str) -> BTreeSet<String> {
    let found = Project::with_world(text).load().expect_err(text);
    let unknown = found.iter().find(|d| d.message.contains("zzzzzzzzzzzz")).expect("the key is unknown");
    let known = unknown.help[0].strip_prefix("known keys: ").expect("no key is close");
    known.split(", ").map(|key| key.trim_matches('`').to_owned()).collect()
}

#[test]
fn cameras_have_names_and_keep_the_order_of_the_file() {
    let text =
        "[cameras.up]\nposition = [1, 2, 3]\npitch = 90\n[cameras.aside]\nposition = [4, 5, 6]\nlook_at = [0, 0, 0]\n";
    let (loaded, _) = Project::with_world(text).load().expect("it is right");
    let names: Vec<&str> = loaded.cameras.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((names, loaded.camera), (vec!["up", "aside"], None));
    assert_eq!(loaded.cameras[1].1.aim, Aim::LookAt([0.0; 3]));
    // A name that `--camera` would take for a position, and a camera that is wrong itself.
    let found = errors("[cameras.\"1,2,3\"]\nposition = [1, 2, 3]\n[cameras.b]\nposition = [1, 2]\n");
    assert!(found.contains("RX0014 1: `\"1,2,3\"` a camera cannot be called `1,2,3`"), "{found}");
    assert!(found.contains("4: `[1, 2]`"), "{found}");
}

#[test]
fn a_camera_looks_somewhere() {
    let camera = |look_at: &str| format!("[cameras.a]\nposition = [1.5, 2.0, -3.25]\nlook_at = {look_at}\n");
    assert!(Project::with_world(&camera("[1.5, 2.0, -3.0]")).load().is_ok());
    let found = errors(&camera("[1.5, 2, -3.25]"));
    assert!(found.contains("RX0014 3: `[1.5, 2, -3.25]` `cameras.a.look_at` is where the camera is"), "{found}");
}

#[test]
fn walls_of_a_maze_are_no_wider_than_its_cells() {
    let maze = |sizes: &str| {
        format!(
            r##"[materials.a]
albedo = "#808080"
[[build]]
op = "maze"
material = "a"
cells = [3, 3]
{sizes}
"##
        )
    };
    assert!(Project::with_world(&maze("cell = 3\nwall = 3")).load().is_ok());
    let found = errors(&maze("cell = 3\nwall = 4"));
    assert!(found.contains("`build[0].wall` is 4, wider than the maze's `cell`, which is 3"), "{found}");
    // The cell that is meant where the file says nothing.
    assert!(errors(&maze("wall = 5")).contains("which is 4"));
}

#[test]
fn instances_stand_where_the_file_says() {
    let text = format!(
        r#"{MATERIALS}[[instances]]
name = "a"
model = "arrow"
position = [1, 2, 3]
yaw = 90
[[instances]]
model = "arrow"
position = [1, 2, 3]
anchor = "origin"
turn = {{ param = "spin", about = [0.5, 0.0, 0.5] }}
slide = {{ param = "lift", along = [0, 2, 0] }}
"#
    );
    let (loaded, found) = Project::with_world(&text).load().expect("it is right");
    assert_eq!(found[0].code.as_str(), "RX0311", "instances are not voxels of the world");
    let instances = &loaded.instances;
    assert_eq!((instances.models.len(), instances.list.len()), (1, 2));
    // Their materials are behind the world's own, by the name of the model.
    let names: Vec<&str> = loaded.world.materials().iter().map(|material| material.name.as_str()).collect();
    assert!(names[4].starts_with("arrow.") && names.len() == 6, "{names:?}");
    assert_eq!(*instances.models[0].materials, [0, 4, 5]);
    // The centre of its lowest layer, x from 3 to 9 and z from 1 to 3; turned to the left, +X goes to −Z.
    assert_eq!((instances.list[0].anchor, instances.list[1].anchor), ([6, 0, 2], [0, 0, 0]));
    let frames = instances.frames(|_| None);
    assert_eq!(frames[0].place([3, 0, 0]), Some([1, 2, 0]));
    // First turned about the axis, then moved.
    let moved = instances.frames(|param| Some(if param == "spin" { 180.0 } else { 5.0 }));
    assert_eq!(moved[0], frames[0]);
    assert_eq!(moved[1].place([1, 0, 0]), Some([-2, 12, -3]));
}

#[test]
fn a_grid_of_instances_is_numbered_along_x_first() {
    let text = format!(
        r#"{MATERIALS}[[instances]]
model = "arrow"
position = [5, 0, 0]
[[instances]]
name = "a"
model = "arrow"
position = [1, 2, 3]
yaw = 90
count = [2, 3, 4]
step = [10, 0.5, -100]
[[instances]]
model = "arrow"
position = [7, 8, 9]
count = [2, 1, 1]
"#
    );
    let (loaded, _) = Project::with_world(&text).load().expect("it is right");
    let list = &loaded.instances.list;
    assert_eq!((list.len(), loaded.instances.models.len()), (1 + 24 + 2, 1));
    let named: Vec<usize> = (0..list.len()).filter(|&i| list[i].name.is_some()).collect();
    assert_eq!(named, [1]);
    for i in 0..24_u8 {
        let steps = [i % 2, i / 2 % 3, i / 6].map(f64::from);
        let position = [1.0 + 10.0 * steps[0], 2.0 + 0.5 * steps[1], 3.0 - 100.0 * steps[2]];
        let of = &list[1 + usize::from(i)];
        assert_eq!(of.pose, Pose { position, ..Pose::new([0.0; 3], [90.0, 0.0, 0.0]) });
    }
    assert_eq!(list[25].pose, list[26].pose);
}

#[test]
fn what_is_wrong_with_instances_is_said() {
    let one = "[[instances]]\nmodel = \"arrow\"\n";
    let cases = [
        (format!("{one}position = [0, 0, 2e9]"), "RX0014"),
        (format!("{one}position = [0, 0, 0]\nname = \"a\"\n{one}position = [0, 0, 0]\nname = \"a\""), "RX0448"),
        (format!("{one}position = [0, 0, 0]\n").repeat(16_385), "RX0445"),
        (format!("{one}position = [0, 0, 0]\ncount = [128, 1, 128]\n{one}position = [0, 0, 0]"), "RX0445"),
        (format!("{one}position = [0, 0, 0]\ncount = [16384, 16384, 16384]"), "RX0445"),
        (format!("{one}position = [0, 0, 0]\ncount = [0, 1, 1]"), "RX0014"),
        (format!("{one}position = [0, 0, 0]\ncount = [2000, 1, 1]\nstep = [-1e6, 0, 0]"), "RX0446"),
        ("[[instances]]\nmodel = \"arow\"\nposition = [0, 0, 0]".to_owned(), "RX0302"),
        (format!("{one}position = [0, 0]"), "RX0014"),
        (format!("{one}position = [0, 0, 0]\nturn = {{ param = \"a\", axis = \"w\" }}"), "RX0014"),
        (format!("{one}position = [0, 0, 0]\nslide = {{ param = \"a\" }}"), "RX0013"),
    ];
    for (case, code) in cases {
        let text = format!("{MATERIALS}{case}");
        let found = Project::with_world(&text).load().expect_err(code);
        assert!(found.iter().any(|d| d.code.as_str() == code), "{code}: {found:?}");
    }
}

#[test]
fn a_model_of_an_instance_must_be_in_reach() {
    // One voxel far from the origin of its file, by the key `anchor` far from where it stands.
    let far =
        World::from_voxels(vec![Material::air(), Material::matt("m", [0.5; 3])], [(glam::IVec3::new(70_000, 0, 0), 1)]);
    let text = format!("{MATERIALS}[[instances]]\nmodel = \"arrow\"\nanchor = \"origin\"\nposition = [0, 0, 0]\n");
    let mut project = Project::with_world(&text);
    project.0.insert("worlds/models/arrow.vox".to_owned(), vox::export(&far).expect("one voxel"));
    let found = project.load().expect_err("it is too far away");
    assert_eq!(found[0].code.as_str(), "RX0446", "{found:?}");
}

fn keys_in(schema: &Value) -> BTreeSet<String> {
    schema["properties"].as_object().expect("an object").keys().cloned().collect()
}

/// A declaration with a function for its shape and one for its reader has its keys in two places.
#[test]
fn the_schema_has_exactly_the_keys_that_are_read() {
    let schema = schema();
    let odd = "zzzzzzzzzzzz = 1";
    for (at, text) in [
        ("", String::new()),
        ("/properties/cameras/additionalProperties", "[cameras.a]\n".to_owned()),
        ("/properties/materials/additionalProperties", "[materials.m]\n".to_owned()),
        ("/properties/models/additionalProperties", "[models.m]\n".to_owned()),
        ("/properties/instances/items", "[[instances]]\n".to_owned()),
    ] {
        assert_eq!(keys_read(&format!("{text}{odd}")), keys_in(schema.pointer(at).expect(at)), "{at}");
    }
    let operations = schema["properties"]["build"]["items"]["oneOf"].as_array().expect("operations");
    assert_eq!(operations.len(), 8);
    let word = |operation: &Value| operation["properties"]["op"]["const"].as_str().expect("a word").to_owned();
    for operation in operations {
        let op = word(operation);
        assert_eq!(keys_read(&format!("[[build]]\nop = \"{op}\"\n{odd}")), keys_in(operation), "{op}");
    }
    let layer = format!("[[build]]\nop = \"terrain\"\nlayers = [{{ {odd} }}]");
    assert_eq!(keys_read(&layer), keys_in(&operations[5]["properties"]["layers"]["items"]));
    let unknown = errors("[[build]]\nop = \"zzzzzzzzzzzz\"");
    let words: Vec<_> = operations.iter().map(|operation| format!("`{}`", word(operation))).collect();
    assert!(unknown.ends_with(&format!("one of: {}", words.join(", "))), "{unknown}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn no_edit_makes_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), "[ -/:-~]|\\PC", any::<bool>()), 1..6)) {
        let mut text: Vec<char> = format!("{MATERIALS}{EVERYTHING}").chars().collect();
        for (at, new, replace) in edits {
            let at = at.index(text.len());
            text.splice(at..at + usize::from(replace), new.chars());
        }
        let text: String = text.into_iter().collect();
        match Project::with_world(&text).load() {
            Ok((loaded, _)) => prop_assert_eq!(loaded.world.voxels().count() as u64, loaded.world.solids()),
            // Every place is in the text, on whole characters.
            Err(found) => drop(lines(&text, &found)),
        }
    }
}

/// One of each operation, all small.
const EVERYTHING: &str = include_str!("fixtures/files/everything.toml");
