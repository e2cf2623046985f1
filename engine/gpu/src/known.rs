//! Devices that are known from reports: their limits and features, to check a graph for a device that is not here.

mod named;

use ash::vk;
use spirv::Capability;

pub use self::named::*;
use crate::choice::{DeviceKind, Version};
use crate::device::Capabilities;
use crate::modules::{self, Enabled};
use crate::query::QueueClock;
use crate::subgroups;

/// The limits and features of a device, from reports about it. A limit that no report has is as large as raxel ever asks for, unless the device says
/// otherwise. A feature that no report has is missing.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is something that a device has or lacks")]
pub struct KnownDevice {
    /// Name in messages.
    pub name: &'static str,
    /// `maxPerStageDescriptorStorageBuffers`.
    pub storage_buffers: u32,
    /// `maxPerStageDescriptorStorageImages`.
    pub storage_images: u32,
    /// `maxPerStageDescriptorSampledImages`.
    pub sampled_images: u32,
    /// `maxPerStageDescriptorSamplers`.
    pub samplers: u32,
    /// `maxPerStageDescriptorUniformBuffers`.
    pub uniform_buffers: u32,
    /// `maxPerStageResources`.
    pub resources: u32,
    /// `maxComputeWorkGroupInvocations`.
    pub invocations: u32,
    /// `maxComputeWorkGroupSize`.
    pub workgroup: [u32; 3],
    /// `maxComputeSharedMemorySize`, bytes.
    pub shared_memory: u32,
    /// `maxPushConstantsSize`, bytes.
    pub push_constants: u32,
    /// `maxStorageBufferRange`, bytes.
    pub buffer_range: u32,
    /// `maxUniformBufferRange`, bytes.
    pub uniform_range: u32,
    /// `maxImageDimension2D` and `maxImageDimension3D`.
    pub image_sides: [u32; 2],
    /// `maxImageArrayLayers`.
    pub image_layers: u32,
    /// `minStorageBufferOffsetAlignment`, `minUniformBufferOffsetAlignment`, `nonCoherentAtomSize`, bytes.
    pub alignment: u32,
    /// `bufferImageGranularity`, bytes.
    pub granularity: u32,
    /// Subgroup operations of compute shaders.
    pub subgroup_operations: vk::SubgroupFeatureFlags,
    /// Sizes of subgroups, where they are known.
    pub subgroups: Option<Subgroups>,
    /// Features that Vulkan does not demand and the device lacks.
    pub without: &'static [Feature],
    /// Storage images of formats beyond those that every device has, filters for floats of 32 bits, and images of 16 normalized bits.
    pub formats: bool,
    /// `timestampValidBits` of the queue; 0 where it does not say when a pass ended.
    pub timestamp_bits: u32,
    /// The queue draws, too (`VK_QUEUE_GRAPHICS_BIT`).
    pub graphics: bool,
    /// `VK_KHR_swapchain`.
    pub swapchain: bool,
    /// Extensions besides the swapchain's, and those of `minor` 2.
    pub extensions: bool,
    /// Vulkan 1.1, 1.2 or 1.3. Of 1.2, the device has the extensions for what raxel needs of 1.3.
    pub minor: u32,
}

/// A device's reported sizes of subgroups.
#[derive(Clone, Copy, Debug)]
pub struct Subgroups {
    /// `subgroupSize`: the size of a pipeline that asks for none.
    pub usual: u32,
    /// `minSubgroupSize` and `maxSubgroupSize`.
    pub range: [u32; 2],
    /// `maxComputeWorkgroupSubgroups`.
    pub in_workgroup: u32,
    /// Compute pipelines may ask for a size (`requiredSubgroupSizeStages`).
    pub asked: bool,
}

/// A feature of shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is Vulkan's feature of that name")]
pub enum Feature {
    Int64,
    Int16,
    Int8,
    Float64,
    Float16,
    Int64Atomics,
    Storage8,
    ScalarLayout,
    ReadWithoutFormat,
    WriteWithoutFormat,
    ExtendedFormats,
    IndexedStorageImages,
    IndexedSampledImages,
    IndexedStorageBuffers,
}

impl Feature {
    /// Every one.
    pub const ALL: &[Self] = &[
        Self::Int64,
        Self::Int16,
        Self::Int8,
        Self::Float64,
        Self::Float16,
        Self::Int64Atomics,
        Self::Storage8,
        Self::ScalarLayout,
        Self::ReadWithoutFormat,
        Self::WriteWithoutFormat,
        Self::ExtendedFormats,
        Self::IndexedStorageImages,
        Self::IndexedSampledImages,
        Self::IndexedStorageBuffers,
    ];

    /// The capability of a module that needs it. Blocks in scalar layout declare none, and formats are those of each image.
    pub fn capability(self) -> Option<Capability> {
        Some(match self {
            Self::Int64 => Capability::Int64,
            Self::Int16 => Capability::Int16,
            Self::Int8 => Capability::Int8,
            Self::Float64 => Capability::Float64,
            Self::Float16 => Capability::Float16,
            Self::Int64Atomics => Capability::Int64Atomics,
            Self::Storage8 => Capability::StorageBuffer8BitAccess,
            Self::ReadWithoutFormat => Capability::StorageImageReadWithoutFormat,
            Self::WriteWithoutFormat => Capability::StorageImageWriteWithoutFormat,
            Self::IndexedStorageImages => Capability::StorageImageArrayDynamicIndexing,
            Self::IndexedSampledImages => Capability::SampledImageArrayDynamicIndexing,
            Self::IndexedStorageBuffers => Capability::StorageBufferArrayDynamicIndexing,
            Self::ScalarLayout | Self::ExtendedFormats => return None,
        })
    }
}

impl KnownDevice {
    /// What raxel would see of the device. The version of its driver and its memory are unknown: its name stands for the one, and 0 for the other.
    pub fn capabilities(&self) -> Capabilities {
        let (limits, operations, plain_ballots) = (self.limits(), self.subgroup_operations, self.extensions);
        let (core, on12, on13) = self.features();
        let floats = vk::PhysicalDeviceFloatControlsProperties::default();
        let enabled = Enabled { core: &core, on12: &on12, on13: &on13, operations, plain_ballots, floats: &floats };
        let sizes = self.subgroups.filter(|_| self.minor > 2).and_then(|known| known.asked(&limits));
        let period = limits.timestamp_period;
        Capabilities {
            name: self.name.to_owned(),
            driver: self.name.to_owned(),
            kind: DeviceKind::Other,
            version: Version::from_packed(vk::make_api_version(0, 1, self.minor, 0)),
            memory: 0,
            limits,
            subgroup_size: self.subgroups.map_or(1, |known| known.usual),
            subgroup_sizes: sizes,
            subgroup_operations: operations,
            shaders: modules::allowed(&enabled),
            int64: self.has(Feature::Int64),
            robust_buffers: true,
            robust_images: self.minor > 2,
            read_without_format: self.has(Feature::ReadWithoutFormat),
            write_without_format: self.has(Feature::WriteWithoutFormat),
            clock: (self.timestamp_bits > 0).then_some(QueueClock { period, bits: self.timestamp_bits }),
            cannot_present: (!self.swapchain).then_some("its driver has no VK_KHR_swapchain"),
            plain_ballots,
            buffer_markers: false,
            graphics: self.graphics,
            validated: false,
        }
    }

    fn has(&self, feature: Feature) -> bool {
        !self.without.contains(&feature)
    }

    fn limits(&self) -> vk::PhysicalDeviceLimits {
        vk::PhysicalDeviceLimits {
            max_per_stage_descriptor_storage_buffers: self.storage_buffers,
            max_per_stage_descriptor_storage_images: self.storage_images,
            max_per_stage_descriptor_sampled_images: self.sampled_images,
            max_per_stage_descriptor_samplers: self.samplers,
            max_per_stage_descriptor_uniform_buffers: self.uniform_buffers,
            max_per_stage_resources: self.resources,
            max_compute_work_group_invocations: self.invocations,
            max_compute_work_group_size: self.workgroup,
            // Every driver has these. Some have more along x.
            max_compute_work_group_count: [65535; 3],
            max_compute_shared_memory_size: self.shared_memory,
            max_push_constants_size: self.push_constants,
            max_storage_buffer_range: self.buffer_range,
            max_uniform_buffer_range: self.uniform_range,
            max_image_dimension2_d: self.image_sides[0],
            max_image_dimension3_d: self.image_sides[1],
            max_image_array_layers: self.image_layers,
            min_storage_buffer_offset_alignment: self.alignment.into(),
            min_uniform_buffer_offset_alignment: self.alignment.into(),
            non_coherent_atom_size: self.alignment.into(),
            buffer_image_granularity: self.granularity.into(),
            timestamp_period: 1.0,
            ..Default::default()
        }
    }

    /// Its features of shaders: those of Vulkan 1.0, of 1.2, and of 1.3.
    fn features(
        &self,
    ) -> (
        vk::PhysicalDeviceFeatures,
        vk::PhysicalDeviceVulkan12Features<'static>,
        vk::PhysicalDeviceVulkan13Features<'static>,
    ) {
        let has = |feature| vk::Bool32::from(self.has(feature));
        let core = vk::PhysicalDeviceFeatures {
            shader_int64: has(Feature::Int64),
            shader_int16: has(Feature::Int16),
            shader_float64: has(Feature::Float64),
            shader_storage_image_read_without_format: has(Feature::ReadWithoutFormat),
            shader_storage_image_write_without_format: has(Feature::WriteWithoutFormat),
            shader_storage_image_extended_formats: has(Feature::ExtendedFormats),
            shader_storage_image_array_dynamic_indexing: has(Feature::IndexedStorageImages),
            shader_sampled_image_array_dynamic_indexing: has(Feature::IndexedSampledImages),
            shader_storage_buffer_array_dynamic_indexing: has(Feature::IndexedStorageBuffers),
            ..Default::default()
        };
        let on12 = vk::PhysicalDeviceVulkan12Features {
            shader_int8: has(Feature::Int8),
            shader_float16: has(Feature::Float16),
            storage_buffer8_bit_access: has(Feature::Storage8),
            shader_buffer_int64_atomics: has(Feature::Int64Atomics),
            scalar_block_layout: has(Feature::ScalarLayout),
            // Vulkan 1.3 demands both.
            vulkan_memory_model: vk::TRUE,
            vulkan_memory_model_device_scope: vk::TRUE,
            ..Default::default()
        };
        let on13 = vk::PhysicalDeviceVulkan13Features {
            shader_integer_dot_product: vk::Bool32::from(self.minor > 2),
            ..Default::default()
        };
        (core, on12, on13)
    }
}

impl Subgroups {
    /// The sizes that a compute pipeline can ask for.
    fn asked(&self, limits: &vk::PhysicalDeviceLimits) -> Option<[u32; 2]> {
        let stages = if self.asked { vk::ShaderStageFlags::COMPUTE } else { vk::ShaderStageFlags::empty() };
        let sizes = vk::PhysicalDeviceSubgroupSizeControlProperties {
            min_subgroup_size: self.range[0],
            max_subgroup_size: self.range[1],
            max_compute_workgroup_subgroups: self.in_workgroup,
            required_subgroup_size_stages: stages,
            ..Default::default()
        };
        subgroups::sizes(&sizes, limits)
    }
}

/// The known devices that somebody may mean: those of this name, else those whose names contain it, else those that have each of its words. Case and
/// signs do not count.
pub fn named(name: &str) -> Vec<&'static KnownDevice> {
    let plain =
        |text: &str| text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    let whole = plain(name);
    let words: Vec<String> = name.split_whitespace().map(plain).filter(|word| !word.is_empty()).collect();
    // A number is a word of its own: `2` is no part of `1.2`.
    let is_in = |word: &String, other: String| {
        other.starts_with(word) || word.starts_with(char::is_alphabetic) && other.contains(word)
    };
    let has =
        |device: &KnownDevice, word: &String| device.name.split_whitespace().any(|other| is_in(word, plain(other)));
    let ways: [&dyn Fn(&KnownDevice) -> bool; 3] =
        [&|device| plain(device.name) == whole, &|device| plain(device.name).contains(&whole), &|device| {
            words.iter().all(|word| has(device, word))
        }];
    let found = |way: &&dyn Fn(&KnownDevice) -> bool| DEVICES.iter().filter(|device| way(device)).collect::<Vec<_>>();
    if whole.is_empty() {
        Vec::new()
    } else {
        ways.iter().map(found).find(|found| !found.is_empty()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_found_by_its_name_or_by_words_of_it() {
        let names = |name: &str| named(name).iter().map(|device| device.name).collect::<Vec<_>>();
        assert_eq!(names("Raspberry Pi 5"), [SMALL.name]);
        assert_eq!(names("raspberry-pi 5 (v3dv)"), [SMALL.name]);
        assert_eq!(names("pi5"), [SMALL.name]);
        assert_eq!(names("UHD"), [INTEL_MESA.name, INTEL_WINDOWS.name]);
        assert_eq!(names("windows uhd"), [INTEL_WINDOWS.name]);
        assert_eq!(names("Mali G78"), [MALI.name]);
        assert_eq!(names("Raspberry Pi 2"), [""; 0]);
        assert_eq!(names("Voodoo"), [""; 0]);
        assert_eq!(names(" - "), [""; 0]);
        for device in DEVICES {
            assert_eq!(names(device.name), [device.name]);
        }
    }

    #[test]
    fn the_least_device_has_what_vulkan_guarantees() {
        let least = LEAST.capabilities();
        for lacks in [Capability::Int64, Capability::StorageImageWriteWithoutFormat, Capability::SubgroupBallotKHR] {
            assert!(!least.shaders.contains(&lacks), "{lacks:?}");
        }
        assert!(!least.traces_packets() && !least.has_plain_ballots());
        assert!(VEGA.capabilities().traces_packets() && VEGA.capabilities().shaders.contains(&Capability::Int64));
        assert!(!METAL.capabilities().traces_packets());
        assert_eq!(INTEL_MESA.capabilities().subgroup_sizes, Some([32, 32]));
    }
}
