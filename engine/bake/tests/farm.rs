//! The files for clusters that bake match what a cluster expects.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use std::path::Path;
use std::process::Command;

use common::python::Python;
use raxel_testing::output;

/// Reads the job and checks what the scheduler and `shard.sh` need of it.
const CHECK: &str = r#"
import sys
import yaml
job = yaml.safe_load(open(sys.argv[1]))
assert job["apiVersion"] == "batch/v1" and job["kind"] == "Job", job
spec = job["spec"]
assert spec["completionMode"] == "Indexed" and spec["completions"] == spec["parallelism"], spec
pod = spec["template"]["spec"]
assert pod["restartPolicy"] in ("OnFailure", "Never")
(container,) = pod["containers"]
assert container["args"] == ["bake"], container["args"]
environment = {entry["name"]: entry["value"] for entry in container["env"]}
assert all(isinstance(value, str) for value in environment.values()), environment
assert environment["PARTS"] == str(spec["completions"])
assert environment["OUT"].startswith("s3://")
for corner in ("MIN", "MAX"):
    assert len([int(number) for number in environment[corner].split(",")]) == 3
"#;

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
