//! Demos as tests, cuts and captions: checks make the exit code, and point at their lines.

mod common;

use common::{Project, Run};

/// A graph that shows the number of frames since it began, and the position of the camera.
const GRAPH: &str = "name = 'count'\npresent = 'sum'\n[targets.sum]\nformat = 'rgba16f'\nhistory = 1\n[[passes]]\nname = 'add'\n\
                     shader = 'add.comp'\ndispatch = { threads = 'sum' }\nbind = { before = 'sum@1', after = 'sum' }\n[passes.push]\n\
                     cell = { type = 'ivec3', from = 'camera.cell' }\nlast = { type = 'ivec3', from = 'camera.previous.cell' }\n";

const SHADER: &str = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(rgba16f) readonly uniform image2D before;\n\
                      layout(rgba16f) writeonly uniform image2D after;\nlayout(push_constant) uniform Push { ivec3 cell; ivec3 last; } push;\n\
                      void main() {\n    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n    if (any(greaterThanEqual(p, imageSize(after)))) return;\n\
                      vec4 sum = imageLoad(before, p);\n    imageStore(after, p, vec4(sum.r + 1.0, push.cell.x, push.last.x, 1.0));\n}\n";

const DEMO: &str = "world = 'empty.toml'\ngraph = 'count.toml'\nduration = 2.0\nfps = 10\nsize = [16, 8]\n\
                    [[camera]]\ntime = 0.0\nposition = [0.5, 0.5, 0.5]\ninterpolation = 'linear'\n\
                    [[camera]]\ntime = 1.0\nposition = [10.5, 0.5, 0.5]\ncut = true\ninterpolation = 'linear'\n\
                    [[camera]]\ntime = 2.0\nposition = [20.5, 0.5, 0.5]\n";

fn project() -> Project {
    let project = Project::empty();
    let world = "[materials]\nstone = { albedo = '#808080' }\n[[build]]\nop = 'box'\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nmaterial = 'stone'\n";
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
    project.edit("worlds/a.demo.toml", "cut = true\n", "");
    assert_eq!(texel(&project, &["--at", "1.3s"]).0[0], 14.0, "without a cut nothing starts over");
}

#[test]
fn checks_make_the_exit_code_and_point_at_their_lines() {
    let project = project();
    let run = project.raxel(&["test"]).exits(2);
    assert!(run.stderr.contains("no demo of the project checks anything"), "{}", run.stderr);
    let check =
        "[[check]]\nframe = 5\nreference = 'refs/a.png'\nflip = 0.001\n[[check]]\npass = 'add'\nbelow_ms = 60000.0\n";
    project.write("worlds/a.demo.toml", format!("{DEMO}{check}"));
    let run = project.raxel(&["test", "--format", "short"]).exits(1);
    assert!(run.stderr.contains("worlds/a.demo.toml:20:13: error[RX0421]"), "{}", run.stderr);
    project.raxel(&["test", "--write"]).exits(0);
    let written = image::open(project.path("worlds/refs/a.png")).unwrap();
    assert_eq!((written.width(), written.height()), (16, 8));
    let run = project.raxel(&["test", "--validate"]).exits(0);
    assert!(run.stderr.contains("2 checks held") && run.stdout.contains("FLIP 0.000000 of 0.001"), "{}", run.stdout);

    // The shader changes what is shown.
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
