//! The launcher `./raxel`, with programs in the place of cargo and apt-get that only say how they were called.

#![cfg(unix)]

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A copy of the launcher in a folder of its own, and programs that are found before those of the system.
struct Launcher {
    folder: tempfile::TempDir,
    _alone: MutexGuard<'static, ()>,
}

/// A program that is written while another thread starts a process cannot be run: that process may still have it open.
static ALONE: Mutex<()> = Mutex::new(());

impl Launcher {
    fn new() -> Self {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let launcher = Self { folder: tempfile::tempdir().unwrap(), _alone: alone };
        fs::create_dir(launcher.path("bin")).unwrap();
        fs::copy(common::repository().join("raxel"), launcher.path("raxel")).unwrap();
        launcher.program("cargo", "echo \"cargo $* from ${SHADERC_LIB_DIR:-the system}\"");
        // A missing package is asked for, and not installed.
        launcher.program("id", "echo 0");
        launcher.program("apt-get", "exit 0");
        launcher
    }

    fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    fn program(&self, name: &str, script: &str) {
        let path = self.path(&format!("bin/{name}"));
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.path("raxel"));
        let path = format!("{}:{}", self.path("bin").display(), std::env::var("PATH").unwrap());
        command.args(arguments).env("PATH", path).stdin(Stdio::null());
        for name in ["SHADERC_LIB_DIR", "RAXEL_SHADERC", "CARGO_TARGET_DIR", "VULKAN_SDK"] {
            command.env_remove(name);
        }
        command
    }
}

fn texts(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (text(&output.stdout), text(&output.stderr))
}

#[test]
fn everything_is_tested_and_all_that_failed_is_listed_at_the_end() {
    let launcher = Launcher::new();
    launcher.program(
        "cargo",
        r"case $1 in
fmt) exit 1 ;;
clippy) exit 101 ;;
esac
echo '     Running unittests src/lib.rs (target/checked/deps/raxel_graph-0123456789abcdef)' >&2
echo 'test plan::tests::orders ... FAILED'
echo 'test plan::tests::aliases ... ok'
echo 'error: test failed, to rerun pass `-p raxel-graph --lib`' >&2
echo '     Running tests/cli/main.rs (target/checked/deps/cli-0123456789abcdef)' >&2
echo 'test words::help ... ok'
echo '     Running tests/hang.rs (target/checked/deps/hang-0123456789abcdef)' >&2
echo 'error: test failed, to rerun pass `-p raxel-runtime --test hang`' >&2
echo '   Doc-tests raxel' >&2
echo 'test engine/lib.rs - (line 3) ... FAILED'
exit 101",
    );
    let output = common::output(&mut launcher.command(&["test"]));
    let (_, said) = texts(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let (_, list) = said.split_once("raxel: these failed:\n").expect("a list");
    let expected = "  formatting\n  lints\n  tests\n    \
                    unit tests of raxel_graph: plan::tests::orders\n    \
                    tests/hang.rs: ended early (`-p raxel-runtime --test hang`)\n    \
                    examples in the docs of raxel: engine/lib.rs - (line 3)\n";
    assert_eq!(list, expected);
}

#[test]
fn what_failed_is_run_again_and_nothing_else() {
    let launcher = Launcher::new();
    launcher.program(
        "cargo",
        r#"echo "cargo $*" >>calls
[ "$1" = test ] || exit 0
echo '     Running tests/cli/main.rs (target/checked/deps/cli-0123456789abcdef)' >&2
echo 'error: could not compile `of_a_test` (lib)' >&2
echo 'test words::help ... FAILED'
echo 'error: test failed, to rerun pass `-p raxel --test cli`' >&2
exit 101"#,
    );
    let run = |arguments: &[&str]| {
        let _ = fs::remove_file(launcher.path("calls"));
        let output = common::output(&mut launcher.command(arguments));
        (output.status.code(), texts(&output).1, fs::read_to_string(launcher.path("calls")).unwrap_or_default())
    };
    assert_eq!(run(&["test"]).0, Some(1));
    let once_more = "cargo test --profile checked --no-fail-fast -p raxel --test cli\n";
    let (code, said, calls) = run(&["test", "--again"]);
    assert_eq!((code, calls.as_str()), (Some(1), once_more), "{said}");
    assert!(said.contains("    tests/cli/main.rs: words::help\n"), "{said}");
    // A test may compile what is wrong.
    assert!(!said.contains("    could not compile"), "{said}");

    launcher.program("cargo", "echo \"cargo $*\" >>calls");
    let (code, said, calls) = run(&["test", "--again"]);
    assert_eq!((code, calls.as_str()), (Some(0), once_more), "{said}");
    assert!(said.ends_with("raxel: tests: all passed\n"), "{said}");
    let (code, said, calls) = run(&["test", "--again"]);
    assert_eq!((code, calls.as_str()), (Some(2), ""), "{said}");

    // A test that does not compile fails again.
    launcher.program("cargo", "[ $1 != test ] || { echo 'error: could not compile `raxel` (lib)' >&2; exit 101; }");
    let (code, said, _) = run(&["test"]);
    assert!(code == Some(1) && said.contains("    could not compile `raxel` (lib)\n"), "{code:?} {said}");
    assert_eq!(run(&["test", "--again"]).0, Some(1));
}

#[test]
fn parts_have_names_and_say_how_long_they_took() {
    let launcher = Launcher::new();
    fs::copy(common::repository().join("ARCHITECTURE.md"), launcher.path("ARCHITECTURE.md")).unwrap();
    let run = |arguments: &[&str]| texts(&common::output(&mut launcher.command(arguments)));
    let (done, said) = run(&["test", "--no-device"]);
    let tests = done.lines().find(|line| line.starts_with("cargo test ")).expect("tests are run");
    for (part, runs) in
        [("-p raxel-graph ", true), ("-p raxel-gpu ", false), ("-p raxel-panels ", false), ("-p raxel ", false)]
    {
        assert_eq!(tests.contains(part), runs, "{part}: {tests}");
    }
    assert!(said.contains("raxel: formatting took ") && said.contains("raxel: lints took "), "{said}");
    let (done, _) = run(&["test", "--window"]);
    assert!(done.starts_with("cargo test ") && done.contains("--test window --test window_faults"), "{done}");

    launcher.program(
        "cargo",
        r"[ $1 = test ] || exit 0
echo '     Running unittests src/lib.rs (target/checked/deps/raxel_graph-0123456789abcdef)' >&2
echo 'test result: ok. 5 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 2.11s'
echo '     Running tests/cli/main.rs (target/checked/deps/cli-0123456789abcdef)' >&2
echo 'test result: ok. 5 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 120.49s'",
    );
    let (_, said) = run(&["test"]);
    let (_, longest) = said.split_once("raxel: these tests took longest:\n").expect("a list");
    assert!(
        longest.starts_with("     120.5 s  tests/cli/main.rs\n       2.1 s  unit tests of raxel_graph\n"),
        "{longest}"
    );
}

#[test]
fn nothing_failed_and_some_crates_only() {
    let launcher = Launcher::new();
    let output = common::output(&mut launcher.command(&["test", "-p", "raxel-shader"]));
    let (done, said) = texts(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.ends_with("raxel: formatting, lints, tests: all passed\n"), "{said}");
    for called in [
        "fmt --all --check",
        "clippy --profile checked -p raxel-shader",
        "test --profile checked --no-fail-fast -p raxel-shader",
    ] {
        assert!(done.contains(&format!("cargo {called}")), "{done}");
    }
}

#[test]
fn the_shader_compiler_is_built_from_source_when_asked_or_when_none_links() {
    let launcher = Launcher::new();
    let asked = common::output(launcher.command(&["test"]).env("RAXEL_SHADERC", "source"));
    let (done, said) = texts(&asked);
    assert!(done.contains(&format!("from {}", launcher.path(".raxel/from-source").display())), "{done}{said}");
    assert!(
        !launcher.path(".raxel/from-source").exists(),
        "cargo builds from source only where there is no such folder"
    );

    // The libraries do not link: the folder that cargo looks at must not be there.
    launcher.program("c++", "exit 1");
    launcher.program("ar", "cat >/dev/null");
    let (_, said) = texts(&common::output(&mut launcher.command(&["test"])));
    assert!(said.contains("building the shader compiler from source"), "{said}");
    let left: Vec<_> = fs::read_dir(launcher.path(".raxel")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["test.log"]);
}

/// The archives of a system merge into one that links and compiles a shader; or they are refused, and nothing is left of them.
#[test]
fn a_shader_compiler_of_the_system_is_tried_before_it_is_used() {
    let launcher = Launcher::new();
    let (_, said) = texts(&common::output(&mut launcher.command(&["test"])));
    let made = launcher.path(".raxel/shaderc/libshaderc_combined.a");
    assert_eq!(made.is_file(), said.contains("using the shader compiler in "), "{said}");
    assert_eq!(made.is_file(), !said.contains("compiler from source"), "{said}");
    assert!(!launcher.path(".raxel/shaderc.new").exists() && !launcher.path(".raxel/shaderc/try.cpp").exists());
    // The second time there is nothing to do.
    if made.is_file() {
        let again = || texts(&common::output(&mut launcher.command(&["test"]))).1;
        let said = again();
        assert!(!said.contains("shader compiler"), "{said}");
        // A folder that several systems share.
        fs::write(launcher.path(".raxel/shaderc/system"), "debian 99 Linux x86_64\n").unwrap();
        let said = again();
        assert!(
            said.contains("was built for another system") && said.contains("using the shader compiler in "),
            "{said}"
        );
    }
}

#[test]
fn an_old_rust_is_one_line() {
    let launcher = Launcher::new();
    fs::copy(common::repository().join("Cargo.toml"), launcher.path("Cargo.toml")).unwrap();
    let with = |version: &str| {
        launcher.program("cargo", &format!("echo \"cargo {version} (0123456789 2025-01-01)\""));
        let output = common::output(&mut launcher.command(&["test"]));
        (output.status.code(), texts(&output).1)
    };
    let (code, said) = with("1.85.0");
    let needed = env!("CARGO_PKG_RUST_VERSION");
    let expected = format!("raxel: Rust {needed} or newer is needed, and this is 1.85: https://rustup.rs\n");
    assert_eq!((code, said.as_str()), (Some(2), expected.as_str()));
    assert_eq!(with("1.999.0").0, Some(0));
}

/// A binary in the place of the built one, which prints its arguments.
#[test]
fn the_demo_is_that_of_the_binary_with_every_option() {
    let launcher = Launcher::new();
    fs::create_dir_all(launcher.path("target/release")).unwrap();
    launcher.program("../target/release/raxel", "echo \"raxel $*\"");
    for words in [&["demo"][..], &["demo", "fair", "--size", "160x90"], &["demo", "--size=160x90", "-o", "there"]] {
        let (done, said) = texts(&common::output(&mut launcher.command(words)));
        assert!(done.ends_with(&format!("raxel {}\n", words.join(" "))), "{done}{said}");
    }
}
