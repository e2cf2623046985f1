//! Data flow between passes: some pass must write each resource that is presented or read.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{
    BufferSize, Dispatch, Extent, Fact, Graph, Pass, ResourceId, ResourceKind, Rounds, ValueOrigin,
};
use raxel_graph::index32;

use super::{given, loops};
use crate::resolve::Resolved;

/// Checks a graph whose passes are all known. Warnings are given only where nothing is wrong: until then, a mistake may be the reason that
/// something seems unused.
pub(crate) fn check(graph: &Graph, resolved: &Resolved, found: &mut Vec<Diagnostic>) {
    let wrong = found.iter().any(Diagnostic::is_error);
    let mut flow = Vec::new();
    for index in 0..graph.resources.len() {
        resource(graph, resolved, ResourceId(index32(index)), &mut flow);
    }
    unused_params(graph, &mut flow);
    loops::unused(resolved, &mut flow);
    given::unused(graph, resolved, &mut flow);
    found.extend(flow.into_iter().filter(|diagnostic| diagnostic.is_error() || !wrong));
}

fn resource(graph: &Graph, resolved: &Resolved, id: ResourceId, found: &mut Vec<Diagnostic>) {
    // The writers of a resource that is itself wrong are not known.
    if !resolved.resources[id.0 as usize].sound {
        return;
    }
    let resource = graph.resource(id);
    let names = exchanged(graph, id);
    let written = graph.passes.iter().flat_map(|pass| &pass.accesses);
    let written = written.filter(|access| names.contains(&access.resource)).any(|access| access.access.writes());
    if let (Some(warning), false) = (resource.warnings.first(), written) {
        let message = format!("no pass writes `{}`, so its warnings count nothing", resource.name);
        found.push(
            Diagnostic::warning(codes::graph::NEVER_WRITTEN, message)
                .label(warning.place.clone(), "never counted")
                .label(resource.place.clone(), "never written")
                .help("bind it in the pass that counts, or take its `warnings` out"),
        );
    }
    if written || has_content(&resource.kind) {
        return;
    }
    let name = &resource.name;
    if let Some(present) = resolved.present.as_ref().filter(|present| present.value == id) {
        found.push(
            Diagnostic::error(codes::graph::PRESENT_UNWRITTEN, format!("`{name}` is presented, but no pass writes it"))
                .label(present.span.clone(), "presented here")
                .label(resource.place.clone(), "declared here")
                .help("present a target that a pass writes, or give it `init` or `clear`"),
        );
    } else if let Some(reader) = reader(graph, id) {
        found.push(
            Diagnostic::warning(
                codes::graph::NEVER_WRITTEN,
                format!("pass `{}` reads `{name}`, but no pass writes it: it is always zero", reader.name),
            )
            .label(resource.place.clone(), "never written")
            .label(reader.place.clone(), "read by this pass")
            .help("if zero is meant, say so with `init = 0`"),
        );
    } else if !mentioned(graph, id) {
        let what = if matches!(resource.kind, ResourceKind::Target(_)) { "target" } else { "buffer" };
        found.push(
            Diagnostic::warning(codes::graph::UNUSED, format!("{what} `{name}` is not used"))
                .label(resource.place.clone(), "no pass binds it"),
        );
    }
}

/// The first pass that touches a resource; the one behind it for a pass that raxel made.
fn reader(graph: &Graph, id: ResourceId) -> Option<&Pass> {
    let at = graph.passes.iter().position(|pass| pass.accesses.iter().any(|access| access.resource == id))?;
    graph.passes[at..].iter().find(|pass| !pass.made)
}

/// The resource, and those that change places with it in a loop: a pass writes it under one name, and another reads it under another.
fn exchanged(graph: &Graph, id: ResourceId) -> Vec<ResourceId> {
    let mut names = vec![id];
    let mut at = 0;
    while let Some(name) = names.get(at).copied() {
        for [a, b] in graph.loops.iter().flat_map(|repeated| &repeated.swap) {
            for (from, to) in [(a, b), (b, a)] {
                if *from == name && !names.contains(to) {
                    names.push(*to);
                }
            }
        }
        at += 1;
    }
    names
}

/// Whether something is in it though no pass writes it.
fn has_content(kind: &ResourceKind) -> bool {
    match kind {
        ResourceKind::Target(target) => target.clear.is_some() || target.init.is_some() || target.source.is_some(),
        ResourceKind::Buffer(buffer) => {
            let given = matches!(buffer.size, BufferSize::Source(_) | BufferSize::Values(_));
            buffer.clear.is_some() || buffer.init.is_some() || given
        }
    }
}

/// Whether a size, a dispatch or a value depends on its extent.
fn mentioned(graph: &Graph, id: ResourceId) -> bool {
    let by_size = graph.resources.iter().any(|other| match &other.kind {
        ResourceKind::Target(target) => matches!(target.extent, Extent::Of { target, .. } if target == id),
        ResourceKind::Buffer(buffer) => matches!(buffer.size, BufferSize::Of { of, .. } if of == id),
    });
    let by_pass = graph.passes.iter().any(|pass| {
        let dispatched = match pass.dispatch {
            Dispatch::ThreadsOf { target, .. } | Dispatch::GroupsOf { target, .. } => target == id,
            Dispatch::ElementsOf { buffer } => buffer == id,
            Dispatch::Threads(_) | Dispatch::ThreadsOfWorld | Dispatch::Groups(_) | Dispatch::Indirect { .. } => false,
        };
        let fills = pass.push.iter().chain(pass.uniforms.iter().flat_map(|block| &block.fills));
        let sources = fills.map(|fill| &fill.from).chain(pass.specialization.iter().map(|(_, source)| source));
        dispatched
            || sources.into_iter().any(|from| *from == ValueOrigin::ExtentOf(id) || *from == ValueOrigin::CountOf(id))
    });
    let by_loop = graph.loops.iter().any(|repeated| repeated.rounds == Rounds::Mips(id));
    by_size || by_pass || by_loop
}

fn unused_params(graph: &Graph, found: &mut Vec<Diagnostic>) {
    // The file of the world decides which instances move by params.
    if graph.source_names().contains("world.instances") {
        return;
    }
    for (index, param) in graph.params.iter().enumerate() {
        let id = raxel_graph::checked::ParamId(index32(index));
        let counts = graph.loops.iter().any(|repeated| repeated.rounds == Rounds::Param(id));
        let used = counts
            || graph.passes.iter().any(|pass| {
                let mut fills = pass.push.iter().chain(pass.uniforms.iter().flat_map(|block| &block.fills));
                let condition = pass.when.iter().any(|when| when.fact == Fact::Param(id));
                condition || fills.any(|fill| fill.from == ValueOrigin::Param(id))
            });
        if !used {
            found.push(
                Diagnostic::warning(codes::graph::UNUSED, format!("param `{}` is not used", param.name))
                    .label(param.place.clone(), "no pass takes it"),
            );
        }
    }
}
