//! `raxel graph`: the plan of a graph, as text, JSON, Graphviz or Mermaid. Nothing runs and no device is asked.

use std::path::PathBuf;

use raxel_graph::{Phase, print};
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::project::Project;
use raxel_terminal::args::{Size, size};
use raxel_terminal::console::{self, Console};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::{Conditions, OfflineProject, Paper};

/// Prints a graph's plan: order, culled passes, lifetimes, memory and barriers.
///
/// It runs nothing and needs no GPU. Sizes of memory are estimates.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel graph graphs/primary.toml --format dot | dot -Tsvg > plan.svg")]
pub(crate) struct Args {
    /// The graph; the project's by default.
    graph: Option<PathBuf>,

    /// The form of the plan.
    #[arg(long, value_enum, default_value_t = Form::Text)]
    pub format: Form,

    /// The output size to plan for, in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    size: Size,

    /// The debug target to plan for; the graph's `present` by default.
    #[arg(long, value_name = "TARGET")]
    target: Option<String>,

    /// Print the result of this phase of the compiler instead of the plan: sizes, unroll, cull, order, lifetimes, varies, alias or barriers.
    #[arg(long, value_name = "PHASE", value_parser = phase, conflicts_with = "format")]
    phase: Option<Phase>,

    /// The world to plan for: bounds, materials and conditions of passes depend on it. The project's by default.
    #[arg(long, value_name = "WORLD")]
    world: Option<PathBuf>,
}

fn phase(name: &str) -> std::result::Result<Phase, String> {
    let names = || Phase::ALL.iter().map(|phase| phase.name());
    Phase::from_name(name).ok_or_else(|| format!("one of {}", names().collect::<Vec<_>>().join(", ")))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Form {
    Text,
    Json,
    Dot,
    Mermaid,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let (offline, path) = OfflineProject::of(args.graph.as_deref(), Project::default_graph, console)?;
    let part = offline.loader.graph(&path);
    let texts = part.texts.clone();
    let graph = OfflineProject::good(part, console)?;
    let target = match &args.target {
        Some(target) => DebugTarget::parse(target).map_err(|error| Failure::usage(error.to_string()))?,
        None => DebugTarget::default(),
    };
    let present = target.resolve(&graph).map_err(|error| Failure::usage(error.to_string()))?;
    let world = args.world.as_deref().map(|named| offline.named_world(named, console)).transpose()?;
    let over = offline.planned_over(world, graph.is_sized_by_world() || graph.asks_the_world());
    if let Some(assumed) = over.assumed() {
        console.message(&assumed);
    }
    let paper = Paper { output: args.size.0, present, over: &over, conditions: Conditions::AtStart };
    if let Some(phase) = args.phase {
        let text = paper.dump(&graph, phase).map_err(|found| console.stop_in(&found, &texts))?;
        if text.is_empty() {
            console.message(&format!("the phase `{}` has nothing to print for this graph", phase.name()));
        }
        console::data(&text);
        return Ok(());
    }
    let plan = paper.plan(&graph).map_err(|found| console.stop_in(&found, &texts))?;
    console::data(&match args.format {
        Form::Text => print::text(&plan),
        Form::Json => print::json(&plan),
        Form::Dot => print::dot(&plan),
        Form::Mermaid => print::mermaid(&plan),
    });
    Ok(())
}
