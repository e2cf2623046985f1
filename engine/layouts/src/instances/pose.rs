//! The pose of an instance, and its motions.

use std::ops::RangeInclusive;

use raxel_language::Keys;

/// The centre of the anchor's cell, from the position.
const MIDDLE: f64 = 0.5;
/// A quaternion of `f32` that is so near to a quarter turn is meant to be one.
const QUARTER: f64 = 4.0e-7;

/// A place and a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The smallest corner of the anchor's cell, in voxels, before the rotation about the centre of that cell.
    pub position: [f64; 3],
    /// From the model's axes to the world's: rows of a rotation matrix.
    pub rotation: [[f64; 3]; 3],
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Axis {
    /// Right.
    X,
    /// Up.
    Y,
    /// Towards the viewer.
    Z,
}

/// A movement by the value of a param.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Name of the graph's param: a number.
    pub param: String,
    /// Its value for graphs without that param.
    pub default: Option<f64>,
    /// Its effect.
    pub kind: MotionKind,
}

/// The effect of a param's value on an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionKind {
    /// Moves it by the value times this vector, in voxels.
    Slide([f64; 3]),
    /// Turns it by that many degrees, to the left as seen from the end of the axis.
    Rotation {
        /// The axis.
        axis: Axis,
        /// A point on the axis; the centre of its own anchor when `None`.
        about: Option<[f64; 3]>,
        /// It goes around the axis without being turned itself.
        upright: bool,
    },
}

impl Pose {
    /// Coordinates that a position may have.
    pub const COORDINATES: RangeInclusive<f64> = -1.0e9..=1.0e9;

    /// At a position, turned by `roll` about the model's Z axis, then by `pitch` about X, then by `yaw` about Y: degrees, all to the left
    /// as seen from the end of the axis.
    pub fn new(position: [f64; 3], [yaw, pitch, roll]: [f64; 3]) -> Self {
        let turns = product(&about(Axis::Y, yaw), &product(&about(Axis::X, pitch), &about(Axis::Z, roll)));
        Self { position, rotation: turns }
    }

    /// At a position, turned by a quaternion: x, y, z, w, of any length. A length of zero gives no pose. Quarter turns whose numbers are
    /// as exact as `f32` are exact.
    pub fn turned(position: [f64; 3], quaternion: [f64; 4]) -> Option<Self> {
        let length = quaternion.iter().map(|q| q * q).sum::<f64>();
        if length == 0.0 {
            return None;
        }
        let [x, y, z, w] = quaternion;
        let twice = |product: f64| 2.0 * product / length;
        let rotation = [
            [1.0 - twice(y * y + z * z), twice(x * y - z * w), twice(x * z + y * w)],
            [twice(x * y + z * w), 1.0 - twice(x * x + z * z), twice(y * z - x * w)],
            [twice(x * z - y * w), twice(y * z + x * w), 1.0 - twice(x * x + y * y)],
        ];
        // A quarter turn up to the rounding of the quaternion becomes an exact one.
        let whole = rotation.map(|row| row.map(f64::round));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < QUARTER;
        let is_quarter = rotation.as_flattened().iter().zip(whole.as_flattened()).all(near);
        Some(Self { position, rotation: if is_quarter { whole } else { rotation } })
    }

    /// Moved by a value.
    #[must_use]
    pub fn moved(self, kind: MotionKind, amount: f64) -> Self {
        match kind {
            MotionKind::Slide(along) => {
                let position = std::array::from_fn(|i| self.position[i] + amount * along[i]);
                Self { position, ..self }
            }
            MotionKind::Rotation { axis, about: point, upright } => {
                let turn = about(axis, amount);
                let position = point.map_or(self.position, |point| {
                    let arm = std::array::from_fn(|i| self.position[i] + MIDDLE - point[i]);
                    let turned = apply(&turn, arm);
                    std::array::from_fn(|i| point[i] + turned[i] - MIDDLE)
                });
                Self { position, rotation: if upright { self.rotation } else { product(&turn, &self.rotation) } }
            }
        }
    }

    /// The centre of the anchor's cell.
    pub fn middle(&self) -> [f64; 3] {
        self.position.map(|p| p + MIDDLE)
    }
}

/// Sine and cosine of degrees; of quarter turns exactly.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a quarter turn is one of a few")]
fn sine_cosine(degrees: f64) -> [f64; 2] {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).floor();
    let [sine, cosine] = match turn - 90.0 * quarter {
        0.0 => [0.0, 1.0],
        rest => [rest.to_radians().sin(), rest.to_radians().cos()],
    };
    match quarter as u32 % 4 {
        0 => [sine, cosine],
        1 => [cosine, -sine],
        2 => [-sine, -cosine],
        _ => [-cosine, sine],
    }
}

/// A turn about an axis of the world.
fn about(axis: Axis, degrees: f64) -> [[f64; 3]; 3] {
    let [s, c] = sine_cosine(degrees);
    match axis {
        Axis::X => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        Axis::Y => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        Axis::Z => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// First `b`, then `a`.
fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn apply(a: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| a[i][k] * v[k]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(vector: [f64; 3]) -> [u64; 3] {
        vector.map(|component| (component + 0.0).to_bits())
    }

    #[test]
    fn quarter_turns_are_whole_numbers() {
        for yaw in [-270.0, -90.0, 0.0, 90.0, 180.0, 270.0, 360.0, 450.0] {
            for pitch in [-90.0, 0.0, 90.0, 180.0] {
                let pose = Pose::new([0.0; 3], [yaw, pitch, 90.0]);
                assert!(pose.rotation.as_flattened().iter().all(|v| [-1.0, 0.0, 1.0].contains(v)), "{pose:?}");
            }
        }
        // To the left, seen from above, +X goes to −Z, as models of [[build]] are turned.
        assert_eq!(bits(apply(&about(Axis::Y, 90.0), [1.0, 0.0, 0.0])), bits([0.0, 0.0, -1.0]));
    }

    #[test]
    fn a_turn_about_a_point_keeps_the_distance() {
        let turn = MotionKind::Rotation { axis: Axis::Y, about: Some([8.0, 0.0, 8.0]), upright: false };
        let pose = Pose::new([18.0, 3.0, 7.0], [0.0; 3]);
        let quarter = pose.moved(turn, 90.0);
        assert_eq!(bits(quarter.middle()), bits([7.5, 3.5, -2.5]));
        assert_eq!(quarter.rotation, about(Axis::Y, 90.0));
        let upright = MotionKind::Rotation { axis: Axis::Y, about: Some([8.0, 0.0, 8.0]), upright: true };
        assert_eq!(pose.moved(upright, 90.0), Pose { position: quarter.position, ..pose });
        let other = pose.moved(turn, 37.0).middle();
        let length = ((other[0] - 8.0).powi(2) + (other[2] - 8.0).powi(2)).sqrt();
        assert!((length - (10.5_f64.powi(2) + 0.25).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_quaternion_turns_as_angles_do_and_leaves_its_axis() {
        let turned = |axis: [f64; 3], degrees: f64| {
            let (s, c) = (degrees / 2.0).to_radians().sin_cos();
            Pose::turned([0.0; 3], [s * axis[0], s * axis[1], s * axis[2], c]).expect("it has a length").rotation
        };
        let near = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
            assert!(a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
        };
        let axes = [(Axis::X, [1.0, 0.0, 0.0]), (Axis::Y, [0.0, 1.0, 0.0]), (Axis::Z, [0.0, 0.0, 1.0])];
        for (axis, along) in axes {
            near(turned(along, 37.0), about(axis, 37.0));
        }
        // X, Y and Z become each other in a third of a turn about the diagonal between them; any length will do.
        near(turned([1.0 / 3.0_f64.sqrt(); 3], 120.0), [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let pose = Pose::turned([0.0; 3], [1.0, 2.0, 3.0, 4.0]).expect("it has a length");
        let axis = apply(&pose.rotation, [1.0, 2.0, 3.0]);
        assert!((0..3).all(|i| (axis[i] - (i + 1) as f64).abs() < 1e-12), "{axis:?}");
    }

    #[test]
    fn a_slide_goes_along_its_direction_as_often_as_the_value_says() {
        let pose = Pose::new([1.0, 2.0, 3.0], [30.0, 0.0, 0.0]);
        let moved = pose.moved(MotionKind::Slide([0.5, -2.0, 0.0]), 4.0);
        assert_eq!(moved, Pose { position: [3.0, -6.0, 3.0], ..pose });
    }
}
