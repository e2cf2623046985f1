//! The pieces that lighting systems share, `shaders/include/raxel/light` and `tone.glsl`. A compute shader tests the promises of each.

mod common;

use common::{Project, repository};
use raxel::{Options, Session, Validation};

/// The `count` floats that `tests/light_library/NAME.comp` has written to its buffer `results`.
fn results(name: &str, buffers: &str, passes: &str, count: usize) -> Vec<f32> {
    let world = r##"name = "one"
[materials.stone]
albedo = "#808080"
[[build]]
op = "box"
min = [0, 0, 0]
max = [1, 1, 1]
material = "stone"
"##;
    results_in(world, name, buffers, passes, count)
}

/// The same in a world of its own.
fn results_in(world: &str, name: &str, buffers: &str, passes: &str, count: usize) -> Vec<f32> {
    let project = Project::empty();
    let shader = std::fs::read(repository().join(format!("tests/light_library/{name}.comp"))).unwrap();
    project.write("worlds/one.toml", world).write("shaders/check.comp", shader).write(
        "graphs/check.toml",
        format!(
            r#"name = "check"
present = "results"
[buffers.results]
size = {{ count = {count}, stride = 4 }}
init = 0
{buffers}
{passes}"#
        ),
    );
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path("graphs/check.toml")),
        world: Some(project.path("worlds/one.toml")),
        size: [8, 8],
        validation: Validation::Required,
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{name}: {error}"));
    session.frame().unwrap_or_else(|error| panic!("{name}: {error}"));
    let bytes = session.read_buffer("results", 0..4 * count as u64).unwrap();
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{name}: {messages:#?}");
    bytes.chunks_exact(4).map(|word| f32::from_le_bytes(word.try_into().unwrap())).collect()
}

const ONE_PASS: &str =
    "[[passes]]\nname = \"check\"\nshader = \"check.comp\"\ndispatch = [1, 1, 1]\nbind = { Results = \"results\" }\n";

/// Slots of the table, and the define that asks for them.
const TABLES: [(u32, &str); 2] = [(1 << 20, ""), (1 << 19, ", RX_FACE_WHOLE = 1")];

#[test]
fn faces_find_their_slots_and_slots_their_faces() {
    for (slots, define) in TABLES {
        faces_in_a_table(slots, define);
    }
}

fn faces_in_a_table(slots: u32, define: &str) {
    let buffers = format!(
        r"[buffers.keys]
size = {{ count = {slots}, stride = 4 }}
init = 0
[buffers.met]
size = {{ count = {slots}, stride = 4 }}
init = 0
"
    );
    let pass = |name: &str, stage: u32| {
        format!(
            r#"[[passes]]
name = "{name}"
shader = "check.comp"
dispatch = {{ threads = [262144, 1, 1] }}
defines = {{ STAGE = {stage}{define} }}
bind = {{ FaceKeys = "keys", Met = "met", Results = "results" }}
"#
        )
    };
    let found = results("face_table", &buffers, &(pass("insert", 0) + &pass("look", 1)), 4);
    // Counts of wrong keys: they do not come back unchanged, have no slot, are not found, or share a slot.
    let words: Vec<u32> = found.iter().map(|number| number.to_bits()).collect();
    assert_eq!(words, [0, 0, 0, 0], "of 131,072 faces in {slots} slots, each inserted by two threads at once");
}

#[test]
fn tone_curves_are_monotonic_and_the_neutral_one_has_an_inverse() {
    let found = results("tone", "", ONE_PASS, 6);
    for (curve, name) in ["Narkowicz", "Reinhard", "AgX", "Neutral"].into_iter().enumerate() {
        assert!(found[curve] >= -1e-6, "{name} falls by {}", -found[curve]);
    }
    assert!(found[4] < 1e-6, "black becomes {}", found[4]);
    assert!(found[5] < 1e-4, "there and back differ by {}", found[5]);
}

#[test]
fn surfaces_are_reciprocal_and_keep_energy() {
    let found = results("bsdf", "", ONE_PASS, 5);
    assert!(found[0] < 1e-5, "GGX in both directions differs by {}", found[0]);
    assert!(found[1] < 1e-5, "rough matt surfaces in both directions differ by {}", found[1]);
    assert!(found[2] < 0.03, "a white rough metal in a white furnace is off by {}", found[2]);
    assert!(found[3] < 0.01, "a white rough matt surface in a white furnace is off by {}", found[3]);
    assert!(found[4] < 0.01, "two ways to integrate GGX differ by {}", found[4]);
}

#[test]
fn the_tables_of_the_air_are_read_where_they_are_written_and_phases_are_densities() {
    let found = results("atmosphere", "", ONE_PASS, 5);
    assert!(found[0] < 1e-3, "transmittance is off by {} of a table's side", found[0]);
    assert!(found[1] < 1e-3, "the sky is off by {} of a table's side", found[1]);
    assert!((found[2] - 1.0).abs() < 1e-3, "Rayleigh's phase adds up to {}", found[2]);
    assert!((found[3] - 1.0).abs() < 5e-3, "the phase of haze adds up to {}", found[3]);
    // Straight up through the air, in green light: what a clear day has.
    assert!((0.80..0.92).contains(&found[4]), "{}", found[4]);
}

#[test]
fn a_place_is_found_on_the_picture_before() {
    let found = results("reproject", "", ONE_PASS, 2);
    assert!(found[0] < 2e-3, "off by {} pixels", found[0]);
    assert!(found[1] == 0.0, "a place behind the camera is on its picture");
}

/// A pane of two voxels, two panes of other colours side by side, glass before a wall, and glass of 20 voxels; a long pane that a ray meets on a slant.
#[test]
fn rays_go_through_panes_and_take_their_colours() {
    let mut world = r#"name = "panes"
[materials]
red = { albedo = [0.5, 0.25, 0.25], transparency = 0.5 }
green = { albedo = [0.25, 0.5, 0.25], transparency = 1.0 }
stone = { albedo = [0.5, 0.5, 0.5] }
"#
    .to_owned();
    for (material, y, from, to) in [
        ("red", 0, 0, 2),
        ("red", 2, 0, 1),
        ("green", 2, 1, 3),
        ("red", 4, 0, 1),
        ("stone", 4, 1, 2),
        ("red", 6, 0, 20),
        ("red", -1, 0, 2),
    ] {
        world += &format!(
            "[[build]]\nop = \"box\"\nmin = [{from}, {y}, 0]\nmax = [{to}, {}, 1]\nmaterial = \"{material}\"\n",
            y + 1
        );
    }
    let pass = "[[passes]]\nname = \"check\"\nshader = \"check.comp\"\ndispatch = [1, 1, 1]\nbind = { Results = \"results\", world = \"world\" }\n";
    let found = results_in(&world, "body", "[buffers.world]\nsource = \"world.tree64\"\n", pass, 10);
    // The rest of a color behind `way` voxels: albedo to the power of the way times 0.4 for matt glass, 0.04 for clear.
    let left = |albedo: f32, transparency: f32, way: f32| albedo.powf(way * (0.4 + (0.04 - 0.4) * transparency));
    let slant = 1.01_f32.sqrt();
    let expected = [
        left(0.5, 0.5, 2.0),
        left(0.25, 0.5, 2.0),
        2.0,
        10.0 - 2.75,
        left(0.5, 0.5, 1.0) * left(0.25, 1.0, 2.0),
        left(0.25, 0.5, 1.0) * left(0.5, 1.0, 2.0),
        1.0,
        1.0,
        left(0.25, 0.5, 2.0 * slant),
        -0.5 + 0.1 * 5.5,
    ];
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < 1e-3, "{index}: {found} in place of {expected}");
    }
}
