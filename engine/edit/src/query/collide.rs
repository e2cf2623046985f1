//! How far a box can move before it meets something solid. In 1/256 voxel, so that nothing is rounded.

use std::sync::Arc;

use raxel_world::{AIR, Chunk, ChunkPos};

use crate::operation::UNIT;
use crate::scene::Base;

/// Longest motion along an axis, in voxels; what is asked for beyond it is cut off.
pub const MOST_MOTION: i64 = 4096;

/// What came of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collision {
    /// How far the box came, in 1/256 voxel.
    pub moved: [i64; 3],
    /// Along which axes something stopped it.
    pub stopped: [bool; 3],
}

/// Moves a box (its smallest and its largest corner, in 1/256 voxel) along y, then x, then z, as far as no solid voxel is in the way: it
/// slides along what it meets. A box that stands in something solid already is stopped by the next solid voxels only.
pub fn collide(base: &dyn Base, mut corners: [[i64; 3]; 2], motion: [i64; 3]) -> Collision {
    let mut collision = Collision { moved: [0; 3], stopped: [false; 3] };
    let mut solids = Solids::new(base);
    for axis in [1, 0, 2] {
        let wanted = motion[axis].clamp(-MOST_MOTION * UNIT, MOST_MOTION * UNIT);
        let moved = solids.sweep(corners, axis, wanted);
        corners.iter_mut().for_each(|corner| corner[axis] += moved);
        collision.moved[axis] = moved;
        collision.stopped[axis] = moved != wanted;
    }
    collision
}

/// Whether a box (its smallest and its largest corner, in 1/256 voxel) has a solid voxel in it. One that is only touched is not in it.
pub fn overlaps(base: &dyn Base, corners: [[i64; 3]; 2]) -> bool {
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
}

impl<'a> Solids<'a> {
    fn new(base: &'a dyn Base) -> Self {
        Self { base, last: None }
    }

    fn solid(&mut self, cell: [i64; 3]) -> bool {
        let [Ok(x), Ok(y), Ok(z)] = cell.map(i32::try_from) else { return false };
        let pos = ChunkPos::new(x >> 6, y >> 6, z >> 6);
        if self.last.as_ref().is_none_or(|(known, _)| *known != pos) {
            self.last = Some((pos, self.base.chunk(pos)));
        }
        let chunk = self.last.as_ref().and_then(|(_, chunk)| chunk.as_ref());
        chunk.is_some_and(|chunk| chunk.voxel((x & 63) as u32, (y & 63) as u32, (z & 63) as u32) != AIR)
    }

    fn any(&mut self, min: [i64; 3], max: [i64; 3]) -> bool {
        (min[1]..max[1]).any(|y| (min[2]..max[2]).any(|z| (min[0]..max[0]).any(|x| self.solid([x, y, z]))))
    }

    /// How far a box comes along one axis.
    fn sweep(&mut self, corners: [[i64; 3]; 2], axis: usize, wanted: i64) -> i64 {
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
            if self.any(min, max) {
                let face = if wanted > 0 { layer } else { layer + 1 };
                return face * UNIT - lead;
            }
        }
        wanted
    }
}
