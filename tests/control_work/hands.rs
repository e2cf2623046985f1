//! What only a window has: its frame rate, its flight and its brush.

use std::process::Command;
use std::time::Duration;

use serde_json::json;

use crate::common::eventually;
use crate::{Runs, SCENE, Stage};

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
    std::thread::sleep(Duration::from_millis(2500));
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
