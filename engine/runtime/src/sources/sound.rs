//! Sounds that play: the spectrum and the waveform at the time of each frame. Those of a file follow from the time alone, so that
//! a film is the same at each run, and a seek needs nothing of the frames before. So do the microphone's, where it hears a file.

use std::fmt;
use std::sync::Arc;

use raxel_execute::ExternalResource;
use raxel_graph::Sound;
use raxel_media::sound::{TEXELS, silence, texels};
use raxel_timeline::inputs::{HISTORY, Heard, SAMPLE_RATE, samples_before};
use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use super::on_device::write_image;

/// Samples that one spectrum is made of. Its frequencies are `SAMPLE_RATE / WINDOW` apart, and a row has the lower half of them.
const WINDOW: usize = 2048;

/// Magnitudes that are shown, in decibels below a full one.
const QUIETEST: f32 = -100.0;
const LOUDEST: f32 = -30.0;

/// Spectra are smoothed over this many earlier steps of time. Each earlier step counts for less.
const STEPS: u32 = 24;
const STEP: u64 = SAMPLE_RATE as u64 / 60;
const FADE: f32 = 0.8;

/// A frame asks for no older sample than there is.
const _: () = assert!(WINDOW as u64 + (STEPS as u64 - 1) * STEP <= HISTORY as u64);

/// A sound that plays into a source.
pub(super) struct Listener {
    sound: Sound,
    transform: Arc<dyn RealToComplex<f32>>,
    weights: Vec<f32>,
    /// How many samples were over when the source's texels were made, and the version of the microphone's sound.
    heard: Option<(u64, u64)>,
    written: Vec<f32>,
    /// How often the source was written.
    serial: u64,
}

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} at {:?}", self.sound, self.heard)
    }
}

impl Listener {
    /// The source holds silence.
    pub(super) fn new(sound: &Sound) -> Self {
        Self {
            sound: sound.clone(),
            transform: RealFftPlanner::new().plan_fft_forward(WINDOW),
            weights: (0..WINDOW).map(blackman).collect(),
            heard: None,
            written: silence(),
            serial: 0,
        }
    }

    /// Brings spectrum and waveform of a time into the source, before the next frame of the session. At its end, a file begins again.
    pub(super) fn follow(&mut self, seconds: f64, microphone: &Heard<'_>, source: &Arc<ExternalResource>) {
        let of_file = self.sound.samples.is_some();
        let (over, changes) =
            if of_file { (samples_before(seconds), 0) } else { (microphone.over, microphone.changes) };
        if self.heard == Some((over, changes)) {
            return;
        }
        let values = match self.sound.samples.clone() {
            Some(samples) => self.values(over, |at| turn(&samples, at)),
            None => self.values(over, |at| microphone.sample(at)),
        };
        // Silence after silence makes no work.
        if values != self.written {
            // The shape was right when the graph was loaded.
            let Ok(image) = texels(&self.sound, &values) else { return };
            // If too many writes wait already, the next frame tries again.
            if !write_image(&image, source) {
                return;
            }
            (self.written, self.serial) = (values, self.serial + 1);
        }
        self.heard = Some((over, changes));
    }

    /// A number that changes with the contents of the source.
    pub(super) fn serial(&self) -> u64 {
        self.serial
    }

    /// Both rows, once `over` samples are over.
    fn values(&self, over: u64, sample: impl Fn(u64) -> i16) -> Vec<f32> {
        // In [−1, 1).
        let sample = |at| f32::from(sample(at)) / 32_768.0;
        let mut values = silence();
        let (spectrum, waveform) = values.split_at_mut(TEXELS as usize);
        let mut samples = self.transform.make_input_vec();
        let (mut bins, mut scratch) = (self.transform.make_output_vec(), self.transform.make_scratch_vec());
        let (mut weight, mut weights) = (1.0, 0.0);
        for step in 0..STEPS {
            if let Some(over) = over.checked_sub(u64::from(step) * STEP) {
                self.magnitudes(over, sample, &mut samples, &mut bins, &mut scratch);
                for (sum, bin) in spectrum.iter_mut().zip(&bins) {
                    *sum += weight * bin.norm();
                }
            }
            weights += weight;
            weight *= FADE;
        }
        for sum in &mut *spectrum {
            let decibels = 20.0 * (*sum / (weights * WINDOW as f32)).log10();
            *sum = ((decibels - QUIETEST) / (LOUDEST - QUIETEST)).clamp(0.0, 1.0);
        }
        for (texel, at) in waveform.iter_mut().zip(0..u64::from(TEXELS)) {
            *texel = 0.5 + 0.5 * (over + at).checked_sub(u64::from(TEXELS)).map_or(0.0, sample);
        }
        values
    }

    /// The spectrum of the samples before one.
    fn magnitudes(
        &self,
        over: u64,
        sample: impl Fn(u64) -> f32,
        samples: &mut [f32],
        bins: &mut [Complex<f32>],
        scratch: &mut [Complex<f32>],
    ) {
        for ((weighted, weight), at) in samples.iter_mut().zip(&self.weights).zip(0..WINDOW as u64) {
            *weighted = (over + at).checked_sub(WINDOW as u64).map_or(0.0, |at| weight * sample(at));
        }
        // All three have the lengths that the transform asked for.
        if self.transform.process_with_scratch(samples, bins, scratch).is_err() {
            bins.fill(Complex::default());
        }
    }
}

/// A sample of the first turn of a file or of a later one.
#[expect(clippy::cast_possible_truncation, reason = "the remainder is below the number of samples")]
fn turn(samples: &[i16], at: u64) -> i16 {
    samples[(at % samples.len() as u64) as usize]
}

/// The weight of a sample: Blackman's window with α = 0.16, as the Web Audio API has it.
fn blackman(at: usize) -> f32 {
    let turn = std::f32::consts::TAU * at as f32 / WINDOW as f32;
    0.42 - 0.5 * turn.cos() + 0.08 * (2.0 * turn).cos()
}

#[cfg(test)]
mod tests {
    use raxel_graph::ImageRequest;

    use super::*;

    /// A tone of a frequency and an amplitude between two samples, and nothing around it.
    fn tone(bin: f64, amplitude: f64, between: std::ops::Range<usize>, samples: usize) -> impl Fn(u64) -> Vec<f32> {
        let value = |at: usize| {
            let turns = bin * at as f64 / WINDOW as f64;
            let value = amplitude * (std::f64::consts::TAU * turns).sin();
            if between.contains(&at) { (value * 32_767.0).round() as i16 } else { 0 }
        };
        let samples: Vec<i16> = (0..samples).map(value).collect();
        let sound = Sound { path: "a.wav".to_owned(), samples: None, request: ImageRequest::default() };
        let listener = Listener::new(&sound);
        move |over| listener.values(over, |at| turn(&samples, at))
    }

    fn loudest(values: &[f32]) -> usize {
        (0..TEXELS as usize).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap()
    }

    #[test]
    fn a_tone_is_a_peak_at_its_frequency_and_while_it_sounds() {
        let second = SAMPLE_RATE as usize;
        for bin in [3, 40, 137, 500] {
            let heard = tone(bin as f64, 0.05, second..3 * second, 4 * second);
            assert_eq!(heard(second as u64), silence(), "nothing sounds before");
            let values = heard(2 * second as u64);
            assert_eq!(loudest(&values), bin);
            // Half of the amplitude, times the mean of the weights.
            let decibels = 20.0 * (0.05_f32 / 2.0 * 0.42).log10();
            let expected = (decibels + 100.0) / 70.0;
            assert!((values[bin] - expected).abs() < 0.005, "{} {expected}", values[bin]);
            assert!(values[(bin + 256) % 512] < 0.1, "{}", values[(bin + 256) % 512]);
            // It fades, and is gone after half a second.
            let after = |seconds: f64| heard(3 * second as u64 + samples_before(seconds))[bin];
            assert!(after(0.1) > 0.3 && after(0.1) < values[bin], "{}", after(0.1));
            assert!(after(0.5).abs() < f32::EPSILON, "{}", after(0.5));
        }
    }

    #[test]
    fn the_waveform_is_the_last_samples() {
        let heard = tone(8.0, 0.5, 0..4800, 4800);
        let values = heard(1000);
        for (texel, at) in [(512, 488), (600, 576), (1023, 999)] {
            let turns = 8.0 * f64::from(at) / WINDOW as f64;
            let expected = 0.5 + 0.25 * (std::f64::consts::TAU * turns).sin();
            assert!((f64::from(values[texel]) - expected).abs() < 1e-4, "{texel}: {} {expected}", values[texel]);
        }
        // Before the beginning is silence, and after the end the beginning.
        assert!((heard(100)[512 + 411] - 0.5).abs() < f32::EPSILON);
        assert_eq!(heard(4800 + 512)[512..], heard(512)[512..]);
    }

    #[test]
    fn far_times_are_heard() {
        let far = tone(8.0, 0.5, 0..4800, 4800)(samples_before(f64::MAX));
        assert!(far.iter().all(|value| value.is_finite()));
    }
}
