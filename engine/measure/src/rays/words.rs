//! Rays and hits as the shader `trace_rays.comp` has them: 48 bytes each.

use bytemuck::{Pod, Zeroable};
use raxel_oracle::camera::Tile;
use raxel_oracle::metrics::Outcome;
use raxel_oracle::period::PeriodRay;
use raxel_oracle::{Hit, Ray};

/// A ray on its way to the device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RayWords {
    cell: [i32; 3],
    t_max: f32,
    frac: [f32; 3],
    t_free: f32,
    dir: [f32; 4],
}

/// Work for a device: a ray, or a tile of them.
pub trait Work: Sync {
    /// Lines that it takes up in the list of rays.
    const LINES: usize;
    /// Rays that are traced for it. Each has a hit.
    const RAYS: usize;

    /// Writes its [`Work::LINES`] lines.
    fn write(&self, lines: &mut [RayWords]);
}

impl Work for Ray {
    const LINES: usize = 1;
    const RAYS: usize = 1;

    fn write(&self, lines: &mut [RayWords]) {
        lines[0] = self.into();
    }
}

impl Work for RayWords {
    const LINES: usize = 1;
    const RAYS: usize = 1;

    fn write(&self, lines: &mut [RayWords]) {
        lines[0] = *self;
    }
}

/// A period ray, for the marchers `period` and `refill`: the octant in the place of `t_max`, `first` in that of the fraction.
impl Work for PeriodRay {
    const LINES: usize = 1;
    const RAYS: usize = 1;

    fn write(&self, lines: &mut [RayWords]) {
        let ([fx, fy, fz], [x, y, z]) = (self.first, self.period);
        // Whole numbers of at most 24 bits.
        let whole = |number: u32| number as f32;
        lines[0] = RayWords {
            cell: self.cell,
            t_max: f32::from_bits(self.octant),
            frac: [fx, fy, fz].map(whole),
            t_free: 0.0,
            dir: [x, y, z, 0].map(whole),
        };
    }
}

/// A tile of pixels, for the marchers `beam` and `packet`: five lines that hold its camera.
impl Work for Tile {
    const LINES: usize = 5;
    const RAYS: usize = Tile::RAYS;

    fn write(&self, lines: &mut [RayWords]) {
        let Tile { camera, size, first } = self;
        lines.fill(RayWords::zeroed());
        (lines[0].cell, lines[0].frac) = (camera.cell.to_array(), camera.frac.to_array());
        for (line, column) in lines[1..4].iter_mut().zip(camera.view_to_world.to_cols_array_2d()) {
            line.dir = column;
        }
        let [width, height] = size.map(u32::cast_signed);
        lines[4].cell = [width, height, 0];
        lines[4].frac = [camera.tan_half_fov.x, camera.tan_half_fov.y, 0.0];
        // Whole numbers in the bits of floats.
        lines[4].dir = [f32::from_bits(first[0]), f32::from_bits(first[1]), 0.0, 0.0];
    }
}

/// A ray that goes on from a hit, for the marchers `onward` and `instances_onward`. The shader makes its start from the hit, and its direction from `dir`
/// and the face ([`bounced`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnwardRay {
    /// The voxel that was hit: of the world, or counted from the anchor of a model that is not on the lattice of the world.
    pub voxel: [i32; 3],
    /// Its face.
    pub face: u32,
    /// Its material, which the shader of `onward` looks up again after it has traced.
    pub material: u32,
    /// Place on the face.
    pub uv: [f32; 2],
    /// Direction before it bounces.
    pub dir: [f32; 3],
    /// The instance that was hit, if one was, and whether it is off the lattice of the world.
    pub instance: Option<(u32, bool)>,
}

/// A direction after it has bounced off a face: turned around along the normal, and its components along the two tangents exchanged.
pub fn bounced(dir: [f32; 3], face: u32) -> [f32; 3] {
    let [x, y, z] = dir;
    match face / 2 {
        0 => [-x, z, y],
        1 => [z, -y, x],
        2 => [y, x, -z],
        // Inside of a voxel, the tangents are x and z, and there is no normal.
        _ => [z, 0.0, x],
    }
}

impl Work for OnwardRay {
    const LINES: usize = 1;
    const RAYS: usize = 1;

    fn write(&self, lines: &mut [RayWords]) {
        let ([u, v], [x, y, z]) = (self.uv, self.dir);
        let (instance, free) = self.instance.unwrap_or((u32::MAX, false));
        // Whole numbers in the bits of floats.
        lines[0] = RayWords {
            cell: self.voxel,
            t_max: f32::from_bits(self.face | u32::from(free) << 8),
            frac: [u, v, 0.0],
            t_free: f32::from_bits(instance),
            dir: [x, y, z, f32::from_bits(self.material)],
        };
    }
}

/// A voxel that a shader sets, for the marcher `store`. The answer, whether it was set, has the form of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelEdit {
    /// The voxel.
    pub cell: [i32; 3],
    /// Its new material; 0 takes it away.
    pub material: u16,
}

impl Work for VoxelEdit {
    const LINES: usize = 1;
    const RAYS: usize = 1;

    fn write(&self, lines: &mut [RayWords]) {
        let t_max = f32::from_bits(u32::from(self.material));
        lines[0] = RayWords { cell: self.cell, t_max, ..RayWords::zeroed() };
    }
}

impl From<&Ray> for RayWords {
    fn from(ray: &Ray) -> Self {
        let [x, y, z] = ray.dir;
        Self { cell: ray.cell, t_max: ray.t_max, frac: ray.frac, t_free: 0.0, dir: [x, y, z, 0.0] }
    }
}

impl RayWords {
    /// The ray, which is known to pass only air up to a time, in lengths of its direction. The marcher `ahead` begins there.
    pub fn ahead(ray: &Ray, t_free: f32) -> Self {
        Self { t_free, ..Self::from(ray) }
    }
}

/// The outcome of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It hits nothing.
    Miss,
    /// It hits a voxel.
    Hit,
    /// The tracer gave up: it looked at more cells than there can be on a line.
    Hang,
    /// The device wrote nothing, or nonsense, where the hit should be.
    Unwritten,
}

/// The device's words about a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct HitWords {
    /// The voxel.
    pub voxel: [i32; 3],
    state: u32,
    /// 0 −X, 1 +X, 2 −Y, 3 +Y, 4 −Z, 5 +Z, 6 inside.
    pub face: u32,
    /// Palette index, from `rx_trace`.
    pub material: u32,
    /// Palette index of the voxel, from `rx_material`; of the marcher `instances` the voxel in its model, ten bits of each coordinate.
    pub looked_up: u32,
    /// In lengths of the direction.
    pub t: f32,
    /// Place on the face.
    pub uv: [f32; 2],
    /// Cells that were looked at.
    pub steps: u32,
    /// Of the marcher `instances`: the instance (16 bits, all of them for the world), its face << 16, whether it is free << 24.
    pub instance: u32,
}

impl HitWords {
    /// The words of a slot before each dispatch: no tracer writes this.
    pub(super) const POISON: u32 = 0xcdcd_cdcd;

    /// The outcome of the ray.
    pub fn state(&self) -> State {
        match self.state {
            0 => State::Miss,
            1 => State::Hit,
            2 => State::Hang,
            _ => State::Unwritten,
        }
    }

    /// The hit, if there is one.
    pub fn hit(&self) -> Option<Hit> {
        let Self { voxel, face, material, t, uv, steps, .. } = *self;
        (self.state() == State::Hit).then_some(Hit { voxel, face, material, t, uv, steps })
    }

    /// The outcome to judge; `hit` is that of [`HitWords::hit`].
    pub fn outcome<'h>(&self, hit: Option<&'h Hit>) -> Outcome<'h> {
        match (self.state(), hit) {
            (State::Hit, Some(hit)) => Outcome::Hit(hit),
            (State::Hang, _) => Outcome::Hang,
            (State::Unwritten, _) => Outcome::Unwritten,
            (State::Hit | State::Miss, _) => Outcome::Miss,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_shader_wrote_is_seen() {
        let words: HitWords = bytemuck::cast([HitWords::POISON; 12]);
        assert_eq!((words.state(), words.hit(), words.outcome(None)), (State::Unwritten, None, Outcome::Unwritten));
        let written: HitWords = bytemuck::cast([0u32; 12]);
        assert_eq!(written.outcome(None), Outcome::Miss);
    }
}
