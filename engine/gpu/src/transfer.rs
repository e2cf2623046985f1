//! Bytes to the device and back, by staging buffers.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use crate::buffer::{Buffer, BufferInfo};
use crate::command::{Barrier, CommandBuffer};
use crate::device::Device;
use crate::image::Image;
use crate::memory::{Backing, Location};
use crate::result::{Error, Result};

/// Makes a storage buffer on the device that holds `bytes` (padded with zeros to a multiple of 4). Waits for the copy; may be called
/// from any thread.
pub fn upload(device: &Arc<Device>, name: &str, bytes: &[u8], timeout: Option<Duration>) -> Result<Buffer> {
    let size = (bytes.len() as u64).max(4).next_multiple_of(4);
    let limit = u64::from(device.capabilities().limits.max_storage_buffer_range);
    if size > limit {
        return Err(Error::TooLarge { name: name.to_owned(), size, limit });
    }
    let usage =
        vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
    let buffer = Buffer::new(device, name, &BufferInfo { size, usage, location: Location::Device }, Backing::Own)?;
    let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_SRC, location: Location::Upload };
    let staging = Buffer::new(device, &format!("{name}, staging"), &info, Backing::Own)?;
    let padding = [0; 4];
    let written = staging.write(0, bytes) && staging.write(bytes.len() as u64, &padding[..size as usize - bytes.len()]);
    if !written {
        return Err(unmapped(name, size));
    }
    let mut commands = CommandBuffer::new(device, "upload")?;
    commands.begin()?;
    commands.copy_buffer(&staging, 0, &buffer, size);
    commands.barrier(&Barrier::full());
    let moment = commands.submit()?;
    device.wait(moment, timeout)?;
    Ok(buffer)
}

/// Reads a part of a buffer back, after everything submitted so far.
pub fn download_buffer(
    device: &Arc<Device>,
    buffer: &Buffer,
    offset: u64,
    size: u64,
    timeout: Option<Duration>,
) -> Result<Vec<u8>> {
    download(device, buffer.name(), size, timeout, |commands, staging| {
        commands.copy_buffer(buffer, offset, staging, size);
    })
}

/// Reads one layer (or slice of a 3-D image) of one mip back, after everything submitted so far. The image is in `GENERAL`.
pub fn download_image(
    device: &Arc<Device>,
    image: &Image,
    texel_bytes: u32,
    mip: u32,
    layer: u32,
    timeout: Option<Duration>,
) -> Result<Vec<u8>> {
    let [width, height, _] = image.mip_extent(mip);
    let size = u64::from(width) * u64::from(height) * u64::from(texel_bytes);
    download(device, image.name(), size, timeout, |commands, staging| {
        commands.copy_image_to_buffer(image, mip, layer, staging);
    })
}

fn download(
    device: &Arc<Device>,
    name: &str,
    size: u64,
    timeout: Option<Duration>,
    copy: impl FnOnce(&mut CommandBuffer, &Buffer),
) -> Result<Vec<u8>> {
    if size == 0 {
        return Ok(Vec::new());
    }
    let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_DST, location: Location::Download };
    let staging = Buffer::new(device, &format!("{name}, read-back"), &info, Backing::Own)?;
    let mut commands = CommandBuffer::new(device, "read-back")?;
    commands.begin()?;
    commands.barrier(&Barrier::full());
    copy(&mut commands, &staging);
    commands.barrier(&Barrier::full());
    let moment = commands.submit()?;
    device.wait(moment, timeout)?;
    staging.bytes().map(<[u8]>::to_vec).ok_or_else(|| unmapped(name, size))
}

fn unmapped(name: &str, size: u64) -> Error {
    Error::OutOfMemory { name: format!("{name}, host-visible"), size }
}
