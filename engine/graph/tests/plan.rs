//! Plans of graphs written by hand: one claim a test.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use hand::Hand;
use raxel_graph::checked::{BufferSize, Clear, Condition, Every, Fact, Origin};
use raxel_graph::plan::{AccessMask, Barrier, CullReason, Dependency, HazardKind, Lifetime, Plan, Scope, Stages, Step};
use raxel_shader::format::Format;
use raxel_shader::interface::Access;

fn live(plan: &Plan) -> Vec<&str> {
    plan.passes.iter().map(|pass| plan.graph.pass(pass.pass).name.as_str()).collect()
}

fn barriers(plan: &Plan) -> Vec<&Barrier> {
    plan.steps.iter().filter_map(|step| if let Step::Barrier(barrier) = step { Some(barrier) } else { None }).collect()
}

fn lifetime(plan: &Plan, name: &str) -> Lifetime {
    let id = plan.graph.find_resource(name).unwrap();
    plan.resources.iter().find(|resource| resource.resource == id).unwrap().lifetime
}

fn targets(names: &[&str]) -> Hand {
    let mut hand = Hand::new("test");
    for name in names {
        hand.target(name, Format::Rgba16f, |_, _| {});
    }
    hand
}

#[test]
fn two_readers_share_one_barrier() {
    let mut hand = targets(&["hit", "near", "far", "color"]);
    hand.pass("primary", &["w hit"]);
    hand.pass("near", &["s hit", "w near"]);
    hand.pass("far", &["s hit", "w far"]);
    hand.pass("shade", &["s near", "s far", "w color"]);
    let plan = hand.plan("color").unwrap();
    // primary | near far | shade | present: what follows in the next frame is ordered by these too.
    assert_eq!(barriers(&plan).len(), 3);
    assert!(matches!(plan.steps[3], Step::Dispatch { pass: 2 }));
}

#[test]
fn one_chain_needs_no_barrier_between_frames() {
    let mut hand = targets(&["a", "b"]);
    hand.alias = false;
    hand.pass("first", &["w a"]);
    hand.pass("second", &["r a", "w b"]);
    let plan = hand.plan("b").unwrap();
    let write = AccessMask::SHADER_STORAGE_WRITE;
    let dependency = |to: AccessMask| {
        let scope = |access| Scope { stages: Stages::COMPUTE_SHADER, access };
        Some(Dependency { src: scope(write), dst: scope(to) })
    };
    let memory: Vec<_> = barriers(&plan).iter().map(|barrier| barrier.memory).collect();
    assert_eq!(
        memory,
        [dependency(AccessMask::SHADER_STORAGE_READ | write), dependency(AccessMask::SHADER_SAMPLED_READ)]
    );
    assert!(matches!(plan.steps[0], Step::Dispatch { .. }));
}

#[test]
fn mips_are_ordered_one_by_one() {
    let mut hand = Hand::new("pyramid");
    hand.target("pyramid", Format::R32f, |target, _| target.mips = 3);
    hand.pass("base", &["w pyramid:0"]);
    hand.pass("down1", &["r pyramid:0", "w pyramid:1"]);
    hand.pass("side", &["w pyramid:2"]);
    let plan = hand.plan("pyramid").unwrap();
    // Only mip 0 is shown, so nothing else runs.
    assert_eq!(live(&plan), ["base"]);
    hand.pinned = vec!["pyramid"];
    let plan = hand.plan("pyramid").unwrap();
    assert_eq!(live(&plan), ["base", "down1", "side"]);
    // base | down1 side present |: down1 and side touch different mips, so nothing stands between them.
    assert_eq!(barriers(&plan).len(), 2);
    assert!(matches!(plan.steps[2..], [Step::Barrier(_), Step::Dispatch { pass: 1 }, Step::Dispatch { pass: 2 }, ..]));
}

#[test]
fn history_keeps_its_writer_and_its_own_copies() {
    let mut hand = targets(&["noisy"]);
    hand.target("color", Format::Rgba16f, |_, history| *history = 2);
    hand.pass("noise", &["w noisy"]);
    hand.pass("accumulate", &["s noisy", "s color@2", "w color"]);
    let plan = hand.plan("color").unwrap();
    let color = plan.graph.find_resource("color").unwrap();
    let copies: Vec<_> = plan.resources.iter().map(|resource| resource.copies).collect();
    assert_eq!(copies, [1, 3]);
    assert_eq!(lifetime(&plan, "color"), Lifetime::Persistent);
    let wraps = |barrier: &&Barrier| {
        let across =
            |h: &raxel_graph::plan::Hazard| h.resource == color && h.wraps && h.kind == HazardKind::ReadAfterWrite;
        barrier.hazards.iter().any(across)
    };
    assert_eq!(barriers(&plan).into_iter().filter(wraps).count(), 1);
}

#[test]
fn a_view_in_the_middle_keeps_what_later_frames_need() {
    let mut hand = targets(&["a", "b"]);
    hand.target("sum", Format::R32f, |_, history| *history = 1);
    hand.pass("first", &["s sum@1", "w a"]);
    hand.pass("second", &["s a", "w b"]);
    hand.pass("accumulate", &["s b", "w sum"]);
    hand.pass("shade", &["s sum", "w a"]);
    hand.after = Some("first");
    let plan = hand.plan("a").unwrap();
    // `shade` only matters to this frame's end, which is not shown; the others feed `sum@1` of the next frame.
    assert_eq!(live(&plan), ["first", "second", "accumulate"]);
    let present = plan.steps.iter().position(|step| *step == Step::Present).unwrap();
    assert!(plan.steps[present..].contains(&Step::Dispatch { pass: 1 }));
}

#[test]
fn a_store_behind_one_of_now_and_then_makes_nothing_anew() {
    // `now` may add to what `rare` has stored in an earlier frame, so what `late` stores counts in the next frame, too.
    let mut hand = targets(&["t"]);
    hand.pass("rare", &["w t"]).every = Some(Every::Frames(3));
    hand.pass("now", &["w t"]);
    hand.pass("late", &["w t"]);
    hand.after = Some("now");
    assert_eq!(live(&hand.plan("t").unwrap()), ["rare", "now", "late"]);
    // Made in each frame, it holds nothing of the last one.
    hand.graph.passes[0].every = None;
    assert_eq!(live(&hand.plan("t").unwrap()), ["rare", "now"]);
}

#[test]
fn a_view_before_the_first_store_shows_the_whole_last_frame() {
    // `late` runs for `pinned` anyway; what `second` adds to `t` is seen in the next frame alone.
    let mut hand = targets(&["a", "t", "pinned"]);
    hand.pass("early", &["w a"]);
    hand.pass("late", &["w t", "w pinned"]);
    hand.pass("second", &["w t"]);
    hand.pinned = vec!["pinned"];
    hand.after = Some("early");
    assert_eq!(live(&hand.plan("t").unwrap()), ["late", "second"]);
    // Behind the store that replaces it, nothing of the last frame is seen.
    hand.after = Some("late");
    assert_eq!(live(&hand.plan("t").unwrap()), ["late"]);
}

#[test]
fn clears_and_copies_are_ordered_with_passes() {
    let mut hand = targets(&["color"]);
    hand.alias = false;
    hand.buffer("sum", BufferSize::Bytes(64), Some(0));
    for (name, origin) in [("world", Origin::Source(Access::ReadWrite)), ("copy", Origin::Copy)] {
        hand.buffer(name, BufferSize::Source("world.tree64".to_owned()), None);
        hand.graph.resources.last_mut().unwrap().origin = origin;
    }
    hand.pass("edit", &["x world", "x sum"]);
    hand.pass("shade", &["r copy", "r sum", "w color"]);
    let plan = hand.plan("color").unwrap();
    let orders = |from: AccessMask, to: AccessMask| {
        let memory = barriers(&plan).into_iter().filter_map(|barrier| barrier.memory);
        memory.into_iter().any(|memory| memory.src.access.contains(from) && memory.dst.access.contains(to))
    };
    let stored = AccessMask::SHADER_STORAGE_WRITE;
    assert!(
        orders(AccessMask::TRANSFER_WRITE, AccessMask::SHADER_STORAGE_READ),
        "`sum` is cleared before it is loaded"
    );
    assert!(orders(stored, AccessMask::TRANSFER_WRITE), "`sum` is stored in the frame before it is cleared");
    assert!(orders(stored, AccessMask::TRANSFER_READ), "`world` is stored before it is copied");
}

#[test]
fn a_view_after_a_culled_pass_stays_where_the_pass_was() {
    let mut hand = targets(&["a", "b"]);
    hand.pass("first", &["w a"]);
    hand.pass("other", &["w b"]);
    hand.pass("again", &["w a"]);
    hand.after = Some("other");
    let plan = hand.plan("a").unwrap();
    assert_eq!(live(&plan), ["first"]);
    assert_eq!(plan.culled.len(), 2);
    assert!(plan.culled.iter().all(|culled| culled.reason == CullReason::Unused));
}

#[test]
fn a_pass_that_is_off_leaves_its_outputs_alone() {
    let mut hand = targets(&["glow", "color"]);
    hand.facts = false;
    hand.pass("glow", &["w glow"]).when = vec![Condition { fact: Fact::WorldHasEmission, negated: false }];
    hand.pass("shade", &["s glow", "w color"]);
    let plan = hand.plan("color").unwrap();
    assert_eq!(live(&plan), ["shade"]);
    assert_eq!(plan.culled[0].reason, CullReason::Condition);
    assert_eq!(lifetime(&plan, "glow"), Lifetime::Persistent);
    hand.graph.passes[0].when[0].negated = true;
    assert_eq!(live(&hand.plan("color").unwrap()), ["glow", "shade"]);
}

#[test]
fn what_a_pass_leaves_for_other_frames_persists() {
    let mut hand = targets(&["slow", "half", "color"]);
    hand.pass("slow", &["w slow"]).every = Some(Every::Hz(20.0));
    hand.pass("half", &["x half"]);
    hand.pass("shade", &["s slow", "s half", "w color"]);
    let plan = hand.plan("color").unwrap();
    for name in ["slow", "half", "color"] {
        assert_eq!(lifetime(&plan, name), Lifetime::Persistent, "{name}");
    }
    // A clear makes `half` a matter of one frame.
    if let raxel_graph::checked::ResourceKind::Target(target) = &mut hand.graph.resources[1].kind {
        target.clear = Some(Clear::Float([0.0; 4]));
    }
    let plan = hand.plan("color").unwrap();
    assert!(matches!(lifetime(&plan, "half"), Lifetime::Transient { .. }));
    assert!(matches!(plan.steps[0], Step::Dispatch { .. } | Step::Barrier(_)));
}

#[test]
fn targets_of_different_times_share_memory() {
    let mut hand = targets(&["a", "b", "c", "color"]);
    hand.pass("first", &["w a"]);
    hand.pass("second", &["s a", "w b"]);
    hand.pass("third", &["s b", "w c"]);
    hand.pass("shade", &["s c", "w color"]);
    let plan = hand.plan("color").unwrap();
    let places = |name| match lifetime(&plan, name) {
        Lifetime::Transient { place, .. } => place,
        Lifetime::Persistent => None,
    };
    assert_eq!(plan.blocks.len(), 1);
    assert_eq!(places("a"), places("c"));
    assert!(places("a").is_some());
    // `b` lives beside both, so it shares memory with neither. `color` is shown.
    assert_eq!(places("b"), None);
    assert_eq!(lifetime(&plan, "color"), Lifetime::Persistent);
    let activated: usize = barriers(&plan).iter().map(|barrier| barrier.activate.len()).sum();
    assert_eq!(activated, 2);
    hand.alias = false;
    assert!(hand.plan("color").unwrap().blocks.is_empty());
    hand.alias = true;
    hand.pinned = vec!["a"];
    assert!(hand.plan("color").unwrap().blocks.is_empty());
}

#[test]
fn indirect_arguments_wait_at_their_own_stage() {
    let mut hand = targets(&["color"]);
    hand.buffer("args", BufferSize::Bytes(12), None);
    hand.pass("count", &["w args"]);
    hand.pass("draw", &["i args", "w color"]);
    let plan = hand.plan("color").unwrap();
    let memory = barriers(&plan)[0].memory.unwrap();
    assert_eq!(memory.dst.stages, Stages::DRAW_INDIRECT | Stages::COMPUTE_SHADER);
    assert!(memory.dst.access.contains(AccessMask::INDIRECT_COMMAND_READ));
}

#[test]
fn descriptions_do_not_change_with_what_is_shown() {
    let mut hand = targets(&["hit", "color"]);
    hand.pass("primary", &["w hit"]);
    hand.pass("shade", &["r hit", "w color"]);
    let (hit, color) = (hand.plan("hit").unwrap(), hand.plan("color").unwrap());
    assert_eq!(hit.resources[0].desc, color.resources[0].desc);
    assert_eq!(live(&hit), ["primary"]);
}
