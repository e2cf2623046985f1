//! Sizes: none in terms of itself, mips that its texels allow, dispatches over existing mips.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{BufferSize, Extent, ResourceId, ResourceKind, Target};
use raxel_graph::index32;
use raxel_graph::size::full_chain;

use crate::resolve::Resolved;

/// Checks every target and buffer.
pub(crate) fn check(graph: &Resolved, found: &mut Vec<Diagnostic>) {
    let mut followed = vec![false; graph.resources.len()];
    for id in (0..graph.resources.len()).map(|index| ResourceId(index32(index))) {
        if let Some(cycle) = follow(graph, id, &mut followed) {
            found.push(measured_by_itself(graph, &cycle));
        }
        mips(graph, id, found);
    }
}

fn target(graph: &Resolved, id: ResourceId) -> Option<&Target> {
    match &graph.resources[id.0 as usize].item.kind {
        ResourceKind::Target(target) => Some(target),
        ResourceKind::Buffer(_) => None,
    }
}

/// The resource that this one's size follows.
fn parent(graph: &Resolved, id: ResourceId) -> Option<ResourceId> {
    match &graph.resources[id.0 as usize].item.kind {
        ResourceKind::Target(target) => match target.extent {
            Extent::Of { target, .. } => Some(target),
            _ => None,
        },
        ResourceKind::Buffer(buffer) => match buffer.size {
            BufferSize::Of { of, .. } => Some(of),
            _ => None,
        },
    }
}

/// Follows sizes from `id` on to the first that was followed before, so that each is followed once. Gives the cycle that they end in, from
/// the one that is declared first on.
fn follow(graph: &Resolved, id: ResourceId, followed: &mut [bool]) -> Option<Vec<ResourceId>> {
    let mut chain = Vec::new();
    let mut next = Some(id);
    while let Some(id) = next {
        if std::mem::replace(&mut followed[id.0 as usize], true) {
            let mut cycle = chain.split_off(chain.iter().position(|known| *known == id)?);
            let first = cycle.iter().enumerate().min_by_key(|(_, id)| **id).map_or(0, |(at, _)| at);
            cycle.rotate_left(first);
            return Some(cycle);
        }
        chain.push(id);
        next = parent(graph, id);
    }
    None
}

fn measured_by_itself(graph: &Resolved, cycle: &[ResourceId]) -> Diagnostic {
    let item = |id: ResourceId| &graph.resources[id.0 as usize].item;
    let names: Vec<&str> = cycle.iter().chain(&cycle[..1]).map(|id| item(*id).name.as_str()).collect();
    let message = format!("the size of `{}` is measured by itself: {}", names[0], names.join(" → "));
    let diagnostic = Diagnostic::error(codes::graph::SIZE_CYCLE, message);
    cycle.iter().fold(diagnostic, |diagnostic, id| diagnostic.label(item(*id).place.clone(), ""))
}

fn mips(graph: &Resolved, id: ResourceId, found: &mut Vec<Diagnostic>) {
    let Some(target) = target(graph, id) else { return };
    let Some(most) = fixed(graph, id).map(full_chain) else { return };
    if target.mips > most {
        let declared = &graph.resources[id.0 as usize].item;
        found.push(
            Diagnostic::error(
                codes::graph::MIP_OR_LAYER,
                format!("target `{}` has {} mips, but its texels allow {most}", declared.name, target.mips),
            )
            .label(declared.place.clone(), "")
            .help("`mips = \"full\"` is as many as there can be"),
        );
    }
}

/// The extent, where the file alone decides it.
fn fixed(graph: &Resolved, id: ResourceId) -> Option<[u32; 3]> {
    match target(graph, id)?.extent {
        Extent::Fixed2([w, h]) => Some([w, h, 1]),
        Extent::Fixed3(extent) => Some(extent),
        Extent::Output { .. } | Extent::Of { .. } | Extent::World { .. } | Extent::Source => None,
    }
}

/// Number of mips, where the file alone decides it.
pub(crate) fn mip_count(graph: &Resolved, id: ResourceId) -> Option<u32> {
    match target(graph, id)?.mips {
        0 => fixed(graph, id).map(full_chain),
        count => Some(count),
    }
}

/// Whether a target has three dimensions, its own or those of the target that it is a part of.
pub(crate) fn is_volume(graph: &Resolved, id: ResourceId) -> bool {
    let mut next = Some(id);
    for _ in 0..=graph.resources.len() {
        let Some(id) = next else { return false };
        if matches!(
            target(graph, id).map(|target| target.extent),
            Some(Extent::Fixed3(_) | Extent::World { .. } | Extent::Source)
        ) {
            return true;
        }
        next = parent(graph, id);
    }
    false
}
