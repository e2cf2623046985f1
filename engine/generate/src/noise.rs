//! Fractal noise that is the same on every machine: plain 64-bit arithmetic, in a fixed order.

#![allow(clippy::inline_always, reason = "what is not inlined is not compiled for the processor at hand")]

use pulp::{Arch, Simd, WithSimd};

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
        reach * self.frequency * self.lacunarity.powi(self.octaves.cast_signed() - 1).max(1.0)
    }

    /// Made ready to be sampled.
    pub(crate) fn sampler(&self) -> Sampler {
        self.sampler_for(1)
    }

    /// The same for samples `spacing` voxels apart, but without octaves that have less than two samples a wave, which would be taken at
    /// random places: their mean is zero, except where they are folded. One is always there.
    #[expect(clippy::cast_possible_truncation, reason = "any 32 bits of a mixed seed will do")]
    pub(crate) fn sampler_for(&self, spacing: i64) -> Sampler {
        let mut strength = 1.0;
        let mut frequency = self.frequency;
        let mut octaves: Vec<_> = (0..self.octaves)
            .map(|octave| {
                let seed = raxel_world::random::mix(self.seed.wrapping_add(u64::from(octave))) as i32;
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
        Sampler { processor: Arch::new(), octaves, scale: 1.0 / total, ridges: self.ridges }
    }
}

/// Places that noise is computed for at once: two registers of the least of processors.
pub(crate) const AT_ONCE: usize = 8;

/// Noise made ready to be sampled.
pub(crate) struct Sampler {
    /// The wider processor that the noise is also compiled for: its registers are twice those of the least one. Every bit stays the same.
    processor: Arch,
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
        self.processor.dispatch(OverPlane { sampler: self, x, z })
    }

    /// In space, in −1…1.
    pub(crate) fn in_space<const N: usize>(&self, at: [[f64; N]; 3]) -> [f64; N] {
        self.processor.dispatch(InSpace { sampler: self, at })
    }

    #[inline(always)]
    fn sum<const N: usize>(&self, of: impl Fn(&Octave) -> [f32; N]) -> [f64; N] {
        let mut sum = [0.0; N];
        for octave in &self.octaves {
            let values = of(octave);
            for n in 0..N {
                let value = f64::from(values[n]);
                sum[n] += octave.strength * if self.ridges { 1.0 - 2.0 * value.abs() } else { value };
            }
        }
        sum.map(|sum| (sum * self.scale).clamp(-1.0, 1.0))
    }
}

/// [`Sampler::at`], for any processor.
struct OverPlane<'s> {
    sampler: &'s Sampler,
    x: &'s [f64; AT_ONCE],
    z: &'s [f64; AT_ONCE],
}

impl WithSimd for OverPlane<'_> {
    type Output = [f64; AT_ONCE];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { sampler, x, z } = self;
        sampler.sum(|octave| {
            let scaled = |c: &[f64; AT_ONCE]| std::array::from_fn(|n| c[n] * octave.frequency);
            plane_noise(octave.seed, scaled(x), scaled(z))
        })
    }
}

/// [`Sampler::in_space`], for any processor.
struct InSpace<'s, const N: usize> {
    sampler: &'s Sampler,
    at: [[f64; N]; 3],
}

impl<const N: usize> WithSimd for InSpace<'_, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { sampler, at } = self;
        sampler.sum(|octave| {
            space_noise(
                octave.seed,
                std::array::from_fn(|axis| std::array::from_fn(|n| at[axis][n] * octave.frequency)),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_processor_gives_the_same_bits() {
        let noise = Noise { seed: 3, frequency: 0.016, octaves: 4, lacunarity: 2.0, gain: 0.5, ridges: false };
        for (sampler, ridges) in [(noise.sampler(), false), (Noise { ridges: true, ..noise }.sampler(), true)] {
            let mut random = raxel_world::random::SplitMix64::new(7);
            for n in 0..20_000 {
                let reach = if n % 2 == 0 { 1000.0 } else { 1_073_741_824.0 };
                let mut place = || std::array::from_fn(|_| reach * (random.below(1 << 20) as f64 / 524_288.0 - 1.0));
                let at: [[f64; AT_ONCE]; 3] = [place(), place(), place()];
                let [x, _, z] = &at;
                let least = OverPlane { sampler: &sampler, x, z }.with_simd(pulp::Scalar::new());
                assert_eq!(sampler.at(x, z).map(f64::to_bits), least.map(f64::to_bits), "{ridges} {at:?}");
                let least = InSpace { sampler: &sampler, at }.with_simd(pulp::Scalar::new());
                assert_eq!(sampler.in_space(at).map(f64::to_bits), least.map(f64::to_bits), "{ridges} {at:?}");
            }
        }
    }
}
