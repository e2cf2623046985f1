//! Vulkan fails under a window, one call in each run. The window goes on, or ends with one error. It never panics, hangs, or stays black without
//! an error.
//!
//! Calls for surfaces and swapchains fail with each of their errors, at one of the calls; with `RAXEL_FAULTS=all` at every one. Of all other calls,
//! the suite tries a few, chosen by the seed `RAXEL_FAULTS_SEED`; `-- --ignored` tries each error at up to [`MOST`] calls of one name.
#![cfg(target_os = "linux")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{CALLS, Display, Fault, Faults, Project, RunRaxel, Running, chosen, command, eventually};

const SIZE: [usize; 2] = [160, 90];

/// At as many calls of one name each error is tried.
const MOST: usize = 4;

/// A call, how many of its name come before it, and its answer.
type Case = (&'static str, usize, Fault);

/// A display, a project, and the library before Vulkan.
struct Stage {
    display: Display,
    project: Project,
    faults: Faults,
    log: PathBuf,
    /// The window's pictures of two debug targets.
    pictures: [Vec<[u8; 3]>; 2],
}

impl Stage {
    fn new() -> Self {
        let project = Project::shipped();
        let pictures = ["normal", "steps"].map(|target| {
            let size = format!("{}x{}", SIZE[0], SIZE[1]);
            let out = ["--size", &size, "--target", target, "-o", "r.png"];
            project
                .raxel(&[&["render", "graphs/inspect.toml", "--world", "worlds/menger.toml"], &out[..]].concat())
                .exits(0);
            let image = image::open(project.path("r.png")).unwrap().into_rgb8();
            image.pixels().map(|pixel| pixel.0).collect()
        });
        let faults = Faults::new(&project);
        Self { display: Display::start(), log: project.path("log"), faults, project, pictures }
    }

    /// A window that is resized there and back, shows two pictures, and is closed. Where it reports an error, its pictures are not waited for. Gives its
    /// exit code.
    fn run(&self) -> i32 {
        let size = format!("{}x{}", SIZE[0], SIZE[1]);
        let shown = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--validate", "--no-panels"];
        let mut command = command(self.project.root(), &[&shown[..], &["--size", &size]].concat());
        command.envs(self.faults.variables()).env("RAXEL_CACHE", self.project.path("cache"));
        command.env("DISPLAY", &self.display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stderr(fs::File::create(&self.log).unwrap()));
        let screen = || self.display.pixels(SIZE[0], SIZE[1]);
        eventually("the first picture", || screen() == self.pictures[0] || child.ended() || self.errors() > 0);
        let window = || self.display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        eventually("a window", || child.ended() || !window().is_empty());
        let window = window();
        let resize = |width: &str, height: &str| drop(self.display.xdotool(&["windowsize", &window, width, height]));
        if !child.ended() {
            resize("100", "60");
            eventually("another size", || screen() != self.pictures[0] || child.ended());
            resize(&SIZE[0].to_string(), &SIZE[1].to_string());
            eventually("the size before", || screen() == self.pictures[0] || child.ended() || self.errors() > 0);
            drop(self.display.xdotool(&["windowfocus", &window]));
            self.press("Tab", || screen() == self.pictures[1] || child.ended() || self.errors() > 0);
            self.press("Escape", || child.ended());
        }
        child.finish().code().unwrap_or(-1)
    }

    /// How many errors the window has reported.
    fn errors(&self) -> usize {
        let said = fs::read_to_string(&self.log).unwrap();
        said.lines().filter(|line| line.starts_with("error")).count()
    }

    /// Presses a key, and again when nothing came of it: a busy machine may lose one while the window takes the focus.
    fn press(&self, key: &str, mut holds: impl FnMut() -> bool) {
        let mut polls = 0;
        eventually(key, || {
            if polls % 100 == 0 {
                self.display.xdotool(&["key", key]);
            }
            polls += 1;
            holds()
        });
    }

    /// Lets one call fail. Returns whether there was that call, and the defects of its outcome.
    fn wrong(&self, (call, skip, fault): Case) -> (bool, Option<String>) {
        self.faults.arm(call, skip, fault);
        let code = self.run();
        let reached = self.faults.disarm().into_iter().any(|(_, answer)| answer == fault as i32);
        let (said, errors) = (fs::read_to_string(&self.log).unwrap(), self.errors());
        let right = if is_of_windows(call) {
            // If only the window's images fail, or a device is lost, the window goes on. An unknown error may be any.
            let goes_on = call.contains("AcquireNextImage") || call == "vkQueuePresentKHR";
            let goes_on = goes_on && !matches!(fault, Fault::HostMemory | Fault::DeviceMemory | Fault::Unknown);
            match code {
                0 => errors == 0,
                4 | 5 => errors == 1 && reached && !goes_on,
                _ => false,
            }
        } else {
            match code {
                // A step that was refused is one error.
                0 => errors <= usize::from(reached),
                3..=5 => errors == 1 && reached,
                _ => false,
            }
        };
        let panicked = said.contains("panicked") || said.contains("bug in raxel");
        let wrong = !right || panicked;
        (reached, wrong.then(|| format!("{call} {skip} {fault:?} (reached: {reached}): exit code {code}\n{said}")))
    }
}

/// Whether a call is about a window.
fn is_of_windows(call: &str) -> bool {
    ["Surface", "Swapchain", "AcquireNextImage", "QueuePresent"].iter().any(|part| call.contains(part))
}

/// How often a run makes each call if none fails.
fn counted(stage: &Stage) -> BTreeMap<String, usize> {
    stage.faults.disarm();
    assert_eq!(stage.run(), 0, "{}", fs::read_to_string(&stage.log).unwrap());
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (name, _) in stage.faults.disarm() {
        *counts.entry(name).or_default() += 1;
    }
    counts
}

/// The calls of a run that are about windows, or those that are not, with each of their errors, where `skips` says: it knows the call's number of turns, and the
/// turn and the number of its errors.
fn cases(
    counts: &BTreeMap<String, usize>,
    of_windows: bool,
    skips: impl Fn(usize, usize, usize) -> Vec<usize>,
) -> Vec<Case> {
    let mut cases = Vec::new();
    for (call, answers) in CALLS.iter().filter(|(call, _)| is_of_windows(call) == of_windows) {
        let Some(count) = counts.get(*call).copied() else { continue };
        for (turn, fault) in answers.iter().enumerate() {
            cases.extend(skips(count, turn, answers.len()).into_iter().map(|skip| (*call, skip, *fault)));
        }
    }
    println!("{} cases; calls of a whole run: {counts:?}", cases.len());
    cases
}

fn try_each(stages: [Stage; 2], cases: Vec<Case>) {
    let count = cases.len();
    let (cases, wrong, reached) = (Mutex::new(cases), Mutex::new(Vec::new()), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for stage in stages {
            let (cases, wrong, reached) = (&cases, &wrong, &reached);
            scope.spawn(move || {
                while let Some(case) = { cases.lock().unwrap().pop() } {
                    let (was_reached, found) = stage.wrong(case);
                    reached.fetch_add(usize::from(was_reached), Ordering::Relaxed);
                    // At once: a long run may be cut off.
                    found.iter().for_each(|found| println!("{found}"));
                    wrong.lock().unwrap().extend(found);
                }
            });
        }
    });
    let (wrong, reached) = (wrong.into_inner().unwrap(), reached.into_inner());
    // The number of drawn frames depends on time, so another run may lack the last call of one run.
    assert!(4 * reached > 3 * count, "{reached} of {count} calls were made");
    assert!(wrong.is_empty(), "{} are wrong\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_window_goes_on_or_ends_with_one_error_after_any_call_for_it_has_failed() {
    let stages = [Stage::new(), Stage::new()];
    let all = std::env::var("RAXEL_FAULTS").is_ok_and(|which| which == "all");
    // Spread over the calls: some at the opening, some after a change of size.
    let spread = |count, turn, faults| vec![turn * (count - 1) / (faults - 1)];
    let every = |count, _, _| (0..count).collect();
    let counts = counted(&stages[0]);
    let cases = if all { cases(&counts, true, every) } else { cases(&counts, true, spread) };
    assert!(cases.len() > 20, "calls for windows are made: {}", cases.len());
    try_each(stages, cases);
}

/// Calls that are not about windows.
fn other_cases(stage: &Stage) -> Vec<Case> {
    let skips = |count: usize, _, _| {
        let most = count.min(MOST);
        (0..most).map(|at| at * (count - 1) / (most - 1).max(1)).collect()
    };
    cases(&counted(stage), false, skips)
}

#[test]
fn a_window_goes_on_or_says_why_not_after_some_call_has_failed() {
    let stages = [Stage::new(), Stage::new()];
    let cases = other_cases(&stages[0]);
    assert!(cases.len() > 200, "calls are made: {}", cases.len());
    try_each(stages, chosen(cases, 20));
}

/// `RAXEL_FAULTS` chooses cases by a part of their text, such as `vkQueueSubmit2` or `DeviceLost`.
#[test]
#[ignore = "an hour of processor time at most: every call with every error"]
fn a_window_goes_on_or_says_why_not_after_any_call_has_failed() {
    let stages = [Stage::new(), Stage::new()];
    let mut cases = other_cases(&stages[0]);
    if let Ok(part) = std::env::var("RAXEL_FAULTS") {
        cases.retain(|case| format!("{case:?}").contains(&part));
    }
    try_each(stages, cases);
}
