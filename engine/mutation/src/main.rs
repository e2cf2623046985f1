//! `raxel-mutation GROUP`: plants every fault of a group in a copy of the repository, builds it once, and runs its tests for each fault.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use raxel_mutation::build::{Copy, Result, cargo};
use raxel_mutation::groups::{GROUPS, Group};
use raxel_mutation::plant::Fault;
use raxel_mutation::run::{Gate, run, tests_of};

/// A fault that changes nothing, by `file`, text of the `line`, `from`, `to`, and `why`.
type Explained = BTreeMap<String, String>;

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let Some(group) = GROUPS.iter().find(|group| group.name == name) else {
        let names: Vec<&str> = GROUPS.iter().map(|group| group.name).collect();
        eprintln!("usage: raxel-mutation GROUP; groups are {}", names.join(", "));
        return ExitCode::from(2);
    };
    match judge(group) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// The text of a variable of docs/mutation.md.
fn text(name: &str) -> Option<String> {
    std::env::var(format!("RAXEL_MUTATION_{name}")).ok()
}

/// A whole number in a variable.
fn setting(name: &str, default: usize) -> Result<usize> {
    let Some(text) = text(name) else { return Ok(default) };
    text.trim().parse().map_err(|_| format!("RAXEL_MUTATION_{name} must be a whole number, got `{text}`").into())
}

/// The faults that the variables of docs/mutation.md choose, in the order in which they run.
fn chosen(faults: &BTreeMap<usize, (&Path, &Fault)>) -> Result<Vec<usize>> {
    let files = text("IN").unwrap_or_default();
    let of_files = |path: &Path| files.split(',').any(|file| path.to_string_lossy().contains(file));
    let only = text("ONLY");
    let only = only.map(|text| text.split(',').filter_map(|number| number.trim().parse().ok()).collect::<Vec<usize>>());
    let is_named = |number: &usize| only.as_ref().is_none_or(|only| only.contains(number));
    let chosen = faults.iter().filter(|(_, (path, _))| of_files(path)).map(|(number, _)| *number).filter(is_named);
    let mut chosen: Vec<usize> = chosen.step_by(setting("EVERY", 1)?.max(1)).collect();
    let seed = setting("SEED", 0)?;
    if seed != 0 {
        chosen.sort_by_cached_key(|number| {
            let mut hasher = DefaultHasher::new();
            (seed, number).hash(&mut hasher);
            hasher.finish()
        });
    }
    let to = setting("TO", usize::MAX)?.min(chosen.len());
    Ok(chosen.drain(setting("FROM", 0)?.min(to)..to).collect())
}

/// Whether every fault is noticed or explained.
fn judge(group: &Group) -> Result<bool> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    let root =
        std::env::var_os("RAXEL_MUTATION_COPY").map_or_else(|| repository.join("target/mutation"), PathBuf::from);
    let copy = Copy::new(&repository, &root, group)?;
    let gates = gates(group, &root)?;
    let faults = copy.faults();
    let chosen = chosen(&faults)?;
    println!("{}: {} faults of {}; {} do not compile", group.name, chosen.len(), faults.len(), copy.left_out());
    let reasons = std::fs::read_to_string(repository.join("tests/mutation/explained_rust.toml"))?;
    let explained = toml::from_str::<BTreeMap<String, Vec<Explained>>>(&reasons)?.remove("fault").unwrap_or_default();
    let is_explained = |number: usize| {
        let (path, fault) = faults[&number];
        explained.iter().any(|reason| is(reason, path, fault))
    };
    let name = |number: usize| {
        if !is_explained(number) {
            let (path, fault) = faults[&number];
            let Fault { line, from, to, text, .. } = fault;
            println!("{number} {}:{line}: `{from}` -> `{to}` in {text}", path.display());
        }
    };
    let jobs = setting("JOBS", std::thread::available_parallelism().map_or(1, usize::from))?;
    let noticed = run(&gates, &chosen, jobs, &name)?;
    let survivors: Vec<usize> = noticed.iter().filter(|(_, noticed)| !**noticed).map(|(number, _)| *number).collect();
    let unexplained = survivors.iter().filter(|number| !is_explained(**number)).count();
    println!(
        "{} noticed, {} explained, {unexplained} not noticed",
        noticed.len() - survivors.len(),
        survivors.len() - unexplained
    );
    Ok(unexplained == 0)
}

fn is(reason: &Explained, path: &Path, fault: &Fault) -> bool {
    let path = path.to_string_lossy();
    let of = [("file", path.as_ref()), ("line", &fault.text), ("from", &fault.from), ("to", &fault.to)];
    of.iter().all(|(key, value)| reason.get(*key).is_some_and(|reason| reason == value))
}

fn gates(group: &Group, root: &Path) -> Result<Vec<Gate>> {
    let memory = (setting("MEMORY", 8)? as u64).saturating_mul(1 << 30);
    let (by, named) = (text("BY").unwrap_or_default(), text("TESTS").unwrap_or_default());
    let is_named = |test: &String| named.split(',').any(|name| test.contains(name));
    let mut gates = Vec::new();
    for tests in group.tests.iter().filter(|tests| by.split(',').any(|by| tests.join(" ").contains(by))) {
        let (messages, built) = cargo(root, &[&["test", "--no-run", "--message-format", "json"], *tests].concat())?;
        if !built {
            return Err(format!("the tests of {} do not build", group.folder).into());
        }
        for message in messages {
            if let (Some(program), Some(manifest)) = (message["executable"].as_str(), message["manifest_path"].as_str())
                && message["profile"]["test"] == true
            {
                let folder = Path::new(manifest).parent().ok_or("a manifest without a folder")?;
                // One by one: if a quick test notices a fault, no slow test runs for it.
                for test in tests_of(Path::new(program))?.into_iter().filter(is_named) {
                    gates.push(Gate::new(Path::new(program), &[&test, "--exact"], folder, memory)?);
                }
            }
        }
    }
    let rays = text("RAYS").unwrap_or_else(|| "1e6".to_owned());
    if let Some(stress) = group.stress.filter(|_| rays != "0") {
        if !cargo(root, &["build", "--workspace", "--bin", "raxel"])?.1 {
            return Err("raxel does not build".into());
        }
        let arguments = [stress, &["--rays", &rays]].concat();
        gates.push(Gate::new(&root.join("target/checked/raxel"), &arguments, root, memory)?);
    }
    if gates.is_empty() {
        return Err(format!("no test of {} is a gate", group.name).into());
    }
    gates.sort_by_key(|gate| gate.limit);
    Ok(gates)
}
