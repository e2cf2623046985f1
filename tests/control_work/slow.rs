//! A disk that is slow: frames of a window go on meanwhile.

use std::fs;
use std::io::Write as _;

use serde_json::{Value, json};

use crate::common::{Project, eventually, shared_library};
use crate::{Runs, Stage};

/// A graph whose frames print. Files and folders whose paths contain `held` are opened only while the gate is open; it is open at first.
fn slow(project: Project, runs: Runs, scene: &[&str], held: &str) -> Stage {
    project.write("graphs/printing.toml", include_str!("../fixtures/control_work/printing.toml"));
    project.write("shaders/printing.comp", include_str!("../fixtures/control_work/printing.comp"));
    let library = shared_library(&project, "libslow.so", include_str!("../common/slow_open.c"));
    let gate = project.path("gate");
    fs::write(&gate, "").unwrap();
    let scene = [&["graphs/printing.toml", "--size", "64x64"], scene].concat();
    let mut stage = Stage::with(project, runs, &scene, |command| {
        command.env("LD_PRELOAD", &library).env("GATE", &gate).env("HOLD", held);
    });
    stage.pictured("a picture", |picture| picture.as_str().is_some_and(|data| !data.is_empty()));
    stage
}

impl Stage {
    fn send(&mut self, request: &Value) {
        writeln!(self.talk.requests, "{request}").unwrap();
    }

    fn open_gate(&self) {
        fs::write(self.project.path("gate"), "").unwrap();
    }

    fn close_gate(&self) {
        fs::remove_file(self.project.path("gate")).unwrap();
    }

    /// Frames of a window go on, and no answer comes. A frame prints; there are at most a few prints from before.
    #[track_caller]
    fn goes_on(&self) {
        let mut frames = 0;
        while frames < 20 {
            let line = self.talk.line();
            assert!(line.get("event").is_some(), "{line}");
            frames += usize::from(line["event"] == json!("printed"));
        }
    }
}

/// Frames of a window go on while a picture is read that takes long, and another request gives it up.
#[test]
fn a_picture_that_is_slow_to_read_holds_up_no_frame_and_is_given_up() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = slow(Project::empty(), runs, &[], "slow.exr");
        let gate = stage.project.path("gate");
        stage.ask(json!({ "do": "screenshot", "path": "fast.exr" }));
        fs::copy(stage.project.path("fast.exr"), stage.project.path("slow.exr")).unwrap();
        let keep = json!({ "do": "keep", "path": "slow.exr" });

        stage.close_gate();
        stage.send(&keep);
        if runs == Runs::Window {
            stage.goes_on();
        }
        // Requests that need the picture wait for it.
        stage.send(&json!({ "do": "measure" }));
        fs::write(&gate, "").unwrap();
        assert_eq!(stage.talk.answer()["kept"], json!("slow.exr, 64 × 64"));
        assert_eq!(stage.talk.answer()["kept"], json!("slow.exr, 64 × 64"), "measured");

        for next in [json!({ "do": "keep" }), json!({ "do": "forget" }), json!({ "do": "quit" })] {
            fs::remove_file(&gate).unwrap();
            stage.send(&keep);
            stage.send(&next);
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

/// A file that was given up is read to its end, so a few are given up at once, and no more.
#[test]
fn at_most_two_pictures_that_are_slow_to_read_are_given_up() {
    let mut stage = slow(Project::empty(), Runs::Window, &[], "slow.exr");
    stage.ask(json!({ "do": "screenshot", "path": "fast.exr" }));
    fs::copy(stage.project.path("fast.exr"), stage.project.path("slow.exr")).unwrap();
    stage.close_gate();
    for given_up in [true, true, false] {
        stage.send(&json!({ "do": "keep", "path": "slow.exr" }));
        stage.send(&json!({ "do": "forget" }));
        if given_up {
            assert_eq!(stage.talk.answer()["ok"], json!(false));
            assert_eq!(stage.talk.answer()["ok"], json!(true));
        }
    }
    stage.goes_on();
    stage.open_gate();
    assert_eq!(stage.talk.answer()["kept"], json!("slow.exr, 64 × 64"));
    assert_eq!(stage.talk.answer()["ok"], json!(true));
    stage.ends();
}

#[test]
fn a_file_that_is_slow_to_write_holds_up_no_frame_and_answers_keep_their_order() {
    let mut stage = slow(Project::empty(), Runs::Window, &[], "slow/");
    fs::create_dir(stage.project.path("slow")).unwrap();
    for (path, request) in [
        ("slow/a.png", json!({ "do": "screenshot", "path": "slow/a.png" })),
        ("slow/a.exr", json!({ "do": "screenshot", "path": "slow/a.exr" })),
        ("slow/picture", json!({ "do": "picture", "path": "slow/picture" })),
        ("slow/texels", json!({ "do": "texels", "target": "color", "path": "slow/texels" })),
    ] {
        stage.close_gate();
        stage.send(&request);
        stage.send(&json!({ "do": "info", "id": "after it" }));
        stage.goes_on();
        assert!(!stage.project.path(path).exists(), "{path}");
        stage.open_gate();
        let answer = stage.talk.answer();
        assert_eq!((&answer["ok"], &answer["id"]), (&json!(true), &Value::Null), "{answer}");
        assert!(stage.project.path(path).exists(), "{path}");
        assert_eq!(stage.talk.answer()["id"], json!("after it"));
    }
    stage.ends();
}

#[test]
fn folders_that_are_slow_to_list_hold_up_no_frame() {
    let mut stage = slow(Project::empty(), Runs::Window, &[], "/graphs");
    stage.close_gate();
    stage.send(&json!({ "do": "files" }));
    stage.goes_on();
    stage.open_gate();
    assert_eq!(stage.talk.answer()["files"][0]["path"], json!("graphs/printing.toml"));
    stage.close_gate();
    stage.send(&json!({ "do": "open", "path": "graphs/printing.toml" }));
    stage.goes_on();
    stage.open_gate();
    assert_eq!(stage.talk.answer()["opened"], json!(true));
    // A short wait refuses no file before its folder is listed: it is opened all the same.
    stage.project.write("graphs/other.toml", stage.read("graphs/printing.toml").replace("\"printing\"", "\"other\""));
    stage.close_gate();
    stage.send(&json!({ "do": "open", "path": "graphs/other.toml", "seconds": 0 }));
    stage.goes_on();
    stage.open_gate();
    stage.talk.answer();
    eventually("it is opened", || stage.ask(json!({ "do": "info" }))["graph"] == json!("graphs/other.toml"));
    stage.ends();
}

const WORLD: &str = r##"name = "box"
[materials]
red = { albedo = "#ff0000" }
[[build]]
op = "box"
min = [0, 0, 0]
max = [4, 4, 4]
material = "red"
"##;

/// F12 writes the picture, F9 a take, and O lists files.
#[test]
fn keys_that_write_or_list_files_hold_up_no_frame() {
    let project = Project::empty();
    project.write("worlds/box.toml", WORLD);
    let mut stage = slow(project, Runs::Window, &["--world", "worlds/box.toml"], "/.raxel-:/graphs");
    let window = stage.display.as_ref().unwrap().xdotool(&["search", "--name", "printing"]).trim().to_owned();
    stage.display.as_ref().unwrap().xdotool(&["windowfocus", "--sync", &window]);
    let title = |stage: &Stage| stage.display.as_ref().unwrap().xdotool(&["getwindowname", &window]);
    let press = |stage: &Stage, key: &str| drop(stage.display.as_ref().unwrap().xdotool(&["key", key]));
    press(&stage, "F9");
    eventually("a take is recorded", || title(&stage).contains("recording"));
    let pictures = |stage: &Stage| {
        let is_picture = |entry: &fs::DirEntry| entry.path().extension().is_some_and(|extension| extension == "png");
        fs::read_dir(stage.project.root()).unwrap().map_while(Result::ok).filter(is_picture).count()
    };
    let take = stage.project.path("worlds/take.demo.toml");
    stage.close_gate();
    press(&stage, "F12");
    press(&stage, "F9");
    press(&stage, "o");
    stage.goes_on();
    assert!(pictures(&stage) == 0 && !take.exists());
    assert!(title(&stage).contains("recording"), "the take goes on until it is written");
    assert!(stage.refused(json!({ "do": "stop" })).contains("the take is being written"));
    stage.open_gate();
    eventually("the files are written", || pictures(&stage) == 1 && take.exists());
    eventually("the take has ended", || !title(&stage).contains("recording"));
    stage.ends();
}
