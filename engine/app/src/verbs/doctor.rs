//! `raxel doctor`: whether this machine has what raxel needs, and what to do about what it lacks.

mod graph;
mod world;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use raxel_cache::{Cache, CacheLocation, CacheSize, SWITCH};
use raxel_diagnostics::{Diagnostic, MemoryFiles};
use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, ExecutorOptions, FrameInputs, Picture};
use raxel_gpu::{Device, DeviceOptions, Validation};
use raxel_output as output;
use raxel_runtime::BuildError;
use raxel_runtime::load::Loader;
use raxel_runtime::params::Params;
use raxel_runtime::project::Project;
use raxel_runtime::runner::{GraphRunner, Setup};
use raxel_runtime::world::SessionWorld;
use raxel_terminal::args::{Messages, OnDevice};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use serde_json::json;

/// Checks this machine: Vulkan loader, devices, validation layer, shader compiler, a rendered picture, ffmpeg.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 4 when there is no suitable device, 3 when it does not run the graph or the world fits no layout.\n\n\
                  Examples:\n  raxel doctor --graph graphs/beauty.toml\n  raxel doctor --world worlds/valley.toml"
)]
pub(crate) struct Args {
    /// Also say what this graph needs of the device, and whether it runs.
    #[arg(long, value_name = "GRAPH")]
    graph: Option<PathBuf>,

    /// Also say how much memory of the device this world takes: for the graph, or else in each layout.
    #[arg(long, value_name = "WORLD")]
    world: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

/// How one finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grade {
    /// As it should be.
    Good,
    /// Missing, and raxel runs without it.
    Optional,
    /// raxel does not run like this.
    Bad,
}

/// Prints findings as they are made.
struct Report<'t> {
    console: &'t Console,
    failure: Option<Failure>,
}

impl Report<'_> {
    fn line(&self, grade: Grade, what: &str, finding: &str) {
        if self.console.format() == Format::Json {
            let ok = match grade {
                Grade::Good => "ok",
                Grade::Optional => "missing",
                Grade::Bad => "bad",
            };
            return console::json(&json!({ "reason": "doctor", "what": what, "state": ok, "finding": finding }));
        }
        let (mark, color) = match grade {
            Grade::Good => ("ok  ", "\x1b[32m"),
            Grade::Optional => ("none", "\x1b[33m"),
            Grade::Bad => ("BAD ", "\x1b[1;31m"),
        };
        let (on, off) = if self.console.colored(To::Stdout) { (color, "\x1b[0m") } else { ("", "") };
        let mut lines = finding.lines();
        console::data(&format!("{on}{mark}{off}  {what:<17} {}\n", lines.next().unwrap_or_default()));
        for line in lines {
            console::data(&format!("{:24}{line}\n", ""));
        }
    }

    fn bad(&mut self, what: &str, failure: Failure) {
        self.line(Grade::Bad, what, failure.message.as_deref().unwrap_or("does not run: the errors are above"));
        self.failure.get_or_insert(failure);
    }
}

pub(crate) fn run(args: &Args, options: &DeviceOptions, console: &Console) -> Result {
    let Args { graph, world, messages: _, on: _ } = args;
    let mut report = Report { console, failure: None };
    report.line(Grade::Good, "raxel", env!("CARGO_PKG_VERSION"));

    let device = Device::new(&DeviceOptions { validation: Validation::Off, ..options.clone() });
    match &device {
        Ok(device) => {
            let verdicts: Vec<String> = device.verdicts().iter().map(ToString::to_string).collect();
            let able = device.capabilities();
            report.line(Grade::Good, "devices", &verdicts.join("\n"));
            report.line(Grade::Good, "driver", &able.driver);
            report.line(Grade::Good, "camera rays", &able.packets().to_string());
            match able.cannot_present {
                None => report.line(Grade::Good, "windows", "the device can present"),
                Some(why) => {
                    let finding = format!("the device cannot present: {why}; `raxel render` works without");
                    report.line(Grade::Optional, "windows", &finding);
                }
            }
        }
        Err(error) => report.bad("devices", error.into()),
    }

    match Device::new(&DeviceOptions { validation: Validation::Required, ..options.clone() }) {
        Ok(_) => report.line(Grade::Good, "validation layer", "VK_LAYER_KHRONOS_validation; `--validate` uses it"),
        Err(error @ raxel_gpu::Error::NoValidationLayer) => {
            report.line(Grade::Optional, "validation layer", &error.to_string());
        }
        // Said above.
        Err(_) => {}
    }

    match compile() {
        Ok(milliseconds) => {
            report.line(Grade::Good, "shader compiler", &format!("{milliseconds:.0} ms for a small shader"));
        }
        Err(failure) => report.bad("shader compiler", failure),
    }
    if let Ok(device) = &device {
        match render(device) {
            Ok(milliseconds) => {
                report.line(Grade::Good, "rendering", &format!("64×64 pixels as expected in {milliseconds:.0} ms"));
            }
            Err(failure) => report.bad("rendering", failure),
        }
    }

    if let Ok(device) = &device {
        match (graph, world) {
            (Some(graph), world) => graph::judge((graph, world.as_deref()), device, options, &mut report)?,
            (None, Some(world)) => world::judge(world, device, &mut report)?,
            (None, None) => {}
        }
    }

    let (grade, finding) = cache();
    report.line(grade, "cache", &finding);

    match output::ffmpeg_version() {
        Some(version) => report.line(Grade::Good, "ffmpeg", &format!("{version}; `-o film.mp4` uses it")),
        None => report.line(Grade::Optional, "ffmpeg", "not found; films need it: apt-get install ffmpeg"),
    }
    match Project::around(Path::new(".")) {
        Ok(project) => report.line(
            Grade::Good,
            "project",
            &format!(
                "{}: {}, {}, {}",
                project.root().display(),
                counted(project.graphs().len(), "graph", "graphs"),
                counted(project.worlds().len(), "world", "worlds"),
                counted(project.demos().len(), "demo", "demos")
            ),
        ),
        Err(_) => report.line(Grade::Optional, "project", "none around this folder; `raxel new DIR` makes one"),
    }
    report.failure.map_or(Ok(()), Err)
}

/// A number of things in words, e.g. "1 graph" or "2 graphs".
fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Where compiled shaders and pipelines are kept, and whether they are.
fn cache() -> (Grade, String) {
    match CacheLocation::of_environment() {
        CacheLocation::Folder(folder) => {
            let cache = Cache::at(&folder);
            let folder = folder.display();
            // A run that cannot keep its results works, and says nothing.
            let trial = format!("doctor-{}", std::process::id());
            cache.write(&trial, b"kept");
            let keeps = cache.read(&trial).is_some();
            cache.remove(&trial);
            if !keeps {
                let finding = format!("{folder} cannot be written; set {SWITCH} to another folder");
                return (Grade::Optional, finding);
            }
            let CacheSize { entries, bytes } = cache.size();
            (Grade::Good, format!("{folder}: {entries} files, {:.1} MiB", bytes as f64 / f64::from(1 << 20)))
        }
        CacheLocation::Off => (Grade::Good, format!("off, by {SWITCH}")),
        CacheLocation::Unknown => (Grade::Good, format!("off: there is no home folder; set {SWITCH} to a folder")),
    }
}

/// A project of one pass that is compiled in.
fn self_test() -> Loader {
    let files = MemoryFiles::default();
    files.insert("graphs/self-test.toml", include_str!("../../templates/self-test.toml"));
    files.insert("shaders/self-test.comp", include_str!("../../templates/self-test.comp"));
    Loader::with_files(Arc::new(files))
}

/// Compiles the test's shader; milliseconds.
fn compile() -> Result<f64> {
    let start = Instant::now();
    match self_test().graph("graphs/self-test.toml").result {
        Ok(_) => Ok(start.elapsed().as_secs_f64() * 1e3),
        Err(found) => Err(broken(&found)),
    }
}

/// Renders the test's picture and looks at every pixel; milliseconds.
fn render(device: &Arc<Device>) -> Result<f64> {
    const SIZE: u32 = 64;
    let graph = match self_test().graph("graphs/self-test.toml").result {
        Ok(graph) => graph,
        Err(found) => return Err(broken(&found)),
    };
    let start = Instant::now();
    let mut runner = GraphRunner::new(device.clone(), ExecutorOptions::default())?;
    let setup = Setup { output: [SIZE; 2], pinned: Vec::new(), alias: true };
    runner.load(&graph, &SessionWorld::empty(), &Params::default(), setup).map_err(|error| match error {
        BuildError::Diagnosed(found) => broken(&found),
        BuildError::Device(error) => error.into(),
    })?;
    let executor = runner.executor();
    let builtins = Builtins::default();
    let inputs = FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock: Moment::START, disabled: &[] };
    executor.frame(&inputs)?;
    let picture = executor.read_presented()?;
    if picture != expected(SIZE) {
        return Err(Failure::new(Exit::Check, "the picture is not the one that the shader describes"));
    }
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

/// The picture that templates/self-test.comp paints.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the picture has 64 pixels a side, so that every channel is below 256"
)]
fn expected(size: u32) -> Picture {
    let rgba =
        (0..size * size).flat_map(|i| [(i % size * 4) as u8, (i / size * 4) as u8, (i % 7 * 36) as u8, 255]).collect();
    Picture { width: size, height: size, rgba }
}

fn broken(found: &[Diagnostic]) -> Failure {
    let messages: Vec<&str> = found.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
    Failure::new(Exit::Check, messages.join("\n"))
}
