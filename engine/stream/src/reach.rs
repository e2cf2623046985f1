//! Which tiles are wanted: a function of where the camera is, in whole numbers.

use glam::IVec3;
use raxel_world::{ChunkPos, MAX_LEVEL, StreamSettings, cell_edge};

/// A tile: its level, and its place in tiles of that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// 0 for chunks.
    pub level: u32,
    /// In tiles.
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

    /// The tile one level above that it is a part of.
    #[must_use]
    pub fn parent(self) -> Self {
        let ChunkPos { x, y, z } = self.pos;
        Self { level: self.level + 1, pos: ChunkPos::new(x >> 2, y >> 2, z >> 2) }
    }

    /// Its smallest voxel.
    pub fn origin(self) -> [i64; 3] {
        [self.pos.x, self.pos.y, self.pos.z].map(|c| i64::from(c) * Self::edge(self.level))
    }
}

/// How far tiles of each level reach around the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reach {
    /// In tiles of the level. The tiles of a level lie within those of the next one, which stand in where finer ones are not there yet.
    radii: Vec<i32>,
    /// Smallest and one past the largest height.
    height: [i64; 2],
}

impl Reach {
    /// What a file wants of a world whose voxels have these heights.
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
        Self { radii, height }
    }

    /// The coarsest level.
    pub fn top(&self) -> u32 {
        self.radii.len() as u32 - 1
    }

    /// Tiles around the camera of level 0.
    pub fn near(&self) -> i32 {
        self.radii[0]
    }

    /// What is edited is seen, however high or deep: the rows of tiles at these heights are wanted as well.
    pub fn include(&mut self, [low, high]: [i64; 2]) {
        self.height = if self.height[0] < self.height[1] {
            [self.height[0].min(low), self.height[1].max(high)]
        } else {
            [low, high]
        };
    }

    /// The same with another reach of level 0.
    #[must_use]
    pub fn with_near(&self, tiles: i32) -> Self {
        let mut reach = self.clone();
        reach.radii[0] = tiles;
        reach
    }

    /// What a streamer loads to show this: where the world is not complete before each frame, one tile further at every level, so that what
    /// comes near is there before it is missed, and the coarsest of several levels two further: a horizon that is there before it is seen,
    /// even where a camera passes two borders at a corner.
    #[must_use]
    pub fn loaded(&self, complete: bool) -> Self {
        let mut reach = self.clone();
        if !complete {
            reach.radii.iter_mut().for_each(|radius| *radius += 1);
            if let [_, .., top] = &mut reach.radii[..] {
                *top += 1;
            }
        }
        reach
    }

    /// Voxels that everything lies within, around the camera.
    pub fn outer(&self) -> i64 {
        (i64::from(self.radii[self.radii.len() - 1]) + 1) * TileKey::edge(self.top())
    }

    /// Whether a tile is wanted from a voxel, or was and is kept within `slack` tiles more.
    pub fn wants(&self, camera: IVec3, tile: TileKey, slack: i32) -> bool {
        let Some(radius) = self.radii.get(tile.level as usize) else { return false };
        let here = TileKey::of_cell(tile.level, camera).pos;
        let gap = |a: i32, b: i32| i64::from((a - b).abs() - 1).max(0);
        let (x, y, z) = (gap(tile.pos.x, here.x), gap(tile.pos.y, here.y), gap(tile.pos.z, here.z));
        let radius = i64::from(radius + slack);
        // An upright cylinder, not a ball: who rises sees more of the land around, not less.
        x * x + z * z < radius * radius && y < radius && self.rows(tile.level).contains(&tile.pos.y)
    }

    /// Every wanted tile.
    pub fn tiles(&self, camera: IVec3) -> Vec<TileKey> {
        let mut all = Vec::new();
        for level in 0..=self.top() {
            let here = TileKey::of_cell(level, camera).pos;
            let radius = self.radii[level as usize];
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
    fn rows(&self, level: u32) -> std::ops::Range<i32> {
        let edge = TileKey::edge(level);
        let [low, high] = self.height;
        if low >= high { 0..0 } else { low.div_euclid(edge) as i32..(high - 1).div_euclid(edge) as i32 + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(near: u32, far: u32) -> Reach {
        Reach::of(&StreamSettings { near, far, ..StreamSettings::default() }, [-100, 300])
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
    fn levels_lie_within_each_other() {
        let reach = reach(128, 128 * 64);
        assert_eq!(reach.top(), 3);
        let camera = IVec3::new(-70, 40, 12_345);
        let tiles = reach.tiles(camera);
        assert!(tiles.iter().all(|tile| tile.level == 3 || reach.wants(camera, tile.parent(), 0)));
        assert!((0..4).all(|level| tiles.iter().any(|tile| tile.level == level)));
        assert!(tiles.iter().all(|tile| reach.wants(camera, *tile, 0)));
    }
}
