//! The microphone, as frames hear it. A frame's sound is a function of positions in time. Captured sound gets a position when it comes,
//! and the sound of a file has one from the beginning.

mod line;
mod resample;

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

pub use line::{Feed, Line};
pub use raxel_graph::supply::SAMPLE_RATE;

/// How many samples before its time a frame may ask for.
pub const HISTORY: usize = SAMPLE_RATE as usize / 2;

/// Seconds without a sample after which a device that captures is stuck.
const PATIENCE: u64 = 2;

/// A file that a microphone hears in place of a device.
#[derive(Clone)]
pub struct SoundFile {
    /// Its project path.
    pub path: String,
    /// All of it, as one channel, from 0 seconds on. Silence follows.
    pub samples: Arc<[i16]>,
}

impl fmt::Debug for SoundFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} samples of {}", self.samples.len(), self.path)
    }
}

/// The sound of frames: that of a demo's file, else of a given file, else of a device.
#[derive(Debug, Default)]
pub struct Microphone {
    line: Line,
    given: Option<SoundFile>,
    captured: Captured,
    /// The file that the last frame heard.
    file: Option<Arc<[i16]>>,
    /// How many samples were over in the last frame.
    over: u64,
    /// How often it began to hear something else.
    changes: u64,
}

impl Microphone {
    /// Where a device feeds its samples.
    pub fn line(&self) -> Line {
        self.line.clone()
    }

    /// Hears a file from the start of the session's time on, or a device again.
    pub fn give(&mut self, file: Option<SoundFile>) {
        self.given = file;
    }

    /// The file that was given.
    pub fn given(&self) -> Option<&SoundFile> {
        self.given.as_ref()
    }

    /// Whether a device captures and has given no sample for two seconds of the session.
    pub fn is_stuck(&self) -> bool {
        self.line.is_fed() && self.captured.missing >= PATIENCE * u64::from(SAMPLE_RATE)
    }

    /// Brings it to the time of the next frame. `demo` is the file of a demo, and the time in the demo.
    pub fn follow(&mut self, seconds: f64, demo: Option<(&Arc<[i16]>, f64)>) {
        let given = self.given.as_ref().map(|given| (&given.samples, seconds));
        let (file, seconds) = demo.or(given).map_or((None, seconds), |(file, seconds)| (Some(file.clone()), seconds));
        let over = samples_before(seconds);
        let same = match (&file, &self.file) {
            (Some(now), Some(before)) => Arc::ptr_eq(now, before),
            (None, None) => true,
            _ => false,
        };
        if !same || over < self.over {
            self.changes += 1;
        }
        if file.is_none() {
            self.captured.follow(over, &self.line);
        }
        (self.file, self.over) = (file, over);
    }

    /// The sound that the frame hears.
    pub fn heard(&self) -> Heard<'_> {
        Heard { microphone: self, over: self.over, changes: self.changes }
    }
}

/// The sound that a frame hears.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    microphone: &'a Microphone,
    /// How many samples are over.
    pub over: u64,
    /// How often the microphone began to hear something else.
    pub changes: u64,
}

impl Heard<'_> {
    /// The sample at a position, at most [`HISTORY`] before `over`. Silence before the start.
    pub fn sample(&self, at: u64) -> i16 {
        let sample = match &self.microphone.file {
            Some(file) => usize::try_from(at).ok().and_then(|at| file.get(at)).copied(),
            None => self.microphone.captured.sample(at),
        };
        sample.unwrap_or_default()
    }
}

/// The captured sound of a device, at the positions where frames first heard it. A frame gets as many samples as have passed. If there are
/// too few, the rest is silence: from then on, later samples are there in time.
#[derive(Debug, Default)]
struct Captured {
    samples: VecDeque<i16>,
    /// The position after the last.
    end: u64,
    /// How many samples a device has failed to give since its last one. Jumps of the time do not count.
    missing: u64,
}

impl Captured {
    fn follow(&mut self, over: u64, line: &Line) {
        if over < self.end {
            (self.samples, self.end, self.missing) = (VecDeque::new(), over, 0);
        }
        let wanted = over - self.end;
        let came = line.take(usize::try_from(wanted).unwrap_or(usize::MAX));
        let silence = wanted - came.len() as u64;
        // After a jump of the time, nothing can have come yet, so a silent device does not count as stuck.
        let passed = if wanted > u64::from(SAMPLE_RATE) { 0 } else { wanted };
        self.missing = if came.is_empty() && line.is_fed() { self.missing.saturating_add(passed) } else { 0 };
        let silence = usize::try_from(silence).map_or(HISTORY, |silence| silence.min(HISTORY));
        self.samples.extend(std::iter::repeat_n(0, silence).chain(came));
        let surplus = self.samples.len().saturating_sub(HISTORY);
        self.samples.drain(..surplus);
        self.end = over;
    }

    fn sample(&self, at: u64) -> Option<i16> {
        let back = usize::try_from(self.end.checked_sub(at)?).ok()?;
        self.samples.get(self.samples.len().checked_sub(back)?).copied()
    }
}

/// How many samples are over at a time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast of a float saturates")]
pub fn samples_before(seconds: f64) -> u64 {
    // A sample is over at its end, even if the product is rounded down.
    ((seconds.max(0.0) * f64::from(SAMPLE_RATE) + 1e-6).floor() as u64).min(u64::MAX / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The samples before a frame.
    fn last<const N: usize>(microphone: &Microphone) -> [i16; N] {
        let heard = microphone.heard();
        std::array::from_fn(|at| (heard.over + at as u64).checked_sub(N as u64).map_or(0, |at| heard.sample(at)))
    }

    fn seconds(samples: u64) -> f64 {
        samples as f64 / f64::from(SAMPLE_RATE)
    }

    /// Samples that are these whole numbers.
    fn hear(feed: &mut Feed, samples: std::ops::Range<i16>) {
        feed.hear(&samples.map(|sample| f32::from(sample) / 32_767.0).collect::<Vec<_>>());
    }

    #[test]
    fn a_frame_hears_what_came_before_it_and_silence_where_nothing_came() {
        let mut microphone = Microphone::default();
        microphone.follow(0.0, None);
        let mut feed = microphone.line().feed(SAMPLE_RATE, 1).unwrap();
        hear(&mut feed, 1..5);
        microphone.follow(seconds(2), None);
        assert_eq!(last::<3>(&microphone), [0, 1, 2]);
        // Two are left, and three are wanted.
        microphone.follow(seconds(5), None);
        assert_eq!(last::<6>(&microphone), [0, 1, 2, 0, 3, 4]);
        hear(&mut feed, 5..9);
        microphone.follow(seconds(5), None);
        assert_eq!(last::<2>(&microphone), [3, 4], "the clock stands still");
        microphone.follow(seconds(9), None);
        assert_eq!(last::<6>(&microphone), [3, 4, 5, 6, 7, 8]);
        // Time goes back: nothing was before.
        microphone.follow(seconds(2), None);
        assert_eq!(last::<6>(&microphone), [0; 6]);
        hear(&mut feed, 9..11);
        microphone.follow(seconds(4), None);
        assert_eq!(last::<3>(&microphone), [0, 9, 10]);
    }

    #[test]
    fn a_far_jump_takes_no_memory() {
        let mut microphone = Microphone::default();
        let mut feed = microphone.line().feed(SAMPLE_RATE, 1).unwrap();
        hear(&mut feed, 1..3);
        microphone.follow(1e18, None);
        assert_eq!(last::<3>(&microphone), [0, 1, 2]);
        assert_eq!(microphone.captured.samples.len(), HISTORY);
        microphone.follow(f64::MAX, None);
        microphone.follow(f64::NAN, None);
        assert_eq!(last::<3>(&microphone), [0; 3]);
    }

    #[test]
    fn a_file_is_heard_in_place_of_a_device() {
        let file = |samples: &[i16]| SoundFile { path: "a.wav".to_owned(), samples: samples.into() };
        let mut microphone = Microphone::default();
        microphone.give(Some(file(&[1, 2, 3, 4])));
        microphone.follow(seconds(3), None);
        let changes = microphone.heard().changes;
        assert_eq!(last::<4>(&microphone), [0, 1, 2, 3]);
        microphone.follow(seconds(6), None);
        assert_eq!(last::<4>(&microphone), [3, 4, 0, 0], "it does not begin again");
        assert_eq!(microphone.heard().changes, changes);
        // A demo's file is heard at the time of the demo.
        let of_demo = file(&[7, 8, 9]).samples;
        microphone.follow(seconds(7), Some((&of_demo, seconds(2))));
        assert_eq!(last::<3>(&microphone), [0, 7, 8]);
        assert_eq!(microphone.heard().changes, changes + 1);
        microphone.follow(seconds(8), Some((&of_demo, seconds(1))));
        assert_eq!((last::<2>(&microphone), microphone.heard().changes), ([0, 7], changes + 2), "the demo starts over");
        microphone.give(None);
        microphone.follow(seconds(9), None);
        assert_eq!((last::<2>(&microphone), microphone.heard().changes), ([0, 0], changes + 3));
    }

    #[test]
    fn a_device_that_gives_nothing_is_stuck() {
        let mut microphone = Microphone::default();
        microphone.follow(10.0, None);
        assert!(!microphone.is_stuck(), "there is no device");
        let mut feed = microphone.line().feed(8000, 1).unwrap();
        microphone.follow(11.0, None);
        microphone.follow(11.9, None);
        assert!(!microphone.is_stuck());
        microphone.follow(12.0, None);
        assert!(microphone.is_stuck());
        feed.hear(&[0.5; 100]);
        microphone.follow(12.1, None);
        assert!(!microphone.is_stuck(), "it goes on");
        microphone.follow(20.0, None);
        assert!(!microphone.is_stuck(), "the time jumped");
        microphone.follow(21.0, None);
        microphone.follow(22.0, None);
        assert!(microphone.is_stuck());
        drop(feed);
        assert!(!microphone.is_stuck(), "it is gone");
    }

    #[test]
    fn times_are_samples() {
        assert_eq!([0.0, -1.0, 1.0 / 48_000.0, 0.1, 3.0].map(samples_before), [0, 0, 1, 4800, 144_000]);
    }
}
