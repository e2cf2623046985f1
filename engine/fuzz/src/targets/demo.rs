//! Demo files, from the text to the picture's settings at several times.

use std::sync::{Arc, LazyLock};

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_graph::checked::{Graph, Value};
use raxel_runtime::load::{LoadOutcome, Loader};
use raxel_runtime::timeline;

use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "demo",
    run,
    bounds: Bounds::PARSER,
    mutation: Mutation::Toml(timeline::schema),
    seeds: &["worlds/dusk.demo.toml", "worlds/frontier.demo.toml", "worlds/quarry.demo.toml"],
    longest: 16 << 10,
    quick: 1500,
};

/// The file of the input.
const PATH: &str = "worlds/main.demo.toml";

/// A graph with a param of each type, for tracks.
static PART: LazyLock<LoadOutcome<Graph>> = LazyLock::new(|| {
    let mut text = String::from("name = \"params\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba16f\"\n");
    let types = [
        ("f32", "1.0"),
        ("i32", "-1"),
        ("u32", "1"),
        ("bool", "true"),
        ("vec2", "[1.0, 2.0]"),
        ("vec3", "[1.0, 2.0, 3.0]"),
        ("vec4", "[1.0, 2.0, 3.0, 4.0]"),
        ("ivec3", "[1, 2, 3]"),
    ];
    for (ty, default) in types {
        text += &format!("[params.{ty}]\ntype = \"{ty}\"\ndefault = {default}\n");
    }
    for name in ["exposure", "sun_azimuth", "sun_elevation", "fog"] {
        text += &format!("[params.{name}]\ntype = \"f32\"\ndefault = 0.5\nrange = [0.0, 1.0]\n");
    }
    text += "[[passes]]\nname = \"fill\"\nshader = \"fill.comp\"\ndispatch = { threads = \"color\" }\nbind = { o = \"color\" }\n";
    let shader = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\n\
                  layout(rgba16f) writeonly uniform image2D o;\n\
                  void main() { imageStore(o, ivec2(gl_GlobalInvocationID.xy), vec4(1.0)); }\n";
    let files = MemoryFiles::new([("graphs/params.toml", text.as_str()), ("shaders/fill.comp", shader)]);
    Loader::with_files(Arc::new(files)).graph("graphs/params.toml")
});

fn run(input: &[u8]) {
    let files = MemoryFiles::default();
    projects::add(&files, PATH, input);
    let mut texts = SourceMap::default();
    let Some(demo) = check::outcome(timeline::read(&files, PATH, &mut texts), &texts) else { return };
    let graph = &**PART.result.as_ref().expect("the graph of the tracks is right");
    texts.extend(&PART.texts);
    check::diagnostics(&demo.check(&|_| Some(graph)), &texts);
    check::diagnostics(&demo.check(&|_| None), &texts);

    assert!(demo.duration.is_finite() && demo.duration > 0.0);
    assert!(demo.frames() >= 1 && demo.checked_times().iter().all(|time| time.is_finite()));
    let keys = demo.camera.iter().map(|key| key.time.value).chain(demo.edits.iter().map(|edit| edit.time.value));
    let keys = keys.chain(demo.tracks.iter().flat_map(|track| track.keys.values.iter().map(|key| key.value.0)));
    let times = [0.0, -1.0, 1e-9, demo.duration / 3.0, demo.duration, demo.duration * 2.5, 1e12, f64::MAX];
    let mut last = 0.0;
    for time in times.into_iter().chain(keys.take(64)) {
        let local = demo.local_time(time);
        assert!((0.0..=demo.duration).contains(&local), "{time} s is {local} s into {} s", demo.duration);
        if let Some(camera) = demo.camera(time) {
            let place = camera.position().to_array();
            let all = place.into_iter().chain([camera.yaw, camera.pitch, camera.fov]);
            assert!(all.into_iter().all(f64::is_finite), "at {time} s the camera is {camera:?}");
        }
        for (_, value) in demo.params(time, graph) {
            assert!(is_finite(&value), "at {time} s a param is {value:?}");
        }
        let _ = (demo.caption(time), demo.debug_target(time), demo.graph_at(time), demo.cuts_between(last, time));
        last = time;
    }
}

fn is_finite(value: &Value) -> bool {
    let text = format!("{value:?}");
    !text.contains("NaN") && !text.contains("inf")
}
