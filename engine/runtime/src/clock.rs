//! The clock of a session: frames, seconds, pause, single steps.
//!
//! Headless, time is frame index × fixed step, so that the same inputs give the same bytes. Live, time follows the wall clock.

use std::time::Instant;

/// How time passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Each frame takes exactly so many seconds.
    Fixed(f64),
    /// Each frame takes as long as it took.
    Live,
}

/// The time that a frame is drawn for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Frames since the last reset; the first is 0.
    pub index: u64,
    /// Seconds since the last reset.
    pub time: f64,
    /// Seconds since the frame before; 0 on frame 0 and while paused.
    pub delta: f64,
    /// Whether this is a new frame: false when the clock is paused and the same time is drawn again.
    pub advanced: bool,
}

/// Counts frames and seconds.
#[derive(Clone, Debug)]
pub struct Clock {
    pace: Pace,
    now: Option<FrameTime>,
    paused: bool,
    steps: u32,
    /// The next frame has the time of the last one.
    again: bool,
    woken: Option<Instant>,
    /// Added to every time, by [`Clock::seek`].
    origin: f64,
    /// Index of the first frame.
    first: u64,
}

/// A live frame that took longer (a moved window, a breakpoint) counts as this many seconds.
const LONGEST_FRAME: f64 = 0.25;

/// Seconds of a single step while paused, when the pace is live.
const LIVE_STEP: f64 = 1.0 / 60.0;

impl Clock {
    /// A clock at its start.
    pub fn new(pace: Pace) -> Self {
        Self { pace, now: None, paused: false, steps: 0, again: false, woken: None, origin: 0.0, first: 0 }
    }

    /// How time passes.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Changes how time passes from the next frame on.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
        self.woken = None;
        // A fixed pace reckons from the index; keep the time where it is.
        if let (Pace::Fixed(step), Some(now)) = (pace, self.now) {
            self.origin = now.time - now.index as f64 * step;
        }
    }

    /// Starts over: the next frame is frame 0 at 0 seconds. Pause stays as it is.
    pub fn reset(&mut self) {
        *self = Self { paused: self.paused, ..Self::new(self.pace) };
    }

    /// Starts over at a later frame: the next one is frame `index`, at the time that it has at a fixed pace.
    pub fn start_at(&mut self, index: u64) {
        self.reset();
        self.first = index;
    }

    /// Puts the next frame at `time` seconds.
    pub fn seek(&mut self, time: f64) {
        let index = self.now.map_or(self.first, |now| now.index + 1);
        self.origin = match self.pace {
            Pace::Fixed(step) => time - index as f64 * step,
            Pace::Live => time,
        };
        self.woken = None;
        if let Some(now) = &mut self.now {
            now.time = time;
        }
        if self.paused {
            self.steps = self.steps.max(1);
        }
    }

    /// Whether the clock stands still.
    pub fn paused(&self) -> bool {
        self.paused
    }

    /// Stops or starts the clock.
    pub fn set_paused(&mut self, paused: bool) {
        self.paused = paused;
        self.steps = 0;
        self.woken = None;
    }

    /// While paused: lets one more frame pass.
    pub fn step(&mut self) {
        if self.paused {
            self.steps = self.steps.saturating_add(1);
        }
    }

    /// The next frame is another one of the moment of the last: its index is one higher, its time is the same.
    pub fn again(&mut self) {
        self.again = true;
    }

    /// The time of the last frame.
    pub fn now(&self) -> Option<FrameTime> {
        self.now
    }

    /// The time of the next frame, which begins at `wall`.
    pub fn tick(&mut self, wall: Instant) -> FrameTime {
        let stepped = self.steps > 0;
        let again = std::mem::take(&mut self.again);
        let time = match self.now {
            None => {
                let at = |index: u64| match self.pace {
                    Pace::Fixed(step) => self.origin + index as f64 * step,
                    Pace::Live => self.origin,
                };
                let delta = if self.first == 0 { 0.0 } else { (at(self.first) - at(self.first - 1)).max(0.0) };
                FrameTime { index: self.first, time: at(self.first), delta, advanced: true }
            }
            Some(now) if again => {
                // At a fixed pace, the frame after it follows a step later.
                if let Pace::Fixed(step) = self.pace {
                    self.origin -= step;
                }
                FrameTime { index: now.index + 1, delta: 0.0, advanced: true, ..now }
            }
            Some(now) if self.paused && !stepped => FrameTime { delta: 0.0, advanced: false, ..now },
            Some(now) => {
                let index = now.index + 1;
                let time = match self.pace {
                    Pace::Fixed(step) => self.origin + index as f64 * step,
                    Pace::Live if stepped => now.time + LIVE_STEP,
                    Pace::Live => {
                        let took = self.woken.map_or(0.0, |woken| wall.saturating_duration_since(woken).as_secs_f64());
                        now.time + took.min(LONGEST_FRAME)
                    }
                };
                FrameTime { index, time, delta: (time - now.time).max(0.0), advanced: true }
            }
        };
        self.steps = self.steps.saturating_sub(1);
        self.woken = Some(wall);
        self.now = Some(time);
        time
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn fixed_time_is_index_times_step() {
        let mut clock = Clock::new(Pace::Fixed(1.0 / 60.0));
        let wall = Instant::now();
        for index in 0..1000_u64 {
            let time = clock.tick(wall);
            assert_eq!((time.index, time.time), (index, index as f64 * (1.0 / 60.0)));
        }
        clock.reset();
        assert_eq!(clock.tick(wall), FrameTime { index: 0, time: 0.0, delta: 0.0, advanced: true });
    }

    #[test]
    fn a_pause_stops_time_and_a_step_lets_one_frame_pass() {
        let mut clock = Clock::new(Pace::Live);
        let wall = Instant::now();
        let at = |ms| wall + Duration::from_millis(ms);
        clock.tick(at(0));
        let running = clock.tick(at(20));
        assert!((running.time - 0.02).abs() < 1e-9);
        clock.set_paused(true);
        let held = clock.tick(at(40));
        assert_eq!((held.index, held.time, held.advanced), (1, running.time, false));
        clock.step();
        let stepped = clock.tick(at(60));
        assert_eq!((stepped.index, stepped.advanced), (2, true));
        assert!(!clock.tick(at(80)).advanced);
        clock.set_paused(false);
        // The pause itself is no time.
        assert!((clock.tick(at(9000)).time - stepped.time).abs() < 1e-9);
        // Nor is a frame that hung counted in full.
        assert!((clock.tick(at(19_000)).delta - LONGEST_FRAME).abs() < 1e-9);
    }

    #[test]
    fn a_moment_again_is_a_new_frame_at_the_same_time() {
        let step = 1.0 / 60.0;
        let mut clock = Clock::new(Pace::Fixed(step));
        let wall = Instant::now();
        for _ in 0..4 {
            clock.tick(wall);
        }
        let moment = clock.now().unwrap();
        for count in 1..=100 {
            clock.again();
            let time = clock.tick(wall);
            assert_eq!(time, FrameTime { index: 3 + count, delta: 0.0, ..moment });
        }
        let next = clock.tick(wall);
        assert!((next.time - 4.0 * step).abs() < 1e-9 && (next.delta - step).abs() < 1e-9, "{next:?}");
    }

    #[test]
    fn a_later_start_gives_the_frames_of_the_whole_run() {
        let (mut whole, mut part) = (Clock::new(Pace::Fixed(1.0 / 24.0)), Clock::new(Pace::Fixed(1.0 / 24.0)));
        let wall = Instant::now();
        part.start_at(100);
        let frames: Vec<FrameTime> = (0..110).map(|_| whole.tick(wall)).collect();
        for expected in &frames[100..] {
            assert_eq!(part.tick(wall), *expected);
        }
    }

    #[test]
    fn seeking_keeps_the_pace() {
        let mut clock = Clock::new(Pace::Fixed(0.5));
        clock.seek(3.0);
        assert_eq!(clock.tick(Instant::now()).time, 3.0);
        assert_eq!(clock.tick(Instant::now()).time, 3.5);
        clock.seek(1.0);
        assert_eq!(clock.tick(Instant::now()).time, 1.0);
        assert_eq!(clock.tick(Instant::now()).time, 1.5);
    }
}
