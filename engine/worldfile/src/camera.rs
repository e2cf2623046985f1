//! `[camera]` and `[cameras.NAME]`: from where a world is best looked at.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_language::{Keys, Shape};
use serde::Serialize;
use serde_json::json;

/// Where a camera starts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraHint {
    /// In voxels, Y up.
    pub position: [f64; 3],
    /// Where it looks.
    pub aim: Aim,
    /// Vertical field of view in degrees, if the file gives one.
    pub fov: Option<f64>,
}

/// Where a camera looks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Aim {
    /// At a position in voxels.
    LookAt([f64; 3]),
    /// Along a direction.
    Angles {
        /// Turn to the left about +Y in degrees; 0 looks along −Z.
        yaw: f64,
        /// Tilt upwards in degrees, −90…90.
        pitch: f64,
    },
}

/// Coordinates of a camera and of its target, in voxels.
pub const CAMERA_COORDINATES: RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_648.0;

/// Vertical fields of view that a camera may have, in degrees.
pub const CAMERA_FOV: RangeInclusive<f64> = 1.0..=179.0;

/// Where to look from.
#[derive(Keys)]
#[keys(into = CameraHint, check = elsewhere(position, look_at))]
pub(super) struct Camera {
    /// Where the camera starts, in voxels; Y is up.
    #[keys(range = CAMERA_COORDINATES)]
    position: [f64; 3],
    /// The point that the camera looks at, in voxels. Instead of `yaw` and `pitch`.
    #[keys(range = CAMERA_COORDINATES, excludes("yaw", "pitch", why = "a camera looks at a place or along a direction"))]
    look_at: Option<[f64; 3]>,
    /// Turn to the left in degrees; 0 looks along −Z.
    #[keys(range = -360.0..=360.0, default = 0.0)]
    yaw: f64,
    /// Tilt upwards in degrees.
    #[keys(range = -90.0..=90.0, default = 0.0)]
    pitch: f64,
    /// Vertical field of view in degrees, 1 to 179.
    #[keys(range = CAMERA_FOV, told = 60)]
    fov: Option<f64>,
}

/// A camera that is found by its name.
#[derive(Keys)]
#[keys(check = tellable(name))]
pub(super) struct NamedCamera {
    #[keys(entry)]
    pub(super) name: Spanned<String>,
    #[keys(flatten)]
    pub(super) camera: Camera,
}

impl From<Camera> for CameraHint {
    fn from(Camera { position, look_at, yaw, pitch, fov }: Camera) -> Self {
        Self { position, aim: look_at.map_or(Aim::Angles { yaw, pitch }, Aim::LookAt), fov }
    }
}

/// The table of [`NamedCamera`]s.
pub(super) fn named() -> Shape {
    Shape::Schema(json!({
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_-]*$" },
        "additionalProperties": Camera::form().definition(),
    }))
}

fn elsewhere(table: &Table<'_, '_>, position: &[f64; 3], look_at: Option<&[f64; 3]>) -> bool {
    let right = look_at != Some(position);
    if !right && let Some(node) = table.get("look_at") {
        node.bad_value::<()>(format!("`{}` is where the camera is: it has no direction", node.name));
    }
    right
}

/// A name that `--camera` cannot take for a position.
fn tellable(table: &Table<'_, '_>, name: &Spanned<String>) -> bool {
    let Spanned { value: name, span } = name;
    let inner = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let right = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && name.chars().all(inner);
    if !right {
        table.reporter().report(
            Diagnostic::error(codes::files::BAD_VALUE, format!("a camera cannot be called `{name}`"))
                .label(span.clone(), "")
                .help("a letter or _, then letters, digits, _ and -"),
        );
    }
    right
}
