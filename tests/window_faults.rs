//! The window system fails under a window: calls for surfaces and swapchains fail, one in each run. The window goes on, or ends with one error.
//! `RAXEL_FAULTS=all` lets each of these calls fail with every error; else each error is tried once, at one of the calls.
#![cfg(target_os = "linux")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{CALLS, Display, Fault, Faults, Project, RunRaxel, Running, command, eventually};

const SIZE: [usize; 2] = [160, 90];

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

    /// A window that is resized there and back, shows two pictures, and is closed. Gives its exit code.
    fn run(&self) -> i32 {
        let size = format!("{}x{}", SIZE[0], SIZE[1]);
        let shown = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--validate", "--no-panels"];
        let mut command = command(self.project.root(), &[&shown[..], &["--size", &size]].concat());
        command.envs(self.faults.variables()).env("RAXEL_CACHE", self.project.path("cache"));
        command.env("DISPLAY", &self.display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stderr(fs::File::create(&self.log).unwrap()));
        let screen = || self.display.pixels(SIZE[0], SIZE[1]);
        eventually("the first picture", || screen() == self.pictures[0] || child.ended());
        let window = self.display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        let resize = |width: &str, height: &str| drop(self.display.xdotool(&["windowsize", &window, width, height]));
        if !child.ended() {
            resize("100", "60");
            eventually("another size", || screen() != self.pictures[0] || child.ended());
            resize(&SIZE[0].to_string(), &SIZE[1].to_string());
            eventually("the size before", || screen() == self.pictures[0] || child.ended());
            drop(self.display.xdotool(&["windowfocus", &window]));
            self.press("Tab", || screen() == self.pictures[1] || child.ended());
            self.press("Escape", || child.ended());
        }
        child.finish().code().unwrap_or(-1)
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
    fn wrong(&self, (call, skip, fault): (&str, usize, Fault)) -> (bool, Option<String>) {
        self.faults.arm(call, skip, fault);
        let code = self.run();
        let reached = self.faults.disarm().into_iter().any(|(_, answer)| answer == fault as i32);
        let said = fs::read_to_string(&self.log).unwrap();
        let errors = said.lines().filter(|line| line.starts_with("error")).count();
        // If only the window's images fail, or a device is lost, the window goes on. An unknown error may be any.
        let goes_on = call.contains("AcquireNextImage") || call == "vkQueuePresentKHR";
        let goes_on = goes_on && !matches!(fault, Fault::HostMemory | Fault::DeviceMemory | Fault::Unknown);
        let right = match code {
            0 => errors == 0,
            4 | 5 => errors == 1 && reached && !goes_on,
            _ => false,
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

#[test]
fn a_window_goes_on_or_ends_with_one_error_after_any_call_for_it_has_failed() {
    let first = Stage::new();
    let stages = [first, Stage::new()];
    // The counted run.
    stages[0].faults.disarm();
    assert_eq!(stages[0].run(), 0, "{}", fs::read_to_string(&stages[0].log).unwrap());
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (name, _) in stages[0].faults.disarm() {
        *counts.entry(name).or_default() += 1;
    }
    let all = std::env::var("RAXEL_FAULTS").is_ok_and(|which| which == "all");
    let mut cases = Vec::new();
    for (call, answers) in CALLS.iter().filter(|(call, _)| is_of_windows(call)) {
        let Some(count) = counts.get(*call).copied() else { continue };
        for (turn, fault) in answers.iter().enumerate() {
            // Spread over the calls: some at the opening, some after a change of size.
            let skips = if all { (0..count).collect() } else { vec![turn * (count - 1) / (answers.len() - 1)] };
            cases.extend(skips.into_iter().map(|skip| (*call, skip, *fault)));
        }
    }
    println!("{} cases; calls of a whole run: {counts:?}", cases.len());
    assert!(cases.len() > 20, "calls for windows are made: {counts:?}");
    let count = cases.len();
    let (cases, wrong, reached) = (Mutex::new(cases), Mutex::new(Vec::new()), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for stage in stages {
            let (cases, wrong, reached) = (&cases, &wrong, &reached);
            scope.spawn(move || {
                while let Some(case) = { cases.lock().unwrap().pop() } {
                    let (was_reached, found) = stage.wrong(case);
                    reached.fetch_add(usize::from(was_reached), Ordering::Relaxed);
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
