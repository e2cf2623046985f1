//! A program edits the world, flies, pauses, and records takes.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::SCENE;
use crate::common::{Display, Project, RunRaxel, Talk, command, eventually, repository};

#[test]
fn the_world_is_edited_and_edits_are_undone() {
    let mut talk = Talk::start(&mut command(repository(), &[&["control"][..], &SCENE].concat()));
    let solid = |talk: &mut Talk| {
        talk.ask(json!({ "do": "step" }));
        talk.ask(json!({ "do": "picture" }))["data"].clone()
    };
    let before = solid(&mut talk);
    let subtract = json!({ "op": "sphere", "center": [0, 0, 0], "radius": 400, "mode": "subtract" });
    let refused = talk.say(&json!({ "do": "edit", "operations": [subtract, { "op": "sphere" }] }).to_string());
    assert_eq!(refused["ok"], json!(false), "{refused}");
    assert_eq!(solid(&mut talk), before, "one of them is wrong, and none was made");
    let edited = talk.ask(json!({ "do": "edit", "operations": [subtract] }));
    assert!(edited["chunks"].as_u64() > Some(0) && edited["steps"] == json!({ "undo": 1, "redo": 0 }), "{edited}");
    let dug = solid(&mut talk);
    assert_ne!(dug, before);
    assert_eq!(talk.ask(json!({ "do": "undo" }))["undone"], json!(true));
    assert_eq!(solid(&mut talk), before);
    assert_eq!(talk.ask(json!({ "do": "undo" }))["undone"], json!(false));
    assert_eq!(talk.ask(json!({ "do": "redo" }))["redone"], json!(true));
    assert_eq!(solid(&mut talk), dug);
}

/// A pause is a look at one moment: frames go on, so that a graph that averages over frames gives the picture of `--settle`, bit by bit.
#[test]
fn a_picture_settles_during_a_pause() {
    let project = Project::shipped();
    let scene = ["graphs/beauty.toml", "--world", "worlds/menger.toml", "--size", "48x27", "--fps", "30"];
    let mut talk = Talk::start(&mut command(project.root(), &[&["control"][..], &scene].concat()));
    talk.ask(json!({ "do": "step", "frames": 4 }));
    talk.ask(json!({ "do": "pause" }));
    for (frames, frame) in [(1, 4), (15, 19)] {
        let now = talk.ask(json!({ "do": "step", "frames": frames }));
        assert_eq!((&now["frame"], &now["seconds"]), (&json!(frame), &json!(0.1)));
    }
    talk.ask(json!({ "do": "screenshot", "path": "paused.png" }));
    talk.ask(json!({ "do": "pause", "paused": false }));
    assert_eq!(talk.ask(json!({ "do": "step" }))["seconds"], json!(4.0 / 30.0), "the pause was no time");
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());

    let render = [&["render"][..], &scene, &["--frames", "4", "--settle", "16", "-o", "settled.png"]].concat();
    project.raxel(&render).exits(0);
    let [paused, settled] =
        ["paused.png", "settled.png"].map(|path| image::open(project.path(path)).unwrap().into_rgba8());
    assert!(paused == settled, "a pause shows another picture than `--settle`");
}

/// A take of a program is rendered again, byte by byte, with the strokes on the canvas that earlier frames have left.
#[test]
fn a_take_of_a_program_renders_the_same() {
    let project = Project::shipped();
    let scene = ["graphs/examples/paint.toml", "--world", "worlds/menger.toml", "--size", "64x36", "--fps", "30"];
    let mut talk = Talk::start(&mut command(project.root(), &[&["control"][..], &scene].concat()));
    for (line, said, help) in [
        ("{\"do\": \"stop\"}", "no take is being recorded", ""),
        ("{\"do\": \"input\", \"buttons\": [\"lefft\"]}", "`lefft` is no mouse button", "did you mean `left`?"),
        ("{\"do\": \"input\", \"cursor\": [1, 2], \"keys\": [\"keyW\"]}", "`keyW` is no key", "did you mean `KeyW`?"),
    ] {
        let answer = talk.say(line);
        assert!(answer["error"].as_str().unwrap().contains(said), "{line}: {answer}");
        assert!(answer["help"].to_string().contains(help), "{line}: {answer}");
    }
    // A refused request changes nothing.
    let none = json!({ "cursor": [], "buttons": [], "wheel": [0.0, 0.0], "keys": [], "time_of_day": 0.0 });
    let held = talk.ask(json!({ "do": "input" }));
    for (name, value) in none.as_object().unwrap() {
        assert_eq!(held[name], *value, "{held}");
    }
    talk.ask(json!({ "do": "step", "frames": 3 }));
    talk.ask(json!({ "do": "record" }));
    for frame in 0..12 {
        let buttons = if (2..9).contains(&frame) { vec!["left"] } else { vec![] };
        talk.ask(
            json!({ "do": "input", "cursor": [4 + 5 * frame, 30 - 2 * frame], "buttons": buttons, "wheel": [0, 2] }),
        );
        if frame == 6 {
            talk.ask(json!({ "do": "input", "keys": ["ShiftLeft"] }));
        }
        talk.ask(json!({ "do": "step" }));
    }
    let last = talk.ask(json!({ "do": "input" }));
    assert_eq!((&last["keys"], &last["cursor"]), (&json!(["ShiftLeft"]), &json!([59, 8])));
    talk.ask(json!({ "do": "screenshot", "path": "played.png" }));
    let refused = talk.say("{\"do\": \"stop\", \"name\": \"../away\"}");
    assert!(refused["error"].as_str().unwrap().contains("cannot be the name of a take"), "{refused}");
    let refused = talk.say("{\"do\": \"stop\", \"name\": \"paint\"}");
    assert!(refused["error"].as_str().unwrap().contains("is there already"), "{refused}");
    let written = talk.ask(json!({ "do": "stop" }));
    assert_eq!((&written["path"], &written["ended"]), (&json!("worlds/take.demo.toml"), &Value::Null));
    assert_eq!(written["seconds"], json!(0.4));
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());

    project.raxel(&["check", "worlds/take.demo.toml"]).exits(0);
    project.raxel(&["render", "worlds/take.demo.toml", "--frames", "12", "-o", "again.png"]).exits(0);
    let picture = |path: &str| image::open(project.path(path)).unwrap().into_rgba8();
    let (played, again) = (picture("played.png"), picture("again.png"));
    let colours: std::collections::HashSet<_> = played.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 3, "a stroke of some colours is on the canvas: {}", colours.len());
    assert!(played == again, "the take shows another picture");
}

/// The sound that a graph heard lies beside its take, which hears it again.
#[test]
fn a_take_of_a_program_sounds_the_same() {
    let project = Project::shipped();
    project.copy_folder("textures");
    let scene = ["graphs/examples/microphone.toml", "--world", "worlds/menger.toml", "--size", "64x36", "--fps", "30"];
    let mut talk = Talk::start(&mut command(project.root(), &[&["control"][..], &scene].concat()));
    for (path, why) in [
        ("textures/gone.ogg", "`textures/gone.ogg` does not exist"),
        ("textures/nots.ogg", "`textures/nots.ogg` does not exist: did you mean `textures/notes.ogg`?"),
        ("worlds/menger.toml", "`worlds/menger.toml` cannot be read: "),
        ("../a.wav", "`../a.wav` is not a path inside the project"),
    ] {
        let refused = talk.say(&json!({ "do": "input", "keys": ["Space"], "microphone": path }).to_string());
        assert!(refused["error"].as_str().unwrap().starts_with(why), "{refused}");
    }
    let heard = talk.ask(json!({ "do": "input" }));
    assert_eq!((&heard["microphone"], &heard["keys"]), (&json!(""), &json!([])), "a refused request changes nothing");
    let heard = talk.ask(json!({ "do": "input", "microphone": "textures/notes.ogg" }));
    assert_eq!(heard["microphone"], "textures/notes.ogg");
    talk.ask(json!({ "do": "record" }));
    talk.ask(json!({ "do": "step", "frames": 20 }));
    talk.ask(json!({ "do": "screenshot", "path": "played.png" }));
    let written = talk.ask(json!({ "do": "stop" }));
    assert_eq!((&written["path"], &written["ended"]), (&json!("worlds/take.demo.toml"), &Value::Null));
    // The sound of a take is replaced no more than its demo.
    std::fs::remove_file(project.path("worlds/take.demo.toml")).unwrap();
    talk.ask(json!({ "do": "record" }));
    talk.ask(json!({ "do": "step", "frames": 20 }));
    let refused = talk.say("{\"do\": \"stop\", \"name\": \"take\"}");
    assert!(refused["error"].as_str().unwrap().contains("`worlds/take.wav` is there already"), "{refused}");
    assert_eq!(talk.ask(json!({ "do": "stop" }))["path"], "worlds/take-2.demo.toml");
    assert_eq!(talk.ask(json!({ "do": "input", "microphone": "" }))["microphone"], "");
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());

    project.raxel(&["check", "worlds/take-2.demo.toml"]).exits(0);
    let [first, second] =
        ["worlds/take.wav", "worlds/take-2.wav"].map(|path| std::fs::read(project.path(path)).unwrap());
    assert!(first == second && first.len() == 44 + 2 * 19 * 1600, "{} bytes", first.len());
    project.raxel(&["render", "worlds/take-2.demo.toml", "--frames", "20", "-o", "again.png"]).exits(0);
    project.raxel(&["render", "graphs/examples/microphone.toml", "--size", "64x36", "-o", "silent.png"]).exits(0);
    let picture = |path: &str| image::open(project.path(path)).unwrap().into_rgba8();
    assert!(picture("played.png") == picture("again.png"), "the take shows another picture");
    assert!(picture("played.png") != picture("silent.png"), "it hears something");
}

/// Keys move the camera of a window. A flight is one step of undo, and so is a jump.
#[test]
fn a_flight_and_a_jump_are_undone() {
    let display = Display::start();
    let mut window = command(repository(), &[&["run", "--control", "--no-panels"][..], &SCENE].concat());
    let mut talk = Talk::start(window.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"));
    let mut name = String::new();
    eventually("the window", || {
        display.xdotool(&["search", "--name", "inspect"]).trim().clone_into(&mut name);
        !name.is_empty()
    });
    display.xdotool(&["windowfocus", "--sync", &name]);
    let mut camera = || talk.ask(json!({ "do": "camera" }))["position"].clone();
    let first = camera();
    // A busy machine may lose a key while the window takes the focus, so it is pressed until it has an effect.
    let press = |key: &str, camera: &mut dyn FnMut() -> Value, there: &Value| {
        let mut pressed: Option<Instant> = None;
        eventually(key, || {
            if pressed.is_none_or(|at| at.elapsed() > Duration::from_secs(5)) {
                display.xdotool(&["key", key]);
                pressed = Some(Instant::now());
            }
            camera() == *there
        });
    };
    display.xdotool(&["keydown", "w"]);
    eventually("the camera flies", || {
        display.xdotool(&["keydown", "w"]);
        camera() != first
    });
    std::thread::sleep(Duration::from_millis(300));
    display.xdotool(&["keyup", "w"]);
    // A flight has ended when the camera has rested for half a second.
    std::thread::sleep(Duration::from_secs(1));
    let flown = camera();
    press("Home", &mut camera, &first);
    press("ctrl+z", &mut camera, &flown);
    press("ctrl+z", &mut camera, &first);
    press("ctrl+y", &mut camera, &flown);
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// A take ends where another graph runs. It has the params of its own graph nevertheless.
#[test]
fn a_take_that_another_graph_has_ended_keeps_its_params() {
    let project = Project::shipped();
    let shader = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float red; };
void main() { imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(red)); }
";
    let graph = include_str!("../fixtures/window/bare.toml");
    project.write("graphs/bare.toml", graph).write("shaders/fill.comp", shader);
    project.write("graphs/other.toml", graph.replace("params.red", "params.glow").replace("param.red", "param.glow"));
    let scene = ["graphs/bare.toml", "--world", "worlds/menger.toml", "--size", "16x16"];
    let mut talk = Talk::start(&mut command(project.root(), &[&["control"][..], &scene].concat()));
    talk.ask(json!({ "do": "record" }));
    talk.ask(json!({ "do": "set", "param": "red", "value": 0.75 }));
    talk.ask(json!({ "do": "step", "frames": 2 }));
    talk.ask(json!({ "do": "open", "path": "graphs/other.toml" }));
    talk.ask(json!({ "do": "step" }));
    let stopped = talk.ask(json!({ "do": "stop" }));
    assert!(stopped["ended"].is_string(), "{stopped}");
    let text = std::fs::read_to_string(project.path("worlds/take.demo.toml")).unwrap();
    assert!(text.contains("[tracks.\"red\"]") && text.contains("0.75"), "{text}");
}
