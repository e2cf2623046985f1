//! A model at random places on the ground that was built before.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::build::place::Placed;
use crate::chunk::{Chunk, block_index};
use crate::dense::Mode;
use crate::material::{AIR, MaterialIndex};
use crate::orientation::{Orientation, Placement};
use crate::random::SplitMix64;
use crate::world::{ChunkPos, World};

/// What to scatter, where and how densely.
pub struct Scatter {
    /// Its voxels.
    pub model: Arc<World>,
    /// Palette index in the world being built, by the model's palette index.
    pub materials: Arc<[MaterialIndex]>,
    /// The cell of the model that comes to stand on the ground.
    pub anchor: [i64; 3],
    /// How many.
    pub count: u64,
    /// Smallest x and z.
    pub min: [i64; 2],
    /// One past the largest x and z.
    pub max: [i64; 2],
    /// Materials that it stands on; any when empty.
    pub on: Vec<MaterialIndex>,
    /// Least distance between two of them, in voxels in the plane.
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

impl Scatter {
    /// At most so many can be asked for.
    pub const MAX_COUNT: u64 = 1 << 20;
    /// Places tried for each one wanted.
    const TRIES: u64 = 32;

    /// Chooses the places on the chunks built so far. They are the same whatever the number of threads.
    pub(crate) fn choose(&self, chunks: &BTreeMap<ChunkPos, Arc<Chunk>>) -> Placed {
        let ground = Ground::new(chunks);
        let mut random = SplitMix64::new(self.seed);
        let mut taken: HashMap<[i64; 2], Vec<[i64; 2]>> = HashMap::new();
        let bucket_edge = self.spacing.max(1);
        let mut placements = Vec::new();
        let size: [u64; 2] = std::array::from_fn(|i| (self.max[i] - self.min[i]) as u64);
        for _ in 0..self.count * Self::TRIES {
            if placements.len() as u64 == self.count {
                break;
            }
            let place: [i64; 2] = std::array::from_fn(|i| self.min[i] + random.below(size[i]) as i64);
            let turns = random.below(4) as u32;
            let Some((y, material)) = ground.top(place) else { continue };
            if !self.on.is_empty() && !self.on.contains(&material) {
                continue;
            }
            let bucket = place.map(|p| p.div_euclid(bucket_edge));
            let crowded =
                (-1..=1).flat_map(|dz| (-1..=1).map(move |dx| [bucket[0] + dx, bucket[1] + dz])).any(|near| {
                    taken.get(&near).is_some_and(|others| {
                        others.iter().any(|other| {
                            let [dx, dz] = [other[0] - place[0], other[1] - place[1]];
                            dx * dx + dz * dz < self.spacing * self.spacing
                        })
                    })
                });
            if crowded {
                continue;
            }
            let placement = place_anchor(
                self.anchor,
                if self.turn { turns } else { 0 },
                [place[0], i64::from(y) + 1 - self.sink, place[1]],
            );
            let Some(bounds) = self.model.bounds() else { break };
            let placed = Placed::placed_bounds(&bounds, &placement);
            if (0..3).any(|i| placed.min[i] < i64::from(i32::MIN) || placed.max[i] > i64::from(i32::MAX) + 1) {
                continue;
            }
            taken.entry(bucket).or_default().push(place);
            placements.push(placement);
        }
        Placed { model: self.model.clone(), materials: self.materials.clone(), placements, mode: self.mode }
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
    fn top(&self, [x, z]: [i64; 2]) -> Option<(i32, MaterialIndex)> {
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
                    return Some((chunk_y * 64 + y as i32, material));
                }
            }
        }
        None
    }
}
