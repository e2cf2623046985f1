//! Places and sizes in a world file, and whether they are inside the world.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, codes};
use raxel_language::Keys;
use raxel_world::Bounds;

/// Smallest and one past the largest voxel coordinate.
pub const CELLS: RangeInclusive<i64> = -(1 << 31)..=1 << 31;

/// The same for positions, in voxels.
pub const POSITIONS: RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_648.0;

/// Where operations without bounds end: there are 2³¹ voxels of them along each axis.
const ENDLESS: i64 = 1 << 30;

/// A half-open box, by two of its keys.
#[derive(Keys)]
pub(super) struct Extent<const N: usize> {
    /// Smallest voxel, with `max` or `size`. Instead of `center`.
    #[keys(range = CELLS)]
    min: Option<[i64; N]>,
    /// One past the largest voxel, with `min`. Instead of `size`.
    #[keys(range = CELLS)]
    max: Option<[i64; N]>,
    /// Voxels along each axis, with `min` or `center`. Instead of `max`.
    #[keys(range = 1..=1 << 32)]
    size: Option<[i64; N]>,
    /// Middle, in voxels, with `size`. Instead of `min`.
    #[keys(range = CELLS)]
    center: Option<[i64; N]>,
}

/// The corners of a half-open box.
#[derive(Clone, Copy)]
pub(super) struct Corners<const N: usize> {
    /// Smallest voxel.
    pub(super) min: [i64; N],
    /// One past the largest voxel.
    pub(super) max: [i64; N],
}

impl<const N: usize> Extent<N> {
    /// Its corners. Without a key it is everything, if that is allowed.
    pub(super) fn corners(&self, table: &Table<'_, '_>, endless: bool) -> Option<Corners<N>> {
        let plus = |min: [i64; N], size: [i64; N]| std::array::from_fn(|i| min[i] + size[i]);
        let (low, high) = match (self.min, self.max, self.size, self.center) {
            (Some(min), Some(max), None, None) => (min, max),
            (Some(min), None, Some(size), None) => (min, plus(min, size)),
            (None, None, Some(size), Some(center)) => {
                let min = std::array::from_fn(|i| center[i] - size[i] / 2);
                (min, plus(min, size))
            }
            (None, None, None, None) if endless => ([-ENDLESS; N], [ENDLESS; N]),
            _ => {
                table.reporter().report(
                    Diagnostic::error(codes::world::EXTENT, format!("`{}` has no clear extent", table.name()))
                        .label(table.span().clone(), "")
                        .help(
                            "give `min` and `max` (one past the last voxel), or `min` and `size`, or `center` and `size`",
                        ),
                );
                return None;
            }
        };
        if (0..N).any(|i| low[i] >= high[i]) {
            let message = format!("`{}` is empty: from {low:?} to {high:?}", table.name());
            let report = Diagnostic::error(codes::world::EXTENT, message)
                .label(table.get("max").map_or_else(|| table.span().clone(), |node| node.span), "")
                .help("`max` is one past the last voxel, so it is larger than `min` in every component");
            table.reporter().report(report);
            return None;
        }
        Some(Corners { min: low, max: high })
    }
}

/// Reports a box that leaves the range of voxel coordinates.
pub(super) fn inside_world(table: &Table<'_, '_>, bounds: &Bounds) -> Option<()> {
    if (0..3).all(|i| bounds.min[i] >= *CELLS.start() && bounds.max[i] <= *CELLS.end()) {
        return Some(());
    }
    table.reporter().report(
        Diagnostic::error(
            codes::world::OUT_OF_RANGE,
            format!("`{}` leaves the world: it reaches from {:?} to {:?}", table.name(), bounds.min, bounds.max),
        )
        .label(table.span().clone(), "")
        .note("voxel coordinates are −2147483648 … 2147483647"),
    );
    None
}
