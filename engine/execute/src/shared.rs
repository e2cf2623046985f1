//! State that the executor shares with its builders.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use raxel_gpu::{Device, Image};

use super::error::ExecuteError;
use super::executor::ExecutorOptions;
use super::physical::Physical;
use super::pipelines::Pipelines;
use super::source::WriteQueue;

/// State that the executor shares with its builders.
pub(super) struct Shared {
    pub(super) device: Arc<Device>,
    pub(super) options: ExecutorOptions,
    /// Nanoseconds.
    watchdog: AtomicU64,
    /// Objects that the running plan uses.
    pub(super) running: Mutex<Running>,
    /// Writes of sources that wait for the next frame.
    pub(super) writes: Arc<WriteQueue>,
    pub(super) pipelines: Pipelines,
}

#[derive(Default)]
pub(super) struct Running {
    /// Counts the swaps.
    pub(super) serial: u64,
    pub(super) resources: Vec<Arc<Physical>>,
    pub(super) picture: Option<Arc<PictureImage>>,
}

/// The image that the debug target is mapped to.
pub(super) struct PictureImage {
    pub(super) image: Arc<Image>,
    /// Is in `GENERAL`.
    pub(super) initialized: AtomicBool,
}

impl Shared {
    pub(super) fn new(device: Arc<Device>, options: ExecutorOptions) -> Shared {
        let shared = Shared {
            device,
            watchdog: AtomicU64::new(0),
            options,
            running: Mutex::default(),
            writes: Arc::default(),
            pipelines: Pipelines::new(),
        };
        shared.set_watchdog(options.watchdog);
        shared
    }

    pub(super) fn watchdog(&self) -> Duration {
        Duration::from_nanos(self.watchdog.load(Ordering::Relaxed))
    }

    pub(super) fn set_watchdog(&self, limit: Duration) {
        self.watchdog.store(u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    /// Turns an error into ours; a device that hangs is given up.
    pub(super) fn error(&self, error: raxel_gpu::Error) -> ExecuteError {
        if matches!(error, raxel_gpu::Error::TimedOut { .. }) {
            self.device.abandon();
        }
        error.into()
    }
}

/// A panicking thread leaves these maps whole: entries are put in last.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
