//! `raxel bench light --film DEMO`: frames of a film against their moments at rest.

use std::path::Path;

use raxel_gpu::{Device, DeviceKind, DeviceOptions};
use raxel_measure::light::film::{Compared, FilmError, FilmOptions, Filmed, WorstAndMean, film};
use raxel_output::{Folders, Pending, Table, shown};
use raxel_runtime::FrameError;
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::{FileKind, OfflineProject};
use raxel_terminal::session::{assigned, open_failure};
use serde_json::{Value, json};

use super::super::about::{command, today};
use super::Args;

/// Frames after a stop.
const STOP: u32 = 16;

/// Runs the demo by each graph that is named, or by its own.
pub(super) fn run(args: &Args, demo: &Path, device: &DeviceOptions, console: &Console) -> Result {
    if FileKind::of_named(demo) != FileKind::Demo {
        return Err(Failure::usage(format!("`{}` is no demo", demo.display())).help("--film worlds/NAME.demo.toml"));
    }
    let offline = OfflineProject::around(demo).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let path = offline.project.path_of(demo).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let read = OfflineProject::good(offline.loader.demo(&path), console)?;
    let graphs: Vec<Option<String>> = if args.systems.is_empty() {
        vec![None]
    } else {
        let find = |name: &String| super::find_graph(name, &offline.project).map(Some);
        args.systems.iter().map(find).collect::<Result<_>>()?
    };
    let set = args.set.iter().map(|text| assigned("--set", text)).collect::<Result<Vec<_>>>()?;
    let _made = args.output.as_ref().map(|folder| Folders::make(folder)).transpose()?;
    if let Some(folder) = &args.output {
        Pending::new(&folder.join("film.json"))?;
    }
    let software = Device::new(device)?.capabilities().kind == DeviceKind::Cpu;
    let options = |graph: &Option<String>| FilmOptions {
        project: offline.project.root().to_owned(),
        demo: offline.project.on_disk(&path),
        graph: graph.clone(),
        set: set.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect(),
        device: device.device.clone(),
        validation: device.validation,
        size: args.size.map_or(if software { [96, 54] } else { read.size }, |size| size.0),
        fps: args.fps.unwrap_or(read.fps),
        every: args.every,
        settle: args.settle.unwrap_or(if software { 32 } else { 500 }),
        stop: STOP,
    };
    let mut all = Vec::new();
    let mut complaints = false;
    for graph in &graphs {
        let options = options(graph);
        let filmed = film(&options).map_err(|error| failure(error, &path, console))?;
        console.diagnostics(&filmed.messages.0, &filmed.messages.1, To::Stderr);
        for complaint in &filmed.complaints {
            console.message(&format!("validation {}", complaint.replace('\n', " ")));
        }
        complaints |= !filmed.complaints.is_empty();
        match console.format() {
            Format::Json => console::json(&document(&path, &options, &filmed)),
            _ => console::data(&table(&path, &options, &filmed)),
        }
        all.push((options, filmed));
    }
    if let Some(folder) = &args.output {
        let [csv_path, json_path] = ["film.csv", "film.json"].map(|name| folder.join(name));
        Pending::new(&csv_path)?.finish(&csv(&all)?)?;
        let documents: Vec<Value> = all.iter().map(|(options, filmed)| document(&path, options, filmed)).collect();
        let value = json!({ "command": command(std::env::args().skip(1)), "date": today(), "films": documents });
        Pending::new(&json_path)?.finish(format!("{value:#}\n").as_bytes())?;
        console.message(&format!("wrote {}, {}", shown(&csv_path), shown(&json_path)));
    }
    if complaints {
        return Err(Failure::new(Exit::Validation, "the validation layer has complained; see above"));
    }
    Ok(())
}

fn failure(error: FilmError, demo: &str, console: &Console) -> Failure {
    match error {
        FilmError::Open(error) => open_failure(error, console),
        FilmError::Frame(FrameError::Device(error)) => error.into(),
        FilmError::Set(error) => Failure::usage(format!("`--set`: {error}")),
        error @ FilmError::Short { .. } => {
            Failure::usage(format!("`{demo}`: {error}")).help("--every takes fewer seconds")
        }
        error => Failure::new(Exit::Project, format!("`{demo}`: {error}")),
    }
}

/// A line for each moment, then the worst and the mean of all.
fn table(demo: &str, options: &FilmOptions, filmed: &Filmed) -> String {
    let [width, height] = options.size;
    let mut text = format!(
        "{demo} by {}, {width}×{height}, {} frames a second, settled after {} frames, {}\n{:>9} {:>10} {:>20} {:>12}\n",
        filmed.graph,
        options.fps,
        options.settle,
        filmed.device.name,
        "second",
        "FLIP",
        format!("{STOP} frames later"),
        "brightness"
    );
    let line = |name: &str, film: f64, stopped: f64, brightness: f64| {
        format!("{name:>9} {film:>10.4} {stopped:>20.4} {:>10.2} %\n", 100.0 * brightness)
    };
    for Compared { second, film, stopped, brightness, .. } in &filmed.moments {
        text += &line(&second.to_string(), *film, *stopped, *brightness);
    }
    let [film, stopped, brightness] = figures(filmed);
    text += &line("worst", film.worst, stopped.worst, brightness.worst);
    text += &line("mean", film.mean, stopped.mean, brightness.mean);
    text
}

/// Worst and mean of the film, of its stops, of its brightness.
fn figures(filmed: &Filmed) -> [WorstAndMean; 3] {
    [
        filmed.worst_and_mean(|moment| moment.film),
        filmed.worst_and_mean(|moment| moment.stopped),
        filmed.worst_and_mean(|moment| moment.brightness),
    ]
}

fn document(demo: &str, options: &FilmOptions, filmed: &Filmed) -> Value {
    let figures = figures(filmed).map(|WorstAndMean { worst, mean }| json!({ "worst": worst, "mean": mean }));
    json!({
        "reason": "bench-light-film",
        "demo": demo,
        "graph": filmed.graph,
        "device": filmed.device.name,
        "driver": filmed.device.driver,
        "size": options.size,
        "fps": options.fps,
        "settle": options.settle,
        "stop": options.stop,
        "moments": filmed.moments,
        "film": figures[0],
        "stopped": figures[1],
        "brightness": figures[2],
    })
}

fn csv(all: &[(FilmOptions, Filmed)]) -> Result<Vec<u8>> {
    let mut table = Table::new(["graph", "second", "frame", "flip", "flip_stopped", "brightness"].iter())?;
    for (_, filmed) in all {
        for moment in &filmed.moments {
            let Compared { second, frame, film, stopped, brightness } = moment;
            let numbers = [second.to_string(), frame.to_string(), film.to_string(), stopped.to_string()];
            table.row(std::iter::once(filmed.graph.clone()).chain(numbers).chain([brightness.to_string()]))?;
        }
    }
    Ok(table.finish()?)
}
