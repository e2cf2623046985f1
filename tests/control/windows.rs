//! A program drives a window.

use std::io::Write;
use std::process::Command;
use std::sync::mpsc::channel;

use serde_json::json;

use crate::common::{Display, LIMIT, Project, Talk, command, eventually, shared_library};
use crate::{SCENE, Window};

#[test]
fn a_window_is_driven_too() {
    let display = Display::start();
    let project = Project::shipped();
    let mut window = command(project.root(), &[&["run", "--control"][..], &SCENE].concat());
    let mut talk = Talk::start(window.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"));
    let refused = talk.say("{\"do\": \"step\"}");
    assert!(refused["error"].as_str().unwrap().contains("pause it first"), "{refused}");
    let refused = talk.say("{\"do\": \"input\", \"buttons\": []}");
    assert!(refused["error"].as_str().unwrap().contains("its own mouse"), "{refused}");
    talk.ask(json!({ "do": "pause" }));
    talk.ask(json!({ "do": "target", "target": "depth" }));
    talk.ask(json!({ "do": "set", "param": "sky_depth", "value": 321.0 }));
    // The window draws by itself: the value is seen after a frame.
    eventually("the value that was set", || {
        let answer = talk.say("{\"do\": \"texels\", \"target\": \"depth\"}");
        answer["ok"] == json!(true)
            && talk.ask(json!({ "do": "pixel", "target": "depth", "x": 0, "y": 0 }))["values"] == json!([321.0])
    });
    let told = talk.reloaded(|| _ = project.edit("graphs/inspect.toml", "present", "presnet"));
    assert_eq!(told["reloaded"], json!(false), "{told}");
    assert!(told["diagnostics"].to_string().contains("graphs/inspect.toml"), "{told}");
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

#[test]
fn a_window_over_mistakes_answers_too() {
    let display = Display::start();
    let project = Project::shipped();
    project.edit("graphs/inspect.toml", "present", "presnet");
    let mut window = command(project.root(), &[&["run", "--control"][..], &SCENE].concat());
    let mut talk = Talk::start(window.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"));
    let refused = talk.say("{\"do\": \"info\"}");
    assert!(refused["error"].as_str().unwrap().contains("nothing runs"), "{refused}");
    let found = talk.ask(json!({ "do": "diagnostics" }));
    assert!(found["showing"].is_null() && found["diagnostics"].to_string().contains("presnet"), "{found}");
    let told = talk.reloaded(|| _ = project.edit("graphs/inspect.toml", "presnet", "presentt"));
    assert!(told["reloaded"] == json!(false) && told["diagnostics"].to_string().contains("presentt"), "{told}");
    let told = talk.reloaded(|| _ = project.edit("graphs/inspect.toml", "presentt", "present"));
    assert_eq!((&told["reloaded"], &told["diagnostics"]), (&json!(true), &json!([])), "{told}");
    assert!(talk.ask(json!({ "do": "info" }))["graph"].to_string().contains("inspect"));
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// A window runs its frames and ends, whatever a program sends, and whether it reads the answers or not.
#[test]
fn a_flood_of_requests_stalls_no_frame() {
    let display = Display::start();
    for reads in [true, false] {
        let Window { mut child, mut requests, mut answers, .. } = Window::start(&display, &["--frames", "10"]);
        let (sender, flood) = channel();
        std::thread::spawn(move || {
            let some = "{\"do\":\"info\"}\n".repeat(200);
            let _ = sender.send((0..10_000).all(|_| requests.write_all(some.as_bytes()).is_ok()));
        });
        if reads {
            std::thread::spawn(move || std::io::copy(&mut answers, &mut std::io::sink()));
        }
        // Two million requests are far more than it can answer in ten frames.
        let taken = flood.recv_timeout(LIMIT).expect("the window ends, and its pipe with it");
        assert!(!taken, "it has taken all requests before its frames (it reads: {reads})");
        assert!(child.finish().success());
    }
}

/// The part of RenderDoc that a program sees: the table of functions of its API 1.1.2. Each function prints its name when it is called.
const FAKE_RENDERDOC: &str = include_str!("../fixtures/control/fake_renderdoc.c");

#[test]
#[cfg(target_os = "linux")]
fn a_frame_is_captured_under_renderdoc_and_refused_without_it() {
    let project = Project::shipped();
    let mut talk = Talk::start(command(project.root(), &["control"]).args(SCENE));
    let refused = talk.say(r#"{"do": "capture"}"#);
    assert!(refused["ok"] == false && refused["error"].as_str().unwrap().contains("renderdoccmd capture"), "{refused}");
    drop(talk);

    let library = shared_library(&project, "librenderdoc.so", FAKE_RENDERDOC);
    let log = project.path("calls");
    let under = |command: &mut Command| {
        command.args(SCENE).env("LD_PRELOAD", &library).env("FAKE_RENDERDOC", &log);
    };
    let mut control = command(project.root(), &["control"]);
    under(&mut control);
    let mut talk = Talk::start(&mut control);
    talk.ask(json!({ "do": "step", "frames": 3 }));
    assert_eq!(talk.ask(json!({ "do": "capture" }))["path"], "/captures/frame0.rdc");
    assert_eq!(talk.ask(json!({ "do": "capture" }))["path"], "/captures/frame1.rdc");
    assert_eq!(std::fs::read_to_string(&log).unwrap(), "start any\nend\nstart any\nend\n");
    drop(talk);
    let mut control = command(project.root(), &["control"]);
    under(control.env("FAKE_RENDERDOC_FAILS", "1"));
    let refused = Talk::start(&mut control).say(r#"{"do": "capture"}"#);
    assert!(refused["error"].as_str().unwrap().contains("made no capture"), "{refused}");
}

/// One step of work for each of `rounds`, on the old value.
const WORK: &str = include_str!("../fixtures/control/work.comp");

/// A driver that draws and computes in one queue must not take the times of passes when it draws.
#[test]
fn the_times_of_passes_are_theirs_beside_panels() {
    let display = Display::start();
    let project = Project::empty();
    let pass = |name: &str, rounds: u32| {
        format!(
            r#"[[passes]]
name = "{name}"
shader = "work.comp"
dispatch = {{ threads = "color" }}
bind = {{ color = "color" }}
push = {{ frame = "frame.index", rounds = {rounds} }}
"#
        )
    };
    let head = r#"name = "work"
present = "color"
[targets.color]
format = "rgba16f"
size = [64, 36]
clear = 0.0
"#;
    project.write("graphs/work.toml", format!("{head}{}{}{}", pass("short", 1), pass("long", 3000), pass("last", 1)));
    project.write("shaders/work.comp", WORK);
    let mut talk = Talk::start(
        command(project.root(), &["run", "graphs/work.toml", "--size", "320x180", "--control"])
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY"),
    );
    // The least of several times, as many as needed: a busy machine only adds to the time of a pass.
    let mut least = [f64::MAX; 3];
    let mut seen = 0;
    eventually("the long pass takes longer than the short ones", || {
        let answer = talk.say(r#"{"do": "timings"}"#);
        let passes = answer["passes"].as_array().cloned().unwrap_or_default();
        let time = |name: &str| passes.iter().find(|pass| pass["pass"] == name)?["milliseconds"].as_f64();
        let times = [time("short"), time("long"), time("last")];
        if let [Some(short), Some(long), Some(last)] = times {
            least = [least[0].min(short), least[1].min(long), least[2].min(last)];
            seen += 1;
        }
        seen >= 20 && least[1] > 4.0 * least[0] && least[1] > 4.0 * least[2]
    });
}
