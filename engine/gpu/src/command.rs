//! Command buffers: recording commands for the device.
#![expect(
    clippy::cast_possible_wrap,
    reason = "sides of images are far below 2³¹: `maxImageDimension` of no device comes near"
)]

use std::sync::Arc;

use ash::vk;

use crate::buffer::Buffer;
use crate::choice::DeviceKind;
use crate::descriptors::Descriptors;
use crate::device::Device;
use crate::image::Image;
use crate::last_use::UploadUses;
use crate::pipeline::ComputePipeline;
use crate::query::Timestamps;
use crate::queue::{TimelineValue, WindowSemaphores};
use crate::result::{Error, Named, Result};
use crate::retire::Dead;

/// A dependency that was put together beforehand, so that recording it allocates nothing.
#[derive(Clone, Default)]
pub struct Barrier {
    memory: Option<vk::MemoryBarrier2<'static>>,
    images: Vec<vk::ImageMemoryBarrier2<'static>>,
    held: Vec<Arc<Image>>,
}

/// Stages and accesses of one side of a dependency.
pub type Scope = (vk::PipelineStageFlags2, vk::AccessFlags2);

/// All commands of a queue, with all their accesses to memory.
const EVERYTHING: Scope = (
    vk::PipelineStageFlags2::ALL_COMMANDS,
    vk::AccessFlags2::from_raw(vk::AccessFlags2::MEMORY_READ.as_raw() | vk::AccessFlags2::MEMORY_WRITE.as_raw()),
);

impl Barrier {
    /// A dependency of everything after on everything before.
    pub fn full() -> Barrier {
        Barrier::default().memory(EVERYTHING, EVERYTHING)
    }

    /// As [`Barrier::full`]. The host also sees everything before, once the submission has finished.
    pub fn full_to_host() -> Barrier {
        Barrier::to_host(EVERYTHING)
    }

    /// A dependency of everything after on `src`. The host also sees the writes of `src`, once the submission has finished.
    pub fn to_host(src: Scope) -> Barrier {
        Barrier::default().memory(src, (EVERYTHING.0 | vk::PipelineStageFlags2::HOST, EVERYTHING.1))
    }

    /// Adds the global memory barrier.
    #[must_use]
    pub fn memory(mut self, src: Scope, dst: Scope) -> Barrier {
        self.memory = Some(
            vk::MemoryBarrier2::default()
                .src_stage_mask(src.0)
                .src_access_mask(src.1)
                .dst_stage_mask(dst.0)
                .dst_access_mask(dst.1),
        );
        self
    }

    /// Adds the transition of a whole image from `UNDEFINED` to `GENERAL`: its contents are lost.
    #[must_use]
    pub fn activate(mut self, image: &Arc<Image>, src: Scope, dst: Scope) -> Barrier {
        self.images.push(
            transition(image.raw, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL)
                .src_stage_mask(src.0)
                .src_access_mask(src.1)
                .dst_stage_mask(dst.0)
                .dst_access_mask(dst.1),
        );
        self.held.push(image.clone());
        self
    }
}

pub(crate) fn transition(
    image: vk::Image,
    old: vk::ImageLayout,
    new: vk::ImageLayout,
) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .image(image)
        .old_layout(old)
        .new_layout(new)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(whole())
}

pub(crate) fn whole() -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        base_mip_level: 0,
        level_count: vk::REMAINING_MIP_LEVELS,
        base_array_layer: 0,
        layer_count: vk::REMAINING_ARRAY_LAYERS,
    }
}

/// Four channels of a clear, in the kind of the image's format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClearColor {
    /// Float, unorm, snorm.
    Float([f32; 4]),
    /// Signed.
    Int([i32; 4]),
    /// Unsigned.
    Uint([u32; 4]),
}

/// A command buffer with its pool. [`Self::begin`] opens a [`Recording`], which is submitted or given up; the buffer can be recorded again
/// once the device has finished that submission.
pub struct CommandBuffer {
    raw: vk::CommandBuffer,
    pool: vk::CommandPool,
    device: Arc<Device>,
    name: String,
    /// The last submission: until the device reaches it, the buffer must not be touched.
    submitted: TimelineValue,
    /// The upload buffers that the recorded commands use.
    uses: UploadUses,
}

impl CommandBuffer {
    /// Makes an empty one.
    pub fn new(device: &Arc<Device>, name: &str) -> Result<CommandBuffer> {
        let create = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue.family);
        // SAFETY: plain data.
        let pool = unsafe { device.raw.create_command_pool(&create, None) }.named("vkCreateCommandPool")?;
        let mut commands = CommandBuffer {
            raw: vk::CommandBuffer::null(),
            pool,
            device: device.clone(),
            name: name.to_owned(),
            submitted: TimelineValue::default(),
            uses: UploadUses::new(),
        };
        let allocate = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        // SAFETY: the pool was just made.
        commands.raw = unsafe { device.raw.allocate_command_buffers(&allocate) }.named("vkAllocateCommandBuffers")?[0];
        device.name(commands.raw, name);
        Ok(commands)
    }

    /// The last submission of this buffer; zero, which is always reached, before the first.
    pub fn submitted(&self) -> TimelineValue {
        self.submitted
    }

    /// Forgets the recorded commands and starts over.
    ///
    /// # Errors
    /// [`Error::InFlight`] while the device has not finished the last submission; wait for [`Self::submitted`] first.
    pub fn begin(&mut self) -> Result<Recording<'_>> {
        if !self.device.has_reached(self.submitted)? {
            return Err(Error::InFlight { name: self.name.clone() });
        }
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: `&mut self` is the pool's external synchronisation, and the last submission has finished.
        unsafe {
            let reset = self.device.raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty());
            self.device.watch(reset.named("vkResetCommandPool"))?;
            self.device.watch(self.device.raw.begin_command_buffer(self.raw, &begin).named("vkBeginCommandBuffer"))?;
        }
        self.uses.clear();
        self.device.recording_began();
        Ok(Recording { commands: self, bound: vk::Pipeline::null() })
    }
}

/// A command buffer while it is recorded. Dropped without [`Self::submit`], its commands are dropped.
pub struct Recording<'a> {
    commands: &'a mut CommandBuffer,
    /// The compute pipeline that is bound. It outlives the recording, also when it is dropped: no other has its handle.
    bound: vk::Pipeline,
}

impl Recording<'_> {
    /// Ends the recording and submits it. The value is reached when the device has finished it.
    pub fn submit(self) -> Result<TimelineValue> {
        self.submit_with(None)
    }

    pub(crate) fn submit_with(self, window: Option<&WindowSemaphores>) -> Result<TimelineValue> {
        let CommandBuffer { raw, device, submitted, uses, .. } = &mut *self.commands;
        // SAFETY: the buffer is being recorded.
        device.watch(unsafe { device.raw.end_command_buffer(*raw) }.named("vkEndCommandBuffer"))?;
        *submitted = device.submit(*raw, uses, window)?;
        Ok(*submitted)
    }

    pub(crate) fn raw(&self) -> vk::CommandBuffer {
        self.commands.raw
    }

    pub(crate) fn device(&self) -> &Arc<Device> {
        &self.commands.device
    }

    /// The commands use a buffer: the host must not write it until they have finished.
    pub(crate) fn uses(&mut self, buffer: &Buffer) {
        self.commands.uses.add(buffer.last_use());
    }

    /// Records a dependency.
    pub fn barrier(&mut self, barrier: &Barrier) {
        let mut info = vk::DependencyInfo::default().image_memory_barriers(&barrier.images);
        if let Some(memory) = &barrier.memory {
            info = info.memory_barriers(std::slice::from_ref(memory));
        }
        // SAFETY: recording; the images are held by the barrier.
        unsafe { self.device().raw.cmd_pipeline_barrier2(self.raw(), &info) };
    }

    pub(crate) fn image_barrier(&mut self, barrier: vk::ImageMemoryBarrier2<'_>) {
        let info = vk::DependencyInfo::default().image_memory_barriers(std::slice::from_ref(&barrier));
        // SAFETY: recording; the caller keeps the image.
        unsafe { self.device().raw.cmd_pipeline_barrier2(self.raw(), &info) };
    }

    /// Clears all mips and layers of an image in `GENERAL`.
    pub fn clear_image(&mut self, image: &Image, color: ClearColor) {
        let value = match color {
            ClearColor::Float(float32) => vk::ClearColorValue { float32 },
            ClearColor::Int(int32) => vk::ClearColorValue { int32 },
            ClearColor::Uint(uint32) => vk::ClearColorValue { uint32 },
        };
        // SAFETY: recording; a dropped image lives on until the submission has finished.
        unsafe {
            self.device().raw.cmd_clear_color_image(
                self.raw(),
                image.raw,
                vk::ImageLayout::GENERAL,
                &value,
                &[whole()],
            );
        }
    }

    /// Clears the image of a window in the given layout.
    pub(crate) fn clear_raw(&mut self, image: vk::Image, layout: vk::ImageLayout, color: [f32; 4]) {
        let value = vk::ClearColorValue { float32: color };
        // SAFETY: recording; the image was acquired, and its chain lives until the submission has finished.
        unsafe { self.device().raw.cmd_clear_color_image(self.raw(), image, layout, &value, &[whole()]) };
    }

    /// Fills a part of a buffer with a 32-bit pattern.
    ///
    /// # Panics
    /// If the part does not lie in the buffer, or its offset or size is no multiple of 4.
    pub fn fill_buffer(&mut self, buffer: &Buffer, offset: u64, size: u64, pattern: u32) {
        buffer.require(offset, size, 4);
        self.uses(buffer);
        // SAFETY: as in `clear_image`; the part lies in the buffer.
        unsafe { self.device().raw.cmd_fill_buffer(self.raw(), buffer.raw, offset, size, pattern) };
    }

    /// Writes bytes into a buffer from `offset` on, out of the command buffer itself: for small tables.
    ///
    /// # Panics
    /// If the bytes do not lie in the buffer, or their offset or number is no multiple of 4.
    pub fn update_buffer(&mut self, buffer: &Buffer, offset: u64, bytes: &[u8]) {
        // `vkCmdUpdateBuffer` takes this many bytes at a time.
        const MOST: usize = 65_536;
        buffer.require(offset, bytes.len() as u64, 4);
        self.uses(buffer);
        for (number, part) in bytes.chunks(MOST).enumerate() {
            let offset = offset + (number * MOST) as u64;
            // SAFETY: as in `clear_image`; the part lies in the buffer and has at most 65,536 bytes, a multiple of 4.
            unsafe { self.device().raw.cmd_update_buffer(self.raw(), buffer.raw, offset, part) };
        }
    }

    /// Binds a pipeline and its descriptor sets. A pipeline that is bound already is not bound again: the rounds of a loop share one.
    ///
    /// # Panics
    /// If the descriptor sets were made for another pipeline.
    pub fn bind(&mut self, pipeline: &ComputePipeline, descriptors: &Descriptors) {
        assert!(descriptors.layout == pipeline.layout.id, "the descriptor sets are of another pipeline");
        descriptors.uses.iter().for_each(|last_use| self.commands.uses.add(Some(last_use)));
        let point = vk::PipelineBindPoint::COMPUTE;
        let known = std::mem::replace(&mut self.bound, pipeline.raw) == pipeline.raw;
        // SAFETY: as in `clear_image`; the sets were made for this pipeline's layout.
        unsafe {
            if !known {
                self.device().raw.cmd_bind_pipeline(self.raw(), point, pipeline.raw);
            }
            if !descriptors.sets.is_empty() {
                let (layout, sets) = (pipeline.layout.raw, &descriptors.sets);
                self.device().raw.cmd_bind_descriptor_sets(self.raw(), point, layout, 0, sets, &[]);
            }
        }
    }

    /// Sets the push constants from offset 0 on.
    ///
    /// # Panics
    /// If the pipeline has fewer, or the number of bytes is no multiple of 4.
    pub fn push(&mut self, pipeline: &ComputePipeline, bytes: &[u8]) {
        let most = pipeline.layout.push_bytes as usize;
        assert!(bytes.len().is_multiple_of(4) && bytes.len() <= most, "{} of {most} bytes are pushed", bytes.len());
        // SAFETY: as in `clear_image`; the layout has a range of at least this many bytes.
        unsafe {
            let stages = vk::ShaderStageFlags::COMPUTE;
            self.device().raw.cmd_push_constants(self.raw(), pipeline.layout.raw, stages, 0, bytes);
        }
    }

    /// Dispatches `groups` workgroups of the bound pipeline.
    ///
    /// # Panics
    /// If none is.
    pub fn dispatch(&mut self, groups: [u32; 3]) {
        self.require_pipeline();
        // SAFETY: recording; a pipeline is bound.
        unsafe { self.device().raw.cmd_dispatch(self.raw(), groups[0], groups[1], groups[2]) };
    }

    /// Dispatches as many workgroups of the pipeline that is bound as three `uint`s at an offset say.
    ///
    /// # Panics
    /// If none is bound, or the three do not lie in the buffer, at a multiple of 4.
    pub fn dispatch_indirect(&mut self, buffer: &Buffer, offset: u64) {
        self.require_pipeline();
        buffer.require(offset, 12, 4);
        self.uses(buffer);
        // SAFETY: as in `clear_image`; a pipeline is bound, and the arguments lie in the buffer.
        unsafe { self.device().raw.cmd_dispatch_indirect(self.raw(), buffer.raw, offset) };
    }

    fn require_pipeline(&self) {
        assert!(self.bound != vk::Pipeline::null(), "a dispatch needs a pipeline");
    }

    /// Copies bytes from one buffer to another; each has its own offset.
    ///
    /// # Panics
    /// If they do not lie in both.
    pub fn copy_buffer(&mut self, (from, src_offset): (&Buffer, u64), (to, dst_offset): (&Buffer, u64), size: u64) {
        from.require(src_offset, size, 1);
        to.require(dst_offset, size, 1);
        self.uses(from);
        self.uses(to);
        let region = vk::BufferCopy { src_offset, dst_offset, size };
        // SAFETY: as in `clear_image`; the bytes lie in both.
        unsafe { self.device().raw.cmd_copy_buffer(self.raw(), from.raw, to.raw, &[region]) };
    }

    /// Copies many parts of one buffer to another: the offsets in both, and bytes.
    ///
    /// # Safety
    /// Every part lies in both buffers, no two of them overlap in `to`, and the host writes no part of `from` until the commands have finished:
    /// this does not count as a use of `from`.
    pub(crate) unsafe fn copy_regions(&mut self, from: &Buffer, to: &Buffer, parts: &[[u64; 3]]) {
        let region = |&[src_offset, dst_offset, size]: &[u64; 3]| vk::BufferCopy { src_offset, dst_offset, size };
        let regions: Vec<vk::BufferCopy> = parts.iter().map(region).collect();
        self.uses(to);
        // SAFETY: as in `clear_image`; the caller's promise.
        unsafe { self.device().raw.cmd_copy_buffer(self.raw(), from.raw, to.raw, &regions) };
    }

    /// Copies one layer, or one slice of a 3-D image, of one mip to the start of a buffer, without padding. The image is in `GENERAL`.
    ///
    /// # Panics
    /// If the image has no such layer, slice or mip, or the buffer is smaller.
    pub fn copy_image_to_buffer(&mut self, image: &Image, mip: u32, layer: u32, to: &Buffer) {
        let [width, height, _] = image.mip_extent(mip);
        let first = if image.info().volume { [0, 0, layer] } else { [0; 3] };
        let layers = if image.info().volume { 1 } else { layer.saturating_add(1) };
        to.require(0, image.require(mip, first, [width, height, 1], layers), 1);
        self.uses(to);
        let (slice, layer) = if image.info().volume { (layer, 0) } else { (0, layer) };
        let region = vk::BufferImageCopy {
            image_subresource: subresource(mip, layer),
            image_offset: vk::Offset3D { x: 0, y: 0, z: slice as i32 },
            image_extent: vk::Extent3D { width, height, depth: 1 },
            ..Default::default()
        };
        let layout = vk::ImageLayout::GENERAL;
        // SAFETY: as in `clear_image`.
        unsafe { self.device().raw.cmd_copy_image_to_buffer(self.raw(), image.raw, layout, to.raw, &[region]) };
    }

    /// Copies one texel of one mip of one layer, or of one slice of a 3-D image, to an offset of a buffer, a multiple of 4 and of the texel's bytes. The
    /// image is in `GENERAL`.
    ///
    /// # Panics
    /// If the image has no such texel, or the buffer no room for it there.
    pub fn copy_texel_to_buffer(
        &mut self,
        image: &Image,
        mip: u32,
        layer: u32,
        [x, y]: [u32; 2],
        (to, buffer_offset): (&Buffer, u64),
    ) {
        let volume = image.info().volume;
        let (slice, layer) = if volume { (layer, 0) } else { (0, layer) };
        to.require(buffer_offset, image.require(mip, [x, y, slice], [1; 3], layer.saturating_add(1)), 1);
        self.uses(to);
        let region = vk::BufferImageCopy {
            buffer_offset,
            image_subresource: subresource(mip, layer),
            image_offset: vk::Offset3D { x: x as i32, y: y as i32, z: slice as i32 },
            image_extent: vk::Extent3D { width: 1, height: 1, depth: 1 },
            ..Default::default()
        };
        let layout = vk::ImageLayout::GENERAL;
        // SAFETY: as in `clear_image`.
        unsafe { self.device().raw.cmd_copy_image_to_buffer(self.raw(), image.raw, layout, to.raw, &[region]) };
    }

    /// Copies texels without padding from an offset of a buffer, a multiple of 4 and of the texel's bytes, into a box of one mip of an
    /// image in `GENERAL`, at the first layer.
    ///
    /// # Panics
    /// If the box does not lie in the mip, or the texels do not lie in the buffer.
    pub fn copy_buffer_to_texels(
        &mut self,
        (from, buffer_offset): (&Buffer, u64),
        image: &Image,
        mip: u32,
        [x, y, z]: [u32; 3],
        [width, height, depth]: [u32; 3],
    ) {
        from.require(buffer_offset, image.require(mip, [x, y, z], [width, height, depth], 1), 1);
        self.uses(from);
        let region = vk::BufferImageCopy {
            buffer_offset,
            image_subresource: subresource(mip, 0),
            image_offset: vk::Offset3D { x: x as i32, y: y as i32, z: z as i32 },
            image_extent: vk::Extent3D { width, height, depth },
            ..Default::default()
        };
        let layout = vk::ImageLayout::GENERAL;
        // SAFETY: as in `clear_image`.
        unsafe { self.device().raw.cmd_copy_buffer_to_image(self.raw(), from.raw, image.raw, layout, &[region]) };
    }

    /// Makes timestamps ready to be written.
    pub fn reset_timestamps(&mut self, timestamps: &Timestamps) {
        // SAFETY: as in `clear_image`.
        unsafe { self.device().raw.cmd_reset_query_pool(self.raw(), timestamps.raw, 0, timestamps.count()) };
    }

    /// Takes the time when all compute work before has finished (`after`), or when work from here on may start.
    ///
    /// # Panics
    /// If there are fewer timestamps.
    pub fn timestamp(&mut self, timestamps: &Timestamps, index: u32, after: bool) {
        assert!(index < timestamps.count(), "timestamp {index} of {}", timestamps.count());
        let stage = if after { vk::PipelineStageFlags2::COMPUTE_SHADER } else { vk::PipelineStageFlags2::TOP_OF_PIPE };
        // SAFETY: as in `clear_image`.
        unsafe { self.device().raw.cmd_write_timestamp2(self.raw(), stage, timestamps.raw, index) };
        if self.device().capabilities().kind == DeviceKind::Cpu {
            // Once llvmpipe has drawn to a window, it charges a time to its next draw, which is after the passes that follow. Lavapipe
            // draws all that is pending at a barrier.
            let all = vk::PipelineStageFlags2::ALL_COMMANDS;
            let barrier = [vk::MemoryBarrier2::default().src_stage_mask(all).dst_stage_mask(all)];
            let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
            // SAFETY: as in `clear_image`.
            unsafe { self.device().raw.cmd_pipeline_barrier2(self.raw(), &dependency) };
        }
    }

    /// Writes a word, for [`crate::Buffer::word`] after a device loss: once all compute work before has finished (`after`), or when the
    /// device gets there. Without `VK_AMD_buffer_marker` a word for the latter is a plain fill, which is in its place only on a device that
    /// runs commands one after the other.
    ///
    /// # Panics
    /// If the word does not lie in the buffer, at a multiple of 4.
    pub fn mark(&mut self, buffer: &Buffer, offset: u64, word: u32, after: bool) {
        buffer.require(offset, 4, 4);
        self.uses(buffer);
        if let Some(marker) = &self.device().marker {
            let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
            let stage = if after { stage } else { vk::PipelineStageFlags::TOP_OF_PIPE };
            // SAFETY: as in `clear_image`; the extension is on.
            unsafe {
                (marker.fp().cmd_write_buffer_marker_amd)(self.raw(), stage, buffer.raw, offset, word);
            }
            return;
        }
        let memory = vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::COMPUTE_SHADER)
            .dst_stage_mask(vk::PipelineStageFlags2::CLEAR | vk::PipelineStageFlags2::COPY);
        let info = vk::DependencyInfo::default().memory_barriers(std::slice::from_ref(&memory));
        // SAFETY: as in `clear_image`.
        unsafe {
            if after {
                self.device().raw.cmd_pipeline_barrier2(self.raw(), &info);
            }
            self.device().raw.cmd_fill_buffer(self.raw(), buffer.raw, offset, 4, word);
        }
    }

    /// Opens a named region, for captures and messages.
    pub fn label(&mut self, name: &std::ffi::CStr) {
        if let Some(debug) = &self.device().debug {
            let label = vk::DebugUtilsLabelEXT::default().label_name(name);
            // SAFETY: recording.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw(), &label) };
        }
    }

    /// Closes the region.
    pub fn end_label(&mut self) {
        if let Some(debug) = &self.device().debug {
            // SAFETY: recording; a region is open.
            unsafe { debug.cmd_end_debug_utils_label(self.raw()) };
        }
    }

    /// Copies a whole picture onto another image of another size, nearest texels; layouts `GENERAL` and `to_layout`.
    pub(crate) fn blit(&mut self, from: &Image, to: vk::Image, to_layout: vk::ImageLayout, to_corners: [[u32; 2]; 2]) {
        let corners = |[from, to]: [[u32; 2]; 2]| {
            let corner = |[x, y]: [u32; 2], z| vk::Offset3D { x: x as i32, y: y as i32, z };
            [corner(from, 0), corner(to, 1)]
        };
        let region = vk::ImageBlit::default()
            .src_subresource(subresource(0, 0))
            .src_offsets(corners([[0; 2], [from.info().extent[0], from.info().extent[1]]]))
            .dst_subresource(subresource(0, 0))
            .dst_offsets(corners(to_corners));
        let (raw, general, filter) = (&self.device().raw, vk::ImageLayout::GENERAL, vk::Filter::NEAREST);
        // SAFETY: as in `clear_image`.
        unsafe { raw.cmd_blit_image(self.raw(), from.raw, general, to, to_layout, &[region], filter) };
    }

    /// Copies the texels of one image to another of the same texel size, bit by bit, in every mip that both have; both in `GENERAL`. Of images
    /// with different extents it copies the part that both have.
    ///
    /// # Panics
    /// If the texels of the two have different sizes.
    pub fn copy_image(&mut self, from: &Image, to: &Image) {
        let general = vk::ImageLayout::GENERAL;
        assert!(from.texel_bytes() == to.texel_bytes(), "{from:?} has other texels than {to:?}");
        for mip in 0..from.info().mips.min(to.info().mips) {
            let (of_from, of_to) = (from.mip_extent(mip), to.mip_extent(mip));
            let [width, height, depth] = std::array::from_fn(|axis| of_from[axis].min(of_to[axis]));
            let region = vk::ImageCopy {
                src_subresource: subresource(mip, 0),
                dst_subresource: subresource(mip, 0),
                extent: vk::Extent3D { width, height, depth },
                ..Default::default()
            };
            // SAFETY: as in `clear_image`.
            unsafe { self.device().raw.cmd_copy_image(self.raw(), from.raw, general, to.raw, general, &[region]) };
        }
    }
}

impl Drop for Recording<'_> {
    fn drop(&mut self) {
        self.commands.device.recording_ended();
    }
}

impl Drop for CommandBuffer {
    fn drop(&mut self) {
        // Destroyed once the timeline has passed every submission made so far, its own included.
        self.device.retire(Dead::CommandPool(self.pool));
    }
}

fn subresource(mip: u32, layer: u32) -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: mip,
        base_array_layer: layer,
        layer_count: 1,
    }
}
