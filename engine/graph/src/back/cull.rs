//! Cull: leave out passes whose `when` does not hold and passes that nothing presented or pinned depends on, now or in any later
//! frame.
//!
//! A pass that leaves something for later frames is never culled for being unused. So what an accumulator, a history or a kept target
//! holds does not depend on what was shown or pinned in the frames before, and culling cannot be seen.

use std::ops::Range;

use crate::back::limits;
use crate::ir::checked::{BoundAccess, Every, Graph, Pass, PassId, ResourceId};
use crate::ir::index::index32;
use crate::ir::plan::{CullReason, Culled, Observe, PlanInput, Present};
use crate::ir::size::Size;
use crate::ir::subresources::{SubresourcePartition, SubresourceRange};

/// What is left of a graph.
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
    /// By resource: later frames find in (a part of) it what this one leaves, whether or not a live pass looks.
    pub carried: Vec<bool>,
}

/// Which parts of every resource matter at one point of the frame.
type Needs = Vec<Vec<bool>>;

/// Decides what runs.
pub(crate) fn cull(graph: &Graph, sizes: &[Size], input: &PlanInput) -> Cull {
    let on: Vec<bool> = graph.passes.iter().map(|pass| pass.runs_where(input.facts)).collect();
    let parts = parts(graph, sizes, input.present);
    let range = |access: &BoundAccess| -> Vec<usize> { parts_of(&parts, sizes, access).collect() };

    // What must be in the resources when a frame ends: what is read from outside, and by later frames. The latter is not known
    // before the passes that read it are, so this grows until it stays the same.
    let carried = carried(graph, &on, &parts, range);
    let mut at_end: Needs = carried.clone();
    for pinned in input.pinned {
        at_end[pinned.0 as usize].fill(true);
    }
    if input.observe == Observe::Everything {
        at_end.iter_mut().for_each(|parts| parts.fill(true));
    }
    let presented = presented(input.present, sizes);
    let presented: Vec<usize> = parts[input.present.resource.0 as usize].of(presented).collect();
    let taken_early = input.present.age == 0 && input.present.after.is_some();
    if !taken_early {
        mark(&mut at_end[input.present.resource.0 as usize], presented.iter().copied());
    }

    let mut live = vec![false; graph.passes.len()];
    loop {
        let before = at_end.clone();
        let mut needs = at_end.clone();
        // Backwards through the frame: a pass runs when something behind it needs what it writes. A store never makes an earlier
        // one useless, for a pass need not write every texel.
        let mut end = graph.passes.len();
        while end > 0 {
            let group = group_before(graph, end);
            if input.present.after.is_some_and(|after| group.contains(&(after.0 as usize))) {
                mark(&mut needs[input.present.resource.0 as usize], presented.iter().copied());
            }
            let repeated = catches_up(graph, &graph.passes[group.start]);
            loop {
                let before_tick = repeated.then(|| needs.clone());
                for (index, pass) in
                    group.clone().map(|index| (index, &graph.passes[index])).rev().filter(|(i, _)| on[*i])
                {
                    live[index] |= pass
                        .accesses
                        .iter()
                        .any(|a| a.access.writes() && range(a).iter().any(|&part| needs[a.resource.0 as usize][part]));
                    if live[index] {
                        for access in pass.accesses.iter().filter(|a| a.access.reads()) {
                            let point = if access.age == 0 { &mut needs } else { &mut at_end };
                            mark(&mut point[access.resource.0 as usize], range(access));
                        }
                    }
                }
                // What a tick needs when it starts may be made by the tick before it.
                if before_tick.is_none_or(|before| needs == before) {
                    break;
                }
            }
            end = group.start;
        }
        // What is needed when a frame starts must be there when the last one ends, unless the frame makes it anew.
        let anew = made_anew(graph, &live, Some((input.present, &presented)), &parts, range);
        for (index, anew) in anew.iter().enumerate() {
            let needed = (0..anew.len()).filter(|&part| needs[index][part] && !anew[part]);
            mark(&mut at_end[index], needed);
        }
        if at_end == before {
            break;
        }
    }

    let mut result = Cull {
        live: Vec::new(),
        culled: Vec::new(),
        used: Vec::new(),
        switched_off: vec![false; graph.resources.len()],
        carried: carried.iter().map(|parts| parts.contains(&true)).collect(),
    };
    let mut used = vec![false; graph.resources.len()];
    used[input.present.resource.0 as usize] = true;
    for pinned in input.pinned {
        used[pinned.0 as usize] = true;
    }
    for (index, resource) in graph.resources.iter().enumerate() {
        // A clear may leave something for later frames, too.
        let carried = resource.kind.is_cleared() && (resource.history > 0 || resource.clock.is_some());
        // What no pass touches must not refuse a graph that runs without it: a source need not be there, nor a target fit.
        used[index] |= (carried || input.observe == Observe::Everything)
            && resource.kind.supplied_by().is_none()
            && limits::fits(graph, resource, sizes[index], input);
    }
    for (index, pass) in graph.passes.iter().enumerate() {
        let id = PassId(index32(index));
        if live[index] {
            result.live.push(id);
            for access in &pass.accesses {
                used[access.resource.0 as usize] = true;
            }
        } else if on[index] {
            result.culled.push(Culled { pass: id, reason: CullReason::Unused });
        } else {
            result.culled.push(Culled { pass: id, reason: CullReason::Condition });
            for access in pass.accesses.iter().filter(|a| a.access.writes()) {
                result.switched_off[access.resource.0 as usize] = true;
            }
        }
    }
    result.used = (0..graph.resources.len()).filter(|&i| used[i]).map(|i| ResourceId(index32(i))).collect();
    result
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

/// The parts in which later frames find what this one leaves, as the graph is written: those that are kept, those that the first pass to
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

/// The parts that hold nothing of an earlier frame once they are first looked at: those of resources that are cleared, and those
/// that a `writeonly` binding touches first. This is the assumption of [`lifetimes`](mod@crate::back::lifetimes). A later `writeonly` store makes nothing
/// anew: it may add to what an earlier pass of the frame stored.
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

/// What the present step reads.
pub(crate) fn presented(present: Present, sizes: &[Size]) -> SubresourceRange {
    match sizes[present.resource.0 as usize] {
        Size::Image { volume, .. } => SubresourceRange::one(present.mip, if volume { 0 } else { present.layer }),
        size @ Size::Buffer { .. } => SubresourceRange::whole(&size),
    }
}

/// The parts of every resource that accesses and the present point tell apart.
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
