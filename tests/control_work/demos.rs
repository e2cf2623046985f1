//! A demo starts over, and its keys are changed.

use serde_json::{Value, json};

use crate::common::eventually;
use crate::{Runs, Stage};

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
