//! The camera of a random world: in air, before things at several distances, with some lit voxels in view.

use glam::{DVec3, Vec2};
use raxel_edit::Base;
use raxel_edit::query::{CastHit, cast};
use raxel_ray::Ray;
use raxel_ray::camera::Pinhole;
use raxel_runtime::camera::Camera;
use raxel_world::Material;

use super::draw::Draw;
use super::kinds::Draft;

/// Rays that are looked along, across and down.
const RAYS: [u32; 2] = [8, 5];
/// Cameras that are tried in a world.
const TRIES: u32 = 48;
/// Voxels beyond which nothing counts as seen.
const FAR: f64 = 600.0;
/// Nearest voxel that a camera may have before it.
const CLEAR: f64 = 2.0;
/// Smallest part of the hits that light must reach on a straight way.
const LIT: f64 = 0.15;
/// Lamps that are looked for from a hit.
const LAMPS: usize = 16;

/// Where a camera stands and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    pub position: [f64; 3],
    /// Degrees.
    pub yaw: f64,
    pub pitch: f64,
    pub fov: f64,
    /// Voxels to the voxel at the centre of the picture.
    pub depth: f64,
}

impl View {
    /// The camera as the text of the world gives it.
    pub(super) fn camera(&self) -> Camera {
        let [yaw, pitch, fov] = [self.yaw, self.pitch, self.fov].map(f64::to_radians);
        Camera { yaw, pitch, fov, ..Camera::at(self.position) }
    }
}

/// A camera; `None` if no tried camera is good enough.
pub(super) fn find(base: &dyn Base, materials: &[Material], draft: &Draft, draw: &mut Draw) -> Option<View> {
    (0..TRIES).find_map(|_| {
        let [low, high] = draw.one(&draft.stands);
        let mut position: [f64; 3] = std::array::from_fn(|axis| draw.number(low[axis], high[axis]));
        if let Some([least, most]) = draft.above {
            let from = DVec3::new(position[0], 2000.0, position[2]);
            let ground = first(base, from, DVec3::NEG_Y, 4000.0)?;
            position[1] = f64::from(ground.exact.voxel[1]) + 1.0 + draw.number(least, most);
        }
        let (yaw, pitch) = (draw.number(-180.0, 180.0), draw.number(draft.pitch[0], draft.pitch[1]));
        let view = View { position, yaw, pitch, fov: draw.number(45.0, 75.0), depth: 0.0 };
        judge(base, materials, draft, view)
    })
}

/// The view with its depth, if it is good.
fn judge(base: &dyn Base, materials: &[Material], draft: &Draft, view: View) -> Option<View> {
    let camera = view.camera();
    let aspect = 16.0 / 9.0;
    let pinhole = Pinhole {
        cell: camera.cell,
        frac: camera.frac,
        view_to_world: camera.view_to_world(),
        tan_half_fov: camera.tan_half_fov(aspect),
    };
    let mut hits = Vec::new();
    for pixel in 0..RAYS[0] * RAYS[1] {
        let ray = pinhole.ray([pixel % RAYS[0], pixel / RAYS[0]], RAYS);
        if let Some(hit) = cast(base, &ray, FAR).ok()? {
            if hit.exact.face > 5 || hit.distance < CLEAR {
                return None;
            }
            hits.push((along(&ray, hit.distance), hit));
        }
    }
    if (hits.len() as f64) < draft.solid * f64::from(RAYS[0] * RAYS[1]) {
        return None;
    }
    let mut distances: Vec<f64> = hits.iter().map(|(_, hit)| hit.distance).collect();
    distances.sort_by(f64::total_cmp);
    let faces = hits.iter().fold(0_u32, |faces, (_, hit)| faces | 1 << hit.exact.face).count_ones();
    // Not only a wall right before it.
    if distances[distances.len() / 2] < 6.0 || distances[distances.len() - 1] < 2.0 * distances[0] || faces < 2 {
        return None;
    }
    let lit = hits.iter().filter(|(point, hit)| is_lit(base, materials, draft, *point, hit)).count();
    let size = Vec2::new(RAYS[0] as f32, RAYS[1] as f32);
    let middle = pinhole.direction(size * 0.5, size);
    let depth = first(base, DVec3::from_array(view.position), middle.as_dvec3(), FAR).map_or(64.0, |hit| hit.distance);
    (lit as f64 >= LIT * hits.len() as f64).then_some(View { depth, ..view })
}

/// Whether the sun, the open sky or a lamp is seen from a hit, or it gives off light itself.
fn is_lit(base: &dyn Base, materials: &[Material], draft: &Draft, point: DVec3, hit: &CastHit) -> bool {
    let emits =
        |hit: &CastHit| materials.get(usize::from(hit.exact.material)).is_some_and(|material| material.emission > 0.0);
    if emits(hit) {
        return true;
    }
    let axis = (hit.exact.face / 2) as usize;
    let mut normal = DVec3::ZERO;
    normal[axis] = if hit.exact.face & 1 == 1 { 1.0 } else { -1.0 };
    let from = point + normal * 0.01;
    let light = draft.light;
    let sun = sun_direction(light.azimuth, light.elevation);
    if light.sun > 0.0 && sun.y > 0.0 && normal.dot(sun) > 0.0 && first(base, from, sun, FAR).is_none() {
        return true;
    }
    if light.sky > 0.0 && first(base, from, (normal + DVec3::Y * 1.01).normalize(), FAR).is_none() {
        return true;
    }
    let mut lamps: Vec<DVec3> = draft.text.lamps.iter().map(|lamp| DVec3::from_array(*lamp)).collect();
    lamps.sort_by(|a, b| a.distance_squared(from).total_cmp(&b.distance_squared(from)));
    lamps.iter().take(LAMPS).any(|lamp| {
        let way = *lamp - from;
        normal.dot(way) > 0.0 && first(base, from, way.normalize(), way.length() + 4.0).is_some_and(|hit| emits(&hit))
    })
}

/// Towards the sun, as `rx_sun_direction` has it.
fn sun_direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    DVec3::new(a.sin() * e.cos(), e.sin(), -a.cos() * e.cos())
}

fn along(ray: &Ray, distance: f64) -> DVec3 {
    let at = |axis: usize| f64::from(ray.cell[axis]) + f64::from(ray.frac[axis]);
    DVec3::new(at(0), at(1), at(2)) + DVec3::from_array(ray.dir.map(f64::from)).normalize() * distance
}

/// The first hit of a ray from a point. A chunk that is unavailable counts as air.
fn first(base: &dyn Base, from: DVec3, dir: DVec3, reach: f64) -> Option<CastHit> {
    let eye = Camera::at(from.to_array());
    let ray = Ray::new(eye.cell.to_array(), eye.frac.to_array(), dir.as_vec3().to_array());
    cast(base, &ray, reach).ok().flatten()
}
