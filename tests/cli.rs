//! The command line as its users and their scripts see it: exit codes, stdout and stderr, JSON, bad files.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::{Project, Run, output, raxel};

#[test]
fn help_version_and_wrong_use() {
    let help = raxel(&["--help"]).exits(0);
    for verb in [
        "run", "render", "check", "graph", "list", "world", "shaders", "new", "init", "schema", "bench", "stress",
        "doctor", "explain", "clean",
    ] {
        assert!(help.stdout.contains(&format!("\n  {verb} ")), "help names {verb}");
    }
    for more in ["--help", "-h"] {
        assert_eq!(raxel(&["help", more]).exits(0).stdout, raxel(&["help"]).exits(0).stdout);
        assert_eq!(raxel(&["help", "world", more]).exits(0).stdout, raxel(&["help", "world"]).exits(0).stdout);
    }
    assert!(raxel(&["--version"]).exits(0).stdout.starts_with("raxel "));
    raxel(&[]).exits(2);
    assert!(raxel(&["chekc"]).exits(2).stderr.contains("check"), "a verb is suggested");
    raxel(&["render", "--size", "0x10", "-o", "a.png"]).exits(2);
    raxel(&["render", "--size", "ten", "-o", "a.png"]).exits(2);
}

#[test]
fn a_shader_is_no_graph_and_that_is_said_once() {
    let project = Project::shipped();
    for verb in [&["check"][..], &["graph"], &["render", "-o", "a.png"]] {
        let run = project.raxel(&[verb, &["shaders/primary.comp"]].concat()).exits(3);
        let said = run.stdout + &run.stderr;
        assert_eq!(said.matches("error").count() - said.matches("1 error").count(), 1, "{said}");
        assert!(said.contains("`shaders/primary.comp` is a shader, and a graph is needed"), "{said}");
        assert!(said.contains("name a graph that has `shader = \"primary.comp\"` in a pass"), "{said}");
    }
}

#[test]
fn two_outputs_of_a_command_have_two_names() {
    let project = Project::shipped();
    let run = project.raxel(&["render", "graphs/primary.toml", "--trace", "a.png", "-o", "./a.png"]).exits(2);
    assert!(run.stderr.contains("raxel is writing another file there"), "{}", run.stderr);
    // That of the refused command.
    assert!(std::fs::read_to_string(project.path("a.png")).unwrap().contains("traceEvents"));
}

#[test]
fn explain_prints_pages_and_suggests() {
    assert!(raxel(&["explain", "rx11"]).exits(0).stdout.starts_with("# RX0011: unknown key"));
    assert!(raxel(&["explain"]).exits(0).stdout.contains("RX0011  unknown key\n"));
    let wrong = raxel(&["explain", "RX9911"]).exits(2);
    assert!(wrong.stdout.is_empty() && wrong.stderr.contains("did you mean `RX"));
}

/// A key that stood elsewhere before is refused, with its present place.
#[test]
fn what_has_moved_is_named_with_its_new_place() {
    let project = Project::shipped();
    let moved = [
        ("graphs/naive.toml", "graphs/rivals/naive.toml"),
        ("graphs/light/ddgi.toml", "graphs/rivals/light/ddgi.toml"),
        ("graphs/light/views/lum_live.toml", "graphs/rivals/light/views/lum_live.toml"),
        ("graphs/bench/dda.toml", "graphs/rivals/march/dda.toml"),
    ];
    for (old, new) in moved {
        let run = project.raxel(&["check", old]).exits(3);
        assert!(run.stdout.contains(&format!("did you mean `{new}`?")), "{}", run.stdout);
    }
    // The name alone is enough to be found.
    let run = project.raxel(&["render", "primary.toml", "-o", "a.png"]).exits(3);
    assert!(run.stderr.contains("did you mean `graphs/primary.toml`?"), "{}", run.stderr);
    for (verb, old, new) in [("bench", moved[3].0, moved[3].1), ("light", moved[1].0, moved[1].1)] {
        let verbs: &[&str] = if verb == "light" { &["bench", "light"] } else { &["bench"] };
        let run = project.raxel(&[verbs, &[old]].concat()).exits(3);
        assert!(run.stderr.contains(&format!("did you mean `{new}`?")), "{}", run.stderr);
    }
    for (nearly, whole) in [
        ("primry.toml", "graphs/primary.toml"),
        ("graphs/primary", "graphs/primary.toml"),
        ("primary", "graphs/primary.toml"),
        ("worlds/vallye.toml", "worlds/valley.toml"),
    ] {
        let run = project.raxel(&["check", nearly]).exits(3);
        assert!(run.stdout.contains(&format!("did you mean `{whole}`?")), "{nearly}: {}", run.stdout);
    }
    let run = project.raxel(&["shaders", "--library", "raxel/tree64.glsl"]).exits(2);
    assert!(run.stderr.contains("did you mean `raxel/internal/layouts/tree64.glsl`?"), "{}", run.stderr);

    project.edit("graphs/inspect.toml", "\"inspect.comp\"", "\"naive.comp\"");
    let run = project.raxel(&["check", "graphs/inspect.toml"]).exits(3);
    assert!(run.stdout.contains("did you mean `rivals/naive.comp`?"), "{}", run.stdout);
    project.edit("shaders/bench/first_hit.comp", "#include <raxel/rivals/march.glsl>", "#include <raxel/march.glsl>");
    let run = project.raxel(&["check", "graphs/bench/first_hit.toml"]).exits(3);
    assert!(run.stdout.contains("did you mean `<raxel/rivals/march.glsl>`?"), "{}", run.stdout);
}

#[test]
fn completions_name_the_verbs() {
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(raxel(&["completions", shell]).exits(0).stdout.contains("render"), "{shell}");
    }
}

#[test]
fn shipped_graphs_pass_the_check_and_say_so_in_json() {
    let run = raxel(&["check", "graphs/primary.toml", "graphs/inspect.toml", "--format", "json"]).exits(0);
    let summaries: Vec<_> = run.json();
    assert_eq!(summaries.len(), 2);
    for (summary, file) in summaries.iter().zip(["graphs/primary.toml", "graphs/inspect.toml"]) {
        assert_eq!(summary["reason"], "checked");
        assert_eq!(summary["file"], file);
        assert_eq!(summary["kind"], "graph");
        assert_eq!(summary["errors"], 0);
    }
}

const HEAVY_GRAPH: &str = include_str!("fixtures/cli/heavy.toml");
const HEAVY_SHADER: &str = include_str!("fixtures/cli/heavy.comp");

#[test]
fn needs_that_many_devices_do_not_meet_are_warnings() {
    let project = Project::empty();
    project.write("graphs/heavy.toml", HEAVY_GRAPH).write("shaders/heavy.comp", HEAVY_SHADER);
    let run = project.raxel(&["check", "graphs/heavy.toml"]).exits(0);
    let warning = |message: &str, label: &str, note: &str| {
        format!(
            "warning[RX0163]: {message}\n --> graphs/heavy.toml:8:8\n  |\n8 | name = \"heavy\"\n  |        ^^^^^^^ {label}\n  |\n{note}\
             help: `raxel doctor --graph` compares the graph with a device\n"
        )
    };
    let limit = |name: &str| format!("  = note: the limit is `{name}`\n");
    let threads = "pass `heavy` needs 512 workgroup threads, and many devices have 256";
    let shared = "pass `heavy` needs 20000 shared bytes, and many devices have 16384";
    let int64 = "pass `heavy` needs `Int64`, which not every device has";
    let expected = [
        warning(threads, "this pass", &limit("maxComputeWorkGroupInvocations")),
        warning(shared, "this pass", &limit("maxComputeSharedMemorySize")),
        warning(int64, "declared by the compiled shader", ""),
    ];
    assert_eq!(run.stdout.trim_end(), expected.join("\n").trim_end());
    // The pass runs only where there are 64-bit integers.
    project.write("graphs/heavy.toml", HEAVY_GRAPH.replace("shader =", "when = \"device.packets\"\nshader ="));
    let run = project.raxel(&["check", "graphs/heavy.toml"]).exits(0);
    assert!(run.stdout.contains(threads) && !run.stdout.contains("Int64"), "{}", run.stdout);
    // The pass for all other devices is looked at, too.
    project.write("graphs/heavy.toml", HEAVY_GRAPH.replace("shader =", "when = \"!device.packets\"\nshader ="));
    let run = project.raxel(&["check", "graphs/heavy.toml"]).exits(0);
    assert!(run.stdout.contains(threads) && run.stdout.contains("Int64"), "{}", run.stdout);
}

#[test]
fn a_large_world_is_checked_without_being_built() {
    let project = Project::shipped();
    let terrain = std::fs::read_to_string(project.path("worlds/terrain.toml")).unwrap();
    project.write("worlds/wide.toml", terrain.replace("[1024, 1024]", "[65536, 1024]").replace("[-1024,", "[0,"));
    let run = project.raxel(&["check", "worlds/wide.toml"]).exits(0);
    assert!(run.stderr.contains("chunks were not built"), "{}", run.stderr);
    // Graphs are planned over the box that it reaches over.
    let run = project.raxel(&["check", "graphs/primary.toml", "--world", "worlds/wide.toml"]).exits(0);
    assert!(run.stderr.contains("graphs/primary.toml: ok"), "{}", run.stderr);
    // A mistake that the file alone shows is still found.
    project.edit("worlds/wide.toml", "octaves   = 7", "octaves   = 7000");
    project.raxel(&["check", "worlds/wide.toml"]).exits(3);
    // A world of the usual size is built.
    let run = project.raxel(&["check", "worlds/menger.toml", "--format", "json"]).exits(0).json();
    let summary = run.last().unwrap().as_object().unwrap();
    assert!(summary.values().all(|value| !value.is_null()), "a fact that does not apply is left out: {summary:?}");
}

#[test]
fn a_mistake_that_files_share_is_told_once() {
    let project = Project::shipped();
    project.edit("graphs/primary.toml", "present ", "presnt ");
    let files = ["check", "graphs/primary.toml", "graphs/rivals/primary_chunks.toml", "worlds/valley.demo.toml"];
    let run = project.raxel(&files).exits(3);
    assert_eq!(run.stdout.matches("no key `presnt`").count(), 1, "{}", run.stdout);
    assert!(run.stderr.contains("graphs/rivals/primary_chunks.toml: 1 error, shown above"), "{}", run.stderr);
    assert!(run.stderr.contains("worlds/valley.demo.toml: 1 error, shown above"), "{}", run.stderr);
    // A program asks for the mistakes of each file.
    let run = project.raxel(&[&files[..], &["--format", "json"]].concat()).exits(3);
    assert_eq!(run.stdout.matches("\"code\":\"RX0011\"").count(), 3, "{}", run.stdout);
}

#[test]
fn all_mistakes_are_reported_at_once_with_their_places() {
    let project = Project::shipped();
    project
        .edit("graphs/primary.toml", "outColor = \"color\"", "outColor = \"colour\"")
        .edit("graphs/primary.toml", "[params.exposure]\ntype ", "[params.exposure]\ntyp ")
        .edit("graphs/primary.toml", "exposure      = { type = \"f32\"", "exposure      = { type = \"i32\"");
    let run = project.raxel(&["check", "graphs/primary.toml"]).exits(3);
    for part in
        ["error[RX", "--> graphs/primary.toml:", "colour", "did you mean `color`?", "`typ`", "shaders/primary.comp"]
    {
        assert!(run.stdout.contains(part), "{part:?} is not in\n{}", run.stdout);
    }
    let short = project.raxel(&["check", "graphs/primary.toml", "--format", "short"]).exits(3);
    for line in short.stdout.lines() {
        let mut parts = line.splitn(4, ':');
        assert!(parts.next().unwrap().contains("primary.toml"), "{line}");
        assert!(parts.next().unwrap().parse::<u32>().is_ok() && parts.next().unwrap().parse::<u32>().is_ok(), "{line}");
    }
    let json = project.raxel(&["check", "graphs/primary.toml", "--format", "json"]).exits(3).json();
    let (summary, diagnostics) = json.split_last().unwrap();
    assert_eq!(summary["errors"].as_u64().unwrap() as usize, diagnostics.len());
    assert!(diagnostics.len() >= 3 && summary["reason"] == "checked");
}

#[test]
fn broken_files_are_diagnosed_and_never_a_panic() {
    let project = Project::shipped();
    let primary = std::fs::read(project.path("graphs/primary.toml")).unwrap();
    project
        .write("graphs/empty.toml", "")
        .write("graphs/truncated.toml", &primary[..primary.len() / 2])
        .write("graphs/binary.toml", [0xff, 0xfe, 0, 1, 2])
        .write("graphs/huge.toml", vec![b'#'; 65 << 20])
        .write("graphs/deep.toml", format!("a = {}{}", "[".repeat(50_000), "]".repeat(50_000)))
        .write("graphs/cycle.toml", "extends = \"cycle2.toml\"")
        .write("graphs/cycle2.toml", "extends = \"cycle.toml\"")
        .write("graphs/outside.toml", "extends = \"../../x.toml\"")
        .write("worlds/empty.vox", "")
        .write("worlds/broken.vox", b"VOX \x96\0\0\0MAIN\xff\xff\xff\x7f")
        .write("worlds/binary.toml", [0xc3, 0x28])
        .write("worlds/broken.demo.toml", "world = 3")
        .write("shaders/empty.spv", "")
        .write("shaders/cut.spv", [3, 2, 0x23, 7, 0, 5, 1, 0]);
    for (name, shader) in [("empty_spv", "empty.spv"), ("cut_spv", "cut.spv"), ("none", "none.comp")] {
        let old = String::from_utf8(primary.clone()).unwrap();
        project.write(&format!("graphs/{name}.toml"), old.replace("primary.comp", shader));
    }
    for file in [
        "graphs/empty.toml",
        "graphs/truncated.toml",
        "graphs/binary.toml",
        "graphs/huge.toml",
        "graphs/deep.toml",
        "graphs/cycle.toml",
        "graphs/outside.toml",
        "graphs/empty_spv.toml",
        "graphs/cut_spv.toml",
        "graphs/none.toml",
        "graphs/not-there.toml",
        "worlds/empty.vox",
        "worlds/broken.vox",
        "worlds/binary.toml",
        "worlds/broken.demo.toml",
        "graphs",
    ] {
        let run = project.raxel(&["check", file, "--format", "short"]).exits(3);
        assert!(run.stdout.contains("[RX"), "{file} gives no code:\n{}\n{}", run.stdout, run.stderr);
    }
}

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
const OVER_A_WORLD: &str = include_str!("fixtures/cli/over.toml");

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
    let project = common::Project::empty();
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
    let project = common::Project::shipped();
    let graph = std::fs::read_to_string(project.path("graphs/examples/model.toml")).unwrap();
    project.write("graphs/examples/model.toml", graph.replace("model.pine.", "model.rook."));
    project.raxel(&["check", "graphs/examples/model.toml"]).exits(0);
    // Without defaults, the graph must have the params that move its instances.
    let project = common::Project::shipped();
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
fn a_new_project_checks_and_a_full_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for template in ["voxel", "minimal"] {
        let path = folder.path().join(template);
        let name = path.to_str().unwrap();
        raxel(&["new", name, "--template", template]).exits(0);
        assert!(path.join(".raxel/graph.schema.json").is_file());
        let run = common::raxel_in(&path, &["check"]).exits(0);
        assert!(run.stdout.is_empty(), "{}", run.stdout);
        let again = raxel(&["new", name]).exits(2);
        assert!(again.stderr.contains("is not empty"));
        for file in ["raxel.toml", "README.md", "graphs/primary.toml", "shaders/primary.comp", "worlds/valley.toml"] {
            let Ok(text) = std::fs::read_to_string(path.join(file)) else { continue };
            for named in named_files(&text) {
                let folders = ["", "graphs", "shaders", "worlds"];
                assert!(folders.iter().any(|folder| path.join(folder).join(&named).exists()), "{file} names {named}");
            }
        }
    }
}

/// The paths with a folder that a text names, but those of the shader library and of a command that prints it.
fn named_files(text: &str) -> Vec<String> {
    let is_path = |c: char| c.is_alphanumeric() || "/._-*".contains(c);
    let words = text.split(|c: char| !is_path(c)).map(|word| word.trim_matches('.'));
    let is_file = |word: &&str| {
        let extension = word.rsplit_once('.').map(|(_, extension)| extension);
        word.contains('/') && !word.contains('*') && matches!(extension, Some("md" | "glsl" | "comp" | "toml"))
    };
    words.filter(is_file).filter(|word| !word.starts_with("raxel/")).map(str::to_owned).collect()
}

#[test]
fn the_manifest_says_what_runs_by_default() {
    let project = Project::shipped();
    project.write("raxel.toml", "graph = 'inspect.toml'\nworld = 'menger.toml'\nsize = [64, 36]\n");
    assert!(project.raxel(&["list"]).exits(0).stdout.contains("sky_depth"));
    let rendered = |args: &[&str]| {
        let run = project.raxel(&[&["render", "-o", "a.png", "--format", "json"], args].concat()).exits(0);
        run.json().into_iter().find(|line| line["reason"] == "rendered").unwrap()
    };
    let said = rendered(&[]);
    assert_eq!((&said["graph"], &said["size"]), (&"graphs/inspect.toml".into(), &serde_json::json!([64, 36])));
    // The command line wins, and a demo over graph and world.
    assert_eq!(rendered(&["graphs/rivals/naive.toml", "--size", "32x18"])["size"], serde_json::json!([32, 18]));
    project.write(
        "worlds/own.demo.toml",
        "world = 'menger.toml'\ngraph = 'rivals/naive.toml'\nduration = 1.0\nsize = [48, 27]\n",
    );
    project.write("raxel.toml", "graph = 'inspect.toml'\ndemo = 'own.demo.toml'\nsize = [64, 36]\n");
    let said = rendered(&[]);
    assert_eq!((&said["graph"], &said["size"]), (&"graphs/rivals/naive.toml".into(), &serde_json::json!([48, 27])));
    assert_eq!(rendered(&["--world", "worlds/menger.toml"])["graph"], "graphs/inspect.toml");
    project.raxel(&["check", "raxel.toml"]).exits(0);

    project.write("raxel.toml", "graph = 'none.toml'\n");
    for args in [&["check"][..], &["list"], &["render", "-o", "a.png"], &["graph"]] {
        let run = project.raxel(args).exits(3);
        let said = run.stdout + &run.stderr;
        assert!(said.contains("RX0460") && said.contains("raxel.toml:1:9"), "{args:?}: {said}");
    }
}

#[test]
fn a_folder_with_files_becomes_a_project_and_none_of_them_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("README.md"), "mine").unwrap();
    let init = || common::raxel_in(folder.path(), &["init", "--template", "minimal"]);
    init().exits(0);
    assert_eq!(std::fs::read_to_string(folder.path().join("README.md")).unwrap(), "mine");
    common::raxel_in(folder.path(), &["check"]).exits(0);
    // It is one now: nothing is written over, nothing half-made is left.
    std::fs::remove_file(folder.path().join("shaders/paint.comp")).unwrap();
    let again = init().exits(2);
    assert!(again.stderr.contains("graphs/primary.toml` is there already"), "{}", again.stderr);
    assert!(!folder.path().join("shaders/paint.comp").exists());
}

#[test]
fn a_graph_and_a_world_are_listed_by_name() {
    let project = Project::shipped();
    let list = ["list", "graphs/primary.toml", "--world", "worlds/valley.toml"];
    let text = project.raxel(&list).exits(0).stdout;
    // Columns are as wide as what stands in them.
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    for line in [
        "sky_strength f32 0.6 0…4 Sun and sky: Skylight Light from the whole sky; corners of the world see less of it.",
        "hit target rgba32i",
        "primary",
    ] {
        assert!(text.lines().any(|found| words(found) == words(line)), "{line:?} is not in\n{text}");
    }
    let json = project.raxel(&[&list[..], &["--format", "json"]].concat()).exits(0).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["present"], "color");
    assert_eq!(json["params"][0]["name"], "exposure");
    assert!(json["passes"].as_array().unwrap().iter().any(|pass| pass == "trace"), "{json}");
    assert_eq!(json["world"], "worlds/valley.toml");
    // A graph alone has no world to name.
    let alone = Project::empty();
    alone.write(
        "graphs/a.toml",
        r#"name = "a"
present = "a"
[targets.a]
format = "r32f"
init = 0.0
"#,
    );
    let json = alone.raxel(&["list", "--format", "json"]).exits(0).json();
    assert_eq!((&json[0]["name"], json[0].get("world")), (&"a".into(), None), "{json:?}");
    project.raxel(&["list", "graphs/none.toml"]).exits(3);
    // A world is listed with the project's graph, a demo with its own.
    let list = |args: &[&str]| project.raxel(&[&["list", "--format", "json"], args].concat()).exits(0).json().remove(0);
    let world = list(&["worlds/valley.toml"]);
    assert_eq!((&world["name"], &world["world"]), (&"primary".into(), &"worlds/valley.toml".into()), "{world}");
    let demo = list(&["worlds/dawn.demo.toml"]);
    assert_eq!((&demo["name"], &demo["world"]), (&"inspect".into(), &"worlds/valley.toml".into()), "{demo}");
    let over = list(&["worlds/dawn.demo.toml", "--world", "worlds/menger.toml"]);
    assert_eq!((&over["name"], &over["world"]), (&"inspect".into(), &"worlds/menger.toml".into()), "{over}");
    project.raxel(&["list", "worlds/valley.toml", "--world", "worlds/menger.toml"]).exits(2);
    // Choices stand for their numbers, units with what has them.
    let text = project.raxel(&["list", "graphs/examples/params.toml"]).exits(0).stdout;
    for line in ["pattern u32 Discs Discs | Stripes | Squares Pattern", "turn f32 30 0…360 ° Shape: Turned by"] {
        assert!(text.lines().any(|found| words(found) == words(line)), "{line:?} is not in\n{text}");
    }
    let render = |choice: &str| {
        let set = format!("pattern={choice}");
        project.raxel(&["render", "graphs/examples/params.toml", "--size", "32x18", "--set", &set, "-o", "p.png"])
    };
    render("Stripes").exits(0);
    let by_name = std::fs::read(project.path("p.png")).unwrap();
    render("1").exits(0);
    assert!(std::fs::read(project.path("p.png")).unwrap() == by_name);
    assert!(render("Stripe").exits(2).stderr.contains("did you mean `Stripes`?"));
}

#[test]
fn clean_removes_what_raxel_made_and_nothing_else() {
    let project = Project::empty();
    project.write(".raxel/cache/x", "1").write(".raxel/demo/valley.png", "1").write(".raxel/mine.txt", "1");
    project.raxel(&["clean"]).exits(0);
    assert!(!project.path(".raxel/cache").exists() && !project.path(".raxel/demo").exists());
    assert!(project.path(".raxel/mine.txt").exists());
    assert!(project.raxel(&["clean"]).exits(0).stderr.contains("nothing to remove"));
}

#[test]
fn shaders_are_written_as_modules() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    raxel(&["shaders", "graphs/primary.toml", "-o", out]).exits(0);
    let module = std::fs::read(folder.path().join("primary.primary.spv")).unwrap();
    assert_eq!(module[..4], [3, 2, 0x23, 7]);
}

/// glslang dereferences a null pointer over the second text. The child process dies of it, not this one.
#[test]
fn hlsl_that_stops_the_compiler_is_a_diagnostic() {
    const GRAPH: &str = include_str!("fixtures/cli/hlsl.toml");
    let shader = |value: &str| {
        format!(
            r#"struct Push {{ float k; }};
[[vk::push_constant]] ConstantBuffer<Push> push;
[[vk::image_format("r32f")]] RWTexture2D<float> dst;
[numthreads(8, 8, 1)]
void main(uint3 id : SV_DispatchThreadID) {{ dst[id.xy] = {value}; }}
"#
        )
    };
    let project = Project::empty();
    project.write("graphs/h.toml", GRAPH).write("shaders/p.hlsl", shader("push.k"));
    project.raxel(&["check", "graphs/h.toml"]).exits(0);
    project.write("shaders/p.hlsl", shader("push.k ++ .y"));
    let run = project.raxel(&["check", "graphs/h.toml"]).exits(3);
    assert!(run.stdout.contains("RX0210") && run.stdout.contains("shaders/p.hlsl"), "{}", run.stdout);
}

/// The same range as in the files of worlds and demos, and a camera cannot look at where it is.
#[test]
fn a_camera_of_the_command_line_is_held_to_the_rules_of_files() {
    let project = Project::shipped();
    let render = |camera: &[&str]| {
        let line = [&["render", "--world", "worlds/menger.toml", "--size", "32x18", "-o", "a.png"], camera].concat();
        project.raxel(&line)
    };
    let run = render(&["--camera", "1e300,0,0"]).exits(2);
    assert!(run.stderr.contains("it must be in -2147483648…2147483648"), "{}", run.stderr);
    render(&["--camera", "0,0,nan"]).exits(2);
    render(&["--look-at", "0,-3e9,0"]).exits(2);
    let run = render(&["--camera", "0.1,7.5,-3", "--look-at", "0.1,7.5,-3"]).exits(2);
    assert!(run.stderr.contains("is where the camera is"), "{}", run.stderr);
    assert!(!project.path("a.png").exists());
    render(&["--camera", "0.1,7.5,-3", "--look-at", "0.1,-80,-3"]).exits(0);
}

/// Two models without a scene graph are the frames of an animation.
#[test]
fn a_frame_of_an_animation_is_imported() {
    let project = Project::shipped();
    let mut content = Vec::new();
    for voxels in [&[[0u8, 0, 0, 1]][..], &[[0, 0, 0, 1], [1, 0, 0, 1], [2, 0, 0, 1]]] {
        for (id, body) in [
            (b"SIZE", [3u32, 1, 1].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>()),
            (b"XYZI", (voxels.len() as u32).to_le_bytes().into_iter().chain(voxels.concat()).collect()),
        ] {
            content.extend(id);
            content.extend((body.len() as u32).to_le_bytes());
            content.extend([0; 4]);
            content.extend(body);
        }
    }
    let mut file = b"VOX \x96\0\0\0MAIN\0\0\0\0".to_vec();
    file.extend((content.len() as u32).to_le_bytes());
    file.extend(content);
    project.write("flame.vox", file);
    let solids = |world: &str| {
        project.raxel(&["world", "info", world, "--format", "json"]).exits(0).json()[0]["info"]["solids"].clone()
    };
    project.raxel(&["world", "import", "flame.vox"]).exits(0);
    assert_eq!(solids("worlds/flame.toml"), 1);
    project.raxel(&["world", "import", "flame.vox", "--frame", "1", "-o", "worlds/second.toml", "--force"]).exits(0);
    assert_eq!(solids("worlds/second.toml"), 3);
    let run = project.raxel(&["world", "import", "flame.vox", "--frame", "2", "--force"]).exits(3);
    assert!(run.stderr.contains("RX0324") && run.stderr.contains("2 frames, 0 to 1"), "{}", run.stderr);
}

/// As for every other result: a program that asks for the version must not take nothing for one.
#[test]
#[cfg(target_os = "linux")]
fn a_help_or_version_that_cannot_be_written_is_an_error() {
    for arguments in [&["--version"][..], &["--help"], &["render", "--help"], &["help", "check"]] {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", "exec \"$0\" \"$@\" > /dev/full", env!("CARGO_BIN_EXE_raxel")]).args(arguments);
        let said = Run::from(output(&mut shell)).exits(2).stderr;
        assert!(said.starts_with("error: stdout cannot be written"), "{arguments:?}: {said}");
    }
}
