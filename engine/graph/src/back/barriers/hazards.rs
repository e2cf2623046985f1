//! Finds which accesses must be ordered.
//!
//! A frame of n actions has n gaps; gap g is in front of action g, and the frame repeats without end. An access by action i and one by
//! action j, d frames later, are ordered by a barrier in one of the d·n + j − i gaps that end with gap j. The two meet in one copy of a
//! resource for some values of d (see [`frames_apart`]). Only the smallest d matters, because every larger one has more gaps to choose
//! from.

use super::Frame;
use super::frames_apart::frames_apart;
use crate::back::lifetimes::Life;
use crate::back::order::{Action, ResourceAccess, is_write};
use crate::ir::checked::PassId;
use crate::ir::index::index32;
use crate::ir::plan::{AccessMask, Hazard, HazardKind, ResourceDesc};
use crate::ir::subresources::SubresourcePartition;

/// Gaps in a row: `count` of them, ending at `end`. They may begin in an earlier frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gaps {
    pub end: u32,
    pub count: u32,
}

/// Two kinds of access that a chain of barriers within `gaps` must order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    pub from: AccessMask,
    pub to: AccessMask,
    pub gaps: Gaps,
}

/// A resource that takes over shared memory.
#[derive(Clone, Debug)]
pub(super) struct AliasTransition {
    /// Index among the used resources.
    pub resource: u32,
    /// It needs a transition; otherwise the hazards are among the pairs.
    pub image: bool,
    /// The last access of each kind by former occupants: how many gaps there are from it to the first use, that one included.
    pub previous_users: Vec<(AccessMask, u32)>,
    /// The first access of each kind by the resource, with its action.
    pub users: Vec<(AccessMask, u32)>,
    /// Where it may take over: behind the last former access, not after the first use; for a transition, in the same frame.
    pub gaps: Gaps,
}

/// Everything that must be ordered.
#[derive(Default)]
pub(super) struct Hazards {
    /// For each two kinds of access, the intervals that no other one is contained in.
    pub pairs: Vec<Pair>,
    /// Take-overs of shared memory.
    pub alias_transitions: Vec<AliasTransition>,
    /// Reasons to print: of each access, the nearest hazards.
    pub reasons: Vec<(Hazard, Gaps)>,
}

/// Finds everything that must be ordered.
pub(super) fn find(frame: &Frame) -> Hazards {
    let mut tight = IntervalSet::new(frame.order.actions.len());
    let mut hazards = Hazards::default();
    let mut accesses: Vec<Vec<ResourceAccess>> = vec![Vec::new(); frame.resources.len()];
    for access in &frame.order.accesses {
        accesses[access.resource as usize].push(*access);
    }
    for (resource, accesses) in accesses.iter().enumerate() {
        same_resource(frame, resource, accesses, &mut tight, &mut hazards.reasons);
    }
    for resource in 0..accesses.len() {
        shared_memory(frame, resource, &accesses, &mut tight, &mut hazards);
    }
    hazards.pairs = tight.into_pairs();
    hazards
}

fn same_resource(
    frame: &Frame,
    resource: usize,
    accesses: &[ResourceAccess],
    tight: &mut IntervalSet,
    reasons: &mut Vec<(Hazard, Gaps)>,
) {
    let n = index32(frame.order.actions.len());
    let plan = &frame.resources[resource];
    // A placed image is taken over again in each frame: see `shared_memory`.
    let within_frame = frame.alias.places[resource].is_some() && matches!(plan.desc, ResourceDesc::Image(_));
    let parts = SubresourcePartition::new(accesses.iter().map(|access| access.range));
    let mut earlier: Vec<(u32, &ResourceAccess)> = Vec::new();
    for to in accesses {
        earlier.clear();
        for from in accesses {
            if !(from.writes() || to.writes()) || !from.range.overlaps(&to.range) {
                continue;
            }
            let frames = frames_apart(frame.graph, plan.copies, from, to);
            if frames > 0 && within_frame {
                continue;
            }
            let count = frames * n + to.action - from.action;
            tight.add(from.mask, to.mask, Gaps { end: to.action, count });
            earlier.push((count, from));
        }
        explain(frame, &parts, to, &mut earlier, reasons);
    }
}

/// Of the hazards of one access, keeps those with nothing in between: a store hides earlier accesses of the same parts.
fn explain(
    frame: &Frame,
    parts: &SubresourcePartition,
    to: &ResourceAccess,
    earlier: &mut [(u32, &ResourceAccess)],
    reasons: &mut Vec<(Hazard, Gaps)>,
) {
    earlier.sort_by_key(|(count, from)| (*count, from.writes()));
    let mut open: Vec<usize> = parts.of(to.range).collect();
    let mut loaded: Vec<usize> = Vec::new();
    for (count, from) in earlier {
        if open.is_empty() {
            break;
        }
        let met: Vec<usize> = parts.of(from.range).filter(|part| open.contains(part)).collect();
        let kind = match (from.writes(), to.writes()) {
            (true, false) => HazardKind::ReadAfterWrite,
            (true, true) => HazardKind::WriteAfterWrite,
            _ => HazardKind::WriteAfterRead,
        };
        let hidden = kind == HazardKind::WriteAfterWrite && met.iter().all(|part| loaded.contains(part));
        if !met.is_empty() && !hidden {
            let hazard = Hazard {
                resource: frame.resources[to.resource as usize].resource,
                kind,
                from: pass_of(frame, from.action),
                to: pass_of(frame, to.action),
                wraps: *count > to.action,
            };
            reasons.push((hazard, Gaps { end: to.action, count: *count }));
        }
        if from.writes() {
            open.retain(|part| !met.contains(part));
        } else {
            loaded.extend(met);
        }
    }
}

fn shared_memory(
    frame: &Frame,
    resource: usize,
    accesses: &[Vec<ResourceAccess>],
    tight: &mut IntervalSet,
    hazards: &mut Hazards,
) {
    let Life::Transient { first, .. } = frame.lives[resource] else { return };
    if frame.alias.neighbours[resource].is_empty() {
        return;
    }
    let n = index32(frame.order.actions.len());
    let image = matches!(frame.resources[resource].desc, ResourceDesc::Image(_));
    let mut users: Vec<(AccessMask, u32)> = Vec::new();
    for access in &accesses[resource] {
        if !users.iter().any(|(mask, _)| *mask == access.mask) {
            users.push((access.mask, access.action));
        }
    }
    // An image follows itself too: its contents of the last frame were stored to the same memory.
    let itself = image.then_some(index32(resource));
    let mut previous_users: Vec<(AccessMask, u32)> = Vec::new();
    let mut nearest: Option<(u32, u32)> = None;
    for former in frame.alias.neighbours[resource].iter().copied().chain(itself) {
        for access in &accesses[former as usize] {
            let count = if access.action < first { first - access.action } else { n + first - access.action };
            match previous_users.iter_mut().find(|(mask, _)| *mask == access.mask) {
                Some((_, least)) => *least = count.min(*least),
                None => previous_users.push((access.mask, count)),
            }
            if nearest.is_none_or(|(least, _)| count < least) {
                nearest = Some((count, access.action));
            }
        }
    }
    let Some((least, action)) = nearest else { return };
    if !image {
        for &(from, count) in &previous_users {
            for &(to, action) in &users {
                if is_write(from) || is_write(to) {
                    tight.add(from, to, Gaps { end: action, count: count + action - first });
                }
            }
        }
    }
    let hazard = Hazard {
        resource: frame.resources[resource].resource,
        kind: HazardKind::Alias,
        from: pass_of(frame, action),
        to: pass_of(frame, first),
        wraps: least > first,
    };
    // The transition belongs to the frame that uses the image: the first frame has none before it.
    let gaps = Gaps { end: first, count: if image { least.min(first + 1) } else { least } };
    hazards.reasons.push((hazard, gaps));
    hazards.alias_transitions.push(AliasTransition { resource: index32(resource), image, previous_users, users, gaps });
}

fn pass_of(frame: &Frame, action: u32) -> Option<PassId> {
    match frame.order.actions[action as usize] {
        Action::Dispatch(pass) => Some(frame.order.passes[pass as usize].pass),
        Action::Clear(..) | Action::Copy(_) | Action::Present => None,
    }
}

/// For each two kinds of access and each end, the shortest interval.
struct IntervalSet {
    actions: usize,
    shortest: Vec<u32>,
}

const KINDS: usize = AccessMask::all().bits().count_ones() as usize;

impl IntervalSet {
    fn new(actions: usize) -> IntervalSet {
        IntervalSet { actions, shortest: vec![u32::MAX; KINDS * KINDS * actions] }
    }

    fn add(&mut self, from: AccessMask, to: AccessMask, gaps: Gaps) {
        let kinds = from.bits().trailing_zeros() as usize * KINDS + to.bits().trailing_zeros() as usize;
        let entry = &mut self.shortest[kinds * self.actions + gaps.end as usize];
        *entry = gaps.count.min(*entry);
    }

    /// An interval that contains another one is covered when that one is.
    #[expect(clippy::cast_possible_wrap, reason = "numbers of actions have 32 bits")]
    fn into_pairs(self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let n = self.actions as i64;
        for (kinds, shortest) in self.shortest.chunks_exact(self.actions.max(1)).enumerate() {
            let start = |end: usize| end as i64 - i64::from(shortest[end]) + 1;
            let ends = || (0..shortest.len()).filter(|&end| shortest[end] != u32::MAX);
            // The latest start of an interval that ends earlier. At first, it is that of the intervals that end in the frame before.
            let Some(mut latest) = ends().map(|end| start(end) - n).max() else { continue };
            for end in ends() {
                if start(end) > latest {
                    latest = start(end);
                    pairs.push(Pair {
                        from: AccessMask::from_bits_retain(1 << (kinds / KINDS)),
                        to: AccessMask::from_bits_retain(1 << (kinds % KINDS)),
                        gaps: Gaps { end: index32(end), count: shortest[end] },
                    });
                }
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each kind of pair keeps its own intervals, also in a frame of one action, which follows itself.
    #[test]
    fn intervals_of_a_frame_of_one_action_keep_their_kinds() {
        let mut set = IntervalSet::new(1);
        let kinds = [
            (AccessMask::TRANSFER_READ, AccessMask::TRANSFER_WRITE),
            (AccessMask::TRANSFER_WRITE, AccessMask::TRANSFER_READ),
        ];
        for (from, to) in kinds {
            set.add(from, to, Gaps { end: 0, count: 1 });
        }
        let mut pairs: Vec<_> =
            set.into_pairs().iter().map(|pair| (pair.from, pair.to, pair.gaps.end, pair.gaps.count)).collect();
        pairs.sort_by_key(|(from, ..)| from.bits());
        let mut right = kinds.map(|(from, to)| (from, to, 0, 1));
        right.sort_by_key(|(from, ..)| from.bits());
        assert_eq!(pairs, right);
    }
}
