//! Copies the repository, plants every fault of a group in the copy, and builds its tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::groups::Group;
use crate::plant::{Fault, Planted, origin};

/// The switch that the library gets: the number in `RAXEL_MUTANT` selects the fault that runs.
pub const SWITCH: &str = "
#[doc(hidden)]
pub mod planted {
    static RUNS: std::sync::LazyLock<usize> =
        std::sync::LazyLock::new(|| std::env::var(\"RAXEL_MUTANT\").ok().and_then(|n| n.parse().ok()).unwrap_or(usize::MAX));

    pub fn is(number: usize) -> bool {
        *RUNS == number
    }
}
";

/// A source with its faults.
pub struct Source {
    /// Relative to the repository.
    pub path: PathBuf,
    planted: Planted,
    /// The number of its first fault.
    first: usize,
    left_out: BTreeSet<usize>,
}

/// A copy of the repository in which every fault stands.
pub struct Copy {
    /// Where it is.
    pub root: PathBuf,
    /// Its sources with faults.
    pub sources: Vec<Source>,
}

/// A file, and bytes of its text with faults.
type Place = (PathBuf, Range<usize>);

/// Where the bytes of each text come from, by its path ([`origin`]).
type Parts = BTreeMap<PathBuf, Vec<Range<usize>>>;

/// The result of a step, with any error.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

impl Copy {
    /// Copies the files that git tracks and plants the faults of a group.
    pub fn new(repository: &Path, root: &Path, group: &Group) -> Result<Self> {
        let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(repository).output()?.stdout;
        for file in String::from_utf8(listed)?.split_terminator('\0') {
            let (from, to) = (repository.join(file), root.join(file));
            fs::create_dir_all(to.parent().ok_or("a file without a folder")?)?;
            if from.is_file() && fs::read(&from)? != fs::read(&to).unwrap_or_default() {
                fs::copy(&from, &to)?;
            }
        }
        let folder = Path::new("engine").join(group.folder);
        let manifest = root.join(&folder).join("Cargo.toml");
        // A fault may leave a name unused.
        fs::write(&manifest, fs::read_to_string(&manifest)?.replace("[lints]\nworkspace = true\n", ""))?;
        let library = root.join(&folder).join("src/lib.rs");
        fs::write(&library, fs::read_to_string(&library)? + SWITCH)?;
        let mut paths = Vec::new();
        for source in group.sources {
            files(&repository.join(&folder).join("src").join(source), &mut paths)?;
        }
        let (mut sources, mut first) = (Vec::new(), 0);
        for path in paths {
            let planted = Planted::of(&fs::read_to_string(&path)?)?;
            let count = planted.faults().count();
            let path = path.strip_prefix(repository)?.to_owned();
            sources.push(Source { path, planted, first, left_out: BTreeSet::new() });
            first += count;
        }
        let mut copy = Self { root: root.to_owned(), sources };
        copy.leave_out_what_does_not_compile(group)?;
        if copy.faults().is_empty() {
            return Err(format!("no fault of {} compiles", group.name).into());
        }
        Ok(copy)
    }

    /// Every fault that compiles, by its number.
    pub fn faults(&self) -> BTreeMap<usize, (&Path, &Fault)> {
        let mut faults = BTreeMap::new();
        for source in &self.sources {
            faults.extend(source.left().map(|(n, fault)| (source.first + n, (source.path.as_path(), fault))));
        }
        faults
    }

    /// How many faults do not compile, and are left out.
    pub fn left_out(&self) -> usize {
        self.sources.iter().map(|source| source.left_out.len()).sum()
    }

    fn leave_out_what_does_not_compile(&mut self, group: &Group) -> Result<()> {
        let library = Path::new("engine").join(group.folder).join("src/lib.rs");
        loop {
            let mut parts = Parts::new();
            for source in &self.sources {
                let (mut text, of) = source.planted.text(source.first, &source.left_out);
                if source.path == library {
                    text += SWITCH;
                }
                fs::write(self.root.join(&source.path), text)?;
                parts.insert(source.path.clone(), of);
            }
            let package = format!("raxel-{}", group.folder);
            let (checked, compiles) = cargo(&self.root, &["check", "-p", &package, "--message-format", "json"])?;
            if compiles {
                return Ok(());
            }
            let mut found = false;
            for places in checked.iter().map(error_places) {
                // The first place of an error is nearest to its reason.
                let reason = places.iter().find_map(|place| self.reason(place, &parts));
                let reason = reason.or_else(|| places.iter().find_map(|place| self.statement_beside(place, &parts)));
                if let Some((source, fault)) = reason {
                    found |= self.sources[source].left_out.insert(fault);
                }
            }
            if !found {
                return Err(format!("{package} does not compile, and no fault is the reason").into());
            }
        }
    }

    /// The fault that a place lies in, or that lies in the place: its source and its number there.
    fn reason(&self, place: &Place, parts: &Parts) -> Option<(usize, usize)> {
        let (index, source, Range { start, end }) = self.of_source(place, parts)?;
        let around = source.left().filter(|(_, fault)| fault.range.start <= start && start <= fault.range.end);
        let around = around.min_by_key(|(_, fault)| fault.range.len());
        // A block that has to end early does not without its last statement.
        let last = source.left().filter(|(_, fault)| start <= fault.range.start && fault.range.end <= end);
        let last = last.filter(|(_, fault)| fault.to.is_empty()).last();
        last.or(around).map(|(number, _)| (index, number))
    }

    /// The nearest statement that may be gone: a value that it gives to a variable, or takes from one, is missed elsewhere.
    fn statement_beside(&self, place: &Place, parts: &Parts) -> Option<(usize, usize)> {
        let (index, source, at) = self.of_source(place, parts)?;
        let statements = source.left().filter(|(_, fault)| fault.to.is_empty());
        let nearest = statements.min_by_key(|(_, fault)| fault.range.start.abs_diff(at.start));
        nearest.map(|(number, _)| (index, number))
    }

    /// The source of a place, and the bytes that it has there.
    fn of_source(&self, (file, place): &Place, parts: &Parts) -> Option<(usize, &Source, Range<usize>)> {
        let (index, source) = self.sources.iter().enumerate().find(|(_, source)| file.ends_with(&source.path))?;
        let [start, end] = [place.start, place.end].map(|byte| origin(&parts[&source.path], byte));
        Some((index, source, start..end))
    }
}

impl Source {
    /// The faults that are not left out, with their numbers.
    fn left(&self) -> impl Iterator<Item = (usize, &Fault)> {
        self.planted.faults().enumerate().filter(|(number, _)| !self.left_out.contains(number))
    }
}

fn files(path: &Path, into: &mut Vec<PathBuf>) -> io::Result<()> {
    if !path.is_dir() {
        into.push(path.to_owned());
        return Ok(());
    }
    let mut entries: Vec<PathBuf> =
        fs::read_dir(path)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<_>>()?;
    entries.sort();
    for entry in entries {
        let name = entry.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if entry.is_dir() || (entry.extension().is_some_and(|extension| extension == "rs") && name != "tests.rs") {
            files(&entry, into)?;
        }
    }
    Ok(())
}

/// Runs cargo and gives its messages, and whether it succeeded.
pub fn cargo(root: &Path, arguments: &[&str]) -> Result<(Vec<Value>, bool)> {
    let (verb, rest) = arguments.split_first().ok_or("no verb")?;
    let output = Command::new("cargo")
        .args([verb, "--profile", "checked"])
        .args(rest)
        .current_dir(root)
        .env("CARGO_TARGET_DIR", root.join("target"))
        .stderr(Stdio::inherit())
        .output()?;
    let text = String::from_utf8(output.stdout)?;
    let messages = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    Ok((messages, output.status.success()))
}

/// File and bytes of each place that an error of the compiler marks, the wrong one before those that only belong to it.
fn error_places(message: &Value) -> Vec<Place> {
    let message = &message["message"];
    if message["level"] != "error" {
        return Vec::new();
    }
    let mut spans: Vec<&Value> = message["spans"].as_array().into_iter().flatten().collect();
    spans.sort_by_key(|span| span["is_primary"] != true);
    let place = |span: &&Value| {
        let byte = |name: &str| usize::try_from(span[name].as_u64()?).ok();
        Some((PathBuf::from(span["file_name"].as_str()?), byte("byte_start")?..byte("byte_end")?))
    };
    spans.iter().filter_map(place).collect()
}
