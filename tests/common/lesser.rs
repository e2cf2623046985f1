//! Devices with lower limits than the one that runs the tests. A library stands between the program and the Vulkan loader: it lowers the
//! reported limits of the device, and ends the program if it asks for more.

mod named;
mod random;

use std::mem::offset_of;
use std::path::PathBuf;

use raxel_gpu::vk;
use spirv::Capability;

pub use self::named::*;
use super::{Project, before_vulkan};

/// The exit of a program that asks for more than the device reports.
pub const EXCEEDED: i32 = 97;

/// The lower limits of a device, where the device below has more.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is something that a device has or lacks")]
pub struct Lesser {
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
    /// Sizes of subgroups, instead of those that the device below runs. That device still runs its own sizes, and raxel must be right all the
    /// same.
    pub subgroups: Option<Subgroups>,
    /// Features that Vulkan does not demand and the device lacks.
    pub without: &'static [Feature],
    /// Storage images of formats beyond those that every device has, filters for floats of 32 bits, and images of 16 normalized bits.
    pub formats: bool,
    /// `timestampValidBits` of the queue; 0 where it does not say when a pass ended. The clock of fewer than 64 bits begins again at 0 after the
    /// first time of each frame.
    pub timestamp_bits: u32,
    /// The queue draws, too (`VK_QUEUE_GRAPHICS_BIT`).
    pub graphics: bool,
    /// `VK_KHR_swapchain`.
    pub swapchain: bool,
    /// Extensions besides the swapchain's, and those of `minor` 2.
    pub extensions: bool,
    /// Vulkan 1.1, 1.2 or 1.3. Of 1.2, the device has the extensions for what raxel needs of 1.3.
    pub minor: u32,
    /// The least time that the driver takes for a compute pipeline, in milliseconds.
    pub pipeline_milliseconds: u32,
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
    fn capability(self) -> Option<Capability> {
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

    /// The structure that says whether the device has it, and the byte offset there.
    fn place(self) -> (i32, usize) {
        macro_rules! core {
            ($field:ident) => {
                (FEATURES, offset_of!(vk::PhysicalDeviceFeatures, $field))
            };
        }
        macro_rules! of12 {
            ($field:ident) => {
                (
                    vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES.as_raw(),
                    offset_of!(vk::PhysicalDeviceVulkan12Features, $field),
                )
            };
        }
        match self {
            Self::Int64 => core!(shader_int64),
            Self::Int16 => core!(shader_int16),
            Self::Float64 => core!(shader_float64),
            Self::ReadWithoutFormat => core!(shader_storage_image_read_without_format),
            Self::WriteWithoutFormat => core!(shader_storage_image_write_without_format),
            Self::ExtendedFormats => core!(shader_storage_image_extended_formats),
            Self::IndexedStorageImages => core!(shader_storage_image_array_dynamic_indexing),
            Self::IndexedSampledImages => core!(shader_sampled_image_array_dynamic_indexing),
            Self::IndexedStorageBuffers => core!(shader_storage_buffer_array_dynamic_indexing),
            Self::Int8 => of12!(shader_int8),
            Self::Float16 => of12!(shader_float16),
            Self::Int64Atomics => of12!(shader_buffer_int64_atomics),
            Self::Storage8 => of12!(storage_buffer8_bit_access),
            Self::ScalarLayout => of12!(scalar_block_layout),
        }
    }
}

/// Formats whose images every device can store to, of those that graphs can name ("Required Format Support").
const STORED_EVERYWHERE: &[vk::Format] = &[
    vk::Format::R8G8B8A8_UNORM,
    vk::Format::R8G8B8A8_SNORM,
    vk::Format::R8G8B8A8_UINT,
    vk::Format::R8G8B8A8_SINT,
    vk::Format::R16G16B16A16_UINT,
    vk::Format::R16G16B16A16_SINT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32_UINT,
    vk::Format::R32_SINT,
    vk::Format::R32_SFLOAT,
    vk::Format::R32G32_UINT,
    vk::Format::R32G32_SINT,
    vk::Format::R32G32_SFLOAT,
    vk::Format::R32G32B32A32_UINT,
    vk::Format::R32G32B32A32_SINT,
    vk::Format::R32G32B32A32_SFLOAT,
];

/// Formats of floats that a sampler need not filter.
const UNFILTERED: &[vk::Format] = &[vk::Format::R32_SFLOAT, vk::Format::R32G32_SFLOAT, vk::Format::R32G32B32A32_SFLOAT];

/// Formats that no device need have at all.
const UNKNOWN: &[vk::Format] = &[
    vk::Format::R16_UNORM,
    vk::Format::R16_SNORM,
    vk::Format::R16G16_UNORM,
    vk::Format::R16G16_SNORM,
    vk::Format::R16G16B16A16_UNORM,
    vk::Format::R16G16B16A16_SNORM,
];

/// The way to lower a word of an answer.
#[derive(Clone, Copy)]
enum How {
    AtMost,
    AtLeast,
    And,
    Set,
}

/// Structures of answers, by `VkStructureType`. Structures older than chains have no such type, so they have unused numbers here.
const LIMITS: i32 = -1;
const FEATURES: i32 = -2;

impl Lesser {
    /// Makes the library in a folder of the project; the environment of a program that runs with it.
    pub fn library(&self, project: &Project) -> PathBuf {
        self.library_that_claims(self, project)
    }

    /// The same, but the device claims to be another one: a program that believes it asks for more than there is.
    pub fn library_that_claims(&self, claimed: &Self, project: &Project) -> PathBuf {
        let mut patches = String::new();
        for (of, at, how, value) in claimed.patches() {
            patches += &format!("    {{ {of}, {at}, {}, {value}u }},\n", how as u32);
        }
        let list = |formats: &[vk::Format]| {
            formats.iter().map(|format| format.as_raw().to_string()).collect::<Vec<_>>().join(", ")
        };
        let asked = self.subgroups.filter(|subgroups| subgroups.asked).map_or([0; 2], |subgroups| subgroups.range);
        let limits = [
            ("STORAGE_BUFFERS", self.storage_buffers),
            ("STORAGE_IMAGES", self.storage_images),
            ("SAMPLED_IMAGES", self.sampled_images.min(self.samplers)),
            ("UNIFORM_BUFFERS", self.uniform_buffers),
            ("RESOURCES", self.resources),
            ("INVOCATIONS", self.invocations),
            ("WORKGROUP_X", self.workgroup[0]),
            ("WORKGROUP_Y", self.workgroup[1]),
            ("WORKGROUP_Z", self.workgroup[2]),
            ("SHARED_MEMORY", self.shared_memory),
            ("PUSH_CONSTANTS", self.push_constants),
            ("BUFFER_RANGE", self.buffer_range),
            ("UNIFORM_RANGE", self.uniform_range),
            ("ALIGNMENT", self.alignment),
            ("SIDE_2D", self.image_sides[0]),
            ("SIDE_3D", self.image_sides[1]),
            ("LAYERS", self.image_layers),
            ("SUBGROUPS", u32::from(self.subgroups.is_some())),
            ("SUBGROUP_LEAST", asked[0]),
            ("SUBGROUP_MOST", asked[1]),
            ("FORMATS", u32::from(self.formats)),
            ("EXTENSIONS", u32::from(self.extensions)),
            ("SWAPCHAIN", u32::from(self.swapchain)),
            ("MINOR", self.minor),
            ("TIMESTAMP_BITS", self.timestamp_bits),
            ("GRAPHICS", u32::from(self.graphics)),
            ("PIPELINE_MILLISECONDS", self.pipeline_milliseconds),
        ];
        let mut values = String::new();
        for (name, value) in limits {
            values += &format!("static const unsigned {name} = {value}u;\n");
        }
        let formats = format!(
            "static const int stored_everywhere[] = {{ {} }}, unfiltered[] = {{ {} }}, unknown[] = {{ {} }};\n",
            list(STORED_EVERYWHERE),
            list(UNFILTERED),
            list(UNKNOWN)
        );
        let missing: Vec<String> = self.missing().iter().map(|&lacks| (lacks as u32).to_string()).collect();
        let missing = format!("static const unsigned missing[] = {{ {} }};\n", missing.join(", "));
        let head = format!("enum {{ EXCEEDED = {EXCEEDED} }};\nstatic const char *device_name = \"{}\";\n", self.name);
        before_vulkan(
            project,
            &[
                &head,
                &values,
                &formats,
                &missing,
                TYPES,
                "static const struct Patch patches[] = {\n",
                &patches,
                "};\n",
                LIBRARY,
            ]
            .concat(),
        )
    }

    /// The capabilities that no module may declare.
    fn missing(&self) -> Vec<Capability> {
        use Capability as C;
        use vk::SubgroupFeatureFlags as Subgroup;
        let of_operations = [
            (Subgroup::BASIC, C::GroupNonUniform),
            (Subgroup::VOTE, C::GroupNonUniformVote),
            (Subgroup::ARITHMETIC, C::GroupNonUniformArithmetic),
            (Subgroup::BALLOT, C::GroupNonUniformBallot),
            (Subgroup::SHUFFLE, C::GroupNonUniformShuffle),
            (Subgroup::SHUFFLE_RELATIVE, C::GroupNonUniformShuffleRelative),
            (Subgroup::CLUSTERED, C::GroupNonUniformClustered),
            (Subgroup::QUAD, C::GroupNonUniformQuad),
        ];
        let operations = of_operations.into_iter().filter(|(has, _)| !self.subgroup_operations.contains(*has));
        let of_extensions: &[C] = if self.extensions { &[] } else { &[C::SubgroupBallotKHR, C::SubgroupVoteKHR] };
        let of_13 = [C::DotProduct, C::DotProductInputAll, C::DotProductInput4x8Bit, C::DotProductInput4x8BitPacked];
        // No device has it: the list is never empty.
        let never = [C::Geometry];
        let features = self.without.iter().filter_map(|feature| feature.capability());
        features
            .chain(operations.map(|(_, capability)| capability))
            .chain(of_extensions.iter().copied())
            .chain(of_13.into_iter().filter(|_| self.minor < 3))
            .chain(never)
            .collect()
    }

    /// Words of answers: structure, byte offset, how, value.
    fn patches(&self) -> Vec<(i32, usize, How, u32)> {
        macro_rules! limit {
            ($field:ident) => {
                offset_of!(vk::PhysicalDeviceProperties, limits) + offset_of!(vk::PhysicalDeviceLimits, $field)
            };
        }
        let at_most = [
            (limit!(max_per_stage_descriptor_storage_buffers), self.storage_buffers),
            (limit!(max_per_stage_descriptor_storage_images), self.storage_images),
            (limit!(max_per_stage_descriptor_sampled_images), self.sampled_images),
            (limit!(max_per_stage_descriptor_samplers), self.samplers),
            (limit!(max_per_stage_descriptor_uniform_buffers), self.uniform_buffers),
            (limit!(max_per_stage_resources), self.resources),
            (limit!(max_compute_work_group_invocations), self.invocations),
            (limit!(max_compute_work_group_size), self.workgroup[0]),
            (limit!(max_compute_work_group_size) + 4, self.workgroup[1]),
            (limit!(max_compute_work_group_size) + 8, self.workgroup[2]),
            (limit!(max_compute_shared_memory_size), self.shared_memory),
            (limit!(max_push_constants_size), self.push_constants),
            (limit!(max_storage_buffer_range), self.buffer_range),
            (limit!(max_uniform_buffer_range), self.uniform_range),
            (limit!(max_image_dimension2_d), self.image_sides[0]),
            (limit!(max_image_dimension3_d), self.image_sides[1]),
            (limit!(max_image_array_layers), self.image_layers),
        ];
        let at_least = [
            (limit!(min_storage_buffer_offset_alignment), self.alignment),
            (limit!(min_uniform_buffer_offset_alignment), self.alignment),
            (limit!(non_coherent_atom_size), self.alignment),
            (limit!(buffer_image_granularity), self.granularity),
        ];
        let mut patches: Vec<_> = at_most.iter().map(|(at, value)| (LIMITS, *at, How::AtMost, *value)).collect();
        patches.extend(at_least.iter().map(|(at, value)| (LIMITS, *at, How::AtLeast, *value)));
        let of_subgroups = vk::StructureType::PHYSICAL_DEVICE_SUBGROUP_PROPERTIES.as_raw();
        let operations = offset_of!(vk::PhysicalDeviceSubgroupProperties, supported_operations);
        patches.push((of_subgroups, operations, How::And, self.subgroup_operations.as_raw()));
        if let Some(subgroups) = self.subgroups {
            let usual = offset_of!(vk::PhysicalDeviceSubgroupProperties, subgroup_size);
            patches.push((of_subgroups, usual, How::Set, subgroups.usual));
            macro_rules! size {
                ($field:ident) => {
                    offset_of!(vk::PhysicalDeviceSubgroupSizeControlProperties, $field)
                };
            }
            let of_sizes = vk::StructureType::PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES.as_raw();
            let stages = if subgroups.asked { vk::ShaderStageFlags::COMPUTE } else { vk::ShaderStageFlags::empty() };
            patches.extend([
                (of_sizes, size!(min_subgroup_size), How::Set, subgroups.range[0]),
                (of_sizes, size!(max_subgroup_size), How::Set, subgroups.range[1]),
                (of_sizes, size!(max_compute_workgroup_subgroups), How::Set, subgroups.in_workgroup),
                (of_sizes, size!(required_subgroup_size_stages), How::Set, stages.as_raw()),
            ]);
        }
        if self.minor < 3 {
            let version = vk::make_api_version(0, 1, self.minor, 0);
            patches.push((LIMITS, offset_of!(vk::PhysicalDeviceProperties, api_version), How::AtMost, version));
            // A driver of 1.2 does not know the structure.
            let of13 = vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES.as_raw();
            let first = offset_of!(vk::PhysicalDeviceVulkan13Features, robust_image_access);
            let end = size_of::<vk::PhysicalDeviceVulkan13Features<'_>>();
            patches.extend((first..end - 3).step_by(4).map(|at| (of13, at, How::And, 0)));
        }
        if self.timestamp_bits == 0 {
            patches.push((LIMITS, limit!(timestamp_compute_and_graphics), How::And, 0));
        }
        for feature in self.without {
            let (structure, at) = feature.place();
            patches.push((structure, at, How::And, 0));
        }
        patches
    }
}

const TYPES: &str = r"
typedef unsigned long long Word;
struct Patch { int of; unsigned at; unsigned how; unsigned value; };
struct Chain { int type; struct Chain *next; };
";

/// The order of fields is that of the Vulkan headers.
const LIBRARY: &str = include_str!("lesser/library.c");
