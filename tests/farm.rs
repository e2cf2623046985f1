//! A film made in parts equals the film made at once, byte for byte. The parts are tasks of a Slurm array, and pods of a Kubernetes job.

#![cfg(unix)]

mod common;

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Command;

use common::{Run, output, raxel, repository};

const DEMO: [&str; 6] = ["render", "worlds/valley.demo.toml", "--size", "48x26", "--frames", "7"];

/// Runs one task as the scheduler would.
fn task(out: &Path, environment: &[(&str, String)]) -> Run {
    let mut shell = Command::new(repository().join("examples/farm/shard.sh"));
    shell.current_dir(repository()).env("RAXEL", env!("CARGO_BIN_EXE_raxel")).env("OUT", out);
    shell
        .env("RAXEL_CACHE", "off")
        .env("SIZE", "48x26")
        .env("FRAMES", "7")
        .env_remove("SLURM_ARRAY_TASK_ID")
        .env_remove("JOB_COMPLETION_INDEX");
    output(shell.envs(environment.iter().map(|(name, value)| (name, value)))).into()
}

fn frames(folder: &Path) -> Vec<Vec<u8>> {
    (0..7).map(|frame| std::fs::read(folder.join(format!("{frame:05}.png"))).unwrap()).collect()
}

#[test]
fn parts_are_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    raxel(&[&DEMO[..], &["-o", inside("whole/%05d.png").to_str().unwrap()]].concat()).exits(0);
    let whole = frames(&inside("whole"));
    for index in 0..3 {
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", (index + 4).to_string()),
            ("SLURM_ARRAY_TASK_MIN", "4".to_owned()),
            ("SLURM_ARRAY_TASK_COUNT", "3".to_owned()),
        ];
        task(&inside("slurm"), &slurm).exits(0);
        task(&inside("pods"), &[("JOB_COMPLETION_INDEX", index.to_string()), ("PARTS", "3".to_owned())]).exits(0);
    }
    assert!(frames(&inside("slurm")) == whole && frames(&inside("pods")) == whole);
    assert!(task(&inside("none"), &[]).exits(2).stderr.contains("JOB_COMPLETION_INDEX"));

    // A task that is killed goes on in its second run, of the same job. Another job makes every frame.
    let requeued = |job: &str| {
        let of = ["SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_COUNT"]
            .map(|name| (name, "1".to_owned()));
        task(&inside("requeued"), &[&of[..], &[("SLURM_ARRAY_JOB_ID", job.to_owned())]].concat()).exits(0).stderr
    };
    let there = "frames are there already";
    assert!(!requeued("7").contains(there));
    std::fs::remove_file(inside("requeued/00005.png")).unwrap();
    let kept = std::fs::metadata(inside("requeued/00004.png")).unwrap().ino();
    assert!(requeued("7").contains("5 of 7 frames are there already"));
    assert_eq!(std::fs::metadata(inside("requeued/00004.png")).unwrap().ino(), kept);
    assert!(frames(&inside("requeued")) == whole);
    assert!(!requeued("8").contains(there));
    assert_ne!(std::fs::metadata(inside("requeued/00004.png")).unwrap().ino(), kept);
    let [list, pattern] =
        ["requeued/.finished-8-1", "requeued/%05d.png"].map(|name| inside(name).to_str().unwrap().to_owned());
    let other = [&DEMO[..], &["-o", &pattern, "--resume", &list]].concat();
    let said = raxel(&other).exits(2).stderr;
    assert!(said.contains("is not a list of this command's frames"), "{said}");

    // The film of the frames is the film.
    let film = |name: &str| inside(name).to_str().unwrap().to_owned();
    raxel(&[&DEMO[..], &["-o", &film("once.mp4")]].concat()).exits(0);
    let pattern = inside("pods/%05d.png");
    raxel(&["film", pattern.to_str().unwrap(), "--fps", "30", "-o", &film("parts.mp4")]).exits(0);
    assert!(std::fs::read(inside("once.mp4")).unwrap() == std::fs::read(inside("parts.mp4")).unwrap());
    let run = raxel(&["film", inside("empty/%d.png").to_str().unwrap(), "-o", &film("a.mp4")]).exits(2);
    assert!(run.stderr.contains("there is no `"), "{}", run.stderr);
}

#[test]
fn the_files_agree_with_each_other() {
    let read = |name: &str| std::fs::read_to_string(repository().join("examples/farm").join(name)).unwrap();
    let job = read("job.yaml");
    let number = |key: &str| job.lines().find_map(|line| line.trim().strip_prefix(key)).unwrap().trim().to_owned();
    assert_eq!(number("completions:"), number("parallelism:"));
    assert!(job.contains(&format!(
        "- name: PARTS # the number of completions\n              value: \"{}\"",
        number("completions:")
    )));
    assert!(job.contains("completionMode: Indexed"));
    assert!(read("film.sbatch").contains("exec examples/farm/shard.sh"));
    // The files that the image copies are there.
    for line in read("Containerfile").lines().filter(|line| line.starts_with("COPY ") && !line.contains("--from")) {
        let from = line.split_whitespace().nth(1).unwrap();
        assert!(repository().join(from).exists(), "{line}");
    }
    for script in ["shard.sh", "film.sbatch"] {
        let path = repository().join("examples/farm").join(script);
        assert!(output(Command::new("bash").arg("-n").arg(path)).status.success(), "{script}");
    }
}
