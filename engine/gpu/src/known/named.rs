//! The devices by name, from public reports.

use ash::vk::SubgroupFeatureFlags as Operations;

use super::{Feature, KnownDevice, Subgroups};

/// As much as every device of Vulkan 1.3 has ("Required Limits", "Feature Requirements").
pub const LEAST: KnownDevice = KnownDevice {
    name: "the least of Vulkan 1.3",
    storage_buffers: 4,
    storage_images: 4,
    sampled_images: 16,
    samplers: 16,
    uniform_buffers: 12,
    resources: 128,
    invocations: 128,
    workgroup: [128, 128, 64],
    shared_memory: 16384,
    push_constants: 128,
    buffer_range: 1 << 27,
    uniform_range: 16384,
    image_sides: [4096, 256],
    image_layers: 256,
    alignment: 256,
    granularity: 131_072,
    subgroup_operations: Operations::BASIC,
    subgroups: None,
    without: Feature::ALL,
    formats: false,
    timestamp_bits: 0,
    graphics: false,
    swapchain: true,
    extensions: false,
    minor: 3,
};

/// A device without limits of its own. The other devices are differences from it.
const WHOLE: KnownDevice = KnownDevice {
    name: "a device as large as it may be",
    storage_buffers: u32::MAX,
    storage_images: u32::MAX,
    sampled_images: u32::MAX,
    samplers: u32::MAX,
    uniform_buffers: u32::MAX,
    resources: u32::MAX,
    invocations: 1024,
    workgroup: [1024; 3],
    shared_memory: 32768,
    push_constants: 256,
    buffer_range: u32::MAX,
    uniform_range: u32::MAX,
    image_sides: [16384, 2048],
    image_layers: 2048,
    alignment: 64,
    granularity: 1,
    subgroup_operations: Operations::from_raw(u32::MAX),
    subgroups: None,
    without: &[],
    formats: true,
    timestamp_bits: 64,
    graphics: true,
    swapchain: true,
    extensions: true,
    minor: 3,
};

/// Votes, ballots, shuffles and quads: no arithmetic, and nothing by clusters.
const SHUFFLES: Operations = Operations::from_raw(
    Operations::BASIC.as_raw()
        | Operations::VOTE.as_raw()
        | Operations::BALLOT.as_raw()
        | Operations::SHUFFLE.as_raw()
        | Operations::SHUFFLE_RELATIVE.as_raw()
        | Operations::QUAD.as_raw(),
);

/// Raspberry Pi 5 under Mesa (V3DV): `vulkaninfo` in <https://github.com/bevyengine/bevy/issues/18867>, and
/// `get_features` and `get_device_properties` of `src/broadcom/vulkan/v3dv_device.c`. Newer drivers also have arithmetic in subgroups.
pub const SMALL: KnownDevice = KnownDevice {
    name: "Raspberry Pi 5 (V3DV)",
    storage_buffers: 8,
    samplers: 24,
    uniform_buffers: 16,
    uniform_range: 1 << 30,
    buffer_range: 1 << 30,
    invocations: 256,
    workgroup: [256, 256, 256],
    image_sides: [4096, 4096],
    image_layers: 2048,
    alignment: 32,
    granularity: 256,
    subgroup_operations: SHUFFLES,
    subgroups: Some(Subgroups { usual: 16, range: [16, 16], in_workgroup: 16, asked: false }),
    without: &[
        Feature::Int64,
        Feature::Int16,
        Feature::Int8,
        Feature::Float64,
        Feature::Float16,
        Feature::Int64Atomics,
        Feature::WriteWithoutFormat,
        Feature::IndexedStorageImages,
        Feature::IndexedSampledImages,
        Feature::IndexedStorageBuffers,
    ],
    formats: true,
    timestamp_bits: 64,
    graphics: true,
    ..LEAST
};

/// Apple M1 under MoltenVK: `vulkaninfo` in <https://github.com/hanatos/vkdt/pull/87> and <https://github.com/gfx-rs/wgpu/issues/5551>. It
/// has no floats of 64 bits, no atomics of 64 bits, and not the older ballots.
pub const METAL: KnownDevice = KnownDevice {
    name: "Apple M1 (MoltenVK)",
    storage_buffers: 31,
    storage_images: 8,
    sampled_images: 128,
    samplers: 16,
    uniform_buffers: 31,
    resources: 159,
    push_constants: 4096,
    alignment: 16,
    granularity: 16,
    subgroup_operations: Operations::from_raw(SHUFFLES.as_raw() | Operations::ARITHMETIC.as_raw()),
    subgroups: Some(Subgroups { usual: 32, range: [4, 32], in_workgroup: 256, asked: false }),
    without: &[Feature::Float64, Feature::Int64Atomics],
    extensions: false,
    ..WHOLE
};

/// Intel UHD 620 under Mesa (ANV): `vulkaninfo` in <https://github.com/ValveSoftware/gamescope/issues/361>, that of the same generation in
/// <https://github.com/KhronosGroup/Vulkan-Tools/issues/491>, and `get_properties` of `src/intel/vulkan/anv_physical_device.c`.
pub const INTEL_MESA: KnownDevice = KnownDevice {
    name: "Intel UHD 620 (Mesa)",
    shared_memory: 65536,
    storage_buffers: 65535,
    storage_images: 65535,
    sampled_images: 65535,
    samplers: 65535,
    uniform_buffers: 64,
    push_constants: 128,
    buffer_range: 1 << 30,
    uniform_range: 1 << 27,
    granularity: 64,
    // A workgroup has 56 subgroups at most, so that only the largest size covers one of 1024 invocations.
    subgroups: Some(Subgroups { usual: 32, range: [8, 32], in_workgroup: 56, asked: true }),
    ..WHOLE
};

/// Intel UHD 620 under Windows, driver of Intel: the limits that `wgpu` printed on that driver (16 storage images, 200 storage buffers, 64 samplers,
/// 1024 × 1024 × 64 invocations, ranges below 2³⁰ and 2²⁷ bytes). Its sizes of subgroups are those under Mesa.
pub const INTEL_WINDOWS: KnownDevice = KnownDevice {
    name: "Intel UHD 620 (Windows)",
    storage_buffers: 200,
    storage_images: 16,
    sampled_images: 200,
    samplers: 64,
    uniform_buffers: 200,
    workgroup: [1024, 1024, 64],
    buffer_range: 1 << 30,
    uniform_range: 1 << 27,
    subgroups: Some(Subgroups { usual: 32, range: [8, 32], in_workgroup: 56, asked: true }),
    ..WHOLE
};

/// AMD RDNA 2 under Mesa (RADV): `radv_get_physical_device_properties` of `src/amd/vulkan/radv_physical_device.c`, and a Radeon 6500 XT in
/// <https://github.com/KomputeProject/kompute/issues/275>. Subgroups of 64, and of 32 if a pipeline asks.
pub const RDNA2: KnownDevice = KnownDevice {
    name: "AMD RDNA 2 (RADV)",
    shared_memory: 65536,
    alignment: 4,
    subgroups: Some(Subgroups { usual: 64, range: [32, 64], in_workgroup: u32::MAX, asked: true }),
    ..WHOLE
};

/// AMD before RDNA under Mesa: the same file. Subgroups of 64, and no other.
pub const VEGA: KnownDevice = KnownDevice {
    name: "AMD Vega (RADV)",
    subgroups: Some(Subgroups { usual: 64, range: [64, 64], in_workgroup: u32::MAX, asked: false }),
    ..RDNA2
};

/// NVIDIA GTX 10 (Pascal): `vulkaninfo` of a 1050 Ti in <https://github.com/KhronosGroup/Vulkan-Tools/pull/106>. No floats of 16 bits.
pub const PASCAL: KnownDevice = KnownDevice {
    name: "NVIDIA GTX 10",
    shared_memory: 49152,
    image_sides: [32768, 16384],
    storage_buffers: 1 << 20,
    storage_images: 1 << 20,
    sampled_images: 1 << 20,
    samplers: 1 << 20,
    uniform_buffers: 15,
    workgroup: [1024, 1024, 64],
    uniform_range: 65536,
    alignment: 256,
    granularity: 1024,
    subgroups: Some(Subgroups { usual: 32, range: [32, 32], in_workgroup: 48, asked: true }),
    without: &[Feature::Float16],
    ..WHOLE
};

/// Adreno 740 (a Galaxy S23 Ultra), driver of Qualcomm: `vulkaninfo` in <https://github.com/termux-user-repository/tur/issues/530>, and the
/// sizes of subgroups in <https://github.com/gfx-rs/wgpu/issues/8801>. Features that are unknown there are missing here.
pub const ADRENO_7: KnownDevice = KnownDevice {
    name: "Adreno 740 (Qualcomm)",
    workgroup: [1024, 1024, 64],
    uniform_range: 65536,
    subgroups: Some(Subgroups { usual: 64, range: [64, 128], in_workgroup: 16, asked: true }),
    without: &[Feature::Float64, Feature::Int64, Feature::Int64Atomics],
    extensions: false,
    ..WHOLE
};

/// Adreno 6xx under Mesa (Turnip): `tu_get_features` and `tu_get_properties` of `src/freedreno/vulkan/tu_device.cc`. Subgroups of 64 and 128, and no
/// bytes in storage buffers.
pub const ADRENO_6: KnownDevice = KnownDevice {
    name: "Adreno 6xx (Turnip)",
    buffer_range: 1 << 27,
    uniform_range: 65536,
    granularity: 64,
    subgroups: Some(Subgroups { usual: 128, range: [64, 128], in_workgroup: 16, asked: true }),
    without: &[Feature::Float64, Feature::Int64Atomics, Feature::Storage8],
    extensions: false,
    ..WHOLE
};

/// Mali-G78 with a driver of Arm that has Vulkan 1.3: the limits of that driver in <https://github.com/termux/termux-packages/issues/19460>.
pub const MALI: KnownDevice = KnownDevice {
    name: "Mali-G78 (Arm)",
    storage_buffers: 35,
    storage_images: 21,
    sampled_images: 256,
    samplers: 128,
    uniform_buffers: 36,
    buffer_range: 1 << 28,
    uniform_range: 65536,
    image_sides: [16384, 16384],
    image_layers: 4096,
    subgroups: Some(Subgroups { usual: 16, range: [16, 16], in_workgroup: 64, asked: true }),
    without: &[Feature::Float64, Feature::Int64Atomics],
    extensions: false,
    ..WHOLE
};

/// Raspberry Pi 4 under Mesa (V3DV), with a driver of Vulkan 1.2: `get_features` and `get_properties` of `src/broadcom/vulkan/v3dv_device.c` for
/// version 4.2 of the hardware, and `vulkaninfo` in <https://github.com/DTolm/VkFFT/issues/19>. Its subgroups can only elect.
pub const RASPBERRY_4: KnownDevice = KnownDevice {
    name: "Raspberry Pi 4 (V3DV of Vulkan 1.2)",
    alignment: 256,
    subgroup_operations: Operations::BASIC,
    minor: 2,
    ..SMALL
};

/// Intel Iris Xe (Tiger Lake) under Mesa (ANV): `get_features`, `get_properties` and the queues of `src/intel/vulkan/anv_physical_device.c`. No floats
/// of 64 bits, and a clock of 36.
pub const INTEL_XE: KnownDevice = KnownDevice {
    name: "Intel Iris Xe (Mesa)",
    buffer_range: u32::MAX,
    granularity: 1,
    subgroups: Some(Subgroups { usual: 32, range: [8, 32], in_workgroup: 64, asked: true }),
    without: &[Feature::Float64],
    timestamp_bits: 36,
    ..INTEL_MESA
};

/// Mali-G52 with a driver of Arm that has Vulkan 1.3 (<https://github.com/FreshROMs/android_kernel_samsung_exynos9610_mint/issues/42>): workgroups of
/// 384 (<https://github.com/ARM-software/ComputeLibrary/issues/999>). Its subgroups of 8, alignments and missing clock are those of
/// `src/panfrost/vulkan/panvk_physical_device.c` for Bifrost.
pub const MALI_G52: KnownDevice = KnownDevice {
    name: "Mali-G52 (Arm)",
    invocations: 384,
    workgroup: [384; 3],
    push_constants: 128,
    granularity: 64,
    subgroups: Some(Subgroups { usual: 8, range: [8, 8], in_workgroup: 48, asked: false }),
    timestamp_bits: 0,
    ..MALI
};

/// `PowerVR` BXE-4-32 (a `VisionFive` 2), driver of Imagination: `vulkaninfo` in <https://github.com/meta-flutter/meta-flutter/issues/454>,
/// and the operations of subgroups in <https://github.com/geerlingguy/sbc-reviews/issues/65>. Limits that are unknown there are as low as
/// Vulkan allows.
pub const POWERVR: KnownDevice = KnownDevice {
    name: "PowerVR BXE-4-32 (Imagination)",
    invocations: 512,
    workgroup: [512, 512, 64],
    subgroup_operations: Operations::from_raw(u32::MAX),
    graphics: true,
    ..LEAST
};

/// An accelerator whose queues compute and do not draw, as AMD's CDNA under Mesa (`radv_get_physical_device_queue_family_properties` of
/// `src/amd/vulkan/radv_physical_device.c`).
pub const ACCELERATOR: KnownDevice = KnownDevice { name: "an accelerator that does not draw", graphics: false, ..VEGA };

/// All of them.
pub const DEVICES: [KnownDevice; 16] = [
    LEAST,
    SMALL,
    METAL,
    INTEL_MESA,
    INTEL_WINDOWS,
    RDNA2,
    VEGA,
    PASCAL,
    ADRENO_7,
    ADRENO_6,
    MALI,
    RASPBERRY_4,
    INTEL_XE,
    MALI_G52,
    POWERVR,
    ACCELERATOR,
];
