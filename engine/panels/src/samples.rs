//! The last measurements of something, and their usual values.

use std::cell::OnceCell;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Measurements that are kept: four seconds at sixty frames a second.
const KEPT: usize = 240;

/// The usual value is found among the measurements of this time before the newest: where frames are slow, older ones count.
const RECENT: Duration = Duration::from_secs(4);

/// But among at least this many of them, of any age.
const FEWEST: usize = 3;

/// A window over the last measurements, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    kept: VecDeque<(f32, Instant)>,
    /// The only one that is kept is to give way to the next.
    warming: bool,
    /// The middle one and the 95th of 100, once somebody has asked: panels ask for them more than once a frame.
    usual: OnceCell<[Option<f32>; 2]>,
}

impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        (&self.kept, self.warming) == (&other.kept, other.warming)
    }
}

impl Samples {
    /// Measurements that drop the first one as soon as there is another: a driver may still compile in it.
    pub fn warming() -> Self {
        Self { warming: true, ..Self::default() }
    }

    /// Adds one; the oldest goes when there are too many. A value that is no finite number is left out.
    pub fn push(&mut self, value: f64) {
        self.push_at(value, Instant::now());
    }

    /// Adds one that was measured at a time, not before the one added last.
    #[expect(clippy::cast_possible_truncation, reason = "a graph of 32-bit floats is enough to look at")]
    fn push_at(&mut self, value: f64, at: Instant) {
        if !value.is_finite() {
            return;
        }
        if self.kept.len() == KEPT || (self.warming && self.kept.len() == 1) {
            self.kept.pop_front();
            self.warming = false;
        }
        self.kept.push_back((value as f32, at));
        self.usual.take();
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.kept.clear();
        self.usual.take();
    }

    /// From the oldest to the newest.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.kept.iter().map(|(value, _)| *value)
    }

    /// The newest.
    pub fn last(&self) -> Option<f32> {
        self.kept.back().map(|(value, _)| *value)
    }

    /// The median of the recent ones.
    pub fn median(&self) -> Option<f32> {
        self.usual()[0]
    }

    /// The one that 95 of 100 recent ones do not exceed.
    pub(crate) fn p95(&self) -> Option<f32> {
        self.usual()[1]
    }

    fn usual(&self) -> [Option<f32>; 2] {
        *self.usual.get_or_init(|| {
            let mut recent: Vec<f32> = self.recent().collect();
            [0.5, 0.95].map(|share| quantile(&mut recent, share))
        })
    }

    /// The recent ones, from the newest to the oldest.
    fn recent(&self) -> impl Iterator<Item = f32> + '_ {
        let newest = self.kept.back().map(|(_, at)| *at);
        let is_recent = move |at: Instant| newest.is_some_and(|newest| newest.saturating_duration_since(at) <= RECENT);
        let kept = self.kept.iter().rev().enumerate();
        kept.take_while(move |(age, (_, at))| *age < FEWEST || is_recent(*at)).map(|(_, (value, _))| *value)
    }
}

/// The nearest-rank quantile: the smallest measurement that a share `q` of them do not exceed.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a rank is at most the number of measurements"
)]
fn quantile(measured: &mut [f32], q: f64) -> Option<f32> {
    let rank = ((measured.len() as f64 * q).ceil() as usize).max(1) - 1;
    if rank >= measured.len() {
        return None;
    }
    Some(*measured.select_nth_unstable_by(rank, f32::total_cmp).1)
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
    fn slow_frames_are_not_outvoted_by_what_was_minutes_ago() {
        let (mut samples, start) = (Samples::default(), Instant::now());
        let mut second = 0;
        let mut push = |samples: &mut Samples, value| {
            second += 1;
            samples.push_at(value, start + Duration::from_secs(second));
        };
        (0..100).for_each(|_| push(&mut samples, 10.0));
        (0..3).for_each(|_| push(&mut samples, 900.0));
        assert_eq!((samples.median(), samples.p95(), samples.iter().len()), (Some(900.0), Some(900.0), 103));
        // A frame that takes longer than that does not stand alone.
        samples.push_at(7.0, start + Duration::from_secs(1000));
        assert_eq!((samples.median(), samples.last()), (Some(900.0), Some(7.0)));
    }

    #[test]
    fn only_the_newest_count() {
        let mut samples = Samples::default();
        (0..KEPT).for_each(|_| samples.push(1000.0));
        (0..KEPT).for_each(|_| samples.push(2.0));
        assert_eq!((samples.iter().len(), samples.p95()), (KEPT, Some(2.0)));
    }
}
