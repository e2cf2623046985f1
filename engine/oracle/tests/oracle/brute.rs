//! A second opinion on the exact tracer by an unrelated method: every voxel's box is intersected in `f64`, the nearest wins.
//! Only for worlds of a few thousand voxels.

use raxel_oracle::{Lattice, Ray};
use raxel_ray::ONE;
use raxel_world::World;

/// `f64` cannot order boxes that a ray meets within this of the nearest one's time (in voxels of the largest axis).
const TOLERANCE: f64 = 1e-6;

/// The answer of the brute-force tracer.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The ray meets no solid voxel, not even nearly.
    Miss,
    /// This voxel is first.
    Hit([i32; 3]),
    /// Too close to an edge to decide: one of these, or none when `true`.
    Unsure(Vec<[i32; 3]>, bool),
}

/// First solid voxel along a ray, by slabs.
pub(super) fn first_hit(world: &World, ray: &Ray) -> Verdict {
    let Some(lattice) = Lattice::of(ray) else { return Verdict::Miss };
    // Every box that is met for sure or nearly: entry time, how long the ray is in it, voxel. Times in voxels of the largest axis.
    let mut met: Vec<(f64, f64, [i32; 3])> = Vec::new();
    for (voxel, _) in world.voxels() {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let low = f64::from(voxel[axis]) - lattice.cell[axis] as f64 - lattice.frac[axis] as f64 / ONE as f64;
            let d = lattice.dir[axis] as f64 / f64::from(1u32 << 30);
            if d == 0.0 {
                if i64::from(voxel[axis]) != lattice.cell[axis] {
                    leave = f64::NEG_INFINITY;
                }
                continue;
            }
            let (a, b) = (low / d, (low + 1.0) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        if leave - enter > -TOLERANCE {
            met.push((enter, leave - enter, voxel.to_array()));
        }
    }
    let sure =
        met.iter().filter(|(_, chord, _)| *chord > TOLERANCE).map(|(enter, ..)| *enter).fold(f64::INFINITY, f64::min);
    let near: Vec<_> = met.into_iter().filter(|(enter, ..)| *enter <= sure + TOLERANCE).collect();
    match near.as_slice() {
        [] => Verdict::Miss,
        [(_, chord, voxel)] if *chord > TOLERANCE => Verdict::Hit(*voxel),
        _ => Verdict::Unsure(near.iter().map(|(.., voxel)| *voxel).collect(), sure == f64::INFINITY),
    }
}
