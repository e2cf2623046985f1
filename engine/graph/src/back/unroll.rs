//! Unroll: loops are written out, so that every later phase sees one pass behind the other. Names that change places in a loop are
//! resolved here, too: each pass of each round gets the current resource of its name.
//!
//! When a frame ends, every name stands for its own resource again. So loops do not matter for a resource that is shown, read back, kept
//! for the next frame or read as `name@1`. Before an odd number of swaps, passes store to the other one of the two.

use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, codes};

use crate::ir::checked::{
    self, Dispatch, Every, Fill, Graph, InLoop, LoopId, MOST_ROUNDS, Pass, PassId, ResourceId, Round, Rounds, Value,
    ValueOrigin,
};
use crate::ir::index::index32;
use crate::ir::plan::{PlanInput, Present};
use crate::ir::size::Size;
use crate::ir::subresources::{SubresourcePartition, SubresourceRange};

/// One thing of a frame in its order, before names are resolved.
#[derive(Clone, Copy)]
enum Entry {
    /// A pass, in the round of that index if it is in a loop.
    Pass(PassId, Option<u32>),
    /// The end of a round of a loop whose names change places.
    Swap(LoopId),
}

/// A graph without loops, and the present point in it. A graph that declares no loop is returned as it is.
pub(crate) fn unroll(
    graph: &Arc<Graph>,
    sizes: &[Size],
    input: &PlanInput,
) -> Result<(Arc<Graph>, Present), Vec<Diagnostic>> {
    let asked = Present { after: input.present.after.map(|pass| case_that_runs(graph, pass, input)), ..input.present };
    if graph.loops.is_empty() {
        return Ok((graph.clone(), asked));
    }
    let entries = entries(graph, sizes, input);
    // From the end of the frame to its start: the resource of each name.
    let mut stands_for: Vec<ResourceId> = (0..graph.resources.len()).map(|id| ResourceId(index32(id))).collect();
    let mut passes = Vec::with_capacity(entries.len());
    let mut shown = input.present.resource;
    let after = asked.after.map(|pass| anchor(&entries, pass, input.present.round));
    for (at, entry) in entries.iter().enumerate().rev() {
        match *entry {
            Entry::Swap(id) => {
                for [a, b] in &graph.loops[id.0 as usize].swap {
                    stands_for.swap(a.0 as usize, b.0 as usize);
                }
            }
            Entry::Pass(id, index) => {
                if after == Some(Some(at)) && input.present.age == 0 {
                    shown = stands_for[shown.0 as usize];
                }
                passes.push((at, pass_of_round(graph, id, index, &stands_for)));
            }
        }
    }
    passes.reverse();
    let after = after.flatten().and_then(|at| passes.iter().position(|(entry, _)| *entry == at));
    let present =
        Present { resource: shown, after: after.map(|index| PassId(index32(index))), round: None, ..input.present };
    let passes = passes.into_iter().map(|(_, pass)| pass).collect();
    let flat = Graph { passes, loops: Vec::new(), ..(**graph).clone() };
    runs_now_and_then(graph, sizes, input)?;
    carried(graph, &flat, &stands_for, sizes, input)?;
    Ok((Arc::new(flat), present))
}

/// The order of a frame.
fn entries(graph: &Graph, sizes: &[Size], input: &PlanInput) -> Vec<Entry> {
    let loop_of = |pass: &Pass| pass.in_loop.as_ref().map(|in_loop| in_loop.of);
    let mut entries = Vec::with_capacity(graph.passes.len());
    let mut first = 0;
    for group in graph.passes.chunk_by(|a, b| loop_of(a) == loop_of(b)) {
        let ids = (first..first + group.len()).map(|id| PassId(index32(id)));
        first += group.len();
        let Some(id) = loop_of(&group[0]) else {
            entries.extend(ids.map(|pass| Entry::Pass(pass, None)));
            continue;
        };
        let repeated = &graph.loops[id.0 as usize];
        // A loop without a pass that runs leaves every name where it is.
        let runs = group.iter().any(|pass| is_on(pass, input));
        let count = rounds(graph, repeated.rounds, sizes, input);
        for round in 0..count {
            let index = if repeated.down { count - 1 - round } else { round };
            entries.extend(ids.clone().map(|pass| Entry::Pass(pass, Some(index))));
            if runs && !repeated.swap.is_empty() {
                entries.push(Entry::Swap(id));
            }
        }
    }
    entries
}

/// The pass itself, or the case of it that runs in this world.
fn case_that_runs(graph: &Graph, pass: PassId, input: &PlanInput) -> PassId {
    let cases = graph.cases(&graph.pass(pass).name);
    cases.into_iter().find(|case| is_on(graph.pass(*case), input)).unwrap_or(pass)
}

fn is_on(pass: &Pass, input: &PlanInput) -> bool {
    pass.runs_where(input.facts)
}

/// How often a loop is repeated.
fn rounds(graph: &Graph, rounds: Rounds, sizes: &[Size], input: &PlanInput) -> u32 {
    let count = match rounds {
        Rounds::Fixed(count) => count,
        Rounds::Mips(target) => sizes[target.0 as usize].mips().saturating_sub(1),
        Rounds::Param(id) => {
            let set = input.counts.iter().find(|(param, _)| *param == id).map(|(_, count)| *count);
            set.or_else(|| checked::count_of(graph.params[id.0 as usize].default)).unwrap_or(0)
        }
    };
    count.min(MOST_ROUNDS)
}

/// The entry of that round of a pass, or of its last one. A pass that has no round is where it would be: behind the one before it.
fn anchor(entries: &[Entry], pass: PassId, round: Option<u32>) -> Option<usize> {
    let wanted = |entry: &Entry| matches!(entry, Entry::Pass(id, index) if *id == pass && *index == round);
    if let Some(at) = round.and_then(|_| entries.iter().position(wanted)) {
        return Some(at);
    }
    entries.iter().rposition(|entry| matches!(entry, Entry::Pass(id, _) if *id <= pass))
}

/// A pass as it is in one round.
fn pass_of_round(graph: &Graph, id: PassId, index: Option<u32>, stands_for: &[ResourceId]) -> Pass {
    let mut pass = graph.pass(id).clone();
    pass.round = Some(Round { pass: id, index });
    if let (Some(in_loop), Some(index)) = (pass.in_loop.take(), index) {
        pass.name = format!("{}[{index}]", pass.name);
        resolve_round(&mut pass, &in_loop, index);
    }
    for access in pass.accesses.iter_mut().filter(|access| access.age == 0) {
        access.resource = stands_for[access.resource.0 as usize];
    }
    if let Dispatch::Indirect { buffer, .. } = &mut pass.dispatch {
        *buffer = stands_for[buffer.0 as usize];
    }
    pass
}

/// Puts the numbers of a round into a pass.
fn resolve_round(pass: &mut Pass, in_loop: &InLoop, index: u32) {
    pass.accesses = checked::accesses_of_round(&pass.accesses, in_loop, index);
    if let (Some(of_round), Dispatch::ThreadsOf { mip, .. } | Dispatch::GroupsOf { mip, .. }) =
        (in_loop.dispatch_mip, &mut pass.dispatch)
    {
        *mip = of_round.at(index);
    }
    let number = |from: &mut ValueOrigin| {
        if let ValueOrigin::Round(of_round) = from {
            *from = ValueOrigin::Value(Value::U32(of_round.at(index)));
        }
    };
    let fills = pass.push.iter_mut().chain(pass.uniforms.iter_mut().flat_map(|block| &mut block.fills));
    fills.for_each(|fill: &mut Fill| number(&mut fill.from));
    pass.specialization.iter_mut().for_each(|(_, from)| number(from));
}

/// Names are resolved once for all frames. So a loop that one frame skips and another runs several times (the ticks of a clock) must
/// leave every name where it was.
fn runs_now_and_then(graph: &Graph, sizes: &[Size], input: &PlanInput) -> Result<(), Vec<Diagnostic>> {
    let mut found = Vec::new();
    for (index, repeated) in graph.loops.iter().enumerate() {
        let of = |pass: &&Pass| pass.in_loop.as_ref().is_some_and(|in_loop| in_loop.of.0 as usize == index);
        let mut running = graph.passes.iter().filter(of).filter(|pass| is_on(pass, input)).peekable();
        let count = rounds(graph, repeated.rounds, sizes, input);
        let (Some(&first), Some([a, b])) = (running.peek(), repeated.swap.first()) else { continue };
        if count.is_multiple_of(2) || running.any(|pass| pass.every.is_none()) {
            continue;
        }
        let [a, b] = [a, b].map(|id| &graph.resource(*id).name);
        let (when, how) = match first.every {
            Some(Every::Clock(clock)) => {
                (format!("in each tick of clock `{}`", graph.clock(clock).name), "runs once a tick")
            }
            _ => (format!("in loop `{}`, which not every frame runs", repeated.name), "runs only now and then"),
        };
        let message = format!("`{a}` and `{b}` change places an odd number of times {when}");
        found.push(
            Diagnostic::error(codes::graph::SWAP_CARRIED, message)
                .label(repeated.place.clone(), swaps(count))
                .label(first.place.clone(), how)
                .help("use an even number of rounds: a frame may run this loop several times or not at all"),
        );
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}

fn swaps(rounds: u32) -> String {
    let s = if rounds == 1 { "" } else { "s" };
    format!("{rounds} round{s}, with a swap after each")
}

/// A name that stands for different resources at the start and at the end of a frame must be made in each frame.
fn carried(
    graph: &Graph,
    flat: &Graph,
    stands_for: &[ResourceId],
    sizes: &[Size],
    input: &PlanInput,
) -> Result<(), Vec<Diagnostic>> {
    let mut found = Vec::new();
    for (index, other) in stands_for.iter().enumerate() {
        let id = ResourceId(index32(index));
        let resource = graph.resource(id);
        if *other == id || resource.kind.is_cleared() {
            continue;
        }
        let Some(reader) = first_reader(flat, *other, &sizes[other.0 as usize], input) else { continue };
        let swapping = graph.loops.iter().find(|repeated| repeated.swap.iter().flatten().any(|swapped| *swapped == id));
        let name = &resource.name;
        let error = Diagnostic::error(
            codes::graph::SWAP_CARRIED,
            format!("`{name}` changes places an odd number of times in a frame, but is carried from frame to frame"),
        )
        .label(resource.place.clone(), "declared here")
        .label(reader.place.clone(), "this pass reads what the last frame left");
        let error = match swapping {
            Some(repeated) => error.label(repeated.place.clone(), swaps(rounds(graph, repeated.rounds, sizes, input))),
            None => error,
        };
        found.push(error.help(format!("use an even number of rounds, or give `{name}` the key `clear`")));
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
}

/// The pass that reads the last frame's contents of a resource: it reads a part that no pass before it stored. A resource that a pass
/// stores only now and then is new for passes that run in the same frames.
fn first_reader<'g>(flat: &'g Graph, id: ResourceId, size: &Size, input: &PlanInput) -> Option<&'g Pass> {
    let accesses = |pass: &'g Pass| pass.accesses.iter().filter(move |access| access.resource == id && access.age == 0);
    let running = || flat.passes.iter().filter(|pass| is_on(pass, input));
    let parts =
        SubresourcePartition::new(running().flat_map(accesses).map(|access| SubresourceRange::of(access, size)));
    let mut stored: Vec<Vec<Option<Every>>> = vec![Vec::new(); parts.count()];
    for pass in running() {
        let is_new = |part: usize| stored[part].iter().any(|every| every.is_none() || *every == pass.every);
        for access in accesses(pass).filter(|access| access.access.reads()) {
            if parts.of(SubresourceRange::of(access, size)).any(|part| !is_new(part)) {
                return Some(pass);
            }
        }
        for access in accesses(pass).filter(|access| access.access.writes()) {
            parts.of(SubresourceRange::of(access, size)).for_each(|part| stored[part].push(pass.every));
        }
    }
    None
}
