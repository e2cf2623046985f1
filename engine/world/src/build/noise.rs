//! Fractal noise that is the same on every machine: plain 64-bit arithmetic, in a fixed order.

use fastnoise_lite::{FastNoiseLite, NoiseType};

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
                let seed = crate::random::mix(self.seed.wrapping_add(u64::from(octave)));
                let mut noise = FastNoiseLite::with_seed(seed as u32 as i32);
                noise.set_noise_type(Some(NoiseType::OpenSimplex2));
                noise.set_frequency(Some(1.0));
                let this = (noise, frequency, strength);
                frequency *= self.lacunarity;
                strength *= self.gain;
                this
            })
            .collect();
        let total: f64 = octaves.iter().map(|(_, _, strength)| strength).sum();
        if spacing > 1 && !self.ridges {
            let seen = |frequency: f64| 2.0 * spacing as f64 * frequency <= 1.0;
            if octaves.iter().any(|(_, frequency, _)| seen(*frequency)) {
                octaves.retain(|(_, frequency, _)| seen(*frequency));
            } else {
                octaves.truncate(1);
            }
        }
        Sampler { octaves, scale: 1.0 / total, ridges: self.ridges }
    }
}

/// Noise made ready to be sampled.
pub(crate) struct Sampler {
    octaves: Vec<(FastNoiseLite, f64, f64)>,
    scale: f64,
    ridges: bool,
}

impl Sampler {
    /// Over the plane, in −1…1.
    pub(crate) fn at(&self, x: f64, z: f64) -> f64 {
        self.sum(|noise, frequency| noise.get_noise_2d(x * frequency, z * frequency))
    }

    /// In space, in −1…1.
    pub(crate) fn in_space(&self, [x, y, z]: [f64; 3]) -> f64 {
        self.sum(|noise, frequency| noise.get_noise_3d(x * frequency, y * frequency, z * frequency))
    }

    fn sum(&self, of: impl Fn(&FastNoiseLite, f64) -> f32) -> f64 {
        let mut sum = 0.0;
        for (noise, frequency, strength) in &self.octaves {
            let value = f64::from(of(noise, *frequency));
            sum += strength * if self.ridges { 1.0 - 2.0 * value.abs() } else { value };
        }
        (sum * self.scale).clamp(-1.0, 1.0)
    }
}
