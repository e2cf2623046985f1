//! Flights that are measured, and errors.

use raxel::{Options, Session};
use raxel_layouts::Layout;
use raxel_rivals as rivals;
use raxel_runtime::OpenError;

use crate::common::{Display, Run, RunRaxel, command, output};
use crate::{options, project};

#[test]
fn what_a_streamed_world_cannot_do_is_said() {
    let project = project();
    let refused = |options: Options| Session::open(options).err().expect("it cannot open").to_string();
    for layout in rivals::LAYOUTS.iter().copied().filter(|layout| *layout != Layout::TREE64) {
        let options = Options { layout: Some(layout), ..options(&project, "bench/first_hit") };
        let Err(OpenError::Project { diagnostics, .. }) = Session::open(options) else { panic!("{layout:?} opens") };
        let whole = format!("`world.{}` needs the whole world", layout.name());
        assert!(!diagnostics.is_empty(), "{layout:?}");
        // A layout with an image is bound in two places.
        for found in &diagnostics {
            assert!(found.code.as_str() == "RX0342" && found.message.contains(&whole), "{found:?}");
            // The user of the world, and the streamed world.
            let files: Vec<&str> = found.labels.iter().map(|label| &*label.span.file).collect();
            assert_eq!(files, ["graphs/bench/first_hit.toml", "worlds/frontier.toml"]);
        }
    }
    project.edit("worlds/frontier.toml", "gpu_memory =", "cpu_memory = \"64 KiB\"\ngpu_memory =");
    let message = refused(options(&project, "bench/first_hit"));
    assert!(message.contains("RX0470") && message.contains("`cpu_memory` is 64.0 KiB"), "{message}");
    project.edit("worlds/frontier.toml", "\"64 KiB\"", "0");
    project.edit("worlds/frontier.toml", "\"100 MiB\"", "\"1 MiB\"");
    let needed = |step: Option<f64>| -> f64 {
        let message = refused(Options { step, ..options(&project, "bench/first_hit") });
        assert!(message.contains("RX0341") && message.contains("there are 1.0 MiB"), "{message}");
        let number = message.split("takes about ").nth(1).and_then(|text| text.split(' ').next());
        number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{message}"))
    };
    // A window loads tiles beyond the horizon as well.
    let (picture, window) = (needed(Some(0.1)), needed(None));
    assert!(window > 1.2 * picture, "{picture} MiB, {window} MiB");
}

#[test]
fn a_flight_is_measured() {
    let project = project();
    let arguments = ["bench", "stream", "graphs/bench/first_hit.toml", "--world", "worlds/frontier.toml"];
    let short = ["--seconds", "1", "--speed", "200", "--size", "48x27", "--edits", "6", "--format", "json"];
    let run = project.raxel(&[&arguments[..], &short].concat()).exits(0);
    let result = run.json().pop().expect("a line");
    assert_eq!(result["reason"], "bench-stream");
    let frames = result["live"]["frames"].as_array().expect("frames");
    assert!(frames.len() > 2 && frames.len() == result["resident"]["frames"].as_array().unwrap().len());
    assert!(frames.iter().map(|frame| frame["bytes"].as_u64().unwrap()).sum::<u64>() > 0);
    let resident = result["resident"]["frames"].as_array().unwrap();
    assert!(resident.iter().all(|frame| frame["missing"] == 0), "complete before each frame");
    // Each frame says where it was, and what its passes took.
    for way in ["live", "resident"] {
        let passes = result[way]["passes"].as_array().expect("passes").len();
        let frames = result[way]["frames"].as_array().unwrap();
        assert!(passes > 0 && frames[0]["part"] == "straight" && frames[0]["since"] == frames[0]["time"]);
        for frame in frames {
            let took = frame["passes"].as_array().expect("passes");
            let most = took.iter().map(|pass| pass.as_f64().unwrap()).fold(0.0, f64::max);
            let device = frame["device"].as_f64().expect("the device has a clock");
            assert!(took.len() <= passes && most > 0.0 && most <= device * 1.001, "{frame}");
            assert!(frame["milliseconds"].as_f64() >= frame["submitted"].as_f64(), "{frame}");
        }
    }
    for kind in ["small", "large"] {
        let edits = result["edits"][kind].as_array().expect("edits");
        assert!(!edits.is_empty() && edits.len() <= 6 && edits.iter().all(|edit| edit["frames"].as_u64() > Some(0)));
    }
    let many = &result["edits"]["many"];
    assert!(many["chunks"].as_u64() == Some(200) && many["frames"].as_u64() == Some(3), "{many}");
    let kept = &result["kept"];
    assert!(kept["bytes"].as_u64() <= kept["most"].as_u64() && kept["chunks"].as_u64() > Some(0), "{kept}");
    assert!(kept["found"].as_u64() > Some(0), "the sample around the first camera is not made twice: {kept}");
    assert!(result["pool"][1].as_u64() <= result["pool"][2].as_u64());
    // The same for people: parts of the path in their order, then frames from the longest on.
    let run = project.raxel(&[&arguments[..], &short[..6], &["--edits", "0"]].concat()).exits(0);
    let at = |text: &str| run.stdout.find(text).unwrap_or_else(|| panic!("no `{text}` in\n{}", run.stdout));
    assert!(
        at("part, ms") < at("longest frames, loading")
            && at("longest frames, loading") < at("longest frames, resident")
    );
    let listed = run.stdout[at("longest frames, loading")..at("longest frames, resident")].lines().skip(2);
    let listed: Vec<f64> = listed.map(|line| line.split_whitespace().next().unwrap().parse().unwrap()).collect();
    assert!(!listed.is_empty() && listed.len() <= 5 && listed.is_sorted_by(|a, b| a >= b), "{listed:?}");
    // A world that is whole has nothing to measure.
    let whole = project.raxel(&["bench", "stream", "graphs/bench/first_hit.toml", "--world", "worlds/menger.toml"]);
    assert!(whole.stderr.contains("is not streamed"), "{}", whole.stderr);
    // A verb that needs every voxel reports why it cannot have them.
    let export = project.raxel(&["world", "export", "worlds/frontier.toml", "-o", "a.vox"]);
    assert!(export.code != 0 && export.stderr.contains("RX0343"), "{}", export.stderr);
    assert!(export.stderr.contains("[stream]\n"), "the line is shown: {}", export.stderr);
}

#[test]
fn a_flight_says_once_what_passes_count() {
    let project = project();
    let run = || {
        let arguments = ["bench", "stream", "graphs/light/face_cache.toml", "--world", "worlds/frontier.toml"];
        let short = ["--seconds", "1", "--speed", "8", "--size", "16x9", "--edits", "0", "--format", "short"];
        project.raxel(&[&arguments[..], &short].concat()).exits(0).stderr
    };
    assert!(!run().contains("RX0411"));
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u;", "RX_FACE_PROBES = 0u;");
    let said = run();
    assert_eq!(said.matches("their faces found no slot in the table: ").count(), 1, "{said}");
}

/// A thread that cannot start, one that panics, and a source that panics. A variable plants them in builds with debug assertions.
#[cfg(debug_assertions)]
#[test]
fn a_streaming_thread_that_fails_is_an_error_at_once() {
    const SCENE: [&str; 5] = ["graphs/bench/first_hit.toml", "--world", "worlds/frontier.toml", "--size", "32x18"];
    let project = project();
    let run = |fault: &str, arguments: &[&str], stdin: &str| -> Run {
        project.write("requests", stdin);
        let requests = std::fs::File::open(project.path("requests")).unwrap();
        let arguments = [arguments, &SCENE[..]].concat();
        output(command(project.root(), &arguments).env("RAXEL_FAULT_STREAM", fault).stdin(requests)).into()
    };
    let faults = [
        ("spawn", "RX0344", "the thread `stream director` cannot start: a planted fault"),
        ("director", "RX0344", "the thread `stream director` has ended: it panicked: a planted fault"),
        ("worker", "RX0344", "has ended: it panicked: a planted fault"),
        ("source", "RX0451", "is unavailable: it panicked: a planted fault"),
    ];
    for (fault, code, text) in faults {
        let film = run(fault, &["render", "--frames", "2", "-o", "a-{frame}.png"], "").exits(3);
        assert!(film.stderr.contains(code) && film.stderr.contains(text), "{fault}: {}", film.stderr);
        assert!(!project.path("a-0.png").exists(), "{fault}: a picture was written");
    }
    // By program: every step is refused with the reason, and the session goes on.
    let steps = "{\"do\":\"step\"}\n{\"do\":\"step\"}\n{\"do\":\"info\"}\n{\"do\":\"quit\"}\n";
    let control = run("director", &["control"], steps).exits(0);
    let refused =
        |line: &&str| line.contains("\"ok\":false") && line.contains("the thread `stream director` has ended");
    assert_eq!(control.stdout.lines().filter(refused).count(), 2, "{}", control.stdout);
    assert!(control.stdout.lines().filter(|line| line.contains("\"ok\":true")).count() >= 2, "{}", control.stdout);
    // While frames run: a flight stops, a window says it once and goes on with its picture.
    let flight = run("director", &["bench", "stream"], "").exits(3);
    assert!(flight.stderr.contains("RX0344"), "{}", flight.stderr);
    let display = Display::start();
    let mut window = command(project.root(), &[&["run"][..], &SCENE, &["--frames", "30"]].concat());
    let window: Run = output(window.env("RAXEL_FAULT_STREAM", "worker").env("DISPLAY", &display.name)).into();
    let window = window.exits(0);
    assert_eq!(window.stderr.matches("RX0344").count(), 1, "{}", window.stderr);
}
