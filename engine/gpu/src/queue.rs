//! The one queue and its timeline: every submission gets the next value, and every wait is for a value.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::vk;

use crate::device::Device;
use crate::last_use::UploadUses;
use crate::result::{Error, Named, Result};
use crate::stopwatch::LOOK;

/// A point on a device's timeline: reached when the submission that got it has finished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimelineValue(pub(crate) u64);

pub(crate) struct Queue {
    pub(crate) family: u32,
    raw: Mutex<vk::Queue>,
    semaphore: vk::Semaphore,
    submitted: AtomicU64,
    waits: AtomicU64,
    /// At least this value is reached: saves a call of the driver.
    reached: AtomicU64,
}

impl Queue {
    pub(crate) fn new(device: &ash::Device, family: u32) -> Result<Queue> {
        let mut ty = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut ty);
        // SAFETY: timelineSemaphore is on, and the device was made with one queue of this family.
        unsafe {
            let semaphore = device.create_semaphore(&info, None).named("vkCreateSemaphore")?;
            let raw = Mutex::new(device.get_device_queue(family, 0));
            let (submitted, reached, waits) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
            Ok(Queue { family, raw, semaphore, submitted, waits, reached })
        }
    }

    /// # Safety
    /// The device is idle and the queue is not used again.
    pub(crate) unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's promise.
        unsafe { device.destroy_semaphore(self.semaphore, None) };
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, vk::Queue> {
        self.raw.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Semaphores of a window that a submission waits for and signals.
pub(crate) struct WindowSemaphores {
    pub(crate) acquired: vk::Semaphore,
    pub(crate) rendered: vk::Semaphore,
}

impl Device {
    /// Submits a recorded command buffer, which uses these upload buffers. Submissions start in order; barriers say which results of one another
    /// must see.
    pub(crate) fn submit(
        &self,
        commands: vk::CommandBuffer,
        uses: &UploadUses,
        window: Option<&WindowSemaphores>,
    ) -> Result<TimelineValue> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        let info = |semaphore, stage| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(stage);
        let queue = self.queue.lock();
        let value = self.queue.submitted.load(Ordering::Relaxed) + 1;
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        // The picture of the window is first touched by a transfer.
        let acquired = window
            .map_or(vk::SemaphoreSubmitInfo::default(), |w| info(w.acquired, vk::PipelineStageFlags2::ALL_TRANSFER));
        let signals = [
            info(self.queue.semaphore, all).value(value),
            window.map_or(vk::SemaphoreSubmitInfo::default(), |w| info(w.rendered, all)),
        ];
        let waits = [acquired];
        let windows = usize::from(window.is_some());
        let submit = vk::SubmitInfo2::default()
            .command_buffer_infos(&buffers)
            .wait_semaphore_infos(&waits[..windows])
            .signal_semaphore_infos(&signals[..=windows]);
        // Before the submission, so that no write can begin once the device may read. After a failed submission the next one gets this value,
        // so that the buffers can be written when that has finished.
        uses.submit_as(TimelineValue(value));
        // SAFETY: the queue is locked, the buffer is recorded, and everything recorded in it is kept until the value is reached
        // (objects retire by value, see `retire`).
        let result = unsafe { self.raw.queue_submit2(*queue, &[submit], vk::Fence::null()) };
        self.watch(result.named("vkQueueSubmit2"))?;
        self.queue.submitted.store(value, Ordering::Release);
        Ok(TimelineValue(value))
    }

    /// The value of the last submission.
    pub fn submitted(&self) -> TimelineValue {
        TimelineValue(self.queue.submitted.load(Ordering::Acquire))
    }

    /// The last value the device reached.
    pub fn reached(&self) -> Result<TimelineValue> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        // SAFETY: the semaphore is a live timeline semaphore.
        let value = unsafe { self.raw.get_semaphore_counter_value(self.queue.semaphore) };
        let value = self.watch(value.named("vkGetSemaphoreCounterValue"))?;
        self.queue.reached.fetch_max(value, Ordering::AcqRel);
        Ok(TimelineValue(value))
    }

    /// Whether the device has reached a value, without waiting.
    pub fn has_reached(&self, value: TimelineValue) -> Result<bool> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        Ok(self.queue.reached.load(Ordering::Acquire) >= value.0 || self.reached()? >= value)
    }

    /// Waits at most so long, and says whether the device has reached a value.
    pub fn reaches_within(&self, value: TimelineValue, at_most: Duration) -> Result<bool> {
        self.queue.waits.fetch_add(1, Ordering::Relaxed);
        self.look_for(value, at_most)
    }

    /// Waits until the device has reached a value.
    ///
    /// # Errors
    /// [`Error::TimedOut`] if it finishes no submission in `limit`, as [`crate::Stopwatch`] counts it.
    pub fn wait(&self, value: TimelineValue, limit: Duration) -> Result<()> {
        self.queue.waits.fetch_add(1, Ordering::Relaxed);
        let mut stopwatch = self.stopwatch();
        let mut finished = None;
        while !self.look_for(value, limit.min(LOOK))? {
            let now = self.reached()?;
            // The driver's own clock runs while this process is stopped.
            if now >= value {
                break;
            }
            // The first answer says nothing of the time before it.
            if finished.replace(now).is_some_and(|before| before != now) {
                stopwatch = self.stopwatch();
            } else if stopwatch.is_over(limit) {
                return Err(Error::TimedOut { seconds: limit.as_secs_f64() });
            }
        }
        Ok(())
    }

    fn look_for(&self, value: TimelineValue, at_most: Duration) -> Result<bool> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        match self.wait_timeline(value, at_most) {
            Err(vk::Result::TIMEOUT) => Ok(false),
            result => self.watch(result.named("vkWaitSemaphores")).map(|()| true),
        }
    }

    /// How often somebody has waited for the device so far. Tests use it to show that nothing stalls a frame.
    pub fn waits(&self) -> u64 {
        self.queue.waits.load(Ordering::Relaxed)
    }

    /// Waits for everything that was submitted, as [`Self::wait`] does.
    pub fn wait_idle(&self, limit: Duration) -> Result<()> {
        self.wait(self.submitted(), limit)
    }

    /// Waits until the queue has done all of its work so far, but no longer than `timeout`. `vkQueueWaitIdle` has no limit. `queue` is the
    /// locked queue.
    pub(crate) fn wait_queue(&self, queue: vk::Queue, timeout: Duration) -> Result<()> {
        // SAFETY: plain data.
        let fence = unsafe { self.raw.create_fence(&vk::FenceCreateInfo::default(), None) }.named("vkCreateFence")?;
        // SAFETY: the caller has locked the queue; the fence is new. It is signalled after all that was submitted before.
        let submitted = unsafe { self.raw.queue_submit2(queue, &[], fence) }.named("vkQueueSubmit2");
        let done = submitted.and_then(|()| {
            // SAFETY: the fence is alive.
            match unsafe { self.raw.wait_for_fences(&[fence], true, nanoseconds(timeout)) } {
                Err(vk::Result::TIMEOUT) => Err(Error::TimedOut { seconds: timeout.as_secs_f64() }),
                result => result.named("vkWaitForFences"),
            }
        });
        if !matches!(done, Err(Error::TimedOut { .. })) {
            // SAFETY: it is signalled, or was never submitted, or the device is lost. One that was waited for in vain stays for ever.
            unsafe { self.raw.destroy_fence(fence, None) };
        }
        self.watch(done)
    }

    /// Waits until a device that was given up has finished after all. False when it has not within `timeout`, or is really lost.
    pub fn wait_abandoned(&self, timeout: Duration) -> bool {
        self.wait_timeline(self.submitted(), timeout).is_ok()
    }

    fn wait_timeline(&self, value: TimelineValue, timeout: Duration) -> std::result::Result<(), vk::Result> {
        let (semaphores, values) = ([self.queue.semaphore], [value.0]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: the semaphore is a live timeline semaphore.
        unsafe { self.raw.wait_semaphores(&info, nanoseconds(timeout)) }?;
        self.queue.reached.fetch_max(value.0, Ordering::AcqRel);
        Ok(())
    }
}

/// A limit as Vulkan counts it. The largest number means "for ever" to some drivers.
fn nanoseconds(timeout: Duration) -> u64 {
    u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX).min(u64::MAX - 1)
}
