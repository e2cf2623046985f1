//! Control by program: the protocol as lines, in the window too, and the Python package that speaks it.

#![cfg(unix)]

#[path = "../common/mod.rs"]
mod common;

mod events;
mod read;
mod requests;
mod takes;
mod windows;

use std::io::BufReader;
use std::process::{ChildStdin, ChildStdout, Stdio};

use common::{Display, Running, Said, command, repository};

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

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
