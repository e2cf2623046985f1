//! Descriptor sets: written once, when a plan is prepared, and never again.

use std::sync::Arc;

use ash::vk;

use crate::buffer::Buffer;
use crate::device::Device;
use crate::image::ImageView;
use crate::last_use::UploadUses;
use crate::pipeline::{ComputePipeline, PipelineLayout, Sampler};
use crate::result::{Named, Result};
use crate::retire::Dead;

/// The target of one descriptor.
#[derive(Clone)]
pub enum Resource {
    /// A storage image in `GENERAL`.
    StorageImage(Arc<ImageView>),
    /// A sampled image in `GENERAL` with its sampler.
    SampledImage(Arc<ImageView>, Arc<Sampler>),
    /// A buffer, or a part of it.
    Buffer {
        /// The buffer.
        buffer: Arc<Buffer>,
        /// Bytes from its begin.
        offset: u64,
        /// Bytes of the part.
        size: u64,
    },
}

impl Resource {
    /// All of a buffer.
    pub fn whole(buffer: &Arc<Buffer>) -> Self {
        Self::Buffer { buffer: buffer.clone(), offset: 0, size: buffer.size() }
    }
}

/// The descriptor sets of one pipeline, and everything they point to.
pub struct Descriptors {
    pub(crate) sets: Vec<vk::DescriptorSet>,
    /// The layout that they were made for.
    pub(crate) layout: u64,
    /// The upload buffers among their targets.
    pub(crate) uses: UploadUses,
    pool: vk::DescriptorPool,
    device: Arc<Device>,
    _held: Vec<Resource>,
}

impl Descriptors {
    /// Makes the sets of a pipeline. `resources[i]` are the elements of the pipeline's i-th slot; a slot with fewer elements than its
    /// array length repeats the last.
    ///
    /// # Panics
    /// If a part of a buffer does not lie in it.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        pipeline: &ComputePipeline,
        resources: &[Vec<Resource>],
    ) -> Result<Descriptors> {
        Descriptors::with_layout(device, name, &pipeline.layout, resources)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a layout has a few sets")]
    pub(crate) fn with_layout(
        device: &Arc<Device>,
        name: &str,
        layout: &PipelineLayout,
        resources: &[Vec<Resource>],
    ) -> Result<Descriptors> {
        let mut uses = UploadUses::default();
        for resource in resources.iter().flatten() {
            if let Resource::Buffer { buffer, offset, size: range } = resource {
                buffer.require(*offset, *range, 1);
                uses.add(buffer.last_use());
            }
        }
        let count = layout.sets.len() as u32;
        let sizes: Vec<_> = layout
            .slots
            .iter()
            .map(|slot| vk::DescriptorPoolSize { ty: slot.ty, descriptor_count: slot.count })
            .collect();
        if count == 0 {
            let pool = vk::DescriptorPool::null();
            let (layout, device) = (layout.id, device.clone());
            return Ok(Descriptors { sets: Vec::new(), layout, uses, pool, device, _held: Vec::new() });
        }
        let create = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        // SAFETY: plain data.
        let pool = unsafe { device.raw.create_descriptor_pool(&create, None) }.named("vkCreateDescriptorPool")?;
        let mut descriptors = Descriptors {
            sets: Vec::new(),
            layout: layout.id,
            uses,
            pool,
            device: device.clone(),
            _held: resources.iter().flatten().cloned().collect(),
        };
        let allocate = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layout.sets);
        // SAFETY: the pool was sized for exactly these sets.
        descriptors.sets =
            unsafe { device.raw.allocate_descriptor_sets(&allocate) }.named("vkAllocateDescriptorSets")?;
        for (set, raw) in descriptors.sets.iter().enumerate() {
            device.name(*raw, &format!("{name}, set {set}"));
        }
        for (slot, elements) in layout.slots.iter().zip(resources) {
            let Some(last) = elements.last() else { continue };
            for element in 0..slot.count {
                let resource = elements.get(element as usize).unwrap_or(last);
                descriptors.write(slot.set, slot.binding, element, slot.ty, resource);
            }
        }
        Ok(descriptors)
    }

    fn write(&self, set: u32, binding: u32, element: u32, ty: vk::DescriptorType, resource: &Resource) {
        let general = vk::ImageLayout::GENERAL;
        let image = |view: &ImageView, sampler: vk::Sampler| {
            [vk::DescriptorImageInfo { sampler, image_view: view.raw, image_layout: general }]
        };
        let images = match resource {
            Resource::StorageImage(view) => image(view, vk::Sampler::null()),
            Resource::SampledImage(view, sampler) => image(view, sampler.raw),
            Resource::Buffer { .. } => [vk::DescriptorImageInfo::default()],
        };
        let buffers = match resource {
            Resource::Buffer { buffer, offset, size: range } => {
                [vk::DescriptorBufferInfo { buffer: buffer.raw, offset: *offset, range: *range }]
            }
            _ => [vk::DescriptorBufferInfo::default()],
        };
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.sets[set as usize])
            .dst_binding(binding)
            .dst_array_element(element)
            .descriptor_type(ty);
        let write = match resource {
            Resource::Buffer { .. } => write.buffer_info(&buffers),
            _ => write.image_info(&images),
        };
        // SAFETY: the set is new, so no command buffer uses it; all handles are alive and held by `_held`.
        unsafe { self.device.raw.update_descriptor_sets(&[write], &[]) };
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        if self.pool != vk::DescriptorPool::null() {
            self.device.retire(Dead::DescriptorPool(self.pool));
        }
    }
}
