//! `raxel render` on a real device: bytes that repeat, every kind of output, and its errors.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::path::Path;

use common::{Project, Run, RunRaxel, command, output, raxel, raxel_in};

/// A quick picture of the shipped graph that needs no big world.
const MENGER: [&str; 6] = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "96x54"];

fn menger(more: &[&str]) -> Run {
    raxel(&[&MENGER[..], more].concat())
}

fn decoded(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let pictures: Vec<Vec<u8>> = ["a.png", "b.png"]
        .iter()
        .map(|name| {
            let path = folder.path().join(name);
            raxel(&["render", "graphs/primary.toml", "--size", "128x72", "-o", path.to_str().unwrap()]).exits(0);
            std::fs::read(path).unwrap()
        })
        .collect();
    assert!(pictures[0] == pictures[1]);
    let picture = decoded(&folder.path().join("a.png"));
    assert_eq!(picture.dimensions(), (128, 72));
    let colors: std::collections::HashSet<_> = picture.pixels().collect();
    assert!(colors.len() > 100, "{} colours are no valley", colors.len());
}

#[test]
fn an_exr_holds_the_texels_of_the_target() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.exr");
    menger(&["--target", "depth", "--set", "sky_depth=99999", "-o", path.to_str().unwrap()]).exits(0);
    let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    let size = image.layer_data.size;
    assert_eq!((size.0, size.1), (96, 54));
    let channels = &image.layer_data.channel_data.list;
    assert_eq!(channels.len(), 1, "depth has one channel");
    let depth: Vec<f32> = channels[0].sample_data.values_as_f32().collect();
    assert!(depth.contains(&99999.0), "the sky has the value that was set");
    assert!(depth.iter().any(|&d| d < 1000.0), "the sponge is some voxels away");
    assert!(depth.iter().all(|&d| d > 0.0));
}

#[test]
fn frames_and_their_shards_are_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = |name: &str| folder.path().join(name).join("%03d.png").to_str().unwrap().to_owned();
    let frames = ["render", "worlds/valley.demo.toml", "--size", "48x27", "--fps", "2", "--frames", "5", "-o"];
    raxel(&[&frames[..], &[&pattern("whole")]].concat()).exits(0);
    for part in ["1/2", "2/2"] {
        raxel(&[&frames[..], &[&pattern("parts"), "--shard", part]].concat()).exits(0);
    }
    let read = |name: &str, frame: u32| std::fs::read(folder.path().join(format!("{name}/{frame:03}.png"))).unwrap();
    for frame in 0..5 {
        assert!(read("whole", frame) == read("parts", frame), "frame {frame}");
    }
    assert_eq!(std::fs::read_dir(folder.path().join("parts")).unwrap().count(), 5);
    assert!(read("whole", 0) != read("whole", 2), "the camera flies");
}

/// Runs `raxel render --format json` and returns its output.
fn rendered(arguments: &[&str]) -> serde_json::Value {
    raxel(&[&["render"], arguments, &["--format", "json"]].concat()).exits(0).json().remove(0)
}

#[test]
fn a_part_runs_no_frame_that_it_does_not_need() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let film = ["worlds/valley.demo.toml", "--size", "48x27", "--fps", "4"];
    rendered(&[&film[..], &["--frames", "12", "-o", &inside("whole/%02d.png")]].concat());
    let whole = |frame: u32| std::fs::read(folder.path().join(format!("whole/{frame:02}.png"))).unwrap();
    // The valley's graph keeps nothing from frame to frame; the camera of the frame before is known.
    let shard = rendered(&[&film[..], &["--frames", "12", "--shard", "3/3", "-o", &inside("part/%02d.png")]].concat());
    assert_eq!((&shard["frames"], &shard["run"]), (&serde_json::json!([8, 12]), &serde_json::json!([7, 12])));
    for frame in 8..12 {
        assert!(std::fs::read(folder.path().join(format!("part/{frame:02}.png"))).unwrap() == whole(frame), "{frame}");
    }
    let at = rendered(&[&film[..], &["--at", "2.5s", "-o", &inside("at.png")]].concat());
    assert_eq!(at["run"], serde_json::json!([9, 11]));
    assert!(std::fs::read(inside("at.png")).unwrap() == whole(10));
}

#[test]
fn a_graph_that_looks_back_runs_from_its_start() {
    let project = Project::empty();
    let graph = include_str!("fixtures/render/sum.toml");
    let shader = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) readonly uniform image2D before;
layout(r32f) writeonly uniform image2D after;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
imageStore(after, p, imageLoad(before, p) + 1.0);
}
";
    project.write("graphs/sum.toml", graph).write("shaders/add.comp", shader);
    let arguments = ["render", "--size", "8x8", "--frames", "10", "--shard", "2/2", "--format", "json", "-o"];
    let run = project.raxel(&[&arguments[..], &["f/%02d.exr"]].concat()).exits(0);
    assert_eq!(run.json()[0]["run"], serde_json::json!([0, 10]));
    let image = exr::prelude::read_first_flat_layer_from_file(project.path("f/09.exr")).unwrap();
    let found = image.layer_data.channel_data.list[0].sample_data.values_as_f32().next();
    assert_eq!(found, Some(10.0), "ten frames were added up");
}

#[test]
fn samples_smooth_edges_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |samples: &str, size: &str| {
        let path = folder.path().join(format!("{samples}-{size}.png"));
        let arguments = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--target", "normal"];
        raxel(&[&arguments[..], &["--size", size, "--samples", samples, "-o", path.to_str().unwrap()]].concat())
            .exits(0);
        (std::fs::read(&path).unwrap(), decoded(&path))
    };
    let (bytes, smooth) = picture("16", "64x36");
    assert!(bytes == picture("16", "64x36").0, "it is the same in every run");
    let (_, plain) = picture("1", "64x36");
    // The truth: every pixel as the mean of 64 that are in it, in linear light.
    let (_, large) = picture("1", "512x288");
    let linear = |v: u8| (f64::from(v) / 255.0).powf(2.2);
    let truth = |x: u32, y: u32| {
        let inside = (0..8).flat_map(|j| (0..8).map(move |i| (i, j)));
        inside.map(|(i, j)| linear(large.get_pixel(x * 8 + i, y * 8 + j).0[0])).sum::<f64>() / 64.0
    };
    let error = |picture: &image::RgbImage| {
        picture.enumerate_pixels().map(|(x, y, pixel)| (linear(pixel.0[0]) - truth(x, y)).powi(2)).sum::<f64>()
    };
    assert!(error(&smooth) * 4.0 < error(&plain), "{} against {}", error(&smooth), error(&plain));
}

#[test]
fn a_picture_settles_while_time_stands_still() {
    let shader = r"#version 460
layout(local_size_x = 1) in;
layout(rgba32f) uniform image2D told;
layout(push_constant) uniform Push { float time; uint still; float moved; } push;
void main() { imageStore(told, ivec2(0), vec4(push.time, push.still, push.moved, 1.0)); }";
    let graph = include_str!("fixtures/render/told.toml");
    let demo = r#"name = "told"
graph = "told.toml"
world = "menger.toml"
duration = 2.0
fps = 10
[tracks.moved]
keys = [[0.0, 0.0], [2.0, 20.0]]
"#;
    let project = Project::empty();
    let menger = std::fs::read(common::repository().join("worlds/menger.toml")).unwrap();
    project.write("shaders/tell.comp", shader).write("graphs/told.toml", graph);
    project.write("worlds/menger.toml", menger).write("worlds/told.demo.toml", demo);
    let render = |arguments: &[&str]| {
        project.raxel(&[&["render", "worlds/told.demo.toml"], arguments].concat()).exits(0);
    };
    let told = |file: &str| {
        let image = exr::prelude::read_first_flat_layer_from_file(project.path(file)).unwrap();
        ["R", "G", "B"].map(|name| {
            let channel = image.layer_data.channel_data.list.iter().find(|channel| channel.name.eq(name)).unwrap();
            f64::from(channel.sample_data.values_as_f32().next().unwrap())
        })
    };
    let is = |found: [f64; 3], time: f64, still: f64| {
        let near =
            (found[0] - time).abs() < 1e-5 && (found[1] - still).abs() < 0.5 && (found[2] - 10.0 * time).abs() < 1e-4;
        assert!(near, "time, frame.still and the param are {found:?}, not {time}, {still} and {}", 10.0 * time);
    };
    for (at, settle, still) in [("0.7s", "0", 0.0), ("0.7s", "9", 9.0), ("0s", "9", 9.0)] {
        render(&["--at", at, "--settle", settle, "-o", "a.exr"]);
        is(told("a.exr"), at.trim_end_matches('s').parse().unwrap(), still);
    }
    // Each picture of a film, and time goes on behind it.
    render(&["--frames", "4", "--settle", "2", "-o", "f/%02d.exr"]);
    for frame in 0..4 {
        is(told(&format!("f/{frame:02}.exr")), 0.1 * f64::from(frame), 2.0);
    }
    // Pictures that are averaged are pictures of one frame.
    project.write("graphs/told.toml", graph.replace("frame.still", "frame.index"));
    render(&["--frames", "4", "--samples", "3", "-o", "s/%02d.exr"]);
    for frame in 0..4 {
        is(told(&format!("s/{frame:02}.exr")), 0.1 * f64::from(frame), f64::from(frame));
    }
}

#[test]
fn several_targets_are_the_layers_of_one_exr() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let twice = menger(&["--layers", "depth,normal,depth", "-o", path.to_str().unwrap()]).exits(2).stderr;
    assert!(twice.contains("`--layers` names `depth` twice") && !path.exists(), "{twice}");
    menger(&["--layers", "depth,normal", "-o", path.to_str().unwrap()]).exits(0);
    let image = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
    let layers: Vec<_> = image
        .layer_data
        .iter()
        .map(|layer| (layer.attributes.layer_name.as_ref().unwrap().to_string(), layer.channel_data.list.len()))
        .collect();
    assert_eq!(layers[0], ("depth".to_owned(), 1));
    assert_eq!(layers[1].0, "normal");
    let run = menger(&["--layers", "depth,nromal", "-o", path.to_str().unwrap()]).exits(2);
    assert!(run.stderr.contains("did you mean `normal`?"), "{}", run.stderr);
    menger(&["--layers", "depth", "-o", "a.png"]).exits(2);
}

#[test]
fn frames_go_through_a_pipe() {
    let arguments = [&MENGER[..], &["--frames", "3", "--as", "raw", "-o", "-"]].concat();
    let piped = output(&mut command(common::repository(), &arguments));
    assert!(piped.status.success(), "{}", String::from_utf8_lossy(&piped.stderr));
    assert_eq!(piped.stdout.len(), 3 * 96 * 54 * 4);
    let picture = output(&mut command(common::repository(), &[&MENGER[..], &["-o", "-"]].concat())).stdout;
    let picture = image::load_from_memory_with_format(&picture, image::ImageFormat::Png).unwrap().into_rgba8();
    assert!(picture.as_raw()[..] == piped.stdout[..96 * 54 * 4], "the same pixels in either form");
    menger(&["-o", "-", "--time"]).exits(2);
}

#[test]
fn jpg_and_hdr_are_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    menger(&["-o", &inside("a.jpg"), "--quality", "95"]).exits(0);
    menger(&["-o", &inside("a.png"), "--compression", "high"]).exits(0);
    let (lossy, exact) = (decoded(Path::new(&inside("a.jpg"))), decoded(Path::new(&inside("a.png"))));
    let apart: u64 = lossy.iter().zip(exact.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    assert!(apart > 0 && apart < 4 * exact.len() as u64, "{apart}");
    menger(&["--target", "depth", "-o", &inside("d.hdr")]).exits(0);
    let depth = image::open(inside("d.hdr")).unwrap().into_rgb32f();
    assert!(depth.iter().any(|&d| d > 1.0 && d < 1000.0), "the sponge is some voxels away");
}

#[test]
fn a_film_needs_ffmpeg_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.mp4");
    let arguments = [&MENGER[..], &["--frames", "2", "-o", film.to_str().unwrap()]].concat();
    let run: Run = output(command(common::repository(), &arguments).env("PATH", folder.path())).into();
    let said = run.exits(2).stderr;
    assert!(said.contains("needs ffmpeg") && said.contains("frames/%04d.png"), "{said}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn an_output_that_cannot_be_written_is_said_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(inside("d.png")).unwrap();
    // The graph does not exist either; the output is looked at first.
    for output in [inside("no/a.png"), inside("a"), inside("a.tga"), inside("%d%d.png")] {
        let run = raxel(&["render", "graphs/none.toml", "-o", &output]).exits(2);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    }
    raxel(&["render", "graphs/none.toml", "-o", &inside("a.png")]).exits(3);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is written");
}

#[test]
fn broken_projects_write_nothing() {
    let project = Project::shipped();
    project.edit("shaders/primary.comp", "void main", "void mian");
    let before = project.files();
    let run = project.raxel(&["render", "-o", "p.png"]).exits(3);
    assert!(run.stdout.is_empty() && run.stderr.contains("shaders/primary.comp"), "{}", run.stderr);
    project.write("worlds/valley.toml", "[[build]]\nop = \"bix\"\n");
    let run = project.raxel(&["render", "-o", "p.png", "--format", "short"]).exits(3);
    assert!(run.stderr.contains("worlds/valley.toml:2:"), "both files are reported at once: {}", run.stderr);
    assert!(run.stderr.contains("shaders/primary.comp:"), "{}", run.stderr);
    assert_eq!(project.files(), before);
}

#[test]
fn names_and_values_on_the_command_line_are_checked() {
    for (arguments, said) in [
        (["--set", "sky_dpeth=1"], "did you mean `sky_depth`?"),
        (["--set", "sky_depth=much"], "sky_depth"),
        (["--set", "sky_depth"], "has no `=`"),
        (["--target", "dept"], "did you mean `depth`?"),
        (["--after", "inspct"], "did you mean `inspect`?"),
        (["--camera", "1,2"], "three numbers"),
        (["--camera", "above"], "`worlds/menger.toml` has no camera `above`"),
        (["--shard", "3/2"], "PART/PARTS"),
    ] {
        let run = menger(&[&arguments[..], &["-o", "never.png"]].concat()).exits(2);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
        assert!(!common::repository().join("never.png").exists());
    }
}

#[test]
fn without_a_driver_the_exit_code_is_4_with_the_command_that_installs_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut command = command(common::repository(), &[&MENGER[..], &["-o", path.to_str().unwrap()]].concat());
    let command = command.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
    assert!(Run::from(output(command)).exits(4).stderr.contains("apt-get install"));
    assert!(!path.exists());
}

#[test]
fn what_was_rendered_is_told_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let told = menger(&["-o", path.to_str().unwrap(), "--format", "json", "--time", "--validate"]).exits(0).json();
    assert_eq!(told[0]["reason"], "rendered");
    assert_eq!(told[0]["size"], serde_json::json!([96, 54]));
    assert_eq!(told[0]["passes"][0]["pass"], "inspect");
    assert!(told[0]["passes"][0]["milliseconds"].as_f64().unwrap() > 0.0);

    // For a picture the frame before it is enough, for times all are run; and the picture is the same.
    let eighth = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let frames = ["-o", path.to_str().unwrap(), "--format", "json", "--frames", "8"];
        let told = menger(&[&frames[..], more].concat()).exits(0).json();
        (told[0]["run"].clone(), std::fs::read(path).unwrap())
    };
    let (alone, timed) = (eighth("alone.png", &[]), eighth("timed.png", &["--time"]));
    assert_eq!((alone.0, timed.0), (serde_json::json!([6, 8]), serde_json::json!([0, 8])));
    assert!(alone.1 == timed.1);
}

#[test]
fn the_camera_can_be_put_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let take = |name: &str, camera: &[&str]| {
        let path = folder.path().join(name);
        menger(&[camera, &["-o", path.to_str().unwrap()]].concat()).exits(0);
        decoded(&path)
    };
    let hinted = take("hint.png", &[]);
    let moved = take("moved.png", &["--camera", "-80,200,-60", "--look-at", "40,40,40"]);
    assert!(hinted != moved);
    // The same place by another name.
    assert!(moved == take("again.png", &["--camera=-80.0,2e2,-60", "--look-at=40,40,40"]));
}

#[test]
fn a_camera_of_the_world_has_a_name() {
    let project = Project::shipped();
    let camera = "[cameras.corner]\nposition = [-80, 200, -60]\nlook_at = [40, 40, 40]\nfov = 45\n\n[materials]";
    project.edit("worlds/menger.toml", "[materials]", camera);
    let take = |camera: &[&str], code| {
        let run = project.raxel(&[&MENGER[..], camera, &["-o", "a.png"]].concat()).exits(code);
        (run.stderr, decoded(&project.path("a.png")))
    };
    let (_, named) = take(&["--camera", "corner"], 0);
    assert!(named == take(&["--camera=-80,200,-60", "--look-at=40,40,40"], 0).1);
    let (said, _) = take(&["--camera", "korner"], 2);
    assert!(said.contains("has no camera `korner`") && said.contains("did you mean `corner`?"), "{said}");
}

#[test]
fn a_new_project_renders_with_the_binary_alone() {
    let folder = tempfile::tempdir().unwrap();
    for template in ["voxel", "minimal"] {
        let project = folder.path().join(template);
        raxel_in(folder.path(), &["new", template, "--template", template]).exits(0);
        raxel_in(&project, &["render", "-o", "p.png", "--size", "64x36", "--validate"]).exits(0);
        assert_eq!(decoded(&project.join("p.png")).dimensions(), (64, 36));
        // From a folder inside it, too.
        raxel_in(&project.join("graphs"), &["render", "-o", "q.png", "--size", "64x36"]).exits(0);
        let read = |path: &str| std::fs::read(project.join(path)).unwrap();
        assert!(read("p.png") == read("graphs/q.png"));
    }
}

#[test]
fn the_doctor_finds_nothing_wrong_where_the_tests_run() {
    let run = raxel(&["doctor"]).exits(0);
    for line in ["devices", "shader compiler", "rendering", "project"] {
        assert!(run.stdout.contains(line), "{}", run.stdout);
    }
    let found = raxel(&["doctor", "--format", "json"]).exits(0).json();
    assert!(found.iter().all(|finding| finding["state"] != "bad"));

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for (place, state, words) in [("file/in", "missing", "cannot be written"), ("new/in", "ok", " files, ")] {
        let place = folder.path().join(place);
        let mut doctor = command(common::repository(), &["doctor", "--format", "json"]);
        let found = Run::from(output(doctor.env("RAXEL_CACHE", &place))).exits(0).json();
        let cache = found.iter().find(|finding| finding["what"] == "cache").unwrap();
        assert_eq!(cache["state"], state, "{cache}");
        assert!(cache["finding"].as_str().unwrap().contains(words), "{cache}");
    }
}

#[test]
fn worlds_go_out_and_come_in() {
    let project = Project::shipped();
    let said = project.raxel(&["world", "info", "worlds/menger.toml", "--format", "json"]).exits(0).json();
    let solids = said[0]["info"]["solids"].as_u64().unwrap();
    assert!(solids > 1000);
    let said = project.raxel(&["world", "export", "worlds/menger.toml", "-o", "cube.vox"]).exits(0).stderr;
    assert!(!said.contains("instance"), "{said}");
    project.raxel(&["world", "import", "cube.vox"]).exits(0);
    let imported = project.raxel(&["world", "info", "worlds/cube.toml", "--format", "json"]).exits(0).json();
    assert_eq!(imported[0]["info"]["solids"].as_u64().unwrap(), solids);
    project.raxel(&["check", "worlds/cube.toml"]).exits(0);
    project.raxel(&["world", "import", "cube.vox"]).exits(2);
    project.raxel(&["world", "import", "cube.vox", "--force"]).exits(0);

    let said = project.raxel(&["world", "export", "worlds/flock.toml", "-o", "flock.vox"]).exits(0).stderr;
    assert!(said.contains("without its 512 instances"), "{said}");

    let before = project.files();
    project.write("broken.vox", b"VOX nonsense");
    project.raxel(&["world", "import", "broken.vox"]).exits(3);
    project.raxel(&["world", "import", "missing.vox"]).exits(3);
    project.raxel(&["world", "export", "worlds/none.toml", "-o", "x.vox"]).exits(3);
    std::fs::remove_file(project.path("broken.vox")).unwrap();
    assert_eq!(project.files(), before);
}

/// A full queue is reported at the end, once, with its place in the graph; one with room is not.
#[test]
fn what_passes_count_is_said_at_the_end() {
    let project = Project::shipped();
    let render = |more: &[&str]| {
        let scene = ["render", "graphs/examples/warnings.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
        project.raxel(&[&scene[..], more, &["--frames", "4", "-o", "a.png"]].concat()).exits(0)
    };
    assert!(!render(&[]).stderr.contains("RX0411"));
    project.edit("graphs/examples/warnings.toml", "count = 262144", "count = 64");
    let said = render(&[]).stderr;
    assert_eq!(said.matches("warning[RX0411]: pixels show the sky").count(), 1, "{said}");
    assert!(said.contains("graphs/examples/warnings.toml:") && said.contains("raise `count`"), "{said}");
    let lines = render(&["--format", "json"]).stderr;
    let found = lines.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let found: Vec<_> = found.filter(|found| found["code"] == "RX0411").collect();
    assert_eq!(found.len(), 1, "{lines}");
}

/// Prints of a pass come frame by frame, and a failed assertion is an error after the picture was written.
#[test]
fn shaders_print_and_assert() {
    let project = Project::shipped();
    let scene =
        ["render", "graphs/examples/print.toml", "--world", "worlds/menger.toml", "--size", "96x54", "-o", "a.png"];
    let said = project.raxel(&scene).exits(0).stderr;
    let line = said.lines().find(|line| line.contains("voxel (")).unwrap_or_else(|| panic!("{said}"));
    assert!(
        line.starts_with("shaders/examples/print.comp:") && line.contains(": `look`, frame 0, (48, 27, 0): "),
        "{line}"
    );
    let json = project.raxel(&[&scene[..], &["--format", "json"]].concat()).exits(0).stderr;
    let event = json.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let event = event.into_iter().find(|event| event["event"] == "printed").unwrap_or_else(|| panic!("{json}"));
    assert_eq!(
        (&event["pass"], &event["frame"], &event["lines"][0]["invocation"][1]),
        (&"look".into(), &0.into(), &27.into())
    );

    project.edit("shaders/examples/print.comp", "rx_assert(!found || hit.t >= 0.0)", "rx_assert(pixel.y != 3)");
    std::fs::remove_file(project.path("a.png")).unwrap();
    let said = project.raxel(&scene).exits(1).stderr;
    assert!(said.contains("error[RX0412]: `rx_assert(pixel.y != 3)` failed in pass `look`: 96 invocations"), "{said}");
    assert!(said.contains("shaders/examples/print.comp:") && said.contains(", 3, 0) of frame 0"), "{said}");
    assert!(project.path("a.png").exists());
}

/// `a` stores 1, and `b` copies it into the shown target. `c` stores 2, and nothing shown depends on it.
#[test]
fn texels_are_those_that_the_last_writer_left() {
    let project = Project::empty();
    let set = "shader = 'set.comp'\ndispatch = [1, 1, 1]\nbind = { to = 't' }\n";
    let graph = format!(
        r"name = 'numbers'
present = 'fin'
[targets.t]
format = 'r32f'
size = [1, 1]
[targets.fin]
format = 'r32f'
size = [1, 1]
[[passes]]
name = 'a'
{set}push = {{ value = 1.0 }}
[[passes]]
name = 'b'
shader = 'copy.comp'
dispatch = [1, 1, 1]
bind = {{ from = 't', to = 'fin' }}
[[passes]]
name = 'c'
{set}push = {{ value = 2.0 }}
"
    );
    let head = "#version 460\nlayout(local_size_x = 1) in;\nlayout(r32f) writeonly uniform image2D to;\n";
    let set = "layout(push_constant) uniform Push { float value; };\n\
               void main() { imageStore(to, ivec2(0), vec4(value)); }\n";
    let copy = "layout(r32f) readonly uniform image2D from;\n\
                void main() { imageStore(to, ivec2(0), imageLoad(from, ivec2(0))); }\n";
    project.write("graphs/numbers.toml", graph);
    project.write("shaders/set.comp", format!("{head}{set}")).write("shaders/copy.comp", format!("{head}{copy}"));
    let first = |file: &str| {
        let image = exr::prelude::read_first_flat_layer_from_file(project.path(file)).unwrap();
        image.layer_data.channel_data.list[0].sample_data.values_as_f32().next().unwrap()
    };
    let render = ["render", "graphs/numbers.toml", "--size", "1x1", "--frames", "3", "-o", "f/%d.exr"];
    for (more, value) in [(&["--target", "t"][..], 2), (&["--target", "fin"], 1), (&["--layers", "t"], 2)] {
        project.raxel(&[&render[..], more].concat()).exits(0);
        assert_eq!([0, 1, 2].map(|frame| first(&format!("f/{frame}.exr")) as u32), [value; 3], "{more:?}");
    }
    // A point within a frame has a picture, but leaves no texels.
    for after in [&["--target", "t", "--after", "a"][..], &["--target", "t,after=a"]] {
        let refused = project.raxel(&[&render[..], after].concat()).exits(2);
        assert!(refused.stderr.contains("an EXR has the texels at the end of the frame"), "{}", refused.stderr);
    }
}
