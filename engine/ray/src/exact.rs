//! Exact times along a ray, in fractions of 128-bit integers, and the hit at such a time.

use std::cmp::Ordering;

use crate::lattice::{Lattice, ONE};
use crate::ray::{FACE_INSIDE, Ray};

/// A time along the lattice ray: `numerator / denominator` lattice steps.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// Not negative.
    pub numerator: i128,
    /// Positive.
    pub denominator: i128,
}

impl Time {
    /// Where the ray begins.
    pub const ZERO: Time = Time { numerator: 0, denominator: 1 };

    /// In lengths of the ray's direction.
    pub fn in_lengths(self, lattice: &Lattice) -> f64 {
        self.numerator as f64 / self.denominator as f64 / ONE as f64 * (-f64::from(lattice.exponent)).exp2()
    }
}

impl PartialEq for Time {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Time {}

impl PartialOrd for Time {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Time {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }
}

/// From when to when a ray is in a voxel's cube, its surface included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// When it comes in, or the beginning of the ray.
    pub enter: Time,
    /// When it goes out.
    pub leave: Time,
}

impl Passage {
    /// `None` if the ray does not even touch the cube.
    pub fn of(lattice: &Lattice, voxel: [i32; 3]) -> Option<Self> {
        let mut enter = Time::ZERO;
        let mut leave: Option<Time> = None;
        for (axis, cell) in voxel.into_iter().enumerate() {
            // Both planes, from the origin, in lattice units.
            let ahead = (i64::from(cell) - lattice.cell[axis]) * ONE - lattice.frac[axis];
            let planes = [ahead, ahead + ONE];
            let d = lattice.dir[axis];
            if d == 0 {
                if planes[0] > 0 || planes[1] < 0 {
                    return None;
                }
                continue;
            }
            let [first, last] = if d > 0 { planes } else { [-planes[1], -planes[0]] };
            let time = |plane: i64| Time { numerator: i128::from(plane), denominator: i128::from(d.abs()) };
            enter = enter.max(time(first));
            leave = Some(leave.map_or(time(last), |leave| leave.min(time(last))));
        }
        leave.filter(|leave| enter <= *leave).map(|leave| Self { enter, leave })
    }

    /// The way through the cube, in voxels; 0 where it is only touched.
    pub fn length(&self, lattice: &Lattice) -> f64 {
        let (a, b) = (self.enter, self.leave);
        let difference = b.numerator * a.denominator - a.numerator * b.denominator;
        difference as f64 / (a.denominator * b.denominator) as f64 * lattice.length() / ONE as f64
    }
}

/// The exact first hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExactHit {
    /// The voxel.
    pub voxel: [i32; 3],
    /// 0 −X … 5 +Z, 6 inside.
    pub face: u32,
    /// Palette index.
    pub material: u16,
    /// When.
    pub time: Time,
}

impl ExactHit {
    /// The place on the face along the other two axes in the order x, y, z, 0…1; with face 6 the place in the voxel along x and y.
    pub fn uv(&self, ray: &Ray, lattice: &Lattice) -> [f64; 2] {
        let Time { numerator, denominator } = self.time;
        let place = [0, 1, 2].map(|axis| {
            if self.face == FACE_INSIDE || lattice.dir[axis] == 0 {
                // It does not move, so it stays where the caller has put it, whether that is on the lattice or not.
                return f64::from(ray.frac[axis].clamp(0.0, 1.0));
            }
            let from_voxel = (lattice.cell[axis] - i64::from(self.voxel[axis])) * ONE + lattice.frac[axis];
            let there = i128::from(from_voxel) * denominator + i128::from(lattice.dir[axis]) * numerator;
            there as f64 / denominator as f64 / ONE as f64
        });
        match self.face / 2 {
            0 => [place[1], place[2]],
            1 => [place[0], place[2]],
            _ => [place[0], place[1]],
        }
    }
}

/// The face through which the ray enters a voxel: that of the steepest axis crossed, or the first of several.
#[expect(clippy::cast_possible_truncation, reason = "there are three axes")]
pub fn face_of(dir: [i64; 3], crossed: [bool; 3]) -> u32 {
    let steepest = (0..3).filter(|&axis| crossed[axis]).max_by_key(|&axis| (dir[axis].abs(), 2 - axis));
    steepest.map_or(FACE_INSIDE, |axis| 2 * axis as u32 + u32::from(dir[axis] < 0))
}
