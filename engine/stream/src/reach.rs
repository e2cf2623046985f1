//! Finds the wanted tiles around a camera, in whole numbers.

use glam::IVec3;
use raxel_world::{ChunkPos, MAX_LEVEL, cell_edge};
use raxel_worldfile::StreamSettings;

/// A tile: its level, and its position in tiles of that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// 0 for chunks.
    pub level: u32,
    /// Position in tiles of the level.
    pub pos: ChunkPos,
}

impl TileKey {
    /// Voxels along a tile of a level.
    pub const fn edge(level: u32) -> i64 {
        64 * cell_edge(level)
    }

    /// The tile of a level that holds a voxel.
    pub fn of_cell(level: u32, cell: IVec3) -> Self {
        let shift = 6 + 2 * level;
        Self { level, pos: ChunkPos::new(cell.x >> shift, cell.y >> shift, cell.z >> shift) }
    }

    /// The tile of the next coarser level that contains it.
    #[must_use]
    pub fn parent(self) -> Self {
        let ChunkPos { x, y, z } = self.pos;
        Self { level: self.level + 1, pos: ChunkPos::new(x >> 2, y >> 2, z >> 2) }
    }

    /// Whether the tile is made from a chunk: the chunk lies in it. The lamps of a chunk also depend on the chunks at its faces.
    pub(crate) fn reads(self, chunk: ChunkPos, lamps: bool) -> bool {
        let shift = 2 * self.level;
        let apart = |chunk: i32, tile: i32| u64::from((chunk >> shift).abs_diff(tile));
        let tiles = apart(chunk.x, self.pos.x) + apart(chunk.y, self.pos.y) + apart(chunk.z, self.pos.z);
        tiles == 0 || tiles == 1 && lamps && self.level == 0
    }

    /// Its smallest voxel.
    pub fn origin(self) -> [i64; 3] {
        [self.pos.x, self.pos.y, self.pos.z].map(|c| i64::from(c) * Self::edge(self.level))
    }
}

/// How far tiles of each level reach around the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamingRange {
    /// The radius of each level, in tiles of that level. Each level lies within the next coarser one, which is shown where finer tiles are missing.
    radii: Vec<i32>,
    /// Tiles are loaded as if the camera could be in any neighbouring tile within `around`, so that crossing a border finds them resident.
    around: i32,
    /// The smallest height, and one past the largest, in voxels.
    height: [i64; 2],
}

impl StreamingRange {
    /// The range that a world file asks for, in a world whose voxels have these heights.
    #[expect(clippy::cast_possible_truncation, reason = "`far` is at most `MOST_FAR`")]
    pub fn of(settings: &StreamSettings, built: [i64; 2]) -> Self {
        let top = (0..MAX_LEVEL).find(|level| i64::from(settings.near) * cell_edge(*level) >= i64::from(settings.far));
        let top = top.unwrap_or(MAX_LEVEL);
        let radii = (0..=top)
            .map(|level| {
                let reach =
                    if level == top { i64::from(settings.far) } else { i64::from(settings.near) * cell_edge(level) };
                (reach + TileKey::edge(level) - 1).div_euclid(TileKey::edge(level)) as i32
            })
            .collect();
        let height = match settings.height {
            Some([low, high]) => [low.max(built[0]), high.min(built[1])],
            None => built,
        };
        Self { radii, around: 0, height }
    }

    /// The coarsest level.
    #[expect(clippy::cast_possible_truncation, reason = "there are `MAX_LEVEL` + 1 levels at most")]
    pub fn top(&self) -> u32 {
        self.radii.len() as u32 - 1
    }

    /// The radius of level 0, in tiles.
    pub fn near(&self) -> i32 {
        self.radii[0]
    }

    /// Wants the rows of tiles at these heights as well: edits are shown however high or deep they are.
    pub fn include(&mut self, [low, high]: [i64; 2]) {
        self.height = if self.height[0] < self.height[1] {
            [self.height[0].min(low), self.height[1].max(high)]
        } else {
            [low, high]
        };
    }

    /// The same with another radius of level 0, in tiles.
    #[must_use]
    pub(crate) fn with_near(&self, tiles: i32) -> Self {
        let mut reach = self.clone();
        reach.radii[0] = tiles;
        reach
    }

    /// The range that a streamer loads in order to show this one. For a `complete` world that is the same range. Otherwise it has the tiles that
    /// are wanted from every tile next to the camera's, also across its corners. So the loading of a tile starts while the camera is still a
    /// whole tile away. That is a quarter of a second before for chunks at 256 voxels a second, and longer for coarser levels. A radius larger
    /// by one tile is not enough: a camera that passes two borders of different axes in a row wants the tiles across both.
    #[must_use]
    pub fn loaded(&self, complete: bool) -> Self {
        Self { around: i32::from(!complete), ..self.clone() }
    }

    /// Whether this range, as [`Self::loaded`] returns it, has around `from` every tile that is shown from `camera`.
    pub(crate) fn covers(&self, from: IVec3, camera: IVec3) -> bool {
        let (a, b) = (TileKey::of_cell(0, from).pos, TileKey::of_cell(0, camera).pos);
        [a.x - b.x, a.y - b.y, a.z - b.z].iter().all(|tiles| tiles.abs() <= self.around)
    }

    /// Every tile lies within this distance of the camera, in voxels.
    pub fn outer(&self) -> i64 {
        i64::from(self.radii[self.radii.len() - 1] + self.around + 1) * TileKey::edge(self.top())
    }

    /// Whether the camera at a voxel wants a tile. `slack` widens the range by that many tiles.
    pub fn wants(&self, camera: IVec3, tile: TileKey, slack: i32) -> bool {
        let Some(radius) = self.radii.get(tile.level as usize) else { return false };
        let here = TileKey::of_cell(tile.level, camera).pos;
        let gap = |a: i32, b: i32| i64::from((a - b).abs() - 1 - self.around).max(0);
        let (x, y, z) = (gap(tile.pos.x, here.x), gap(tile.pos.y, here.y), gap(tile.pos.z, here.z));
        let radius = i64::from(radius + slack);
        // An upright cylinder, not a ball: a camera that rises sees more of the land around it, not less.
        x * x + z * z < radius * radius && y < radius && self.rows(tile.level).contains(&tile.pos.y)
    }

    /// Every tile that the camera at a voxel wants.
    pub fn tiles(&self, camera: IVec3) -> Vec<TileKey> {
        let mut all = Vec::new();
        for level in 0..=self.top() {
            let here = TileKey::of_cell(level, camera).pos;
            let radius = self.radii[level as usize] + self.around;
            let rows = self.rows(level);
            for y in rows.start.max(here.y - radius)..rows.end.min(here.y + radius + 1) {
                for z in here.z - radius..=here.z + radius {
                    for x in here.x - radius..=here.x + radius {
                        let tile = TileKey { level, pos: ChunkPos::new(x, y, z) };
                        if self.wants(camera, tile, 0) {
                            all.push(tile);
                        }
                    }
                }
            }
        }
        all
    }

    /// Rows of tiles in the band of heights.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "heights of a world are within ±2³¹ voxels, and a tile has at least 64"
    )]
    fn rows(&self, level: u32) -> std::ops::Range<i32> {
        let edge = TileKey::edge(level);
        let [low, high] = self.height;
        if low >= high { 0..0 } else { low.div_euclid(edge) as i32..(high - 1).div_euclid(edge) as i32 + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(near: u32, far: u32) -> StreamingRange {
        StreamingRange::of(&StreamSettings { near, far, ..StreamSettings::default() }, [-100, 300])
    }

    #[test]
    fn a_tile_reads_its_own_chunks_and_a_chunk_with_lamps_those_at_its_faces() {
        let tile = |level, x, y, z| TileKey { level, pos: ChunkPos::new(x, y, z) };
        let around = |tile: TileKey, lamps| {
            let positions =
                (-9..9).flat_map(|x| (-9..9).flat_map(move |y| (-9..9).map(move |z| ChunkPos::new(x, y, z))));
            positions.filter(|pos| tile.reads(*pos, lamps)).collect::<Vec<_>>()
        };
        assert_eq!(around(tile(0, -1, 2, 3), false), [ChunkPos::new(-1, 2, 3)]);
        let with_lamps = around(tile(0, -1, 2, 3), true);
        assert_eq!(with_lamps.len(), 7);
        assert!((0..6).all(|face| with_lamps.contains(&ChunkPos::new(-1, 2, 3).beside(face))));
        for lamps in [false, true] {
            let coarse = around(tile(1, -1, 0, 1), lamps);
            let inside =
                |pos: &ChunkPos| (-4..0).contains(&pos.x) && (0..4).contains(&pos.y) && (4..8).contains(&pos.z);
            assert!(coarse.len() == 64 && coarse.iter().all(inside), "{coarse:?}");
        }
    }

    #[test]
    fn every_voxel_within_near_is_wanted() {
        let reach = reach(256, 256);
        let mut random = raxel_world::random::SplitMix64::new(1);
        for _ in 0..10_000 {
            let mut near = |around: i32| IVec3::from_array([0; 3].map(|_| around + random.below(513) as i32 - 256));
            let camera = near(1_000_000);
            let cell = camera + near(0);
            let distance = (cell - camera).as_dvec3().length();
            let tile = TileKey::of_cell(0, cell);
            if (-100..300).contains(&cell.y) && distance < 256.0 {
                assert!(reach.wants(camera, tile, 0), "{cell} from {camera}");
            }
        }
    }

    #[test]
    fn who_rises_sees_no_less_of_the_land() {
        let reach = reach(1024, 4096);
        let chunks = |y: i32| -> Vec<TileKey> {
            reach.tiles(IVec3::new(-70, y, 12_345)).into_iter().filter(|tile| tile.level == 0).collect()
        };
        assert!(chunks(40).len() > 5000 && chunks(40) == chunks(700) && chunks(40) == chunks(-700));
        assert_eq!(chunks(3000), []);
    }

    #[test]
    fn what_is_wanted_from_beside_is_loaded() {
        let shown = reach(512, 4096);
        let loaded = shown.loaded(false);
        assert_eq!(shown.loaded(true), shown);
        // Borders of all levels are beside it.
        let at = IVec3::new(0, 40, 4095);
        assert!(!loaded.covers(at, at + 128));
        for step in 0..27 {
            let beside = at + 64 * (IVec3::new(step % 3, step / 3 % 3, step / 9) - 1);
            let is_loaded = |tile| loaded.wants(at, tile, 0);
            assert!(loaded.covers(at, beside) && shown.tiles(beside).into_iter().all(is_loaded), "{beside}");
        }
        // The range has few other tiles.
        let counts = [&shown, &loaded].map(|reach| reach.tiles(at).len());
        assert!(counts[1] * 10 < counts[0] * 15, "{counts:?}");
    }

    #[test]
    fn levels_lie_within_each_other() {
        let reach = reach(128, 128 * 64).loaded(false);
        assert_eq!(reach.top(), 3);
        let camera = IVec3::new(-70, 40, 12_345);
        let tiles = reach.tiles(camera);
        assert!(tiles.iter().all(|tile| tile.level == 3 || reach.wants(camera, tile.parent(), 0)));
        assert!((0..4).all(|level| tiles.iter().any(|tile| tile.level == level)));
        assert!(tiles.iter().all(|tile| reach.wants(camera, *tile, 0)));
    }
}
