//! Bytes from the device to the host without waiting. The copy is submitted behind all earlier work. Its ticket is polled for the
//! bytes.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use crate::buffer::{Buffer, BufferInfo};
use crate::command::{Barrier, CommandBuffer, Recording};
use crate::device::Device;
use crate::image::Image;
use crate::memory::{Backing, Location};
use crate::queue::TimelineValue;
use crate::result::{Error, Result};

/// Most copies on their way at once.
const SLOTS: usize = 8;

/// Staging buffers that are used in turn. A buffer is free again when its ticket is gone and the device has finished with it.
pub struct ReadbackRing {
    device: Arc<Device>,
    slots: Vec<Slot>,
}

struct Slot {
    commands: CommandBuffer,
    staging: Arc<Buffer>,
}

/// Bytes on their way to the host.
pub struct Readback {
    device: Arc<Device>,
    staging: Option<Arc<Buffer>>,
    size: u64,
    submitted: TimelineValue,
}

impl ReadbackRing {
    /// A ring without buffers; they are made when they are needed.
    pub fn new(device: &Arc<Device>) -> ReadbackRing {
        ReadbackRing { device: device.clone(), slots: Vec::new() }
    }

    /// Asks for `size` bytes of a buffer from `offset` on (both multiples of 4), after everything submitted so far.
    ///
    /// # Errors
    /// [`Error::ReadbacksInFlight`] when too many tickets are held. Any error of the driver.
    pub fn buffer(&mut self, buffer: &Buffer, offset: u64, size: u64) -> Result<Readback> {
        self.request(buffer.name(), size, |recording, staging| {
            recording.copy_buffer((buffer, offset), (staging, 0), size);
        })
    }

    /// Asks for one layer (or slice of a 3-D image) of one mip, without padding. The image is in `GENERAL`. Errors as for
    /// [`Self::buffer`].
    pub fn image(&mut self, image: &Image, texel_bytes: u32, mip: u32, layer: u32) -> Result<Readback> {
        let [width, height, _] = image.mip_extent(mip);
        let size = u64::from(width) * u64::from(height) * u64::from(texel_bytes);
        self.request(image.name(), size, |recording, staging| {
            recording.copy_image_to_buffer(image, mip, layer, staging);
        })
    }

    fn request(&mut self, name: &str, size: u64, copy: impl FnOnce(&mut Recording<'_>, &Buffer)) -> Result<Readback> {
        let device = self.device.clone();
        if size == 0 {
            return Ok(Readback { device, staging: None, size, submitted: TimelineValue::default() });
        }
        let slot = self.free_slot(name, size)?;
        let staging = slot.staging.clone();
        let mut recording = slot.commands.begin()?;
        recording.barrier(&Barrier::full());
        copy(&mut recording, &staging);
        // Later commands wait for the copy, and the host sees it.
        recording.barrier(&Barrier::full_to_host());
        let submitted = recording.submit()?;
        Ok(Readback { device, staging: Some(staging), size, submitted })
    }

    /// A free slot of at least that size: no ticket uses it, and the device does not.
    fn free_slot(&mut self, name: &str, size: u64) -> Result<&mut Slot> {
        let reached = self.device.reached()?;
        let free = |slot: &Slot| Arc::strong_count(&slot.staging) == 1 && slot.commands.submitted() <= reached;
        let index = match self.slots.iter().position(free) {
            Some(index) => index,
            None if self.slots.len() < SLOTS => {
                let commands = CommandBuffer::new(&self.device, "read-back")?;
                self.slots.push(Slot { commands, staging: Arc::new(self.staging(name, size)?) });
                self.slots.len() - 1
            }
            None => return Err(Error::ReadbacksInFlight { most: SLOTS }),
        };
        // A buffer that is far too large is released: one large picture must not pin its memory for ever.
        if !(size..=size.saturating_mul(4).max(1 << 16)).contains(&self.slots[index].staging.size()) {
            self.slots[index].staging = Arc::new(self.staging(name, size)?);
        }
        Ok(&mut self.slots[index])
    }

    fn staging(&self, name: &str, size: u64) -> Result<Buffer> {
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_DST, location: Location::Download };
        Buffer::new(&self.device, &format!("{name}, read-back"), &info, Backing::Own)
    }
}

impl Readback {
    /// A read-back of the copy that the caller's own submission makes into a host-visible buffer.
    pub fn of(device: &Arc<Device>, staging: Arc<Buffer>, submitted: TimelineValue) -> Readback {
        Readback { device: device.clone(), size: staging.size(), staging: Some(staging), submitted }
    }

    /// The bytes, once the device has copied them. Does not wait.
    pub fn poll(&self) -> Result<Option<Vec<u8>>> {
        if self.device.has_reached(self.submitted)? { self.copied().map(Some) } else { Ok(None) }
    }

    /// Whether [`Self::poll`] has the bytes. It copies none of them.
    pub fn has_arrived(&self) -> Result<bool> {
        self.device.has_reached(self.submitted)
    }

    /// The value that the device reaches when it has copied them.
    pub fn submitted(&self) -> TimelineValue {
        self.submitted
    }

    /// Waits for the bytes, but no longer than `timeout`.
    pub fn wait(&self, timeout: Duration) -> Result<Vec<u8>> {
        self.device.wait(self.submitted, timeout)?;
        self.copied()
    }

    #[expect(clippy::cast_possible_truncation, reason = "the buffer is mapped, so that `usize` holds its size")]
    fn copied(&self) -> Result<Vec<u8>> {
        let Some(staging) = &self.staging else { return Ok(Vec::new()) };
        let mut bytes = vec![0; self.size as usize];
        if staging.read(0, &mut bytes) {
            Ok(bytes)
        } else {
            Err(Error::OutOfMemory { name: format!("{}, host-visible", staging.name()), size: self.size })
        }
    }
}
