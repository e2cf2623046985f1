//! The back end: a checked graph in, a plan out, without a device. [`plan`] runs its phases in order; [`dump`](fn@dump) shows the state after one.

mod alias;
mod barriers;
mod cull;
mod describe;
mod dump;
mod lifetimes;
mod limits;
mod memory;
mod needs;
mod order;
mod poison;
mod portable;
mod sizes;
mod unroll;
mod updates;
mod varies;

pub use dump::Phase;
pub use memory::EstimatedMemory;
pub use needs::{Need, needs};
pub use portable::rarely_met;

use std::sync::Arc;

use raxel_diagnostics::Diagnostic;

use self::dump::After;
use crate::back::alias::{Alias, alias};
use crate::back::barriers::{Frame, barriers};
use crate::back::cull::cull;
use crate::back::describe::describe;
use crate::back::lifetimes::{Life, lifetimes};
use crate::back::order::{Action, Instance, Order, order};
use crate::back::poison::poison;
pub use crate::back::sizes::local_size;
use crate::back::sizes::{groups, materials, sizes, specialization};
use crate::back::unroll::unroll;
use crate::back::updates::source_updates;
use crate::back::varies::{uses_history, varies};
use crate::ir::checked::{Graph, ResourceId};
use crate::ir::index::index32;
use crate::ir::plan::{Barrier, ClockPlan, Lifetime, PassPlan, Plan, PlanInput, ResourcePlan, Step};

/// Compiles a checked graph for one output size, present point and state of the conditions. Reports, all at once, the errors that
/// only a size or a device can show.
#[allow(clippy::needless_pass_by_value, reason = "a plan keeps its graph, as it is or written out")]
pub fn plan(graph: Arc<Graph>, input: &PlanInput) -> Result<Plan, Vec<Diagnostic>> {
    bake(&graph, input, &mut |_, _| {})
}

/// The results after a phase, as text: one line for each fact.
#[allow(clippy::needless_pass_by_value, reason = "a plan keeps its graph, as it is or written out")]
pub fn dump(graph: Arc<Graph>, input: &PlanInput, phase: Phase) -> Result<String, Vec<Diagnostic>> {
    let mut text = String::new();
    let done = bake(&graph, input, &mut |after, graph| {
        if after.phase() == phase {
            text = after.text(graph);
        }
    });
    // A graph that does not fit the device can still be looked at up to where it fails.
    if text.is_empty() { done.map(|_| text) } else { Ok(text) }
}

fn bake(
    declared: &Arc<Graph>,
    input: &PlanInput,
    watch: &mut dyn FnMut(&After, &Graph),
) -> Result<Plan, Vec<Diagnostic>> {
    // Everything relative to the output or to the world gets its size.
    let sizes = sizes(declared, input);
    let materials = materials(declared, &input.world);
    watch(&After::Sizes(&sizes), declared);
    limits::check_present(declared, &sizes, input)?;

    // Loops are written out: from here on a frame is a list of passes.
    let (graph, present) = unroll(declared, &sizes, input)?;
    // Outputs that the runtime collects count as read.
    let pinned: Vec<ResourceId> = input.pinned.iter().copied().chain(graph.collected()).collect();
    let input = &PlanInput { present, pinned: &pinned, ..input.clone() };
    let mut watch = |after: &After| watch(after, &graph);
    watch(&After::Unroll(declared));

    // Passes whose results are not used are left out; so are resources that only they use.
    let cull = cull(&graph, &sizes, input);
    watch(&After::Cull(&cull));

    // The live part must fit the device.
    limits::check(&graph, &sizes, &materials, input, &cull)?;
    let mut resources = describe(&graph, &sizes, &cull.used, input.memory);

    // A frame is the file's passes in the order of the file; clears and the present step find their places.
    let mut ordered = order(&graph, &sizes, input, &cull, &[]);
    // A resource that no later frame reads is transient: it matters from its first to its last step only.
    let mut lives = lifetimes(&graph, input, &cull, &ordered);
    // For validation, transient resources are filled before their first use.
    if input.poison {
        let transient =
            |(life, resource): (&Life, &ResourcePlan)| *life != Life::Persistent && resource.clear.is_none();
        let poisoned: Vec<bool> = lives.iter().zip(&resources).map(transient).collect();
        ordered = order(&graph, &sizes, input, &cull, &poisoned);
        lives = lifetimes(&graph, input, &cull, &ordered);
        for (resource, _) in resources.iter_mut().zip(&poisoned).filter(|(_, poisoned)| **poisoned) {
            resource.clear = Some(poison(resource));
        }
    }
    let order = ordered;
    watch(&After::Order(&order, &cull));
    watch(&After::Lifetimes(&lives, &cull));

    // A resource that depends only on params keeps its own memory, so that it survives from frame to frame.
    let varies = varies(&graph, &cull, &order, &lives);
    for (resource, varies) in resources.iter_mut().zip(&varies) {
        resource.varies = *varies;
    }
    watch(&After::Varies(&varies, &cull));
    let uses_history = uses_history(&graph, &cull, &order, &lives);

    // Transient resources whose lives do not overlap share memory.
    let alias = alias(&resources, &lives, input.memory.granularity(), input.alias);
    watch(&After::Alias(&alias, &cull));

    // Conflicting accesses are ordered by as few and as small barriers as there can be.
    let frame = Frame { graph: &graph, order: &order, resources: &resources, lives: &lives, alias: &alias };
    let barriers = barriers(&frame);
    watch(&After::Barriers(&barriers, &order, &cull));

    // The frame becomes one flat list.
    let (steps, clocks) = flatten(&order, barriers, &lives, &alias, &mut resources);
    let passes = (order.passes.iter())
        .map(|&Instance { pass: id, tick }| {
            let pass = graph.pass(id);
            let specialization = specialization(pass, &sizes, &materials);
            let groups = groups(pass, &sizes, &specialization, input.world.extent, &input.limits);
            PassPlan { pass: id, tick, groups, specialization }
        })
        .collect();
    let updates = source_updates(&graph, &cull, input.present);
    Ok(Plan {
        output: input.output,
        present: input.present,
        resources,
        blocks: alias.blocks,
        sizes,
        materials,
        passes,
        clocks,
        culled: cull.culled,
        steps,
        updates,
        uses_history,
        graph,
    })
}

/// Puts each barrier in front of its action, and counts lifetimes and clocks in steps.
fn flatten(
    order: &Order,
    barriers: Vec<Option<Barrier>>,
    lives: &[Life],
    alias: &Alias,
    resources: &mut [ResourcePlan],
) -> (Vec<Step>, Vec<ClockPlan>) {
    let mut steps = Vec::with_capacity(order.actions.len() * 2);
    let mut step_of = Vec::with_capacity(order.actions.len());
    for (action, barrier) in order.actions.iter().zip(barriers) {
        steps.extend(barrier.map(Step::Barrier));
        step_of.push(index32(steps.len()));
        steps.push(match *action {
            Action::Clear(resource, tick) => Step::Clear { resource, tick },
            Action::Copy(resource) => Step::Copy { resource },
            Action::Dispatch(pass) => Step::Dispatch { pass },
            Action::Present => Step::Present,
        });
    }
    for (index, life) in lives.iter().enumerate() {
        if let Life::Transient { first, last } = *life {
            resources[index].lifetime = Lifetime::Transient {
                first: step_of[first as usize],
                last: step_of[last as usize],
                place: alias.places[index],
            };
        }
    }
    let clock = |&(first, end): &(u32, u32)| {
        if first == end {
            return ClockPlan::default();
        }
        ClockPlan { first: step_of[first as usize], end: step_of[end as usize - 1] + 1 }
    };
    let clocks = order.clocks.iter().map(clock).collect();
    (steps, clocks)
}
