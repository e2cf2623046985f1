//! The Menger sponge: a cube without the centre of each face and without its own centre, at every scale.

use raxel_world::Bounds;

use crate::shape::{Shape, Span3, span_of_box};

/// A sponge of 3^level voxels along an edge.
pub struct Menger {
    origin: [i64; 3],
    level: u32,
    /// For every coordinate: bit k is set when its k-th ternary digit, the coarsest first, is 1.
    middles: Vec<u32>,
}

impl Menger {
    /// At most this many levels: 531 441 voxels along an edge.
    pub const MAX_LEVEL: u32 = 12;

    /// With its smallest corner at `origin`.
    pub fn new(origin: [i64; 3], level: u32) -> Self {
        let level = level.min(Self::MAX_LEVEL);
        let middles = (0..3u32.pow(level))
            .map(|coordinate| {
                let digit = |k: u32| coordinate / 3u32.pow(level - 1 - k) % 3;
                (0..level).fold(0, |bits, k| bits | u32::from(digit(k) == 1) << k)
            })
            .collect();
        Self { origin, level, middles }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the caller has found the cell inside the bounds"
    )]
    fn middles_of(&self, cell: [i64; 3]) -> [u32; 3] {
        std::array::from_fn(|i| self.middles[(cell[i] - self.origin[i]) as usize])
    }
}

impl Shape for Menger {
    fn bounds(&self) -> Bounds {
        let edge = 3i64.pow(self.level);
        Bounds { min: self.origin, max: self.origin.map(|o| o + edge) }
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        let bounds = self.bounds();
        if span_of_box(&bounds, min, edge) == Span3::Outside {
            return Span3::Outside;
        }
        // A cube within one cell of a coarse level shares that level's digits; where two of them are 1 there is nothing.
        let max: [i64; 3] = std::array::from_fn(|i| (min[i] + edge - 1).min(bounds.max[i] - 1));
        let min: [i64; 3] = std::array::from_fn(|i| min[i].max(bounds.min[i]));
        let mut cell_edge = 3i64.pow(self.level);
        for k in 0..self.level {
            cell_edge /= 3;
            if (0..3).any(|i| (min[i] - self.origin[i]) / cell_edge != (max[i] - self.origin[i]) / cell_edge) {
                break;
            }
            let [x, y, z] = self.middles_of(min).map(|bits| bits >> k & 1);
            if x + y + z >= 2 {
                return Span3::Outside;
            }
        }
        Span3::Both
    }

    fn contains(&self, cell: [i64; 3]) -> bool {
        if span_of_box(&self.bounds(), cell, 1) == Span3::Outside {
            return false;
        }
        let [x, y, z] = self.middles_of(cell);
        x & y | y & z | z & x == 0
    }

    /// The coarsest level whose edge bars the voxel belongs to; the last level for corners all the way down.
    fn material(&self, cell: [i64; 3]) -> usize {
        let [x, y, z] = self.middles_of(cell);
        (x | y | z).trailing_zeros().min(self.level.saturating_sub(1)) as usize
    }
}
