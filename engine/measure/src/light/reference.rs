//! The truth of a scene: two halves of a path tracer without a bias, of independent random numbers.

use raxel_graph::checked::Value;
use raxel_runtime::Session;
use serde::{Deserialize, Serialize};

use super::{Epsilon, LightError, Picture, RADIANCE, Scene, luminance, run};

/// Paths a pixel and frame: more in one dispatch would meet the limit of loop rounds of software devices.
const PATHS: u32 = 4;
/// The most on a GPU, where the numbers of frames are not to outgrow `frame.still`.
const MOST_PATHS: u32 = 16;

/// Two halves of a reference.
#[derive(Clone, Debug)]
pub struct References {
    /// The pictures.
    pub halves: [Picture; 2],
    /// The facts to keep beside them.
    pub about: About,
}

/// Where a reference comes from, and how good it is.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct About {
    /// The scene.
    pub scene: String,
    /// Pixels.
    pub size: [u32; 2],
    /// Paths a pixel of each half.
    pub paths: u32,
    /// Relative square error that the variance of the paths lets one expect of a half.
    pub forecast: f64,
    /// Half of the mean weighted square of the difference of the halves: the error that a half has.
    pub noise: f64,
    /// Mean luminance.
    pub mean: f64,
    /// The ε of all errors of the scene.
    pub epsilon: f64,
    /// BLAKE3 of each half's floats: the same on the same device and driver.
    pub hashes: [String; 2],
    /// Mean luminance with all lamps off; `None` where there are none.
    pub dark: Option<f64>,
    /// GPU milliseconds of a path a pixel.
    pub path_ms: f64,
    /// Whether an earlier run has made it.
    pub kept: bool,
}

impl References {
    /// Makes both halves in a session of the reference graph.
    pub(super) fn make(
        session: &mut Session,
        scene: &Scene,
        (goal, most): (f64, u32),
        gpu: bool,
    ) -> Result<Self, LightError> {
        let paths = if gpu { MOST_PATHS } else { PATHS }.min(most);
        session.set_param("paths", Value::I32(paths.cast_signed()))?;
        let (first, forecast, frames, path_ms) = until(session, goal, most.div_ceil(paths), paths, scene.epsilon)?;
        session.set_param("seed", Value::U32(SECOND_SEED))?;
        session.reset();
        for _ in 0..frames {
            session.frame()?;
        }
        let second = Picture::of(&session.read_target(RADIANCE)?);
        session.set_param("seed", Value::U32(FIRST_SEED))?;
        let dark = run::has_lamps(session).then(|| dark(session)).transpose()?;
        let mean = f64::midpoint(first.mean(), second.mean());
        let epsilon = scene.epsilon.of(mean);
        let judged = super::judge([&first, &second], [&first, &second], epsilon);
        let about = About {
            scene: scene.name.clone(),
            size: first.size,
            paths: frames * paths,
            forecast,
            noise: judged.noise,
            mean,
            epsilon,
            hashes: [first.hash(), second.hash()],
            dark,
            path_ms,
            kept: false,
        };
        Ok(Self { halves: [first, second], about })
    }

    /// Both halves, as they are judged by.
    pub fn both(&self) -> [&Picture; 2] {
        [&self.halves[0], &self.halves[1]]
    }
}

/// Seeds of the halves; runs have 1 and 2.
const FIRST_SEED: u32 = 0x7e57_0001;
const SECOND_SEED: u32 = 0x7e57_0002;

/// Frames until the variance of the paths forecasts an error below the goal.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts of floats saturate, and the number is clamped"
)]
fn until(
    session: &mut Session,
    goal: f64,
    most: u32,
    paths: u32,
    epsilon: Epsilon,
) -> Result<(Picture, f64, u32, f64), LightError> {
    session.set_param("seed", Value::U32(FIRST_SEED))?;
    session.reset();
    let (mut frames, mut next, mut times) = (0, 8.min(most), Vec::new());
    loop {
        while frames < next {
            session.frame()?;
            if times.len() < 32 {
                session.wait()?;
                times.push(session.timings().iter().filter_map(|pass| pass.nanoseconds).sum::<f64>() / 1e6);
            }
            frames += 1;
        }
        let (sums, squares) = (session.read_target("sum")?.floats(), session.read_target("squares")?.floats());
        let forecast = forecast(&sums, &squares, epsilon);
        if forecast <= goal || frames >= most {
            times.sort_by(f64::total_cmp);
            let path_ms = times[times.len() / 2] / f64::from(paths);
            return Ok((Picture::of(&session.read_target(RADIANCE)?), forecast, frames, path_ms));
        }
        // As many as the forecast requires, in steps, so that there is a new forecast after each.
        let wanted = (f64::from(frames) * forecast / goal * 1.05).min(4.0 * f64::from(frames));
        next = (wanted.ceil() as u32).clamp(frames + 1, most);
    }
}

/// Mean of σ² / n / (μ² + ε) over pixels and channels, from sums and sums of squares of n paths.
fn forecast(sums: &[[f32; 4]], squares: &[[f32; 4]], epsilon: Epsilon) -> f64 {
    let bright = |[r, g, b, n]: &[f32; 4]| luminance(&[*r, *g, *b]) / f64::from(*n);
    let light = sums.iter().map(bright).filter(|value| value.is_finite()).sum::<f64>() / sums.len().max(1) as f64;
    let epsilon = epsilon.of(light);
    let channel = |sum: f32, square: f32, n: f64| {
        let mean = f64::from(sum) / n;
        let variance = (f64::from(square) / n - mean * mean).max(0.0);
        variance / (n - 1.0).max(1.0) / (mean * mean + epsilon)
    };
    let pixel = |(sum, square): (&[f32; 4], &[f32; 4])| {
        (0..3).map(|i| channel(sum[i], square[i], f64::from(sum[3]))).sum::<f64>() / 3.0
    };
    sums.iter().zip(squares).map(pixel).sum::<f64>() / sums.len().max(1) as f64
}

/// Mean luminance without lamps.
fn dark(session: &mut Session) -> Result<f64, LightError> {
    session.set_param("lamp_strength", Value::F32(0.0))?;
    session.reset();
    for _ in 0..16 {
        session.frame()?;
    }
    let mean = Picture::of(&session.read_target(RADIANCE)?).mean();
    session.unset_param("lamp_strength")?;
    Ok(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forecast_is_the_variance_of_the_mean() {
        // Two values, 0 and 2, in equal parts over 100 paths: mean 1, variance 1.
        let (sums, squares) = ([[100.0, 100.0, 100.0, 100.0]], [[200.0, 200.0, 200.0, 0.0]]);
        assert!((forecast(&sums, &squares, Epsilon::NAMED) - 1.0 / 99.0 / 1.01).abs() < 1e-9);
        // Their mean luminance is 1, and a hundredth of it makes no difference to an ε that follows it.
        let bright = forecast(&sums, &squares, Epsilon::Mean);
        assert!((bright - 1.0 / 99.0 / (1.0 + 1.0 / 9.0)).abs() < 1e-9);
        let dim = forecast(&[[1.0, 1.0, 1.0, 100.0]], &[[0.02, 0.02, 0.02, 0.0]], Epsilon::Mean);
        assert!((dim - bright).abs() < 1e-6, "{dim} {bright}");
    }
}
