//! Ticks of the clocks of a graph: how many are due in a frame, and what they rotate.
//!
//! Tick k of a clock is due when k / hz seconds have passed, tick 0 at the start. A frame runs those that have become due since the last
//! one, `most` of them at most; time beyond that is dropped. Times are counted in whole units of 1 / 705,600,000 s (the flick: frames of
//! 24, 25, 30, 48, 50, 60, 90, 100, 120 and 144 a second take a whole number of them), rates in thousandths of a hertz. The rest is
//! integer arithmetic, so that rounding drops no tick and runs none twice.

use raxel_graph::checked::{ClockId, ClockValue, Graph, Value};
use raxel_graph::plan::Turn;

/// Units of time in a second.
const FLICKS: u128 = 705_600_000;

/// Added to every number of ticks that rotates something, so that the tick before the first one has a number too. A multiple of every
/// number of copies, 1 to 17.
const ORIGIN: u64 = 12_252_240;

/// The clocks of a graph, from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Ticks {
    clocks: Vec<ClockState>,
}

#[derive(Clone, Debug)]
struct ClockState {
    name: String,
    /// Thousandths of a hertz.
    rate: u128,
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

impl Ticks {
    /// Nothing has run yet.
    pub fn new(graph: &Graph) -> Ticks {
        let clock = |clock: &raxel_graph::checked::Clock| ClockState {
            name: clock.name.clone(),
            rate: (clock.hz * 1000.0).round() as u128,
            most: clock.most,
            reached: None,
            finished: 0,
            due: 0,
            phase: 0.0,
            before: (None, 0, 0),
        };
        Ticks { clocks: graph.clocks.iter().map(clock).collect() }
    }

    /// Begins the frame at so many seconds. Time that runs backwards makes nothing due.
    pub fn advance(&mut self, seconds: f64) {
        let flicks = (seconds.max(0.0) * FLICKS as f64).round() as u128;
        for clock in &mut self.clocks {
            let thousandths = flicks * clock.rate;
            clock.before = (clock.reached, clock.finished, clock.due);
            let number = u64::try_from(thousandths / (FLICKS * 1000)).unwrap_or(u64::MAX - 1);
            let reached = number + 1;
            let passed = clock.reached.map_or(1, |before| reached.saturating_sub(before));
            clock.finished += u64::from(clock.due);
            clock.due = u32::try_from(passed).unwrap_or(u32::MAX).min(clock.most);
            clock.reached = Some(reached);
            clock.phase = ((thousandths % (FLICKS * 1000)) as f64 / (FLICKS * 1000) as f64) as f32;
        }
    }

    /// The frame that was begun has not been.
    pub fn undo(&mut self) {
        for clock in &mut self.clocks {
            (clock.reached, clock.finished, clock.due) = clock.before;
        }
    }

    /// Starts over: the next frame runs tick 0.
    pub fn reset(&mut self) {
        for clock in &mut self.clocks {
            (clock.reached, clock.finished, clock.due) = (None, 0, 0);
        }
    }

    /// Goes on where clocks of the same names have got to, so that what they turn keeps its order across a swap of plans.
    pub fn carry(&mut self, old: &Ticks) {
        for clock in &mut self.clocks {
            let Some(before) = old.clocks.iter().find(|before| before.name == clock.name) else { continue };
            clock.finished = before.finished + u64::from(before.due);
            // At another rate, the next tick is due now.
            clock.reached = before.reached.filter(|_| before.rate == clock.rate);
        }
    }

    /// Whether the frame runs so many ticks and one more.
    pub fn is_due(&self, clock: ClockId, tick: u32) -> bool {
        tick < self.clocks[clock.0 as usize].due
    }

    /// The number that rotates what is counted that way.
    pub fn rotation(&self, frame: u64, turn: Turn) -> u64 {
        let (clock, ticks) = match turn {
            Turn::Frame => return frame,
            Turn::Before(clock) => (clock, 0),
            Turn::Tick(clock, tick) => (clock, u64::from(tick) + 1),
            Turn::After(clock) => (clock, u64::from(self.clocks[clock.0 as usize].due)),
        };
        ORIGIN + self.clocks[clock.0 as usize].finished + ticks - 1
    }

    /// What `clock.NAME.…` is where the clock stands like that.
    pub fn value(&self, turn: Turn, value: ClockValue) -> Value {
        let (Turn::Before(clock) | Turn::Tick(clock, _) | Turn::After(clock)) = turn else { return Value::U32(0) };
        let state = &self.clocks[clock.0 as usize];
        match value {
            ClockValue::Tick => Value::U32(self.rotation(0, turn).saturating_sub(ORIGIN) as u32),
            ClockValue::Delta => Value::F32((1000.0 / state.rate as f64) as f32),
            ClockValue::Phase => Value::F32(state.phase),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(hz: f64, most: u32) -> Ticks {
        let state = ClockState {
            name: "sim".to_owned(),
            rate: (hz * 1000.0) as u128,
            most,
            reached: None,
            finished: 0,
            due: 0,
            phase: 0.0,
            before: (None, 0, 0),
        };
        Ticks { clocks: vec![state] }
    }

    /// Numbers of the ticks that the first `frames` frames run.
    fn run(ticks: &mut Ticks, step: f64, frames: u64) -> Vec<u64> {
        let mut ran = Vec::new();
        for frame in 0..frames {
            ticks.advance(frame as f64 * step);
            let tick = |tick| ticks.rotation(0, Turn::Tick(ClockId(0), tick)) - ORIGIN;
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
                ticks.advance(f64::from(second - 1) + 0.5);
                ticks.advance(f64::from(second * fps) * (1.0 / f64::from(fps)));
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
        ticks.advance(5.0);
        assert_eq!(due(&ticks), 1, "the first frame runs one tick, whenever it is");
        ticks.advance(6.0);
        assert_eq!(due(&ticks), 4);
        ticks.advance(6.0);
        assert_eq!(due(&ticks), 0);
        assert_eq!(ticks.rotation(9, Turn::After(clock)), ORIGIN + 4);
        assert_eq!(ticks.rotation(9, Turn::Frame), 9);
        ticks.advance(1.0);
        assert_eq!(due(&ticks), 0, "backwards");
        ticks.advance(1.0 + 2.0 / 60.0);
        assert_eq!(due(&ticks), 2);
        assert_eq!(ticks.value(Turn::Before(clock), ClockValue::Tick), Value::U32(4));
        assert_eq!(ticks.value(Turn::Tick(clock, 1), ClockValue::Tick), Value::U32(6));
        let mut next = self::ticks(60.0, 4);
        next.carry(&ticks);
        next.advance(1.0 + 3.0 / 60.0);
        assert_eq!((due(&next), next.rotation(0, Turn::After(clock))), (1, ORIGIN + 7));
    }
}
