//! Waits for a device for as long as it goes on finishing passes. A slow device is not taken for one that hangs: the watchdog's time begins anew with
//! each pass that has finished.

use std::time::{Duration, Instant};

use raxel_gpu::{Error, TimelineValue};

use super::executor::Executor;
use super::{FRAMES, SLOW};

/// How often the device is asked whether it has finished another pass; more often where the watchdog is impatient.
const ASKED_EACH: Duration = Duration::from_millis(250);

/// How long a pass takes, in seconds, when that is first told; again after twice the time, and so on.
const TOLD_AFTER: u64 = 2;

/// How far a device has come: submissions, and passes of the frames in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Heartbeat {
    pub(super) reached: TimelineValue,
    pub(super) finished: [usize; FRAMES],
}

impl Executor {
    /// How far the device has come.
    pub(super) fn heartbeat(&self) -> raxel_gpu::Result<Heartbeat> {
        let reached = self.shared.device.reached()?;
        Ok(Heartbeat { reached, finished: std::array::from_fn(|slot| self.slots[slot].finished()) })
    }

    /// Waits until the device has reached a value.
    ///
    /// # Errors
    /// [`Error::TimedOut`] when it has finished no pass and no submission for as long as the watchdog allows. Any error of the driver.
    pub(super) fn wait_at_work(&self, until: TimelineValue) -> raxel_gpu::Result<()> {
        let device = &self.shared.device;
        let mut beat = None;
        let mut since = Instant::now();
        let mut told_after = TOLD_AFTER;
        loop {
            let limit = self.shared.watchdog();
            let left = limit.saturating_sub(since.elapsed());
            match device.wait(until, left.min(limit / 4).min(ASKED_EACH)) {
                Err(Error::TimedOut { .. }) => {}
                result => return result,
            }
            let now = Some(self.heartbeat()?);
            if beat != now {
                // The first answer says nothing of the time before it.
                if beat.is_some() {
                    since = Instant::now();
                    told_after = TOLD_AFTER;
                }
                beat = now;
            }
            let elapsed = since.elapsed();
            if elapsed >= limit {
                return Err(Error::TimedOut { seconds: limit.as_secs_f64() });
            }
            let seconds = elapsed.as_secs();
            if seconds >= told_after {
                told_after = seconds.saturating_mul(2);
                let pass = self.suspect().map(|suspect| suspect.pass);
                let on = pass.as_ref().map_or_else(String::new, |pass| format!(" on pass `{pass}`"));
                tracing::info!(target: SLOW, event = "working", pass, seconds, "the device has worked{on} for {seconds} s");
            }
        }
    }
}
