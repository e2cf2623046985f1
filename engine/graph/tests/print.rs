//! Printed plans of graphs written by hand.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use std::fmt::Write as _;

use hand::{Hand, showcase};
use raxel_graph::checked::{Condition, Fact};
use raxel_graph::{Phase, print};
use raxel_shader::format::Format;

#[test]
fn text() {
    insta::assert_snapshot!(print::text(&showcase().plan("color").unwrap()));
}

#[test]
fn text_of_a_chain_that_shares_memory() {
    let mut hand = Hand::new("chain");
    for name in ["a", "b", "c", "d", "e"] {
        hand.target(name, Format::Rgba16f, |_, _| {});
    }
    hand.buffer("list", raxel_graph::checked::BufferSize::Bytes(1 << 16), None);
    hand.pass("first", &["w a"]);
    hand.pass("second", &["s a", "w b"]).subgroup_size = Some(32);
    hand.pass("third", &["s b", "w c"]);
    hand.pass("collect", &["s c", "w list"]);
    hand.pass("fourth", &["r list", "w d"]);
    hand.pass("fifth", &["s d", "w e"]);
    insta::assert_snapshot!(print::text(&hand.plan("e").unwrap()));
}

#[test]
fn a_pass_of_a_clock_counts_once_however_often_it_is_planned() {
    let mut hand = Hand::new("clocked");
    let clock = hand.clock("sim", 4);
    hand.target("state", Format::Rgba16f, |_, history| *history = 1);
    hand.graph.resources[0].clock = Some(clock);
    hand.target("color", Format::Rgba16f, |_, _| {});
    hand.pass("simulate", &["r state@1", "w state"]).every = Some(raxel_graph::checked::Every::Clock(clock));
    hand.pass("shade", &["r state", "w color"]);
    let text = print::text(&hand.plan("color").unwrap());
    assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("2 of 2 passes, ")), "{text}");
}

#[test]
fn a_pass_counts_once_however_many_cases_it_has() {
    let mut hand = Hand::new("cases");
    hand.target("color", Format::Rgba16f, |_, _| {});
    for negated in [false, true] {
        let fact = Fact::WorldHasInstances;
        hand.pass("trace", &["w color"]).when.push(Condition { fact, negated });
    }
    hand.target("unseen", Format::Rgba16f, |_, _| {});
    hand.pass("idle", &["w unseen"]);
    let text = print::text(&hand.plan("color").unwrap());
    assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("1 of 2 passes, ")), "{text}");
}

#[test]
fn json() {
    let json = print::json(&showcase().plan("color").unwrap());
    serde_json::from_str::<serde_json::Value>(&json).unwrap();
    insta::assert_snapshot!(json);
}

#[test]
fn dot() {
    insta::assert_snapshot!(print::dot(&showcase().plan("color").unwrap()));
}

#[test]
fn mermaid() {
    insta::assert_snapshot!(print::mermaid(&showcase().plan("color").unwrap()));
}

#[test]
fn names_cannot_break_a_picture() {
    let mut hand = Hand::new("a \"b\" \\ <c>");
    hand.target("x\"]; y", Format::R32f, |_, _| {});
    hand.pass("\\", &["w x\"]; y"]);
    let plan = hand.plan("x\"]; y").unwrap();
    assert!(print::dot(&plan).contains(r#"label="x\"]; y\n"#), "{}", print::dot(&plan));
    assert!(print::mermaid(&plan).contains("x#quot;]; y"), "{}", print::mermaid(&plan));
}

#[test]
fn every_phase_can_be_dumped() {
    let hand = showcase();
    let mut all = String::new();
    for phase in Phase::ALL {
        let text = hand.with_input("color", |graph, input| raxel_graph::dump(graph, input, *phase)).unwrap();
        let _ = write!(all, "== {}\n{text}", phase.name());
        assert_eq!(Phase::from_name(phase.name()), Some(*phase));
    }
    insta::assert_snapshot!(all);
}
