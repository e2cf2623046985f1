//! Lines, their order and their limits.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::common::{Display, Run, Talk, command, line, output, repository};
use crate::{SCENE, Window};

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
    // There is a picture now, and no folder for it.
    let answer = talk.say("{\"do\": \"screenshot\", \"path\": \"/no/folder/a.png\"}");
    assert!(answer["error"].as_str().unwrap().contains("does not exist"), "{answer}");
    assert!(!talk.ask(json!({ "do": "timings" }))["passes"].as_array().unwrap().is_empty());
    talk.ask(json!({ "do": "quit" }));
    assert!(talk.child.finish().success());
}

#[test]
fn a_closed_pipe_ends_it() {
    let talk = Talk::start(&mut command(repository(), &[&["control"][..], &SCENE].concat()));
    let Talk { mut child, requests, .. } = talk;
    drop(requests);
    assert!(child.finish().success());
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
    let answers = std::iter::from_fn(|| line(&mut answers)).map(|line| serde_json::from_str(&line).unwrap());
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
