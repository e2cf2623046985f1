//! `raxel list`: what a graph and a world offer by name, without a GPU: for `--set`, `--target`, `--after` and `--camera`.

use std::fmt::Write as _;
use std::path::PathBuf;

use raxel_diagnostics::Diagnostic;
use raxel_graph::checked::{Graph, Param, Value};
use raxel_runtime::params::{components, type_name};
use raxel_runtime::world::SessionWorld;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::{FileKind, OfflineProject};
use serde_json::json;

/// Lists the params, targets, buffers and passes of a graph and the cameras of a world: the names that other verbs take.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel list graphs/primary.toml --world worlds/valley.toml")]
pub(crate) struct Args {
    /// A graph, a demo (*.demo.toml) or a world; the project's graph by default.
    #[arg(value_name = "GRAPH|DEMO|WORLD")]
    file: Option<PathBuf>,

    /// The world; the demo's, or the project's by default.
    #[arg(long, value_name = "WORLD")]
    world: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let default = |project: &raxel_runtime::project::Project| project.default_graph();
    let (offline, named) = OfflineProject::of(args.file.as_deref(), default, console)?;
    let stop = |diagnostic: Box<Diagnostic>| console.stop(&[*diagnostic]);
    let (path, own_world) = match args.file.as_deref().map_or(FileKind::Graph, FileKind::of_named) {
        FileKind::World if args.world.is_some() => return Err(Failure::usage("two worlds are named")),
        FileKind::World => (offline.project.default_graph().map_err(stop)?, Some(named)),
        FileKind::Demo => {
            let demo = OfflineProject::good(offline.loader.demo(&named), console)?;
            (demo.graph.value.clone(), Some(demo.world.value.clone()))
        }
        FileKind::Graph | FileKind::Project => (named, None),
    };
    let graph = OfflineProject::good(offline.loader.graph(&path), console)?;
    let world = match &args.world {
        Some(world) => Some(offline.project.path_of(world).map_err(stop)?),
        // A graph without a world is listed all the same.
        None => own_world.or_else(|| offline.project.default_world().ok()),
    };
    let world = world.map(|world| offline.world(&world, console)).transpose()?;
    if console.format() == Format::Json {
        console::json(&machine(&path, &graph, world.as_deref()));
    } else {
        console::data(&human(&graph, world.as_deref()));
    }
    Ok(())
}

fn resources(graph: &Graph) -> impl Iterator<Item = (&str, &'static str, String)> {
    let declared = graph.resources.iter().filter(|resource| !resource.made);
    declared.map(|resource| match &resource.kind {
        raxel_graph::checked::ResourceKind::Target(target) => {
            (resource.name.as_str(), "target", target.format.name().to_owned())
        }
        raxel_graph::checked::ResourceKind::Buffer(_) => {
            (resource.name.as_str(), "buffer", resource.kind.supplied_by().unwrap_or_default().to_owned())
        }
    })
}

fn human(graph: &Graph, world: Option<&SessionWorld>) -> String {
    let mut text = String::new();
    let params = graph.params.iter().map(row);
    section(&mut text, "params (--set NAME=VALUE)", params.collect());
    let listed = resources(graph).map(|(name, kind, about)| [name.to_owned(), kind.to_owned(), about]);
    section(&mut text, "targets and buffers (--target NAME)", listed.collect());
    let passes = graph.pass_names().map(|name| [name.to_owned()]);
    section(&mut text, "passes (--after NAME)", passes.collect());
    let cameras = world.into_iter().flat_map(SessionWorld::camera_names).map(|name| [name.to_owned()]);
    section(&mut text, "cameras (--camera NAME)", cameras.collect());
    text
}

/// A param's name, type, default, range or choices, group and label, and purpose.
fn row(param: &Param) -> [String; 6] {
    let default = literal(&param.default);
    let chosen = default.parse().ok().and_then(|index: usize| param.choices.get(index)).cloned();
    let unit = param.unit.as_ref().map_or_else(String::new, |unit| format!(" {unit}"));
    let range = match (param.choices.as_slice(), param.range) {
        ([], Some([low, high])) => format!("{low}…{high}{unit}"),
        ([], None) => unit.trim_start().to_owned(),
        (choices, _) => choices.join(" | "),
    };
    let label = match &param.group {
        Some(group) => format!("{group}: {}", param.label),
        None => param.label.clone(),
    };
    let about = param.tooltip.clone().unwrap_or_default();
    [param.name.clone(), type_name(&param.default).to_owned(), chosen.unwrap_or(default), range, label, about]
}

/// Rows under a title, their columns aligned; nothing when there are none.
fn section<const N: usize>(text: &mut String, title: &str, rows: Vec<[String; N]>) {
    if rows.is_empty() {
        return;
    }
    let widths: [usize; N] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let _ = writeln!(text, "{title}");
    for row in rows {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}  "));
        let _ = writeln!(text, "  {}", cells.collect::<String>().trim_end());
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "values of a graph are 32-bit floats, and their shortest digits are shown"
)]
fn literal(value: &Value) -> String {
    if let Value::Bool(on) = value {
        return on.to_string();
    }
    let parts: Vec<String> = components(value).iter().map(|part| (*part as f32).to_string()).collect();
    parts.join(",")
}

fn machine(path: &str, graph: &Graph, world: Option<&SessionWorld>) -> serde_json::Value {
    let params = graph.params.iter().map(|param| {
        json!({
            "name": param.name,
            "type": type_name(&param.default),
            "default": literal(&param.default),
            "range": param.range,
            "step": param.step,
            "label": param.label,
            "tooltip": param.tooltip,
            "unit": param.unit,
            "group": param.group,
            "choices": param.choices,
        })
    });
    let resources = resources(graph).map(|(name, kind, about)| json!({ "name": name, "kind": kind, "about": about }));
    let mut listed = json!({
        "graph": path,
        "name": graph.name,
        "present": graph.resource(graph.present).name,
        "params": params.collect::<Vec<_>>(),
        "resources": resources.collect::<Vec<_>>(),
        "passes": graph.pass_names().collect::<Vec<_>>(),
        "cameras": world.map(|world| world.camera_names().collect::<Vec<_>>()).unwrap_or_default(),
    });
    // Without a world there is nothing that could be named.
    if let Some(world) = world.and_then(|world| world.path.as_ref()) {
        listed["world"] = world.as_str().into();
    }
    listed
}
