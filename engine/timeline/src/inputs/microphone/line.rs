//! The line from a device to a session. The thread of the device writes to it, and a frame takes the samples that have come. Neither waits
//! for the other longer than a copy takes.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::SAMPLE_RATE;
use super::resample::Resampler;

/// Samples that wait at most: older ones are dropped.
const MOST_WAITING: usize = SAMPLE_RATE as usize;

/// Samples that may be left for later frames. A device gives some hundred or thousand at once.
const MOST_LEFT: usize = SAMPLE_RATE as usize / 4;

/// Samples a second that a device may capture.
const RATES: std::ops::RangeInclusive<u32> = 1000..=1_000_000;

/// Channels that a device may have.
const CHANNELS: std::ops::RangeInclusive<u16> = 1..=256;

/// Where a device feeds its samples.
#[derive(Clone, Debug, Default)]
pub struct Line(Arc<Mutex<Waiting>>);

#[derive(Debug, Default)]
struct Waiting {
    samples: VecDeque<i16>,
    /// How many devices have begun to capture. The last of them alone is heard.
    devices: u64,
    /// It still captures.
    fed: bool,
}

impl Line {
    /// Begins to feed the samples of a device, in the place of any other. The error names a rate or a number of channels that no device
    /// has.
    pub fn feed(&self, rate: u32, channels: u16) -> Result<Feed, String> {
        if !RATES.contains(&rate) || !CHANNELS.contains(&channels) {
            return Err(format!(
                "it captures {channels} channels with {rate} samples a second, and raxel hears 1 to 256 with 1,000 to 1,000,000"
            ));
        }
        let resampler = (rate != SAMPLE_RATE).then(|| Resampler::new(rate));
        let mut waiting = self.waiting();
        let device = waiting.devices + 1;
        *waiting = Waiting { samples: VecDeque::new(), devices: device, fed: true };
        Ok(Feed { line: self.clone(), device, channels: channels.into(), resampler, samples: Vec::new() })
    }

    /// Whether a device captures.
    pub(super) fn is_fed(&self) -> bool {
        self.waiting().fed
    }

    /// The oldest waiting samples, at most `wanted`.
    pub(super) fn take(&self, wanted: usize) -> Vec<i16> {
        let samples = &mut self.waiting().samples;
        // The device is faster than the clock of the session, or the clock stood still.
        if samples.len() > wanted.saturating_add(MOST_LEFT) {
            samples.drain(..samples.len() - wanted - MOST_LEFT / 2);
        }
        let wanted = wanted.min(samples.len());
        samples.drain(..wanted).collect()
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Takes the samples of a device, in its own form. The device is gone when this is dropped.
#[derive(Debug)]
pub struct Feed {
    line: Line,
    /// Its number, from 1.
    device: u64,
    channels: usize,
    /// Unless it captures as many samples a second as frames hear.
    resampler: Option<Resampler>,
    /// Reused from call to call.
    samples: Vec<i16>,
}

impl Feed {
    /// Hears samples, in [−1, 1] and with the channels next to each other. Channels are mixed to one. Samples that are not finite are
    /// silence.
    pub fn hear(&mut self, samples: &[f32]) {
        self.samples.clear();
        for frame in samples.chunks_exact(self.channels) {
            let finite = frame.iter().filter(|sample| sample.is_finite());
            let sample = finite.map(|sample| sample.clamp(-1.0, 1.0)).sum::<f32>() / self.channels as f32;
            match &mut self.resampler {
                Some(resampler) => resampler.push(sample, |sample| self.samples.push(stored(sample))),
                None => self.samples.push(stored(sample)),
            }
        }
        let mut waiting = self.line.waiting();
        // A device that another one has replaced may still be on its way out.
        if waiting.devices != self.device {
            return;
        }
        let newest = &self.samples[self.samples.len().saturating_sub(MOST_WAITING)..];
        let surplus = (waiting.samples.len() + newest.len()).saturating_sub(MOST_WAITING);
        waiting.samples.drain(..surplus);
        waiting.samples.extend(newest);
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        let mut waiting = self.line.waiting();
        if waiting.devices == self.device {
            waiting.fed = false;
        }
    }
}

/// A sample as files have it.
#[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates")]
fn stored(sample: f32) -> i16 {
    (sample * 32_767.0).round() as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The samples of a device that captures a second of a tone, in pieces of `piece` bytes.
    fn tone(rate: u32, channels: u16, hertz: f64, amplitude: f64, piece: usize) -> Vec<i16> {
        let line = Line::default();
        let mut feed = line.feed(rate, channels).unwrap();
        let mut samples = Vec::new();
        for at in 0..rate {
            let value = amplitude * (std::f64::consts::TAU * hertz * f64::from(at) / f64::from(rate)).sin();
            samples.extend(std::iter::repeat_n(value as f32, channels.into()));
        }
        samples.chunks(piece * usize::from(channels)).for_each(|piece| feed.hear(piece));
        line.take(MOST_WAITING)
    }

    /// The amplitude of a frequency in the central part of a second.
    fn amplitude(samples: &[i16], hertz: f64) -> f64 {
        let middle = &samples[12_000..36_000];
        let part = |of: fn(f64) -> f64| {
            let turn = std::f64::consts::TAU * hertz / f64::from(SAMPLE_RATE);
            middle.iter().zip(0..).map(|(sample, at)| f64::from(*sample) * of(turn * f64::from(at))).sum::<f64>()
        };
        part(f64::sin).hypot(part(f64::cos)) / middle.len() as f64 * 2.0 / 32_767.0
    }

    #[test]
    fn every_rate_and_every_number_of_channels_sounds_alike() {
        for (rate, channels) in [(8000, 1), (11_025, 2), (44_100, 2), (48_000, 6), (96_000, 1), (192_000, 8)] {
            let samples = tone(rate, channels, 1000.0, 0.5, 441);
            let count = samples.len() as i64;
            assert!((count - 48_000).abs() <= 200, "{rate} Hz: {count} samples");
            let [heard, other] = [1000.0, 3500.0].map(|hertz| amplitude(&samples, hertz));
            assert!((heard - 0.5).abs() < 0.001 && other < 0.0005, "{rate} Hz: {heard} {other}");
        }
        // A tone that 48,000 samples a second cannot hold must not sound as another one.
        let samples = tone(192_000, 1, 45_000.0, 0.5, 1000);
        assert!(amplitude(&samples, 3000.0) < 0.0005, "{}", amplitude(&samples, 3000.0));
        // A tone of a device with few samples has no image above them.
        let samples = tone(8000, 1, 1000.0, 0.5, 1000);
        assert!(amplitude(&samples, 7000.0) < 0.0005, "{}", amplitude(&samples, 7000.0));
    }

    #[test]
    fn samples_that_are_no_numbers_are_silence() {
        for rate in [SAMPLE_RATE, 44_100] {
            let line = Line::default();
            let mut feed = line.feed(rate, 2).unwrap();
            feed.hear(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN].repeat(200));
            assert!(line.take(1000).iter().all(|sample| *sample == 0));
        }
        let line = Line::default();
        let mut feed = line.feed(SAMPLE_RATE, 2).unwrap();
        feed.hear(&[f32::NAN, 0.5, 1e30, 1.0, -1e30, -1.0, 0.25]);
        assert_eq!(line.take(10), [8192, 32_767, -32_767], "the last has no other channel");
    }

    #[test]
    fn memory_is_bounded_and_the_newest_stay() {
        let line = Line::default();
        let mut feed = line.feed(SAMPLE_RATE, 1).unwrap();
        for piece in 0..10_u16 {
            feed.hear(&vec![f32::from(piece) / 32_767.0; 30_000]);
        }
        assert_eq!(line.waiting().samples.len(), MOST_WAITING);
        // A frame takes its part, and the rest is not old.
        assert_eq!(line.take(800).len(), 800);
        assert_eq!(line.waiting().samples.len(), MOST_LEFT / 2);
        feed.hear(&vec![1.0; 3 * MOST_WAITING]);
        assert_eq!(line.take(usize::MAX), vec![32_767; MOST_WAITING]);
        assert!(line.take(usize::MAX).is_empty());
    }

    #[test]
    fn a_device_that_was_replaced_is_not_heard() {
        let line = Line::default();
        let mut old = line.feed(SAMPLE_RATE, 1).unwrap();
        let mut new = line.feed(SAMPLE_RATE, 1).unwrap();
        old.hear(&[1.0; 8]);
        new.hear(&[0.5; 2]);
        drop(old);
        assert!(line.is_fed(), "the new one captures");
        assert_eq!(line.take(10), [16_384; 2]);
        drop(new);
        assert!(!line.is_fed());
    }

    #[test]
    fn no_device_is_like_this() {
        let line = Line::default();
        for (rate, channels) in [(0, 1), (48_000, 0), (u32::MAX, 2), (48_000, 257)] {
            let error = line.feed(rate, channels).unwrap_err();
            assert!(error.starts_with(&format!("it captures {channels} channels with {rate} samples")), "{error}");
        }
        assert!(!line.is_fed());
    }
}
