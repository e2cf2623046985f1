//! `raxel bench --demo FILE`: the time of each frame of a demo, and of each of its passes.

use std::fmt::Write;
use std::path::Path;

use indicatif::ProgressBar;
use raxel_gpu::DeviceOptions;
use raxel_measure::Times;
use raxel_measure::demo::FrameTimes;
use raxel_measure::light::DeviceName;
use raxel_output::{Folders, Pending, Table, shown};
use raxel_runtime::timeline::Demo;
use raxel_runtime::{Observe, Options, Session};
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::{frame_failure, open_failure, print_messages, print_validation, validated};
use serde_json::{Value, json};

use super::about::About;
use super::matrix;

/// Runs all frames of the demo without a window, one after the other, and reports their times.
pub(super) fn run(file: &Path, args: &matrix::Args, device: &DeviceOptions, console: &Console) -> Result {
    let offline = OfflineProject::around(file).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let path = offline.project.path_of(file).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let demo = OfflineProject::good(offline.loader.demo(&path), console)?;
    let [size] = args.sizes_or(demo.size)[..] else {
        return Err(Failure::usage("a demo is run in one size"));
    };
    let _made = args.output.as_ref().map(|folder| Folders::make(folder)).transpose()?;
    // Whether the files can be made is found out before minutes are spent.
    let files = args.output.as_ref().map(|folder| -> Result<_> {
        let path = |name: &str| folder.join(name);
        Ok([
            (path("demo.csv"), Pending::new(&path("demo.csv"))?),
            (path("demo.json"), Pending::new(&path("demo.json"))?),
        ])
    });
    let files = files.transpose()?;
    let options = Options {
        project: Some(offline.project.root().to_owned()),
        demo: Some(offline.project.on_disk(&path)),
        size,
        step: Some(1.0 / demo.fps),
        device: device.device.clone(),
        validation: device.validation,
        observe: Observe::Shown,
        ..Options::default()
    };
    let mut session = Session::open(options).map_err(|error| open_failure(error, console))?;
    let bar = if console.watched() { ProgressBar::new(demo.frames()) } else { ProgressBar::hidden() };
    let mut times = FrameTimes::default();
    for _ in 0..demo.frames() {
        times.frame(&mut session).map_err(|error| frame_failure(error, console))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let asserted = print_messages(&mut session, console);
    let document = machine(&demo, &session, &times);
    match console.format() {
        Format::Json => console::json(&document),
        _ => console::data(&human(&demo, &session, &times)),
    }
    if let Some([(csv, csv_file), (json, json_file)]) = files {
        csv_file.finish(&table(&times)?)?;
        json_file.finish(format!("{document:#}\n").as_bytes())?;
        console.message(&format!("wrote {}, {}", shown(&csv), shown(&json)));
    }
    let complaints = print_validation(&session, console);
    let failed = times.judge(&demo).filter(|verdict| !verdict.holds).count();
    if failed > 0 {
        return Err(Failure::new(Exit::Check, format!("{failed} checks about passes do not hold")));
    }
    validated(complaints).and(asserted)
}

/// The timed rows: graph, name, times.
fn rows(times: &FrameTimes) -> impl Iterator<Item = (&str, &str, &Times)> {
    let passes = times.passes.iter().map(|pass| (pass.graph.as_str(), pass.pass.as_str(), &pass.times));
    passes.chain([("", "all passes", &times.gpu), ("", "frame", &times.frame)])
}

fn human(demo: &Demo, session: &Session, times: &FrameTimes) -> String {
    let [width, height] = session.size();
    let mut text = format!(
        "{}: {} frames, {width}×{height}, {}\n",
        demo.file,
        times.frame.milliseconds.len(),
        session.device().capabilities().name
    );
    let _ = writeln!(text, "{:>10} {:>10} {:>10} {:>7}", "median ms", "p95 ms", "max ms", "frames");
    for (graph, name, of) in rows(times) {
        let [median, p95, max] = [0.5, 0.95, 1.0].map(|part| of.percentile(part));
        let graph = if demo.graphs.is_empty() || graph.is_empty() { String::new() } else { format!("  ({graph})") };
        let _ = writeln!(text, "{median:10.3} {p95:10.3} {max:10.3} {:7}  {name}{graph}", of.milliseconds.len());
    }
    for verdict in times.judge(demo) {
        let word = if verdict.holds { "ok" } else { "FAILED" };
        let measured = verdict.median_ms.map_or_else(|| "never timed".to_owned(), |median| format!("{median:.3} ms"));
        let _ = writeln!(text, "{word}: pass `{}`: {measured} of {}", verdict.pass, verdict.below_ms);
    }
    text
}

fn table(times: &FrameTimes) -> Result<Vec<u8>> {
    let mut table = Table::new(["graph", "what", "frames", "median_ms", "p95_ms", "max_ms"].iter())?;
    for (graph, name, of) in rows(times) {
        let numbers = [0.5, 0.95, 1.0].map(|part| format!("{:.6}", of.percentile(part)));
        let head = [graph.to_owned(), name.to_owned(), of.milliseconds.len().to_string()];
        table.row(head.into_iter().chain(numbers))?;
    }
    Ok(table.finish()?)
}

fn machine(demo: &Demo, session: &Session, times: &FrameTimes) -> Value {
    let part = |of: &Times| {
        let [median, p95, max] = [0.5, 0.95, 1.0].map(|part| of.percentile(part));
        json!({ "frames": of.milliseconds.len(), "median_ms": median, "p95_ms": p95, "max_ms": max, "milliseconds": of.milliseconds })
    };
    let passes = times.passes.iter().map(|pass| {
        let mut row = part(&pass.times);
        row["graph"] = json!(pass.graph);
        row["pass"] = json!(pass.pass);
        row
    });
    let mut value = About::of(DeviceName::of(session.device())).json("bench-demo");
    value["demo"] = json!(demo.file);
    value["size"] = json!(session.size());
    value["frame"] = part(&times.frame);
    value["gpu"] = part(&times.gpu);
    value["passes"] = passes.collect();
    value["checks"] = json!(times.judge(demo).collect::<Vec<_>>());
    value
}
