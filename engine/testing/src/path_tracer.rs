//! A second opinion on light: a path tracer in `f64` that `graphs/light/reference.toml` is held against.
//!
//! It shares only the voxels and the exact ray caster with the rest: its sampling is different. Directions come from a point on a unit sphere that
//! touches the surface, not from a disc; the disc of the sun has a frame of its own; lamps are found by the rays that meet them, and never
//! looked for; numbers are random and follow no sequence. The scene must be the same: matt surfaces, the sun as an even disc, the sky's
//! formula and the emission of lamps, as `docs/light/judge.md` defines them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use raxel_oracle::{FACE_INSIDE, Lattice, Oracle, Ray};
use raxel_world::Material;
use raxel_world::random::{SplitMix64, mix};
use rayon::prelude::*;

/// Half of the angle under which the sun's disc is seen, degrees.
const SUN_HALF_ANGLE: f64 = 0.267;
/// Surfaces that a path reaches before chance may end it.
const SURE: u32 = 4;

/// The light of a world besides its lamps: the params of `graphs/light/base/light.toml`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Degrees from −z towards +x.
    pub sun_azimuth: f64,
    /// Degrees above the horizon.
    pub sun_elevation: f64,
    /// Irradiance of the sun over π, in multiples of its colour.
    pub sun_strength: f64,
    /// Multiplies the sky.
    pub sky_strength: f64,
    /// Multiplies the emission of lamps.
    pub lamp_strength: f64,
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Voxel that it is in.
    pub cell: [i32; 3],
    /// Place in that voxel.
    pub frac: [f32; 3],
    /// To the right, up, and against the direction of view; unit vectors in world space.
    pub axes: [DVec3; 3],
    /// Tangents of half the field of view, horizontal and vertical.
    pub tan_half_fov: [f64; 2],
}

/// Light of a pixel, averaged over its area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Radiance: red, green, blue.
    pub mean: [f64; 3],
    /// Variance of that mean.
    pub variance: [f64; 3],
}

/// Light in one world.
pub struct PathTracer<'a> {
    oracle: &'a Oracle<'a>,
    light: Light,
    sun: DVec3,
    /// Irradiance on a plane that faces the sun.
    irradiance: DVec3,
}

impl<'a> PathTracer<'a> {
    /// Prepares the light of a world.
    pub fn new(oracle: &'a Oracle<'a>, light: Light) -> Self {
        let (azimuth, elevation) = (light.sun_azimuth.to_radians(), light.sun_elevation.to_radians());
        let sun = DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos());
        Self { oracle, light, sun, irradiance: light.sun_strength * PI * sun_color(sun.y) }
    }

    /// A picture, row by row from the top: `paths` for each pixel, at least 2, each through a random place of its area.
    pub fn picture(&self, view: &View, [width, height]: [u32; 2], paths: u32, seed: u64) -> Vec<Estimate> {
        let pixel = |pixel: u32| {
            let mut random = SplitMix64::new(mix(seed ^ mix(u64::from(pixel))));
            let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
            for _ in 0..paths {
                let x = (f64::from(pixel % width) + uniform(&mut random)) / f64::from(width) * 2.0 - 1.0;
                let y = 1.0 - (f64::from(pixel / width) + uniform(&mut random)) / f64::from(height) * 2.0;
                let [right, up, back] = view.axes;
                let dir = x * view.tan_half_fov[0] * right + y * view.tan_half_fov[1] * up - back;
                let light = self.radiance(view.cell, view.frac, dir.normalize(), &mut random);
                sum += light;
                squares += light * light;
            }
            let n = f64::from(paths);
            let mean = sum / n;
            let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
            Estimate { mean: mean.to_array(), variance: variance.to_array() }
        };
        (0..width * height).into_par_iter().map(pixel).collect()
    }

    /// The light along one path.
    fn radiance(&self, cell: [i32; 3], frac: [f32; 3], dir: DVec3, random: &mut SplitMix64) -> DVec3 {
        let (mut light, mut share) = (DVec3::ZERO, DVec3::ONE);
        let (mut cell, mut frac, mut dir) = (cell, frac, dir);
        for surfaces in 1.. {
            let Some(at) = self.first_hit(cell, frac, dir) else {
                return light + share * self.light.sky_strength * sky(dir, self.sun);
            };
            let albedo = DVec3::from_array(at.material.albedo.map(f64::from));
            light += share * albedo * (self.light.lamp_strength * f64::from(at.material.emission));
            if at.face == FACE_INSIDE {
                break;
            }
            share *= albedo;

            let normal = normal(at.face);
            (cell, frac) = outside(&at);
            let to_sun = self.sun_point(random);
            let irradiance = self.irradiance * normal.dot(to_sun).max(0.0);
            if irradiance != DVec3::ZERO && self.first_hit(cell, frac, to_sun).is_none() {
                light += share * irradiance / PI;
            }

            if surfaces >= SURE {
                let live = share.max_element().min(0.9);
                if uniform(random) >= live {
                    break;
                }
                share /= live;
            }
            dir = cosine_direction(normal, random);
        }
        light
    }

    fn first_hit(&self, cell: [i32; 3], frac: [f32; 3], dir: DVec3) -> Option<Place<'a>> {
        let ray = Ray::new(cell, frac, dir.as_vec3().to_array());
        let (hit, lattice) = self.oracle.first_hit(&ray).hit.zip(Lattice::of(&ray))?;
        let material = &self.oracle.world().materials()[usize::from(hit.material)];
        Some(Place { voxel: hit.voxel, face: hit.face, uv: hit.uv(&ray, &lattice), material })
    }

    /// A direction to a point of the sun's disc, all parts of its solid angle being equally likely.
    fn sun_point(&self, random: &mut SplitMix64) -> DVec3 {
        let across = self.sun.any_orthonormal_vector();
        let beside = self.sun.cross(across);
        let cosine = 1.0 - uniform(random) * (1.0 - SUN_HALF_ANGLE.to_radians().cos());
        let (sine, turn) = ((1.0 - cosine * cosine).sqrt(), TAU * uniform(random));
        cosine * self.sun + sine * (turn.cos() * across + turn.sin() * beside)
    }
}

/// Where a ray has met a surface.
struct Place<'a> {
    voxel: [i32; 3],
    face: u32,
    uv: [f64; 2],
    material: &'a Material,
}

fn normal(face: u32) -> DVec3 {
    let mut normal = DVec3::ZERO;
    normal[(face / 2) as usize] = if face % 2 == 1 { 1.0 } else { -1.0 };
    normal
}

/// The same place, in the cell before the face.
#[expect(clippy::cast_possible_truncation, reason = "a place is a 32-bit float in 0…1")]
fn outside(at: &Place<'_>) -> ([i32; 3], [f32; 3]) {
    let axis = (at.face / 2) as usize;
    let (mut cell, mut frac) = (at.voxel, [0.0; 3]);
    cell[axis] = cell[axis].wrapping_add(if at.face % 2 == 1 { 1 } else { -1 });
    frac[axis] = if at.face % 2 == 1 { 0.0 } else { 1.0 };
    for (other, place) in (0..3).filter(|other| *other != axis).zip(at.uv) {
        frac[other] = place.clamp(0.0, 1.0) as f32;
    }
    (cell, frac)
}

/// In [0, 1).
fn uniform(random: &mut SplitMix64) -> f64 {
    (random.bits() >> 11) as f64 * (-53f64).exp2()
}

/// A direction with the density cosine / π: from the surface to a random point of the unit sphere that rests on it.
fn cosine_direction(normal: DVec3, random: &mut SplitMix64) -> DVec3 {
    loop {
        let z = 2.0 * uniform(random) - 1.0;
        let (turn, r) = (TAU * uniform(random), (1.0 - z * z).sqrt());
        let to = normal + DVec3::new(r * turn.cos(), r * turn.sin(), z);
        // The point where the sphere touches the surface has no direction.
        if to.length_squared() > 1e-12 {
            return to.normalize();
        }
    }
}

fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Colour of a sun whose direction has this height. The formula of `rx_sun_color`.
fn sun_color(height: f64) -> DVec3 {
    let high = smoothstep(0.02, 0.5, height.clamp(0.0, 1.0));
    let color = DVec3::new(1.0, 0.45, 0.16).lerp(DVec3::new(1.0, 0.93, 0.8), high);
    color * smoothstep(-0.04, 0.06, height)
}

/// Radiance of the sky for a strength of 1, without the disc. The formula of `rx_sky`.
fn sky(dir: DVec3, sun: DVec3) -> DVec3 {
    let day = smoothstep(-0.12, 0.25, sun.y);
    let zenith = DVec3::new(0.010, 0.014, 0.035).lerp(DVec3::new(0.085, 0.235, 0.60), day);
    let horizon = DVec3::new(0.035, 0.035, 0.060).lerp(DVec3::new(0.56, 0.71, 0.90), day);
    let low = (1.0 - smoothstep(0.0, 0.55, sun.y.abs())) * day;
    let towards = 0.5 + 0.5 * dir.dot(sun);
    let horizon = horizon.lerp(DVec3::new(0.98, 0.56, 0.27), low * towards * towards * 0.8);
    let above = horizon.lerp(zenith, 1.0 - (-3.2 * dir.y.max(0.0)).exp());
    let below = 1.0 - smoothstep(-0.35, 0.0, dir.y);
    let glow = dir.dot(sun).max(0.0);
    above.lerp(horizon * 0.72, below) + sun_color(sun.y) * (0.10 * glow.powi(12) + 0.22 * glow.powi(90))
}

#[cfg(test)]
mod tests {
    use glam::IVec3;
    use raxel_world::World;

    use super::*;

    const DARK: Light =
        Light { sun_azimuth: 0.0, sun_elevation: 90.0, sun_strength: 0.0, sky_strength: 0.0, lamp_strength: 1.0 };

    /// From (4.5, 4.5, 4.5) downwards.
    fn down() -> View {
        View { cell: [4; 3], frac: [0.5; 3], axes: [DVec3::X, -DVec3::Z, DVec3::Y], tan_half_fov: [0.2, 0.2] }
    }

    fn world(material: Material, voxels: impl Fn(IVec3) -> bool) -> World {
        let side = -1..10;
        let all = side.clone().flat_map(|x| {
            let side = side.clone();
            side.clone().flat_map(move |y| side.clone().map(move |z| IVec3::new(x, y, z)))
        });
        World::from_voxels(vec![Material::air(), material], all.filter(|voxel| voxels(*voxel)).map(|voxel| (voxel, 1)))
    }

    /// The mean over a picture with its standard error.
    fn mean(estimates: &[Estimate], channel: usize) -> [f64; 2] {
        let n = estimates.len() as f64;
        let variance = estimates.iter().map(|pixel| pixel.variance[channel]).sum::<f64>();
        [estimates.iter().map(|pixel| pixel.mean[channel]).sum::<f64>() / n, variance.sqrt() / n]
    }

    #[test]
    fn a_furnace_glows_as_bright_as_all_its_bounces() {
        let wall = Material { emission: 2.0, ..Material::matt("wall", [0.5, 0.25, 0.75]) };
        let world = world(wall, |voxel| voxel.min_element() < 0 || voxel.max_element() > 8);
        let oracle = Oracle::new(&world);
        let picture = PathTracer::new(&oracle, DARK).picture(&down(), [16, 8], 400, 1);
        for (channel, albedo) in [0.5, 0.25, 0.75].into_iter().enumerate() {
            let truth = albedo * 2.0 / (1.0 - albedo);
            let [mean, se] = mean(&picture, channel);
            assert!(se < 0.005 * truth && (mean - truth).abs() < 4.5 * se, "{mean} ± {se} is not {truth}");
        }
    }

    #[test]
    fn an_open_floor_sends_back_what_falls_on_it() {
        let world = world(Material::matt("floor", [0.5; 3]), |voxel| voxel.y == 0);
        let oracle = Oracle::new(&world);
        let sun = Light { sun_strength: 2.0, ..DARK };
        for pixel in PathTracer::new(&oracle, sun).picture(&down(), [4, 4], 8, 1) {
            for (mean, color) in pixel.mean.into_iter().zip([1.0, 0.93, 0.8]) {
                assert!((mean - 0.5 * 2.0 * color).abs() < 1e-4, "{pixel:?}");
            }
        }
    }

    #[test]
    fn directions_follow_the_cosine() {
        let mut random = SplitMix64::new(5);
        let count = 40_000;
        let (mut first, mut second) = (0.0, 0.0);
        for _ in 0..count {
            let cosine = cosine_direction(-DVec3::Z, &mut random).dot(-DVec3::Z);
            assert!(cosine > 0.0);
            first += cosine;
            second += cosine * cosine;
        }
        // The mean of a cosine-weighted cosine is 2/3, that of its square 1/2; standard errors are 0.0012 and 0.0015.
        let [first, second] = [first, second].map(|sum| sum / f64::from(count));
        assert!((first - 2.0 / 3.0).abs() < 0.006 && (second - 0.5).abs() < 0.0075, "{first} {second}");
    }
}
