//! Small pictures of targets as passes leave them. Each is made right after its pass, by the shader that shows the debug target, and copied to
//! the host. A frame makes a few of them: those that have waited longest, and only if their passes have run since. Nothing is made, and nothing
//! exists on the device, before it is asked for.

use std::sync::Arc;

use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, ComputePipeline, Descriptors, Device, Image, ImageInfo, Location, Readback,
    Recording, Resource, Sampling, TimelineValue, vk,
};
use raxel_graph::checked::{Interval, ResourceId, ResourceKind};
use raxel_graph::plan::{CopySelector, Plan, ResourceDesc, Step};

use super::digest::Digest;
use super::display::{self, Push, SourceKind};
use super::error::ExecuteError;
use super::executor::Executor;
use super::physical;
use super::prepare::{Prepared, display_sets};
use super::readback::ReadTicket;
use super::rotations::copy_of;
use super::shared::Shared;

/// Most pixels of a thumbnail along each axis.
const MOST: [u32; 2] = [96, 60];

/// Thumbnails that a frame makes.
const A_FRAME: usize = 2;

/// A target as a pass has left it, small.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thumbnail {
    /// Index of the pass into the plan's passes.
    pub pass: usize,
    /// Index into the accesses of the pass: the one that writes the target.
    pub access: usize,
    /// Pixels along each axis.
    pub size: [u32; 2],
    /// Red, green, blue, alpha, row by row from the top; sRGB-encoded.
    pub rgba: Vec<u8>,
}

/// The maker of thumbnails of the running plan.
pub(super) struct Thumbnails {
    image: Arc<Image>,
    initialized: bool,
    nodes: Vec<Node>,
    on_the_way: Vec<ReadTicket<Thumbnail>>,
}

/// A target that a pass writes.
struct Node {
    pass: usize,
    access: usize,
    /// Index of the target into the plan's resources.
    resource: usize,
    /// Selects its current copy where the pass is.
    selector: CopySelector,
    pipeline: Arc<ComputePipeline>,
    /// For each copy of the target.
    sets: Vec<Descriptors>,
    push: Push,
    size: [u32; 2],
    /// See [`repeats`].
    repeats: bool,
    /// The frame of the newest thumbnail, made or possible, and the digest of that run of the pass.
    made: Option<(u64, Digest)>,
}

/// Thumbnails that the frame that is recorded makes.
pub(super) struct Making<'a> {
    thumbnails: &'a mut Thumbnails,
    /// Indices of their nodes, and the buffer for each.
    chosen: Vec<(usize, Arc<Buffer>)>,
    recorded: Vec<bool>,
}

impl Thumbnails {
    pub(super) fn new(shared: &Shared, running: &Prepared) -> Result<Thumbnails, ExecuteError> {
        let device = &shared.device;
        let info = ImageInfo {
            format: vk::Format::R8G8B8A8_UNORM,
            volume: false,
            extent: [MOST[0], MOST[1], 1],
            mips: 1,
            layers: 1,
            usage: vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC,
        };
        let image = Arc::new(Image::new(device, "thumbnail", &info, Backing::Own)?);
        // The shader has a place for a reference, and never reads this one.
        let info = BufferInfo { size: 16, usage: vk::BufferUsageFlags::STORAGE_BUFFER, location: Location::Device };
        let none = Arc::new(Buffer::new(device, "no picture to compare with", &info, Backing::Own)?);
        let plan = running.plan();
        let mut nodes = Vec::new();
        for (step, kind) in plan.steps.iter().enumerate() {
            let Step::Dispatch { pass } = kind else { continue };
            let pass = *pass as usize;
            for (access, bound) in plan.graph.pass(plan.passes[pass].pass).accesses.iter().enumerate() {
                if bound.access.writes() {
                    let part = (bound.resource, bound.mips.first, bound.layers.first);
                    nodes.extend(Node::new(shared, running, (step, pass, access), part, (&image, &none))?);
                }
            }
        }
        Ok(Thumbnails { image, initialized: false, nodes, on_the_way: Vec::new() })
    }

    /// Chooses the thumbnails of the next frame: of the stale ones, those that have waited longest. `runs` identifies the newest run of
    /// each pass; `None` where every pass runs in every frame.
    pub(super) fn begin(&mut self, device: &Arc<Device>, runs: Option<&[Digest]>) -> Result<Making<'_>, ExecuteError> {
        let is_stale = |node: &Node| match (node.made, runs) {
            (Some((_, made)), Some(runs)) => made != runs[node.pass],
            _ => true,
        };
        let mut waiting: Vec<usize> = (0..self.nodes.len()).filter(|node| is_stale(&self.nodes[*node])).collect();
        waiting.sort_by_key(|node| self.nodes[*node].made.map(|(frame, _)| frame));
        waiting.truncate(A_FRAME);
        let size = u64::from(MOST[0]) * u64::from(MOST[1]) * 4;
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_DST, location: Location::Download };
        let staged = |node| Ok((node, Arc::new(Buffer::new(device, "copy of a thumbnail", &info, Backing::Own)?)));
        let chosen = waiting.into_iter().map(staged).collect::<Result<Vec<_>, ExecuteError>>()?;
        let recorded = vec![false; chosen.len()];
        Ok(Making { thumbnails: self, chosen, recorded })
    }

    /// Those that have arrived since the last call. Of a lost device none do.
    fn take(&mut self) -> Vec<Thumbnail> {
        let mut arrived = Vec::new();
        self.on_the_way.retain(|ticket| match ticket.poll() {
            Ok(None) => true,
            Ok(Some(thumbnail)) => {
                arrived.push(thumbnail);
                false
            }
            Err(_) => false,
        });
        arrived
    }
}

impl Node {
    /// `None` for a buffer, and for an image that the device cannot sample.
    fn new(
        shared: &Shared,
        running: &Prepared,
        (step, pass, access): (usize, usize, usize),
        (of, mip, layer): (ResourceId, u32, u32),
        (image, none): (&Arc<Image>, &Arc<Buffer>),
    ) -> Result<Option<Node>, ExecuteError> {
        let device = &shared.device;
        let plan = running.plan();
        let Some(resource) = plan.resources.iter().position(|planned| planned.resource == of) else { return Ok(None) };
        let ResourceDesc::Image(desc) = &plan.resources[resource].desc else { return Ok(None) };
        let extent = [desc.extent[0], desc.extent[1]].map(|texels| (texels >> mip).max(1));
        let size = fitting(extent);
        // The first slice of a volume is often empty.
        let layer = if desc.volume { (desc.extent[2] >> mip) / 2 } else { layer };
        let Some((variant, push)) = describe(plan, of, (mip, layer), size) else { return Ok(None) };
        let ty = match variant.source {
            SourceKind::Volume => vk::ImageViewType::TYPE_3D,
            _ => vk::ImageViewType::TYPE_2D_ARRAY,
        };
        let physical = &running.resources[resource];
        let pipeline = shared.pipelines.display(device, variant)?;
        let sampler = shared.pipelines.sampler(device, Sampling::default())?;
        let mut sources = Vec::new();
        for source in (0..physical.count() as usize).filter_map(|copy| physical.image(copy)) {
            if !source.info().usage.contains(vk::ImageUsageFlags::SAMPLED) {
                return Ok(None);
            }
            let view = physical::view(device, source, ty, Interval::one(mip), Interval::ALL)?;
            sources.push(Resource::SampledImage(view, sampler.clone()));
        }
        let target = physical::view(device, image, vk::ImageViewType::TYPE_2D, Interval::one(0), Interval::one(0))?;
        let sets = display_sets(device, &pipeline, &sources, &Resource::StorageImage(target), none)?;
        let selector = plan.selector(step, of);
        let repeats = repeats(plan, pass);
        Ok(Some(Node { pass, access, resource, selector, pipeline, sets, push, size, repeats, made: None }))
    }
}

/// Whether a pass writes targets alone, so that it may run again for what it tells. Buffers that passes write may be acted on, so no pass that
/// writes one runs again. That is so of each pass that runs again with it, too: those that write the same targets.
pub(super) fn repeats(plan: &Plan, pass: usize) -> bool {
    let written = |pass: usize| {
        let accesses = &plan.graph.pass(plan.passes[pass].pass).accesses;
        accesses.iter().filter(|bound| bound.access.writes()).map(|bound| bound.resource)
    };
    let is_target = |of: ResourceId| matches!(plan.graph.resource(of).kind, ResourceKind::Target(_));
    let mut again = vec![pass];
    let mut seen = 0;
    while let Some(&next) = again.get(seen) {
        seen += 1;
        if !written(next).all(is_target) {
            return false;
        }
        let shares = |other: usize| written(other).any(|of| written(next).any(|own| own == of));
        let new: Vec<usize> = (0..plan.passes.len()).filter(|other| !again.contains(other) && shares(*other)).collect();
        again.extend(new);
    }
    true
}

/// How a target is shown in `size` pixels.
fn describe(plan: &Plan, of: ResourceId, (mip, layer): (u32, u32), size: [u32; 2]) -> Option<(display::Variant, Push)> {
    let ResourceKind::Target(target) = &plan.graph.resource(of).kind else { return None };
    let planned = plan.resources.iter().find(|planned| planned.resource == of)?;
    let ResourceDesc::Image(desc) = &planned.desc else { return None };
    Some(display::describe_image(desc, target.display, (mip, layer), size))
}

/// The largest extent of these proportions that a thumbnail can have.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is at most `MOST`")]
fn fitting(extent: [u32; 2]) -> [u32; 2] {
    let [width, height] = extent.map(|texels| f64::from(texels.max(1)));
    let scale = (f64::from(MOST[0]) / width).min(f64::from(MOST[1]) / height);
    [width, height].map(|side| (side * scale).round().max(1.0) as u32)
}

impl Making<'_> {
    /// Passes that run for their thumbnails, even if nothing else asks for it: a run makes the same contents again.
    pub(super) fn forced(&self) -> impl Iterator<Item = usize> + '_ {
        let nodes = self.chosen.iter().map(|(index, _)| &self.thumbnails.nodes[*index]);
        nodes.filter(|node| node.repeats).map(|node| node.pass)
    }

    /// A pass was recorded: makes its thumbnails. Everything before is waited for, and everything after waits.
    pub(super) fn record(
        &mut self,
        recording: &mut Recording<'_>,
        running: &Prepared,
        pass: usize,
        rotation: impl Fn(CopySelector) -> u64,
    ) {
        let all =
            (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE);
        for ((index, staging), recorded) in self.chosen.iter().zip(&mut self.recorded) {
            let node = &self.thumbnails.nodes[*index];
            if node.pass != pass {
                continue;
            }
            let before = if self.thumbnails.initialized {
                Barrier::full()
            } else {
                Barrier::full().activate(&self.thumbnails.image, all, all)
            };
            self.thumbnails.initialized = true;
            recording.barrier(&before);
            let copy = copy_of(rotation(node.selector), 0, running.resources[node.resource].count());
            recording.bind(&node.pipeline, &node.sets[copy]);
            recording.push(&node.pipeline, bytemuck::bytes_of(&node.push));
            recording.dispatch([node.size[0].div_ceil(display::GROUP), node.size[1].div_ceil(display::GROUP), 1]);
            recording.barrier(&Barrier::full());
            recording.copy_image_to_buffer(&self.thumbnails.image, 0, 0, staging);
            recording.barrier(&Barrier::full_to_host());
            *recorded = true;
        }
    }

    /// The frame was submitted, or had nothing to submit.
    pub(super) fn submitted(self, device: &Arc<Device>, submitted: TimelineValue, frame: u64, runs: &[Digest]) {
        let Making { thumbnails, chosen, recorded } = self;
        for ((index, staging), recorded) in chosen.into_iter().zip(recorded) {
            let node = &mut thumbnails.nodes[index];
            // A pass that is off, or not due, has nothing new: others come before it.
            node.made = Some((frame, runs[node.pass]));
            if recorded {
                let (pass, access, size) = (node.pass, node.access, node.size);
                let readback = Readback::of(device, staging, submitted);
                thumbnails.on_the_way.push(ReadTicket::new(readback, move |rgba| Thumbnail {
                    pass,
                    access,
                    size,
                    rgba: cropped(&rgba, size),
                }));
            }
        }
    }
}

/// The top left part of the picture of a thumbnail.
fn cropped(rgba: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let rows = rgba.chunks_exact(MOST[0] as usize * 4).take(height as usize);
    rows.flat_map(|row| &row[..width as usize * 4]).copied().collect()
}

impl Executor {
    /// Makes thumbnails of all targets that passes write, from the next frame on, or no more.
    pub fn make_thumbnails(&mut self, on: bool) {
        self.wants_thumbnails = on;
        if !on {
            self.thumbnails = None;
        }
    }

    /// The thumbnails of the running plan that have arrived since the last call.
    pub fn take_thumbnails(&mut self) -> Vec<Thumbnail> {
        self.thumbnails.as_mut().map(Thumbnails::take).unwrap_or_default()
    }
}
