//! The chunks that edits have changed, and undo and redo.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_world::{Chunk, ChunkPos, Unavailable};
use rayon::prelude::*;

use crate::apply::{Applied, Prepared, Scratch, with_voxels};
use crate::history::{History, Moment, StepChange, StepChunk, Steps, Stored, VoxelChange};
use crate::operation::{EditError, Operation};
use crate::packed::PackedChunk;
use crate::scene::{Base, Scene};

/// The chunks that edits have changed, over those of a [`Base`], with the history of undo and redo.
#[derive(Debug, Default)]
pub struct Edits {
    overlay: BTreeMap<ChunkPos, Stored>,
    history: History,
}

/// The chunk at a position, if edits have changed it.
#[derive(Clone, Debug, PartialEq)]
pub enum Overlay {
    /// No edit has changed the chunk: ask the base.
    Base,
    /// The edited chunk; `None` has no solid voxels.
    Edited(Option<Arc<Chunk>>),
}

/// The changes of an edit.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// The changed chunks, in the order of their positions. Empty if nothing changed.
    pub chunks: Vec<ChunkChange>,
}

/// A chunk before and after an edit.
#[derive(Clone, Debug)]
pub struct ChunkChange {
    /// Position in chunks.
    pub pos: ChunkPos,
    /// The chunk before; `None` has no solid voxels.
    pub before: Option<Arc<Chunk>>,
    /// The chunk after; `None` has no solid voxels.
    pub after: Option<Arc<Chunk>>,
    /// Whether it is the edits' own now. False when it is the base's again: after [`Operation::Restore`], and when its first edit was undone.
    pub edited: bool,
}

/// A chunk that is about to change.
struct Changed {
    chunk: ChunkChange,
    /// The edits' copy of it; `None` is the base's.
    stored: Option<Stored>,
    /// The voxels that change, where only these are kept for undo.
    voxels: Option<Box<[VoxelChange]>>,
}

impl Change {
    /// The change as an operation that leaves the same chunks, independent of the chunks before it.
    pub fn as_put(&self) -> Operation {
        let put = |chunk: &ChunkChange| (chunk.pos, chunk.edited.then(|| PackedChunk::pack(chunk.after.as_deref())));
        Operation::Put { chunks: self.chunks.par_iter().map(put).collect() }
    }

    /// The changed chunks after the edit.
    pub fn after(&self) -> impl Iterator<Item = (ChunkPos, Option<Arc<Chunk>>)> + '_ {
        self.chunks.iter().map(|chunk| (chunk.pos, chunk.after.clone()))
    }
}

impl Edits {
    /// Applies operations in order, as one step of undo. After an error, nothing has changed.
    pub fn apply(&mut self, operations: &[Operation], scene: &Scene, base: &dyn Base) -> Result<Change, EditError> {
        let changed = self.run(operations, scene, base)?;
        if !changed.is_empty() {
            let step = |changed: &Changed| {
                let pos = changed.chunk.pos;
                let before = self.overlay.get(&pos).cloned();
                let change = match &changed.voxels {
                    Some(voxels) => StepChange::Voxels { first: before.is_none(), voxels: voxels.clone() },
                    None => StepChange::Whole { before, after: changed.stored.clone() },
                };
                StepChunk { pos, change }
            };
            self.history.push(changed.iter().map(step).collect());
        }
        Ok(self.commit(changed))
    }

    /// As [`Edits::apply`], without a step of undo: for operations that a save replays.
    pub fn replay(&mut self, operations: &[Operation], scene: &Scene, base: &dyn Base) -> Result<Change, EditError> {
        let changed = self.run(operations, scene, base)?;
        Ok(self.commit(changed))
    }

    /// Undoes the newest step. `None` if there is none.
    ///
    /// # Errors
    /// When the base does not have a chunk of the step. Nothing has changed then, and the step can still be undone.
    pub fn undo(&mut self, base: &dyn Base) -> Result<Option<Change>, Unavailable> {
        let Some(step) = self.history.undo() else { return Ok(None) };
        let step = step.to_vec();
        let change = self.bring(step, Moment::Before, base);
        if change.is_err() {
            self.history.redo();
        }
        change.map(Some)
    }

    /// Redoes the step that was undone last. `None` if there is none, or if an edit came after the undo.
    ///
    /// # Errors
    /// When the base does not have a chunk of the step. Nothing has changed then, and the step can still be redone.
    pub fn redo(&mut self, base: &dyn Base) -> Result<Option<Change>, Unavailable> {
        let Some(step) = self.history.redo() else { return Ok(None) };
        let step = step.to_vec();
        let change = self.bring(step, Moment::After, base);
        if change.is_err() {
            self.history.undo();
        }
        change.map(Some)
    }

    /// Undoes the newest step without a way to redo it. `None` if there is none.
    ///
    /// # Errors
    /// As [`Edits::undo`].
    pub fn take_back(&mut self, base: &dyn Base) -> Result<Option<Change>, Unavailable> {
        let change = self.undo(base)?;
        if change.is_some() {
            self.history.drop_undone();
        }
        Ok(change)
    }

    /// Removes all edits and the history of undo.
    ///
    /// # Errors
    /// When the base does not have a chunk that was edited. Nothing has changed then.
    pub fn clear(&mut self, base: &dyn Base) -> Result<Change, Unavailable> {
        let wanted: Vec<_> = self.overlay.keys().map(|pos| (*pos, None)).collect();
        let change = self.place(wanted, base)?;
        self.history.clear();
        Ok(change)
    }

    /// How many steps can be undone and redone.
    pub fn steps(&self) -> Steps {
        self.history.steps()
    }

    /// Bytes of memory that the history takes.
    pub fn history_bytes(&self) -> u64 {
        self.history.bytes()
    }

    /// The edits' version of a chunk.
    ///
    /// # Errors
    /// When the chunk came from a save and cannot be unpacked.
    pub fn overlay(&self, pos: ChunkPos) -> Result<Overlay, Unavailable> {
        self.overlay.get(&pos).map_or(Ok(Overlay::Base), |stored| stored.chunk(pos).map(Overlay::Edited))
    }

    /// The same, packed; `None` when no edit has changed it.
    pub fn packed(&self, pos: ChunkPos) -> Option<PackedChunk> {
        self.overlay.get(&pos).map(Stored::packed)
    }

    pub(crate) fn stored(&self, pos: ChunkPos) -> Option<Stored> {
        self.overlay.get(&pos).cloned()
    }

    /// The chunk at a position: the edits' own, or that of the base. `None` has no solid voxel.
    ///
    /// # Errors
    /// When the base does not have it, or it came from a save and cannot be unpacked.
    pub fn chunk(&self, pos: ChunkPos, base: &dyn Base) -> Result<Option<Arc<Chunk>>, Unavailable> {
        match self.overlay.get(&pos) {
            Some(stored) => stored.chunk(pos),
            None => base.try_chunk(pos),
        }
    }

    /// Positions of the chunks that edits have changed, in order.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = ChunkPos> + '_ {
        self.overlay.keys().copied()
    }

    /// Whether no edit has changed anything, or all were undone.
    pub fn is_empty(&self) -> bool {
        self.overlay.is_empty()
    }

    /// Takes over the chunks of a save, with materials below `materials`. They are unpacked when they are asked for, or all at once by
    /// [`Edits::unpack`].
    pub fn adopt(&mut self, chunks: impl IntoIterator<Item = (ChunkPos, PackedChunk)>, materials: usize) {
        self.overlay.extend(chunks.into_iter().map(|(pos, packed)| (pos, Stored::Packed(packed, materials))));
    }

    /// Unpacks every chunk on all cores. Returns the positions of chunks that are broken or have impossible materials. These chunks
    /// become the base's again.
    pub fn unpack(&mut self) -> Vec<ChunkPos> {
        let ready = |(pos, stored): (&ChunkPos, &mut Stored)| {
            let Stored::Packed(packed, materials) = stored else { return None };
            match packed.unpack(*materials) {
                Some(chunk) => {
                    *stored = Stored::Ready(chunk.map(Arc::new));
                    None
                }
                None => Some(*pos),
            }
        };
        let broken: Vec<ChunkPos> = self.overlay.par_iter_mut().filter_map(ready).collect();
        for pos in &broken {
            self.overlay.remove(pos);
        }
        broken
    }

    /// Works out the changes of operations, chunk by chunk on all cores. Returns them with the record to store.
    fn run(&self, operations: &[Operation], scene: &Scene, base: &dyn Base) -> Result<Vec<Changed>, EditError> {
        let prepared = Prepared::all(operations, scene)?;
        let mut of_chunk: BTreeMap<ChunkPos, Vec<&Prepared<'_>>> = BTreeMap::new();
        for operation in &prepared {
            operation.each_chunk(|pos| of_chunk.entry(pos).or_default().push(operation));
        }
        let changed = of_chunk.into_par_iter().map_init(Scratch::default, |scratch, (pos, operations)| {
            let stored = self.overlay.get(&pos);
            let before = match stored {
                Some(stored) => stored.chunk(pos)?,
                None => base.try_chunk(pos)?,
            };
            let Applied { after, edited, voxels } =
                scratch.run(pos, (before.clone(), stored.is_some()), &operations, base)?;
            if after == before && edited == stored.is_some() {
                return Ok(None);
            }
            let stored = edited.then(|| Stored::Ready(after.clone()));
            Ok(Some(Changed { chunk: ChunkChange { pos, before, after, edited }, stored, voxels }))
        });
        changed.filter_map(Result::transpose).collect()
    }

    /// Sets the chunks of a step to their state before or after it.
    fn bring(&mut self, step: Vec<StepChunk>, moment: Moment, base: &dyn Base) -> Result<Change, Unavailable> {
        let wanted = step.into_par_iter().map(|StepChunk { pos, change }| {
            let stored = match (change, moment) {
                (StepChange::Whole { before, .. }, Moment::Before) => before,
                (StepChange::Whole { after, .. }, Moment::After) => after,
                (StepChange::Voxels { first: true, .. }, Moment::Before) => None,
                (StepChange::Voxels { voxels, .. }, _) => {
                    let chunk = with_voxels(self.chunk(pos, base)?.as_deref(), &voxels, moment);
                    Some(Stored::Ready(chunk.map(Arc::new)))
                }
            };
            Ok::<_, Unavailable>((pos, stored))
        });
        let wanted = wanted.collect::<Result<_, _>>()?;
        self.place(wanted, base)
    }

    /// Puts chunks in place; `None` is the base's.
    fn place(&mut self, wanted: Vec<(ChunkPos, Option<Stored>)>, base: &dyn Base) -> Result<Change, Unavailable> {
        let change = |(pos, stored): (ChunkPos, Option<Stored>)| {
            let after = stored.as_ref().map_or_else(|| base.try_chunk(pos), |stored| stored.chunk(pos))?;
            let chunk = ChunkChange { pos, before: self.chunk(pos, base)?, after, edited: stored.is_some() };
            Ok::<_, Unavailable>(Changed { chunk, stored, voxels: None })
        };
        let changed = wanted.into_par_iter().map(change).collect::<Result<_, _>>()?;
        Ok(self.commit(changed))
    }

    fn commit(&mut self, changed: Vec<Changed>) -> Change {
        let mut change = Change { chunks: Vec::with_capacity(changed.len()) };
        for Changed { chunk, stored, .. } in changed {
            match stored {
                Some(stored) => self.overlay.insert(chunk.pos, stored),
                None => self.overlay.remove(&chunk.pos),
            };
            change.chunks.push(chunk);
        }
        change
    }
}
