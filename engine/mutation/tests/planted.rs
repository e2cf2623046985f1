//! A program with all faults switched off works as before, and each switched fault changes its result.
#![allow(missing_docs, reason = "a test")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use raxel_mutation::build::{Copy, SWITCH};
use raxel_mutation::groups::Group;
use raxel_mutation::plant::{Planted, origin};
use raxel_mutation::run::{Gate, tests_of};

/// It says all that a fault could change.
const PROGRAM: &str = include_str!("fixtures/planted/program.rs");

fn compiled(text: &str, folder: &Path) -> PathBuf {
    let (source, program) = (folder.join("main.rs"), folder.join("main"));
    std::fs::write(&source, text).expect("a temporary folder");
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output =
        Command::new(compiler).args(["--edition", "2024", "-Awarnings", "-o"]).arg(&program).arg(&source).output();
    let output = output.expect("the compiler that built this test");
    assert!(output.status.success(), "{}\n{text}", String::from_utf8_lossy(&output.stderr));
    program
}

fn says(program: &Path, fault: usize) -> (bool, Vec<u8>) {
    let output = Command::new(program).env("RAXEL_MUTANT", fault.to_string()).output().expect("a program");
    (output.status.success(), output.stdout)
}

#[test]
fn every_fault_changes_the_program_and_no_fault_leaves_it_as_it_was() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plain = says(&compiled(PROGRAM, folder.path()), 0);
    let planted = Planted::of(PROGRAM).expect("Rust");
    let (text, parts) = planted.text(0, &BTreeSet::new());
    let program = compiled(&(text.clone() + SWITCH), folder.path());
    assert_eq!(says(&program, usize::MAX), plain);
    let silent: Vec<String> = planted
        .faults()
        .enumerate()
        .filter(|(number, _)| says(&program, *number) == plain)
        .map(|(_, fault)| format!("{} -> {} in {}", fault.from, fault.to, fault.text))
        .collect();
    assert!(planted.faults().count() > 30 && silent.is_empty(), "silent: {silent:#?}");
    // The compiler's places lead back to the source.
    let at = text.find("continue").expect("it is there");
    assert_eq!(origin(&parts, at), PROGRAM.find("continue").expect("it is there"));
}

#[test]
fn a_fault_that_is_left_out_leaves_no_trace() {
    let planted = Planted::of(PROGRAM).expect("Rust");
    let all: BTreeSet<usize> = (0..planted.faults().count()).collect();
    assert_eq!(planted.text(0, &all).0, PROGRAM);
}

/// A group may have the faults of a whole crate, of the file with the switch as well.
#[test]
fn faults_of_a_whole_crate_compile_and_a_group_without_faults_is_an_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (repository, root) = (folder.path().join("repository"), folder.path().join("copy"));
    let source = repository.join("engine/sums/src");
    std::fs::create_dir_all(&source).unwrap();
    let profile = "[profile.checked]\ninherits = \"release\"\n";
    let manifest = "[package]\nname = \"raxel-sums\"\nversion = \"0.1.0\"\nedition = \"2024\"\n";
    std::fs::write(
        repository.join("Cargo.toml"),
        format!("[workspace]\nresolver = \"3\"\nmembers = [\"engine/sums\"]\n{profile}"),
    )
    .unwrap();
    std::fs::write(repository.join("engine/sums/Cargo.toml"), manifest).unwrap();
    let group = Group { name: "sums", folder: "sums", sources: &[""], tests: &[], stress: None };
    let none = Err("no fault of sums compiles".to_owned());
    // Without its second statement the loop borrows twice, and the compiler marks the second.
    let halves = r"pub fn count(mut all: &mut [u8]) -> usize {
    let mut n = 0;
    for _ in 0..4 {
        let (own, rest) = all.split_at_mut(1);
        all = rest;
        n += own.len();
    }
    n
}
";
    for (text, right) in [
        ("pub fn sum(a: u32, b: u32) -> u32 {\n    a + b\n}\n", Ok((1, 0))),
        (halves, Ok((5, 1))),
        ("pub struct Sum;\n", none),
    ] {
        std::fs::write(source.join("lib.rs"), text).unwrap();
        for arguments in [&["init", "--quiet"][..], &["add", "--all"]] {
            let done = Command::new("git").args(arguments).current_dir(&repository).status().unwrap();
            assert!(done.success());
        }
        let copied = Copy::new(&repository, &root, &group).map(|copy| (copy.faults().len(), copy.left_out()));
        assert_eq!(copied.map_err(|error| error.to_string()), right);
    }
}

/// A program whose memory a fault may blow up, with one test that is ignored.
const HUNGRY: &str = include_str!("fixtures/planted/hungry.rs");

/// Compiles [`HUNGRY`] with its tests.
fn hungry(folder: &Path) -> PathBuf {
    let (source, program) = (folder.join("hungry.rs"), folder.join("hungry"));
    std::fs::write(&source, HUNGRY).expect("a temporary folder");
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(compiler).args(["--edition", "2024", "--test", "-o"]).arg(&program).arg(&source).output();
    let output = output.expect("the compiler that built this test");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

#[test]
fn a_fault_that_takes_more_memory_than_it_may_is_noticed_and_an_ignored_test_is_no_gate() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = hungry(folder.path());
    assert_eq!(tests_of(&program).unwrap(), ["takes_as_much_as_it_is_told"]);
    let arguments = ["takes_as_much_as_it_is_told", "--exact"];
    let gate = |memory| Gate::new(&program, &arguments, folder.path(), memory);
    let gate_of_256 = gate(256 << 20).expect("it passes without a fault");
    // The fault's number is how many MiB the test takes.
    assert_eq!(
        [16, 64, 300, 1000].map(|mebibytes| gate_of_256.notices(mebibytes).unwrap()),
        [false, false, true, true]
    );
    let error = gate(1 << 12).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("--exact` fails without a fault, or needs more than 4096 bytes"), "{error}");
}

/// A reason that no longer belongs to a fault hides nothing, and is taken out.
#[test]
fn every_explained_fault_is_still_one() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(repository.join("tests/mutation/explained_rust.toml")).unwrap();
    let explained: toml::Table = text.parse().unwrap();
    for reason in explained["fault"].as_array().unwrap() {
        let word = |key: &str| reason[key].as_str().unwrap();
        let source = std::fs::read_to_string(repository.join(word("file"))).unwrap();
        let planted = Planted::of(&source).unwrap();
        let is = |fault: &raxel_mutation::plant::Fault| {
            [&fault.text, &fault.from, &fault.to] == [word("line"), word("from"), word("to")]
        };
        assert!(planted.faults().any(is), "{reason}");
        assert!(!word("why").is_empty(), "{reason}");
    }
}
