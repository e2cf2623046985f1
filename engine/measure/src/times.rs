//! Times of the same thing, taken many times.

use serde::Serialize;

/// Times in the order in which they were taken.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Times {
    /// Each time.
    pub milliseconds: Vec<f64>,
}

impl Times {
    /// The value that `part` (0 to 1) of the times do not exceed: the nearest rank. Not a number where nothing was timed.
    pub fn percentile(&self, part: f64) -> f64 {
        percentile(self.milliseconds.iter().copied(), part)
    }
}

/// The value that `part` (0 to 1) of some values do not exceed: the nearest rank.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rank is at most the number of values")]
pub fn percentile(values: impl Iterator<Item = f64>, part: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let rank = (part * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "ranks are picked from the samples, not computed")]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let times = Times { milliseconds: vec![5.0, 1.0, 4.0, 2.0, 3.0] };
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|part| times.percentile(part)), [1.0, 3.0, 5.0, 5.0]);
        assert!(Times::default().percentile(0.5).is_nan());
    }
}
