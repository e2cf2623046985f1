//! Demos as tests, cuts and captions: checks make the exit code, and point at their lines.

mod common;

use common::{Project, Run, RunRaxel};

/// A graph that shows the number of frames since it began, and the position of the camera.
const GRAPH: &str = include_str!("fixtures/demo/count.toml");

const SHADER: &str = include_str!("fixtures/demo/count.comp");

const DEMO: &str = include_str!("fixtures/demo/count.demo.toml");

fn project() -> Project {
    let project = Project::empty();
    let world = r"[materials]
stone = { albedo = '#808080' }
[[build]]
op = 'box'
min = [0, 0, 0]
max = [1, 1, 1]
material = 'stone'
";
    project.write("graphs/count.toml", GRAPH).write("shaders/add.comp", SHADER);
    project.write("worlds/empty.toml", world).write("worlds/a.demo.toml", DEMO);
    project
}

/// The first texel of a frame.
fn texel(project: &Project, arguments: &[&str]) -> ([f32; 3], Run) {
    let run =
        project.raxel(&[&["render", "worlds/a.demo.toml", "--format", "json", "-o", "t.exr"], arguments].concat());
    let run = run.exits(0);
    let image = exr::prelude::read_first_flat_layer_from_file(project.path("t.exr")).unwrap();
    let value = |name: &str| {
        let mut channels = image.layer_data.channel_data.list.iter();
        channels.find(|channel| channel.name.to_string() == name).unwrap().sample_data.values_as_f32().next().unwrap()
    };
    (["R", "G", "B"].map(value), run)
}

#[test]
#[allow(clippy::float_cmp, reason = "they count frames")]
fn a_cut_starts_over_and_parts_start_at_it() {
    let project = project();
    // Frame 9 is the tenth since the start; the camera of the frame before is where it was.
    assert_eq!(texel(&project, &["--at", "0.9s"]).0, [10.0, 0.0, 0.0]);
    // Frame 10 is the first of the next shot: nothing of the other is left, and there is no way from there to here.
    let (cut, run) = texel(&project, &["--at", "1s"]);
    assert_eq!((cut, &run.json()[0]["run"]), ([1.0, 10.0, 10.0], &serde_json::json!([10, 11])));
    let (after, run) = texel(&project, &["--at", "1.3s"]);
    assert_eq!((after, &run.json()[0]["run"]), ([4.0, 13.0, 12.0], &serde_json::json!([10, 14])));
    // The whole run has the same.
    let whole = ["render", "worlds/a.demo.toml", "--format", "json", "--frames", "14", "-o", "w/%02d.exr"];
    assert_eq!(project.raxel(&whole).exits(0).json()[0]["run"], serde_json::json!([0, 14]));
    let read = |name: &str| std::fs::read(project.path(name)).unwrap();
    assert!(read("w/13.exr") == read("t.exr"));
    let late = project.raxel(&["render", "worlds/a.demo.toml", "--at", "99s", "-o", "late.exr"]).exits(2);
    assert!(late.stderr.contains("after the end of the demo"), "{}", late.stderr);
    assert!(!project.path("late.exr").exists());
    project.edit("worlds/a.demo.toml", "cut = true\n", "");
    assert_eq!(texel(&project, &["--at", "1.3s"]).0[0], 14.0, "without a cut nothing starts over");
}

#[test]
fn checks_make_the_exit_code_and_point_at_their_lines() {
    let project = project();
    let run = project.raxel(&["test"]).exits(2);
    assert!(run.stderr.contains("no demo of the project checks anything"), "{}", run.stderr);
    let check = r"[[check]]
frame = 5
reference = 'refs/a.png'
flip = 0.001
[[check]]
pass = 'add'
below_ms = 60000.0
";
    project.write("worlds/a.demo.toml", format!("{DEMO}{check}"));
    let run = project.raxel(&["test", "--format", "short"]).exits(1);
    assert!(run.stderr.contains("worlds/a.demo.toml:20:13: error[RX0421]"), "{}", run.stderr);
    project.raxel(&["test", "--write"]).exits(0);
    let written = image::open(project.path("worlds/refs/a.png")).unwrap();
    assert_eq!((written.width(), written.height()), (16, 8));
    let run = project.raxel(&["test", "--validate"]).exits(0);
    assert!(run.stderr.contains("2 checks held") && run.stdout.contains("FLIP 0.000000 of 0.001"), "{}", run.stdout);

    // The shader's edit changes the picture.
    project.edit("shaders/add.comp", "push.cell.x,", "1.0 - clamp(float(push.cell.x), 0.0, 1.0),");
    let run = project.raxel(&["test", "--format", "short"]).exits(1);
    assert!(run.stderr.contains("worlds/a.demo.toml:20:13: error[RX0422]"), "{}", run.stderr);
    assert!(run.stderr.contains("1 of 2 checks do not hold"), "{}", run.stderr);
    assert!(project.path("worlds/refs/a.new.png").exists() && project.path("worlds/refs/a.diff.png").exists());

    project.edit("worlds/a.demo.toml", "60000.0", "0.000001");
    let run = project.raxel(&["test", "--format", "json"]).exits(1);
    assert_eq!(run.json().iter().filter(|line| line["ok"] == serde_json::json!(false)).count(), 2);
    assert!(run.stderr.contains("RX0423"), "{}", run.stderr);
    project.edit("worlds/a.demo.toml", "pass = 'add'", "pass = 'ad'");
    assert!(project.raxel(&["check"]).exits(3).stdout.contains("RX0420"));
}

/// The example in the repository.
#[test]
fn the_shipped_checks_hold() {
    let run = common::raxel(&["test"]).exits(0);
    assert!(run.stdout.contains("worlds/sponge.demo.toml: ok"), "{}", run.stdout);
}

#[test]
fn a_caption_is_in_the_picture() {
    let project = project();
    let picture = |name: &str| {
        project.raxel(&["render", "worlds/a.demo.toml", "--at", "0.5s", "--size", "320x180", "-o", name]).exits(0);
        image::open(project.path(name)).unwrap().into_rgb8()
    };
    let plain = picture("plain.png");
    let caption = "[[caption]]\ntime = 0.4\nuntil = 0.6\ntext = 'Ten frames'\n";
    project.write("worlds/a.demo.toml", format!("{DEMO}{caption}"));
    let said = picture("said.png");
    assert!(plain.rows().zip(said.rows()).take(150).all(|(a, b)| a.eq(b)), "above the band all is as it was");
    // The picture is red.
    let letters = |picture: &image::RgbImage| picture.pixels().filter(|pixel| pixel.0[1] > 100).count();
    assert!(letters(&plain) == 0 && letters(&said) > 20, "{} pixels are light", letters(&said));
}

/// The project with a second graph, which has a param, from the sixth frame to the tenth.
fn two_graphs() -> Project {
    let project = project();
    let other = GRAPH
        .replace("name = 'count'", "name = 'other'")
        .replace("add.comp", "other.comp")
        .replace("name = 'add'", "name = 'sub'");
    let other = format!(
        "{other}tint = {{ type = 'f32', from = 'param.tint' }}\n[params.tint]\ntype = 'f32'\ndefault = 0.0\nrange = [0, 9]\n"
    );
    let shader = SHADER
        .replace("ivec3 last; }", "ivec3 last; float tint; }")
        .replace("push.cell.x, push.last.x", "-push.cell.x, push.tint");
    project.write("graphs/other.toml", other).write("shaders/other.comp", shader);
    let turns = r"[[graphs]]
time = 0.5
graph = 'other.toml'
[[graphs]]
time = 0.9
graph = 'count.toml'
[tracks.tint]
keys = [[0.0, 0.0], [1.0, 2.0]]
";
    project.write("worlds/a.demo.toml", format!("{DEMO}{turns}"));
    project
}

#[test]
#[allow(clippy::float_cmp, reason = "they count frames")]
fn graphs_take_turns_in_films_parts_and_tests() {
    let project = two_graphs();
    project.raxel(&["check", "worlds/a.demo.toml"]).exits(0);
    // The last frame of the first graph, the first and the third of the second, and the first of the first again.
    assert_eq!(texel(&project, &["--at", "0.4s"]).0, [5.0, 0.0, 0.0]);
    let (first, run) = texel(&project, &["--at", "0.5s", "--validate"]);
    assert_eq!((first, &run.json()[0]["run"]), ([1.0, 0.0, 1.0], &serde_json::json!([5, 6])));
    let (third, run) = texel(&project, &["--at", "0.7s"]);
    assert_eq!((third[0], &run.json()[0]["run"]), (3.0, &serde_json::json!([5, 8])));
    assert!((third[2] - 1.4).abs() < 1e-3, "{third:?}");
    assert_eq!(texel(&project, &["--at", "0.9s"]).0, [1.0, 0.0, 0.0]);
    // The whole run and its parts have the same bytes.
    project.raxel(&["render", "worlds/a.demo.toml", "--validate", "-o", "whole/%02d.exr"]).exits(0);
    for shard in ["1/3", "2/3", "3/3"] {
        project.raxel(&["render", "worlds/a.demo.toml", "--shard", shard, "-o", "parts/%02d.exr"]).exits(0);
    }
    for frame in 0..20 {
        let read = |folder: &str| std::fs::read(project.path(&format!("{folder}/{frame:02}.exr"))).unwrap();
        assert!(read("whole") == read("parts"), "frame {frame}");
    }

    // Passes of both graphs are timed, each in its own frames, and checks find them.
    let checks = r"[[check]]
pass = 'add'
below_ms = 60000.0
[[check]]
pass = 'sub'
below_ms = 60000.0
[[check]]
frame = 6
target = 'sum'
reference = 'refs/b.png'
flip = 0.0
";
    let text = std::fs::read_to_string(project.path("worlds/a.demo.toml")).unwrap();
    project.write("worlds/a.demo.toml", text + checks);
    project.raxel(&["test", "--write"]).exits(0);
    assert!(project.raxel(&["test"]).exits(0).stderr.contains("3 checks held"));
    let bench = ["bench", "--demo", "worlds/a.demo.toml", "--format", "json", "-o", "out"];
    let run = project.raxel(&bench).exits(0);
    let report = &run.json()[0];
    let passes: Vec<_> = report["passes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| (p["graph"].as_str().unwrap(), p["pass"].as_str().unwrap(), p["frames"].as_u64().unwrap()))
        .collect();
    assert_eq!(passes, [("graphs/count.toml", "add", 16), ("graphs/other.toml", "sub", 4)]);
    assert_eq!(report["frame"]["frames"], 20);
    assert!(report["passes"][0]["p95_ms"].as_f64() >= report["passes"][0]["median_ms"].as_f64());
    assert_eq!(report["checks"].as_array().unwrap().len(), 2);
    let csv = std::fs::read_to_string(project.path("out/demo.csv")).unwrap();
    assert!(
        csv.starts_with("graph,what,frames,median_ms,p95_ms,max_ms\n") && csv.contains("graphs/other.toml,sub,4,"),
        "{csv}"
    );
    assert!(project.path("out/demo.json").exists());
    project.edit("worlds/a.demo.toml", "pass = 'sub'\nbelow_ms = 60000.0", "pass = 'sub'\nbelow_ms = 0.0000011");
    let run = project.raxel(&["bench", "--demo", "worlds/a.demo.toml"]).exits(1);
    assert!(run.stdout.contains("FAILED: pass `sub`") && run.stdout.contains("(graphs/other.toml)"), "{}", run.stdout);
    project.raxel(&["bench", "--demo", "worlds/a.demo.toml", "--layouts", "tree64"]).exits(2);
}

#[test]
fn mistakes_in_graphs_of_a_demo_point_at_their_lines() {
    let project = two_graphs();
    let short = |verb: &[&str]| {
        let run = project.raxel(verb);
        format!("{}{}", run.stdout, run.stderr)
    };
    let check = ["check", "worlds/a.demo.toml", "--format", "short"];
    let render = ["render", "worlds/a.demo.toml", "--format", "short", "-o", "a.png"];
    project.edit("worlds/a.demo.toml", "'other.toml'", "'gone.toml'");
    for verb in [&check[..], &render[..]] {
        assert!(short(verb).contains("worlds/a.demo.toml:20:9: error[RX0001]"), "{}", short(verb));
    }
    project.edit("worlds/a.demo.toml", "'gone.toml'", "'other.toml'").edit("graphs/other.toml", "'sum'", "'smu'");
    for verb in [&check[..], &render[..]] {
        assert!(short(verb).contains("graphs/other.toml:2:"), "{}", short(verb));
    }
    project.edit("graphs/other.toml", "'smu'", "'sum'").edit("worlds/a.demo.toml", "tracks.tint", "tracks.tnit");
    assert!(short(&check).contains("RX0403") && short(&check).contains("none of the graphs has a param `tnit`"));
}
