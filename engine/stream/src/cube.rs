//! The cube that the tree is put in.

use glam::IVec3;
use raxel_world::child_index;

use crate::reach::{StreamingRange, TileKey};

/// The cube that the tree is put in: multiples of the coarsest tiles, so that every tile is a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cube {
    /// Its smallest corner.
    pub origin: [i32; 3],
    /// It has 2^`log2_size` voxels a side, an even power.
    pub log2_size: u32,
}

/// Largest cube.
const MOST_LOG2_SIZE: u32 = 30;

/// The cube reaches this many of the coarsest tiles further around the camera than the wanted tiles. So it stays while the camera passes
/// one of them, and tiles that are kept for longer lie in it.
const ROOM: i64 = 4;

impl Cube {
    /// A cube around a camera, and all tiles that the camera wants. It is the smallest with `ROOM`: rays walk through one four times as
    /// large more slowly, where the same land is in it.
    #[expect(clippy::cast_possible_truncation, reason = "the corner is clamped to 32 bits")]
    pub fn around(camera: IVec3, reach: &StreamingRange) -> Self {
        let tile = TileKey::edge(reach.top());
        let log2_size = (6 + 2 * reach.top()..MOST_LOG2_SIZE)
            .step_by(2)
            .find(|log2| 1i64 << log2 >= 2 * (reach.outer() + ROOM * tile))
            .unwrap_or(MOST_LOG2_SIZE);
        let edge = 1i64 << log2_size;
        let origin = camera.to_array().map(|c| {
            let corner = (i64::from(c) - edge / 2).div_euclid(tile) * tile;
            corner.clamp(i64::from(i32::MIN), i64::from(i32::MAX) + 1 - edge) as i32
        });
        Self { origin, log2_size }
    }

    /// Whether all that a camera wants is still inside.
    pub fn suits(&self, camera: IVec3, reach: &StreamingRange) -> bool {
        let (edge, outer) = (1i64 << self.log2_size, reach.outer());
        (0..3).all(|i| {
            let low = i64::from(self.origin[i]);
            let camera = i64::from(camera[i]);
            let low_is_end = low == i64::from(i32::MIN);
            let high_is_end = low + edge == i64::from(i32::MAX) + 1;
            (camera - outer >= low || low_is_end) && (camera + outer <= low + edge || high_is_end)
        })
    }

    /// Levels from the tiles of level 0 up to the root.
    pub(crate) fn height(&self) -> u32 {
        (self.log2_size - 6) / 2
    }

    /// Child numbers from the root down to a tile, 6 bits each; `None` outside the cube.
    pub(crate) fn path(&self, tile: TileKey) -> Option<u128> {
        let shift = 6 + 2 * tile.level;
        let levels = self.height() - tile.level;
        let pos = [tile.pos.x, tile.pos.y, tile.pos.z];
        let mut local = [0u32; 3];
        for i in 0..3 {
            let at = i64::from(pos[i]) - (i64::from(self.origin[i]) >> shift);
            local[i] = u32::try_from(at).ok().filter(|at| u64::from(*at) < 1 << (2 * levels))?;
        }
        Some((0..levels).rev().fold(0, |path, level| {
            let [x, y, z] = local.map(|c| c >> (2 * level) & 3);
            path << 6 | u128::from(child_index(x, y, z))
        }))
    }
}

#[cfg(test)]
mod tests {
    use raxel_worldfile::StreamSettings;

    use super::*;

    #[test]
    fn the_cube_is_no_larger_than_it_has_to_be_and_stays_while_a_tile_is_passed() {
        let mut random = raxel_world::random::SplitMix64::new(4);
        for (near, far, log2_size) in [(1024, 1024, 12), (1024, 4096, 14), (1024, 65_536, 18)] {
            let settings = StreamSettings { near, far, ..StreamSettings::default() };
            let shown = StreamingRange::of(&settings, [-64, 400]);
            let tile = TileKey::edge(shown.top()) as i32;
            for complete in [true, false] {
                let reach = shown.loaded(complete);
                for _ in 0..50 {
                    let camera = IVec3::from_array([0; 3].map(|_| random.below(2_000_000) as i32 - 1_000_000));
                    let cube = Cube::around(camera, &reach);
                    assert_eq!(cube.log2_size, log2_size, "{near} {far} {complete}");
                    for axis in [IVec3::X, IVec3::Y, IVec3::Z] {
                        assert!(cube.suits(camera + axis * tile, &reach) && cube.suits(camera - axis * tile, &reach));
                    }
                }
                let camera = IVec3::new(random.below(9000) as i32, 170, -(random.below(9000) as i32));
                let cube = Cube::around(camera, &reach);
                assert!(reach.tiles(camera).into_iter().all(|tile| cube.path(tile).is_some()));
            }
        }
    }
}
