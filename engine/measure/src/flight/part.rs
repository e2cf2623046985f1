//! The path of a flight, and the parts that it has.

use std::f64::consts::PI;
use std::fmt;

use glam::DVec3;
use raxel_runtime::camera::Camera;
use serde::{Serialize, Serializer};

/// A part of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlightPart {
    /// Over fresh land.
    #[default]
    Straight,
    /// Half a turn, where the way back begins.
    Turn,
    /// Back over land that was seen.
    Back,
    /// Down into a valley.
    Down,
    /// At a place far away, from 1 on.
    Jump(u32),
}

impl fmt::Display for FlightPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Straight => f.pad("straight"),
            Self::Turn => f.pad("turn"),
            Self::Back => f.pad("back"),
            Self::Down => f.pad("down"),
            Self::Jump(n) => f.pad(&format!("jump {n}")),
        }
    }
}

impl Serialize for FlightPart {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Jumps to fresh land.
pub(super) const JUMPS: u32 = 3;

/// Seconds of half a turn.
const TURN: f64 = 0.5;

/// Straight over fresh land, half a turn, back over land that was seen, down into a valley, and three jumps to fresh land.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// Where it begins.
    pub(super) first: Camera,
    /// Voxels a second of the straight parts.
    pub(super) speed: f64,
    /// Seconds of each straight part.
    pub(super) leg: f64,
    /// Seconds of the way down, and at each place after a jump.
    pub(super) stay: f64,
}

impl Path {
    /// Where the camera is after some seconds.
    pub(super) fn camera(&self, time: f64) -> Camera {
        let mut camera = self.first;
        let ahead = camera.rotation() * DVec3::NEG_Z * DVec3::new(1.0, 0.0, 1.0);
        let ahead = if ahead.length() > 1e-3 { ahead.normalize() } else { DVec3::NEG_Z };
        let out = time.min(self.leg);
        let turn = (time - self.leg).clamp(0.0, TURN);
        let back = (time - self.leg - TURN).clamp(0.0, self.leg);
        camera.translate(ahead * self.speed * (out - back));
        camera.yaw += PI * turn / TURN;
        let dive = (time - 2.0 * self.leg - TURN).clamp(0.0, self.stay);
        camera.translate(DVec3::NEG_Y * 60.0 * (dive / self.stay));
        if let FlightPart::Jump(jump) = self.part(time).0 {
            let jump = f64::from(jump);
            camera.translate(DVec3::new(20_000.0 * jump, 60.0, -15_000.0 * jump));
        }
        camera
    }

    /// The part that the camera is on after some seconds, and the seconds since that began.
    pub(super) fn part(&self, time: f64) -> (FlightPart, f64) {
        let jump = |n: u32| (FlightPart::Jump(n), self.first_jump() + f64::from(n - 1) * self.stay);
        let parts = [
            (FlightPart::Straight, 0.0),
            (FlightPart::Turn, self.leg),
            (FlightPart::Back, self.leg + TURN),
            (FlightPart::Down, 2.0 * self.leg + TURN),
        ];
        let begun = parts.into_iter().chain((1..=JUMPS).map(jump)).rfind(|(_, begin)| time >= *begin);
        let (part, begin) = begun.unwrap_or((FlightPart::Straight, 0.0));
        (part, time - begin)
    }

    /// Seconds until the first jump.
    pub(super) fn first_jump(&self) -> f64 {
        2.0 * self.leg + TURN + self.stay
    }

    /// Seconds of the whole path.
    pub(super) fn length(&self) -> f64 {
        self.first_jump() + f64::from(JUMPS) * self.stay
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_goes_out_and_comes_back_and_jumps() {
        let path = Path { first: Camera::at([0.5, 100.5, 0.5]), speed: 64.0, leg: 10.0, stay: 2.0 };
        let at = |time: f64| path.camera(time);
        let first = path.first;
        assert_eq!(at(0.0), first);
        assert!((at(10.0).position() - first.position()).length() > 630.0);
        assert!((at(20.5).position() - first.position()).length() < 1e-3);
        assert!((at(20.5).yaw - first.yaw - PI).abs() < 1e-9);
        assert!(at(22.49).position().y < 45.0);
        let jumps = [22.6, 24.6, 26.6, path.length()].map(|time| at(time).position().x);
        assert!(jumps[0] > 19_000.0 && jumps[1] > 39_000.0 && jumps[2] > 59_000.0, "{jumps:?}");
        assert!((jumps[2] - jumps[3]).abs() < 1e-9);
        let parts = [9.9, 10.1, 11.0, 21.0, 23.0, 25.0, 100.0].map(|time| path.part(time).0.to_string());
        assert_eq!(parts, ["straight", "turn", "back", "down", "jump 1", "jump 2", "jump 3"]);
        assert!((path.part(25.0).1 - 0.5).abs() < 1e-9);
    }
}
