//! Words of buffers that a graph warns of (`warnings`): copied at the end of each frame whose passes may have written them, and read when
//! the device has finished that frame. Nothing waits for them, and a frame without these passes copies nothing.

use std::sync::Arc;

use raxel_gpu::{Backing, Barrier, Buffer, BufferInfo, Device, Location, Recording, vk};
use raxel_graph::checked::ResourceId;
use raxel_graph::plan::Plan;

use super::FRAMES;
use super::error::ExecuteError;
use super::prepare::Prepared;
use super::rotations::copy_of;

/// The count of a frame in a word that a graph warns of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterReading {
    /// The buffer, in the graph of the plan that ran.
    pub resource: ResourceId,
    /// Index into its warnings.
    pub warning: u32,
    /// The value of the word at the end of the frame.
    pub count: u32,
}

/// The words of a plan that are warned of.
pub(super) struct CounterReadback {
    words: Vec<Word>,
    /// A word for each, for each frame in flight; `None` where there are none.
    staging: Option<Buffer>,
    before: Barrier,
    after: Barrier,
}

struct Word {
    /// Index into the plan's resources.
    planned: usize,
    offset: u64,
    /// Passes that may write its buffer: indices into the plan's.
    writers: Vec<u32>,
    resource: ResourceId,
    warning: u32,
}

impl CounterReadback {
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes in 32 bits")]
    pub(super) fn new(device: &Arc<Device>, plan: &Plan) -> Result<CounterReadback, ExecuteError> {
        let mut words = Vec::new();
        for (planned, resource) in plan.resources.iter().enumerate() {
            let id = resource.resource;
            let writes = |pass: &u32| {
                let accesses = &plan.graph.pass(plan.passes[*pass as usize].pass).accesses;
                accesses.iter().any(|access| access.resource == id && access.access.writes())
            };
            let warnings = &plan.graph.resource(id).warnings;
            if warnings.is_empty() {
                continue;
            }
            let writers: Vec<u32> = (0..plan.passes.len() as u32).filter(writes).collect();
            words.extend(warnings.iter().zip(0..).map(|(warning, number)| Word {
                planned,
                offset: warning.offset,
                writers: writers.clone(),
                resource: id,
                warning: number,
            }));
        }
        let info = BufferInfo {
            size: (words.len() * FRAMES * 4) as u64,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: Location::Download,
        };
        let staging =
            (!words.is_empty()).then(|| Buffer::new(device, "counts that are warned of", &info, Backing::Own));
        let (compute, copy) = (vk::PipelineStageFlags2::COMPUTE_SHADER, vk::PipelineStageFlags2::ALL_TRANSFER);
        let (read, write) = (vk::AccessFlags2::TRANSFER_READ, vk::AccessFlags2::TRANSFER_WRITE);
        Ok(CounterReadback {
            words,
            staging: staging.transpose()?,
            before: Barrier::default()
                .memory((compute | copy, vk::AccessFlags2::SHADER_STORAGE_WRITE | write), (copy, read | write)),
            // The next frame may write the copied resources.
            after: Barrier::to_host((copy, read | write)),
        })
    }

    fn place(&self, slot: usize, word: u32) -> u64 {
        ((slot * self.words.len() + word as usize) * 4) as u64
    }

    /// Copies the words that the passes of a frame may have written: `ran`, indices into the plan's. Notes which.
    pub(super) fn record(
        &self,
        recording: &mut Recording<'_>,
        prepared: &Prepared,
        (frame, slot): (u64, usize),
        (ran, copied): (&[u32], &mut Vec<u32>),
    ) {
        copied.clear();
        let Some(staging) = &self.staging else { return };
        for (number, word) in self.words.iter().zip(0..).map(|(word, number)| (number, word)) {
            if !word.writers.iter().any(|pass| ran.contains(pass)) {
                continue;
            }
            let physical = &prepared.resources[word.planned];
            let rotation = prepared.replay.rotation_after(frame, word.resource);
            let Some(buffer) = physical.buffer(copy_of(rotation, 0, physical.count())) else { continue };
            if copied.is_empty() {
                recording.barrier(&self.before);
            }
            recording.copy_buffer((buffer, word.offset), (staging, self.place(slot, number)), 4);
            copied.push(number);
        }
        if !copied.is_empty() {
            recording.barrier(&self.after);
        }
    }

    /// The counts of a finished frame in the words that were copied in it.
    pub(super) fn read<'a>(&'a self, slot: usize, copied: &'a [u32]) -> impl Iterator<Item = CounterReading> + 'a {
        copied.iter().filter_map(move |&number| {
            let word = self.words.get(number as usize)?;
            let count = self.staging.as_ref()?.word(self.place(slot, number))?;
            Some(CounterReading { resource: word.resource, warning: word.warning, count })
        })
    }
}
