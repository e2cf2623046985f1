//! A demo as data, and what it drives at a time.

use glam::DVec3;
use raxel_diagnostics::{Span, Spanned};
use raxel_execute::moment::{Fraction, Moment};
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
    pub world: Spanned<String>,
    /// Project path of the graph that it begins with.
    pub graph: Spanned<String>,
    /// Seconds.
    pub duration: f64,
    /// Frames a second, headless.
    pub fps: f64,
    /// Pixels of the output, headless.
    pub size: [u32; 2],
    /// Starts over at its end; else its last picture stays.
    pub looped: bool,
    /// Camera keys in order of time. Empty: the camera is not the demo's.
    pub camera: Vec<CameraKey>,
    /// Param tracks in the order of the file.
    pub tracks: Vec<Track>,
    /// Changes of the graph in order of time.
    pub graphs: Vec<GraphKey>,
    /// Changes of the debug target in order of time.
    pub shows: Vec<DebugTargetKey>,
    /// Edits of the world in order of time.
    pub edits: Vec<EditKey>,
    /// Lines of text over the picture, in order of time.
    pub captions: Vec<Caption>,
    /// What must hold, in the order of the file.
    pub checks: Vec<Check>,
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
    /// The camera jumps to it: until then it stays as the key before leaves it.
    pub cut: bool,
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
    pub param: Spanned<String>,
    /// Times and components of the values, in order of time. All have the same number of components.
    pub keys: Vec<Spanned<(f64, Vec<f64>)>>,
    /// The values are `true` and `false`.
    pub boolean: bool,
    /// How it gets from key to key.
    pub interpolation: Interpolation,
}

/// A change of the graph.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphKey {
    /// Seconds.
    pub time: f64,
    /// Project path of the graph that runs from then on.
    pub graph: Spanned<String>,
}

/// A change of the debug target.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugTargetKey {
    /// Seconds.
    pub time: f64,
    /// What is shown from then on.
    pub target: Spanned<DebugTarget>,
}

/// A line of text over the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptionText {
    /// What is said.
    pub text: String,
    /// At the top rather than at the bottom.
    pub top: bool,
}

/// A line of text for some time.
#[derive(Clone, Debug, PartialEq)]
pub struct Caption {
    /// Seconds at which it appears and is gone.
    pub during: [f64; 2],
    /// The line.
    pub line: CaptionText,
}

/// Something that must hold when the demo runs as a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Where it stands.
    pub span: Span,
    /// What it is.
    pub claim: Claim,
}

/// What a check claims.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A target at a frame is as a reference.
    Picture {
        /// The frame.
        frame: u64,
        /// What is looked at; `None` for what the demo shows.
        target: Option<Spanned<DebugTarget>>,
        /// Project path of the reference: a PNG, of the displayed picture.
        reference: Spanned<String>,
        /// Largest mean FLIP error.
        flip: f64,
    },
    /// A pass is fast.
    Pass {
        /// Its name.
        pass: Spanned<String>,
        /// Most milliseconds of GPU time, median of all frames.
        below_ms: f64,
    },
}

impl Demo {
    /// The frame at so many seconds, headless.
    pub fn frame_at(&self, seconds: f64) -> u64 {
        Moment::from(seconds).nearest(Fraction::of(self.fps))
    }

    /// The seconds at which checks look at pictures, in order.
    pub fn checked_times(&self) -> Vec<f64> {
        let seconds = |check: &Check| match check.claim {
            Claim::Picture { frame, .. } => Some(frame as f64 / self.fps),
            Claim::Pass { .. } => None,
        };
        let mut times: Vec<f64> = self.checks.iter().filter_map(seconds).collect();
        times.sort_by(f64::total_cmp);
        times
    }

    /// The caption at `time` seconds on the clock: of several the last that has appeared.
    pub fn caption(&self, time: impl Into<Moment>) -> Option<&CaptionText> {
        let time = self.local_time(time);
        let shown = |caption: &&Caption| (caption.during[0]..caption.during[1]).contains(&time);
        self.captions.iter().rev().find(shown).map(|caption| &caption.line)
    }

    /// Whether there is a cut on the way from one moment to a later one, both in seconds on the clock: of the camera, or since another
    /// graph runs.
    pub fn cuts_between(&self, before: impl Into<Moment>, after: impl Into<Moment>) -> bool {
        let (before, after) = (self.local_time(before), self.local_time(after));
        let between = |time: f64| before < time && time <= after;
        self.camera.iter().any(|key| key.cut && between(key.time))
            || self.graph_in(before).value != self.graph_in(after).value
    }

    /// The graph at `time` seconds on the clock.
    pub fn graph_at(&self, time: impl Into<Moment>) -> &Spanned<String> {
        self.graph_in(self.local_time(time))
    }

    /// The graph at `time` seconds into the timeline.
    pub(super) fn graph_in(&self, time: f64) -> &Spanned<String> {
        self.graphs.iter().rev().find(|key| key.time <= time).map_or(&self.graph, |key| &key.graph)
    }

    /// Every graph that it runs, the one that it begins with first, each at the first place that names it.
    pub fn all_graphs(&self) -> Vec<&Spanned<String>> {
        let mut all: Vec<&Spanned<String>> = vec![&self.graph];
        for key in &self.graphs {
            if all.iter().all(|known| known.value != key.graph.value) {
                all.push(&key.graph);
            }
        }
        all
    }

    /// Frames of a headless run from start to end.
    pub fn frames(&self) -> u64 {
        self.frame_at(self.duration).max(1)
    }

    /// Seconds into the timeline at `time` seconds on the clock. The float nearest to the exact time: it equals that of a key at this time.
    pub fn local_time(&self, time: impl Into<Moment>) -> f64 {
        let (time, end) = (time.into(), Moment::from(self.duration));
        let local = if self.looped { time.within(end) } else { time.min(end) };
        local.seconds().min(self.duration)
    }

    /// The values of params at `time` seconds on the clock. A track whose param the graph lacks is left out. Allocates nothing, like all
    /// that is asked once a frame.
    pub fn params<'d>(
        &'d self,
        time: impl Into<Moment>,
        graph: &'d Graph,
    ) -> impl Iterator<Item = (ParamId, Value)> + 'd {
        let time = self.local_time(time);
        self.tracks.iter().filter_map(move |track| {
            let id = graph.find_param(&track.param.value)?;
            Some((id, track.at(time, &graph.params[id.0 as usize].default)?))
        })
    }

    /// The debug target at `time` seconds on the clock: `None`, the graph's own, until the first change, and again when another graph
    /// begins.
    pub fn debug_target(&self, time: impl Into<Moment>) -> Option<&DebugTarget> {
        let time = self.local_time(time);
        let since = self.graphs.iter().rev().find(|key| key.time <= time).map_or(0.0, |key| key.time);
        let shown = self.shows.iter().rev().find(|key| key.time <= time)?;
        (shown.time >= since).then_some(&shown.target.value)
    }

    /// The camera at `time` seconds on the clock; `None` when it is not the demo's.
    pub fn camera(&self, time: impl Into<Moment>) -> Option<Camera> {
        let time = self.local_time(time);
        let keys = &self.camera;
        if keys.is_empty() {
            return None;
        }
        let i = segment(keys.iter().map(|key| key.time), time);
        // A curve goes from one cut to the next.
        let first = keys[..=i].iter().rposition(|key| key.cut).unwrap_or(0);
        let end = keys[i + 1..].iter().position(|key| key.cut).map_or(keys.len(), |next| i + 1 + next);
        let (keys, i) = (&keys[first..end], i - first);
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
