//! A demo as data, and its values at a time.

use glam::DVec3;
use raxel_diagnostics::{Span, Spanned};
use raxel_execute::moment::{Fraction, Moment};
use raxel_graph::checked::{Graph, ParamId, Value};
use raxel_language::{ByName, Keys, Shape};
use raxel_worldfile::{CAMERA_COORDINATES, CAMERA_FOV};

use crate::camera::Camera;
use crate::curve::{Interpolation, sample, segment};
use crate::debug_target::DebugTarget;
use crate::demo_inputs::DemoInputs;
use crate::edits::{self, EditKey};
use crate::inputs::SoundFile;
use crate::params;
use crate::read::{Clock, elsewhere, frame, in_order, lasts, line, nearest_frame, once, project_path, steps, time};

/// A world, a graph and a timeline.
#[derive(Clone, Debug, Keys)]
#[keys(context = Clock)]
pub struct Demo {
    /// Project path of the file.
    #[keys(skip)]
    pub file: String,
    /// The file that `inputs.microphone` names, once it is read.
    #[keys(skip)]
    pub heard: Option<SoundFile>,
    /// Name of the demo. The name of the file when left out.
    #[keys(absent = String::new())]
    pub name: String,
    /// One line about the demo; may be left out.
    #[keys(absent = String::new())]
    pub about: String,
    /// The world, relative to worlds/.
    ///
    /// Here as a project path, like the graph.
    #[keys(read = project_path("worlds"))]
    pub world: Spanned<String>,
    /// The graph, relative to graphs/.
    ///
    /// The one that it begins with.
    #[keys(read = project_path("graphs"))]
    pub graph: Spanned<String>,
    /// Length in seconds.
    #[keys(range = Clock::DURATIONS, unit = "seconds")]
    pub duration: f64,
    /// Frames a second without a window.
    #[keys(range = Clock::RATES, default = 30.0, unit = "Hz")]
    pub fps: f64,
    /// The demo starts over at its end.
    ///
    /// Else its last picture stays.
    #[keys(rename = "loop", default = false)]
    pub looped: bool,
    /// Camera keys in order of time.
    ///
    /// Empty: the camera is not the demo's.
    #[keys(read = in_order)]
    pub camera: Vec<CameraKey>,
    /// Width and height without a window, in pixels.
    #[keys(range = 1..=16384, default = [1280, 720])]
    pub size: [u32; 2],
    /// Captions over the picture, in order of time.
    #[keys(rename = "caption", read = in_order)]
    pub captions: Vec<Caption>,
    /// Checks that `raxel test` makes: of a picture, or of the time of a pass.
    #[keys(rename = "check")]
    pub checks: Vec<Check>,
    /// Changes of the graph in order of time. Histories and kept contents start over, and the new graph shows its own picture.
    #[keys(read = in_order)]
    pub graphs: Vec<GraphKey>,
    /// Changes of the debug target in order of time.
    #[keys(rename = "show", read = in_order)]
    pub shows: Vec<DebugTargetKey>,
    /// Edits of the world in order of time. Edits of one time follow the order of the file. None when left out.
    #[keys(read = edits::in_order)]
    pub edits: Vec<EditKey>,
    /// Mouse, keyboard, gamepad, microphone and time of day over time. They come from the window when left out.
    pub inputs: Option<DemoInputs>,
    /// Params over time, by name.
    pub tracks: ByName<Track>,
}

/// The camera at a time.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock, check = elsewhere(position, look_at))]
pub struct CameraKey {
    /// Seconds from the start.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    pub time: Spanned<f64>,
    /// Position of the camera, in voxels.
    #[keys(range = CAMERA_COORDINATES, unit = "voxels")]
    pub position: [f64; 3],
    /// The point that the camera looks at, in voxels. Instead of `yaw` and `pitch`.
    #[keys(
        range = CAMERA_COORDINATES,
        unit = "voxels",
        excludes("yaw", "pitch", why = "a camera looks at a point, or along angles")
    )]
    pub look_at: Option<[f64; 3]>,
    /// Degrees to the left of −Z, with `pitch`. Instead of `look_at`.
    ///
    /// Here in radians, like all angles.
    #[keys(range = -3600.0..=3600.0, absent = 0.0, map = f64::to_radians, unit = "degrees")]
    pub yaw: f64,
    /// Degrees upwards, with `yaw`. Instead of `look_at`.
    #[keys(range = -90.0..=90.0, absent = 0.0, map = f64::to_radians, unit = "degrees")]
    pub pitch: f64,
    /// Vertical field of view in degrees, 1 to 179.
    #[keys(range = CAMERA_FOV, default = 60.0, map = f64::to_radians, unit = "degrees")]
    pub fov: f64,
    /// How the value gets from one key to the next.
    #[keys(default = Interpolation::Smooth)]
    pub interpolation: Interpolation,
    /// The camera jumps here: curves end, and histories and kept contents start over.
    ///
    /// Until then it stays as the key before leaves it.
    #[keys(default = false)]
    pub cut: bool,
}

/// A param over time.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock, check = steps(keys, interpolation))]
pub struct Track {
    /// The param, at its place.
    #[keys(entry)]
    pub param: Spanned<String>,
    /// [seconds, value] in order of time.
    pub keys: TrackKeys,
    /// How the value gets from one key to the next.
    #[keys(told = Interpolation::Linear)]
    pub interpolation: Option<Interpolation>,
}

/// The values of a param over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackKeys {
    /// Times and components of the values, in order of time. All have the same number of components.
    pub values: Vec<Spanned<(f64, Vec<f64>)>>,
    /// The values are `true` and `false`.
    pub boolean: bool,
}

/// A change of the graph.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock)]
pub struct GraphKey {
    /// Seconds from the start.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    pub time: Spanned<f64>,
    /// The graph from then on, relative to graphs/.
    #[keys(read = project_path("graphs"))]
    pub graph: Spanned<String>,
}

/// A change of the debug target.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock)]
pub struct DebugTargetKey {
    /// Seconds from the start.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    pub time: Spanned<f64>,
    /// NAME or NAME@AGE, followed by any of ,mip=N ,layer=N ,after=PASS. For a loop, PASS is the last round, and PASS\[2\] the round of
    /// index 2.
    #[keys(
        about = "NAME, NAME@AGE, and after it any of ,mip=N ,layer=N ,after=PASS (of a loop the last round; PASS[2] is that of index 2)."
    )]
    pub target: Spanned<DebugTarget>,
}

/// A line of text over the picture.
#[derive(Clone, Debug, PartialEq, Eq, Keys)]
pub struct CaptionText {
    /// One line.
    #[keys(read = line)]
    pub text: String,
    /// Place in the picture.
    #[keys(default = CaptionEdge::Bottom)]
    pub place: CaptionEdge,
}

/// Where a caption stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum CaptionEdge {
    /// At the bottom of the picture.
    Bottom,
    /// At the top of the picture.
    Top,
}

/// A line of text for some time.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock, check = lasts(time, until))]
pub struct Caption {
    /// Seconds from the start.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    pub time: Spanned<f64>,
    /// Seconds from the start at which the caption ends.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    pub until: Spanned<f64>,
    /// The line.
    #[keys(flatten)]
    pub line: CaptionText,
}

/// Something that must hold when the demo runs as a test.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock)]
pub struct Check {
    /// Where it stands.
    #[keys(span)]
    pub span: Span,
    /// Its claim.
    #[keys(flatten)]
    pub claim: Claim,
}

/// The claims of checks.
#[derive(Clone, Debug, PartialEq, Keys)]
#[keys(context = Clock)]
pub enum Claim {
    /// A pass is fast.
    #[keys(key = "pass", excludes = "a check is about a pass or about a picture")]
    Pass {
        /// The pass whose time is checked. Instead of `reference`.
        pass: Spanned<String>,
        /// Largest GPU time in milliseconds, the median of all frames. Needed for a pass.
        #[keys(range = 1e-6..=1e6, unit = "milliseconds")]
        below_ms: f64,
    },
    /// A target at a frame is as a reference.
    Picture {
        /// The reference picture: a PNG relative to worlds/. `raxel test --write` writes it. Needed for a picture.
        ///
        /// Here as a project path.
        #[keys(read = project_path("worlds"))]
        reference: Spanned<String>,
        /// Largest mean FLIP error, 0 to 1. Needed for a picture.
        #[keys(range = 0.0..=1.0)]
        flip: f64,
        /// The target that is checked, as in `show`. The demo's shown target when left out.
        target: Option<Spanned<DebugTarget>>,
        /// When it is looked at.
        #[keys(flatten)]
        frame: Looked,
    },
}

/// The frame that is looked at: one of the two is there.
#[derive(Clone, Debug, PartialEq, Eq, Keys)]
#[keys(context = Clock, check = once(frame, time))]
pub struct Looked {
    /// The frame that is checked, from 0. Needed for a picture, unless there is `time`.
    #[keys(read = frame, range = 0..=u64::MAX, excludes("time", why = "both say when"))]
    frame: Option<u64>,
    /// The time of this frame in seconds. Instead of `frame`.
    ///
    /// Here as the nearest frame.
    #[keys(read = nearest_frame, shape = Shape::Number { least: Some(0.0), most: None }, unit = "seconds")]
    time: Option<u64>,
}

impl Demo {
    /// The frame at `seconds` seconds, headless.
    pub fn frame_at(&self, seconds: f64) -> u64 {
        Moment::from(seconds).nearest(Fraction::of(self.fps))
    }

    /// The seconds at which checks look at pictures, in order.
    pub fn checked_times(&self) -> Vec<f64> {
        let seconds = |check: &Check| match check.claim {
            Claim::Picture { ref frame, .. } => Some(frame.number() as f64 / self.fps),
            Claim::Pass { .. } => None,
        };
        let mut times: Vec<f64> = self.checks.iter().filter_map(seconds).collect();
        times.sort_by(f64::total_cmp);
        times
    }

    /// The caption at `time` seconds on the clock: of several the last that has appeared.
    pub fn caption(&self, time: impl Into<Moment>) -> Option<&CaptionText> {
        let time = self.local_time(time);
        let shown = |caption: &&Caption| (caption.time.value..caption.until.value).contains(&time);
        self.captions.iter().rev().find(shown).map(|caption| &caption.line)
    }

    /// Whether there is a cut on the way from one moment to a later one, both in seconds on the clock: of the camera, or since another
    /// graph runs.
    pub fn cuts_between(&self, before: impl Into<Moment>, after: impl Into<Moment>) -> bool {
        let (before, after) = (self.local_time(before), self.local_time(after));
        let between = |time: f64| before < time && time <= after;
        self.camera.iter().any(|key| key.cut && between(key.time.value))
            || self.graph_in(before).value != self.graph_in(after).value
    }

    /// The graph at `time` seconds on the clock.
    pub fn graph_at(&self, time: impl Into<Moment>) -> &Spanned<String> {
        self.graph_in(self.local_time(time))
    }

    /// The graph at `time` seconds into the timeline.
    pub(crate) fn graph_in(&self, time: f64) -> &Spanned<String> {
        self.graphs.iter().rev().find(|key| key.time.value <= time).map_or(&self.graph, |key| &key.graph)
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
        let since = self.graphs.iter().rev().find(|key| key.time.value <= time).map_or(0.0, |key| key.time.value);
        let shown = self.shows.iter().rev().find(|key| key.time.value <= time)?;
        (shown.time.value >= since).then_some(&shown.target.value)
    }

    /// The camera at `time` seconds on the clock; `None` when it is not the demo's.
    pub fn camera(&self, time: impl Into<Moment>) -> Option<Camera> {
        let time = self.local_time(time);
        let keys = &self.camera;
        if keys.is_empty() {
            return None;
        }
        let i = segment(keys.iter().map(|key| key.time.value), time);
        // A curve goes from one cut to the next.
        let first = keys[..=i].iter().rposition(|key| key.cut).unwrap_or(0);
        let end = keys[i + 1..].iter().position(|key| key.cut).map_or(keys.len(), |next| i + 1 + next);
        let (keys, i) = (&keys[first..end], i - first);
        let how = keys[i].interpolation;
        let curve = |value: &dyn Fn(&CameraKey) -> f64| {
            sample(keys.len(), |i| (keys[i].time.value, value(&keys[i])), time, how)
        };
        let mut camera = Camera::default();
        camera.place(DVec3::from_array(std::array::from_fn(|axis| curve(&|key| key.position[axis]))));
        camera.fov = curve(&|key| key.fov);
        // Between two keys that look at points, the point moves; else the angles turn. Both agree at the keys.
        let ends = [&keys[i], &keys[(i + 1).min(keys.len() - 1)]];
        if ends.iter().all(|key| key.look_at.is_some()) {
            let target = std::array::from_fn(|axis| curve(&|key| key.looks_at()[axis]));
            camera.look_at(target);
        } else {
            camera.yaw = sample(keys.len(), |i| (keys[i].time.value, yaw_of_key(keys, i)), time, how);
            camera.pitch = curve(&|key| key.angles()[1]).clamp(-Camera::MAX_PITCH, Camera::MAX_PITCH);
        }
        Some(camera)
    }
}

impl CameraKey {
    /// The point it looks at; for angles, one a hundred voxels ahead.
    fn looks_at(&self) -> [f64; 3] {
        self.look_at.unwrap_or_else(|| {
            let towards = Camera { yaw: self.yaw, pitch: self.pitch, ..Camera::default() };
            (DVec3::from_array(self.position) + towards.rotation() * (DVec3::NEG_Z * 100.0)).to_array()
        })
    }

    /// Yaw and pitch.
    fn angles(&self) -> [f64; 2] {
        let Some(target) = self.look_at else { return [self.yaw, self.pitch] };
        let mut camera = Camera::at(self.position);
        camera.look_at(target);
        [camera.yaw, camera.pitch]
    }
}

impl Looked {
    /// Its number.
    pub fn number(&self) -> u64 {
        self.frame.or(self.time).unwrap_or_default()
    }
}

/// The yaw of a key such that each turn from one key to the next is the short way round.
fn yaw_of_key(keys: &[CameraKey], key: usize) -> f64 {
    use std::f64::consts::TAU;
    let mut yaws = keys[..=key].iter().map(|key| key.angles()[0]);
    let first = yaws.next().unwrap_or_default();
    // Whole turns are added, and nothing else: a yaw that needs none stays as it is, bit by bit.
    yaws.fold(first, |last, yaw| yaw + ((last - yaw) / TAU).round() * TAU)
}

impl Track {
    /// How it gets from key to key.
    fn interpolation(&self) -> Interpolation {
        self.interpolation.unwrap_or(if self.keys.boolean { Interpolation::Step } else { Interpolation::Linear })
    }

    /// The value at `time` seconds into the timeline, as the type of `like`. `None` when they do not fit.
    fn at(&self, time: f64, like: &Value) -> Option<Value> {
        let width = self.keys.values.first()?.value.1.len();
        // The widest value is a matrix.
        let mut numbers = [0.0; 16];
        let numbers = numbers.get_mut(..width)?;
        for (part, number) in numbers.iter_mut().enumerate() {
            let key = |i: usize| (self.keys.values[i].value.0, self.keys.values[i].value.1[part]);
            *number = sample(self.keys.values.len(), key, time, self.interpolation());
            if params::is_integer(like) {
                *number = number.round();
            }
        }
        params::from_components(numbers, like)
    }
}
