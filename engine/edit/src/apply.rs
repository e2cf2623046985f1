//! Applies operations to one chunk.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_generate::{Box3, Placed, Shape, Solid};
use raxel_world::{
    AIR, Bits, BlockVoxels, Bounds, Chunk, ChunkPos, DenseChunk, MaterialIndex, Mode, Placement, Unavailable,
    block_cell, voxel_index,
};

use crate::history::{Moment, VoxelChange};
use crate::operation::{Brush, EditError, MOST_CHUNKS, Operation};
use crate::packed::PackedChunk;
use crate::scene::{Base, EditModel, Scene};
use crate::shape::{Ball, Pillar};

/// An operation that is right, ready to be applied to any chunk.
pub(crate) struct Prepared<'a> {
    /// The voxels that it may change; none for [`Kind::Put`].
    bounds: Option<Bounds>,
    kind: Kind<'a>,
}

#[allow(clippy::option_option, reason = "a chunk may be put back to what the world has, to air or to voxels")]
enum Kind<'a> {
    Set([i32; 3], MaterialIndex),
    /// The full chunk is there when the shape may have whole chunks inside and fills them.
    Solid(Solid, Option<Arc<Chunk>>),
    Model(&'a EditModel, Placement, Mode),
    Restore,
    Put(BTreeMap<ChunkPos, Option<Option<Arc<Chunk>>>>),
}

/// The result of an operation that covers a whole chunk.
enum Whole {
    Base,
    Voxels(Option<Arc<Chunk>>),
}

impl<'a> Prepared<'a> {
    /// Checks operations and makes them ready, all or none.
    pub(crate) fn all(operations: &'a [Operation], scene: &'a Scene) -> Result<Vec<Self>, EditError> {
        let mut chunks = 0;
        let prepare = |operation| {
            let prepared = Self::new(operation, scene)?;
            chunks += prepared.chunks();
            if chunks > u128::from(MOST_CHUNKS) {
                return Err(EditError::TooLarge { chunks, limit: MOST_CHUNKS });
            }
            Ok(prepared)
        };
        operations.iter().map(prepare).collect()
    }

    fn new(operation: &'a Operation, scene: &'a Scene) -> Result<Self, EditError> {
        let bounds = operation.bounds(scene)?;
        let large = bounds.is_some_and(|bounds| bounds.size().iter().all(|size| *size >= 64));
        let solid = |shape: Box<dyn Shape>, brush: Brush| {
            let full = match brush {
                Brush::Add(material) if large => Some(Arc::new(Chunk::full(material))),
                _ => None,
            };
            let solid = Solid { shape, mode: brush.mode(), materials: brush.material().into_iter().collect() };
            Kind::Solid(solid, full)
        };
        let kind = match operation {
            Operation::Set { cell, material } => Kind::Set(*cell, *material),
            Operation::Box { bounds, brush } => solid(Box::new(Box3 { bounds: *bounds, shell: None }), *brush),
            Operation::Sphere { center, radius, brush } => {
                solid(Box::new(Ball { center: *center, radius: *radius }), *brush)
            }
            Operation::Cylinder { axis, base, radius, height, brush } => {
                let pillar = Pillar { axis: usize::from(*axis), base: *base, radius: *radius, height: *height };
                solid(Box::new(pillar), *brush)
            }
            Operation::Model { model, orientation, mode, .. } => {
                let placement = operation.placement().ok_or(EditError::Orientation { orientation: *orientation })?;
                let model = scene.model(model).ok_or_else(|| EditError::UnknownModel { model: model.clone() })?;
                Kind::Model(model, placement, *mode)
            }
            Operation::Restore { .. } => Kind::Restore,
            Operation::Put { chunks } => {
                let unpack = |(pos, packed): &(ChunkPos, Option<PackedChunk>)| {
                    let broken = EditError::BrokenChunk { x: pos.x, y: pos.y, z: pos.z };
                    let unpack = |packed: &PackedChunk| packed.unpack(scene.materials.len()).ok_or(broken);
                    let chunk = packed.as_ref().map(unpack).transpose()?;
                    Ok((*pos, chunk.map(|chunk| chunk.map(Arc::new))))
                };
                Kind::Put(chunks.iter().map(unpack).collect::<Result<_, EditError>>()?)
            }
        };
        Ok(Self { bounds, kind })
    }

    fn chunks(&self) -> u128 {
        match (&self.kind, &self.bounds) {
            (Kind::Put(chunks), _) => chunks.len() as u128,
            (_, Some(bounds)) => bounds.chunk_count(),
            (_, None) => 0,
        }
    }

    /// Calls `each` with the position of every chunk that it may change.
    pub(crate) fn each_chunk(&self, mut each: impl FnMut(ChunkPos)) {
        if let Kind::Put(chunks) = &self.kind {
            return chunks.keys().copied().for_each(each);
        }
        let Some(bounds) = &self.bounds else { return };
        let [xs, ys, zs] = bounds.chunk_ranges();
        for y in ys {
            for z in zs.clone() {
                xs.clone().for_each(|x| each(ChunkPos::of_range([x, y, z])));
            }
        }
    }

    /// The contents of a chunk that it covers whole, unless they depend on the voxels before.
    fn whole(&self, pos: ChunkPos) -> Option<Whole> {
        match &self.kind {
            Kind::Put(chunks) => {
                Some(chunks.get(&pos)?.as_ref().map_or(Whole::Base, |chunk| Whole::Voxels(chunk.clone())))
            }
            Kind::Restore => self.bounds.filter(|bounds| bounds.contains_chunk(pos)).map(|_| Whole::Base),
            Kind::Solid(solid, full) => {
                let makes = match solid.mode {
                    Mode::Add => Whole::Voxels(Some(full.clone()?)),
                    Mode::Subtract => Whole::Voxels(None),
                    Mode::Paint => return None,
                };
                let origin = pos.origin().to_array().map(i64::from);
                (solid.shape.span(origin, 64) == raxel_generate::Span3::Inside).then_some(makes)
            }
            Kind::Set(..) | Kind::Model(..) => None,
        }
    }

    /// The voxel that it sets, and its material, if it does nothing else.
    fn set(&self) -> Option<([i32; 3], MaterialIndex)> {
        match self.kind {
            Kind::Set(cell, material) => Some((cell, material)),
            _ => None,
        }
    }

    /// Whether it can only change voxels that are solid.
    fn needs_solids(&self) -> bool {
        match &self.kind {
            Kind::Set(_, material) => *material == AIR,
            Kind::Solid(solid, _) => solid.mode != Mode::Add,
            Kind::Model(_, _, mode) => *mode != Mode::Add,
            Kind::Restore | Kind::Put(_) => false,
        }
    }

    fn apply(&self, pos: ChunkPos, dense: &mut DenseChunk, base: &dyn Base) -> Result<(), Unavailable> {
        match &self.kind {
            Kind::Set(cell, material) => {
                let [x, y, z] = cell.map(|c| (c & 63).cast_unsigned());
                dense.set(x, y, z, *material);
            }
            Kind::Solid(solid, _) => solid.apply_to(pos, dense),
            Kind::Model(model, placement, mode) => place(model, placement, *mode, pos, dense),
            Kind::Restore => {
                if let Some(bounds) = &self.bounds {
                    restore(bounds, pos, dense, base.try_chunk(pos)?.as_deref());
                }
            }
            // It is always whole.
            Kind::Put(_) => {}
        }
        Ok(())
    }
}

/// The voxels of a model that fall into a chunk.
#[expect(clippy::cast_sign_loss, reason = "the six lowest bits are not negative")]
fn place(model: &EditModel, placement: &Placement, mode: Mode, pos: ChunkPos, dense: &mut DenseChunk) {
    let origin = pos.origin().to_array().map(i64::from);
    let here = Bounds { min: origin, max: origin.map(|o| o + 64) };
    for (part, chunk) in model.voxels.chunks() {
        let from = part.origin().to_array().map(i64::from);
        let around = Placed::placed_bounds(&Bounds { min: from, max: from.map(|f| f + 64) }, placement);
        if (0..3).any(|i| around.max[i] <= here.min[i] || here.max[i] <= around.min[i]) {
            continue;
        }
        for (local, material) in chunk.iter() {
            let cell = placement.cell(std::array::from_fn(|i| from[i] + i64::from(local[i])));
            if (0..3).all(|i| (here.min[i]..here.max[i]).contains(&cell[i])) {
                let [x, y, z] = cell.map(|c| (c & 63) as u32);
                let (block, bit) = voxel_index(x, y, z);
                dense.apply(block, 1 << bit, mode, model.materials[usize::from(material)]);
            }
        }
    }
}

/// Brings the part of a box inside a chunk back to the base's voxels.
fn restore(bounds: &Bounds, pos: ChunkPos, dense: &mut DenseChunk, base: Option<&Chunk>) {
    let shape = Box3 { bounds: *bounds, shell: None };
    Solid { shape: Box::new(shape), mode: Mode::Subtract, materials: Vec::new() }.apply_to(pos, dense);
    let Some(base) = base else { return };
    let origin = pos.origin().to_array().map(i64::from);
    for (block, &mask) in base.masks().iter().enumerate().filter(|(_, mask)| **mask != 0) {
        let cell = block_cell(block).map(i64::from);
        let covered = shape.mask(std::array::from_fn(|i| origin[i] + 4 * cell[i]));
        for (bit, material) in Bits(mask).zip(base.block_materials(block)).filter(|(bit, _)| covered >> bit & 1 == 1) {
            dense.apply(block, 1 << bit, Mode::Add, material);
        }
    }
}

/// Voxels that are set one by one in a chunk, above which they are set in all of its voxels.
const MOST_SETS: usize = 4096;

/// A chunk after operations.
pub(crate) struct Applied {
    /// The very same `Arc` when no voxel changed.
    pub(crate) after: Option<Arc<Chunk>>,
    /// Whether it is the edits' own.
    pub(crate) edited: bool,
    /// The voxels that changed, where these are few and known.
    pub(crate) voxels: Option<Box<[VoxelChange]>>,
}

/// A chunk, or air, with some voxels as they were before or after their change.
pub(crate) fn with_voxels(chunk: Option<&Chunk>, voxels: &[VoxelChange], moment: Moment) -> Option<Chunk> {
    let mut blocks = BTreeMap::new();
    for change in voxels {
        let (block, bit) = change.place();
        let voxels = blocks.entry(block).or_insert_with(|| read(chunk, block));
        voxels.set(bit, change.material(moment));
    }
    Chunk::with_blocks(chunk, &blocks)
}

fn read(chunk: Option<&Chunk>, block: usize) -> BlockVoxels {
    chunk.map_or(BlockVoxels::EMPTY, |chunk| chunk.block(block))
}

/// Sets voxels of a chunk one by one, in order: only their blocks are looked at.
fn set_voxels(
    (before, edited): (Option<Arc<Chunk>>, bool),
    sets: impl Iterator<Item = ([i32; 3], MaterialIndex)>,
) -> Applied {
    let mut blocks: BTreeMap<usize, BlockVoxels> = BTreeMap::new();
    for (cell, material) in sets {
        let [x, y, z] = cell.map(|c| (c & 63).cast_unsigned());
        let (block, bit) = voxel_index(x, y, z);
        blocks.entry(block).or_insert_with(|| read(before.as_deref(), block)).set(bit, material);
    }
    let mut changes = Vec::new();
    blocks.retain(|block, voxels| {
        let old = read(before.as_deref(), *block);
        let differ = (0..64).filter(|bit| old.materials[*bit] != voxels.materials[*bit]);
        changes.extend(differ.map(|bit| VoxelChange::new((*block, bit), old.materials[bit], voxels.materials[bit])));
        old != *voxels
    });
    if blocks.is_empty() {
        return Applied { after: before, edited, voxels: None };
    }
    let after = Chunk::with_blocks(before.as_deref(), &blocks).map(Arc::new);
    Applied { after, edited: true, voxels: Some(changes.into()) }
}

/// One chunk that operations are applied to, kept for the next one.
#[derive(Default)]
pub(crate) struct Scratch {
    dense: DenseChunk,
}

impl Scratch {
    /// Applies operations to a chunk. The caller says whether the chunk before is the edits' own.
    pub(crate) fn run(
        &mut self,
        pos: ChunkPos,
        (before, mut edited): (Option<Arc<Chunk>>, bool),
        operations: &[&Prepared<'_>],
        base: &dyn Base,
    ) -> Result<Applied, Unavailable> {
        if operations.len() <= MOST_SETS && operations.iter().all(|operation| operation.set().is_some()) {
            return Ok(set_voxels((before, edited), operations.iter().filter_map(|operation| operation.set())));
        }
        let mut voxels = before.clone();
        let mut unpacked = false;
        // An operation that covers the whole chunk hides those before it.
        let first = operations.iter().rposition(|operation| operation.whole(pos).is_some()).unwrap_or(0);
        for operation in &operations[first..] {
            match operation.whole(pos) {
                Some(Whole::Base) => (voxels, edited) = (base.try_chunk(pos)?, false),
                Some(Whole::Voxels(whole)) => {
                    edited |= whole != voxels;
                    voxels = whole;
                }
                None => {
                    if !unpacked {
                        if voxels.is_none() && operation.needs_solids() {
                            continue;
                        }
                        self.dense.clear();
                        if let Some(chunk) = &voxels {
                            self.dense.unpack(chunk);
                        }
                        unpacked = true;
                    }
                    operation.apply(pos, &mut self.dense, base)?;
                }
            }
        }
        if unpacked {
            let after = Chunk::pack(&self.dense);
            if after.as_ref() != voxels.as_deref() {
                voxels = after.map(Arc::new);
                edited = true;
            }
        }
        if voxels == before {
            voxels = before;
        }
        Ok(Applied { after: voxels, edited, voxels: None })
    }
}
