//! Clocks: their passes stand together, also when loops are written out; only passes of a clock write resources that turn with it, and a
//! resource that only some frames write does not turn with the frames.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{ClockId, Every, Graph, Loop, LoopId, Pass, Resource, ResourceId};
use raxel_graph::index32;

use crate::resolve::Resolved;

/// Checks the clocks of a graph whose passes are all known. As in [`super::flow`], warnings are given only where nothing is wrong.
pub(crate) fn check(graph: &Graph, resolved: &Resolved, found: &mut Vec<Diagnostic>) {
    let wrong = found.iter().any(Diagnostic::is_error);
    let mut clocks = Vec::new();
    for index in 0..graph.clocks.len() {
        passes_stand_together(graph, ClockId(index32(index)), &mut clocks);
    }
    for (index, repeated) in graph.loops.iter().enumerate() {
        loop_is_of_one_rhythm(graph, LoopId(index32(index)), repeated, &mut clocks);
    }
    for (index, declared) in resolved.resources.iter().enumerate().filter(|(_, declared)| declared.sound) {
        let id = ResourceId(index32(index));
        match declared.item.clock {
            Some(clock) => written_by_its_clock(graph, id, clock, &mut clocks),
            None => turns_with_its_writers(graph, id, &mut clocks),
        }
    }
    found.extend(clocks.into_iter().filter(|diagnostic| diagnostic.is_error() || !wrong));
}

fn is_of(pass: &Pass, clock: ClockId) -> bool {
    pass.every == Some(Every::Clock(clock))
}

/// A tick is a run of its passes one after the other, so nothing else may stand between them.
fn passes_stand_together(graph: &Graph, clock: ClockId, found: &mut Vec<Diagnostic>) {
    let name = &graph.clock(clock).name;
    let mut of_clock = (0..graph.passes.len()).filter(|&pass| is_of(&graph.passes[pass], clock));
    let Some(mut last) = of_clock.next() else {
        found.push(
            Diagnostic::warning(codes::graph::UNUSED, format!("clock `{name}` drives no pass"))
                .label(graph.clock(clock).place.clone(), format!("no pass has `every = \"{name}\"`")),
        );
        return;
    };
    for pass in of_clock {
        if pass > last + 1 {
            let between = &graph.passes[last + 1];
            found.push(
                Diagnostic::error(
                    codes::graph::CLOCK_GROUP,
                    format!(
                        "passes `{}` and `{}` run by clock `{name}`, but `{}` stands between them",
                        graph.passes[last].name, graph.passes[pass].name, between.name
                    ),
                )
                .label(between.place.clone(), "runs once a frame")
                .label(graph.passes[pass].place.clone(), "runs once a tick")
                .help(format!(
                    "a frame may catch up several ticks, each of which runs all passes of the clock: move `{}` before or behind \
                     them, or give it `every = \"{name}\"`",
                    between.name
                )),
            );
            return;
        }
        last = pass;
    }
}

/// A tick runs all rounds of a loop. Of a loop with passes of several rhythms, the second round would stand between the passes of the
/// clock; and names that change places there must not be those of another clock.
fn loop_is_of_one_rhythm(graph: &Graph, id: LoopId, repeated: &Loop, found: &mut Vec<Diagnostic>) {
    let passes = || graph.passes.iter().filter(|pass| pass.in_loop.as_ref().is_some_and(|in_loop| in_loop.of == id));
    let clock_of = |pass: &Pass| if let Some(Every::Clock(clock)) = pass.every { Some(clock) } else { None };
    let Some(first) = passes().next() else { return };
    let clocked = passes().find_map(|pass| clock_of(pass).map(|clock| (pass, clock)));
    if let Some((of_clock, clock)) = clocked
        && let Some(other) = passes().find(|pass| clock_of(pass) != Some(clock))
    {
        let name = &graph.clock(clock).name;
        let message = format!(
            "loop `{}` repeats pass `{}`, which runs by clock `{name}`, together with `{}`, which does not",
            repeated.name, of_clock.name, other.name
        );
        found.push(
            Diagnostic::error(codes::graph::CLOCK_GROUP, message)
                .label(of_clock.place.clone(), "runs once a tick")
                .label(other.place.clone(), "runs at another rhythm")
                .label(repeated.place.clone(), "the loop")
                .help(format!(
                    "a tick runs all rounds of a loop: give all of its passes `every = \"{name}\"`, or none"
                )),
        );
        return;
    }
    for resource in repeated.swap.iter().map(|[a, _]| graph.resource(*a)) {
        let Some(clock) = resource.clock.filter(|clock| clock_of(first) != Some(*clock)) else { continue };
        let name = &graph.clock(clock).name;
        let message = format!(
            "loop `{}` lets `{}` change places, which turns with clock `{name}`, but does not run by that clock",
            repeated.name, resource.name
        );
        found.push(
            Diagnostic::error(codes::graph::CLOCK_WRITER, message)
                .label(first.place.clone(), "changes its place at another rhythm")
                .label(resource.place.clone(), format!("turns with `{name}`"))
                .help(format!("give the passes of the loop `every = \"{name}\"`, or swap other resources")),
        );
    }
}

fn writers(graph: &Graph, id: ResourceId) -> impl Iterator<Item = &Pass> {
    let writes = move |pass: &&Pass| pass.accesses.iter().any(|a| a.resource == id && a.access.writes());
    graph.passes.iter().filter(writes)
}

/// A pass of another rhythm would write a copy that the next tick may or may not turn away.
fn written_by_its_clock(graph: &Graph, id: ResourceId, clock: ClockId, found: &mut Vec<Diagnostic>) {
    let (resource, name) = (graph.resource(id), &graph.clock(clock).name);
    for writer in writers(graph, id).filter(|pass| !is_of(pass, clock)) {
        found.push(
            Diagnostic::error(
                codes::graph::CLOCK_WRITER,
                format!(
                    "pass `{}` writes `{}`, which turns with clock `{name}`, but does not run by that clock",
                    writer.name, resource.name
                ),
            )
            .label(writer.place.clone(), "writes it at another rhythm")
            .label(resource.place.clone(), format!("turns with `{name}`"))
            .help(format!("give the pass `every = \"{name}\"`, or write another resource")),
        );
    }
}

/// History and clears turn with the frames. Where no pass writes in every frame, most copies are old, or cleared and empty.
fn turns_with_its_writers(graph: &Graph, id: ResourceId, found: &mut Vec<Diagnostic>) {
    let resource = graph.resource(id);
    let what = match (resource.history > 0, resource.kind.is_cleared()) {
        (true, _) => "history",
        (false, true) => "clear",
        (false, false) => return,
    };
    let mut writers = writers(graph, id).peekable();
    let Some(first) = writers.peek().copied() else { return };
    if !writers.all(|pass| pass.every.is_some()) {
        return;
    }
    found.push(turns_without(graph, resource, first, what));
}

fn turns_without(graph: &Graph, resource: &Resource, writer: &Pass, what: &str) -> Diagnostic {
    let name = &resource.name;
    let (does, help) = match (what, writer.every) {
        ("history", Some(Every::Clock(clock))) => (
            "the copies change places in every frame",
            format!("give `{name}` the key `clock = \"{}\"`", graph.clock(clock).name),
        ),
        (_, Some(Every::Clock(clock))) => {
            ("it is cleared in every frame", format!("give `{name}` the key `clock = \"{}\"`", graph.clock(clock).name))
        }
        ("history", _) => (
            "the copies change places in every frame",
            format!(
                "declare a clock, `[clocks.NAME]` with `hz`, and give it to `{name}` and to the passes that write it"
            ),
        ),
        _ => (
            "it is cleared in every frame",
            format!(
                "clear `{name}` in the pass, or give it and the passes that write it a clock, `[clocks.NAME]` with `hz`"
            ),
        ),
    };
    Diagnostic::warning(
        codes::graph::CLOCK_MISSING,
        format!("`{name}` has `{what}`, but pass `{}` does not write it in every frame", writer.name),
    )
    .label(resource.place.clone(), does)
    .label(writer.place.clone(), "runs only now and then")
    .help(help)
}
