//! The one queue and its timeline: every submission gets the next value, and whatever waits, waits for a value.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::vk;

use crate::command::CommandBuffer;
use crate::device::Device;
use crate::result::{Error, Named, Result};

/// A point on a device's timeline: reached when the submission that got it has finished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimelineValue(pub(crate) u64);

pub(crate) struct Queue {
    pub(crate) family: u32,
    raw: Mutex<vk::Queue>,
    semaphore: vk::Semaphore,
    submitted: AtomicU64,
    waits: AtomicU64,
}

impl Queue {
    pub(crate) fn new(device: &ash::Device, family: u32) -> Result<Queue> {
        let mut ty = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut ty);
        // SAFETY: timelineSemaphore is on, and the device was made with one queue of this family.
        unsafe {
            let semaphore = device.create_semaphore(&info, None).named("vkCreateSemaphore")?;
            let raw = Mutex::new(device.get_device_queue(family, 0));
            Ok(Queue { family, raw, semaphore, submitted: AtomicU64::new(0), waits: AtomicU64::new(0) })
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
    /// Submits a recorded command buffer. Submissions run in order; what one must see of another is said by barriers.
    pub fn submit(&self, commands: &CommandBuffer) -> Result<TimelineValue> {
        self.submit_for_window(commands, None)
    }

    pub(crate) fn submit_for_window(
        &self,
        commands: &CommandBuffer,
        window: Option<&WindowSemaphores>,
    ) -> Result<TimelineValue> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        let info = |semaphore, stage| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(stage);
        let queue = self.queue.lock();
        let value = self.queue.submitted.load(Ordering::Relaxed) + 1;
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands.raw)];
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
        self.watch(value.named("vkGetSemaphoreCounterValue")).map(TimelineValue)
    }

    /// Waits until the device has reached a value. `None` waits as long as it takes.
    pub fn wait(&self, value: TimelineValue, timeout: Option<Duration>) -> Result<()> {
        if self.is_lost() {
            return Err(Error::DeviceLost);
        }
        self.queue.waits.fetch_add(1, Ordering::Relaxed);
        let (semaphores, values) = ([self.queue.semaphore], [value.0]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        let nanoseconds = timeout.map_or(u64::MAX, |t| u64::try_from(t.as_nanos()).unwrap_or(u64::MAX));
        // SAFETY: the semaphore is a live timeline semaphore.
        match unsafe { self.raw.wait_semaphores(&info, nanoseconds) } {
            Err(vk::Result::TIMEOUT) => Err(Error::TimedOut { seconds: timeout.unwrap_or_default().as_secs_f64() }),
            result => self.watch(result.named("vkWaitSemaphores")),
        }
    }

    /// How often somebody waited for the device so far: what must not stall a frame is tested by it.
    pub fn waits(&self) -> u64 {
        self.queue.waits.load(Ordering::Relaxed)
    }

    /// Waits for everything that was submitted.
    pub fn wait_idle(&self, timeout: Option<Duration>) -> Result<()> {
        self.wait(self.submitted(), timeout)
    }
}
