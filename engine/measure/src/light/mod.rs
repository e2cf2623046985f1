//! Lighting judged by run time against error: systems × scenes, each run twice with other random numbers and held against two independent
//! references. The figures of `raxel bench light`; `docs/light/judge.md` has the protocol.
//!
//! A system is a graph with a target `radiance` of floats: linear light that reaches the eye, along rays through the centres of the pixels,
//! before exposure, haze and tone curve. Its param `seed` makes another, independent run.

pub mod error;
pub mod film;
pub mod flip;
mod overlay;
pub mod reference;
mod reference_store;
mod run;
pub mod seeded;

use std::path::PathBuf;

use raxel_execute::Texels;
use raxel_gpu::{Device, Validation};
use raxel_runtime::camera::Camera;
use raxel_runtime::params::SetError;
use raxel_runtime::session::{FrameError, OpenError, ReadError};
use serde::Serialize;

pub use error::{Epsilon, Judged, judge};
pub use reference::References;
pub use run::Bench;

/// The graph that is the truth, and the brute force that every system must beat.
pub const REFERENCE: &str = "graphs/light/reference_centre.toml";

/// The target that is judged.
pub(crate) const RADIANCE: &str = "radiance";

/// A view of a world under some light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// Project path of the world.
    pub world: String,
    /// From where it is seen; the world's first camera when `None`.
    pub camera: Option<Camera>,
    /// Params that are set in every system that declares them.
    pub params: Vec<(String, f32)>,
    /// The same as texts, of any type; they win.
    pub set: Vec<(String, String)>,
    /// The motion in the moving part of a run.
    pub motion: Motion,
    /// Params that move the world's instances. A system that lacks one of them gets it for the run.
    pub instance_params: Vec<String>,
    /// The ε that keeps the weight of dark pixels finite.
    pub epsilon: Epsilon,
}

/// Everything that moves. It ends where the references were made: with the scene's camera and params.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The camera.
    pub camera: CameraMotion,
    /// Params, by how much each changes in a second. Systems without the param go without.
    pub params: Vec<(String, f32)>,
}

/// How a camera moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CameraMotion {
    /// To the right or the left, from the side with more room.
    #[default]
    Sideways,
    /// By this many voxels a second.
    By([f64; 3]),
}

/// Where and how long everything is run.
#[derive(Clone, Debug)]
pub struct Effort {
    /// A folder of the project.
    pub project: PathBuf,
    /// The Vulkan device: a part of its name, or its number.
    pub device: Option<String>,
    /// Whether the validation layer looks on.
    pub validation: Validation,
    /// Extent of the pictures in pixels.
    pub size: [u32; 2],
    /// Frames of a still camera that are run; pictures are judged at the powers of two.
    pub frames: u32,
    /// Frames of a moving camera. The last one is judged. 0 leaves motion out.
    pub pan: u32,
    /// Frames after a lamp goes out; 0 leaves that out.
    pub lag: u32,
    /// Most paths a pixel of each half of a reference.
    pub most_paths: u32,
    /// A half of a reference is good enough when this relative error is forecast for it.
    pub goal: f64,
    /// Whether references are kept in `.raxel/cache/light` of the project, and taken from there.
    pub keep: bool,
}

/// Errors of a system or of the device.
#[derive(Debug, thiserror::Error)]
pub enum LightError {
    /// It does not open.
    #[error("{}", first_line(.0))]
    Open(Box<OpenError>),
    /// A frame does not run.
    #[error(transparent)]
    Frame(Box<FrameError>),
    /// A picture cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A param cannot be set.
    #[error(transparent)]
    Set(#[from] SetError),
    /// The graph with the params that move instances cannot be written.
    #[error("`{path}` cannot be written: {error}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// It has nothing that can be judged.
    #[error("it has no target `radiance` of floats")]
    NoRadiance,
}

impl From<OpenError> for LightError {
    fn from(error: OpenError) -> Self {
        Self::Open(Box::new(error))
    }
}

impl From<FrameError> for LightError {
    fn from(error: FrameError) -> Self {
        Self::Frame(Box::new(error))
    }
}

fn first_line(error: &OpenError) -> String {
    match error {
        OpenError::Project { diagnostics, .. } => {
            let first = diagnostics.iter().find(|diagnostic| diagnostic.is_error());
            first.map_or_else(|| error.to_string(), |found| format!("{}: {}", found.code, found.message))
        }
        _ => error.to_string(),
    }
}

/// A picture in linear light: rows from the top, red, green, blue.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels along each axis.
    pub size: [u32; 2],
    /// Light of each pixel.
    pub texels: Vec<[f32; 3]>,
}

impl Picture {
    /// Of a target's texels.
    pub fn of(texels: &Texels) -> Self {
        let rgb = texels.floats().iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
        Self { size: [texels.width, texels.height], texels: rgb }
    }

    /// BLAKE3 of its floats.
    pub fn hash(&self) -> String {
        blake3::hash(bytemuck::cast_slice(&self.texels)).to_hex().to_string()
    }

    /// Mean luminance (ITU-R BT.709) of the pixels that are finite.
    pub fn mean(&self) -> f64 {
        let luminance = self.texels.iter().map(luminance).filter(|luminance| luminance.is_finite());
        luminance.sum::<f64>() / self.texels.len().max(1) as f64
    }
}

/// Luminance of linear light (ITU-R BT.709).
pub fn luminance([r, g, b]: &[f32; 3]) -> f64 {
    0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b)
}

/// One system in one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// With a still camera, in the order of frames.
    pub still: Vec<Point>,
    /// GPU milliseconds of the first frame.
    pub first_ms: f64,
    /// GPU milliseconds of a later frame: the sum of the medians of its passes, each by how often it ran.
    pub frame_ms: f64,
    /// Change from the last frame but one to the last, weighted as an error: flicker under a still camera.
    pub flicker: f64,
    /// Mean HDR-FLIP of the last picture.
    pub flip: Option<f64>,
    /// Mean luminance of the last picture.
    pub mean: f64,
    /// Whether nothing was dispatched any more in the last frame.
    pub rests: bool,
    /// Bytes of memory that the plan has of its own.
    pub bytes: u64,
    /// With a moving camera.
    pub pan: Option<Pan>,
    /// After a lamp went out.
    pub lag: Option<Lag>,
}

/// The picture after a number of frames.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Frames since the start.
    pub frame: u32,
    /// GPU milliseconds of all frames since the start, each pass by its median.
    pub ms: f64,
    /// How wrong it is.
    #[serde(flatten)]
    pub judged: Judged,
}

/// The last picture of a camera that has moved until then.
#[derive(Clone, Debug, Serialize)]
pub struct Pan {
    /// Voxels that it has come.
    pub voxels: f64,
    /// GPU milliseconds of a frame.
    pub frame_ms: f64,
    /// How wrong it is.
    #[serde(flatten)]
    pub judged: Judged,
}

/// How the light of a lamp goes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lag {
    /// Frames until 5 % of its light are left; `None` when that was not reached.
    pub to_5_percent: Option<u32>,
    /// Frames until 1 % is left.
    pub to_1_percent: Option<u32>,
    /// The part that is left in the end.
    pub left: f64,
    /// Frames that were looked at.
    pub frames: u32,
}

/// The name of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceName {
    /// The device's own name.
    pub name: String,
    /// Its driver, with the version.
    pub driver: String,
}

impl DeviceName {
    /// The name of a device.
    pub fn of(device: &Device) -> Self {
        let capabilities = device.capabilities();
        Self { name: capabilities.name.clone(), driver: capabilities.driver.clone() }
    }
}
