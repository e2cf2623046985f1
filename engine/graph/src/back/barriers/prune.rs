//! Fits the scopes: gives every barrier the bits of its hazards, then removes each stage and access that no hazard needs. The stores
//! before the transition of an image stay, because the transition names them itself. Removing a bit never covers anything, so one try for
//! each is enough, and the remaining ones are needed.

use super::Frame;
use super::cover::{Need, NeedKind, Slot, covered};
use super::hazards::{Gaps, Hazards};
use crate::back::order::{is_write, stage_of};
use crate::ir::index::index32;
use crate::ir::plan::{AccessMask, Activation, Barrier, Dependency, Hazard, Scope, Stages};

/// Fitted barriers.
pub(super) struct Scopes {
    slots: Vec<Slot>,
    actions: u32,
}

/// Fits the scopes of barriers in `gaps`.
pub(super) fn prune(frame: &Frame, hazards: &Hazards, gaps: &[u32]) -> Scopes {
    let actions = index32(frame.order.actions.len());
    let slots = gaps.iter().map(|&gap| Slot { gap, ..Slot::default() }).collect();
    let mut scopes = Scopes { slots, actions };
    let mut needs = scopes.ask(hazards);
    scopes.take_away(&mut needs);
    scopes
}

impl Scopes {
    /// The slots in an interval: the first, and how many.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        reason = "gaps and slots are numbered modulo the actions of a frame, which have 32 bits"
    )]
    fn within(&self, gaps: Gaps) -> (u32, u32) {
        let before = |gap: i64| {
            let round = gap.div_euclid(self.actions.into());
            let rest = gap.rem_euclid(self.actions.into()) as u32;
            round * self.slots.len() as i64 + self.slots.partition_point(|slot| slot.gap < rest) as i64
        };
        let end = i64::from(gaps.end) + 1;
        let (first, last) = (before(end - i64::from(gaps.count)), before(end));
        (first.rem_euclid(self.slots.len().max(1) as i64) as u32, (last - first) as u32)
    }

    /// The last slot in an interval.
    fn last_within(&self, gaps: Gaps) -> usize {
        let (first, count) = self.within(gaps);
        debug_assert!(count > 0, "every interval has a barrier");
        (first + count - 1) as usize % self.slots.len()
    }

    /// Gives each hazard its bits in the last slot that can serve it, and lists the needs that must stay covered.
    fn ask(&mut self, hazards: &Hazards) -> Vec<Need> {
        let mut needs = Vec::new();
        for pair in &hazards.pairs {
            let (first, slots) = self.within(pair.gaps);
            let slot = self.last_within(pair.gaps);
            let memory = &mut self.slots[slot].memory;
            add(&mut memory.src, pair.from, is_write(pair.from));
            add(&mut memory.dst, pair.to, is_write(pair.from));
            needs.push(Need { kind: NeedKind::Pair(pair.from, pair.to), first, slots, by: (slots - 1, slots - 1) });
        }
        for (alias_transition, of) in hazards.alias_transitions.iter().enumerate().filter(|(_, of)| of.image) {
            let at = self.last_within(of.gaps);
            let gap = self.slots[at].gap;
            let alias_transition = index32(alias_transition);
            let mut scopes = Dependency::default();
            for &(from, count) in &of.previous_users {
                add(&mut scopes.src, from, is_write(from));
                let (first, slots) = self.within(Gaps { end: gap, count: count - (of.gaps.end - gap) });
                needs.push(Need {
                    kind: NeedKind::Into(from, alias_transition),
                    first,
                    slots,
                    by: (slots - 1, slots - 1),
                });
            }
            for &(to, action) in &of.users {
                add(&mut scopes.dst, to, true);
                let (first, slots) = self.within(Gaps { end: action, count: action - gap + 1 });
                needs.push(Need { kind: NeedKind::OutOf(alias_transition, to), first, slots, by: (0, 0) });
            }
            self.slots[at].transitions.push((alias_transition, scopes));
        }
        needs
    }

    fn take_away(&mut self, needs: &mut [Need]) {
        let count = self.slots.len();
        // By slot, the needs that rely on it: only they can miss a bit of it.
        let mut relying: Vec<Vec<u32>> = vec![Vec::new(); count];
        let rely = |relying: &mut Vec<Vec<u32>>, id: usize, need: &Need| {
            for at in need.by.0..=need.by.1.min(need.by.0 + index32(count) - 1) {
                relying[(need.first + at) as usize % count].push(index32(id));
            }
        };
        for (id, need) in needs.iter().enumerate() {
            rely(&mut relying, id, need);
        }
        for slot in (0..count).rev() {
            for bit in bits(&self.slots[slot]) {
                let whole = self.slots[slot].clone();
                if !remove(&mut self.slots[slot], bit) {
                    continue;
                }
                let mut moved = Vec::new();
                let mut missed = false;
                for &id in &relying[slot] {
                    let need = &needs[id as usize];
                    let at = (slot + count - need.first as usize % count) % count;
                    if (at + count - need.by.0 as usize % count) % count > (need.by.1 - need.by.0) as usize {
                        continue;
                    }
                    match covered(&self.slots, need) {
                        Some(by) if by == need.by => {}
                        Some(by) => moved.push((id, by)),
                        None => {
                            missed = true;
                            break;
                        }
                    }
                }
                if missed {
                    self.slots[slot] = whole;
                    continue;
                }
                for (id, by) in moved {
                    let need = &mut needs[id as usize];
                    need.by = by;
                    let need = *need;
                    rely(&mut relying, id as usize, &need);
                }
                relying[slot].sort_unstable();
                relying[slot].dedup();
            }
        }
    }

    /// The barrier of each gap, with its reasons.
    pub(crate) fn into_barriers(self, frame: &Frame, hazards: &Hazards) -> Vec<Option<Barrier>> {
        let mut barriers: Vec<Option<Barrier>> = vec![None; self.actions as usize];
        for slot in &self.slots {
            let memory = (slot.memory != Dependency::default()).then_some(slot.memory);
            let activate = slot
                .transitions
                .iter()
                .map(|(alias_transition, scopes)| Activation {
                    resource: hazards.alias_transitions[*alias_transition as usize].resource,
                    dependency: *scopes,
                })
                .collect();
            barriers[slot.gap as usize] = Some(Barrier { memory, activate, hazards: Vec::new() });
        }
        for alias_transition in hazards.alias_transitions.iter().filter(|alias_transition| !alias_transition.image) {
            let mut dependency = Dependency::default();
            for (from, _) in &alias_transition.previous_users {
                add(&mut dependency.src, *from, is_write(*from));
            }
            for (to, action) in &alias_transition.users {
                if *action == alias_transition.gaps.end {
                    add(&mut dependency.dst, *to, true);
                }
            }
            let gap = self.slots[self.last_within(alias_transition.gaps)].gap;
            if let Some(barrier) = &mut barriers[gap as usize] {
                barrier.activate.push(Activation { resource: alias_transition.resource, dependency });
            }
        }
        for (hazard, gaps) in &hazards.reasons {
            let gap = self.slots[self.last_within(*gaps)].gap;
            if let Some(barrier) = &mut barriers[gap as usize]
                && !barrier.hazards.contains(hazard)
            {
                barrier.hazards.push(*hazard);
            }
        }
        let order = |hazard: &Hazard| (hazard.wraps, hazard.resource, hazard.kind as u8, hazard.from, hazard.to);
        for barrier in barriers.iter_mut().flatten() {
            barrier.hazards.sort_by_key(order);
            barrier.activate.sort_by_key(|activation| activation.resource);
        }
        debug_assert_eq!(frame.order.actions.len(), barriers.len());
        barriers
    }
}

fn add(scope: &mut Scope, access: AccessMask, memory: bool) {
    scope.stages |= stage_of(access);
    if memory {
        scope.access |= access;
    }
}

/// One bit of one scope: of the memory barrier (`None`) or of a transition; of its source or destination.
#[derive(Clone, Copy)]
struct Bit {
    transition: Option<usize>,
    source: bool,
    what: What,
}

#[derive(Clone, Copy)]
enum What {
    Access(AccessMask),
    Stage(Stages),
}

/// The bits of a slot in the order in which they are tried: accesses before the stages that make them.
fn bits(slot: &Slot) -> Vec<Bit> {
    let mut bits = Vec::new();
    for transition in std::iter::once(None).chain((0..slot.transitions.len()).map(Some)) {
        for source in [false, true] {
            let accesses = AccessMask::all().iter().map(What::Access);
            bits.extend(accesses.map(|what| Bit { transition, source, what }));
        }
        for source in [false, true] {
            let stages = Stages::all().iter().map(What::Stage);
            bits.extend(stages.map(|what| Bit { transition, source, what }));
        }
    }
    bits
}

/// Takes a bit away; false when there is nothing to take, or an access still needs the stage.
fn remove(slot: &mut Slot, bit: Bit) -> bool {
    let dependency = match bit.transition {
        None => &mut slot.memory,
        Some(at) => &mut slot.transitions[at].1,
    };
    let scope = if bit.source { &mut dependency.src } else { &mut dependency.dst };
    match bit.what {
        What::Access(access) => {
            // The transition of an image names the stores of the former occupants itself: see the module `barriers`.
            if bit.source && bit.transition.is_some() && is_write(access) {
                return false;
            }
            let there = scope.access.contains(access);
            scope.access -= access;
            there
        }
        What::Stage(stage) => {
            let makes = |access: AccessMask| stage_of(access) == stage;
            if !scope.stages.contains(stage) || scope.access.iter().any(makes) {
                return false;
            }
            scope.stages -= stage;
            true
        }
    }
}
