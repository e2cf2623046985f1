//! The last measurements of something, and what is usual among them.

use std::collections::VecDeque;

/// Measurements that are kept: four seconds at sixty frames a second.
const KEPT: usize = 240;

/// A window over the last measurements, in the order in which they came.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    kept: VecDeque<f32>,
    /// The only one that is kept is to give way to the next.
    warming: bool,
}

impl Samples {
    /// Measurements of which the first counts only until there is another: a driver may still compile in it.
    pub fn warming() -> Self {
        Self { warming: true, ..Self::default() }
    }

    /// Adds one; the oldest goes when there are too many. What is no finite number is left out.
    #[expect(clippy::cast_possible_truncation, reason = "a graph of 32-bit floats is enough to look at")]
    pub fn push(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        if self.kept.len() == KEPT || (self.warming && self.kept.len() == 1) {
            self.kept.pop_front();
            self.warming = false;
        }
        self.kept.push_back(value as f32);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.kept.clear();
    }

    /// From the oldest to the newest.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.kept.iter().copied()
    }

    /// The newest.
    pub fn last(&self) -> Option<f32> {
        self.kept.back().copied()
    }

    /// The middle one by size.
    pub fn median(&self) -> Option<f32> {
        self.quantile(0.5)
    }

    /// The one that 95 of 100 do not exceed.
    pub fn p95(&self) -> Option<f32> {
        self.quantile(0.95)
    }

    /// The nearest-rank quantile: the smallest measurement that a share `q` of all do not exceed.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a rank is at most the number of samples"
    )]
    fn quantile(&self, q: f64) -> Option<f32> {
        let mut sorted: Vec<f32> = self.iter().collect();
        let rank = ((sorted.len() as f64 * q).ceil() as usize).max(1) - 1;
        if rank >= sorted.len() {
            return None;
        }
        Some(*sorted.select_nth_unstable_by(rank, f32::total_cmp).1)
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_by_nearest_rank() {
        let mut samples = Samples::default();
        assert_eq!((samples.median(), samples.p95(), samples.last()), (None, None, None));
        for value in (1..=100).rev() {
            samples.push(f64::from(value));
        }
        samples.push(f64::NAN);
        assert_eq!((samples.median(), samples.p95(), samples.last()), (Some(50.0), Some(95.0), Some(1.0)));
    }

    #[test]
    fn a_first_one_gives_way_to_the_second() {
        let mut samples = Samples::warming();
        samples.push(1500.0);
        assert_eq!((samples.median(), samples.p95()), (Some(1500.0), Some(1500.0)));
        samples.push(20.0);
        samples.push(22.0);
        assert_eq!((samples.median(), samples.p95(), samples.iter().len()), (Some(20.0), Some(22.0), 2));
    }

    #[test]
    fn only_the_newest_count() {
        let mut samples = Samples::default();
        (0..KEPT).for_each(|_| samples.push(1000.0));
        (0..KEPT).for_each(|_| samples.push(2.0));
        assert_eq!((samples.iter().len(), samples.p95()), (KEPT, Some(2.0)));
    }
}
