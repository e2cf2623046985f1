//! The rays that leave hits in a random direction, bit for bit as `shaders/bench/bounce.comp` makes them.
//!
//! Directions are cosine-weighted around the normal: a point in a disk is raised to the hemisphere (Malley's method; Pharr, Jakob and
//! Humphreys, "Physically Based Rendering", 2023, section A.5.3). Everything is in whole numbers below 2¹⁵, which `f32` holds exactly.

use crate::ray::{FACE_INSIDE, Ray};

/// Length of every direction, but for rounding.
const RADIUS: i32 = 32767;
/// Points that are drawn until one lies in the disk; the chance that none does is below 10⁻¹⁰.
const TRIES: u32 = 16;

/// `rx_hash`.
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A direction around the axis of length about 2¹⁵: two components across, one along.
fn around(seed: u32) -> [i32; 3] {
    let [x, y] = (1..=TRIES)
        .map(|draw| hash(seed.wrapping_add(draw)))
        .map(|bits| [(bits & 0xffff) as i32 - 32768, (bits >> 16) as i32 - 32768])
        .find(|[x, y]| i64::from(*x).pow(2) + i64::from(*y).pow(2) < i64::from(RADIUS).pow(2))
        .unwrap_or([0, 0]);
    let up = ((RADIUS * RADIUS - x * x - y * y) as u32).isqrt() as i32;
    [x, y, up.max(1)]
}

/// The ray that leaves a hit. `uv` is its place on the face, `pixel` the number of its pixel, row by row.
pub fn ray(voxel: [i32; 3], face: u32, uv: [f32; 2], pixel: u32) -> Ray {
    let [u, v, up] = around(hash(pixel) & 0xffff_ffe0);
    if face >= FACE_INSIDE {
        let dir = [u, v, up].map(|c| c as f32);
        return Ray::new(voxel, [uv[0], uv[1], 0.5], dir);
    }
    let axis = (face >> 1) as usize;
    let outward = if face & 1 == 1 { 1 } else { -1 };
    let (mut cell, mut frac, mut dir) = (voxel, [0.0; 3], [0.0; 3]);
    cell[axis] = cell[axis].wrapping_add(outward);
    frac[axis] = if outward == 1 { 0.0 } else { 1.0 };
    dir[axis] = (outward * up) as f32;
    for (i, other) in (0..3).filter(|other| *other != axis).enumerate() {
        frac[other] = uv[i];
        dir[other] = [u, v][i] as f32;
    }
    Ray::new(cell, frac, dir)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_cosine_weighted_around_the_normal() {
        let count = 20_000;
        for face in 0..6 {
            let axis = face as usize >> 1;
            let side = if face & 1 == 1 { 1.0 } else { -1.0 };
            let cosines: Vec<f32> = (0..count)
                .map(|pixel| {
                    let ray = ray([7, -3, 5], face, [0.25, 0.75], pixel);
                    let length = ray.dir.iter().map(|d| d * d).sum::<f32>().sqrt();
                    assert!((length - RADIUS as f32).abs() < 2.0, "{ray:?}");
                    ray.dir[axis] * side / length
                })
                .collect();
            assert!(cosines.iter().all(|cosine| *cosine > 0.0), "face {face} looks outwards");
            // The mean of a cosine-weighted cosine is 2/3, that of its square 1/2.
            let mean = cosines.iter().sum::<f32>() / count as f32;
            let square = cosines.iter().map(|cosine| cosine * cosine).sum::<f32>() / count as f32;
            assert!((mean - 2.0 / 3.0).abs() < 0.01 && (square - 0.5).abs() < 0.01, "{mean} {square}");
        }
    }

    #[test]
    fn it_starts_on_the_face_in_the_neighbour() {
        let ray = ray([7, -3, 5], 2, [0.25, 0.75], 9);
        assert_eq!((ray.cell, ray.frac), ([7, -4, 5], [0.25, 1.0, 0.75]));
        assert!(ray.dir[1] < 0.0);
    }
}
