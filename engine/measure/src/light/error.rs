//! The error of pictures, split into bias and noise, from two runs T and two references R with independent errors.
//!
//! With the weight w = 1 / (Rm² + ε), Rm = (R1 + R2) / 2, per channel, and the ε of the scene ([`Epsilon`]):
//!
//! * error = mean over both T of w (T − R1)(T − R2)
//! * bias² = mean of w (T1 − R1)(T2 − R2), and the same with R1 and R2 exchanged
//! * noise = ½ mean of w (T1 − T2)²
//! * gain = mean of T − Rm over mean of Rm: the share of all light that is too much, or lost if it is negative
//!
//! The noise of the references cancels on average, and error = bias² + noise holds exactly. Bias² may come out below 0 by about its standard
//! error, which is taken over tiles.

use serde::Serialize;

use super::Picture;

/// The ε of w = 1 / (Rm² + ε), which keeps the weight of dark pixels finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Epsilon {
    /// A third of the mean luminance of the reference, squared: so errors of a night count as those of a day do. The mean luminances of
    /// scenes with names are 0.21 to 0.41, for which this is 0.005 to 0.019.
    #[default]
    Mean,
    /// This number, for any light.
    Fixed(f64),
}

impl Epsilon {
    /// That of the scenes that have names. Figures of systems that were measured before scenes had an ε of their own stay comparable.
    pub const NAMED: Self = Self::Fixed(0.01);
    /// The least ε that follows light: of a scene that is black.
    pub const LEAST: f64 = 1e-8;

    /// The number, for light of this mean luminance.
    pub fn of(self, mean: f64) -> f64 {
        match self {
            Self::Fixed(epsilon) => epsilon,
            Self::Mean => (mean / 3.0).powi(2).max(Self::LEAST),
        }
    }
}

/// The formula, to be printed with the numbers.
pub const FORMULA: &str = "relMSE = mean of (T - R1)(T - R2) / (Rm^2 + e) over pixels and channels of linear light, Rm = (R1 + R2) / 2; \
     bias^2 with T1 and T2 in the two factors, noise = mean of (T1 - T2)^2 / (Rm^2 + e) / 2; relMSE = bias^2 + noise; \
     e = 0.01 in scenes with names, elsewhere the square of a third of the mean luminance";

/// How wrong a pair of runs is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Judged {
    /// Relative mean square error: of bias and noise together.
    pub error: f64,
    /// Its standard error.
    pub error_se: f64,
    /// Square of the relative bias: the part that more frames do not mend.
    pub bias2: f64,
    /// Its standard error.
    pub bias2_se: f64,
    /// Relative variance of a run.
    pub noise: f64,
    /// Mean light of the runs over that of the references, less 1: above 0 they have too much, below 0 they lose some. 0 where the references are black.
    pub gain: f64,
    /// Its standard error.
    pub gain_se: f64,
    /// The 99th percentile of pixels by w (T − Rm)²: fireflies.
    pub p99: f64,
    /// Texels of the runs that are infinite or no number; they count as black.
    pub not_finite: u64,
}

/// Judges two runs by two references, with an ε. All have the same size.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rank is at most the number of pixels")]
pub fn judge(runs: [&Picture; 2], references: [&Picture; 2], epsilon: f64) -> Judged {
    let [width, height] = runs[0].size.map(|side| side as usize);
    let side = if width * height >= 32 * 32 * 32 { 32 } else { 8 };
    let columns = width.div_ceil(side);
    let mut tiles = vec![Tile::default(); columns * height.div_ceil(side)];
    let (mut squares, mut noise, mut not_finite) = (Vec::with_capacity(width * height), 0.0, 0);
    for pixel in 0..width * height {
        let tile = &mut tiles[pixel / width / side * columns + pixel % width / side];
        tile.pixels += 1.0;
        let mut square = 0.0;
        for channel in 0..3 {
            let [r1, r2] = references.map(|picture| f64::from(picture.texels[pixel][channel]));
            let [t1, t2] = runs.map(|picture| {
                let value = picture.texels[pixel][channel];
                not_finite += u64::from(!value.is_finite());
                if value.is_finite() { f64::from(value) } else { 0.0 }
            });
            let middle = f64::midpoint(r1, r2);
            let weight = 1.0 / (middle * middle + epsilon) / 3.0;
            tile.error += weight * 0.5 * ((t1 - r1) * (t1 - r2) + (t2 - r1) * (t2 - r2));
            tile.gain += (f64::midpoint(t1, t2) - middle) / 3.0;
            tile.light += middle / 3.0;
            tile.bias2 += weight * 0.5 * ((t1 - r1) * (t2 - r2) + (t1 - r2) * (t2 - r1));
            noise += weight * 0.5 * (t1 - t2) * (t1 - t2);
            square += weight * 0.5 * ((t1 - middle).powi(2) + (t2 - middle).powi(2));
        }
        squares.push(square);
    }
    let pixels = squares.len().max(1) as f64;
    let rank = ((0.99 * pixels).ceil() as usize).clamp(1, squares.len().max(1)) - 1;
    let p99 = if squares.is_empty() { 0.0 } else { *squares.select_nth_unstable_by(rank, f64::total_cmp).1 };
    let (error, error_se) = mean(&tiles, pixels, |tile| tile.error);
    let (bias2, bias2_se) = mean(&tiles, pixels, |tile| tile.bias2);
    let (gain, gain_se) = gain(&tiles);
    Judged { error, error_se, bias2, bias2_se, noise: noise / pixels, gain, gain_se, p99, not_finite }
}

/// Sums over a tile of the picture.
#[derive(Clone, Default)]
struct Tile {
    pixels: f64,
    error: f64,
    bias2: f64,
    gain: f64,
    light: f64,
}

/// Light that is too much, as a share of all light, and its standard error as a ratio of sums over tiles.
fn gain(tiles: &[Tile]) -> (f64, f64) {
    let light: f64 = tiles.iter().map(|tile| tile.light).sum();
    if light <= 0.0 {
        return (0.0, 0.0);
    }
    let gain = tiles.iter().map(|tile| tile.gain).sum::<f64>() / light;
    let count = tiles.len() as f64;
    let spread: f64 = tiles.iter().map(|tile| (tile.gain - gain * tile.light).powi(2)).sum();
    (gain, if count > 1.0 { (spread * count / (count - 1.0)).sqrt() / light } else { f64::NAN })
}

/// Mean over pixels, and its standard error as a ratio of sums over tiles, which are nearly independent of each other.
fn mean(tiles: &[Tile], pixels: f64, of: impl Fn(&Tile) -> f64) -> (f64, f64) {
    let mean = tiles.iter().map(&of).sum::<f64>() / pixels;
    let count = tiles.len() as f64;
    let spread: f64 = tiles.iter().map(|tile| (of(tile) - mean * tile.pixels).powi(2)).sum();
    (mean, if count > 1.0 { (spread * count / (count - 1.0)).sqrt() / pixels } else { f64::NAN })
}

/// Weighted change from one picture to the next of the same run, by the same references.
pub fn flicker(before: &Picture, after: &Picture, references: [&Picture; 2], epsilon: f64) -> f64 {
    let mut sum = 0.0;
    for (pixel, (a, b)) in before.texels.iter().zip(&after.texels).enumerate() {
        for channel in 0..3 {
            let [r1, r2] = references.map(|picture| f64::from(picture.texels[pixel][channel]));
            let middle = f64::midpoint(r1, r2);
            sum += f64::from(b[channel] - a[channel]).powi(2) / (middle * middle + epsilon) / 3.0;
        }
    }
    sum / before.texels.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 40];

    /// A picture of 0.5 with an offset and even noise of a known variance, by a generator of whole numbers.
    fn noisy(offset: f64, variance: f64, seed: u64) -> Picture {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let width = (12.0 * variance).sqrt();
        let texels =
            (0..SIZE[0] * SIZE[1]).map(|_| std::array::from_fn(|_| (0.5 + offset + width * next()) as f32)).collect();
        Picture { size: SIZE, texels }
    }

    #[test]
    fn error_is_bias_and_noise() {
        let references = [noisy(0.0, 1e-3, 1), noisy(0.0, 1e-3, 2)];
        let runs = [noisy(0.1, 4e-3, 3), noisy(0.1, 4e-3, 4)];
        let judged = judge([&runs[0], &runs[1]], [&references[0], &references[1]], 0.01);
        assert!((judged.error - judged.bias2 - judged.noise).abs() < 1e-12, "{judged:?}");
        // 0.1² and 4·10⁻³, each by 0.5² + 0.01.
        assert!((judged.bias2 - 0.01 / 0.26).abs() < 4.0 * judged.bias2_se, "{judged:?}");
        assert!((judged.noise - 0.004 / 0.26).abs() < 5e-4, "{judged:?}");
        assert!(judged.bias2_se > 0.0 && judged.bias2_se < 1e-3, "{judged:?}");
        // 0.1 of 0.5.
        assert!((judged.gain - 0.2).abs() < 4.0 * judged.gain_se && judged.gain_se < 5e-3, "{judged:?}");
        let black = Picture { size: SIZE, texels: vec![[0.0; 3]; (SIZE[0] * SIZE[1]) as usize] };
        assert_eq!(judge([&runs[0], &runs[1]], [&black, &black], 0.01).gain.to_bits(), 0);
    }

    #[test]
    fn noise_of_the_references_is_no_error_and_what_has_no_bias_shows_none() {
        // The weights hold the references too, so their noise cancels only where it is small, as that of references is.
        let references = [noisy(0.0, 1e-3, 5), noisy(0.0, 1e-3, 6)];
        let truth = noisy(0.0, 0.0, 7);
        let judged = judge([&truth, &truth], [&references[0], &references[1]], 0.01);
        assert!(judged.error.abs() < 4.0 * judged.error_se && judged.noise == 0.0, "{judged:?}");
        let runs = [noisy(0.0, 1e-2, 8), noisy(0.0, 1e-2, 9)];
        let judged = judge([&runs[0], &runs[1]], [&references[0], &references[1]], 0.01);
        assert!(judged.bias2.abs() < 4.0 * judged.bias2_se, "{judged:?}");
        assert!(judged.error > 10.0 * judged.error_se, "{judged:?}");
    }

    /// The same picture at a thousandth of the light has the same error, by an ε that follows the light.
    #[test]
    fn night_counts_as_day_does() {
        let day = [noisy(0.0, 1e-3, 1), noisy(0.0, 1e-3, 2), noisy(0.1, 4e-3, 3), noisy(0.1, 4e-3, 4)];
        let of = |scale: f32, epsilon: Epsilon| {
            let [r1, r2, t1, t2] = day.each_ref().map(|picture| Picture {
                texels: picture.texels.iter().map(|texel| texel.map(|value| value * scale)).collect(),
                ..*picture
            });
            judge([&t1, &t2], [&r1, &r2], epsilon.of(f64::midpoint(r1.mean(), r2.mean()))).error
        };
        let [noon, night] = [1.0, 1e-3].map(|scale| of(scale, Epsilon::Mean));
        assert!((noon / night - 1.0).abs() < 1e-4, "{noon} {night}");
        assert!(of(1e-3, Epsilon::NAMED) < 1e-3 * of(1.0, Epsilon::NAMED));
        assert!((Epsilon::Mean.of(0.0) - Epsilon::LEAST).abs() < f64::EPSILON);
    }

    #[test]
    fn fireflies_and_what_is_no_number_are_seen() {
        let truth = noisy(0.0, 0.0, 1);
        let mut run = truth.clone();
        for pixel in run.texels.iter_mut().step_by(50) {
            *pixel = [5.5; 3];
        }
        run.texels[1] = [f32::NAN, f32::INFINITY, 0.5];
        let judged = judge([&run, &truth], [&truth, &truth], 0.01);
        assert_eq!(judged.not_finite, 2);
        // One of two runs has them: half of 5² / 0.26.
        assert!((judged.p99 - 12.5 / 0.26).abs() < 1e-3, "{judged:?}");
        assert!((flicker(&truth, &truth, [&truth, &truth], 0.01)).abs() < f64::EPSILON);
    }
}
