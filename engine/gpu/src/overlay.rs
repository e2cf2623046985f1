//! Triangles over a picture: textured, coloured, clipped and blended, as immediate-mode user interfaces make them for each frame. The
//! layout of a vertex, and the meaning of its colours, are those of `egui::epaint::Mesh`.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use crate::buffer::{Buffer, BufferInfo};
use crate::command::{Barrier, Recording};
use crate::descriptors::{Descriptors, Resource};
use crate::device::Device;
use crate::image::{Image, ImageInfo, ImageView, ViewInfo};
use crate::memory::{Backing, Location};
use crate::pipeline::{DescriptorSlot, PipelineLayout, Sampler, Sampling, ShaderModule};
use crate::result::{Error, Named, Result};
use crate::retire::Dead;
use crate::surface::AcquiredImage;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct OverlayVertex {
    /// Points from the top left of the picture; a point is `OverlayFrame::pixels_per_point` pixels.
    pub position: [f32; 2],
    /// 0 to 1 from the top left of the texture.
    pub uv: [f32; 2],
    /// Red, green, blue, alpha: sRGB-encoded, multiplied by alpha after the encoding.
    pub color: [u8; 4],
}

/// Triangles of one texture under one clip rectangle.
#[derive(Clone, Copy, Debug)]
pub struct OverlayMesh<'a> {
    /// Nothing outside is drawn: left, top, right, bottom, in points.
    pub clip: [f32; 4],
    /// A texture given to [`Overlay::set_texture`]. The mesh is left out when it is not there.
    pub texture: u64,
    /// Corners.
    pub vertices: &'a [OverlayVertex],
    /// Three a triangle, counted within `vertices`. The mesh is left out when one is too large.
    pub indices: &'a [u32],
}

/// The drawings over one picture, from back to front.
#[derive(Clone, Copy, Debug)]
pub struct OverlayFrame<'a> {
    /// Pixels of the window for each point; positive.
    pub pixels_per_point: f32,
    /// Meshes.
    pub meshes: &'a [OverlayMesh<'a>],
}

/// New texels of a texture, or of a rectangle of it.
#[derive(Clone, Copy, Debug)]
pub struct TexturePatch<'a> {
    /// Top left texel of the rectangle; `None` replaces the whole texture, its size included.
    pub position: Option<[u32; 2]>,
    /// Texels of the rectangle.
    pub size: [u32; 2],
    /// Rows from the top, four bytes a texel, encoded as the colours of [`OverlayVertex`].
    pub rgba: &'a [u8],
    /// Linear filtering, else the nearest texel. Only of the whole texture.
    pub linear: bool,
}

/// The SPIR-V of `overlay.vert` and `overlay.frag`, entry points `main`. Vertex inputs 0 to 2 are position, uv and colour; push constants
/// hold the extent of the picture in points; binding 0 of set 0 is the texture; specialization constant 0 is true if the target encodes
/// colours by itself.
#[derive(Clone, Copy, Debug)]
pub struct OverlayShaders<'a> {
    /// The vertex shader.
    pub vertex: &'a [u32],
    /// The fragment shader.
    pub fragment: &'a [u32],
}

/// A pipeline for one format of targets, its textures, and vertex and index buffers for each frame in flight.
pub struct Overlay {
    device: Arc<Device>,
    pipeline: vk::Pipeline,
    layout: PipelineLayout,
    textures: HashMap<u64, Texture>,
    uploads: Vec<Upload>,
    frames: Vec<FrameBuffers>,
}

struct Texture {
    image: Arc<Image>,
    descriptors: Descriptors,
}

/// Texels that the next drawing copies into their texture.
struct Upload {
    image: Arc<Image>,
    staging: Buffer,
    position: [u32; 2],
    size: [u32; 2],
    /// The texture has no contents yet.
    whole: bool,
}

#[derive(Default)]
struct FrameBuffers {
    vertices: Option<Buffer>,
    indices: Option<Buffer>,
}

/// An image that is drawn to.
struct Attachment {
    view: vk::ImageView,
    layout: vk::ImageLayout,
    extent: [u32; 2],
}

impl Overlay {
    /// Makes the pipeline for targets of a format: [`crate::Surface::format`], or an image's. Slow: the driver compiles the shaders.
    #[expect(clippy::cast_possible_truncation, reason = "a vertex has a few bytes")]
    pub fn new(device: &Arc<Device>, shaders: &OverlayShaders<'_>, format: vk::Format) -> Result<Overlay> {
        if !device.capabilities().graphics {
            return Err(Error::FormatUnsupported {
                name: "overlay".to_owned(),
                format,
                usage: "a target of triangles: the queue only computes".to_owned(),
            });
        }
        let slot = DescriptorSlot { set: 0, binding: 0, ty: vk::DescriptorType::COMBINED_IMAGE_SAMPLER, count: 1 };
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let layout = PipelineLayout::new(device, &[slot], size_of::<[f32; 2]>() as u32, stages)?;
        let pipeline = pipeline(device, &layout, shaders, format)?;
        device.name(pipeline, "overlay");
        Ok(Overlay {
            device: device.clone(),
            pipeline,
            layout,
            textures: HashMap::new(),
            uploads: Vec::new(),
            frames: Vec::new(),
        })
    }

    /// Makes a texture, or changes a rectangle of one. The texels are copied by the next drawing.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the bytes do not fill the rectangle or it lies outside the texture; any error of the driver.
    pub fn set_texture(&mut self, id: u64, patch: &TexturePatch<'_>) -> Result<()> {
        let [width, height] = patch.size;
        let size = u64::from(width) * u64::from(height) * 4;
        let wrong = |limit| Err(Error::TooLarge { name: format!("texture {id}"), size, limit });
        if size == 0 || size != patch.rgba.len() as u64 {
            return wrong(patch.rgba.len() as u64);
        }
        let image = match (patch.position, self.textures.get(&id)) {
            (Some([x, y]), Some(texture)) => {
                let [across, down, _] = texture.image.info().extent;
                if u64::from(x) + u64::from(width) > across.into() || u64::from(y) + u64::from(height) > down.into() {
                    return wrong(u64::from(across) * u64::from(down) * 4);
                }
                texture.image.clone()
            }
            (Some(_), None) => return wrong(0),
            (None, _) => self.make_texture(id, patch.size, patch.linear)?,
        };
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_SRC, location: Location::Upload };
        let staging = Buffer::new(&self.device, "overlay texels", &info, Backing::Own)?;
        staging.write(0, patch.rgba)?;
        let (position, whole) = (patch.position.unwrap_or_default(), patch.position.is_none());
        self.uploads.push(Upload { image, staging, position, size: patch.size, whole });
        Ok(())
    }

    /// Forgets a texture. Pictures drawn with it stay.
    pub fn free_texture(&mut self, id: u64) {
        self.textures.remove(&id);
    }

    fn make_texture(&mut self, id: u64, [width, height]: [u32; 2], linear: bool) -> Result<Arc<Image>> {
        let info = ImageInfo {
            format: vk::Format::R8G8B8A8_UNORM,
            volume: false,
            extent: [width, height, 1],
            mips: 1,
            layers: 1,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        };
        let image = Arc::new(Image::new(&self.device, &format!("overlay texture {id}"), &info, Backing::Own)?);
        let view = Arc::new(ImageView::new(&self.device, &image, &ViewInfo::FLAT)?);
        let sampler = Arc::new(Sampler::new(&self.device, Sampling { linear, repeat: false })?);
        let elements = [vec![Resource::SampledImage(view, sampler)]];
        let descriptors = Descriptors::with_layout(&self.device, "overlay", &self.layout, &elements)?;
        self.textures.insert(id, Texture { image: image.clone(), descriptors });
        Ok(image)
    }

    /// Records the drawing over the picture in an acquired image. `frame` is the number of the frame in flight. Gives the number of meshes drawn.
    ///
    /// # Errors
    /// [`Error::InUse`] while the device has not finished the last drawing under the same number; any error of the driver.
    pub fn draw_on(
        &mut self,
        recording: &mut Recording<'_>,
        acquired: &mut AcquiredImage<'_>,
        frame: usize,
        content: &OverlayFrame<'_>,
    ) -> Result<u32> {
        let extent = acquired.extent();
        self.upload(recording);
        let Some(view) = acquired.attach(recording) else { return Ok(0) };
        let layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        self.draw(recording, &Attachment { view, layout, extent }, frame, content)
    }

    /// Records the drawing over an image in `GENERAL` that was made with `COLOR_ATTACHMENT`, through a view of one mip. Everything before
    /// is waited for, and everything after waits. `frame` as for [`Self::draw_on`].
    pub fn draw_into(
        &mut self,
        recording: &mut Recording<'_>,
        target: &ImageView,
        frame: usize,
        content: &OverlayFrame<'_>,
    ) -> Result<u32> {
        self.upload(recording);
        let [width, height, _] = target.image().info().extent;
        recording.barrier(&Barrier::full());
        let attachment = Attachment { view: target.raw, layout: vk::ImageLayout::GENERAL, extent: [width, height] };
        let drawn = self.draw(recording, &attachment, frame, content);
        recording.barrier(&Barrier::full());
        drawn
    }

    /// Copies new texels into their textures.
    fn upload(&mut self, recording: &mut Recording<'_>) {
        let transfer = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
        let sampled = (vk::PipelineStageFlags2::FRAGMENT_SHADER, vk::AccessFlags2::SHADER_SAMPLED_READ);
        for upload in self.uploads.drain(..) {
            let before = if upload.whole {
                Barrier::default().activate(&upload.image, sampled, transfer)
            } else {
                Barrier::default().memory((sampled.0 | transfer.0, transfer.1), transfer)
            };
            recording.barrier(&before);
            let ([x, y], [width, height]) = (upload.position, upload.size);
            recording.copy_buffer_to_texels((&upload.staging, 0), &upload.image, 0, [x, y, 0], [width, height, 1]);
            recording.barrier(&Barrier::default().memory(transfer, sampled));
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "an overlay has far fewer than 2³¹ vertices and indices")]
    fn draw(
        &mut self,
        recording: &mut Recording<'_>,
        target: &Attachment,
        frame: usize,
        content: &OverlayFrame<'_>,
    ) -> Result<u32> {
        let Overlay { device, pipeline, layout, textures, frames, .. } = self;
        let scale = content.pixels_per_point;
        let drawable = |mesh: &&OverlayMesh<'_>| {
            textures.contains_key(&mesh.texture)
                && scissor(mesh.clip, scale, target.extent).is_some()
                && mesh.indices.len() >= 3
                && mesh.indices.iter().all(|index| (*index as usize) < mesh.vertices.len())
        };
        let vertices: u64 = content.meshes.iter().filter(drawable).map(|mesh| mesh.vertices.len() as u64).sum();
        let indices: u64 = content.meshes.iter().filter(drawable).map(|mesh| mesh.indices.len() as u64).sum();
        if indices == 0 || !(scale > 0.0 && scale.is_finite()) {
            return Ok(0);
        }
        if frames.len() <= frame {
            frames.resize_with(frame + 1, FrameBuffers::default);
        }
        let (vertex_bytes, index_bytes) = (size_of::<OverlayVertex>() as u64, size_of::<u32>() as u64);
        let FrameBuffers { vertices: vertex_buffer, indices: index_buffer } = &mut frames[frame];
        let vertex_usage = vk::BufferUsageFlags::VERTEX_BUFFER;
        let vertex_buffer = grown(device, vertex_buffer, vertices * vertex_bytes, vertex_usage, "overlay vertices")?;
        let index_usage = vk::BufferUsageFlags::INDEX_BUFFER;
        let index_buffer = grown(device, index_buffer, indices * index_bytes, index_usage, "overlay indices")?;

        let (mut vertex_end, mut index_end) = (0, 0);
        for mesh in content.meshes.iter().filter(drawable) {
            let (vertices, indices): (&[u8], &[u8]) =
                (bytemuck::cast_slice(mesh.vertices), bytemuck::cast_slice(mesh.indices));
            vertex_buffer.write(vertex_end, vertices)?;
            index_buffer.write(index_end, indices)?;
            vertex_end += vertices.len() as u64;
            index_end += indices.len() as u64;
        }

        let points = target.extent.map(|pixels| pixels as f32 / scale);
        recording.begin_drawing(target.view, target.layout, target.extent);
        recording.bind_drawing(*pipeline, layout, vertex_buffer, index_buffer, bytemuck::bytes_of(&points));
        let (mut first_vertex, mut first_index, mut drawn) = (0_u64, 0_u64, 0);
        for mesh in content.meshes.iter().filter(drawable) {
            let (Some(texture), Some(scissor)) =
                (textures.get(&mesh.texture), scissor(mesh.clip, scale, target.extent))
            else {
                continue;
            };
            let triangles = mesh.indices.len() as u32 / 3 * 3;
            recording.draw_triangles(layout, &texture.descriptors, scissor, triangles, first_index, first_vertex);
            first_vertex += mesh.vertices.len() as u64;
            first_index += mesh.indices.len() as u64;
            drawn += 1;
        }
        recording.end_drawing();
        Ok(drawn)
    }
}

impl Drop for Overlay {
    fn drop(&mut self) {
        self.device.retire(Dead::Pipeline(self.pipeline));
    }
}

/// The buffer, or a larger one if it is too small. The old one is destroyed when the device has finished with it.
fn grown<'b>(
    device: &Arc<Device>,
    buffer: &'b mut Option<Buffer>,
    bytes: u64,
    usage: vk::BufferUsageFlags,
    name: &str,
) -> Result<&'b Buffer> {
    if buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
        let info = BufferInfo { size: bytes.next_power_of_two().max(1 << 12), usage, location: Location::Upload };
        *buffer = Some(Buffer::new(device, name, &info, Backing::Own)?);
    }
    buffer.as_ref().ok_or_else(|| Error::OutOfMemory { name: name.to_owned(), size: bytes })
}

/// The pixels within a clip rectangle and the picture; `None` when there are none.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "a cast of a float saturates, and sides of pictures are far below 2³¹"
)]
fn scissor([left, top, right, bottom]: [f32; 4], scale: f32, [width, height]: [u32; 2]) -> Option<vk::Rect2D> {
    // The cast takes negative numbers and NaN to 0.
    let pixel = |points: f32, most: u32| ((points * scale).round() as u32).min(most);
    let (x, y) = (pixel(left, width), pixel(top, height));
    let extent =
        vk::Extent2D { width: pixel(right, width).saturating_sub(x), height: pixel(bottom, height).saturating_sub(y) };
    let offset = vk::Offset2D { x: x as i32, y: y as i32 };
    (extent.width > 0 && extent.height > 0).then_some(vk::Rect2D { offset, extent })
}

#[expect(clippy::cast_possible_truncation, reason = "a vertex has a few bytes")]
fn pipeline(
    device: &Arc<Device>,
    layout: &PipelineLayout,
    shaders: &OverlayShaders<'_>,
    format: vk::Format,
) -> Result<vk::Pipeline> {
    let (vertex, fragment) = (
        ShaderModule::new(device, "overlay", shaders.vertex)?,
        ShaderModule::new(device, "overlay", shaders.fragment)?,
    );
    // A target with an sRGB format encodes the shader's output, so the shader decodes first.
    let encodes = matches!(format, vk::Format::R8G8B8A8_SRGB | vk::Format::B8G8R8A8_SRGB);
    let data = u32::from(encodes).to_ne_bytes();
    let entries = [vk::SpecializationMapEntry { constant_id: 0, offset: 0, size: 4 }];
    let specialization = vk::SpecializationInfo::default().map_entries(&entries).data(&data);
    let stage = |stage, module: &ShaderModule| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw).name(c"main")
    };
    let stages = [
        stage(vk::ShaderStageFlags::VERTEX, &vertex),
        stage(vk::ShaderStageFlags::FRAGMENT, &fragment).specialization_info(&specialization),
    ];
    let bindings = [vk::VertexInputBindingDescription {
        binding: 0,
        stride: size_of::<OverlayVertex>() as u32,
        input_rate: vk::VertexInputRate::VERTEX,
    }];
    let attribute =
        |location, format, offset| vk::VertexInputAttributeDescription { location, binding: 0, format, offset };
    let attributes = [
        attribute(0, vk::Format::R32G32_SFLOAT, 0),
        attribute(1, vk::Format::R32G32_SFLOAT, 8),
        attribute(2, vk::Format::R8G8B8A8_UNORM, 16),
    ];
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    // Either winding is a front: interfaces do not care.
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let blends = [vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(true)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .color_blend_op(vk::BlendOp::ADD)
        .src_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_DST_ALPHA)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE)
        .alpha_blend_op(vk::BlendOp::ADD)
        .color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamics = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamics);
    let formats = [format];
    let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
    let create = [vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout.raw)
        .push_next(&mut rendering)];
    // SAFETY: modules, layout and everything `create` points to live until the call returns; the cache is internally synchronised.
    let made = unsafe { device.raw.create_graphics_pipelines(device.pipelines.raw, &create, None) };
    Ok(device.watch(made.map_err(|(_, result)| result).named("vkCreateGraphicsPipelines"))?[0])
}

impl Recording<'_> {
    fn begin_drawing(&mut self, view: vk::ImageView, layout: vk::ImageLayout, [width, height]: [u32; 2]) {
        let attachments = [vk::RenderingAttachmentInfo::default()
            .image_view(view)
            .image_layout(layout)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        let viewport =
            vk::Viewport { width: width as f32, height: height as f32, max_depth: 1.0, ..Default::default() };
        let raw = &self.device().raw;
        // SAFETY: recording; dynamicRendering is on, and the image of the view lives until the submission has finished.
        unsafe {
            raw.cmd_begin_rendering(self.raw(), &info);
            raw.cmd_set_viewport(self.raw(), 0, &[viewport]);
        }
    }

    fn bind_drawing(
        &mut self,
        pipeline: vk::Pipeline,
        layout: &PipelineLayout,
        vertices: &Buffer,
        indices: &Buffer,
        push: &[u8],
    ) {
        self.uses(vertices);
        self.uses(indices);
        let (raw, commands) = (&self.device().raw, self.raw());
        // SAFETY: as above; dropped objects live on until the submission has finished, and the layout has room for the push constants.
        unsafe {
            raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline);
            raw.cmd_bind_vertex_buffers(commands, 0, &[vertices.raw], &[0]);
            raw.cmd_bind_index_buffer(commands, indices.raw, 0, vk::IndexType::UINT32);
            raw.cmd_push_constants(commands, layout.raw, layout.stages, 0, push);
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "an overlay has far fewer than 2³¹ vertices and indices")]
    fn draw_triangles(
        &mut self,
        layout: &PipelineLayout,
        descriptors: &Descriptors,
        scissor: vk::Rect2D,
        indices: u32,
        first_index: u64,
        first_vertex: u64,
    ) {
        let (raw, commands, point) = (&self.device().raw, self.raw(), vk::PipelineBindPoint::GRAPHICS);
        // SAFETY: as above; every index is within the vertices that follow `first_vertex`, which the caller has checked.
        unsafe {
            raw.cmd_bind_descriptor_sets(commands, point, layout.raw, 0, &descriptors.sets, &[]);
            raw.cmd_set_scissor(commands, 0, &[scissor]);
            raw.cmd_draw_indexed(commands, indices, 1, first_index as u32, first_vertex as i32, 0);
        }
    }

    fn end_drawing(&mut self) {
        // SAFETY: recording; a rendering is open.
        unsafe { self.device().raw.cmd_end_rendering(self.raw()) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_rectangle_is_cut_to_the_picture() {
        let rect = |x, y, width, height| {
            Some(vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } })
        };
        assert_eq!(scissor([1.0, 2.0, 3.0, 5.0], 2.0, [100, 100]), rect(2, 4, 4, 6));
        assert_eq!(scissor([-5.0, 0.0, f32::INFINITY, 9.0], 1.0, [20, 8]), rect(0, 0, 20, 8));
        for empty in [[3.0, 0.0, 3.0, 9.0], [5.0, 0.0, 1.0, 9.0], [30.0, 0.0, 40.0, 9.0], [f32::NAN; 4]] {
            assert_eq!(scissor(empty, 1.0, [20, 8]), None, "{empty:?}");
        }
    }
}
