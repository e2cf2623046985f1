//! Films and bakes as arrays of a real Slurm: tasks that are killed, a node that goes away, two jobs on one output. The files are those of one
//! machine, byte for byte, and a shard that was there is not written again.
//!
//! `examples/farm/slurm.sh` starts the cluster; Debian and Ubuntu have it in `slurm-wlm` and `munge`:
//! `cargo test --profile checked --test slurm -- --ignored`
#![cfg(target_os = "linux")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Run, eventually, output, raxel, repository};

/// The task that is held half-way in its first run.
const HELD: u32 = 1;

/// Runs raxel. In the first run of one task it is stopped after a moment, or when a file is there, and never ends by itself.
const HOLD: &str = include_str!("fixtures/slurm/hold.sh");

struct Cluster {
    folder: tempfile::TempDir,
}

impl Cluster {
    fn start() -> Self {
        let cluster = Self { folder: tempfile::tempdir().unwrap() };
        Self::script(&["start", cluster.root().to_str().unwrap()]).exits(0);
        let program = env!("CARGO_BIN_EXE_raxel");
        let hold = cluster.path("raxel");
        fs::write(&hold, HOLD.replace("RAXEL", program).replace("HELD", &HELD.to_string())).unwrap();
        fs::set_permissions(&hold, fs::Permissions::from_mode(0o755)).unwrap();
        cluster
    }

    fn script(arguments: &[&str]) -> Run {
        output(Command::new(repository().join("examples/farm/slurm.sh")).args(arguments)).into()
    }

    fn root(&self) -> &Path {
        self.folder.path()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }

    fn slurm(&self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.current_dir(repository()).args(arguments).env("SLURM_CONF", self.path("slurm.conf"));
        command
    }

    /// Submits a file of the farm as an array of 4 tasks; gives the number of the job.
    fn submit(&self, file: &str, variables: &[(&str, &str)]) -> String {
        let log = format!("--output={}/log-%A-%a", self.root().display());
        let mut sbatch = self.slurm("sbatch", &["--parsable", "--array=0-3", &log, &format!("examples/farm/{file}")]);
        sbatch.env("RAXEL", self.path("raxel")).env("RAXEL_CACHE", "off").envs(variables.iter().copied());
        Run::from(output(&mut sbatch)).exits(0).stdout.trim().to_owned()
    }

    /// The state of each task of a job.
    fn tasks(&self, job: &str) -> BTreeMap<u32, String> {
        let said = Run::from(output(&mut self.slurm("scontrol", &["--oneliner", "show", "job", job]))).exits(0).stdout;
        let field = |line: &str, key: &str| {
            line.split_whitespace().find_map(|word| word.strip_prefix(key)).unwrap_or_default().to_owned()
        };
        // Tasks that wait share a line, whose number is a list.
        let tasks = said.lines().map(|line| (field(line, "ArrayTaskId="), field(line, "JobState=")));
        tasks.filter_map(|(task, state)| Some((task.parse().ok()?, state))).collect()
    }

    /// Waits until every task of a job has been done.
    fn done(&self, job: &str) {
        eventually("the end of a job", || {
            let tasks = self.tasks(job);
            let failed =
                tasks.values().any(|state| !["COMPLETED", "RUNNING", "PENDING", "COMPLETING"].contains(&&**state));
            assert!(!failed, "{tasks:?}\n{}", self.logs(job));
            tasks.len() == 4 && tasks.values().all(|state| state == "COMPLETED")
        });
    }

    fn logs(&self, job: &str) -> String {
        (0..4).map(|task| fs::read_to_string(self.path(&format!("log-{job}-{task}"))).unwrap_or_default()).collect()
    }

    /// Waits until the held task has stopped half-way and the others are done: its node, its job, and its processes.
    fn held(&self, job: &str, hold: &Path) -> Vec<String> {
        eventually("a task that is held", || {
            let tasks = self.tasks(job);
            hold.exists() && tasks.iter().all(|(task, state)| *task == HELD || state == "COMPLETED") && tasks.len() == 4
        });
        fs::read_to_string(hold).unwrap().split_whitespace().map(str::to_owned).collect()
    }
}

impl Cluster {
    /// Kills the held task, which has failed then, and requeues it. Returns the files from before its second run, which it must not write again.
    fn kill_and_requeue(&self, job: &str, hold: &Path, out: &Path) -> Vec<String> {
        let held = self.held(job, hold);
        let before = files(out);
        let mut kill = Command::new("kill");
        Run::from(output(kill.arg("-KILL").args(&held[2..3]))).exits(0);
        let _ = output(Command::new("kill").arg("-KILL").args(&held[3..]));
        eventually("a task that failed", || self.tasks(job)[&HELD] == "FAILED");
        Run::from(output(&mut self.slurm("scontrol", &["requeue", &held[1]]))).exits(0);
        self.done(job);
        let after = files(out);
        for (name, was) in &before {
            assert!(after[name] == *was, "{name} is written again");
        }
        before.into_keys().collect()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let stopped = Self::script(&["stop", self.root().to_str().unwrap()]);
        if !std::thread::panicking() {
            stopped.exits(0);
        }
    }
}

/// Every file of a folder, without the hidden ones that a killed task may leave: its bytes; its number and time in the file system.
fn files(folder: &Path) -> BTreeMap<String, (Vec<u8>, (u64, i64))> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if !path.file_name().unwrap().to_str().unwrap().starts_with('.') {
                let about = fs::metadata(&path).unwrap();
                found.insert(name, (fs::read(&path).unwrap(), (about.ino(), about.mtime_nsec())));
            }
        }
    }
    found
}

fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    files(folder).into_iter().map(|(name, (bytes, _))| (name, bytes)).collect()
}

const BAKE: [(&str, &str); 3] = [("WORLD", "worlds/baked/isle.toml"), ("EDGE", "64"), ("LEVELS", "2")];

#[test]
#[ignore = "needs Slurm and munge"]
fn a_bake_on_slurm_is_the_bake_of_one_machine_whatever_ends_a_task() {
    let cluster = Cluster::start();
    let [whole, killed, lost, both] = ["whole", "killed", "lost", "both"].map(|name| cluster.path(name));
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let one = ["world", "bake", "worlds/baked/isle.toml", "--edge", "64", "--levels", "2", "--out"];
    raxel(&[&one[..], &[&text(&whole)]].concat()).exits(0);
    let whole = bytes(&whole);
    assert!(whole.len() > 10, "{:?}", whole.keys());

    // A task that is killed has failed; requeued, it goes on.
    let hold = cluster.path("hold-killed");
    let job = cluster.submit("bake.sbatch", &[&BAKE[..], &[("OUT", &text(&killed)), ("HOLD", &text(&hold))]].concat());
    cluster.kill_and_requeue(&job, &hold, &killed);
    assert!(bytes(&killed) == whole);

    // A node that goes away: Slurm itself runs its task on another one.
    let hold = cluster.path("hold-lost");
    let job = cluster.submit("bake.sbatch", &[&BAKE[..], &[("OUT", &text(&lost)), ("HOLD", &text(&hold))]].concat());
    let held = cluster.held(&job, &hold);
    let before = files(&lost);
    Cluster::script(&["lose", cluster.root().to_str().unwrap(), &held[0]]).exits(0);
    cluster.done(&job);
    let after = files(&lost);
    for (name, was) in &before {
        assert!(after[name] == *was, "{name} is written again");
    }
    assert!(bytes(&lost) == whole);

    // Two jobs on one output.
    let jobs = [(); 2].map(|()| cluster.submit("bake.sbatch", &[&BAKE[..], &[("OUT", &text(&both))]].concat()));
    jobs.iter().for_each(|job| cluster.done(job));
    assert!(bytes(&both) == whole);
}

#[test]
#[ignore = "needs Slurm and munge"]
fn a_film_on_slurm_is_the_film_of_one_machine_whatever_ends_a_task() {
    let cluster = Cluster::start();
    let [whole, killed, parts, both] = ["whole", "killed", "parts", "both"].map(|name| cluster.path(name));
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let one = ["render", "worlds/valley.demo.toml", "--size", "48x26", "--frames", "40", "-o"];
    raxel(&[&one[..], &[&text(&whole.join("%05d.png"))]].concat()).exits(0);
    let film = [("SIZE", "48x26"), ("FRAMES", "40")];

    // A task that is killed has failed; requeued, it goes on: the part 1 of 0 to 3 has the frames 10 to 19.
    let (hold, from) = (cluster.path("hold-killed"), text(&killed.join("00011.png")));
    let job = cluster.submit(
        "film.sbatch",
        &[&film[..], &[("OUT", &text(&killed)), ("HOLD", &text(&hold)), ("HOLD_FROM", &from)]].concat(),
    );
    let kept = cluster.kill_and_requeue(&job, &hold, &killed);
    let of_the_task = kept.iter().filter(|name| ("00010.png".."00020.png").contains(&name.as_str())).count();
    assert!((2..10).contains(&of_the_task), "{kept:?}");
    assert!(bytes(&killed) == bytes(&whole));

    // The node of a task goes away.
    let hold = cluster.path("hold");
    let job = cluster.submit("film.sbatch", &[&film[..], &[("OUT", &text(&parts)), ("HOLD", &text(&hold))]].concat());
    let held = cluster.held(&job, &hold);
    Cluster::script(&["lose", cluster.root().to_str().unwrap(), &held[0]]).exits(0);
    cluster.done(&job);
    assert!(bytes(&parts) == bytes(&whole));

    // Two jobs on one output.
    let jobs = [(); 2].map(|()| cluster.submit("film.sbatch", &[&film[..], &[("OUT", &text(&both))]].concat()));
    jobs.iter().for_each(|job| cluster.done(job));
    assert!(bytes(&both) == bytes(&whole));
}
