//! Rays and hits, as shaders have them (`shaders/include/raxel/ray.glsl`).

/// Face id of a ray that starts in a solid voxel.
pub const FACE_INSIDE: u32 = 6;

/// A ray whose `t_max` is not less has no end.
pub const FAR: f32 = 3.0e38;

/// A ray: origin `cell + frac`, any direction length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Voxel that the ray starts in.
    pub cell: [i32; 3],
    /// Place in that voxel, 0…1, both included.
    pub frac: [f32; 3],
    /// Direction.
    pub dir: [f32; 3],
    /// Hits beyond this are misses; in lengths of `dir`.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end.
    pub const fn new(cell: [i32; 3], frac: [f32; 3], dir: [f32; 3]) -> Self {
        Self { cell, frac, dir, t_max: FAR }
    }

    /// The same ray, moved by whole voxels. `None` when it leaves the range of coordinates.
    pub fn moved(self, by: [i32; 3]) -> Option<Self> {
        let [x, y, z] = [0, 1, 2].map(|i| self.cell[i].checked_add(by[i]));
        Some(Self { cell: [x?, y?, z?], ..self })
    }
}

/// A tracer's hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The voxel.
    pub voxel: [i32; 3],
    /// 0 −X, 1 +X, 2 −Y, 3 +Y, 4 −Z, 5 +Z, 6 inside.
    pub face: u32,
    /// Palette index.
    pub material: u32,
    /// In lengths of the direction.
    pub t: f32,
    /// Place on the face, 0…1, along the other two axes in the order x, y, z.
    pub uv: [f32; 2],
    /// Cells that were looked at.
    pub steps: u32,
}
