//! The files for clusters that bake match what a cluster expects.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::path::Path;
use std::process::Command;

use common::python::Python;
use raxel_testing::output;

/// Reads the job and checks what the scheduler and `shard.sh` need of it.
const CHECK: &str = include_str!("fixtures/farm/check.py");

fn file(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/farm").join(name)
}

#[test]
fn the_job_of_kubernetes_is_right() {
    let Some(python) = Python::with("yaml", &["PyYAML==6.0.3"]) else { return };
    python.run(CHECK, &[file("bake.yaml").to_str().unwrap()], &[]);
}

#[test]
fn the_scripts_are_scripts() {
    for name in ["shard.sh", "bake.sbatch"] {
        let checked = output(Command::new("bash").arg("-n").arg(file(name)));
        assert!(checked.status.success(), "{name}: {}", String::from_utf8_lossy(&checked.stderr));
    }
    let array = std::fs::read_to_string(file("bake.sbatch")).unwrap();
    assert!(array.contains("#SBATCH --array=0-15\n") && array.contains("exec examples/farm/shard.sh bake\n"));
}
