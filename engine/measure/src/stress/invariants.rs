//! Invariants that need no oracle: a scene that is moved, turned or mirrored is hit alike.

use std::sync::Arc;

use glam::IVec3;
use raxel_gpu::Device;
use raxel_oracle::scenes::Scene;
use raxel_oracle::sets::RaySet;
use raxel_oracle::{FACE_INSIDE, Hit, Oracle, Ray};
use raxel_world::World;
use serde::Serialize;

use super::plan::Plan;
use crate::rays::{RayError, Stream, Tracer};

/// The scenes that were compared with the original, and how many rays differed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Invariants {
    /// Hits and misses of moved rays.
    pub moved: u64,
    /// Of these, other ones: in any bit of voxel, face, t or uv.
    pub moved_wrong: u64,
    /// Hits and misses of rays under the cube's 48 symmetries.
    pub turned: u64,
    /// Of these, other ones: in the voxel, a bit of t, or (where no edge is hit) the face.
    pub turned_wrong: u64,
}

/// Where the scene is moved to, from around the origin.
const MOVES: [[i32; 3]; 4] = [
    [1_000_000, -70_001, 3],
    [i32::MAX - 200, i32::MIN + 200, 123_456_789],
    [-(1 << 24) - 1, 1 << 30, 63],
    [64, -64, 0],
];

/// Traces `rays` rays of several sets each through a scene, and through the scene moved, turned and mirrored, with the seed and the watchdog of a plan.
pub fn invariants(tracer: &mut Tracer, device: &Arc<Device>, plan: &Plan, rays: usize) -> Result<Invariants, RayError> {
    let seed = plan.seed;
    let mut stream = Stream::with_capacity(device, 1 << 13)?.with_patience(plan.watchdog);
    let Some(scene) = Scene::find("gravel") else { return Ok(Invariants::default()) };
    let corner = IVec3::new(-30, 7, 3);
    let here = scene.world(corner, seed);
    let rays: Vec<Ray> = ["pinhole", "edges", "faces", "lattice", "near-ties", "tiny", "inside", "zeros"]
        .iter()
        .filter_map(|set| RaySet::find(set))
        .flat_map(|set| set.rays(&here, rays, seed))
        .collect();
    let mut trace = |world: &World, rays: &[Ray]| -> Result<Vec<Option<Hit>>, RayError> {
        let world = tracer.upload(world)?;
        Ok(stream.trace_all(tracer, &world, rays)?.iter().map(crate::rays::HitWords::hit).collect())
    };
    let expected = trace(&here, &rays)?;
    let mut found = Invariants::default();

    for by in MOVES {
        let there = scene.world(corner + IVec3::from_array(by), seed);
        let (kept, moved): (Vec<usize>, Vec<Ray>) =
            rays.iter().enumerate().filter_map(|(i, ray)| Some((i, ray.moved(by)?))).unzip();
        for (i, hit) in kept.into_iter().zip(trace(&there, &moved)?) {
            let bits = |hit: Hit, by: [i32; 3]| {
                let voxel: [i32; 3] = std::array::from_fn(|axis| hit.voxel[axis].wrapping_add(by[axis]));
                (voxel, hit.face, hit.material, hit.t.to_bits(), hit.uv.map(f32::to_bits))
            };
            found.moved += 1;
            found.moved_wrong += u64::from(expected[i].map(|hit| bits(hit, by)) != hit.map(|hit| bits(hit, [0; 3])));
        }
    }

    let oracle = Oracle::new(&here);
    let ties: Vec<bool> = rays.iter().map(|ray| oracle.first_hit(ray).tie).collect();
    for symmetry in symmetries() {
        let voxels = here.voxels().map(|(voxel, material)| (symmetry.cell(voxel.to_array()).into(), material));
        let there = World::from_voxels(here.materials().to_vec(), voxels);
        let turned: Vec<Ray> = rays.iter().map(|ray| symmetry.ray(ray)).collect();
        for ((expected, hit), tie) in expected.iter().zip(trace(&there, &turned)?).zip(&ties) {
            // The order of the axes decides between the two faces of an edge, and it is no symmetry.
            let face = |face: u32| if *tie { 0 } else { face };
            let expected = expected
                .map(|hit| (symmetry.cell(hit.voxel), face(symmetry.face(hit.face)), hit.material, hit.t.to_bits()));
            let hit = hit.map(|hit| (hit.voxel, face(hit.face), hit.material, hit.t.to_bits()));
            found.turned += 1;
            found.turned_wrong += u64::from(expected != hit);
        }
    }
    Ok(found)
}

/// A symmetry of the cube: axes in another order, some of them mirrored.
struct Symmetry {
    order: [usize; 3],
    mirrored: [bool; 3],
}

fn symmetries() -> impl Iterator<Item = Symmetry> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    orders
        .into_iter()
        .flat_map(|order| (0..8).map(move |bits| Symmetry { order, mirrored: [0, 1, 2].map(|i| bits >> i & 1 == 1) }))
}

impl Symmetry {
    fn cell(&self, cell: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|i| if self.mirrored[i] { -1 - cell[self.order[i]] } else { cell[self.order[i]] })
    }

    fn ray(&self, ray: &Ray) -> Ray {
        let frac = |i: usize| if self.mirrored[i] { 1.0 - ray.frac[self.order[i]] } else { ray.frac[self.order[i]] };
        let dir = |i: usize| if self.mirrored[i] { -ray.dir[self.order[i]] } else { ray.dir[self.order[i]] };
        Ray::new(self.cell(ray.cell), [0, 1, 2].map(frac), [0, 1, 2].map(dir))
    }

    fn face(&self, face: u32) -> u32 {
        let axis = (0..3).find(|&i| self.order[i] as u32 == face / 2);
        axis.map_or(FACE_INSIDE, |i| 2 * i as u32 + (face & 1 ^ u32::from(self.mirrored[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_has_48_symmetries() {
        let mut seen: Vec<[i32; 3]> = symmetries().map(|symmetry| symmetry.cell([1, 20, 300])).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 48);
        assert!(symmetries().all(|symmetry| symmetry.face(FACE_INSIDE) == FACE_INSIDE));
    }
}
