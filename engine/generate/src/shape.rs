//! Closed forms: box, ball, cylinder, and every other form that can decide for a cube of voxels whether it is inside, outside or both.

use raxel_world::MaterialIndex;
use raxel_world::{Bounds, ChunkPos};
use raxel_world::{DenseChunk, Mode};
use raxel_world::{child_cell, child_index};

use crate::{Draft, LocalBox, local_part};

/// The relation of a cube of voxels to a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span3 {
    /// No voxel of it is in the shape.
    Outside,
    /// Every voxel of it is in the shape, and all are of one material.
    Inside,
    /// It takes a closer look.
    Both,
}

/// A form in the grid. Its tests are made in 64 bits, so that nothing overflows at the ends of the range.
pub trait Shape: Send + Sync {
    /// A box around it.
    fn bounds(&self) -> Bounds;

    /// The relation of the cube of `edge` voxels at `min` to the shape. [`Span3::Both`] is always allowed.
    fn span(&self, min: [i64; 3], edge: i64) -> Span3;

    /// Whether a voxel is in it. A shape answers here for voxels that [`Self::span`] cannot decide.
    fn contains(&self, cell: [i64; 3]) -> bool {
        self.span(cell, 1) == Span3::Inside
    }

    /// The index of the operation's material for a voxel inside the bounds (taken modulo their number).
    fn material(&self, _cell: [i64; 3]) -> usize {
        0
    }

    /// The 4³ block at `min`, bits in the order of `child_index`.
    fn mask(&self, min: [i64; 3]) -> u64 {
        (0..64).fold(0, |mask, bit| {
            let [x, y, z] = child_cell(bit).map(i64::from);
            mask | u64::from(self.contains([min[0] + x, min[1] + y, min[2] + z])) << bit
        })
    }
}

/// A shape, the effect on its voxels, and their new material.
pub struct Solid {
    /// The form.
    pub shape: Box<dyn Shape>,
    /// Add, subtract or paint.
    pub mode: Mode,
    /// One material or more (see [`Shape::material`]); unused when subtracting.
    pub materials: Vec<MaterialIndex>,
}

impl Solid {
    /// Applies it to the voxels of the chunk at a position.
    pub fn apply_to(&self, pos: ChunkPos, chunk: &mut DenseChunk) {
        self.apply(&mut Draft { pos, chunk });
    }

    pub(crate) fn apply(&self, draft: &mut Draft<'_>) {
        let Some(LocalBox { low, high }) = local_part(&self.shape.bounds(), draft.pos) else { return };
        let origin = draft.pos.origin().to_array().map(i64::from);
        for ny in low[1] >> 4..=(high[1] - 1) >> 4 {
            for nz in low[2] >> 4..=(high[2] - 1) >> 4 {
                for nx in low[0] >> 4..=(high[0] - 1) >> 4 {
                    let node = [nx, ny, nz].map(i32::cast_unsigned);
                    let min = std::array::from_fn(|i| origin[i] + i64::from(node[i]) * 16);
                    self.apply_node(draft, node, min);
                }
            }
        }
    }

    fn apply_node(&self, draft: &mut Draft<'_>, node: [u32; 3], min: [i64; 3]) {
        let first = child_index(node[0], node[1], node[2]) as usize * 64;
        let whole = self.shape.span(min, 16);
        if whole == Span3::Outside {
            return;
        }
        for child in 0..64 {
            let cell = child_cell(child).map(i64::from);
            let min = std::array::from_fn(|i| min[i] + cell[i] * 4);
            let span = if whole == Span3::Inside { whole } else { self.shape.span(min, 4) };
            let block = first + child as usize;
            match span {
                Span3::Outside => {}
                Span3::Inside => self.apply_block(draft, block, u64::MAX, min, true),
                Span3::Both => self.apply_block(draft, block, self.shape.mask(min), min, false),
            }
        }
    }

    fn apply_block(&self, draft: &mut Draft<'_>, block: usize, mask: u64, min: [i64; 3], one_material: bool) {
        let count = self.materials.len();
        if count <= 1 || self.mode == Mode::Subtract {
            draft.chunk.apply(block, mask, self.mode, self.materials.first().copied().unwrap_or_default());
        } else if one_material {
            draft.chunk.apply(block, mask, self.mode, self.materials[self.shape.material(min) % count]);
        } else {
            for bit in raxel_world::Bits(mask) {
                let [x, y, z] = child_cell(bit).map(i64::from);
                let material = self.shape.material([min[0] + x, min[1] + y, min[2] + z]);
                draft.chunk.apply(block, 1 << bit, self.mode, self.materials[material % count]);
            }
        }
    }
}

/// A box, whole or as a shell.
#[derive(Clone, Copy, Debug)]
pub struct Box3 {
    /// Its voxels.
    pub bounds: Bounds,
    /// Thickness of its walls when it is hollow.
    pub shell: Option<i64>,
}

impl Box3 {
    fn hollow(&self) -> Option<Bounds> {
        let shell = self.shell?;
        let inner = Bounds { min: self.bounds.min.map(|m| m + shell), max: self.bounds.max.map(|m| m - shell) };
        (0..3).all(|i| inner.min[i] < inner.max[i]).then_some(inner)
    }
}

/// The relation of a cube to a box.
pub(crate) fn span_of_box(bounds: &Bounds, min: [i64; 3], edge: i64) -> Span3 {
    if (0..3).any(|i| min[i] + edge <= bounds.min[i] || min[i] >= bounds.max[i]) {
        Span3::Outside
    } else if (0..3).all(|i| min[i] >= bounds.min[i] && min[i] + edge <= bounds.max[i]) {
        Span3::Inside
    } else {
        Span3::Both
    }
}

impl Shape for Box3 {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        let outer = span_of_box(&self.bounds, min, edge);
        match self.hollow().map(|inner| span_of_box(&inner, min, edge)) {
            Some(Span3::Inside) => Span3::Outside,
            Some(Span3::Both) if outer != Span3::Outside => Span3::Both,
            _ => outer,
        }
    }
}

/// A ball or ellipsoid, whole or as a shell. A voxel is in it when its centre is.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Its centre, in voxels.
    pub centre: [f64; 3],
    /// Its three half-axes, in voxels.
    pub radius: [f64; 3],
    /// Thickness of its wall when it is hollow.
    pub shell: Option<f64>,
}

impl Ball {
    /// Squared distance from the centre in half-axes, of the nearest (`far` = false) or farthest centre of a cube's voxels.
    fn distance2(&self, min: [i64; 3], edge: i64, radius: [f64; 3], far: bool) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            let low = min[i] as f64 + 0.5 - self.centre[i];
            let high = (min[i] + edge - 1) as f64 + 0.5 - self.centre[i];
            let d = if far { low.abs().max(high.abs()) } else { low.max(-high).max(0.0) };
            sum += (d / radius[i]) * (d / radius[i]);
        }
        sum
    }

    /// The half-axes of the hollow, if there is one.
    fn hollow(&self) -> Option<[f64; 3]> {
        let inner = self.radius.map(|r| r - self.shell.unwrap_or(r));
        inner.iter().all(|r| *r > 0.0).then_some(inner)
    }
}

impl Shape for Ball {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "casts of floats saturate, and bounds outside the world are refused"
    )]
    fn bounds(&self) -> Bounds {
        Bounds {
            min: std::array::from_fn(|i| (self.centre[i] - self.radius[i]).floor() as i64),
            max: std::array::from_fn(|i| (self.centre[i] + self.radius[i]).ceil() as i64),
        }
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        if self.distance2(min, edge, self.radius, false) > 1.0 {
            return Span3::Outside;
        }
        let hollow = self.hollow();
        if hollow.is_some_and(|inner| self.distance2(min, edge, inner, true) <= 1.0) {
            return Span3::Outside;
        }
        let filled = self.distance2(min, edge, self.radius, true) <= 1.0;
        let clear = hollow.is_none_or(|inner| self.distance2(min, edge, inner, false) > 1.0);
        if filled && clear { Span3::Inside } else { Span3::Both }
    }
}

/// An upright or lying cylinder, or a cone when its radii differ. A voxel is in it when its centre is.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    /// Along which axis it stands: 0 x, 1 y, 2 z.
    pub axis: usize,
    /// Centre of its base; the component along the axis is a voxel boundary.
    pub base: [f64; 3],
    /// Radius at the base, in voxels.
    pub radius: f64,
    /// Radius at the top, in voxels.
    pub top_radius: f64,
    /// Voxels from base to top.
    pub height: i64,
}

impl Cylinder {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "casts of floats saturate, and bounds outside the world are refused"
    )]
    fn foot(&self) -> i64 {
        self.base[self.axis].floor() as i64
    }

    /// Radius at the centre of the layer `above` voxels over the foot.
    fn radius_at(&self, above: i64) -> f64 {
        let t = (above as f64 + 0.5) / self.height as f64;
        self.radius + (self.top_radius - self.radius) * t
    }
}

impl Shape for Cylinder {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "casts of floats saturate, and bounds outside the world are refused"
    )]
    fn bounds(&self) -> Bounds {
        let widest = self.radius.max(self.top_radius);
        let mut bounds = Bounds {
            min: self.base.map(|b| (b - widest).floor() as i64),
            max: self.base.map(|b| (b + widest).ceil() as i64),
        };
        bounds.min[self.axis] = self.foot();
        bounds.max[self.axis] = self.foot() + self.height;
        bounds
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        let low = min[self.axis] - self.foot();
        let high = low + edge;
        if high <= 0 || low >= self.height {
            return Span3::Outside;
        }
        let (mut near, mut far) = (0.0, 0.0);
        for i in (0..3).filter(|&i| i != self.axis) {
            let a = min[i] as f64 + 0.5 - self.base[i];
            let b = (min[i] + edge - 1) as f64 + 0.5 - self.base[i];
            near += a.max(-b).max(0.0).powi(2);
            far += a.abs().max(b.abs()).powi(2);
        }
        let (first, last) = (self.radius_at(low.max(0)), self.radius_at(high.min(self.height) - 1));
        if near > first.max(last).powi(2) {
            Span3::Outside
        } else if far <= first.min(last).powi(2) && low >= 0 && high <= self.height {
            Span3::Inside
        } else {
            Span3::Both
        }
    }
}
