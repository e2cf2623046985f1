//! A directory that follows changes against one that is made from all tiles at once.

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::Mutex;

use raxel_world::random::SplitMix64;
use raxel_world::{Bounds, ChunkPos, Material};

use super::*;
use crate::pool::PoolMemory;

/// The upper nodes made from all tiles at once, level by level, with addresses relative to their own first one.
#[derive(Debug)]
struct Reference {
    nodes: Vec<TileNode>,
    /// Whether the address of the children of each is relative.
    relative: Vec<bool>,
    root: u32,
    /// Smallest and largest voxel of tiles with solids; in an empty world the largest is smaller.
    bounds: [[i32; 3]; 2],
    /// Tiles with solids that it reaches.
    live: usize,
    /// The lamps of the shown tiles.
    lights: Vec<LightGroup>,
    /// The overlays of the lamps of coarse tiles: their level, and the path of the child that a finer tile replaces.
    overlaid: HashSet<(u32, u128)>,
}

/// A node on the way up: its path from the root.
#[derive(Clone, Copy)]
struct Item {
    path: u128,
    node: Option<TileNode>,
    relative: bool,
}

impl Reference {
    /// The directory of tiles up to a level. A tile hides its part of the coarser tile around it. If the tile one level above is missing,
    /// a still coarser tile is shown.
    fn of<'t>(cube: &Cube, top: u32, tiles: impl Iterator<Item = (TileKey, &'t LiveTile)>) -> Self {
        let mut levels: Vec<Vec<(u128, &LiveTile)>> = vec![Vec::new(); top as usize + 1];
        let mut bounds = [[i64::MAX; 3], [i64::MIN; 3]];
        let mut live = 0;
        for (key, tile) in tiles {
            let Some(path) = cube.path(key) else { continue };
            levels[key.level as usize].push((path, tile));
            if tile.node.is_some() {
                live += 1;
                // A ray that leaves coarse land upwards would go on for long beyond the end of the tile.
                let (origin, cell) = (key.origin(), cell_edge(key.level));
                for i in 0..3 {
                    bounds[0][i] = bounds[0][i].min(origin[i] + tile.cells.min[i] * cell);
                    bounds[1][i] = bounds[1][i].max(origin[i] + tile.cells.max[i] * cell - 1);
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
        // Hidden tiles, by the level and the path of the missing tile around them.
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
}

struct Words(Mutex<Vec<u32>>);

impl PoolMemory for Words {
    fn write(&self, at: u32, words: &[u32]) {
        self.0.lock().expect("no writer panics")[at as usize..][..words.len()].copy_from_slice(words);
    }
}

const HEADER: usize = raxel_layouts::Tree64Header::WORDS as usize;
const WORDS: u32 = 1 << 17;
const TOP: u32 = 2;

/// Compares the part that is reached from a node with the reference, and returns its number of nodes.
fn compare(reference: &Reference, of: u32, words: &[u32], at: u32) -> usize {
    let node = |at: u32| TileNode(words[HEADER + 4 * at as usize..][..4].try_into().expect("four words"));
    let (wanted, found) = (reference.nodes[of as usize], node(at));
    if !reference.relative[of as usize] {
        assert_eq!(wanted, found);
        return 1;
    }
    assert_eq!((wanted.mask(), wanted.0[3]), (found.mask(), found.0[3]));
    let below = (0..wanted.mask().count_ones()).map(|n| compare(reference, wanted.0[2] + n, words, found.0[2] + n));
    1 + below.sum::<usize>()
}

/// One that may be a part of others, and may be outside the cube.
fn key(random: &mut SplitMix64) -> TileKey {
    let level = random.below(u64::from(TOP) + 1) as u32;
    let mut pos = [0; 3].map(|_| random.below(3) as i32 - 1);
    for _ in level..TOP {
        pos = pos.map(|c| 4 * c + random.below(2) as i32);
    }
    if random.below(20) == 0 {
        pos[0] += 64 << (2 * (TOP - level));
    }
    TileKey { level, pos: ChunkPos::new(pos[0], pos[1], pos[2]) }
}

fn tile(random: &mut SplitMix64, level: u32) -> Arc<LiveTile> {
    let mask = random.bits() & random.bits();
    let node = match random.below(6) {
        0 => None,
        1 => Some(TileNode::filled(1 + random.below(5) as u16)),
        _ => Some(TileNode::of_children(mask, random.below(1 << 20) as u32)),
    };
    let filled = node.is_none_or(|node| node.filled_material().is_some());
    let child = |n: u32| TileNode::of_children(u64::from(n) + 1, random.below(1 << 20) as u32);
    let children = if level == 0 || filled { [].into() } else { (0..mask.count_ones()).map(child).collect() };
    let min = [0; 3].map(|_| random.below(64).cast_signed());
    let cells = Bounds { min, max: min.map(|min| min + 1 + random.below(64 - min.unsigned_abs()).cast_signed()) };
    let mut group = || LightGroup { first: random.bits() as u32, count: 1, power: 1.0 };
    let lights = match (mask & 3, level) {
        (0, 0) => [(0, group())].into(),
        (0, _) => Bits(mask).map(|number| (number, group())).collect(),
        _ => [].into(),
    };
    Arc::new(LiveTile { node, cells, children, lights })
}

/// The state that a frame in flight reads.
struct InFlight {
    version: u64,
    root: u32,
    reference: Reference,
}

#[test]
fn what_follows_changes_is_what_all_tiles_at_once_make() {
    for seed in 0..16 {
        let mut random = SplitMix64::new(seed);
        let memory = Arc::new(Words(Mutex::new(vec![0; WORDS as usize])));
        let pool = Pool::new(memory.clone(), WORDS, &[Material::air()], true);
        let mut cube = Cube { origin: [-8192; 3], log2_size: 14 };
        let mut directory = TileDirectory::new(cube);
        let mut tiles: BTreeMap<TileKey, Arc<LiveTile>> = BTreeMap::new();
        let mut retired: VecDeque<(u64, PoolBlock)> = VecDeque::new();
        let mut in_flight: VecDeque<InFlight> = VecDeque::new();
        let (mut version, mut refused) = (0, 0);
        for step in 0..150 {
            for _ in 0..random.below(12) {
                let key = key(&mut random);
                match random.below(3) {
                    0 => tiles.remove(&key),
                    _ => tiles.insert(key, tile(&mut random, key.level)),
                };
                directory.set(key, tiles.get(&key));
            }
            if random.below(10) == 0 {
                let origin = [0; 3].map(|_| (random.below(4) as i32 - 9) * 1024);
                cube = Cube { origin, log2_size: if random.below(2) == 0 { 14 } else { 16 } };
                directory.clear(cube);
                tiles.iter().for_each(|(key, tile)| directory.set(*key, Some(tile)));
            }
            if step == 100 {
                tiles.keys().for_each(|key| directory.set(*key, None));
                tiles.clear();
                assert!(directory.root.below.is_none(), "nothing is kept of what is gone");
            }
            // Sometimes there is room for a part of it at first, or for nothing.
            let taken: Vec<PoolBlock> = match random.below(3) {
                0 => std::iter::from_fn(|| pool.allocate(4)).collect(),
                _ => Vec::new(),
            };
            let left = random.index(20);
            let mut taken = taken.into_iter();
            taken.by_ref().take(left).for_each(|block| pool.free(block));
            let mut placed = directory.write(&pool, version + 1);
            taken.for_each(|block| pool.free(block));
            if placed.is_none() {
                refused += 1;
                let key = key(&mut random);
                tiles.remove(&key);
                directory.set(key, None);
                placed = directory.write(&pool, version + 1);
            }
            let placed = placed.expect("there is room for it");
            for given_up in directory.given_up() {
                if given_up.version > version {
                    pool.free(given_up.block);
                } else {
                    retired.push_back((version + 1, given_up.block));
                }
            }
            version += 1;
            let reference = Reference::of(&cube, TOP, tiles.iter().map(|(key, tile)| (*key, &**tile)));
            assert_eq!((placed.bounds, placed.live), (reference.bounds, reference.live));
            assert!(directory.lights() == reference.lights, "step {step}: other lamps");
            let words = memory.0.lock().expect("no writer panics").clone();
            let nodes = compare(&reference, reference.root, &words, placed.root);
            assert_eq!(placed.nodes, nodes, "step {step}");
            in_flight.push_back(InFlight { version, root: placed.root, reference });
            // Those before are unchanged.
            for InFlight { root, reference, .. } in &in_flight {
                compare(reference, reference.root, &words, *root);
            }
            while in_flight.len() > random.index(4) + 1 {
                in_flight.pop_front();
            }
            let released = in_flight[0].version;
            while retired.front().is_some_and(|(of, _)| *of <= released) {
                pool.free(retired.pop_front().expect("there is one").1);
            }
        }
        assert!(refused > 5, "{refused}");
        directory.clear(cube);
        directory.given_up().into_iter().for_each(|given_up| pool.free(given_up.block));
        retired.into_iter().for_each(|(_, block)| pool.free(block));
        assert_eq!(pool.stats().used, 0, "nothing is lost");
    }
}

#[test]
fn a_changed_tile_costs_the_way_up_from_it() {
    let mut random = SplitMix64::new(1);
    let memory = Arc::new(Words(Mutex::new(vec![0; WORDS as usize])));
    let pool = Pool::new(memory, WORDS, &[Material::air()], false);
    let cube = Cube { origin: [-8192; 3], log2_size: 14 };
    let mut directory = TileDirectory::new(cube);
    let keys: Vec<TileKey> =
        (0..16 * 16 * 4).map(|n| TileKey { level: 0, pos: ChunkPos::new(n % 16, n / 256, n / 16 % 16) }).collect();
    for key in &keys {
        directory.set(*key, Some(&tile(&mut random, 0)));
    }
    let all = directory.write(&pool, 1).expect("there is room").words;
    directory.set(keys[77], Some(&tile(&mut random, 0)));
    let one = directory.write(&pool, 2).expect("there is room").words;
    // 64 chunks, the 16 parts of the level above, and one node on each of the levels above that.
    assert!(all > 3000 && one <= 4 * (64 + 16 + 3), "{all} words, then {one}");
    assert_eq!(directory.write(&pool, 3).expect("there is room").words, 4, "its root alone");
}
