//! Instances: models that stand in a world without being part of its voxels, so that they can be moved and turned in every frame. The
//! twin of `shaders/include/raxel/instances.glsl`.

mod bvh;
mod encode;
mod frame;
mod lamps;
mod pose;
pub mod records;

use std::sync::Arc;

pub use encode::InstanceBuffer;
pub use frame::{Frame, ModelPlace, REACH, Rotation};
pub use pose::{Axis, Motion, MotionKind, Pose};
use raxel_world::World;
use raxel_world::{Material, MaterialIndex};

use crate::LayoutError;

/// Most instances of a world: the deepest tree of boxes fits the shader's stack.
pub const MAX_INSTANCES: usize = 16_384;

/// Coordinates that voxels of instances may have, in either direction.
pub const COORDINATES: i64 = 1 << 30;

/// The instances of a world.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// The models that are used, each once.
    pub models: Vec<InstanceModel>,
    /// In the order of the file.
    pub list: Vec<Instance>,
}

/// A model that instances show.
#[derive(Clone, Debug)]
pub struct InstanceModel {
    /// Its voxels around its own origin.
    pub voxels: Arc<World>,
    /// Palette index in the world, by the model's palette index. Entries beyond the model's palette are ignored.
    pub materials: Arc<[MaterialIndex]>,
}

/// A model at a place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Index of its model.
    pub model: usize,
    /// The cell of the model that is put at the position. The model turns about its centre.
    pub anchor: [i64; 3],
    /// Where it stands before it is moved.
    pub pose: Pose,
    /// Its motions, one after the other.
    pub motions: Vec<Motion>,
}

impl Instance {
    /// Where it stands, by the values of params. `None` of a value stands for the motion's own default.
    pub(crate) fn pose_at(&self, value: impl Fn(&str) -> Option<f64>) -> Pose {
        let moved = |pose: Pose, motion: &Motion| {
            let amount = value(&motion.param).or(motion.default).unwrap_or(0.0);
            pose.moved(motion.kind, amount)
        };
        self.motions.iter().fold(self.pose, moved)
    }
}

impl InstanceModel {
    /// The largest distance of its voxels from the origin of the world, in any rotation, if an instance stands at a position.
    pub fn reach(&self, position: [f64; 3]) -> f64 {
        position.iter().fold(0.0_f64, |far, p| far.max(p.abs())) + 2.0 * self.size() as f64
    }

    /// How far its voxels reach from its own origin, or from one another, along an axis.
    pub fn size(&self) -> i64 {
        let Some(bounds) = self.voxels.bounds() else { return 0 };
        let along = |i: usize| (bounds.max[i] - bounds.min[i]).max(bounds.max[i].abs()).max(bounds.min[i].abs());
        (0..3).map(along).max().unwrap_or(0)
    }
}

impl Instances {
    /// Where all of them stand, by the values of params.
    pub fn frames(&self, value: impl Fn(&str) -> Option<f64>) -> Vec<Frame> {
        self.frames_with(&[], value)
    }

    /// The same, except for instances with their own pose in `written`, by their indices: the file and params do not move these.
    pub fn frames_with(&self, written: &[Option<Pose>], value: impl Fn(&str) -> Option<f64>) -> Vec<Frame> {
        let own = written.iter().copied().chain(std::iter::repeat(None));
        let pose = |(instance, own): (&Instance, Option<Pose>)| own.unwrap_or_else(|| instance.pose_at(&value));
        self.list.iter().zip(own).map(|of| Frame::of(&pose(of))).collect()
    }

    /// The buffer that shaders read, in a world with this palette. Without a palette, no instance is a lamp.
    pub fn encode(&self, palette: &[Material], limit: u64) -> Result<InstanceBuffer, LayoutError> {
        InstanceBuffer::new(self, palette, limit)
    }

    /// Whether a voxel of one of them gives off light, in a world with this palette.
    pub fn has_emission(&self, palette: &[Material]) -> bool {
        let shines = |model: &InstanceModel| {
            lamps::powers(model, palette).iter().any(|power| *power > 0.0)
                && !lamps::of_model(model, palette).is_empty()
        };
        self.models.iter().any(shines)
    }
}
