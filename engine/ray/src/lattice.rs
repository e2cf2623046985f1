//! The ray that is traced exactly.

use crate::ray::Ray;

/// Steps of the fraction lattice in a voxel: 2²⁴.
pub const ONE: i64 = 1 << 24;

/// A ray with integer origin and direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Voxel that the ray starts in.
    pub cell: [i64; 3],
    /// Place in it in units of 2⁻²⁴ voxel: 0…2²⁴.
    pub frac: [i64; 3],
    /// Direction; the largest component is in 2³⁰…2³¹ − 1.
    pub dir: [i64; 3],
    /// The direction in voxels is `dir` × 2^`exponent`.
    pub exponent: i32,
}

impl Lattice {
    /// `None` for a ray that hits nothing by rule: not finite, or without direction.
    #[expect(clippy::cast_possible_truncation, reason = "a fraction in 0…1 of `ONE`, which 53 bits hold")]
    pub fn of(ray: &Ray) -> Option<Self> {
        let finite = ray.frac.iter().chain(&ray.dir).all(|v| v.is_finite());
        let exponent_of = |v: f32| (v.to_bits() >> 23 & 0xff).cast_signed();
        let top = ray.dir.map(exponent_of).into_iter().max().unwrap_or(0);
        if !finite || top == 0 {
            return None;
        }
        let component = |v: f32| {
            let (exponent, shift) = (exponent_of(v), top - exponent_of(v));
            if exponent == 0 || shift > 30 {
                return 0;
            }
            let size = i64::from(v.to_bits() & 0x7f_ffff | 0x80_0000) << 7 >> shift;
            if v.is_sign_negative() { -size } else { size }
        };
        Some(Self {
            cell: ray.cell.map(i64::from),
            frac: ray.frac.map(|f| (f64::from(f.clamp(0.0, 1.0)) * ONE as f64) as i64),
            dir: ray.dir.map(component),
            exponent: top - 157,
        })
    }

    /// Length of `dir`.
    pub fn length(&self) -> f64 {
        self.dir.iter().map(|d| (*d as f64).powi(2)).sum::<f64>().sqrt()
    }

    /// Whether a ray that starts on a face, an edge or a corner of its cell has a solid voxel there, or lies in a plane of the lattice.
    pub fn touches(&self, solid: impl Fn([i64; 3]) -> bool) -> bool {
        let on = |axis: usize| self.frac[axis] == 0 || self.frac[axis] == ONE;
        if (0..3).any(|axis| on(axis) && self.dir[axis] == 0) {
            return true;
        }
        let planes = (0..3).filter(|&axis| on(axis)).fold(0u32, |bits, axis| bits | 1 << axis);
        let beyond = self.frac.map(|frac| if frac == 0 { -1 } else { 1 });
        planes != 0
            && (0..8u32).filter(|some| some & !planes == 0).any(|some| {
                solid([0, 1, 2].map(|axis| self.cell[axis] + if some >> axis & 1 == 1 { beyond[axis] } else { 0 }))
            })
    }
}
