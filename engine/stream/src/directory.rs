//! The upper nodes of the tree: everything above the tiles, made anew for each publication.

use std::collections::HashSet;
use std::sync::Arc;

use glam::IVec3;
use raxel_world::layout::TileNode;
use raxel_world::lights::LightGroup;
use raxel_world::{cell_edge, child_index};

use crate::reach::{Reach, TileKey};

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

/// The cube reaches so many of the coarsest tiles further around the camera than what is wanted, so that it stays while the camera passes
/// one of them, and what is kept for longer lies in it.
const ROOM: i64 = 4;

impl Cube {
    /// A cube around a camera, and all of what the camera wants. It is the smallest with [`ROOM`]: rays walk through one four times as large
    /// more slowly, where the same land is in it.
    pub fn around(camera: IVec3, reach: &Reach) -> Self {
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
    pub fn suits(&self, camera: IVec3, reach: &Reach) -> bool {
        let (edge, outer) = (1i64 << self.log2_size, reach.outer());
        (0..3).all(|i| {
            let low = i64::from(self.origin[i]);
            let camera = i64::from(camera[i]);
            let low_is_end = low == i64::from(i32::MIN);
            let high_is_end = low + edge == i64::from(i32::MAX) + 1;
            (camera - outer >= low || low_is_end) && (camera + outer <= low + edge || high_is_end)
        })
    }

    /// Child numbers from the root down to a tile, 6 bits each; `None` outside the cube.
    fn path(&self, tile: TileKey) -> Option<u128> {
        let shift = 6 + 2 * tile.level;
        let levels = (self.log2_size - shift) / 2;
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

/// A tile that is in the pool.
#[derive(Clone, Debug)]
pub struct LiveTile {
    /// Its node; `None` when it is empty.
    pub node: Option<TileNode>,
    /// Its smallest and largest cells that are solid, on each axis.
    pub cells: [[u32; 3]; 2],
    /// Above level 0: the nodes of its occupied children, in the order of its mask, unless it is filled.
    pub children: Arc<[TileNode]>,
    /// Its lamps, with the child that each group is in; a chunk has one group.
    pub lights: Arc<[(u32, LightGroup)]>,
}

impl LiveTile {
    /// The node of one of its 64 children: a part as large as a tile of the level below.
    fn child(&self, number: u32) -> Option<TileNode> {
        let node = self.node?;
        if node.mask() >> number & 1 == 0 {
            return None;
        }
        match node.filled_material() {
            Some(material) => Some(TileNode::filled(material)),
            None => self.children.get((node.mask() & ((1 << number) - 1)).count_ones() as usize).copied(),
        }
    }
}

/// The upper nodes, with addresses relative to their own first one.
#[derive(Debug)]
pub struct Directory {
    nodes: Vec<TileNode>,
    /// Whether the address of the children of each is relative.
    relative: Vec<bool>,
    root: u32,
    /// Smallest and largest voxel of tiles with solids; in an empty world the largest is smaller.
    pub bounds: [[i32; 3]; 2],
    /// Tiles with solids that it reaches.
    pub live: usize,
    /// The lamps of what it shows.
    pub lights: Vec<LightGroup>,
    /// What lies over the lamps of coarse tiles: their level, and the path of the child in whose place something finer is shown.
    overlaid: HashSet<(u32, u128)>,
}

/// A node on the way up: its path from the root.
#[derive(Clone, Copy)]
struct Item {
    path: u128,
    node: Option<TileNode>,
    relative: bool,
}

impl Directory {
    /// The directory of tiles up to a level. A tile hides that part of the coarser one around it; where the tile just above is missing and
    /// a still coarser one is there, that one is shown.
    pub fn of<'t>(cube: &Cube, top: u32, tiles: impl Iterator<Item = (TileKey, &'t LiveTile)>) -> Self {
        let mut levels: Vec<Vec<(u128, &LiveTile)>> = vec![Vec::new(); top as usize + 1];
        let mut bounds = [[i64::MAX; 3], [i64::MIN; 3]];
        let mut live = 0;
        for (key, tile) in tiles {
            let Some(path) = cube.path(key) else { continue };
            levels[key.level as usize].push((path, tile));
            if tile.node.is_some() {
                live += 1;
                // Where the tile ends, a ray would go on for long that leaves coarse land upwards.
                let (origin, cell) = (key.origin(), cell_edge(key.level));
                let [low, high] = tile.cells.map(|at| at.map(i64::from));
                for i in 0..3 {
                    bounds[0][i] = bounds[0][i].min(origin[i] + low[i] * cell);
                    bounds[1][i] = bounds[1][i].max(origin[i] + (high[i] + 1) * cell - 1);
                }
            }
        }
        levels.iter_mut().for_each(|level| level.sort_unstable_by_key(|(path, _)| *path));

        let mut directory = Self {
            nodes: Vec::new(),
            relative: Vec::new(),
            root: 0,
            bounds: [[0; 3], [-1; 3]],
            live,
            lights: Vec::new(),
            overlaid: HashSet::new(),
        };
        // Tiles of which nothing is shown, by the level and the path of the one that is missing around them.
        let mut hidden: HashSet<(u32, u128)> = HashSet::new();
        let item = |&(path, tile): &(u128, &LiveTile)| Item { path, node: tile.node, relative: false };
        let mut below: Vec<Item> = levels[0].iter().map(item).collect();
        let height = (cube.log2_size - 6) / 2;
        for level in 1..=height {
            let own = levels.get(level as usize).map_or(&[][..], Vec::as_slice);
            let hidden_by_coarser = |path: u128| {
                (level as usize + 1..levels.len()).any(|coarser| {
                    let above = path >> (6 * (coarser - level as usize));
                    levels[coarser].binary_search_by_key(&above, |(path, _)| *path).is_ok()
                })
            };
            let mut items = Vec::with_capacity(own.len());
            let mut own = own.iter().peekable();
            for group in below.chunk_by(|a, b| a.path >> 6 == b.path >> 6) {
                let path = group[0].path >> 6;
                while let Some(before) = own.next_if(|(of, _)| *of < path) {
                    items.push(item(before));
                }
                let base = own.next_if(|(of, _)| *of == path).map(|(_, tile)| *tile);
                if base.is_none() && hidden_by_coarser(path) {
                    hidden.insert((level, path));
                    continue;
                }
                items.push(Item { path, ..directory.parent(level, group, base) });
            }
            items.extend(own.map(item));
            below = items;
        }
        let root = below.first().and_then(|item| Some((item.node?, item.relative)));
        let (node, relative) = root.unwrap_or((TileNode::default(), false));
        directory.root = directory.nodes.len() as u32;
        directory.nodes.push(node);
        directory.relative.push(relative);
        if live > 0 {
            directory.bounds =
                bounds.map(|corner| corner.map(|c| c.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32));
        }
        for (level, tiles) in (0..).zip(&levels) {
            for (path, tile) in tiles.iter().filter(|(_, tile)| !tile.lights.is_empty()) {
                if (level + 1..=top).any(|above| hidden.contains(&(above, path >> (6 * (above - level))))) {
                    continue;
                }
                let shown = |child: u32| !directory.overlaid.contains(&(level, path << 6 | u128::from(child)));
                let lights = tile.lights.iter().filter(|(child, _)| level == 0 || shown(*child));
                directory.lights.extend(lights.map(|(_, group)| *group));
            }
        }
        directory
    }

    /// A node of these children, which lie over those of the coarser tile in its place. Empty when all of them are.
    fn parent(&mut self, level: u32, group: &[Item], base: Option<&LiveTile>) -> Item {
        let first = self.nodes.len() as u32;
        let mut mask = 0u64;
        if base.is_some_and(|tile| !tile.lights.is_empty()) {
            self.overlaid.extend(group.iter().map(|item| (level, item.path)));
        }
        let mut own = group.iter().peekable();
        for number in 0..64 {
            let (node, relative) = match own.next_if(|item| item.path & 63 == u128::from(number)) {
                Some(item) => (item.node, item.relative),
                None => (base.and_then(|tile| tile.child(number)), false),
            };
            if let Some(node) = node {
                mask |= 1 << number;
                self.nodes.push(node);
                self.relative.push(relative);
            }
        }
        let node = (mask != 0).then(|| TileNode::of_children(mask, first));
        Item { path: 0, node, relative: true }
    }

    /// Words that it takes.
    pub fn words(&self) -> u32 {
        4 * self.nodes.len() as u32
    }

    /// Nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether it reaches no tile.
    pub fn is_empty(&self) -> bool {
        self.live == 0
    }

    /// Its words for a place in the buffer, a multiple of 4 words behind the header, and the number of its root there.
    pub fn place(&self, at: u32) -> (Vec<u32>, u32) {
        let base = at / 4;
        let mut words = Vec::with_capacity(4 * self.nodes.len());
        for (node, relative) in self.nodes.iter().zip(&self.relative) {
            let [low, high, first, material] = node.0;
            words.extend_from_slice(&[low, high, if *relative { first + base } else { first }, material]);
        }
        (words, base + self.root)
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::StreamSettings;

    use super::*;

    #[test]
    fn the_cube_is_no_larger_than_it_has_to_be_and_stays_while_a_tile_is_passed() {
        let mut random = raxel_world::random::SplitMix64::new(4);
        for (near, far, log2_size) in [(1024, 1024, 12), (1024, 4096, 14), (1024, 65_536, 18)] {
            let settings = StreamSettings { near, far, ..StreamSettings::default() };
            let shown = Reach::of(&settings, [-64, 400]);
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
