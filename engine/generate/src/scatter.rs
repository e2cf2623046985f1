//! A model at random places: on the ground that was built before, or on the land alone, place by place.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use raxel_world::Mode;
use raxel_world::random::{SplitMix64, mix};
use raxel_world::{AIR, MaterialIndex};
use raxel_world::{Chunk, block_index};
use raxel_world::{ChunkPos, World};
use raxel_world::{Orientation, Placement};
use rayon::prelude::*;

use crate::Operation;
use crate::caves::{CaveField, Caves};
use crate::place::Placed;
use crate::terrain::{Relief, Terrain};

/// The scattered models, and the rules for each place.
pub struct Scattered {
    /// Its voxels.
    pub model: Arc<World>,
    /// Palette index in the world being built, by the model's palette index.
    pub materials: Arc<[MaterialIndex]>,
    /// The cell of the model that comes to stand on the ground.
    pub anchor: [i64; 3],
    /// Smallest x and z of the places.
    pub min: [i64; 2],
    /// One past the largest x and z.
    pub max: [i64; 2],
    /// Materials that it stands on; any when empty.
    pub on: Vec<MaterialIndex>,
    /// Least distance between two of them, in voxels: in the plane, or in a grid along x or z.
    pub spacing: i64,
    /// Voxels that it is sunk into the ground.
    pub sink: i64,
    /// Whether each gets a random quarter turn.
    pub turn: bool,
    /// Same seed, same places.
    pub seed: u64,
    /// Add, subtract or paint.
    pub mode: Mode,
}

impl Scattered {
    /// The placement on a voxel of the ground; `None` where it may not stand, or would leave the world.
    fn placement(&self, [x, z]: [i64; 2], (y, ground): (i64, MaterialIndex), turns: u32) -> Option<Placement> {
        let stands = self.on.is_empty() || self.on.contains(&ground);
        let placement = place_anchor(self.anchor, turns, [x, y + 1 - self.sink, z]);
        let bounds = Placed::placed_bounds(&self.model.bounds()?, &placement);
        let in_range = (0..3).all(|i| bounds.min[i] >= i64::from(i32::MIN) && bounds.max[i] <= i64::from(i32::MAX) + 1);
        (stands && in_range).then_some(placement)
    }

    /// The model at these places.
    fn placed(&self, placements: Vec<Placement>) -> Placed {
        Placed { model: self.model.clone(), materials: self.materials.clone(), placements, mode: self.mode }
    }
}

/// A number of models at random places on the earlier operations' ground.
pub struct Scatter {
    /// The scattered thing.
    pub scattered: Scattered,
    /// How many.
    pub count: u64,
}

impl Scatter {
    /// The largest count.
    pub const MAX_COUNT: u64 = 1 << 20;
    /// Places tried for each one wanted.
    const TRIES: u64 = 32;

    /// Chooses the places on the chunks built so far. They are the same for any number of threads.
    #[expect(clippy::cast_possible_truncation, reason = "a number of turns is below 4")]
    pub(crate) fn choose(&self, chunks: &BTreeMap<ChunkPos, Arc<Chunk>>) -> Placed {
        let Scattered { min, max, spacing, turn, seed, .. } = self.scattered;
        let ground = Ground::new(chunks);
        let mut random = SplitMix64::new(seed);
        let mut taken: HashMap<[i64; 2], Vec<[i64; 2]>> = HashMap::new();
        let bucket_edge = spacing.max(1);
        let mut placements = Vec::new();
        let size: [u64; 2] = std::array::from_fn(|i| (max[i] - min[i]).cast_unsigned());
        for _ in 0..self.count * Self::TRIES {
            if placements.len() as u64 == self.count {
                break;
            }
            let place: [i64; 2] = std::array::from_fn(|i| min[i] + random.below(size[i]).cast_signed());
            let turns = random.below(4) as u32;
            let Some(top) = ground.top(place) else { continue };
            let Some(placement) = self.scattered.placement(place, top, if turn { turns } else { 0 }) else { continue };
            let bucket = place.map(|p| p.div_euclid(bucket_edge));
            let crowded =
                (-1..=1).flat_map(|dz| (-1..=1).map(move |dx| [bucket[0] + dx, bucket[1] + dz])).any(|near| {
                    taken.get(&near).is_some_and(|others| {
                        others.iter().any(|other| {
                            let [dx, dz] = [other[0] - place[0], other[1] - place[1]];
                            dx * dx + dz * dz < spacing * spacing
                        })
                    })
                });
            if crowded {
                continue;
            }
            taken.entry(bucket).or_default().push(place);
            placements.push(placement);
        }
        self.scattered.placed(placements)
    }
}

/// A model at random places on the land, at most one in each cell of a grid. Only the cell and the columns of the land decide whether and
/// where a cell has a model. So any part of an endless world can be made by itself.
pub struct Jittered {
    /// The scattered thing. Its spacing is less than `cell`.
    pub scattered: Scattered,
    /// Voxels along a cell of the grid.
    pub cell: i64,
    /// The probability that a cell has one, in 0…1.
    pub chance: f64,
}

impl Jittered {
    /// The most cells that are looked at for a world that is built whole.
    pub const MAX_CELLS: u64 = 1 << 22;

    /// The column and the number of quarter turns of a cell's model, if the land there allows one.
    #[expect(clippy::cast_possible_truncation, reason = "a number of turns is below 4")]
    pub(crate) fn candidate(&self, [x, z]: [i64; 2]) -> Option<([i64; 2], u32)> {
        let mut random = SplitMix64::new(mix(self.scattered.seed ^ mix(x.cast_unsigned() ^ mix(z.cast_unsigned()))));
        // The upper 53 bits: every one of them counts in an f64.
        if (random.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64) >= self.chance {
            return None;
        }
        let room = (self.cell - self.scattered.spacing).max(1).cast_unsigned();
        let place = [x, z].map(|c| c * self.cell + random.below(room).cast_signed());
        let turns = random.below(4) as u32;
        let inside = (0..2).all(|i| (self.scattered.min[i]..self.scattered.max[i]).contains(&place[i]));
        inside.then_some((place, if self.scattered.turn { turns } else { 0 }))
    }

    /// The placement of a cell of the grid; `None` when it has none.
    pub(crate) fn placement(&self, cell: [i64; 2], land: &Land<'_>) -> Option<Placement> {
        let (place, turns) = self.candidate(cell)?;
        self.scattered.placement(place, land.top(place)?, turns)
    }

    /// Cells of the grid whose models can reach into a box of columns: half-open ranges along x and z.
    pub(crate) fn cells(&self, min: [i64; 2], max: [i64; 2]) -> [std::ops::Range<i64>; 2] {
        let reach = self.reach();
        [0, 1].map(|i| {
            let low = min[i].saturating_sub(reach).max(self.scattered.min[i]);
            let high = max[i].saturating_add(reach).min(self.scattered.max[i]);
            low.div_euclid(self.cell)..(high - 1).div_euclid(self.cell) + 1
        })
    }

    /// The largest distance of its voxels from its place in the plane, for any turn.
    fn reach(&self) -> i64 {
        let Some(bounds) = self.scattered.model.bounds() else { return 0 };
        let ends = [0, 2].map(|i| {
            let last = bounds.max[i] - 1;
            (self.scattered.anchor[i] - bounds.min[i]).abs().max((last - self.scattered.anchor[i]).abs())
        });
        ends[0].max(ends[1]) + 1
    }

    /// Voxels of the model below its anchor.
    pub(crate) fn depth(&self) -> i64 {
        self.scattered.model.bounds().map_or(0, |bounds| (self.scattered.anchor[1] - bounds.min[1]).max(0))
    }

    /// Whether the model is too small to be seen in cells of a level: less than two of them along every side.
    pub(crate) fn is_small(&self, level: u32) -> bool {
        let size = self.scattered.model.bounds().map_or([0; 3], |bounds| bounds.size());
        level > 0 && size.iter().all(|side| side.cast_signed() < 2 * raxel_world::cell_edge(level))
    }

    /// Whether all of it is sunk into the ground: it shows in caves and cuts alone.
    pub(crate) fn is_buried(&self) -> bool {
        self.scattered
            .model
            .bounds()
            .is_some_and(|bounds| bounds.max[1] - 1 - self.scattered.anchor[1] < self.scattered.sink)
    }

    /// Whether they cover at least an eighth of the land, seen from above, where each cell of the grid has one.
    pub(crate) fn is_dense(&self) -> bool {
        let [x, _, z] = self.scattered.model.bounds().map_or([0; 3], |bounds| bounds.size().map(u128::from));
        8 * x * z >= u128::from(self.cell.unsigned_abs()).pow(2)
    }

    /// The material that most of the model's voxels are of.
    pub(crate) fn commonest(&self) -> Option<MaterialIndex> {
        let counts = self.scattered.model.counts().iter().enumerate().filter(|(_, count)| **count > 0);
        counts
            .max_by_key(|(index, count)| (**count, std::cmp::Reverse(*index)))
            .map(|(index, _)| self.scattered.materials[index])
    }

    /// How many cells its area has.
    pub fn cell_count(&self) -> u128 {
        let count = |i: usize| {
            u128::from((self.scattered.max[i] - self.scattered.min[i]).unsigned_abs() / self.cell.unsigned_abs()) + 2
        };
        count(0) * count(1)
    }

    /// All of them.
    pub(crate) fn choose(&self, land: &Land<'_>) -> Placed {
        let [xs, zs] = self.cells(self.scattered.min, self.scattered.max);
        let rows: Vec<i64> = zs.collect();
        let placements = rows
            .into_par_iter()
            .flat_map_iter(|z| xs.clone().filter_map(move |x| self.placement([x, z], land)))
            .collect();
        self.scattered.placed(placements)
    }
}

/// The land that the terrains of a build make, without anything else that is built on it.
pub(crate) struct Land<'t> {
    terrains: Vec<(Relief<'t>, Option<CaveField<'t>>, &'t Terrain)>,
}

impl<'t> Land<'t> {
    /// The land of the terrains among these operations.
    pub(crate) fn of(operations: impl Iterator<Item = &'t Operation>) -> Self {
        let terrains = operations.filter_map(|operation| match operation {
            Operation::Terrain(terrain) if terrain.mode == Mode::Add => {
                Some((terrain.relief(), terrain.caves.as_ref().map(Caves::field), terrain))
            }
            _ => None,
        });
        Self { terrains: terrains.collect() }
    }

    /// The uppermost voxel of a column and its material. `None` where there is no land, and where a cave has taken that voxel.
    pub(crate) fn top(&self, [x, z]: [i64; 2]) -> Option<(i64, MaterialIndex)> {
        let tops = self.terrains.iter().filter_map(|(relief, caves, terrain)| {
            let (y, material) = relief.top(x, z)?;
            Some((y, material, caves, terrain))
        });
        let (y, material, caves, terrain) = tops.max_by_key(|(y, ..)| *y)?;
        let level = terrain.water.as_ref().map_or(i64::MIN, |water| water.level);
        let taken = y >= level
            && caves
                .as_ref()
                .zip(terrain.caves.as_ref())
                .is_some_and(|(field, caves)| y < caves.ceiling(y + 1, level) && field.is_hollow([x, y, z]));
        (!taken).then_some((y, material))
    }
}

/// The placement that turns a model about its anchor cell and brings that cell to `to`.
pub fn place_anchor(anchor: [i64; 3], turns: u32, to: [i64; 3]) -> Placement {
    let turn = Orientation::quarter_turns(turns);
    let turned = turn.cell(anchor);
    Placement { turn, to: std::array::from_fn(|i| to[i] - turned[i]) }
}

/// Finds the uppermost voxel of a column.
struct Ground<'a> {
    /// Chunks of each column of chunks, highest first.
    columns: HashMap<[i32; 2], Vec<(i32, &'a Chunk)>>,
}

impl<'a> Ground<'a> {
    fn new(chunks: &'a BTreeMap<ChunkPos, Arc<Chunk>>) -> Self {
        let mut columns: HashMap<[i32; 2], Vec<(i32, &Chunk)>> = HashMap::new();
        for (pos, chunk) in chunks.iter().rev() {
            columns.entry([pos.x, pos.z]).or_default().push((pos.y, chunk));
        }
        Self { columns }
    }

    /// Height and material.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "land lies within ±2²⁵ chunks, and columns further out have none"
    )]
    fn top(&self, [x, z]: [i64; 2]) -> Option<(i64, MaterialIndex)> {
        let column = self.columns.get(&[(x >> 6) as i32, (z >> 6) as i32])?;
        let (x, z) = ((x & 63) as u32, (z & 63) as u32);
        for (chunk_y, chunk) in column {
            for by in (0..16).rev() {
                let mask = chunk.mask(block_index(x >> 2, by, z >> 2));
                let column = mask >> (x & 3 | (z & 3) << 2) & 0x0001_0001_0001_0001;
                if column != 0 {
                    let y = by * 4 + column.ilog2() / 16;
                    let material = chunk.voxel(x, y, z);
                    debug_assert_ne!(material, AIR);
                    return Some((i64::from(*chunk_y) * 64 + i64::from(y), material));
                }
            }
        }
        None
    }
}
