//! Cull: leave out passes whose `when` does not hold and passes that nothing presented or pinned depends on, now or in any later
//! frame.
//!
//! A pass that leaves something for later frames is never culled for being unused. So the contents of an accumulator, a history or a kept
//! target do not depend on earlier shown or pinned resources, and culling cannot be seen.

use std::ops::Range;

use crate::back::limits;
use crate::ir::checked::{BoundAccess, Every, Graph, Pass, PassId, ResourceId};
use crate::ir::index::index32;
use crate::ir::plan::{CullReason, Culled, Observe, PlanInput, Present};
use crate::ir::size::Size;
use crate::ir::subresources::{SubresourcePartition, SubresourceRange};

/// The live part of a graph.
#[derive(Clone, Debug)]
pub(crate) struct Cull {
    /// Passes that run, in program order.
    pub live: Vec<PassId>,
    /// The others.
    pub culled: Vec<Culled>,
    /// Resources that live passes, the present point or pins use, in order of the file.
    pub used: Vec<ResourceId>,
    /// By resource: a pass that would write it is off, so that (a part of) it stays at `init`.
    pub switched_off: Vec<bool>,
    /// By resource: later frames read in (a part of) it contents of this one, whether or not a live pass looks.
    pub carried: Vec<bool>,
}

/// The parts of every resource that matter at one point of the frame.
type Needs = Vec<Vec<bool>>;

/// Decides which passes run.
pub(crate) fn cull(graph: &Graph, sizes: &[Size], input: &PlanInput) -> Cull {
    let on: Vec<bool> = graph.passes.iter().map(|pass| pass.runs_where(input.facts)).collect();
    let parts = parts(graph, sizes, input.present);
    let carried = carried(graph, &on, &parts, |access| parts_of(&parts, sizes, access).collect());
    let presented = parts[input.present.resource.0 as usize].of(presented(input.present, sizes)).collect();
    let flow = Flow { graph, sizes, parts: &parts, on: &on, present: input.present, presented };
    let live = flow.live(needed_outside(&carried, &flow, input));
    Cull {
        live: (0..live.len()).filter(|&index| live[index]).map(|index| PassId(index32(index))).collect(),
        culled: culled(&live, &on),
        used: used(graph, &live, sizes, input),
        switched_off: switched_off(graph, &on),
        carried: carried.iter().map(|parts| parts.contains(&true)).collect(),
    }
}

/// Subresources whose contents must exist when a frame ends, as far as this is known before the passes: later frames or the outside
/// read them.
fn needed_outside(carried: &Needs, flow: &Flow<'_>, input: &PlanInput) -> Needs {
    let mut at_end = carried.clone();
    for pinned in input.pinned {
        at_end[pinned.0 as usize].fill(true);
    }
    if input.observe == Observe::Everything {
        at_end.iter_mut().for_each(|parts| parts.fill(true));
    }
    let taken_early = input.present.age == 0 && input.present.after.is_some();
    if !taken_early {
        flow.mark_presented(&mut at_end);
    }
    at_end
}

/// The needs of passes for each other.
struct Flow<'a> {
    graph: &'a Graph,
    sizes: &'a [Size],
    parts: &'a [SubresourcePartition],
    /// By pass: its `when` holds.
    on: &'a [bool],
    present: Present,
    /// The parts that the present step reads.
    presented: Vec<usize>,
}

impl Flow<'_> {
    /// By pass: something needs its output, in this frame or in a later one. Which parts later frames read is not known before the passes
    /// that read them are, so `at_end` grows until it stays the same.
    fn live(&self, mut at_end: Needs) -> Vec<bool> {
        let mut live = vec![false; self.graph.passes.len()];
        loop {
            let before = at_end.clone();
            let at_start = self.backwards(&mut at_end, &mut live);
            // Contents that a frame needs when it starts must be there when the last one ends, unless the frame makes them itself.
            let presented = Some((self.present, self.presented.as_slice()));
            let anew = made_anew(self.graph, &live, presented, self.parts, |access| self.parts_of(access));
            for (index, anew) in anew.iter().enumerate() {
                mark(&mut at_end[index], (0..anew.len()).filter(|&part| at_start[index][part] && !anew[part]));
            }
            if at_end == before {
                return live;
            }
        }
    }

    /// Walks the frame backwards, and returns the contents that it needs at its start. A pass is live when a later reader needs its output.
    /// A store never makes an earlier one useless, for a pass need not write every texel.
    fn backwards(&self, at_end: &mut Needs, live: &mut [bool]) -> Needs {
        let mut needs = at_end.clone();
        let mut end = self.graph.passes.len();
        while end > 0 {
            let group = group_before(self.graph, end);
            if self.present.after.is_some_and(|after| group.contains(&(after.0 as usize))) {
                self.mark_presented(&mut needs);
            }
            let repeated = catches_up(self.graph, &self.graph.passes[group.start]);
            loop {
                let before_tick = repeated.then(|| needs.clone());
                for index in group.clone().rev().filter(|&index| self.on[index]) {
                    live[index] |= self.is_needed(&self.graph.passes[index], &needs);
                    if live[index] {
                        self.mark_read(&self.graph.passes[index], &mut needs, at_end);
                    }
                }
                // Contents that a tick needs when it starts may be made by the tick before it.
                if before_tick.is_none_or(|before| needs == before) {
                    break;
                }
            }
            end = group.start;
        }
        needs
    }

    fn is_needed(&self, pass: &Pass, needs: &Needs) -> bool {
        let mut written = pass.accesses.iter().filter(|access| access.access.writes());
        written.any(|access| self.parts_of(access).iter().any(|&part| needs[access.resource.0 as usize][part]))
    }

    fn mark_read(&self, pass: &Pass, needs: &mut Needs, at_end: &mut Needs) {
        for access in pass.accesses.iter().filter(|access| access.access.reads()) {
            let point = if access.age == 0 { &mut *needs } else { &mut *at_end };
            mark(&mut point[access.resource.0 as usize], self.parts_of(access));
        }
    }

    fn mark_presented(&self, needs: &mut Needs) {
        mark(&mut needs[self.present.resource.0 as usize], self.presented.iter().copied());
    }

    fn parts_of(&self, access: &BoundAccess) -> Vec<usize> {
        parts_of(self.parts, self.sizes, access).collect()
    }
}

/// The passes that do not run, and why.
fn culled(live: &[bool], on: &[bool]) -> Vec<Culled> {
    let reason = |index: usize| if on[index] { CullReason::Unused } else { CullReason::Condition };
    let rest = (0..live.len()).filter(|&index| !live[index]);
    rest.map(|index| Culled { pass: PassId(index32(index)), reason: reason(index) }).collect()
}

/// The resources that something uses.
fn used(graph: &Graph, live: &[bool], sizes: &[Size], input: &PlanInput) -> Vec<ResourceId> {
    let mut used = vec![false; graph.resources.len()];
    used[input.present.resource.0 as usize] = true;
    for pinned in input.pinned {
        used[pinned.0 as usize] = true;
    }
    for (index, resource) in graph.resources.iter().enumerate() {
        // A clear may leave something for later frames, too.
        let carried = resource.kind.is_cleared() && (resource.history > 0 || resource.clock.is_some());
        // A resource that no pass touches must not refuse a graph that runs without it. Its source need not exist, and its target need not fit.
        used[index] |= (carried || input.observe == Observe::Everything)
            && resource.kind.supplied_by().is_none()
            && limits::fits(graph, resource, sizes[index], input);
    }
    let passes = graph.passes.iter().zip(live).filter(|(_, live)| **live);
    for access in passes.flat_map(|(pass, _)| &pass.accesses) {
        used[access.resource.0 as usize] = true;
    }
    (0..used.len()).filter(|&index| used[index]).map(|index| ResourceId(index32(index))).collect()
}

/// By resource: a pass that would write it is off.
fn switched_off(graph: &Graph, on: &[bool]) -> Vec<bool> {
    let mut switched_off = vec![false; graph.resources.len()];
    for (pass, _) in graph.passes.iter().zip(on).filter(|(_, on)| !**on) {
        for access in pass.accesses.iter().filter(|access| access.access.writes()) {
            switched_off[access.resource.0 as usize] = true;
        }
    }
    switched_off
}

/// The passes that end there and run together: those of a clock, or one alone.
fn group_before(graph: &Graph, end: usize) -> Range<usize> {
    let last = graph.passes[end - 1].every;
    if !matches!(last, Some(Every::Clock(_))) {
        return end - 1..end;
    }
    end - graph.passes[..end].iter().rev().take_while(|pass| pass.every == last).count()..end
}

/// Whether a pass may run several times in a frame.
fn catches_up(graph: &Graph, pass: &Pass) -> bool {
    matches!(pass.every, Some(Every::Clock(clock)) if graph.clock(clock).most > 1)
}

/// The parts in which later frames read contents of this one, as the graph is written: those that are kept, those that the first pass to
/// touch them loads, and those that a pass stores to only now and then. Neither the present point nor the pins have a say.
fn carried(
    graph: &Graph,
    on: &[bool],
    parts: &[SubresourcePartition],
    range: impl Fn(&BoundAccess) -> Vec<usize> + Copy,
) -> Needs {
    let anew = made_anew(graph, on, None, parts, range);
    let mut carried: Needs = parts.iter().map(|parts| vec![false; parts.count()]).collect();
    for (pass, _) in graph.passes.iter().zip(on).filter(|(_, on)| **on) {
        for access in pass.accesses.iter().filter(|access| access.age == 0) {
            let index = access.resource.0 as usize;
            let resource = graph.resource(access.resource);
            let kept = resource.keep
                || resource.history > 0
                || resource.clock.is_some()
                || resource.kind.is_initialised()
                || resource.kind.supplied_by().is_some();
            let now_and_then = pass.every.is_some() && access.access.writes();
            for part in range(access) {
                carried[index][part] |= kept || now_and_then || !anew[index][part];
            }
        }
    }
    carried
}

/// The parts that hold nothing of an earlier frame once they are first looked at: those of resources that are cleared, and those that a
/// `writeonly` binding touches first. This is the assumption of [`lifetimes`](mod@crate::back::lifetimes). A later `writeonly` store
/// replaces nothing: it may add to the stores of earlier passes of the frame.
fn made_anew(
    graph: &Graph,
    live: &[bool],
    presented: Option<(Present, &[usize])>,
    parts: &[SubresourcePartition],
    range: impl Fn(&BoundAccess) -> Vec<usize>,
) -> Needs {
    let mut anew: Needs = parts.iter().map(|parts| vec![false; parts.count()]).collect();
    let mut touched = anew.clone();
    for (index, resource) in graph.resources.iter().enumerate() {
        // A frame without a tick clears nothing that turns with a clock.
        if resource.kind.is_cleared() && resource.clock.is_none() {
            anew[index].fill(true);
            touched[index].fill(true);
        }
    }
    for (index, pass) in graph.passes.iter().enumerate() {
        if live[index] {
            let now = || pass.accesses.iter().filter(|access| access.age == 0);
            for access in now().filter(|access| access.access.reads()) {
                mark(&mut touched[access.resource.0 as usize], range(access));
            }
            for access in now().filter(|access| access.access.writes()) {
                let resource = access.resource.0 as usize;
                for part in range(access) {
                    anew[resource][part] |= !touched[resource][part] && pass.every.is_none();
                    touched[resource][part] = true;
                }
            }
        }
        if let Some((present, presented)) = presented
            && present.age == 0
            && present.after == Some(PassId(index32(index)))
        {
            mark(&mut touched[present.resource.0 as usize], presented.iter().copied());
        }
    }
    anew
}

/// The range that the present step reads.
pub(crate) fn presented(present: Present, sizes: &[Size]) -> SubresourceRange {
    match sizes[present.resource.0 as usize] {
        Size::Image { volume, .. } => SubresourceRange::one(present.mip, if volume { 0 } else { present.layer }),
        size @ Size::Buffer { .. } => SubresourceRange::whole(&size),
    }
}

/// The parts of every resource that accesses and the present point treat differently.
fn parts(graph: &Graph, sizes: &[Size], present: Present) -> Vec<SubresourcePartition> {
    let mut ranges: Vec<Vec<SubresourceRange>> = sizes.iter().map(|size| vec![SubresourceRange::whole(size)]).collect();
    for access in graph.passes.iter().flat_map(|pass| &pass.accesses) {
        let resource = access.resource.0 as usize;
        ranges[resource].push(SubresourceRange::of(access, &sizes[resource]));
    }
    ranges[present.resource.0 as usize].push(presented(present, sizes));
    ranges.into_iter().map(SubresourcePartition::new).collect()
}

fn parts_of<'a>(
    parts: &'a [SubresourcePartition],
    sizes: &'a [Size],
    access: &BoundAccess,
) -> impl Iterator<Item = usize> + use<> {
    let resource = access.resource.0 as usize;
    parts[resource].of(SubresourceRange::of(access, &sizes[resource]))
}

fn mark(needs: &mut [bool], parts: impl IntoIterator<Item = usize>) {
    for part in parts {
        needs[part] = true;
    }
}
