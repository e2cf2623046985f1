//! Makes a plan ready to run: images, buffers, pipelines, descriptor sets. On any thread, while another plan runs.

use std::ffi::CString;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, ComputePipeline, Descriptors, Device, Image, ImageInfo, Location, Resource,
    Sampling, vk,
};
use raxel_graph::checked::{BoundAccess, Dispatch, Interval, Usage};
use raxel_graph::plan::{CopySelector, Plan, SourceUpdates, Step};
use raxel_shader::format::Format;
use raxel_shader::interface::{Binding, BindingKind, Dim};

use super::FRAMES;
use super::counters::CounterReadback;
use super::device::{self, Texture, scope};
use super::digest::{self, Digest};
use super::display::{self, SourceKind, Variant};
use super::error::ExecuteError;
use super::fit;
use super::instrumentation::Instrumentation;
use super::making::Compiling;
use super::physical::{self, Physical};
use super::prints::PrintReadback;
use super::replay::Replay;
use super::rotations::{Rotations, copy_of};
use super::shared::{PictureImage, Shared, lock};
use super::source::{ExternalResource, Sources};

/// Makes plans ready to run. Cheap to clone, and meant for threads other than the executor's.
#[derive(Clone)]
pub struct Builder {
    pub(super) shared: Arc<Shared>,
}

/// Pipelines that wait for their plan to be prepared.
#[derive(Default)]
pub struct Pipelined {
    _held: Vec<Arc<ComputePipeline>>,
}

/// A plan with everything it needs on the device.
pub struct Prepared {
    /// Number of the swap after which it was prepared: it shares resources with the plan that ran then.
    pub(super) swaps_before: u64,
    pub(super) replay: Replay,
    pub(super) resources: Vec<Arc<Physical>>,
    pub(super) passes: Vec<PreparedPass>,
    /// By step; `None` where the step is no barrier.
    pub(super) barriers: Vec<Option<Barrier>>,
    /// Before, between and after the writes of a frame that updates sources.
    pub(super) updates: [Barrier; 3],
    /// The uniform blocks of all passes, a buffer for each frame in flight: the host writes one while the device reads the other.
    pub(super) uniforms: Option<[Arc<Buffer>; FRAMES]>,
    pub(super) display: PreparedDisplay,
    pub(super) instrumentation: Arc<Instrumentation>,
    pub(super) counted: Arc<CounterReadback>,
    pub(super) printed: Arc<PrintReadback>,
}

pub(super) struct PreparedPass {
    pub(super) pipeline: Arc<ComputePipeline>,
    /// For each way the copies it touches can stand, for each frame in flight if it has uniform blocks.
    pub(super) sets: Vec<Descriptors>,
    pub(super) rotations: Rotations,
    pub(super) groups: Groups,
    pub(super) label: CString,
}

pub(super) enum Groups {
    Direct([u32; 3]),
    /// Copies of the argument buffer, age, the selector of the current copy, byte offset.
    Indirect(Vec<Arc<Buffer>>, u32, CopySelector, u64),
}

pub(super) struct PreparedDisplay {
    pub(super) pipeline: Arc<ComputePipeline>,
    /// For each copy of the debug target, without a reference.
    pub(super) sets: Vec<Descriptors>,
    /// The sources of the sets: the debug target for each of its copies, and the picture.
    sources: Vec<Resource>,
    target: Resource,
    pub(super) variant: Variant,
    /// Index of the debug target into the plan's resources.
    pub(super) resource: Option<usize>,
    pub(super) age: u32,
    pub(super) selector: CopySelector,
    pub(super) push: display::Push,
    pub(super) groups: [u32; 3],
    pub(super) picture: Arc<PictureImage>,
    pub(super) before: Barrier,
    pub(super) after: Barrier,
}

impl Prepared {
    /// The plan.
    pub fn plan(&self) -> &Arc<Plan> {
        self.replay.plan()
    }
}

impl PreparedDisplay {
    /// The sets with a reference.
    pub(super) fn sets_with(
        &self,
        device: &Arc<Device>,
        reference: &Arc<Buffer>,
    ) -> Result<Vec<Descriptors>, ExecuteError> {
        display_sets(device, &self.pipeline, &self.sources, &self.target, reference)
    }
}

impl Builder {
    /// The device.
    pub fn device(&self) -> &Arc<Device> {
        &self.shared.device
    }

    /// Puts bytes into a storage buffer on the device, to be supplied as a source. Waits for the copy.
    pub fn upload_buffer(&self, bytes: &[u8], name: &str) -> Result<Arc<Buffer>, ExecuteError> {
        raxel_gpu::upload(&self.shared.device, name, bytes, self.shared.watchdog())
            .map(Arc::new)
            .map_err(|error| self.shared.error(error))
    }

    /// Puts texels into an image on the device, to be supplied as a source: every mip, x first, then y, then z, without padding. Waits
    /// for the copies.
    pub fn upload_image(&self, name: &str, texture: Texture, mips: &[&[u8]]) -> Result<Arc<Image>, ExecuteError> {
        device::upload_image(&self.shared.device, name, texture, mips, self.shared.watchdog())
            .map_err(|error| self.shared.error(error))
    }

    /// A source of this device: a buffer, an image with its format, or both.
    pub fn source(
        &self,
        name: &str,
        buffer: Option<Arc<Buffer>>,
        image: Option<(Arc<Image>, Format)>,
    ) -> Arc<ExternalResource> {
        ExternalResource::new(name, buffer, image, self.shared.writes.clone())
    }

    /// The pass whose pipeline the driver has worked on longest, if it has for a second.
    pub fn compiling(&self) -> Option<Compiling> {
        self.shared.pipelines.compiling()
    }

    /// Has the driver compile a plan's shaders, several at a time. They are there for [`Self::prepare`] as long as the result is held; a
    /// failed pipeline is its error.
    pub fn compile_pipelines(&self, plan: &Plan) -> Pipelined {
        if tracing::enabled!(tracing::Level::DEBUG) {
            self.shared.pipelines.tell_reused(plan);
        }
        Pipelined { _held: self.shared.pipelines.of_plan(&self.shared.device, plan) }
    }

    /// Makes everything that a plan needs. A resource that the running plan and the new one describe alike is shared, contents included;
    /// the running plan is not disturbed.
    #[allow(clippy::needless_pass_by_value, reason = "the result keeps it")]
    pub fn prepare(&self, plan: Arc<Plan>, sources: &Sources) -> Result<Prepared, ExecuteError> {
        let device = &self.shared.device;
        let (running, picture, swaps_before) = {
            let running = lock(&self.shared.running);
            (running.resources.clone(), running.picture.clone(), running.serial)
        };
        let resources = physical::make(device, &plan, &running, sources)?;
        let _pipelined = self.shared.pipelines.of_plan(device, &plan);
        let picture = self.picture(&plan, picture)?;
        let (variant, mut push) = display::describe(&plan);
        let shown = resources.iter().zip(&plan.resources).find(|(_, r)| r.resource == plan.present.resource);
        if let Some(buffer) = shown.and_then(|(physical, _)| physical.buffer(0)) {
            push = push.with_bytes(buffer.size());
        }
        let replay = Replay::new(&plan, display_key(&plan, &push, 0));
        let uniforms = match replay.uniform_bytes() {
            0 => None,
            bytes => {
                let info =
                    BufferInfo { size: bytes, usage: vk::BufferUsageFlags::UNIFORM_BUFFER, location: Location::Upload };
                let buffer = |name| Ok::<_, ExecuteError>(Arc::new(Buffer::new(device, name, &info, Backing::Own)?));
                Some([buffer("uniform blocks, even frames")?, buffer("uniform blocks, odd frames")?])
            }
        };
        let printed = Arc::new(PrintReadback::new(device, &plan)?);
        let passes = (0..plan.passes.len())
            .map(|index| self.pass(&plan, index, &replay, &resources, (uniforms.as_ref(), &printed)))
            .collect::<Result<_, _>>()?;
        let display = self.display(&plan, &resources, variant, push, picture)?;
        Ok(Prepared {
            swaps_before,
            barriers: plan.steps.iter().map(|step| barrier(step, &resources)).collect(),
            updates: [plan.updates.before, SourceUpdates::BETWEEN, plan.updates.after]
                .map(|dependency| Barrier::default().memory(scope(dependency.src), scope(dependency.dst))),
            instrumentation: Arc::new(Instrumentation::new(device, &self.shared.options, &plan)?),
            counted: Arc::new(CounterReadback::new(device, &plan)?),
            printed,
            replay,
            resources,
            passes,
            uniforms,
            display,
        })
    }

    fn picture(&self, plan: &Plan, running: Option<Arc<PictureImage>>) -> Result<Arc<PictureImage>, ExecuteError> {
        let info = ImageInfo {
            format: vk::Format::R8G8B8A8_UNORM,
            volume: false,
            extent: [plan.output[0], plan.output[1], 1],
            mips: 1,
            layers: 1,
            usage: vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST,
        };
        Ok(match running {
            Some(picture) if *picture.image.info() == info => picture,
            _ => Arc::new(PictureImage {
                image: Arc::new(Image::new(&self.shared.device, "picture", &info, Backing::Own)?),
                initialized: AtomicBool::new(false),
            }),
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes and bindings in 32 bits")]
    fn pass(
        &self,
        plan: &Plan,
        index: usize,
        replay: &Replay,
        resources: &[Arc<Physical>],
        (uniforms, printed): (Option<&[Arc<Buffer>; FRAMES]>, &PrintReadback),
    ) -> Result<PreparedPass, ExecuteError> {
        let planned = &plan.passes[index];
        let pass = plan.graph.pass(planned.pass);
        let physical = |access: &BoundAccess| {
            plan.resources.iter().position(|r| r.resource == access.resource).map(|i| &resources[i])
        };
        let pipeline = self.shared.pipelines.of_pass(&self.shared.device, pass, &planned.specialization)?;
        // Descriptors name physical copies, so there is a set for every way the copies it touches can stand.
        let step = plan.steps.iter().position(|step| *step == Step::Dispatch { pass: index as u32 }).unwrap_or(0);
        let selector = |access: &BoundAccess| plan.selector(step, access.resource);
        let selectors =
            pass.accesses.iter().filter_map(|a| Some((selector(a), u64::from(physical(a)?.count().max(1)))));
        let rotations = Rotations::of(selectors);
        let frames = if pass.uniforms.is_empty() { 1 } else { FRAMES };
        let places = replay.uniform_places(index);
        let mut sets = Vec::new();
        for way in 0..rotations.count() {
            for slot in 0..frames {
                let mut elements = Vec::with_capacity(pass.shader.interface.bindings.len());
                for (b, binding) in pass.shader.interface.bindings.iter().enumerate() {
                    let mut bound = Vec::new();
                    for access in pass.accesses.iter().filter(|access| access.binding == Some(b as u32)) {
                        if let Some(physical) = physical(access) {
                            let rotation = rotations.rotation(way, selector(access));
                            bound.extend(self.element(physical, access, binding, rotation)?);
                        }
                    }
                    if let (Some(place), Some(buffers)) = (places.iter().find(|p| p.binding == b as u32), uniforms) {
                        bound.push(Resource::Buffer {
                            buffer: buffers[slot].clone(),
                            offset: place.offset,
                            size: place.size,
                        });
                    }
                    elements.push(bound);
                }
                elements.extend(printed.binding(index).map(|resource| vec![resource]));
                sets.push(Descriptors::new(&self.shared.device, &pass.name, &pipeline, &elements)?);
            }
        }
        let groups = match (&pass.dispatch, planned.groups) {
            (Dispatch::Indirect { buffer, offset }, _) => {
                let of = |access: &&BoundAccess| access.usage == Usage::IndirectArguments && access.resource == *buffer;
                let arguments = pass.accesses.iter().find(of);
                let physical = arguments.and_then(physical);
                let copies = physical.map(|p| (0..p.count()).filter_map(|c| p.buffer(c as usize).cloned()).collect());
                let selector = arguments.map_or(CopySelector::Frame, selector);
                Groups::Indirect(
                    copies.unwrap_or_default(),
                    arguments.map_or(0, |access| access.age),
                    selector,
                    *offset,
                )
            }
            (_, groups) => Groups::Direct(groups.unwrap_or([0; 3])),
        };
        let label = CString::new(pass.name.clone()).unwrap_or_default();
        Ok(PreparedPass { pipeline, sets, rotations, groups, label })
    }

    /// The resource that one access puts into its binding.
    fn element(
        &self,
        physical: &Physical,
        access: &BoundAccess,
        binding: &Binding,
        rotation: u64,
    ) -> Result<Option<Resource>, ExecuteError> {
        let copy = copy_of(rotation, access.age, physical.count());
        if let Some(buffer) = physical.buffer(copy) {
            return Ok(Some(Resource::whole(buffer)));
        }
        let Some(image) = physical.image(copy) else { return Ok(None) };
        let device = &self.shared.device;
        match &binding.kind {
            BindingKind::StorageImage { dim, arrayed, .. } => {
                // A storage image shows its first mip only.
                let view = physical::view(
                    device,
                    image,
                    view_type(*dim, *arrayed),
                    Interval::one(access.mips.first),
                    access.layers,
                )?;
                Ok(Some(Resource::StorageImage(view)))
            }
            BindingKind::SampledImage { dim, arrayed, .. } => {
                let view = physical::view(device, image, view_type(*dim, *arrayed), access.mips, access.layers)?;
                let sampling = access
                    .sampler
                    .map_or_else(Sampling::default, |of| Sampling { linear: of.linear, repeat: of.repeat });
                let filtered = physical.format().filter(|_| sampling.linear);
                if let Some(error) = filtered.and_then(|format| fit::linear(device, &physical.name, format)) {
                    return Err(error);
                }
                Ok(Some(Resource::SampledImage(view, self.shared.pipelines.sampler(device, sampling)?)))
            }
            BindingKind::StorageBuffer(_) | BindingKind::UniformBuffer(_) | BindingKind::Unsupported(_) => Ok(None),
        }
    }

    fn display(
        &self,
        plan: &Plan,
        resources: &[Arc<Physical>],
        variant: Variant,
        push: display::Push,
        picture: Arc<PictureImage>,
    ) -> Result<PreparedDisplay, ExecuteError> {
        let device = &self.shared.device;
        let pipeline = self.shared.pipelines.display(device, variant)?;
        let shown = plan.present;
        let physical = plan
            .resources
            .iter()
            .position(|r| r.resource == shown.resource)
            .map(|i| &resources[i])
            .ok_or_else(|| ExecuteError::NotLive { resource: plan.graph.resource(shown.resource).name.clone() })?;
        let target =
            physical::view(device, &picture.image, vk::ImageViewType::TYPE_2D, Interval::one(0), Interval::one(0))?;
        let sources = (0..physical.count() as usize)
            .map(|copy| {
                Ok(match (physical.image(copy), physical.buffer(copy)) {
                    (Some(image), _) => {
                        let ty = match variant.source {
                            SourceKind::Volume => vk::ImageViewType::TYPE_3D,
                            _ => vk::ImageViewType::TYPE_2D_ARRAY,
                        };
                        let view = physical::view(device, image, ty, Interval::one(shown.mip), Interval::ALL)?;
                        Resource::SampledImage(view, self.shared.pipelines.sampler(device, Sampling::default())?)
                    }
                    (None, Some(buffer)) => Resource::whole(buffer),
                    (None, None) => return Err(ExecuteError::NotLive { resource: physical.name.clone() }),
                })
            })
            .collect::<Result<Vec<_>, ExecuteError>>()?;
        let target = Resource::StorageImage(target);
        // The shader has a place for a reference, and never reads this one.
        let info = BufferInfo { size: 16, usage: vk::BufferUsageFlags::STORAGE_BUFFER, location: Location::Device };
        let none = Arc::new(Buffer::new(device, "no picture to compare with", &info, Backing::Own)?);
        let sets = display_sets(device, &pipeline, &sources, &target, &none)?;
        let (compute, transfer) = (vk::PipelineStageFlags2::COMPUTE_SHADER, vk::PipelineStageFlags2::ALL_TRANSFER);
        let store = vk::AccessFlags2::SHADER_STORAGE_WRITE;
        Ok(PreparedDisplay {
            pipeline,
            sets,
            sources,
            target,
            variant,
            resource: plan.resources.iter().position(|planned| planned.resource == shown.resource),
            age: shown.age,
            selector: plan
                .selector(plan.steps.iter().position(|step| *step == Step::Present).unwrap_or(0), shown.resource),
            push,
            groups: [plan.output[0].div_ceil(display::GROUP), plan.output[1].div_ceil(display::GROUP), 1],
            picture,
            // The last picture may still be copied to the window.
            before: Barrier::default().memory((transfer | compute, store), (compute, store)),
            after: Barrier::default().memory((compute, store), (transfer, vk::AccessFlags2::TRANSFER_READ)),
        })
    }
}

/// The descriptor sets of the display shader, one for each copy of its inputs.
pub(super) fn display_sets(
    device: &Arc<Device>,
    pipeline: &ComputePipeline,
    sources: &[Resource],
    target: &Resource,
    reference: &Arc<Buffer>,
) -> Result<Vec<Descriptors>, ExecuteError> {
    let reference = Resource::whole(reference);
    let set = |source: &Resource| {
        let elements = [vec![source.clone()], vec![target.clone()], vec![reference.clone()]];
        Ok(Descriptors::new(device, "display", pipeline, &elements)?)
    };
    sources.iter().map(set).collect()
}

/// A digest of the way of showing a plan's debug target. `captures` counts the requested copies: each of them shows the target again.
pub(super) fn display_key(plan: &Plan, push: &display::Push, captures: u64) -> Digest {
    let shown = [digest::of_bytes(0, bytemuck::bytes_of(push)), digest::of_value(0, &plan.present)];
    digest::of(captures, &shown)
}

fn view_type(dim: Dim, arrayed: bool) -> vk::ImageViewType {
    match (dim, arrayed) {
        (Dim::D1, false) => vk::ImageViewType::TYPE_1D,
        (Dim::D1, true) => vk::ImageViewType::TYPE_1D_ARRAY,
        (Dim::D2, false) => vk::ImageViewType::TYPE_2D,
        (Dim::D2, true) => vk::ImageViewType::TYPE_2D_ARRAY,
        (Dim::D3, _) => vk::ImageViewType::TYPE_3D,
        (Dim::Cube, false) => vk::ImageViewType::CUBE,
        (Dim::Cube, true) => vk::ImageViewType::CUBE_ARRAY,
    }
}

fn barrier(step: &Step, resources: &[Arc<Physical>]) -> Option<Barrier> {
    let Step::Barrier(planned) = step else { return None };
    let mut barrier = Barrier::default();
    if let Some(dependency) = &planned.memory {
        barrier = barrier.memory(scope(dependency.src), scope(dependency.dst));
    }
    for activation in &planned.activate {
        if let Some(image) = resources[activation.resource as usize].image(0) {
            let dependency = &activation.dependency;
            barrier = barrier.activate(image, scope(dependency.src), scope(dependency.dst));
        }
    }
    Some(barrier)
}
