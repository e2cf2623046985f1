//! Worlds that are baked by processes, and streamed from the result.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};

use common::{Project, Run, RunRaxel, files, output, repository};

const ISLE: [&str; 5] = ["world", "bake", "worlds/baked/isle.toml", "--edge", "128"];
/// A part of the endless world, in 8 shards of voxels and as many of cells as it takes.
const LAND: [&str; 11] = [
    "world",
    "bake",
    "worlds/frontier.toml",
    "--edge",
    "64",
    "--levels",
    "2",
    "--min",
    "-64,0,-64",
    "--max",
    "64,128,64",
];

fn baked(arguments: &[&str], more: &[&str], out: &Path) -> serde_json::Value {
    let out = ["--format", "json", "--out", out.to_str().unwrap()];
    let run = common::raxel(&[arguments, more, &out].concat()).exits(0);
    run.json().pop().expect("it prints what it did")["report"].clone()
}

/// A task, as the scheduler starts it.
fn task(out: &Path, environment: &[(&str, String)]) -> Command {
    let mut shell = Command::new(repository().join("examples/farm/shard.sh"));
    shell.arg("bake").current_dir(repository()).env("RAXEL", env!("CARGO_BIN_EXE_raxel")).env("OUT", out);
    shell.env("WORLD", "worlds/frontier.toml").env("MIN", "-64,0,-64").env("MAX", "64,128,64").env("EDGE", "64");
    shell.env("LEVELS", "2").env_remove("SLURM_ARRAY_TASK_ID").env_remove("JOB_COMPLETION_INDEX").stdin(Stdio::null());
    shell.envs(environment.iter().map(|(name, value)| (name, value)));
    shell
}

#[test]
fn one_shard_is_said_to_be_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = format!("file://{}", folder.path().join("small").display());
    let small = ["world", "bake", "worlds/frontier.toml", "--min", "0,64,0", "--max", "64,128,64", "--edge", "64"];
    let run = common::raxel(&[&small[..], &["--levels", "1", "--out", &out]].concat()).exits(0);
    assert!(run.stderr.contains(": 1 shard, 1 written, 0 there already; "), "{}", run.stderr);
}

#[test]
fn tasks_make_what_one_process_makes() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    let report = baked(&LAND, &[], &inside("whole"));
    assert!(report["shards"] == 12 && report["written"] == 12 && report["skipped"] == 0, "{report}");
    let whole = files(&inside("whole"));

    // All at once, as on a cluster.
    std::thread::scope(|scope| {
        for index in 0..3 {
            let (slurm, pods) = (inside("slurm"), inside("pods"));
            scope.spawn(move || {
                let environment = [
                    ("SLURM_ARRAY_TASK_ID", (index + 4).to_string()),
                    ("SLURM_ARRAY_TASK_MIN", "4".to_owned()),
                    ("SLURM_ARRAY_TASK_COUNT", "3".to_owned()),
                ];
                Run::from(output(&mut task(&slurm, &environment))).exits(0);
            });
            scope.spawn(move || {
                let environment = [("JOB_COMPLETION_INDEX", index.to_string()), ("PARTS", "3".to_owned())];
                Run::from(output(&mut task(&pods, &environment))).exits(0);
            });
        }
    });
    assert!(files(&inside("slurm")) == whole && files(&inside("pods")) == whole);

    // Eight boxes. One is killed and run again.
    let boxes = inside("boxes");
    let mut killed = common::command(repository(), &[&LAND[..], &["--shard", "1,0,1/2", "--out"]].concat());
    let killed = common::Running::start(killed.arg(&boxes).stdout(Stdio::null()).stderr(Stdio::null()));
    std::thread::sleep(std::time::Duration::from_millis(30));
    drop(killed);
    for part in 0..8 {
        let part = format!("{},{},{}/2", part & 1, part >> 1 & 1, part >> 2);
        baked(&LAND, &["--shard", &part], &boxes);
    }
    let mut found = files(&boxes);
    found.retain(|(path, _)| Path::new(path).extension().is_none_or(|extension| extension != "part"));
    assert!(found == whole);

    // A shard that was cut off is made again, and no other one is.
    let shard = inside("whole/0/c/0/0/1");
    let bytes = std::fs::read(&shard).unwrap();
    std::fs::write(&shard, &bytes[..bytes.len() - 9]).unwrap();
    let report = baked(&LAND, &[], &inside("whole"));
    assert!(report["written"] == 1 && report["redone"] == 1 && report["skipped"] == 11, "{report}");
    assert!(files(&inside("whole")) == whole);
}

#[test]
fn what_cannot_be_baked_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = |arguments: &[&str], out: &Path| common::raxel(&[arguments, &["--out", out.to_str().unwrap()]].concat());
    let said = run(&[&LAND[..], &["--max", "-64,0,0"]].concat()[..], &out);
    assert_eq!(said.code, 2, "--max is given twice: {}", said.stderr);
    let empty = ["world", "bake", "worlds/frontier.toml", "--min", "0,0,0", "--max", "0,9,9"];
    assert!(run(&empty, &out).exits(3).stderr.contains("RX0453"));
    for wrong in ["0/2", "3/2", "2,0,0/2", "x"] {
        assert!(run(&[&ISLE[..], &["--shard", wrong]].concat(), &out).exits(2).stderr.contains("I/N"), "{wrong}");
    }
    assert!(!out.exists());
    #[cfg(not(feature = "cloud"))]
    assert!(run(&ISLE, Path::new("s3://worlds/isle")).exits(3).stderr.contains("RX0450"));
    assert!(run(&ISLE, Path::new("ftp://worlds/isle")).exits(3).stderr.contains("RX0450"));
    run(&ISLE, &out).exits(0);
    assert!(run(&LAND, &out).exits(3).stderr.contains("RX0452"));
    // A file in the place of a folder.
    std::fs::write(folder.path().join("file"), "").unwrap();
    assert!(run(&ISLE, &folder.path().join("file")).exits(3).stderr.contains("RX0451"));
}

#[test]
fn the_isle_in_the_repository_is_what_is_baked() {
    let folder = tempfile::tempdir().unwrap();
    baked(&ISLE, &[], &folder.path().join("isle"));
    assert!(files(&folder.path().join("isle")) == files(&repository().join("worlds/baked/isle")));
}

/// A project whose world streams the isle from `worlds/baked/isle`, with the looks of the store.
fn from_store() -> Project {
    let project = Project::shipped();
    project.edit("worlds/baked/from_store.toml", "[materials]\nplaster = { albedo = \"#c9503a\" }\n", "");
    project
}

fn picture(project: &Project, world: &str) -> Run {
    let arguments = ["render", "graphs/primary.toml", "--world", world, "--size", "64x40", "-o", "picture.png"];
    project.raxel(&arguments)
}

#[test]
fn a_world_from_a_store_looks_as_it_was_built() {
    let project = from_store();
    let read = || std::fs::read(project.path("picture.png")).unwrap();
    picture(&project, "worlds/baked/isle.toml").exits(0);
    let built = read();
    picture(&project, "worlds/baked/from_store.toml").exits(0);
    assert!(read() == built, "the pictures differ");
    // The world of the repository has another look for one material, and is right otherwise.
    common::raxel(&["check", "worlds/baked/from_store.toml", "worlds/baked/isle.toml"]).exits(0);

    // A missing or damaged shard is reported, and never taken for air.
    let shard = project.path("worlds/baked/isle/0/c/0/0/0");
    let bytes = std::fs::read(&shard).unwrap();
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 3] ^= 1;
    for (damage, why) in
        [(None, "was not baked yet"), (Some(&bytes[..bytes.len() / 2]), "damaged"), (Some(&damaged), "damaged")]
    {
        match damage {
            None => std::fs::remove_file(&shard).unwrap(),
            Some(bytes) => std::fs::write(&shard, bytes).unwrap(),
        }
        let run = picture(&project, "worlds/baked/from_store.toml").exits(3);
        assert!(run.stderr.contains("RX0451") && run.stderr.contains(why), "{}", run.stderr);
    }
    std::fs::write(&shard, &bytes).unwrap();
    picture(&project, "worlds/baked/from_store.toml").exits(0);
    assert!(read() == built);
}

#[test]
fn world_files_that_do_not_suit_their_store_are_told_why() {
    let project = from_store();
    let world = "worlds/baked/from_store.toml";
    let text = std::fs::read_to_string(project.path(world)).unwrap();
    let build = r##"[[build]]
op = "box"
min = [0, 0, 0]
size = [4, 4, 4]
material = "m"
[materials]
m = { albedo = "#ffffff" }
"##;
    for (changed, code) in [
        (text.replace("near   = 320", "near   = 192\nfar    = 400"), "RX0455"),
        (format!("{text}{build}"), "RX0456"),
        (text.replace("zarr:worlds/baked/isle", "zarr:worlds/baked/nothing"), "RX0454"),
        (text.replace("zarr:worlds/baked/isle", "zarr:gopher://isle"), "RX0450"),
        (text.replace("zarr:worlds/baked/isle", "worlds/baked/isle"), "RX0014"),
    ] {
        assert_ne!(changed, text, "{code}");
        project.write(world, &changed);
        let run = project.raxel(&["check", world]).exits(3);
        assert!(run.stdout.contains(code) && run.stdout.contains("from_store.toml"), "{code}: {}", run.stdout);
    }
    project.write(world, &text);
    project.write("worlds/baked/isle/zarr.json", "{}");
    assert!(project.raxel(&["check", world]).exits(3).stdout.contains("RX0454"));
}
