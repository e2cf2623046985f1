//! Waits for a device for as long as it goes on finishing passes. A slow device does not count as hung: the watchdog's time begins again with each
//! finished pass. A software device that gets little processor time has a longer limit ([`raxel_gpu::Stopwatch`]).

use std::time::Duration;

use raxel_gpu::{Device, Error, Stopwatch, TimelineValue};

use super::error::ExecuteError;
use super::executor::{Executor, Progress};
use super::{FRAMES, SLOW};

/// The interval between two looks at the progress of the device. It is shorter if the watchdog's limit is short.
const ASKED_EACH: Duration = Duration::from_millis(250);

/// Seconds after which a slow pass is first reported; again after twice the time, and so on.
const TOLD_AFTER: u64 = 2;

/// The progress of a device: submissions, and passes of the frames in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Heartbeat {
    reached: TimelineValue,
    finished: [usize; FRAMES],
}

/// The last seen progress of the device, and the time since.
pub(super) struct Observed {
    beat: Option<Heartbeat>,
    stopwatch: Stopwatch,
}

impl Observed {
    /// A device that has something to do from now on.
    pub(super) fn from_now(device: &Device) -> Self {
        Self { beat: None, stopwatch: device.stopwatch() }
    }

    /// The device has something to do from now on.
    pub(super) fn begin(&mut self, device: &Device) {
        self.stopwatch = device.stopwatch();
    }

    /// Notes how far the device has come. Whether it has finished something since it was asked last.
    fn note(&mut self, beat: Heartbeat, device: &Device) -> bool {
        // The first answer says nothing of the time before it.
        let moves = self.beat.replace(beat).is_some_and(|before| before != beat);
        if moves {
            self.begin(device);
        }
        moves
    }
}

impl Executor {
    /// The progress of the device.
    fn heartbeat(&self) -> raxel_gpu::Result<Heartbeat> {
        let reached = self.shared.device.reached()?;
        Ok(Heartbeat { reached, finished: std::array::from_fn(|slot| self.slots[slot].finished()) })
    }

    /// Waits until the device has reached a value.
    ///
    /// # Errors
    /// [`Error::TimedOut`] if it finishes neither a pass nor a submission within the watchdog's limit. Any error of the driver.
    pub(super) fn wait_at_work(&self, until: TimelineValue) -> raxel_gpu::Result<()> {
        let device = &self.shared.device;
        let mut observed = Observed::from_now(device);
        let mut told_after = TOLD_AFTER;
        loop {
            let limit = self.shared.watchdog();
            if device.reaches_within(until, ASKED_EACH.min(limit / 4))? {
                return Ok(());
            }
            let beat = self.heartbeat()?;
            // The driver's own clock runs while this process is stopped.
            if beat.reached >= until {
                return Ok(());
            }
            if observed.note(beat, device) {
                told_after = TOLD_AFTER;
            }
            if observed.stopwatch.is_over(limit) {
                return Err(Error::TimedOut { seconds: limit.as_secs_f64() });
            }
            let seconds = observed.stopwatch.passed().as_secs();
            if seconds >= told_after {
                told_after = seconds.saturating_mul(2);
                let pass = self.suspect().map(|suspect| suspect.pass);
                let on = pass.as_ref().map_or_else(String::new, |pass| format!(" on pass `{pass}`"));
                tracing::info!(target: SLOW, event = "working", pass, seconds, "the device has worked{on} for {seconds} s");
            }
        }
    }

    /// Waits at most so long until the device has reached a value.
    pub(super) fn observe(&mut self, until: TimelineValue, at_most: Duration) -> Result<Progress, ExecuteError> {
        let device = self.shared.device.clone();
        let there = device.reaches_within(until, at_most);
        if there.map_err(|error| self.attribute_loss(error.into()))? {
            return Ok(Progress::Done);
        }
        let beat = self.heartbeat().map_err(|error| self.attribute_loss(error.into()))?;
        if beat.reached >= until {
            return Ok(Progress::Done);
        }
        self.progress.note(beat, &device);
        if self.progress.stopwatch.is_over(self.shared.watchdog()) {
            return Err(self.attribute_loss(ExecuteError::DeviceLost { suspect: None, timed_out: true }));
        }
        let pass = self.suspect().map(|suspect| suspect.pass);
        Ok(Progress::Working { pass, elapsed: self.progress.stopwatch.passed() })
    }
}
