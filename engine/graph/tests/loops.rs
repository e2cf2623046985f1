//! Loops written out: order, names, mips, names that change places.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use hand::Hand;
use raxel_graph::checked::*;
use raxel_graph::plan::{Plan, PlanInput, Present, Step};
use raxel_shader::format::Format;

fn repeated(hand: &mut Hand, name: &str, rounds: Rounds, swap: &[[&str; 2]]) -> LoopId {
    let id = |name: &&str| hand.graph.find_resource(name).expect("a resource of that name");
    let swap = swap.iter().map(|[a, b]| [id(a), id(b)]).collect();
    let place = raxel_diagnostics::Span::new("graphs/hand.toml", 0..0);
    hand.graph.loops.push(Loop { name: name.to_owned(), rounds, down: false, swap, place });
    LoopId(hand.graph.loops.len() as u32 - 1)
}

fn inside(of: LoopId) -> InLoop {
    InLoop { of, mips: Vec::new(), dispatch_mip: None }
}

/// Each live pass with the resources that it accesses, in the order of its binds.
fn passes(plan: &Plan) -> Vec<String> {
    let name = |access: &BoundAccess| {
        let mip = if access.mips == Interval::ALL { String::new() } else { format!(":{}", access.mips.first) };
        let age = if access.age == 0 { String::new() } else { format!("@{}", access.age) };
        format!("{}{age}{mip}", plan.graph.resource(access.resource).name)
    };
    let shown = |pass: &Pass| format!("{} {}", pass.name, pass.accesses.iter().map(name).collect::<Vec<_>>().join(" "));
    plan.passes.iter().map(|pass| shown(plan.graph.pass(pass.pass))).collect()
}

/// The labels of an error.
fn labels(found: &raxel_diagnostics::Diagnostic) -> Vec<&str> {
    found.labels.iter().map(|label| label.text.as_str()).collect()
}

/// `start` writes a; the loop reads a and writes b; `finish` reads a.
fn relaxing(rounds: u32) -> Hand {
    let mut hand = Hand::new("relaxing");
    for name in ["a", "b", "color"] {
        hand.target(name, Format::Rgba16f, |_, _| {});
    }
    let relax = repeated(&mut hand, "relax", Rounds::Fixed(rounds), &[["a", "b"]]);
    hand.pass("start", &["w a"]);
    hand.pass("relax", &["r a", "w b"]).in_loop = Some(inside(relax));
    hand.pass("finish", &["r a", "w color"]);
    hand
}

#[test]
fn names_change_places_after_each_round() {
    // At the end of a frame every name stands for itself; what an odd number of swaps comes behind stores to the other.
    let even = ["start a", "relax[0] a b", "relax[1] b a", "finish a color"];
    assert_eq!(passes(&relaxing(2).plan("color").unwrap()), even);
    let odd = ["start b", "relax[0] b a", "relax[1] a b", "relax[2] b a", "finish a color"];
    assert_eq!(passes(&relaxing(3).plan("color").unwrap()), odd);
    assert_eq!(passes(&relaxing(0).plan("color").unwrap()), ["start a", "finish a color"]);
    // The result is called `a`, for every reader.
    assert_eq!(passes(&relaxing(1).plan("a").unwrap()), ["start b", "relax[0] b a"]);
    let culled: Vec<_> = relaxing(2).plan("b").unwrap().culled.iter().map(|culled| culled.pass.0).collect();
    assert_eq!(culled, [2, 3], "`b` is what the last round but one gave: `relax[1]` only read it");
}

#[test]
fn plans_lead_back_to_the_passes_of_the_file() {
    let plan = relaxing(3).plan("color").unwrap();
    let declared: Vec<u32> = plan.passes.iter().map(|pass| plan.graph.declared(pass.pass).0).collect();
    assert_eq!(declared, [0, 1, 1, 1, 2]);
    let rounds: Vec<_> = plan.passes.iter().map(|pass| plan.graph.pass(pass.pass).round.unwrap().index).collect();
    assert_eq!(rounds, [None, Some(0), Some(1), Some(2), None]);
    // A present point after a pass of a loop is after its last round, under the name that it has there.
    let mut hand = relaxing(3);
    hand.after = Some("relax");
    let plan = hand.plan("b").unwrap();
    assert_eq!(plan.graph.pass(plan.present.after.unwrap()).name, "relax[2]");
    assert_eq!(plan.graph.resource(plan.present.resource).name, "a", "what the last round calls `b`");
    // A round that is named is the one.
    hand.with_input("b", |graph, input| {
        let present = Present { round: Some(1), ..input.present };
        let plan = raxel_graph::plan(graph, &PlanInput { present, ..*input }).unwrap();
        assert_eq!(plan.graph.pass(plan.present.after.unwrap()).name, "relax[1]");
    });
    // Without a round it is taken after the pass before.
    let mut hand = relaxing(0);
    hand.after = Some("relax");
    let plan = hand.plan("a").unwrap();
    assert_eq!(plan.graph.pass(plan.present.after.unwrap()).name, "start");
}

#[test]
fn counts_follow_params_and_mips() {
    let mut hand = relaxing(0);
    let place = raxel_diagnostics::Span::new("graphs/hand.toml", 0..0);
    hand.graph.params.push(Param { range: Some([0.0, 8.0]), ..Param::new("rounds", Value::I32(1), place) });
    hand.graph.loops[0].rounds = Rounds::Param(ParamId(0));
    assert_eq!(passes(&hand.plan("color").unwrap()).len(), 3, "the default");
    hand.counts = vec![(ParamId(0), 4)];
    assert_eq!(passes(&hand.plan("color").unwrap()).len(), 6);

    // A pyramid of 320 × 180 has 9 mips: 8 steps down, and 8 up again.
    let mut hand = Hand::new("pyramid");
    hand.target("pyramid", Format::Rgba16f, |target, _| target.mips = 0).target("color", Format::Rgba16f, |_, _| {});
    let pyramid = hand.graph.find_resource("pyramid").unwrap();
    let down = repeated(&mut hand, "down", Rounds::Mips(pyramid), &[]);
    let up = repeated(&mut hand, "up", Rounds::Mips(pyramid), &[]);
    hand.graph.loops[1].down = true;
    hand.pass("base", &["w pyramid:0"]);
    let mips = vec![(0, RoundIndex::Index), (1, RoundIndex::Next)];
    let dispatch_mip = Some(RoundIndex::Next);
    hand.pass("down", &["r pyramid:0", "w pyramid:1"]).in_loop =
        Some(InLoop { of: down, mips: mips.clone(), dispatch_mip });
    let dispatch_mip = Some(RoundIndex::Index);
    let back = hand.pass("up", &["x pyramid:0", "r pyramid:1"]);
    back.in_loop = Some(InLoop { of: up, mips, dispatch_mip });
    let number = Fill {
        member: "round".to_owned(),
        offset: 0,
        ty: raxel_graph::ValueType::scalar(raxel_shader::interface::Scalar::U32),
        stride: 0,
        from: ValueOrigin::Round(RoundIndex::Index),
    };
    back.push = vec![number];
    back.specialization = vec![(0, ValueOrigin::Round(RoundIndex::Index))];
    hand.pass("show", &["r pyramid:0", "w color"]);
    let plan = hand.plan("color").unwrap();
    let order = passes(&plan);
    assert_eq!(order.len(), 1 + 8 + 8 + 1);
    assert_eq!(
        order[1..4],
        ["down[0] pyramid:0 pyramid:1", "down[1] pyramid:1 pyramid:2", "down[2] pyramid:2 pyramid:3"]
    );
    assert_eq!(order[8..11], ["down[7] pyramid:7 pyramid:8", "up[7] pyramid:7 pyramid:8", "up[6] pyramid:6 pyramid:7"]);
    assert_eq!(order[16], "up[0] pyramid:0 pyramid:1");
    // 20 × 12 texels of mip 4, 8 × 8 a workgroup.
    let of = |name: &str| plan.passes.iter().find(|pass| plan.graph.pass(pass.pass).name == name).unwrap();
    assert_eq!(of("down[3]").groups, Some([3, 2, 1]));
    assert_eq!(plan.graph.pass(of("up[6]").pass).push[0].from, ValueOrigin::Value(Value::U32(6)));
    assert_eq!(plan.graph.pass(of("up[6]").pass).specialization, [(0, ValueOrigin::Value(Value::U32(6)))]);
    // If a round wants a mip that is not there, the message names the round.
    hand.graph.loops[1].rounds = Rounds::Fixed(9);
    let found = hand.plan("color").unwrap_err();
    assert_eq!(found[0].message, "pass `up[8]` binds mip 9 of `pyramid`, which has 9");
}

#[test]
fn what_is_carried_from_frame_to_frame_needs_an_even_number_of_swaps() {
    let carried = |rounds: u32| {
        let mut hand = relaxing(rounds);
        // No pass makes `a` from scratch: each frame continues from the last.
        hand.graph.passes.remove(0);
        hand
    };
    assert!(carried(4).plan("color").is_ok());
    let found = carried(3).plan("color").unwrap_err();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].code.as_str(), "RX0195");
    assert_eq!(
        found[0].message,
        "`a` changes places an odd number of times in a frame, but is carried from frame to frame"
    );
    assert_eq!(labels(&found[0]).last(), Some(&"3 rounds, with a swap after each"));
    // The loop that swaps it is the one that is shown, and no other.
    let mut other = carried(1);
    for name in ["c", "d"] {
        other.target(name, Format::Rgba16f, |_, _| {});
    }
    let last = repeated(&mut other, "other", Rounds::Fixed(2), &[["c", "d"]]);
    other.graph.loops.swap(0, 1);
    other.graph.passes[0].in_loop = Some(inside(last));
    assert_eq!(labels(&other.plan("color").unwrap_err()[0]).last(), Some(&"1 round, with a swap after each"));
    // A clear replaces it.
    let mut cleared = carried(3);
    for resource in &mut cleared.graph.resources[..2] {
        if let ResourceKind::Target(target) = &mut resource.kind {
            target.clear = Some(Clear::Float([0.0; 4]));
        }
    }
    assert!(cleared.plan("color").is_ok());
    // A loop that is switched off swaps nothing.
    let mut off = carried(3);
    off.facts = false;
    off.graph.passes[0].when = vec![Condition { fact: Fact::WorldHasVoxels, negated: false }];
    assert_eq!(passes(&off.plan("color").unwrap()), ["finish a color"]);
}

/// `relaxing`, all of it but `finish` run by a clock of at most two ticks a frame.
fn ticking(rounds: u32) -> Hand {
    let mut hand = relaxing(rounds);
    let clock = hand.clock("sim", 2);
    for pass in &mut hand.graph.passes[..2] {
        pass.every = Some(Every::Clock(clock));
    }
    hand
}

#[test]
fn a_tick_runs_all_rounds() {
    let mut hand = ticking(2);
    for resource in &mut hand.graph.resources[..2] {
        resource.clock = Some(ClockId(0));
        if let ResourceKind::Target(target) = &mut resource.kind {
            target.clear = Some(Clear::Float([0.0; 4]));
        }
    }
    let plan = hand.plan("color").unwrap();
    let tick = ["start a", "relax[0] a b", "relax[1] b a"];
    assert_eq!(passes(&plan), [&tick[..], &tick[..], &["finish a color"]].concat());
    let ticks: Vec<Option<u32>> = plan.passes.iter().map(|pass| pass.tick).collect();
    assert_eq!(ticks, [Some(0), Some(0), Some(0), Some(1), Some(1), Some(1), None]);
    let clears: Vec<(u32, Option<u32>)> = (plan.steps.iter())
        .filter_map(|step| if let Step::Clear { resource, tick } = step { Some((*resource, *tick)) } else { None })
        .collect();
    assert_eq!(clears, [(0, Some(0)), (1, Some(0)), (0, Some(1)), (1, Some(1))], "once a tick, not once a round");
}

#[test]
fn a_loop_that_not_every_frame_runs_leaves_names_where_they_were() {
    let refused = |hand: &Hand| {
        let found = hand.plan("color").unwrap_err();
        assert!(found.len() == 1 && found[0].code.as_str() == "RX0195", "{found:?}");
        found[0].message.clone()
    };
    assert!(ticking(4).plan("color").is_ok());
    assert_eq!(refused(&ticking(3)), "`a` and `b` change places an odd number of times in each tick of clock `sim`");
    // Without a running pass nothing changes places.
    let mut off = ticking(3);
    off.facts = false;
    off.graph.passes[1].when = vec![Condition { fact: Fact::WorldHasVoxels, negated: false }];
    assert!(off.plan("color").is_ok());
    let rare = |rounds: u32| {
        let mut hand = relaxing(rounds);
        hand.graph.passes[1].every = Some(Every::Frames(3));
        hand
    };
    assert!(rare(2).plan("color").is_ok());
    assert_eq!(
        refused(&rare(3)),
        "`a` and `b` change places an odd number of times in loop `relax`, which not every frame runs"
    );
    // A resource that is made only now and then is carried through the other frames.
    let mut made = relaxing(3);
    made.graph.passes[0].every = Some(Every::Frames(3));
    assert_eq!(
        refused(&made),
        "`a` changes places an odd number of times in a frame, but is carried from frame to frame"
    );
}

/// The frames of a plan without loops are as they ever were: not even the graph is another.
#[test]
fn a_graph_without_loops_is_planned_as_it_is() {
    let hand = hand::showcase();
    hand.with_input("color", |graph, input| {
        let plan = raxel_graph::plan(graph.clone(), input).unwrap();
        assert!(std::sync::Arc::ptr_eq(&plan.graph, &graph));
        assert_eq!(plan.graph.declared(plan.passes[2].pass), plan.passes[2].pass);
    });
}
