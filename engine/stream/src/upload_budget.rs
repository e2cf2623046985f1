//! Limits the bytes that each frame uploads to the device.

use std::time::{Duration, Instant};

/// A frame that takes longer than this counts as several, so that a window that draws nothing still loads its world.
const FRAME: Duration = Duration::from_millis(33);

/// The most frames over which one large write is paid back.
const MOST_DEBT: i64 = 8;

/// A number of bytes for each frame. A write may start while any are left, and may take more than are left: the following frames then have fewer.
#[derive(Debug)]
pub(crate) struct UploadBudget {
    /// Bytes for each frame; `None` sets no limit.
    each: Option<i64>,
    left: i64,
    given: Instant,
    /// Bytes written in this frame.
    spent: u64,
    /// Bytes written in the frame that wrote most.
    most: u64,
}

impl UploadBudget {
    pub(crate) fn new(each: Option<u64>, now: Instant) -> Self {
        let each = each.map(|each| i64::try_from(each).unwrap_or(i64::MAX).max(1));
        Self { each, left: each.unwrap_or(0), given: now, spent: 0, most: 0 }
    }

    /// A frame begins.
    pub(crate) fn frame(&mut self, now: Instant) {
        let each = self.each.unwrap_or(0);
        self.left = self.left.saturating_add(each).min(each);
        self.given = now;
        self.spent = 0;
    }

    /// How long the next write has to wait for the next frame; `None` when it can start now.
    pub(crate) fn wait(&mut self, now: Instant) -> Option<Duration> {
        let each = self.each?;
        let passed = now.saturating_duration_since(self.given);
        if self.left <= 0 && passed >= FRAME {
            let frames = i64::try_from(passed.as_nanos() / FRAME.as_nanos()).unwrap_or(i64::MAX);
            self.left = self.left.saturating_add(each.saturating_mul(frames)).min(each);
            self.given = now;
            self.spent = 0;
        }
        (self.left <= 0).then(|| FRAME.saturating_sub(now.saturating_duration_since(self.given)))
    }

    /// Counts bytes that are written.
    pub(crate) fn spend(&mut self, bytes: u64) {
        self.spent += bytes;
        self.most = self.most.max(self.spent);
        if let Some(each) = self.each {
            let bytes = i64::try_from(bytes).unwrap_or(i64::MAX);
            self.left = self.left.saturating_sub(bytes).max(each.saturating_mul(-MOST_DEBT));
        }
    }

    /// Bytes written in the frame that wrote most.
    pub(crate) fn most(&self) -> u64 {
        self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_its_bytes_and_pays_for_what_the_last_one_took_too_many() {
        let start = Instant::now();
        let mut budget = UploadBudget::new(Some(1000), start);
        assert_eq!(budget.wait(start), None);
        budget.spend(600);
        assert_eq!(budget.wait(start), None, "there are some left");
        budget.spend(1800);
        assert!(budget.wait(start).is_some_and(|wait| wait <= FRAME));
        budget.frame(start);
        assert!(budget.wait(start).is_some(), "1400 too many");
        budget.frame(start);
        assert_eq!(budget.wait(start), None);
        budget.spend(100);
        // Unused budget is not saved up.
        (0..5).for_each(|_| budget.frame(start));
        budget.spend(1000);
        assert!(budget.wait(start).is_some());
        assert_eq!(budget.most(), 2400);
    }

    #[test]
    fn without_frames_time_counts() {
        let start = Instant::now();
        let mut budget = UploadBudget::new(Some(1000), start);
        budget.spend(3500);
        assert!(budget.wait(start + FRAME / 2).is_some());
        assert!(budget.wait(start + FRAME).is_some());
        assert_eq!(budget.wait(start + 4 * FRAME), None);
        // However large it was, it does not stop everything for ever.
        budget.spend(1 << 40);
        (0..=MOST_DEBT).for_each(|_| budget.frame(start + 4 * FRAME));
        assert_eq!(budget.wait(start + 4 * FRAME), None);
    }

    #[test]
    fn no_number_is_any_number() {
        let start = Instant::now();
        let mut budget = UploadBudget::new(None, start);
        budget.spend(1 << 40);
        assert_eq!((budget.wait(start), budget.most()), (None, 1 << 40));
    }
}
