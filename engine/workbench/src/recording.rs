//! A param that is moved while it is recorded becomes keys of a track.

use raxel_graph::checked::Value;
use raxel_runtime::params::{components, from_components, is_integer};

/// Keys have this distance at least, in seconds.
const STEP: f64 = 0.01;

/// The part of the range of a recording's values that a key less may change.
const TOLERANCE: f64 = 0.01;

/// Most samples of a recording: [`Recording::keys`] may take time with their square. A longer motion becomes several recordings.
const MOST_SAMPLES: usize = 16_384;

/// A param that is being moved, with its values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Its name.
    pub param: String,
    /// Its value before.
    pub before: Value,
    /// Seconds of the demo, in order, and values.
    samples: Vec<(f64, Vec<f64>)>,
}

/// A key of a track.
pub type Key = (f64, Value);

/// How long a param counts as being moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Records {
    /// Nothing is recorded.
    #[default]
    Nothing,
    /// As long as a panel's widget is held.
    WhileHeld,
    /// Until a program ends the recording.
    UntilEnd,
}

/// Records params, while it is on.
#[derive(Debug, Default)]
pub struct Recorder {
    records: Records,
    /// Params that are being moved.
    moving: Vec<Recording>,
    /// Motions that have ended, and that nobody has taken yet.
    ended: Vec<Recording>,
    /// The demo does not drive the params meanwhile.
    released: bool,
}

impl Recorder {
    /// Whether it records.
    pub fn is_on(&self) -> bool {
        self.records != Records::Nothing
    }

    /// Whether it records for a program.
    pub fn is_of_program(&self) -> bool {
        self.records == Records::UntilEnd
    }

    /// Begins, or ends: a param is recorded while it is held.
    pub fn turn(&mut self, on: bool) {
        self.records = if on { Records::WhileHeld } else { Records::Nothing };
    }

    /// Begins to record for a program: each param that is moved is recorded until [`Self::end`].
    pub fn begin(&mut self) {
        self.records = Records::UntilEnd;
    }

    /// Ends, and gives all recordings, in the order of their ends.
    pub fn end(&mut self) -> Vec<Recording> {
        self.records = Records::Nothing;
        self.ended.append(&mut self.moving);
        std::mem::take(&mut self.ended)
    }

    /// Goes on with recordings that [`Self::end`] gave, for a program. The last one of each param is the one that goes on.
    pub fn go_on(&mut self, recordings: Vec<Recording>) {
        self.records = Records::UntilEnd;
        for recording in recordings.into_iter().rev() {
            let goes_on = self.moving.iter().all(|moving| moving.param != recording.param);
            if goes_on { &mut self.moving } else { &mut self.ended }.push(recording);
        }
        self.moving.reverse();
        self.ended.reverse();
    }

    /// Forgets what was recorded: other files run.
    pub fn forget(&mut self) {
        *self = Self { records: self.records, ..Self::default() };
    }

    /// The demo drives the param, and must not until it is released.
    pub fn release(&mut self) {
        self.released = true;
    }

    /// Whether the demo is to drive the params again. Says so once.
    pub fn gives_back(&mut self) -> bool {
        std::mem::take(&mut self.released)
    }

    /// A param was moved at a time, and had a value before.
    pub fn moved(&mut self, param: &str, before: Value, time: f64, value: &[f64]) {
        if !self.is_on() {
            return;
        }
        self.ended.extend(self.moving.extract_if(.., |recording| recording.param == param && recording.is_over(time)));
        if let Some(recording) = self.moving.iter_mut().find(|recording| recording.param == param) {
            recording.add(time, value.to_vec());
        } else {
            let samples = vec![(time, value.to_vec())];
            self.moving.push(Recording { param: param.to_owned(), before, samples });
        }
    }

    /// Notes the values that params have at a time, whoever has set them: `of` gives that of a name.
    pub fn note(&mut self, time: f64, of: impl Fn(&str) -> Option<Vec<f64>>) {
        for recording in self.moving.iter_mut().filter(|recording| !recording.is_over(time)) {
            if let Some(value) = of(&recording.param) {
                recording.add(time, value);
            }
        }
    }

    /// A frame at a time, in which params may rest. Returns the recordings that have ended: no param is held any more, or the demo has started
    /// over. A program has them from [`Self::end`] instead.
    pub fn frame(&mut self, time: f64, held: bool) -> Vec<Recording> {
        let held = held || self.records == Records::UntilEnd;
        self.ended.extend(self.moving.extract_if(.., |recording| !held || recording.is_over(time)));
        self.moving.iter_mut().for_each(|recording| recording.rest(time));
        if self.records == Records::UntilEnd { Vec::new() } else { std::mem::take(&mut self.ended) }
    }
}

impl Recording {
    /// One key: the value of a param at a time, over a value that it has before a new track begins.
    pub fn key(param: &str, before: Value, time: f64, value: &Value) -> Self {
        Self { param: param.to_owned(), before, samples: vec![(time, components(value))] }
    }

    fn add(&mut self, time: f64, value: Vec<f64>) {
        match self.samples.as_mut_slice() {
            // Two samples are enough of a param that rests.
            [.., (_, first), (last, second)] if *first == value && *second == value => *last = time,
            [.., (last, known)] if time < *last + STEP => *known = value,
            _ => self.samples.push((time, value)),
        }
    }

    /// The param has the same value at another time.
    fn rest(&mut self, time: f64) {
        if let Some((_, value)) = self.samples.last().cloned() {
            self.add(time, value);
        }
    }

    /// Whether a sample of this time belongs to another recording: the demo has started over, or this one is full.
    fn is_over(&self, time: f64) -> bool {
        self.samples.len() >= MOST_SAMPLES || self.samples.last().is_some_and(|(last, _)| time < *last)
    }

    /// The time of its last sample.
    pub fn last(&self) -> Option<f64> {
        self.samples.last().map(|(time, _)| *time)
    }

    /// Its keys: as few as come close to the seen values. Whole numbers and switches have one where they change.
    pub fn keys(&self) -> Vec<Key> {
        let last = self.samples.len().saturating_sub(1);
        let mut kept = vec![false; self.samples.len()];
        if self.steps() {
            for (index, keep) in kept.iter_mut().enumerate() {
                *keep = index == 0 || self.samples[index].1 != self.samples[index - 1].1;
            }
        } else {
            let size = |axis: usize| {
                let values = || self.samples.iter().filter_map(|(_, value)| value.get(axis).copied());
                values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
            };
            let count = self.samples.first().map_or(0, |(_, value)| value.len());
            let tolerance = (0..count).map(size).fold(0.0, f64::max) * TOLERANCE;
            self.thin([0, last], tolerance, &mut kept);
        }
        let kept = self.samples.iter().zip(kept).filter(|(_, kept)| *kept);
        kept.filter_map(|((time, value), _)| Some((*time, from_components(value, &self.before)?))).collect()
    }

    /// Whether its values go from one to the next in steps.
    pub fn steps(&self) -> bool {
        is_integer(&self.before) || matches!(self.before, Value::Bool(_))
    }

    /// Keeps both ends of a part, and the point farthest from the line between them, as long as that is too far (Douglas and Peucker).
    fn thin(&self, whole: [usize; 2], tolerance: f64, kept: &mut [bool]) {
        // Parts that are left, in place of a recursion, which may be as deep as there are samples.
        let mut parts = vec![whole];
        while let Some([from, to]) = parts.pop() {
            let (Some((t0, a)), Some((t1, b))) = (self.samples.get(from), self.samples.get(to)) else { continue };
            (kept[from], kept[to]) = (true, true);
            let error = |index: &usize| {
                let (time, value) = &self.samples[*index];
                let share = (time - t0) / (t1 - t0).max(STEP);
                let apart = |axis: usize| (a[axis] + (b[axis] - a[axis]) * share - value[axis]).abs();
                (0..value.len()).map(apart).fold(0.0, f64::max)
            };
            let farthest = (from + 1..to).max_by(|x, y| error(x).total_cmp(&error(y)));
            if let Some(index) = farthest.filter(|index| error(index) > tolerance) {
                parts.extend([[from, index], [index, to]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(recording: &Recording) -> Vec<(i32, f32)> {
        let float = |value| if let Value::F32(value) = value { value } else { panic!("{value:?}") };
        recording.keys().into_iter().map(|(time, value)| ((time * 100.0).round() as i32, float(value))).collect()
    }

    #[test]
    fn a_gesture_becomes_few_keys() {
        let mut recorder = Recorder::default();
        let before = Value::F32(0.0);
        recorder.moved("fog", before, 1.0, &[0.0]);
        assert_eq!(recorder.frame(1.1, false), [], "it does not record");
        recorder.turn(true);
        // Up in a second, at rest for another, and down at once.
        for step in 0..=60 {
            let time = 1.0 + f64::from(step) / 60.0;
            recorder.moved("fog", before, time, &[f64::from(step) / 60.0]);
            assert_eq!(recorder.frame(time, true), []);
        }
        for step in 1..=60 {
            assert_eq!(recorder.frame(2.0 + f64::from(step) / 60.0, true), []);
        }
        recorder.moved("fog", before, 3.02, &[0.25]);
        let recording = &recorder.frame(3.03, false)[0];
        assert_eq!(keys(recording), [(100, 0.0), (200, 1.0), (300, 1.0), (302, 0.25)]);
        assert_eq!(recorder.frame(4.0, false), [], "it has ended");
    }

    /// The params of recordings, each with its keys.
    fn all(recordings: &[Recording]) -> Vec<(&str, Vec<(i32, f32)>)> {
        recordings.iter().map(|recording| (recording.param.as_str(), keys(recording))).collect()
    }

    #[test]
    fn a_motion_ends_where_the_demo_begins_anew() {
        let mut recorder = Recorder::default();
        recorder.turn(true);
        let before = Value::F32(0.5);
        recorder.moved("fog", before, 1.0, &[1.0]);
        // While the clock stands still, the last value counts.
        recorder.moved("fog", before, 1.0, &[2.0]);
        recorder.moved("sun", before, 1.0, &[3.0]);
        let ended = recorder.frame(0.2, true);
        assert_eq!(all(&ended), [("fog", vec![(100, 2.0)]), ("sun", vec![(100, 3.0)])]);
        assert_eq!(ended[0].before, before);
    }

    #[test]
    fn a_program_has_all_motions_at_the_end() {
        let mut recorder = Recorder::default();
        recorder.begin();
        let before = Value::F32(0.5);
        recorder.moved("fog", before, 1.0, &[1.0]);
        recorder.moved("sun", before, 1.0, &[3.0]);
        assert_eq!(recorder.frame(1.5, false), [], "a program holds nothing, and has not ended it");
        recorder.moved("fog", before, 2.0, &[2.0]);
        // The demo begins anew between two frames.
        recorder.moved("fog", before, 0.5, &[4.0]);
        let ended = recorder.end();
        let expected = [
            ("fog", vec![(100, 1.0), (150, 1.0), (200, 2.0)]),
            ("sun", vec![(100, 3.0), (150, 3.0)]),
            ("fog", vec![(50, 4.0)]),
        ];
        assert_eq!(all(&ended), expected);
        assert!(!recorder.is_on());
        // Those that moved last go on, with what a param was set to otherwise.
        recorder.go_on(ended);
        recorder.note(2.0, |param| (param == "fog").then(|| vec![5.0]));
        assert_eq!(recorder.frame(3.0, false), []);
        let expected = [
            ("fog", vec![(100, 1.0), (150, 1.0), (200, 2.0)]),
            ("sun", vec![(100, 3.0), (300, 3.0)]),
            ("fog", vec![(50, 4.0), (200, 5.0), (300, 5.0)]),
        ];
        assert_eq!(all(&recorder.end()), expected);
        recorder.begin();
        recorder.moved("fog", before, 1.0, &[1.0]);
        recorder.forget();
        assert_eq!((recorder.is_on(), recorder.end()), (true, Vec::new()));
    }

    /// Such a motion divides into a part with one sample and one with all others, again and again.
    #[test]
    fn a_long_motion_overflows_no_stack_and_no_memory() {
        let mut recorder = Recorder::default();
        recorder.begin();
        let before = Value::F32(0.0);
        for step in 0..40_000 {
            let swing = if step % 2 == 0 { -f64::from(step) } else { f64::from(step) };
            recorder.moved("fog", before, f64::from(step), &[swing]);
        }
        // And a rest of a day.
        for frame in 0..100_000 {
            recorder.frame(40_000.0 + f64::from(frame), false);
        }
        let ended = recorder.end();
        let samples: Vec<usize> = ended.iter().map(|recording| recording.samples.len()).collect();
        assert_eq!(samples, [MOST_SAMPLES, MOST_SAMPLES, 40_000 - 2 * MOST_SAMPLES + 1]);
        assert!(ended[2].keys().len() > 1000);
    }

    #[test]
    fn switches_and_whole_numbers_have_keys_where_they_change() {
        let mut recorder = Recorder::default();
        recorder.turn(true);
        for (time, value) in [(0.0, 3.0), (0.5, 3.0), (1.0, 4.0), (1.5, 4.0), (2.0, 3.0)] {
            recorder.moved("steps", Value::I32(3), time, &[value]);
        }
        let recording = &recorder.frame(2.1, false)[0];
        assert!(recording.steps());
        assert_eq!(recording.keys(), [(0.0, Value::I32(3)), (1.0, Value::I32(4)), (2.0, Value::I32(3))]);
    }
}
