//! A world whose tiles are made when somebody asks for them, with the chunks that edits have changed in place of its own.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

use raxel_world::{
    AIR, Chunk, ChunkPos, ChunkSource, Content, DenseChunk, MAX_LEVEL, Material, MaterialIndex, Mode, Unavailable,
    block_index, reduce, voxel_index,
};

use crate::edits::{Change, Edits};
use crate::history::Stored;
use crate::scene::Base;

/// The tiles of a source with edits. Edits go in on one thread while others ask for tiles; an answer is always that of whole edits of
/// each chunk.
///
/// A tile of a level above 0 is that of the source below, with the cells of edited chunks replaced by what [`reduce`] makes of these. So
/// what an edit looks like from afar depends on the edited chunks alone.
pub struct EditedSource {
    unedited: Unedited,
    materials: Vec<Material>,
    edited: RwLock<Edited>,
}

/// The source below the edits.
struct Unedited(Arc<dyn ChunkSource>);

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
    /// Made when a coarse tile is first asked for.
    coarse: OnceLock<Coarse>,
}

/// The cells of a chunk at the levels of which it has no more than a block.
struct Coarse {
    /// Level 2: 4³ cells, in the order of a block. Air is empty.
    block: [MaterialIndex; 64],
    /// Level 3: one cell.
    cell: MaterialIndex,
}

thread_local! {
    /// Half a megabyte each, which every thread keeps that makes tiles.
    static WORKING: RefCell<[DenseChunk; 2]> = RefCell::default();
}

impl EditedSource {
    /// A source without edits. `materials` begin with those of the source; there are more where models bring their own.
    pub fn new(source: Arc<dyn ChunkSource>, materials: Vec<Material>) -> Self {
        Self { unedited: Unedited(source), materials, edited: RwLock::default() }
    }

    /// The source below the edits.
    pub fn unedited(&self) -> &dyn Base {
        &self.unedited
    }

    /// Takes over what an edit changed.
    pub fn change(&self, change: &Change) {
        let mut edited = self.edited.write().unwrap_or_else(PoisonError::into_inner);
        for chunk in &change.chunks {
            edited.put(chunk.pos, chunk.edited.then(|| Stored::Ready(chunk.after.clone())));
        }
    }

    /// Takes over everything that was edited, in place of all edits before.
    pub fn replace(&self, edits: &Edits) {
        let mut edited = self.edited.write().unwrap_or_else(PoisonError::into_inner);
        let heights = edited.heights;
        *edited = Edited { heights, ..Edited::default() };
        // What a save has packed stays so until somebody asks for it.
        edits.positions().for_each(|pos| edited.put(pos, edits.stored(pos)));
    }

    /// Smallest and one past the largest height of all chunks that edits have ever changed, whole chunks; `None` before the first.
    pub fn edited_heights(&self) -> Option<[i64; 2]> {
        self.edited.read().unwrap_or_else(PoisonError::into_inner).heights
    }

    fn edited_chunk(&self, pos: ChunkPos) -> Option<Arc<EditedChunk>> {
        self.edited.read().unwrap_or_else(PoisonError::into_inner).chunks.get(&pos).cloned()
    }

    /// A tile of the source with the edited chunks in it.
    fn with_edits(&self, level: u32, pos: ChunkPos, content: Content) -> Content {
        let edited = if level == 0 { Vec::new() } else { self.edited_chunks(level, pos) };
        if edited.is_empty() {
            return content;
        }
        WORKING.with_borrow_mut(|[tile, working]| {
            content.unpack(tile);
            for (pos, chunk) in edited {
                chunk.lay(level, pos, tile, working);
            }
            Content::pack(tile)
        })
    }

    fn edited_chunks(&self, level: u32, pos: ChunkPos) -> Vec<(ChunkPos, Arc<EditedChunk>)> {
        let edited = self.edited.read().unwrap_or_else(PoisonError::into_inner);
        let Some(positions) = edited.of_tile.get(&(level, pos)) else { return Vec::new() };
        positions.iter().filter_map(|pos| Some((*pos, edited.chunks.get(pos)?.clone()))).collect()
    }
}

impl ChunkSource for EditedSource {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        match (level, self.edited_chunk(pos)) {
            (0, Some(edited)) => edited.content(),
            _ => self.with_edits(level, pos, self.unedited.0.chunk(level, pos)),
        }
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        match (level, self.edited_chunk(pos)) {
            (0, Some(edited)) => Ok(edited.content()),
            _ => Ok(self.with_edits(level, pos, self.unedited.0.try_chunk(level, pos)?)),
        }
    }

    fn given_up(&self, level: u32, pos: ChunkPos) {
        self.unedited.0.given_up(level, pos);
    }
}

impl Base for EditedSource {
    fn chunk(&self, pos: ChunkPos) -> Option<Arc<Chunk>> {
        ChunkSource::chunk(self, 0, pos).to_chunk()
    }
}

impl Base for Unedited {
    fn chunk(&self, pos: ChunkPos) -> Option<Arc<Chunk>> {
        self.0.chunk(0, pos).to_chunk()
    }

    fn try_chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable> {
        self.0.try_chunk(0, pos).map(|content| content.to_chunk())
    }
}

impl std::fmt::Debug for EditedSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let edited = self.edited.read().unwrap_or_else(PoisonError::into_inner);
        write!(f, "EditedSource({} edited chunks)", edited.chunks.len())
    }
}

impl Edited {
    /// Puts an edited chunk in place, or goes back to that of the source.
    fn put(&mut self, pos: ChunkPos, voxels: Option<Stored>) {
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
        self.chunks.insert(pos, Arc::new(EditedChunk { voxels, coarse: OnceLock::new() }));
        for tile in tiles {
            self.of_tile.entry(tile).or_default().insert(pos);
        }
        let [low, high] = [64 * i64::from(pos.y), 64 * i64::from(pos.y) + 64];
        let [before, after] = self.heights.unwrap_or([low, high]);
        self.heights = Some([before.min(low), after.max(high)]);
    }
}

impl EditedChunk {
    fn content(&self) -> Content {
        self.voxels.chunk().map_or(Content::Empty, Content::of)
    }

    /// Replaces the cells of a tile above level 0 that the chunk is in.
    fn lay(&self, level: u32, pos: ChunkPos, tile: &mut DenseChunk, working: &mut DenseChunk) {
        let within = |mask: i32| [pos.x, pos.y, pos.z].map(|c| (c & mask) as u32);
        match level {
            1 => reduce(&self.content(), within(3), tile),
            2 => {
                let coarse = self.coarse.get_or_init(|| Coarse::of(&self.content(), working));
                let [x, y, z] = within(15);
                let block = block_index(x, y, z);
                tile.apply(block, u64::MAX, Mode::Subtract, AIR);
                for (bit, material) in coarse.block.iter().enumerate().filter(|(_, material)| **material != AIR) {
                    tile.apply(block, 1 << bit, Mode::Add, *material);
                }
            }
            _ => {
                let coarse = self.coarse.get_or_init(|| Coarse::of(&self.content(), working));
                let [x, y, z] = within(63);
                let (block, bit) = voxel_index(x, y, z);
                match coarse.cell {
                    AIR => tile.apply(block, 1 << bit, Mode::Subtract, AIR),
                    material => tile.apply(block, 1 << bit, Mode::Add, material),
                }
            }
        }
    }
}

impl Coarse {
    /// What three reductions leave of a chunk: the first leaves a node, the second a block, the third a cell, each the first of its kind.
    fn of(content: &Content, working: &mut DenseChunk) -> Self {
        working.clear();
        let once = |content: &Content, working: &mut DenseChunk| {
            reduce(content, [0; 3], working);
            Content::pack(working)
        };
        let node = once(content, working);
        let block = once(&node, working);
        let cells = |working: &DenseChunk| {
            let (mask, materials) = (working.masks()[0], working.block(0));
            std::array::from_fn(|bit| if mask >> bit & 1 == 1 { materials[bit] } else { AIR })
        };
        let coarse: [MaterialIndex; 64] = cells(working);
        once(&block, working);
        let last: [MaterialIndex; 64] = cells(working);
        Self { block: coarse, cell: last[0] }
    }
}

/// The tile of a level that a chunk is in.
fn tile_of(level: u32, pos: ChunkPos) -> ChunkPos {
    let shift = 2 * level;
    ChunkPos::new(pos.x >> shift, pos.y >> shift, pos.z >> shift)
}
