//! Period rays (`shaders/include/raxel/period.glsl`), traced in whole numbers of 64 bits: they cross the planes of each axis at whole
//! times, a whole period apart.

use raxel_ray::{FACE_INSIDE, Ray};

use crate::metrics::{Outcome, Wrong};
use crate::oracle::Oracle;

/// Units of time in the length of a voxel's edge.
pub const UNIT: u32 = 4096;
/// A ray ends at this time.
pub(crate) const END: u32 = 1 << 24;

/// A ray that crosses plane n of an axis, counted from its cell, at `first + n · period`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodRay {
    /// Voxel that it starts in.
    pub cell: [i32; 3],
    /// Bit a: it goes down along axis a.
    pub octant: u32,
    /// 1 to `period`.
    pub first: [u32; 3],
    /// 4096 to 2²⁴. With a period of 0 the ray hits nothing.
    pub period: [u32; 3],
}

/// A direction with less than this part of its length along an axis crosses no plane of it.
const STILL: f64 = 1.0 / 8192.0;

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

/// A coordinate of a hit on its face, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct FaceCoordinate {
    /// Its exact value.
    pub value: f64,
    /// The largest error of a tracer in `f32`: the loss of 1 / period on the way there.
    pub tolerance: f64,
}

impl PeriodRay {
    /// The period ray next to a ray, by the rule of `rx_period_ray`; `None` if the ray has no direction. `t_max` is not kept.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is clamped")]
    pub fn near(ray: &Ray) -> Option<Self> {
        let dir = ray.dir.map(f64::from);
        let length = dir.iter().map(|d| d * d).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite() && ray.frac.iter().all(|f| (0.0..=1.0).contains(f))) {
            return None;
        }
        let dir = dir.map(|d| d / length);
        let still = dir.map(|d| d.abs() < STILL);
        let whole = |value: f64, least: u32, most: u32| value.round_ties_even().clamp(least.into(), most.into()) as u32;
        let period = dir.map(|d| whole(f64::from(UNIT) / d.abs().max(STILL), UNIT, END));
        let first = std::array::from_fn(|axis| {
            let frac = f64::from(ray.frac[axis]);
            let ahead = if dir[axis] < 0.0 { frac } else { 1.0 - frac };
            if still[axis] { END } else { whole(f64::from(period[axis]) * ahead, 1, period[axis]) }
        });
        let octant = (0..3).filter(|&axis| dir[axis] < 0.0).fold(0, |bits, axis| bits | 1 << axis);
        Some(Self { cell: ray.cell, octant, first, period })
    }

    /// A ray near this one whose times are multiples of 1024, so that it often crosses planes of several axes at once.
    #[must_use]
    pub fn coarse(self) -> Self {
        let step = 1024;
        let round = |time: u32, least: u32| ((time + step / 2) / step * step).max(least);
        let period = self.period.map(|period| round(period, UNIT));
        Self { period, first: std::array::from_fn(|axis| round(self.first[axis], step).min(period[axis])), ..self }
    }

    /// When it crosses its n-th plane of an axis.
    fn crossing(&self, axis: usize, n: i64) -> i64 {
        i64::from(self.first[axis]) + n * i64::from(self.period[axis])
    }

    /// The number of planes of an axis that it has crossed up to a time, including a crossing at that time.
    fn crossed(&self, axis: usize, time: i64) -> i64 {
        let ahead = time - i64::from(self.first[axis]);
        if ahead < 0 { 0 } else { ahead / i64::from(self.period[axis]) + 1 }
    }

    /// The first solid voxel along it.
    #[expect(clippy::cast_possible_truncation, reason = "cells of the world have 32 bits")]
    pub fn first_hit(&self, oracle: &Oracle<'_>) -> Option<PeriodHit> {
        if self.period.contains(&0) {
            return None;
        }
        let sign = [0, 1, 2].map(|axis| self.sign(axis));
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
                    return Some(PeriodHit {
                        voxel,
                        face: self.face(planes, time),
                        material,
                        time: time.cast_unsigned(),
                    });
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

    fn sign(&self, axis: usize) -> i64 {
        if self.octant >> axis & 1 == 1 { -1 } else { 1 }
    }

    /// The axes whose planes are crossed at a time.
    fn crossed_at(&self, planes: [i64; 3], time: i64) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(move |&axis| planes[axis] > 0 && self.crossing(axis, planes[axis] - 1) == time)
    }

    /// Of the axes that are crossed at a time the steepest, then the first.
    #[expect(clippy::cast_possible_truncation, reason = "there are three axes")]
    fn face(&self, planes: [i64; 3], time: i64) -> u32 {
        let axis = self.crossed_at(planes, time).min_by_key(|&axis| self.period[axis]);
        axis.map_or(FACE_INSIDE, |axis| 2 * axis as u32 + (self.octant >> axis & 1))
    }

    /// Planes of each axis that are crossed until a hit.
    fn planes(&self, hit: &PeriodHit) -> [i64; 3] {
        std::array::from_fn(|axis| (i64::from(hit.voxel[axis]) - i64::from(self.cell[axis])) * self.sign(axis))
    }

    /// Whether it comes into the voxel that it hits by an edge or a corner.
    pub fn ties(&self, hit: &PeriodHit) -> bool {
        self.crossed_at(self.planes(hit), hit.time.cast_signed()).count() > 1
    }

    /// Where it hits the face, along its two axes.
    pub fn place(&self, hit: &PeriodHit) -> [FaceCoordinate; 2] {
        let planes = self.planes(hit);
        let along = |axis: usize| {
            let crossed = (hit.time as f64 - f64::from(self.first[axis])) / f64::from(self.period[axis]);
            let within = (crossed + 1.0 - planes[axis] as f64).clamp(0.0, 1.0);
            let value = if self.sign(axis) < 0 { 1.0 - within } else { within };
            FaceCoordinate { value, tolerance: (crossed.abs() + 1.0) * 4.0 * 2f64.powi(-23) }
        };
        [[1, 2], [0, 2], [0, 1], [0, 1]][(hit.face / 2) as usize].map(along)
    }

    /// In which way a hit is wrong, by its voxel and face alone.
    pub fn judge_face(&self, exact: Option<&PeriodHit>, found: Option<([i32; 3], u32)>) -> Option<Wrong> {
        let gone = |voxel: [i32; 3]| (0..3).map(|i| u64::from(voxel[i].abs_diff(self.cell[i]))).sum::<u64>();
        match (exact, found) {
            (None, None) => None,
            (Some(_), None) => Some(Wrong::Miss),
            (None, Some(_)) => Some(Wrong::False),
            (Some(exact), Some((voxel, _))) if exact.voxel != voxel => {
                Some(if gone(voxel) < gone(exact.voxel) { Wrong::Early } else { Wrong::Late })
            }
            (Some(exact), Some((_, face))) => (exact.face != face).then_some(Wrong::Face),
        }
    }

    /// In which way a tracer is wrong about the ray. Times are whole numbers, so t has no error.
    pub fn judge(&self, exact: Option<&PeriodHit>, found: Outcome<'_>) -> Option<Wrong> {
        let found = match found {
            Outcome::Hang => return Some(Wrong::Hang),
            Outcome::Unwritten => return Some(Wrong::Unwritten),
            Outcome::Miss => None,
            Outcome::Hit(hit) if !(hit.t.is_finite() && hit.uv.iter().all(|uv| uv.is_finite())) => {
                return Some(Wrong::NotFinite);
            }
            Outcome::Hit(hit) => Some(hit),
        };
        let wrong = self.judge_face(exact, found.map(|hit| (hit.voxel, hit.face)));
        let (None, Some(exact), Some(found)) = (wrong, exact, found) else { return wrong };
        let off = |(found, exact): (&f32, FaceCoordinate)| (f64::from(*found) - exact.value).abs() > exact.tolerance;
        if found.material != u32::from(exact.material) {
            Some(Wrong::Material)
        } else if (f64::from(found.t) * f64::from(UNIT) - exact.time as f64).abs() > 0.0 {
            Some(Wrong::Time)
        } else {
            found.uv.iter().zip(self.place(exact)).any(off).then_some(Wrong::Place)
        }
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
