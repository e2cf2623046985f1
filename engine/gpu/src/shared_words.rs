//! Words that the host stores while the device may read them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::buffer::Buffer;
use crate::memory::Location;
use crate::result::{Error, Result};

/// The words of a [`Location::Shared`] buffer, as the host stores them.
///
/// Every word is stored whole, but in no fixed order. A shader that reads meanwhile gets the old or the new word, and may get later words before
/// earlier ones. Submissions that are made after [`Self::store`] returns see all its words. So this buffer needs a protocol that keeps frames
/// from words that are being stored. A mistake there only shows wrong voxels.
pub struct SharedWords {
    buffer: Arc<Buffer>,
}

impl SharedWords {
    /// `None` if the buffer is not [`Location::Shared`].
    pub fn new(buffer: Arc<Buffer>) -> Option<Self> {
        let shared = buffer.location() == Location::Shared && buffer.mapping().is_some();
        shared.then_some(Self { buffer })
    }

    /// Stores words from the word `at` on.
    ///
    /// # Errors
    /// [`Error::NotWritable`], with nothing stored, if they do not lie in the buffer.
    pub fn store(&self, at: u64, words: &[u32]) -> Result<()> {
        let refused = || Error::NotWritable {
            name: self.buffer.name().to_owned(),
            offset: at.saturating_mul(4),
            bytes: size_of_val(words) as u64,
            size: self.buffer.size(),
        };
        let fits = at.checked_add(words.len() as u64).is_some_and(|end| end <= self.buffer.size() / 4);
        let Some(host) = self.buffer.mapping().filter(|_| fits) else { return Err(refused()) };
        let start = usize::try_from(at).map_err(|_| refused())?;
        let first = host.cast::<u32>();
        for (word, offset) in words.iter().zip(start..) {
            // SAFETY: the word lies in the mapping, which lives as long as the buffer, and mappings are aligned for words. The host touches the
            // words of a shared buffer here alone, as atomics of one size, so that threads that store the same word do not race.
            let place = unsafe { AtomicU32::from_ptr(first.as_ptr().add(offset)) };
            place.store(*word, Ordering::Relaxed);
        }
        Ok(())
    }
}
