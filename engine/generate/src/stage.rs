//! Runs the operations: all chunks at once, each chunk through every operation in turn. A scatter has to see the ground that it
//! stands on, so it begins a new stage.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use raxel_world::Chunk;
use raxel_world::Material;
use raxel_world::{Bounds, ChunkPos, World};
use raxel_world::{DenseChunk, Mode};
use rayon::prelude::*;

use crate::place::Touching;
use crate::scatter::Land;
use crate::terrain::Surface;
use crate::{Draft, Operation, Placed, chunk_ranges, local_part};

/// How large a world may become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildLimits {
    /// Chunks that its operations reach over.
    pub chunks: u64,
    /// Bytes of all different chunks in main memory.
    pub bytes: u64,
}

impl Default for BuildLimits {
    /// 4096³ voxels, 4 GiB.
    fn default() -> Self {
        Self { chunks: 1 << 18, bytes: 4 << 30 }
    }
}

/// Why a build was not made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// An operation reaches over more chunks than a build may have. Found before any is made.
    #[error("it reaches over {chunks} chunks of 64³ voxels; a world has at most {limit}")]
    TooManyChunks {
        /// Index of the operation.
        operation: usize,
        /// Chunks that it, or all operations up to it, reach over (or more).
        chunks: u128,
        /// Chunks allowed.
        limit: u64,
    },
    /// The voxels take too much memory.
    #[error("its voxels take more than {limit} bytes")]
    TooManyBytes {
        /// Bytes allowed.
        limit: u64,
    },
}

/// A scatter that found fewer places than it was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortfall {
    /// Index of the operation.
    pub operation: usize,
    /// How many were asked for.
    pub wanted: u64,
    /// How many stand.
    pub placed: u64,
}

/// Builds a world from operations in order.
pub fn build(materials: Vec<Material>, operations: &[Operation]) -> Result<(World, Vec<Shortfall>), BuildError> {
    build_within(materials, operations, &BuildLimits::default())
}

/// The same, within other limits.
pub fn build_within(
    materials: Vec<Material>,
    operations: &[Operation],
    limits: &BuildLimits,
) -> Result<(World, Vec<Shortfall>), BuildError> {
    reach(operations, limits)?;
    let mut chunks = BTreeMap::new();
    let mut shortfalls = Vec::new();
    let mut stage = Vec::new();
    // Models on the land follow from the operations alone, so they need no stage of their own.
    let jittered: Vec<Option<Placed>> = (operations.iter().enumerate())
        .map(|(index, operation)| match operation {
            Operation::Jittered(jittered) => Some(jittered.choose(&Land::of(operations[..index].iter()))),
            _ => None,
        })
        .collect();
    for (index, operation) in operations.iter().enumerate() {
        if let Some(placed) = &jittered[index] {
            stage.push(Step::place(index, placed, limits)?);
        } else if let Operation::Scatter(scatter) = operation {
            run(&mut chunks, &std::mem::take(&mut stage), limits)?;
            let placed = scatter.choose(&chunks);
            if (placed.placements.len() as u64) < scatter.count {
                let count = placed.placements.len() as u64;
                shortfalls.push(Shortfall { operation: index, wanted: scatter.count, placed: count });
            }
            let step = Step::place(index, &placed, limits)?;
            run(&mut chunks, &[step], limits)?;
        } else {
            stage.push(Step::new(index, operation, limits)?);
        }
    }
    run(&mut chunks, &stage, limits)?;
    Ok((World::from_shared(materials, chunks), shortfalls))
}

/// The reach of operations, known before anything is made. Models count nothing: their places are not chosen yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// Chunks of 64³ voxels, counted once for each operation that may make them.
    pub chunks: u64,
    /// A box around all voxels that operations add; `None` where they add none.
    pub bounds: Option<Bounds>,
}

/// The reach of operations. An error where it is more than the limits allow.
pub fn reach(operations: &[Operation], limits: &BuildLimits) -> Result<Reach, BuildError> {
    let mut chunks: u128 = 0;
    let mut bounds: Option<Bounds> = None;
    for (index, operation) in operations.iter().enumerate() {
        chunks += chunks_reached(operation);
        if chunks > u128::from(limits.chunks) {
            return Err(BuildError::TooManyChunks { operation: index, chunks, limit: limits.chunks });
        }
        if let Some(added) = added(operation) {
            bounds = Some(bounds.map_or(added, |bounds| bounds.union(added)));
        }
    }
    let chunks = u64::try_from(chunks).expect("at most `limits.chunks`, which is a u64");
    Ok(Reach { chunks, bounds })
}

/// The box that an operation adds voxels in, where that is known before models are placed.
fn added(operation: &Operation) -> Option<Bounds> {
    match operation {
        Operation::Solid(solid) => (solid.mode == Mode::Add).then(|| solid.shape.bounds()),
        Operation::Terrain(terrain) => (terrain.mode == Mode::Add).then(|| terrain.bounds()),
        Operation::Place(_) | Operation::Scatter(_) | Operation::Jittered(_) => None,
    }
}

/// Chunks that an operation may make; none when it only changes those that are there.
fn chunks_reached(operation: &Operation) -> u128 {
    // Chunks of models are counted when their places are known.
    added(operation).map_or(0, |bounds| bounds.chunk_count())
}

/// An operation ready to run.
enum Step<'a> {
    Solid(&'a crate::Solid, Bounds),
    Terrain(&'a crate::Terrain, Bounds),
    Place(&'a Placed, Touching),
}

impl<'a> Step<'a> {
    fn new(index: usize, operation: &'a Operation, limits: &BuildLimits) -> Result<Self, BuildError> {
        match operation {
            Operation::Solid(solid) => Ok(Self::Solid(solid, solid.shape.bounds())),
            Operation::Terrain(terrain) => Ok(Self::Terrain(terrain, terrain.bounds())),
            Operation::Place(placed) => Self::place(index, placed, limits),
            Operation::Scatter(_) | Operation::Jittered(_) => unreachable!("they become placed models first"),
        }
    }

    fn place(index: usize, placed: &'a Placed, limits: &BuildLimits) -> Result<Self, BuildError> {
        let touching = placed.touching(limits.chunks).ok_or(BuildError::TooManyChunks {
            operation: index,
            chunks: u128::from(limits.chunks) + 1,
            limit: limits.chunks,
        })?;
        Ok(Self::Place(placed, touching))
    }

    fn mode(&self) -> Mode {
        match self {
            Self::Solid(solid, _) => solid.mode,
            Self::Terrain(terrain, _) => terrain.mode,
            Self::Place(placed, _) => placed.mode,
        }
    }

    fn touches(&self, pos: ChunkPos) -> bool {
        match self {
            Self::Solid(_, bounds) | Self::Terrain(_, bounds) => local_part(bounds, pos).is_some(),
            Self::Place(_, touching) => touching.contains_key(&pos),
        }
    }

    /// Chunks that it may make.
    #[expect(clippy::cast_possible_truncation, reason = "chunks of cells within ±2³¹ are within ±2²⁵")]
    fn makes(&self) -> Vec<ChunkPos> {
        match self {
            _ if self.mode() != Mode::Add => Vec::new(),
            Self::Solid(_, bounds) | Self::Terrain(_, bounds) => {
                let [xs, ys, zs] = chunk_ranges(bounds).map(|range| range.start as i32..range.end as i32);
                let mut all = Vec::new();
                for y in ys {
                    for z in zs.clone() {
                        all.extend(xs.clone().map(|x| ChunkPos::new(x, y, z)));
                    }
                }
                all
            }
            Self::Place(_, touching) => touching.keys().copied().collect(),
        }
    }
}

/// Applies one stage to the chunks so far.
fn run(
    chunks: &mut BTreeMap<ChunkPos, Arc<Chunk>>,
    steps: &[Step<'_>],
    limits: &BuildLimits,
) -> Result<(), BuildError> {
    let mut touched: HashSet<ChunkPos> = steps.iter().flat_map(Step::makes).collect();
    touched.extend(chunks.keys().filter(|pos| steps.iter().any(|step| step.touches(**pos))));
    // Heights are worked out once for all chunks above each other.
    let mut columns: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
    for pos in touched {
        columns.entry((pos.z, pos.x)).or_default().push(pos.y);
    }
    let pool = Pool::of(chunks.values(), limits.bytes);
    let built: Vec<(ChunkPos, Option<Arc<Chunk>>)> = columns
        .into_par_iter()
        .map_init(DenseChunk::default, |dense, ((z, x), mut ys)| {
            ys.sort_unstable();
            let surfaces: Vec<Option<Surface>> = steps
                .iter()
                .map(|step| match step {
                    Step::Terrain(terrain, _) => {
                        let needed = ys.iter().any(|&y| step.touches(ChunkPos::new(x, y, z)));
                        needed.then(|| terrain.surface(x, z))
                    }
                    _ => None,
                })
                .collect();
            let mut of_column = Vec::with_capacity(ys.len());
            for y in ys {
                if pool.full() {
                    break;
                }
                let pos = ChunkPos::new(x, y, z);
                dense.clear();
                if let Some(chunk) = chunks.get(&pos) {
                    dense.unpack(chunk);
                }
                let mut draft = Draft { pos, chunk: dense };
                for (step, surface) in steps.iter().zip(&surfaces) {
                    match (step, surface) {
                        (Step::Solid(solid, _), _) => solid.apply(&mut draft),
                        (Step::Terrain(terrain, _), Some(surface)) => terrain.apply(&mut draft, surface),
                        (Step::Terrain(..), None) => {}
                        (Step::Place(placed, touching), _) => placed.apply(&mut draft, touching),
                    }
                }
                of_column.push((pos, Chunk::pack(draft.chunk).map(|chunk| pool.share(chunk))));
            }
            of_column
        })
        .flatten_iter()
        .collect();
    if pool.full() {
        return Err(BuildError::TooManyBytes { limit: limits.bytes });
    }
    for (pos, chunk) in built {
        match chunk {
            Some(chunk) => chunks.insert(pos, chunk),
            None => chunks.remove(&pos),
        };
    }
    Ok(())
}

/// Keeps one of equal chunks. The choice has no effect: they are equal.
struct Pool {
    known: [Mutex<HashMap<u64, Vec<Arc<Chunk>>>>; 16],
    bytes: AtomicU64,
    limit: u64,
}

impl Pool {
    #[expect(clippy::cast_possible_truncation, reason = "the remainder of a hash is enough to choose a shard")]
    fn of<'c>(chunks: impl Iterator<Item = &'c Arc<Chunk>>, limit: u64) -> Self {
        let pool = Self { known: std::array::from_fn(|_| Mutex::default()), bytes: AtomicU64::new(0), limit };
        let mut seen = HashSet::new();
        for chunk in chunks.filter(|chunk| seen.insert(Arc::as_ptr(chunk))) {
            pool.bytes.fetch_add(chunk.bytes(), Ordering::Relaxed);
            let shard = &pool.known[chunk.content_hash() as usize % 16];
            let mut shard = shard.lock().unwrap_or_else(PoisonError::into_inner);
            shard.entry(chunk.content_hash()).or_default().push(chunk.clone());
        }
        pool
    }

    #[expect(clippy::cast_possible_truncation, reason = "the remainder of a hash is enough to choose a shard")]
    fn share(&self, chunk: Chunk) -> Arc<Chunk> {
        let hash = chunk.content_hash();
        let mut shard = self.known[hash as usize % 16].lock().unwrap_or_else(PoisonError::into_inner);
        let same_hash = shard.entry(hash).or_default();
        if let Some(known) = same_hash.iter().find(|known| ***known == chunk) {
            return known.clone();
        }
        self.bytes.fetch_add(chunk.bytes(), Ordering::Relaxed);
        let chunk = Arc::new(chunk);
        same_hash.push(chunk.clone());
        chunk
    }

    fn full(&self) -> bool {
        self.bytes.load(Ordering::Relaxed) > self.limit
    }
}
