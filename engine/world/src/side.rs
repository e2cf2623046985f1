//! The outermost cells of a tile at one of its faces, for the tile beyond that face.

use crate::chunk::voxel_index;
use crate::tile::Content;

/// Which of the 64 × 64 cells of a tile that touch one of its faces are solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Side([u64; 64]);

impl Side {
    /// The cells of a tile at a face: 0 to 5 for −x, +x, −y, +y, −z, +z.
    pub fn of(content: &Content, face: u32) -> Self {
        let chunk = match content {
            Content::Empty => return Self([0; 64]),
            Content::Full(_) => return Self([u64::MAX; 64]),
            Content::Chunk(chunk) => chunk,
        };
        let axis = (face >> 1) as usize;
        let mut rows = [0; 64];
        for (v, row) in (0..).zip(&mut rows) {
            for u in 0..64 {
                let mut cell = [0; 3];
                cell[axis] = if face & 1 == 1 { 63 } else { 0 };
                cell[(axis + 1) % 3] = u;
                cell[(axis + 2) % 3] = v;
                let (block, bit) = voxel_index(cell[0], cell[1], cell[2]);
                *row |= (chunk.mask(block) >> bit & 1) << u;
            }
        }
        Self(rows)
    }

    /// Whether a cell at the face is solid. Its coordinates are in 0…63; the one along the axis of the face does not count.
    pub fn is_solid(&self, cell: [u32; 3], face: u32) -> bool {
        let axis = (face >> 1) as usize;
        let (u, v) = (cell[(axis + 1) % 3], cell[(axis + 2) % 3]);
        self.0[v as usize] >> u & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dense::DenseChunk;
    use crate::random::SplitMix64;

    #[test]
    fn a_side_has_the_outermost_cells() {
        let mut random = SplitMix64::new(3);
        let mut dense = DenseChunk::default();
        for _ in 0..100_000 {
            let [x, y, z] = [0; 3].map(|_| random.below(64) as u32);
            dense.set(x, y, z, 1);
        }
        let content = Content::pack(&dense);
        let chunk = content.to_chunk().unwrap();
        for face in 0..6 {
            let side = Side::of(&content, face);
            for (u, v) in (0..64).flat_map(|u| (0..64).map(move |v| (u, v))) {
                let mut cell = [u, v, u];
                cell[(face >> 1) as usize] = if face & 1 == 1 { 63 } else { 0 };
                let [x, y, z] = cell;
                assert_eq!(side.is_solid(cell, face), chunk.voxel(x, y, z) != 0, "{face} {cell:?}");
            }
            assert!(Side::of(&Content::Full(1), face).is_solid([5; 3], face));
            assert!(!Side::of(&Content::Empty, face).is_solid([5; 3], face));
        }
    }
}
