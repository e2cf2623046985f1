//! A demo as data, and what it drives at a time.

use glam::DVec3;
use raxel_diagnostics::Span;
use raxel_graph::checked::{Graph, ParamId, Value};

use super::curve::{Interpolation, sample, segment};
use super::edits::EditKey;
use crate::camera::Camera;
use crate::debug_target::DebugTarget;
use crate::params;

/// A demo file.
#[derive(Clone, Debug)]
pub struct Demo {
    /// Project path of the file.
    pub file: String,
    /// `name`.
    pub name: String,
    /// `about`.
    pub about: String,
    /// Project path of the world.
    pub world: Place<String>,
    /// Project path of the graph.
    pub graph: Place<String>,
    /// Seconds.
    pub duration: f64,
    /// Frames a second, headless.
    pub fps: f64,
    /// Starts over at its end; else its last picture stays.
    pub looped: bool,
    /// Camera keys in order of time. Empty: the camera is not the demo's.
    pub camera: Vec<CameraKey>,
    /// Param tracks in the order of the file.
    pub tracks: Vec<Track>,
    /// Changes of the debug target in order of time.
    pub shows: Vec<DebugTargetKey>,
    /// Edits of the world in order of time.
    pub edits: Vec<EditKey>,
}

/// A value with its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Place<T> {
    /// The value.
    pub value: T,
    /// Where it is written.
    pub span: Span,
}

/// The camera at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraKey {
    /// Seconds.
    pub time: f64,
    /// Voxels.
    pub position: [f64; 3],
    /// Where it looks.
    pub direction: Direction,
    /// Vertical field of view, radians.
    pub fov: f64,
    /// How it gets to the next key.
    pub interpolation: Interpolation,
}

/// Where a camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// At a position in voxels.
    LookAt([f64; 3]),
    /// Yaw and pitch, radians.
    Angles([f64; 2]),
}

/// A param over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The param, at its place.
    pub param: Place<String>,
    /// Times and components of the values, in order of time. All have the same number of components.
    pub keys: Vec<Place<(f64, Vec<f64>)>>,
    /// The values are `true` and `false`.
    pub boolean: bool,
    /// How it gets from key to key.
    pub interpolation: Interpolation,
}

/// A change of the debug target.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugTargetKey {
    /// Seconds.
    pub time: f64,
    /// What is shown from then on.
    pub target: Place<DebugTarget>,
}

impl Demo {
    /// Frames of a headless run from start to end.
    pub fn frames(&self) -> u64 {
        (self.duration * self.fps).round().max(1.0) as u64
    }

    /// Seconds into the timeline at `time` seconds on the clock.
    pub fn local_time(&self, time: f64) -> f64 {
        if self.looped { time.rem_euclid(self.duration) } else { time.clamp(0.0, self.duration) }
    }

    /// The values of params at `time` seconds on the clock. A track whose param the graph lacks is left out. Allocates nothing, like all
    /// that is asked once a frame.
    pub fn params<'d>(&'d self, time: f64, graph: &'d Graph) -> impl Iterator<Item = (ParamId, Value)> + 'd {
        let time = self.local_time(time);
        self.tracks.iter().filter_map(move |track| {
            let id = graph.find_param(&track.param.value)?;
            Some((id, track.at(time, &graph.params[id.0 as usize].default)?))
        })
    }

    /// The debug target at `time` seconds on the clock: `None`, the graph's own, until the first change.
    pub fn debug_target(&self, time: f64) -> Option<&DebugTarget> {
        let time = self.local_time(time);
        self.shows.iter().rev().find(|key| key.time <= time).map(|key| &key.target.value)
    }

    /// The camera at `time` seconds on the clock; `None` when it is not the demo's.
    pub fn camera(&self, time: f64) -> Option<Camera> {
        let time = self.local_time(time);
        let keys = &self.camera;
        if keys.is_empty() {
            return None;
        }
        let i = segment(keys.iter().map(|key| key.time), time);
        let how = keys[i].interpolation;
        let curve =
            |value: &dyn Fn(&CameraKey) -> f64| sample(keys.len(), |i| (keys[i].time, value(&keys[i])), time, how);
        let mut camera = Camera::default();
        camera.place(DVec3::from_array(std::array::from_fn(|axis| curve(&|key| key.position[axis]))));
        camera.fov = curve(&|key| key.fov);
        // Between two keys that look at points, the point moves; else the angles turn. Both agree at the keys.
        let ends = [&keys[i], &keys[(i + 1).min(keys.len() - 1)]];
        if ends.iter().all(|key| matches!(key.direction, Direction::LookAt(_))) {
            let target = std::array::from_fn(|axis| curve(&|key| key.looks_at()[axis]));
            camera.look_at(target);
        } else {
            camera.yaw = sample(keys.len(), |i| (keys[i].time, yaw_of_key(keys, i)), time, how);
            camera.pitch = curve(&|key| key.angles()[1]).clamp(-Camera::MAX_PITCH, Camera::MAX_PITCH);
        }
        Some(camera)
    }
}

impl CameraKey {
    /// The point it looks at; for angles, one a hundred voxels ahead.
    fn looks_at(&self) -> [f64; 3] {
        match self.direction {
            Direction::LookAt(target) => target,
            Direction::Angles([yaw, pitch]) => {
                let ahead = Camera { yaw, pitch, ..Camera::default() }.rotation() * (DVec3::NEG_Z * 100.0);
                (DVec3::from_array(self.position) + ahead).to_array()
            }
        }
    }

    /// Yaw and pitch.
    fn angles(&self) -> [f64; 2] {
        match self.direction {
            Direction::Angles(angles) => angles,
            Direction::LookAt(target) => {
                let mut camera = Camera::at(self.position);
                camera.look_at(target);
                [camera.yaw, camera.pitch]
            }
        }
    }
}

/// The yaw of a key such that each turn from one key to the next is the short way round.
fn yaw_of_key(keys: &[CameraKey], key: usize) -> f64 {
    use std::f64::consts::{PI, TAU};
    let mut yaws = keys[..=key].iter().map(|key| key.angles()[0]);
    let first = yaws.next().unwrap_or_default();
    yaws.fold(first, |last, yaw| last + (yaw - last + PI).rem_euclid(TAU) - PI)
}

impl Track {
    /// The value at `time` seconds into the timeline, as the type of `like`. `None` when they do not fit.
    fn at(&self, time: f64, like: &Value) -> Option<Value> {
        let width = self.keys.first()?.value.1.len();
        // The widest value is a matrix.
        let mut numbers = [0.0; 16];
        let numbers = numbers.get_mut(..width)?;
        for (part, number) in numbers.iter_mut().enumerate() {
            let key = |i: usize| (self.keys[i].value.0, self.keys[i].value.1[part]);
            *number = sample(self.keys.len(), key, time, self.interpolation);
            if params::is_integer(like) {
                *number = number.round();
            }
        }
        params::from_components(numbers, like)
    }
}
