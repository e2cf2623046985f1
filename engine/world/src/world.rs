//! The world: materials, and the chunks that have solids.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use glam::{I64Vec3, IVec3};
use serde::{Deserialize, Serialize};

use crate::chunk::{CHUNK_EDGE, Chunk, block_index};
use crate::dense::DenseChunk;
use crate::material::{AIR, Material, MaterialIndex};

/// Where a chunk lies, in chunks: its first voxel is 64 times this. Every component is in −2²⁵ … 2²⁵ − 1. Ordered by y, z, x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ChunkPos {
    /// Height.
    pub y: i32,
    /// Depth.
    pub z: i32,
    /// Width.
    pub x: i32,
}

impl ChunkPos {
    /// From components in the usual order.
    pub const fn new(x: i32, y: i32, z: i32) -> Self {
        Self { y, z, x }
    }

    /// The chunk that holds a voxel.
    #[inline]
    pub fn of_cell(cell: IVec3) -> Self {
        Self::new(cell.x >> 6, cell.y >> 6, cell.z >> 6)
    }

    /// One of the chunks in [`Bounds::chunk_ranges`]: cells go from −2³¹ to 2³¹, so that its coordinates are within ±2²⁵.
    #[expect(clippy::cast_possible_truncation, reason = "chunks of cells within ±2³¹ are within ±2²⁵")]
    #[inline]
    pub fn of_range([x, y, z]: [i64; 3]) -> Self {
        debug_assert!([x, y, z].iter().all(|c| i32::try_from(*c).is_ok()), "no chunk is at {x}, {y}, {z}");
        Self::new(x as i32, y as i32, z as i32)
    }

    /// The one beyond a face: 0 to 5 for −x, +x, −y, +y, −z, +z.
    #[must_use]
    pub fn beside(self, face: u32) -> Self {
        let step = if face & 1 == 1 { 1 } else { -1 };
        let by = |axis| if face >> 1 == axis { step } else { 0 };
        Self::new(self.x + by(0), self.y + by(1), self.z + by(2))
    }

    /// The voxel at its smallest corner.
    #[inline]
    pub fn origin(self) -> IVec3 {
        IVec3::new(self.x, self.y, self.z) * CHUNK_EDGE
    }
}

/// A half-open box of voxels: `min` is inside, `max` is not. 64 bits wide, as `max` can be 2³¹.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest coordinates inside.
    pub min: [i64; 3],
    /// One past the largest coordinates inside.
    pub max: [i64; 3],
}

impl Bounds {
    /// Voxels along each axis.
    #[inline]
    pub fn size(&self) -> [u64; 3] {
        std::array::from_fn(|i| (self.max[i] - self.min[i]).cast_unsigned())
    }

    /// Chunks that it touches, as half-open ranges of chunk coordinates along x, y, z.
    #[inline]
    pub fn chunk_ranges(&self) -> [std::ops::Range<i64>; 3] {
        std::array::from_fn(|i| self.min[i] >> 6..(self.max[i] + 63) >> 6)
    }

    /// How many chunks it touches; 0 when it is empty along an axis.
    #[inline]
    pub fn chunk_count(&self) -> u128 {
        self.chunk_ranges().map(|range| u128::from((range.end - range.start).max(0).unsigned_abs())).iter().product()
    }

    /// Whether every voxel of a chunk is inside.
    #[inline]
    pub fn contains_chunk(&self, pos: ChunkPos) -> bool {
        let origin = pos.origin().to_array().map(i64::from);
        (0..3).all(|i| self.min[i] <= origin[i] && origin[i] + i64::from(CHUNK_EDGE) <= self.max[i])
    }

    /// The same box elsewhere.
    #[must_use]
    #[inline]
    pub fn moved(self, by: [i64; 3]) -> Self {
        let moved = |corner: [i64; 3]| std::array::from_fn(|i| corner[i] + by[i]);
        Self { min: moved(self.min), max: moved(self.max) }
    }

    /// Smallest box around both.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }
}

/// Voxels over the whole range of `i32` coordinates. Immutable once built.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    materials: Vec<Material>,
    chunks: BTreeMap<ChunkPos, Arc<Chunk>>,
    bounds: Option<Bounds>,
    counts: Vec<u64>,
}

/// Box around the solids of one chunk, in voxels of the world.
fn solid_bounds(pos: ChunkPos, chunk: &Chunk) -> Bounds {
    chunk.bounds().moved(pos.origin().as_i64vec3().to_array())
}

/// Figures about a world.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// Solid voxels.
    pub solids: u64,
    /// Box around all solids; none in an empty world.
    pub bounds: Option<Bounds>,
    /// Chunks with solids.
    pub chunks: usize,
    /// Different ones among them; equal chunks are stored once.
    pub unique_chunks: usize,
    /// Bytes of the voxels in main memory.
    pub bytes: u64,
    /// Each material but air, with its number of voxels.
    pub materials: Vec<MaterialInfo>,
}

/// One material's share of a world.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialInfo {
    /// Palette index.
    pub index: MaterialIndex,
    /// Voxels made of it.
    pub voxels: u64,
    /// The material.
    #[serde(flatten)]
    pub material: Material,
}

impl World {
    /// From its parts. `materials[0]` is air, and every voxel's material is in `materials`. Equal chunks are made one.
    pub fn new(materials: Vec<Material>, chunks: impl IntoIterator<Item = (ChunkPos, Arc<Chunk>)>) -> Self {
        #[allow(clippy::mutable_key_type, reason = "once it is known, the hash of a chunk stays as it is")]
        let mut pool: HashSet<Arc<Chunk>> = HashSet::new();
        let mut shared = BTreeMap::new();
        for (pos, chunk) in chunks {
            let known = pool.get(&chunk).cloned().unwrap_or_else(|| {
                pool.insert(chunk.clone());
                chunk
            });
            shared.insert(pos, known);
        }
        Self::from_shared(materials, shared)
    }

    /// From its parts, where equal chunks already are one.
    pub fn from_shared(materials: Vec<Material>, chunks: BTreeMap<ChunkPos, Arc<Chunk>>) -> Self {
        let mut counts = vec![0; materials.len().max(1)];
        let mut bounds: Option<Bounds> = None;
        // Figures of a shared chunk are worked out once.
        let mut uses: HashMap<*const Chunk, u64> = HashMap::new();
        let mut bounds_of = HashMap::new();
        for (pos, chunk) in &chunks {
            *uses.entry(Arc::as_ptr(chunk)).or_default() += 1;
            let of_chunk = bounds_of.entry(Arc::as_ptr(chunk)).or_insert_with(|| chunk.bounds());
            let here = of_chunk.moved(pos.origin().as_i64vec3().to_array());
            bounds = Some(bounds.map_or(here, |all| all.union(here)));
        }
        for chunk in chunks.values() {
            // Each distinct chunk is counted at its first use, times its uses.
            if let Some(uses) = uses.remove(&Arc::as_ptr(chunk)) {
                let mut of_chunk = vec![0; counts.len()];
                chunk.count_materials(&mut of_chunk);
                counts.iter_mut().zip(of_chunk).for_each(|(total, count)| *total += count * uses);
            }
        }
        Self { materials, chunks, bounds, counts }
    }

    /// From single voxels; of two at the same place the later one stays, and air empties. For tests and small models.
    pub fn from_voxels(materials: Vec<Material>, voxels: impl IntoIterator<Item = (IVec3, MaterialIndex)>) -> Self {
        let mut of_chunk: BTreeMap<ChunkPos, Vec<(IVec3, MaterialIndex)>> = BTreeMap::new();
        for (cell, material) in voxels {
            of_chunk.entry(ChunkPos::of_cell(cell)).or_default().push((cell & 63, material));
        }
        let mut dense = DenseChunk::default();
        let chunks = of_chunk.into_iter().filter_map(|(pos, voxels)| {
            dense.clear();
            for (local, material) in voxels {
                dense.set(local.x.cast_unsigned(), local.y.cast_unsigned(), local.z.cast_unsigned(), material);
            }
            Some((pos, Arc::new(Chunk::pack(&dense)?)))
        });
        Self::new(materials, chunks)
    }

    /// The same world with other chunks at some positions; `None` empties one. `materials` are those of the world, and behind them the
    /// further ones of the other chunks. Only the figures of those chunks are computed again.
    #[must_use]
    pub fn with_chunks(
        &self,
        materials: &[Material],
        changes: impl IntoIterator<Item = (ChunkPos, Option<Arc<Chunk>>)>,
    ) -> Self {
        let mut world = self.clone();
        world.materials.extend(materials.iter().skip(world.materials.len()).cloned());
        world.counts.resize(world.materials.len(), 0);
        let mut shrunk = false;
        for (pos, chunk) in changes {
            let before = match &chunk {
                Some(chunk) => world.chunks.insert(pos, chunk.clone()),
                None => world.chunks.remove(&pos),
            };
            let mut counted = vec![0; world.counts.len()];
            if let Some(before) = &before {
                before.count_materials(&mut counted);
                world.counts.iter_mut().zip(&counted).for_each(|(total, count)| *total -= count);
                shrunk = true;
                counted.fill(0);
            }
            if let Some(chunk) = &chunk {
                chunk.count_materials(&mut counted);
                world.counts.iter_mut().zip(&counted).for_each(|(total, count)| *total += count);
                let here = solid_bounds(pos, chunk);
                world.bounds = Some(world.bounds.map_or(here, |all| all.union(here)));
            }
        }
        if shrunk {
            world.bounds = world.outer_bounds();
        }
        world
    }

    /// Box around all solids, from the outermost chunks of each axis alone.
    fn outer_bounds(&self) -> Option<Bounds> {
        let ends = self.chunks.keys().map(|pos| [[pos.x, pos.y, pos.z]; 2]).reduce(|[low, high], [a, b]| {
            [std::array::from_fn(|i| low[i].min(a[i])), std::array::from_fn(|i| high[i].max(b[i]))]
        })?;
        let outermost = |pos: &ChunkPos| {
            let at = [pos.x, pos.y, pos.z];
            (0..3).any(|i| at[i] == ends[0][i] || at[i] == ends[1][i])
        };
        let outer = self.chunks.iter().filter(|(pos, _)| outermost(pos));
        outer.map(|(pos, chunk)| solid_bounds(*pos, chunk)).reduce(Bounds::union)
    }

    /// A world without voxels.
    pub fn empty() -> Self {
        Self::from_shared(vec![Material::air()], BTreeMap::new())
    }

    /// The palette; index 0 is air.
    #[inline]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Voxels of each material, by palette index. Air's entry is 0.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Solid voxels.
    pub fn solids(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Box around all solids.
    #[inline]
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    /// Centre of the bounds, in voxels; the origin for an empty world.
    pub fn centre(&self) -> I64Vec3 {
        self.bounds
            .map_or(I64Vec3::ZERO, |b| I64Vec3::from_array(std::array::from_fn(|i| i64::midpoint(b.min[i], b.max[i]))))
    }

    /// Chunks with solids, in the order of their positions. Equal chunks are the same `Arc`.
    pub fn chunks(&self) -> impl ExactSizeIterator<Item = (ChunkPos, &Arc<Chunk>)> {
        self.chunks.iter().map(|(pos, chunk)| (*pos, chunk))
    }

    /// The chunk at a position, if it has solids.
    #[inline]
    pub fn chunk(&self, pos: ChunkPos) -> Option<&Arc<Chunk>> {
        self.chunks.get(&pos)
    }

    /// Material of a voxel.
    #[inline]
    pub fn voxel(&self, cell: IVec3) -> MaterialIndex {
        let Some(chunk) = self.chunk(ChunkPos::of_cell(cell)) else { return AIR };
        chunk.voxel((cell.x & 63).cast_unsigned(), (cell.y & 63).cast_unsigned(), (cell.z & 63).cast_unsigned())
    }

    /// Occupancy of the 4³ block whose smallest voxel is `4 * block`; bits in the order of [`crate::child_index`].
    #[inline]
    pub fn mask4(&self, block: IVec3) -> u64 {
        let Some(chunk) = self.chunk(ChunkPos::new(block.x >> 4, block.y >> 4, block.z >> 4)) else { return 0 };
        chunk.mask(block_index(
            (block.x & 15).cast_unsigned(),
            (block.y & 15).cast_unsigned(),
            (block.z & 15).cast_unsigned(),
        ))
    }

    /// Every solid voxel: chunk by chunk, in tree order inside each.
    pub fn voxels(&self) -> impl Iterator<Item = (IVec3, MaterialIndex)> + '_ {
        self.chunks().flat_map(|(pos, chunk)| {
            chunk
                .iter()
                .map(move |(local, material)| (pos.origin() + glam::UVec3::from_array(local).as_ivec3(), material))
        })
    }

    /// Whether a voxel gives off light.
    pub fn has_emission(&self) -> bool {
        self.used_materials().any(|material| material.emission > 0.0)
    }

    /// Whether a voxel lets light through.
    pub fn has_transparency(&self) -> bool {
        self.used_materials().any(|material| material.transparency > 0.0)
    }

    /// Materials that voxels are made of.
    fn used_materials(&self) -> impl Iterator<Item = &Material> {
        self.materials.iter().zip(&self.counts).filter(|(_, count)| **count > 0).map(|(material, _)| material)
    }

    /// Figures for people.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
    pub fn info(&self) -> Info {
        let unique: HashMap<*const Chunk, u64> =
            self.chunks.values().map(|chunk| (Arc::as_ptr(chunk), chunk.bytes())).collect();
        Info {
            solids: self.solids(),
            bounds: self.bounds,
            chunks: self.chunks.len(),
            unique_chunks: unique.len(),
            bytes: unique.values().sum(),
            materials: (self.materials.iter().zip(&self.counts).enumerate().skip(1))
                .map(|(index, (material, &voxels))| MaterialInfo {
                    index: index as MaterialIndex,
                    voxels,
                    material: material.clone(),
                })
                .collect(),
        }
    }
}
