//! Clocks: passes that catch up ticks, what turns with them, and frames without a tick.

use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, FrameInputs, FrameReport};

use crate::lab::{Lab, Planned};

/// `count` adds the number of the tick to what the tick before left; `trail` notes the last four; `show` reads both from outside.
const GRAPH: &str = include_str!("../fixtures/clocks/clocks.toml");

const COUNT: &str = include_str!("../fixtures/clocks/count.comp");

const MARK: &str = r"#version 460
layout(local_size_x = 1) in;
layout(r32f) uniform image2D mark;
layout(r32f) readonly uniform image2D sum;
void main() { imageStore(mark, ivec2(0), imageLoad(mark, ivec2(0)) + imageLoad(sum, ivec2(0))); }";

const SHOW: &str = include_str!("../fixtures/clocks/show.comp");

const FILES: [(&str, &str); 4] = [
    ("graphs/test.toml", GRAPH),
    ("shaders/count.comp", COUNT),
    ("shaders/mark.comp", MARK),
    ("shaders/show.comp", SHOW),
];

fn at(lab: &mut Lab, seconds: f64) -> FrameReport {
    let builtins = Builtins { frame_time: seconds as f32, ..Builtins::default() };
    let inputs =
        FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock: Moment::from(seconds), disabled: &[] };
    lab.executor.frame(&inputs).unwrap_or_else(|error| panic!("{error}"))
}

/// The readers' view outside when tick `last` was the last: the sum, the last three ticks, the mark, the number of the tick.
fn seen(last: u32) -> [f32; 4] {
    let sum = (last * (last + 1) / 2) as f32;
    let tick = |back: u32| if last >= back { (last - back) as f32 + 0.1 } else { 0.0 };
    [sum, tick(0) * 10000.0 + tick(1) * 100.0 + tick(2), 100.0 + sum, last as f32]
}

#[test]
fn a_frame_catches_up_and_readers_see_the_last_tick() {
    for memo in [true, false] {
        let mut lab = Lab::new();
        lab.load(&FILES, &Planned { pinned: &["before", "sum", "last"], ..Planned::default() });
        lab.executor.set_memo(memo);
        // Seconds, ticks that run, the last tick.
        let frames =
            [(0.0, 1, 0), (0.05, 0, 0), (0.1, 1, 1), (0.3, 2, 3), (0.3, 0, 3), (1.0, 3, 6), (1.1, 1, 7), (1.19, 0, 7)];
        let mut before = None;
        for (seconds, ticks, last) in frames {
            let report = at(&mut lab, seconds);
            let idle = 2 * (3 - ticks);
            assert_eq!(report.idle, idle, "at {seconds}");
            if memo && ticks == 0 {
                // The view of `early` follows a frame late: it sees the ticks of this frame in the next one.
                assert!(report.dispatched <= 1, "at {seconds}: {report:?}");
            }
            let color = lab.floats("color", 0, 0, 0)[0];
            assert_eq!(color, seen(last), "at {seconds}");
            assert_eq!(lab.floats("last", 0, 0, 0)[0][0], last as f32 + 0.1);
            assert_eq!(lab.floats("sum", 0, 0, 0)[0][0], seen(last)[0]);
            if let Some(before) = before {
                assert_eq!(lab.floats("before", 0, 0, 0)[0], seen(before), "at {seconds}, before the ticks");
            }
            before = Some(last);
        }
        if memo {
            at(&mut lab, 1.19);
            let paused = at(&mut lab, 1.19);
            assert_eq!((paused.dispatched, paused.barriers, paused.displayed), (0, 0, false));
        }
        // A reset starts with tick 0 again.
        lab.executor.reset_history();
        at(&mut lab, 0.0);
        assert_eq!(lab.floats("color", 0, 0, 0)[0], seen(0));
    }
}

#[test]
fn a_swap_goes_on_with_the_next_tick() {
    let mut lab = Lab::new();
    let how = Planned { pinned: &["sum"], ..Planned::default() };
    lab.load(&FILES, &how);
    for seconds in [0.0, 0.1, 0.3] {
        at(&mut lab, seconds);
    }
    let edited = SHOW.replace("float(tick)", "float(tick) + 0.0");
    lab.load(&[FILES[0], FILES[1], FILES[2], ("shaders/show.comp", &edited)], &how);
    at(&mut lab, 0.4);
    assert_eq!(lab.floats("color", 0, 0, 0)[0], seen(4));
}
