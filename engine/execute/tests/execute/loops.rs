//! Loops on the device: rounds, names that change places, mips, and the inputs of a pass of a loop.

use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, FrameInputs, Override};
use raxel_graph::checked::{ParamId, Value};

use crate::lab::{Lab, Planned, graph};

/// Each round appends its index as a decimal digit.
const DIGITS: &str = include_str!("../fixtures/loops/digits.toml");

const START: (&str, &str) = (
    "shaders/start.comp",
    r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) writeonly uniform image2D result;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(result)))) imageStore(result, p, vec4(9.0, 0.0, 0.0, 1.0));
}",
);

const APPEND: (&str, &str) = ("shaders/append.comp", include_str!("../fixtures/loops/append.comp"));

#[test]
fn rounds_follow_each_other_whatever_their_number() {
    let mut lab = Lab::new();
    let files = [("graphs/test.toml", DIGITS), START, APPEND];
    // Digits of the rounds behind the first, and the sum of `loop.next`.
    for (count, digits, sum) in [(0, 9.0, 0.0), (1, 90.0, 1.0), (2, 901.0, 3.0), (3, 9012.0, 6.0), (5, 901_234.0, 15.0)]
    {
        let counts = [(ParamId(0), count)];
        lab.load(&files, &Planned { counts: &counts, ..Planned::default() });
        let report = lab.frame();
        assert_eq!(report.dispatched, 1 + count);
        assert_eq!(lab.floats("color", 0, 0, 0)[9], [digits, sum, 0.0, 1.0], "{count} rounds");
        let report = lab.frame();
        assert_eq!((report.dispatched, report.displayed), (0, false), "a still frame dispatches nothing");
    }
    // Downwards: the last digit is that of round 0.
    let down = DIGITS.replace("order = \"up\"", "order = \"down\"");
    lab.load(&[("graphs/test.toml", &down), START, APPEND], &Planned::default());
    lab.frame();
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [9210.0, 6.0, 0.0, 1.0]);
}

/// A value that replaces the graph's, and a pass that is switched off, mean every round.
#[test]
fn what_is_said_to_a_pass_is_said_to_all_of_its_rounds() {
    let mut lab = Lab::new();
    let files = [("graphs/test.toml", DIGITS), START, APPEND];
    let declared = graph(&files);
    let append = declared.find_pass("append").expect("it is there");
    let base = declared.pass(append).push.iter().position(|fill| fill.member == "base").expect("it is pushed") as u32;
    lab.load(&files, &Planned { pinned: &["color"], ..Planned::default() });
    let over = [Override { pass: append, uniform: None, fill: base, value: Value::F32(2.0) }];
    let builtins = Builtins::default();
    let inputs = |overrides, disabled| FrameInputs {
        builtins: &builtins,
        params: &[],
        overrides,
        clock: Moment::START,
        disabled,
    };
    lab.executor.frame(&inputs(&over, &[])).expect("it runs");
    // ((9 · 2 + 0) · 2 + 1) · 2 + 2
    assert_eq!(lab.floats("color", 0, 0, 0)[0][0], 76.0);
    let report = lab.executor.frame(&inputs(&[], &[append])).expect("it runs");
    assert_eq!(report.idle, 3, "every round is left out");
    assert_eq!(lab.floats("color", 0, 0, 0)[0][0], 76.0, "and leaves its result as it is");
}

const PYRAMID: &str = include_str!("../fixtures/loops/pyramid.toml");

const DOWN: (&str, &str) = ("shaders/down.comp", include_str!("../fixtures/loops/down.comp"));

#[test]
fn a_loop_goes_from_mip_to_mip() {
    let mut lab = Lab::new();
    lab.load(
        &[("graphs/test.toml", PYRAMID), START, DOWN, APPEND],
        &Planned { pinned: &["pyramid"], ..Planned::default() },
    );
    assert_eq!(lab.frame().dispatched, 1 + 4 + 1);
    for mip in 0..5 {
        let texels = lab.floats("pyramid", 0, mip, 0);
        assert_eq!(texels.len(), 256 >> (2 * mip));
        assert_eq!(texels[texels.len() - 1][0], 9.0 * f32::from(1_u16 << (2 * mip)), "mip {mip}");
    }
    assert_eq!(lab.floats("color", 0, 0, 0)[0][0], 9.0 * 256.0);
}

/// All rounds run in each tick. A round adds its index and one to the result of the round before, and the next tick continues from there.
const TICKING: &str = include_str!("../fixtures/loops/ticking.toml");

const RELAX: &str = include_str!("../fixtures/loops/relax.comp");

const SHOW_STATE: &str = r"#version 460
layout(local_size_x = 1) in;
layout(r32f) readonly uniform image2D state;
layout(r32f) writeonly uniform image2D result;
void main() { imageStore(result, ivec2(0), imageLoad(state, ivec2(0))); }";

#[test]
fn a_loop_of_a_clock_runs_all_rounds_in_each_tick() {
    let mut lab = Lab::new();
    let files = [("graphs/test.toml", TICKING), ("shaders/relax.comp", RELAX), ("shaders/show.comp", SHOW_STATE)];
    lab.load(&files, &Planned::default());
    let builtins = Builtins::default();
    let at = |lab: &mut Lab, seconds: f64| {
        let inputs = FrameInputs {
            builtins: &builtins,
            params: &[],
            overrides: &[],
            clock: Moment::from(seconds),
            disabled: &[],
        };
        let report = lab.executor.frame(&inputs).unwrap_or_else(|error| panic!("{error}"));
        (report.dispatched, report.idle, lab.floats("color", 0, 0, 0)[0][0])
    };
    // Four rounds add 1 + 2 + 3 + 4, and four times a hundred times the number of the tick.
    let after = |ticks: u32| (0..ticks).map(|tick| 10.0 + 400.0 * tick as f32).sum::<f32>();
    assert_eq!(at(&mut lab, 0.0), (4 + 1, 8, after(1)), "the first frame runs tick 0");
    assert_eq!(at(&mut lab, 0.25), (8 + 1, 4, after(3)), "two ticks are due");
    assert_eq!(at(&mut lab, 0.28), (0, 12, after(3)), "no tick is due, and the picture is in place");
    assert_eq!(at(&mut lab, 0.61), (12 + 1, 0, after(6)), "as many as `most` are caught up with");
    lab.executor.reset_history();
    assert_eq!(at(&mut lab, 0.7), (4 + 1, 8, after(1)), "a reset starts over");
}
