//! What shaders print, write and overrun is told.

use std::io::Write;

use serde_json::json;

use crate::common::{Project, Talk, command};

/// Prints of the frames of a request come before its answer; a failed assertion is among the diagnostics.
#[test]
fn what_shaders_print_is_an_event_before_the_answer() {
    let project = Project::shipped();
    let scene = ["control", "graphs/examples/print.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
    let mut talk = Talk::start(&mut command(project.root(), &scene));
    writeln!(talk.requests, "{}", json!({ "do": "step" })).unwrap();
    let printed = talk.line();
    assert_eq!(
        (&printed["event"], &printed["pass"], &printed["frame"]),
        (&json!("printed"), &json!("look"), &json!(0))
    );
    assert_eq!(printed["lines"].as_array().map(Vec::len), Some(1), "{printed}");
    assert_eq!(printed["lines"][0]["file"], "shaders/examples/print.comp");
    assert_eq!(talk.line()["frame"], 0);
    talk.reloaded(|| {
        project.edit("shaders/examples/print.comp", "rx_assert(!found || hit.t >= 0.0)", "rx_assert(pixel.x < 95)");
    });
    talk.ask(json!({ "do": "step" }));
    let found = talk.ask(json!({ "do": "diagnostics" }));
    assert_eq!(found["diagnostics"][0]["code"], "RX0412", "{found}");
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// A program switches the checks of bounds on and off: an access out of bounds is among the diagnostics while they are on.
#[test]
fn an_access_out_of_bounds_is_a_diagnostic_while_checks_are_on() {
    let project = Project::shipped();
    let far = "imageStore(outColor, pixel + 90, vec4(1));\n    rx_assert(!found";
    project.edit("shaders/examples/print.comp", "rx_assert(!found", far);
    let scene = ["control", "graphs/examples/print.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
    let mut talk = Talk::start(&mut command(project.root(), &scene));
    let beyond = |talk: &mut Talk| {
        talk.ask(json!({ "do": "reset" }));
        talk.ask(json!({ "do": "step" }));
        let found = talk.ask(json!({ "do": "diagnostics" }));
        let codes = found["diagnostics"].as_array().unwrap().iter().map(|found| found["code"].clone());
        codes.filter(|code| code == "RX0413").count()
    };
    assert_eq!(beyond(&mut talk), 0);
    for (on, found) in [(true, 1), (false, 0)] {
        let compiles = talk.ask(json!({ "do": "check_bounds", "on": on }));
        assert_eq!(compiles["compiles"], true);
        let after = &compiles["generation"];
        assert_eq!(talk.ask(json!({ "do": "wait_reload", "seconds": 60, "after": after }))["reloaded"], true);
        assert_eq!(talk.ask(json!({ "do": "check_bounds", "on": on }))["compiles"], false);
        assert_eq!(beyond(&mut talk), found);
    }
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// A program finds the line and the invocation that wrote a texel, of the same moment, and asking runs no frame.
#[test]
fn the_writers_of_a_texel_are_found() {
    let project = Project::shipped();
    let scene = ["control", "graphs/examples/print.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
    let mut talk = Talk::start(&mut command(project.root(), &scene));
    talk.ask(json!({ "do": "step" }));
    let texel = |x: u32| json!({ "do": "writers", "target": "color", "x": x, "y": 20 });
    let refused = talk.say(&texel(70).to_string());
    assert_eq!(
        (refused["ok"].clone(), refused["help"][0].clone()),
        (json!(false), json!("send `record_writes`, and then `wait_reload`"))
    );
    let records = talk.ask(json!({ "do": "record_writes" }));
    assert_eq!(records["compiles"], true);
    // What was asked holds before it is compiled.
    assert_eq!(talk.ask(json!({ "do": "record_writes" }))["compiles"], false);
    let after = &records["generation"];
    assert_eq!(talk.ask(json!({ "do": "wait_reload", "seconds": 60, "after": after }))["reloaded"], true);
    talk.ask(json!({ "do": "pause" }));
    let text = std::fs::read_to_string(project.root().join("shaders/examples/print.comp")).unwrap();
    let line = 1 + text.lines().position(|line| line.contains("imageStore")).unwrap();
    for (x, frame) in [(70, 1), (9, 2)] {
        assert_eq!(talk.ask(texel(x))["passes"], json!([]), "no frame has run for it");
        talk.ask(json!({ "do": "step" }));
        let found = talk.ask(texel(x));
        let [pass] = found["passes"].as_array().unwrap().as_slice() else { panic!("{found}") };
        let write = &pass["writes"][0];
        let values = talk.ask(json!({ "do": "pixel", "target": "color", "x": x, "y": 20 }))["values"].clone();
        assert_eq!(
            (&pass["count"], &pass["race"], &pass["frame"]),
            (&json!(1), &json!(false), &json!(frame)),
            "{found}"
        );
        assert_eq!((&write["file"], &write["line"]), (&json!("shaders/examples/print.comp"), &json!(line)), "{found}");
        assert_eq!((&write["invocation"], &write["workgroup"]), (&json!([x, 20, 0]), &json!([x / 8, 2, 0])), "{found}");
        assert_eq!(write["values"].as_array().unwrap().len(), values.as_array().unwrap().len());
    }
    for (wrong, said) in [
        (json!({ "do": "writers", "target": "color", "x": 96, "y": 0 }), "there is none at 96, 0"),
        (json!({ "do": "writers", "target": "none", "x": 0, "y": 0 }), "no target `none`"),
        (json!({ "do": "writers", "target": "color", "mip": 3, "x": 0, "y": 0 }), "mip"),
    ] {
        let refused = talk.say(&wrong.to_string());
        assert!(refused["error"].as_str().is_some_and(|error| error.contains(said)), "{refused}");
    }
    assert_eq!(talk.ask(json!({ "do": "record_writes", "on": false }))["compiles"], true);
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// A count that should be 0 is an event once, and among the diagnostics for as long as it lasts.
#[test]
fn a_full_queue_is_an_event_and_a_diagnostic() {
    let project = Project::shipped();
    project.edit("graphs/examples/warnings.toml", "count = 262144", "count = 64");
    let scene = ["control", "graphs/examples/warnings.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
    let mut talk = Talk::start(&mut command(project.root(), &scene));
    writeln!(talk.requests, "{}", json!({ "do": "step", "frames": 4 })).unwrap();
    let said = loop {
        let line = talk.line();
        if line["event"] == "diagnostic" {
            break line["diagnostic"].clone();
        }
    };
    assert_eq!(said["code"], "RX0411", "{said}");
    assert!(said["message"].as_str().unwrap().starts_with("pixels show the sky"), "{said}");
    let found = talk.ask(json!({ "do": "diagnostics" }));
    let codes: Vec<_> = found["diagnostics"].as_array().unwrap().iter().map(|found| found["code"].clone()).collect();
    assert_eq!(codes, ["RX0411"], "{found}");
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}
