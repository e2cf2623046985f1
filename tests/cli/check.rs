//! `raxel check`: mistakes are found with their places, and nothing else is done.

use crate::common::{Project, RunRaxel, raxel};

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

const HEAVY_GRAPH: &str = include_str!("../fixtures/cli/heavy.toml");

const HEAVY_SHADER: &str = include_str!("../fixtures/cli/heavy.comp");

#[test]
fn needs_that_many_devices_do_not_meet_are_warnings() {
    let project = Project::empty();
    project.write("graphs/heavy.toml", HEAVY_GRAPH).write("shaders/heavy.comp", HEAVY_SHADER);
    let run = project.raxel(&["check", "graphs/heavy.toml"]).exits(0);
    let warning = |message: &str, label: &str, note: &str| {
        format!(
            r#"warning[RX0163]: {message}
 --> graphs/heavy.toml:8:8
  |
8 | name = "heavy"
  |        ^^^^^^^ {label}
  |
{note}help: `raxel doctor --graph` compares the graph with a device
"#
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

/// glslang dereferences a null pointer over the second text. The child process dies of it, not this one.
#[test]
fn hlsl_that_stops_the_compiler_is_a_diagnostic() {
    const GRAPH: &str = include_str!("../fixtures/cli/hlsl.toml");
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
