//! Writes of sources on their way to the device, through a staging buffer for each frame in flight. Nothing here waits. A staging
//! buffer is written again when its last frame has finished, and the executor knows this before it records the next frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, Device, Location, Recording, vk};

use super::FRAMES;
use super::error::ExecuteError;
use super::source::{Part, Write, WriteQueue};

/// Bytes that one frame uploads, unless a single write has more. The rest follows with the next frame.
pub const FRAME_BYTES: usize = 32 << 20;

/// Bytes of the smallest staging buffer.
const SMALLEST: u64 = 1 << 16;

/// Every copy starts at a multiple of this in the staging buffer: that of the largest texel.
const ALIGNMENT: u64 = 16;

/// The staging buffers, and the writes of the frame that is being recorded.
pub(super) struct Uploads {
    queue: Arc<WriteQueue>,
    staging: [Option<Arc<Buffer>>; FRAMES],
    /// Staged and not submitted: a frame that fails leaves them for the next one.
    writes: Vec<Write>,
}

impl Uploads {
    pub(super) fn new(queue: Arc<WriteQueue>) -> Self {
        Self { queue, staging: [None, None], writes: Vec::new() }
    }

    /// Puts waiting writes into the staging buffer of a frame in flight that has finished. Returns whether there are any; then the
    /// versions of their sources have changed.
    pub(super) fn stage(&mut self, device: &Arc<Device>, slot: usize) -> Result<bool, ExecuteError> {
        if self.writes.is_empty() {
            self.queue.take(FRAME_BYTES, &mut self.writes);
        }
        if self.writes.is_empty() {
            return Ok(false);
        }
        let needed = self.places().last().map_or(0, |(place, write)| place + write.bytes.len() as u64);
        let staging = match &self.staging[slot] {
            Some(staging) if staging.size() >= needed => staging.clone(),
            _ => {
                let size = needed.next_power_of_two().max(SMALLEST);
                let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_SRC, location: Location::Upload };
                let staging = Arc::new(Buffer::new(device, "staging of sources", &info, Backing::Own)?);
                self.staging[slot].insert(staging).clone()
            }
        };
        for (place, write) in self.places() {
            staging.write(place, &write.bytes)?;
            write.source.changed();
        }
        Ok(true)
    }

    /// Records the copies of staged data, with the barriers that the plan has for them: before, between and after.
    pub(super) fn record(&self, recording: &mut Recording<'_>, slot: usize, [before, between, after]: &[Barrier; 3]) {
        let Some(staging) = self.staging[slot].as_ref().filter(|_| !self.writes.is_empty()) else { return };
        recording.barrier(before);
        let mut stored = Stored::default();
        for (place, write) in self.places() {
            if !stored.add(write) {
                recording.barrier(between);
                stored = Stored::default();
                stored.add(write);
            }
            match (write.part, write.source.buffer(), write.source.image()) {
                (Part::Bytes { offset }, Some(buffer), _) => {
                    recording.copy_buffer((staging, place), (buffer, offset), write.bytes.len() as u64);
                }
                (Part::Texels { mip, first, extent }, _, Some(image)) => {
                    recording.copy_buffer_to_texels((staging, place), image, mip, first, extent);
                }
                _ => {}
            }
        }
        recording.barrier(after);
    }

    /// The frame that has the copies was submitted.
    pub(super) fn submitted(&mut self) {
        for write in self.writes.drain(..) {
            write.source.submitted();
        }
    }

    /// Where each write lies in the staging buffer.
    fn places(&self) -> impl Iterator<Item = (u64, &Write)> {
        let mut end = 0_u64;
        self.writes.iter().map(move |write| {
            let place = end.next_multiple_of(ALIGNMENT);
            end = place + write.bytes.len() as u64;
            (place, write)
        })
    }
}

/// The parts that copies since the last barrier store to: a second store to one of them must wait for the first.
#[derive(Default)]
struct Stored {
    /// Ends of parts of buffers, by source and start. No two of them overlap.
    bytes: BTreeMap<(usize, u64), u64>,
    /// Boxes of texels: source, mip, first, end.
    boxes: Vec<(usize, u32, [u32; 3], [u32; 3])>,
}

/// The most boxes that are compared with each other; with more, a barrier is cheaper.
const MOST_BOXES: usize = 64;

impl Stored {
    /// Adds a write. `false` when it may meet one before it.
    fn add(&mut self, write: &Write) -> bool {
        let source = Arc::as_ptr(&write.source) as usize;
        match write.part {
            Part::Bytes { offset } => {
                let end = offset + write.bytes.len() as u64;
                // The last range that starts before the end of this one.
                let before = self.bytes.range((source, 0)..(source, end)).next_back();
                if before.is_some_and(|(_, before)| *before > offset) {
                    return false;
                }
                self.bytes.insert((source, offset), end);
            }
            Part::Texels { mip, first, extent } => {
                let end = [0, 1, 2].map(|axis| first[axis] + extent[axis]);
                let meets = |(s, m, a, b): &(usize, u32, [u32; 3], [u32; 3])| {
                    *s == source && *m == mip && (0..3).all(|axis| a[axis] < end[axis] && first[axis] < b[axis])
                };
                if self.boxes.len() == MOST_BOXES || self.boxes.iter().any(meets) {
                    return false;
                }
                self.boxes.push((source, mip, first, end));
            }
        }
        true
    }
}
