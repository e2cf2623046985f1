//! Bytes to the device and back, by staging buffers.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use crate::buffer::{Buffer, BufferInfo};
use crate::command::{Barrier, CommandBuffer};
use crate::device::Device;
use crate::image::{Image, ImageInfo};
use crate::memory::{Backing, Location};
use crate::readback::ReadbackRing;
use crate::result::{Error, Result};

/// Makes a storage buffer on the device that holds `bytes` (padded with zeros to a multiple of 4). Waits for the copy; may be called
/// from any thread.
#[expect(clippy::cast_possible_truncation, reason = "it is the length of a slice, rounded up")]
pub fn upload(device: &Arc<Device>, name: &str, bytes: &[u8], timeout: Duration) -> Result<Buffer> {
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
    staging.write(0, bytes)?;
    staging.write(bytes.len() as u64, &padding[..size as usize - bytes.len()])?;
    let mut commands = CommandBuffer::new(device, "upload")?;
    let mut recording = commands.begin()?;
    recording.copy_buffer((&staging, 0), (&buffer, 0), size);
    recording.barrier(&Barrier::full());
    let value = recording.submit()?;
    device.wait(value, timeout)?;
    Ok(buffer)
}

/// Bytes of one staging buffer for an image, unless a single slice has more.
const STAGING_BYTES: u64 = 64 << 20;

/// Makes an image of one layer whose mips hold `mips`: texels of `texel_bytes` bytes, x first, then y, then z, without padding. It is in `GENERAL`
/// and visible to everything after. Waits for the copies; may be called from any thread.
#[expect(
    clippy::cast_possible_truncation,
    reason = "slices are at most `depth`, and places outside the texels are outside the slice for `usize` too"
)]
pub fn upload_image(
    device: &Arc<Device>,
    name: &str,
    info: &ImageInfo,
    texel_bytes: u32,
    mips: &[&[u8]],
    timeout: Duration,
) -> Result<Arc<Image>> {
    let image = Arc::new(Image::new(device, name, info, Backing::Own)?);
    let mut commands = CommandBuffer::new(device, "upload")?;
    let all = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE);
    let mut before = Barrier::default().activate(&image, all, all);
    for (mip, texels) in (0..info.mips).zip(mips) {
        let [width, height, depth] = image.mip_extent(mip);
        let slice = u64::from(width) * u64::from(height) * u64::from(texel_bytes);
        let slices = (STAGING_BYTES / slice.max(1)).clamp(1, u64::from(depth)) as u32;
        for first in (0..depth).step_by(slices as usize) {
            let count = slices.min(depth - first);
            let (start, size) = (u64::from(first) * slice, u64::from(count) * slice);
            let usage = vk::BufferUsageFlags::TRANSFER_SRC;
            let info = BufferInfo { size, usage, location: Location::Upload };
            let staging = Buffer::new(device, &format!("{name}, staging"), &info, Backing::Own)?;
            let part = texels.get(start as usize..(start + size) as usize);
            let Some(part) = part else {
                let (name, there) = (format!("{name}, mip {mip}"), texels.len() as u64);
                return Err(Error::NotWritable { name, offset: start, bytes: size, size: there });
            };
            staging.write(0, part)?;
            let mut recording = commands.begin()?;
            recording.barrier(&std::mem::replace(&mut before, Barrier::full()));
            recording.copy_buffer_to_texels((&staging, 0), &image, mip, [0, 0, first], [width, height, count]);
            recording.barrier(&Barrier::full());
            let value = recording.submit()?;
            device.wait(value, timeout)?;
        }
    }
    Ok(image)
}

/// Reads a part of a buffer back, after everything submitted so far. Waits for the copy.
pub fn download_buffer(
    device: &Arc<Device>,
    buffer: &Buffer,
    offset: u64,
    size: u64,
    timeout: Duration,
) -> Result<Vec<u8>> {
    ReadbackRing::new(device).buffer(buffer, offset, size)?.wait(timeout)
}

/// Reads one layer (or slice of a 3-D image) of one mip back, after everything submitted so far. The image is in `GENERAL`. Waits for the
/// copy.
pub fn download_image(
    device: &Arc<Device>,
    image: &Image,
    texel_bytes: u32,
    mip: u32,
    layer: u32,
    timeout: Duration,
) -> Result<Vec<u8>> {
    ReadbackRing::new(device).image(image, texel_bytes, mip, layer)?.wait(timeout)
}
