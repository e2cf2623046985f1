//! What the panels of a window do, done by a program: other files, presets, values written into files, keys of demos, displays, comparisons.

#![cfg(unix)]

#[path = "../common/mod.rs"]
mod common;

mod bytes;
mod demos;
mod files;
mod hands;
mod passes;
mod shown;
mod slow;

use std::fs;
use std::process::Command;

use common::{Display, Project, Talk, command, eventually};
use serde_json::{Value, json};

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

/// Who runs the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Runs {
    Requests,
    Window,
}

/// A project of its own with a session over it, with or without a window.
struct Stage {
    talk: Talk,
    project: Project,
    runs: Runs,
    /// After the session: it ends under its window otherwise.
    display: Option<Display>,
}

impl Stage {
    fn start(runs: Runs, scene: &[&str]) -> Self {
        Self::over(Project::shipped(), runs, scene)
    }

    fn over(project: Project, runs: Runs, scene: &[&str]) -> Self {
        Self::with(project, runs, scene, |_| {})
    }

    fn with(project: Project, runs: Runs, scene: &[&str], change: impl FnOnce(&mut Command)) -> Self {
        let display = (runs == Runs::Window).then(Display::start);
        let verb: &[&str] = match runs {
            Runs::Requests => &["control"],
            Runs::Window => &["run", "--control", "--no-panels"],
        };
        let mut command = command(project.root(), &[verb, scene].concat());
        if let Some(display) = &display {
            command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        }
        change(&mut command);
        Self { talk: Talk::start(&mut command), project, runs, display }
    }

    #[track_caller]
    fn ask(&mut self, request: Value) -> Value {
        self.talk.ask(request)
    }

    /// The error of a request that is refused.
    #[track_caller]
    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn refused(&mut self, request: Value) -> String {
        let answer = self.talk.say(&request.to_string());
        assert_eq!(answer["ok"], json!(false), "{request}: {answer}");
        format!("{} {}", answer["error"].as_str().unwrap(), answer["help"])
    }

    /// Asks for a write, and waits until its file was read again.
    #[track_caller]
    fn write(&mut self, request: Value) -> Value {
        let answer = self.ask(request);
        let told = self.ask(json!({ "do": "wait_reload", "seconds": 60, "after": answer["generation"] }));
        assert_eq!(told["reloaded"], json!(true), "{told}");
        answer
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.project.path(path)).unwrap()
    }

    /// Lets a frame run; a window runs it by itself.
    fn frame(&mut self) {
        if self.runs == Runs::Requests {
            self.ask(json!({ "do": "step" }));
        }
    }

    /// Waits for a picture.
    #[track_caller]
    fn pictured(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let mut last = Value::Null;
        eventually(what, || {
            self.frame();
            let answer = self.talk.say(&json!({ "do": "picture" }).to_string());
            last = answer["data"].clone();
            answer["ok"] == json!(true) && is_it(&last)
        });
        last
    }

    fn ends(mut self) {
        self.ask(json!({ "do": "quit" }));
        assert!(self.talk.child.finish().success());
        drop(self.display);
    }
}
