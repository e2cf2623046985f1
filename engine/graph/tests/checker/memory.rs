//! Is it safe to forget what shares memory?

use raxel_graph::checked::*;
use raxel_graph::plan::{BlockOffset, Lifetime, Observe, Plan, ResourceDesc, ResourcePlan, Step};

use super::flow::{carried, subresources, touched};
use super::graphs::Case;

/// A resource in a shared block.
struct Placed {
    index: usize,
    place: BlockOffset,
    image: bool,
    first: u32,
    last: u32,
}

/// The bytes of a placed resource, in whole pages against a resource of the other kind.
pub(crate) fn bytes(plan: &Plan, index: usize, page: u64) -> Option<(u32, u64, u64)> {
    let Lifetime::Transient { place: Some(place), .. } = plan.resources[index].lifetime else { return None };
    let (start, end) = (place.offset, place.offset + plan.resources[index].memory.size);
    Some((place.block, start - start % page, end.div_ceil(page) * page))
}

/// Whether two placed resources share memory.
pub(crate) fn share(plan: &Plan, a: usize, b: usize, granularity: u64) -> bool {
    let image = |i: usize| matches!(plan.resources[i].desc, ResourceDesc::Image(_));
    let page = if image(a) == image(b) { 1 } else { granularity };
    match (bytes(plan, a, page), bytes(plan, b, page)) {
        (Some(a), Some(b)) => a.0 == b.0 && a.1 < b.2 && b.1 < a.2,
        _ => false,
    }
}

/// Faults in lifetimes and places.
pub(crate) fn faults(case: &Case, plan: &Plan) -> Vec<String> {
    let mut faults = Vec::new();
    let mut placed = Vec::new();
    if plan.uses_history != uses_history(plan) {
        faults.push(format!("a frame looks back: {}", plan.uses_history));
    }
    for (index, resource) in plan.resources.iter().enumerate() {
        if resource.varies != varies(plan, index) {
            let name = &case.graph.resource(resource.resource).name;
            faults.push(format!("{name}: varies is {}", resource.varies));
        }
    }
    for (index, resource) in plan.resources.iter().enumerate() {
        let name = &case.graph.resource(resource.resource).name;
        let Lifetime::Transient { first, last, place } = resource.lifetime else { continue };
        let uses = uses(plan, index);
        if uses.first() != Some(&first) || uses.last() != Some(&last) {
            faults.push(format!("{name}: lives {first} to {last}, but is used at {uses:?}"));
        }
        if let Some(why) = outlives_frame(case, plan, index) {
            faults.push(format!("{name}: transient, but {why}"));
        }
        if let Some(place) = place {
            if !varies(plan, index) {
                faults.push(format!("{name}: shares memory, though it is the same in every frame"));
            }
            if !case.alias {
                faults.push(format!("{name}: shares memory, which was not asked for"));
            }
            let image = matches!(resource.desc, ResourceDesc::Image(_));
            placed.push(Placed { index, place, image, first, last });
        }
    }
    for one in &placed {
        let resource = &plan.resources[one.index];
        let block = &plan.blocks[one.place.block as usize];
        let needs = resource.memory;
        if !one.place.offset.is_multiple_of(needs.alignment) || !block.alignment.is_multiple_of(needs.alignment) {
            faults.push(format!("resource {}: not aligned", one.index));
        }
        if one.place.offset + needs.size > block.size {
            faults.push(format!("resource {}: beyond its block", one.index));
        }
        if block.type_bits == 0 || needs.type_bits & block.type_bits != block.type_bits {
            faults.push(format!("resource {}: no memory type for it and its block", one.index));
        }
        let mut shares = false;
        for other in placed.iter().filter(|other| other.index != one.index && other.place.block == one.place.block) {
            let page = if one.image == other.image { 1 } else { case.memory.granularity };
            let (a, b) = (bytes(plan, one.index, page), bytes(plan, other.index, page));
            let (Some(a), Some(b)) = (a, b) else { continue };
            if a.1 < b.2 && b.1 < a.2 {
                shares = true;
                if one.first <= other.last && other.first <= one.last {
                    faults.push(format!("resources {} and {} live in the same bytes", one.index, other.index));
                }
            }
        }
        if !shares {
            faults.push(format!("resource {}: in a block, but shares with nobody", one.index));
        }
    }
    for (number, block) in plan.blocks.iter().enumerate() {
        let of_block = placed.iter().filter(|one| one.place.block == number as u32);
        let sum: u64 = of_block.map(|one| plan.resources[one.index].memory.size).sum();
        if block.size > sum {
            faults.push(format!("block {number}: larger than its occupants together"));
        }
    }
    faults
}

/// Steps that touch a resource.
fn uses(plan: &Plan, index: usize) -> Vec<u32> {
    let id = plan.resources[index].resource;
    let touches = |step: &Step| match step {
        Step::Barrier(_) => false,
        Step::Clear { resource, .. } | Step::Copy { resource } => *resource as usize == index,
        Step::Dispatch { pass } => {
            plan.graph.pass(plan.passes[*pass as usize].pass).accesses.iter().any(|a| a.resource == id)
        }
        Step::Present => plan.present.resource == id,
    };
    (0..).zip(&plan.steps).filter(|(_, step)| touches(step)).map(|(at, _)| at).collect()
}

fn asks_for_clear(kind: &ResourceKind) -> bool {
    match kind {
        ResourceKind::Target(target) => target.clear.is_some(),
        ResourceKind::Buffer(buffer) => buffer.clear.is_some(),
    }
}

/// Whether a resource may hold something else in every frame: walks back through everything that it is made from.
fn varies(plan: &Plan, index: usize) -> bool {
    let graph = &plan.graph;
    let live = || plan.passes.iter().map(|planned| graph.pass(planned.pass));
    let mut open = vec![plan.resources[index].resource];
    let mut known = open.clone();
    while let Some(id) = open.pop() {
        let writers = || live().filter(|pass| pass.accesses.iter().any(|a| a.resource == id && a.access.writes()));
        if grows(plan, id) || writers().any(|pass| !pass.push.is_empty()) {
            return true;
        }
        for read in writers().flat_map(|pass| &pass.accesses).filter(|a| a.access.reads()) {
            if !known.contains(&read.resource) {
                known.push(read.resource);
                open.push(read.resource);
            }
        }
    }
    false
}

/// Whether passes store to it, and it holds something of earlier frames.
fn grows(plan: &Plan, id: ResourceId) -> bool {
    let mut accesses = plan.passes.iter().flat_map(|planned| &plan.graph.pass(planned.pass).accesses);
    let older = accesses.clone().any(|a| a.resource == id && a.age > 0);
    let older = older || plan.present.resource == id && plan.present.age > 0;
    let stored = accesses.any(|a| a.resource == id && a.access.writes());
    stored && (older || plan.graph.resource(id).clock.is_some() || loaded_first(plan, id))
}

/// Whether a frame depends on those before it by more than the camera of the last one.
fn uses_history(plan: &Plan) -> bool {
    let filled = |index: usize| {
        let fills = |step: &Step| matches!(step, Step::Clear { resource, .. } | Step::Copy { resource } if *resource as usize == index);
        plan.steps.iter().any(fills)
    };
    let carries = |(index, planned): (usize, &ResourcePlan)| {
        let resource = plan.graph.resource(planned.resource);
        let mut accesses = plan.passes.iter().flat_map(|planned| &plan.graph.pass(planned.pass).accesses);
        let stored = accesses.any(|a| a.resource == planned.resource && a.access.writes()) || filled(index);
        (initialised(&resource.kind) || resource.keep) && stored || grows(plan, planned.resource)
    };
    let counts = |fill: &Fill| matches!(fill.from, ValueOrigin::Builtin(Builtin::FrameStill | Builtin::HistoryValid));
    let tells = |pass: &Pass| pass.every.is_some() || pass.push.iter().any(counts);
    plan.resources.iter().enumerate().any(carries)
        || plan.passes.iter().any(|planned| tells(plan.graph.pass(planned.pass)))
}

fn initialised(kind: &ResourceKind) -> bool {
    match kind {
        ResourceKind::Target(target) => target.init.is_some(),
        ResourceKind::Buffer(buffer) => buffer.init.is_some(),
    }
}

/// Whether a frame loads what an earlier one left there.
fn loaded_first(plan: &Plan, id: ResourceId) -> bool {
    let index = plan.resources.iter().position(|r| r.resource == id);
    if index.is_none_or(|index| plan.resources[index].lifetime != Lifetime::Persistent) {
        return false;
    }
    let (mips, layers) = subresources(&plan.graph)[id.0 as usize];
    let mut parts = (0..mips).flat_map(|mip| (0..layers).map(move |layer| (mip, layer)));
    parts.any(|part| {
        let touches = |a: &&BoundAccess| a.resource == id && touched(a, (mips, layers)).contains(&part);
        for step in &plan.steps {
            match step {
                Step::Clear { resource, .. } if Some(*resource as usize) == index => return false,
                Step::Dispatch { pass } => {
                    let accesses = &plan.graph.pass(plan.passes[*pass as usize].pass).accesses;
                    if accesses.iter().filter(touches).any(|a| a.access.reads()) {
                        return true;
                    }
                    if accesses.iter().any(|a| touches(&a)) {
                        return false;
                    }
                }
                Step::Present if plan.present.resource == id => {
                    let volume = matches!(&plan.resources[index.unwrap_or(0)].desc, ResourceDesc::Image(i) if i.volume);
                    let layer = if volume { 0 } else { plan.present.layer };
                    let buffer = matches!(plan.graph.resource(id).kind, ResourceKind::Buffer(_));
                    if buffer || part == (plan.present.mip, layer) {
                        return true;
                    }
                }
                _ => {}
            }
        }
        false
    })
}

/// Why the contents of a resource matter beyond the frame that stores them.
fn outlives_frame(case: &Case, plan: &Plan, index: usize) -> Option<&'static str> {
    let graph = &case.graph;
    let id = plan.resources[index].resource;
    let resource = graph.resource(id);
    let touched_by = |pass: &&Pass| pass.accesses.iter().any(|a| a.resource == id);
    let stored_by = |pass: &&Pass| pass.accesses.iter().any(|a| a.resource == id && a.access.writes());
    if initialised(&resource.kind) {
        return Some("it has `init`");
    }
    if resource.kind.supplied_by().is_some() {
        return Some("it is a source or a copy of one");
    }
    if resource.history > 0 {
        return Some("it has history");
    }
    if resource.keep {
        return Some("it is to be kept");
    }
    if resource.clock.is_some() {
        return Some("it turns with a clock");
    }
    if id == case.present.resource || case.pinned.contains(&id) || case.observe == Observe::Everything {
        return Some("it is looked at from outside");
    }
    if carried(case).iter().any(|part| part.0 == id.0) {
        return Some("the graph carries it to the next frame, whatever is culled");
    }
    if graph.passes.iter().filter(|pass| !case.runs(pass)).any(|pass| stored_by(&pass)) {
        return Some("a pass that stores to it is off");
    }
    let live = || plan.passes.iter().map(|pass| graph.pass(pass.pass));
    if live().filter(touched_by).any(|pass| pass.every.is_some()) {
        return Some("a pass that touches it does not run in each frame");
    }
    // Subresource by subresource: nothing is loaded before it is stored.
    let (mips, layers) = subresources(graph)[id.0 as usize];
    for mip in 0..mips {
        for layer in 0..layers {
            for step in &plan.steps {
                let touches = |a: &&BoundAccess| a.resource == id && touched(a, (mips, layers)).contains(&(mip, layer));
                match step {
                    // A resource that is only filled to be watched hides no load.
                    Step::Clear { resource: cleared, .. }
                        if *cleared as usize == index && asks_for_clear(&resource.kind) =>
                    {
                        break;
                    }
                    Step::Dispatch { pass } => {
                        let accesses = &graph.pass(plan.passes[*pass as usize].pass).accesses;
                        if accesses.iter().filter(touches).any(|a| a.access.reads()) {
                            return Some("it is loaded before anything is stored");
                        }
                        if accesses.iter().any(|a| touches(&a)) {
                            break;
                        }
                    }
                    _ => {}
                }
            }
        }
    }
    None
}
