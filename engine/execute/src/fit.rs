//! Whether a device has the features that a plan needs: formats of targets, and capabilities of shaders. Limits are the planner's.

use std::sync::Arc;

use raxel_gpu::known::KnownDevice;
use raxel_gpu::{Capabilities, Device};
use raxel_graph::plan::{ImageDesc, Plan, ResourceDesc};
use raxel_shader::format::{Format, ScalarKind};

use super::device::image_info;
use super::error::ExecuteError;
use super::physical::filters_linearly;

/// A device that a plan may run on: an open one, or one that is known from reports.
pub trait Abilities {
    /// Its limits and features.
    fn capabilities(&self) -> &Capabilities;

    /// Whether it can make an image.
    ///
    /// # Errors
    /// The driver does not say.
    fn can_make(&self, image: &ImageDesc) -> Result<bool, ExecuteError>;

    /// Whether it can filter between texels of a format.
    fn filters(&self, format: Format) -> bool;
}

impl Abilities for Arc<Device> {
    fn capabilities(&self) -> &Capabilities {
        Device::capabilities(self)
    }

    fn can_make(&self, image: &ImageDesc) -> Result<bool, ExecuteError> {
        Ok(self.image_support(&image_info(self, image))?)
    }

    fn filters(&self, format: Format) -> bool {
        filters_linearly(self, format)
    }
}

/// A device that is not here.
#[derive(Clone, Debug)]
pub struct OnPaper {
    capabilities: Capabilities,
    /// Images of every format can be made, and stored to.
    formats: bool,
}

impl OnPaper {
    /// What is known of a device.
    pub fn of(known: &KnownDevice) -> Self {
        Self { capabilities: known.capabilities(), formats: known.formats }
    }
}

impl Abilities for OnPaper {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn can_make(&self, image: &ImageDesc) -> Result<bool, ExecuteError> {
        let format = image.format;
        Ok(self.formats || format.is_sampled_everywhere() && (!image.usage.storage || format.is_stored_everywhere()))
    }

    fn filters(&self, format: Format) -> bool {
        format.is_filtered_everywhere() || self.formats && format.scalar() == ScalarKind::Float
    }
}

/// Everything of a plan that the device cannot run, in the order of the plan: targets, then passes. Nothing is made for it.
///
/// # Errors
/// The driver does not say.
pub fn unfit(device: &dyn Abilities, plan: &Plan) -> Result<Vec<ExecuteError>, ExecuteError> {
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
        if let Some(lacks) = device.capabilities().lacks(&pass.shader.spirv) {
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
pub(super) fn image(
    device: &dyn Abilities,
    name: &str,
    desc: &ImageDesc,
) -> Result<Option<ExecuteError>, ExecuteError> {
    let usage = if desc.usage.storage { "a storage image" } else { "a sampled image" };
    Ok((!device.can_make(desc)?).then(|| ExecuteError::Format {
        target: name.to_owned(),
        format: desc.format.name(),
        usage: usage.to_owned(),
    }))
}

/// Why the device cannot filter between texels of a format, if it cannot.
pub(super) fn linear(device: &dyn Abilities, name: &str, format: Format) -> Option<ExecuteError> {
    (!device.filters(format)).then(|| ExecuteError::Format {
        target: name.to_owned(),
        format: format.name(),
        usage: "a linearly filtered image".to_owned(),
    })
}
