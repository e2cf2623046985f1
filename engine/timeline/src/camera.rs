//! The camera: a voxel and a place in it, so that a picture is the same bytes anywhere in ±2³¹ voxels.
//!
//! Right-handed, Y up; with yaw and pitch zero it looks along −Z. Motion is reckoned in `f64` on the place in the voxel, never on
//! the distance from the origin.

use glam::{DMat3, DVec2, DVec3, IVec3, Mat4, Vec2, Vec3};
use raxel_stream::Eye;

/// Position, direction and field of view of a camera. World space is right-handed, with Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Voxel that holds the camera.
    pub cell: IVec3,
    /// Place in that voxel, each component in [0, 1).
    pub frac: Vec3,
    /// Turn to the left about +Y, radians. Zero looks along −Z.
    pub yaw: f64,
    /// Tilt upwards, radians in ±[`Camera::MAX_PITCH`].
    pub pitch: f64,
    /// Vertical field of view, radians.
    pub fov: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self { cell: IVec3::ZERO, frac: Vec3::splat(0.5), yaw: 0.0, pitch: 0.0, fov: 60_f64.to_radians() }
    }
}

/// A user's input to a flying camera in one frame, as plain numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlyInput {
    /// Right (D minus A), up (E minus Q) and forward (W minus S), each in −1…1.
    pub motion: [f64; 3],
    /// Motion of the mouse in pixels, positive to the right and down.
    pub look: [f64; 2],
}

/// Speeds of a flying camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlySpeed {
    /// Speed of motion in voxels a second.
    pub voxels: f64,
    /// Speed of turning in radians for each pixel of mouse motion.
    pub radians: f64,
}

impl Default for FlySpeed {
    fn default() -> Self {
        Self { voxels: 32.0, radians: 0.0025 }
    }
}

/// A rotation between view space and the world, in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewMatrices {
    /// `camera.view_to_world`.
    pub view_to_world: Mat4,
    /// Its inverse.
    pub world_to_view: Mat4,
}

impl Camera {
    /// Straight up, in radians. There, yaw turns the picture.
    pub const MAX_PITCH: f64 = std::f64::consts::FRAC_PI_2;

    /// A camera at a position in voxels, with the default direction and field of view. Positions outside ±2³¹ are clamped.
    pub fn at(position: [f64; 3]) -> Self {
        let mut camera = Self::default();
        camera.place(DVec3::from_array(position));
        camera
    }

    /// Moves the camera to a position in voxels, clamped to ±2³¹.
    pub fn place(&mut self, position: DVec3) {
        for axis in 0..3 {
            (self.cell[axis], self.frac[axis]) = split(0, position[axis]);
        }
    }

    /// The position in voxels, exact to about 10⁻⁷ voxels near the origin and to 10⁻⁶ at ±2³¹.
    pub fn position(&self) -> DVec3 {
        self.cell.as_dvec3() + self.frac.as_dvec3()
    }

    /// Moves by `delta` voxels along the world's axes. At the ends of ±2³¹ the camera stops.
    pub fn translate(&mut self, delta: DVec3) {
        for axis in 0..3 {
            (self.cell[axis], self.frac[axis]) = split(self.cell[axis], f64::from(self.frac[axis]) + delta[axis]);
        }
    }

    /// Turns the camera into a direction in world space, of any length. The zero vector changes nothing.
    pub fn look_along(&mut self, direction: DVec3) {
        if direction == DVec3::ZERO || !direction.is_finite() {
            return;
        }
        let level = direction.x.hypot(direction.z);
        if level > 0.0 {
            self.yaw = (-direction.x).atan2(-direction.z);
        }
        self.pitch = direction.y.atan2(level).clamp(-Self::MAX_PITCH, Self::MAX_PITCH);
    }

    /// Turns the camera to a position in voxels. The difference of cells is exact, so this works far from the origin.
    pub fn look_at(&mut self, target: [f64; 3]) {
        let target = DVec3::from_array(target);
        let whole = target.floor();
        let cells = whole - self.cell.as_dvec3();
        self.look_along(cells + ((target - whole) - self.frac.as_dvec3()));
    }

    /// Flies for one frame, `seconds` after the last one.
    pub fn fly(&mut self, input: &FlyInput, speed: &FlySpeed, seconds: f64) {
        let look = DVec2::from_array(input.look) * speed.radians;
        self.yaw = (self.yaw - look.x).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch - look.y).clamp(-Self::MAX_PITCH, Self::MAX_PITCH);
        let [right, up, forward] = input.motion;
        let rotation = self.rotation();
        let motion = rotation.x_axis * right + DVec3::Y * up - rotation.z_axis * forward;
        // Two keys at once are no faster than one.
        self.translate(motion.clamp_length_max(1.0) * speed.voxels * seconds);
    }

    /// Whether the camera is at a position in voxels, within its precision. Then it cannot look at that position.
    pub fn is_at(&self, position: [f64; 3]) -> bool {
        let there = Self::at(position);
        (there.cell, there.frac) == (self.cell, self.frac)
    }

    /// Rotation from view space (x right, y up, looking along −z) to world space.
    pub fn rotation(&self) -> DMat3 {
        // The cosine of the float next to a right angle is not 0, and straight down would lean.
        let tilt = if self.pitch.abs() == Self::MAX_PITCH {
            let sin = self.pitch.signum();
            DMat3::from_cols(DVec3::X, DVec3::Z * sin, DVec3::NEG_Y * sin)
        } else {
            DMat3::from_rotation_x(self.pitch)
        };
        DMat3::from_rotation_y(self.yaw) * tilt
    }

    /// `camera.view_to_world`: the rotation as a 4×4 matrix without translation.
    pub fn view_to_world(&self) -> Mat4 {
        Mat4::from_mat3(self.rotation().as_mat3())
    }

    /// `camera.world_to_view`: the inverse rotation.
    pub fn world_to_view(&self) -> Mat4 {
        Mat4::from_mat3(self.rotation().transpose().as_mat3())
    }

    /// `camera.view_to_world` and its inverse, sheared along the line of sight: the ray through (x, y, −1) in view space goes where the ray
    /// through (x + shift\[0\], y + shift\[1\], −1) went.
    pub fn sheared(&self, shift: [f64; 2]) -> ViewMatrices {
        let shear =
            |sign: f64| DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-sign * shift[0], -sign * shift[1], 1.0));
        let rotation = self.rotation();
        let (to_world, to_view) = (rotation * shear(1.0), shear(-1.0) * rotation.transpose());
        let [view_to_world, world_to_view] = [to_world, to_view].map(|matrix| Mat4::from_mat3(matrix.as_mat3()));
        ViewMatrices { view_to_world, world_to_view }
    }

    /// The camera in the form for a streamed world, for a picture of that aspect of width over height.
    pub fn eye(&self, aspect: f64) -> Eye {
        let half_angle = self.tan_half_fov(aspect).as_dvec2().length().atan();
        Eye { position: self.position(), cell: self.cell, forward: self.rotation() * DVec3::NEG_Z, half_angle }
    }

    /// `camera.tan_half_fov`: tangents of half the horizontal and vertical field of view. `aspect` is width over height.
    pub fn tan_half_fov(&self, aspect: f64) -> Vec2 {
        let vertical = (self.fov * 0.5).tan();
        DVec2::new(vertical * aspect, vertical).as_vec2()
    }
}

/// Splits `cell + offset` into a cell and a fraction in [0, 1), without ever adding the two as floats.
#[expect(clippy::cast_possible_truncation, reason = "`whole` saturates at the ends of 64 bits, and the rest is in 0…1")]
fn split(cell: i32, offset: f64) -> (i32, f32) {
    /// The largest `f32` below 1.
    const ALMOST_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
    if !offset.is_finite() {
        return (cell, 0.5);
    }
    let whole = offset.floor();
    let mut frac = (offset - whole) as f32;
    // `as` saturates, so that the sum of two such numbers fits.
    let mut sum = i64::from(cell).saturating_add(whole as i64);
    if frac >= 1.0 {
        frac = 0.0;
        sum = sum.saturating_add(1);
    }
    match i32::try_from(sum) {
        Ok(cell) => (cell, frac),
        Err(_) if sum < 0 => (i32::MIN, 0.0),
        Err(_) => (i32::MAX, ALMOST_ONE),
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    #[test]
    fn motion_is_the_same_anywhere() {
        let mut near = Camera { cell: IVec3::ZERO, frac: Vec3::new(0.25, 0.5, 0.75), ..Camera::default() };
        let mut far = Camera { cell: IVec3::new(2_000_000_000, -2_000_000_000, 7), ..near };
        let offset = far.cell - near.cell;
        let step = DVec3::new(0.013, -0.7, 3.001);
        for _ in 0..1000 {
            near.translate(step);
            far.translate(step);
            assert_eq!(near.cell + offset, far.cell);
            assert_eq!(near.frac, far.frac);
            assert!(near.frac.cmpge(Vec3::ZERO).all() && near.frac.cmplt(Vec3::ONE).all());
        }
    }

    #[test]
    fn the_world_has_ends() {
        let mut camera = Camera::at([1e300, -1e300, f64::from(i32::MAX)]);
        assert_eq!(camera.cell, IVec3::new(i32::MAX, i32::MIN, i32::MAX));
        camera.translate(DVec3::new(5.0, -5.0, -1.0));
        assert_eq!(camera.cell, IVec3::new(i32::MAX, i32::MIN, i32::MAX - 1));
        assert!(camera.frac.cmplt(Vec3::ONE).all());
    }

    #[test]
    fn a_shear_moves_every_ray_by_the_same_part_of_a_pixel() {
        let camera = Camera { yaw: 0.7, pitch: -0.3, ..Camera::default() };
        let ViewMatrices { view_to_world, world_to_view } = camera.sheared([0.25, -0.125]);
        for [x, y] in [[0.0, 0.0], [0.5, -1.0], [-2.0, 0.25]] {
            let sheared = view_to_world.transform_vector3(Vec3::new(x, y, -1.0));
            let shifted = camera.rotation() * DVec3::new(f64::from(x) + 0.25, f64::from(y) - 0.125, -1.0);
            assert!(sheared.as_dvec3().abs_diff_eq(shifted, 1e-6));
            assert!(world_to_view.transform_vector3(sheared).abs_diff_eq(Vec3::new(x, y, -1.0), 1e-6));
        }
    }

    #[test]
    fn a_step_just_below_a_voxel_stays_a_fraction() {
        assert_eq!(split(4, -1e-12), (4, 0.0));
        assert_eq!(split(4, 0.999_999), (4, 0.999_999));
        assert_eq!(split(i32::MAX, f64::NAN), (i32::MAX, 0.5));
    }

    #[test]
    fn looks_where_it_is_told() {
        let mut camera = Camera::at([10.0, 20.0, 30.0]);
        assert_eq!(camera.rotation() * DVec3::NEG_Z, DVec3::NEG_Z);
        for target in [[20.0, 20.0, 30.0], [10.0, 25.0, 20.0], [0.0, 0.0, 100.0]] {
            camera.look_at(target);
            let wanted = (DVec3::from_array(target) - camera.position()).normalize();
            assert!((camera.rotation() * DVec3::NEG_Z).abs_diff_eq(wanted, 1e-9), "{target:?}");
        }
    }

    #[test]
    fn straight_down_is_exact() {
        for (pitch, y) in [(-90.0_f64, -1.0), (90.0, 1.0)] {
            for yaw in [0.0, 1.2, -3.0] {
                let camera = Camera { yaw, pitch: pitch.to_radians(), ..Camera::default() };
                assert_eq!(camera.rotation() * DVec3::NEG_Z, DVec3::new(0.0, y, 0.0), "{yaw}");
                assert!(camera.rotation().determinant() > 0.999_999);
            }
        }
        let mut camera = Camera::at([5.5, 100.5, -3.5]);
        camera.look_at([5.5, 0.0, -3.5]);
        assert_eq!(camera.view_to_world().z_axis.truncate(), Vec3::Y);
        // Flying on without a motion of the mouse leaves it.
        camera.fly(&FlyInput::default(), &FlySpeed::default(), 0.1);
        assert_eq!(camera.view_to_world().z_axis.truncate(), Vec3::Y);
    }

    #[test]
    fn nothing_can_be_looked_at_from_where_it_is() {
        let camera = Camera::at([0.1, -7.3, 1e9]);
        assert!(camera.is_at([0.1, -7.3, 1e9]) && !camera.is_at([0.1, -7.3, 1e9 + 0.1]));
    }

    #[test]
    fn keys_move_along_the_view() {
        let mut camera = Camera::at([0.5, 0.5, 0.5]);
        camera.fly(
            &FlyInput { motion: [0.0, 0.0, 1.0], look: [0.0; 2] },
            &FlySpeed { voxels: 10.0, radians: 0.01 },
            0.5,
        );
        assert_eq!(camera.position(), DVec3::new(0.5, 0.5, -4.5));
        // A quarter turn to the right, then forward is +X.
        let quarter = std::f64::consts::FRAC_PI_2 / 0.01;
        camera.fly(
            &FlyInput { motion: [0.0, 0.0, 1.0], look: [quarter, 0.0] },
            &FlySpeed { voxels: 1.0, radians: 0.01 },
            1.0,
        );
        assert!(camera.position().abs_diff_eq(DVec3::new(1.5, 0.5, -4.5), 1e-6));
        // No further than straight up.
        camera.fly(&FlyInput { motion: [0.0; 3], look: [0.0, -1e9] }, &FlySpeed::default(), 0.0);
        assert_eq!(camera.pitch, Camera::MAX_PITCH);
    }

    #[test]
    fn field_of_view_follows_the_aspect() {
        let camera = Camera { fov: std::f64::consts::FRAC_PI_2, ..Camera::default() };
        assert!(camera.tan_half_fov(2.0).abs_diff_eq(Vec2::new(2.0, 1.0), 1e-6));
    }
}
