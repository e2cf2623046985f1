//! Instances at random poses in a site, and the right answers about rays through them.

use std::sync::Arc;

use glam::IVec3;
use raxel_layouts::instances::{Frame, Instance, InstanceModel, Instances, Pose};
use raxel_oracle::instances::{Scene, SceneHit};
use raxel_oracle::metrics::{Errors, ULPS, Wrong, near};
use raxel_oracle::scenes::Scene as Solids;
use raxel_oracle::sets::Random;
use raxel_oracle::{FAR, Lattice, Ray};
use raxel_world::{Material, World};

use crate::rays::{HitWords, RayError, State};

/// How many stand in a site: the judge asks each of them about each ray.
const COUNT: usize = 12;

/// The largest error of a component of a normal.
const NORMAL_ERROR: f64 = 1e-6;

/// Materials of the models.
const MATERIALS: u16 = 40;

/// A site with instances.
pub(super) struct Posed {
    instances: Instances,
    frames: Vec<Frame>,
    pub scene: Scene,
}

impl Posed {
    /// Instances about the solids of a world; `None` where they may not stand.
    pub(crate) fn of(world: &World, seed: u64) -> Option<Self> {
        let bounds = world.bounds()?;
        let mut random = Random::new(seed ^ 0x1257);
        let list: Vec<Instance> = (0..COUNT).map(|i| instance(i, bounds.min, bounds.max, &mut random)).collect();
        let may_stand = |p: &f64| Pose::COORDINATES.contains(p);
        if !list.iter().all(|instance| instance.pose.position.iter().all(may_stand)) {
            return None;
        }
        let models = models(world, seed, &mut random)?;
        let instances = Instances { models, list };
        let frames = instances.frames(|_| None);
        let scene = Scene::new(world.clone(), &instances, &frames);
        Some(Self { instances, frames, scene })
    }

    /// The buffer that shaders see.
    pub(crate) fn words(&self) -> Result<Vec<u32>, RayError> {
        Ok(self.instances.encode(&[], u64::from(u32::MAX))?.words(&self.frames))
    }

    /// Adds the device's hit of a ray to its counts, and returns the mistake if it is wrong.
    pub(crate) fn judge(
        &self,
        errors: &mut Errors,
        ray: &Ray,
        exact: Option<&SceneHit>,
        words: &HitWords,
    ) -> Option<Wrong> {
        let t = exact.zip(Lattice::of(ray)).map(|(hit, lattice)| hit.in_lengths(&lattice));
        let ends = |t: f64| ray.t_max < FAR && t > f64::from(ray.t_max);
        // A ray that ends at its hit finds it or does not, by the last bits of t.
        let at_end = |t: f64| ray.t_max < FAR && (t - f64::from(ray.t_max)).abs() <= ULPS * 2f64.powi(-23) * t;
        let wrong = match (words.state(), exact.zip(t)) {
            (State::Hang, _) => Some(Wrong::Hang),
            (State::Unwritten, _) => Some(Wrong::Unwritten),
            (State::Miss, None) => None,
            (State::Miss, Some((_, t))) => (!at_end(t) && !ends(t)).then_some(Wrong::Miss),
            (State::Hit, None) => Some(Wrong::False),
            (State::Hit, Some((hit, t))) => {
                self.compare(hit, t, words).or_else(|| (ends(t) && !at_end(t)).then_some(Wrong::Beyond))
            }
        };
        errors.add_judged(t.is_some_and(|t| !ends(t)), false, wrong);
        wrong
    }

    /// The same of a ray that goes on from a hit, whose normal the device has written in the place of `uv`.
    pub(crate) fn judge_onward(
        &self,
        errors: &mut Errors,
        ray: &Ray,
        (from, exact): (&SceneHit, Option<&SceneHit>),
        words: &HitWords,
    ) -> Option<Wrong> {
        let normal = self.scene.normal(from);
        let right = words.uv.iter().zip(normal).all(|(found, right)| (f64::from(*found) - right).abs() < NORMAL_ERROR);
        if right {
            return self.judge(errors, ray, exact, words);
        }
        errors.add_judged(exact.is_some(), false, Some(Wrong::Face));
        Some(Wrong::Face)
    }

    fn compare(&self, exact: &SceneHit, t: f64, words: &HitWords) -> Option<Wrong> {
        let instance = exact.instance.map_or(0xffff, |index| index as u32);
        if !(words.t.is_finite() && words.uv.iter().all(|uv| uv.is_finite())) {
            return Some(Wrong::NotFinite);
        }
        if (words.voxel, words.instance & 0xffff) != (exact.voxel, instance) {
            return Some(if f64::from(words.t) < t { Wrong::Early } else { Wrong::Late });
        }
        let own = self.scene.model_voxel(exact);
        let cell = own.cell.iter().enumerate().fold(0, |word, (axis, c)| word | (*c as u32 & 1023) << (10 * axis));
        let kind = words.instance >> 16;
        if (words.face, words.looked_up, kind) != (exact.face, cell, own.face | u32::from(own.free) << 8) {
            Some(Wrong::Face)
        } else if words.material != u32::from(exact.material) {
            Some(Wrong::Material)
        } else if !near(words.t, t) {
            Some(Wrong::Time)
        } else {
            (words.steps == 0).then_some(Wrong::Steps)
        }
    }
}

/// Six models. Their leaves have 1, 2, 4, 12 or 40 materials, so that they are packed in every way.
#[expect(clippy::cast_possible_truncation, reason = "there are few materials")]
fn models(world: &World, seed: u64, random: &mut Random) -> Option<Vec<InstanceModel>> {
    let own: Vec<Material> =
        std::iter::once(Material::air()).chain((0..MATERIALS).map(|_| Material::matt("test", [0.5; 3]))).collect();
    let last = u16::try_from(world.materials().len().checked_sub(1)?).ok().filter(|last| *last > 0)?;
    // Neighbours among them are different materials of the world, as far as it has several.
    let materials: Vec<u16> = (0..=MATERIALS).map(|m| if m == 0 { 0 } else { 1 + m % last }).collect();
    let mut crate_of = |size: IVec3, share: u64, distinct: u64| {
        let cells = (0..size.element_product())
            .map(|i| IVec3::new(i % size.x, i / size.x % size.y, i / size.x / size.y) - IVec3::new(2, 0, 1));
        let mut solid = Vec::new();
        for cell in cells {
            if random.below(100) < share {
                solid.push((cell, 1 + random.below(distinct) as u16));
            }
        }
        solid.push((IVec3::ZERO, 1));
        World::from_voxels(own.clone(), solid)
    };
    let voxels = [
        crate_of(IVec3::new(9, 7, 12), 60, 2),
        crate_of(IVec3::new(3, 110, 2), 90, 4),
        Solids::find("menger")?.world(IVec3::new(-9, -30, 4), seed),
        crate_of(IVec3::ONE, 100, 1),
        crate_of(IVec3::new(6, 11, 7), 80, 12),
        crate_of(IVec3::new(8, 9, 10), 90, u64::from(MATERIALS)),
    ];
    let model = |voxels: World| {
        let materials = materials[..voxels.materials().len()].into();
        InstanceModel { voxels: Arc::new(voxels), materials }
    };
    Some(voxels.map(model).into())
}

/// An instance in the box of a world or beside it: on its lattice by quarter turns, half a voxel off it, or turned in any way.
fn instance(number: usize, low: [i64; 3], high: [i64; 3], random: &mut Random) -> Instance {
    let size = [0, 1, 2].map(|i| (high[i] - low[i]).max(1));
    let cell: [i64; 3] = std::array::from_fn(|i| low[i] - 8 + random.below(size[i] as u64 + 16) as i64);
    let mut quarter = || 90.0 * random.below(4) as f64;
    let turns = [quarter(), quarter(), quarter()];
    let (place, turns) = match number % 3 {
        0 => ([0.0; 3], turns),
        1 => ([0.5, 0.0, 0.5], turns),
        _ => {
            let place = [0; 3].map(|_: i32| f64::from(random.unit()));
            (place, [0; 3].map(|_: i32| f64::from(random.unit()) * 720.0 - 360.0))
        }
    };
    let position = std::array::from_fn(|i| cell[i] as f64 + place[i]);
    let anchor = [random.below(9) as i64 - 2, random.below(7) as i64, random.below(12) as i64 - 1];
    let pose = Pose::new(position, turns);
    Instance { name: None, model: random.below(6) as usize, anchor, pose, motions: Vec::new() }
}
