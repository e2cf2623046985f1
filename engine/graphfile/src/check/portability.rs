//! Workgroups and capabilities: an error where no device can run a shader, a warning where some cannot.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{Value, ValueOrigin};

use super::Context;

/// Capabilities that need no feature, or one that every Vulkan 1.3 desktop driver has.
const COMMON: [&str; 24] = [
    "Matrix",
    "Shader",
    "Int64",
    "Int16",
    "Image1D",
    "ImageQuery",
    "Sampled1D",
    "StorageImageExtendedFormats",
    "StorageImageWriteWithoutFormat",
    "DerivativeControl",
    "DeviceGroup",
    "GroupNonUniform",
    "GroupNonUniformVote",
    "GroupNonUniformBallot",
    "GroupNonUniformShuffle",
    "GroupNonUniformArithmetic",
    "GroupNonUniformQuad",
    "GroupNonUniformShuffleRelative",
    "GroupNonUniformClustered",
    "SubgroupBallotKHR",
    "SubgroupVoteKHR",
    "VulkanMemoryModel",
    "DotProduct",
    "StorageImageArrayDynamicIndexing",
];

/// Capabilities that raxel switches on where the device has them.
const SOMETIMES: [&str; 13] = [
    "Float64",
    "Float16",
    "Int8",
    "Int64Atomics",
    "StorageBuffer8BitAccess",
    "StorageImageReadWithoutFormat",
    "VulkanMemoryModelDeviceScope",
    "DotProductInput4x8BitPacked",
    "DotProductInput4x8Bit",
    "DenormPreserve",
    "DenormFlushToZero",
    "SignedZeroInfNanPreserve",
    "RoundingModeRTE",
];

/// Checks the workgroup size, with the constants that the graph sets, and the capabilities.
pub(crate) fn check(context: &Context<'_>, constants: &[(u32, ValueOrigin)], found: &mut Vec<Diagnostic>) {
    let size = context.interface().local_size.map(|axis| {
        let set = constants.iter().find(|(id, _)| Some(*id) == axis.spec_id);
        match set {
            Some((_, ValueOrigin::Value(Value::U32(value)))) => *value,
            Some((_, ValueOrigin::Value(Value::I32(value)))) => u32::try_from(*value).unwrap_or(0),
            // A count that only a plan knows is judged there.
            Some(_) => 1,
            None => axis.value,
        }
    });
    let pass = &context.pass;
    let place = pass.request.as_ref().map_or(&pass.name.span, |request| &request.span);
    // Only the device knows the largest number of threads.
    if size.contains(&0) {
        let [x, y, z] = size;
        found.push(
            Diagnostic::error(
                codes::graph::WORKGROUP,
                format!("the workgroup of pass `{}` is {x} × {y} × {z}: it has no threads", pass.name.value),
            )
            .label(place.clone(), "the shader's `local_size`, with the constants of the graph"),
        );
    }
    if !context.first_use {
        return;
    }
    for capability in context.interface().capabilities.iter().map(String::as_str) {
        if SOMETIMES.contains(&capability) {
            let message = format!("pass `{}` needs `{capability}`, which not every device has", pass.name.value);
            let warning = Diagnostic::warning(codes::graph::NOT_PORTABLE, message);
            found.push(warning.label(place.clone(), "declared by the compiled shader"));
        } else if !COMMON.contains(&capability) {
            let message = format!("pass `{}` needs `{capability}`, which raxel does not switch on", pass.name.value);
            let error = Diagnostic::error(codes::graph::CAPABILITY, message);
            found.push(error.label(place.clone(), "declared by the compiled shader"));
        }
    }
}
