//! The outline of the voxels that a press of the brush would reach, over the picture.

use glam::{DVec2, DVec3};
use raxel_edit::{Operation, UNIT};
use raxel_runtime::camera::Camera;

/// Segments of a circle.
const ARC: usize = 48;

/// Segments of the outline of an edit in pixels of the window, from the top left. The part beside the camera or behind it is left out.
pub(super) fn outline(edit: &Operation, camera: &Camera, window: [u32; 2]) -> Vec<[[f32; 2]; 2]> {
    let lines = lines(edit);
    let pairs = lines.iter().flat_map(|line| line.windows(2));
    pairs.filter_map(|pair| Some([project(pair[0], camera, window)?, project(pair[1], camera, window)?])).collect()
}

/// Lines through points in voxels.
fn lines(edit: &Operation) -> Vec<Vec<DVec3>> {
    let voxels = |fixed: [i64; 3]| DVec3::from_array(fixed.map(|c| c as f64 / UNIT as f64));
    match edit {
        Operation::Set { cell, .. } => {
            let low = DVec3::from_array(cell.map(f64::from));
            prism(&square(low, low + DVec3::ONE), DVec3::Y, 1)
        }
        Operation::Box { bounds, .. } => {
            let [low, high] = [bounds.min, bounds.max].map(|corner| DVec3::from_array(corner.map(|c| c as f64)));
            prism(&square(low, high), DVec3::Y * (high.y - low.y), 1)
        }
        Operation::Sphere { center, radius, .. } => {
            let radius = f64::from(*radius) / UNIT as f64;
            (0..3).map(|axis| circle(voxels(*center), radius, axis)).collect()
        }
        Operation::Cylinder { axis, base, radius, height, .. } => {
            let axis = usize::from(*axis).min(2);
            let base = circle(voxels(*base), f64::from(*radius) / UNIT as f64, axis);
            prism(&base, DVec3::AXES[axis] * f64::from(*height), ARC / 4)
        }
        _ => Vec::new(),
    }
}

/// The base of a box, closed.
fn square(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let corner = |x, z| DVec3::new(x, low.y, z);
    vec![
        corner(low.x, low.z),
        corner(high.x, low.z),
        corner(high.x, high.z),
        corner(low.x, high.z),
        corner(low.x, low.z),
    ]
}

/// A circle about an axis, closed.
fn circle(center: DVec3, radius: f64, axis: usize) -> Vec<DVec3> {
    let (u, v) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
    let at = |step: usize| {
        let (sin, cos) = (step as f64 / ARC as f64 * std::f64::consts::TAU).sin_cos();
        center + (u * cos + v * sin) * radius
    };
    (0..=ARC).map(at).collect()
}

/// A base, the same moved, and lines between them from every `every`-th point of the base.
fn prism(base: &[DVec3], up: DVec3, every: usize) -> Vec<Vec<DVec3>> {
    let top: Vec<DVec3> = base.iter().map(|point| *point + up).collect();
    let sides: Vec<Vec<DVec3>> = base.iter().zip(&top).skip(1).step_by(every).map(|(a, b)| vec![*a, *b]).collect();
    [base.to_vec(), top].into_iter().chain(sides).collect()
}

/// The pixel of a point in voxels.
fn project(point: DVec3, camera: &Camera, [width, height]: [u32; 2]) -> Option<[f32; 2]> {
    let extent = DVec2::new(f64::from(width), f64::from(height));
    let seen = camera.rotation().transpose() * (point - camera.position());
    let depth = -seen.z;
    if depth < 0.05 {
        return None;
    }
    let tan = camera.tan_half_fov(extent.x / extent.y).as_dvec2();
    let at = DVec2::new(0.5 + 0.5 * seen.x / (depth * tan.x), 0.5 - 0.5 * seen.y / (depth * tan.y)) * extent;
    Some(at.as_vec2().to_array())
}

#[cfg(test)]
mod tests {
    use raxel_edit::Brush;

    use super::*;

    #[test]
    fn a_ball_ahead_is_a_circle_in_the_middle() {
        // It looks along -Z, half of its field of view is 30 degrees, and the ball is 10 voxels away.
        let camera = Camera::at([0.0; 3]);
        let ball = Operation::sphere([0.0, 0.0, -10.0], 1.0, Brush::Subtract);
        let segments = outline(&ball, &camera, [640, 360]);
        assert_eq!(segments.len(), 3 * ARC);
        let points = || segments.iter().flatten();
        let expected = 180.0 * (1.0 / 10.0) / 30.0_f32.to_radians().tan();
        let top = points().map(|[_, y]| *y).fold(f32::INFINITY, f32::min);
        let left = points().map(|[x, _]| *x).fold(f32::INFINITY, f32::min);
        assert!(
            (180.0 - top - expected).abs() < 1.0 && (320.0 - left - expected).abs() < 1.0,
            "{left} {top} {expected}"
        );
        // Behind the camera nothing is seen.
        assert!(outline(&Operation::sphere([0.0, 0.0, 10.0], 1.0, Brush::Subtract), &camera, [640, 360]).is_empty());
    }

    #[test]
    #[allow(clippy::float_cmp, reason = "these values are exact")]
    fn boxes_have_twelve_edges_and_cylinders_stand_on_their_base() {
        let camera = Camera::at([0.5, 0.5, 20.0]);
        assert_eq!(outline(&Operation::set([0; 3], 1), &camera, [100, 100]).len(), 12);
        let post = Operation::Cylinder { axis: 1, base: [128, 0, 128], radius: 256, height: 4, brush: Brush::Subtract };
        let heights: Vec<f64> = lines(&post).iter().flatten().map(|point| point.y).collect();
        assert!(heights.iter().all(|y| *y == 0.0 || *y == 4.0));
        assert_eq!(outline(&post, &camera, [100, 100]).len(), 2 * ARC + 4);
    }
}
