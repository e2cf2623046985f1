//! Buffers.
#![expect(
    clippy::cast_possible_truncation,
    reason = "offsets are checked against the size of memory that is mapped, which `usize` holds"
)]

use std::fmt;
use std::ptr::NonNull;
use std::sync::Arc;

use ash::vk;

use crate::device::Device;
use crate::last_use::LastUse;
use crate::memory::{Backing, Held, Location};
use crate::result::{Error, Named, Result};
use crate::retire::Dead;

/// The properties of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferInfo {
    /// Bytes; at least 1.
    pub size: u64,
    /// Usages.
    pub usage: vk::BufferUsageFlags,
    /// Where its memory lives. A placed buffer is always on the device.
    pub location: Location,
}

/// A buffer and its memory.
pub struct Buffer {
    pub(crate) raw: vk::Buffer,
    device: Arc<Device>,
    held: Held,
    size: u64,
    location: Location,
    name: String,
    /// Of a buffer that the host writes.
    last_use: Option<Arc<LastUse>>,
}

impl fmt::Debug for Buffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffer({}, {} bytes)", self.name, self.size)
    }
}

impl Buffer {
    /// Makes a buffer.
    pub fn new(device: &Arc<Device>, name: &str, info: &BufferInfo, backing: Backing<'_>) -> Result<Buffer> {
        let limit = u64::from(device.capabilities().limits.max_storage_buffer_range);
        if info.usage.contains(vk::BufferUsageFlags::STORAGE_BUFFER) && info.size > limit {
            return Err(Error::TooLarge { name: name.to_owned(), size: info.size, limit });
        }
        // SAFETY: the info is plain data.
        let raw = unsafe { device.raw.create_buffer(&create_info(info), None) }.making(name, "vkCreateBuffer")?;
        // SAFETY: the buffer was just made.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let held =
            Held::find(device, name, requirements, backing, info.location, true).and_then(|(held, memory, at)| {
                // SAFETY: memory and offset suit the requirements; the memory is held as long as the buffer.
                unsafe { device.raw.bind_buffer_memory(raw, memory, at) }.making(name, "vkBindBufferMemory")?;
                Ok(held)
            });
        match held {
            Ok(held) => {
                device.name(raw, name);
                Ok(Buffer {
                    raw,
                    device: device.clone(),
                    held,
                    size: info.size,
                    location: info.location,
                    name: name.to_owned(),
                    last_use: (info.location == Location::Upload).then(Arc::default),
                })
            }
            Err(error) => {
                // SAFETY: no other code has the buffer yet.
                unsafe { device.raw.destroy_buffer(raw, None) };
                Err(error)
            }
        }
    }

    /// The memory that a buffer would need.
    pub fn requirements(device: &Device, info: &BufferInfo) -> vk::MemoryRequirements {
        let create = create_info(info);
        let query = vk::DeviceBufferMemoryRequirements::default().create_info(&create);
        let mut answer = vk::MemoryRequirements2::default();
        // SAFETY: maintenance4 is on; the info is plain data.
        unsafe { device.raw.get_device_buffer_memory_requirements(&query, &mut answer) };
        answer.memory_requirements
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Panics if a part does not lie in the buffer, or does not begin and end at multiples of `multiple` bytes: the device would then access
    /// memory of another object.
    pub(crate) fn require(&self, offset: u64, size: u64, multiple: u64) {
        let inside = offset.checked_add(size).is_some_and(|end| end <= self.size);
        let aligned = offset.is_multiple_of(multiple) && size.is_multiple_of(multiple);
        assert!(
            inside && aligned,
            "{size} bytes from {offset} on are not part of `{}`, which has {}",
            self.name,
            self.size
        );
    }

    /// Whether its memory is the device's own, so that the device reads the host's writes at full speed.
    pub fn is_device_local(&self) -> bool {
        let Held::Own(memory) = &self.held else { return true };
        memory.allocation().memory_properties().contains(vk::MemoryPropertyFlags::DEVICE_LOCAL)
    }

    /// Writes bytes from the host, for everything that is submitted afterwards.
    ///
    /// # Errors
    /// With nothing written: [`Error::InUse`] while the device has not finished all submitted work that uses the buffer, and
    /// [`Error::NotWritable`] if it is not [`Location::Upload`] or too small. [`Error::DeviceLost`].
    pub fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let Some(last_use) = &self.last_use else { return Err(self.not_writable(offset, bytes)) };
        let to = self.part(offset, bytes)?;
        last_use.exclusively(&self.device, &self.name, || {
            // SAFETY: `part` has as many bytes. No submitted work uses the buffer, none is submitted while this runs, and other writers wait.
            // No reference into an upload buffer is ever given out.
            unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), to.as_ptr(), bytes.len()) };
        })
    }

    /// Writes bytes from the host while submitted work may use other bytes of the buffer.
    ///
    /// # Safety
    /// Nothing else accesses these bytes meanwhile: no submitted work that may be unfinished, and no other thread.
    pub(crate) unsafe fn write_part(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let to = self.part(offset, bytes)?;
        // SAFETY: `part` has as many bytes; the rest is the caller's promise.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), to.as_ptr(), bytes.len()) };
        Ok(())
    }

    /// Where bytes at an offset lie in the mapping of an upload buffer.
    fn part(&self, offset: u64, bytes: &[u8]) -> Result<NonNull<u8>> {
        let fits = offset.checked_add(bytes.len() as u64).is_some_and(|end| end <= self.size);
        match self.mapping() {
            // SAFETY: the offset lies in the mapping, or one past its end.
            Some(host) if fits && self.location == Location::Upload => Ok(unsafe { host.add(offset as usize) }),
            _ => Err(self.not_writable(offset, bytes)),
        }
    }

    fn not_writable(&self, offset: u64, bytes: &[u8]) -> Error {
        Error::NotWritable { name: self.name.clone(), offset, bytes: bytes.len() as u64, size: self.size }
    }

    /// Its first byte for the host; `None` where the host does not see it. The mapping has at least [`Self::size`] bytes and lives as long as
    /// the buffer.
    pub(crate) fn mapping(&self) -> Option<NonNull<u8>> {
        let Held::Own(memory) = &self.held else { return None };
        memory.allocation().mapped_ptr().map(NonNull::cast)
    }

    pub(crate) fn location(&self) -> Location {
        self.location
    }

    /// The last use, which each recording with the buffer sets; `None` where the host does not write it.
    pub(crate) fn last_use(&self) -> Option<&Arc<LastUse>> {
        self.last_use.as_ref()
    }

    /// Copies bytes out, as the device left them. Nothing is lent: the device may write again at any time. `false`, with nothing copied,
    /// when the buffer is not [`Location::Download`] or too small.
    #[allow(clippy::cast_ptr_alignment, reason = "the middle starts at an aligned address")]
    pub fn read(&self, offset: u64, into: &mut [u8]) -> bool {
        let Held::Own(memory) = &self.held else { return false };
        let fits = offset.checked_add(into.len() as u64).is_some_and(|end| end <= self.size);
        let Some(host) = memory.allocation().mapped_ptr().filter(|_| fits && self.location == Location::Download)
        else {
            return false;
        };
        let start = host.as_ptr().cast::<u8>().wrapping_add(offset as usize);
        let head = start.align_offset(align_of::<u64>()).min(into.len());
        let (before, rest) = into.split_at_mut(head);
        let (words, after) = rest.split_at_mut(rest.len() & !7);
        // SAFETY: the mapping has `size` bytes, and `offset` and the length lie within. The aligned part starts at an aligned address. The
        // reads are volatile and no reference is made, since the device may write meanwhile.
        unsafe {
            for (i, byte) in before.iter_mut().enumerate() {
                *byte = start.add(i).read_volatile();
            }
            let middle = start.add(head);
            for (i, word) in words.chunks_exact_mut(8).enumerate() {
                word.copy_from_slice(&middle.add(8 * i).cast::<u64>().read_volatile().to_ne_bytes());
            }
            let end = middle.add(words.len());
            for (i, byte) in after.iter_mut().enumerate() {
                *byte = end.add(i).read_volatile();
            }
        }
        true
    }

    /// One word at a multiple of 4, as it is right now, even while the device writes it. `None` when out of range or not
    /// [`Location::Download`].
    pub fn word(&self, offset: u64) -> Option<u32> {
        let Held::Own(memory) = &self.held else { return None };
        let fits =
            self.location == Location::Download && offset.is_multiple_of(4) && offset.checked_add(4)? <= self.size;
        let host = memory.allocation().mapped_ptr().filter(|_| fits)?;
        // SAFETY: in range and aligned; volatile, since the device may write it.
        Some(unsafe { host.as_ptr().cast::<u32>().add(offset as usize / 4).read_volatile() })
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // Before `held`, whose memory it uses.
        self.device.retire(Dead::Buffer(self.raw));
    }
}

fn create_info(info: &BufferInfo) -> vk::BufferCreateInfo<'static> {
    vk::BufferCreateInfo::default().size(info.size.max(1)).usage(info.usage).sharing_mode(vk::SharingMode::EXCLUSIVE)
}
