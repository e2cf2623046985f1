//! Devices that can less than the one that the tests run on. A library stands between the program and the Vulkan loader: it lowers what the
//! device says of itself, and ends the program if it is asked for more than that.

use std::mem::offset_of;
use std::path::PathBuf;

use raxel_gpu::vk;

use super::{Project, before_vulkan};

/// How the program ends when it asks for more than the device says it has.
pub const EXCEEDED: i32 = 97;

/// What a device says of itself, where the device below has more.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_excessive_bools, reason = "each says whether the device has one thing")]
pub struct Lesser {
    /// Name in messages.
    pub name: &'static str,
    /// `maxPerStageDescriptorStorageBuffers`.
    pub storage_buffers: u32,
    /// `maxPerStageDescriptorStorageImages`.
    pub storage_images: u32,
    /// `maxPerStageDescriptorSampledImages` and `maxPerStageDescriptorSamplers`.
    pub sampled_images: u32,
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
    /// `maxImageDimension2D` and `maxImageDimension3D`.
    pub image_sides: [u32; 2],
    /// `minStorageBufferOffsetAlignment`, `minUniformBufferOffsetAlignment`, `nonCoherentAtomSize`, bytes.
    pub alignment: u32,
    /// Subgroup operations of compute shaders.
    pub subgroup_operations: vk::SubgroupFeatureFlags,
    /// Features that Vulkan 1.3 does not demand: integers of 64 and 16 bits, floats of 16 and 64, storage images without a format, formats beyond
    /// those that every device has.
    pub optional: bool,
    /// The queue says when a pass ended.
    pub timestamps: bool,
    /// Extensions besides the swapchain's, and those of `core12`.
    pub extensions: bool,
    /// Vulkan 1.2, with extensions for what raxel needs of 1.3.
    pub core12: bool,
    /// How long the driver takes for a compute pipeline at least, milliseconds.
    pub pipeline_milliseconds: u32,
}

/// As much as every device of Vulkan 1.3 has ("Required Limits", "Feature Requirements").
pub const LEAST: Lesser = Lesser {
    name: "the least of Vulkan 1.3",
    storage_buffers: 4,
    storage_images: 4,
    sampled_images: 16,
    resources: 128,
    invocations: 128,
    workgroup: [128, 128, 64],
    shared_memory: 16384,
    push_constants: 128,
    buffer_range: 1 << 27,
    image_sides: [4096, 256],
    alignment: 256,
    subgroup_operations: vk::SubgroupFeatureFlags::BASIC,
    optional: false,
    timestamps: false,
    extensions: false,
    core12: false,
    pipeline_milliseconds: 0,
};

/// A small device with a driver of its own, such as the Raspberry Pi 5 (4 storage images, 8 storage buffers).
pub const SMALL: Lesser = Lesser {
    name: "a small device",
    storage_buffers: 8,
    sampled_images: 24,
    invocations: 256,
    workgroup: [256, 256, 256],
    subgroup_operations: vk::SubgroupFeatureFlags::from_raw(
        vk::SubgroupFeatureFlags::BASIC.as_raw()
            | vk::SubgroupFeatureFlags::VOTE.as_raw()
            | vk::SubgroupFeatureFlags::BALLOT.as_raw(),
    ),
    timestamps: true,
    ..LEAST
};

/// A device over Metal, such as Apple's M1: 31 buffers, 8 storage images, no 64-bit floats.
pub const METAL: Lesser = Lesser {
    name: "a device over Metal",
    storage_buffers: 31,
    storage_images: 8,
    sampled_images: 16,
    resources: 159,
    invocations: 1024,
    workgroup: [1024; 3],
    shared_memory: 32768,
    push_constants: 4096,
    buffer_range: u32::MAX,
    image_sides: [16384, 2048],
    alignment: 16,
    optional: true,
    timestamps: true,
    ..SMALL
};

/// The same over a driver of Vulkan 1.2.
pub const METAL_12: Lesser = Lesser { name: "a device of Vulkan 1.2", core12: true, ..METAL };

/// The same with a driver that is slow at compiling.
pub const SLOW_DRIVER: Lesser = Lesser { name: "a device with a slow driver", pipeline_milliseconds: 1600, ..METAL };

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

/// How a word of an answer is lowered.
#[derive(Clone, Copy)]
enum How {
    AtMost,
    AtLeast,
    And,
}

/// Structures of answers, by `VkStructureType`; those that were there before chains have numbers that no structure has.
const LIMITS: i32 = -1;
const FEATURES: i32 = -2;

impl Lesser {
    /// Makes the library in a folder of the project; the environment of a program that runs with it.
    pub fn library(&self, project: &Project) -> PathBuf {
        let mut patches = String::new();
        for (of, at, how, value) in self.patches() {
            patches += &format!("    {{ {of}, {at}, {}, {value}u }},\n", how as u32);
        }
        let list = |formats: &[vk::Format]| {
            formats.iter().map(|format| format.as_raw().to_string()).collect::<Vec<_>>().join(", ")
        };
        let limits = [
            ("STORAGE_BUFFERS", self.storage_buffers),
            ("STORAGE_IMAGES", self.storage_images),
            ("SAMPLED_IMAGES", self.sampled_images),
            ("RESOURCES", self.resources),
            ("INVOCATIONS", self.invocations),
            ("PUSH_CONSTANTS", self.push_constants),
            ("BUFFER_RANGE", self.buffer_range),
            ("SIDE_2D", self.image_sides[0]),
            ("SIDE_3D", self.image_sides[1]),
            ("OPTIONAL", u32::from(self.optional)),
            ("EXTENSIONS", u32::from(self.extensions)),
            ("CORE12", u32::from(self.core12)),
            ("TIMESTAMPS", u32::from(self.timestamps)),
            ("PIPELINE_MILLISECONDS", self.pipeline_milliseconds),
        ];
        let mut values = String::new();
        for (name, value) in limits {
            values += &format!("static const unsigned {name} = {value}u;\n");
        }
        let formats = format!(
            "static const int stored_everywhere[] = {{ {} }};\nstatic const int unfiltered[] = {{ {} }};\n",
            list(STORED_EVERYWHERE),
            list(UNFILTERED)
        );
        let head = format!("enum {{ EXCEEDED = {EXCEEDED} }};\nstatic const char *device_name = \"{}\";\n", self.name);
        before_vulkan(
            project,
            &[&head, &values, &formats, TYPES, "static const struct Patch patches[] = {\n", &patches, "};\n", LIBRARY]
                .concat(),
        )
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
            (limit!(max_per_stage_descriptor_samplers), self.sampled_images),
            (limit!(max_per_stage_resources), self.resources),
            (limit!(max_compute_work_group_invocations), self.invocations),
            (limit!(max_compute_work_group_size), self.workgroup[0]),
            (limit!(max_compute_work_group_size) + 4, self.workgroup[1]),
            (limit!(max_compute_work_group_size) + 8, self.workgroup[2]),
            (limit!(max_compute_shared_memory_size), self.shared_memory),
            (limit!(max_push_constants_size), self.push_constants),
            (limit!(max_storage_buffer_range), self.buffer_range),
            (limit!(max_image_dimension2_d), self.image_sides[0]),
            (limit!(max_image_dimension3_d), self.image_sides[1]),
        ];
        let at_least = [
            limit!(min_storage_buffer_offset_alignment),
            limit!(min_uniform_buffer_offset_alignment),
            limit!(non_coherent_atom_size),
        ];
        let mut patches: Vec<_> = at_most.iter().map(|(at, value)| (LIMITS, *at, How::AtMost, *value)).collect();
        patches.extend(at_least.iter().map(|at| (LIMITS, *at, How::AtLeast, self.alignment)));
        let subgroups = vk::StructureType::PHYSICAL_DEVICE_SUBGROUP_PROPERTIES.as_raw();
        let operations = offset_of!(vk::PhysicalDeviceSubgroupProperties, supported_operations);
        patches.push((subgroups, operations, How::And, self.subgroup_operations.as_raw()));
        if self.core12 {
            patches.push((
                LIMITS,
                offset_of!(vk::PhysicalDeviceProperties, api_version),
                How::AtMost,
                vk::API_VERSION_1_2,
            ));
            // A driver of 1.2 does not know the structure.
            let of13 = vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES.as_raw();
            let first = offset_of!(vk::PhysicalDeviceVulkan13Features, robust_image_access);
            let end = size_of::<vk::PhysicalDeviceVulkan13Features<'_>>();
            patches.extend((first..end - 3).step_by(4).map(|at| (of13, at, How::And, 0)));
        }
        if !self.timestamps {
            patches.push((LIMITS, limit!(timestamp_compute_and_graphics), How::And, 0));
        }
        if !self.optional {
            let core = [
                offset_of!(vk::PhysicalDeviceFeatures, shader_int64),
                offset_of!(vk::PhysicalDeviceFeatures, shader_int16),
                offset_of!(vk::PhysicalDeviceFeatures, shader_float64),
                offset_of!(vk::PhysicalDeviceFeatures, shader_storage_image_read_without_format),
                offset_of!(vk::PhysicalDeviceFeatures, shader_storage_image_write_without_format),
                offset_of!(vk::PhysicalDeviceFeatures, shader_storage_image_extended_formats),
                offset_of!(vk::PhysicalDeviceFeatures, shader_storage_image_array_dynamic_indexing),
                offset_of!(vk::PhysicalDeviceFeatures, shader_sampled_image_array_dynamic_indexing),
                offset_of!(vk::PhysicalDeviceFeatures, shader_storage_buffer_array_dynamic_indexing),
            ];
            patches.extend(core.map(|at| (FEATURES, at, How::And, 0)));
            let of12 = vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES.as_raw();
            let on12 = [
                offset_of!(vk::PhysicalDeviceVulkan12Features, scalar_block_layout),
                offset_of!(vk::PhysicalDeviceVulkan12Features, shader_int8),
                offset_of!(vk::PhysicalDeviceVulkan12Features, shader_float16),
                offset_of!(vk::PhysicalDeviceVulkan12Features, storage_buffer8_bit_access),
                offset_of!(vk::PhysicalDeviceVulkan12Features, shader_buffer_int64_atomics),
            ];
            patches.extend(on12.map(|at| (of12, at, How::And, 0)));
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
const LIBRARY: &str = r#"
#include <stdarg.h>
#include <unistd.h>
enum { LIMITS = -1, FEATURES = -2, AT_MOST = 0, AT_LEAST = 1, AND = 2 };
enum { FORMAT_NOT_SUPPORTED = -11, INCOMPLETE = 5 };
enum { SAMPLED_BIT = 1, STORAGE_BIT = 2, ATOMIC_BIT = 4, FILTER_BIT = 0x1000 };
enum { USAGE_STORAGE = 8, NAME_SIZE = 256, EXTENSION_SIZE = 260, FAMILY_SIZE = 24 };

static void exceeded(const char *what, Word asked, Word most) {
    fprintf(stderr, "%s: asked for %llu %s of %llu\n", device_name, asked, what, most);
    fflush(NULL);
    _exit(EXCEEDED);
}
static void lower(void *answer, int of) {
    for (unsigned i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct Patch *patch = &patches[i];
        if (patch->of != of) continue;
        unsigned *word = (unsigned *)((char *)answer + patch->at);
        if (patch->how == AND) *word &= patch->value;
        if (patch->how == AT_MOST && *word > patch->value) *word = patch->value;
        if (patch->how == AT_LEAST && *word < patch->value) *word = patch->value;
    }
}
static void lower_chain(struct Chain *chain) {
    for (; chain; chain = chain->next) lower(chain, chain->type);
}
static int among(int format, const int *formats, unsigned count) {
    for (unsigned i = 0; i < count; i++) if (formats[i] == format) return 1;
    return 0;
}
static int stores(int format) {
    return OPTIONAL || among(format, stored_everywhere, sizeof stored_everywhere / sizeof *stored_everywhere);
}

static void (*properties)(Word, void *), (*properties2)(Word, struct Chain *);
static void (*features)(Word, void *), (*features2)(Word, struct Chain *);
static void (*formats)(Word, int, unsigned *);
static int (*images)(Word, int, int, int, unsigned, unsigned, unsigned *);
static void (*families)(Word, unsigned *, char *);
static int (*extensions)(Word, const char *, unsigned *, char *);
static int (*create_device)(Word, const char *, const void *, Word *);
static int (*create_layout)(Word, const char *, const void *, Word *);
static int (*create_image)(Word, const char *, const void *, Word *);
static int (*create_pipeline_layout)(Word, const char *, const void *, Word *);
static int (*create_pipelines)(Word, Word, unsigned, const void *, const void *, Word *);
static void (*update_sets)(Word, unsigned, const char *, unsigned, const void *);

static void our_properties(Word device, void *answer) { properties(device, answer); lower(answer, LIMITS); }
static void our_properties2(Word device, struct Chain *answer) {
    properties2(device, answer);
    lower(answer + 1, LIMITS);
    lower_chain(answer->next);
}
static void our_features(Word device, void *answer) { features(device, answer); lower(answer, FEATURES); }
static void our_features2(Word device, struct Chain *answer) {
    features2(device, answer);
    lower(answer + 1, FEATURES);
    lower_chain(answer->next);
}
static void our_formats(Word device, int format, unsigned *answer) {
    formats(device, format, answer);
    for (int i = 0; i < 3; i++) {
        if (!stores(format)) answer[i] &= ~(unsigned)(STORAGE_BIT | ATOMIC_BIT);
        if (!OPTIONAL && among(format, unfiltered, sizeof unfiltered / sizeof *unfiltered)) answer[i] &= ~(unsigned)FILTER_BIT;
    }
}
static int our_images(Word device, int format, int type, int tiling, unsigned usage, unsigned flags, unsigned *answer) {
    if ((usage & USAGE_STORAGE) && !stores(format)) return FORMAT_NOT_SUPPORTED;
    int result = images(device, format, type, tiling, usage, flags, answer);
    unsigned most = type == 2 ? SIDE_3D : SIDE_2D;
    for (int i = 0; i < 3; i++) if (!result && answer[i] > most) answer[i] = most;
    return result;
}
static void our_families(Word device, unsigned *count, char *answer) {
    families(device, count, answer);
    for (unsigned i = 0; answer && !TIMESTAMPS && i < *count; i++) *(unsigned *)(answer + FAMILY_SIZE * i + 8) = 0;
}
static int is_kept(const char *extension) {
    return EXTENSIONS || !strcmp(extension, "VK_KHR_swapchain") || (CORE12 && (!strcmp(extension, "VK_KHR_synchronization2") ||
        !strcmp(extension, "VK_KHR_maintenance4") || !strcmp(extension, "VK_KHR_dynamic_rendering")));
}
/* Of Vulkan 1.3; each has another name by its extension. */
static int is_core13(const char *name) {
    static const char *const all[] = { "vkCmdPipelineBarrier2", "vkQueueSubmit2", "vkCmdWriteTimestamp2", "vkCmdSetEvent2", "vkCmdWaitEvents2",
        "vkGetDeviceBufferMemoryRequirements", "vkGetDeviceImageMemoryRequirements", "vkCmdBeginRendering", "vkCmdEndRendering" };
    for (unsigned i = 0; i < sizeof all / sizeof *all; i++) if (!strcmp(name, all[i])) return 1;
    return 0;
}
static int our_extensions(Word device, const char *layer, unsigned *count, char *answer) {
    unsigned all = 0, kept = 0;
    int result = extensions(device, layer, &all, NULL);
    if (result || !all) { *count = all; return result; }
    char *found = malloc((size_t)all * EXTENSION_SIZE);
    result = extensions(device, layer, &all, found);
    for (unsigned i = 0; i < all; i++) {
        if (!is_kept(found + i * EXTENSION_SIZE)) continue;
        if (answer && kept < *count) memcpy(answer + kept * EXTENSION_SIZE, found + i * EXTENSION_SIZE, EXTENSION_SIZE);
        kept++;
    }
    free(found);
    if (answer && kept > *count) return INCOMPLETE;
    *count = kept;
    return result;
}
/* What is asked for is what is offered. */
static int our_device(Word physical, const char *info, const void *allocator, Word *device) {
    const unsigned *asked = *(const unsigned *const *)(info + 64);
    for (unsigned i = 0; i < sizeof patches / sizeof *patches; i++) {
        const struct Patch *patch = &patches[i];
        if (patch->how != AND || patch->value) continue;
        if (patch->of == FEATURES && asked && asked[patch->at / 4]) exceeded("of a feature at byte", patch->at, 0);
        for (const struct Chain *chain = *(struct Chain *const *)(info + 8); chain; chain = chain->next)
            if (chain->type == patch->of && *(const unsigned *)((const char *)chain + patch->at)) exceeded("of a feature at byte", patch->at, 0);
    }
    unsigned count = *(const unsigned *)(info + 48);
    const char *const *names = *(const char *const *const *)(info + 56);
    for (unsigned i = 0; i < count; i++) if (!is_kept(names[i])) exceeded(names[i], 1, 0);
    return create_device(physical, info, allocator, device);
}
static int our_layout(Word device, const char *info, const void *allocator, Word *layout) {
    unsigned count = *(const unsigned *)(info + 20), of[16] = {0}, all = 0;
    const char *binding = *(const char *const *)(info + 24);
    for (unsigned i = 0; i < count; i++, binding += 24) {
        const unsigned *words = (const unsigned *)binding;
        if (words[1] < 16) of[words[1]] += words[2];
        all += words[2];
    }
    if (of[7] + of[9] > STORAGE_BUFFERS) exceeded("storage buffers", of[7] + of[9], STORAGE_BUFFERS);
    if (of[3] > STORAGE_IMAGES) exceeded("storage images", of[3], STORAGE_IMAGES);
    if (of[1] + of[2] > SAMPLED_IMAGES) exceeded("sampled images", of[1] + of[2], SAMPLED_IMAGES);
    if (all > RESOURCES) exceeded("resources", all, RESOURCES);
    return create_layout(device, info, allocator, layout);
}
static int our_pipeline_layout(Word device, const char *info, const void *allocator, Word *layout) {
    unsigned count = *(const unsigned *)(info + 32);
    const unsigned *range = *(const unsigned *const *)(info + 40);
    for (unsigned i = 0; i < count; i++, range += 3)
        if (range[1] + range[2] > PUSH_CONSTANTS) exceeded("bytes of push constants", range[1] + range[2], PUSH_CONSTANTS);
    return create_pipeline_layout(device, info, allocator, layout);
}
static int our_pipelines(Word device, Word cache, unsigned count, const void *infos, const void *allocator, Word *made) {
    usleep(1000 * PIPELINE_MILLISECONDS);
    return create_pipelines(device, cache, count, infos, allocator, made);
}
static int our_image(Word device, const char *info, const void *allocator, Word *image) {
    const unsigned *words = (const unsigned *)(info + 16);
    unsigned type = words[1], format = words[2], most = type == 2 ? SIDE_3D : SIDE_2D, usage = *(const unsigned *)(info + 56);
    for (int i = 3; i < 6; i++) if (words[i] > most) exceeded("texels along a side", words[i], most);
    if ((usage & USAGE_STORAGE) && !stores(format)) exceeded("as storage image: format", format, 0);
    return create_image(device, info, allocator, image);
}
static void our_sets(Word device, unsigned count, const char *writes, unsigned copies, const void *copied) {
    for (unsigned i = 0; i < count; i++) {
        const char *write = writes + 64 * i;
        unsigned buffers = *(const unsigned *)(write + 32), type = *(const unsigned *)(write + 36);
        const Word *buffer = *(const Word *const *)(write + 48);
        for (unsigned k = 0; (type == 7 || type == 9) && k < buffers; k++)
            if (buffer[3 * k + 2] != ~0ull && buffer[3 * k + 2] > BUFFER_RANGE) exceeded("bytes of a storage buffer", buffer[3 * k + 2], BUFFER_RANGE);
    }
    update_sets(device, count, writes, copies, copied);
}
static void *vulkan;
static Function ours(const char *name, Function found) {
    if (CORE12 && is_core13(name)) return NULL;
#define OURS(call, here) if (!strcmp(name, call)) { here = (void *)found; return (Function)our_##here; }
    OURS("vkGetPhysicalDeviceProperties", properties)
    OURS("vkGetPhysicalDeviceProperties2", properties2)
    OURS("vkGetPhysicalDeviceFeatures", features)
    OURS("vkGetPhysicalDeviceFeatures2", features2)
    OURS("vkGetPhysicalDeviceFormatProperties", formats)
    OURS("vkGetPhysicalDeviceImageFormatProperties", images)
    OURS("vkGetPhysicalDeviceQueueFamilyProperties", families)
    OURS("vkEnumerateDeviceExtensionProperties", extensions)
#undef OURS
/* The loader's own function finds the driver of the device that it is called with: each device has other functions. */
#define OURS(call, before, here) if (!strcmp(name, call)) { before = dlsym(vulkan, name); return (Function)here; }
    OURS("vkCreateDevice", create_device, our_device)
    OURS("vkCreateDescriptorSetLayout", create_layout, our_layout)
    OURS("vkCreatePipelineLayout", create_pipeline_layout, our_pipeline_layout)
    OURS("vkCreateComputePipelines", create_pipelines, our_pipelines)
    OURS("vkCreateImage", create_image, our_image)
    OURS("vkUpdateDescriptorSets", update_sets, our_sets)
    return found;
}
"#;
