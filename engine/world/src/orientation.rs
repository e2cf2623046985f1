//! The 48 ways to turn and mirror a grid of voxels onto itself.

/// A signed permutation of the axes: component `i` of the result is component `axis[i]` of the argument, negated if `negate[i]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orientation {
    axis: [usize; 3],
    negate: [bool; 3],
}

impl Orientation {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { axis: [0, 1, 2], negate: [false; 3] };

    /// From the axes of a MagicaVoxel model (Z up) to those of a world (Y up): (x, y, z) becomes (x, z, −y).
    pub const Y_UP_FROM_Z_UP: Self = Self { axis: [0, 2, 1], negate: [false, false, true] };

    /// From the axes of a world to those of a MagicaVoxel model: (x, y, z) becomes (x, −z, y).
    pub const Z_UP_FROM_Y_UP: Self = Self { axis: [0, 2, 1], negate: [false, true, false] };

    /// Quarter turns to the left about +Y, seen from above.
    pub fn quarter_turns(turns: u32) -> Self {
        match turns % 4 {
            0 => Self::IDENTITY,
            1 => Self { axis: [2, 1, 0], negate: [false, false, true] },
            2 => Self { axis: [0, 1, 2], negate: [true, false, true] },
            _ => Self { axis: [2, 1, 0], negate: [true, false, false] },
        }
    }

    /// From the byte of a .vox file: bits 0–1 and 2–3 are the columns of the non-zero entry in the first and second row of the
    /// matrix, bits 4–6 the signs of the rows (MagicaVoxel-file-format-vox-extension.txt, "ROTATION"). `None` when the two
    /// columns are equal or there is no such column.
    pub fn from_vox(byte: u8) -> Option<Self> {
        let first = usize::from(byte & 3);
        let second = usize::from(byte >> 2 & 3);
        if first > 2 || second > 2 || first == second || byte >> 7 != 0 {
            return None;
        }
        Some(Self { axis: [first, second, 3 - first - second], negate: [4, 5, 6].map(|bit| byte >> bit & 1 != 0) })
    }

    /// From the rows of a matrix whose entries are 0, 1 and −1. `None` if it is not one of these turns.
    pub fn from_rows(rows: [[i32; 3]; 3]) -> Option<Self> {
        let mut found = Self::IDENTITY;
        for (row, entries) in rows.iter().enumerate() {
            let column = entries.iter().position(|entry| *entry != 0)?;
            if entries.iter().map(|entry| entry.abs()).sum::<i32>() != 1 {
                return None;
            }
            found.axis[row] = column;
            found.negate[row] = entries[column] < 0;
        }
        (0..3).all(|axis| found.axis.contains(&axis)).then_some(found)
    }

    /// Whether it turns without mirroring: 24 of the 48 do.
    pub fn is_rotation(&self) -> bool {
        let swaps =
            (0..3).flat_map(|i| (i + 1..3).map(move |j| (i, j))).filter(|&(i, j)| self.axis[i] > self.axis[j]).count();
        (swaps + self.negate.iter().filter(|negate| **negate).count()).is_multiple_of(2)
    }

    /// Undoes it.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let from = |axis: usize| self.axis.iter().position(|a| *a == axis).unwrap_or(axis);
        Self { axis: [0, 1, 2].map(from), negate: [0, 1, 2].map(|axis| self.negate[from(axis)]) }
    }

    /// The byte that [`Orientation::from_vox`] reads.
    #[expect(clippy::cast_possible_truncation, reason = "there are three axes")]
    #[inline]
    pub fn to_vox(&self) -> u8 {
        let sign = |axis: usize| u8::from(self.negate[axis]) << (4 + axis);
        self.axis[0] as u8 | (self.axis[1] as u8) << 2 | sign(0) | sign(1) | sign(2)
    }

    /// Turns a vector.
    #[inline]
    pub fn vector(&self, v: [i64; 3]) -> [i64; 3] {
        std::array::from_fn(|i| if self.negate[i] { -v[self.axis[i]] } else { v[self.axis[i]] })
    }

    /// Turns a cell about the lattice point at the origin: cell c covers [c, c + 1), so its mirror image is −c − 1.
    #[inline]
    pub fn cell(&self, c: [i64; 3]) -> [i64; 3] {
        std::array::from_fn(|i| if self.negate[i] { -c[self.axis[i]] - 1 } else { c[self.axis[i]] })
    }

    /// First `inner`, then `self`.
    #[must_use]
    #[inline]
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            axis: std::array::from_fn(|i| inner.axis[self.axis[i]]),
            negate: std::array::from_fn(|i| self.negate[i] != inner.negate[self.axis[i]]),
        }
    }
}

/// An orientation and then a translation, in voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// The turn, about the lattice point at the origin.
    pub turn: Orientation,
    /// Where the origin goes.
    pub to: [i64; 3],
}

impl Placement {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { turn: Orientation::IDENTITY, to: [0; 3] };

    /// Places a cell. Saturates far beyond the range of voxel coordinates.
    #[inline]
    pub fn cell(&self, c: [i64; 3]) -> [i64; 3] {
        let turned = self.turn.cell(c);
        std::array::from_fn(|i| turned[i].saturating_add(self.to[i]))
    }

    /// First `inner`, then `self`.
    #[must_use]
    #[inline]
    pub fn after(&self, inner: &Self) -> Self {
        let moved = self.turn.vector(inner.to);
        Self { turn: self.turn.after(&inner.turn), to: std::array::from_fn(|i| moved[i].saturating_add(self.to[i])) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composition_is_application_in_turn() {
        let all: Vec<_> = (0..128).filter_map(Orientation::from_vox).collect();
        assert_eq!(all.len(), 48);
        assert_eq!(all.iter().filter(|orientation| orientation.is_rotation()).count(), 24);
        for a in &all {
            assert_eq!(a.after(&a.inverse()), Orientation::IDENTITY);
            assert_eq!(Orientation::from_vox(a.to_vox()), Some(*a));
            let columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|unit| a.vector(unit));
            let rows = [0, 1, 2].map(|row| columns.map(|column| column[row] as i32));
            assert_eq!(Orientation::from_rows(rows), Some(*a));
            for b in &all {
                assert_eq!(a.after(b).is_rotation(), a.is_rotation() == b.is_rotation());
                let c = [3, -7, 11];
                assert_eq!(a.after(b).cell(c), a.cell(b.cell(c)));
                assert_eq!(a.after(b).vector(c), a.vector(b.vector(c)));
            }
        }
    }

    #[test]
    fn other_matrices_are_no_turns() {
        for rows in [
            [[1, 0, 0], [1, 0, 0], [0, 0, 1]],
            [[1, 1, 0], [0, 1, 0], [0, 0, 1]],
            [[2, 0, 0], [0, 1, 0], [0, 0, 1]],
            [[0; 3]; 3],
        ] {
            assert_eq!(Orientation::from_rows(rows), None);
        }
    }

    #[test]
    fn up_axes_are_inverse() {
        let there_and_back = Orientation::Z_UP_FROM_Y_UP.after(&Orientation::Y_UP_FROM_Z_UP);
        assert_eq!(there_and_back, Orientation::IDENTITY);
        assert_eq!(Orientation::Y_UP_FROM_Z_UP.cell([1, 2, 3]), [1, 3, -3]);
    }

    #[test]
    fn four_quarter_turns_are_none() {
        let quarter = Orientation::quarter_turns(1);
        assert_eq!(quarter.vector([1, 0, 0]), [0, 0, -1], "to the left, seen from above, +X goes to −Z");
        let mut turned = Orientation::IDENTITY;
        for turns in 0..5 {
            assert_eq!(turned, Orientation::quarter_turns(turns));
            turned = quarter.after(&turned);
        }
    }
}
