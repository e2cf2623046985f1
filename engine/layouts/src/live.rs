//! Layouts in a buffer with room to spare. An edit replaces only the touched parts.

use std::sync::Arc;

use raxel_world::Chunk;
use raxel_world::{ChunkPos, World};

use super::hashed_chunks::LiveHashedChunks;
use super::header::{Extent, MAX_LOG2_SIZE};
use super::{Edits, Layout, LayoutError, LiveTree64};

/// Voxels around the world that edits can reach without another buffer.
const MARGIN: i64 = 256;

/// Words that changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Index of the first one in the buffer.
    pub at: usize,
    /// The words.
    pub words: Vec<u32>,
}

/// A world in a buffer that follows edits.
#[derive(Debug)]
pub enum LiveLayout {
    /// In blocks of any size.
    Tree64(Box<LiveTree64>),
    /// In blocks of one size: the layouts `octree` and `chunk_table`.
    HashedChunks(Box<LiveHashedChunks>),
}

impl LiveLayout {
    /// Puts a world into a buffer of at most `limit` bytes, whose words are returned as well. A layout that does not follow edits
    /// ([`Layout::follows_edits`]) is taken as `tree64`.
    pub fn new(layout: Layout, world: &World, limit: u64) -> Result<(Self, Vec<u32>), LayoutError> {
        match layout.edits() {
            Edits::HashedChunks(form) => LiveHashedChunks::new(form, world, limit)
                .map(|(live, words)| (Self::HashedChunks(Box::new(live)), words)),
            Edits::Tree64 | Edits::Encode => {
                LiveTree64::new(world, limit).map(|(live, words)| (Self::Tree64(Box::new(live)), words))
            }
        }
    }

    /// Follows a change of chunks, after which the world is `world`. Gives the changed words, in parts that do not overlap; `None` when the
    /// world no longer fits. Then encode it again.
    pub fn update(
        &mut self,
        world: &World,
        changes: impl IntoIterator<Item = (ChunkPos, Option<Arc<Chunk>>)>,
    ) -> Option<Vec<Patch>> {
        match self {
            Self::Tree64(live) => live.update(world, changes),
            Self::HashedChunks(live) => live.update(world, changes),
        }
    }
}

/// A cube around a world, with a margin if coordinates have room for one.
pub(super) fn roomy(world: &World, layout: Layout) -> Result<Extent, LayoutError> {
    let tight = Extent::of(world, layout)?;
    let Some(bounds) = world.bounds() else { return Ok(Extent { origin: [-512; 3], log2_size: 10, ..tight }) };
    let low = bounds.min.map(|min| (min - MARGIN).max(-(1 << 31)) & !63);
    let span = (0..3).map(|i| bounds.max[i] + MARGIN - low[i]).max().unwrap_or(1);
    let Some(log2_size) = (6..=MAX_LOG2_SIZE).step_by(2).find(|log2| span <= 1 << log2) else { return Ok(tight) };
    let origin = low.map(|low| low.min((1 << 31) - (1 << log2_size)) as i32);
    Ok(Extent { origin, log2_size, ..tight })
}

impl Extent {
    /// The same cube with the box of the solid voxels of another world.
    pub(super) fn with_bounds_of(self, world: &World) -> Self {
        let Some(bounds) = world.bounds() else { return Self { bounds_min: [0; 3], bounds_last: [-1; 3], ..self } };
        Self {
            bounds_min: bounds.min.map(|min| min as i32),
            bounds_last: bounds.max.map(|max| (max - 1) as i32),
            ..self
        }
    }

    /// Whether the cube holds a chunk.
    pub(super) fn holds(&self, pos: ChunkPos) -> bool {
        let at = pos.origin().to_array();
        (0..3).all(|i| (0..1_i64 << self.log2_size).contains(&(i64::from(at[i]) - i64::from(self.origin[i]))))
    }
}
