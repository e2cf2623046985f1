//! Random graphs, planned and judged.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod checker;

use std::collections::BTreeSet;

use checker::graphs::{case, random, text};
use checker::sync::{self, Run};
use raxel_graph::checked::{Every, Pass};
use raxel_graph::plan::{
    Activation, BlockOffset, CullReason, Culled, Lifetime, Plan, ResourceDesc, ResourcePlan, Step,
};

/// Graphs of the normal test run.
const GRAPHS: u64 = 3000;

fn planned(seed: u64) -> Option<(checker::graphs::Case, Plan)> {
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
        barriers += plan.steps.iter().filter(|s| matches!(s, Step::Barrier(_))).count();
        placed += plan.blocks.len();
    }
    // The random graphs are worth the trouble.
    let enough = passes > 5000 && culled > 500 && barriers > 5000 && placed > 300;
    assert!(enough, "{passes} passes, {culled} culled, {barriers} barriers, {placed} blocks");
}

/// The total resources of plans of many graphs, so that a change of choices is noticed, even a right one.
#[test]
fn what_plans_take_is_known() {
    const AT_ONCE: u64 = 300;
    let figures = [
        "passes",
        "culled",
        "created",
        "varying",
        "looking_back",
        "barriers",
        "gaps",
        "stages",
        "accesses",
        "takeovers",
        "reasons",
        "of_pairs",
        "across_frames",
        "blocks",
        "block_bytes",
        "own_bytes",
    ];
    let mut table = format!("graphs,{}\n", figures.join(","));
    for first in (0..GRAPHS).step_by(AT_ONCE as usize) {
        let mut sums = [0_u64; 16];
        for (_, plan) in (first..first + AT_ONCE).filter_map(planned) {
            let own =
                |resource: &&ResourcePlan| !matches!(resource.lifetime, Lifetime::Transient { place: Some(_), .. });
            let of_plan = [
                plan.passes.len() as u64,
                plan.culled.len() as u64,
                plan.resources.len() as u64,
                plan.resources.iter().filter(|resource| resource.varies).count() as u64,
                u64::from(plan.uses_history),
                plan.blocks.len() as u64,
                plan.blocks.iter().map(|block| block.size).sum(),
                plan.resources.iter().filter(own).map(|resource| resource.memory.size).sum(),
            ];
            for (sum, figure) in sums.iter_mut().zip(of_plan[..5].iter().chain(&[0; 8]).chain(&of_plan[5..])) {
                *sum += figure;
            }
            for (at, step) in (0_u64..).zip(&plan.steps) {
                let Step::Barrier(barrier) = step else { continue };
                let scopes = barrier.memory.iter().chain(barrier.activate.iter().map(|of| &of.dependency));
                let scopes: Vec<_> = scopes.flat_map(|of| [of.src, of.dst]).collect();
                let of_barrier = [
                    1,
                    at,
                    scopes.iter().map(|scope| u64::from(scope.stages.bits().count_ones())).sum(),
                    scopes.iter().map(|scope| u64::from(scope.access.bits().count_ones())).sum(),
                    barrier.activate.len() as u64,
                    barrier.hazards.len() as u64,
                    barrier.hazards.iter().filter(|hazard| hazard.from.is_some() && hazard.to.is_some()).count() as u64,
                    barrier.hazards.iter().filter(|hazard| hazard.wraps).count() as u64,
                ];
                for (sum, figure) in sums[5..].iter_mut().zip(of_barrier) {
                    *sum += figure;
                }
            }
        }
        let sums: Vec<String> = sums.iter().map(u64::to_string).collect();
        table += &format!("{first}..{},{}\n", first + AT_ONCE, sums.join(","));
    }
    insta::assert_snapshot!(table);
}

#[test]
fn nothing_can_be_removed() {
    for seed in 0..GRAPHS / 3 {
        let Some((case, plan)) = planned(seed) else { continue };
        let runs: Vec<Run> = sync::rhythms(&plan)
            .into_iter()
            .map(|ticks| {
                let short = Run::short(&plan, case.memory.granularity);
                // Frames without a tick put off the time when a copy comes round.
                let frames = if plan.graph.clocks.is_empty() { short.frames } else { 2 * short.frames };
                Run { frames, ticks, ..short }
            })
            .collect();
        for (what, less) in sync::with_one_less(&plan) {
            let missed = runs.iter().any(|run| !sync::faults(&less, run).is_empty());
            assert!(missed, "seed {seed}: {what} is as good\n{}\n{:#?}", text(&case), plan.steps);
        }
    }
}

#[test]
fn passes_may_be_left_out() {
    for seed in 0..GRAPHS / 3 {
        let Some((case, plan)) = planned(seed) else { continue };
        let mut rhythms = sync::rhythms(&plan);
        for chance in [20, 60, 95] {
            let Some(ticks) = rhythms.pop().or_else(|| sync::rhythms(&plan).pop()) else { continue };
            let skip = move |frame: u32, pass: u32| {
                random(seed << 20 | u64::from(frame) << 10 | u64::from(pass)).percent(chance)
            };
            let run = Run { skip: Box::new(skip), ticks, ..Run::full(&plan, case.memory.granularity) };
            let faults = sync::faults(&plan, &run);
            assert!(faults.is_empty(), "seed {seed}\n{}\n{:#?}\n{faults:#?}", text(&case), plan.steps);
        }
    }
}

/// The runtime may write sources in front of any frame; nothing that orders this is there for nothing.
#[test]
fn updates_of_sources_are_ordered() {
    let mut noticed = BTreeSet::new();
    let mut asked = BTreeSet::new();
    let runs: [fn(u32) -> bool; 3] = [|_| true, |frame| frame % 2 == 1, |frame| frame % 3 == 0];
    for seed in 0..GRAPHS {
        let Some((case, plan)) = planned(seed) else { continue };
        for updates in runs {
            let run = || Run { updates, ..Run::full(&plan, case.memory.granularity) };
            let faults = sync::faults(&plan, &run());
            assert!(faults.is_empty(), "seed {seed}\n{}\n{:#?}\n{faults:#?}", text(&case), plan.updates);
        }
        for (what, less) in sync::with_smaller_updates(&plan) {
            let run = Run { updates: runs[0], ..Run::full(&plan, case.memory.granularity) };
            if !noticed.contains(&what) && !sync::faults(&less, &run).is_empty() {
                noticed.insert(what.clone());
            }
            asked.insert(what);
        }
    }
    // In one graph, a barrier of the passes may do the same; not in all of them.
    assert_eq!(noticed, asked);
}

/// Loops are written out correctly, and the result is planned like everything else.
#[test]
fn every_plan_of_loops_is_right() {
    let (mut rounds, mut swapped, mut ticking, mut refused, mut graphs) = (0, 0, 0, 0, 0);
    for seed in 0..GRAPHS {
        let Some(mut case) = checker::loops::looped(seed) else { continue };
        let expected = checker::loops::written_out(&case);
        let plan = match case.plan() {
            Ok(plan) => plan,
            Err(found) => {
                let carried = found.iter().any(|d| d.code.as_str() == "RX0195");
                let other = found.iter().all(|d| matches!(d.code.as_str(), "RX0172" | "RX0179"));
                assert!(carried || other, "seed {seed}: {found:?}");
                assert!(!carried || expected.is_err(), "seed {seed}: nothing is carried\n{}", text(&case));
                refused += u32::from(carried);
                continue;
            }
        };
        let (flat, shown) = expected.unwrap_or_else(|_| panic!("seed {seed}: a name is carried\n{}", text(&case)));
        let faults = checker::loops::faults(&flat, shown, &plan);
        assert!(faults.is_empty(), "seed {seed}\n{}\n{:?}\n{faults:#?}", text(&case), case.graph.loops);
        swapped += u32::from(case.graph.loops.iter().any(|repeated| !repeated.swap.is_empty()));
        let of_tick = |pass: &Pass| pass.in_loop.is_some() && matches!(pass.every, Some(Every::Clock(_)));
        ticking += u32::from(case.graph.passes.iter().any(of_tick));
        rounds += flat.passes.len() as i64 - case.graph.passes.len() as i64;
        graphs += 1;
        // From here on it is a graph like any other.
        (case.graph, case.present) = (std::sync::Arc::new(flat), shown);
        let faults = checker::faults(&case, &plan);
        assert!(faults.is_empty(), "seed {seed}\n{}\n{:#?}\n{faults:#?}", text(&case), plan.steps);
        if seed % 3 == 0 {
            let run = Run::short(&plan, case.memory.granularity);
            for (what, less) in sync::with_one_less(&plan) {
                assert!(!sync::faults(&less, &run).is_empty(), "seed {seed}: {what} is as good\n{}", text(&case));
            }
        }
    }
    let enough = graphs > 1500 && rounds > 1000 && swapped > 500 && ticking > 100 && refused > 20;
    assert!(
        enough,
        "{graphs} graphs, {rounds} more passes, {swapped} with swaps, {ticking} with a clock, {refused} refused"
    );
}

/// A way to break a plan; `None` where it cannot be applied.
type Break = fn(&checker::graphs::Case, &Plan) -> Option<Plan>;

/// The judge must be able to say no: each of these leaves no plan right.
#[test]
fn broken_plans_are_found_out() {
    let ways: &[(&str, Break)] = &[
        ("all barriers are gone", |_, plan| Some(edited(plan, |step| !matches!(step, Step::Barrier(_))))),
        ("a clear is gone", |_, plan| {
            let clear = plan.steps.iter().position(|step| matches!(step, Step::Clear { .. }))?;
            Some(without(plan, clear))
        }),
        ("a pass is gone", |_, plan| {
            let last = plan.steps.iter().rposition(|step| matches!(step, Step::Dispatch { .. }))?;
            Some(without(plan, last))
        }),
        ("nothing is shown", |_, plan| Some(edited(plan, |step| *step != Step::Present))),
        ("two passes change places", |_, plan| {
            let mut broken = plan.clone();
            let mut passes = broken.steps.iter_mut().filter(|step| matches!(step, Step::Dispatch { .. }));
            let (a, b) = (passes.next()?, passes.next()?);
            std::mem::swap(a, b);
            Some(broken)
        }),
        ("a barrier is put off until the next one", |_, plan| {
            let mut broken = plan.clone();
            let mut barriers = broken.steps.iter_mut().filter_map(|step| match step {
                Step::Barrier(barrier) if barrier.activate.is_empty() => Some(barrier),
                _ => None,
            });
            let (a, b) = (barriers.next()?, barriers.next()?);
            let moved = std::mem::take(a).memory?;
            let merged = b.memory.get_or_insert_default();
            merged.src.stages |= moved.src.stages;
            merged.src.access |= moved.src.access;
            merged.dst.stages |= moved.dst.stages;
            merged.dst.access |= moved.dst.access;
            Some(broken)
        }),
        ("an image takes over too late", |_, plan| {
            let mut broken = plan.clone();
            let mut taken = None;
            for step in &mut broken.steps {
                if let Step::Barrier(barrier) = step {
                    let image =
                        |a: &Activation| matches!(plan.resources[a.resource as usize].desc, ResourceDesc::Image(_));
                    if let Some(late) = taken {
                        barrier.activate.push(late);
                        return Some(broken);
                    }
                    if let Some(at) = barrier.activate.iter().position(image) {
                        taken = Some(barrier.activate.remove(at));
                    }
                }
            }
            None
        }),
        ("two live resources share bytes", |_, plan| {
            let lives: Vec<_> = (0..plan.resources.len())
                .filter_map(|index| match plan.resources[index].lifetime {
                    Lifetime::Transient { first, last, place: Some(place) } => Some((index, first, last, place)),
                    _ => None,
                })
                .collect();
            let met = |a: &(usize, u32, u32, BlockOffset), b: &(usize, u32, u32, BlockOffset)| {
                a.0 != b.0 && a.3.block == b.3.block && a.1 <= b.2 && b.1 <= a.2
            };
            let (a, b) = lives.iter().find_map(|a| Some((a, lives.iter().find(|b| met(a, b))?)))?;
            let mut broken = plan.clone();
            if let Lifetime::Transient { place: Some(place), .. } = &mut broken.resources[a.0].lifetime {
                place.offset = b.3.offset;
            }
            Some(broken)
        }),
        ("what is shown is forgotten", |_, plan| {
            let mut broken = plan.clone();
            let shown = broken.resources.iter_mut().find(|r| r.resource == plan.present.resource)?;
            shown.lifetime = Lifetime::Transient { first: 0, last: plan.steps.len() as u32 - 1, place: None };
            Some(broken)
        }),
        ("a pass that is needed is culled", |_, plan| {
            let mut broken = plan.clone();
            let pass = broken.passes.pop()?.pass;
            broken.culled.push(Culled { pass, reason: CullReason::Unused });
            let gone = broken.passes.len() as u32;
            broken.steps.retain(|step| *step != Step::Dispatch { pass: gone });
            Some(broken)
        }),
    ];
    for (what, way) in ways {
        let mut tried = 0;
        for seed in 0..GRAPHS / 3 {
            let Some((case, plan)) = planned(seed) else { continue };
            // Without a barrier there is nothing to remove.
            if !plan.steps.iter().any(|step| matches!(step, Step::Barrier(_))) {
                continue;
            }
            let Some(broken) = way(&case, &plan) else { continue };
            tried += 1;
            let faults = checker::faults(&case, &broken);
            assert!(!faults.is_empty(), "seed {seed}: {what}, and nobody sees it\n{}\n{:#?}", text(&case), plan.steps);
        }
        assert!(tried > 20, "{what}: tried on {tried} graphs only");
    }
}

fn edited(plan: &Plan, keep: impl Fn(&Step) -> bool) -> Plan {
    let mut broken = plan.clone();
    broken.steps.retain(keep);
    broken
}

fn without(plan: &Plan, step: usize) -> Plan {
    let mut broken = plan.clone();
    broken.steps.remove(step);
    broken
}
