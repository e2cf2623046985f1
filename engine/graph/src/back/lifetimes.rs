//! Lifetimes: finds the resources that matter only inside a frame, with their first and their last action.

use crate::back::cull::Cull;
use crate::back::order::{Action, Order, ResourceAccess};
use crate::ir::checked::Graph;
use crate::ir::plan::{Observe, PlanInput};
use crate::ir::subresources::SubresourcePartition;

/// Lifetime of a used resource, in actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Life {
    /// From frame to frame.
    Persistent,
    /// From the first to the last action that accesses it (both included).
    Transient { first: u32, last: u32 },
}

/// Finds the lifetime of every used resource.
///
/// A resource is transient when no frame reads its contents of the frame before. It has no history, `init`, `keep` or clock. Nothing
/// outside the graph reads or supplies it. Every pass that accesses it runs in every frame. The first access of each part is a clear, or
/// a store by a pass that cannot load it. Culled passes count: they may be live in the next plan, which finds the contents in place.
///
/// Such a store rests on one assumption: a pass that binds a resource `writeonly` stores every texel that is loaded later in the frame. A
/// shader that leaves texels as they were declares `partial = true` in its `bind`, which makes the access a load too.
pub(crate) fn lifetimes(graph: &Graph, input: &PlanInput, cull: &Cull, order: &Order) -> Vec<Life> {
    let mut accesses: Vec<Vec<ResourceAccess>> = vec![Vec::new(); cull.used.len()];
    for access in &order.accesses {
        accesses[access.resource as usize].push(*access);
    }
    cull.used
        .iter()
        .zip(&accesses)
        .map(|(&id, accesses)| {
            let resource = graph.resource(id);
            let (Some(first), Some(last)) = (accesses.first(), accesses.last()) else { return Life::Persistent };
            let outside = input.observe == Observe::Everything
                || id == input.present.resource
                || input.pinned.contains(&id)
                || resource.kind.supplied_by().is_some();
            let survives = outside
                || resource.kind.is_initialised()
                || resource.history > 0
                || resource.keep
                || resource.clock.is_some()
                || cull.switched_off[id.0 as usize]
                || cull.carried[id.0 as usize]
                || accesses.iter().any(|access| runs_now_and_then(graph, order, access))
                || read_before_written(accesses);
            if survives { Life::Persistent } else { Life::Transient { first: first.action, last: last.action } }
        })
        .collect()
}

fn runs_now_and_then(graph: &Graph, order: &Order, access: &ResourceAccess) -> bool {
    match order.actions[access.action as usize] {
        Action::Dispatch(pass) => graph.pass(order.passes[pass as usize].pass).every.is_some(),
        Action::Clear(..) | Action::Copy(_) | Action::Present => false,
    }
}

/// Whether some part is loaded by the first action that accesses it.
pub(crate) fn read_before_written(accesses: &[ResourceAccess]) -> bool {
    let parts = SubresourcePartition::new(accesses.iter().map(|access| access.range));
    let mut written = vec![false; parts.count()];
    for of_action in accesses.chunk_by(|a, b| a.action == b.action) {
        for load in of_action.iter().filter(|access| !access.writes()) {
            if parts.of(load.range).any(|part| !written[part]) {
                return true;
            }
        }
        for store in of_action.iter().filter(|access| access.writes()) {
            for part in parts.of(store.range) {
                written[part] = true;
            }
        }
    }
    false
}
