//! How wrong a tracer is.

use crate::exact::Answer;
use crate::lattice::Lattice;
use crate::ray::{Hit, Ray};

/// Counts over a set of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit something by the exact tracer.
    pub hits: u64,
    /// Rays that go through an edge or a corner.
    pub ties: u64,
    /// A hit where there is one was missed.
    pub missed: u64,
    /// A hit was reported where there is none.
    pub invented: u64,
    /// The voxel hit lies before the right one.
    pub early: u64,
    /// The voxel hit lies behind the right one.
    pub late: u64,
    /// The right voxel, another face.
    pub face: u64,
    /// The right voxel and face, another material.
    pub material: u64,
    /// Wrong in any of these ways, though the ray meets no tie.
    pub wrong_without_tie: u64,
    /// Largest difference in t of a right hit, relative to t or absolute below 1 voxel, in voxels.
    pub t_error: f64,
}

impl Errors {
    /// Wrong in any way.
    pub fn wrong(&self) -> u64 {
        self.missed + self.invented + self.early + self.late + self.face + self.material
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ties: self.ties + other.ties,
            missed: self.missed + other.missed,
            invented: self.invented + other.invented,
            early: self.early + other.early,
            late: self.late + other.late,
            face: self.face + other.face,
            material: self.material + other.material,
            wrong_without_tie: self.wrong_without_tie + other.wrong_without_tie,
            t_error: self.t_error.max(other.t_error),
        }
    }

    /// Adds one ray.
    pub fn add(&mut self, ray: &Ray, exact: &Answer, found: Option<&Hit>) {
        let before = self.wrong();
        self.rays += 1;
        self.hits += u64::from(exact.hit.is_some());
        self.ties += u64::from(exact.tie);
        match (exact.hit, found, Lattice::of(ray)) {
            (None, None, _) => {}
            (Some(_), None, _) => self.missed += 1,
            (None, Some(_), _) | (Some(_), Some(_), None) => self.invented += 1,
            (Some(exact), Some(found), Some(lattice)) => {
                let t = exact.time.in_lengths(&lattice);
                if exact.voxel != found.voxel {
                    if f64::from(found.t) < t { self.early += 1 } else { self.late += 1 }
                } else if exact.face != found.face {
                    self.face += 1;
                } else if u32::from(exact.material) != found.material {
                    self.material += 1;
                } else {
                    // In voxels along the largest axis, for distances below 1, else relative.
                    let voxels = t * (f64::from(lattice.exponent) + 30.0).exp2();
                    let error = (f64::from(found.t) / t - 1.0).abs() * voxels.min(1.0);
                    self.t_error = self.t_error.max(if t > 0.0 { error } else { f64::from(found.t).abs() });
                }
            }
        }
        if !exact.tie {
            self.wrong_without_tie += self.wrong() - before;
        }
    }
}
