//! The frame of a model: a pose in whole numbers. Shaders and the exact tracer bring rays into it by the same integers.

use raxel_world::Orientation;

use super::pose::Pose;

/// Steps of a fraction of a voxel: 2²⁴, the lattice that rays are on.
const ONE: i64 = 1 << 24;
/// Steps of an entry of a rotation: 2²³, so that it is exact in `f32`.
const ROTATION_ONE: f64 = (1 << 23) as f64;

/// A ray is brought into a free frame if it starts at most this many voxels away from it along each axis.
pub const REACH: i64 = 1 << 29;

/// A pose in whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The cell in which the centre of the anchor's cell lies.
    pub cell: [i32; 3],
    /// Its place in that cell, in units of 2⁻²⁴ voxel.
    pub fraction: [u32; 3],
    /// How the model is turned about it.
    pub turn: Rotation,
}

/// How a model is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// By quarter turns, and its voxels are on the lattice of the world's: from the model's axes to the world's.
    Quarter(Orientation),
    /// In any other way. Rows of a matrix from the world's axes to the model's, in units of 2⁻²³.
    Free([[i32; 3]; 3]),
}

/// A place in a free frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelPlace {
    /// Cell, counted from the anchor's.
    pub cell: [i64; 3],
    /// Place in the cell, in units of 2⁻²⁴.
    pub fraction: [i64; 3],
}

impl Frame {
    /// Of a pose, rounded to the nearest.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "positions are within `COORDINATES`, and a rotation has entries in −1…1"
    )]
    pub fn of(pose: &Pose) -> Self {
        let middle = pose.middle().map(|m| (m * ONE as f64).round() as i64);
        let whole = |row: &[f64; 3]| row.map(|v| v as i32);
        let quarter = Orientation::from_rows([0, 1, 2].map(|i| whole(&pose.rotation[i])))
            .filter(|_| pose.rotation.as_flattened().iter().all(|v| v.fract() == 0.0))
            .filter(|_| middle.iter().all(|m| m.rem_euclid(ONE) == ONE / 2));
        let turn = quarter.map_or_else(
            || {
                // The inverse of a rotation is its transpose.
                let entry = |row: usize, column: usize| (pose.rotation[column][row] * ROTATION_ONE).round() as i32;
                Rotation::Free(std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column))))
            },
            Rotation::Quarter,
        );
        Self {
            cell: middle.map(|m| m.div_euclid(ONE) as i32),
            fraction: middle.map(|m| m.rem_euclid(ONE) as u32),
            turn,
        }
    }

    /// The cell of the world that a cell of the model, counted from the anchor's, is in, if the model is on the lattice of the world.
    pub fn place(&self, from_anchor: [i64; 3]) -> Option<[i64; 3]> {
        let Rotation::Quarter(orientation) = self.turn else { return None };
        let turned = orientation.vector(from_anchor);
        Some(std::array::from_fn(|i| i64::from(self.cell[i]) + turned[i]))
    }

    /// The smallest box of whole voxels around everything that the voxels `low` to `last` of the model, counted from the anchor's, can
    /// cover: its smallest voxel and its last.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "positions are within `COORDINATES`, and casts of floats saturate"
    )]
    pub fn bounds(&self, low: [i64; 3], last: [i64; 3]) -> [[i64; 3]; 2] {
        let corners =
            (0..8).map(|corner: usize| std::array::from_fn(|i| if corner >> i & 1 == 1 { last[i] } else { low[i] }));
        match self.turn {
            Rotation::Quarter(_) => {
                let placed = corners.filter_map(|corner| self.place(corner));
                placed.fold([[i64::MAX; 3], [i64::MIN; 3]], |[min, max], at| {
                    [std::array::from_fn(|i| min[i].min(at[i])), std::array::from_fn(|i| max[i].max(at[i]))]
                })
            }
            Rotation::Free(rows) => {
                let from_model = |v: [f64; 3]| -> [f64; 3] {
                    std::array::from_fn(|i| (0..3).map(|k| f64::from(rows[k][i]) / ROTATION_ONE * v[k]).sum())
                };
                let half: [f64; 3] = std::array::from_fn(|i| (last[i] - low[i] + 1) as f64 * 0.5);
                let middle = from_model(std::array::from_fn(|i| low[i] as f64 + half[i] - 0.5));
                std::array::from_fn(|side| {
                    std::array::from_fn(|i| {
                        let reach: f64 = (0..3).map(|k| (f64::from(rows[k][i]) / ROTATION_ONE).abs() * half[k]).sum();
                        // The rows are a rotation but for rounding, and their transpose its inverse but for twice that.
                        let room = 1.0 + (half.iter().sum::<f64>() + middle.map(f64::abs).iter().sum::<f64>()) * 2e-6;
                        let centre = f64::from(self.cell[i]) + f64::from(self.fraction[i]) / ONE as f64 + middle[i];
                        if side == 0 {
                            (centre - reach - room).floor() as i64
                        } else {
                            (centre + reach + room).ceil() as i64
                        }
                    })
                })
            }
        }
    }

    /// Brings a place of the world, a cell and a fraction in units of 2⁻²⁴, into a free frame: a cell counted from the anchor's and a
    /// fraction, rounded down. `None` if it is too far away, or the frame is not free.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "positions are within `COORDINATES`, and casts of floats saturate"
    )]
    pub fn into_model(&self, cell: [i64; 3], fraction: [i64; 3]) -> Option<ModelPlace> {
        let Rotation::Free(rows) = self.turn else { return None };
        let cells: [i64; 3] = std::array::from_fn(|i| cell[i] - i64::from(self.cell[i]));
        if cells.iter().any(|c| c.abs() > REACH) {
            return None;
        }
        let rests: [i64; 3] = std::array::from_fn(|i| fraction[i] - i64::from(self.fraction[i]));
        let place = rows.map(|row| {
            let sum: i128 = (0..3).map(|k| i128::from(row[k]) * i128::from(cells[k] * ONE + rests[k])).sum();
            // The centre of the anchor's cell is half a voxel from its corner.
            (sum >> 23) as i64 + ONE / 2
        });
        Some(ModelPlace { cell: place.map(|p| p.div_euclid(ONE)), fraction: place.map(|p| p.rem_euclid(ONE)) })
    }

    /// Brings a direction into a free frame, in `f32` and in this order: sums and products, each rounded by itself.
    #[expect(clippy::cast_possible_truncation, reason = "directions of rays are 32-bit floats")]
    pub fn direction(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        let Rotation::Free(rows) = self.turn else { return None };
        let entry = |v: i32| v as f32 / ROTATION_ONE as f32;
        let [x, y, z] = direction;
        Some(rows.map(|row| (entry(row[0]) * x + entry(row[1]) * y) + entry(row[2]) * z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_place_models_as_build_does() {
        for (yaw, turns) in [(0.0, 0), (90.0, 1), (180.0, 2), (-90.0, 3)] {
            let frame = Frame::of(&Pose::new([10.0, -4.0, 7.0], [yaw, 0.0, 0.0]));
            let anchor = [3, 0, -5];
            let placement = raxel_generate::place_anchor(anchor, turns, [10, -4, 7]);
            for cell in [[0, 0, 0], [9, 2, 1], anchor] {
                let from_anchor = std::array::from_fn(|i| cell[i] - anchor[i]);
                assert_eq!(frame.place(from_anchor), Some(placement.cell(cell)), "{yaw} {cell:?}");
            }
        }
    }

    #[test]
    fn boxes_hold_what_is_turned() {
        for yaw in 0..40 {
            let pose = Pose::new([100.25, -7.5, 1.0e6], [f64::from(yaw) * 9.7, f64::from(yaw) * 3.1, 12.0]);
            let frame = Frame::of(&pose);
            let (low, last) = ([-3, 0, -40], [5, 90, 2]);
            let [min, max] = frame.bounds(low, last);
            let mut reached = [[f64::MAX; 3], [f64::MIN; 3]];
            for corner in 0..8 {
                let cell: [i64; 3] = std::array::from_fn(|i| if corner >> i & 1 == 1 { last[i] + 1 } else { low[i] });
                let from_middle = cell.map(|c| c as f64 - 0.5);
                for i in 0..3 {
                    let turned: f64 = (0..3).map(|k| pose.rotation[i][k] * from_middle[k]).sum();
                    let at = pose.middle()[i] + turned;
                    assert!((min[i] as f64) < at && at < (max[i] + 1) as f64, "{yaw}: {at} in {min:?} {max:?}");
                    reached[0][i] = reached[0][i].min(at);
                    reached[1][i] = reached[1][i].max(at);
                }
            }
            // With a voxel of room, and the part that rounding to cells adds.
            let wide = (0..3).any(|i| reached[0][i] - min[i] as f64 > 3.0 || max[i] as f64 - reached[1][i] > 3.0);
            assert!(!wide, "{yaw}: {reached:?} in {min:?} {max:?}");
            let Rotation::Free(_) = frame.turn else { panic!("{frame:?}") };
        }
    }

    #[test]
    fn a_frame_without_a_turn_moves_places_exactly() {
        let frame = Frame::of(&Pose::new([5.25, 0.0, -2.0], [0.0; 3]));
        let ModelPlace { cell, fraction } = frame.into_model([5, 0, -2], [ONE / 2, 3, ONE]).unwrap();
        assert_eq!((cell, fraction), ([0, 0, 1], [ONE / 4, 3, 0]));
        assert_eq!(frame.direction([1.0e-30, -0.3, 2.0]), Some([1.0e-30, -0.3, 2.0]));
        assert_eq!(frame.into_model([6 + REACH, 0, 0], [0; 3]), None);
    }
}
