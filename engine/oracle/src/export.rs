//! Worlds, rays and exact hits as files for other tracers, in the format of `docs/bench-export.md`. Everything is relative to the smallest
//! corner of the world's solid voxels, and little-endian.

use std::io::{self, Write};

use raxel_ray::{Lattice, ONE, Ray};
use raxel_world::World;
use rayon::prelude::*;

use crate::oracle::Oracle;

/// First bytes of a file of voxels.
pub const MAGIC: [u8; 4] = *b"RXVX";
/// Of the format.
pub const VERSION: u32 = 1;
/// Voxels that a box may have on a side: coordinates have 16 bits.
pub const LARGEST: u64 = 1 << 16;
/// Face of a ray that hits nothing.
pub(crate) const NO_FACE: u32 = u32::MAX;

/// Why a world has no such files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// There is no voxel.
    #[error("the world has no voxel")]
    Empty,
    /// Coordinates do not fit.
    #[error("the world is {size} voxels wide, and exported coordinates have 16 bits: at most {LARGEST}")]
    TooWide {
        /// Its longest side in voxels.
        size: u64,
    },
}

/// The corner that everything is relative to.
#[expect(clippy::cast_possible_truncation, reason = "cells of the world have 32 bits")]
pub fn corner(world: &World) -> Result<[i32; 3], ExportError> {
    let bounds = world.bounds().ok_or(ExportError::Empty)?;
    let size = bounds.size().into_iter().max().unwrap_or(0);
    if size > LARGEST {
        return Err(ExportError::TooWide { size });
    }
    // The smallest voxel has coordinates of 32 bits.
    Ok(bounds.min.map(|c| c as i32))
}

/// Writes the voxels.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`corner` has found that coordinates have 16 bits"
)]
pub fn voxels(world: &World, corner: [i32; 3], to: &mut dyn Write) -> io::Result<()> {
    to.write_all(&MAGIC)?;
    to.write_all(&VERSION.to_le_bytes())?;
    to.write_all(&world.solids().to_le_bytes())?;
    for c in corner {
        to.write_all(&c.to_le_bytes())?;
    }
    for (voxel, material) in world.voxels() {
        for axis in 0..3 {
            // Differences of i32 that `corner` has found to fit 16 bits.
            to.write_all(&(voxel[axis].wrapping_sub(corner[axis]) as u16).to_le_bytes())?;
        }
        to.write_all(&material.to_le_bytes())?;
    }
    Ok(())
}

/// A ray whose numbers, relative to a corner, are `f32` without rounding: its origin is put on the nearest such place, and its direction
/// is cut as the lattice cuts it, so that every reader traces exactly this ray. `None` when it hits nothing by the rule, or its origin
/// leaves the range of coordinates.
#[expect(clippy::cast_possible_truncation, reason = "exported rays and times are 32-bit floats")]
pub fn representable(ray: &Ray, corner: [i32; 3]) -> Option<Exported> {
    let lattice = Lattice::of(ray)?;
    let (mut cell, mut frac, mut origin) = ([0; 3], [0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let cells = lattice.cell[axis] - i64::from(corner[axis]);
        let fixed = i128::from(cells) * i128::from(ONE) + i128::from(lattice.frac[axis]);
        // Rounded once to 24 bits; the rest is a multiple of 2⁻²⁴, and so is its fraction.
        let rounded = (fixed as f64 / ONE as f64) as f32;
        origin[axis] = rounded;
        let whole = f64::from(rounded).floor();
        frac[axis] = (f64::from(rounded) - whole) as f32;
        cell[axis] = i32::try_from(whole as i64 + i64::from(corner[axis])).ok()?;
    }
    let unit = f64::from(lattice.exponent).exp2();
    let dir = lattice.dir.map(|d| (d as f64 * unit) as f32);
    Some(Exported { ray: Ray { cell, frac, dir, t_max: ray.t_max }, origin })
}

/// A ray as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exported {
    /// In the world.
    pub ray: Ray,
    /// Its origin relative to the corner.
    pub origin: [f32; 3],
}

/// The files of an export.
pub struct ExportFiles<'w> {
    /// The rays.
    pub rays: &'w mut dyn Write,
    /// Their exact hits.
    pub hits: &'w mut dyn Write,
    /// A byte a ray.
    pub ties: &'w mut dyn Write,
}

/// Writes rays, their exact hits, and a byte a ray that is 1 where another rule for ties may give another hit.
#[expect(clippy::cast_possible_truncation, reason = "exported rays and times are 32-bit floats")]
pub fn rays_and_hits(
    oracle: &Oracle<'_>,
    corner: [i32; 3],
    rays: &[Exported],
    to: &mut ExportFiles<'_>,
) -> io::Result<()> {
    let records: Vec<([u8; 32], [u8; 20], u8)> = rays
        .par_iter()
        .map(|exported| {
            let answer = oracle.first_hit(&exported.ray);
            let (mut ray, mut hit) = ([0; 32], [0; 20]);
            let numbers = [exported.origin, exported.ray.dir].map(|[x, y, z]| [x, y, z, 0.0]);
            for (i, number) in numbers.concat().into_iter().enumerate() {
                let number = if i == 7 { exported.ray.t_max } else { number };
                ray[4 * i..4 * i + 4].copy_from_slice(&number.to_le_bytes());
            }
            let (voxel, face, t) = match (answer.hit, Lattice::of(&exported.ray)) {
                (Some(hit), Some(lattice)) => (
                    std::array::from_fn(|axis| hit.voxel[axis].wrapping_sub(corner[axis])),
                    hit.face,
                    hit.time.in_lengths(&lattice) as f32,
                ),
                _ => ([-1i32; 3], NO_FACE, -1.0),
            };
            for axis in 0..3 {
                hit[4 * axis..4 * axis + 4].copy_from_slice(&voxel[axis].to_le_bytes());
            }
            hit[12..16].copy_from_slice(&face.to_le_bytes());
            hit[16..20].copy_from_slice(&t.to_le_bytes());
            (ray, hit, u8::from(answer.tie))
        })
        .collect();
    for (ray, hit, tie) in &records {
        to.rays.write_all(ray)?;
        to.hits.write_all(hit)?;
        to.ties.write_all(&[*tie])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;
    use crate::scenes::materials;

    #[test]
    fn what_is_written_is_what_is_traced() {
        let corner = [-1024, 7, 1 << 30];
        let odd = [0.1f32, 0.999_999_94, 1.0 / 3.0];
        for (shift, dir) in [(0, [0.3f32, -1e-4, 1.0]), (3000, [1e-3, 1.0, -0.77]), (-2_000_000, [-7e-7, -0.5, 0.25])] {
            let cell = corner.map(|c: i32| c + shift);
            let exported = representable(&Ray::new(cell, odd, dir), corner).unwrap();
            let ray = exported.ray;
            for (axis, corner) in corner.into_iter().enumerate() {
                let exact = f64::from(ray.cell[axis] - corner) + f64::from(ray.frac[axis]);
                assert_eq!(f64::from(exported.origin[axis]).to_bits(), exact.to_bits(), "{exported:?}");
                assert!((0.0..=1.0).contains(&ray.frac[axis]));
            }
            // Cutting again cuts nothing.
            let again = representable(&ray, corner).unwrap();
            assert_eq!(again, exported);
            let lattice = Lattice::of(&ray).unwrap();
            let unit = f64::from(lattice.exponent).exp2();
            assert!(
                (0..3).all(|axis| f64::from(ray.dir[axis]).to_bits() == (lattice.dir[axis] as f64 * unit).to_bits())
            );
        }
    }

    #[test]
    fn wide_and_empty_worlds_are_refused() {
        let wide = |x: i32| World::from_voxels(materials(), [(IVec3::ZERO, 1), (IVec3::new(x, 0, 0), 1)]);
        assert_eq!(corner(&World::empty()), Err(ExportError::Empty));
        assert_eq!(corner(&wide(65_536)), Err(ExportError::TooWide { size: 65_537 }));
        assert_eq!(corner(&wide(-65_535)), Ok([-65_535, 0, 0]));
    }
}
