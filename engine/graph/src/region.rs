//! Subresources: the block of mips and layers that an access touches, and the parts into which accesses cut a resource.

use crate::checked::BoundAccess;
use crate::sizes::Size;

/// A block of mips × layers; both ranges are first and end (exclusive). Buffers have the one block `0..1 × 0..1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Region {
    pub mips: (u32, u32),
    pub layers: (u32, u32),
}

impl Region {
    /// All of a resource.
    pub fn whole(size: &Size) -> Region {
        let (mips, layers) = size.subresources();
        Region { mips: (0, mips), layers: (0, layers) }
    }

    /// What an access touches. What lies outside the resource is cut off (it is reported elsewhere).
    pub fn of(access: &BoundAccess, size: &Size) -> Region {
        let (mips, layers) = size.subresources();
        Region { mips: clip(access.mips, mips), layers: clip(access.layers, layers) }
    }

    /// One mip of one layer.
    pub fn one(mip: u32, layer: u32) -> Region {
        Region { mips: (mip, mip + 1), layers: (layer, layer + 1) }
    }

    /// Whether both touch a common subresource.
    pub fn overlaps(&self, other: &Region) -> bool {
        meets(self.mips, other.mips) && meets(self.layers, other.layers)
    }
}

fn clip((first, count): (u32, u32), end: u32) -> (u32, u32) {
    let last = if count == 0 { end } else { first.saturating_add(count).min(end) };
    (first.min(last), last)
}

fn meets(a: (u32, u32), b: (u32, u32)) -> bool {
    a.0 < b.1 && b.0 < a.1
}

/// The coarsest grid of mips × layers in which every region of a resource is a whole number of cells ("parts"). It keeps sets of
/// subresources small: a resource that is always touched as a whole has one part, whatever its mips and layers.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    mips: Vec<u32>,
    layers: Vec<u32>,
}

impl Parts {
    /// The grid that tells `regions` apart.
    pub fn new(regions: impl IntoIterator<Item = Region>) -> Parts {
        let (mut mips, mut layers) = (Vec::new(), Vec::new());
        for region in regions {
            mips.extend([region.mips.0, region.mips.1]);
            layers.extend([region.layers.0, region.layers.1]);
        }
        for cuts in [&mut mips, &mut layers] {
            cuts.sort_unstable();
            cuts.dedup();
        }
        Parts { mips, layers }
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.mips.len().saturating_sub(1) * self.layers.len().saturating_sub(1)
    }

    /// The parts of a region that was given to [`Parts::new`].
    pub fn of(&self, region: Region) -> impl Iterator<Item = usize> + use<> {
        let cell = |cuts: &[u32], at: u32| cuts.binary_search(&at).unwrap_or_else(|next| next);
        let mips = cell(&self.mips, region.mips.0)..cell(&self.mips, region.mips.1);
        let layers = cell(&self.layers, region.layers.0)..cell(&self.layers, region.layers.1);
        let row = self.layers.len().saturating_sub(1);
        mips.flat_map(move |mip| layers.clone().map(move |layer| mip * row + layer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_tell_regions_apart_and_no_more() {
        let whole = Region { mips: (0, 8), layers: (0, 4) };
        let tail = Region { mips: (3, 8), layers: (0, 4) };
        let parts = Parts::new([whole, tail]);
        assert_eq!(parts.count(), 2);
        assert_eq!(parts.of(whole).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(parts.of(tail).collect::<Vec<_>>(), [1]);
        let parts = Parts::new([whole, tail, Region::one(4, 2)]);
        assert_eq!(parts.count(), 4 * 3);
        assert_eq!(parts.of(Region::one(4, 2)).collect::<Vec<_>>(), [7]);
        assert!(tail.overlaps(&Region::one(4, 2)));
        assert!(!tail.overlaps(&Region::one(2, 2)));
    }
}
