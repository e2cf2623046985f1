//! Worlds without end: the operations of a build, asked for one tile at a time.
//!
//! The contents of a tile follow from the operations, the tile and its level alone. Heights of columns are kept for a while, since the tiles above
//! and below each other share them; that shows nowhere but in the time.

mod recent;

use std::cell::RefCell;
use std::sync::Arc;

use raxel_world::Placement;
use raxel_world::{Bits, block_index, child_cell, voxel_index};
use raxel_world::{Bounds, ChunkPos};
use raxel_world::{ChunkProvider, Content, MAX_LEVEL, Unavailable, cell_edge};
use raxel_world::{DenseChunk, Mode};
use raxel_world::{Material, MaterialIndex};

use crate::scatter::Land;
use crate::shape::Span3;
use crate::stamp::{Cells, Stamp};
use crate::terrain::Heights;
use crate::{Draft, Jittered, Operation, Placed, Solid, Terrain};
use recent::Recent;

/// Columns of tiles whose heights and models are kept: 35 kB each.
const KEPT_COLUMNS: usize = 1024;

/// The operations of a world file, ready to make any tile. At most one stage: a [`crate::Scatter`], which has to see everything
/// that was built before, is no part of it.
pub struct Generator {
    materials: Vec<Material>,
    operations: Vec<Operation>,
    /// For each operation, the model that it places, if it does.
    stamps: Vec<Option<Stamp>>,
    heights: Recent<Column, Heights>,
    placements: Recent<Column, Vec<Placement>>,
}

/// A column of tiles for an operation: its index, the level, x, z.
type Column = (usize, u32, i32, i32);

/// An operation that only sees the world when it is built whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("operation {operation} scatters by count, over everything that was built before")]
pub struct NeedsWhole {
    /// Its index.
    pub operation: usize,
}

thread_local! {
    /// Half a megabyte, which every thread that makes tiles keeps.
    static WORKING: RefCell<DenseChunk> = RefCell::default();
}

/// The contents of a tile after some of the operations.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// The same in every cell; air is empty.
    Uniform(MaterialIndex),
    /// The working copy has it.
    Mixed,
}

impl Generator {
    /// Takes over operations whose materials are in the palette.
    pub fn new(materials: Vec<Material>, operations: Vec<Operation>) -> Result<Self, NeedsWhole> {
        let whole = |operation: &Operation| matches!(operation, Operation::Scatter(_));
        if let Some(operation) = operations.iter().position(whole) {
            return Err(NeedsWhole { operation });
        }
        let stamp = |operation: &Operation| match operation {
            Operation::Place(placed) => Some(Stamp::of(&placed.model)),
            Operation::Jittered(jittered) => Some(Stamp::of(&jittered.scattered.model)),
            _ => None,
        };
        let stamps = operations.iter().map(stamp).collect();
        let (heights, placements) = (Recent::new(KEPT_COLUMNS), Recent::new(KEPT_COLUMNS));
        Ok(Self { materials, operations, stamps, heights, placements })
    }

    fn heights(&self, index: usize, terrain: &Terrain, level: u32, pos: ChunkPos) -> Arc<Heights> {
        self.heights.get((index, level, pos.x, pos.z), || terrain.heights(pos.x, pos.z))
    }

    /// The models that can reach into a column of tiles.
    fn placements(&self, index: usize, jittered: &Jittered, level: u32, pos: ChunkPos) -> Arc<Vec<Placement>> {
        self.placements.get((index, level, pos.x, pos.z), || {
            let edge = 64 * cell_edge(level);
            let min = [i64::from(pos.x) * edge, i64::from(pos.z) * edge];
            let [xs, zs] = jittered.cells(min, min.map(|c| c + edge));
            let land = Land::of(self.operations[..index].iter());
            zs.flat_map(|z| xs.clone().map(move |x| [x, z]))
                .filter_map(|cell| jittered.placement(cell, &land))
                .collect()
        })
    }

    /// The cells of a tile, of a level of at most [`MAX_LEVEL`]; `pos` counts tiles of that level. Builds them on this thread.
    pub fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        debug_assert!(level <= MAX_LEVEL);
        WORKING.with_borrow_mut(|dense| self.make(level, pos, dense))
    }

    fn make(&self, level: u32, pos: ChunkPos, dense: &mut DenseChunk) -> Content {
        let mut tile = Tile { level, pos, state: State::Uniform(0), dense };
        for (index, (operation, stamp)) in self.operations.iter().zip(&self.stamps).enumerate() {
            match operation {
                Operation::Solid(solid) => tile.solid(solid),
                Operation::Terrain(terrain) => {
                    let terrain = &terrain.at_level(level);
                    let bounds = terrain.bounds();
                    if !tile.meets(&bounds) {
                        continue;
                    }
                    let heights = self.heights(index, terrain, level, pos);
                    match terrain.span(pos.y, &heights, terrain.covers_tile(pos.x, pos.z)) {
                        Span3::Outside => {}
                        Span3::Inside => tile.whole(terrain.mode, terrain.deepest()),
                        Span3::Both => {
                            let surface = terrain.surface_of(&heights, pos.x, pos.z);
                            tile.mixed(|draft| terrain.apply(draft, &surface));
                        }
                    }
                }
                Operation::Place(placed) => {
                    for placement in &placed.placements {
                        tile.stamp(stamp.as_ref(), &placed.materials, placement, placed.mode);
                    }
                }
                // Above level 0 there are no caves that could show it.
                Operation::Jittered(jittered) if level > 0 && jittered.is_buried() => {}
                Operation::Jittered(jittered) => {
                    if jittered.is_small(level) {
                        if jittered.is_dense() {
                            tile.tint(jittered);
                        }
                    } else if tile.can_have(jittered, self.height_range()) {
                        for placement in self.placements(index, jittered, level, pos).iter() {
                            if level > 0 && jittered.scattered.mode == Mode::Add {
                                tile.stamp_where_thick(stamp.as_ref(), &jittered.scattered.materials, placement);
                            } else {
                                tile.stamp(
                                    stamp.as_ref(),
                                    &jittered.scattered.materials,
                                    placement,
                                    jittered.scattered.mode,
                                );
                            }
                        }
                    }
                }
                Operation::Scatter(_) => unreachable!("`new` has refused it"),
            }
        }
        match tile.state {
            State::Uniform(0) => Content::Empty,
            State::Uniform(material) => Content::Full(material),
            State::Mixed => Content::pack(tile.dense),
        }
    }
}

impl ChunkProvider for Generator {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        Ok(self.chunk(level, pos))
    }

    fn height_range(&self) -> Option<[i64; 2]> {
        let of = |operation: &Operation| {
            let bounds = match operation {
                Operation::Solid(solid) if solid.mode == Mode::Add => solid.shape.bounds(),
                Operation::Terrain(terrain) if terrain.mode == Mode::Add => terrain.bounds(),
                Operation::Place(placed) if placed.mode == Mode::Add => {
                    let model = placed.model.bounds()?;
                    let all = placed.placements.iter().map(|placement| Placed::placed_bounds(&model, placement));
                    all.reduce(Bounds::union)?
                }
                _ => return None,
            };
            Some([bounds.min[1], bounds.max[1]])
        };
        let union = |a: [i64; 2], b: [i64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let built = self.operations.iter().filter_map(of).reduce(union)?;
        // Models stand on the land, sunk into it at most.
        let above = self.operations.iter().filter_map(|operation| match operation {
            Operation::Jittered(jittered) => {
                let size = jittered.scattered.model.bounds()?.size();
                Some(size[0].max(size[1]).max(size[2]).cast_signed().saturating_sub(jittered.scattered.sink.min(0)))
            }
            _ => None,
        });
        Some([built[0], built[1].saturating_add(above.max().unwrap_or(0))])
    }
}

impl std::fmt::Debug for Generator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Generator({} operations)", self.operations.len())
    }
}

/// A tile on its way through the operations.
struct Tile<'d> {
    level: u32,
    pos: ChunkPos,
    state: State,
    dense: &'d mut DenseChunk,
}

impl Tile<'_> {
    /// Whether a box of cells of this level meets it.
    fn meets(&self, bounds: &Bounds) -> bool {
        let origin = self.pos.origin().to_array().map(i64::from);
        (0..3).all(|i| bounds.min[i] < origin[i] + 64 && bounds.max[i] > origin[i])
    }

    /// A box of voxels in cells.
    fn in_cells(&self, bounds: &Bounds) -> Bounds {
        let edge = cell_edge(self.level);
        let (min, max) = (bounds.min.map(|c| c.div_euclid(edge)), bounds.max.map(|c| -(-c).div_euclid(edge)));
        Bounds { min, max }
    }

    /// Applies a mode to every cell.
    fn whole(&mut self, mode: Mode, material: MaterialIndex) {
        match (mode, self.state) {
            (Mode::Subtract, _) => self.state = State::Uniform(0),
            (Mode::Paint, State::Uniform(0)) => {}
            (Mode::Add, _) | (Mode::Paint, State::Uniform(_)) => self.state = State::Uniform(material),
            (Mode::Paint, State::Mixed) => {
                (0..raxel_world::BLOCKS).for_each(|block| self.dense.apply(block, u64::MAX, mode, material));
            }
        }
    }

    /// Applies an operation that treats cells differently.
    fn mixed(&mut self, apply: impl FnOnce(&mut Draft<'_>)) {
        match self.state {
            State::Uniform(0) => self.dense.clear(),
            State::Uniform(material) => self.dense.fill(material),
            State::Mixed => {}
        }
        self.state = State::Mixed;
        apply(&mut Draft { pos: self.pos, chunk: self.dense });
    }

    fn solid(&mut self, solid: &Solid) {
        if !self.meets(&self.in_cells(&solid.shape.bounds())) {
            return;
        }
        if self.level == 0 {
            let origin = self.pos.origin().to_array().map(i64::from);
            match solid.shape.span(origin, 64) {
                Span3::Outside => {}
                Span3::Inside if solid.materials.len() <= 1 => {
                    self.whole(solid.mode, solid.materials.first().copied().unwrap_or_default());
                }
                Span3::Inside | Span3::Both => self.mixed(|draft| solid.apply(draft)),
            }
            return;
        }
        let edge = cell_edge(self.level);
        self.mixed(|draft| {
            let origin = draft.pos.origin().to_array().map(i64::from);
            for block in 0..raxel_world::BLOCKS {
                let cell = raxel_world::block_cell(block);
                let corner: [i64; 3] = std::array::from_fn(|i| (origin[i] + 4 * i64::from(cell[i])) * edge);
                let whole = solid.shape.span(corner, 4 * edge);
                for bit in Bits(if whole == Span3::Outside { 0 } else { u64::MAX }) {
                    let inner = child_cell(bit).map(i64::from);
                    let min: [i64; 3] = std::array::from_fn(|i| corner[i] + inner[i] * edge);
                    let span = if whole == Span3::Inside { whole } else { solid.shape.span(min, edge) };
                    // A coarse cell is solid where any voxel is, and empty only where all are taken away.
                    let covered = match solid.mode {
                        Mode::Subtract => span == Span3::Inside,
                        Mode::Add | Mode::Paint => span != Span3::Outside,
                    };
                    if covered {
                        let count = solid.materials.len().max(1);
                        // The centre of a coarse cell may lie beside a shape that reaches into the cell.
                        let bounds = solid.shape.bounds();
                        let middle: [i64; 3] =
                            std::array::from_fn(|i| (min[i] + edge / 2).clamp(bounds.min[i], bounds.max[i] - 1));
                        let material = solid.materials.get(solid.shape.material(middle) % count).copied();
                        draft.chunk.apply(block, 1 << bit, solid.mode, material.unwrap_or_default());
                    }
                }
            }
        });
    }

    /// Whether a model on the land can reach into its heights.
    fn can_have(&self, jittered: &Jittered, range: Option<[i64; 2]>) -> bool {
        let Some([low, high]) = range else { return false };
        let edge = 64 * cell_edge(self.level);
        let y = i64::from(self.pos.y) * edge;
        y < high && y + edge > low.saturating_sub(jittered.scattered.sink.max(0)).saturating_sub(jittered.depth())
    }

    fn cells(&self) -> Cells {
        Cells { level: self.level, pos: self.pos }
    }

    /// Applies a model. Above level 0 no cell is emptied.
    fn stamp(&mut self, stamp: Option<&Stamp>, materials: &[MaterialIndex], placement: &Placement, mode: Mode) {
        let cells = self.cells();
        let Some(stamp) = stamp.filter(|_| self.level == 0 || mode != Mode::Subtract) else { return };
        if stamp.reaches(placement, cells) {
            self.mixed(|draft| stamp.put(placement, cells, materials, mode, draft));
        }
    }

    /// Adds a scattered model above level 0.
    fn stamp_where_thick(&mut self, stamp: Option<&Stamp>, materials: &[MaterialIndex], placement: &Placement) {
        let cells = self.cells();
        if let Some(stamp) = stamp.filter(|stamp| stamp.reaches(placement, cells)) {
            self.mixed(|draft| stamp.put_where_thick(placement, cells, materials, draft));
        }
    }

    /// Models that are too small for cells of this level colour the ground that they stand on.
    fn tint(&mut self, jittered: &Jittered) {
        let (State::Mixed, Some(material)) = (self.state, jittered.commonest()) else { return };
        let edge = cell_edge(self.level);
        let origin = self.pos.origin().to_array().map(i64::from);
        let tops: Vec<[u32; 3]> = (0..64 * 64).filter_map(|i| top_cell(self.dense, i & 63, i >> 6)).collect();
        for [x, y, z] in tops {
            let (block, bit) = voxel_index(x, y, z);
            let ground = self.dense.block(block)[bit as usize];
            let middle = [x, z].map(i64::from).into_iter().zip([origin[0], origin[2]]);
            let mut of_grid = [0; 2];
            of_grid.iter_mut().zip(middle).for_each(|(to, (local, from))| {
                *to = ((from + local) * edge + edge / 2).div_euclid(jittered.cell);
            });
            if (jittered.scattered.on.is_empty() || jittered.scattered.on.contains(&ground))
                && jittered.candidate(of_grid).is_some()
            {
                self.dense.apply(block, 1 << bit, Mode::Paint, material);
            }
        }
    }
}

/// The uppermost solid cell of a column, unless it is at the very top: then the ground may go on in the tile above.
fn top_cell(dense: &DenseChunk, x: u32, z: u32) -> Option<[u32; 3]> {
    let column = |by: u32| {
        let mask = dense.masks()[block_index(x >> 2, by, z >> 2)];
        mask >> (x & 3 | (z & 3) << 2) & 0x0001_0001_0001_0001
    };
    let by = (0..16).rev().find(|by| column(*by) != 0)?;
    let y = by * 4 + column(by).ilog2() / 16;
    (y < 63).then_some([x, y, z])
}
