//! Finds how far a box can move before it meets something solid. Lengths are in 1/256 voxel, so nothing is rounded.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_world::{AIR, Chunk, ChunkPos, Unavailable};

use crate::operation::UNIT;
use crate::scene::Base;

/// Longest motion along an axis, in voxels; the rest is cut off.
pub const MOST_MOTION: i64 = 4096;

/// The result of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collision {
    /// The distance that the box came, in 1/256 voxel.
    pub moved: [i64; 3],
    /// Along which axes something stopped it.
    pub stopped: [bool; 3],
}

/// Moves a box (its smallest and its largest corner, in 1/256 voxel) along y, then x, then z, until a solid voxel is in the way: it
/// slides along obstacles. If the box begins in something solid, only further solid voxels stop it.
///
/// # Errors
/// When the box comes to a chunk that is unavailable before something stops it.
pub fn collide(base: &dyn Base, mut corners: [[i64; 3]; 2], motion: [i64; 3]) -> Result<Collision, Unavailable> {
    let mut collision = Collision { moved: [0; 3], stopped: [false; 3] };
    let mut solids = Solids::new(base);
    for axis in [1, 0, 2] {
        let wanted = motion[axis].clamp(-MOST_MOTION * UNIT, MOST_MOTION * UNIT);
        let moved = solids.sweep(corners, axis, wanted)?;
        corners.iter_mut().for_each(|corner| corner[axis] += moved);
        collision.moved[axis] = moved;
        collision.stopped[axis] = moved != wanted;
    }
    Ok(collision)
}

/// Whether a box (its smallest and its largest corner, in 1/256 voxel) has a solid voxel in it. One that is only touched is not in it.
///
/// # Errors
/// When no solid voxel is known in the box, and one of its chunks is unavailable.
pub fn overlaps(base: &dyn Base, corners: [[i64; 3]; 2]) -> Result<bool, Unavailable> {
    let [min, max] = cells(corners);
    Solids::new(base).any(min, max)
}

/// The cells of a box, half open: those whose inside it meets.
fn cells([min, max]: [[i64; 3]; 2]) -> [[i64; 3]; 2] {
    [min.map(|m| m.div_euclid(UNIT)), max.map(|m| -(-m).div_euclid(UNIT))]
}

/// Solid voxels by their cells; the last chunk is kept at hand.
struct Solids<'a> {
    base: &'a dyn Base,
    last: Option<(ChunkPos, Option<Arc<Chunk>>)>,
    /// Chunks that the base could not give. Each request may take long, so it is not repeated.
    unavailable: BTreeMap<ChunkPos, Unavailable>,
}

impl<'a> Solids<'a> {
    fn new(base: &'a dyn Base) -> Self {
        Self { base, last: None, unavailable: BTreeMap::new() }
    }

    /// Whether a cell is solid; as an error the position of its chunk, which is unavailable.
    fn solid(&mut self, cell: [i64; 3]) -> Result<bool, ChunkPos> {
        let [Ok(x), Ok(y), Ok(z)] = cell.map(i32::try_from) else { return Ok(false) };
        let pos = ChunkPos::new(x >> 6, y >> 6, z >> 6);
        let chunk = match &self.last {
            Some((known, chunk)) if *known == pos => chunk,
            _ if self.unavailable.contains_key(&pos) => return Err(pos),
            _ => match self.base.try_chunk(pos) {
                Ok(chunk) => &self.last.insert((pos, chunk)).1,
                Err(error) => {
                    self.unavailable.insert(pos, error);
                    return Err(pos);
                }
            },
        };
        let voxel =
            |chunk: &Chunk| chunk.voxel((x & 63).cast_unsigned(), (y & 63).cast_unsigned(), (z & 63).cast_unsigned());
        Ok(chunk.as_deref().is_some_and(|chunk| voxel(chunk) != AIR))
    }

    /// Whether a box of cells has a solid one. A solid voxel decides, wherever it is; a chunk that is unavailable matters only without one.
    fn any(&mut self, min: [i64; 3], max: [i64; 3]) -> Result<bool, Unavailable> {
        let mut unknown = None;
        for y in min[1]..max[1] {
            for z in min[2]..max[2] {
                let mut x = min[0];
                while x < max[0] {
                    match self.solid([x, y, z]) {
                        Ok(true) => return Ok(true),
                        Ok(false) => x += 1,
                        Err(pos) => {
                            unknown = Some(pos);
                            // The rest of the row in that chunk is not known either.
                            x = (x | 63) + 1;
                        }
                    }
                }
            }
        }
        unknown.and_then(|pos| self.unavailable.get(&pos)).map_or(Ok(false), |error| Err(error.clone()))
    }

    /// The distance that a box comes along one axis.
    fn sweep(&mut self, corners: [[i64; 3]; 2], axis: usize, wanted: i64) -> Result<i64, Unavailable> {
        let [mut min, mut max] = cells(corners);
        let lead = if wanted > 0 { corners[1][axis] } else { corners[0][axis] };
        let goal = lead + wanted;
        // Layer by layer, from the first that it is not in yet.
        let layers: Box<dyn Iterator<Item = i64>> = if wanted > 0 {
            Box::new(max[axis]..-(-goal).div_euclid(UNIT))
        } else {
            Box::new((goal.div_euclid(UNIT)..min[axis]).rev())
        };
        for layer in layers {
            (min[axis], max[axis]) = (layer, layer + 1);
            if self.any(min, max)? {
                let face = if wanted > 0 { layer } else { layer + 1 };
                return Ok(face * UNIT - lead);
            }
        }
        Ok(wanted)
    }
}
