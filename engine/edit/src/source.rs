//! The tiles of a streamed world, made on request, with edits laid over them.

mod cells;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

use raxel_world::{Chunk, ChunkPos, ChunkProvider, Content, DenseChunk, MAX_LEVEL, Material, Unavailable};
use rayon::prelude::*;

use self::cells::ChangedCells;
use crate::edits::{Change, Edits};
use crate::history::Stored;
use crate::scene::Base;

/// The tiles of a source with edits. One thread adds edits while others request tiles. A tile never has half an edit of a chunk.
///
/// A tile of a level above 0 equals that of the source, except in cells where edits changed voxels: see `ChangedCells`. So from afar, an
/// edited hill looks like an untouched one.
pub struct EditedChunks {
    unedited: Unedited,
    materials: Vec<Material>,
    edited: RwLock<Edited>,
}

/// The source below the edits.
struct Unedited(Arc<dyn ChunkProvider>);

#[derive(Default)]
struct Edited {
    chunks: BTreeMap<ChunkPos, Arc<EditedChunk>>,
    /// Edited chunks by the tile of each level above 0 that they are in.
    of_tile: BTreeMap<(u32, ChunkPos), BTreeSet<ChunkPos>>,
    /// Smallest and one past the largest height of all chunks that were ever edited.
    heights: Option<[i64; 2]>,
}

struct EditedChunk {
    voxels: Stored,
    /// The content of the source below at the same place, if it is known already.
    below: OnceLock<Content>,
    /// Made when a coarse tile is first asked for.
    cells: OnceLock<ChangedCells>,
}

thread_local! {
    /// Half a megabyte, which every thread keeps that makes tiles.
    static WORKING: RefCell<DenseChunk> = RefCell::default();
}

impl EditedChunks {
    /// A source without edits. `materials` starts with those of the source; models may add more.
    pub fn new(source: Arc<dyn ChunkProvider>, materials: Vec<Material>) -> Self {
        Self { unedited: Unedited(source), materials, edited: RwLock::default() }
    }

    /// The source below the edits.
    pub fn unedited(&self) -> &dyn Base {
        &self.unedited
    }

    /// Adds the changes of an edit.
    pub fn change(&self, change: &Change) {
        let mut edited = self.edited.write().unwrap_or_else(PoisonError::into_inner);
        for chunk in &change.chunks {
            let below = match edited.chunks.get(&chunk.pos) {
                Some(before) => before.below.clone(),
                // Until now it was the source's.
                None => OnceLock::from(content_of(chunk.before.clone())),
            };
            edited.put(chunk.pos, chunk.edited.then(|| Stored::Ready(chunk.after.clone())), below);
        }
    }

    /// Replaces all edits.
    pub fn replace(&self, edits: &Edits) {
        let mut edited = self.edited.write().unwrap_or_else(PoisonError::into_inner);
        let heights = edited.heights;
        *edited = Edited { heights, ..Edited::default() };
        // A save's packed chunks stay packed until they are asked for.
        edits.positions().for_each(|pos| edited.put(pos, edits.stored(pos), OnceLock::new()));
    }

    /// Smallest height, and one past the largest, of all chunks that edits ever changed, in voxels. `None` before the first edit.
    pub fn edited_heights(&self) -> Option<[i64; 2]> {
        self.edited.read().unwrap_or_else(PoisonError::into_inner).heights
    }

    fn edited_chunk(&self, pos: ChunkPos) -> Option<Arc<EditedChunk>> {
        self.edited.read().unwrap_or_else(PoisonError::into_inner).chunks.get(&pos).cloned()
    }

    /// A tile of the source with the edited chunks in it.
    fn with_edits(&self, level: u32, pos: ChunkPos, content: Content) -> Result<Content, Unavailable> {
        let edited = if level == 0 { Vec::new() } else { self.edited_chunks(level, pos) };
        if edited.is_empty() {
            return Ok(content);
        }
        // Before the working copy is taken: the source below makes chunks for this, thousands where a save was opened just now.
        let unknown: Vec<_> = edited.iter().filter(|(_, chunk)| chunk.cells.get().is_none()).collect();
        unknown.into_par_iter().try_for_each(|(pos, chunk)| chunk.find_cells(&self.unedited, *pos))?;
        Ok(WORKING.with_borrow_mut(|tile| {
            content.unpack(tile);
            for (pos, chunk) in &edited {
                if let Some(cells) = chunk.cells.get() {
                    cells.lay(level, *pos, tile);
                }
            }
            Content::pack(tile)
        }))
    }

    fn edited_chunks(&self, level: u32, pos: ChunkPos) -> Vec<(ChunkPos, Arc<EditedChunk>)> {
        let edited = self.edited.read().unwrap_or_else(PoisonError::into_inner);
        let Some(positions) = edited.of_tile.get(&(level, pos)) else { return Vec::new() };
        positions.iter().filter_map(|pos| Some((*pos, edited.chunks.get(pos)?.clone()))).collect()
    }
}

impl ChunkProvider for EditedChunks {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        match (level, self.edited_chunk(pos)) {
            (0, Some(edited)) => edited.voxels.chunk(pos).map(content_of),
            _ => self.with_edits(level, pos, self.unedited.0.try_chunk(level, pos)?),
        }
    }

    fn on_evicted(&self, level: u32, pos: ChunkPos) {
        self.unedited.0.on_evicted(level, pos);
    }
}

impl Base for EditedChunks {
    fn try_chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable> {
        ChunkProvider::try_chunk(self, 0, pos).map(|content| content.to_chunk())
    }
}

impl Base for Unedited {
    fn try_chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable> {
        self.0.try_chunk(0, pos).map(|content| content.to_chunk())
    }
}

impl std::fmt::Debug for EditedChunks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let edited = self.edited.read().unwrap_or_else(PoisonError::into_inner);
        write!(f, "EditedChunks({} edited chunks)", edited.chunks.len())
    }
}

impl Edited {
    /// Puts an edited chunk in place, or goes back to that of the source.
    fn put(&mut self, pos: ChunkPos, voxels: Option<Stored>, below: OnceLock<Content>) {
        let tiles = (1..=MAX_LEVEL).map(|level| (level, tile_of(level, pos)));
        let Some(voxels) = voxels else {
            self.chunks.remove(&pos);
            for tile in tiles {
                if let Some(positions) = self.of_tile.get_mut(&tile) {
                    positions.remove(&pos);
                    if positions.is_empty() {
                        self.of_tile.remove(&tile);
                    }
                }
            }
            return;
        };
        self.chunks.insert(pos, Arc::new(EditedChunk { voxels, below, cells: OnceLock::new() }));
        for tile in tiles {
            self.of_tile.entry(tile).or_default().insert(pos);
        }
        let [low, high] = [64 * i64::from(pos.y), 64 * i64::from(pos.y) + 64];
        let [before, after] = self.heights.unwrap_or([low, high]);
        self.heights = Some([before.min(low), after.max(high)]);
    }
}

impl EditedChunk {
    /// Finds the cells with changes.
    fn find_cells(&self, source: &Unedited, pos: ChunkPos) -> Result<(), Unavailable> {
        let below = match self.below.get() {
            Some(below) => below.clone(),
            None => source.0.try_chunk(0, pos)?,
        };
        let (after, before) = (self.voxels.chunk(pos)?, below.to_chunk());
        self.cells.get_or_init(|| ChangedCells::between(before.as_deref(), after.as_deref()));
        if matches!(self.voxels, Stored::Ready(_)) {
            // Its voxels are held unpacked as well, and it may soon be edited again.
            self.below.get_or_init(|| below);
        }
        Ok(())
    }
}

fn content_of(chunk: Option<Arc<Chunk>>) -> Content {
    chunk.map_or(Content::Empty, Content::of)
}

/// The tile of a level that a chunk is in.
fn tile_of(level: u32, pos: ChunkPos) -> ChunkPos {
    let shift = 2 * level;
    ChunkPos::new(pos.x >> shift, pos.y >> shift, pos.z >> shift)
}
