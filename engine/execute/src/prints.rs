//! Prints of passes, and other records of theirs: a buffer on the device for all passes of a plan that print, copied at the end of each
//! frame in which one of them ran, and read when the device has finished that frame. Nothing waits for it. A plan without such passes has no
//! buffer and copies nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, Device, Location, Recording, Resource, vk};
use raxel_graph::plan::Plan;
use raxel_shader::prints::{Access, Call, OutOfBounds, Prints};

use super::FRAMES;
use super::error::ExecuteError;
use super::texel_trace::TracedTexel;
use super::writers::{PassWrites, Watching};

/// A pass's part of the buffer begins at a multiple of this: no device asks for a larger one (Vulkan 1.3, `minStorageBufferOffsetAlignment`).
const ALIGNMENT: u64 = 256;

/// The prints of one pass in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassPrints {
    /// Frames that the executor had run before.
    pub frame: u64,
    /// The pass, or the round of a loop.
    pub pass: String,
    /// The lines, in the order in which they were written.
    pub lines: Vec<PrintedLine>,
    /// Prints beyond the lines that there is room for, by call.
    pub omitted: Vec<Omitted>,
    /// All assertions of the pass's shader.
    pub assertions: Vec<Assertion>,
    /// The checked accesses that were out of bounds.
    pub out_of_bounds: Vec<(Access, OutOfBounds)>,
    /// Its writes of the watched texel, if it may write that.
    pub written: Option<PassWrites>,
}

/// One line that an invocation printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedLine {
    /// File and line of the call, when the source is known.
    pub place: Option<(Arc<str>, u32)>,
    /// `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// The text with its values.
    pub text: String,
}

/// Lines of one call that were not kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omitted {
    /// File and line of the call, when the source is known.
    pub place: Option<(Arc<str>, u32)>,
    /// How many.
    pub count: u32,
}

/// The outcome of an assertion in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Assertion {
    /// The assertion.
    pub call: Call,
    /// The number of its failures.
    pub failed: u32,
    /// The invocation of its first failure.
    pub first: Option<[u32; 3]>,
}

/// The buffer that the passes of a plan print to.
pub(super) struct PrintReadback {
    plan: Arc<Plan>,
    /// The passes that print, in the order of the plan.
    passes: Vec<PrintingPass>,
    /// The buffer on the device, and a copy of it for each frame in flight; `None` where no pass prints.
    memory: Option<(Arc<Buffer>, Buffer)>,
    /// The buffer holds zeros where no frame has written.
    cleared: AtomicBool,
    bytes: u64,
}

struct PrintingPass {
    /// Index into the plan's passes.
    planned: usize,
    offset: u64,
    bytes: u64,
}

impl PrintReadback {
    pub(super) fn new(device: &Arc<Device>, plan: &Arc<Plan>) -> Result<PrintReadback, ExecuteError> {
        let mut passes = Vec::new();
        let mut end = 0u64;
        for (planned, pass) in plan.passes.iter().enumerate() {
            if let Some(prints) = &plan.graph.pass(pass.pass).shader.interface.prints {
                passes.push(PrintingPass { planned, offset: end, bytes: prints.bytes });
                end = (end + prints.bytes).next_multiple_of(ALIGNMENT);
            }
        }
        let memory = if passes.is_empty() {
            None
        } else {
            let (from, to) = (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST);
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER | from | to;
            let info = BufferInfo { size: end, usage, location: Location::Device };
            let printed = Buffer::new(device, "what passes print", &info, Backing::Own)?;
            let info = BufferInfo { size: end * FRAMES as u64, usage: to, location: Location::Download };
            Some((Arc::new(printed), Buffer::new(device, "what passes have printed", &info, Backing::Own)?))
        };
        Ok(PrintReadback { plan: plan.clone(), passes, memory, cleared: AtomicBool::new(false), bytes: end })
    }

    /// The pass's part of the buffer, which its shader prints to.
    pub(super) fn binding(&self, planned: usize) -> Option<Resource> {
        let pass = self.passes.iter().find(|pass| pass.planned == planned)?;
        let (buffer, _) = self.memory.as_ref()?;
        Some(Resource::Buffer { buffer: buffer.clone(), offset: pass.offset, size: pass.bytes })
    }

    /// The passes that may write a texel, and record it.
    pub(super) fn watch(&self, texel: &Arc<TracedTexel>) -> Watching {
        Watching::new(&self.plan, texel, self.passes.iter().map(|pass| pass.planned))
    }

    /// Fills a new buffer with zeros, before the passes of a frame. Then tells the passes which texel is watched.
    pub(super) fn begin(&self, recording: &mut Recording<'_>, watching: Option<&Watching>) {
        let Some((buffer, _)) = &self.memory else { return };
        let fills = !self.cleared.load(Ordering::Relaxed);
        if fills {
            recording.fill_buffer(buffer, 0, self.bytes, 0);
        }
        let watched: Vec<_> = self.passes.iter().filter_map(|pass| Some((pass, watching?.of(pass.planned)?))).collect();
        if fills && !watched.is_empty() {
            recording.barrier(&Barrier::default().memory(COPIED, COPIED));
        }
        for (pass, of) in &watched {
            recording.update_buffer(buffer, pass.offset + of.offset, bytemuck::cast_slice(&of.words));
        }
        if fills || !watched.is_empty() {
            recording.barrier(&Barrier::default().memory(COPIED, PASSES));
        }
    }

    /// Copies the prints of the passes that `ran`, and clears their buffers for the next frame. Notes their indices in `copied`.
    pub(super) fn record(
        &self,
        recording: &mut Recording<'_>,
        slot: usize,
        (ran, watching): (&[u32], Option<&Watching>),
        copied: &mut Vec<usize>,
    ) {
        copied.clear();
        let Some((buffer, staging)) = &self.memory else { return };
        let did_run = |pass: &PrintingPass| ran.iter().any(|ran| *ran as usize == pass.planned);
        copied.extend((0..self.passes.len()).filter(|index| did_run(&self.passes[*index])));
        // A pass that did not run was told of the texel all the same.
        let is_used = |pass: &&PrintingPass| did_run(pass) || watching.is_some_and(|of| of.of(pass.planned).is_some());
        if !self.passes.iter().any(|pass| is_used(&pass)) {
            return;
        }
        recording.barrier(&Barrier::default().memory(PASSES, COPIED));
        for PrintingPass { offset, bytes, .. } in copied.iter().map(|index| &self.passes[*index]) {
            recording.copy_buffer((buffer, *offset), (staging, self.staged(slot) + offset), *bytes);
        }
        recording.barrier(&Barrier::default().memory(COPIED, COPIED));
        for PrintingPass { offset, bytes, .. } in self.passes.iter().filter(is_used) {
            recording.fill_buffer(buffer, *offset, *bytes, 0);
        }
        recording.barrier(&Barrier::to_host(COPIED));
    }

    /// The recorded copies were submitted.
    pub(super) fn submitted(&self) {
        self.cleared.store(true, Ordering::Relaxed);
    }

    /// Where the copy for a frame in flight begins.
    fn staged(&self, slot: usize) -> u64 {
        slot as u64 * self.bytes
    }

    /// The prints of the passes that were copied in a finished frame.
    pub(super) fn read(
        &self,
        slot: usize,
        frame: u64,
        (copied, watching): (&[usize], Option<&Watching>),
    ) -> Vec<PassPrints> {
        let Some((_, staging)) = &self.memory else { return Vec::new() };
        let passes = copied.iter().filter_map(|index| self.passes.get(*index));
        let read = passes.filter_map(|pass| {
            let planned = self.plan.graph.pass(self.plan.passes[pass.planned].pass);
            let mut bytes = vec![0; usize::try_from(pass.bytes).ok()?];
            let prints = planned.shader.interface.prints.as_ref()?;
            let copied = staging.read(self.staged(slot) + pass.offset, &mut bytes);
            let words = bytes.chunks_exact(4).map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]]));
            let words: Vec<u32> = words.collect();
            let written = || watching?.written(&self.plan, pass.planned, &words, frame);
            copied.then(|| PassPrints { written: written(), ..told(prints, &words, frame, &planned.name) })
        });
        read.collect()
    }
}

const PASSES: (vk::PipelineStageFlags2, vk::AccessFlags2) = (
    vk::PipelineStageFlags2::COMPUTE_SHADER,
    vk::AccessFlags2::from_raw(
        vk::AccessFlags2::SHADER_STORAGE_READ.as_raw() | vk::AccessFlags2::SHADER_STORAGE_WRITE.as_raw(),
    ),
);
const COPIED: (vk::PipelineStageFlags2, vk::AccessFlags2) = (
    vk::PipelineStageFlags2::ALL_TRANSFER,
    vk::AccessFlags2::from_raw(vk::AccessFlags2::TRANSFER_READ.as_raw() | vk::AccessFlags2::TRANSFER_WRITE.as_raw()),
);

/// Decodes a pass's part of the buffer.
fn told(prints: &Prints, words: &[u32], frame: u64, pass: &str) -> PassPrints {
    let beyond = |access: &Access| Some((access.clone(), access.recorded(words)?));
    let mut told = PassPrints {
        frame,
        pass: pass.to_owned(),
        lines: Vec::new(),
        omitted: Vec::new(),
        assertions: Vec::new(),
        out_of_bounds: prints.accesses.iter().filter_map(beyond).collect(),
        written: None,
    };
    let mut lines = Vec::new();
    for call in &prints.calls {
        let recorded = call.recorded(words);
        if call.assertion {
            let first = recorded.records.iter().min_by_key(|record| record.order);
            let first = first.map(|record| record.invocation);
            told.assertions.push(Assertion { call: call.clone(), failed: recorded.reached, first });
            continue;
        }
        let kept = u32::try_from(recorded.records.len()).unwrap_or(u32::MAX);
        if recorded.reached > kept {
            told.omitted.push(Omitted { place: call.line.clone(), count: recorded.reached - kept });
        }
        lines.extend(recorded.records.into_iter().map(|record| {
            let line = PrintedLine { place: call.line.clone(), invocation: record.invocation, text: record.text };
            (record.order, line)
        }));
    }
    lines.sort_by_key(|(order, _)| *order);
    told.lines = lines.into_iter().map(|(_, line)| line).collect();
    told
}
