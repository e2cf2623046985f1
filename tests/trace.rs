//! `--trace`: a file of Chrome's format whose slices nest, on the CPU and on the GPU. `-v` lists compiled and reused objects.

mod common;

use std::collections::BTreeMap;

use common::{Project, Run, RunRaxel, before_vulkan, command, output, raxel};
use serde_json::Value;

/// A slice: name, start and end in microseconds.
type Slice = (String, f64, f64);

/// Slices by process and thread, in order of their start.
fn tracks(trace: &Value) -> BTreeMap<(u64, u64), Vec<Slice>> {
    let mut tracks: BTreeMap<_, Vec<Slice>> = BTreeMap::new();
    for event in trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "X") {
        let number = |key: &str| event[key].as_f64().unwrap();
        let slice = (event["name"].as_str().unwrap().to_owned(), number("ts"), number("ts") + number("dur"));
        tracks.entry((event["pid"].as_u64().unwrap(), event["tid"].as_u64().unwrap())).or_default().push(slice);
    }
    for track in tracks.values_mut() {
        track.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.2.total_cmp(&a.2)));
    }
    tracks
}

#[test]
fn a_trace_has_nested_tracks_of_cpu_and_gpu() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scene = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "96x54", "--frames", "6"];
    let output = ["-o", &inside("f/%d.png"), "--trace", &inside("t.json")];
    let run = raxel(&[&scene[..], &output].concat()).exits(0);
    assert!(run.stderr.contains("wrote the trace"), "{}", run.stderr);
    let trace: Value = serde_json::from_slice(&std::fs::read(inside("t.json")).unwrap()).unwrap();
    let tracks = tracks(&trace);
    for (track, slices) in &tracks {
        let mut open: Vec<&Slice> = Vec::new();
        for slice in slices {
            open.retain(|outer| outer.2 > slice.1 + 1e-3);
            // Half a microsecond is the rounding of two clocks.
            assert!(open.iter().all(|outer| slice.2 <= outer.2 + 0.5), "{track:?}: {slice:?} leaves {open:?}");
            open.push(slice);
        }
    }
    let names = |process: u64| -> Vec<&str> {
        let of = tracks.iter().filter(|((of, _), _)| *of == process);
        of.flat_map(|(_, slices)| slices.iter().map(|(name, ..)| name.as_str())).collect()
    };
    for name in ["open session", "load graph", "load world", "plan", "prepare", "frame", "read back", "encode", "write"]
    {
        assert!(names(1).contains(&name), "{name} is not among {:?}", names(1));
    }
    assert!(names(2).contains(&"inspect") && names(2).contains(&"frame 0"), "{:?}", names(2));
    // The passes of the last frame come after it.
    let one = ["-o", &inside("one.png"), "--trace", &inside("one.json")];
    raxel(&[&scene[..6], &one].concat()).exits(0);
    let trace = std::fs::read_to_string(inside("one.json")).unwrap();
    assert!(trace.contains("\"inspect\"") && trace.contains("\"frame 0\""), "{trace}");
    // An output that cannot be written is reported before anything runs.
    let run = raxel(&[&scene[..], &["-o", &inside("g/%d.png"), "--trace", &inside("no/t.json")]].concat()).exits(2);
    assert!(run.stderr.contains("does not exist") && !folder.path().join("g").exists(), "{}", run.stderr);
}

#[test]
fn verbose_says_what_was_compiled_and_what_was_reused() {
    let project = Project::shipped();
    let check = |more: &[&str]| {
        let files = ["check", "graphs/inspect.toml", "graphs/primary.toml", "graphs/rivals/primary_chunks.toml"];
        project.raxel(&[&files[..], more].concat()).exits(0).stderr
    };
    let said = check(&["-v"]);
    assert!(said.contains("compiled shaders/inspect.comp in "), "{said}");
    assert!(!check(&[]).contains("compiled"));
    let run = project.raxel(&[
        "render",
        "graphs/inspect.toml",
        "--world",
        "worlds/menger.toml",
        "--size",
        "8x8",
        "-v",
        "-o",
        "a.png",
    ]);
    let said = run.exits(0).stderr;
    assert!(said.contains("compiled shaders/inspect.comp in ") && said.contains("busy: render"), "{said}");
}

/// Notes labels and dispatches in the order in which they are recorded.
const LISTING: &str = include_str!("fixtures/trace/listing.c");

#[test]
#[cfg(target_os = "linux")]
fn each_pass_is_recorded_under_its_name_without_validation() {
    let project = Project::shipped();
    let (library, calls) = (before_vulkan(&project, LISTING), project.path("calls"));
    let mut render =
        command(project.root(), &["render", "graphs/examples/mips.toml", "--size", "32x18", "-o", "a.png"]);
    Run::from(output(render.env("LD_PRELOAD", &library).env("RECORDED_CALLS", &calls))).exits(0);
    let calls = std::fs::read_to_string(calls).unwrap();
    // The rounds of a loop have their numbers.
    for pass in ["light", "down[0]", "down[1]", "up[0]", "show"] {
        assert!(calls.contains(&format!("begin {pass}\ndispatch\nend\n")), "{pass}: {calls}");
    }
}
