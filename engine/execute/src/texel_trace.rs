//! One texel of a target, as each pass of a frame leaves it: copied right after every dispatch that may have written it.

use std::sync::Arc;

use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, Device, Location, Readback, Recording, TimelineValue, vk};
use raxel_graph::plan::{CopySelector, Plan, ResourceDesc, Step};
use raxel_shader::format::Format;

use super::error::ExecuteError;
use super::executor::Executor;
use super::prepare::Prepared;
use super::readback::ReadTicket;
use super::report::Texels;
use super::rotations::copy_of;

/// Dispatches of a frame whose texels are kept; the texels of later ones are not.
const MOST: usize = 256;

/// Bytes between texels in the buffer that they are copied to: the largest texel, and a multiple of every other.
const STRIDE: usize = 16;

/// A texel that is followed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TracedTexel {
    /// Name of the target.
    pub target: String,
    /// Its mip.
    pub mip: u32,
    /// Its layer, or the slice of a volume.
    pub layer: u32,
    /// From the top left.
    pub at: [u32; 2],
}

/// A texel in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TexelTrace {
    /// The number of the frame, as in its report.
    pub frame: u64,
    /// The texel after each dispatch that may have written it, in their order.
    pub writes: Vec<TexelWrite>,
}

/// A texel as a dispatch left it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TexelWrite {
    /// Name of the pass.
    pub pass: String,
    /// A picture of this texel alone.
    pub texel: Texels,
}

/// The trace of the frame that is recorded.
pub(super) struct Tracing {
    texel: TracedTexel,
    format: Format,
    /// Index of the target into the plan's resources.
    resource: usize,
    writers: Vec<Writer>,
    staging: Arc<Buffer>,
    /// Indices of writers, in the order in which they wrote.
    written: Vec<usize>,
}

/// A pass that may write the texel.
struct Writer {
    /// Index into the plan's passes.
    pass: usize,
    name: String,
    /// Selects the current copy of the target after it.
    selector: CopySelector,
}

impl TracedTexel {
    /// The index of its target into the plan's resources; `None` where the plan has no such texel.
    pub(super) fn find(&self, plan: &Plan) -> Option<usize> {
        let id = plan.graph.find_resource(&self.target)?;
        let size = &plan.sizes[id.0 as usize];
        let extent = size.texels(self.mip).filter(|_| self.mip < size.mips())?;
        let is_inside = self.at[0] < extent[0] && self.at[1] < extent[1] && self.layer < extent[2];
        plan.resources.iter().position(|planned| planned.resource == id).filter(|_| is_inside)
    }
}

impl Tracing {
    /// `None` where the plan has no such texel, or no pass that writes it.
    fn new(device: &Arc<Device>, running: &Prepared, texel: &TracedTexel) -> Result<Option<Self>, ExecuteError> {
        let plan = running.plan();
        let Some(resource) = texel.find(plan) else { return Ok(None) };
        let (id, ResourceDesc::Image(desc)) = (plan.resources[resource].resource, &plan.resources[resource].desc)
        else {
            return Ok(None);
        };
        let mut writers = Vec::new();
        for (step, kind) in plan.steps.iter().enumerate() {
            let Step::Dispatch { pass } = kind else { continue };
            let pass = *pass as usize;
            let of_graph = plan.passes[pass].pass;
            if plan.may_write(of_graph, id, texel.mip, texel.layer) {
                let name = plan.graph.pass(of_graph).name.clone();
                writers.push(Writer { pass, name, selector: plan.selector(step, id) });
            }
        }
        if writers.is_empty() {
            return Ok(None);
        }
        let size = (STRIDE * MOST) as u64;
        let info = BufferInfo { size, usage: vk::BufferUsageFlags::TRANSFER_DST, location: Location::Download };
        let staging = Arc::new(Buffer::new(device, "copies of a texel", &info, Backing::Own)?);
        let (texel, format) = (texel.clone(), desc.format);
        Ok(Some(Self { texel, format, resource, writers, staging, written: Vec::new() }))
    }

    /// A pass was recorded: copies what it left. Everything before is waited for, and everything after waits, the host too.
    pub(super) fn record(
        &mut self,
        recording: &mut Recording<'_>,
        running: &Prepared,
        pass: usize,
        rotation: impl Fn(CopySelector) -> u64,
    ) {
        let Some(writer) = self.writers.iter().position(|writer| writer.pass == pass) else { return };
        let physical = &running.resources[self.resource];
        let copy = copy_of(rotation(self.writers[writer].selector), 0, physical.count());
        let Some(image) = physical.image(copy).filter(|_| self.written.len() < MOST) else { return };
        let TracedTexel { mip, layer, at, .. } = self.texel;
        recording.barrier(&Barrier::full());
        let place = (STRIDE * self.written.len()) as u64;
        recording.copy_texel_to_buffer(image, mip, layer, at, (&self.staging, place));
        recording.barrier(&Barrier::full_to_host());
        self.written.push(writer);
    }

    /// The ticket of a frame that was submitted; `None` if no pass wrote the texel.
    pub(super) fn ticket(
        self,
        device: &Arc<Device>,
        submitted: TimelineValue,
        frame: u64,
    ) -> Option<ReadTicket<TexelTrace>> {
        let Self { format, writers, staging, written, .. } = self;
        let readback = Readback::of(device, staging, submitted);
        (!written.is_empty()).then(|| {
            ReadTicket::new(readback, move |bytes| {
                let texels = bytes.chunks_exact(STRIDE).map(|slot| slot[..format.bytes() as usize].to_vec());
                let texel = |bytes| Texels { format, width: 1, height: 1, bytes };
                let names = written.iter().map(|writer| writers[*writer].name.clone());
                let writes = names.zip(texels).map(|(pass, bytes)| TexelWrite { pass, texel: texel(bytes) });
                TexelTrace { frame, writes: writes.collect() }
            })
        })
    }
}

impl Executor {
    /// Follows a texel from the next frame on, or none.
    pub fn trace_texel(&mut self, texel: Option<TracedTexel>) {
        self.traced = texel;
    }

    /// The trace of the last frame, once; `None` if no pass wrote the texel.
    pub fn texel_trace(&mut self) -> Option<ReadTicket<TexelTrace>> {
        self.trace.take()
    }

    pub(super) fn begin_trace(&self) -> Result<Option<Tracing>, ExecuteError> {
        match (&self.traced, &self.running) {
            (Some(texel), Some(running)) => Tracing::new(&self.shared.device, running, texel),
            _ => Ok(None),
        }
    }
}
