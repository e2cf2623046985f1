//! Brings sound from one number of samples a second to another: by a sinc that is cut off under both, as J. O. Smith, "Digital Audio Resampling
//! Home Page", describes it, with a Blackman window.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use super::SAMPLE_RATE;

/// Zeros of the sinc on each side.
const ZEROS: f64 = 24.0;

/// The part of the frequencies that both can hold which is kept.
const KEPT: f64 = 0.92;

/// Entries of the table for each sample that comes in.
const STEPS: usize = 128;

/// Makes [`SAMPLE_RATE`] samples a second of another number.
#[derive(Debug)]
pub(super) struct Resampler {
    /// Samples a second that come in.
    rate: u32,
    /// One side of the filter, `STEPS` entries a sample.
    filter: Vec<f32>,
    /// The newest samples: as many after the one that is made as before it.
    samples: VecDeque<f32>,
    /// The distance of the next sample behind the central one, in units of 1/`SAMPLE_RATE` of a sample.
    ahead: u32,
}

impl Resampler {
    pub(super) fn new(rate: u32) -> Self {
        let cut = (f64::from(SAMPLE_RATE) / f64::from(rate)).min(1.0) * KEPT;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a device has at most 1,000,000 samples a second"
        )]
        let reach = (ZEROS / cut).ceil() as usize;
        // Beyond the last entry is one more, since two are mixed.
        let filter = (0..reach * STEPS + 2).map(|at| tap(at as f64 / STEPS as f64, cut, reach as f64)).collect();
        Self { rate, filter, samples: VecDeque::from(vec![0.0; 2 * reach]), ahead: 0 }
    }

    /// Takes a sample, and gives those that can be made now.
    pub(super) fn push(&mut self, sample: f32, mut made: impl FnMut(f32)) {
        self.samples.pop_front();
        self.samples.push_back(sample);
        while self.ahead < SAMPLE_RATE {
            made(self.at(self.ahead as f32 / SAMPLE_RATE as f32));
            self.ahead += self.rate;
        }
        self.ahead -= SAMPLE_RATE;
    }

    /// The sound at that distance behind the central sample.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "distances are positive and at most the reach"
    )]
    fn at(&self, ahead: f32) -> f32 {
        let middle = (self.samples.len() / 2 - 1) as f32 + ahead;
        let weighted = self.samples.iter().enumerate().map(|(at, sample)| {
            let entry = (at as f32 - middle).abs() * STEPS as f32;
            let below = entry as usize;
            let (from, to) = (self.filter[below], self.filter[below + 1]);
            sample * (from + (to - from) * (entry - below as f32))
        });
        weighted.sum()
    }
}

/// The filter at a distance in samples.
#[expect(clippy::cast_possible_truncation, reason = "a weight")]
fn tap(distance: f64, cut: f64, reach: f64) -> f32 {
    if distance >= reach {
        return 0.0;
    }
    let x = PI * cut * distance;
    let sinc = if x == 0.0 { 1.0 } else { x.sin() / x };
    let turn = TAU * distance / (2.0 * reach);
    (cut * sinc * (0.42 + 0.5 * turn.cos() + 0.08 * (2.0 * turn).cos())) as f32
}
