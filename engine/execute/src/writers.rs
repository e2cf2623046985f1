//! The invocations that write a texel, where shaders record it: each pass that may write the texel is told in the buffer that it prints to
//! which one it is, and its records come with its prints.

use std::sync::Arc;

use raxel_graph::checked::{BoundAccess, Interval, Pass, ResourceId, Usage};
use raxel_graph::local_size;
use raxel_graph::plan::{Plan, ResourceDesc};
use raxel_shader::interface::{BindingKind, Dim};
use raxel_shader::writes::{WatchedDescriptor, Written};

use super::executor::Executor;
use super::prepare::Prepared;
use super::texel_trace::TracedTexel;
use super::thumbnails::repeats;

/// The writes of a watched texel by one pass in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassWrites {
    /// The texel.
    pub texel: Arc<TracedTexel>,
    /// Frames that the executor had run before.
    pub frame: u64,
    /// The pass, or the round of a loop.
    pub pass: String,
    /// How often it wrote the texel.
    pub count: u32,
    /// The first writes, in the order in which they were recorded. Writes of one invocation are in the order of the program; those of
    /// different ones may have reached the texel in another order.
    pub writes: Vec<InvocationWrite>,
}

/// One write of a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct InvocationWrite {
    /// File and line, counted from 1, when the source is known.
    pub place: Option<(Arc<str>, u32)>,
    /// `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// `gl_WorkGroupID`.
    pub workgroup: [u32; 3],
    /// The value of each of the target's channels, before it is converted to the target's format.
    pub value: Written,
    /// Whether an atomic operation wrote it.
    pub atomic: bool,
}

impl PassWrites {
    /// Whether several invocations wrote the texel, and not all of them by atomic operations: then the device decides which value is left,
    /// unless a barrier of the workgroup stands between.
    pub fn races(&self) -> bool {
        let first = self.writes.first().map(|write| write.invocation);
        let others = self.writes.iter().any(|write| Some(write.invocation) != first);
        others && self.writes.iter().any(|write| !write.atomic)
    }
}

/// The texel whose writes are recorded, and the passes that have not told of it yet.
#[derive(Default)]
pub(super) struct Writers {
    texel: Option<Arc<TracedTexel>>,
    /// Passes of the running plan that may write it and have not run since it was chosen; `None` before they are known.
    untold: Option<Vec<usize>>,
}

impl Writers {
    /// Every pass is to tell again.
    pub(super) fn renew(&mut self) {
        self.untold = None;
    }

    /// What the passes of a frame are told.
    pub(super) fn begin(&mut self, running: Option<&Prepared>) -> Option<Watching> {
        let (texel, running) = (self.texel.as_ref()?, running?);
        let watching = running.printed.watch(texel);
        let passes = || watching.passes.iter().map(|watched| watched.planned);
        self.untold.get_or_insert_with(|| passes().filter(|pass| repeats(running.plan(), *pass)).collect());
        (!watching.passes.is_empty()).then_some(watching)
    }

    /// Passes that run to tell of the texel, even if nothing else asks for it: a run makes the same contents again.
    pub(super) fn forced(&self) -> impl Iterator<Item = usize> + '_ {
        self.untold.iter().flatten().copied()
    }

    /// These passes ran in a frame that was submitted.
    pub(super) fn ran(&mut self, ran: &[u32]) {
        if let Some(untold) = &mut self.untold {
            untold.retain(|pass| !ran.iter().any(|ran| *ran as usize == *pass));
        }
    }
}

impl Executor {
    /// Records the writes of a texel from the next frame on, or of none, in shaders that were compiled for that. They come with
    /// [`Self::take_prints`]. Passes that write it and targets alone run once for another texel, even if their results are still valid.
    pub fn find_writers(&mut self, texel: Option<TracedTexel>) {
        if self.writers.texel.as_deref() != texel.as_ref() {
            self.writers = Writers { texel: texel.map(Arc::new), untold: None };
        }
    }

    /// Records the writes of the texel of [`Self::find_writers`] again, as of another texel.
    pub fn find_writers_again(&mut self) {
        self.writers.renew();
    }
}

/// A watched texel in a frame.
pub(super) struct Watching {
    texel: Arc<TracedTexel>,
    /// Channels of the target.
    channels: usize,
    passes: Vec<WatchedPass>,
}

/// A pass that may write the watched texel.
pub(super) struct WatchedPass {
    /// Index into the plan's passes.
    planned: usize,
    /// Bytes into its part of the buffer at which the words begin.
    pub offset: u64,
    /// The texel for its shader.
    pub words: Vec<u32>,
}

impl Watching {
    /// Of these passes of a plan, those that may write a texel. None where the plan has no such texel.
    pub(super) fn new(plan: &Plan, texel: &Arc<TracedTexel>, passes: impl Iterator<Item = usize>) -> Self {
        let mut watching = Self { texel: texel.clone(), channels: 0, passes: Vec::new() };
        let Some(resource) = texel.find(plan).map(|index| &plan.resources[index]) else { return watching };
        let ResourceDesc::Image(desc) = &resource.desc else { return watching };
        watching.channels = desc.format.channels() as usize;
        let watched = |planned: usize| {
            let pass = plan.graph.pass(plan.passes[planned].pass);
            let writes = pass.shader.interface.prints.as_ref()?.writes.as_ref()?;
            let (first, words) = writes.watch(texel.at, &descriptors(pass, resource.resource, texel))?;
            Some(WatchedPass { planned, offset: 4 * u64::from(first), words })
        };
        watching.passes = passes.filter_map(watched).collect();
        watching
    }

    /// What a pass is told.
    pub(super) fn of(&self, planned: usize) -> Option<&WatchedPass> {
        self.passes.iter().find(|pass| pass.planned == planned)
    }

    /// The records of a pass in the words of its part of the buffer; `None` if it was told nothing.
    pub(super) fn written(&self, plan: &Plan, planned: usize, words: &[u32], frame: u64) -> Option<PassWrites> {
        self.of(planned)?;
        let of_plan = &plan.passes[planned];
        let pass = plan.graph.pass(of_plan.pass);
        let recorded = pass.shader.interface.prints.as_ref()?.writes.as_ref()?.recorded(words);
        let local = local_size(pass, &of_plan.specialization).map(|side| side.max(1));
        let writes = recorded.writes.into_iter().map(|mut write| {
            write.value.words.truncate(self.channels);
            InvocationWrite {
                place: write.line,
                invocation: write.invocation,
                workgroup: std::array::from_fn(|axis| write.invocation[axis] / local[axis]),
                value: write.value,
                atomic: write.atomic,
            }
        });
        let (texel, pass) = (self.texel.clone(), pass.name.clone());
        Some(PassWrites { texel, frame, pass, count: recorded.count, writes: writes.collect() })
    }
}

/// The descriptors of a pass that it may write a texel of a target through.
fn descriptors(pass: &Pass, target: ResourceId, texel: &TracedTexel) -> Vec<WatchedDescriptor> {
    let mut found = Vec::new();
    for (index, binding) in (0..).zip(&pass.shader.interface.bindings) {
        let BindingKind::StorageImage { dim, arrayed, .. } = binding.kind else { continue };
        let bound = pass.accesses.iter().filter(|access| access.binding == Some(index));
        for (element, access) in (0..).zip(bound) {
            // A storage image shows its first mip only.
            let shows = access.resource == target && access.age == 0 && access.mips.first == texel.mip;
            if shows
                && access.usage == Usage::StorageImage
                && access.access.writes()
                && let Some(layer) = layer_in_view(access, (dim, arrayed), texel.layer)
            {
                found.push(WatchedDescriptor { set: binding.set, binding: binding.binding, element, layer });
            }
        }
    }
    found
}

/// The number that a layer or slice has in the view of an access; `None` where the view does not show it.
fn layer_in_view(access: &BoundAccess, (dim, arrayed): (Dim, bool), layer: u32) -> Option<u32> {
    match (dim, arrayed) {
        (Dim::D3, _) => Some(layer),
        (Dim::D1 | Dim::D2, false) => (access.layers.first == layer).then_some(0),
        (Dim::D1 | Dim::D2, true) | (Dim::Cube, _) => {
            access.layers.meets(Interval::one(layer)).then(|| layer - access.layers.first)
        }
    }
}
