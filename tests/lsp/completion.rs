//! Names and values of TOML files are offered and explained.

use std::path::Path;

use serde_json::json;

use crate::common::{Project, RunRaxel};
use crate::{Editor, NOTES, address, notes, place_of};

#[test]
fn names_are_completed_and_explained() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let graph = project.path("graphs/inspect.toml");
    editor.open(&graph, "");
    let text = include_str!("../fixtures/lsp/unfinished.toml");
    let has = |offered: &[String], wanted: &[&str]| {
        for name in wanted {
            assert!(offered.iter().any(|label| label == name), "{name} is not among {offered:?}");
        }
    };
    let offered = editor.offered(&graph, &format!("{text}bind = {{ out = \"|\" }}\n"));
    assert_eq!(offered, ["color", "list"]);
    let offered = editor.offered(&graph, &format!("{text}[passes.push]\nx = {{ type = \"f32\", from = \"|\" }}\n"));
    has(&offered, &["camera.cell", "frame.time", "param.sun"]);
    has(&editor.offered(&graph, &format!("{text}sha|")), &["shader", "dispatch", "bind", "when"]);
    has(
        &editor.offered(&graph, &format!("{text}shader = \"|\"")),
        &["inspect.comp", "primary.comp", "examples/mip_down.comp"],
    );
    has(&editor.offered(&graph, "[targets.a]\nfor|"), &["format", "size", "history"]);
    has(&editor.offered(&graph, "[targets.a]\nformat = \"|\""), &["rgba16f", "r32f"]);
    let sources = ["world.tree64", "world.instances", "input.keys", "world.edits", "model.tree.tree64"];
    has(&editor.offered(&graph, "[buffers.a]\nsource = \"|\""), &sources);
    let manifest = project.path("raxel.toml");
    std::fs::write(&manifest, "").unwrap();
    editor.open(&manifest, "");
    let offered = editor.offered(&manifest, "demo = \"|\"\n");
    assert!(offered.contains(&"valley.demo.toml".to_owned()) && !offered.contains(&"valley.toml".to_owned()));
    has(&editor.offered(&manifest, "wor|"), &["world", "graph", "size"]);
    // Of tables of several forms, those that are written.
    let demo = project.path("worlds/valley.demo.toml");
    editor.open(&demo, "");
    let offered = editor.offered(
        &demo,
        r#"[[edits]]
time = 1.0
op = "sphere"
|
mode = "subtract"
[[edits]]
op = "box"
"#,
    );
    assert_eq!(offered, ["center", "material", "mode", "op", "radius", "time"]);
    // A demo can show the targets of its graph, and of the graph that this one extends.
    let show = "graph = \"beauty.toml\"\n[[show]]\ntime = 1.0\ntarget = \"|\"\n";
    has(&editor.offered(&demo, show), &["bloom", "slot", "hit", "sky_view", "queue"]);
    let ops = ["box", "cylinder", "model", "restore", "set", "sphere"];
    assert_eq!(editor.offered(&demo, "[[edits]]\nop = \"|\"\n"), ops);
    let world = project.path("worlds/pool.toml");
    editor.open(&world, "");
    let offered = editor.offered(&world, "[[build]]\nop = \"cylinder\"\nra|");
    has(&offered, &["base", "radius", "top_radius", "axis"]);
    assert!(!offered.iter().any(|key| ["level", "layers", "center"].contains(&key.as_str())), "{offered:?}");
    let shader = project.path("shaders/inspect.comp");
    editor.open(&shader, "");
    has(&editor.offered(&shader, "void main() { rx_|"), &["rx_trace", "rx_camera_ray", "RxHit"]);
    for include in ["#include <|>", "#include \"|", "#include <raxel/wo|>"] {
        let offered = editor.offered(&shader, &format!("#version 460\n{include}\nvoid main() {{}}\n"));
        has(&offered, &["raxel/world.glsl", "examples/frame.glsl"]);
        assert!(!offered.iter().any(|name| name.starts_with("rx_") || name.starts_with("include/")), "{offered:?}");
    }
    let block = "layout(push_constant) uniform Push { float exposure; vec2 size; } push;\n";
    assert_eq!(editor.offered(&shader, &format!("{block}void main() {{ push.e|")), ["exposure", "size"]);

    let place = editor.place(&graph, "[targets.a]\nhist|ory = 1\n");
    let said = editor.ask("textDocument/hover", place);
    assert!(said["contents"]["value"].as_str().unwrap().starts_with("`history`: "), "{said}");
    let place = editor.place(&graph, "[[passes]]\naf|ter = \"color\"\n");
    let said = editor.ask("textDocument/hover", place);
    assert!(
        said["contents"]["value"].as_str().unwrap().contains("Not beside `before`: a pass has one place."),
        "{said}"
    );
    let place = editor.place(&graph, &format!("{text}bind = {{ out = \"col|or\" }}\n"));
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(found["range"]["start"]["line"], json!(3));
    let place = editor.place(&graph, &format!("{text}shader = \"inspe|ct.comp\"\n"));
    assert_eq!(editor.ask("textDocument/definition", place)["uri"], json!(address(&shader)));
}

#[test]
fn names_of_the_base_are_known_in_a_graph_that_extends_it() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, base) = (project.path("graphs/mine.toml"), project.path("graphs/inspect.toml"));
    std::fs::write(&graph, "").unwrap();
    editor.open(&graph, "");
    let head = "extends = \"inspect.toml\"\n[params.gain]\ntype = \"f32\"\ndefault = 1.0\n";
    let pass = format!("{head}[[passes]]\nname = \"inspect\"\n");
    let mut has = |text: &str, wanted: &[&str], none: &[&str]| {
        let offered = editor.offered(&graph, text);
        assert!(wanted.iter().all(|name| offered.iter().any(|label| label == name)), "{text}: {offered:?}");
        assert!(!none.iter().any(|name| offered.iter().any(|label| label == name)), "{text}: {offered:?}");
    };
    has(&format!("{head}present = \"|\""), &["depth", "normal", "world"], &[]);
    has(&format!("{pass}bind = {{ outDepth = \"|\" }}\n"), &["depth", "steps"], &["outDepth"]);
    has(&format!("{head}[[passes]]\nname = \"b\"\nafter = \"|\""), &["inspect", "b"], &[]);
    // Short forms: the value of a member is what it comes from, and names are those of the shader.
    let values = ["camera.fov", "param.gain", "param.sky_depth", "target.depth.size", "buffer.world.count"];
    has(&format!("{pass}push = {{ sky_depth = \"|\" }}\n"), &values, &[]);
    has(&format!("{pass}[passes.push]\nsky_depth = \"|\""), &values, &[]);
    has(&format!("{pass}push = {{ | }}\n"), &["sky_depth", "camera_cell"], &["outHit", "name"]);
    has(&format!("{pass}[passes.push]\ncam|"), &["sky_depth", "camera_cell"], &["from", "outHit"]);
    has(&format!("{pass}bind = {{ | }}\n"), &["outHit", "outSteps"], &["push", "name"]);
    has(&format!("{head}[blocks.Push]\n|"), &["sky_depth", "tan_half_fov"], &["name"]);
    has(&format!("{head}[targets.|"), &["depth", "normal"], &["gain"]);
    has(&format!("{pass}[passes.|"), &["push", "bind", "uniforms"], &["targets"]);

    let place = editor.place(&graph, &format!("{head}present = \"dep|th\"\n"));
    let said = editor.ask("textDocument/hover", place.clone());
    let said = said["contents"]["value"].as_str().unwrap();
    assert!(said.contains("[targets.depth]") && said.contains("`graphs/inspect.toml`"), "{said}");
    let lines = std::fs::read_to_string(&base).unwrap();
    let line = lines.lines().position(|line| line == "[targets.depth]").unwrap() as u64;
    assert_eq!(place_of(&editor.ask("textDocument/definition", place)), (address(&base).as_str(), line));
    // A binding leads to the shader.
    let shader = project.path("shaders/inspect.comp");
    let text = std::fs::read_to_string(&shader).unwrap();
    let line = text.lines().position(|line| line.contains("image2D outDepth;")).unwrap() as u64;
    let place = editor.place(&graph, &format!("{pass}bind = {{ outDep|th = \"depth\" }}\n"));
    assert_eq!(place_of(&editor.ask("textDocument/definition", place)), (address(&shader).as_str(), line));

    let demo = project.path("worlds/mine.demo.toml");
    std::fs::write(&demo, "").unwrap();
    editor.open(&demo, "");
    let head = r#"world = "valley.toml"
graph = "mine.toml"
[[edits]]
time = 1.0
op = "set"
"#;
    let offered = editor.offered(&demo, &format!("{head}material = \"|\"\n"));
    assert!(offered.contains(&"grass".to_owned()) && offered.contains(&"sand".to_owned()), "{offered:?}");
    assert_eq!(editor.offered(&demo, &format!("{head}[tracks.]\n|")), ["interpolation", "keys"]);
    std::fs::write(&graph, "extends = \"inspect.toml\"\n[params.gain]\n").unwrap();
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": address(&graph) } }));
    assert_eq!(editor.offered(&demo, &format!("{head}[tracks.|]\n")), ["gain", "sky_depth"]);
}

#[test]
fn values_of_keys_are_completed_and_explained() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, demo) = (project.path("graphs/mine.toml"), project.path("worlds/mine.demo.toml"));
    for path in [&graph, &demo] {
        std::fs::write(path, "").unwrap();
        editor.open(path, "");
    }
    let head = "world = \"valley.toml\"\ngraph = \"inspect.toml\"\n";
    for keys in ["keys = [[0.0, [\"|\"]]]\n", "keys = [\n    # held\n    [0.0, [\"|\"]],\n]\n"] {
        let offered = editor.offered(&demo, &format!("{head}[inputs]\n{keys}"));
        assert!(
            offered.len() > 100 && ["KeyW", "ArrowLeft"].iter().all(|key| offered.iter().any(|label| label == key))
        );
    }
    let offered = editor.offered(&demo, &format!("{head}[inputs]\nbuttons = [[0.0, [\"|\"]]]\n"));
    assert_eq!(offered, ["left", "right", "middle", "back", "forward"]);
    let offered =
        editor.offered(&demo, &format!("{head}[inputs]\ngamepad_buttons = [[0.0, [\"left_stick\", \"|\"]]]\n"));
    assert!(offered.iter().any(|label| label == "south"), "{offered:?}");
    // The keys of a track are no inputs.
    let offered = editor.offered(&demo, &format!("{head}[tracks.sky_depth]\nkeys = [[0.0, \"|\"]]\n"));
    assert_eq!(offered, [""; 0]);

    let mut hover = |path: &Path, text: &str| {
        let place = editor.place(path, text);
        let said = editor.ask("textDocument/hover", place);
        said["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    for (text, meaning) in [
        ("[targets.a]\nformat = \"rgba|16f\"\n", "`rgba16f`: channels: 4, read as floats; bytes of a texel: 8"),
        ("[buffers.a]\nsource = \"world.tr|ee64\"\n", "`world.tree64`: supplied by the session"),
        ("[targets.a.display]\nmap = \"tur|bo\"\n", "`turbo`: One channel through the Turbo colour map."),
        ("[targets.a]\ndisplay = \"i|d\"\n", "`id`: A hash of the integer channels as colour."),
        (
            "[[passes]]\nname = \"a\"\nwhen = \"!world.has_em|ission\"\n",
            "`world.has_emission`: `bool`. Holds if a voxel of the world",
        ),
        (
            "[[passes]]\nname = \"a\"\nwhen = \"device.pac|kets\"\n",
            "`device.packets`: `bool`. Holds if `<raxel/packet.glsl>`",
        ),
        (
            "[buffers.a]\nwhen = \"world.has_inst|ances\"\n",
            "`world.has_instances`: `bool`. Holds if the world has instances.",
        ),
        ("[[passes]]\nname = \"a\"\nwhen = \"alw|ays\"\n", "`always`: Takes the condition of the base away."),
        ("[params.fog]\ntype = \"bool\"\n[[passes]]\nname = \"a\"\nwhen = \"!param.fo|g\"\n", "type = \"bool\""),
    ] {
        let said = hover(&graph, text);
        assert!(said.contains(meaning), "{text}: {said}");
    }
    for (text, meaning) in [
        ("[[edits]]\nop = \"sp|here\"\n", "`sphere`: A ball."),
        ("[inputs]\nkeys = [[0.0, [\"Key|W\"]]]\n", "`keys`: Keys that are held from then on"),
        ("[tracks.sky_|depth]\n", "[params.sky_depth]"),
    ] {
        let said = hover(&demo, &format!("{head}{text}"));
        assert!(said.contains(meaning), "{text}: {said}");
    }
    let place = editor.place(&demo, &format!("{head}[tracks.sky_|depth]\n"));
    let found = editor.ask("textDocument/definition", place);
    assert_eq!(place_of(&found).0, address(&project.path("graphs/inspect.toml")), "{found}");
}

/// What is offered as a source or to be copied can be written there: the graph has no mistake.
#[test]
fn what_supplies_a_resource_is_offered_where_it_fits() {
    let (project, mut editor, graph, _) = notes();
    project.copy_folder("textures");
    project.copy_folder("worlds/models");
    project.write("textures/table.bin", "table");
    let world = "[models.pine]\nfile = \"models/pine.vox\"\n[[build]]\nop = \"model\"\nmodel = \"pine\"\n";
    project.write("worlds/trees.toml", world);
    let mut resources = String::new();
    for (table, key, offers, hides) in [
        (
            "targets",
            "source",
            &["world.texture3d", "input.microphone", "file.textures/notes.ogg", "model.pine.texture3d"][..],
            &["world.tree64", "input.keys", "file.textures/table.bin"][..],
        ),
        (
            "targets",
            "copy",
            &["world.texture3d", "model.pine.texture3d"],
            &["world.tree64", "input.microphone", "file.textures/tiles.png"],
        ),
        (
            "buffers",
            "source",
            &["world.tree64", "world.edits", "input.keys", "file.textures/table.bin"],
            &["input.microphone"],
        ),
        (
            "buffers",
            "copy",
            &["world.tree64", "model.pine.octree"],
            &["world.edits", "world.poses", "input.microphone", "file.textures/table.bin"],
        ),
    ] {
        let offered = editor.offered(&graph, &format!("{NOTES}[{table}.a]\n{key} = \"|\""));
        let has = |name: &&str| offered.iter().any(|label| label == name);
        assert!(offers.iter().all(has) && !hides.iter().any(has), "{key} of {table}: {offered:?}");
        for (index, source) in offered.iter().enumerate() {
            resources += &format!("[{table}.{key}{index}_{table}]\n{key} = {source:?}\n");
        }
    }
    project.write("graphs/note.toml", NOTES.replace("[[passes]]", &format!("{resources}[[passes]]")));
    project.raxel(&["check", "graphs/note.toml"]).exits(0);
}
