//! Models made ready to be put into the tiles of an endless world, at any level.
//!
//! Dozens of models may reach into a tile, and again into each tile of a column. So the facts that do not depend on a model's place are computed
//! once: the box of each of its parts, and their non-empty blocks.

use std::sync::Arc;

use raxel_world::Mode;
use raxel_world::Placement;
use raxel_world::{AIR, MaterialIndex};
use raxel_world::{Bits, Chunk, block_cell, child_cell, voxel_index};
use raxel_world::{Bounds, ChunkPos, World};

use crate::{Draft, Placed};

/// A model made ready.
pub(crate) struct Stamp {
    bounds: Option<Bounds>,
    parts: Vec<Part>,
}

/// A chunk of the model.
struct Part {
    chunk: Arc<Chunk>,
    /// Its smallest voxel.
    origin: [i64; 3],
    bounds: Bounds,
    /// Those that are not empty, in order.
    blocks: Box<[u16]>,
}

/// The cells of a tile.
#[derive(Clone, Copy)]
pub(crate) struct Cells {
    pub(crate) level: u32,
    pub(crate) pos: ChunkPos,
}

impl Cells {
    /// The voxels that they are.
    fn bounds(self) -> Bounds {
        let [min, max] = [0, 64].map(|c| self.origin().map(|first| (first + c) << self.shift()));
        Bounds { min, max }
    }

    fn origin(self) -> [i64; 3] {
        self.pos.origin().to_array().map(i64::from)
    }

    /// A cell has 2^this voxels along an edge.
    fn shift(self) -> u32 {
        2 * self.level
    }
}

impl Stamp {
    #[expect(clippy::cast_possible_truncation, reason = "a chunk has 4096 blocks")]
    pub(crate) fn of(model: &World) -> Self {
        let part = |(pos, chunk): (ChunkPos, &Arc<Chunk>)| {
            let origin = pos.origin().to_array().map(i64::from);
            let bounds = chunk.bounds().moved(origin);
            let blocks = chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0);
            Part { chunk: chunk.clone(), origin, bounds, blocks: blocks.map(|(block, _)| block as u16).collect() }
        };
        Self { bounds: model.bounds(), parts: model.chunks().map(part).collect() }
    }

    /// Whether it reaches into a tile from a place.
    pub(crate) fn reaches(&self, placement: &Placement, cells: Cells) -> bool {
        let tile = cells.bounds();
        let meets = |bounds: &Bounds| meet(&Placed::placed_bounds(bounds, placement), &tile);
        self.bounds.as_ref().is_some_and(meets) && self.parts.iter().any(|part| meets(&part.bounds))
    }

    /// Applies it to a tile. Above level 0, a cell gets the material of the last voxel in it.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cells are inside the tile, whose coordinates are below 64"
    )]
    pub(crate) fn put(
        &self,
        placement: &Placement,
        cells: Cells,
        materials: &[MaterialIndex],
        mode: Mode,
        draft: &mut Draft<'_>,
    ) {
        let (origin, shift) = (cells.origin(), cells.shift());
        self.voxels(placement, cells, |voxel, material| {
            let [x, y, z]: [u32; 3] = std::array::from_fn(|i| ((voxel[i] >> shift) - origin[i]) as u32);
            let (block, bit) = voxel_index(x, y, z);
            draft.chunk.apply(block, 1 << bit, mode, materials[usize::from(material)]);
        });
    }

    /// Adds it to a tile above level 0: the cells that hold at least as many of its voxels as a wall one voxel thick through the cell.
    /// With fewer, most rays pass between them, and a forest would be met far too early. The material is that of the last voxel.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cells are inside the tile, whose coordinates are below 64"
    )]
    pub(crate) fn put_where_thick(
        &self,
        placement: &Placement,
        cells: Cells,
        materials: &[MaterialIndex],
        draft: &mut Draft<'_>,
    ) {
        let Some(bounds) = self.bounds.map(|bounds| Placed::placed_bounds(&bounds, placement)) else { return };
        let (origin, shift) = (cells.origin(), cells.shift());
        // The cells of the tile that it can reach.
        let min: [i64; 3] = std::array::from_fn(|i| (bounds.min[i] >> shift).max(origin[i]));
        let size: [i64; 3] = std::array::from_fn(|i| ((bounds.max[i] - 1) >> shift).min(origin[i] + 63) + 1 - min[i]);
        let mut found = vec![(0u32, AIR); size.iter().map(|s| (*s).max(0)).product::<i64>() as usize];
        self.voxels(placement, cells, |voxel, material| {
            let [x, y, z]: [i64; 3] = std::array::from_fn(|i| (voxel[i] >> shift) - min[i]);
            let (voxels, last) = &mut found[((y * size[2] + z) * size[0] + x) as usize];
            (*voxels, *last) = (*voxels + 1, materials[usize::from(material)]);
        });
        let wall = 1 << (2 * shift);
        for (at, (_, material)) in (0..).zip(found).filter(|(_, (voxels, _))| *voxels >= wall) {
            let cell = [at % size[0], at / size[0] / size[2], at / size[0] % size[2]];
            let [x, y, z]: [u32; 3] = std::array::from_fn(|i| (min[i] + cell[i] - origin[i]) as u32);
            let (block, bit) = voxel_index(x, y, z);
            draft.chunk.apply(block, 1 << bit, Mode::Add, material);
        }
    }

    /// Its voxels in a tile, with their materials in the model's palette.
    #[expect(clippy::cast_possible_truncation, reason = "a block has 64 voxels")]
    fn voxels(&self, placement: &Placement, cells: Cells, mut each: impl FnMut([i64; 3], MaterialIndex)) {
        let tile = cells.bounds();
        // From the first voxel of a block to each.
        let steps: [[i64; 3]; 64] =
            std::array::from_fn(|bit| placement.turn.vector(child_cell(bit as u32).map(i64::from)));
        for part in &self.parts {
            let placed = Placed::placed_bounds(&part.bounds, placement);
            if !meet(&placed, &tile) {
                continue;
            }
            let whole = (0..3).all(|i| tile.min[i] <= placed.min[i] && placed.max[i] <= tile.max[i]);
            for block in part.blocks.iter().map(|block| usize::from(*block)) {
                let local = block_cell(block);
                let first = placement.cell(std::array::from_fn(|i| part.origin[i] + 4 * i64::from(local[i])));
                for (bit, material) in Bits(part.chunk.mask(block)).zip(part.chunk.block_materials(block)) {
                    let voxel = std::array::from_fn(|i| first[i] + steps[bit as usize][i]);
                    if whole || (0..3).all(|i| (tile.min[i]..tile.max[i]).contains(&voxel[i])) {
                        each(voxel, material);
                    }
                }
            }
        }
    }
}

/// Whether two boxes have a voxel in common.
fn meet(a: &Bounds, b: &Bounds) -> bool {
    (0..3).all(|i| a.min[i] < b.max[i] && b.min[i] < a.max[i])
}
