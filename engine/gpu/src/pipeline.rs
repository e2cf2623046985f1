//! Pipelines with their layouts, and samplers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

use crate::choice::Version;
use crate::device::Device;
use crate::modules;
use crate::result::{Error, Named, Result};
use crate::retire::Dead;

/// One descriptor of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DescriptorSlot {
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// Kind.
    pub ty: vk::DescriptorType,
    /// Array length.
    pub count: u32,
}

/// The inputs of a compute pipeline.
#[derive(Clone, Copy, Debug)]
pub struct PipelineInfo<'a> {
    /// The module.
    pub spirv: &'a [u32],
    /// Entry point.
    pub entry: &'a str,
    /// Descriptors.
    pub slots: &'a [DescriptorSlot],
    /// Bytes of push constants, a multiple of 4.
    pub push_bytes: u32,
    /// Specialization constants: id and 32 bits of value.
    pub specialization: &'a [(u32, u32)],
    /// Invocations in a subgroup, asked for where the device lets one ask ([`crate::Capabilities::asks_for_subgroups_of`]).
    pub subgroup_size: Option<u32>,
}

/// Which descriptors and push constants the shaders of a pipeline take.
pub(crate) struct PipelineLayout {
    pub(crate) raw: vk::PipelineLayout,
    /// A number that no other layout of this process has: the driver may use a handle again.
    pub(crate) id: u64,
    pub(crate) sets: Vec<vk::DescriptorSetLayout>,
    pub(crate) slots: Vec<DescriptorSlot>,
    pub(crate) stages: vk::ShaderStageFlags,
    /// Bytes of push constants.
    pub(crate) push_bytes: u32,
    device: Arc<Device>,
}

/// The number of the next layout.
static NEXT_LAYOUT: AtomicU64 = AtomicU64::new(0);

impl PipelineLayout {
    pub(crate) fn new(
        device: &Arc<Device>,
        slots: &[DescriptorSlot],
        push_bytes: u32,
        stages: vk::ShaderStageFlags,
    ) -> Result<PipelineLayout> {
        let push_bytes = push_bytes.next_multiple_of(4);
        // From here on, `Drop` frees the objects so far.
        let mut layout = PipelineLayout {
            raw: vk::PipelineLayout::null(),
            id: NEXT_LAYOUT.fetch_add(1, Ordering::Relaxed),
            sets: Vec::new(),
            slots: slots.to_vec(),
            stages,
            push_bytes,
            device: device.clone(),
        };
        let sets = slots.iter().map(|slot| slot.set + 1).max().unwrap_or(0);
        for set in 0..sets {
            let bindings: Vec<_> = slots
                .iter()
                .filter(|slot| slot.set == set)
                .map(|slot| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(slot.binding)
                        .descriptor_type(slot.ty)
                        .descriptor_count(slot.count)
                        .stage_flags(stages)
                })
                .collect();
            let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: plain data.
            let set = unsafe { device.raw.create_descriptor_set_layout(&create, None) };
            layout.sets.push(set.named("vkCreateDescriptorSetLayout")?);
        }
        let range = vk::PushConstantRange { stage_flags: stages, offset: 0, size: push_bytes };
        let ranges = [range];
        let create = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&layout.sets)
            .push_constant_ranges(if push_bytes == 0 { &[] } else { &ranges });
        // SAFETY: the set layouts are alive.
        layout.raw = unsafe { device.raw.create_pipeline_layout(&create, None) }.named("vkCreatePipelineLayout")?;
        Ok(layout)
    }
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        self.device.retire(Dead::PipelineLayout(self.raw, std::mem::take(&mut self.sets)));
    }
}

/// A compute pipeline with its layout.
pub struct ComputePipeline {
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: PipelineLayout,
    device: Arc<Device>,
}

impl ComputePipeline {
    /// Makes a pipeline. Slow: the driver compiles the shader.
    #[expect(clippy::cast_possible_truncation, reason = "a shader has a few specialization constants")]
    pub fn new(device: &Arc<Device>, name: &str, info: &PipelineInfo<'_>) -> Result<ComputePipeline> {
        let entry = std::ffi::CString::new(info.entry).map_err(|_| Error::Vulkan {
            call: "vkCreateShaderModule",
            result: vk::Result::ERROR_INITIALIZATION_FAILED,
        })?;
        fit(info.slots, &device.capabilities().limits, name)?;
        let layout = PipelineLayout::new(device, info.slots, info.push_bytes, vk::ShaderStageFlags::COMPUTE)?;
        let module = ShaderModule::new(device, name, info.spirv)?;
        let entries: Vec<_> = info
            .specialization
            .iter()
            .enumerate()
            .map(|(i, (id, _))| vk::SpecializationMapEntry { constant_id: *id, offset: (i * 4) as u32, size: 4 })
            .collect();
        let data: Vec<u8> = info.specialization.iter().flat_map(|(_, bits)| bits.to_ne_bytes()).collect();
        let specialization = vk::SpecializationInfo::default().map_entries(&entries).data(&data);
        let asked = info.subgroup_size.filter(|size| device.capabilities().asks_for_subgroups_of(*size));
        let mut size = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default()
            .required_subgroup_size(asked.unwrap_or_default());
        let mut stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(&entry)
            .specialization_info(&specialization);
        if asked.is_some() {
            stage = stage.push_next(&mut size);
        }
        let mut feedback = vk::PipelineCreationFeedback::default();
        // Early versions of Vulkan 1.3 ask for the feedback of the stage, too.
        let mut of_stage = [vk::PipelineCreationFeedback::default()];
        let mut wanted = vk::PipelineCreationFeedbackCreateInfo::default()
            .pipeline_creation_feedback(&mut feedback)
            .pipeline_stage_creation_feedbacks(&mut of_stage);
        let mut create = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw);
        // A driver of Vulkan 1.2 does not know the structure.
        if device.capabilities().version >= (Version { major: 1, minor: 3, patch: 0 }) {
            create = create.push_next(&mut wanted);
        }
        // SAFETY: module and layout are alive; the cache is internally synchronised; the feedback lives until the call returns.
        let made = unsafe { device.raw.create_compute_pipelines(device.pipelines.raw, &[create], None) };
        let raw = device.watch(made.map_err(|(_, result)| result).making(name, "vkCreateComputePipelines"))?[0];
        device.pipelines.count(feedback);
        device.name(raw, name);
        Ok(ComputePipeline { raw, layout, device: device.clone() })
    }
}

/// Refuses a compute shader that binds more than the device can.
fn fit(slots: &[DescriptorSlot], limits: &vk::PhysicalDeviceLimits, name: &str) -> Result<()> {
    use vk::DescriptorType as Type;
    let of = |types: &[vk::DescriptorType]| {
        slots.iter().filter(|slot| types.contains(&slot.ty)).map(|slot| u64::from(slot.count)).sum::<u64>()
    };
    let [storage, uniform, image, sampled] =
        [Type::STORAGE_BUFFER, Type::UNIFORM_BUFFER, Type::STORAGE_IMAGE, Type::COMBINED_IMAGE_SAMPLER];
    let buffers = limits.max_per_stage_descriptor_storage_buffers;
    let kinds = [
        (&[storage][..], "storage buffers", buffers, "maxPerStageDescriptorStorageBuffers"),
        (
            &[uniform],
            "uniform blocks",
            limits.max_per_stage_descriptor_uniform_buffers,
            "maxPerStageDescriptorUniformBuffers",
        ),
        (
            &[image],
            "storage images",
            limits.max_per_stage_descriptor_storage_images,
            "maxPerStageDescriptorStorageImages",
        ),
        (
            &[sampled],
            "sampled images",
            limits.max_per_stage_descriptor_sampled_images,
            "maxPerStageDescriptorSampledImages",
        ),
        (&[sampled], "samplers", limits.max_per_stage_descriptor_samplers, "maxPerStageDescriptorSamplers"),
        (&[storage, uniform, image, sampled], "resources", limits.max_per_stage_resources, "maxPerStageResources"),
    ];
    for (types, what, limit, limit_name) in kinds {
        let count = of(types);
        if count > limit.into() {
            return Err(Error::TooManyBindings { name: name.to_owned(), count, what, limit, limit_name });
        }
    }
    Ok(())
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        self.device.retire(Dead::Pipeline(self.raw));
    }
}

/// A module; it is not needed any more once its pipeline is made.
pub(crate) struct ShaderModule {
    pub(crate) raw: vk::ShaderModule,
    device: Arc<Device>,
}

impl ShaderModule {
    pub(crate) fn new(device: &Arc<Device>, name: &str, spirv: &[u32]) -> Result<ShaderModule> {
        modules::check(&device.capabilities().shaders, spirv, name)?;
        let create = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: the shader compiler has parsed the module; the driver is given nothing it has not seen whole.
        let raw = unsafe { device.raw.create_shader_module(&create, None) }.making(name, "vkCreateShaderModule")?;
        Ok(ShaderModule { raw, device: device.clone() })
    }
}

impl Drop for ShaderModule {
    fn drop(&mut self) {
        // SAFETY: only the call that made a pipeline of it used it, and that call has returned.
        unsafe { self.device.raw.destroy_shader_module(self.raw, None) };
    }
}

/// The sampling of an image, over all its mips. The default is the nearest texel, clamped to the edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampling {
    /// Linear filtering, else the nearest texel.
    pub linear: bool,
    /// Repeats beyond the edge, else clamps to it.
    pub repeat: bool,
}

/// A sampler.
pub struct Sampler {
    pub(crate) raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Makes a sampler.
    pub fn new(device: &Arc<Device>, Sampling { linear, repeat }: Sampling) -> Result<Sampler> {
        let (filter, mipmap) = if linear {
            (vk::Filter::LINEAR, vk::SamplerMipmapMode::LINEAR)
        } else {
            (vk::Filter::NEAREST, vk::SamplerMipmapMode::NEAREST)
        };
        let mode = if repeat { vk::SamplerAddressMode::REPEAT } else { vk::SamplerAddressMode::CLAMP_TO_EDGE };
        let create = vk::SamplerCreateInfo::default()
            .mag_filter(filter)
            .min_filter(filter)
            .mipmap_mode(mipmap)
            .address_mode_u(mode)
            .address_mode_v(mode)
            .address_mode_w(mode)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: plain data.
        let raw = unsafe { device.raw.create_sampler(&create, None) }.named("vkCreateSampler")?;
        device.name(raw, if linear { "linear sampler" } else { "nearest sampler" });
        Ok(Sampler { raw, device: device.clone() })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        self.device.retire(Dead::Sampler(self.raw));
    }
}
