//! The first solid voxel along a ray, exactly: the rule of the oracle, followed from chunk to chunk.

use std::sync::Arc;

use raxel_ray::exact::{ExactHit, Time, face_of};
use raxel_ray::{Lattice, Ray};
use raxel_world::{Chunk, ChunkPos, Unavailable, block_index, child_index};

use crate::scene::Base;

/// Steps of the ray's lattice in a voxel.
const ONE: i128 = raxel_ray::ONE as i128;

/// Cubes that a ray looks at, at most: chunks, nodes, blocks and voxels together.
const MOST_STEPS: u32 = 1 << 20;

/// The first thing that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// The voxel, its material, and the face: 0 −X, 1 +X, 2 −Y, 3 +Y, 4 −Z, 5 +Z, 6 when the ray starts inside.
    pub exact: ExactHit,
    /// Voxels from the origin of the ray.
    pub distance: f64,
}

impl CastHit {
    /// The empty cell in front of the face, where something would be placed. The voxel itself when the ray starts inside, or at the
    /// end of the range of coordinates.
    pub fn front(&self) -> [i32; 3] {
        let mut cell = self.exact.voxel;
        let axis = (self.exact.face / 2) as usize;
        if axis < 3 {
            cell[axis] = cell[axis].saturating_add(if self.exact.face & 1 == 1 { 1 } else { -1 });
        }
        cell
    }
}

/// The first solid voxel along a ray, not farther than `reach` voxels. `None` as well for a ray that hits nothing by rule: one that is not
/// finite, or without direction. It looks at 2²⁰ cubes at most: through chunks of air it comes 67 million voxels far along an axis.
///
/// # Errors
/// When the ray comes to a chunk that is unavailable before it meets anything. A hit in front of that chunk is exact.
pub fn cast(base: &dyn Base, ray: &Ray, reach: f64) -> Result<Option<CastHit>, Unavailable> {
    let Some(lattice) = Lattice::of(ray) else { return Ok(None) };
    let mut walk = Walk::new(lattice);
    let mut chunk: Option<(ChunkPos, Option<Arc<Chunk>>)> = None;
    for _ in 0..MOST_STEPS {
        let Some(cell) = walk.in_range() else { return Ok(None) };
        let pos = ChunkPos::new(cell[0] >> 6, cell[1] >> 6, cell[2] >> 6);
        let voxels = match &chunk {
            Some((known, voxels)) if *known == pos => voxels,
            _ => &chunk.insert((pos, base.try_chunk(pos)?)).1,
        };
        let local = cell.map(|c| (c & 63).cast_unsigned());
        match voxels.as_deref().map_or(Err(6), |chunk| look(chunk, local)) {
            Ok(material) => {
                let hit = walk.hit(cell, material);
                let distance = hit.time.numerator as f64 / hit.time.denominator as f64 / ONE as f64 * lattice.length();
                return Ok((distance <= reach).then_some(CastHit { exact: hit, distance }));
            }
            Err(log2) => walk.leave(log2),
        }
        if walk.distance() > reach {
            return Ok(None);
        }
    }
    Ok(None)
}

/// The material at chunk-local coordinates, or else the size of the largest empty cube around them.
fn look(chunk: &Chunk, [x, y, z]: [u32; 3]) -> Result<u16, u32> {
    let node = child_index(x >> 4, y >> 4, z >> 4) as usize;
    if chunk.node_mask(node) == 0 {
        return Err(4);
    }
    let mask = chunk.mask(block_index(x >> 2, y >> 2, z >> 2));
    if mask == 0 {
        return Err(2);
    }
    if mask >> child_index(x & 3, y & 3, z & 3) & 1 == 0 {
        return Err(0);
    }
    Ok(chunk.voxel(x, y, z))
}

/// A ray on its way. All times are fractions that begin at its origin, so that nothing adds up to an error.
struct Walk {
    lattice: Lattice,
    cell: [i64; 3],
    sign: [i64; 3],
    /// Fraction and direction, mirrored so that the direction is not negative.
    g: [i128; 3],
    d: [i128; 3],
    crossed: [bool; 3],
    time: Time,
}

impl Walk {
    fn new(lattice: Lattice) -> Self {
        let g = [0, 1, 2].map(|axis| match lattice.dir[axis] {
            0 => 0,
            1.. => i128::from(lattice.frac[axis]),
            _ => ONE - i128::from(lattice.frac[axis]),
        });
        Self {
            cell: lattice.cell,
            sign: lattice.dir.map(|d| if d < 0 { -1 } else { 1 }),
            g,
            d: lattice.dir.map(|d| i128::from(d.abs())),
            crossed: [false; 3],
            time: Time::ZERO,
            lattice,
        }
    }

    /// The cell, unless the ray has left the range of coordinates.
    fn in_range(&self) -> Option<[i32; 3]> {
        let [x, y, z] = self.cell.map(|c| i32::try_from(c).ok());
        Some([x?, y?, z?])
    }

    /// Leaves the aligned cube of 2^`log2` voxels around the cell, over all planes that are crossed at once.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the earliest way out is taken, so that no axis crosses more planes than the cube has"
    )]
    fn leave(&mut self, log2: u32) {
        let size = 1_i64 << log2;
        let exit = |axis: usize| {
            let place = self.cell[axis] & (size - 1);
            let planes = if self.sign[axis] > 0 { size - place } else { place + 1 };
            let count = (self.cell[axis] - self.lattice.cell[axis]) * self.sign[axis] + planes;
            Time { numerator: i128::from(count) * ONE - self.g[axis], denominator: self.d[axis] }
        };
        let moving = (0..3).filter(|&axis| self.d[axis] != 0);
        // The largest component is never zero.
        let Some((first, time)) = moving.map(|axis| (axis, exit(axis))).min_by(|a, b| a.1.cmp(&b.1)) else { return };
        let mut crossed = [false; 3];
        let mut cell = self.cell;
        for axis in 0..3 {
            if self.d[axis] == 0 {
                continue;
            }
            // Planes that the ray has crossed by then, in units of the two denominators.
            let passed = time.numerator * self.d[axis] + self.g[axis] * self.d[first];
            let unit = ONE * self.d[first];
            let count = passed.div_euclid(unit);
            cell[axis] = self.lattice.cell[axis] + self.sign[axis] * count as i64;
            crossed[axis] = cell[axis] != self.cell[axis] && passed.rem_euclid(unit) == 0;
        }
        (self.cell, self.crossed, self.time) = (cell, crossed, time);
    }

    /// Voxels from the origin.
    fn distance(&self) -> f64 {
        self.time.numerator as f64 / self.time.denominator as f64 / ONE as f64 * self.lattice.length()
    }

    fn hit(&self, voxel: [i32; 3], material: u16) -> ExactHit {
        ExactHit { voxel, face: face_of(self.lattice.dir, self.crossed), material, time: self.time }
    }
}
