//! A picture that takes long to read.

use std::fs;
use std::io::Write as _;

use serde_json::{Value, json};

use crate::common::{Project, shared_library};
use crate::{Runs, Stage};

/// Frames of a window go on while a picture is read that takes long, and another request gives it up.
#[test]
fn a_picture_that_is_slow_to_read_holds_up_no_frame_and_is_given_up() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::empty();
        project.write("graphs/printing.toml", include_str!("../fixtures/control_work/printing.toml"));
        project.write("shaders/printing.comp", include_str!("../fixtures/control_work/printing.comp"));
        let slow = shared_library(&project, "libslow.so", include_str!("../common/slow_open.c"));
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
