//! Random edits around the solids of a world: as operations for a streamed world, and voxel by voxel for the world that rays are judged by.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{I64Vec3, IVec3};
use raxel_edit::{Brush, Operation, UNIT};
use raxel_oracle::sets::Random;
use raxel_world::{AIR, Bounds, Chunk, ChunkPos, DenseChunk, MaterialIndex, World, voxel_index};

/// Small edits of a step.
const SMALL: usize = 6;
/// How far around a solid voxel a small edit may be, in voxels.
const AROUND: i64 = 12;
/// Largest edge of a box that is smaller than a chunk, and largest radius of a ball, in voxels.
const MOST_EDGE: u64 = 14;
const MOST_RADIUS: u64 = 8;
/// Voxels beyond the box of a world that a step may change: the chunk beside a solid one, and a box that begins in that.
pub(super) const BEYOND: i64 = 128 + AROUND + MOST_EDGE as i64;
/// A whole chunk is dug out only of a world with at least this many, so that a small one is not emptied.
const ENOUGH_CHUNKS: usize = 4;
/// Chunk positions are in −2²⁵ … 2²⁵ − 1.
const CHUNKS: std::ops::Range<i32> = -(1 << 25)..1 << 25;

/// An edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edit {
    shape: Shape,
    brush: Brush,
}

/// Which voxels an edit covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Voxel(IVec3),
    Box(Bounds),
    /// The voxels whose centres are at most `radius` voxels from the centre of a voxel.
    Ball(IVec3, i32),
}

impl Edit {
    /// As a streamed world takes it.
    pub(super) fn operation(&self) -> Operation {
        match (self.shape, self.brush) {
            (Shape::Voxel(cell), Brush::Add(material)) => Operation::set(cell.to_array(), material),
            (Shape::Voxel(cell), Brush::Subtract) => Operation::set(cell.to_array(), AIR),
            (Shape::Voxel(_) | Shape::Box(_), brush) => Operation::Box { bounds: self.bounds(), brush },
            (Shape::Ball(center, radius), brush) => Operation::Sphere {
                center: center.to_array().map(|c| i64::from(c) * UNIT + UNIT / 2),
                radius: radius.cast_unsigned() * UNIT as u32,
                brush,
            },
        }
    }

    fn bounds(&self) -> Bounds {
        let around = |center: IVec3, radius: i32| {
            let (center, radius) = (center.to_array().map(i64::from), i64::from(radius));
            Bounds { min: center.map(|c| c - radius), max: center.map(|c| c + radius + 1) }
        };
        match self.shape {
            Shape::Voxel(cell) => around(cell, 0),
            Shape::Box(bounds) => bounds,
            Shape::Ball(center, radius) => around(center, radius),
        }
    }

    /// Whether it covers a voxel of its [`Edit::bounds`].
    fn covers(&self, cell: [i64; 3]) -> bool {
        let Shape::Ball(center, radius) = self.shape else { return true };
        let apart = I64Vec3::from_array(cell) - center.as_i64vec3();
        apart.length_squared() <= i64::from(radius) * i64::from(radius)
    }
}

/// The world after edits, one voxel after another. It shares no code with how edits are applied to a streamed world.
pub(super) fn edited(world: &World, edits: &[Edit]) -> World {
    let covered = edits.iter().flat_map(|edit| {
        let Bounds { min, max } = edit.bounds();
        let cells = (min[2]..max[2])
            .flat_map(move |z| (min[1]..max[1]).flat_map(move |y| (min[0]..max[0]).map(move |x| [x, y, z])));
        cells.filter(|cell| edit.covers(*cell)).map(|cell| (IVec3::from_array(cell.map(|c| c as i32)), edit.brush))
    });
    replaced(world, covered)
}

/// The world after brushes on single voxels, one after another.
pub(super) fn replaced(world: &World, voxels: impl Iterator<Item = (IVec3, Brush)>) -> World {
    let mut changed: BTreeMap<ChunkPos, DenseChunk> = BTreeMap::new();
    for (cell, brush) in voxels {
        put(world, &mut changed, cell, brush);
    }
    let chunks = changed.into_iter().map(|(pos, dense)| (pos, Chunk::pack(&dense).map(Arc::new)));
    world.with_chunks(world.materials(), chunks)
}

fn put(world: &World, changed: &mut BTreeMap<ChunkPos, DenseChunk>, cell: IVec3, brush: Brush) {
    let pos = ChunkPos::of_cell(cell);
    let dense = changed.entry(pos).or_insert_with(|| {
        let mut dense = DenseChunk::default();
        if let Some(chunk) = world.chunk(pos) {
            dense.unpack(chunk);
        }
        dense
    });
    let [x, y, z] = (cell & 63).to_array().map(i32::cast_unsigned);
    let (block, bit) = voxel_index(x, y, z);
    let solid = dense.masks()[block] >> bit & 1 == 1;
    match brush {
        Brush::Add(material) => dense.set(x, y, z, material),
        Brush::Subtract => dense.set(x, y, z, AIR),
        Brush::Paint(material) if solid => dense.set(x, y, z, material),
        Brush::Paint(_) => {}
    }
}

/// The edits of one step: small ones beside solids, at borders of chunks and in chunks beside solid ones, and one of a whole chunk: an empty
/// one is filled, or one with solids is dug out. `world` has a material at least.
pub(super) fn step(world: &World, number: usize, random: &mut Random) -> Vec<Edit> {
    let chunks: Vec<ChunkPos> = world.chunks().map(|(pos, _)| pos).collect();
    let mut edits: Vec<Edit> = (0..SMALL).map(|_| small(world, &chunks, random)).collect();
    let home = chunk(&chunks, random);
    if number.is_multiple_of(2) {
        let beside = beside(home, random);
        if world.chunk(beside).is_none() {
            edits.push(Edit { shape: whole(beside), brush: Brush::Add(material(world, random)) });
        }
    } else if chunks.len() >= ENOUGH_CHUNKS {
        edits.push(Edit { shape: whole(home), brush: Brush::Subtract });
    }
    edits
}

fn material(world: &World, random: &mut Random) -> MaterialIndex {
    1 + random.below(world.materials().len() as u64 - 1) as MaterialIndex
}

/// One of the chunks with solids; that at the origin where there is none.
fn chunk(chunks: &[ChunkPos], random: &mut Random) -> ChunkPos {
    match chunks.len() {
        0 => ChunkPos::new(0, 0, 0),
        n => chunks[random.below(n as u64) as usize],
    }
}

/// The chunk beyond a random face; beyond the opposite one at the ends of the coordinates.
fn beside(pos: ChunkPos, random: &mut Random) -> ChunkPos {
    let face = random.below(6) as u32;
    let beside = pos.beside(face);
    let inside = [beside.x, beside.y, beside.z].iter().all(|c| CHUNKS.contains(c));
    if inside { beside } else { pos.beside(face ^ 1) }
}

/// Every voxel of a chunk.
fn whole(pos: ChunkPos) -> Shape {
    let min = pos.origin().to_array().map(i64::from);
    Shape::Box(Bounds { min, max: min.map(|c| c + 64) })
}

/// The voxel with these coordinates, or the last one on the way there.
fn clamped(cell: I64Vec3, margin: i64) -> IVec3 {
    let ends = [i64::from(i32::MIN) + margin, i64::from(i32::MAX) - margin];
    cell.clamp(I64Vec3::splat(ends[0]), I64Vec3::splat(ends[1])).as_ivec3()
}

fn small(world: &World, chunks: &[ChunkPos], random: &mut Random) -> Edit {
    let home = chunk(chunks, random);
    let solid = match world.chunk(home) {
        Some(chunk) => {
            let number = random.below(u64::from(chunk.solids())) as usize;
            let local = chunk.iter().nth(number).map_or([0; 3], |(local, _)| local);
            home.origin() + IVec3::from_array(local.map(u32::cast_signed))
        }
        None => home.origin(),
    };
    let at = match random.below(4) {
        0 => solid,
        1 => {
            let mut by = || random.below(2 * AROUND as u64 + 1) as i64 - AROUND;
            clamped(solid.as_i64vec3() + I64Vec3::new(by(), by(), by()), 0)
        }
        2 => {
            // The first or the last voxel of its chunk on some axes: the one beyond it is another tile's.
            let ends = random.below(64);
            let border = |axis: usize| match ends >> (2 * axis) & 3 {
                0 => solid[axis] & !63,
                1 => solid[axis] | 63,
                _ => solid[axis],
            };
            IVec3::new(border(0), border(1), border(2))
        }
        _ => {
            let beside = beside(home, random);
            beside.origin() + IVec3::from_array([0; 3].map(|_: i32| random.below(64) as i32))
        }
    };
    let shape = match random.below(8) {
        0..=2 => Shape::Voxel(at),
        3..=5 => {
            let min = at.to_array().map(i64::from);
            let edges = [0; 3].map(|_: i64| 1 + random.below(MOST_EDGE) as i64);
            Shape::Box(Bounds { min, max: std::array::from_fn(|i| (min[i] + edges[i]).min(1 << 31)) })
        }
        _ => {
            let radius = 1 + random.below(MOST_RADIUS) as i32;
            Shape::Ball(clamped(at.as_i64vec3(), i64::from(radius) + 1), radius)
        }
    };
    let brush = match random.below(8) {
        0..=3 => Brush::Add(material(world, random)),
        4..=6 => Brush::Subtract,
        _ => Brush::Paint(material(world, random)),
    };
    Edit { shape, brush }
}

#[cfg(test)]
mod tests {
    use raxel_edit::{Edits, Scene};
    use raxel_oracle::scenes;

    use super::*;
    use crate::stress::{Site, Sites};

    /// Two ways to apply edits, which share no code, leave the same voxels.
    #[test]
    fn the_world_that_rays_are_judged_by_is_what_operations_make() {
        let mut shapes = [0; 3];
        for (number, scene) in scenes::ALL.iter().filter(|scene| scene.name != "terrain").enumerate() {
            for sites in [Sites::Near, Sites::Far] {
                let world = Site::scene(scene, sites).build(3);
                let (scene, mut edits) = (Scene::new(world.materials(), &[]), Edits::default());
                let (mut right, mut made) = ((*world).clone(), (*world).clone());
                let mut random = Random::new(number as u64);
                for turn in 0..6 {
                    let step = step(&right, turn, &mut random);
                    let operations: Vec<Operation> = step.iter().map(Edit::operation).collect();
                    let change = edits.apply(&operations, &scene, &*world).expect("edits are in range");
                    made = made.with_chunks(world.materials(), change.after());
                    right = edited(&right, &step);
                    assert!(right == made, "{scene:?} {step:?}");
                    for edit in &step {
                        shapes[match edit.shape {
                            Shape::Voxel(_) => 0,
                            Shape::Box(_) => 1,
                            Shape::Ball(..) => 2,
                        }] += 1;
                    }
                }
                assert!(right != *world);
            }
        }
        assert!(shapes.iter().all(|count| *count > 100), "{shapes:?}");
    }
}
