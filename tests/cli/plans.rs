//! Plans, schemas and shaders are printed.

use crate::common::{Project, RunRaxel, raxel};

#[test]
fn plans_are_printed_in_every_form() {
    let text = raxel(&["graph", "graphs/primary.toml"]).exits(0);
    assert!(text.stdout.contains("primary"));
    let dot = raxel(&["graph", "graphs/primary.toml", "--format", "dot"]).exits(0);
    assert!(dot.stdout.starts_with("digraph"), "{}", dot.stdout);
    let mermaid = raxel(&["graph", "graphs/primary.toml", "--format", "mermaid"]).exits(0);
    assert!(mermaid.stdout.contains("flowchart") || mermaid.stdout.contains("graph "), "{}", mermaid.stdout);
    let json = raxel(&["graph", "graphs/primary.toml", "--format", "json", "--size", "64x32"]).exits(0);
    let plan: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert!(plan.is_object());
    raxel(&["graph", "graphs/none.toml"]).exits(3);
}

/// A target over the bounds of the world, a material of it, and a pass that only worlds with lamps have.
const OVER_A_WORLD: &str = include_str!("../fixtures/cli/over.toml");

/// A box of 64 x 16 x 6 voxels of one material.
fn box_of(material: &str, emission: f32) -> String {
    format!(
        r##"[materials]
{material} = {{ albedo = "#808080", emission = {emission:?} }}
[[build]]
op = "box"
min = [0, 0, 0]
size = [64, 16, 6]
material = "{material}"
"##
    )
}

#[test]
fn plans_without_a_device_follow_the_world() {
    let project = Project::empty();
    project.write("graphs/over.toml", OVER_A_WORLD).write(
        "shaders/fill.comp",
        r"#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(r32ui) writeonly uniform uimage3D field;
layout(push_constant) uniform Push { uint stone; };
void main() { imageStore(field, ivec3(gl_GlobalInvocationID), uvec4(stone)); }
",
    );
    // Without any world there is a stand-in, and both verbs name it.
    let run = project.raxel(&["check", "graphs/over.toml"]).exits(0);
    assert!(run.stderr.contains("ok (planned over a world of 256 x 256 x 256 voxels"), "{}", run.stderr);
    let run = project.raxel(&["graph", "graphs/over.toml"]).exits(0);
    assert!(run.stdout.contains("128×128×128") || run.stdout.contains("128x128x128"), "{}", run.stdout);
    assert!(run.stderr.contains("--world"), "{}", run.stderr);

    // The only world of the project is its default.
    project.write("worlds/box.toml", box_of("stone", 0.0));
    let run = project.raxel(&["check", "graphs/over.toml"]).exits(0);
    assert!(run.stderr.contains("ok (planned over `worlds/box.toml`; --world"), "{}", run.stderr);
    let passes = |arguments: &[&str]| {
        let run = project.raxel(&[&["graph", "graphs/over.toml", "--format", "json"], arguments].concat()).exits(0);
        let plan: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        (plan["passes"].as_array().unwrap().len(), run)
    };
    let (count, run) = passes(&[]);
    assert!(
        run.stdout.contains("[32,8,3]") || run.stdout.replace([' ', '\n'], "").contains("[32,8,3]"),
        "{}",
        run.stdout
    );
    assert_eq!(count, 1, "nothing glows in it");

    // Another one is named.
    project.write("worlds/lamps.toml", box_of("stone", 4.0)).write("worlds/sand.toml", box_of("sand", 0.0));
    let (count, run) = passes(&["--world", "worlds/lamps.toml"]);
    assert_eq!((count, run.stderr.as_str()), (2, ""));
    let run = project.raxel(&["check", "graphs/over.toml", "--world", "worlds/sand.toml"]).exits(3);
    assert!(run.stdout.contains("RX0") && run.stdout.contains("the world has no material `stone`"), "{}", run.stdout);
    project.raxel(&["graph", "graphs/over.toml", "--world", "worlds/sand.toml"]).exits(3);
    project.raxel(&["check", "graphs/over.toml", "--world", "worlds/none.toml"]).exits(3);
    let line =
        &project.raxel(&["check", "graphs/over.toml", "--world=worlds/lamps.toml", "--format=json"]).exits(0).json()[0];
    assert_eq!(line["world"], "worlds/lamps.toml");
}

/// A graph is wrong over a world whose file lacks something that the graph wants, even without a device.
#[test]
fn models_and_moved_instances_are_looked_for_in_the_world() {
    let over = |graph: &str, world: &str| raxel(&["check", graph, "--world", world]);
    let run = over("graphs/examples/model.toml", "worlds/menger.toml").exits(3);
    assert!(run.stdout.contains("there is no model `pine` in `worlds/menger.toml`"), "{}", run.stdout);
    raxel(&["graph", "graphs/examples/model.toml", "--world", "worlds/menger.toml"]).exits(3);
    // A graph may be meant for another world than the one that is taken where none is named.
    let project = Project::shipped();
    let graph = std::fs::read_to_string(project.path("graphs/examples/model.toml")).unwrap();
    project.write("graphs/examples/model.toml", graph.replace("model.pine.", "model.rook."));
    project.raxel(&["check", "graphs/examples/model.toml"]).exits(0);
    // Without defaults, the graph must have the params that move its instances.
    let project = Project::shipped();
    let fair = std::fs::read_to_string(project.path("worlds/fair.toml")).unwrap();
    project.write("worlds/fair.toml", fair.replace(", default = 0.0", ""));
    project.raxel(&["check", "graphs/examples/instances.toml", "--world", "worlds/fair.toml"]).exits(0);
    let run = project.raxel(&["check", "graphs/examples/flock.toml", "--world", "worlds/fair.toml"]).exits(3);
    assert!(run.stdout.contains("are moved by `carousel`, which is not a param of the graph"), "{}", run.stdout);
}

#[test]
fn schemas_are_json_and_a_new_project_has_them() {
    for kind in ["graph", "world", "demo", "project"] {
        let schema: serde_json::Value = serde_json::from_str(&raxel(&["schema", kind]).exits(0).stdout).unwrap();
        assert_eq!(schema["type"], "object", "{kind}");
    }
}

#[test]
fn shaders_are_written_as_modules() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    raxel(&["shaders", "graphs/primary.toml", "-o", out]).exits(0);
    let module = std::fs::read(folder.path().join("primary.primary.spv")).unwrap();
    assert_eq!(module[..4], [3, 2, 0x23, 7]);
}
