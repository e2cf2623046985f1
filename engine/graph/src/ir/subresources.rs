//! Subresources: the range of mips and layers that an access is about, and the parts into which accesses divide a resource.

use crate::ir::checked::{BoundAccess, Interval};
use crate::ir::size::Size;

/// Mips × layers, each as first and end (exclusive). A buffer has the one subresource `0..1 × 0..1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SubresourceRange {
    pub mips: (u32, u32),
    pub layers: (u32, u32),
}

impl SubresourceRange {
    /// All of a resource.
    pub(crate) fn whole(size: &Size) -> SubresourceRange {
        SubresourceRange { mips: (0, size.mips()), layers: (0, size.layers()) }
    }

    /// The range of an access. The part outside of the resource is cut off (it is reported elsewhere).
    pub(crate) fn of(access: &BoundAccess, size: &Size) -> SubresourceRange {
        SubresourceRange { mips: clip(access.mips, size.mips()), layers: clip(access.layers, size.layers()) }
    }

    /// One mip of one layer.
    pub(crate) fn one(mip: u32, layer: u32) -> SubresourceRange {
        SubresourceRange { mips: (mip, mip + 1), layers: (layer, layer + 1) }
    }

    /// Whether both contain a common subresource.
    pub(crate) fn overlaps(&self, other: &SubresourceRange) -> bool {
        meets(self.mips, other.mips) && meets(self.layers, other.layers)
    }
}

fn clip(interval: Interval, end: u32) -> (u32, u32) {
    let end = interval.end().min(end);
    (interval.first.min(end), end)
}

fn meets(a: (u32, u32), b: (u32, u32)) -> bool {
    a.0 < b.1 && b.0 < a.1
}

/// The coarsest partition of mips × layers in which every range of a resource is a whole number of parts. It keeps sets of subresources
/// small: a resource that is always accessed as a whole has one part, for any number of mips and layers.
#[derive(Clone, Debug)]
pub(crate) struct SubresourcePartition {
    mips: Vec<u32>,
    layers: Vec<u32>,
}

impl SubresourcePartition {
    /// The coarsest partition in which each of `ranges` is a whole number of parts.
    pub(crate) fn new(ranges: impl IntoIterator<Item = SubresourceRange>) -> SubresourcePartition {
        let (mut mips, mut layers) = (Vec::new(), Vec::new());
        for range in ranges {
            mips.extend([range.mips.0, range.mips.1]);
            layers.extend([range.layers.0, range.layers.1]);
        }
        for cuts in [&mut mips, &mut layers] {
            cuts.sort_unstable();
            cuts.dedup();
        }
        SubresourcePartition { mips, layers }
    }

    /// Number of parts.
    pub(crate) fn count(&self) -> usize {
        self.mips.len().saturating_sub(1) * self.layers.len().saturating_sub(1)
    }

    /// The parts of a range that was given to [`SubresourcePartition::new`].
    pub(crate) fn of(&self, range: SubresourceRange) -> impl Iterator<Item = usize> + use<> {
        let part = |cuts: &[u32], at: u32| cuts.binary_search(&at).unwrap_or_else(|next| next);
        let mips = part(&self.mips, range.mips.0)..part(&self.mips, range.mips.1);
        let layers = part(&self.layers, range.layers.0)..part(&self.layers, range.layers.1);
        let row = self.layers.len().saturating_sub(1);
        mips.flat_map(move |mip| layers.clone().map(move |layer| mip * row + layer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_tell_ranges_apart_and_no_more() {
        let whole = SubresourceRange { mips: (0, 8), layers: (0, 4) };
        let tail = SubresourceRange { mips: (3, 8), layers: (0, 4) };
        let parts = SubresourcePartition::new([whole, tail]);
        assert_eq!(parts.count(), 2);
        assert_eq!(parts.of(whole).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(parts.of(tail).collect::<Vec<_>>(), [1]);
        let parts = SubresourcePartition::new([whole, tail, SubresourceRange::one(4, 2)]);
        assert_eq!(parts.count(), 4 * 3);
        assert_eq!(parts.of(SubresourceRange::one(4, 2)).collect::<Vec<_>>(), [7]);
        assert!(tail.overlaps(&SubresourceRange::one(4, 2)));
        assert!(!tail.overlaps(&SubresourceRange::one(2, 2)));
    }
}
