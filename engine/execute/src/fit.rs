//! Whether a device has the features that a plan needs: formats of targets, and capabilities of shaders. Limits are the planner's.

use std::sync::Arc;

use raxel_gpu::Device;
use raxel_graph::plan::{ImageDesc, Plan, ResourceDesc};
use raxel_shader::format::Format;

use super::device::image_info;
use super::error::ExecuteError;
use super::physical::filters_linearly;

/// Everything of a plan that the device cannot run, in the order of the plan: targets, then passes. Nothing is made for it.
///
/// # Errors
/// The driver does not say.
pub fn unfit(device: &Arc<Device>, plan: &Plan) -> Result<Vec<ExecuteError>, ExecuteError> {
    let mut found = Vec::new();
    for planned in &plan.resources {
        if let ResourceDesc::Image(desc) = &planned.desc
            && let Some(error) = image(device, &plan.graph.resource(planned.resource).name, desc)?
        {
            found.push(error);
        }
    }
    for planned in &plan.passes {
        let pass = plan.graph.pass(planned.pass);
        if let Some(lacks) = device.lacks(&pass.shader.spirv) {
            found.push(ExecuteError::Capability { pass: pass.name.clone(), lacks: format!("`{lacks}`") });
        }
        for access in pass.accesses.iter().filter(|access| access.sampler.is_some_and(|sampler| sampler.linear)) {
            let planned = plan.resources.iter().find(|planned| planned.resource == access.resource);
            let format = planned.and_then(|planned| match &planned.desc {
                ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc) => Some(desc.format),
                _ => None,
            });
            let name = &plan.graph.resource(access.resource).name;
            if let Some(error) = format.and_then(|format| linear(device, name, format)) {
                found.push(error);
            }
        }
    }
    Ok(found)
}

/// Why the device cannot make an image, if it cannot.
pub(super) fn image(device: &Arc<Device>, name: &str, desc: &ImageDesc) -> Result<Option<ExecuteError>, ExecuteError> {
    let usage = if desc.usage.storage { "a storage image" } else { "a sampled image" };
    let supported = device.image_support(&image_info(device, desc))?;
    Ok((!supported).then(|| ExecuteError::Format {
        target: name.to_owned(),
        format: desc.format.name(),
        usage: usage.to_owned(),
    }))
}

/// Why the device cannot filter between texels of a format, if it cannot.
pub(super) fn linear(device: &Device, name: &str, format: Format) -> Option<ExecuteError> {
    (!filters_linearly(device, format)).then(|| ExecuteError::Format {
        target: name.to_owned(),
        format: format.name(),
        usage: "a linearly filtered image".to_owned(),
    })
}
