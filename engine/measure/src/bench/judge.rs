//! The exact hits of a list of rays, and the hits of a graph's targets for the same rays.

use raxel_oracle::exact::Answer;
use raxel_oracle::metrics::{Errors, Wrong, near};
use raxel_oracle::period::PeriodRay;
use raxel_oracle::{FACE_INSIDE, Hit, Oracle, Ray, bounce};
use rayon::prelude::*;

/// Rays with their exact answers.
pub(super) struct Truth {
    pub(super) rays: Vec<Ray>,
    pub(super) answers: Vec<Answer>,
}

impl Truth {
    pub(super) fn of(oracle: &Oracle<'_>, rays: Vec<Ray>) -> Self {
        let answers = rays.par_iter().map(|ray| oracle.first_hit(ray)).collect();
        Self { rays, answers }
    }
}

/// A texel of a target `hit`: voxel, and face + 8 · material or −1.
pub(super) type HitTexel = [i32; 4];

/// Compares texels with the truth, ray by ray. `depths` are in lengths of the rays' directions.
#[expect(clippy::cast_possible_truncation, reason = "the shaders that are judged have 32-bit floats")]
pub(super) fn judge(truth: &Truth, found: &[HitTexel], depths: Option<&[f32]>) -> Errors {
    (0..truth.rays.len())
        .into_par_iter()
        .fold(Errors::default, |mut errors, i| {
            let (ray, answer) = (&truth.rays[i], &truth.answers[i]);
            let hit = read(found[i]).map(|(voxel, face, material)| {
                let depth = depths.map(|depths| depths[i]);
                // Judges materials only if the tracer looks them up, and depths only if it has them.
                let exact = answer.hit.filter(|exact| exact.voxel == voxel && exact.face == face);
                let right = exact.zip(raxel_oracle::Lattice::of(ray));
                let exact_t = right.map(|(exact, lattice)| exact.time.in_lengths(&lattice) as f32);
                Hit {
                    voxel,
                    face,
                    material: match exact {
                        Some(exact) if material == 0 => u32::from(exact.material),
                        _ => material,
                    },
                    t: depth.or(exact_t).unwrap_or_else(|| entry(ray, voxel)),
                    uv: [0.0; 2],
                    steps: 0,
                }
            });
            let wrong = errors.add(ray, answer, hit.as_ref());
            let exact = answer.hit.as_ref().zip(hit).zip(raxel_oracle::Lattice::of(ray));
            if let (None, Some(_), Some(((exact, hit), lattice))) = (wrong, depths, exact) {
                errors.time += u64::from(!near(hit.t, exact.time.in_lengths(&lattice)));
            }
            errors
        })
        .reduce(Errors::default, Errors::and)
}

/// Voxel, face and material.
fn read([x, y, z, w]: HitTexel) -> Option<([i32; 3], u32, u32)> {
    (w >= 0).then_some(([x, y, z], w.cast_unsigned() & 7, w.cast_unsigned() >> 3))
}

/// Where a ray enters a voxel's box, or comes nearest to it, in lengths of its direction: good enough to decide which of two is in front.
#[expect(clippy::cast_possible_truncation, reason = "the shaders that are judged have 32-bit floats")]
fn entry(ray: &Ray, voxel: [i32; 3]) -> f32 {
    let enter = (0..3).filter(|&axis| ray.dir[axis] != 0.0).map(|axis| {
        let d = f64::from(ray.dir[axis]);
        let ahead = (i64::from(voxel[axis]) + i64::from(d < 0.0) - i64::from(ray.cell[axis])) as f64;
        (ahead - f64::from(ray.frac[axis])) / d
    });
    enter.fold(0.0, f64::max) as f32
}

/// The rays that leave the hits, in the order of the pixels, and which pixels those are.
#[expect(clippy::cast_possible_truncation, reason = "a picture numbers its pixels in 32 bits")]
pub(super) fn bounces(hits: &[HitTexel], places: &[[f32; 2]]) -> (Vec<Ray>, Vec<usize>) {
    (0..hits.len())
        .into_par_iter()
        .filter_map(|pixel| {
            let (voxel, face, _) = read(hits[pixel])?;
            Some((bounce::ray(voxel, face, places[pixel], pixel as u32), pixel))
        })
        .unzip()
}

/// The period rays that leave the hits, and which pixels those are; none leaves a ray's own solid.
#[expect(clippy::cast_possible_truncation, reason = "a picture numbers its pixels in 32 bits")]
pub(super) fn period_bounces(hits: &[HitTexel], places: &[[f32; 2]]) -> (Vec<PeriodRay>, Vec<usize>) {
    (0..hits.len())
        .into_par_iter()
        .filter_map(|pixel| {
            let (voxel, face, _) = read(hits[pixel]).filter(|(_, face, _)| *face < FACE_INSIDE)?;
            Some((bounce::period_ray(voxel, face, places[pixel], pixel as u32), pixel))
        })
        .unzip()
}

/// Compares the hits of period rays with the truth.
pub(super) fn judge_periods(oracle: &Oracle<'_>, rays: &[PeriodRay], found: &[HitTexel]) -> Errors {
    let judged = rays.par_iter().zip(found).map(|(ray, texel)| {
        let mut errors = Errors::default();
        let (exact, found) = (ray.first_hit(oracle), read(*texel));
        let other_material = exact
            .zip(found)
            .is_some_and(|(exact, (_, _, material))| material != 0 && material != u32::from(exact.material));
        let wrong = ray.judge_face(exact.as_ref(), found.map(|(voxel, face, _)| (voxel, face)));
        let wrong = wrong.or_else(|| other_material.then_some(Wrong::Material));
        errors.add_judged(exact.is_some(), exact.is_some_and(|hit| ray.ties(&hit)), wrong);
        errors
    });
    judged.reduce(Errors::default, Errors::and)
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_world::{Material, World};

    use super::*;

    #[test]
    fn every_way_to_be_wrong_is_told_from_the_others() {
        let solids = [[5, 0, 0], [9, 0, 0]].map(|voxel| (IVec3::from_array(voxel), 1));
        let world = World::from_voxels(vec![Material::air(), Material::air()], solids);
        let along = Ray::new([0; 3], [0.5; 3], [2.0, 0.0, 0.0]);
        let past = Ray::new([0, 4, 0], [0.5; 3], [2.0, 0.0, 0.0]);
        let truth = Truth::of(&Oracle::new(&world), vec![along, past]);
        let errors = |first: HitTexel, second: HitTexel| judge(&truth, &[first, second], Some(&[2.25, 0.0]));
        let (hit, none) = ([5, 0, 0, 8], [0, 0, 0, -1]);
        let right = errors(hit, none);
        assert_eq!((right.wrong(), right.rays, right.hits), (0, 2, 1));
        assert!(right.t_error < 1e-6, "{right:?}");
        assert_eq!(errors([5, 0, 0, 0], none).wrong(), 0, "a material that is not looked up is not wrong");
        assert_eq!(errors([5, 0, 0, 16], none).material, 1);
        assert_eq!(errors([5, 0, 0, 9], none).face, 1);
        assert_eq!(errors(none, none).missed, 1);
        assert_eq!(errors(hit, hit).invented, 1);
        // Without depths the voxel decides.
        let blind = |first: HitTexel| judge(&truth, &[first, none], None);
        assert_eq!((blind([4, 0, 0, 8]).early, blind([9, 0, 0, 8]).late, blind(hit).wrong()), (1, 1, 0));
    }
}
