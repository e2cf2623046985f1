//! A slow, independent judge of plans. It shares no code with the phases. By brute force, it computes sizes, culling, order, memory
//! and synchronisation again from the checked graph, and compares them with the plan.

pub(crate) mod flow;
pub(crate) mod graphs;
pub(crate) mod loops;
pub(crate) mod memory;
pub(crate) mod sizes;
pub(crate) mod sync;

use raxel_graph::plan::Plan;

/// Everything that is wrong with a plan; empty for a right one.
pub(crate) fn faults(case: &graphs::Case, plan: &Plan) -> Vec<String> {
    let mut faults = flow::faults(case, plan);
    if faults.is_empty() {
        faults.extend(sizes::faults(case, plan));
        faults.extend(memory::faults(case, plan));
        for ticks in sync::rhythms(plan) {
            let full = sync::Run::full(plan, case.memory.granularity);
            faults.extend(sync::faults(plan, &sync::Run { ticks, frames: full.frames.max(6), ..full }));
            if !faults.is_empty() {
                break;
            }
        }
    }
    faults
}
