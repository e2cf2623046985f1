//! `raxel bench light`: lighting systems by run time against error.

mod chart;
mod files;
mod film;
mod scenes;
mod summary;
mod table;

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use raxel_diagnostics::names::{closest, list};
use raxel_gpu::{Device, DeviceKind, DeviceOptions};
use raxel_measure::light::error::FORMULA;
use raxel_measure::light::seeded::SceneKind;
use raxel_measure::light::{Bench, Effort, Epsilon, LightError, Outcome, REFERENCE, References, Scene};
use raxel_output::{Folders, Pending};
use raxel_runtime::project::Project;
use raxel_terminal::args::{Messages, Size, each_once, size};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::Eye;

use super::labels::stem;

/// Judges lighting systems: the error of their light against a converged path tracer, bias and noise apart, over GPU time.
///
/// Scenes are those with names, any world, or random ones by a seed. With `--film`, frames of a demo are compared with their moments at rest.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  raxel bench light -o out/                          everything, with CSV, JSON and charts\n  \
                        raxel bench light face_cache --scenes room,leak    one system in two scenes\n  \
                        raxel bench light face_cache --seed 7              one system in random scenes\n  \
                        raxel bench light --seed 7 --print-scenes          the files of these scenes\n  \
                        raxel bench light face_cache --world worlds/frontier.toml --set sun_elevation=-6 --set sun_strength=0\n  \
                        raxel bench light face_cache --world worlds/fair.toml --move carousel=40 --move camera=0,0,0\n  \
                        raxel bench light --film worlds/dusk.demo.toml     frames of a film against their moments at rest\n  \
                        raxel bench light --references -o out/             only the references, with their hashes"
)]
pub(crate) struct Args {
    /// Systems, by file or by name; all of graphs/light and graphs/rivals/light by default. The path tracer itself is always the first.
    #[arg(value_name = "GRAPH")]
    systems: Vec<String>,

    /// Scenes: valley, near, room, lamps, menger, leak, or any world as WORLD or WORLD:CAMERA; those six by default.
    #[arg(long, value_name = "SCENE,…", value_delimiter = ',')]
    scenes: Vec<String>,

    /// A scene of this world, streamed or not, seen from `--camera`.
    #[arg(long, value_name = "WORLD")]
    world: Option<PathBuf>,

    /// The camera of that scene.
    #[command(flatten)]
    eye: Eye,

    /// Random scenes of this seed: the same seed gives the same scenes.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// How many random scenes, the kinds in turn.
    #[arg(long, value_name = "K", default_value_t = 12, requires = "seed", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,

    /// Kinds of random scenes.
    #[arg(
        long,
        value_name = "KIND,…",
        value_delimiter = ',',
        requires = "seed",
        value_parser = PossibleValuesParser::new(SceneKind::ALL.map(SceneKind::name)),
        default_value = "room,street,cave,land"
    )]
    kinds: Vec<String>,

    /// Print the world files of the random scenes, and run nothing.
    #[arg(long, requires = "seed")]
    print_scenes: bool,

    /// Set a param in every scene and in every system that has it; may be repeated.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    /// Moves something besides the scenes' own motion: a param by that much a second, or `camera=X,Y,Z` by that many voxels a second; may
    /// be repeated.
    #[arg(long = "move", value_name = "NAME=RATE", allow_hyphen_values = true)]
    moves: Vec<String>,

    /// The ε of errors: `mean`, the square of a third of the mean luminance, or a number; 0.01 in the scenes with names, else `mean` by default.
    #[arg(long, value_name = "mean|E", value_parser = epsilon)]
    epsilon: Option<Epsilon>,

    /// Compare frames of this demo with their moments at rest, by its own graph or by each GRAPH.
    #[arg(
        long,
        value_name = "DEMO",
        conflicts_with_all = [
            "scenes", "world", "camera", "look_at", "seed", "moves", "epsilon", "frames", "pan", "lag", "paths", "goal", "references"
        ]
    )]
    film: Option<PathBuf>,

    /// Seconds from one moment of the film to the next.
    #[arg(long, value_name = "SECONDS", default_value = "1", requires = "film", value_parser = seconds)]
    every: f64,

    /// Frames of a moment of the film until it counts as settled; 500 on a GPU and 32 on a software device by default.
    #[arg(long, value_name = "N", requires = "film", value_parser = clap::value_parser!(u32).range(1..=60_000))]
    settle: Option<u32>,

    /// Frames a second of the film; the demo's by default.
    #[arg(long, value_name = "FPS", requires = "film", value_parser = seconds)]
    fps: Option<f64>,

    /// Pixels; 960x540 on a GPU and 96x54 on a software device by default.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    /// Frames of a still camera; 256 on a GPU and 16 on a software device by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=60_000))]
    frames: Option<u32>,

    /// Frames in which camera, params and instances move; 120 on a GPU by default, on a software device 8 with `--seed` or `--move` and else none.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pan: Option<u32>,

    /// Frames after the lamps go out; 100 on a GPU and none on a software device by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=10_000))]
    lag: Option<u32>,

    /// Most paths a pixel of each half of a reference; 16384 on a GPU and 256 on a software device by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1_000_000))]
    paths: Option<u32>,

    /// A half of a reference is good enough with this relative square error; 5e-6 on a GPU and 1e-3 on a software device by default.
    #[arg(long, value_name = "E")]
    goal: Option<f64>,

    /// Only make the references, and print their hashes.
    #[arg(long, conflicts_with = "systems")]
    references: bool,

    /// Write results.csv, results.json and a chart for each scene into this folder; of a film, film.csv and film.json.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

fn epsilon(text: &str) -> std::result::Result<Epsilon, String> {
    if text == "mean" {
        return Ok(Epsilon::Mean);
    }
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.map(Epsilon::Fixed).ok_or_else(|| "write `mean`, or a number above 0".to_owned())
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (0.001..=1000.0).contains(number));
    number.ok_or_else(|| "a number from 0.001 to 1000".to_owned())
}

/// One system in one scene.
struct Row {
    system: String,
    outcome: std::result::Result<Outcome, String>,
}

/// A scene with everything that was measured in it. The first row is the path tracer itself.
struct Judgement {
    scene: Scene,
    references: References,
    rows: Vec<Row>,
}

impl Judgement {
    /// Error times milliseconds of the path tracer, by its last picture: every system must beat it.
    fn brute_force(&self) -> Option<f64> {
        let last = self.rows.first()?.outcome.as_ref().ok()?.still.last()?;
        Some(last.judged.error * last.ms).filter(|product| *product > 0.0)
    }

    /// The same with a moving camera.
    fn brute_force_moving(&self) -> Option<f64> {
        let pan = self.rows.first()?.outcome.as_ref().ok()?.pan.as_ref()?;
        Some(pan.judged.error * pan.frame_ms).filter(|product| *product > 0.0)
    }
}

pub(super) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    if let Some(demo) = &args.film {
        return film::run(args, demo, device, console);
    }
    if args.print_scenes {
        scenes::of_seed(args)?.iter().for_each(|seeded| console::data(&format!("{}\n", seeded.text())));
        return Ok(());
    }
    let _made = args.output.as_ref().map(|folder| Folders::make(folder)).transpose()?;
    if let Some(folder) = &args.output {
        Pending::new(&folder.join("results.json"))?;
    }
    let offline = OfflineProject::around(Path::new(".")).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let systems = find_systems(&args.systems, &offline.project)?;
    let scenes = scenes::find(args, &systems, &offline, console)?;
    let effort = effort(args, device, &offline.project)?;
    let mut bench = Bench::new(effort);
    let mut all: Vec<Judgement> = Vec::new();
    let mut failed: Vec<String> = Vec::new();
    if console.format() != Format::Json {
        console::data(&format!("{FORMULA}\n"));
    }
    let random = |judgement: &Judgement| scenes::is_random(&judgement.scene);
    for scene in scenes {
        let references = bench.references(&scene).map_err(|error| reference_failure(error, &scene))?;
        table::print_reference(&references.about, console);
        let mut judgement = Judgement { scene, references, rows: Vec::new() };
        for system in if args.references { &[][..] } else { &systems[..] } {
            let outcome =
                bench.system(system, &judgement.scene, &judgement.references).map_err(|error| error.to_string());
            let (messages, texts) = bench.take_messages();
            console.diagnostics(&messages, &texts, To::Stderr);
            let name = stem(system).to_owned();
            if let Err(reason) = &outcome {
                failed.push(format!("{name} in {}: {reason}", judgement.scene.name));
            }
            judgement.rows.push(Row { system: name, outcome });
            table::print_last(&judgement, console);
        }
        all.push(judgement);
        // A run that is broken off keeps the figures so far.
        if let Some(folder) = &args.output {
            let written = files::write(folder, &bench, &all, &summary::summaries(&all, random))?;
            console.detail(&format!("wrote {}", written.join(", ")));
        }
    }
    summary::print(&summary::summaries(&all, random), console);
    for complaint in bench.complaints() {
        console.message(&format!("validation {}", complaint.replace('\n', " ")));
    }
    if !failed.is_empty() {
        return Err(Failure::new(Exit::Project, format!("not judged: {}", failed.join("; "))));
    }
    if !bench.complaints().is_empty() {
        return Err(Failure::new(Exit::Validation, "the validation layer has complained; see above"));
    }
    Ok(())
}

fn reference_failure(error: LightError, scene: &Scene) -> Failure {
    match error {
        LightError::Open(error) => match *error {
            raxel_runtime::OpenError::Device(error) => error.into(),
            error => Failure::new(Exit::Project, format!("the reference of {}: {error}", scene.name)),
        },
        error => Failure::new(Exit::Project, format!("the reference of {}: {error}", scene.name)),
    }
}

/// The runs and their lengths, with defaults by the kind of the device.
fn effort(args: &Args, device: &DeviceOptions, project: &Project) -> Result<Effort> {
    let software = Device::new(device)?.capabilities().kind == DeviceKind::Cpu;
    let or = |given: Option<u32>, gpu: u32, cpu: u32| given.unwrap_or(if software { cpu } else { gpu });
    let goal = args.goal.unwrap_or(if software { 1e-3 } else { 5e-6 });
    if !goal.is_finite() || goal <= 0.0 {
        return Err(Failure::usage("`--goal` is a number above 0"));
    }
    Ok(Effort {
        project: project.root().to_owned(),
        device: device.device.clone(),
        validation: device.validation,
        size: args.size.map_or(if software { [96, 54] } else { [960, 540] }, |size| size.0),
        frames: or(args.frames, 256, 16),
        pan: or(args.pan, 120, if args.seed.is_some() || !args.moves.is_empty() { 8 } else { 0 }),
        lag: or(args.lag, 100, 0),
        most_paths: or(args.paths, 16384, 256),
        goal,
        keep: true,
    })
}

/// Where systems are: raxel's own, then those that they are compared with.
const FOLDERS: [&str; 2] = ["graphs/light", "graphs/rivals/light"];

/// The path tracer, then the systems that are named, or all.
fn find_systems(named: &[String], project: &Project) -> Result<Vec<String>> {
    if !project.on_disk(REFERENCE).is_file() {
        return Err(Failure::new(Exit::Project, format!("the project has no `{REFERENCE}` to judge by")));
    }
    let systems = if named.is_empty() {
        known_systems(project)
    } else {
        named.iter().map(|name| find_graph(name, project)).collect::<Result<_>>()?
    };
    let all: Vec<String> = std::iter::once(REFERENCE.to_owned()).chain(systems).collect();
    Ok(each_once(all))
}

/// All systems but the path tracers.
fn known_systems(project: &Project) -> Vec<String> {
    let all = FOLDERS.map(|folder| project.graphs_in(folder)).concat();
    all.into_iter().filter(|path| !stem(path).starts_with("reference")).collect()
}

/// The project path of a graph that is named by its file, or as one of the known systems.
fn find_graph(name: &String, project: &Project) -> Result<String> {
    let known = known_systems(project);
    let found = known.iter().find(|path| *path == name || stem(path) == name);
    let file = || project.path_of(Path::new(name)).ok().filter(|path| project.on_disk(path).is_file());
    found.cloned().or_else(file).ok_or_else(|| {
        let failure = Failure::new(Exit::Project, format!("there is no graph `{name}`"));
        if let Some(path) = known.iter().find(|path| stem(path) == stem(name)) {
            return failure.help(format!("did you mean `{path}`?"));
        }
        match closest(name, known.iter().map(|path| stem(path))) {
            Some(close) => failure.help(format!("did you mean `{close}`?")),
            None => {
                failure.help(format!("{} have {}", FOLDERS.join(" and "), list(known.iter().map(|path| stem(path)))))
            }
        }
    })
}
