//! A graph's needs that the file of its world lacks, as far as they show without a device.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{Graph, Resource};

use super::instances;
use super::name::SourceName;
use crate::world::SessionWorld;

/// The models that a graph names and the file of the world has not, and the params that would move its instances.
pub fn check(graph: &Graph, world: &SessionWorld) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for resource in &graph.resources {
        match resource.kind.supplied_by().and_then(SourceName::parse) {
            Some(SourceName::Model(model, _)) if world.model_names().all(|known| known != model) => {
                found.push(no_model(&model, resource, world));
            }
            Some(SourceName::Instances) => found.extend(instances::check(graph, world, resource)),
            _ => {}
        }
    }
    found
}

/// The warning that a graph traces the voxels of a world and leaves out its instances.
pub(crate) fn unseen_instances(graph: &Graph, world: &SessionWorld) -> Option<Diagnostic> {
    let bound = graph.passes.iter().flat_map(|pass| &pass.accesses).map(|access| graph.resource(access.resource));
    let mut sources = bound.filter_map(|resource| SourceName::parse(resource.kind.supplied_by()?));
    if !world.has_instances() || sources.any(|source| source == SourceName::Instances) {
        return None;
    }
    let of_world = |resource: &&Resource| resource.kind.supplied_by().and_then(SourceName::world_layout).is_some();
    let traced = graph.resources.iter().find(of_world)?;
    let whose = world.path.as_deref().unwrap_or("the world");
    let message = format!("the graph `{}` does not show the instances of `{whose}`", graph.name);
    Some(
        Diagnostic::warning(codes::world::INSTANCES_UNSEEN, message)
            .label(traced.place.clone(), "the voxels of the world alone")
            .help("bind a buffer with `source = \"world.instances\"` where passes trace; `primary` and `beauty` do"),
    )
}

pub(super) fn no_model(model: &str, resource: &Resource, world: &SessionWorld) -> Diagnostic {
    let names = || world.model_names();
    let whose = world.path.as_deref().unwrap_or("the empty world");
    let diagnostic =
        Diagnostic::error(codes::session::UNKNOWN_SOURCE, format!("there is no model `{model}` in `{whose}`"))
            .label(resource.place.clone(), "for this");
    match closest(model, names()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None if names().next().is_none() => diagnostic.help(format!("declare it there: [models.{model}]")),
        None => diagnostic.help(format!("its models: {}", list(names()))),
    }
}
