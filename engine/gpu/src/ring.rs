//! Bytes from many threads to one buffer that the host cannot write, through a ring of memory that it can.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::vk;

use crate::buffer::{Buffer, BufferInfo};
use crate::command::{Barrier, CommandBuffer};
use crate::device::Device;
use crate::memory::{Backing, Location};
use crate::queue::TimelineValue;
use crate::result::{Error, Result};

/// Every copy starts at a multiple of this in the ring.
const ALIGNMENT: u64 = 16;

/// Copies of bytes to a buffer on the device, gathered from many threads and submitted together. Writers wait only while the ring is full
/// of copies that the device has not finished; [`UploadRing::flush`] never waits.
pub struct UploadRing {
    device: Arc<Device>,
    target: Arc<Buffer>,
    staging: Buffer,
    timeout: Duration,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Bytes of the ring that were ever taken, and ever released: places are these modulo its size.
    taken: u64,
    given_back: u64,
    /// Copies that are not submitted, by where they go: place in the ring and bytes. No two of them meet.
    waiting: BTreeMap<u64, (u64, u64)>,
    /// Copies that the device may not have finished, with the bytes that each releases when it has.
    submitted: VecDeque<Batch>,
    /// Command buffers that have finished.
    idle: Vec<CommandBuffer>,
}

struct Batch {
    finished_at: TimelineValue,
    end: u64,
    commands: CommandBuffer,
}

impl UploadRing {
    /// A ring of that many bytes, at least 64, in front of a buffer. A write that waits for the device longer than `timeout` fails.
    pub fn new(device: &Arc<Device>, target: &Arc<Buffer>, bytes: u64, timeout: Duration) -> Result<Self> {
        let size = bytes.max(4 * ALIGNMENT).next_multiple_of(ALIGNMENT);
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_SRC, location: Location::Upload };
        let name = format!("{}, staging ring", target.name());
        let staging = Buffer::new(device, &name, &info, Backing::Own)?;
        Ok(Self { device: device.clone(), target: target.clone(), staging, timeout, state: Mutex::default() })
    }

    /// Takes bytes for a part of the buffer, at a multiple of 4. Work submitted after the next [`Self::flush`] sees them. Earlier work does not:
    /// the copy waits for all of it, and everything later waits for the copy.
    ///
    /// # Errors
    /// [`Error::NotWritable`] if the part does not lie in the buffer, or not at multiples of 4; any error of the device.
    pub fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let (count, size) = (bytes.len() as u64, self.target.size());
        let inside = offset.checked_add(count).is_some_and(|end| end <= size);
        if !inside || !offset.is_multiple_of(4) || !count.is_multiple_of(4) {
            return Err(Error::NotWritable { name: self.target.name().to_owned(), offset, bytes: count, size });
        }
        // Smaller than the ring, so that one part is copied while the next one is written.
        let most = (self.staging.size() / 4).next_multiple_of(ALIGNMENT) as usize;
        for (number, part) in bytes.chunks(most).enumerate() {
            self.write_part(offset + (number * most) as u64, part)?;
        }
        Ok(())
    }

    /// Submits the taken copies, without waiting for them.
    pub fn flush(&self) -> Result<()> {
        self.submit(&mut self.state())
    }

    fn write_part(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let (size, end) = (bytes.len() as u64, offset + bytes.len() as u64);
        let mut state = self.state();
        let state = &mut *state;
        // The last one that starts before the end of this one: if that does not reach into it, none does.
        let before = state.waiting.range(..end).next_back();
        if before.is_some_and(|(start, (_, size))| start + size > offset) {
            self.submit(state)?;
        }
        let place = loop {
            self.collect(state)?;
            if let Some(place) = state.reserve(size, self.staging.size()) {
                break place;
            }
            self.submit(state)?;
            let Some(oldest) = state.submitted.front() else {
                return Err(Error::OutOfMemory { name: self.staging.name().to_owned(), size });
            };
            self.device.wait(oldest.finished_at, self.timeout)?;
        };
        // SAFETY: the place was just reserved: the device has finished with the bytes there, and other writers wait for the state.
        unsafe { self.staging.write_part(place, bytes) }?;
        state.waiting.insert(offset, (place, size));
        Ok(())
    }

    fn submit(&self, state: &mut State) -> Result<()> {
        if state.waiting.is_empty() {
            return Ok(());
        }
        let mut commands = match state.idle.pop() {
            Some(commands) => commands,
            None => CommandBuffer::new(&self.device, "upload ring")?,
        };
        let regions: Vec<[u64; 3]> = state.waiting.iter().map(|(to, (from, size))| [*from, *to, *size]).collect();
        let mut recording = commands.begin()?;
        recording.barrier(&Barrier::full());
        // SAFETY: each part was reserved in the staging buffer, and is reserved again only once the device has finished. `write` has checked
        // that they lie in the target, and `write_part` submits before a part would overlap another one.
        unsafe { recording.copy_regions(&self.staging, &self.target, &regions) };
        recording.barrier(&Barrier::full());
        let finished_at = recording.submit()?;
        state.waiting.clear();
        state.submitted.push_back(Batch { finished_at, end: state.taken, commands });
        Ok(())
    }

    /// Releases the bytes that the device has finished with.
    fn collect(&self, state: &mut State) -> Result<()> {
        while let Some(batch) = state.submitted.front() {
            if !self.device.has_reached(batch.finished_at)? {
                break;
            }
            if let Some(Batch { end, commands, .. }) = state.submitted.pop_front() {
                state.given_back = end;
                state.idle.push(commands);
            }
        }
        Ok(())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// A place for `bytes` bytes in one piece; `None` while there is none.
    fn reserve(&mut self, bytes: u64, size: u64) -> Option<u64> {
        let bytes = bytes.next_multiple_of(ALIGNMENT);
        let place = self.taken % size;
        // The rest at the end is skipped when it is too small.
        let skipped = if place + bytes > size { size - place } else { 0 };
        let taken = self.taken + skipped + bytes;
        if taken - self.given_back > size {
            return None;
        }
        self.taken = taken;
        Some((taken - bytes) % size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_a_ring_do_not_meet() {
        let mut state = State::default();
        let mut held: VecDeque<(u64, u64, u64)> = VecDeque::new();
        let mut waits = 0;
        for n in 0..10_000_u64 {
            let bytes = 16 * (1 + n * n % 15);
            let place = loop {
                if let Some(place) = state.reserve(bytes, 1024) {
                    break place;
                }
                waits += 1;
                let (_, _, end) = held.pop_front().expect("what is held gives way");
                state.given_back = end;
            };
            assert!(place + bytes <= 1024 && place.is_multiple_of(ALIGNMENT));
            assert!(held.iter().all(|(other, size, _)| place + bytes <= *other || other + size <= place));
            held.push_back((place, bytes, state.taken));
        }
        assert!(waits > 1000);
    }
}
