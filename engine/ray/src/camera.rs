//! The rays of `shaders/include/raxel/camera.glsl`, bit for bit.

use glam::{IVec3, Mat4, Vec2, Vec3};
use rayon::prelude::*;

use crate::ray::Ray;

/// A pinhole camera, as a graph pushes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Voxel that it is in: `camera.cell`.
    pub cell: IVec3,
    /// Place in that voxel: `camera.frac`.
    pub frac: Vec3,
    /// Rotation from view space (x right, y up, looking along −z): `camera.view_to_world`.
    pub view_to_world: Mat4,
    /// Tangents of half the field of view, horizontal and vertical: `camera.tan_half_fov`.
    pub tan_half_fov: Vec2,
}

/// `rx_inverse_root`.
fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df - (x.to_bits() >> 1));
    for _ in 0..3 {
        let square = (0.5 * x * y) * y;
        y *= 1.5 - square;
    }
    y
}

impl Pinhole {
    /// Direction, of length 1 to some ulp, through a place on an output of `size` pixels; `pixel` is in pixels from the top left.
    /// `rx_camera_direction`.
    pub fn direction(&self, pixel: Vec2, size: Vec2) -> Vec3 {
        let from_middle = Vec2::new(2.0, -2.0) * pixel + Vec2::new(-size.x, size.y);
        let view = from_middle * (self.tan_half_fov * Vec2::new(size.y, size.x));
        let columns = [0, 1, 2].map(|i| self.view_to_world.col(i).truncate());
        let dir = (columns[0] * view.x + columns[1] * view.y) - columns[2] * (size.x * size.y);
        let squares = dir * dir;
        dir * inverse_root((squares.x + squares.y) + squares.z)
    }

    /// The ray through the centre of a pixel: `rx_camera_ray`.
    pub fn ray(&self, pixel: [u32; 2], size: [u32; 2]) -> Ray {
        let [pixel, size] = [pixel, size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let dir = self.direction(pixel + 0.5, size);
        Ray::new(self.cell.to_array(), self.frac.to_array(), dir.to_array())
    }

    /// The rays of all pixels of an output, row by row from the top left.
    pub fn rays(&self, size: [u32; 2]) -> Vec<Ray> {
        let [width, height] = size;
        (0..width * height).into_par_iter().map(|i| self.ray([i % width, i / width], size)).collect()
    }
}

/// 8 × 8 pixels of a picture, for one beam (`shaders/include/raxel/beam.glsl`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile {
    /// Who looks.
    pub camera: Pinhole,
    /// Extent of the picture in pixels.
    pub size: [u32; 2],
    /// Its first pixel, from the top left; a multiple of 8.
    pub first: [u32; 2],
}

impl Tile {
    /// Pixels along each side.
    pub const SIDE: u32 = 8;
    /// Rays of a tile.
    pub const RAYS: usize = (Self::SIDE * Self::SIDE) as usize;

    /// The rays through the centres of the pixels, row by row.
    pub fn rays(&self) -> impl Iterator<Item = Ray> {
        let Self { camera, size, first: [x, y] } = *self;
        (0..Self::SIDE * Self::SIDE).map(move |i| camera.ray([x + i % Self::SIDE, y + i / Self::SIDE], size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_length_one_and_the_right_angle() {
        let turn = Mat4::from_rotation_y(0.7) * Mat4::from_rotation_x(-0.4);
        let tan_half_fov = Vec2::new(0.8, 0.45);
        let camera = Pinhole { cell: IVec3::ZERO, frac: Vec3::splat(0.5), view_to_world: turn, tan_half_fov };
        for pixel in [[0, 0], [1, 7], [959, 0], [480, 269], [13, 539], [959, 539]] {
            let dir = Vec3::from_array(camera.ray(pixel, [960, 540]).dir);
            assert!((dir.length() - 1.0).abs() < 4e-7, "{}", dir.length());
            let ndc = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) / Vec2::new(480.0, -270.0);
            let view = (ndc + Vec2::new(-1.0, 1.0)) * tan_half_fov;
            let expected = turn.transform_vector3(view.extend(-1.0)).normalize();
            assert!(dir.abs_diff_eq(expected, 5e-7), "{dir} {expected}");
        }
        let rays = camera.rays([6, 4]);
        assert_eq!((rays.len(), rays[6 * 3 + 2]), (24, camera.ray([2, 3], [6, 4])));
    }
}
