//! The tracer of one layout on a device, and worlds for it.

use std::fmt;
use std::sync::Arc;

use raxel_diagnostics::{FileError, Files, SourceMap};
use raxel_execute::{Texture, upload_image, watched};
use raxel_gpu::{
    Buffer, ComputePipeline, DescriptorSlot, Device, ImageView, PipelineInfo, Resource, Sampler, Sampling, ViewInfo,
    upload, vk,
};
use raxel_layouts::{Encoded, EncodedImage, Layout};
use raxel_runtime::sources::{VOXEL_FORMAT, layout_limits};
use raxel_shader::interface::BindingKind;
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};
use raxel_world::World;

use super::error::RayError;
use super::masks;
use super::stream::PATIENCE;
use super::stream::Pace;

/// How hits are found: a layout, and a marcher of `<raxel/rivals/march.glsl>` over it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Method {
    /// How the world is stored.
    pub layout: Layout,
    /// The marcher, e.g. `dda` for `RX_MARCH_DDA`; `None` is the layout's own exact tracer.
    pub marcher: Option<String>,
}

impl Method {
    /// The exact tracer of a layout.
    pub fn of(layout: Layout) -> Self {
        Self { layout, marcher: None }
    }

    fn defines(&self) -> Vec<(String, String)> {
        let layout = format!("RX_LAYOUT_{}", self.layout.name().to_uppercase());
        let marcher = self.marcher.iter().map(|marcher| format!("RX_MARCH_{}", marcher.to_uppercase()));
        marcher.chain([layout]).rev().map(|name| (name, "1".to_owned())).collect()
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.marcher {
            Some(marcher) => write!(f, "{}:{marcher}", self.layout.name()),
            None => f.write_str(self.layout.name()),
        }
    }
}

/// A method, compiled.
pub struct Tracer {
    pub(super) device: Arc<Device>,
    pub(super) shader: Arc<Shader>,
    pub(super) pipeline: ComputePipeline,
    pub(super) pace: Pace,
    /// The table of the marcher `raymask`.
    masks: Option<Resource>,
    method: Method,
}

/// A world in a layout on the device.
pub struct DeviceWorld {
    pub(super) buffer: Resource,
    pub(super) image: Option<Resource>,
    /// Bytes on the device.
    pub bytes: u64,
    /// Worlds for other bindings of the shader, by their names.
    others: Vec<(String, DeviceWorld)>,
}

impl DeviceWorld {
    /// A world that is in a buffer already, in a layout without an image. The tracer reads the contents at the time of the dispatch.
    pub fn of_buffer(buffer: &Arc<Buffer>) -> Self {
        let bytes = buffer.size();
        Self { buffer: Resource::whole(buffer), image: None, bytes, others: Vec::new() }
    }

    /// With another world for a shader that has `<raxel/world/BINDING.glsl>`.
    #[must_use]
    pub fn with(mut self, binding: &str, other: DeviceWorld) -> Self {
        self.others.push((binding.to_owned(), other));
        self
    }

    /// The resource of this name, if this world is bound as `binding`.
    fn resource(&self, binding: &str, name: &str) -> Option<&Resource> {
        match name.strip_prefix(binding)? {
            "" => Some(&self.buffer),
            "_voxels" => self.image.as_ref(),
            _ => None,
        }
    }
}

/// The bindings that a shader may have.
const BINDINGS: [&str; 6] = ["world", "world_voxels", "Rays", "Hits", "instances", masks::BINDING];

/// The path of the shader for the compiler: in the project, although its text comes from the binary.
const PATH: &str = "shaders/trace_rays.comp";

/// A project's files with the shader among them.
struct WithShader(Arc<dyn Files>);

impl Files for WithShader {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        match path {
            PATH => Ok(Arc::from(include_bytes!("trace_rays.comp").as_slice())),
            masks::PATH => raxel_shipped::file(path).map_or_else(|| self.0.read(path), |bytes| Ok(Arc::from(bytes))),
            path => self.0.read(path),
        }
    }
}

impl Tracer {
    /// Compiles a method. `files` are those of a project, whose `shaders/include` may override the library; a
    /// [`raxel_diagnostics::MemoryFiles`] without files takes the library as it is.
    pub fn new(device: &Arc<Device>, files: Arc<dyn Files>, method: &Method) -> Result<Self, RayError> {
        Self::among(device, files, method, 1)
    }

    /// The same, where `left` tracers are still to be made, this one included: raxel tells how many, if the driver takes long.
    pub fn among(device: &Arc<Device>, files: Arc<dyn Files>, method: &Method, left: usize) -> Result<Self, RayError> {
        let tracer = Self::made(device, files, method, (&[], left))?;
        let mut names = tracer.shader.interface.bindings.iter().map(|binding| binding.name.as_str());
        match names.find(|name| !BINDINGS.contains(name)) {
            Some(name) => Err(RayError::Binding { name: name.to_owned(), why: "no list of rays comes with" }),
            None => Ok(tracer),
        }
    }

    /// The same with more defines, such as `RX_LAYOUT_TREE64_pine` for a project whose marcher has `<raxel/world/pine.glsl>`. Further
    /// bindings of the shader come with [`DeviceWorld::with`].
    pub fn with_defines(
        device: &Arc<Device>,
        files: Arc<dyn Files>,
        method: &Method,
        defines: &[&str],
    ) -> Result<Self, RayError> {
        Self::made(device, files, method, (defines, 1))
    }

    fn made(
        device: &Arc<Device>,
        files: Arc<dyn Files>,
        method: &Method,
        (defines, left): (&[&str], usize),
    ) -> Result<Self, RayError> {
        let files: Arc<dyn Files> = Arc::new(WithShader(files));
        // If subgroups are neither 32 nor 64 wide, tiles of rays are traced by the same code as single ones, slower.
        let tiles = matches!(method.marcher.as_deref(), Some("packet" | "parallel" | "parallel_any"));
        let slow = (tiles && !device.capabilities().traces_packets()).then_some("RX_TILE_BY_SHARED_MEMORY");
        let more = defines.iter().copied().chain(slow).map(|name| (name.to_owned(), "1".to_owned()));
        let defines = method.defines().into_iter().chain(more).collect();
        let request = Request { path: PATH.into(), entry: "main".into(), defines };
        let named = Named { pipeline: &method.to_string(), told: &format!("tracer `{method}`"), left };
        let (shader, pipeline) = compile(device, &files, &request, named, tiles.then_some(32))?;
        let names = || shader.interface.bindings.iter().map(|binding| binding.name.as_str());
        let wants_masks = names().any(|name| name == masks::BINDING);
        let masks = if wants_masks { Some(masks::bake(device, &files, left)?) } else { None };
        Ok(Self { device: device.clone(), shader, pipeline, pace: Pace::default(), masks, method: method.clone() })
    }

    /// Its method.
    pub fn method(&self) -> &Method {
        &self.method
    }

    /// Encodes a world and brings it to the device. An error has the size and the limit, before anything big is allocated.
    pub fn upload(&self, world: &World) -> Result<DeviceWorld, RayError> {
        self.upload_as(self.method.layout, world)
    }

    /// The same in any layout, for another binding of the shader.
    pub fn upload_as(&self, layout: Layout, world: &World) -> Result<DeviceWorld, RayError> {
        let encoded = layout.encode(world, layout_limits(&self.device))?;
        self.bring(layout, world, &encoded)
    }

    /// The same as a copy that shaders may write.
    pub fn upload_writable(&self, world: &World) -> Result<DeviceWorld, RayError> {
        let layout = self.method.layout;
        let encoded = layout.encode_writable(world, layout_limits(&self.device))?;
        self.bring(layout, world, &encoded)
    }

    /// Brings words to the device, for another binding of the shader.
    pub fn upload_words(&self, name: &str, words: &[u32]) -> Result<DeviceWorld, RayError> {
        let buffer = upload(&self.device, name, bytemuck::cast_slice(words), PATIENCE)?;
        Ok(DeviceWorld::of_buffer(&Arc::new(buffer)))
    }

    fn bring(&self, layout: Layout, world: &World, encoded: &Encoded) -> Result<DeviceWorld, RayError> {
        let limits = layout_limits(&self.device);
        let voxels = layout.encode_image(world, limits)?;
        let words = bytemuck::cast_slice(&encoded.words);
        let buffer = Arc::new(upload(&self.device, "world", words, PATIENCE)?);
        let bytes = buffer.size();
        let image_bytes = voxels.as_ref().map_or(0, EncodedImage::bytes);
        let image = voxels.map(|voxels| self.image(&voxels)).transpose()?;
        Ok(DeviceWorld { buffer: Resource::whole(&buffer), image, bytes: bytes + image_bytes, others: Vec::new() })
    }

    #[expect(clippy::cast_possible_truncation, reason = "an image has 32 mips at most")]
    fn image(&self, voxels: &EncodedImage) -> Result<Resource, RayError> {
        let mips: Vec<&[u8]> = voxels.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
        let texture = Texture { format: VOXEL_FORMAT, extent: voxels.size, volume: true };
        let image = upload_image(&self.device, "world voxels", texture, &mips, PATIENCE)?;
        let info = ViewInfo { ty: vk::ImageViewType::TYPE_3D, mips: mips.len() as u32, ..ViewInfo::FLAT };
        let view = Arc::new(ImageView::new(&self.device, &image, &info)?);
        Ok(Resource::SampledImage(view, Arc::new(Sampler::new(&self.device, Sampling::default())?)))
    }

    /// The resources of the shader's bindings, in order.
    pub(super) fn resources(
        &self,
        world: &DeviceWorld,
        rays: &Resource,
        hits: &Resource,
    ) -> Result<Vec<Vec<Resource>>, RayError> {
        let of = |name: &str| match name {
            "Rays" => Some(rays),
            "Hits" => Some(hits),
            masks::BINDING => self.masks.as_ref(),
            name => world
                .resource("world", name)
                .or_else(|| world.others.iter().find_map(|(binding, other)| other.resource(binding, name))),
        };
        self.shader
            .interface
            .bindings
            .iter()
            .map(|binding| match of(&binding.name) {
                Some(resource) => Ok(vec![resource.clone()]),
                None => Err(RayError::Binding { name: binding.name.clone(), why: "the world in this layout has not" }),
            })
            .collect()
    }
}

/// The names of a pipeline that is being made.
#[derive(Clone, Copy)]
pub(super) struct Named<'a> {
    /// As errors say it.
    pub pipeline: &'a str,
    /// As it is told if the driver takes long.
    pub told: &'a str,
    /// How many pipelines are still to be made, this one included.
    pub left: usize,
}

/// A shader and its pipeline, with its name and the number of those that are still to be made.
pub(super) fn compile(
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
    request: &Request,
    named: Named<'_>,
    subgroup_size: Option<u32>,
) -> Result<(Arc<Shader>, ComputePipeline), RayError> {
    let mut texts = SourceMap::default();
    let (shader, _warnings) = Compiler::new(files.clone())
        .shader(request, &mut texts)
        .map_err(|diagnostics| RayError::Shader { diagnostics, texts })?;
    let slots: Vec<DescriptorSlot> = shader
        .interface
        .bindings
        .iter()
        .map(|binding| {
            let ty = match &binding.kind {
                BindingKind::StorageBuffer(_) => vk::DescriptorType::STORAGE_BUFFER,
                BindingKind::SampledImage { .. } => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
                BindingKind::StorageImage { .. } => vk::DescriptorType::STORAGE_IMAGE,
                BindingKind::UniformBuffer(_) | BindingKind::Unsupported(_) => {
                    return Err(RayError::Binding {
                        name: binding.name.clone(),
                        why: "is of no kind that a world has",
                    });
                }
            };
            Ok(DescriptorSlot { set: binding.set, binding: binding.binding, ty, count: binding.count })
        })
        .collect::<Result<_, _>>()?;
    let push_bytes = shader.interface.push.as_ref().map_or(0, |push| push.size);
    let info = PipelineInfo {
        spirv: &shader.spirv,
        entry: "main",
        slots: &slots,
        push_bytes,
        specialization: &[],
        subgroup_size,
    };
    let pipeline = watched(named.told, named.left, || ComputePipeline::new(device, named.pipeline, &info))?;
    Ok((shader, pipeline))
}
