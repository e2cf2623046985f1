//! Barriers while they are being fitted, and the question whether they order two accesses.

use crate::back::order::{is_write, stage_of};
use crate::ir::plan::{AccessMask, Dependency, Stages};

/// A barrier in the making: a gap, a global memory barrier, and the transitions beside it.
#[derive(Clone, Debug, Default)]
pub(super) struct Slot {
    pub gap: u32,
    pub memory: Dependency,
    /// Index of the take-over, and its scopes.
    pub transitions: Vec<(u32, Dependency)>,
}

impl Slot {
    fn dependencies(&self) -> impl Iterator<Item = (Option<u32>, &Dependency)> {
        std::iter::once((None, &self.memory)).chain(self.transitions.iter().map(|(at, scopes)| (Some(*at), scopes)))
    }
}

/// A required order, in terms of slots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    pub kind: NeedKind,
    /// First slot that may help, and how many (over several frames, more than there are slots).
    pub first: u32,
    pub slots: u32,
    /// The slots that do: from and to, counted from `first`.
    pub by: (u32, u32),
}

/// The kinds of required orders.
#[derive(Clone, Copy, Debug)]
pub(super) enum NeedKind {
    /// One kind of access before another.
    Pair(AccessMask, AccessMask),
    /// An access before a transition, which is in the last of the slots.
    Into(AccessMask, u32),
    /// A transition, which is in the first of the slots, before an access.
    OutOf(u32, AccessMask),
}

/// Source stages of a dependency, with the logically earlier stages.
fn before(dependency: &Dependency) -> Stages {
    let stages = dependency.src.stages;
    if stages.contains(Stages::COMPUTE_SHADER) { stages | Stages::DRAW_INDIRECT } else { stages }
}

/// Destination stages of a dependency, with the logically later stages.
fn behind(dependency: &Dependency) -> Stages {
    let stages = dependency.dst.stages;
    if stages.contains(Stages::DRAW_INDIRECT) { stages | Stages::COMPUTE_SHADER } else { stages }
}

/// The slots that give the order of `need`, counted from its first one; `None` when they do not.
pub(super) fn covered(slots: &[Slot], need: &Need) -> Option<(u32, u32)> {
    let (from, target, to, start) = match need.kind {
        NeedKind::Pair(from, to) => (Some(from), None, Some(to), None),
        NeedKind::Into(from, alias_transition) => (Some(from), Some(alias_transition), None, None),
        NeedKind::OutOf(alias_transition, to) => (None, None, Some(to), Some(alias_transition)),
    };
    let stored = from.is_none_or(is_write);
    // Stages that wait for the first access, with it available if it is a store.
    let mut reached = Stages::empty();
    let mut started = None;
    let mut idle = 0;
    for at in 0..need.slots {
        let slot = &slots[(need.first + at) as usize % slots.len()];
        let mut next = reached;
        for (transition, dependency) in slot.dependencies() {
            let of_target = transition.is_some() && transition == target;
            let of_start = transition.is_some() && transition == start && at == 0;
            let global = transition.is_none();
            if !(global || of_target || of_start) {
                continue;
            }
            let begins = match from {
                None => of_start,
                Some(from) if is_write(from) => dependency.src.access.contains(from),
                Some(from) => before(dependency).intersects(stage_of(from)),
            };
            if !(begins || before(dependency).intersects(reached)) {
                continue;
            }
            next |= behind(dependency);
            let done = match to {
                // Only the transition itself, in the last slot.
                None => of_target && at + 1 == need.slots,
                Some(to) if stored => dependency.dst.access.contains(to),
                Some(to) => behind(dependency).intersects(stage_of(to)),
            };
            if done {
                return Some((started.unwrap_or(at), at));
            }
        }
        if next == reached {
            // Nothing has changed for a whole frame, so nothing will.
            idle += 1;
            if idle > slots.len() && to.is_some() {
                return None;
            }
        } else {
            idle = 0;
            started = started.or(Some(at));
            reached = next;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::plan::Scope;

    fn slot(src: (Stages, AccessMask), dst: (Stages, AccessMask)) -> Slot {
        let [src, dst] = [src, dst].map(|(stages, access)| Scope { stages, access });
        Slot { memory: Dependency { src, dst }, ..Slot::default() }
    }

    /// The frames after the first go through the same slots, and a chain may take one slot of each: slots that wait between two that help
    /// do not end the search.
    #[test]
    fn slots_that_do_nothing_end_the_search_only_after_a_whole_frame_of_them() {
        let store = (Stages::COMPUTE_SHADER, AccessMask::SHADER_STORAGE_WRITE);
        let clear = (Stages::CLEAR, AccessMask::TRANSFER_WRITE);
        let fetch = (Stages::DRAW_INDIRECT, AccessMask::INDIRECT_COMMAND_READ);
        let kind = NeedKind::Pair(store.1, fetch.1);
        // Stores reach clears in the last slot, and clears reach fetches in the one before: in the next frame.
        let chain = [Slot::default(), Slot::default(), slot(clear, fetch), slot(store, clear)];
        let need = |slots| Need { kind, first: 0, slots, by: (0, 0) };
        assert_eq!(covered(&chain, &need(8)), Some((3, 6)));
        assert_eq!(covered(&chain, &need(6)), None, "it ends before");
        let apart = [Slot::default(), slot(clear, fetch), Slot::default(), Slot::default()];
        assert_eq!(covered(&apart, &need(u32::MAX)), None, "nothing waits for stores, however many frames there are");
    }
}
