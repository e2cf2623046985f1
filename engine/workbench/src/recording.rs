//! A param that is moved while it is recorded becomes keys of a track.

use raxel_graph::checked::Value;
use raxel_runtime::params::{components, from_components, is_integer};

/// Keys have this distance at least, in seconds.
const STEP: f64 = 0.01;

/// The part of the range of a recording's values that a key less may change.
const TOLERANCE: f64 = 0.01;

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

/// Records params, while it is on.
#[derive(Debug, Default)]
pub struct Recorder {
    on: bool,
    recording: Option<Recording>,
    /// The demo does not drive the param meanwhile.
    released: bool,
}

impl Recorder {
    /// Whether it records.
    pub fn is_on(&self) -> bool {
        self.on
    }

    /// Begins, or ends.
    pub fn turn(&mut self, on: bool) {
        self.on = on;
    }

    /// The demo drives the param, and must not until it is released.
    pub fn release(&mut self) {
        self.released = true;
    }

    /// Whether the demo is to drive the param again. Says so once.
    pub fn gives_back(&mut self) -> bool {
        std::mem::take(&mut self.released)
    }

    /// A param was moved at a time, and had a value before. Gives the recording of another param, which has ended.
    pub fn moved(&mut self, param: &str, before: Value, time: f64, value: &[f64]) -> Option<Recording> {
        if !self.on {
            return None;
        }
        let ended = self.recording.take_if(|recording| recording.param != param);
        let recording =
            self.recording.get_or_insert_with(|| Recording { param: param.to_owned(), before, samples: Vec::new() });
        recording.add(time, value.to_vec());
        ended
    }

    /// A frame at a time, in which the param may rest. Returns the recording when it has ended: no param is held any more, or the demo has
    /// started over.
    pub fn frame(&mut self, time: f64, held: bool) -> Option<Recording> {
        let recording = self.recording.as_mut()?;
        let anew = recording.samples.last().is_some_and(|(last, _)| time < *last);
        if !held || anew {
            return self.recording.take();
        }
        if let Some((_, value)) = recording.samples.last().cloned() {
            recording.add(time, value);
        }
        None
    }
}

impl Recording {
    /// One key: the value of a param at a time, over a value that it has before a new track begins.
    pub fn key(param: &str, before: Value, time: f64, value: &Value) -> Self {
        Self { param: param.to_owned(), before, samples: vec![(time, components(value))] }
    }

    fn add(&mut self, time: f64, value: Vec<f64>) {
        match self.samples.last_mut() {
            Some((last, known)) if time < *last + STEP => *known = value,
            _ => self.samples.push((time, value)),
        }
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
    fn thin(&self, [from, to]: [usize; 2], tolerance: f64, kept: &mut [bool]) {
        let (Some((t0, a)), Some((t1, b))) = (self.samples.get(from), self.samples.get(to)) else { return };
        (kept[from], kept[to]) = (true, true);
        let error = |index: &usize| {
            let (time, value) = &self.samples[*index];
            let share = (time - t0) / (t1 - t0).max(STEP);
            let apart = |axis: usize| (a[axis] + (b[axis] - a[axis]) * share - value[axis]).abs();
            (0..value.len()).map(apart).fold(0.0, f64::max)
        };
        let farthest = (from + 1..to).max_by(|x, y| error(x).total_cmp(&error(y)));
        if let Some(index) = farthest.filter(|index| error(index) > tolerance) {
            self.thin([from, index], tolerance, kept);
            self.thin([index, to], tolerance, kept);
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
        assert_eq!(recorder.moved("fog", before, 1.0, &[0.0]), None);
        assert_eq!(recorder.frame(1.1, false), None, "it does not record");
        recorder.turn(true);
        // Up in a second, at rest for another, and down at once.
        for step in 0..=60 {
            let time = 1.0 + f64::from(step) / 60.0;
            recorder.moved("fog", before, time, &[f64::from(step) / 60.0]);
            assert_eq!(recorder.frame(time, true), None);
        }
        for step in 1..=60 {
            assert_eq!(recorder.frame(2.0 + f64::from(step) / 60.0, true), None);
        }
        recorder.moved("fog", before, 3.02, &[0.25]);
        let recording = recorder.frame(3.03, false).unwrap();
        assert_eq!(keys(&recording), [(100, 0.0), (200, 1.0), (300, 1.0), (302, 0.25)]);
        assert_eq!(recorder.frame(4.0, false), None, "it has ended");
    }

    #[test]
    fn a_take_ends_with_another_param_and_where_the_demo_begins_anew() {
        let mut recorder = Recorder::default();
        recorder.turn(true);
        let before = Value::F32(0.5);
        recorder.moved("fog", before, 1.0, &[1.0]);
        // While the clock stands still, the last value counts.
        recorder.moved("fog", before, 1.0, &[2.0]);
        let recording = recorder.moved("sun", before, 1.0, &[3.0]).unwrap();
        assert_eq!((recording.param.as_str(), keys(&recording), recording.before), ("fog", vec![(100, 2.0)], before));
        assert_eq!(recorder.frame(0.2, true).map(|recording| keys(&recording)), Some(vec![(100, 3.0)]));
    }

    #[test]
    fn switches_and_whole_numbers_have_keys_where_they_change() {
        let mut recorder = Recorder::default();
        recorder.turn(true);
        for (time, value) in [(0.0, 3.0), (0.5, 3.0), (1.0, 4.0), (1.5, 4.0), (2.0, 3.0)] {
            recorder.moved("steps", Value::I32(3), time, &[value]);
        }
        let recording = recorder.frame(2.1, false).unwrap();
        assert!(recording.steps());
        assert_eq!(recording.keys(), [(0.0, Value::I32(3)), (1.0, Value::I32(4)), (2.0, Value::I32(3))]);
    }
}
