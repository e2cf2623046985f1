//! Keeps the host from writing a buffer that the device may still read.
//!
//! An upload buffer knows the last submission that uses it. A recording collects the upload buffers that its commands name and that its
//! descriptors bind, and its submission sets their last use. A write is refused until the device has finished that submission.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::device::Device;
use crate::queue::TimelineValue;
use crate::result::{Error, Result};

/// The last submission that uses a buffer. The lock is held while the host writes, so that no submission begins during a write.
#[derive(Debug, Default)]
pub(crate) struct LastUse(Mutex<TimelineValue>);

impl LastUse {
    /// Runs `write` if the device has finished all submissions that use the buffer.
    ///
    /// # Errors
    /// [`Error::InUse`] if it has not; [`Error::DeviceLost`].
    pub(crate) fn exclusively(&self, device: &Device, name: &str, write: impl FnOnce()) -> Result<()> {
        let last = self.lock();
        if !device.has_reached(*last)? {
            return Err(Error::InUse { name: name.to_owned() });
        }
        write();
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, TimelineValue> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The upload buffers that a recording uses, each once.
#[derive(Default)]
pub(crate) struct UploadUses(Vec<Arc<LastUse>>);

impl UploadUses {
    /// Recordings with this many upload buffers or fewer allocate nothing.
    const FEW: usize = 16;

    pub(crate) fn new() -> Self {
        Self(Vec::with_capacity(Self::FEW))
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// A command uses a buffer, if it is one that the host writes.
    pub(crate) fn add(&mut self, last_use: Option<&Arc<LastUse>>) {
        if let Some(last_use) = last_use
            && !self.0.iter().any(|known| Arc::ptr_eq(known, last_use))
        {
            self.0.push(last_use.clone());
        }
    }

    /// The commands are submitted next, under this value. Waits until a write that has begun is done.
    pub(crate) fn submit_as(&self, value: TimelineValue) {
        self.0.iter().for_each(|last_use| *last_use.lock() = value);
    }

    /// Those buffers, for a recording that binds a set of descriptors.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Arc<LastUse>> {
        self.0.iter()
    }
}
