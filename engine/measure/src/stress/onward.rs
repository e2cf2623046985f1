//! Rays that continue from the hits of others, as shaders make them (`rx_ray_from_hit`, `rx_scene_ray_from_hit`), and the right answers
//! about them.

use raxel_oracle::exact::Answer;
use raxel_oracle::instances::{SceneHit, SceneOracle, SceneRay};
use raxel_oracle::sets::Random;
use raxel_oracle::{Lattice, Oracle, Ray, bounce};
use rayon::prelude::*;

use super::judge::Seen;
use super::posed::Posed;
use crate::rays::{OnwardRay, bounced};

/// Shorter directions are left out: a device may flush numbers below `f32::MIN_POSITIVE`.
const LEAST: f32 = 1e-27;

/// Rays that go on from the hits of a list of rays through voxels.
#[derive(Default)]
pub(super) struct Onward {
    /// The hits.
    pub from: Vec<OnwardRay>,
    /// The rays that go on from them.
    pub seen: Seen,
}

/// Rays that go on from hits through voxels and instances.
#[derive(Default)]
pub(super) struct OnwardScene {
    /// The hits: for the device, and exactly.
    pub from: Vec<OnwardRay>,
    pub exact_from: Vec<SceneHit>,
    /// The rays that go on from them, with the indices of their sets and their exact hits.
    pub rays: Vec<SceneRay>,
    pub sets: Vec<u16>,
    pub hits: Vec<Option<SceneHit>>,
}

impl Onward {
    /// Makes the rays from the answers to others.
    pub(crate) fn fill(&mut self, oracle: &Oracle<'_>, rays: &[Ray], sets: &[u16], answers: &[Answer]) {
        let made = rays.par_iter().zip(sets).zip(answers).enumerate().with_min_len(64);
        let made = made.filter_map(|(i, ((ray, set), answer))| {
            let (hit, lattice) = (answer.hit?, Lattice::of(ray)?);
            let exact = hit.uv(ray, &lattice).map(|place| place as f32);
            let (uv, dir) = leaving(ray, Some(exact), i)?;
            let (voxel, face, material) = (hit.voxel, hit.face, hit.material.into());
            let from = OnwardRay { voxel, face, material, uv, dir, instance: None };
            let next = bounce::from_hit(hit.voxel, hit.face, uv, bounced(dir, hit.face));
            Some((from, next, *set, oracle.first_hit(&next)))
        });
        let made: Vec<_> = made.collect();
        self.from = made.iter().map(|made| made.0).collect();
        self.seen.rays = made.iter().map(|made| made.1).collect();
        self.seen.sets = made.iter().map(|made| made.2).collect();
        self.seen.answers = made.iter().map(|made| made.3).collect();
    }
}

impl OnwardScene {
    /// Makes the rays from the hits of others through a site's instances.
    pub(crate) fn fill(
        &mut self,
        (posed, oracle): (&Posed, &SceneOracle<'_>),
        rays: &[Ray],
        sets: &[u16],
        hits: &[Option<SceneHit>],
    ) {
        let made = rays.par_iter().zip(sets).zip(hits).enumerate().with_min_len(64);
        let made = made.filter_map(|(i, ((ray, set), hit))| {
            let hit = (*hit)?;
            let (uv, dir) = leaving(ray, None, i)?;
            let free = posed.scene.model_voxel(&hit).free;
            let instance = hit.instance.map(|index| (index as u32, free));
            let (voxel, face, material) = (hit.voxel, hit.face, hit.material.into());
            let from = OnwardRay { voxel, face, material, uv, dir, instance };
            let next = posed.scene.from_hit(&hit, uv, bounced(dir, hit.face));
            Some((from, hit, next, *set, oracle.first_hit_on(&next)))
        });
        let made: Vec<_> = made.collect();
        self.from = made.iter().map(|made| made.0).collect();
        self.exact_from = made.iter().map(|made| made.1).collect();
        self.rays = made.iter().map(|made| made.2).collect();
        self.sets = made.iter().map(|made| made.3).collect();
        self.hits = made.iter().map(|made| made.4).collect();
    }
}

/// Where ray `number` leaves the face that it has hit, and its direction before it bounces there: at its exact place, if that is given, or at any, on
/// edges and corners, too. One in four is turned around first, so that it goes into the voxel that was hit.
fn leaving(ray: &Ray, exact: Option<[f32; 2]>, number: usize) -> Option<([f32; 2], [f32; 3])> {
    let largest = ray.dir.iter().fold(0.0, |largest: f32, d| largest.max(d.abs()));
    if largest < LEAST {
        return None;
    }
    let mut random = Random::new(number as u64 ^ u64::from(ray.dir[0].to_bits()) << 20);
    let anywhere = [0; 2].map(|_: i32| match random.below(8) {
        0 => 0.0,
        1 => 1.0,
        2 => 0.5,
        3 => random.unit() * 1e-6,
        _ => random.unit(),
    });
    let uv = exact.filter(|_| random.below(2) == 0).unwrap_or(anywhere);
    Some((uv, if random.below(4) == 0 { ray.dir.map(|d| -d) } else { ray.dir }))
}

#[cfg(test)]
mod tests {
    use raxel_oracle::scenes::Scene;
    use raxel_oracle::sets;

    use super::*;
    use crate::stress::{Site, Sites};

    /// Every face is left, outwards and inwards, at its edges, too, and the rays find other voxels.
    #[test]
    fn rays_go_on_from_every_face_in_either_direction() {
        let world = Site::scene(Scene::find("menger").expect("a scene"), Sites::Near).build(1);
        let oracle = Oracle::new(&world);
        let rays: Vec<Ray> = sets::ALL.iter().flat_map(|set| set.rays(&world, 200, 3)).collect();
        let answers: Vec<Answer> = rays.iter().map(|ray| oracle.first_hit(ray)).collect();
        let mut onward = Onward::default();
        onward.fill(&oracle, &rays, &vec![0; rays.len()], &answers);
        let (mut faces, mut edges, mut into, mut away) = ([0; 7], 0, 0, 0);
        for (from, answer) in onward.from.iter().zip(&onward.seen.answers) {
            faces[from.face as usize] += 1;
            edges += usize::from(from.uv.iter().any(|uv| [0.0, 1.0].contains(uv)));
            match answer.hit {
                Some(hit) if hit.voxel == from.voxel => into += 1,
                Some(_) => away += 1,
                None => {}
            }
        }
        assert!(
            faces.iter().all(|count| *count > 100) && edges > 300 && into > 300 && away > 300,
            "{faces:?} {edges} {into} {away}"
        );
    }
}
