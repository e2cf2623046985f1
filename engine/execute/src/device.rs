//! The facts of a device that a plan needs, and the translation of a plan's descriptions to Vulkan's.

use std::sync::Arc;
use std::time::Duration;

use raxel_gpu::{BufferInfo, Capabilities, ClearColor, Device, DeviceKind, Image, ImageInfo, Location, Scope, vk};
use raxel_graph::checked::Clear;
use raxel_graph::plan::{
    self, AccessMask, BindingLimits, BufferDesc, DeviceLimits, ImageDesc, ImageUsage, MemoryModel, Requirements, Stages,
};
use raxel_shader::format::Format;

use super::fit::Abilities as _;

/// The limits of a device that a plan is checked against.
pub fn limits(capabilities: &Capabilities) -> DeviceLimits {
    let limits = &capabilities.limits;
    DeviceLimits {
        image_2d: limits.max_image_dimension2_d,
        image_3d: limits.max_image_dimension3_d,
        image_layers: limits.max_image_array_layers,
        storage_buffer: u64::from(limits.max_storage_buffer_range),
        uniform_buffer: u64::from(limits.max_uniform_buffer_range),
        push_constants: limits.max_push_constants_size,
        workgroup_count: limits.max_compute_work_group_count,
        workgroup_size: limits.max_compute_work_group_size,
        workgroup_invocations: limits.max_compute_work_group_invocations,
        shared_memory: limits.max_compute_shared_memory_size,
        bindings: BindingLimits {
            storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            storage_images: limits.max_per_stage_descriptor_storage_images,
            sampled_images: limits
                .max_per_stage_descriptor_sampled_images
                .min(limits.max_per_stage_descriptor_samplers),
            uniform_buffers: limits.max_per_stage_descriptor_uniform_buffers,
            resources: limits.max_per_stage_resources,
        },
    }
}

/// Memory requirements as the device states them.
#[derive(Clone, Debug)]
pub struct DeviceMemory(pub Arc<Device>);

impl MemoryModel for DeviceMemory {
    fn image(&self, image: &ImageDesc) -> Requirements {
        // A driver is asked only of images that it can make; a plan with another one is refused before anything is made (`unfit`).
        if matches!(self.0.can_make(image), Ok(false)) {
            return Requirements { size: 1, alignment: 1, type_bits: u32::MAX };
        }
        requirements(Image::requirements(&self.0, &image_info(&self.0, image)))
    }

    fn buffer(&self, buffer: &BufferDesc) -> Requirements {
        requirements(raxel_gpu::Buffer::requirements(&self.0, &buffer_info(buffer)))
    }

    fn granularity(&self) -> u64 {
        self.0.capabilities().limits.buffer_image_granularity
    }
}

fn requirements(answer: vk::MemoryRequirements) -> Requirements {
    Requirements { size: answer.size, alignment: answer.alignment, type_bits: answer.memory_type_bits }
}

pub(super) fn image_info(device: &Device, desc: &ImageDesc) -> ImageInfo {
    let format = vulkan_format(desc.format);
    let mut usage = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
    if desc.usage.storage {
        usage |= vk::ImageUsageFlags::STORAGE;
    }
    // Sampled whenever it can be: any target may become the debug target, without being created again.
    let can_sample = device.format_features(format).contains(vk::FormatFeatureFlags::SAMPLED_IMAGE);
    if desc.usage.sampled || can_sample {
        usage |= vk::ImageUsageFlags::SAMPLED;
    }
    let ImageDesc { volume, extent, mips, layers, .. } = *desc;
    ImageInfo { format, volume, extent, mips, layers, usage }
}

/// An image for texels from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Texel format.
    pub format: Format,
    /// Texels of mip 0; the third is 1 unless `volume`.
    pub extent: [u32; 3],
    /// 3-D, else 2-D.
    pub volume: bool,
}

/// Puts texels into an image: every mip, x first, then y, then z, without padding. It is in `GENERAL`, and can be bound in every way
/// that the device allows for its format. Waits for the copies.
#[expect(clippy::cast_possible_truncation, reason = "an image has 32 mips at most")]
pub fn upload_image(
    device: &Arc<Device>,
    name: &str,
    texture: Texture,
    mips: &[&[u8]],
    timeout: Duration,
) -> raxel_gpu::Result<Arc<Image>> {
    let info = texture_info(device, texture, mips.len() as u32);
    raxel_gpu::upload_image(device, name, &info, texture.format.bytes(), mips, timeout)
}

/// Bytes that an image for [`upload_image`] may have: at most the driver's limit for one image, and the free memory. Devices that have
/// no memory of their own share the host's, where the texels are put together and staged.
pub fn largest_image(device: &Device, format: Format) -> u64 {
    let capabilities = device.capabilities();
    let room = match capabilities.kind {
        DeviceKind::Discrete => capabilities.memory,
        _ => capabilities.memory / 4,
    };
    device.largest_image(&texture_info(device, Texture { format, extent: [1; 3], volume: true }, 1)).min(room)
}

fn texture_info(device: &Device, Texture { format, extent, volume }: Texture, mips: u32) -> ImageInfo {
    let storage = device.format_features(vulkan_format(format)).contains(vk::FormatFeatureFlags::STORAGE_IMAGE);
    let usage = ImageUsage { storage, sampled: true };
    image_info(device, &ImageDesc { format, volume, extent, mips, layers: 1, usage })
}

pub(super) fn buffer_info(desc: &BufferDesc) -> BufferInfo {
    let mut usage =
        vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
    if desc.uniform {
        usage |= vk::BufferUsageFlags::UNIFORM_BUFFER;
    }
    if desc.indirect {
        usage |= vk::BufferUsageFlags::INDIRECT_BUFFER;
    }
    // Clears fill whole words.
    BufferInfo { size: desc.size.max(4).next_multiple_of(4), usage, location: Location::Device }
}

pub(super) fn scope(scope: plan::Scope) -> Scope {
    let mut stages = vk::PipelineStageFlags2::empty();
    for (ours, theirs) in [
        (Stages::COMPUTE_SHADER, vk::PipelineStageFlags2::COMPUTE_SHADER),
        // Whether a buffer fill is a clear or a copy has changed between versions of the validation layer: both.
        (Stages::CLEAR, vk::PipelineStageFlags2::CLEAR | vk::PipelineStageFlags2::COPY),
        (Stages::DRAW_INDIRECT, vk::PipelineStageFlags2::DRAW_INDIRECT),
    ] {
        if scope.stages.contains(ours) {
            stages |= theirs;
        }
    }
    let mut access = vk::AccessFlags2::empty();
    for (ours, theirs) in [
        (AccessMask::SHADER_STORAGE_READ, vk::AccessFlags2::SHADER_STORAGE_READ),
        (AccessMask::SHADER_STORAGE_WRITE, vk::AccessFlags2::SHADER_STORAGE_WRITE),
        (AccessMask::SHADER_SAMPLED_READ, vk::AccessFlags2::SHADER_SAMPLED_READ),
        (AccessMask::UNIFORM_READ, vk::AccessFlags2::UNIFORM_READ),
        (AccessMask::TRANSFER_WRITE, vk::AccessFlags2::TRANSFER_WRITE),
        (AccessMask::TRANSFER_READ, vk::AccessFlags2::TRANSFER_READ),
        (AccessMask::INDIRECT_COMMAND_READ, vk::AccessFlags2::INDIRECT_COMMAND_READ),
    ] {
        if scope.access.contains(ours) {
            access |= theirs;
        }
    }
    (stages, access)
}

pub(super) fn color(clear: Clear) -> ClearColor {
    match clear {
        Clear::Float(value) => ClearColor::Float(value),
        Clear::Int(value) => ClearColor::Int(value),
        Clear::Uint(value) => ClearColor::Uint(value),
    }
}

/// The 32-bit pattern of a buffer's clear.
pub(super) fn pattern(clear: Clear) -> u32 {
    match clear {
        Clear::Float(value) => value[0].to_bits(),
        Clear::Int(value) => value[0].cast_unsigned(),
        Clear::Uint(value) => value[0],
    }
}

/// Vulkan's format of that name.
pub fn vulkan_format(format: Format) -> vk::Format {
    match format {
        Format::Rgba32f => vk::Format::R32G32B32A32_SFLOAT,
        Format::Rgba16f => vk::Format::R16G16B16A16_SFLOAT,
        Format::Rg32f => vk::Format::R32G32_SFLOAT,
        Format::Rg16f => vk::Format::R16G16_SFLOAT,
        Format::R11fG11fB10f => vk::Format::B10G11R11_UFLOAT_PACK32,
        Format::R32f => vk::Format::R32_SFLOAT,
        Format::R16f => vk::Format::R16_SFLOAT,
        Format::Rgba16 => vk::Format::R16G16B16A16_UNORM,
        Format::Rgb10A2 => vk::Format::A2B10G10R10_UNORM_PACK32,
        Format::Rgba8 => vk::Format::R8G8B8A8_UNORM,
        Format::Rg16 => vk::Format::R16G16_UNORM,
        Format::Rg8 => vk::Format::R8G8_UNORM,
        Format::R16 => vk::Format::R16_UNORM,
        Format::R8 => vk::Format::R8_UNORM,
        Format::Rgba16Snorm => vk::Format::R16G16B16A16_SNORM,
        Format::Rgba8Snorm => vk::Format::R8G8B8A8_SNORM,
        Format::Rg16Snorm => vk::Format::R16G16_SNORM,
        Format::Rg8Snorm => vk::Format::R8G8_SNORM,
        Format::R16Snorm => vk::Format::R16_SNORM,
        Format::R8Snorm => vk::Format::R8_SNORM,
        Format::Rgba32i => vk::Format::R32G32B32A32_SINT,
        Format::Rgba16i => vk::Format::R16G16B16A16_SINT,
        Format::Rgba8i => vk::Format::R8G8B8A8_SINT,
        Format::Rg32i => vk::Format::R32G32_SINT,
        Format::Rg16i => vk::Format::R16G16_SINT,
        Format::Rg8i => vk::Format::R8G8_SINT,
        Format::R32i => vk::Format::R32_SINT,
        Format::R16i => vk::Format::R16_SINT,
        Format::R8i => vk::Format::R8_SINT,
        Format::Rgba32ui => vk::Format::R32G32B32A32_UINT,
        Format::Rgba16ui => vk::Format::R16G16B16A16_UINT,
        Format::Rgb10A2ui => vk::Format::A2B10G10R10_UINT_PACK32,
        Format::Rgba8ui => vk::Format::R8G8B8A8_UINT,
        Format::Rg32ui => vk::Format::R32G32_UINT,
        Format::Rg16ui => vk::Format::R16G16_UINT,
        Format::Rg8ui => vk::Format::R8G8_UINT,
        Format::R32ui => vk::Format::R32_UINT,
        Format::R16ui => vk::Format::R16_UINT,
        Format::R8ui => vk::Format::R8_UINT,
    }
}
