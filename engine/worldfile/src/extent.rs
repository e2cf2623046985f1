//! Places and sizes in a world file, and whether they are inside the world.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, codes};

use raxel_world::Bounds;

/// Smallest and one past the largest voxel coordinate.
pub(super) const CELLS: RangeInclusive<i64> = -(1 << 31)..=1 << 31;

/// The same for positions.
pub(super) const POSITIONS: RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_648.0;

/// Where operations without bounds end: there are 2³¹ voxels of them along each axis.
const ENDLESS: i64 = 1 << 30;

/// As [`read`]; without any bounds, everything, if the world is streamed.
pub(super) fn read_endless(table: &Table<'_, '_>, streamed: bool) -> Option<([i64; 2], [i64; 2])> {
    let bounded = ["min", "max", "size", "center"].into_iter().filter(|key| table.get(key).is_some()).count() > 0;
    if bounded || !streamed { read(table) } else { Some(([-ENDLESS; 2], [ENDLESS; 2])) }
}

/// A half-open box as `min` + `max`, `min` + `size` or `center` + `size`.
pub(super) fn read<const N: usize>(table: &Table<'_, '_>) -> Option<([i64; N], [i64; N])> {
    let nodes = ["min", "max", "size", "center"].map(|key| table.get(key));
    let given = nodes.each_ref().map(Option::is_some);
    let [min, max, size, center] = nodes;
    let whole = |node: Option<raxel_diagnostics::table::Node<'_, '_>>, range| node?.integers::<_, N>(range);
    let extent = match given {
        [true, true, false, false] => (whole(min, CELLS), whole(max.clone(), CELLS)),
        [true, false, true, false] => {
            let (min, size) = (whole(min, CELLS), whole(size, 1..=1 << 32));
            (min, min.zip(size).map(|(min, size)| std::array::from_fn(|i| min[i] + size[i])))
        }
        [false, false, true, true] => {
            let (center, size) = (whole(center, CELLS), whole(size, 1..=1 << 32));
            let min = center.zip(size).map(|(center, size)| std::array::from_fn(|i| center[i] - size[i] / 2));
            (min, min.zip(size).map(|(min, size): ([i64; N], _)| std::array::from_fn(|i| min[i] + size[i])))
        }
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
    let (Some(low), Some(high)) = extent else { return None };
    if (0..N).any(|i| low[i] >= high[i]) {
        let report =
            Diagnostic::error(codes::world::EXTENT, format!("`{}` is empty: from {low:?} to {high:?}", table.name()))
                .label(max.map_or_else(|| table.span().clone(), |node| node.span), "")
                .help("`max` is one past the last voxel, so it is larger than `min` in every component");
        table.reporter().report(report);
        return None;
    }
    Some((low, high))
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
