//! Ball and cylinder in integers: a voxel is in one when its centre is, decided without rounding.

use raxel_generate::{Shape, Span3};
use raxel_world::Bounds;

use crate::operation::UNIT;

/// A distance that is farther than any radius; beyond it, squares would no longer fit.
const FAR: i64 = 1 << 30;

/// From a position to the centre of a voxel, in 1/256 voxel.
fn offset(cell: i64, from: i64) -> i64 {
    (cell * UNIT + UNIT / 2 - from).clamp(-FAR, FAR)
}

/// Squared distance from a position to the nearest and to the farthest centre of `edge` voxels in a row, along one axis.
fn near_far(first: i64, edge: i64, from: i64) -> [i64; 2] {
    let (low, high) = (offset(first, from), offset(first + edge - 1, from));
    let near = low.max(-high).max(0);
    let far = low.abs().max(high.abs());
    [near * near, far * far]
}

/// The first voxel that may be within a radius of a position, and one past the last.
fn reach(position: i64, radius: u32) -> [i64; 2] {
    let radius = i64::from(radius);
    [(position - radius).div_euclid(UNIT), (position + radius).div_euclid(UNIT) + 1]
}

/// The voxels whose centres are in a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// In 1/256 voxel.
    pub(crate) center: [i64; 3],
    /// In 1/256 voxel.
    pub(crate) radius: u32,
}

impl Shape for Ball {
    fn bounds(&self) -> Bounds {
        let ends = self.center.map(|c| reach(c, self.radius));
        Bounds { min: ends.map(|end| end[0]), max: ends.map(|end| end[1]) }
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        let radius2 = i64::from(self.radius) * i64::from(self.radius);
        let [near, far] = (0..3).fold([0; 2], |[near, far], i| {
            let [n, f] = near_far(min[i], edge, self.center[i]);
            [near + n, far + f]
        });
        if near > radius2 {
            Span3::Outside
        } else if far <= radius2 {
            Span3::Inside
        } else {
            Span3::Both
        }
    }
}

/// The voxels whose centres are in a cylinder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pillar {
    /// 0 x, 1 y, 2 z.
    pub(crate) axis: usize,
    /// Centre of its base, in 1/256 voxel.
    pub(crate) base: [i64; 3],
    /// In 1/256 voxel.
    pub(crate) radius: u32,
    /// In voxels.
    pub(crate) height: u32,
}

impl Pillar {
    fn layers(&self) -> [i64; 2] {
        let foot = self.base[self.axis].div_euclid(UNIT);
        [foot, foot + i64::from(self.height)]
    }
}

impl Shape for Pillar {
    fn bounds(&self) -> Bounds {
        let ends: [[i64; 2]; 3] =
            std::array::from_fn(|i| if i == self.axis { self.layers() } else { reach(self.base[i], self.radius) });
        Bounds { min: ends.map(|end| end[0]), max: ends.map(|end| end[1]) }
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        let [foot, top] = self.layers();
        let (low, high) = (min[self.axis], min[self.axis] + edge);
        let radius2 = i64::from(self.radius) * i64::from(self.radius);
        let [near, far] = (0..3).filter(|&i| i != self.axis).fold([0; 2], |[near, far], i| {
            let [n, f] = near_far(min[i], edge, self.base[i]);
            [near + n, far + f]
        });
        if near > radius2 || high <= foot || low >= top {
            Span3::Outside
        } else if far <= radius2 && low >= foot && high <= top {
            Span3::Inside
        } else {
            Span3::Both
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_agree_with_their_voxels() {
        let ball = Ball { center: [300, -700, 128], radius: 2000 };
        let pillar = Pillar { axis: 2, base: [0, 128, -900], radius: 1500, height: 9 };
        let shapes: [&dyn Shape; 2] = [&ball, &pillar];
        for shape in shapes {
            let bounds = shape.bounds();
            let mut inside = 0;
            for edge in [1, 4, 16] {
                for x in (-32..32).step_by(edge) {
                    for y in (-32..32).step_by(edge) {
                        for z in (-32..32).step_by(edge) {
                            let min = [x, y, z];
                            let all: Vec<bool> = (0..edge.pow(3))
                                .map(|i| [i % edge, i / edge % edge, i / edge / edge].map(|i| i as i64))
                                .map(|[i, j, k]| shape.contains([x + i, y + j, z + k]))
                                .collect();
                            match shape.span(min, edge as i64) {
                                Span3::Inside => assert!(all.iter().all(|is| *is)),
                                Span3::Outside => assert!(all.iter().all(|is| !is)),
                                Span3::Both => {}
                            }
                            if edge == 1 && all[0] {
                                inside += 1;
                                assert!((0..3).all(|i| (bounds.min[i]..bounds.max[i]).contains(&min[i])));
                            }
                        }
                    }
                }
            }
            assert!(inside > 900, "{inside}");
        }
    }
}
