//! Tiles: the pieces of a world that is never whole in memory.

use std::sync::Arc;

use crate::chunk::{CHUNK_VOXELS, Chunk};
use crate::dense::{DenseChunk, Mode};
use crate::material::{AIR, Material, MaterialIndex};
use crate::world::{ChunkPos, World};

/// The content of a tile. A tile of level 0 is a chunk; one of level l has 64³ cells of 4^l voxels a side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// No solid cell.
    Empty,
    /// Every cell is of this material.
    Full(MaterialIndex),
    /// Anything else. Its voxels are the cells of the tile.
    Chunk(Arc<Chunk>),
}

/// Levels above 0 that worlds have: cells of up to 4³ = 64 voxels.
pub const MAX_LEVEL: u32 = 3;

/// Voxels along a cell of a level.
#[inline]
pub const fn cell_edge(level: u32) -> i64 {
    1 << (2 * level)
}

/// A source of the contents of tiles. An answer depends only on the tile: earlier requests and the thread do not matter.
pub trait ChunkProvider: Send + Sync {
    /// The palette of all its tiles; index 0 is air.
    fn materials(&self) -> &[Material];

    /// The cells of a tile, of a level of at most [`MAX_LEVEL`]; `pos` counts tiles of that level.
    ///
    /// # Errors
    /// When the source cannot know the cells: a store does not answer, or its bytes are missing or damaged. The source never answers
    /// [`Content::Empty`] for such a tile.
    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable>;

    /// The previous owner just released this tile: sources that remember tiles remember this one longest.
    fn on_evicted(&self, _level: u32, _pos: ChunkPos) {}

    /// Smallest and one past the largest height that a voxel can have; `None` when that is not known, or there are none.
    fn height_range(&self) -> Option<[i64; 2]> {
        None
    }

    /// The identity of its voxels, if they come from outside of the world's file.
    fn fingerprint(&self) -> Option<&str> {
        None
    }

    /// The highest level that it has tiles of.
    fn top_level(&self) -> u32 {
        MAX_LEVEL
    }
}

/// A tile that a source cannot give: which one, and why. It is unknown whether it is solid or air.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} is unavailable: {reason}", name_of(*.level, *.pos))]
pub struct Unavailable {
    /// The level of the tile; 0 for a chunk.
    pub level: u32,
    /// Where it lies, in tiles of that level.
    pub pos: ChunkPos,
    /// The type of failure.
    pub cause: Cause,
    /// The reason in words: the place of the bytes, and their fault.
    pub reason: Arc<str>,
}

/// Why a source cannot give a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// There are no bytes of it: they were never written, or somebody removed them.
    Missing,
    /// Its bytes are not those that were written for it.
    Damaged,
    /// The store does not answer, or refuses to.
    Failing,
    /// The code that makes it panicked: the next request gets the same answer.
    Panicked,
}

impl Unavailable {
    /// A tile of a level, with the reason in words.
    pub fn new(level: u32, pos: ChunkPos, cause: Cause, reason: impl Into<Arc<str>>) -> Self {
        Self { level, pos, cause, reason: reason.into() }
    }
}

fn name_of(level: u32, ChunkPos { x, y, z }: ChunkPos) -> String {
    match level {
        0 => format!("the chunk at {x}, {y}, {z}"),
        _ => format!("the tile at {x}, {y}, {z} of level {level}"),
    }
}

impl Content {
    /// Packs a working copy.
    pub fn pack(dense: &DenseChunk) -> Self {
        Chunk::pack(dense).map_or(Self::Empty, |chunk| Self::of(Arc::new(chunk)))
    }

    /// A chunk, or its only material.
    pub fn of(chunk: Arc<Chunk>) -> Self {
        match chunk.uniform() {
            Some(material) if chunk.solids() as usize == CHUNK_VOXELS => Self::Full(material),
            _ => Self::Chunk(chunk),
        }
    }

    /// The cells as a chunk; `None` when there is no solid one.
    pub fn to_chunk(&self) -> Option<Arc<Chunk>> {
        match self {
            Self::Empty => None,
            Self::Full(material) => Some(Arc::new(Chunk::full(*material))),
            Self::Chunk(chunk) => Some(chunk.clone()),
        }
    }

    /// Takes over the cells into a working copy.
    pub fn unpack(&self, dense: &mut DenseChunk) {
        dense.clear();
        match self {
            Self::Empty => {}
            Self::Full(material) => dense.fill(*material),
            Self::Chunk(chunk) => dense.unpack(chunk),
        }
    }
}

impl ChunkProvider for World {
    fn materials(&self) -> &[Material] {
        Self::materials(self)
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.tile(level, pos))
    }
}

impl World {
    /// The cells of a tile, of a level of at most [`MAX_LEVEL`]; `pos` counts tiles of that level.
    pub fn tile(&self, level: u32, pos: ChunkPos) -> Content {
        if level == 0 {
            return self.chunk(pos).map_or(Content::Empty, |chunk| Content::of(chunk.clone()));
        }
        let mut dense = DenseChunk::default();
        let below = ChunkPos::new(pos.x << 2, pos.y << 2, pos.z << 2);
        for child in 0..64 {
            let [x, y, z] = crate::chunk::child_cell(child).map(u32::cast_signed);
            let pos = ChunkPos::new(below.x + x, below.y + y, below.z + z);
            reduce(&self.tile(level - 1, pos), [x, y, z].map(i32::cast_unsigned), &mut dense);
        }
        Content::pack(&dense)
    }
}

/// Writes a tile, as it looks one level above, into its 16³ cells of the tile around it: `place`, each in 0…3, is where it lies in that. A
/// cell is solid if any of the 4³ cells below is solid. So a coarse tile stops every ray that a finer one would have stopped. The cell
/// gets the most frequent material of these cells, and of equally frequent ones the lowest index.
pub fn reduce(content: &Content, place: [u32; 3], coarse: &mut DenseChunk) {
    let node = crate::chunk::child_index(place[0], place[1], place[2]) as usize;
    for block in node * 64..node * 64 + 64 {
        coarse.apply(block, u64::MAX, Mode::Subtract, AIR);
        match content {
            Content::Empty => {}
            Content::Full(material) => coarse.apply(block, u64::MAX, Mode::Add, *material),
            // The cells of a block of the coarse tile are the blocks of a node of the fine one, in the same order.
            Content::Chunk(chunk) => (0..64).for_each(|bit| {
                if let Some(material) = commonest(chunk, (block & 63) * 64 + bit) {
                    coarse.apply(block, 1 << bit, Mode::Add, material);
                }
            }),
        }
    }
}

/// The material that most voxels of a 4³ block are of; `None` when it has no solid one.
fn commonest(chunk: &Chunk, block: usize) -> Option<MaterialIndex> {
    if chunk.mask(block) == 0 {
        return None;
    }
    if let Some(material) = chunk.block_uniform(block) {
        return Some(material);
    }
    let mut counts: [(MaterialIndex, u32); 64] = [(0, 0); 64];
    let mut different = 0;
    for material in chunk.block_materials(block) {
        if let Some((_, count)) = counts[..different].iter_mut().find(|(known, _)| *known == material) {
            *count += 1;
        } else {
            counts[different] = (material, 1);
            different += 1;
        }
    }
    let most = counts[..different].iter().max_by_key(|(material, count)| (*count, std::cmp::Reverse(*material)));
    most.map(|(material, _)| *material)
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;

    #[test]
    fn coarse_cells_are_solid_wherever_a_voxel_is() {
        let voxels = [([0, 0, 0], 1), ([1, 0, 0], 2), ([2, 0, 0], 2), ([-1, 63, 200], 1), ([300, -5, 7], 2)];
        let world = World::from_voxels(
            vec![Material::air(); 3],
            voxels.map(|(cell, material)| (IVec3::from_array(cell), material)),
        );
        for level in 1..=MAX_LEVEL {
            let edge = cell_edge(level);
            let mut found = Vec::new();
            for z in -1..=4 {
                for y in -1..=1 {
                    for x in -1..=4 {
                        let pos = ChunkPos::new(x, y, z);
                        let Content::Chunk(chunk) = world.tile(level, pos) else { continue };
                        let origin = pos.origin().to_array();
                        let cells = chunk.iter().map(|(local, material)| {
                            let cell: [i64; 3] = std::array::from_fn(|i| i64::from(origin[i]) + i64::from(local[i]));
                            (cell, material)
                        });
                        found.extend(cells.collect::<Vec<_>>());
                    }
                }
            }
            let mut expected: Vec<([i64; 3], u16)> = vec![
                ([0, 0, 0], 2),
                ([-1, 63, 200].map(|c: i64| c.div_euclid(edge)), 1),
                ([300, -5, 7].map(|c: i64| c.div_euclid(edge)), 2),
            ];
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "level {level}");
        }
    }
}
