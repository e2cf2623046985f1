//! Workgroups and capabilities: what no device runs is an error, what some devices lack is a warning.

use raxel_diagnostics::{Diagnostic, codes};

use super::Context;
use crate::checked::Value;

/// Capabilities that need no warning: Vulkan 1.3 requires them, or every desktop driver has them and raxel asks for them.
const COMMON: [&str; 24] = [
    "Matrix",
    "Shader",
    "Int64",
    "Int16",
    "Image1D",
    "ImageQuery",
    "Sampled1D",
    "SampledBuffer",
    "ImageBuffer",
    "StorageImageExtendedFormats",
    "DerivativeControl",
    "GroupNonUniform",
    "GroupNonUniformVote",
    "GroupNonUniformBallot",
    "GroupNonUniformShuffle",
    "GroupNonUniformArithmetic",
    "GroupNonUniformQuad",
    "GroupNonUniformShuffleRelative",
    "GroupNonUniformClustered",
    "VulkanMemoryModel",
    "VulkanMemoryModelKHR",
    "PhysicalStorageBufferAddresses",
    "DotProduct",
    "DemoteToHelperInvocation",
];

/// Checks the workgroup size, with the constants that the graph sets, and the capabilities.
pub fn check(context: &Context<'_>, constants: &[(u32, Value)], found: &mut Vec<Diagnostic>) {
    let size = context.interface().local_size.map(|axis| {
        let set = constants.iter().find(|(id, _)| Some(*id) == axis.spec_id);
        match set {
            Some((_, Value::U32(value))) => *value,
            Some((_, Value::I32(value))) => u32::try_from(*value).unwrap_or(0),
            _ => axis.value,
        }
    });
    let pass = &context.pass;
    let place = pass.request.as_ref().map_or(&pass.name.span, |request| &request.span);
    // How many threads are too many only the device can say.
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
    for capability in &context.interface().capabilities {
        if context.first_use && !COMMON.contains(&capability.as_str()) {
            let message = format!("pass `{}` needs `{capability}`, which not every device has", pass.name.value);
            found.push(
                Diagnostic::warning(codes::graph::NOT_PORTABLE, message)
                    .label(place.clone(), "declared by the compiled shader"),
            );
        }
    }
}
