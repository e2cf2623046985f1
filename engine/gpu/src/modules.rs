//! Which SPIR-V capabilities a module may declare on a device (Vulkan specification, "SPIR-V Capabilities").

use std::collections::BTreeSet;

use ash::vk;
use spirv::Capability;

use crate::result::{Error, Result};

/// Words before the first instruction of a module.
const HEADER: usize = 5;

/// Vulkan 1.3 has these without a feature.
const ALWAYS: [Capability; 11] = [
    Capability::Matrix,
    Capability::Shader,
    Capability::InputAttachment,
    Capability::Sampled1D,
    Capability::Image1D,
    Capability::SampledBuffer,
    Capability::ImageBuffer,
    Capability::ImageQuery,
    Capability::DerivativeControl,
    // The device reports for each format whether an image can have it.
    Capability::StorageImageExtendedFormats,
    Capability::DeviceGroup,
];

/// Features that were enabled when the device was opened.
pub(crate) struct Enabled<'a> {
    pub core: &'a vk::PhysicalDeviceFeatures,
    pub on12: &'a vk::PhysicalDeviceVulkan12Features<'a>,
    pub on13: &'a vk::PhysicalDeviceVulkan13Features<'a>,
    /// Operations of subgroups in compute shaders.
    pub operations: vk::SubgroupFeatureFlags,
    /// `VK_EXT_shader_subgroup_ballot` and `VK_EXT_shader_subgroup_vote`.
    pub plain_ballots: bool,
    pub floats: &'a vk::PhysicalDeviceFloatControlsProperties<'a>,
}

/// Every capability that a module may declare.
pub(crate) fn allowed(enabled: &Enabled<'_>) -> BTreeSet<Capability> {
    use Capability as C;
    use vk::SubgroupFeatureFlags as Subgroup;
    let Enabled { core, on12, on13, operations, plain_ballots, floats } = *enabled;
    let has = |operation| operations.contains(operation);
    let by_feature = [
        (C::Int64, core.shader_int64),
        (C::Int16, core.shader_int16),
        (C::Float64, core.shader_float64),
        (C::StorageImageReadWithoutFormat, core.shader_storage_image_read_without_format),
        (C::StorageImageWriteWithoutFormat, core.shader_storage_image_write_without_format),
        (C::StorageImageArrayDynamicIndexing, core.shader_storage_image_array_dynamic_indexing),
        (C::SampledImageArrayDynamicIndexing, core.shader_sampled_image_array_dynamic_indexing),
        (C::StorageBufferArrayDynamicIndexing, core.shader_storage_buffer_array_dynamic_indexing),
        (C::Int8, on12.shader_int8),
        (C::Float16, on12.shader_float16),
        (C::StorageBuffer8BitAccess, on12.storage_buffer8_bit_access),
        (C::Int64Atomics, on12.shader_buffer_int64_atomics),
        (C::VulkanMemoryModel, on12.vulkan_memory_model),
        (C::VulkanMemoryModelDeviceScope, on12.vulkan_memory_model_device_scope),
        (C::DotProduct, on13.shader_integer_dot_product),
        (C::DotProductInputAll, on13.shader_integer_dot_product),
        (C::DotProductInput4x8Bit, on13.shader_integer_dot_product),
        (C::DotProductInput4x8BitPacked, on13.shader_integer_dot_product),
        (C::SignedZeroInfNanPreserve, floats.shader_signed_zero_inf_nan_preserve_float32),
        (C::DenormPreserve, floats.shader_denorm_preserve_float32),
        (C::DenormFlushToZero, floats.shader_denorm_flush_to_zero_float32),
        (C::RoundingModeRTE, floats.shader_rounding_mode_rte_float32),
        (C::RoundingModeRTZ, floats.shader_rounding_mode_rtz_float32),
    ];
    let by_operation = [
        (C::GroupNonUniform, has(Subgroup::BASIC)),
        (C::GroupNonUniformVote, has(Subgroup::VOTE)),
        (C::GroupNonUniformArithmetic, has(Subgroup::ARITHMETIC)),
        (C::GroupNonUniformBallot, has(Subgroup::BALLOT)),
        (C::GroupNonUniformShuffle, has(Subgroup::SHUFFLE)),
        (C::GroupNonUniformShuffleRelative, has(Subgroup::SHUFFLE_RELATIVE)),
        (C::GroupNonUniformClustered, has(Subgroup::CLUSTERED)),
        (C::GroupNonUniformQuad, has(Subgroup::QUAD)),
        (C::SubgroupBallotKHR, plain_ballots),
        (C::SubgroupVoteKHR, plain_ballots),
    ];
    let features = by_feature.map(|(capability, feature)| (capability, feature == vk::TRUE));
    let sometimes = features.into_iter().chain(by_operation).filter(|(_, there)| *there);
    ALWAYS.into_iter().chain(sometimes.map(|(capability, _)| capability)).collect()
}

/// Refuses a module that declares a capability which is not allowed.
pub(crate) fn check(allowed: &BTreeSet<Capability>, spirv: &[u32], name: &str) -> Result<()> {
    match lacking(allowed, spirv) {
        Some(lacks) => Err(Error::CapabilityMissing { name: name.to_owned(), lacks }),
        None => Ok(()),
    }
}

/// The first capability that a module declares and that is not allowed.
pub(crate) fn lacking(allowed: &BTreeSet<Capability>, spirv: &[u32]) -> Option<String> {
    demands(allowed, spirv).into_iter().find(|(_, has)| !has).map(|(name, _)| name)
}

/// The capabilities that a module declares and that Vulkan does not guarantee, and whether each is allowed.
pub(crate) fn demands(allowed: &BTreeSet<Capability>, spirv: &[u32]) -> Vec<(String, bool)> {
    let mut rest = spirv.get(HEADER..).unwrap_or_default();
    let mut found = Vec::new();
    // The declarations stand first; each has the number of its words in its upper half.
    while let [first, number, after @ ..] = rest
        && *first == 2 << 16 | spirv::Op::Capability as u32
    {
        rest = after;
        match Capability::from_u32(*number) {
            Some(capability) if ALWAYS.contains(&capability) => {}
            Some(capability) => found.push((format!("{capability:?}"), allowed.contains(&capability))),
            None => found.push((number.to_string(), false)),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(capabilities: &[u32]) -> Vec<u32> {
        let header = [0x0723_0203, 0x0001_0500, 0, 10, 0];
        header.into_iter().chain(capabilities.iter().flat_map(|number| [0x0002_0011, *number])).collect()
    }

    #[test]
    fn a_device_without_features_takes_what_vulkan_guarantees() {
        let (core, on12, on13) = Default::default();
        let floats = vk::PhysicalDeviceFloatControlsProperties::default();
        let operations = vk::SubgroupFeatureFlags::empty();
        let enabled =
            Enabled { core: &core, on12: &on12, on13: &on13, operations, plain_ballots: false, floats: &floats };
        let least = allowed(&enabled);
        assert!(check(&least, &module(&[Capability::Shader as u32, Capability::ImageQuery as u32]), "a").is_ok());
        for (capability, name) in [
            (Capability::Float64 as u32, "Float64"),
            (Capability::Int8 as u32, "Int8"),
            (Capability::GroupNonUniformBallot as u32, "GroupNonUniformBallot"),
            (Capability::Geometry as u32, "Geometry"),
            (999_999, "999999"),
        ] {
            let found = check(&least, &module(&[Capability::Shader as u32, capability]), "a").unwrap_err();
            assert!(matches!(&found, Error::CapabilityMissing { lacks, .. } if lacks == name), "{found}");
        }
        let core = vk::PhysicalDeviceFeatures { shader_float64: vk::TRUE, ..core };
        let more = allowed(&Enabled { core: &core, ..enabled });
        assert!(check(&more, &module(&[Capability::Float64 as u32]), "a").is_ok());
        assert_eq!(more.len(), least.len() + 1);
    }

    #[test]
    fn a_module_that_is_cut_off_declares_nothing_more() {
        let least = BTreeSet::from([Capability::Shader]);
        for words in 0..7 {
            assert!(check(&least, &module(&[Capability::Shader as u32])[..words], "a").is_ok());
        }
    }
}
