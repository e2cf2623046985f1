//! A storm of edits breaks and mends graphs, shaders, includes, the world and the demo at random while they run. After any edit raxel runs
//! on, and shows the last good picture or that of a fresh start. A window has all panels open. Validation is silent, and memory does not grow.
//!
//! `cargo test --release --test storm -- --ignored` makes 10,000 edits, a quarter of them in a window. `RAXEL_STORM_EDITS` and
//! `RAXEL_STORM_SEED` change how many and which, also of `some_edits_in_a_window` alone. A failure names the seed, and leaves the project as it
//! was.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![cfg(target_os = "linux")]

#[path = "../common/mod.rs"]
mod common;

mod breaking;

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use breaking::broken;
use common::{Display, Project, RunRaxel, Running, command, repository};

/// The demo, which runs two graphs in turn. The test looks at its first frame.
const DEMO: &str = include_str!("../fixtures/storm/storm.demo.toml");
const DEMO_PATH: &str = "worlds/storm.demo.toml";

/// All panels, none behind another one. The window below has 1024×576 points: a narrow one shows one panel only.
const PANELS: &str = include_str!("../fixtures/storm/panels.toml");

/// The edited files.
const FILES: [&str; 12] = [
    "graphs/primary.toml",
    "graphs/examples/mips.toml",
    "graphs/examples/blocks.toml",
    "shaders/primary.comp",
    "shaders/examples/light.comp",
    "shaders/examples/mip_down.comp",
    "shaders/examples/frame.glsl",
    "shaders/include/raxel/sky.glsl",
    "shaders/include/raxel/shade.glsl",
    "shaders/include/raxel/internal/layouts/tree64.glsl",
    "worlds/pool.toml",
    DEMO_PATH,
];

/// After this number of edits, memory must not grow.
const LONG: usize = 1500;

/// A generator of numbers (xorshift64*, Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number from 0 to one below `end`.
    fn below(&mut self, end: usize) -> usize {
        ((self.next() >> 33) as usize) % end.max(1)
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// A raxel that is edited while it runs.
struct Storm {
    project: Project,
    child: Running,
    requests: ChildStdin,
    lines: Receiver<String>,
    good: Vec<(&'static str, Vec<u8>)>,
    /// The picture of the good files, as base64.
    reference: String,
    random: Random,
    seed: u64,
    /// The last action.
    last: String,
    edits: usize,
    /// Resident memory in KiB, after each edit.
    memory: Vec<u64>,
    /// Edits that were right, and wrong.
    taken: [usize; 2],
    in_window: bool,
    _display: Option<Display>,
}

/// The outcome of an edit.
#[derive(Debug, PartialEq)]
enum Came {
    Reloaded,
    Failed,
}

impl Storm {
    fn start(seed: u64, in_window: bool) -> Self {
        let project = Project::shipped();
        project.write(DEMO_PATH, DEMO);
        let display = in_window.then(Display::start);
        project.write(".raxel/window.toml", PANELS);
        // The picture has 64×36 pixels in both.
        let verb: &[&str] = if in_window {
            &["run", "--control", "--size", "512x288", "--scale", "0.125"]
        } else {
            &["control", "--size", "64x36"]
        };
        let mut command = command(project.root(), &[verb, &[DEMO_PATH, "--validate", "--watchdog", "5"]].concat());
        if let Some(display) = &display {
            command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        }
        let log = fs::File::create(project.path("log")).unwrap();
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(log));
        let requests = child.0.stdin.take().unwrap();
        let stdout = BufReader::new(child.0.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || stdout.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        let good = FILES.map(|path| (path, fs::read(project.path(path)).unwrap())).to_vec();
        let mut storm = Self {
            project,
            child,
            requests,
            lines,
            good,
            reference: String::new(),
            random: Random(seed),
            seed,
            last: "opening".to_owned(),
            edits: 0,
            memory: Vec::new(),
            taken: [0; 2],
            in_window,
            _display: display,
        };
        assert_eq!(storm.line(Duration::from_secs(60))["event"], "ready");
        if in_window {
            storm.ask(&json!({ "do": "pause" }));
        }
        storm.reference = storm.first_picture();
        assert!(!is_black(&storm.reference));
        storm
    }

    /// Ends the test; the project stays, to look for the reason.
    fn fail(&mut self, why: &str) -> ! {
        let kept = std::env::temp_dir().join(format!("raxel-storm-{}", self.seed));
        let _ = fs::remove_dir_all(&kept);
        let _ = fs::create_dir_all(&kept);
        for (path, good) in &self.good {
            let now = fs::read(self.project.path(path)).unwrap_or_default();
            if now != *good {
                let _ = fs::write(kept.join(path.replace('/', "_")), now);
            }
        }
        let log = fs::read_to_string(self.project.path("log")).unwrap_or_default();
        let log: Vec<&str> = log.lines().rev().take(30).collect();
        let log: Vec<&str> = log.into_iter().rev().collect();
        let ended = self.child.0.try_wait();
        panic!(
            "{why}\nseed {}, edit {}: {}\nfiles that are not as they were: {}\nprocess: {ended:?}\n{}",
            self.seed,
            self.edits,
            self.last,
            kept.display(),
            log.join("\n")
        );
    }

    fn line(&mut self, within: Duration) -> Value {
        match self.lines.recv_timeout(within) {
            Ok(line) => serde_json::from_str(&line).unwrap_or_else(|error| self.fail(&format!("{error}: {line}"))),
            Err(error) => self.fail(&format!("no answer: {error}")),
        }
    }

    /// Asks for something; events that come meanwhile are given to `event`.
    fn ask_with(&mut self, request: &Value, event: &mut dyn FnMut(&Value)) -> Value {
        if let Err(error) = writeln!(self.requests, "{request}") {
            self.fail(&format!("it does not listen: {error}"));
        }
        loop {
            // A device that is lost to a shader takes its watchdog's time, six times over on a software device.
            let line = self.line(Duration::from_secs(120));
            if line.get("event").is_some() {
                event(&line);
            } else {
                return line;
            }
        }
    }

    fn ask(&mut self, request: &Value) -> Value {
        let answer = self.ask_with(request, &mut |_| {});
        if answer["ok"] != json!(true) {
            self.fail(&format!("{request}: {answer}"));
        }
        answer
    }

    /// The picture of the first frame of the demo.
    fn picture(&mut self) -> String {
        if self.in_window {
            self.ask(&json!({ "do": "seek", "seconds": 0.0 }));
        } else {
            self.ask(&json!({ "do": "reset" }));
            self.ask(&json!({ "do": "step" }));
        }
        let picture = self.ask_with(&json!({ "do": "picture" }), &mut |_| {});
        // After the loss of a device, a window has no picture until it draws one.
        let drawn_later =
            self.in_window && picture["error"].as_str().is_some_and(|why| why.starts_with("nothing runs yet"));
        if picture["ok"] != json!(true) && !drawn_later {
            self.fail(&format!("no picture: {picture}"));
        }
        picture["data"].as_str().unwrap_or_default().to_owned()
    }

    /// The picture of the files as they were opened. A window draws it when it comes to it.
    fn first_picture(&mut self) -> String {
        let start = Instant::now();
        while self.in_window && self.ask_with(&json!({ "do": "picture" }), &mut |_| {})["ok"] != json!(true) {
            assert!(start.elapsed() < Duration::from_secs(60), "no picture within a minute");
            std::thread::sleep(Duration::from_millis(50));
        }
        let mut picture = self.picture();
        while self.in_window {
            std::thread::sleep(Duration::from_millis(500));
            let next = self.picture();
            if next == picture {
                break;
            }
            picture = next;
        }
        picture
    }

    /// Waits until an edit of the file is there, right or wrong.
    fn wait_for(&mut self, path: &str) -> Came {
        let start = Instant::now();
        loop {
            let mut came = None;
            self.ask_with(&json!({ "do": "wait_reload", "seconds": 5.0 }), &mut |event| {
                let concerns =
                    event["changed"].as_array().is_some_and(|changed| changed.iter().any(|file| *file == path));
                match event["event"].as_str() {
                    Some("reloaded") if concerns => came = Some(Came::Reloaded),
                    Some("reload-failed") if concerns => came = Some(Came::Failed),
                    _ => {}
                }
            });
            if let Some(came) = came {
                return came;
            }
            if start.elapsed() > Duration::from_secs(60) {
                self.fail("an edit was not noticed within a minute");
            }
        }
    }

    /// Saves a file as most editors do, by renaming a new one over it.
    fn save(&mut self, path: &str, bytes: Option<&[u8]>) {
        self.edits += 1;
        let path = self.project.path(path);
        let Some(bytes) = bytes else { return fs::remove_file(path).unwrap() };
        let new = path.with_extension("new");
        fs::write(&new, bytes).unwrap();
        fs::rename(new, path).unwrap();
    }

    /// One file is broken, looked at, and mended.
    fn gust(&mut self) {
        let index = self.random.below(self.good.len());
        let (path, good) = self.good[index].clone();
        let (how, text) = broken(&good, &mut self.random);
        if text.as_ref() == Some(&good) {
            return;
        }
        self.last = format!("{path}: {how}");
        self.save(path, text.as_deref());
        let came = self.wait_for(path);
        self.taken[usize::from(came == Came::Failed)] += 1;
        match came {
            Came::Failed => self.must_be_as_before("an edit that is wrong changed the picture"),
            Came::Reloaded if is_black(&self.picture()) || self.random.below(16) == 0 => {
                self.compare_with_a_fresh_start();
            }
            Came::Reloaded => {}
        }
        if self.random.below(4) == 0 {
            // On through both graphs, the edit of the world and the other target.
            self.ask(&json!({ "do": "step", "frames": 5 }));
        }
        self.save(path, Some(&good));
        if self.wait_for(path) != Came::Reloaded {
            self.fail("what was good before is called wrong");
        }
        self.must_be_as_before("the files are as they were, the picture is not");
        self.note_memory();
    }

    /// Several files are broken in turn without waiting, written in place; at last all are mended.
    fn squall(&mut self) {
        let count = 2 + self.random.below(6);
        self.last = format!("{count} edits without a pause");
        let mut touched = Vec::new();
        for _ in 0..count {
            // The demo decides when all of it has been seen.
            let index = self.random.below(self.good.len() - 1);
            let (path, good) = self.good[index].clone();
            let (_, text) = broken(&good, &mut self.random);
            fs::write(self.project.path(path), text.unwrap_or_default()).unwrap();
            self.edits += 1;
            touched.push(index);
            std::thread::sleep(Duration::from_millis(self.random.below(120) as u64));
        }
        for index in touched {
            let (path, good) = self.good[index].clone();
            fs::write(self.project.path(path), good).unwrap();
            self.edits += 1;
        }
        let marked = [DEMO.as_bytes(), format!("# {}\n", self.edits).as_bytes()].concat();
        self.save(DEMO_PATH, Some(&marked));
        // The last files may have been read before they were whole.
        while self.wait_for(DEMO_PATH) != Came::Reloaded {}
        self.must_be_as_before("the files are as they were, the picture is not");
        self.note_memory();
        let demo = self.good.len() - 1;
        self.good[demo].1 = marked;
    }

    /// The picture is that of the good files.
    fn must_be_as_before(&mut self, otherwise: &str) {
        let start = Instant::now();
        // A window draws it when it comes to it, and an older edit may still be on its way.
        while self.picture() != self.reference {
            if start.elapsed() > Duration::from_secs(120) {
                self.fail(otherwise);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Notes how much memory the process has now.
    fn note_memory(&mut self) {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.0.id())).unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        self.memory.extend(resident.and_then(|text| text.trim().trim_end_matches(" kB").parse::<u64>().ok()));
    }

    /// After a good edit, the session shows the same as a new process over the same files.
    fn compare_with_a_fresh_start(&mut self) {
        if self.in_window {
            return;
        }
        let run = self.project.raxel(&["render", DEMO_PATH, "--size", "64x36", "--frames", "1", "-o", "fresh.png"]);
        if run.code != 0 {
            self.fail(&format!("it runs, and a new process says: {}", run.stderr));
        }
        self.ask(&json!({ "do": "reset" }));
        self.ask(&json!({ "do": "step" }));
        self.ask(&json!({ "do": "screenshot", "path": "running.png" }));
        let pixels = |name: &str| image::open(self.project.path(name)).unwrap().into_rgb8().into_raw();
        // An edit may move the caption to this frame, over the lower rows.
        let rows = 64 * 3 * 22;
        if pixels("fresh.png")[..rows] != pixels("running.png")[..rows] {
            fs::copy(self.project.path("fresh.png"), std::env::temp_dir().join("raxel-storm-fresh.png")).unwrap();
            fs::copy(self.project.path("running.png"), std::env::temp_dir().join("raxel-storm-running.png")).unwrap();
            self.fail("a new process shows another picture");
        }
    }

    fn rage(&mut self, edits: usize) {
        while self.edits < edits {
            if self.random.below(6) == 0 {
                self.squall();
            } else {
                self.gust();
            }
            if self.edits / 500 != self.memory.len() / 500 && self.memory.len().is_multiple_of(100) {
                eprintln!("{} edits, {:?} right and wrong, {:?} KiB", self.edits, self.taken, self.memory.last());
            }
        }
        self.ask(&json!({ "do": "quit" }));
        let status = self.child.finish();
        let log = fs::read_to_string(self.project.path("log")).unwrap_or_default();
        if status.code() != Some(0) || log.contains("validation") {
            self.fail(&format!("it ended with {status}"));
        }
        assert!(!log.contains("the panels are as at first"), "{log}");
        assert!(self.taken.iter().all(|count| *count > 0), "{:?}", self.taken);
        // Shaders and pipelines of earlier edits are kept up to a limit, which a long run reaches in its first half.
        let median = |part: &[u64]| {
            let mut sorted = part.to_vec();
            sorted.sort_unstable();
            sorted[sorted.len() / 2]
        };
        let quarter = self.memory.len() / 4;
        let (before, after) = (median(&self.memory[quarter..2 * quarter]), median(&self.memory[3 * quarter..]));
        eprintln!(
            "seed {}: {} edits, {:?} right and wrong, {before} KiB, {after} KiB",
            self.seed, self.edits, self.taken
        );
        let flat = after < before + before / 8 + 16 * 1024;
        assert!(edits < LONG || flat, "memory grows: {before} KiB, {after} KiB");
    }
}

/// Whether all pixels are black, of RGBA bytes in base64: three pixels are sixteen characters.
fn is_black(base64: &str) -> bool {
    base64.trim_end_matches('=').as_bytes().chunks(16).all(|part| b"AAAA/wAAAP8AAAD/".starts_with(part))
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name} is a number")))
}

#[test]
fn some_edits_headless() {
    Storm::start(number("RAXEL_STORM_SEED", 1), false).rage(number("RAXEL_STORM_EDITS", 160) as usize);
}

#[test]
fn some_edits_in_a_window() {
    Storm::start(number("RAXEL_STORM_SEED", 6), true).rage(number("RAXEL_STORM_EDITS", 20) as usize);
}

#[test]
#[ignore = "half an hour"]
fn ten_thousand_edits() {
    let edits = number("RAXEL_STORM_EDITS", 10_000) as usize;
    Storm::start(number("RAXEL_STORM_SEED", 3), false).rage(edits * 3 / 4);
    Storm::start(number("RAXEL_STORM_SEED", 4), true).rage(edits / 4);
}

#[test]
fn black_is_told_from_dark() {
    assert!(is_black("AAAA/wAAAP8AAAD/AAAA/w==") && is_black("AAAA/wAAAP8AAAD/AAAA/wAAAP8="));
    assert!(!is_black("AAAA/wAAAP8AAAD/AQAA/w=="));
    assert!(repository().join(FILES[0]).exists());
}
