//! Loops: their passes stand together, and keys that follow the round are inside of a loop and of its targets.

use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::checked::{self, BoundAccess, InLoop, LoopId, RoundIndex, Rounds};
use raxel_graph::index32;

use super::Context;
use super::extents::mip_count;
use crate::model::Mip;
use crate::resolve::{Loop, Pass, Resolved};

/// The largest number of a mip that a target can have: the last round that can be checked if the rounds follow the output.
const LAST_MIP: u32 = 16;

/// Checks that between two passes of a loop stands no other.
pub(crate) fn check(graph: &Resolved, found: &mut Vec<Diagnostic>) {
    let of = |pass: &Pass| pass.in_loop.as_ref().map(|name| name.value);
    for (index, pass) in graph.passes.iter().enumerate() {
        let Some(name) = &pass.in_loop else { continue };
        let before = &graph.passes[..index];
        let Some(last) = before.iter().rposition(|other| of(other) == Some(name.value)) else { continue };
        if let Some(between) = before.get(last + 1) {
            let repeated = &graph.loops[name.value.0 as usize].item;
            found.push(
                Diagnostic::error(
                    codes::graph::LOOP_GROUP,
                    format!("the passes of loop `{}` do not stand together", repeated.name),
                )
                .label(name.span.clone(), format!("`{}` is a pass of the loop", pass.name.value))
                .label(before[last].name.span.clone(), "the one before it in the loop")
                .label(between.name.span.clone(), "this one stands between them")
                .help("move the passes of the loop together: all of them run in the first round before any runs in the second"),
            );
        }
    }
}

/// Warns of loops from mip to mip of a target with only one mip: their passes never run.
pub(crate) fn without_rounds(graph: &Resolved, found: &mut Vec<Diagnostic>) {
    for repeated in graph.loops.iter().filter(|repeated| repeated.sound) {
        let Rounds::Mips(target) = repeated.item.rounds else { continue };
        if mip_count(graph, target) != Some(1) {
            continue;
        }
        let (name, target) = (&repeated.item.name, &graph.resources[target.0 as usize]);
        found.push(
            Diagnostic::warning(
                codes::graph::NO_ROUND,
                format!("loop `{name}` has no round: target `{}` has one mip", target.item.name),
            )
            .label(repeated.count.clone(), "a round for each step from one mip to the next")
            .label(target.item.place.clone(), "has nothing but mip 0")
            .help(format!("give `{}` more: `mips = \"full\"`, or a number", target.item.name)),
        );
    }
}

/// The loop of the pass. Without one, `loop.index` means nothing, which is reported.
pub(crate) fn around<'a>(
    context: &Context<'a>,
    index: RoundIndex,
    place: &Span,
    found: &mut Vec<Diagnostic>,
) -> Option<&'a Loop> {
    if let Some(id) = &context.pass.in_loop {
        return Some(&context.graph.loops[id.value.0 as usize]);
    }
    // A loop of another name was meant, and that is reported.
    if context.pass.names_loop {
        return None;
    }
    let pass = &context.pass.name;
    let message = format!("`{}` has no meaning in pass `{}`, which is in no loop", index.name(), pass.value);
    found.push(
        Diagnostic::error(codes::graph::NO_LOOP, message)
            .label(place.clone(), "a number of the round")
            .label(pass.span.clone(), "needs `loop = \"NAME\"`"),
    );
    None
}

/// The largest `loop.index`, where it is known without the output; `None` too where there are no rounds.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and numbers of rounds are bounded by `MOST_ROUNDS` elsewhere"
)]
fn last_index(graph: &Resolved, repeated: &Loop) -> Option<u32> {
    let most = match repeated.item.rounds {
        Rounds::Fixed(count) => count,
        Rounds::Param(id) => graph.params[id.0 as usize].item.range.map_or(0, |[_, high]| high as u32),
        Rounds::Mips(target) => mip_count(graph, target)?.saturating_sub(1),
    };
    most.checked_sub(1)
}

/// The largest mip that a round of the loop asks for, if it is beyond the target's `count` mips, with the key that asks.
pub(crate) fn beyond(graph: &Resolved, repeated: &Loop, index: RoundIndex, count: u32) -> Option<(u32, String)> {
    let mip = index.at(last_index(graph, repeated)?);
    (repeated.sound && mip >= count).then(|| (mip, format!("the last round asks for mip {mip}")))
}

/// The values that a pass takes from its round; the accesses are those of its bindings.
pub(crate) fn in_loop(context: &Context<'_>, accesses: &[BoundAccess]) -> Option<InLoop> {
    let of = context.pass.in_loop.as_ref()?.value;
    let name = |access: &BoundAccess| Some(&context.interface().bindings[access.binding? as usize].name);
    let mips = (0..).zip(accesses).filter_map(|(number, access)| {
        let name = name(access)?;
        let entry = context.pass.bind.iter().find(|entry| entry.name.value == *name)?;
        match &entry.mip {
            Some(Spanned { value: Mip::Round(index), .. }) => Some((number, *index)),
            _ => None,
        }
    });
    let dispatch_mip = context.pass.dispatch_mip.as_ref().map(|index| index.value);
    Some(InLoop { of, mips: mips.collect(), dispatch_mip })
}

/// The accesses of each round that there can be; of a pass in no loop, the one list.
pub(crate) fn rounds(
    context: &Context<'_>,
    accesses: &[BoundAccess],
    in_loop: Option<&InLoop>,
) -> Vec<Vec<BoundAccess>> {
    let Some(in_loop) = in_loop.filter(|in_loop| !in_loop.mips.is_empty()) else { return vec![accesses.to_vec()] };
    let repeated = &context.graph.loops[in_loop.of.0 as usize];
    let last = last_index(context.graph, repeated).unwrap_or(LAST_MIP - 1);
    (0..=last).map(|index| checked::accesses_of_round(accesses, in_loop, index)).collect()
}

/// Warns of loops without a pass.
pub(crate) fn unused(graph: &Resolved, found: &mut Vec<Diagnostic>) {
    for (index, repeated) in graph.loops.iter().enumerate() {
        let id = LoopId(index32(index));
        if !graph.passes.iter().any(|pass| pass.in_loop.as_ref().is_some_and(|of| of.value == id)) {
            let name = &repeated.item.name;
            found.push(
                Diagnostic::warning(codes::graph::UNUSED, format!("loop `{name}` is not used"))
                    .label(repeated.item.place.clone(), format!("no pass has `loop = \"{name}\"`")),
            );
        }
    }
}
