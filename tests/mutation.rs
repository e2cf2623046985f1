//! Plants faults in the tracers' shaders. `raxel stress` must notice each of them, unless
//! `tests/mutation/explained.toml` explains why it changes no hit. docs/mutation.md explains how to run it.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;
#[path = "mutation/plant.rs"]
mod plant;

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::ops::Range;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{self, AtomicUsize};
use std::time::{Duration, Instant};

use common::{Project, Running, command, repository};
use plant::Fault;
use raxel::world::random::SplitMix64;
use rayon::prelude::*;
use wait_timeout::ChildExt as _;

/// The files with the tracers that claim to be exact, with the rows of `raxel stress` that run them.
const GATES: &[(&str, &str)] = &[
    ("beam", "tree64:beam"),
    ("box", "tree64:instances,tree64:onward,tree64:ahead"),
    ("camera", "tree64:packet,tree64:beam"),
    ("rivals/internal/layouts/brickmap", "brickmap,brickmap:ahead"),
    ("rivals/internal/layouts/bvh", "bvh,bvh:ahead"),
    ("rivals/internal/layouts/chunk_table", "chunk_table,chunk_table:ahead,chunk_table:stored"),
    ("rivals/internal/layouts/chunks", "chunks,chunks:ahead,chunks:stored,chunks:onward"),
    ("internal/layouts/flat64", "flat64,flat64:ahead"),
    ("internal/hashed_chunks", "brickmap,chunk_table"),
    ("instances", "tree64:instances,tree64:instances_onward"),
    ("instance_frame", "tree64:instances,tree64:instances_onward"),
    ("instance_voxels", "tree64:instances,tree64:instances_onward"),
    ("internal/mask", "tree64,tree64:packet,flat64,flat64:period,svdag,brickmap,chunk_table"),
    ("internal/octant", "svo,svdag,octree"),
    ("internal/layouts/octree", "octree,octree:ahead,octree:stored"),
    ("internal/packed", "tree64,flat64,tree64:streamed"),
    ("packet", "tree64:packet,svo:packet"),
    ("parallel", "tree64:parallel,tree64:parallel_any"),
    ("period", "flat64:period,flat64:refill"),
    (
        "ray",
        "tree64,svo,tree64:packet,tree64:parallel,tree64:beam,tree64:ahead,tree64:onward,tree64:instances,flat64:period",
    ),
    ("refill", "flat64:refill"),
    ("rivals/internal/store", "chunks:stored,chunk_table:stored"),
    ("rivals/internal/layouts/svdag", "svdag,svdag:ahead"),
    ("rivals/internal/layouts/svo", "svo,svo:ahead,svo:onward"),
    ("rivals/internal/layouts/texture3d", "texture3d,texture3d:ahead"),
    ("internal/tile", "tree64:packet,tree64:parallel,tree64:parallel_any"),
    ("internal/trace", "svo,brickmap,flat64,texture3d"),
    ("internal/layouts/tree64", "tree64,tree64:ahead,tree64:beam,tree64:onward,tree64:streamed"),
    ("internal/walk", "tree64,tree64:ahead,tree64:packet,brickmap,svo"),
];

/// The number of rays that look for a fault, and the number for a second look at survivors.
const RAYS: &str = "1e5,3e6";

/// Those that are built at once: a run has thousands of faults.
const SCENES: &str =
    "dust,sparse,gravel,motley,rubble,checkerboard,diagonal,slope,solid,cubes,boxes,corners,menger,hills";

/// The sets that rows of tiles trace: rays of no others are worth their time where no other row is run.
const TILES: &str = "tiles,octant-tiles,grazing-tiles,skimming-tiles,hidden-tiles,lattice-tiles,wrapped-tiles,range-end-tiles,far-tiles";

/// The sets whose rays are parallel.
const GRIDS: &str =
    "parallel,parallel-ties,parallel-edges,parallel-beside,parallel-moved,parallel-depths,wrapped-parallel";

/// Longer than any run takes. A tracer that does not end is noticed.
const LIMIT: Duration = Duration::from_secs(120);

/// The outcome of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// It is no GLSL.
    Invalid,
    /// A hit was wrong, or the run did not end.
    Noticed,
    Survived,
    /// `raxel stress` ended well, and a row traced no ray: nothing is known.
    Unjudged,
}

/// Faults that change no hit: those of a `file` that every other key fits, and `why` no hit can change. Keys are the text of the `line`, or the `function`
/// that it is in; what the fault changes `from` and `to`, or whether it `changes` a number to a `larger` or a `smaller` one; and, where a line has `from`
/// several times, what stands before it on the line (`after`).
type Explained = BTreeMap<String, String>;

fn path(file: &str) -> String {
    format!("shaders/include/raxel/{file}.glsl")
}

fn source(file: &str) -> String {
    std::fs::read_to_string(repository().join(path(file))).unwrap_or_else(|error| panic!("{}: {error}", path(file)))
}

fn explained() -> Vec<Explained> {
    let text = std::fs::read_to_string(repository().join("tests/mutation/explained.toml")).expect("it is there");
    let mut list: BTreeMap<String, Vec<Explained>> = toml::from_str(&text).expect("a list of tables `[[fault]]`");
    list.remove("fault").unwrap_or_default()
}

/// Whether a reason is of a fault.
fn is(reason: &Explained, file: &str, fault: &Fault, source: &str) -> bool {
    let line = fault.line(source).1;
    reason.iter().all(|(key, value)| match key.as_str() {
        "file" => file == value,
        "function" => fault.function(source) == Some(value),
        "line" => line == value,
        "after" => source[..fault.range.start].ends_with(value.as_str()) && line.contains(value.as_str()),
        "from" => fault.from == *value,
        "to" => fault.to == *value,
        "changes" => fault.order() == Some(if value == "larger" { Ordering::Greater } else { Ordering::Less }),
        "why" => true,
        _ => panic!("tests/mutation/explained.toml: `{key}` is no key of {reason:?}"),
    })
}

/// Whether every row traced rays, by the table that `raxel stress` wrote.
fn all_traced(table: &str, rows: &str) -> bool {
    rows.split(',').all(|row| table.lines().any(|line| line.split(',').next() == Some(row)))
}

/// The sets that are worth to be traced by some rows; all of them if it is none.
fn sets(rows: &str) -> String {
    let of = |row: &str| match row.split_once(':') {
        Some((_, "packet" | "beam")) => Some(TILES),
        Some((_, "parallel" | "parallel_any")) => Some(GRIDS),
        _ => None,
    };
    let sets: Option<BTreeSet<&str>> = rows.split(',').map(of).collect();
    sets.map_or_else(String::new, |sets| sets.into_iter().collect::<Vec<_>>().join(","))
}

/// Whether `raxel stress` notices a source in place of a file.
fn judged(file: &str, text: &str, rows: &str, rays: &str) -> Outcome {
    let project = Project::empty();
    project.write(&path(file), text);
    let (options, sets) = (["--layouts", rows, "--scenes", SCENES, "--rays", rays, "-o", "stress.csv"], sets(rows));
    let chosen = ["--sets", &sets];
    let chosen = if sets.is_empty() { &[] } else { &chosen[..] };
    let mut command = command(project.root(), &[&["stress"], &options[..], chosen].concat());
    command.stdout(Stdio::null()).stderr(Stdio::null()).env("RAYON_NUM_THREADS", "2");
    let mut child = Running::start(&mut command);
    match child.0.wait_timeout(LIMIT).expect("a child can be waited for").map(|status| status.code()) {
        Some(Some(0)) => {
            let table = std::fs::read_to_string(project.root().join("stress.csv")).expect("it is written");
            if all_traced(&table, rows) { Outcome::Survived } else { Outcome::Unjudged }
        }
        // A project with a mistake.
        Some(Some(3)) => Outcome::Invalid,
        _ => Outcome::Noticed,
    }
}

/// A fault in a row of the table: its place, the old and the new text, and the line.
fn place(file: &str, fault: &Fault, source: &str) -> String {
    let (line, code) = fault.line(source);
    format!("{file}:{line}:{},{:?},{:?},{code:?}", fault.column(source), fault.from, fault.to)
}

/// All faults of all files, in an order that a seed gives.
fn all(sources: &BTreeMap<&str, String>, seed: u64) -> Vec<(&'static str, &'static str, Fault)> {
    let of = |&(file, rows): &(&'static str, &'static str)| {
        plant::faults(&sources[file]).into_iter().map(move |fault| (file, rows, fault))
    };
    let mut all: Vec<_> = GATES.iter().flat_map(of).collect();
    let mut random = SplitMix64::new(seed);
    for n in (1..all.len()).rev() {
        all.swap(n, random.below(n as u64 + 1) as usize);
    }
    all
}

/// Whether to plant a fault. `RAXEL_MUTATION_IN` limits faults to files and lines, `RAXEL_MUTATION_AGAIN` to survivors in the table of an earlier run.
fn wanted() -> impl Fn(&str) -> bool {
    let places: String = setting("IN", String::new());
    let places: Vec<String> = places.split_terminator(',').map(|place| format!("{place}:")).collect();
    let table = std::env::var_os("RAXEL_MUTATION_AGAIN");
    let text =
        table.map(|path| std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())));
    let survived: Option<BTreeSet<String>> =
        text.map(|text| text.lines().filter_map(|row| Some(row.strip_prefix("Survived,")?.to_owned())).collect());
    move |place| {
        let is_in = places.is_empty() || places.iter().any(|of| place.starts_with(of.as_str()));
        is_in && survived.as_ref().is_none_or(|survived| survived.contains(place))
    }
}

fn setting<T: std::str::FromStr>(name: &str, default: T) -> T {
    let text = std::env::var(format!("RAXEL_MUTATION_{name}")).ok();
    text.map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("RAXEL_MUTATION_{name}={text} is no number")))
}

#[test]
fn every_explanation_is_of_a_fault_that_can_be_planted() {
    for reason in explained() {
        let (file, _) = GATES.iter().find(|(file, _)| *file == reason["file"]).unwrap_or_else(|| panic!("{reason:?}"));
        let source = source(file);
        let planted = plant::faults(&source).iter().any(|fault| is(&reason, file, fault, &source));
        assert!(planted && reason["why"].len() > 20, "tests/mutation/explained.toml: nothing is like {reason:?}");
        let narrow = reason.contains_key("line") || reason.contains_key("function");
        let known = reason.get("changes").is_none_or(|changes| ["larger", "smaller"].contains(&changes.as_str()));
        assert!(
            narrow && known,
            "tests/mutation/explained.toml: {reason:?} names no line or function, or changes nothing"
        );
    }
}

#[test]
#[ignore = "takes hours without a GPU"]
fn every_planted_fault_is_noticed_or_explained() {
    let sources: BTreeMap<&str, String> = GATES.iter().map(|(file, _)| (*file, source(file))).collect();
    let reasons = explained();
    let explains = |file: &str, fault: &Fault| reasons.iter().any(|reason| is(reason, file, fault, &sources[file]));
    let mut faults = all(&sources, setting("SEED", 1));
    let (wanted, without_reason) = (wanted(), setting("UNEXPLAINED", 0) != 0);
    faults.retain(|(file, _, fault)| {
        wanted(&place(file, fault, &sources[file])) && !(without_reason && explains(file, fault))
    });
    let chosen: Range<usize> = setting("FROM", 0)..setting("TO", faults.len()).min(faults.len());
    println!("faults {chosen:?} of {}", faults.len());
    let rays: String = setting("RAYS", RAYS.to_owned());
    let rays: Vec<&str> = rays.split(',').collect();
    let used: BTreeMap<&str, &str> = faults[chosen.clone()].iter().map(|(file, rows, _)| (*file, *rows)).collect();
    used.par_iter().for_each(|(file, rows)| {
        assert_eq!(judged(file, &sources[file], rows, rays[0]), Outcome::Survived, "{file} as it is, by {rows}");
    });
    let end = Instant::now() + Duration::from_secs(setting("SECONDS", 1 << 30));
    let lines = Mutex::new(std::fs::File::create(setting("OUT", ".raxel/mutation.csv".to_owned())).expect("a file"));
    let counts = Mutex::new(BTreeMap::<Outcome, usize>::new());
    let (unexplained, unjudged) = (Mutex::new(BTreeSet::new()), Mutex::new(BTreeSet::new()));
    let next = AtomicUsize::new(chosen.start);
    let work = || {
        while Instant::now() < end
            && let Some((file, rows, fault)) = faults[..chosen.end].get(next.fetch_add(1, atomic::Ordering::Relaxed))
        {
            let (text, place) = (fault.planted(&sources[file]), place(file, fault, &sources[file]));
            let mut outcomes = rays.iter().map(|rays| judged(file, &text, rows, rays));
            let outcome = outcomes.find(|outcome| *outcome != Outcome::Survived).unwrap_or(Outcome::Survived);
            let is_explained = explains(file, fault);
            let row = format!("{outcome:?},{place}");
            writeln!(lines.lock().unwrap(), "{row}").expect("a file");
            *counts.lock().unwrap().entry(outcome).or_default() += 1;
            match outcome {
                Outcome::Survived if !is_explained => drop(unexplained.lock().unwrap().insert(row)),
                Outcome::Unjudged => drop(unjudged.lock().unwrap().insert(row)),
                _ => {}
            }
        }
    };
    let jobs = setting("JOBS", std::thread::available_parallelism().map_or(1, usize::from));
    std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
    println!("{:?}", counts.into_inner().unwrap());
    let list =
        |faults: Mutex<BTreeSet<String>>| faults.into_inner().unwrap().into_iter().collect::<Vec<_>>().join("\n");
    let (unexplained, unjudged) = (list(unexplained), list(unjudged));
    assert!(unjudged.is_empty(), "a row traced no ray:\n{unjudged}\nnothing notices:\n{unexplained}");
    assert!(unexplained.is_empty(), "nothing notices:\n{unexplained}");
}

/// A reason explains the faults that all of its keys fit, and no others.
#[test]
fn a_reason_is_of_what_its_keys_say() {
    let source = r"float f(float a) {
    return min(a, 2.0) + max(a, 2.0);
}

float g(float a) {
    return a * 2.0;
}
";
    let explained = |keys: &[(&str, &str)]| {
        let reason: Explained = keys.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let faults = plant::faults(source).into_iter().filter(|fault| is(&reason, "a", fault, source));
        faults.map(|fault| format!("{}{}>{}", fault.line(source).0, fault.from, fault.to)).collect::<Vec<_>>()
    };
    assert_eq!(explained(&[("file", "a"), ("function", "g")]), ["6*>/", "62.0>4.0", "62.0>0.0"]);
    assert_eq!(explained(&[("line", "return a * 2.0;"), ("changes", "larger")]), ["62.0>4.0"]);
    assert_eq!(explained(&[("function", "f"), ("after", "max(a, "), ("changes", "smaller")]), ["22.0>0.0"]);
    assert_eq!(explained(&[("from", "min"), ("to", "max")]), ["2min>max"]);
    assert!(explained(&[("file", "b")]).is_empty() && explained(&[("function", "h")]).is_empty());
}

#[test]
fn a_row_without_rays_judges_nothing() {
    let table = "row,site,set,rays\ntree64,dust@near,edges,64\ntree64:packet,dust@near,tiles,64\n";
    assert!(all_traced(table, "tree64") && all_traced(table, "tree64:packet,tree64"));
    assert!(!all_traced(table, "tree64,svo") && !all_traced(table, "tree"));
    assert!(!all_traced("row,site,set,rays\n", "tree64"));
}

#[test]
fn rows_that_trace_tiles_alone_are_given_tiles_alone() {
    assert_eq!(sets("tree64:packet,svo:packet"), TILES);
    assert_eq!(sets("tree64:parallel"), GRIDS);
    assert_eq!(sets("tree64:packet,tree64:parallel"), format!("{GRIDS},{TILES}"));
    assert_eq!(sets("tree64,tree64:packet"), "");
    for set in TILES.split(',').chain(GRIDS.split(',')) {
        assert!(raxel_oracle::sets::RaySet::find(set).is_some(), "no set is called `{set}`");
    }
}
