//! `[camera]` and `[cameras.NAME]`: from where a world is best looked at.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};
use serde::Serialize;

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

/// Coordinates that a camera may have, and what it looks at, in voxels.
pub const CAMERA_COORDINATES: RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_648.0;

/// Vertical fields of view that a camera may have, in degrees.
pub const CAMERA_FOV: RangeInclusive<f64> = 1.0..=179.0;

/// A name that `--camera` can tell from a position.
pub(super) fn name(name: String, node: &Node<'_, '_>) -> Option<String> {
    let inner = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && name.chars().all(inner) {
        return Some(name);
    }
    node.reporter().report(
        Diagnostic::error(codes::files::BAD_VALUE, format!("a camera cannot be called `{name}`"))
            .label(node.key_span.clone(), "")
            .help("a letter or _, then letters, digits, _ and -"),
    );
    None
}

pub(super) fn read(table: &Table<'_, '_>) -> Option<CameraHint> {
    let position = table.need("position").and_then(|node| node.numbers::<3>(CAMERA_COORDINATES));
    let fov = table.get("fov").and_then(|node| node.number(CAMERA_FOV));
    let look_at = table.get("look_at").map(|node| {
        let place = node.numbers::<3>(CAMERA_COORDINATES)?;
        if position == Some(place) {
            return node.bad_value(format!("`{}` is where the camera is: it has no direction", node.name));
        }
        Some(place)
    });
    let yaw = table.get("yaw").and_then(|node| node.number(-360.0..=360.0));
    let pitch = table.get("pitch").and_then(|node| node.number(-90.0..=90.0));
    let why = "a camera looks at a place or along a direction";
    if !table.conflict("look_at", "yaw", why) {
        table.conflict("look_at", "pitch", why);
    }
    table.finish();
    let aim = match look_at {
        Some(place) => Aim::LookAt(place?),
        None => Aim::Angles { yaw: yaw.unwrap_or(0.0), pitch: pitch.unwrap_or(0.0) },
    };
    Some(CameraHint { position: position?, aim, fov })
}
