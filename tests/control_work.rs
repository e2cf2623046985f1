//! What the panels of a window do, done by a program: other files, presets, values written into files, keys of demos, displays, comparisons.

#![cfg(unix)]

mod common;

use std::fs;
use std::io::Write;
use std::os::unix::fs::FileTypeExt;
use std::process::Command;

use common::{Display, FullDisk, Project, Talk, command, eventually, shared_library};
use serde_json::{Value, json};

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

/// Who runs the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Runs {
    Requests,
    Window,
}

/// A project of its own with a session over it, with or without a window.
struct Stage {
    talk: Talk,
    project: Project,
    runs: Runs,
    /// After the session: it ends under its window otherwise.
    display: Option<Display>,
}

impl Stage {
    fn start(runs: Runs, scene: &[&str]) -> Self {
        Self::over(Project::shipped(), runs, scene)
    }

    fn over(project: Project, runs: Runs, scene: &[&str]) -> Self {
        Self::with(project, runs, scene, |_| {})
    }

    fn with(project: Project, runs: Runs, scene: &[&str], change: impl FnOnce(&mut Command)) -> Self {
        let display = (runs == Runs::Window).then(Display::start);
        let verb: &[&str] = match runs {
            Runs::Requests => &["control"],
            Runs::Window => &["run", "--control", "--no-panels"],
        };
        let mut command = command(project.root(), &[verb, scene].concat());
        if let Some(display) = &display {
            command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        }
        change(&mut command);
        Self { talk: Talk::start(&mut command), project, runs, display }
    }

    #[track_caller]
    fn ask(&mut self, request: Value) -> Value {
        self.talk.ask(request)
    }

    /// The error of a request that is refused.
    #[track_caller]
    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn refused(&mut self, request: Value) -> String {
        let answer = self.talk.say(&request.to_string());
        assert_eq!(answer["ok"], json!(false), "{request}: {answer}");
        format!("{} {}", answer["error"].as_str().unwrap(), answer["help"])
    }

    /// Asks for a write, and waits until its file was read again.
    #[track_caller]
    fn write(&mut self, request: Value) -> Value {
        let answer = self.ask(request);
        let told = self.ask(json!({ "do": "wait_reload", "seconds": 60, "after": answer["generation"] }));
        assert_eq!(told["reloaded"], json!(true), "{told}");
        answer
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.project.path(path)).unwrap()
    }

    /// Lets a frame run; a window runs it by itself.
    fn frame(&mut self) {
        if self.runs == Runs::Requests {
            self.ask(json!({ "do": "step" }));
        }
    }

    /// Waits for a picture.
    #[track_caller]
    fn pictured(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let mut last = Value::Null;
        eventually(what, || {
            self.frame();
            let answer = self.talk.say(&json!({ "do": "picture" }).to_string());
            last = answer["data"].clone();
            answer["ok"] == json!(true) && is_it(&last)
        });
        last
    }

    fn ends(mut self) {
        self.ask(json!({ "do": "quit" }));
        assert!(self.talk.child.finish().success());
        drop(self.display);
    }
}

#[test]
fn another_file_opens_in_place_of_what_runs() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        let broken = stage.read("graphs/inspect.toml").replace("outDepth = \"depth\"", "outDepth = \"dept\"");
        stage.project.write("graphs/broken.toml", &broken);
        let files = stage.ask(json!({ "do": "files" }))["files"].clone();
        for (kind, path, runs) in [
            ("graph", "graphs/inspect.toml", true),
            ("graph", "graphs/broken.toml", false),
            ("world", "worlds/menger.toml", true),
            ("demo", "worlds/sponge.demo.toml", false),
        ] {
            let file = json!({ "kind": kind, "path": path, "runs": runs });
            assert!(files.as_array().unwrap().contains(&file), "{file}: {files}");
        }
        let refused = stage.refused(json!({ "do": "open", "path": "graphs/inspekt.toml" }));
        assert!(refused.contains("did you mean `graphs/inspect.toml`"), "{refused}");
        // With mistakes, the old files run on.
        let wrong = stage.ask(json!({ "do": "open", "path": "graphs/broken.toml" }));
        assert_eq!((&wrong["opened"], &wrong["diagnostics"][0]["code"]), (&json!(false), &json!("RX0100")), "{wrong}");
        assert_eq!(stage.ask(json!({ "do": "info" }))["graph"], "graphs/inspect.toml");
        let opened = stage.ask(json!({ "do": "open", "path": "worlds/sponge.demo.toml" }));
        assert_eq!((&opened["opened"], &opened["diagnostics"]), (&json!(true), &json!([])), "{opened}");
        let info = stage.ask(json!({ "do": "info" }));
        assert_eq!((&info["demo"], &info["graph"]), (&json!("worlds/sponge.demo.toml"), &json!("graphs/inspect.toml")));
        // A graph ends the demo, and runs over its world.
        stage.project.write("graphs/broken.toml", broken.replace("\"dept\"", "\"depth\""));
        assert_eq!(stage.ask(json!({ "do": "open", "path": "graphs/broken.toml" }))["opened"], json!(true));
        let info = stage.ask(json!({ "do": "info" }));
        assert_eq!((&info["demo"], &info["world"]), (&Value::Null, &json!("worlds/menger.toml")));
        assert_eq!(info["graph"], "graphs/broken.toml");
        stage.ends();
    }
}

/// A graph that inherits the param `sky_depth`.
fn with_child(project: &Project) {
    project.write("graphs/child.toml", "extends = \"inspect.toml\"\nname = \"child\"\n");
}

const CHILD: [&str; 5] = ["graphs/child.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

#[test]
fn presets_are_kept_and_applied() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], json!([]));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let saved = stage.ask(json!({ "do": "save_preset", "name": "far" }));
        assert_eq!(saved["path"], ".raxel/presets.toml", "{saved}");
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 70 }));
        let far = json!([{ "name": "far", "values": { "sky_depth": [50.0] } }]);
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], far);
        let applied = stage.ask(json!({ "do": "apply_preset", "name": "far" }));
        assert_eq!((&applied["changed"], &applied["left"]), (&json!(["sky_depth"]), &json!([])), "{applied}");
        assert_eq!(stage.ask(json!({ "do": "info" }))["params"][0]["value"], json!(50.0));
        // A user adds a param that the graph does not have.
        stage.project.edit(".raxel/presets.toml", "sky_depth = ", "gone = [1]\nsky_depth = ");
        let applied = stage.ask(json!({ "do": "apply_preset", "name": "far" }));
        assert_eq!((&applied["changed"], &applied["left"]), (&json!([]), &json!(["gone"])), "{applied}");
        for wrong in ["apply_preset", "delete_preset"] {
            let refused = stage.refused(json!({ "do": wrong, "name": "fahr" }));
            assert!(refused.contains("no preset `fahr`") && refused.contains("`far`"), "{refused}");
        }
        assert!(stage.refused(json!({ "do": "save_preset", "name": " " })).contains("`name` is empty"));
        let before = stage.read(".raxel/presets.toml");
        stage.ask(json!({ "do": "delete_preset", "name": "far" }));
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], json!([]));
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([".raxel/presets.toml"]));
        assert_eq!(stage.read(".raxel/presets.toml"), before);
        // A file that is no table of presets stays as it is.
        stage.project.write(".raxel/presets.toml", "\"graphs/inspect.toml\" = 3\n");
        assert!(stage.refused(json!({ "do": "save_preset", "name": "far" })).contains("must be a table"));
        stage.ends();
    }
}

#[test]
fn values_are_written_into_files_and_restored() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::shipped();
        with_child(&project);
        let mut stage = Stage::over(project, runs, &CHILD);
        let [child, inspect] = ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path));
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([]));
        let refused = stage.refused(json!({ "do": "write_params", "params": ["sky_dpeth"] }));
        assert!(refused.contains("did you mean `sky_depth`"), "{refused}");
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let written = stage.write(json!({ "do": "write_params", "params": ["sky_depth"] }));
        let file = json!([{ "path": "graphs/child.toml", "params": ["sky_depth"], "changed": true }]);
        assert_eq!((&written["files"], &written["refused"]), (&file, &json!([])), "{written}");
        assert_eq!(stage.read("graphs/child.toml"), format!("{child}\n[params.sky_depth]\ndefault = 50.0\n"));
        // The param follows its file from here on.
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].clone();
        stage.talk.reloaded(|| {
            stage.project.edit("graphs/child.toml", "50.0", "51.0");
        });
        assert_eq!(value(&mut stage), json!(51.0));
        assert!(stage.refused(json!({ "do": "undo_write" })).contains("edited since"));
        stage.project.write("graphs/child.toml", &child);
        stage.ask(json!({ "do": "wait_reload", "seconds": 60, "after": written["generation"].as_u64().unwrap() + 2 }));

        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 52 }));
        let written = stage.write(json!({ "do": "write_params", "params": ["sky_depth"], "to": "declared" }));
        assert_eq!(written["files"][0]["path"], "graphs/inspect.toml", "{written}");
        assert_eq!(stage.read("graphs/inspect.toml"), inspect.replacen("default = 0.0", "default = 52.0", 1));
        assert_eq!(stage.read("graphs/child.toml"), child);
        // The file is restored, and the session has the value as before the write.
        let undone = stage.write(json!({ "do": "undo_write" }));
        assert_eq!(undone["files"], json!(["graphs/inspect.toml"]));
        assert_eq!(stage.read("graphs/inspect.toml"), inspect);
        assert_eq!(value(&mut stage), json!(52.0));

        let world = stage.read("worlds/menger.toml");
        stage.ask(json!({ "do": "camera", "position": [1, 2, 3], "yaw": 30, "pitch": 0, "fov": 60 }));
        for wrong in ["", "a b", "a.b"] {
            let refused = stage.refused(json!({ "do": "write_camera", "name": wrong }));
            assert!(refused.contains("cannot be the name of a camera"), "{refused}");
        }
        let written = stage.write(json!({ "do": "write_camera", "name": "roof" }));
        assert_eq!((&written["path"], &written["changed"]), (&json!("worlds/menger.toml"), &json!(true)));
        let lines = "[cameras.roof]\nposition = [1.0, 2.0, 3.0]\nyaw = 30.0\npitch = 0.0\nfov = 60.0\n";
        assert!(stage.read("worlds/menger.toml").contains(lines), "{}", stage.read("worlds/menger.toml"));
        stage.ask(json!({ "do": "camera", "name": "roof" }));
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!(stage.read("worlds/menger.toml"), world);
        stage.ends();
    }
}

/// A graph that needs no world.
const PLAIN_GRAPH: &str = r#"
name = "plain"
present = "color"
[targets.color]
format = "rgba8"
[[passes]]
name = "fill"
shader = "plain.comp"
dispatch = { threads = "color" }
bind = { color = "color" }
"#;
const PLAIN_SHADER: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D color;
void main() { imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4(1.0)); }
";

#[test]
fn the_empty_world_has_no_file_for_a_camera() {
    let project = Project::empty();
    project.write("graphs/plain.toml", PLAIN_GRAPH).write("shaders/plain.comp", PLAIN_SHADER);
    let mut stage = Stage::over(project, Runs::Requests, &["graphs/plain.toml", "--size", "32x18"]);
    assert_eq!(stage.ask(json!({ "do": "info" }))["world"], Value::Null);
    assert!(stage.refused(json!({ "do": "write_camera", "name": "a" })).contains("empty world"));
    assert!(stage.refused(json!({ "do": "record_params" })).contains("a demo needs a world"));
    for request in [
        json!({ "do": "keys" }),
        json!({ "do": "move_key", "track": "camera", "key": 0, "to": 1 }),
        json!({ "do": "delete_key", "track": "camera", "key": 0 }),
        json!({ "do": "write_key" }),
    ] {
        let refused = stage.refused(request);
        assert!(refused.contains("no demo runs") && refused.contains("`open` opens one"), "{refused}");
    }
    stage.ends();
}

#[test]
fn keys_of_a_demo_are_moved_deleted_and_written() {
    const DEMO: &str = "worlds/sponge.demo.toml";
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &[DEMO, "--size", "32x18"]);
        stage.ask(json!({ "do": "pause" }));
        let keys = stage.ask(json!({ "do": "keys" }));
        assert_eq!((&keys["path"], &keys["duration"], &keys["drives"]), (&json!(DEMO), &json!(2.0), &json!(true)));
        let track =
            |name: &str, times: Value, movable: bool| json!({ "track": name, "keys": times, "movable": movable });
        let camera = |times: Value| track("camera", times, true);
        let captions = track("caption", json!([0.0]), true);
        let checks = keys["tracks"][2].clone();
        assert_eq!((&checks["track"], &checks["movable"]), (&json!("check"), &json!(false)), "{keys}");
        assert_eq!(keys["tracks"], json!([camera(json!([0.0, 0.9, 1.0])), captions, checks]));
        let text = stage.read(DEMO);
        for (request, said) in [
            (json!({ "do": "move_key", "track": "camera", "key": 1, "to": 1.0 }), "in order of time"),
            (json!({ "do": "move_key", "track": "camera", "key": 2, "to": 2.5 }), "at 0 to 2 s, got 2.5"),
            (json!({ "do": "move_key", "track": "camera", "key": 9, "to": 1.5 }), "no `time` of entry 10"),
            (json!({ "do": "move_key", "track": "check", "key": 0, "to": 1.5 }), "changed in the file"),
            (json!({ "do": "move_key", "track": "cameras", "key": 0, "to": 1.5 }), "`cameras` is no track"),
            (json!({ "do": "delete_key", "track": "tracks.fog", "key": 0 }), "no such key"),
            (json!({ "do": "write_key", "seconds": 3 }), "at 0 to 2 s, got 3"),
            (json!({ "do": "write_key", "param": "sky_dpeth" }), "did you mean `sky_depth`"),
        ] {
            let refused = stage.refused(request);
            assert!(refused.contains(said), "{refused}");
        }
        assert_eq!(stage.read(DEMO), text);
        let moved = stage.write(json!({ "do": "move_key", "track": "camera", "key": 1, "to": 0.5 }));
        assert_eq!((&moved["path"], &moved["changed"]), (&json!(DEMO), &json!(true)));
        assert_eq!(stage.read(DEMO), text.replacen("time     = 0.9", "time     = 0.5", 1));
        stage.write(json!({ "do": "delete_key", "track": "camera", "key": 1 }));
        assert_eq!(stage.ask(json!({ "do": "keys" }))["tracks"][0], camera(json!([0.0, 1.0])));
        // The camera as a key; then the demo flies there by itself.
        stage.ask(json!({ "do": "camera", "position": [300, 20, 300], "look_at": [0, 0, 0] }));
        assert_eq!(stage.ask(json!({ "do": "keys" }))["drives"], json!(false));
        stage.write(json!({ "do": "write_key", "seconds": 0.25 }));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 7 }));
        stage.write(json!({ "do": "write_key", "param": "sky_depth", "seconds": 0.25 }));
        let tracks = stage.ask(json!({ "do": "keys" }))["tracks"].clone();
        assert_eq!(tracks[0], camera(json!([0.0, 0.25, 1.0])));
        assert_eq!(tracks[1], track("tracks.sky_depth", json!([0.0, 0.24, 0.25]), true));
        assert_eq!(stage.ask(json!({ "do": "hand_back" }))["drives"], json!(true));
        stage.ask(json!({ "do": "seek", "seconds": 0.25 }));
        stage.frame();
        eventually("the demo flies", || {
            stage.talk.ask(json!({ "do": "camera" }))["position"] == json!([300.0, 20.0, 300.0])
        });
        for _ in 0..4 {
            stage.write(json!({ "do": "undo_write" }));
        }
        assert_eq!(stage.read(DEMO), text);
        stage.ends();
    }
}

/// The demo of 2 s at 10 frames a second ends after 20 frames.
#[test]
fn a_demo_starts_over_or_stays_at_its_end() {
    let mut stage = Stage::start(Runs::Requests, &["worlds/sponge.demo.toml", "--size", "32x18", "--fps", "10"]);
    stage.ask(json!({ "do": "loop" }));
    assert_eq!(stage.ask(json!({ "do": "step", "frames": 21 }))["seconds"], json!(2.0));
    let again = stage.ask(json!({ "do": "step", "frames": 2 }))["seconds"].as_f64().unwrap();
    assert!((again - 0.1).abs() < 1e-9, "{again}");
    stage.ask(json!({ "do": "loop", "on": false }));
    let end = stage.ask(json!({ "do": "step", "frames": 40 }))["seconds"].as_f64().unwrap();
    assert!((1.999..2.0).contains(&end), "{end}");
    stage.ends();
}

#[test]
fn a_target_is_shown_by_another_map() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        stage.ask(json!({ "do": "target", "target": "depth" }));
        stage.ask(json!({ "do": "pause" }));
        let graphs = json!({ "map": "turbo", "range": [0.0, 500.0], "channel": 0 });
        let used =
            |answer: &Value| json!({ "map": answer["map"], "range": answer["range"], "channel": answer["channel"] });
        assert_eq!(used(&stage.ask(json!({ "do": "display" }))), graphs);
        let turbo = stage.pictured("a picture", |_| true);
        for (request, said) in [
            (json!({ "do": "display", "map": "turbot" }), "did you mean `turbo`"),
            (json!({ "do": "display", "channel": 4 }), "`channel` must be in 0…3"),
            (json!({ "do": "display", "range": [1, 1] }), "the lower one first"),
            (json!({ "do": "display", "range": [0, 1e300] }), "the lower one first"),
            (json!({ "do": "display", "map": 3 }), "`map`: invalid type"),
        ] {
            let refused = stage.refused(request);
            assert!(refused.contains(said), "{refused}");
        }
        let gray = stage.ask(json!({ "do": "display", "map": "gray", "range": [0, 400] }));
        assert_eq!(used(&gray), json!({ "map": "gray", "range": [0.0, 400.0], "channel": 0 }));
        stage.pictured("another picture", |picture| *picture != turbo);
        assert_eq!(used(&stage.ask(json!({ "do": "display", "map": null }))), graphs);
        stage.pictured("the picture of the graph", |picture| *picture == turbo);
        stage.ask(json!({ "do": "target", "target": "world" }));
        assert!(stage.refused(json!({ "do": "display", "map": "gray" })).contains("`world` is a buffer"));
        stage.ends();
    }
}

#[test]
fn what_is_shown_is_measured_against_what_was_kept() {
    for runs in [Runs::Requests, Runs::Window] {
        // A window is no smaller.
        let mut stage = Stage::start(runs, &[&SCENE[..3], &["--size", "64x64"]].concat());
        stage.ask(json!({ "do": "pause" }));
        let start = stage.pictured("a picture", |_| true);
        let refused = stage.refused(json!({ "do": "measure" }));
        assert!(refused.contains("no picture is kept") && refused.contains("`keep` keeps"), "{refused}");
        stage.ask(json!({ "do": "screenshot", "path": "a.exr" }));
        stage.ask(json!({ "do": "screenshot", "path": "a.png" }));
        assert_eq!(stage.ask(json!({ "do": "keep" }))["kept"], "normal, 64 × 64");
        let same = stage.ask(json!({ "do": "measure" }));
        assert_eq!(
            (&same["differing"], &same["pixels"], &same["flip"]),
            (&json!(0), &json!(4096), &json!(0.0)),
            "{same}"
        );
        assert_eq!((&same["of"], &same["kept"]), (&json!("normal"), &json!("normal, 64 × 64")));
        stage.ask(json!({ "do": "camera", "yaw": 10 }));
        stage.pictured("another picture", |picture| *picture != start);
        let moved = stage.ask(json!({ "do": "measure" }));
        stage.ask(json!({ "do": "screenshot", "path": "b.exr" }));
        // As `raxel compare` measures, which reads halves or floats of the same target.
        let compared = stage.project.raxel(&["compare", "a.exr", "b.exr", "--format", "json"]);
        let compared = &compared.json()[0];
        for figure in ["flip", "rmse", "max"] {
            let [here, there] = [&moved[figure], &compared[figure]].map(|value| value.as_f64().unwrap());
            assert!(here > 0.0 && (here - there).abs() < 1e-3, "{figure}: {moved} {compared}");
        }
        assert!(moved["differing"].as_u64() > Some(0), "{moved}");

        // A file, as `raxel compare` takes it.
        assert_eq!(stage.ask(json!({ "do": "keep", "path": "a.exr" }))["kept"], "a.exr, 64 × 64");
        assert_eq!(stage.ask(json!({ "do": "measure" }))["differing"], moved["differing"]);
        stage.ask(json!({ "do": "keep", "path": "a.png" }));
        assert!(stage.refused(json!({ "do": "measure" })).contains("`color` or `raw`"));
        // A target as it goes on.
        stage.ask(json!({ "do": "keep", "target": "normal" }));
        stage.frame();
        assert_eq!(stage.ask(json!({ "do": "measure" }))["differing"], json!(0));
        for (request, said) in [
            (json!({ "do": "keep", "path": "none.png" }), "`none.png` cannot be loaded"),
            (json!({ "do": "keep", "target": "nromal" }), "did you mean `normal`"),
            (json!({ "do": "keep", "target": "normal,after=inspect" }), "not what the frame ends with"),
            (json!({ "do": "keep", "path": "a.png", "target": "normal" }), "exclude each other"),
            (json!({ "do": "compare", "mode": "blink" }), "`mode`: unknown variant `blink`"),
            (json!({ "do": "compare", "gain": 0 }), "`gain` must be in"),
        ] {
            let refused = stage.refused(request);
            assert!(refused.contains(said), "{refused}");
        }
        stage.ask(json!({ "do": "forget" }));
        assert!(stage.refused(json!({ "do": "measure" })).contains("no picture is kept"));
        stage.ends();
    }
}

#[test]
fn only_a_window_shows_a_comparison_and_gives_a_pass_up() {
    let mut stage = Stage::start(Runs::Requests, &SCENE);
    for request in ["cancel", "compare", "fps_cap", "fly_speed", "brush"] {
        let refused = stage.refused(json!({ "do": request }));
        assert!(refused.contains("needs a window") && refused.contains("raxel run --control"), "{refused}");
    }
    stage.ends();

    let mut stage = Stage::start(Runs::Window, &[&SCENE[..], &["--target", "depth"]].concat());
    stage.ask(json!({ "do": "pause" }));
    let start = stage.pictured("a picture", |_| true);
    stage.ask(json!({ "do": "keep" }));
    stage.ask(json!({ "do": "compare", "mode": "difference", "gain": 2 }));
    let black = vec![[0; 3]; 32 * 18];
    let screen = |stage: &Stage| stage.display.as_ref().unwrap().pixels(32, 18);
    eventually("a difference of nothing", || screen(&stage) == black);
    stage.ask(json!({ "do": "compare", "flipped": true }));
    eventually("the kept picture alone", || screen(&stage) != black);
    stage.ask(json!({ "do": "compare", "mode": "off" }));
    assert_eq!(stage.ask(json!({ "do": "cancel" }))["cancelled"], json!(false));
    stage.pictured("the same picture", |picture| *picture == start);
    stage.ends();
}

#[test]
fn a_window_has_a_frame_rate_a_speed_of_flight_and_a_brush() {
    // A window is no smaller.
    let mut stage = Stage::start(Runs::Window, &[&SCENE[..3], &["--size", "64x64"]].concat());
    stage.ask(json!({ "do": "pause" }));
    let start = stage.pictured("a picture", |_| true);
    let frame = |stage: &mut Stage| stage.ask(json!({ "do": "step" }))["frame"].as_u64().unwrap();
    assert_eq!(stage.ask(json!({ "do": "fps_cap" }))["fps"], json!(0));
    assert_eq!(stage.ask(json!({ "do": "fps_cap", "fps": 1 }))["fps"], json!(1));
    let first = frame(&mut stage);
    std::thread::sleep(std::time::Duration::from_millis(2500));
    let slow = frame(&mut stage);
    assert!(slow - first <= 5, "{first} {slow}");
    assert_eq!(stage.ask(json!({ "do": "fps_cap", "fps": 0 }))["fps"], json!(0));
    eventually("frames run as fast as they may", || frame(&mut stage) > slow + 20);

    let screen = stage.display.as_ref().unwrap().name.clone();
    let keys = |arguments: &[&str]| {
        Command::new("xdotool").args(arguments).env("DISPLAY", &screen).output().unwrap();
    };
    let window = stage.display.as_ref().unwrap().xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    keys(&["windowfocus", "--sync", &window]);
    let place = |stage: &mut Stage| {
        let camera = stage.ask(json!({ "do": "camera" }));
        [0, 1, 2].map(|axis| camera["position"][axis].as_f64().unwrap())
    };
    let from = |stage: &mut Stage, start: [f64; 3]| {
        let now = place(stage);
        (0..3).map(|axis| (now[axis] - start[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let home = place(&mut stage);
    assert_eq!(stage.ask(json!({ "do": "fly_speed", "voxels": 0.1 }))["voxels"], json!(0.1));
    eventually("it flies slowly", || {
        keys(&["keydown", "w"]);
        from(&mut stage, home) > 0.0
    });
    keys(&["keyup", "w"]);
    let flown = from(&mut stage, home);
    assert!(flown < 50.0, "{flown}");
    stage.ask(json!({ "do": "fly_speed", "voxels": 100_000 }));
    eventually("it flies fast", || {
        keys(&["keydown", "w"]);
        from(&mut stage, home) > 1000.0
    });
    keys(&["keyup", "w"]);
    assert_eq!(stage.ask(json!({ "do": "fly_speed" }))["voxels"], json!(100_000.0));

    // A brush of the program, pressed by the mouse.
    keys(&["key", "Home"]);
    stage.pictured("where it began", |picture| *picture == start);
    let brush = stage.ask(json!({ "do": "brush" }));
    assert_eq!(
        (&brush["effect"], &brush["shape"], &brush["material"]),
        (&json!("subtract"), &json!("sphere"), &json!(""))
    );
    let refused = stage.refused(json!({ "do": "brush", "size": 3, "material": "none of it" }));
    assert!(refused.contains("the world has no material `none of it`"), "{refused}");
    assert_eq!(stage.ask(json!({ "do": "brush" })), brush);
    let wide = stage.ask(json!({ "do": "brush", "shape": "box", "size": 129, "height": 2, "effect": "add" }));
    assert_eq!(
        (&wide["shape"], &wide["size"], &wide["height"], &wide["effect"]),
        (&json!("box"), &json!(129), &json!(2), &json!("add"))
    );
    eventually("the key makes it smaller", || {
        keys(&["key", "bracketleft"]);
        stage.talk.ask(json!({ "do": "brush" }))["size"].as_u64() < Some(129)
    });
    stage.pictured("a box is added", |picture| {
        keys(&["mousemove", "32", "32", "click", "3"]);
        *picture != start
    });
    while stage.ask(json!({ "do": "undo" }))["undone"] == json!(true) {}
    stage.pictured("the world as it was", |picture| *picture == start);
    stage.ends();
}

/// Brings a paused session to a time.
fn go_to(stage: &mut Stage, seconds: f64) {
    stage.ask(json!({ "do": "seek", "seconds": seconds }));
    eventually("the time", || {
        stage.frame();
        let keys = stage.talk.ask(json!({ "do": "keys" }));
        (keys["seconds"].as_f64().unwrap() - seconds).abs() < 1e-9
    });
}

#[test]
fn params_that_a_program_sets_become_keys_of_the_demo() {
    const DEMO: &str = "worlds/sponge.demo.toml";
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &[DEMO, "--size", "32x18"]);
        stage.ask(json!({ "do": "pause" }));
        stage.pictured("a picture", |_| true);
        let text = stage.read(DEMO);
        let set =
            |stage: &mut Stage, value: f64| stage.ask(json!({ "do": "set", "param": "sky_depth", "value": value }));
        let nothing = stage.ask(json!({ "do": "record_params", "on": false }));
        assert_eq!((&nothing["path"], &nothing["tracks"]), (&Value::Null, &json!([])));
        stage.ask(json!({ "do": "record_params" }));
        go_to(&mut stage, 0.5);
        set(&mut stage, 10.0);
        go_to(&mut stage, 1.0);
        assert!(stage.refused(json!({ "do": "set", "param": "sky_depth", "value": "far" })).contains("sky_depth"));
        set(&mut stage, 30.0);
        go_to(&mut stage, 1.5);
        // The demo drives everything else.
        assert_eq!(stage.ask(json!({ "do": "keys" }))["drives"], json!(true));
        let written = stage.write(json!({ "do": "record_params", "on": false }));
        assert_eq!((&written["path"], &written["changed"]), (&json!(DEMO), &json!(true)), "{written}");
        assert_eq!(written["tracks"], json!([{ "track": "tracks.sky_depth", "keys": 3 }]));
        let keys = stage.ask(json!({ "do": "keys" }));
        let track = json!({ "track": "tracks.sky_depth", "keys": [0.0, 0.49, 0.5, 1.0, 1.5], "movable": true });
        assert!(keys["tracks"].as_array().unwrap().contains(&track), "{keys}");
        // It plays the motion, without a hand that drives.
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].as_f64().unwrap();
        go_to(&mut stage, 0.75);
        assert!((value(&mut stage) - 20.0).abs() < 1e-3, "{}", value(&mut stage));
        go_to(&mut stage, 1.25);
        assert!((value(&mut stage) - 30.0).abs() < 1e-3, "{}", value(&mut stage));
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!(stage.read(DEMO), text);
        stage.ends();
    }
}

#[test]
fn params_that_a_program_sets_make_a_demo_which_undo_takes_back() {
    const TAKE: &str = "worlds/take.demo.toml";
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        stage.ask(json!({ "do": "pause" }));
        stage.pictured("a picture", |_| true);
        let before = stage.ask(json!({ "do": "info" }));
        stage.ask(json!({ "do": "record_params" }));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 5 }));
        let made = stage.write(json!({ "do": "record_params", "on": false }));
        assert_eq!(made["path"], json!(TAKE));
        assert!(stage.read(TAKE).contains("[tracks.sky_depth]"));
        assert_eq!(stage.ask(json!({ "do": "info" }))["demo"], json!(TAKE));
        let undone = stage.write(json!({ "do": "undo_write" }));
        assert_eq!(undone["files"], json!([TAKE]), "{undone}");
        assert!(!stage.project.path(TAKE).exists());
        let info = stage.ask(json!({ "do": "info" }));
        assert_eq!((&info["demo"], &info["graph"], &info["world"]), (&Value::Null, &before["graph"], &before["world"]));
        stage.ends();
    }
}

/// Holds the first program that opens a file of the name `slow.exr`, until there is a file `GATE`.
const SLOW: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
static void hold(const char *path) {
    size_t length = strlen(path);
    if (length < 8 || strcmp(path + length - 8, "slow.exr")) return;
    while (access(getenv("GATE"), F_OK)) usleep(1000);
}
#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        va_list more; \
        va_start(more, flags); \
        int mode = va_arg(more, int); \
        va_end(more); \
        hold(path); \
        return ((int (*)(const char *, int, ...))dlsym(RTLD_NEXT, #name))(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)
"#;

/// A graph whose pass prints in each frame.
const PRINTING: [(&str, &str); 2] = [
    (
        "graphs/printing.toml",
        "name = \"printing\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba8\"\n\
         [[passes]]\nname = \"print\"\nshader = \"printing.comp\"\ndispatch = { threads = \"color\" }\n\
         bind = { color = \"color\" }\npush = { frame = \"frame.index\" }\n",
    ),
    (
        "shaders/printing.comp",
        "#version 460\n#extension GL_EXT_debug_printf : require\nlayout(local_size_x = 8, local_size_y = 8) in;\n\
         layout(rgba8) uniform writeonly image2D color;\nlayout(push_constant) uniform Push { uint frame; } push;\n\
         void main() {\n    imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4(0.5));\n    \
         if (gl_GlobalInvocationID.xy == uvec2(0)) debugPrintfEXT(\"frame %u\", push.frame);\n}\n",
    ),
];

/// Frames of a window go on while a picture is read that takes long, and another request gives it up.
#[test]
fn a_picture_that_is_slow_to_read_holds_up_no_frame_and_is_given_up() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::empty();
        for (path, text) in PRINTING {
            project.write(path, text);
        }
        let slow = shared_library(&project, "libslow.so", SLOW);
        let gate = project.path("gate");
        let scene = ["graphs/printing.toml", "--size", "64x64"];
        let mut stage = Stage::with(project, runs, &scene, |command| {
            command.env("LD_PRELOAD", &slow).env("GATE", &gate);
        });
        stage.pictured("a picture", |picture| picture.as_str().is_some_and(|data| !data.is_empty()));
        stage.ask(json!({ "do": "screenshot", "path": "fast.exr" }));
        fs::copy(stage.project.path("fast.exr"), stage.project.path("slow.exr")).unwrap();
        let keep = json!({ "do": "keep", "path": "slow.exr" });
        let send = |stage: &mut Stage, request: &Value| writeln!(stage.talk.requests, "{request}").unwrap();

        send(&mut stage, &keep);
        if runs == Runs::Window {
            // A frame prints; there are at most a few from before the request.
            let mut frames = 0;
            while frames < 20 {
                let line = stage.talk.line();
                assert!(line.get("event").is_some(), "{line}");
                frames += usize::from(line["event"] == json!("printed"));
            }
        }
        // Requests that need the picture wait for it.
        send(&mut stage, &json!({ "do": "measure" }));
        fs::write(&gate, "").unwrap();
        assert_eq!(stage.talk.answer()["kept"], json!("slow.exr, 64 × 64"));
        assert_eq!(stage.talk.answer()["kept"], json!("slow.exr, 64 × 64"), "measured");

        for next in [json!({ "do": "keep" }), json!({ "do": "forget" }), json!({ "do": "quit" })] {
            fs::remove_file(&gate).unwrap();
            send(&mut stage, &keep);
            send(&mut stage, &next);
            let given_up = stage.talk.answer();
            let error = given_up["error"].as_str().unwrap_or_default();
            assert!(error.contains("the next request gave it up"), "{given_up}");
            assert_eq!(stage.talk.answer()["ok"], json!(true), "{next}");
            if next["do"] == json!("quit") {
                break;
            }
            // It does not come later either.
            fs::write(&gate, "").unwrap();
            let answer = stage.talk.say(&json!({ "do": "measure" }).to_string());
            match next["do"].as_str() {
                Some("keep") => assert_ne!(answer["kept"], json!("slow.exr, 64 × 64"), "{answer}"),
                _ => assert!(answer["error"].as_str().unwrap().contains("no picture is kept"), "{answer}"),
            }
        }
        assert!(stage.talk.child.finish().success());
        fs::write(&gate, "").unwrap();
    }
}

/// Works for minutes on the software driver: it leaves a loop after 65535 rounds, so a round is long and the groups are many.
const SPIN: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
#define STEP x = fract(x * 1.37 + 0.11);
#define STEPS STEP STEP STEP STEP STEP STEP STEP STEP
void main() {
    float x = float(gl_GlobalInvocationID.x);
    for (int i = 0; i < 60000; ++i) { STEPS STEPS STEPS STEPS }
    imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(x));
}
";

#[test]
fn a_pass_that_does_not_end_is_given_up_by_a_request() {
    let project = Project::empty();
    project.write(
        "graphs/spin.toml",
        "name = \"spin\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba32f\"\nsize = [4096, 4096]\n\
         [[passes]]\nname = \"spin\"\nshader = \"spin.comp\"\ndispatch = { threads = \"color\" }\n\
         bind = { outColor = \"color\" }\n",
    );
    project.write("shaders/spin.comp", SPIN);
    let mut stage = Stage::over(project, Runs::Window, &["graphs/spin.toml", "--size", "320x180", "--watchdog", "600"]);
    eventually("the pass is given up", || {
        let answer = stage.talk.ask(json!({ "do": "cancel" }));
        answer["cancelled"] == json!(true) && answer["pass"] == json!("spin")
    });
    assert_eq!(stage.ask(json!({ "do": "cancel" }))["cancelled"], json!(false));
    stage.ends();
}

/// A program drives a window that nobody sees: it answers, and runs frames.
///
/// This cannot fail on X11 for want of redraws: winit hands them from `request_redraw` to the window through a queue of its own, whether the window
/// is mapped or not, and the server never sees them. On Wayland only `pre_present_notify` holds them back, which raxel does not call. Systems that
/// hold them back (Windows while it is minimised, macOS) are not here, so `engine/window/src/hidden.rs` tests what finds that out.
#[test]
fn a_hidden_window_answers() {
    let mut stage = Stage::start(Runs::Window, &SCENE);
    stage.ask(json!({ "do": "pause" }));
    stage.pictured("a picture", |_| true);
    let display = stage.display.as_ref().unwrap();
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowunmap", "--sync", &window]);
    for round in 0..3 {
        let value = f64::from(round) * 10.0 + 5.0;
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": value }));
        eventually("the value is in the target", || {
            let pixel = stage.talk.ask(json!({ "do": "pixel", "target": "depth", "x": 0, "y": 0 }));
            pixel["values"] == json!([value])
        });
        let refused = stage.refused(json!({ "do": "wait_reload", "seconds": 0.2 }));
        assert!(refused.contains("no edit came"), "{refused}");
    }
    stage.ends();
}

#[test]
fn bytes_come_in_a_file() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        stage.ask(json!({ "do": "pause" }));
        stage.pictured("a picture", |_| true);
        let path = stage.project.path("bytes");
        for request in [
            json!({ "do": "texels", "target": "depth" }),
            json!({ "do": "texels", "target": "hit" }),
            json!({ "do": "texels", "target": "normal" }),
            json!({ "do": "picture" }),
            json!({ "do": "buffer", "buffer": "world", "bytes": 64 }),
        ] {
            let mut text = stage.ask(request.clone());
            let data = text.as_object_mut().unwrap().remove("data").unwrap();
            let mut in_file = request.clone();
            in_file["path"] = json!(path);
            assert_eq!(stage.ask(in_file), text, "{request}");
            let expected = data_encoding::BASE64.decode(data.as_str().unwrap().as_bytes()).unwrap();
            assert!(!expected.is_empty() && fs::read(&path).unwrap() == expected, "{request}");
        }
        // Nothing else is left behind, and what cannot be written is refused.
        let files = fs::read_dir(stage.project.root()).unwrap().map(|entry| entry.unwrap().file_name());
        assert!(files.into_iter().all(|name| !name.to_string_lossy().starts_with(".raxel-")));
        let pipe = stage.project.path("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        for (path, said) in [
            (json!(pipe), "it is no regular file"),
            (json!("/dev/full"), "it is no regular file"),
            (json!(stage.project.root()), "it is a folder"),
            (json!(stage.project.path("none/bytes")), "does not exist"),
            (json!(""), "it names no file"),
        ] {
            let refused = stage.refused(json!({ "do": "texels", "target": "depth", "path": path }));
            assert!(refused.contains(said), "{refused}");
        }
        stage.ends();
    }
}

#[test]
fn a_full_disk_refuses_bytes_and_keeps_the_old_file() {
    let project = Project::shipped();
    let disk = FullDisk::with_room(1 << 10);
    let mut control = command(project.root(), &[&["control"][..], &SCENE].concat());
    let mut talk = Talk::start(disk.under(&mut control).env("RAXEL_CACHE", "off"));
    talk.ask(json!({ "do": "step" }));
    project.write("bytes", "old");
    let refused = talk.say(&json!({ "do": "texels", "target": "depth", "path": "bytes" }).to_string());
    let error = refused["error"].as_str().unwrap_or_default();
    assert!(error.contains("`bytes` cannot be written") && error.contains("No space left"), "{refused}");
    assert_eq!(fs::read_to_string(project.path("bytes")).unwrap(), "old");
    talk.ask(json!({ "do": "picture" }));
}

#[test]
fn a_value_that_is_set_after_the_write_stays() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        let before = stage.read("graphs/inspect.toml");
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].clone();
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let written = stage.ask(json!({ "do": "write_params", "params": ["sky_depth"] }));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 60 }));
        let told = stage.ask(json!({ "do": "wait_reload", "seconds": 60, "after": written["generation"] }));
        assert_eq!(told["reloaded"], json!(true), "{told}");
        assert_eq!(value(&mut stage), json!(60.0));
        // Nor does undo take it.
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!((stage.read("graphs/inspect.toml"), value(&mut stage)), (before, json!(60.0)));
        stage.ends();
    }
}

#[test]
fn files_that_were_edited_since_are_not_restored() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::shipped();
        let more = "[params.more]\ntype = \"f32\"\ndefault = 1.0\nrange = [0.0, 10.0]\n";
        project.write("graphs/child.toml", format!("extends = \"inspect.toml\"\nname = \"child\"\n\n{more}"));
        let mut stage = Stage::over(project, runs, &CHILD);
        let [child, inspect] = ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path));
        let write = |stage: &mut Stage| {
            stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
            stage.ask(json!({ "do": "set", "param": "more", "value": 2 }));
            let request = json!({ "do": "write_params", "params": ["sky_depth", "more"], "to": "declared" });
            let written = stage.ask(request);
            assert_eq!(written["files"].as_array().unwrap().len(), 2, "{written}");
            ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path))
        };

        // Refused, until one of them is as it was written.
        let [written_child, written_inspect] = write(&mut stage);
        stage.project.edit("graphs/child.toml", "default = 2.0", "default = 3.0");
        stage.project.edit("graphs/inspect.toml", "default = 50.0", "default = 51.0");
        let refused = stage.refused(json!({ "do": "undo_write" }));
        assert!(refused.contains("child.toml has been edited since"), "{refused}");
        assert!(refused.contains("inspect.toml has been edited since"), "{refused}");
        stage.project.write("graphs/child.toml", &written_child).write("graphs/inspect.toml", &written_inspect);
        let undone = stage.ask(json!({ "do": "undo_write" }));
        let files = json!(["graphs/inspect.toml", "graphs/child.toml"]);
        assert_eq!((&undone["files"], &undone["refused"]), (&files, &json!([])), "{undone}");
        assert_eq!([stage.read("graphs/child.toml"), stage.read("graphs/inspect.toml")], [child, inspect.clone()]);

        // The answer names the file that stays.
        write(&mut stage);
        stage.project.edit("graphs/child.toml", "default = 2.0", "default = 3.0");
        let undone = stage.ask(json!({ "do": "undo_write" }));
        assert_eq!(undone["files"], json!(["graphs/inspect.toml"]), "{undone}");
        let refused = undone["refused"].as_array().unwrap();
        assert!(refused.len() == 1 && refused[0].as_str().unwrap().contains("child.toml has been edited"), "{undone}");
        assert!(stage.read("graphs/child.toml").contains("default = 3.0"));
        assert_eq!(stage.read("graphs/inspect.toml"), inspect);
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([]));
        stage.ends();
    }
}
