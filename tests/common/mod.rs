//! What tests of the binary share: running it, and throw-away projects.

#![allow(dead_code, unused_imports, reason = "each test file uses a part of this")]

mod child;
mod display;
mod faults;
mod lesser;
pub mod markdown;
mod vulkan;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub use child::{LIMIT, Running, Said, line, output, read_all};
pub use display::{Display, eventually};
pub use faults::{CALLS, Fault, Faults};
pub use lesser::{EXCEEDED, LEAST, Lesser, METAL, METAL_12, SLOW_DRIVER, SMALL};
pub use vulkan::before_vulkan;

/// GLSL that stands for a subgroup of 64.
pub const SUBGROUP_OF_64: &str = include_str!("subgroup_of_64.glsl");

/// The root of the repository.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where lighting systems are: raxel's own, and those that they are compared with.
pub const LIGHT: [&str; 2] = ["graphs/light", "graphs/rivals/light"];
/// Where the graphs of tracers are: raxel's own, and those that they are compared with.
pub const TRACERS: [&str; 2] = ["graphs/bench", "graphs/rivals/march"];

/// Project path of the shipped graph of that name in one of two folders; in the first if neither has it.
pub fn graph_in(folders: [&str; 2], name: &str) -> String {
    let [own, rival] = folders.map(|folder| format!("{folder}/{name}.toml"));
    if repository().join(&rival).exists() { rival } else { own }
}

/// What a run of the binary gave.
#[derive(Debug)]
pub struct Run {
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
    pub fn json(&self) -> Vec<serde_json::Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
    }

    /// Stops the test unless the exit code is this one. 101 (a panic) never is.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }
}

/// A command line of the binary in a folder.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raxel"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.env("NO_COLOR", "1").env_remove("CLICOLOR_FORCE").env_remove("RUST_BACKTRACE");
    // What one test keeps must not change what another sees.
    command.env("RAXEL_CACHE", "off");
    command
}

/// Runs the binary in a folder; it must end in time.
pub fn raxel_in(folder: &Path, arguments: &[&str]) -> Run {
    output(&mut command(folder, arguments)).into()
}

/// Runs the binary in the repository.
pub fn raxel(arguments: &[&str]) -> Run {
    raxel_in(repository(), arguments)
}

/// A project in a temporary folder.
pub struct Project {
    folder: tempfile::TempDir,
}

impl Project {
    /// A copy of the repository's graphs, shaders and worlds.
    pub fn shipped() -> Self {
        let project = Self::empty();
        for folder in ["graphs", "shaders", "worlds"] {
            project.copy_folder(folder);
        }
        project
    }

    /// A copy of a folder of the repository that is a project.
    pub fn copy_of(folder: &str) -> Self {
        let project = Self::empty();
        copy(&repository().join(folder), project.root());
        project
    }

    /// Adds a folder of the repository.
    pub fn copy_folder(&self, folder: &str) -> &Self {
        copy(&repository().join(folder), &self.path(folder));
        self
    }

    /// A project without a file.
    pub fn empty() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for sub in ["graphs", "shaders", "worlds"] {
            std::fs::create_dir(folder.path().join(sub)).unwrap();
        }
        Self { folder }
    }

    /// Its root.
    pub fn root(&self) -> &Path {
        self.folder.path()
    }

    /// A file of it.
    pub fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    /// Writes a file.
    pub fn write(&self, path: &str, bytes: impl AsRef<[u8]>) -> &Self {
        let path = self.path(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
        self
    }

    /// Replaces text in a file; the text must be there.
    pub fn edit(&self, path: &str, from: &str, to: &str) -> &Self {
        let old = std::fs::read_to_string(self.path(path)).unwrap();
        assert!(old.contains(from), "{path} has no {from:?}");
        self.write(path, old.replacen(from, to, 1))
    }

    /// Runs the binary in it.
    pub fn raxel(&self, arguments: &[&str]) -> Run {
        raxel_in(self.root(), arguments)
    }

    /// Every file of it, in order, without the `.raxel` folder.
    pub fn files(&self) -> Vec<String> {
        let mut found = Vec::new();
        list(self.root(), self.root(), &mut found);
        found.sort();
        found
    }
}

/// Makes a shared library of C in a project, for programs that are started with `LD_PRELOAD`. The compiler is the one that links Rust.
pub fn shared_library(project: &Project, name: &str, source: &str) -> PathBuf {
    let (from, to) = (project.path("library.c"), project.path(name));
    std::fs::write(&from, source).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", &format!("-Wl,-soname,{name}"), "-o"]).args([&to, &from]);
    Run::from(output(&mut compiler)).exits(0);
    to
}

fn list(root: &Path, folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().is_some_and(|name| name == ".raxel") {
            continue;
        }
        if path.is_dir() {
            list(root, &path, found);
        } else {
            found.push(path.strip_prefix(root).unwrap().display().to_string());
        }
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}
