//! Deferred destruction: objects that are dropped while the device may still use them are destroyed when the timeline has passed them.

use std::collections::VecDeque;
use std::sync::{MutexGuard, PoisonError};

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::device::Device;
use crate::queue::TimelineValue;

/// Handles of one dropped object.
pub(crate) enum Dead {
    Buffer(vk::Buffer),
    Image(vk::Image),
    View(vk::ImageView),
    Memory(Allocation),
    Sampler(vk::Sampler),
    Pipeline(vk::Pipeline),
    PipelineLayout(vk::PipelineLayout, Vec<vk::DescriptorSetLayout>),
    DescriptorPool(vk::DescriptorPool),
    CommandPool(vk::CommandPool),
    QueryPool(vk::QueryPool),
}

/// Dropped objects.
#[derive(Default)]
pub(crate) struct Retired {
    /// In order of the submission that may have used them last.
    dated: VecDeque<(TimelineValue, Dead)>,
    /// Dropped while a command buffer that may name them was recorded but not submitted: dated when none is left.
    undated: Vec<Dead>,
    /// Command buffers that are recorded and not submitted.
    recording: u32,
}

impl Retired {
    pub(crate) fn all(self) -> impl Iterator<Item = Dead> {
        self.dated.into_iter().map(|(_, dead)| dead).chain(self.undated)
    }
}

impl Device {
    pub(crate) fn retire(&self, dead: Dead) {
        let mut retired = self.retired();
        if retired.recording == 0 {
            let now = self.submitted();
            retired.dated.push_back((now, dead));
        } else {
            retired.undated.push(dead);
        }
    }

    pub(crate) fn recording_began(&self) {
        self.retired().recording += 1;
    }

    /// The command buffer was submitted or given up.
    pub(crate) fn recording_ended(&self) {
        let mut retired = self.retired();
        retired.recording -= 1;
        if retired.recording == 0 {
            let now = self.submitted();
            let Retired { dated, undated, .. } = &mut *retired;
            dated.extend(undated.drain(..).map(|dead| (now, dead)));
        }
    }

    /// Destroys objects that the device has finished with. Called once a frame.
    pub fn collect(&self) {
        let Ok(reached) = self.reached() else { return };
        loop {
            let mut retired = self.retired();
            if retired.dated.front().is_none_or(|(value, _)| *value > reached) {
                return;
            }
            let Some((_, dead)) = retired.dated.pop_front() else { return };
            drop(retired);
            // SAFETY: the timeline has passed the last submission made before the object was dropped.
            unsafe { self.free(std::iter::once(dead)) };
        }
    }

    /// # Safety
    /// The device has finished all work that uses these.
    pub(crate) unsafe fn free(&self, dead: impl Iterator<Item = Dead>) {
        for dead in dead {
            // SAFETY: each handle was made on this device, is owned by the list alone, and by the caller's promise is not in use.
            unsafe {
                match dead {
                    Dead::Buffer(buffer) => self.raw.destroy_buffer(buffer, None),
                    Dead::Image(image) => self.raw.destroy_image(image, None),
                    Dead::View(view) => self.raw.destroy_image_view(view, None),
                    Dead::Memory(allocation) => {
                        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
                        if let Some(allocator) = allocator.as_mut() {
                            // It only fails for an allocation that is not its own.
                            let _ = allocator.free(allocation);
                        }
                    }
                    Dead::Sampler(sampler) => self.raw.destroy_sampler(sampler, None),
                    Dead::Pipeline(pipeline) => self.raw.destroy_pipeline(pipeline, None),
                    Dead::PipelineLayout(layout, sets) => {
                        self.raw.destroy_pipeline_layout(layout, None);
                        for set in sets {
                            self.raw.destroy_descriptor_set_layout(set, None);
                        }
                    }
                    Dead::DescriptorPool(pool) => self.raw.destroy_descriptor_pool(pool, None),
                    Dead::CommandPool(pool) => self.raw.destroy_command_pool(pool, None),
                    Dead::QueryPool(pool) => self.raw.destroy_query_pool(pool, None),
                }
            }
        }
    }

    fn retired(&self) -> MutexGuard<'_, Retired> {
        self.retired.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
