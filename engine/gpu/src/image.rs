//! Images and their views.

use std::fmt;
use std::sync::Arc;

use ash::vk;

use crate::device::Device;
use crate::memory::{Backing, Held, Location};
use crate::result::{Error, Named, Result};
use crate::retire::Dead;

/// The properties of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageInfo {
    /// Texel format.
    pub format: vk::Format,
    /// 3-D, else 2-D.
    pub volume: bool,
    /// Texels of mip 0; the third is 1 unless `volume`.
    pub extent: [u32; 3],
    /// Mips.
    pub mips: u32,
    /// Array layers.
    pub layers: u32,
    /// Usages.
    pub usage: vk::ImageUsageFlags,
}

impl ImageInfo {
    pub(crate) fn kind(&self) -> (vk::ImageType, vk::ImageCreateFlags) {
        (if self.volume { vk::ImageType::TYPE_3D } else { vk::ImageType::TYPE_2D }, vk::ImageCreateFlags::empty())
    }

    fn create_info(&self) -> vk::ImageCreateInfo<'static> {
        let [width, height, depth] = self.extent;
        let (ty, flags) = self.kind();
        vk::ImageCreateInfo::default()
            .flags(flags)
            .image_type(ty)
            .format(self.format)
            .extent(vk::Extent3D { width, height, depth })
            .mip_levels(self.mips)
            .array_layers(self.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(self.usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE)
            .initial_layout(vk::ImageLayout::UNDEFINED)
    }
}

/// An image and its memory. Its contents are in `GENERAL` once it was first brought there by a barrier.
pub struct Image {
    pub(crate) raw: vk::Image,
    device: Arc<Device>,
    _held: Held,
    info: ImageInfo,
    name: String,
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.info.extent;
        write!(f, "Image({}, {:?}, {x}x{y}x{z})", self.name, self.info.format)
    }
}

impl Image {
    /// Makes an image.
    pub fn new(device: &Arc<Device>, name: &str, info: &ImageInfo, backing: Backing<'_>) -> Result<Image> {
        if !device.image_support(info)? {
            return Err(Error::FormatUnsupported {
                name: name.to_owned(),
                format: info.format,
                usage: format!("{:?} of {:?}", info.usage, info.extent),
            });
        }
        // SAFETY: the info is plain data and the device supports it.
        let raw = unsafe { device.raw.create_image(&info.create_info(), None) }.making(name, "vkCreateImage")?;
        // SAFETY: the image was just made.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        let held =
            Held::find(device, name, requirements, backing, Location::Device, false).and_then(|(held, memory, at)| {
                // SAFETY: memory and offset suit the requirements; the memory is held as long as the image.
                unsafe { device.raw.bind_image_memory(raw, memory, at) }.making(name, "vkBindImageMemory")?;
                Ok(held)
            });
        match held {
            Ok(held) => {
                device.name(raw, name);
                let (device, name) = (device.clone(), name.to_owned());
                Ok(Image { raw, device, _held: held, info: *info, name })
            }
            Err(error) => {
                // SAFETY: no other code has the image yet.
                unsafe { device.raw.destroy_image(raw, None) };
                Err(error)
            }
        }
    }

    /// The memory that an image would need.
    pub fn requirements(device: &Device, info: &ImageInfo) -> vk::MemoryRequirements {
        let create = info.create_info();
        let query = vk::DeviceImageMemoryRequirements::default().create_info(&create);
        let mut answer = vk::MemoryRequirements2::default();
        // SAFETY: maintenance4 is on; the info is plain data.
        unsafe { device.raw.get_device_image_memory_requirements(&query, &mut answer) };
        answer.memory_requirements
    }

    /// Its properties.
    pub fn info(&self) -> &ImageInfo {
        &self.info
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of a texel; `None` of formats that are not plain texels of a colour.
    pub(crate) fn texel_bytes(&self) -> Option<u64> {
        texel_bytes(self.info.format)
    }

    /// The bytes of a box of texels of one mip, in each of the first `layers` layers the same box. Panics if there is none: on the device it would
    /// be memory of another.
    pub(crate) fn require(&self, mip: u32, first: [u32; 3], extent: [u32; 3], layers: u32) -> u64 {
        let there = self.mip_extent(mip.min(self.info.mips));
        let inside = (0..3).all(|axis| first[axis].checked_add(extent[axis]).is_some_and(|end| end <= there[axis]));
        assert!(
            inside && mip < self.info.mips && layers <= self.info.layers,
            "{extent:?} texels at {first:?} of mip {mip}, layer {}, are not part of {self:?}",
            layers.saturating_sub(1)
        );
        let texels = extent.iter().fold(1_u64, |texels, side| texels.saturating_mul(u64::from(*side)));
        let bytes = self.texel_bytes().and_then(|bytes| texels.checked_mul(bytes));
        bytes.unwrap_or_else(|| panic!("{self:?} has texels of a size that is not known"))
    }

    /// Texels of a mip.
    pub fn mip_extent(&self, mip: u32) -> [u32; 3] {
        self.info.extent.map(|texels| (texels >> mip).max(1))
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // Before `_held`, whose memory it uses.
        self.device.retire(Dead::Image(self.raw));
    }
}

/// Bytes of a texel, by the order of `VkFormat`, in which formats of one size follow each other; `None` of depth and compressed formats.
fn texel_bytes(format: vk::Format) -> Option<u64> {
    Some(match format.as_raw() {
        1 | 9..=15 => 1,
        2..=8 | 16..=22 | 70..=76 => 2,
        23..=36 => 3,
        37..=69 | 77..=83 | 98..=100 | 122..=123 => 4,
        84..=90 => 6,
        91..=97 | 101..=103 | 110..=112 => 8,
        104..=106 => 12,
        107..=109 | 113..=115 => 16,
        116..=118 => 24,
        119..=121 => 32,
        _ => return None,
    })
}

/// The part of an image that a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ViewInfo {
    /// Dimension and arrayness that the shader declares.
    pub ty: vk::ImageViewType,
    /// First mip.
    pub first_mip: u32,
    /// Number of mips.
    pub mips: u32,
    /// First layer.
    pub first_layer: u32,
    /// Number of layers.
    pub layers: u32,
}

impl ViewInfo {
    /// A 2-D image of one mip and one layer.
    pub const FLAT: Self = Self { ty: vk::ImageViewType::TYPE_2D, first_mip: 0, mips: 1, first_layer: 0, layers: 1 };
}

/// A view of a part of an image; holds the image.
pub struct ImageView {
    pub(crate) raw: vk::ImageView,
    device: Arc<Device>,
    image: Arc<Image>,
}

impl ImageView {
    /// Makes a view.
    pub fn new(device: &Arc<Device>, image: &Arc<Image>, info: &ViewInfo) -> Result<ImageView> {
        let create = vk::ImageViewCreateInfo::default()
            .image(image.raw)
            .view_type(info.ty)
            .format(image.info.format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                base_mip_level: info.first_mip,
                level_count: info.mips,
                base_array_layer: info.first_layer,
                layer_count: info.layers,
            });
        // SAFETY: the image is alive and held by the view.
        let raw = unsafe { device.raw.create_image_view(&create, None) }.named("vkCreateImageView")?;
        device.name(raw, &image.name);
        Ok(ImageView { raw, device: device.clone(), image: image.clone() })
    }

    /// The image.
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }
}

impl Drop for ImageView {
    fn drop(&mut self) {
        self.device.retire(Dead::View(self.raw));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_have_the_bytes_of_their_format() {
        let formats = [
            (vk::Format::UNDEFINED, None),
            (vk::Format::R4G4_UNORM_PACK8, Some(1)),
            (vk::Format::A1R5G5B5_UNORM_PACK16, Some(2)),
            (vk::Format::R8_UNORM, Some(1)),
            (vk::Format::R8_SRGB, Some(1)),
            (vk::Format::R8G8_UNORM, Some(2)),
            (vk::Format::B8G8R8_SRGB, Some(3)),
            (vk::Format::R8G8B8A8_UNORM, Some(4)),
            (vk::Format::B8G8R8A8_SRGB, Some(4)),
            (vk::Format::A2B10G10R10_SINT_PACK32, Some(4)),
            (vk::Format::R16_UNORM, Some(2)),
            (vk::Format::R16_SFLOAT, Some(2)),
            (vk::Format::R16G16_SFLOAT, Some(4)),
            (vk::Format::R16G16B16_SFLOAT, Some(6)),
            (vk::Format::R16G16B16A16_UNORM, Some(8)),
            (vk::Format::R16G16B16A16_SFLOAT, Some(8)),
            (vk::Format::R32_UINT, Some(4)),
            (vk::Format::R32G32_SFLOAT, Some(8)),
            (vk::Format::R32G32B32_SFLOAT, Some(12)),
            (vk::Format::R32G32B32A32_SFLOAT, Some(16)),
            (vk::Format::R64_SFLOAT, Some(8)),
            (vk::Format::R64G64_SFLOAT, Some(16)),
            (vk::Format::R64G64B64_SFLOAT, Some(24)),
            (vk::Format::R64G64B64A64_SFLOAT, Some(32)),
            (vk::Format::B10G11R11_UFLOAT_PACK32, Some(4)),
            (vk::Format::E5B9G9R9_UFLOAT_PACK32, Some(4)),
            (vk::Format::D16_UNORM, None),
            (vk::Format::BC1_RGB_UNORM_BLOCK, None),
        ];
        for (format, bytes) in formats {
            assert_eq!(texel_bytes(format), bytes, "{format:?}");
        }
    }
}
