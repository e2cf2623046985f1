//! Lifetimes: which resources matter only inside a frame, and from which to which action.

use crate::checked::Graph;
use crate::cull::Cull;
use crate::order::{Action, Order, Touch};
use crate::plan::PlanInput;
use crate::region::Parts;

/// Lifetime of a used resource, in actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Life {
    /// From frame to frame.
    Persistent,
    /// From the first to the last action that touches it (both included).
    Transient { first: u32, last: u32 },
}

/// Finds the lifetime of every used resource.
///
/// A resource is transient when no frame reads what the frame before it left there: it has no history, `init`, `keep` or clock, nobody
/// outside looks at it or supplies it, every pass that touches it runs in every frame, and the first access of every part of it is a clear or a
/// store by a pass that cannot load it. The latter rests on one assumption: a pass that binds a resource `writeonly` stores every
/// texel that is loaded later in the frame. A shader that leaves texels as they were says so by `partial = true` in its `bind`, which
/// makes the access a load too.
pub(crate) fn lifetimes(graph: &Graph, input: &PlanInput, cull: &Cull, order: &Order) -> Vec<Life> {
    let mut touches: Vec<Vec<Touch>> = vec![Vec::new(); cull.used.len()];
    for touch in &order.touches {
        touches[touch.resource as usize].push(*touch);
    }
    cull.used
        .iter()
        .zip(&touches)
        .map(|(&id, touches)| {
            let resource = graph.resource(id);
            let (Some(first), Some(last)) = (touches.first(), touches.last()) else { return Life::Persistent };
            let outside =
                id == input.present.resource || input.pinned.contains(&id) || resource.kind.supplied_by().is_some();
            let survives = outside
                || resource.kind.is_initialised()
                || resource.history > 0
                || resource.keep
                || resource.clock.is_some()
                || cull.switched_off[id.0 as usize]
                || touches.iter().any(|touch| runs_now_and_then(graph, order, touch))
                || read_before_written(touches);
            if survives { Life::Persistent } else { Life::Transient { first: first.action, last: last.action } }
        })
        .collect()
}

fn runs_now_and_then(graph: &Graph, order: &Order, touch: &Touch) -> bool {
    match order.actions[touch.action as usize] {
        Action::Dispatch(pass) => graph.pass(order.passes[pass as usize].pass).every.is_some(),
        Action::Clear(..) | Action::Copy(_) | Action::Present => false,
    }
}

/// Whether some part is loaded by the first action that touches it.
pub(crate) fn read_before_written(touches: &[Touch]) -> bool {
    let parts = Parts::new(touches.iter().map(|touch| touch.region));
    let mut written = vec![false; parts.count()];
    for of_action in touches.chunk_by(|a, b| a.action == b.action) {
        for load in of_action.iter().filter(|touch| !touch.writes()) {
            if parts.of(load.region).any(|part| !written[part]) {
                return true;
            }
        }
        for store in of_action.iter().filter(|touch| touch.writes()) {
            for part in parts.of(store.region) {
                written[part] = true;
            }
        }
    }
    false
}
