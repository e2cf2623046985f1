//! What a plan uses of a device besides its limits: features of shaders, and formats of images.

use std::sync::Arc;

use raxel_gpu::Device;
use raxel_graph::plan::{ImageDesc, Plan, ResourceDesc};

use super::device::image_info;
use super::error::ExecuteError;
use super::physical::filters_linearly;

/// Something that some devices have and others have not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Use {
    /// Its kind, e.g. `shader feature`.
    pub kind: &'static str,
    /// Its name: a SPIR-V capability, or a format.
    pub name: String,
    /// The first pass or target that uses it, e.g. "pass `shade`".
    pub by: String,
    /// Whether the device has it.
    pub has: bool,
}

/// Everything of that kind that a plan uses, each once, in the order of the plan: passes, then targets.
///
/// # Errors
/// The driver does not say.
pub fn uses(device: &Arc<Device>, plan: &Plan) -> Result<Vec<Use>, ExecuteError> {
    let mut found = Vec::new();
    let mut add = |new: Use| {
        if !found.iter().any(|known: &Use| (known.kind, &known.name, known.has) == (new.kind, &new.name, new.has)) {
            found.push(new);
        }
    };
    for planned in &plan.passes {
        let pass = plan.graph.pass(planned.pass);
        for (name, has) in device.demands(&pass.shader.spirv) {
            add(Use { kind: "shader feature", name, by: format!("pass `{}`", pass.name), has });
        }
    }
    for planned in &plan.resources {
        let ResourceDesc::Image(desc) = &planned.desc else { continue };
        let by = format!("target `{}`", plan.graph.resource(planned.resource).name);
        let kind = if desc.usage.storage { "stored format" } else { "sampled format" };
        let has = device.image_support(&image_info(device, desc))?;
        add(Use { kind, name: desc.format.name().to_owned(), by: by.clone(), has });
        let is_filtered =
            plan.passes.iter().flat_map(|planned| &plan.graph.pass(planned.pass).accesses).any(|access| {
                access.resource == planned.resource && access.sampler.is_some_and(|sampler| sampler.linear)
            });
        if is_filtered {
            let ImageDesc { format, .. } = desc;
            let has = filters_linearly(device, *format);
            add(Use { kind: "filtered format", name: format.name().to_owned(), by, has });
        }
    }
    Ok(found)
}
