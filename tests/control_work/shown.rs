//! What is shown: its map, and what it is compared with.

use serde_json::{Value, json};

use crate::common::{RunRaxel, eventually};
use crate::{Runs, SCENE, Stage};

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

/// *Keep* is a key, and so is the next target: the user has pressed both before a frame runs.
#[test]
fn a_window_keeps_what_was_shown_when_the_key_was_pressed() {
    let mut stage = Stage::start(Runs::Window, &[&SCENE[..3], &["--size", "64x64"]].concat());
    stage.pictured("a picture", |_| true);
    let display = stage.display.as_ref().unwrap();
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    for _ in 0..3 {
        let key = |keys: &[&str]| stage.display.as_ref().unwrap().xdotool(&[&["key", "--delay", "0"], keys].concat());
        stage.talk.ask(json!({ "do": "forget" }));
        stage.talk.ask(json!({ "do": "target", "target": "normal" }));
        stage.talk.say(&json!({ "do": "picture" }).to_string());
        key(&["b", "Tab"]);
        let mut kept = Value::Null;
        eventually("a picture is kept", || {
            kept = stage.talk.say(&json!({ "do": "measure" }).to_string())["kept"].clone();
            kept.is_string()
        });
        assert_eq!(kept, json!("normal, generation 0, 64 × 64"));
    }
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
