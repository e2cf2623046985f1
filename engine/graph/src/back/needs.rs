//! The needs of a plan's passes for a device.

use raxel_shader::interface::BindingKind;

use crate::back::sizes::local_size;
use crate::ir::checked::{Pass, Value};
use crate::ir::plan::{BindingLimits, DeviceLimits, Plan};

/// How much of something one pass needs, and how much a device has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The counted thing, e.g. `storage buffers`.
    pub what: &'static str,
    /// Vulkan's name of the limit.
    pub limit: &'static str,
    /// How much the pass needs.
    pub needs: u64,
    /// How much the device has.
    pub has: u64,
    /// Name of the pass.
    pub pass: String,
}

impl Need {
    /// Whether the device has it.
    pub fn is_met(&self) -> bool {
        self.needs <= self.has
    }
}

/// The needs of a plan for each limit of a device, each from the pass that needs most.
pub fn needs(plan: &Plan, limits: &DeviceLimits) -> Vec<Need> {
    let mut most: Vec<Need> = Vec::new();
    for planned in &plan.passes {
        for need in needs_of(plan.graph.pass(planned.pass), &planned.specialization, limits) {
            match most.iter_mut().find(|known| known.what == need.what) {
                Some(known) if known.needs < need.needs => *known = need,
                Some(_) => {}
                None => most.push(need),
            }
        }
    }
    most.retain(|need| need.needs > 0);
    most
}

/// The needs of one pass with its specialization constants, those of nothing included.
pub(crate) fn needs_of(pass: &Pass, specialization: &[(u32, Value)], limits: &DeviceLimits) -> Vec<Need> {
    let local = local_size(pass, specialization);
    let of_workgroups = [
        ("workgroup threads", local.iter().map(|&side| u64::from(side)).product(), {
            ("maxComputeWorkGroupInvocations", u64::from(limits.workgroup_invocations))
        }),
        ("shared bytes", shared_bytes(pass, specialization), {
            ("maxComputeSharedMemorySize", u64::from(limits.shared_memory))
        }),
        ("pushed bytes", pass.shader.interface.push.as_ref().map_or(0, |block| block.size.into()), {
            ("maxPushConstantsSize", u64::from(limits.push_constants))
        }),
    ];
    let of_pass = |(what, needs, (limit, has))| Need { what, limit, needs, has, pass: pass.name.clone() };
    bindings(pass, &limits.bindings).into_iter().chain(of_workgroups).map(of_pass).collect()
}

/// Bytes that a workgroup of a pass shares, with its specialization constants.
pub(crate) fn shared_bytes(pass: &Pass, specialization: &[(u32, Value)]) -> u64 {
    let bits = |value: &Value| match value {
        Value::U32(value) => Some(*value),
        Value::I32(value) => Some(value.cast_unsigned()),
        Value::Bool(value) => Some(u32::from(*value)),
        _ => None,
    };
    pass.shader.shared_bytes(&specialization.iter().filter_map(|(id, value)| Some((*id, bits(value)?))).collect())
}

/// A kind of binding, how many a pass has, and the limit: Vulkan's name and the device's number.
pub(crate) type Count = (&'static str, u64, (&'static str, u64));

/// Resources that a pass binds, by kind. A shader's records (prints, checks, writes) need a storage buffer.
pub(crate) fn bindings(pass: &Pass, limits: &BindingLimits) -> [Count; 5] {
    let mut counts = [0_u64; 4];
    for binding in &pass.shader.interface.bindings {
        let kind = match binding.kind {
            BindingKind::StorageBuffer(_) => 0,
            BindingKind::StorageImage { .. } => 1,
            BindingKind::SampledImage { .. } => 2,
            BindingKind::UniformBuffer(_) => 3,
            BindingKind::Unsupported(_) => continue,
        };
        counts[kind] += u64::from(binding.count.max(1));
    }
    counts[0] += u64::from(pass.shader.interface.prints.is_some());
    let [buffers, images, sampled, blocks] = counts;
    let kind = |what, count, limit, has: u32| (what, count, (limit, u64::from(has)));
    [
        kind("storage buffers", buffers, "maxPerStageDescriptorStorageBuffers", limits.storage_buffers),
        kind("storage images", images, "maxPerStageDescriptorStorageImages", limits.storage_images),
        kind("sampled images", sampled, "maxPerStageDescriptorSampledImages", limits.sampled_images),
        kind("uniform blocks", blocks, "maxPerStageDescriptorUniformBuffers", limits.uniform_buffers),
        kind("resources", counts.iter().sum(), "maxPerStageResources", limits.resources),
    ]
}
