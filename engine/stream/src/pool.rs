//! The buffer that all tiles live in: header, palette, full run, and blocks of words that come and go. That of their lamps is another one.

use std::sync::{Arc, Mutex, PoisonError};

use offset_allocator::{Allocation, Allocator};
use raxel_layouts::lights::{HEADER_WORDS, LIGHT_WORDS};
use raxel_layouts::{FULL_RUN_WORDS, MATERIAL_WORDS, Tree64Header, full_run, palette};
use raxel_world::Material;

/// Where the words of the pool are.
pub trait PoolMemory: Send + Sync {
    /// Takes words for the buffer, from the word `at` on. Nothing else reads or writes these meanwhile. May wait for the device.
    fn write(&self, at: u32, words: &[u32]);

    /// Returns when every frame that is submitted from now on sees all words that were taken before. Never waits for the device.
    fn flush(&self) {}
}

/// Words of a node, the unit of allocation for tiles.
const NODE: u32 = 4;

/// The part of the pool that is for tiles, in percent. The rest is for directories. Without a new directory, no released block ever
/// becomes free, and between tiles that come and go there is soon no place for one.
const TILES: u64 = 95;

/// The part of a pool of lamps that is for lights, in percent: a table of groups has half of the words of the lights at most, and two of them
/// may be there at once.
const LIGHTS: u64 = 50;

/// Blocks that can be there at once.
const MOST_BLOCKS: u32 = 1 << 20;

/// Freed words are overwritten with this on request: a reader of them shows it.
const POISON: u32 = 0xdead_beef;

/// Figures about a pool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoolStats {
    /// Bytes of blocks that are handed out.
    pub used: u64,
    /// The most bytes that were ever handed out.
    pub peak: u64,
    /// Bytes of blocks that there is room for.
    pub capacity: u64,
    /// How often there was no room.
    pub failed: u64,
}

/// Hands out blocks of a buffer and keeps account of them.
pub(crate) struct Pool {
    memory: Arc<dyn PoolMemory>,
    allocator: Mutex<Account>,
    form: Form,
    full_run: u32,
    capacity: u32,
    poison: bool,
}

/// How a buffer is divided.
#[derive(Clone, Copy)]
struct Form {
    /// Words of the header.
    header: u32,
    /// Words behind the header before the first block.
    first: u32,
    /// Words of the unit of allocation.
    unit: u32,
    /// The part for blocks that are no directories, in percent.
    most: u64,
}

struct Account {
    tiles: Part,
    directories: Part,
    peak: u32,
    failed: u64,
}

/// A part of the pool.
struct Part {
    allocator: Allocator,
    /// Its first unit.
    first: u32,
    used: u32,
}

/// Words of the pool. It is returned to [`Pool::free`], or lost to the pool.
#[derive(Debug)]
#[must_use = "a block that is dropped is lost to the pool"]
pub(crate) struct PoolBlock {
    allocation: Held,
    units: u32,
    /// The first of them in the pool.
    first: u32,
}

#[derive(Clone, Copy)]
struct Held(Allocation);

impl std::fmt::Debug for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0.offset)
    }
}

impl Pool {
    /// A pool in a buffer of `words` words, which has room for the header and the palette at least. `poison` overwrites freed words.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most 2¹⁶ materials of a few words each")]
    pub(crate) fn new(memory: Arc<dyn PoolMemory>, words: u32, materials: &[Material], poison: bool) -> Self {
        let palette = palette(materials);
        let full_run_at = (palette.len() as u32).next_multiple_of(NODE);
        // A node without children, which is the root of the empty world that is shown at first.
        let empty_root = full_run_at + FULL_RUN_WORDS;
        let form = Form { header: Tree64Header::WORDS, first: empty_root + NODE, unit: NODE, most: TILES };
        memory.write(Tree64Header::WORDS, &palette);
        memory.write(Tree64Header::WORDS + full_run_at, &full_run());
        memory.write(Tree64Header::WORDS + empty_root, &[0; NODE as usize]);
        let header = Tree64Header {
            origin: [0; 3],
            log2_size: 6,
            bounds_min: [0; 3],
            material_count: materials.len() as u32,
            bounds_last: [-1; 3],
            materials_at: 0,
            root: empty_root / NODE,
            node_count: 1,
            leaf_count: 0,
            unused: 0,
        };
        memory.write(0, bytemuck::cast_slice(std::slice::from_ref(&header)));
        memory.flush();
        Self { full_run: full_run_at, ..Self::blocks(memory, words, form, poison) }
    }

    /// A pool for lamps in a buffer of `words` words, which lists none at first. A light is the unit of allocation.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most 2¹⁶ materials of a few words each")]
    pub(crate) fn of_lamps(memory: Arc<dyn PoolMemory>, words: u32, poison: bool) -> Self {
        let form = Form { header: HEADER_WORDS as u32, first: 0, unit: LIGHT_WORDS as u32, most: LIGHTS };
        memory.write(0, &[0; HEADER_WORDS]);
        memory.flush();
        Self::blocks(memory, words, form, poison)
    }

    #[expect(clippy::cast_possible_truncation, reason = "it is a part of the capacity, which has 32 bits")]
    fn blocks(memory: Arc<dyn PoolMemory>, words: u32, form: Form, poison: bool) -> Self {
        let capacity = words.saturating_sub(form.header + form.first) / form.unit;
        let tiles = (u64::from(capacity) * form.most / 100) as u32;
        let part = |first: u32, units: u32| {
            let allocator = Allocator::with_max_allocs(units.max(1), units.clamp(64, MOST_BLOCKS));
            Part { allocator, first, used: 0 }
        };
        let account = Account { tiles: part(0, tiles), directories: part(tiles, capacity - tiles), peak: 0, failed: 0 };
        Self { memory, allocator: Mutex::new(account), form, full_run: 0, capacity, poison }
    }

    /// Bytes of a pool with room for `tiles` bytes of tiles, and `materials` materials.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most 2¹⁶ materials of a few words each")]
    pub(crate) fn bytes_for(tiles: u64, materials: usize) -> u64 {
        let before =
            Tree64Header::WORDS + (MATERIAL_WORDS * materials as u32).next_multiple_of(NODE) + FULL_RUN_WORDS + NODE;
        tiles * 100 / TILES + 4 * u64::from(before)
    }

    /// A block of `words` words for a tile; `None` when there is no room for it. A part of the pool is left for directories, without which
    /// no tile would ever be given up.
    pub(crate) fn allocate_tile(&self, words: u32) -> Option<PoolBlock> {
        let mut account = self.account();
        let block = account.tiles.take(words.div_ceil(self.form.unit));
        account.count(block)
    }

    /// A block of at least `words` words for a part of a directory, or a table; `None` when there is no room for it.
    pub(crate) fn allocate(&self, words: u32) -> Option<PoolBlock> {
        let (mut account, units) = (self.account(), words.div_ceil(self.form.unit));
        let block = account.directories.take(units).or_else(|| account.tiles.take(units));
        account.count(block)
    }

    /// Words that tiles can take until four fifths of their part are used. That is less than the room. Otherwise, a refused tile would be
    /// requested when it only just fits, and refused again.
    pub(crate) fn spare_words(&self) -> u64 {
        let most = u64::from(self.capacity) * self.form.most / 125;
        most.saturating_sub(u64::from(self.account().tiles.used)) * u64::from(self.form.unit)
    }

    /// Takes a block back that no frame reads any more.
    #[allow(clippy::needless_pass_by_value, reason = "a block that was given back cannot be used again")]
    pub(crate) fn free(&self, block: PoolBlock) {
        if self.poison {
            self.write(&block, &vec![POISON; (block.units * self.form.unit) as usize]);
        }
        let mut account = self.account();
        let is_tile = block.first < account.directories.first;
        let part = if is_tile { &mut account.tiles } else { &mut account.directories };
        part.used -= block.units;
        part.allocator.free(block.allocation.0);
    }

    /// The first word of a block, behind the header: a multiple of 4, and of 8 in a pool of lamps.
    pub(crate) fn address(&self, block: &PoolBlock) -> u32 {
        self.form.first + block.first * self.form.unit
    }

    /// Writes the words of a block.
    pub(crate) fn write(&self, block: &PoolBlock, words: &[u32]) {
        debug_assert!(words.len() <= (block.units * self.form.unit) as usize);
        self.memory.write(self.form.header + self.address(block), words);
    }

    /// Makes all that was written visible to every frame that is submitted from now on.
    pub(crate) fn flush(&self) {
        self.memory.flush();
    }

    /// The address of the full run, in a pool for tiles.
    pub(crate) fn full_run(&self) -> u32 {
        self.full_run
    }

    /// Bytes of blocks that there is room for.
    pub(crate) fn capacity(&self) -> u64 {
        u64::from(self.capacity) * u64::from(self.form.unit) * 4
    }

    /// How full it is.
    pub(crate) fn stats(&self) -> PoolStats {
        let account = self.account();
        let bytes = |units: u32| u64::from(units) * u64::from(self.form.unit) * 4;
        PoolStats {
            used: bytes(account.used()),
            peak: bytes(account.peak),
            capacity: self.capacity(),
            failed: account.failed,
        }
    }

    fn account(&self) -> std::sync::MutexGuard<'_, Account> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Account {
    fn used(&self) -> u32 {
        self.tiles.used + self.directories.used
    }

    /// Notes the result of an attempt.
    fn count(&mut self, block: Option<PoolBlock>) -> Option<PoolBlock> {
        self.peak = self.peak.max(self.used());
        self.failed += u64::from(block.is_none());
        block
    }
}

impl Part {
    fn take(&mut self, units: u32) -> Option<PoolBlock> {
        let units = units.max(1);
        let allocation = self.allocator.allocate(units)?;
        self.used += units;
        Some(PoolBlock { allocation: Held(allocation), units, first: self.first + allocation.offset })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nowhere;

    impl PoolMemory for Nowhere {
        fn write(&self, _at: u32, _words: &[u32]) {}
    }

    #[test]
    fn a_directory_finds_a_place_however_scattered_the_free_words_are() {
        let pool = Pool::new(Arc::new(Nowhere), 100_000, &[Material::air()], false);
        let mut tiles: Vec<Option<PoolBlock>> = std::iter::from_fn(|| pool.allocate_tile(200)).map(Some).collect();
        assert!(tiles.len() > 400, "{}", tiles.len());
        tiles.iter_mut().step_by(2).filter_map(Option::take).for_each(|tile| pool.free(tile));
        assert!(pool.allocate_tile(2000).is_none(), "no two free blocks lie side by side");
        let directory = pool.allocate(2000).expect("there is a part for it");
        let end = u64::from(pool.address(&directory)) + 2000;
        assert!(end <= 100_000 - 16);
        let stats = pool.stats();
        assert!(stats.used <= stats.peak && stats.peak <= stats.capacity && stats.failed == 2, "{stats:?}");
        pool.free(directory);
        tiles.into_iter().flatten().for_each(|tile| pool.free(tile));
        assert_eq!(pool.stats().used, 0);
        // All of it can be had again, and no block lies in another.
        let mut taken: Vec<u32> = std::iter::from_fn(|| pool.allocate_tile(200))
            .chain(std::iter::from_fn(|| pool.allocate(200)))
            .map(|block| pool.address(&block))
            .collect();
        taken.sort_unstable();
        assert!(taken.len() > 400 && taken.windows(2).all(|pair| pair[1] - pair[0] >= 200));
    }
}
