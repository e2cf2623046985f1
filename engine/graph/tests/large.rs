//! Graphs of a thousand passes, of shapes that invite quadratic and cubic work.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use std::time::Instant;

use hand::Hand;
use raxel_graph::checked::BufferSize;
use raxel_shader::format::Format;

const PASSES: usize = 1000;

fn leaked(text: String) -> &'static str {
    text.leak()
}

fn timed(name: &str, hand: &Hand, shown: &str) {
    let start = Instant::now();
    let plan = hand.plan(shown).unwrap();
    let time = start.elapsed();
    eprintln!("{name}: {} steps in {time:?}", plan.steps.len());
    assert_eq!(plan.passes.len(), PASSES);
    // Hundreds of times the time of a release build, and far below the time of a cubic phase.
    assert!(time.as_secs() < 20, "{name} took {time:?}");
}

#[test]
fn a_thousand_passes_on_one_buffer() {
    let mut hand = Hand::new("one buffer");
    hand.buffer("all", BufferSize::Bytes(1 << 20), None);
    for pass in 0..PASSES {
        hand.pass(leaked(format!("p{pass}")), &["x all"]);
    }
    timed("one buffer", &hand, "all");
}

#[test]
fn a_thousand_targets_that_share_memory() {
    let mut hand = Hand::new("chain");
    for target in 0..PASSES {
        hand.target(&format!("t{target}"), Format::Rgba16f, |_, _| {});
    }
    hand.pass("p0", &["w t0"]);
    for pass in 1..PASSES {
        let binds = [leaked(format!("s t{}", pass - 1)), leaked(format!("w t{pass}"))];
        hand.pass(leaked(format!("p{pass}")), &binds);
    }
    timed("chain", &hand, leaked(format!("t{}", PASSES - 1)));
}

#[test]
fn a_thousand_targets_that_live_to_the_end() {
    let mut hand = Hand::new("wide");
    for target in 0..PASSES {
        hand.target(&format!("t{target}"), Format::R32f, |_, history| *history = u32::from(target % 3 == 0));
    }
    let mut all = vec!["w t999"];
    for pass in 0..PASSES - 1 {
        hand.pass(leaked(format!("p{pass}")), &[leaked(format!("w t{pass}"))]);
        all.push(leaked(format!("s t{pass}")));
    }
    hand.pass("last", &all);
    timed("wide", &hand, "t999");
}

#[test]
fn history_that_hands_life_back_one_frame_at_a_time() {
    let mut hand = Hand::new("ladder");
    for target in 0..PASSES {
        hand.target(&format!("t{target}"), Format::R32f, |_, history| *history = 1);
    }
    hand.pass("p0", &["w t0"]);
    for pass in 1..PASSES {
        let binds = [leaked(format!("s t{}@1", pass - 1)), leaked(format!("w t{pass}"))];
        hand.pass(leaked(format!("p{pass}")), &binds);
    }
    hand.graph.passes.reverse();
    timed("ladder", &hand, "t999");
}
