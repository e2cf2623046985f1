//! Rays through a world and its instances, exactly. `shaders/include/raxel/instances.glsl` has to find the same.

use std::sync::Arc;

use glam::{I64Vec3, IVec3};
use raxel_layouts::instances::{Frame, Instances, ModelPlace, Rotation};
use raxel_ray::{FACE_INSIDE, Lattice, ONE, Ray};
use raxel_world::World;

use crate::bounce::from_hit;
use crate::exact::{Answer, Time};
use crate::oracle::Oracle;

/// A hit of the world or of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneHit {
    /// Index of the instance; `None` is the world.
    pub instance: Option<usize>,
    /// The voxel: of the world, or of the model, counted from the anchor, if the instance is not on the lattice of the world.
    pub voxel: [i32; 3],
    /// Its face, in the same axes.
    pub face: u32,
    /// Palette index of the world.
    pub material: u16,
    /// When; in lattice steps of the world's ray, times 2.
    pub time: Time,
}

impl SceneHit {
    /// When, in lengths of the ray's direction.
    pub fn in_lengths(&self, lattice: &Lattice) -> f64 {
        let steps = self.time.numerator as f64 / self.time.denominator as f64 / 2.0;
        steps / ONE as f64 * (-f64::from(lattice.exponent)).exp2()
    }
}

/// The voxel of a hit in its own model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelVoxel {
    /// In the coordinates of the model's file; of the world, if that was hit.
    pub cell: [i64; 3],
    /// The face that was hit, in the model's axes.
    pub face: u32,
    /// The instance is not on the lattice of the world.
    pub free: bool,
}

/// A ray through a world with instances.
#[derive(Clone, Copy, Debug)]
pub struct SceneRay {
    /// In the world.
    pub ray: Ray,
    /// The instance off the lattice of the world that it leaves, and where it begins in that one's model: a cell counted from the anchor, and a fraction.
    own: Option<(usize, [i32; 3], [f32; 3])>,
}

impl From<Ray> for SceneRay {
    fn from(ray: Ray) -> Self {
        Self { ray, own: None }
    }
}

/// A world with instances where they stand.
pub struct Scene {
    world: World,
    /// The voxels that each instance on the lattice of the world covers, and the models of the others.
    bodies: Vec<Body>,
}

struct Body {
    frame: Frame,
    anchor: [i64; 3],
    materials: Option<Arc<[u16]>>,
    voxels: Arc<World>,
}

impl Scene {
    /// A world with instances at `frames`.
    pub fn new(world: World, instances: &Instances, frames: &[Frame]) -> Self {
        let body = |(instance, frame): (&raxel_layouts::instances::Instance, &Frame)| {
            let model = &instances.models[instance.model];
            let (anchor, frame) = (instance.anchor, *frame);
            match frame.turn {
                Rotation::Free(_) => {
                    let materials = Some(model.materials.clone());
                    Body { frame, anchor, materials, voxels: model.voxels.clone() }
                }
                Rotation::Quarter(_) => {
                    let placed = model.voxels.voxels().filter_map(|(cell, material)| {
                        let from_anchor = I64Vec3::from(cell) - I64Vec3::from(anchor);
                        let at = frame.place(from_anchor.to_array())?.map(i32::try_from);
                        let [Ok(x), Ok(y), Ok(z)] = at else { return None };
                        Some((IVec3::new(x, y, z), model.materials[usize::from(material)]))
                    });
                    let voxels = Arc::new(World::from_voxels(world.materials().to_vec(), placed));
                    Body { frame, anchor, materials: None, voxels }
                }
            }
        };
        let bodies = instances.list.iter().zip(frames).map(body).collect();
        Self { world, bodies }
    }

    /// The voxel of a hit in its own model.
    #[expect(clippy::cast_possible_truncation, reason = "there are three axes")]
    pub fn model_voxel(&self, hit: &SceneHit) -> ModelVoxel {
        let voxel = hit.voxel.map(i64::from);
        let Some(body) = hit.instance.map(|instance| &self.bodies[instance]) else {
            return ModelVoxel { cell: voxel, face: hit.face, free: false };
        };
        let from_anchor = |cell: [i64; 3]| std::array::from_fn(|i| cell[i] + body.anchor[i]);
        let Rotation::Quarter(orientation) = body.frame.turn else {
            return ModelVoxel { cell: from_anchor(voxel), face: hit.face, free: true };
        };
        let back = orientation.inverse();
        let cell = back.vector(std::array::from_fn(|i| voxel[i] - i64::from(body.frame.cell[i])));
        let outwards = |axis: u32| i64::from(hit.face / 2 == axis) * if hit.face & 1 == 1 { 1 } else { -1 };
        let step = back.vector([0, 1, 2].map(outwards));
        let axis = step.iter().position(|s| *s != 0);
        let face = axis.map_or(FACE_INSIDE, |axis| 2 * axis as u32 + u32::from(step[axis] > 0));
        ModelVoxel { cell: from_anchor(cell), face, free: false }
    }

    /// The ray that goes on from a hit in a direction of the world: `rx_scene_ray_from_hit`. `uv` is the place on the face that was hit.
    #[expect(clippy::cast_possible_truncation, reason = "a model's voxels are within 32 bits of the world's")]
    pub fn from_hit(&self, hit: &SceneHit, uv: [f32; 2], dir: [f32; 3]) -> SceneRay {
        let start = from_hit(hit.voxel, hit.face, uv, dir);
        let free = hit.instance.map(|index| (index, self.bodies[index].frame));
        let Some((index, Frame { cell, fraction, turn: Rotation::Free(rows) })) = free else { return start.into() };
        // From the centre of the anchor's cell, in units of 2⁻²⁴.
        let place: [i64; 3] = std::array::from_fn(|i| {
            i64::from(start.cell[i]) * ONE + (f64::from(start.frac[i]) * ONE as f64) as i64 - ONE / 2
        });
        let there: [i64; 3] = std::array::from_fn(|i| {
            let sum: i128 = (0..3).map(|k| i128::from(rows[k][i]) * i128::from(place[k])).sum();
            i64::from(cell[i]) * ONE + i64::from(fraction[i]) + (sum >> 23) as i64
        });
        let ray = Ray::new(
            there.map(|c| c.div_euclid(ONE) as i32),
            there.map(|c| c.rem_euclid(ONE) as f32 / ONE as f32),
            dir,
        );
        SceneRay { ray, own: Some((index, start.cell, start.frac)) }
    }

    /// The outward normal of the face that was hit, in the world; zero for a start inside: `rx_scene_normal`.
    pub fn normal(&self, hit: &SceneHit) -> [f64; 3] {
        let axis = (hit.face / 2) as usize;
        let side = if hit.face & 1 == 1 { 1.0 } else { -1.0 };
        match hit.instance.map(|index| self.bodies[index].frame.turn) {
            _ if hit.face == FACE_INSIDE => [0.0; 3],
            Some(Rotation::Free(rows)) => rows[axis].map(|entry| side * f64::from(entry) / f64::from(1 << 23)),
            _ => std::array::from_fn(|i| if i == axis { side } else { 0.0 }),
        }
    }

    /// Prepares it for rays.
    pub fn oracle(&self) -> SceneOracle<'_> {
        let bodies = self.bodies.iter().map(|body| (body, Oracle::new(&body.voxels))).collect();
        SceneOracle { world: Oracle::new(&self.world), bodies }
    }
}

/// A scene, prepared for exact rays.
pub struct SceneOracle<'s> {
    world: Oracle<'s>,
    bodies: Vec<(&'s Body, Oracle<'s>)>,
}

impl SceneOracle<'_> {
    /// The first hit along a ray: of two at the same time the world's, then that of the first instance. `t_max` is not looked at.
    pub fn first_hit(&self, ray: &Ray) -> Option<SceneHit> {
        self.first_hit_on(&(*ray).into())
    }

    /// The same along a ray that may leave an instance: in its frame, the ray begins at the given place.
    #[expect(clippy::cast_possible_truncation, reason = "cells of a model have 32 bits")]
    pub fn first_hit_on(&self, scene_ray: &SceneRay) -> Option<SceneHit> {
        let SceneRay { ray, own } = scene_ray;
        let lattice = Lattice::of(ray)?;
        let of_world = self.world.first_hit(ray);
        let mut best = found(&of_world, None, 1, None);
        for (index, (body, oracle)) in self.bodies.iter().enumerate() {
            let hit = match body.frame.turn {
                Rotation::Quarter(_) => found(&oracle.first_hit(ray), Some(index), 1, None),
                Rotation::Free(_) => {
                    turned(body, &lattice, own.filter(|own| own.0 == index)).and_then(|(ray, shift)| {
                        let mut hit = found(&oracle.first_hit(&ray), Some(index), shift, body.materials.as_deref())?;
                        hit.voxel = std::array::from_fn(|i| (i64::from(hit.voxel[i]) - body.anchor[i]) as i32);
                        Some(hit)
                    })
                }
            };
            if let Some(hit) = hit
                && best.is_none_or(|best| hit.time < best.time)
            {
                best = Some(hit);
            }
        }
        best
    }
}

/// A ray in the frame of a free instance's model, and by which power of two the numerators of its times are to be multiplied. If it leaves that
/// instance, it begins where it does so.
#[expect(clippy::cast_possible_truncation, reason = "cells of a model have 32 bits")]
fn turned(body: &Body, lattice: &Lattice, own: Option<(usize, [i32; 3], [f32; 3])>) -> Option<(Ray, u32)> {
    let (cell, fraction) = if let Some((_, cell, frac)) = own {
        (cell.map(i64::from), frac)
    } else {
        let ModelPlace { cell, fraction } = body.frame.into_model(lattice.cell, lattice.frac)?;
        (cell, fraction.map(|f| f as f32 / ONE as f32))
    };
    // Exact: a component has 24 significant bits at most.
    let direction = body.frame.direction(lattice.dir.map(|d| d as f32 / (1_u32 << 30) as f32))?;
    let cell = std::array::from_fn(|i| (cell[i] + body.anchor[i]) as i32);
    let ray = Ray::new(cell, fraction, direction);
    let exponent = Lattice::of(&ray)?.exponent;
    // Of the world's ray it is −30 here.
    Some((ray, (1 - (exponent + 30)).try_into().ok()?))
}

fn found(answer: &Answer, instance: Option<usize>, shift: u32, materials: Option<&[u16]>) -> Option<SceneHit> {
    let hit = answer.hit?;
    Some(SceneHit {
        instance,
        voxel: hit.voxel,
        face: hit.face,
        material: materials.map_or(hit.material, |materials| materials[usize::from(hit.material)]),
        time: Time { numerator: hit.time.numerator << shift, denominator: hit.time.denominator },
    })
}

#[cfg(test)]
mod tests {
    use raxel_layouts::instances::{Instance, InstanceModel, Pose};
    use raxel_world::Material;

    use super::*;
    use crate::scenes::Scene as Solids;
    use crate::sets::Random;

    /// A world of some voxels, and instances of one model at poses.
    fn scene(poses: &[Pose]) -> (World, Instances) {
        let materials = || vec![Material::air(), Material::matt("stone", [0.5; 3]), Material::matt("brick", [0.6; 3])];
        let floor = (0..64).flat_map(|x| (0..64).map(move |z| (IVec3::new(x - 32, -9, z - 32), 1)));
        let model = Solids::find("gravel").expect("a scene").world(IVec3::ZERO, 3);
        let few = model.voxels().filter(|(cell, _)| cell.cmplt(IVec3::splat(24)).all()).map(|(cell, _)| (cell, 1));
        let model = Arc::new(World::from_voxels(materials(), few));
        let list =
            poses.iter().map(|&pose| Instance { name: None, model: 0, anchor: [3, 0, 5], pose, motions: Vec::new() });
        let instances = Instances {
            models: vec![InstanceModel { voxels: model, materials: Arc::from([0, 2, 2].as_slice()) }],
            list: list.collect(),
        };
        (World::from_voxels(materials(), floor), instances)
    }

    fn rays(count: usize) -> impl Iterator<Item = Ray> {
        let mut random = Random::new(11);
        (0..count).map(move |_| {
            let mut at = |size: u64| random.below(size) as i32 - size as i32 / 2;
            let (from, to) = ([at(150), at(150), at(150)], [at(40), at(40), at(40)]);
            let dir = std::array::from_fn(|i| (to[i] - from[i]) as f32);
            Ray::new(from, [random.unit(), random.unit(), random.unit()], dir)
        })
    }

    #[test]
    fn quarter_turns_and_whole_moves_are_the_same_model_built_into_the_world() {
        let poses = [
            Pose::new([-20.0, 1.0, 3.0], [90.0, 0.0, 0.0]),
            Pose::new([9.0, -3.0, -14.0], [180.0, 90.0, 0.0]),
            Pose::new([12.0, 20.0, 10.0], [-90.0, 0.0, 270.0]),
        ];
        let (world, instances) = scene(&poses);
        let frames = instances.frames(|_| None);
        let model = &instances.models[0];
        let stamped = frames.iter().flat_map(|frame| {
            model.voxels.voxels().map(move |(cell, _)| {
                let at = frame.place((I64Vec3::from(cell) - I64Vec3::new(3, 0, 5)).to_array()).expect("on the lattice");
                (I64Vec3::from(at).as_ivec3(), 2)
            })
        });
        let both = World::from_voxels(world.materials().to_vec(), stamped.chain(world.voxels()));
        let scene = Scene::new(world, &instances, &frames);
        let (scene, both) = (scene.oracle(), Oracle::new(&both));
        let mut hits = 0;
        for ray in rays(20_000) {
            let (a, b) = (scene.first_hit(&ray), both.first_hit(&ray).hit);
            assert_eq!(
                a.map(|hit| (hit.voxel, hit.face, hit.material)),
                b.map(|hit| (hit.voxel, hit.face, hit.material))
            );
            hits += usize::from(a.is_some_and(|hit| hit.instance.is_some()));
        }
        assert!(hits > 3000, "{hits}");
    }

    #[test]
    fn other_turns_hit_near_where_real_numbers_say() {
        let pose = Pose::new([4.3, 2.0, -7.9], [33.0, 21.0, 70.0]);
        let (world, instances) = scene(&[pose]);
        let frames = instances.frames(|_| None);
        let model = &instances.models[0];
        let empty = World::new(world.materials().to_vec(), []);
        let scene = Scene::new(empty, &instances, &frames);
        let oracle = scene.oracle();
        let mut hits = 0;
        for ray in rays(4000) {
            let Some(hit) = oracle.first_hit(&ray) else { continue };
            hits += 1;
            let lattice = Lattice::of(&ray).expect("a ray");
            let t = hit.time.numerator as f64 / hit.time.denominator as f64 / 2.0 / ONE as f64
                * (-f64::from(lattice.exponent)).exp2();
            // The place of the hit, by the pose alone, lies on the face of the voxel.
            let there: [f64; 3] =
                std::array::from_fn(|i| f64::from(ray.cell[i]) + f64::from(ray.frac[i]) + t * f64::from(ray.dir[i]));
            let arm: [f64; 3] = std::array::from_fn(|i| there[i] - pose.middle()[i]);
            let mut uv = Vec::new();
            for axis in 0..3 {
                let own: f64 = (0..3).map(|k| pose.rotation[k][axis] * arm[k]).sum::<f64>() + 0.5;
                let within = own - f64::from(hit.voxel[axis]);
                assert!((-1e-3..=1.001).contains(&within), "{ray:?} {hit:?}: {within}");
                if hit.face / 2 == axis as u32 {
                    assert!((within - f64::from(hit.face & 1)).abs() < 1e-3, "{ray:?} {hit:?}: {within}");
                } else {
                    uv.push(within.clamp(0.0, 1.0) as f32);
                }
            }
            // A ray that continues from it begins there, and the normal is against the ray.
            if hit.instance.is_some() && hit.face != FACE_INSIDE {
                let onward = scene.from_hit(&hit, [uv[0], uv[1]], ray.dir).ray;
                let apart = |i: usize| f64::from(onward.cell[i]) + f64::from(onward.frac[i]) - there[i];
                assert!((0..3).all(|i| apart(i).abs() < 2e-3), "{ray:?} {hit:?}: {onward:?}");
                let normal = scene.normal(&hit);
                let along: f64 = (0..3).map(|i| normal[i] * f64::from(ray.dir[i])).sum();
                let length: f64 = normal.iter().map(|n| n * n).sum();
                assert!(along <= 1e-3 && (length - 1.0).abs() < 1e-5, "{hit:?}: {normal:?}");
            }
            let cell = IVec3::from_array(hit.voxel) + IVec3::new(3, 0, 5);
            assert_ne!(model.voxels.voxel(cell), 0);
        }
        assert!(hits > 300, "{hits}");
    }
}
