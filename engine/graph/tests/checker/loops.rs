//! Loops of random graphs, written out forwards, by following the memory that every name stands for. The compiler goes backwards.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_graph::checked::*;
use raxel_graph::plan::{Plan, Present};

use super::flow::{subresources, touched};
use super::graphs::{Case, case, random};
use raxel_testing::Random;

/// A random graph with loops; `None` for a seed whose graph is too long to be repeated.
pub(crate) fn looped(seed: u64) -> Option<Case> {
    let mut case = case(seed);
    let mut random = random(seed ^ 0x100f);
    let r = &mut random;
    let graph = Arc::make_mut(&mut case.graph);
    if graph.passes.len() > 12 {
        return None;
    }
    let mut first = r.below(graph.passes.len() as u32) as usize;
    while first < graph.passes.len() && graph.loops.len() < 2 {
        let most = (first + 1 + r.below(3) as usize).min(graph.passes.len());
        // A loop with passes of a clock has no others.
        let of = clock(&graph.passes[first]);
        let end = (first..most).find(|&pass| clock(&graph.passes[pass]) != of).unwrap_or(most);
        repeat(r, graph, first..end);
        first = end + r.below(3) as usize;
    }
    Some(case)
}

fn clock(pass: &Pass) -> Option<ClockId> {
    if let Some(Every::Clock(clock)) = pass.every { Some(clock) } else { None }
}

fn repeat(r: &mut Random, graph: &mut Graph, group: std::ops::Range<usize>) {
    let of = LoopId(graph.loops.len() as u32);
    let sizes = subresources(graph);
    let pyramids: Vec<ResourceId> = (0..graph.resources.len() as u32)
        .map(ResourceId)
        .filter(|id| sizes[id.0 as usize].0 > 1 && graph.resource(*id).kind.supplied_by().is_none())
        .collect();
    let rounds =
        if !pyramids.is_empty() && r.percent(40) { Rounds::Mips(r.pick(&pyramids)) } else { Rounds::Fixed(r.below(4)) };
    for index in group.clone() {
        let mut mips = Vec::new();
        for (number, access) in (0..).zip(&graph.passes[index].accesses) {
            if sizes[access.resource.0 as usize].0 > 1 && r.percent(50) {
                mips.push((number, r.pick(&RoundIndex::ALL)));
            }
        }
        graph.passes[index].in_loop = Some(InLoop { of, mips, dispatch_mip: None });
    }
    let mut swap: Vec<[ResourceId; 2]> = Vec::new();
    for _ in 0..r.below(3) {
        // Half of the accesses are to a twin from now on.
        let accesses: Vec<ResourceId> =
            graph.passes[group.clone()].iter().flat_map(|p| &p.accesses).map(|a| a.resource).collect();
        if accesses.is_empty() {
            break;
        }
        let id = r.pick(&accesses);
        let taken = swap.iter().flatten().any(|other| *other == id);
        // A resource that turns with a clock changes places in loops of that clock alone.
        let turns_apart = graph.resource(id).clock.is_some_and(|of| clock(&graph.passes[group.start]) != Some(of));
        if taken || turns_apart || graph.resource(id).kind.supplied_by().is_some() || graph.resource(id).made {
            continue;
        }
        let twin = ResourceId(graph.resources.len() as u32);
        let resource =
            Resource { name: format!("{}_twin{}", graph.resource(id).name, twin.0), ..graph.resource(id).clone() };
        graph.resources.push(resource);
        for pass in &mut graph.passes[group.start..] {
            let indirect = pass.accesses.iter().any(|a| a.resource == id && a.usage == Usage::IndirectArguments);
            for access in pass.accesses.iter_mut().filter(|access| access.resource == id && !indirect) {
                if r.percent(50) {
                    access.resource = twin;
                }
            }
        }
        swap.push([id, twin]);
    }
    let place = graph.passes[group.start].place.clone();
    graph.loops.push(Loop { name: format!("loop{}", of.0), rounds, down: r.percent(50), swap, place });
}

/// Why a graph has no frame that is the same each time: a name is carried into the next frame in another one's memory.
#[derive(Debug)]
pub(crate) struct Carried;

/// The passes of a frame in a row, and the shown resource at each point.
pub(crate) fn written_out(case: &Case) -> Result<(Graph, Present), Carried> {
    let graph = &case.graph;
    let sizes = subresources(graph);
    // Names by the memory that they stand for, as the frame goes on.
    let mut memory: Vec<u32> = (0..graph.resources.len() as u32).collect();
    let mut passes: Vec<(u32, Pass, Vec<u32>)> = Vec::new();
    let mut next = 0;
    while next < graph.passes.len() {
        let of = graph.passes[next].in_loop.as_ref().map(|l| l.of);
        let end = (next..graph.passes.len())
            .find(|i| graph.passes[*i].in_loop.as_ref().map(|l| l.of) != of)
            .unwrap_or(graph.passes.len());
        let group = next..end;
        let Some(of) = of else {
            passes.extend(group.map(|index| (index as u32, graph.passes[index].clone(), memory.clone())));
            next = end;
            continue;
        };
        let repeated = &graph.loops[of.0 as usize];
        let count = match repeated.rounds {
            Rounds::Fixed(count) => count,
            Rounds::Mips(of) => sizes[of.0 as usize].0 - 1,
            Rounds::Param(_) => 0,
        };
        // Frames and ticks that skip the loop would leave the names in another order than frames that run it.
        let running = || group.clone().map(|index| &graph.passes[index]).filter(|pass| case.runs(pass));
        let skipped = running().next().is_some() && running().all(|pass| pass.every.is_some());
        if skipped && count % 2 == 1 && !repeated.swap.is_empty() {
            return Err(Carried);
        }
        for round in 0..count {
            let number = if repeated.down { count - round - 1 } else { round };
            for index in group.clone() {
                let mut pass = graph.passes[index].clone();
                pass.name = format!("{}[{number}]", pass.name);
                for (access, step) in &graph.passes[index].in_loop.as_ref().expect("it is in a loop").mips {
                    pass.accesses[*access as usize].mips =
                        Interval::one(if *step == RoundIndex::Next { number + 1 } else { number });
                }
                passes.push((index as u32, pass, memory.clone()));
            }
            if running().next().is_some() {
                for [a, b] in &repeated.swap {
                    memory.swap(a.0 as usize, b.0 as usize);
                }
            }
        }
        next = end;
    }
    // Memory is called by the name that stands for it when the frame ends.
    let called = |cell: u32| memory.iter().position(|at| *at == cell).expect("a name for each memory") as u32;
    let mut shown = case.present;
    let after = case.present.after.map(|after| passes.iter().rposition(|(index, ..)| *index <= after.0));
    if let Some(Some(after)) = after {
        shown.after = Some(PassId(after as u32));
        if shown.age == 0 {
            shown.resource = ResourceId(called(passes[after].2[shown.resource.0 as usize]));
        }
    } else {
        shown.after = None;
    }
    let mut flat = Graph { loops: Vec::new(), passes: Vec::new(), ..(**graph).clone() };
    for (index, mut pass, memory) in passes {
        pass.in_loop = None;
        pass.round = Some(Round { pass: PassId(index), index: None });
        for access in pass.accesses.iter_mut().filter(|access| access.age == 0) {
            access.resource = ResourceId(called(memory[access.resource.0 as usize]));
        }
        if let Dispatch::Indirect { buffer, .. } = &mut pass.dispatch {
            *buffer = ResourceId(called(memory[buffer.0 as usize]));
        }
        flat.passes.push(pass);
    }
    // At the start of the next frame, a name stands for its own resource, as at the end of this frame. The passes use the resource
    // that follows from the swaps. If the two differ, no pass may look at contents of the last frame.
    let start: Vec<u32> = (0..graph.resources.len() as u32).map(called).collect();
    // Parts, and when the passes run that stored them.
    let mut stored: BTreeMap<(u32, u32, u32), Vec<Option<Every>>> = BTreeMap::new();
    for pass in flat.passes.iter().filter(|pass| case.runs(pass)) {
        let now = |writes: bool| {
            let of = pass
                .accesses
                .iter()
                .filter(move |a| a.age == 0 && if writes { a.access.writes() } else { a.access.reads() });
            of.flat_map(|a| touched(a, sizes[a.resource.0 as usize]).into_iter().map(|(m, l)| (a.resource.0, m, l)))
        };
        for part in now(false) {
            let stands_elsewhere = start.iter().position(|cell| *cell == part.0) != Some(part.0 as usize);
            let always = |every: &Option<Every>| every.is_none() || *every == pass.every;
            let is_new = stored.get(&part).is_some_and(|by| by.iter().any(always));
            if stands_elsewhere && !flat.resources[part.0 as usize].kind.is_cleared() && !is_new {
                return Err(Carried);
            }
        }
        for part in now(true) {
            stored.entry(part).or_default().push(pass.every);
        }
    }
    Ok((flat, shown))
}

/// Faults in the passes of a plan as they are written out.
pub(crate) fn faults(flat: &Graph, shown: Present, plan: &Plan) -> Vec<String> {
    let mut faults = Vec::new();
    if shown != plan.present {
        faults.push(format!("shows {:?}, should show {shown:?}", plan.present));
    }
    let facts = |pass: &Pass| (pass.name.clone(), pass.accesses.clone(), pass.dispatch.clone());
    let (planned, expected) = (&plan.graph.passes, &flat.passes);
    if planned.iter().map(facts).ne(expected.iter().map(facts)) {
        faults.push("the rounds are not those of the loops".to_owned());
    }
    for (a, b) in planned.iter().zip(expected) {
        if a.round.map(|round| round.pass) != b.round.map(|round| round.pass) {
            faults.push(format!("{} does not lead back to its pass", a.name));
        }
    }
    faults
}
