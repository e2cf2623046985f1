//! Boxes and places, as cells and fractions.
#![expect(
    clippy::cast_possible_truncation,
    reason = "rays are made of cells of 32 bits, clamped or wrapped as the name says, and of 32-bit floats"
)]

use super::{Box3, Random, RayTargets};

/// A cell in the range of coordinates.
pub(super) fn clamped(cell: [i64; 3]) -> [i32; 3] {
    cell.map(|c| c.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// The cell that 32 bits make of one: beyond an end of the coordinates it comes back at the other end.
pub(super) fn wrapped(cell: [i64; 3]) -> [i32; 3] {
    cell.map(|c| c as i32)
}

/// A cell up to one of several distances from a solid voxel on each axis, maybe beyond the ends of the coordinates; and that voxel.
pub(super) fn wrapped_from(targets: &RayTargets, random: &mut Random, reach: [u64; 3]) -> ([i64; 3], [i64; 3]) {
    let (target, reach) = (targets.solid(random), reach[random.index(3)]);
    (std::array::from_fn(|i| target[i] + random.below(2 * reach + 1).cast_signed() - reach.cast_signed()), target)
}

/// A cell with one to three coordinates at an end of their range, the others around the scene; and a solid voxel.
pub(super) fn range_end(targets: &RayTargets, random: &mut Random) -> ([i64; 3], [i64; 3]) {
    let (target, mut cell) = (targets.solid(random), random.cell(around(&targets.bounds)));
    let surely = random.index(3);
    for (axis, at) in cell.iter_mut().enumerate() {
        if axis == surely || random.below(3) == 0 {
            *at = [i32::MIN, i32::MAX][random.index(2)].into();
        }
    }
    (clamped(cell).map(i64::from), target)
}

/// The box with a margin of half its size and a few voxels.
pub(super) fn around(b: &Box3) -> Box3 {
    let margin: [i64; 3] = std::array::from_fn(|i| (b[1][i] - b[0][i]) / 2 + 3);
    [std::array::from_fn(|i| b[0][i] - margin[i]), std::array::from_fn(|i| b[1][i] + margin[i])]
}

pub(super) fn fraction(random: &mut Random) -> [f32; 3] {
    std::array::from_fn(|_| random.unit())
}

/// From an origin to a point, both as cell and fraction: the difference in `f32`.
pub(super) fn towards(from: ([i64; 3], [f32; 3]), to: ([i64; 3], [f32; 3])) -> [f32; 3] {
    std::array::from_fn(|i| ((to.0[i] - from.0[i]) as f64 + f64::from(to.1[i]) - f64::from(from.1[i])) as f32)
}

/// The centre of the box.
pub(super) fn middle(b: &Box3) -> [i64; 3] {
    std::array::from_fn(|i| i64::midpoint(b[0][i], b[1][i]))
}
