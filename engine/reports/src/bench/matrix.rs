//! `raxel bench [GRAPHS…]`: finds the requested graphs, worlds and layouts in the project, and runs them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};
use raxel_diagnostics::{Diagnostic, names};
use raxel_gpu::{DeviceKind, DeviceOptions};
use raxel_layouts::Layout;
use raxel_measure::bench::{BenchError, Effort, Matrix, Refusal, Row, Runner, cameras};
use raxel_measure::light::DeviceName;
use raxel_output::{Folders, Pending};
use raxel_runtime::world::SessionWorld;
use raxel_terminal::args::{Messages, Size, each_once, size};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;

use super::about::About;
use super::{export, files, table as printed};

/// The cases to measure, and the outputs.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Graphs, by file or by name; all of graphs/bench and graphs/rivals/march by default.
    #[arg(value_name = "GRAPH")]
    graphs: Vec<String>,

    /// Layouts to run the graphs over; `own` is the one that each graph names. All by default. Without GRAPH, only the exact tracers `first_hit` and
    /// `beam` run over all, and the others over their own.
    #[arg(long, value_name = "LAYOUT,…", value_delimiter = ',')]
    layouts: Vec<String>,

    /// Worlds, by file or by name; valley, terrain, menger and monument by default, or all of a project that has none of them.
    #[arg(long, value_name = "WORLD,…", value_delimiter = ',')]
    worlds: Vec<String>,

    /// Cameras by name, `camera` for a world's first; by default all that a world names, or its first if it names none.
    #[arg(long, value_name = "CAMERA,…", value_delimiter = ',')]
    cameras: Vec<String>,

    /// Pixels; 3840x2160 on a GPU and 320x180 on a software device by default.
    #[arg(long, value_name = "WxH,…", value_parser = size, value_delimiter = ',')]
    size: Vec<Size>,

    /// Frames to time.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(3..=100_000))]
    frames: u32,

    /// Frames to run before the timed ones.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    warmup: u32,

    /// Stop after that many seconds of timed frames, if there are three; after four times as many seconds in any case.
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    seconds: f64,

    /// Write results.csv, results.json and a chart for each view into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,

    /// Measure nothing; write the voxels of each world, and the rays and exact hits of each camera, into this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    export: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

impl Args {
    /// The sizes that were asked for, or this one.
    pub(super) fn sizes_or(&self, size: [u32; 2]) -> Vec<[u32; 2]> {
        if self.size.is_empty() { vec![size] } else { self.size.iter().map(|size| size.0).collect() }
    }
}

/// Everything that was asked for, found.
struct Found {
    matrix: Matrix,
    worlds: Vec<Arc<SessionWorld>>,
}

pub(super) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    // Whether files can be made there is found out before anything is measured, which takes minutes.
    let folder = args.output.as_ref().or(args.export.as_ref());
    let _made = folder.map(|folder| Folders::make(folder)).transpose()?;
    for (folder, file) in [(&args.output, "results.csv"), (&args.export, "export.json")] {
        if let Some(folder) = folder {
            Pending::new(&folder.join(file))?;
        }
    }
    let offline = OfflineProject::around(Path::new(".")).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let mut found = find(args, &offline, console)?;
    if let Some(folder) = &args.export {
        if found.matrix.sizes.is_empty() {
            found.matrix.sizes = vec![[320, 180]];
        }
        return export::run(folder, &found.matrix, &found.worlds, console);
    }
    let mut runner = Runner::new(Arc::new(offline.loader), device).map_err(bench_failure)?;
    for verdict in runner.device().verdicts().iter().filter(|verdict| verdict.chosen || console.verbose()) {
        console.detail(&verdict.to_string());
    }
    if found.matrix.sizes.is_empty() {
        let software = runner.device().capabilities().kind == DeviceKind::Cpu;
        found.matrix.sizes = vec![if software { [320, 180] } else { [3840, 2160] }];
    }
    let about = About::of(DeviceName::of(runner.device()));
    if console.format() == Format::Json {
        console::json(&files::head_json(&about, &found.matrix.effort));
    }
    // Errors in a graph are printed before the others are measured, which takes minutes.
    let broken = runner.broken(&found.matrix.graphs);
    console.diagnostics(&broken.found, &broken.texts, To::Stderr);
    // A run that is broken off keeps the figures so far.
    let old_charts = args.output.as_deref().map(files::old_charts).unwrap_or_default();
    let keep = |rows: &[Row]| match &args.output {
        Some(folder) => files::write(folder, &about, &found.matrix.effort, rows, &old_charts),
        None => Ok(Vec::new()),
    };
    let rows = measure(&mut runner, &found, console, &keep)?;
    printed::print_means(&rows, console);
    let complaints = runner.device().log().take();
    let written = keep(&rows)?;
    if !written.is_empty() && console.format() != Format::Json {
        console.message(&format!("wrote {}", written.join(", ")));
    }
    for message in &complaints {
        console.message(&format!("validation [{}]: {}", message.id, message.text.replace('\n', " ")));
    }
    if rows.iter().all(|row| row.outcome.is_err()) {
        return Err(Failure::new(Exit::Project, "nothing could be measured; see the reasons above"));
    }
    if !broken.graphs.is_empty() {
        let graphs = names::list(broken.graphs.iter().map(String::as_str));
        return Err(Failure::new(Exit::Project, format!("graphs that do not compile: {graphs}; see above")));
    }
    if !complaints.is_empty() {
        return Err(Failure::new(Exit::Validation, "the validation layer has complained; see above"));
    }
    exact(&rows)
}

/// Exit code 1 when a graph that claims to be exact is wrong about a ray.
fn exact(rows: &[Row]) -> Result {
    let broken = |row: &Row| {
        let measured = row.outcome.as_ref().ok()?;
        let (case, count) = (&row.case, measured.broken());
        let layout = case.layout.unwrap_or("its world");
        let place = format!("{}, {}", case.world, case.camera);
        (count > 0).then(|| {
            format!("{} over {layout} is wrong about {count} of {} rays in {place}", case.graph, measured.rays)
        })
    };
    let broken: Vec<String> = rows.iter().filter_map(broken).collect();
    if broken.is_empty() {
        return Ok(());
    }
    let failure = Failure::new(Exit::Check, broken.join("; "));
    Err(failure
        .help("`about` of each of these graphs says `exact`; `raxel stress` traces harder rays by the same tracers"))
}

/// Runs the matrix. Each view's table is printed, and all rows so far are kept, when all its rows are there.
fn measure(
    runner: &mut Runner,
    found: &Found,
    console: &Console,
    keep: &dyn Fn(&[Row]) -> Result<Vec<String>>,
) -> Result<Vec<Row>> {
    let bar = progress(console);
    let mut rows: Vec<Row> = Vec::new();
    let mut printed = 0;
    let mut kept: Result<Vec<String>> = Ok(Vec::new());
    let mut said: HashSet<Diagnostic> = HashSet::new();
    let ran = runner.run(&found.matrix, &found.worlds, &mut |row| {
        let new_view = rows.last().is_some_and(|last| !same_view(last, &row));
        if new_view {
            bar.suspend(|| printed::print(&rows[printed..], console));
            printed = rows.len();
            if kept.is_ok() {
                kept = keep(&rows);
            }
        }
        // A refusal of the planner is printed once, not for each view; one that only this layout or device makes is in the table.
        if let Err(Refusal { found, texts, .. }) = &row.outcome {
            let new = |found: &&Diagnostic| !found.labels.is_empty() && said.insert((*found).clone());
            let new: Vec<Diagnostic> = found.iter().filter(new).cloned().collect();
            bar.suspend(|| console.diagnostics(&new, texts, To::Stderr));
        }
        let case = &row.case;
        bar.set_message(format!("{} {} {} {}", case.world, case.camera, case.graph, case.layout.unwrap_or("")));
        bar.inc(1);
        rows.push(row);
    });
    bar.finish_and_clear();
    printed::print(&rows[printed..], console);
    ran.map_err(bench_failure)?;
    kept?;
    Ok(rows)
}

/// Whether two rows are of the same world, camera and size.
pub(super) fn same_view(a: &Row, b: &Row) -> bool {
    (&a.case.world, &a.case.camera, a.case.size) == (&b.case.world, &b.case.camera, b.case.size)
}

fn progress(console: &Console) -> ProgressBar {
    if !console.watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{spinner} {pos} measured, {elapsed}  {msg}");
    ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}

fn bench_failure(error: BenchError) -> Failure {
    match error {
        BenchError::Device(error) => error.into(),
    }
}

fn find(args: &Args, offline: &OfflineProject, console: &Console) -> Result<Found> {
    // An export has no use for graphs.
    let graphs = if args.export.is_some() { Vec::new() } else { each_once(find_graphs(args, offline)?) };
    let layouts = each_once(find_layouts(&args.layouts)?);
    let worlds = each_once(find_worlds(&args.worlds, offline)?);
    if !args.seconds.is_finite() || args.seconds <= 0.0 {
        return Err(Failure::usage("`--seconds` is a number above 0"));
    }
    // The judge holds every ray of a picture and its answer.
    if let Some(Size([width, height])) =
        args.size.iter().find(|Size([w, h])| u64::from(*w) * u64::from(*h) > MOST_PIXELS)
    {
        return Err(Failure::usage(format!(
            "{width}x{height} has more pixels than the {MOST_PIXELS} that can be judged"
        ))
        .help("--size 7680x4320"));
    }
    let load = |path: &String| {
        let world = offline.world(path, console)?;
        // Every pixel is judged by the voxel that it should show, which no moment of such a world has for all of them.
        let instead =
            format!("`raxel bench stream GRAPH --world {path}` measures frames and loading on a flight through it");
        offline.whole(&world, path, Some(&instead), console).map(|()| world)
    };
    let loaded: Vec<Arc<SessionWorld>> = worlds.iter().map(load).collect::<Result<_>>()?;
    check_cameras(&args.cameras, &loaded)?;
    let effort = Effort { warmup: args.warmup, frames: args.frames, seconds: args.seconds };
    let everywhere = |graph: &&String| EVERYWHERE.contains(&graph.as_str());
    let all = !args.graphs.is_empty() || !args.layouts.is_empty();
    let own = if all { Vec::new() } else { graphs.iter().filter(|graph| !everywhere(graph)).cloned().collect() };
    let matrix = Matrix {
        graphs,
        layouts,
        own,
        worlds,
        cameras: each_once(args.cameras.clone()),
        sizes: each_once(args.size.iter().map(|size| size.0).collect()),
        effort,
    };
    Ok(Found { matrix, worlds: loaded })
}

/// The graphs that are measured by default: raxel's own tracers, then the marchers that they are compared with.
const TRACERS: [&str; 2] = ["graphs/bench", "graphs/rivals/march"];

/// Those of [`TRACERS`], then those of graphs, of graphs/rivals and of graphs/examples.
fn find_graphs(args: &Args, offline: &OfflineProject) -> Result<Vec<String>> {
    let bench = TRACERS.map(|folder| offline.project.graphs_in(folder)).concat();
    if args.graphs.is_empty() {
        if bench.is_empty() {
            return Err(Failure::usage("the project has no graph in graphs/bench, and none is named")
                .help("raxel bench graphs/primary.toml"));
        }
        return Ok(bench);
    }
    let others =
        ["graphs", "graphs/rivals", "graphs/examples"].map(|folder| offline.project.graphs_in(folder)).concat();
    let known: Vec<String> = bench.into_iter().chain(others).collect();
    args.graphs.iter().map(|named| find_file("graph", named, "graphs", &known, offline)).collect()
}

/// Pixels of 7680 × 4320.
const MOST_PIXELS: u64 = 33_177_600;

/// Graphs that are run over all layouts when nothing is asked for: the matrix of all with all takes an hour.
const EVERYWHERE: [&str; 2] = ["graphs/bench/first_hit.toml", "graphs/bench/beam.toml"];

/// Worlds by default, in this order.
const WORLDS: [&str; 4] = ["worlds/valley.toml", "worlds/terrain.toml", "worlds/menger.toml", "worlds/monument.toml"];

fn find_worlds(named: &[String], offline: &OfflineProject) -> Result<Vec<String>> {
    let known = offline.project.worlds();
    if !named.is_empty() {
        return named.iter().map(|named| find_file("world", named, "worlds", &known, offline)).collect();
    }
    let usual: Vec<String> =
        WORLDS.iter().filter(|path| known.iter().any(|known| known == *path)).map(|path| (*path).to_owned()).collect();
    match (usual.is_empty(), known.is_empty()) {
        (false, _) => Ok(usual),
        (true, false) => Ok(known),
        (true, true) => Err(Failure::usage("the project has no world, and none is named")),
    }
}

/// A file by its path, or one of those known by its name without folder and ending.
fn find_file(what: &str, named: &str, folder: &str, known: &[String], offline: &OfflineProject) -> Result<String> {
    let stem = |path: &str| path.rsplit('/').next().unwrap_or(path).trim_end_matches(".toml").to_owned();
    if let Some(path) = known.iter().find(|path| *path == named || stem(path) == named) {
        return Ok(path.clone());
    }
    if let Ok(path) = offline.project.path_of(Path::new(named))
        && offline.project.on_disk(&path).is_file()
    {
        return Ok(path);
    }
    let names: Vec<String> = known.iter().map(|path| stem(path)).collect();
    // As for a file that another verb is given.
    let failure = Failure::new(Exit::Project, format!("there is no {what} `{named}`"));
    if let Some(path) = known.iter().find(|path| stem(path) == stem(named)) {
        return Err(failure.help(format!("did you mean `{path}`?")));
    }
    Err(match names::closest(&stem(named), names.iter().map(String::as_str)) {
        Some(close) => failure.help(format!("did you mean `{close}`?")),
        None => failure.help(format!("{folder}/ has {}", names::list(names.iter().map(String::as_str)))),
    })
}

fn find_layouts(wanted: &[String]) -> Result<Vec<Layout>> {
    if wanted.iter().any(|name| name == "own") {
        return match wanted.len() {
            1 => Ok(Vec::new()),
            _ => Err(Failure::usage("`--layouts own` stands alone")),
        };
    }
    if wanted.is_empty() {
        return Ok(raxel_rivals::LAYOUTS.to_vec());
    }
    let names = || raxel_rivals::LAYOUTS.iter().map(|layout| layout.name());
    let find = |name: &String| {
        raxel_rivals::layout(name).ok_or_else(|| {
            let failure = Failure::usage(format!("there is no layout `{name}`"));
            match names::closest(name, names()) {
                Some(close) => failure.help(format!("did you mean `{close}`?")),
                None => failure.help(format!("layouts: {}", names::list(names()))),
            }
        })
    };
    wanted.iter().map(find).collect()
}

/// Every camera must be one of a world that is measured, and every world must have one of them.
fn check_cameras(wanted: &[String], worlds: &[Arc<SessionWorld>]) -> Result {
    let known: Vec<&str> = worlds.iter().flat_map(|world| world.camera_names()).chain(["camera"]).collect();
    for name in wanted {
        if !known.contains(&name.as_str()) {
            let failure = Failure::usage(format!("no world that is measured has a camera `{name}`"));
            return Err(match names::closest(name, known.iter().copied()) {
                Some(close) => failure.help(format!("did you mean `{close}`?")),
                None => failure.help(format!("there are {}", names::list(known.iter().copied()))),
            });
        }
    }
    for world in worlds {
        if cameras(world, wanted).is_empty() {
            let path = world.path.as_deref().unwrap_or_default();
            return Err(Failure::usage(format!("`{path}` has none of the cameras that are asked for"))
                .help("leave it out, or add `camera`, which every world has"));
        }
    }
    Ok(())
}
