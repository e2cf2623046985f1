//! `raxel stress`: every tracer held to the exact one, in as many rays as one likes.

mod files;
mod find;
mod one;
mod table;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use raxel_diagnostics::{Files, MemoryFiles};
use raxel_gpu::{Device, DeviceOptions};
use raxel_layouts::Layout;
use raxel_measure::rays::{Method, RayError, Tracer};
use raxel_measure::stress::{self, Invariants, Plan, Refused, Report, Row, RowReport, invariants};
use raxel_terminal::args::{Messages, OnDevice};
use raxel_terminal::console::{Console, Format};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::session::seconds;

/// Traces rays that are hard to trace, by every layout, and counts what is wrong by exact arithmetic.
///
/// Each ray is made from the seed, judged by the exact tracer once, and traced by every row. Exit code 1 when a tracer that claims to be
/// exact is wrong about one ray, gives up, or writes a t that is no number; when the CPU port of the default tracer hits another voxel or
/// face than the device; or when a scene that is moved, turned or mirrored is hit differently. Exit code 4 when the device fails, or has no
/// memory for a part of the run; 5 when it is lost. If it fails, the results before that are printed. See docs/stress.md.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  raxel stress                                            every layout, scene and set, a few seconds\n  \
                  raxel stress --rays 1e9 --layouts tree64 -o out/        a billion rays of the default tracer\n  \
                  raxel stress --sets edges,near-ties --scenes gravel --layouts tree64,svo,tree64:dda\n  \
                  raxel stress --world worlds/valley.toml --rays 1e6\n  \
                  raxel stress --scenes hills@near --ray \"0 20 0  0.5 0.5 0.5  0x3f800000 0 0\"   one ray, traced by all"
)]
pub struct Args {
    /// Sets of rays, by name; all by default.
    #[arg(long, value_name = "SET,…", value_delimiter = ',')]
    sets: Vec<String>,

    /// Scenes, by name; all by default. Each is at two sites, NAME@near around the origin and NAME@far at an end of the coordinates.
    #[arg(long, value_name = "SCENE,…", value_delimiter = ',')]
    scenes: Vec<String>,

    /// A world file in place of the scenes.
    #[arg(long, value_name = "WORLD", conflicts_with = "scenes")]
    world: Option<PathBuf>,

    /// Tracers: LAYOUT for its own, LAYOUT:MARCHER for a marcher of <raxel/rivals/march.glsl> over it, tree64:cpu for the port to the CPU.
    #[arg(long, value_name = "ROW,…", value_delimiter = ',')]
    layouts: Vec<String>,

    /// Rays traced by all rows together; every row, scene and set gets the same share. Accepts 1e9.
    #[arg(long, value_name = "N", default_value = "4e5", value_parser = find::count)]
    rays: u64,

    /// The seed of the rays and of the random scenes.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Trace this ray alone, and print the hits of each row and of the exact tracer. Nine numbers: cell, fraction, direction; then `t_max`
    /// if the ray ends. After the cell, a number that begins with 0x has the bits of a float.
    #[arg(long, value_name = "RAY", value_parser = one::ray, allow_hyphen_values = true)]
    ray: Option<one::NamedRay>,

    /// Seconds after which a submission of rays counts as hung, and the run ends. A submission takes a tenth of a second on most devices.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    watchdog: Duration,

    /// Write the counts of each row, scene and set: FILE.csv, FILE.json, or a folder for both.
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,

    /// The form of its output.
    #[command(flatten)]
    pub messages: Messages,

    /// The device.
    #[command(flatten)]
    pub on: OnDevice,
}

/// The subject of a run, for its heading and its files.
struct About {
    device: String,
    driver: String,
    command: String,
}

/// Runs the verb.
pub fn run(args: &Args, options: &DeviceOptions, console: &Console) -> Result {
    let offline = find::offline();
    let sites = match &args.world {
        Some(world) => find::world(world, console)?,
        None => find::sites(&args.scenes)?,
    };
    let plan = Plan {
        rows: find::rows(&args.layouts)?,
        sets: find::sets(&args.sets)?,
        sites,
        rays: args.rays,
        seed: args.seed,
        watchdog: args.watchdog,
    };
    let mut outputs = args.output.as_deref().map(files::Outputs::prepare).transpose()?.unwrap_or_default();
    // The project's own includes win over those of the binary.
    let files: Arc<dyn Files> =
        offline.map_or_else(|| Arc::new(MemoryFiles::default()) as _, |offline| offline.loader.files().clone());

    let device = Device::new(options)?;
    for verdict in device.verdicts().iter().filter(|verdict| verdict.chosen || console.verbose()) {
        console.detail(&verdict.to_string());
    }
    let capabilities = device.capabilities();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let about = About {
        device: capabilities.name.clone(),
        driver: capabilities.driver.clone(),
        command: format!("raxel {}", arguments.join(" ")),
    };
    if let Some(ray) = &args.ray {
        let broken = one::trace(&plan, &ray.0, &device, &files, console).map_err(|error| failure(error, console))?;
        if !broken.is_empty() {
            return Err(Failure::new(Exit::Check, broken.join("; ")));
        }
        return validated(&device, console);
    }

    let bar = progress(&plan, console);
    let (report, traced) = stress::run(&plan, &device, &files, &mut |at| {
        bar.set_position(at.rays);
        bar.set_message(format!("{}  {}", at.site, at.row));
    });
    bar.set_message("moved, turned and mirrored");
    let mut symmetry = Vec::new();
    let ended = traced.and_then(|()| symmetric((&plan, &report), &device, &files, &mut symmetry));
    bar.finish_and_clear();

    if let Err(error) = ended {
        return Err(stopped((&plan, &report, &symmetry), &about, failure(error, console), console));
    }
    table::print(&plan, &report, &symmetry, &about, console);
    outputs.write(&plan, &report, &symmetry, &about, console)?;
    verdict(&plan, &report, &symmetry, console)?;
    validated(&device, console)
}

/// Prints the results before an error that ended the run, and returns that error. No file is written: a file has the counts of a whole run.
fn stopped(
    (plan, report, symmetry): (&Plan, &Report, &[(Layout, Invariants)]),
    about: &About,
    error: Failure,
    console: &Console,
) -> Failure {
    if report.rows.iter().any(|row| row.total().rays > 0) {
        table::print(plan, report, symmetry, about, console);
        console.message("the run ended early; these are the rays that were judged before");
        let wrong = wrong(plan, report, symmetry, console);
        if !wrong.is_empty() {
            console.message(&wrong.join("; "));
        }
    }
    error
}

/// Exit code 6 when the validation layer has something to say.
fn validated(device: &Device, console: &Console) -> Result {
    let complaints = device.log().take();
    for message in &complaints {
        console.message(&format!("validation [{}]: {}", message.id, message.text.replace('\n', " ")));
    }
    if complaints.is_empty() {
        Ok(())
    } else {
        Err(Failure::new(Exit::Validation, "the validation layer has complained; see above"))
    }
}

/// Moved, turned and mirrored scenes, by each layout's own tracer that is asked for and runs here.
fn symmetric(
    (plan, report): (&Plan, &Report),
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
    all: &mut Vec<(Layout, Invariants)>,
) -> std::result::Result<(), RayError> {
    // 48 worlds a layout: a sample is enough where few rays are asked for.
    let rays = (plan.rays_each() / 16).clamp(16, 1024) as usize;
    for row in report.rows.iter().filter(|row| row.unusable.is_none()) {
        if let Row::Device(method @ Method { layout, marcher: None }) = &row.row {
            let mut tracer = Tracer::new(device, files.clone(), method)?;
            all.push((*layout, invariants(&mut tracer, device, plan, rays)?));
        }
    }
    Ok(())
}

/// Results that must be exact and are not; the first wrong rays are shown.
fn wrong(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], console: &Console) -> Vec<String> {
    let mut wrong = Vec::new();
    for row in report.rows.iter().filter(|row| row.row.exact()) {
        let total = row.total();
        if total.wrong() + total.inexact() > 0 {
            one::show_wrong(plan, row, console);
        }
        let count = total.wrong();
        if count > 0 {
            wrong.push(format!("{} is wrong about {count} rays", row.row));
        }
        let inexact = [("t", total.time), ("uv", total.place), ("number of steps", total.steps)];
        for (what, count) in inexact.into_iter().filter(|(_, count)| *count > 0) {
            wrong.push(format!("{} has a wrong {what} for {count} rays", row.row));
        }
        let differs = row.differs.unwrap_or_default();
        for (what, count) in [("hits", differs.hits), ("steps", differs.steps)] {
            if count > 0 {
                wrong.push(format!("{} and the device differ in {count} {what}", row.row));
            }
        }
    }
    for (layout, found) in symmetry {
        let count = found.moved_wrong + found.turned_wrong;
        if count > 0 {
            wrong.push(format!("{} hits {count} moved, turned or mirrored rays differently", layout.name()));
        }
    }
    wrong
}

/// Exit code 1 when something that must be exact is not; 4 when the device had no memory for a part, 3 when nothing was traced.
fn verdict(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], console: &Console) -> Result {
    let wrong = wrong(plan, report, symmetry, console);
    if !wrong.is_empty() {
        return Err(Failure::new(Exit::Check, wrong.join("; ")));
    }
    let lost: Vec<(&RowReport, &Refused)> = (report.rows.iter())
        .flat_map(|row| row.refused.iter().map(move |refused| (row, refused)))
        .filter(|(_, refused)| refused.out_of_memory)
        .collect();
    if let [(row, first), more @ ..] = &lost[..] {
        let site = &plan.sites[first.site].name;
        let more = if more.is_empty() { String::new() } else { format!(", and {} more", more.len()) };
        let message = format!("`{}` did not trace `{site}`{more}: {}", row.row, first.why);
        let help = "ask for less at once with `--layouts` and `--scenes`, or free memory of the device";
        return Err(Failure::new(Exit::NoDevice, message).help(help));
    }
    if report.rows.iter().all(|row| row.total().rays == 0) {
        return Err(Failure::new(Exit::Project, "nothing could be traced; see the reasons above"));
    }
    Ok(())
}

fn progress(plan: &Plan, console: &Console) -> ProgressBar {
    if !console.watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {percent}%, {eta} left  {msg}");
    ProgressBar::new(plan.total()).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn failure(error: RayError, console: &Console) -> Failure {
    match error {
        RayError::Shader { diagnostics, texts } => console.stop_in(&diagnostics, &texts),
        RayError::Gpu(error @ raxel_gpu::Error::TimedOut { .. }) => {
            Failure::from(error).help("a slow or busy machine may need more time: `--watchdog SECONDS` gives it")
        }
        RayError::Gpu(error) => error.into(),
        error @ (RayError::Binding { .. } | RayError::Layout(_) | RayError::NotStreamed(_)) => {
            Failure::new(Exit::Project, error.to_string())
        }
        // No site has to be too large for these: the streamer, or an edit, is wrong.
        error @ (RayError::Stream(_) | RayError::Edit(_)) => Failure::new(Exit::Check, error.to_string()),
    }
}

impl Args {
    /// The form of messages asked for.
    pub fn format(&self) -> Format {
        self.messages.format
    }
}

#[cfg(test)]
mod tests {
    use raxel_oracle::metrics::Errors;
    use raxel_terminal::console::Color;

    use super::*;

    fn verdict_of(refused: Vec<Refused>, traced: u64) -> Result {
        let plan = Plan {
            rows: vec![Row::default_tracer()],
            sets: find::sets(&["edges".to_owned()]).unwrap(),
            sites: find::sites(&["hills@near".to_owned(), "hills@far".to_owned()]).unwrap(),
            rays: 100,
            seed: 1,
            watchdog: Duration::from_secs(60),
        };
        let row = RowReport {
            row: Row::default_tracer(),
            errors: vec![vec![Errors { rays: traced, ..Errors::default() }], vec![Errors::default()]],
            refused,
            unusable: None,
            seconds: 0.0,
            timed: 0,
            wrong: Vec::new(),
            differs: None,
        };
        let report = Report { rows: vec![row], answered: 0, answer_seconds: 0.0, seconds: 0.0 };
        verdict(&plan, &report, &[], &Console::new(Format::Short, Color::Never, false))
    }

    #[test]
    fn a_run_without_memory_for_a_part_is_no_success() {
        let refused = |out_of_memory| Refused { site: 1, why: "it does not fit".to_owned(), out_of_memory };
        assert_eq!(verdict_of(Vec::new(), 100), Ok(()));
        // The device reports beforehand that it cannot.
        assert_eq!(verdict_of(vec![refused(false)], 100), Ok(()));
        assert_eq!(verdict_of(vec![refused(false)], 0).unwrap_err().exit, Exit::Project);
        for traced in [0, 100] {
            let failure = verdict_of(vec![refused(true)], traced).unwrap_err();
            assert_eq!(failure.exit, Exit::NoDevice);
            assert_eq!(failure.message.as_deref(), Some("`tree64` did not trace `hills@far`: it does not fit"));
        }
    }
}
