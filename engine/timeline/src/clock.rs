//! The clock of a session: frames, seconds, pause, single steps.
//!
//! Headless, time is frame index × fixed step, so that the same inputs give the same bytes. Live, time follows the wall clock, in
//! nanoseconds. Both are exact: a float comes only of times that are shown and handed to shaders.

use std::time::{Duration, Instant};

use raxel_execute::moment::{Fraction, Moment};

/// How time passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Each frame takes exactly this many seconds.
    Fixed(Fraction),
    /// Each frame takes as long as it took.
    Live,
}

/// The time that a frame is drawn for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Frames since the last reset; the first is 0.
    pub index: u64,
    /// The time since the last reset.
    pub time: Moment,
    /// Seconds since the frame before; 0 on frame 0 and while paused.
    pub delta: f64,
    /// Whether this is a new frame: false when the last one is drawn again ([`Clock::repeat`]).
    pub advanced: bool,
}

/// How the next frame follows the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Next {
    /// Time passes, unless the clock is paused.
    #[default]
    Follows,
    /// It has the time of the last one, and the next index.
    SameMoment,
    /// It has the time and the index of the last one.
    SameFrame,
}

/// Counts frames and seconds.
#[derive(Clone, Debug)]
pub struct Clock {
    pace: Pace,
    now: Option<FrameTime>,
    paused: bool,
    steps: u32,
    next: Next,
    woken: Option<Instant>,
    /// A frame and its time; the times of other frames count from it. It is frame 0 at the start, until a seek.
    origin: (u64, Moment),
    /// Index of the first frame.
    first: u64,
}

/// A live frame that took longer (a moved window, a breakpoint) counts as this long.
const LONGEST_FRAME: Duration = Duration::from_millis(250);

/// A single step while paused, when the pace is live.
const LIVE_STEP: Duration = Duration::from_nanos(16_666_667);

impl Clock {
    /// A clock at its start.
    pub fn new(pace: Pace) -> Self {
        Self {
            pace,
            now: None,
            paused: false,
            steps: 0,
            next: Next::default(),
            woken: None,
            origin: (0, Moment::START),
            first: 0,
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

    /// Puts the next frame at a time.
    pub fn seek(&mut self, time: Moment) {
        self.origin = (self.now.map_or(self.first, |now| now.index + 1), time);
        self.woken = None;
        if let Some(now) = &mut self.now {
            now.time = time;
        }
        self.next = Next::SameMoment;
    }

    /// Whether the clock stands still.
    pub fn paused(&self) -> bool {
        self.paused
    }

    /// Stops or starts the clock. While it is paused, each frame is another one of the same moment, as after [`Self::again`].
    pub fn set_paused(&mut self, paused: bool) {
        self.paused = paused;
        self.steps = 0;
        self.woken = None;
    }

    /// While paused: time passes for one frame.
    pub fn step(&mut self) {
        if self.paused {
            self.steps = self.steps.saturating_add(1);
        }
    }

    /// The next frame is another one of the moment of the last: its index is one higher, its time is the same.
    pub fn again(&mut self) {
        self.next = Next::SameMoment;
    }

    /// The next frame is the last one, drawn again: its index and its time are the same.
    pub fn repeat(&mut self) {
        self.next = Next::SameFrame;
    }

    /// The time of the last frame.
    pub fn now(&self) -> Option<FrameTime> {
        self.now
    }

    /// The time of the frame before the first, where a run begins later than at frame 0.
    pub fn before_first(&self) -> Option<Moment> {
        match self.pace {
            Pace::Fixed(step) => Some(Moment::of_frame(self.first.checked_sub(1)?, step)),
            Pace::Live => None,
        }
    }

    /// How time passes.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// The time of the next frame, which begins at `wall`.
    pub fn tick(&mut self, wall: Instant) -> FrameTime {
        let stepped = self.steps > 0;
        let next = std::mem::take(&mut self.next);
        let (known, origin) = self.origin;
        let time = match self.now {
            None => {
                let index = self.first;
                let (time, delta) = match self.pace {
                    Pace::Fixed(step) => {
                        let delta = if index == 0 { 0.0 } else { Moment::from(step).seconds() };
                        (origin.after(index - known, step), delta)
                    }
                    Pace::Live => (origin, 0.0),
                };
                FrameTime { index, time, delta, advanced: true }
            }
            Some(now) if next == Next::SameFrame => FrameTime { delta: 0.0, advanced: false, ..now },
            Some(now) if next == Next::SameMoment || self.paused && !stepped => {
                // At a fixed pace, the frame after it follows a step later.
                self.origin = (now.index + 1, now.time);
                FrameTime { index: now.index + 1, delta: 0.0, advanced: true, ..now }
            }
            Some(now) => {
                let index = now.index + 1;
                let time = match self.pace {
                    Pace::Fixed(step) => origin.after(index - known, step),
                    Pace::Live if stepped => now.time + LIVE_STEP,
                    Pace::Live => {
                        let took = self.woken.map_or(Duration::ZERO, |woken| wall.saturating_duration_since(woken));
                        now.time + took.min(LONGEST_FRAME)
                    }
                };
                FrameTime { index, time, delta: time.since(now.time), advanced: true }
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

    fn fixed(step: f64) -> Clock {
        Clock::new(Pace::Fixed(Fraction::of(step)))
    }

    #[test]
    fn fixed_time_is_index_times_step() {
        let mut clock = fixed(1.0 / 60.0);
        let wall = Instant::now();
        for index in 0..1000_u64 {
            let time = clock.tick(wall);
            assert_eq!((time.index, time.time), (index, Moment::from(index as f64 * (1.0 / 60.0))));
            assert_eq!(time.time.seconds(), index as f64 / 60.0);
        }
        clock.reset();
        assert_eq!(clock.tick(wall), FrameTime { index: 0, time: Moment::START, delta: 0.0, advanced: true });
    }

    #[test]
    fn a_pause_stops_time_and_a_step_lets_one_frame_pass() {
        let mut clock = Clock::new(Pace::Live);
        let wall = Instant::now();
        let at = |ms| wall + Duration::from_millis(ms);
        clock.tick(at(0));
        let running = clock.tick(at(20));
        assert_eq!(running.time, Moment::from(0.02));
        clock.set_paused(true);
        let held = clock.tick(at(40));
        assert_eq!(held, FrameTime { index: 2, delta: 0.0, ..running });
        clock.step();
        let stepped = clock.tick(at(60));
        assert_eq!((stepped.index, stepped.time), (3, running.time + LIVE_STEP));
        assert_eq!(clock.tick(at(80)), FrameTime { index: 4, delta: 0.0, ..stepped });
        clock.set_paused(false);
        // The pause itself is no time.
        assert_eq!(clock.tick(at(9000)).time, stepped.time);
        // A frame that hung does not count in full either.
        assert_eq!(clock.tick(at(19_000)).delta, LONGEST_FRAME.as_secs_f64());
    }

    #[test]
    fn frames_of_a_pause_are_counted_and_time_goes_on_after_it() {
        let step = 1.0 / 60.0;
        let mut clock = fixed(step);
        let wall = Instant::now();
        let moment = (0..4).map(|_| clock.tick(wall)).last().unwrap();
        clock.set_paused(true);
        for index in 4..104 {
            assert_eq!(clock.tick(wall), FrameTime { index, delta: 0.0, ..moment });
        }
        clock.step();
        let stepped = clock.tick(wall);
        assert_eq!(stepped, FrameTime { index: 104, time: Moment::from(4.0 / 60.0), delta: step, advanced: true });
        assert_eq!(clock.tick(wall), FrameTime { index: 105, delta: 0.0, ..stepped });
        clock.set_paused(false);
        for (index, frame) in [(106, 5.0), (107, 6.0)] {
            let time = clock.tick(wall);
            assert_eq!((time.index, time.time, time.delta), (index, Moment::from(frame / 60.0), step));
        }
    }

    #[test]
    fn a_seek_during_a_pause_gives_its_very_moment() {
        for pace in [Pace::Fixed(Fraction::of(0.5)), Pace::Live] {
            let mut clock = Clock::new(pace);
            let wall = Instant::now();
            clock.tick(wall);
            clock.set_paused(true);
            clock.tick(wall);
            for (seconds, index) in [(3.0, 2), (1.0, 4)] {
                clock.seek(Moment::from(seconds));
                for index in [index, index + 1] {
                    let time = Moment::from(seconds);
                    assert_eq!(clock.tick(wall), FrameTime { index, time, delta: 0.0, advanced: true });
                }
            }
        }
    }

    #[test]
    fn a_repeated_frame_keeps_its_index() {
        let mut clock = fixed(0.5);
        let wall = Instant::now();
        clock.tick(wall);
        let frame = clock.tick(wall);
        for _ in 0..3 {
            clock.repeat();
            assert_eq!(clock.tick(wall), FrameTime { delta: 0.0, advanced: false, ..frame });
        }
        let next = clock.tick(wall);
        assert_eq!((next.index, next.time), (2, Moment::from(1.0)));
    }

    #[test]
    fn a_moment_again_is_a_new_frame_at_the_same_time() {
        let step = 1.0 / 60.0;
        let mut clock = fixed(step);
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
        assert_eq!((next.time, next.delta), (Moment::from(4.0 / 60.0), step), "{next:?}");
    }

    #[test]
    fn a_later_start_gives_the_frames_of_the_whole_run() {
        let (mut whole, mut part) = (fixed(1.0 / 24.0), fixed(1.0 / 24.0));
        let wall = Instant::now();
        part.start_at(100);
        let frames: Vec<FrameTime> = (0..110).map(|_| whole.tick(wall)).collect();
        for expected in &frames[100..] {
            assert_eq!(part.tick(wall), *expected);
        }
    }

    #[test]
    fn seeking_keeps_the_pace() {
        let mut clock = fixed(0.5);
        for (seconds, next) in [(3.0, 3.5), (1.0, 1.5)] {
            clock.seek(Moment::from(seconds));
            assert_eq!(clock.tick(Instant::now()).time.seconds(), seconds);
            assert_eq!(clock.tick(Instant::now()).time.seconds(), next);
        }
    }

    #[test]
    fn frames_after_a_seek_have_the_times_of_the_whole_run() {
        let wall = Instant::now();
        for fps in [24.0, 29.97, 30000.0 / 1001.0, 60.0, 144.0] {
            let step = 1.0 / fps;
            let mut whole = fixed(step);
            let times: Vec<Moment> = (0..1000).map(|_| whole.tick(wall).time).collect();
            for start in (1..990_u32).step_by(7) {
                for seconds in [f64::from(start) / fps, f64::from(start) * step] {
                    let mut part = fixed(step);
                    part.tick(wall);
                    part.seek(Moment::from(seconds));
                    let first = start as usize;
                    assert!((first..first + 10).all(|frame| part.tick(wall).time == times[frame]), "{start} at {fps}");
                }
            }
        }
    }
}
