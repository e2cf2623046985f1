//! Undo and redo: each step keeps its chunks as they were before and after it.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use raxel_world::{Chunk, ChunkPos};

use crate::packed::PackedChunk;

/// Bytes that the steps may take; the oldest go first.
pub const HISTORY_BYTES: u64 = 256 << 20;

/// Bytes above which the oldest steps are packed.
const UNPACKED_BYTES: u64 = 64 << 20;

/// Steps that are kept.
const MOST_STEPS: usize = 1000;

/// What edits made of a chunk.
#[derive(Clone, Debug)]
pub(crate) enum Stored {
    /// Ready to be used; `None` has no solids.
    Ready(Option<Arc<Chunk>>),
    /// Packed, with the number of materials that it can have.
    Packed(PackedChunk, usize),
}

impl Stored {
    /// The chunk. Packed bytes were made by this process, or read from a save whose checksums were right; what is no chunk all the same
    /// has no solids.
    pub(crate) fn chunk(&self) -> Option<Arc<Chunk>> {
        match self {
            Self::Ready(chunk) => chunk.clone(),
            Self::Packed(packed, materials) => packed.unpack(*materials).flatten().map(Arc::new),
        }
    }

    pub(crate) fn packed(&self) -> PackedChunk {
        match self {
            Self::Ready(chunk) => PackedChunk::pack(chunk.as_deref()),
            Self::Packed(packed, _) => packed.clone(),
        }
    }
}

/// A chunk before and after a step; `None` where no edit had changed it.
#[derive(Clone, Debug)]
pub(crate) struct StepChunk {
    pub(crate) pos: ChunkPos,
    pub(crate) before: Option<Stored>,
    pub(crate) after: Option<Stored>,
}

/// What is undone or redone at once.
#[derive(Debug)]
struct Step {
    chunks: Vec<StepChunk>,
    bytes: u64,
    packed: bool,
}

impl Step {
    fn new(chunks: Vec<StepChunk>) -> Self {
        let bytes = bytes_of(&chunks);
        Self { chunks, bytes, packed: false }
    }

    fn pack(&mut self) {
        for stored in self.chunks.iter_mut().flat_map(|chunk| [&mut chunk.before, &mut chunk.after]).flatten() {
            if let Stored::Ready(chunk) = stored {
                *stored = Stored::Packed(PackedChunk::pack(chunk.as_deref()), usize::MAX);
            }
        }
        self.bytes = bytes_of(&self.chunks);
        self.packed = true;
    }
}

/// Bytes of the chunks of a step; one that stands in it several times counts once.
fn bytes_of(chunks: &[StepChunk]) -> u64 {
    let mut seen = HashSet::new();
    let stored = chunks.iter().flat_map(|chunk| [&chunk.before, &chunk.after]).flatten();
    let bytes = stored.map(|stored| match stored {
        Stored::Ready(Some(chunk)) if seen.insert(Arc::as_ptr(chunk)) => chunk.bytes(),
        Stored::Ready(_) => 0,
        Stored::Packed(packed, _) => packed.bytes().len() as u64,
    });
    bytes.sum::<u64>() + size_of_val(chunks) as u64
}

/// The steps that can be undone and redone, within bounds of memory.
#[derive(Debug, Default)]
pub(crate) struct History {
    done: VecDeque<Step>,
    undone: Vec<Step>,
    bytes: u64,
}

impl History {
    /// Notes a step. What was undone before it can no longer be redone.
    pub(crate) fn push(&mut self, chunks: Vec<StepChunk>) {
        self.bytes -= self.undone.drain(..).map(|step| step.bytes).sum::<u64>();
        let step = Step::new(chunks);
        self.bytes += step.bytes;
        self.done.push_back(step);
        if self.bytes > UNPACKED_BYTES {
            for step in self.done.iter_mut().filter(|step| !step.packed) {
                let before = step.bytes;
                step.pack();
                self.bytes = self.bytes + step.bytes - before;
                if self.bytes <= UNPACKED_BYTES / 2 {
                    break;
                }
            }
        }
        while self.bytes > HISTORY_BYTES || self.done.len() > MOST_STEPS {
            let Some(oldest) = self.done.pop_front() else { return };
            self.bytes -= oldest.bytes;
        }
    }

    /// Takes the newest step back; it can be redone.
    pub(crate) fn undo(&mut self) -> Option<&[StepChunk]> {
        let step = self.done.pop_back()?;
        self.undone.push(step);
        self.undone.last().map(|step| &step.chunks[..])
    }

    /// Takes the step that was undone last once more.
    pub(crate) fn redo(&mut self) -> Option<&[StepChunk]> {
        let step = self.undone.pop()?;
        self.done.push_back(step);
        self.done.back().map(|step| &step.chunks[..])
    }

    /// Steps that can be undone and redone.
    pub(crate) fn steps(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
