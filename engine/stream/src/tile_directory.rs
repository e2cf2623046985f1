//! The upper nodes of the tree: everything above the tiles. A publication writes only the nodes that changed since the last one.
//!
//! The nodes below one node lie behind each other, in a block of their own. When a tile comes, goes or changes, the blocks on the way up to
//! the root are rewritten, to other places; all others stay where they are, and frames in flight continue to read the old ones.

use std::sync::Arc;

use raxel_layouts::TileNode;
use raxel_layouts::lights::LightGroup;
use raxel_world::{Bits, Bounds, cell_edge, child_cell};

use crate::cube::Cube;
use crate::pool::{Pool, PoolBlock};
use crate::reach::TileKey;

/// A tile that is in the pool.
#[derive(Clone, Debug)]
pub(crate) struct LiveTile {
    /// Its node; `None` when it is empty.
    pub node: Option<TileNode>,
    /// Box around its solid cells.
    pub cells: Bounds,
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

/// The tiles of a cube, and the nodes above them in a pool. A tile hides its part of the coarser tile around it. If the tile one level
/// above is missing, a still coarser tile is shown.
pub(crate) struct TileDirectory {
    cube: Cube,
    root: Branch,
    /// The node of the root.
    block: Option<Written>,
    /// Blocks that it has no more use for.
    given_up: Vec<Written>,
    /// Words written since the last whole state.
    words: u64,
    /// The lamps of the shown tiles, by levels, and whether they have changed.
    lights: Vec<LightGroup>,
    relist: bool,
}

/// A block, and the version of the publication that it was written for.
pub(crate) struct Written {
    /// Where it is.
    pub block: PoolBlock,
    /// The first publication that may reach it.
    pub version: u64,
}

/// A state of the directory that is whole in the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Placed {
    /// The number of its root, in nodes behind the header.
    pub root: u32,
    /// Nodes above the tiles that are reached.
    pub nodes: usize,
    /// Smallest and largest voxel of tiles with solids; in an empty world the largest is smaller.
    pub bounds: [[i32; 3]; 2],
    /// Tiles with solids.
    pub live: usize,
    /// Words written since the last whole state.
    pub words: u64,
}

/// A place in the tree: a tile, finer ones within it, or both.
#[derive(Default)]
struct Branch {
    tile: Option<Arc<LiveTile>>,
    below: Option<Box<Group>>,
}

/// The up to 64 branches below one.
#[derive(Default)]
struct Group {
    mask: u64,
    /// In the order of the mask.
    branches: Vec<Branch>,
    /// Which branches have lamps.
    lit: u64,
    /// Something in it has changed since its block was written.
    stale: bool,
    /// The node above it; `None` when nothing in it is solid.
    node: Option<TileNode>,
    block: Option<Written>,
    total: Total,
}

/// The sums over all tiles of a part of the tree.
#[derive(Clone, Copy)]
struct Total {
    bounds: [[i64; 3]; 2],
    live: usize,
    nodes: usize,
}

/// A change of a tile.
struct Change<'t> {
    tile: Option<&'t Arc<LiveTile>>,
    /// Blocks that it leaves without use.
    given_up: &'t mut Vec<Written>,
    relist: &'t mut bool,
}

/// Where blocks are written.
struct Writer<'d> {
    pool: &'d Pool,
    version: u64,
    given_up: &'d mut Vec<Written>,
    words: &'d mut u64,
}

impl TileDirectory {
    /// One without a tile.
    pub(crate) fn new(cube: Cube) -> Self {
        let (root, given_up, lights) = (Branch::default(), Vec::new(), Vec::new());
        Self { cube, root, block: None, given_up, words: 0, lights, relist: false }
    }

    /// Its cube.
    pub(crate) fn cube(&self) -> &Cube {
        &self.cube
    }

    /// Goes over to another cube, without a tile.
    pub(crate) fn clear(&mut self, cube: Cube) {
        let Self { root, block, given_up, words, .. } = std::mem::replace(self, Self::new(cube));
        (self.given_up, self.words, self.relist) = (given_up, words, true);
        self.given_up.extend(block);
        root.give_up(&mut self.given_up);
    }

    /// Puts a tile in its place, or removes the one there. A tile outside the cube is left out.
    pub(crate) fn set(&mut self, key: TileKey, tile: Option<&Arc<LiveTile>>) {
        let Some(path) = self.cube.path(key) else { return };
        let change = Change { tile, given_up: &mut self.given_up, relist: &mut self.relist };
        self.root.set(path, self.cube.height() - key.level, change);
    }

    /// Writes the changes since the last time, for a publication of this version. Without enough room, the rest is written the next time.
    #[expect(clippy::cast_possible_truncation, reason = "coordinates are clamped to 32 bits")]
    pub(crate) fn write(&mut self, pool: &Pool, version: u64) -> Option<Placed> {
        let height = self.cube.height();
        let writer = &mut Writer { pool, version, given_up: &mut self.given_up, words: &mut self.words };
        self.root.write(height, self.cube.origin.map(i64::from), writer)?;
        let Total { bounds, live, nodes, .. } = self.root.total(height, self.cube.origin.map(i64::from));
        let root = self.root.node().unwrap_or_default();
        let root = writer.replace(&mut self.block, &[root])?;
        if std::mem::take(&mut self.relist) {
            let mut levels = vec![Vec::new(); height as usize + 1];
            self.root.list(&mut levels);
            self.lights = levels.concat();
        }
        let bounds = if live > 0 {
            bounds.map(|corner| corner.map(|c| c.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32))
        } else {
            [[0; 3], [-1; 3]]
        };
        Some(Placed { root, nodes: nodes + 1, bounds, live, words: std::mem::take(&mut self.words) })
    }

    /// The lamps of the last write.
    pub(crate) fn lights(&self) -> &[LightGroup] {
        &self.lights
    }

    /// Blocks that the next write does not reach.
    pub(crate) fn given_up(&mut self) -> Vec<Written> {
        std::mem::take(&mut self.given_up)
    }
}

impl Branch {
    /// Puts a tile `depth` levels below. `path` has the child numbers down to it. Says whether anything is another now.
    #[expect(clippy::cast_possible_truncation, reason = "the six lowest bits are kept")]
    fn set(&mut self, path: u128, depth: u32, change: Change) -> bool {
        let Some(above) = depth.checked_sub(1) else { return self.set_own(change) };
        if change.tile.is_none() && self.below.is_none() {
            return false;
        }
        let group = self.below.get_or_insert_default();
        let number = (path >> (6 * above)) as u32 & 63;
        let at = group.at(number);
        if group.mask >> number & 1 == 0 {
            if change.tile.is_none() {
                return false;
            }
            group.mask |= 1 << number;
            group.branches.insert(at, Self::default());
        }
        let given_up = &mut *change.given_up;
        let branch = &mut group.branches[at];
        if !branch.set(path, above, Change { given_up: &mut *given_up, ..change }) {
            return false;
        }
        group.stale = true;
        if branch.tile.is_none() && branch.below.is_none() {
            group.branches.remove(at);
            group.mask &= !(1 << number);
        }
        if group.mask == 0 {
            given_up.extend(group.block.take());
            self.below = None;
        }
        true
    }

    fn set_own(&mut self, Change { tile, relist, .. }: Change) -> bool {
        let same = match (&self.tile, tile) {
            (Some(before), Some(now)) => Arc::ptr_eq(before, now),
            (before, now) => before.is_none() && now.is_none(),
        };
        if !same {
            let lit = |tile: Option<&Arc<LiveTile>>| tile.is_some_and(|tile| !tile.lights.is_empty());
            // A tile that comes or goes hides or bares lamps of others.
            let (before, now) = (self.tile.as_ref(), tile);
            *relist |= lit(before) || lit(now) || before.is_some() != now.is_some();
            self.tile = tile.cloned();
            if let Some(below) = &mut self.below {
                below.stale = true;
            }
        }
        !same
    }

    /// Whether it is shown below a place that has a tile or has none.
    fn is_shown(&self, base: Option<&LiveTile>) -> bool {
        self.tile.is_some() || base.is_none()
    }

    /// Its node, when all below is written.
    fn node(&self) -> Option<TileNode> {
        match &self.below {
            Some(below) => below.node,
            None => self.tile.as_ref()?.node,
        }
    }

    fn write(&mut self, level: u32, origin: [i64; 3], writer: &mut Writer) -> Option<()> {
        match &mut self.below {
            Some(below) if below.stale => below.write(self.tile.as_deref(), level, origin, writer),
            _ => Some(()),
        }
    }

    /// Whether there are lamps in it, when all below is written.
    fn is_lit(&self) -> bool {
        self.tile.as_ref().is_some_and(|tile| !tile.lights.is_empty())
            || self.below.as_ref().is_some_and(|below| below.lit != 0)
    }

    /// The sums over all of it, once everything below is written.
    fn total(&self, level: u32, origin: [i64; 3]) -> Total {
        let mut total = self.below.as_ref().map_or_else(Total::default, |below| below.total);
        if let Some(tile) = &self.tile {
            total.add(tile, level, origin);
        }
        total
    }

    /// Lists the lamps that are shown, each for its level: a level has as many below it as there are lists before its own.
    fn list(&self, levels: &mut [Vec<LightGroup>]) {
        let Some((own, finer)) = levels.split_last_mut() else { return };
        if let Some(tile) = &self.tile {
            let over = self.below.as_ref().map_or(0, |below| below.tiles());
            own.extend(tile.lights.iter().filter(|(child, _)| over >> child & 1 == 0).map(|(_, group)| *group));
        }
        if let Some(below) = &self.below {
            for number in Bits(below.lit) {
                let branch = &below.branches[below.at(number)];
                if branch.is_shown(self.tile.as_deref()) {
                    branch.list(finer);
                }
            }
        }
    }

    fn give_up(self, given_up: &mut Vec<Written>) {
        if let Some(below) = self.below {
            given_up.extend(below.block);
            below.branches.into_iter().for_each(|branch| branch.give_up(given_up));
        }
    }
}

impl Group {
    /// The place of the branch of a number, or the place where it would be.
    fn at(&self, number: u32) -> usize {
        (self.mask & ((1 << number) - 1)).count_ones() as usize
    }

    /// Which branches have a tile.
    fn tiles(&self) -> u64 {
        let of = |(number, branch): (u32, &Branch)| u64::from(branch.tile.is_some()) << number;
        Bits(self.mask).zip(&self.branches).map(of).sum()
    }

    /// Writes the nodes below a place, where they lie over those of the coarser tile that it has.
    fn write(&mut self, base: Option<&LiveTile>, level: u32, origin: [i64; 3], writer: &mut Writer) -> Option<()> {
        let mut total = Total::default();
        self.lit = 0;
        for (number, branch) in Bits(self.mask).zip(&mut self.branches) {
            let (cell, edge) = (child_cell(number), TileKey::edge(level - 1));
            let origin = [0, 1, 2].map(|i| origin[i] + i64::from(cell[i]) * edge);
            branch.write(level - 1, origin, writer)?;
            self.lit |= u64::from(branch.is_lit()) << number;
            let of = branch.total(level - 1, origin);
            total = total.and(Total { nodes: if branch.is_shown(base) { of.nodes } else { 0 }, ..of });
        }
        let mut mask = 0;
        let mut nodes = Vec::with_capacity(64);
        let over = base.map_or(self.mask, |_| self.tiles());
        if over != 0 {
            let mut branches = Bits(self.mask).zip(&self.branches).peekable();
            for number in 0..64 {
                let own = branches.next_if(|(of, _)| *of == number).filter(|_| over >> number & 1 == 1);
                let node = match own {
                    Some((_, branch)) => branch.node(),
                    None => base.and_then(|tile| tile.child(number)),
                };
                if let Some(node) = node {
                    mask |= 1 << number;
                    nodes.push(node);
                }
            }
            let first = writer.replace(&mut self.block, &nodes)?;
            self.node = (mask != 0).then(|| TileNode::of_children(mask, first));
        } else {
            // All of it waits for tiles between it and the one that is shown.
            writer.given_up.extend(self.block.take());
            (self.node, total.nodes) = (base.and_then(|tile| tile.node), 0);
        }
        total.nodes += nodes.len();
        self.total = total;
        self.stale = false;
        Some(())
    }
}

impl Writer<'_> {
    /// Writes nodes to a block in place of another one, and gives the number of the first.
    #[expect(clippy::cast_possible_truncation, reason = "a node has at most 64 children of four words")]
    fn replace(&mut self, block: &mut Option<Written>, nodes: &[TileNode]) -> Option<u32> {
        let mut first = 0;
        let mut written = None;
        if !nodes.is_empty() {
            let words = bytemuck::cast_slice(nodes);
            let block = self.pool.allocate(words.len() as u32)?;
            self.pool.write(&block, words);
            *self.words += words.len() as u64;
            first = self.pool.address(&block) / 4;
            written = Some(Written { block, version: self.version });
        }
        self.given_up.extend(std::mem::replace(block, written));
        Some(first)
    }
}

impl Default for Total {
    fn default() -> Self {
        Self { bounds: [[i64::MAX; 3], [i64::MIN; 3]], live: 0, nodes: 0 }
    }
}

impl Total {
    fn and(self, other: Self) -> Self {
        let [low, high] = [0, 1].map(|end| [0, 1, 2].map(|i| (self.bounds[end][i], other.bounds[end][i])));
        Self {
            bounds: [low.map(|(a, b)| a.min(b)), high.map(|(a, b)| a.max(b))],
            live: self.live + other.live,
            nodes: self.nodes + other.nodes,
        }
    }

    fn add(&mut self, tile: &LiveTile, level: u32, origin: [i64; 3]) {
        if tile.node.is_some() {
            // A ray that leaves coarse land upwards would go on for long beyond the end of the tile.
            let Bounds { min, max } = tile.cells;
            let cell = cell_edge(level);
            let bounds =
                [[0, 1, 2].map(|i| origin[i] + min[i] * cell), [0, 1, 2].map(|i| origin[i] + max[i] * cell - 1)];
            *self = self.and(Self { bounds, live: 1, ..Self::default() });
        }
    }
}

#[cfg(test)]
mod tests;
