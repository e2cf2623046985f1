//! Devices of random limits.

use raxel_gpu::vk;
use raxel_testing::Random;

use super::{Feature, KnownDevice, LEAST, Subgroups};

/// A device whose limits lie between the least of Vulkan 1.3 and those of the device below. The same seed makes the same device.
pub(crate) fn random_device(seed: u64) -> KnownDevice {
    let mut random = Random::new(seed);
    let mut between = |least: u32, most: u32| least + random.below(most - least + 1);
    let limits = KnownDevice {
        name: "a device of random limits",
        storage_buffers: between(4, 32),
        storage_images: between(4, 16),
        sampled_images: between(16, 128),
        samplers: between(16, 32),
        uniform_buffers: between(12, 15),
        resources: between(44, 128),
        invocations: between(128, 1024),
        workgroup: [between(128, 1024), between(128, 1024), between(64, 1024)],
        shared_memory: between(16384, 32768),
        push_constants: between(32, 64) * 4,
        uniform_range: between(16384, 65536),
        image_sides: [between(4096, 16384), between(256, 2048)],
        image_layers: between(256, 2048),
        alignment: 1 << between(2, 8),
        granularity: 1 << between(0, 17),
        minor: between(2, 3),
        ..LEAST
    };
    let missing: Vec<Feature> = Feature::ALL.iter().copied().filter(|_| random.percent(40)).collect();
    let sizes = [random.below(8_u32), random.below(8_u32)];
    let range = [1 << sizes[0].min(sizes[1]), 1 << sizes[0].max(sizes[1])];
    KnownDevice {
        subgroup_operations: vk::SubgroupFeatureFlags::BASIC
            | vk::SubgroupFeatureFlags::from_raw(random.below(256_u32)),
        subgroups: random.percent(70).then(|| Subgroups {
            usual: random.pick(&range),
            range,
            in_workgroup: 1 << random.below(8_u32),
            asked: random.percent(60),
        }),
        without: missing.leak(),
        formats: random.percent(60),
        timestamp_bits: random.pick(&[0, 36, 48, 64]),
        graphics: random.percent(80),
        extensions: random.percent(60),
        swapchain: random.percent(80),
        ..limits
    }
}
