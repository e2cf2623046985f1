//! Devices with lower limits than the one that runs the tests: those that raxel knows (`engine/gpu/src/known.rs`), and others. A library stands
//! between the program and the Vulkan loader: it lowers the reported limits of the device, and ends the program if it asks for more. A limit that the
//! device below does not reach stays as it is there; so do the sizes of subgroups that run, whatever is reported.

mod random;

use std::mem::offset_of;
use std::path::PathBuf;

use raxel_execute::vulkan_format;
pub(crate) use raxel_gpu::known::*;
use raxel_gpu::vk;
use raxel_shader::format::{Format, ScalarKind};
use spirv::Capability;

pub(crate) use self::random::random_device;
use super::{Project, before_vulkan};

/// The exit of a program that asks for more than the device reports.
pub(crate) const EXCEEDED: i32 = 97;

/// The Apple M1 over a driver of Vulkan 1.2.
pub(crate) const METAL_12: KnownDevice = KnownDevice { name: "Apple M1 (MoltenVK of Vulkan 1.2)", minor: 2, ..METAL };

/// The same with a driver that knows no windows.
pub(crate) const WINDOWLESS: KnownDevice = KnownDevice { name: "a device without windows", swapchain: false, ..METAL };

/// Adreno 620, driver of Qualcomm: Vulkan 1.1 (<https://github.com/termux/termux-packages/pull/7165>).
pub(crate) const ADRENO_OLD: KnownDevice =
    KnownDevice { name: "Adreno 620 (Qualcomm, Vulkan 1.1)", minor: 1, ..ADRENO_7 };

/// Mali-G78 with the driver that many phones still have: Vulkan 1.1 (<https://github.com/strato-emu/compat-list/issues/1450>).
pub(crate) const MALI_OLD: KnownDevice = KnownDevice { name: "Mali-G78 (Arm, Vulkan 1.1)", minor: 1, ..MALI };

/// The devices that raxel does not open.
pub(crate) const TOO_OLD: [KnownDevice; 2] = [ADRENO_OLD, MALI_OLD];

/// The structure that says whether a device has a feature, and the byte offset there.
fn place(feature: Feature) -> (i32, usize) {
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
    match feature {
        Feature::Int64 => core!(shader_int64),
        Feature::Int16 => core!(shader_int16),
        Feature::Float64 => core!(shader_float64),
        Feature::ReadWithoutFormat => core!(shader_storage_image_read_without_format),
        Feature::WriteWithoutFormat => core!(shader_storage_image_write_without_format),
        Feature::ExtendedFormats => core!(shader_storage_image_extended_formats),
        Feature::IndexedStorageImages => core!(shader_storage_image_array_dynamic_indexing),
        Feature::IndexedSampledImages => core!(shader_sampled_image_array_dynamic_indexing),
        Feature::IndexedStorageBuffers => core!(shader_storage_buffer_array_dynamic_indexing),
        Feature::Int8 => of12!(shader_int8),
        Feature::Float16 => of12!(shader_float16),
        Feature::Int64Atomics => of12!(shader_buffer_int64_atomics),
        Feature::Storage8 => of12!(storage_buffer8_bit_access),
        Feature::ScalarLayout => of12!(scalar_block_layout),
    }
}

/// Vulkan's numbers of those formats of graphs for which something holds.
fn formats_that(hold: impl Fn(Format) -> bool) -> String {
    let raw = |format: &Format| vulkan_format(*format).as_raw().to_string();
    Format::ALL.iter().filter(|format| hold(**format)).map(raw).collect::<Vec<_>>().join(", ")
}

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

/// A library that stands for a device.
#[derive(Clone, Copy)]
pub(crate) struct Lesser<'a> {
    /// The device that is there: who asks for more than it has is ended.
    pub has: &'a KnownDevice,
    /// The device that the program is told of.
    pub claims: &'a KnownDevice,
    /// The least time that the driver takes for a compute pipeline, in milliseconds.
    pub pipeline_milliseconds: u32,
}

impl<'a> From<&'a KnownDevice> for Lesser<'a> {
    fn from(device: &'a KnownDevice) -> Self {
        Self { has: device, claims: device, pipeline_milliseconds: 0 }
    }
}

impl Lesser<'_> {
    /// Makes the library in a folder of the project; the environment of a program that runs with it.
    pub(crate) fn library(&self, project: &Project) -> PathBuf {
        let Lesser { has: device, claims, pipeline_milliseconds } = *self;
        let mut patches = String::new();
        for (of, at, how, value) in patches_of(claims) {
            patches += &format!("    {{ {of}, {at}, {}, {value}u }},\n", how as u32);
        }
        let asked = device.subgroups.filter(|subgroups| subgroups.asked).map_or([0; 2], |subgroups| subgroups.range);
        let limits = [
            ("STORAGE_BUFFERS", device.storage_buffers),
            ("STORAGE_IMAGES", device.storage_images),
            ("SAMPLED_IMAGES", device.sampled_images.min(device.samplers)),
            ("UNIFORM_BUFFERS", device.uniform_buffers),
            ("RESOURCES", device.resources),
            ("INVOCATIONS", device.invocations),
            ("WORKGROUP_X", device.workgroup[0]),
            ("WORKGROUP_Y", device.workgroup[1]),
            ("WORKGROUP_Z", device.workgroup[2]),
            ("SHARED_MEMORY", device.shared_memory),
            ("PUSH_CONSTANTS", device.push_constants),
            ("BUFFER_RANGE", device.buffer_range),
            ("UNIFORM_RANGE", device.uniform_range),
            ("ALIGNMENT", device.alignment),
            ("SIDE_2D", device.image_sides[0]),
            ("SIDE_3D", device.image_sides[1]),
            ("LAYERS", device.image_layers),
            ("SUBGROUPS", u32::from(device.subgroups.is_some())),
            ("SUBGROUP_LEAST", asked[0]),
            ("SUBGROUP_MOST", asked[1]),
            ("FORMATS", u32::from(device.formats)),
            ("EXTENSIONS", u32::from(device.extensions)),
            ("SWAPCHAIN", u32::from(device.swapchain)),
            ("MINOR", device.minor),
            ("TIMESTAMP_BITS", device.timestamp_bits),
            ("GRAPHICS", u32::from(device.graphics)),
            ("PIPELINE_MILLISECONDS", pipeline_milliseconds),
        ];
        let mut values = String::new();
        for (name, value) in limits {
            values += &format!("static const unsigned {name} = {value}u;\n");
        }
        let formats = format!(
            "static const int stored_everywhere[] = {{ {} }}, unfiltered[] = {{ {} }}, unknown[] = {{ {} }};\n",
            formats_that(Format::is_stored_everywhere),
            formats_that(|format| format.scalar() == ScalarKind::Float && !format.is_filtered_everywhere()),
            formats_that(|format| !format.is_sampled_everywhere())
        );
        let missing: Vec<String> = missing(device).iter().map(|&lacks| (lacks as u32).to_string()).collect();
        let missing = format!("static const unsigned missing[] = {{ {} }};\n", missing.join(", "));
        let head =
            format!("enum {{ EXCEEDED = {EXCEEDED} }};\nstatic const char *device_name = \"{}\";\n", device.name);
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
}

/// The capabilities that no module may declare.
fn missing(device: &KnownDevice) -> Vec<Capability> {
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
    let operations = of_operations.into_iter().filter(|(has, _)| !device.subgroup_operations.contains(*has));
    let of_extensions: &[C] = if device.extensions { &[] } else { &[C::SubgroupBallotKHR, C::SubgroupVoteKHR] };
    let of_13 = [C::DotProduct, C::DotProductInputAll, C::DotProductInput4x8Bit, C::DotProductInput4x8BitPacked];
    // No device has it: the list is never empty.
    let never = [C::Geometry];
    let features = device.without.iter().filter_map(|feature| feature.capability());
    features
        .chain(operations.map(|(_, capability)| capability))
        .chain(of_extensions.iter().copied())
        .chain(of_13.into_iter().filter(|_| device.minor < 3))
        .chain(never)
        .collect()
}

/// Words of answers: structure, byte offset, how, value.
fn patches_of(device: &KnownDevice) -> Vec<(i32, usize, How, u32)> {
    macro_rules! limit {
        ($field:ident) => {
            offset_of!(vk::PhysicalDeviceProperties, limits) + offset_of!(vk::PhysicalDeviceLimits, $field)
        };
    }
    let at_most = [
        (limit!(max_per_stage_descriptor_storage_buffers), device.storage_buffers),
        (limit!(max_per_stage_descriptor_storage_images), device.storage_images),
        (limit!(max_per_stage_descriptor_sampled_images), device.sampled_images),
        (limit!(max_per_stage_descriptor_samplers), device.samplers),
        (limit!(max_per_stage_descriptor_uniform_buffers), device.uniform_buffers),
        (limit!(max_per_stage_resources), device.resources),
        (limit!(max_compute_work_group_invocations), device.invocations),
        (limit!(max_compute_work_group_size), device.workgroup[0]),
        (limit!(max_compute_work_group_size) + 4, device.workgroup[1]),
        (limit!(max_compute_work_group_size) + 8, device.workgroup[2]),
        (limit!(max_compute_shared_memory_size), device.shared_memory),
        (limit!(max_push_constants_size), device.push_constants),
        (limit!(max_storage_buffer_range), device.buffer_range),
        (limit!(max_uniform_buffer_range), device.uniform_range),
        (limit!(max_image_dimension2_d), device.image_sides[0]),
        (limit!(max_image_dimension3_d), device.image_sides[1]),
        (limit!(max_image_array_layers), device.image_layers),
    ];
    let at_least = [
        (limit!(min_storage_buffer_offset_alignment), device.alignment),
        (limit!(min_uniform_buffer_offset_alignment), device.alignment),
        (limit!(non_coherent_atom_size), device.alignment),
        (limit!(buffer_image_granularity), device.granularity),
    ];
    let mut patches: Vec<_> = at_most.iter().map(|(at, value)| (LIMITS, *at, How::AtMost, *value)).collect();
    patches.extend(at_least.iter().map(|(at, value)| (LIMITS, *at, How::AtLeast, *value)));
    let of_subgroups = vk::StructureType::PHYSICAL_DEVICE_SUBGROUP_PROPERTIES.as_raw();
    let operations = offset_of!(vk::PhysicalDeviceSubgroupProperties, supported_operations);
    patches.push((of_subgroups, operations, How::And, device.subgroup_operations.as_raw()));
    if let Some(subgroups) = device.subgroups {
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
    if device.minor < 3 {
        let version = vk::make_api_version(0, 1, device.minor, 0);
        patches.push((LIMITS, offset_of!(vk::PhysicalDeviceProperties, api_version), How::AtMost, version));
        // A driver of 1.2 does not know the structure.
        let of13 = vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES.as_raw();
        let first = offset_of!(vk::PhysicalDeviceVulkan13Features, robust_image_access);
        let end = size_of::<vk::PhysicalDeviceVulkan13Features<'_>>();
        patches.extend((first..end - 3).step_by(4).map(|at| (of13, at, How::And, 0)));
    }
    if device.timestamp_bits == 0 {
        patches.push((LIMITS, limit!(timestamp_compute_and_graphics), How::And, 0));
    }
    for feature in device.without {
        let (structure, at) = place(*feature);
        patches.push((structure, at, How::And, 0));
    }
    patches
}

const TYPES: &str = r"
typedef unsigned long long Word;
struct Patch { int of; unsigned at; unsigned how; unsigned value; };
struct Chain { int type; struct Chain *next; };
";

/// The order of fields is that of the Vulkan headers.
const LIBRARY: &str = include_str!("lesser/library.c");
