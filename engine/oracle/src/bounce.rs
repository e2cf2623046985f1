//! The rays that leave hits in a random direction, bit for bit as `shaders/bench/bounce.comp` and, as period rays, `period.comp` make them.
//!
//! Directions are cosine-weighted around the normal: a point in a disk is raised to the hemisphere (Malley's method; Pharr, Jakob and
//! Humphreys, "Physically Based Rendering", 2023, section A.5.3). Everything is in whole numbers below 2¹⁵, which `f32` holds exactly.

use raxel_ray::{FACE_INSIDE, Ray};

use crate::period::{END, PeriodRay, UNIT};

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
#[expect(
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "the sum of squares is at most that of the radius"
)]
fn around(seed: u32) -> [i32; 3] {
    let [x, y] = (1..=TRIES)
        .map(|draw| hash(seed.wrapping_add(draw)))
        .map(|bits| [(bits & 0xffff).cast_signed() - 32768, (bits >> 16).cast_signed() - 32768])
        .find(|[x, y]| i64::from(*x).pow(2) + i64::from(*y).pow(2) < i64::from(RADIUS).pow(2))
        .unwrap_or([0, 0]);
    let up = ((RADIUS * RADIUS - x * x - y * y) as u32).isqrt() as i32;
    [x, y, up.max(1)]
}

/// The ray that goes on from a hit in any direction: `rx_ray_from_hit`. `uv` is the place on the face.
pub fn from_hit(voxel: [i32; 3], face: u32, uv: [f32; 2], dir: [f32; 3]) -> Ray {
    if face >= FACE_INSIDE {
        return Ray::new(voxel, [uv[0], uv[1], 0.5], dir);
    }
    let axis = (face >> 1) as usize;
    let outward = if face & 1 == 1 { 1 } else { -1 };
    let (mut cell, mut frac) = (voxel, [0.0; 3]);
    cell[axis] = cell[axis].wrapping_add(outward);
    frac[axis] = if outward == 1 { 0.0 } else { 1.0 };
    for (i, other) in (0..3).filter(|other| *other != axis).enumerate() {
        frac[other] = uv[i];
    }
    Ray::new(cell, frac, dir)
}

/// The ray that leaves a hit. `uv` is its place on the face, `pixel` the number of its pixel, row by row.
pub fn ray(voxel: [i32; 3], face: u32, uv: [f32; 2], pixel: u32) -> Ray {
    let [u, v, up] = around(hash(pixel) & 0xffff_ffe0);
    let dir = match (face >> 1, if face & 1 == 1 { up } else { -up }) {
        (0, outward) => [outward, u, v],
        (1, outward) => [u, outward, v],
        (2, outward) => [u, v, outward],
        _ => [u, v, up],
    };
    from_hit(voxel, face, uv, dir.map(|c| c as f32))
}

/// `RADIUS` over a component to the nearest whole period.
fn period(part: i32) -> u32 {
    let size = part.unsigned_abs().max(8);
    ((UNIT * RADIUS as u32 + size / 2) / size).min(END)
}

/// When the first plane is crossed with `ahead` / 4096 of a voxel to go.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts of floats saturate, as they do in the shader"
)]
fn first(period: u32, ahead: u32) -> u32 {
    // As shaders round it: one multiplication, and a power of two.
    ((period as f32 * ahead as f32) * (1.0 / 4096.0)).floor().max(1.0) as u32
}

/// The period ray that leaves a face, bit for bit as `shaders/bench/period.comp` makes it, out of 4096 directions of a quarter of the
/// hemisphere.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts of floats saturate, as they do in the shader"
)]
pub fn period_ray(voxel: [i32; 3], face: u32, uv: [f32; 2], pixel: u32) -> PeriodRay {
    let draw = hash(pixel);
    let [u, v, normal] = around(draw % 4096 * 32);
    let axis = (face >> 1) as usize;
    let up = face & 1 == 1;
    let mut ray = PeriodRay { cell: voxel, octant: u32::from(!up) << axis, first: [0; 3], period: [0; 3] };
    ray.cell[axis] = ray.cell[axis].wrapping_add(if up { 1 } else { -1 });
    ray.period[axis] = period(normal);
    ray.first[axis] = ray.period[axis];
    for (i, other) in (0..3).filter(|other| *other != axis).enumerate() {
        let place = (uv[i] * UNIT as f32) as u32;
        let down = draw >> (12 + i) & 1 == 1;
        let ahead = if down { place.max(1) } else { UNIT - place.min(UNIT - 1) };
        ray.octant |= u32::from(down) << other;
        ray.period[other] = period([u, v][i]);
        ray.first[other] = first(ray.period[other], ahead);
    }
    ray
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

    #[test]
    fn period_rays_are_cosine_weighted_too_and_start_on_their_face() {
        let (mut cosines, count) = (0.0, 20_000);
        for pixel in 0..count {
            let ray = period_ray([7, -3, 5], 4, [0.25, 0.75], pixel);
            assert_eq!((ray.cell, ray.octant & 4, ray.first[2]), ([7, -3, 4], 4, ray.period[2]));
            let dir = ray.period.map(|period| f64::from(UNIT) / f64::from(period));
            let length = dir.iter().map(|d| d * d).sum::<f64>().sqrt();
            assert!((length - 1.0).abs() < 1e-3, "{ray:?}");
            // A quarter of a voxel from the lower side, three quarters from the upper one.
            let ahead = f64::from(ray.first[0]) / f64::from(ray.period[0]);
            assert!((ahead - if ray.octant & 1 == 1 { 0.25 } else { 0.75 }).abs() < 2e-3, "{ray:?}");
            cosines += dir[2];
        }
        assert!((cosines / f64::from(count) - 2.0 / 3.0).abs() < 0.01);
    }
}
