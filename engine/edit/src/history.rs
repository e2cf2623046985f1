//! Undo and redo. A step keeps its chunks from before and after it. If it set voxels one by one, it keeps only these voxels.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use raxel_world::{Cause, Chunk, ChunkPos, MaterialIndex, Unavailable};
use rayon::prelude::*;

use crate::packed::PackedChunk;

/// Bytes that the steps may take; the oldest go first.
pub(crate) const HISTORY_BYTES: u64 = 256 << 20;

/// Bytes of steps that are not packed, above which the oldest of them are.
const UNPACKED_BYTES: u64 = 64 << 20;

/// Steps that are kept.
const MOST_STEPS: usize = 1000;

/// The edits' version of a chunk.
#[derive(Clone, Debug)]
pub(crate) enum Stored {
    /// Ready to be used; `None` has no solids.
    Ready(Option<Arc<Chunk>>),
    /// Packed, with the number of materials that it can have.
    Packed(PackedChunk, usize),
}

impl Stored {
    /// The chunk; `None` has no solids. `pos` is the place for the error.
    ///
    /// # Errors
    /// When packed bytes are no chunk. This process made them, or read them from a save with right checksums. So the reason is a save of
    /// another program, or a fault of the memory.
    pub(crate) fn chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable> {
        match self {
            Self::Ready(chunk) => Ok(chunk.clone()),
            Self::Packed(packed, materials) => match packed.unpack(*materials) {
                Some(chunk) => Ok(chunk.map(Arc::new)),
                None => Err(Unavailable::new(0, pos, Cause::Damaged, "its edited voxels cannot be unpacked")),
            },
        }
    }

    pub(crate) fn packed(&self) -> PackedChunk {
        match self {
            Self::Ready(chunk) => PackedChunk::pack(chunk.as_deref()),
            Self::Packed(packed, _) => packed.clone(),
        }
    }
}

/// The state of a change: before or after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    Before,
    After,
}

/// A voxel of a chunk before and after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoxelChange {
    /// 64 times its block, and its bit.
    at: u32,
    materials: [MaterialIndex; 2],
}

impl VoxelChange {
    #[expect(clippy::cast_possible_truncation, reason = "a chunk has 64³ voxels")]
    pub(crate) fn new((block, bit): (usize, usize), before: MaterialIndex, after: MaterialIndex) -> Self {
        Self { at: (block * 64 + bit) as u32, materials: [before, after] }
    }

    /// Its block and its bit.
    pub(crate) fn place(self) -> (usize, u32) {
        (self.at as usize / 64, self.at % 64)
    }

    /// Its material then; air is empty.
    pub(crate) fn material(self, moment: Moment) -> MaterialIndex {
        match moment {
            Moment::Before => self.materials[0],
            Moment::After => self.materials[1],
        }
    }
}

/// The change of a step in a chunk.
#[derive(Clone, Debug)]
pub(crate) struct StepChunk {
    pub(crate) pos: ChunkPos,
    pub(crate) change: StepChange,
}

#[derive(Clone, Debug)]
pub(crate) enum StepChange {
    /// The chunk before and after it; `None` where no edit had changed it.
    Whole { before: Option<Stored>, after: Option<Stored> },
    /// Single voxels, and whether no edit had changed the chunk before.
    Voxels { first: bool, voxels: Box<[VoxelChange]> },
}

impl StepChange {
    fn stored(&self) -> impl Iterator<Item = &Stored> {
        let sides = match self {
            Self::Whole { before, after } => [before.as_ref(), after.as_ref()],
            Self::Voxels { .. } => [None, None],
        };
        sides.into_iter().flatten()
    }

    fn stored_mut(&mut self) -> impl Iterator<Item = &mut Stored> {
        let sides = match self {
            Self::Whole { before, after } => [before.as_mut(), after.as_mut()],
            Self::Voxels { .. } => [None, None],
        };
        sides.into_iter().flatten()
    }
}

/// One step of undo and redo.
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

    fn stored(&mut self) -> impl Iterator<Item = &mut Stored> {
        self.chunks.iter_mut().flat_map(|chunk| chunk.change.stored_mut())
    }

    /// Packs its chunks on all cores, and the chunks with which the next step begins.
    fn pack(&mut self, next: Option<&mut Self>) {
        let address = |chunk: &Arc<Chunk>| Arc::as_ptr(chunk).addr();
        let ready = |stored: &mut Stored| match stored {
            Stored::Ready(Some(chunk)) => Some((address(chunk), chunk.clone())),
            _ => None,
        };
        let chunks: HashMap<usize, Arc<Chunk>> = self.stored().filter_map(ready).collect();
        let packed: HashMap<usize, PackedChunk> =
            chunks.par_iter().map(|(address, chunk)| (*address, PackedChunk::pack(Some(chunk)))).collect();
        for step in [Some(&mut *self), next].into_iter().flatten() {
            for stored in step.stored() {
                let Stored::Ready(chunk) = stored else { continue };
                let found = match chunk {
                    Some(chunk) => packed.get(&address(chunk)).cloned(),
                    None => Some(PackedChunk::pack(None)),
                };
                if let Some(found) = found {
                    *stored = Stored::Packed(found, usize::MAX);
                }
            }
            step.bytes = bytes_of(&step.chunks);
        }
        self.packed = true;
    }
}

/// Bytes of the chunks of a step; one that stands in it several times counts once.
fn bytes_of(chunks: &[StepChunk]) -> u64 {
    let mut seen = HashSet::new();
    let stored = chunks.iter().flat_map(|chunk| chunk.change.stored());
    let of_voxels = chunks.iter().map(|chunk| match &chunk.change {
        StepChange::Whole { .. } => 0,
        StepChange::Voxels { voxels, .. } => size_of_val(&voxels[..]) as u64,
    });
    let bytes = stored.map(|stored| match stored {
        Stored::Ready(Some(chunk)) if seen.insert(Arc::as_ptr(chunk)) => chunk.bytes(),
        Stored::Ready(_) => 0,
        Stored::Packed(packed, _) => packed.bytes().len() as u64,
    });
    bytes.sum::<u64>() + of_voxels.sum::<u64>() + size_of_val(chunks) as u64
}

/// How many steps a history has in each direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// Steps that can be undone.
    pub undo: usize,
    /// Steps that can be redone.
    pub redo: usize,
}

/// The steps that can be undone and redone, within bounds of memory.
#[derive(Debug, Default)]
pub(crate) struct History {
    done: VecDeque<Step>,
    undone: Vec<Step>,
    bytes: u64,
}

impl History {
    /// Notes a step. Steps that were undone before it can no longer be redone.
    pub(crate) fn push(&mut self, chunks: Vec<StepChunk>) {
        self.bytes -= self.undone.drain(..).map(|step| step.bytes).sum::<u64>();
        let step = Step::new(chunks);
        self.bytes += step.bytes;
        self.done.push_back(step);
        self.pack();
        while self.bytes > HISTORY_BYTES || self.done.len() > MOST_STEPS {
            let Some(oldest) = self.done.pop_front() else { return };
            self.bytes -= oldest.bytes;
        }
    }

    /// Packs the oldest steps while unpacked steps take too much memory. Nothing can be redone here.
    fn pack(&mut self) {
        let steps = self.done.make_contiguous();
        let first = steps.iter().position(|step| !step.packed).unwrap_or(steps.len());
        for n in first..steps.len() {
            let unpacked: u64 = steps[n..].iter().map(|step| step.bytes).sum();
            if unpacked <= UNPACKED_BYTES {
                break;
            }
            if let Some((step, rest)) = steps[n..].split_first_mut() {
                step.pack(rest.first_mut());
            }
        }
        self.bytes = steps.iter().map(|step| step.bytes).sum();
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

    /// Forgets the step that was undone last.
    pub(crate) fn drop_undone(&mut self) {
        self.bytes -= self.undone.pop().map_or(0, |step| step.bytes);
    }

    /// How many steps there are.
    pub(crate) fn steps(&self) -> Steps {
        Steps { undo: self.done.len(), redo: self.undone.len() }
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
