//! `raxel bench reload`: from a save to the picture, and from the start of the program to its first one.

use raxel_gpu::DeviceOptions;
use raxel_measure::Times;
use raxel_measure::save_latency::{LatencyError, LatencyOptions, ShaderStages, save_latency};
use raxel_output::Scratch;
use raxel_terminal::args::{Messages, Size, size};
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::session::{What, frame_failure, open_failure};
use serde_json::json;

use super::first_picture::first_picture;

/// Measures the time from a save to its picture, and from the start of the program to the first picture.
///
/// It saves edits of a shader and of a graph, and starts the program with an empty cache and with a full one. It edits a copy of the project, never
/// the project.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples: raxel bench reload --edits 50 --size 640x360\n          raxel bench reload --shader trace.comp"
)]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// The shader to edit, e.g. trace.comp; by default that of the last pass before the picture.
    #[arg(long, value_name = "FILE")]
    shader: Option<String>,

    /// Edits of each kind.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    edits: u32,

    /// Pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "640x360")]
    size: Size,

    /// Exit with code 1 if the times are over the budget: shader edits p50 150 ms and p95 400 ms, graph edits p50 50 ms.
    #[arg(long)]
    check: bool,

    #[command(flatten)]
    pub messages: Messages,
}

/// Milliseconds that an edit may take: median and 95th percentile.
const SHADER_BUDGET: (f64, f64) = (150.0, 400.0);
const GRAPH_BUDGET: f64 = 50.0;

pub(super) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let mut session = args.what.options(device)?;
    session.size = args.size.0;
    let scratch = Scratch::new()?;
    let options = LatencyOptions {
        session,
        scratch: scratch.path().to_owned(),
        edits: args.edits as usize,
        shader: args.shader.clone(),
    };
    let times = save_latency(&options).map_err(|error| failure(error, console))?;
    // The session above has reported all mistakes in the files.
    let first = {
        let starts = Scratch::new()?;
        first_picture(&args.what, args.size, device, starts.path())?
    };
    let [width, height] = times.size;
    let ShaderStages { notice, compile, plan, swap, frame } = &times.stages;
    let stages = [("notice", notice), ("compile", compile), ("plan", plan), ("swap", swap), ("frame", frame)];
    if console.format() == Format::Json {
        let part = |times: &Times| json!({ "p50": times.percentile(0.5), "p95": times.percentile(0.95), "max": times.percentile(1.0), "milliseconds": times.milliseconds });
        let of_stages: serde_json::Map<String, serde_json::Value> =
            stages.iter().map(|(name, times)| ((*name).to_owned(), part(times))).collect();
        console::json(&json!({
            "reason": "bench-reload",
            "device": times.device,
            "size": times.size,
            "shader_path": times.shader_path,
            "shader": part(&times.shader),
            "shader_stages": of_stages,
            "comment": part(&times.comment),
            "graph": part(&times.graph),
            "first": part(&first.fresh),
            "first_again": part(&first.again),
        }));
    } else {
        let row = |what: &str, times: &Times| {
            let [p50, p95, max] = [0.5, 0.95, 1.0].map(|part| times.percentile(part));
            console::data(&format!("{what:<14} {p50:8.1} {p95:8.1} {max:8.1}  ms\n"));
        };
        console::data(&format!(
            "save to picture, {} edits each of {} and the graph, {width}×{height}, {}\n",
            args.edits, times.shader_path, times.device
        ));
        console::data(&format!("{:<14} {:>8} {:>8} {:>8}\n", "", "p50", "p95", "max"));
        row("shader edit", &times.shader);
        for (name, times) in stages {
            row(&format!("  {name}"), times);
        }
        row("comment edit", &times.comment);
        row("graph edit", &times.graph);
        row("first picture", &first.fresh);
        row(".. again", &first.again);
    }
    let met = times.shader.percentile(0.5) <= SHADER_BUDGET.0
        && times.shader.percentile(0.95) <= SHADER_BUDGET.1
        && times.graph.percentile(0.5) <= GRAPH_BUDGET;
    if args.check && !met {
        return Err(Failure::new(Exit::Check, "edits take longer than the budget"));
    }
    Ok(())
}

fn failure(error: LatencyError, console: &Console) -> Failure {
    match error {
        LatencyError::Open(error) => open_failure(error, console),
        LatencyError::Frame(error) => frame_failure(error, console),
        LatencyError::Edit(failed) => console.stop_in(&failed.diagnostics, &failed.texts),
        LatencyError::Io(_) => Failure::usage(error.to_string()),
        LatencyError::NoShader { .. } => Failure::new(Exit::Project, error.to_string()),
        LatencyError::Unnoticed(_) => Failure::new(Exit::Check, error.to_string()),
    }
}
