//! A demo starts over, and its keys are changed.

use serde_json::{Value, json};

use crate::common::eventually;
use crate::{Runs, SCENE, Stage};

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
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].as_f64().unwrap();
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
        go_to(&mut stage, 0.75);
        assert!((value(&mut stage) - 20.0).abs() < 1e-3, "{}", value(&mut stage));
        go_to(&mut stage, 1.25);
        assert!((value(&mut stage) - 30.0).abs() < 1e-3, "{}", value(&mut stage));
        let recorded = stage.read(DEMO);
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!(stage.read(DEMO), text);
        // A demo that opens drives all of its params, also those that were recorded before.
        stage.project.write(DEMO, &recorded);
        stage.ask(json!({ "do": "open", "path": DEMO }));
        stage.ask(json!({ "do": "record_params" }));
        set(&mut stage, 7.0);
        stage.ask(json!({ "do": "open", "path": "worlds/menger.toml" }));
        stage.ask(json!({ "do": "open", "path": DEMO }));
        stage.ask(json!({ "do": "pause" }));
        go_to(&mut stage, 0.75);
        assert!((value(&mut stage) - 20.0).abs() < 1e-3, "{}", value(&mut stage));
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
