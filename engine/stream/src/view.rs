//! The streamer's inputs about the camera.

use glam::{DVec3, IVec3};

use crate::reach::TileKey;

/// Where the camera is, where it looks and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The voxel that it is in.
    pub cell: IVec3,
    /// Voxels a second.
    pub velocity: DVec3,
    /// Where it looks; of length 1.
    pub forward: DVec3,
    /// Half the angle of a cone around the picture, in radians.
    pub half_angle: f64,
}

impl View {
    /// A camera at rest that looks along −Z, with a wide angle.
    pub fn at(cell: IVec3) -> Self {
        Self { cell, velocity: DVec3::ZERO, forward: DVec3::NEG_Z, half_angle: std::f64::consts::FRAC_PI_4 }
    }

    /// Whether both see nearly the same, so that the order of loading stays.
    pub(crate) fn is_near(&self, other: &Self) -> bool {
        /// Cosine of 15 degrees.
        const SECTOR: f64 = 0.965_925_826_289_068_3;
        TileKey::of_cell(0, self.cell) == TileKey::of_cell(0, other.cell) && self.forward.dot(other.forward) > SECTOR
    }

    /// How soon a tile is loaded; the smallest value first. The coarsest tiles come before all others, because they stand in for them. Then
    /// come tiles in the picture, then those that may be in it soon, then those outside of it, chunks first, then all others. Distance counts from where the
    /// camera will be in half a second, and a quarter as much for each level.
    pub(crate) fn urgency(&self, tile: TileKey, top: u32, shown: bool) -> (u8, f64) {
        let (to, radius) = self.to_tile(tile);
        let ahead = (to - self.velocity * 0.5).length();
        let turn = match (shown, self.sees_sphere(to, radius)) {
            (true, seen) if tile.level == top => u8::from(!seen),
            (true, true) => 2,
            (false, true) => 3,
            (true, false) => 4 + u8::from(tile.level > 0),
            (false, false) => 6,
        };
        (turn, (ahead - radius).max(0.0) / raxel_world::cell_edge(tile.level) as f64 + radius * 1e-3)
    }

    /// Whether a tile may be in the picture.
    pub fn sees(&self, tile: TileKey) -> bool {
        let (to, radius) = self.to_tile(tile);
        self.sees_sphere(to, radius)
    }

    fn sees_sphere(&self, to: DVec3, radius: f64) -> bool {
        let distance = to.length();
        if distance <= radius {
            return true;
        }
        let angle = (to.dot(self.forward) / distance).clamp(-1.0, 1.0).acos();
        angle <= self.half_angle + (radius / distance).asin()
    }

    /// From the camera to the centre of a tile, and the radius of a sphere around it.
    fn to_tile(self, tile: TileKey) -> (DVec3, f64) {
        let half = TileKey::edge(tile.level) as f64 * 0.5;
        let origin = tile.origin();
        let camera = self.cell.to_array();
        let to = DVec3::from_array(std::array::from_fn(|i| (origin[i] - i64::from(camera[i])) as f64 + half));
        (to, half * 3f64.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_and_seen_is_loaded_first() {
        let view = View::at(IVec3::ZERO);
        let tile = |level: u32, z: i32| TileKey { level, pos: raxel_world::ChunkPos::new(0, 0, z) };
        // The camera looks along −Z.
        let order = [
            (tile(2, -9), true),
            (tile(2, 9), true),
            (tile(0, -3), true),
            (tile(1, -9), true),
            (tile(2, -10), false),
            (tile(0, 3), true),
            (tile(1, 5), true),
            (tile(0, 4), false),
        ];
        let urgency = order.map(|(tile, shown)| view.urgency(tile, 2, shown));
        assert!(urgency.is_sorted_by(|a, b| a < b), "{urgency:?}");
    }
}
