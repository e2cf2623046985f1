//! Frames repeat, and no frame runs that is not needed.

use crate::common::{Project, RunRaxel, raxel};
use crate::{common, decoded};

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
    let graph = include_str!("../fixtures/render/sum.toml");
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
    let graph = include_str!("../fixtures/render/told.toml");
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
