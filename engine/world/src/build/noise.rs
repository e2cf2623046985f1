//! Fractal noise that is the same on every machine: plain 64-bit arithmetic, in a fixed order.

use super::simplex::{plane_noise, space_noise};

/// Fractal noise: octaves of OpenSimplex2, each finer and weaker than the last.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Same seed, same land.
    pub seed: u64,
    /// Waves a voxel of the first octave.
    pub frequency: f64,
    /// How many octaves, 1…16.
    pub octaves: u32,
    /// Frequency of an octave over that of the one before.
    pub lacunarity: f64,
    /// Strength of an octave over that of the one before.
    pub gain: f64,
    /// Fold every octave, so that its zeros become sharp crests.
    pub ridges: bool,
}

impl Noise {
    /// Coordinates in waves must stay below this, so that the lattice of the noise fits 32 bits after its skew.
    pub const MAX_WAVES: f64 = 1e9;

    /// Waves of the finest octave at a distance of `reach` voxels from the origin.
    pub fn waves(&self, reach: f64) -> f64 {
        reach * self.frequency * self.lacunarity.powi(self.octaves as i32 - 1).max(1.0)
    }

    /// Made ready to be sampled.
    pub(crate) fn sampler(&self) -> Sampler {
        self.sampler_for(1)
    }

    /// The same for samples so many voxels apart, but for octaves with less than two of them a wave, which would be taken at random places:
    /// their mean is zero, except where they are folded. One is always there.
    pub(crate) fn sampler_for(&self, spacing: i64) -> Sampler {
        let mut strength = 1.0;
        let mut frequency = self.frequency;
        let mut octaves: Vec<_> = (0..self.octaves)
            .map(|octave| {
                let seed = crate::random::mix(self.seed.wrapping_add(u64::from(octave))) as u32 as i32;
                let this = Octave { seed, frequency, strength };
                frequency *= self.lacunarity;
                strength *= self.gain;
                this
            })
            .collect();
        let total: f64 = octaves.iter().map(|octave| octave.strength).sum();
        if spacing > 1 && !self.ridges {
            let seen = |frequency: f64| 2.0 * spacing as f64 * frequency <= 1.0;
            if octaves.iter().any(|octave| seen(octave.frequency)) {
                octaves.retain(|octave| seen(octave.frequency));
            } else {
                octaves.truncate(1);
            }
        }
        Sampler { octaves, scale: 1.0 / total, ridges: self.ridges }
    }
}

/// Places that noise is worked out for at once: what two registers of the least of processors hold.
pub(crate) const AT_ONCE: usize = 8;

/// Noise made ready to be sampled.
pub(crate) struct Sampler {
    octaves: Vec<Octave>,
    scale: f64,
    ridges: bool,
}

struct Octave {
    seed: i32,
    /// Waves a voxel.
    frequency: f64,
    strength: f64,
}

impl Sampler {
    /// Over the plane, in −1…1.
    pub(crate) fn at(&self, x: &[f64; AT_ONCE], z: &[f64; AT_ONCE]) -> [f64; AT_ONCE] {
        self.sum(|octave| {
            let scaled = |c: &[f64; AT_ONCE]| c.map(|c| c * octave.frequency);
            plane_noise(octave.seed, scaled(x), scaled(z))
        })
    }

    /// In space, in −1…1.
    pub(crate) fn in_space<const N: usize>(&self, at: [[f64; N]; 3]) -> [f64; N] {
        self.sum(|octave| space_noise(octave.seed, at.map(|axis| axis.map(|c| c * octave.frequency))))
    }

    #[inline]
    fn sum<const N: usize>(&self, of: impl Fn(&Octave) -> [f32; N]) -> [f64; N] {
        let mut sum = [0.0; N];
        for octave in &self.octaves {
            for (sum, value) in sum.iter_mut().zip(of(octave).map(f64::from)) {
                *sum += octave.strength * if self.ridges { 1.0 - 2.0 * value.abs() } else { value };
            }
        }
        sum.map(|sum| (sum * self.scale).clamp(-1.0, 1.0))
    }
}
