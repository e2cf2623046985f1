//! What a graph wants of a world's file that is not there, as far as no device is needed to say it.

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
