//! Control by program: the protocol as lines, in the window too, and the Python package that speaks it.

#![cfg(unix)]

mod common;

use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use common::{Display, Project, Run, Running, Said, Talk, command, output, repository, shared_library};
use serde_json::{Value, json};

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

#[test]
fn lines_that_are_no_request_change_nothing() {
    let mut talk = Talk::start(&mut command(repository(), &[&["control"][..], &SCENE].concat()));
    let before = talk.ask(json!({ "do": "camera" }));
    for (line, said) in [
        ("{\"do\": ", "not JSON"),
        ("\"step\"", "a request is an object"),
        ("{\"do\": \"fly\"}", "unknown request `fly`"),
        ("{\"do\": \"step\", \"frame\": 2}", "unknown field `frame`"),
        ("{\"do\": \"set\", \"param\": \"sky_dpeth\", \"value\": 1}", "did you mean `sky_depth`"),
        ("{\"do\": \"set\", \"param\": \"sky_depth\", \"value\": {}}", "`value` is a number"),
        ("{\"do\": \"picture\"}", ""),
        ("{\"do\": \"screenshot\", \"path\": \"/no/folder/a.png\"}", "does not exist"),
        ("{\"do\": \"buffer\", \"buffer\": \"depth\", \"bytes\": 4}", ""),
    ] {
        let answer = talk.say(line);
        assert_eq!(answer["ok"], json!(false), "{line}: {answer}");
        assert!(answer["error"].as_str().unwrap().contains(said), "{line}: {answer}");
    }
    // Any id comes back, and the next request is done.
    assert_eq!(talk.say("{\"id\": [1, null], \"do\": \"reset\"}")["id"], json!([1, null]));
    let after = talk.ask(json!({ "do": "camera" }));
    assert_eq!(before, after);
    assert_eq!(talk.ask(json!({ "do": "step", "frames": 2 }))["frame"], json!(1));
    let pixel = talk.ask(json!({ "do": "pixel", "target": "hit", "x": 3, "y": 2 }));
    assert_eq!((pixel["format"].as_str(), pixel["values"].as_array().unwrap().len()), (Some("rg32ui"), 2));
    assert!(!talk.ask(json!({ "do": "timings" }))["passes"].as_array().unwrap().is_empty());
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

/// Every table of times has a row for every pass, and a pass that did not run is one of them.
#[test]
fn a_pass_that_did_not_run_has_a_row_too() {
    let project = numbers(
        &[("seven", ""), ("fin", "")],
        &[
            ("once", "set", "bind = { to = \"seven\" }\npush = { value = 7.0 }"),
            ("adds", "add", "every = { frames = 3 }\nbind = { sum = \"fin\" }\npush = { value = 1.0 }"),
        ],
    );
    let mut talk = control_numbers(&project);
    let early = talk.say(&json!({ "do": "timings" }).to_string());
    assert_eq!(early["error"], "no frame has run, so no pass has a time", "{early}");
    assert_eq!(early["help"], json!(["run a frame with `step`"]));
    for frame in 0..3 {
        talk.ask(json!({ "do": "step" }));
        let answer = talk.ask(json!({ "do": "timings" }));
        let rows: Vec<_> = answer["passes"].as_array().unwrap().iter().collect();
        assert_eq!(rows.iter().map(|row| &row["pass"]).collect::<Vec<_>>(), [&json!("once"), &json!("adds")]);
        assert_eq!(rows[1]["ran"], json!(frame == 0), "it is due every third frame: {answer}");
        assert!(rows.iter().all(|row| row["ran"] == json!(true) || row["milliseconds"].is_null()), "{answer}");
    }
}

#[test]
fn a_target_is_read_right_after_a_pass() {
    let keys = "bind = { sum = \"fin\" }\npush = { value = 7.0 }";
    let project = numbers(&[("fin", "clear = 0.0")], &[("one", "add", keys), ("two", "add", keys)]);
    let mut talk = control_numbers(&project);
    let read = json!({ "do": "pixel", "target": "fin", "after": "one", "x": 0, "y": 0 });
    talk.ask(json!({ "do": "step" }));
    let refused = talk.say(&read.to_string());
    assert!(refused["help"][0].as_str().unwrap().contains("`target`, \"fin,after=one\""), "{refused}");
    talk.ask(json!({ "do": "target", "target": "fin,after=one" }));
    talk.ask(json!({ "do": "step" }));
    assert_eq!(talk.ask(read)["values"], json!([7.0]));
    assert_eq!(texel(&mut talk, "fin", 0), json!(14.0), "the end of the frame as before");
}

/// A 3-D target with mips: the first pass writes the number of each texel, NaN at two of them, and -7 at one of mip 1.
const SLICES: &str = include_str!("fixtures/control/slices.comp");

#[test]
fn values_are_found_in_all_slices_and_counted_in_one() {
    let project = Project::empty();
    let pass = |mip: u32| {
        format!(
            r#"[[passes]]
name = "mip{mip}"
shader = "slices.comp"
dispatch = {{ threads = "fog", mip = {mip} }}
bind = {{ to = {{ target = "fog", mip = {mip} }} }}
push = {{ mip = {mip} }}
"#
        )
    };
    let head = r#"name = "numbers"
present = "fog"
[targets.fog]
format = "rg32f"
size = [4, 4, 4]
mips = 2
"#;
    project.write("graphs/numbers.toml", format!("{head}{}{}", pass(0), pass(1))).write("shaders/slices.comp", SLICES);
    let mut talk = control_numbers(&project);
    let find = |value: &str, channel: u32, more: Value| {
        let mut request = json!({ "do": "find", "target": "fog", "value": value, "channel": channel });
        request.as_object_mut().unwrap().extend(more.as_object().cloned().unwrap_or_default());
        request
    };
    let refused = talk.say(&find("nan", 0, json!({})).to_string());
    assert!(refused["error"].as_str().unwrap().contains("run a frame"), "{refused}");
    talk.ask(json!({ "do": "step" }));

    let place = |mip: u32, layer: u32, x: u32, y: u32| json!({ "mip": mip, "layer": layer, "x": x, "y": y });
    let first = talk.ask(find("nan", 1, json!({})));
    assert_eq!((&first["found"], &first["slices"]), (&place(0, 1, 1, 2), &json!(2)), "{first}");
    assert_eq!(first["values"], json!([25.0, "NaN"]));
    let second = talk.ask(find("nan", 1, json!({ "from": first["found"] })));
    assert_eq!(second["found"], place(0, 3, 3, 0));
    assert_eq!(talk.ask(find("nan", 1, json!({ "from": second["found"] })))["found"], first["found"], "round again");
    assert_eq!(talk.ask(find("nan", 1, json!({ "forward": false })))["found"], second["found"]);
    assert_eq!(talk.ask(find("smallest", 0, json!({})))["found"], place(1, 1, 1, 1));
    assert_eq!(talk.ask(find("largest", 0, json!({})))["found"], place(0, 3, 3, 3));
    assert_eq!(talk.ask(find("smallest", 0, json!({ "mip": 0 })))["found"], place(0, 0, 0, 0));
    let nothing = talk.ask(find("nan", 1, json!({ "mip": 1 })));
    assert_eq!((&nothing["found"], &nothing["slices"]), (&Value::Null, &json!(2)), "{nothing}");

    let found = talk.ask(json!({ "do": "statistics", "target": "fog", "layer": 1 }));
    let [red, green] = found["channels"].as_array().unwrap().as_slice() else { panic!("{found}") };
    assert_eq!((&red["smallest"], &red["largest"], &red["mean"]), (&json!(16.0), &json!(31.0), &json!(23.5)));
    assert_eq!((&green["nan"], &green["infinite"], &green["count"]), (&json!(1), &json!(0), &json!(16)));
    let bars = red["histogram"].as_array().unwrap();
    assert_eq!((bars.len(), bars.iter().filter_map(Value::as_u64).sum::<u64>()), (64, 16));

    for (request, said) in [
        (find("odd", 0, json!({})), "`value` must be one of `nan`, `infinite`, `smallest`, `largest`; got `odd`"),
        (find("nan", 2, json!({})), "`fog` has the channels 0 to 1; got 2"),
        (find("nan", 0, json!({ "mip": 2 })), "`fog` has no mip 2"),
        (find("nan", 0, json!({ "layer": 9 })), "`fog` has no layer 9"),
        (find("nan", 0, json!({ "from": place(1, 0, 2, 0) })), "`from` is no texel that is searched"),
        (find("nan", 0, json!({ "from": { "x": -1, "y": 0 } })), "`from`: invalid value"),
        (json!({ "do": "statistics", "target": "fig" }), "did you mean `fog`"),
    ] {
        let refused = talk.say(&request.to_string());
        assert!(refused["error"].as_str().is_some_and(|error| error.contains(said)), "{request}: {refused}");
    }
}

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

#[test]
fn a_closed_pipe_ends_it() {
    let talk = Talk::start(&mut command(repository(), &[&["control"][..], &SCENE].concat()));
    let Talk { mut child, requests, .. } = talk;
    drop(requests);
    assert!(child.finish().success());
}

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
    common::eventually("the value that was set", || {
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

/// Keys move the camera of a window. A flight is one step of undo, and so is a jump.
#[test]
fn a_flight_and_a_jump_are_undone() {
    let display = Display::start();
    let mut window = command(repository(), &[&["run", "--control", "--no-panels"][..], &SCENE].concat());
    let mut talk = Talk::start(window.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"));
    let mut name = String::new();
    common::eventually("the window", || {
        display.xdotool(&["search", "--name", "inspect"]).trim().clone_into(&mut name);
        !name.is_empty()
    });
    display.xdotool(&["windowfocus", "--sync", &name]);
    let mut camera = || talk.ask(json!({ "do": "camera" }))["position"].clone();
    let first = camera();
    // A busy machine may lose a key while the window takes the focus, so it is pressed until it has an effect.
    let press = |key: &str, camera: &mut dyn FnMut() -> Value, there: &Value| {
        let mut pressed: Option<Instant> = None;
        common::eventually(key, || {
            if pressed.is_none_or(|at| at.elapsed() > Duration::from_secs(5)) {
                display.xdotool(&["key", key]);
                pressed = Some(Instant::now());
            }
            camera() == *there
        });
    };
    display.xdotool(&["keydown", "w"]);
    common::eventually("the camera flies", || {
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

/// A window that is driven by a program which may not read.
struct Window {
    child: Running,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    messages: Said<String>,
}

impl Window {
    fn start(display: &Display, arguments: &[&str]) -> Self {
        let mut command =
            command(repository(), &[&["run", "--control", "--no-panels"], arguments, &SCENE[..]].concat());
        command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()));
        let requests = child.0.stdin.take().unwrap();
        let answers = BufReader::new(child.0.stdout.take().unwrap());
        let messages = Said::by(child.0.stderr.take().unwrap(), common::line);
        Self { child, requests, answers, messages }
    }
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
        let taken = flood.recv_timeout(common::LIMIT).expect("the window ends, and its pipe with it");
        assert!(!taken, "it has taken all requests before its frames (it reads: {reads})");
        assert!(child.finish().success());
    }
}

/// A program that reads its answers late has all of them, in order. Until then its requests wait.
#[test]
fn a_program_that_reads_late_has_every_answer() {
    const COUNT: usize = 1000;
    let display = Display::start();
    let Window { mut child, mut requests, mut answers, messages } = Window::start(&display, &[]);
    let sender = std::thread::spawn(move || {
        let text = "x".repeat(4096);
        for index in 0..COUNT {
            writeln!(requests, "{}", json!({ "id": [index, text], "do": "camera" })).unwrap();
        }
        requests
    });
    let complains = |line: &String| line.contains("the program does not read its answers");
    let complaint = std::iter::repeat_with(|| messages.next()).find(complains).unwrap();
    assert!(complaint.contains("read stdout while you send requests"), "{complaint}");
    let answers = std::iter::from_fn(|| common::line(&mut answers)).map(|line| serde_json::from_str(&line).unwrap());
    let mut answers = answers.filter(|line: &Value| line.get("event").is_none());
    for index in 0..COUNT {
        let answer = answers.next().unwrap();
        assert_eq!((&answer["id"][0], &answer["ok"]), (&json!(index), &json!(true)));
    }
    writeln!(sender.join().unwrap(), "{}", json!({ "do": "quit" })).unwrap();
    assert_eq!(answers.next().unwrap()["ok"], json!(true));
    assert!(child.finish().success());
    assert!(!messages.rest().iter().any(complains), "it is said once");
}

#[test]
fn a_line_that_is_too_long_is_refused() {
    let mut talk = Talk::start(&mut command(repository(), &[&["control"][..], &SCENE].concat()));
    let refused = talk.say(&json!({ "do": "target", "target": "x".repeat(5 << 20) }).to_string());
    assert_eq!(refused["error"], "the line has more than 4194304 bytes", "{refused}");
    talk.ask(json!({ "do": "info" }));
}

#[test]
fn the_python_package_passes_its_tests() {
    let python = Path::new("python/tests");
    let mut tests = Command::new("python3");
    tests.args(["-m", "unittest", "discover", "-v", "-s"]).arg(python).current_dir(repository());
    tests.env("PYTHONPATH", "python").env("PYTHONDONTWRITEBYTECODE", "1").env("RAXEL", env!("CARGO_BIN_EXE_raxel"));
    tests.env("RAXEL_CACHE", "off");
    let run: Run = output(tests.stdin(Stdio::null())).into();
    let run = run.exits(0);
    assert!(run.stderr.contains("\nOK"), "{}", run.stderr);

    let mut example = Command::new("python3");
    example.arg("python/examples/depth_profile.py").current_dir(repository()).stdin(Stdio::null());
    example.env("PYTHONPATH", "python").env("PYTHONDONTWRITEBYTECODE", "1").env("RAXEL", env!("CARGO_BIN_EXE_raxel"));
    example.env("RAXEL_CACHE", "off");
    let run = Run::from(output(&mut example)).exits(0);
    assert!(run.stdout.contains("graphs/inspect.toml") && run.stdout.contains("voxels"), "{}", run.stdout);
}

/// The part of RenderDoc that a program sees: the table of functions of its API 1.1.2. Each function prints its name when it is called.
const FAKE_RENDERDOC: &str = include_str!("fixtures/control/fake_renderdoc.c");

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
const WORK: &str = include_str!("fixtures/control/work.comp");

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
    common::eventually("the long pass takes longer than the short ones", || {
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

/// Stores a number in a target.
const SET: &str = r"#version 460
layout(local_size_x = 1) in;
layout(r32f) writeonly uniform image2D to;
layout(push_constant) uniform Push { float value; };
void main() { imageStore(to, ivec2(0), vec4(value)); }
";
/// Copies a target.
const COPY: &str = r"#version 460
layout(local_size_x = 1) in;
layout(r32f) readonly uniform image2D from;
layout(r32f) writeonly uniform image2D to;
void main() { imageStore(to, ivec2(0), imageLoad(from, ivec2(0))); }
";
/// Adds a number to the old value.
const ADD: &str = r"#version 460
layout(local_size_x = 1) in;
layout(r32f) uniform image2D sum;
layout(push_constant) uniform Push { float value; };
void main() { imageStore(sum, ivec2(0), imageLoad(sum, ivec2(0)) + value); }
";

/// A project with targets of 4×4 numbers (name, keys) and passes (name, shader, keys). It shows `fin`.
fn numbers(targets: &[(&str, &str)], passes: &[(&str, &str, &str)]) -> Project {
    let project = Project::empty();
    let mut graph = "name = \"numbers\"\npresent = \"fin\"\n".to_owned();
    for (name, keys) in targets {
        graph += &format!("[targets.{name}]\nformat = \"r32f\"\nsize = [4, 4]\n{keys}\n");
    }
    for (name, shader, keys) in passes {
        graph += &format!("[[passes]]\nname = \"{name}\"\nshader = \"{shader}.comp\"\ndispatch = [1, 1, 1]\n{keys}\n");
    }
    project.write("graphs/numbers.toml", graph);
    project.write("shaders/set.comp", SET).write("shaders/copy.comp", COPY).write("shaders/add.comp", ADD);
    project
}

fn control_numbers(project: &Project) -> Talk {
    Talk::start(&mut command(project.root(), &["control", "graphs/numbers.toml", "--size", "4x4"]))
}

fn texel(talk: &mut Talk, target: &str, mip: u32) -> Value {
    talk.ask(json!({ "do": "pixel", "target": target, "x": 0, "y": 0, "mip": mip }))["values"][0].clone()
}

/// Nothing shown depends on the last pass that writes `t`, nor on the only one that writes its mip 1.
#[test]
fn a_read_gives_what_the_last_writer_left() {
    for keys in ["", "keep = true", "history = 1", "init = 9.0"] {
        let project = numbers(
            &[("t", &format!("mips = 2\n{keys}")), ("fin", "")],
            &[
                ("a", "set", "bind = { to = { target = \"t\", mip = 0 } }\npush = { value = 1.0 }"),
                ("b", "copy", "bind = { from = { target = \"t\", mip = 0 }, to = \"fin\" }"),
                ("c", "set", "bind = { to = { target = \"t\", mip = 0 } }\npush = { value = 2.0 }"),
                ("d", "set", "bind = { to = { target = \"t\", mip = 1 } }\npush = { value = 3.0 }"),
            ],
        );
        let mut talk = control_numbers(&project);
        let refused = talk.say("{\"do\": \"pixel\", \"target\": \"t\", \"x\": 0, \"y\": 0}");
        assert!(refused["error"].as_str().unwrap().contains("run a frame first"), "{refused}");
        for _ in 0..3 {
            talk.ask(json!({ "do": "step" }));
            let read = [("t", 0), ("fin", 0), ("t", 1)].map(|(target, mip)| texel(&mut talk, target, mip));
            assert_eq!(json!(read), json!([2.0, 1.0, 3.0]), "`{keys}`");
        }
        // A point within a frame has a picture, but leaves no texels.
        talk.ask(json!({ "do": "target", "target": "t,after=a" }));
        talk.ask(json!({ "do": "step" }));
        let path = |file: &str| json!({ "do": "screenshot", "path": project.path(file) });
        let refused = talk.say(&path("t.exr").to_string());
        assert!(refused["error"].as_str().unwrap().contains("at the end"), "{refused}");
        talk.ask(path("t.png"));
    }
}

/// `fin` adds 10 in each frame. The picture does not need the other targets.
#[test]
fn a_read_runs_no_frame() {
    let project = numbers(
        &[("fin", "keep = true"), ("hidden", ""), ("count", "keep = true"), ("past", "history = 1")],
        &[
            ("fin", "add", "bind = { sum = \"fin\" }\npush = { value = 10.0 }"),
            ("hidden", "set", "bind = { to = \"hidden\" }\npush = { value = 1.0 }"),
            ("count", "add", "bind = { sum = \"count\" }\npush = { value = 1.0 }"),
            ("past", "copy", "bind = { from = \"count\", to = \"past\" }"),
        ],
    );
    let mut talk = control_numbers(&project);
    for frame in 1_u32..=6 {
        let said = talk.ask(json!({ "do": "step" }));
        assert_eq!(said["frame"], json!(frame - 1));
        if frame < 3 {
            continue;
        }
        // Another target is shown from the next frame on; this one has run.
        let shown = ["hidden", "count", "past", "fin"][frame as usize % 4];
        talk.ask(json!({ "do": "target", "target": shown }));
        let frame = f64::from(frame);
        for (target, value) in [("fin", 10.0 * frame), ("hidden", 1.0), ("count", frame), ("past", frame)] {
            assert_eq!(texel(&mut talk, target, 0), json!(value), "`{target}` after {frame} frames");
        }
        let before = talk.ask(json!({ "do": "pixel", "target": "past", "x": 0, "y": 0, "age": 1 }));
        assert_eq!(before["values"], json!([frame - 1.0]));
        assert_eq!(texel(&mut talk, "fin", 0), json!(10.0 * frame), "reading took no step");
    }
}
