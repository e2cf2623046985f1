//! How many bytes frames bring to the device.

use std::time::{Duration, Instant};

/// A frame that takes longer than this counts as several, so that a window that draws nothing is loaded all the same.
const FRAME: Duration = Duration::from_millis(33);

/// Frames that a single large write is paid back in at most.
const MOST_DEBT: i64 = 8;

/// A number of bytes for each frame. A write begins while some are left, and may take more than that: the frames after it have less.
#[derive(Debug)]
pub(crate) struct Allowance {
    /// Bytes for each frame; `None` is any number of them.
    each: Option<i64>,
    left: i64,
    given: Instant,
    /// Bytes of this frame, and of the frame with the most of them.
    spent: u64,
    most: u64,
}

impl Allowance {
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

    /// How long to wait for the next frame before the next write; `None` when it can begin now.
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

    /// So many bytes are written.
    pub(crate) fn spend(&mut self, bytes: u64) {
        self.spent += bytes;
        self.most = self.most.max(self.spent);
        if let Some(each) = self.each {
            let bytes = i64::try_from(bytes).unwrap_or(i64::MAX);
            self.left = self.left.saturating_sub(bytes).max(each.saturating_mul(-MOST_DEBT));
        }
    }

    /// Bytes of the frame with the most of them.
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
        let mut allowance = Allowance::new(Some(1000), start);
        assert_eq!(allowance.wait(start), None);
        allowance.spend(600);
        assert_eq!(allowance.wait(start), None, "there are some left");
        allowance.spend(1800);
        assert!(allowance.wait(start).is_some_and(|wait| wait <= FRAME));
        allowance.frame(start);
        assert!(allowance.wait(start).is_some(), "1400 too many");
        allowance.frame(start);
        assert_eq!(allowance.wait(start), None);
        allowance.spend(100);
        // What is not used is not saved up.
        (0..5).for_each(|_| allowance.frame(start));
        allowance.spend(1000);
        assert!(allowance.wait(start).is_some());
        assert_eq!(allowance.most(), 2400);
    }

    #[test]
    fn without_frames_time_counts() {
        let start = Instant::now();
        let mut allowance = Allowance::new(Some(1000), start);
        allowance.spend(3500);
        assert!(allowance.wait(start + FRAME / 2).is_some());
        assert!(allowance.wait(start + FRAME).is_some());
        assert_eq!(allowance.wait(start + 4 * FRAME), None);
        // However large it was, it does not stop everything for ever.
        allowance.spend(1 << 40);
        (0..=MOST_DEBT).for_each(|_| allowance.frame(start + 4 * FRAME));
        assert_eq!(allowance.wait(start + 4 * FRAME), None);
    }

    #[test]
    fn no_number_is_any_number() {
        let start = Instant::now();
        let mut allowance = Allowance::new(None, start);
        allowance.spend(1 << 40);
        assert_eq!((allowance.wait(start), allowance.most()), (None, 1 << 40));
    }
}
