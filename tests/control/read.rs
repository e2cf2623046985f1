//! Values of targets are read, found and counted.

use serde_json::{Value, json};

use crate::common::{Project, Talk, command};

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
const SLICES: &str = include_str!("../fixtures/control/slices.comp");

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
