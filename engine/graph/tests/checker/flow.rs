//! Is the right thing done, in the right order? Culling is judged by pushing the names of passes forward through many frames:
//! whatever name reaches the picture or a pin belongs to a pass that must run, and to no other.

use std::collections::{BTreeMap, BTreeSet};

use raxel_graph::checked::*;
use raxel_graph::plan::{CullReason, Plan, Step};

use super::graphs::{Case, OUTPUT, SOURCE_IMAGE};
use super::sizes::of_world;

/// Mips and layers of every resource.
pub fn subresources(graph: &Graph) -> Vec<(u32, u32)> {
    graph
        .resources
        .iter()
        .map(|resource| match &resource.kind {
            ResourceKind::Buffer(_) => (1, 1),
            ResourceKind::Target(target) => {
                // Random graphs have no `of`.
                let longest = match target.extent {
                    Extent::Output { scale } => (0..2).map(|i| (f64::from(OUTPUT[i]) * scale[i]).round() as u32).max(),
                    Extent::Fixed2(axes) => axes.into_iter().max(),
                    Extent::Fixed3(axes) => axes.into_iter().max(),
                    Extent::Source => SOURCE_IMAGE.into_iter().max(),
                    Extent::World { scale } => of_world(scale).into_iter().max(),
                    Extent::Of { .. } => None,
                };
                let mut chain = 1;
                while longest.unwrap_or(1) >> chain > 0 {
                    chain += 1;
                }
                (if target.mips == 0 { chain } else { target.mips }, target.layers)
            }
        })
        .collect()
}

/// Every (mip, layer) that an access touches.
pub fn touched(access: &BoundAccess, (mips, layers): (u32, u32)) -> Vec<(u32, u32)> {
    let inside = |(first, count): (u32, u32), at: u32| at >= first && (count == 0 || at < first + count);
    let mut all = Vec::new();
    for mip in (0..mips).filter(|&mip| inside(access.mips, mip)) {
        all.extend((0..layers).filter(|&layer| inside(access.layers, layer)).map(|layer| (mip, layer)));
    }
    all
}

fn cleared(kind: &ResourceKind) -> bool {
    match kind {
        ResourceKind::Target(target) => target.clear.is_some(),
        ResourceKind::Buffer(buffer) => buffer.clear.is_some(),
    }
}

/// Passes whose stores can reach the present step or a pin in some frame, as a bit set; `live` is what the plan says. Of all
/// stores, only a clear and the first access of a frame, if it is write-only and made in each frame, drop what was there.
fn needed(case: &Case, live: u64) -> u64 {
    let graph = &case.graph;
    let sizes = subresources(graph);
    // (resource, copy, mip, layer) → passes whose stores are in there, directly or through what they stored into others.
    let mut contents: BTreeMap<(u32, u32, u32, u32), u64> = BTreeMap::new();
    let mut needed = 0;
    let frames = (graph.passes.len() as u32 + 2) * 3;
    for frame in 0..frames {
        let mut looked_at: BTreeSet<(u32, u32, u32)> = BTreeSet::new();
        let copy = |id: ResourceId, age: u32| {
            let copies = graph.resource(id).history + 1;
            (frame + copies * 2 - age % copies) % copies
        };
        let read = |contents: &BTreeMap<_, u64>, id: ResourceId, age: u32, parts: &[(u32, u32)]| {
            let of =
                |&(mip, layer): &(u32, u32)| contents.get(&(id.0, copy(id, age), mip, layer)).copied().unwrap_or(0);
            parts.iter().map(of).fold(0, |all, one| all | one)
        };
        for (index, resource) in graph.resources.iter().enumerate() {
            if cleared(&resource.kind) {
                let id = ResourceId(index as u32);
                contents.retain(|at, _| (at.0, at.1) != (id.0, copy(id, 0)));
            }
        }
        let shown = case.present;
        let present = |contents: &BTreeMap<_, u64>| {
            let volume = matches!(
                graph.resource(shown.resource).kind,
                ResourceKind::Target(Target { extent: Extent::Fixed3(_) | Extent::World { .. } | Extent::Source, .. })
            );
            read(contents, shown.resource, shown.age, &[(shown.mip, if volume { 0 } else { shown.layer })])
        };
        for (index, pass) in graph.passes.iter().enumerate() {
            if case.runs(pass) {
                let mut stored = 1 << index;
                let lives = live >> index & 1 == 1;
                for access in pass.accesses.iter().filter(|a| a.access.reads()) {
                    let parts = touched(access, sizes[access.resource.0 as usize]);
                    if lives && access.age == 0 {
                        looked_at.extend(parts.iter().map(|&(mip, layer)| (access.resource.0, mip, layer)));
                    }
                    stored |= read(&contents, access.resource, access.age, &parts);
                }
                for access in pass.accesses.iter().filter(|a| a.access.writes()) {
                    for (mip, layer) in touched(access, sizes[access.resource.0 as usize]) {
                        let at = (access.resource.0, copy(access.resource, access.age), mip, layer);
                        let cleared = cleared(&graph.resource(access.resource).kind);
                        let first = lives && looked_at.insert((access.resource.0, mip, layer));
                        if first && !cleared && pass.every.is_none() {
                            contents.remove(&at);
                        }
                        *contents.entry(at).or_default() |= stored;
                    }
                }
            }
            if case.present.after == Some(PassId(index as u32)) {
                if shown.age == 0 {
                    let mips = sizes[shown.resource.0 as usize];
                    for mip in 0..mips.0 {
                        for layer in 0..mips.1 {
                            let volume = layer == 0 && mips.1 == 1;
                            if mip == shown.mip && (layer == shown.layer || volume) {
                                looked_at.insert((shown.resource.0, mip, layer));
                            }
                        }
                    }
                }
                needed |= present(&contents);
            }
        }
        if case.present.after.is_none() {
            needed |= present(&contents);
        }
        for pin in &case.pinned {
            let (mips, layers) = sizes[pin.0 as usize];
            for mip in 0..mips {
                let parts: Vec<_> = (0..layers).map(|layer| (mip, layer)).collect();
                needed |= read(&contents, *pin, 0, &parts);
            }
        }
    }
    needed
}

/// What is wrong with the choice and order of the steps.
pub fn faults(case: &Case, plan: &Plan) -> Vec<String> {
    let graph = &case.graph;
    let mut faults = Vec::new();
    let live = plan.passes.iter().fold(0_u64, |set, pass| set | 1 << pass.pass.0);
    let needed = needed(case, live);
    for (index, pass) in graph.passes.iter().enumerate() {
        let id = PassId(index as u32);
        let lives = plan.passes.iter().any(|p| p.pass == id);
        let reason = plan.culled.iter().find(|c| c.pass == id).map(|c| c.reason);
        let expected = match (case.runs(pass), needed >> index & 1 == 1) {
            (false, _) => Some(CullReason::Condition),
            (true, false) => Some(CullReason::Unused),
            (true, true) => None,
        };
        if reason != expected || lives != expected.is_none() {
            faults.push(format!("{}: culled {reason:?}, should be {expected:?}", pass.name));
        }
    }

    let mut last = None;
    let mut dispatched = Vec::new();
    let mut presents = 0;
    let mut clears: BTreeMap<u32, usize> = BTreeMap::new();
    let mut touched_at: BTreeMap<u32, usize> = BTreeMap::new();
    for (at, step) in plan.steps.iter().enumerate() {
        let mut touch = |id: ResourceId, age: u32| {
            if age == 0 {
                touched_at.entry(id.0).or_insert(at);
            }
        };
        match step {
            Step::Barrier(_) => {
                if matches!(plan.steps.get(at + 1), None | Some(Step::Barrier(_))) {
                    faults.push(format!("step {at}: a barrier before nothing"));
                }
            }
            Step::Clear { resource } => {
                if clears.insert(plan.resources[*resource as usize].resource.0, at).is_some() {
                    faults.push(format!("step {at}: cleared twice"));
                }
            }
            Step::Dispatch { pass } => {
                let id = plan.passes[*pass as usize].pass;
                if last.is_some_and(|last| last >= id) {
                    faults.push(format!("step {at}: out of program order"));
                }
                last = Some(id);
                dispatched.push(*pass);
                for access in &graph.pass(id).accesses {
                    touch(access.resource, access.age);
                }
            }
            Step::Present => {
                presents += 1;
                touch(plan.present.resource, plan.present.age);
                let behind = plan.steps[at..].iter().filter_map(|step| match step {
                    Step::Dispatch { pass } => Some(plan.passes[*pass as usize].pass),
                    _ => None,
                });
                let right = match case.present.after {
                    None => behind.count() == 0,
                    Some(after) => {
                        last.is_none_or(|last| last <= after) && behind.min().is_none_or(|next| next > after)
                    }
                };
                if !right {
                    faults.push(format!("step {at}: presented at the wrong point"));
                }
            }
        }
    }
    if presents != 1 {
        faults.push(format!("presented {presents} times"));
    }
    if dispatched != (0..plan.passes.len() as u32).collect::<Vec<_>>() {
        faults.push("not every live pass is dispatched once".to_owned());
    }
    for resource in &plan.resources {
        let id = resource.resource;
        let clear = clears.get(&id.0);
        if cleared(&graph.resource(id).kind) != clear.is_some() {
            faults.push(format!("{}: clear missing or not asked for", graph.resource(id).name));
        }
        if let (Some(clear), Some(touch)) = (clear, touched_at.get(&id.0))
            && clear > touch
        {
            faults.push(format!("{}: touched before its clear", graph.resource(id).name));
        }
    }
    let used = |id: ResourceId| plan.resources.iter().any(|r| r.resource == id);
    for pass in &plan.passes {
        for access in &graph.pass(pass.pass).accesses {
            if !used(access.resource) {
                faults.push(format!("{} is used and not created", graph.resource(access.resource).name));
            }
        }
    }
    faults
}
