//! Ticks of the clocks of a graph: the number that is due in a frame, and the rotation of copies.
//!
//! Tick k of a clock is due when k / hz seconds have passed, tick 0 at the start. A frame runs those that have become due since the last
//! one, `most` of them at most; time beyond that is dropped. Times and rates are fractions of whole numbers ([`crate::moment`]), so
//! that rounding drops no tick and runs none twice.

use raxel_graph::checked::{ClockId, ClockValue, Graph, Value};
use raxel_graph::plan::CopySelector;

use crate::moment::{Fraction, Moment};

/// Added to every number of ticks that rotates something, so that the tick before the first one has a number too. A multiple of every
/// number of copies, 1 to 17.
const ORIGIN: u64 = 12_252_240;

/// The clocks of a graph, from frame to frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ticks {
    clocks: Vec<ClockState>,
}

#[derive(Clone, Debug)]
struct ClockState {
    name: String,
    /// Ticks a second.
    rate: Fraction,
    most: u32,
    /// Ticks that were due by the last frame; `None` before the first.
    reached: Option<u64>,
    /// Ticks that earlier frames have run.
    finished: u64,
    /// Ticks that this frame runs.
    due: u32,
    phase: f32,
    /// `reached`, `finished` and `due` as the frame before left them.
    before: (Option<u64>, u64, u32),
}

impl ClockState {
    fn new(name: &str, hz: f64, most: u32) -> ClockState {
        ClockState {
            name: name.to_owned(),
            rate: Fraction::of(hz),
            most,
            reached: None,
            finished: 0,
            due: 0,
            phase: 0.0,
            before: (None, 0, 0),
        }
    }
}

impl Ticks {
    /// Nothing has run yet.
    pub(crate) fn new(graph: &Graph) -> Ticks {
        Ticks { clocks: graph.clocks.iter().map(|clock| ClockState::new(&clock.name, clock.hz, clock.most)).collect() }
    }

    /// Begins the frame at a time. Time that runs backwards makes nothing due.
    #[expect(clippy::cast_possible_truncation, reason = "shaders get 32-bit floats, and ticks modulo 2³²")]
    pub(crate) fn advance(&mut self, time: Moment) {
        for clock in &mut self.clocks {
            clock.before = (clock.reached, clock.finished, clock.due);
            let (number, phase) = time.tick(clock.rate);
            let reached = number.saturating_add(1);
            let passed = clock.reached.map_or(1, |before| reached.saturating_sub(before));
            clock.finished += u64::from(clock.due);
            clock.due = u32::try_from(passed).unwrap_or(u32::MAX).min(clock.most);
            clock.reached = Some(reached);
            // Below 1, also where the nearest float is 1.
            clock.phase = (phase as f32).min(1.0 - f32::EPSILON / 2.0);
        }
    }

    /// The frame that was begun has not been.
    pub(crate) fn undo(&mut self) {
        for clock in &mut self.clocks {
            (clock.reached, clock.finished, clock.due) = clock.before;
        }
    }

    /// Starts over: the next frame runs tick 0.
    pub(crate) fn reset(&mut self) {
        for clock in &mut self.clocks {
            (clock.reached, clock.finished, clock.due) = (None, 0, 0);
        }
    }

    /// Continues from the counts of clocks with the same names. So the selected copies keep their order across a swap of plans.
    pub(crate) fn carry(&mut self, old: &Ticks) {
        for clock in &mut self.clocks {
            let Some(before) = old.clocks.iter().find(|before| before.name == clock.name) else { continue };
            clock.finished = before.finished + u64::from(before.due);
            // At another rate, the next tick is due now.
            clock.reached = before.reached.filter(|_| before.rate == clock.rate);
        }
    }

    /// Whether the frame runs more than `tick` ticks.
    pub(crate) fn is_due(&self, clock: ClockId, tick: u32) -> bool {
        tick < self.clocks[clock.0 as usize].due
    }

    /// The number that rotates copies with this selector.
    pub(crate) fn rotation(&self, frame: u64, selector: CopySelector) -> u64 {
        let (clock, ticks) = match selector {
            CopySelector::Frame => return frame,
            CopySelector::Before(clock) => (clock, 0),
            CopySelector::Tick(clock, tick) => (clock, u64::from(tick) + 1),
            CopySelector::After(clock) => (clock, u64::from(self.clocks[clock.0 as usize].due)),
        };
        ORIGIN + self.clocks[clock.0 as usize].finished + ticks - 1
    }

    /// The value of `clock.NAME.…` for this state of the clock.
    #[expect(clippy::cast_possible_truncation, reason = "shaders get 32-bit floats, and ticks modulo 2³²")]
    pub(crate) fn value(&self, selector: CopySelector, value: ClockValue) -> Value {
        let (CopySelector::Before(clock) | CopySelector::Tick(clock, _) | CopySelector::After(clock)) = selector else {
            return Value::U32(0);
        };
        let state = &self.clocks[clock.0 as usize];
        match value {
            ClockValue::Tick => Value::U32(self.rotation(0, selector).saturating_sub(ORIGIN) as u32),
            ClockValue::Delta => {
                let (ticks, seconds) = state.rate.parts();
                Value::F32((seconds as f64 / ticks as f64) as f32)
            }
            ClockValue::Phase => Value::F32(state.phase),
        }
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::random::SplitMix64;

    use super::*;

    fn ticks(hz: f64, most: u32) -> Ticks {
        Ticks { clocks: vec![ClockState::new("sim", hz, most)] }
    }

    /// Numbers of the ticks that the first `frames` frames run.
    fn run(ticks: &mut Ticks, step: f64, frames: u64) -> Vec<u64> {
        let mut ran = Vec::new();
        for frame in 0..frames {
            ticks.advance(Moment::from(frame as f64 * step));
            let tick = |tick| ticks.rotation(0, CopySelector::Tick(ClockId(0), tick)) - ORIGIN;
            ran.extend((0..ticks.clocks[0].due).map(tick));
        }
        ran
    }

    #[test]
    fn no_tick_is_dropped_or_run_twice() {
        for fps in [24.0, 25.0, 30.0, 50.0, 59.94, 60.0, 75.0, 90.0, 120.0, 144.0, 1000.0] {
            for hz in [1.0, 7.5, 20.0, 30.0, 60.0, 59.94, 90.0] {
                let mut ticks = ticks(hz, 4);
                let seconds = 500;
                let ran = run(&mut ticks, 1.0 / fps, (fps * f64::from(seconds)) as u64);
                assert!(ran.iter().copied().eq(0..ran.len() as u64), "{fps} frames, {hz} ticks a second");
                // The last frame may be a frame before the last tick.
                let expected = hz * f64::from(seconds);
                assert!((ran.len() as f64 - expected).abs() <= 1.0 + hz / fps, "{} for {expected} at {fps}", ran.len());
            }
        }
        // Where frames and ticks meet, they meet exactly: k seconds have seen 60 k + 1 ticks.
        for fps in [30_u32, 60, 144] {
            let mut ticks = ticks(60.0, 4);
            for second in 1..2000 {
                ticks.advance(Moment::from(f64::from(second - 1) + 0.5));
                ticks.advance(Moment::from(f64::from(second * fps) * (1.0 / f64::from(fps))));
                assert_eq!(ticks.clocks[0].reached, Some(u64::from(second) * 60 + 1), "{fps}");
                assert!(ticks.clocks[0].phase.abs() < 1e-6);
            }
        }
    }

    #[test]
    fn what_cannot_be_caught_up_is_dropped() {
        let mut ticks = ticks(60.0, 4);
        let clock = ClockId(0);
        let due = |ticks: &Ticks| (0..9).filter(|tick| ticks.is_due(clock, *tick)).count();
        ticks.advance(Moment::from(5.0));
        assert_eq!(due(&ticks), 1, "the first frame runs one tick, whenever it is");
        ticks.advance(Moment::from(6.0));
        assert_eq!(due(&ticks), 4);
        ticks.advance(Moment::from(6.0));
        assert_eq!(due(&ticks), 0);
        assert_eq!(ticks.rotation(9, CopySelector::After(clock)), ORIGIN + 4);
        assert_eq!(ticks.rotation(9, CopySelector::Frame), 9);
        ticks.advance(Moment::from(1.0));
        assert_eq!(due(&ticks), 0, "backwards");
        ticks.advance(Moment::from(1.0 + 2.0 / 60.0));
        assert_eq!(due(&ticks), 2);
        assert_eq!(ticks.value(CopySelector::Before(clock), ClockValue::Tick), Value::U32(4));
        assert_eq!(ticks.value(CopySelector::Tick(clock, 1), ClockValue::Tick), Value::U32(6));
        let mut next = self::ticks(60.0, 4);
        next.carry(&ticks);
        next.advance(Moment::from(1.0 + 3.0 / 60.0));
        assert_eq!((due(&next), next.rotation(0, CopySelector::After(clock))), (1, ORIGIN + 7));
    }

    /// Rates as users write them, with the fraction that they are.
    fn rates(random: &mut SplitMix64, count: usize) -> Vec<(f64, [u128; 2])> {
        let chosen = [
            "1", "7", "20", "23.976", "24", "25", "29.97", "30", "50", "59.94", "60", "90", "144", "240", "999.999",
            "1000",
        ];
        let random = (0..count).map(|_| {
            let digits = random.bits() % 5;
            let below = 10_u64.pow(digits as u32);
            let above = below + random.bits() % (999 * below);
            format!("{}.{:0width$}", above / below, above % below, width = digits as usize)
        });
        let fraction = |text: String| {
            let (whole, part) = text.split_once('.').unwrap_or((&text, ""));
            let above = format!("{whole}{part}").parse().expect("digits");
            (text.parse().expect("a number"), [above, 10_u128.pow(part.len() as u32)])
        };
        chosen.map(str::to_owned).into_iter().chain(random).map(fraction).collect()
    }

    /// Every frame of `frames` runs the ticks that have become due by integer arithmetic, whether all frames were played or a seek went
    /// over some.
    fn ticks_are_exact(frames: u64, hz: &[(f64, [u128; 2])], random: &mut SplitMix64) {
        let paces = [(24.0, [24, 1]), (25.0, [25, 1]), (30000.0 / 1001.0, [30000, 1001]), (29.97, [2997, 100])];
        for (fps, [per, seconds]) in paces.into_iter().chain([(30.0, [30, 1]), (60.0, [60, 1]), (144.0, [144, 1])]) {
            let step = Fraction::of(1.0 / fps);
            for &(hz, [times, of]) in hz {
                let (mut played, mut sought) = (self::ticks(hz, u32::MAX), self::ticks(hz, u32::MAX));
                let rate = played.clocks[0].rate;
                let mut before = 0;
                for frame in 0..frames {
                    let number = u128::from(frame) * seconds * times / (per * of);
                    let time = Moment::of_frame(frame, step);
                    played.advance(time);
                    assert_eq!(u128::from(time.tick(rate).0), number, "{hz} Hz, frame {frame} at {fps}");
                    let due = if frame == 0 { 1 } else { number - before };
                    assert_eq!(u128::from(played.clocks[0].due), due, "{hz} Hz, frame {frame} at {fps}");
                    before = number;
                    if random.bits().is_multiple_of(8) {
                        sought.advance(Moment::from(frame as f64 / fps));
                        assert_eq!(sought.clocks[0].reached, played.clocks[0].reached);
                        assert_eq!(sought.clocks[0].phase.to_bits(), played.clocks[0].phase.to_bits());
                    }
                }
            }
        }
    }

    #[test]
    fn ticks_are_what_integers_say() {
        let mut random = SplitMix64::new(30);
        let rates = rates(&mut random, 40);
        ticks_are_exact(2000, &rates, &mut random);
        ticks_are_exact(100_000, &rates[5..8], &mut random);
    }

    #[test]
    #[ignore = "takes minutes"]
    fn ticks_of_all_rates_are_what_integers_say() {
        let mut random = SplitMix64::new(31);
        let mut rates = rates(&mut random, 200);
        rates.extend((1..=1000_u32).map(|hz| (f64::from(hz), [u128::from(hz), 1])));
        ticks_are_exact(100_000, &rates, &mut random);
    }
}
