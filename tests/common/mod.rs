//! Helpers of the tests of the binary: running it, alone and in projects.

#![allow(dead_code, unused_imports, reason = "each test file uses a part of this")]

mod disk;
mod faults;
mod lesser;
pub(crate) mod markdown;
mod talk;
mod vulkan;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub(crate) use disk::FullDisk;
pub(crate) use faults::{CALLS, Fault, Faults, chosen};
pub(crate) use lesser::*;
pub(crate) use raxel_testing::{
    Display, Folder, LIMIT, Project, Running, Said, copy, eventually, files, line, output, read_all, repository,
};
pub(crate) use talk::Talk;
pub(crate) use vulkan::before_vulkan;

/// GLSL that stands for a subgroup of 64.
pub(crate) const SUBGROUP_OF_64: &str = include_str!("subgroup_of_64.glsl");

/// The folders of lighting systems: raxel's own, and their rivals.
pub(crate) const LIGHT: [&str; 2] = ["graphs/light", "graphs/rivals/light"];
/// The folders of tracers' graphs: raxel's own, and their rivals.
pub(crate) const TRACERS: [&str; 2] = ["graphs/bench", "graphs/rivals/march"];

/// Project path of the shipped graph of that name in one of two folders; in the first if neither has it.
pub(crate) fn graph_in(folders: [&str; 2], name: &str) -> String {
    let [own, rival] = folders.map(|folder| format!("{folder}/{name}.toml"));
    if repository().join(&rival).exists() { rival } else { own }
}

/// The result of a run of the binary.
#[derive(Debug)]
pub(crate) struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(Output { status, stdout, stderr }: Output) -> Self {
        Self {
            code: status.code().unwrap_or(-1),
            stdout: String::from_utf8(stdout).expect("stdout is UTF-8"),
            stderr: String::from_utf8(stderr).expect("stderr is UTF-8"),
        }
    }
}

impl Run {
    /// The lines of stdout as JSON.
    pub(crate) fn json(&self) -> Vec<serde_json::Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
    }

    /// Stops the test unless the exit code is this one. 101 (a panic) never is.
    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }
}

/// A command line of the binary in a folder.
pub(crate) fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raxel"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.env("NO_COLOR", "1").env_remove("CLICOLOR_FORCE").env_remove("RUST_BACKTRACE");
    // A cache of one test must not change the results of another.
    command.env("RAXEL_CACHE", "off");
    command
}

/// Runs the binary in a folder; it must end in time.
pub(crate) fn raxel_in(folder: &Path, arguments: &[&str]) -> Run {
    output(&mut command(folder, arguments)).into()
}

/// Runs the binary in the repository.
pub(crate) fn raxel(arguments: &[&str]) -> Run {
    raxel_in(repository(), arguments)
}

/// The binary in a project.
pub(crate) trait RunRaxel {
    /// Runs the binary in it.
    fn raxel(&self, arguments: &[&str]) -> Run;
}

impl RunRaxel for Project {
    fn raxel(&self, arguments: &[&str]) -> Run {
        raxel_in(self.root(), arguments)
    }
}

/// Makes a shared library of C in a project, for programs that are started with `LD_PRELOAD`. The compiler is the one that links Rust.
pub(crate) fn shared_library(project: &Project, name: &str, source: &str) -> PathBuf {
    let (from, to) = (project.path("library.c"), project.path(name));
    std::fs::write(&from, source).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", &format!("-Wl,-soname,{name}"), "-o"]).args([&to, &from]);
    Run::from(output(&mut compiler)).exits(0);
    to
}
