//! Period rays (`shaders/include/raxel/period.glsl`), traced in whole numbers of 64 bits: they cross the planes of each axis at whole
//! times, a whole period apart.

use raxel_ray::FACE_INSIDE;

use crate::oracle::Oracle;

/// Units of time in the length of a voxel's edge.
pub const UNIT: u32 = 4096;
/// A ray ends at this time.
pub const END: u32 = 1 << 24;

/// A ray that crosses plane n of an axis, counted from its cell, at `first + n · period`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodRay {
    /// Voxel that it starts in.
    pub cell: [i32; 3],
    /// Bit a: it goes down along axis a.
    pub octant: u32,
    /// 1 to `period`.
    pub first: [u32; 3],
    /// 4096 to 2²⁴.
    pub period: [u32; 3],
}

/// Where a period ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodHit {
    /// The voxel.
    pub voxel: [i32; 3],
    /// 0 −X … 5 +Z, 6 inside.
    pub face: u32,
    /// Palette index.
    pub material: u16,
    /// In 1/4096 voxels.
    pub time: u64,
}

impl PeriodRay {
    /// When it crosses its n-th plane of an axis.
    fn crossing(&self, axis: usize, n: i64) -> i64 {
        i64::from(self.first[axis]) + n * i64::from(self.period[axis])
    }

    /// How many planes of an axis it has crossed at a time, one that it crosses then included.
    fn crossed(&self, axis: usize, time: i64) -> i64 {
        let ahead = time - i64::from(self.first[axis]);
        if ahead < 0 { 0 } else { ahead / i64::from(self.period[axis]) + 1 }
    }

    /// The first solid voxel along it.
    pub fn first_hit(&self, oracle: &Oracle<'_>) -> Option<PeriodHit> {
        let sign = [0, 1, 2].map(|axis| if self.octant >> axis & 1 == 1 { -1 } else { 1 });
        let bounds = oracle.bounds();
        let at = |planes: [i64; 3]| -> [i64; 3] {
            std::array::from_fn(|axis| i64::from(self.cell[axis]) + sign[axis] * planes[axis])
        };
        let (mut planes, mut time) = ([0; 3], 0);
        loop {
            let cell = at(planes);
            let beyond = |axis: usize| {
                if sign[axis] > 0 { cell[axis] >= bounds[1][axis] } else { cell[axis] < bounds[0][axis] }
            };
            if time >= i64::from(END) || (0..3).any(beyond) {
                return None;
            }
            let free = match oracle.look(cell) {
                Ok(material) => {
                    let voxel = cell.map(|c| c as i32);
                    return Some(PeriodHit { voxel, face: self.face(planes, time), material, time: time as u64 });
                }
                Err(log2_free) => 1i64 << log2_free,
            };
            // Out of the aligned cube around the cell.
            time = (0..3)
                .map(|axis| {
                    let place = cell[axis] & (free - 1);
                    let more = if sign[axis] > 0 { free - place } else { place + 1 };
                    self.crossing(axis, planes[axis] + more - 1)
                })
                .min()
                .unwrap_or(i64::from(END));
            planes = std::array::from_fn(|axis| self.crossed(axis, time));
        }
    }

    /// Of the axes that are crossed at a time the steepest, then the first.
    fn face(&self, planes: [i64; 3], time: i64) -> u32 {
        let last = |axis: &usize| planes[*axis] > 0 && self.crossing(*axis, planes[*axis] - 1) == time;
        let axis = (0..3).filter(last).min_by_key(|&axis| self.period[axis]);
        axis.map_or(FACE_INSIDE, |axis| 2 * axis as u32 + (self.octant >> axis & 1))
    }
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_world::random::mix;
    use raxel_world::{Material, World};

    use super::*;

    /// Cell by cell, with nothing skipped.
    fn plain(world: &World, ray: &PeriodRay) -> Option<PeriodHit> {
        let (mut planes, mut time) = ([0i64; 3], 0);
        while time < i64::from(END) {
            let cell: [i32; 3] = std::array::from_fn(|axis| {
                ray.cell[axis] + planes[axis] as i32 * if ray.octant >> axis & 1 == 1 { -1 } else { 1 }
            });
            let material = world.voxel(IVec3::from_array(cell));
            if material != 0 {
                return Some(PeriodHit { voxel: cell, face: ray.face(planes, time), material, time: time as u64 });
            }
            let next: [i64; 3] = std::array::from_fn(|axis| ray.crossing(axis, planes[axis]));
            time = next.into_iter().min().unwrap_or(0);
            (0..3).filter(|&axis| next[axis] == time).for_each(|axis| planes[axis] += 1);
        }
        None
    }

    #[test]
    fn what_is_skipped_is_empty() {
        let mut state = 7u64;
        let mut random = |below: u64| {
            state = state.wrapping_add(1);
            mix(state) % below
        };
        let solids: Vec<_> =
            (0..4000).map(|_| (IVec3::from_array([0; 3].map(|_: i32| random(90) as i32 - 20)), 1)).collect();
        let world = World::from_voxels(vec![Material::air(); 2], solids);
        let oracle = Oracle::new(&world);
        let (mut hits, mut ties) = (0, 0);
        for _ in 0..4000 {
            // Few different periods, so that rays often pass through edges and corners.
            let period = [0; 3].map(|_: u32| 4096 + 512 * random(24) as u32);
            let first = std::array::from_fn(|axis| 512 * (1 + random(u64::from(period[axis] / 512))) as u32);
            let cell = [0; 3].map(|_: i32| random(130) as i32 - 40);
            let ray = PeriodRay { cell, octant: random(8) as u32, first, period };
            let found = ray.first_hit(&oracle);
            assert_eq!(found, plain(&world, &ray), "{ray:?}");
            hits += u32::from(found.is_some());
            ties += u32::from(found.is_some_and(|hit| hit.face == 6));
        }
        assert!(hits > 200 && ties < hits, "{hits} {ties}");
    }
}
