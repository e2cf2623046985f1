//! Random graphs, planned and judged.
#![allow(missing_docs, reason = "a test")]

mod checker;

use checker::graphs::{Random, case, text};
use checker::sync::{self, Run};

/// Graphs of the normal test run.
const GRAPHS: u64 = 3000;

fn planned(seed: u64) -> Option<(checker::graphs::Case, raxel_graph::plan::Plan)> {
    let case = case(seed);
    match case.plan() {
        Ok(plan) => Some((case, plan)),
        // A target that is too small for its mips is refused.
        Err(found) => {
            assert!(found.iter().all(|d| matches!(d.code.as_str(), "RX0172" | "RX0179")), "seed {seed}: {found:?}");
            None
        }
    }
}

#[test]
fn every_plan_is_right() {
    let (mut passes, mut barriers, mut placed, mut culled) = (0, 0, 0, 0);
    for seed in 0..GRAPHS {
        let Some((case, plan)) = planned(seed) else { continue };
        let faults = checker::faults(&case, &plan);
        assert!(faults.is_empty(), "seed {seed}\n{}\n{:#?}\n{faults:#?}", text(&case), plan.steps);
        passes += plan.passes.len();
        culled += plan.culled.len();
        barriers += plan.steps.iter().filter(|s| matches!(s, raxel_graph::plan::Step::Barrier(_))).count();
        placed += plan.blocks.len();
    }
    // The random graphs are worth the trouble.
    let enough = passes > 5000 && culled > 500 && barriers > 5000 && placed > 300;
    assert!(enough, "{passes} passes, {culled} culled, {barriers} barriers, {placed} blocks");
}

#[test]
fn nothing_can_be_removed() {
    for seed in 0..GRAPHS / 3 {
        let Some((case, plan)) = planned(seed) else { continue };
        let run = Run::short(&plan, case.memory.granularity);
        for (what, less) in sync::with_one_less(&plan) {
            let faults = sync::faults(&less, &run);
            assert!(!faults.is_empty(), "seed {seed}: {what} is as good\n{}\n{:#?}", text(&case), plan.steps);
        }
    }
}

#[test]
fn passes_may_be_left_out() {
    for seed in 0..GRAPHS / 3 {
        let Some((case, plan)) = planned(seed) else { continue };
        for chance in [20, 60, 95] {
            let skip = move |frame: u32, pass: u32| {
                Random::new(seed << 20 | u64::from(frame) << 10 | u64::from(pass)).percent(chance)
            };
            let run = Run { skip: Box::new(skip), ..Run::full(&plan, case.memory.granularity) };
            let faults = sync::faults(&plan, &run);
            assert!(faults.is_empty(), "seed {seed}\n{}\n{:#?}\n{faults:#?}", text(&case), plan.steps);
        }
    }
}
