//! Buffers.

use std::fmt;
use std::sync::Arc;

use ash::vk;

use crate::device::Device;
use crate::memory::{Backing, Held, Location};
use crate::result::{Error, Named, Result};
use crate::retire::Dead;

/// What a buffer is.
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
    name: String,
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
        let raw = unsafe { device.raw.create_buffer(&create_info(info), None) }.named("vkCreateBuffer")?;
        // SAFETY: the buffer was just made.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let held = Held::find(device, name, requirements, backing, info.location, true).and_then(|(held, memory, at)| {
            // SAFETY: memory and offset suit the requirements; the memory is held as long as the buffer.
            unsafe { device.raw.bind_buffer_memory(raw, memory, at) }.named("vkBindBufferMemory")?;
            Ok(held)
        });
        match held {
            Ok(held) => {
                device.name(raw, name);
                Ok(Buffer { raw, device: device.clone(), held, size: info.size, name: name.to_owned() })
            }
            Err(error) => {
                // SAFETY: nobody has seen the buffer.
                unsafe { device.raw.destroy_buffer(raw, None) };
                Err(error)
            }
        }
    }

    /// What a buffer would need.
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

    /// The host's view of it; `None` when it lives on the device. Reads what the device wrote before the last wait.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.held {
            Held::Own(memory) => memory.bytes().and_then(|bytes| bytes.get(..self.size as usize)),
            Held::Block(_) => None,
        }
    }

    /// The host's view of it, to be written; `None` when it lives on the device. The device must not be reading the part that is written.
    pub fn bytes_mut(&mut self) -> Option<&mut [u8]> {
        let size = self.size as usize;
        match &mut self.held {
            Held::Own(memory) => memory.bytes_mut().and_then(|bytes| bytes.get_mut(..size)),
            Held::Block(_) => None,
        }
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
