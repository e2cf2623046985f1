//! The buffer that all tiles live in: header, palette, full run, and blocks of words that come and go.

use std::sync::{Arc, Mutex, PoisonError};

use offset_allocator::{Allocation, Allocator};
use raxel_world::Material;
use raxel_world::layout::{FULL_RUN_WORDS, MATERIAL_WORDS, Tree64Header, full_run, palette};

/// Where the words of the pool are.
pub trait PoolMemory: Send + Sync {
    /// Takes words for the buffer, from the word `at` on, which nobody else reads or writes meanwhile. May wait for the device.
    fn write(&self, at: u32, words: &[u32]);

    /// Returns when every frame that is submitted from now on sees all words that were taken before. Never waits for the device.
    fn flush(&self) {}
}

/// Words of the unit of allocation: a node.
const UNIT: u32 = 4;

/// Most of the pool that tiles take, in percent.
const TILES: u64 = 95;

/// Blocks that can be there at once.
const MOST_BLOCKS: u32 = 1 << 20;

/// What freed words are overwritten with where that is asked for: whoever still reads them shows it.
const POISON: u32 = 0xdead_beef;

/// Hands out blocks of a buffer and keeps account of them.
pub struct Pool {
    memory: Arc<dyn PoolMemory>,
    allocator: Mutex<Account>,
    /// Words behind the header before the first block.
    first: u32,
    full_run: u32,
    capacity: u32,
    poison: bool,
}

struct Account {
    allocator: Allocator,
    used: u32,
    peak: u32,
    failed: u64,
}

/// Words of the pool. It is given back to [`Pool::free`], or lost to the pool.
#[derive(Debug)]
#[must_use = "a block that is dropped is lost to the pool"]
pub struct Block {
    allocation: Held,
    units: u32,
}

#[derive(Clone, Copy)]
struct Held(Allocation);

impl std::fmt::Debug for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0.offset)
    }
}

impl Pool {
    /// A pool in a buffer of so many words, which has room for the header and the palette at least. `poison` overwrites what is freed.
    pub fn new(memory: Arc<dyn PoolMemory>, words: u32, materials: &[Material], poison: bool) -> Self {
        let palette = palette(materials);
        let full_run_at = (palette.len() as u32).next_multiple_of(UNIT);
        // A node without children, which is the root of the empty world that is shown at first.
        let empty_root = full_run_at + FULL_RUN_WORDS;
        let first = empty_root + UNIT;
        let capacity = words.saturating_sub(Tree64Header::WORDS + first) / UNIT;
        memory.write(Tree64Header::WORDS, &palette);
        memory.write(Tree64Header::WORDS + full_run_at, &full_run());
        memory.write(Tree64Header::WORDS + empty_root, &[0; UNIT as usize]);
        let header = Tree64Header {
            origin: [0; 3],
            log2_size: 6,
            bounds_min: [0; 3],
            material_count: materials.len() as u32,
            bounds_last: [-1; 3],
            materials_at: 0,
            root: empty_root / UNIT,
            node_count: 1,
            leaf_count: 0,
            unused: 0,
        };
        memory.write(0, bytemuck::cast_slice(std::slice::from_ref(&header)));
        memory.flush();
        let allocator = Allocator::with_max_allocs(capacity.max(1), MOST_BLOCKS);
        let account = Account { allocator, used: 0, peak: 0, failed: 0 };
        Self { memory, allocator: Mutex::new(account), first, full_run: full_run_at, capacity, poison }
    }

    /// Bytes of a pool with room for so many bytes of tiles, and so many materials.
    pub fn bytes_for(tiles: u64, materials: usize) -> u64 {
        let before =
            Tree64Header::WORDS + (MATERIAL_WORDS * materials as u32).next_multiple_of(UNIT) + FULL_RUN_WORDS + UNIT;
        tiles * 100 / TILES + 4 * u64::from(before)
    }

    /// A block for a tile of so many words; `None` when there is no room for it. A part of the pool is left for directories, without
    /// which no tile would ever be given up.
    pub fn allocate_tile(&self, words: u32) -> Option<Block> {
        let mut account = self.account();
        if u64::from(account.used + words.div_ceil(UNIT)) * 100 > u64::from(self.capacity) * TILES {
            account.failed += 1;
            return None;
        }
        Self::take(&mut account, words)
    }

    /// A block of at least so many words; `None` when there is no room for it.
    pub fn allocate(&self, words: u32) -> Option<Block> {
        Self::take(&mut self.account(), words)
    }

    fn take(account: &mut Account, words: u32) -> Option<Block> {
        let units = words.div_ceil(UNIT).max(1);
        let Some(allocation) = account.allocator.allocate(units) else {
            account.failed += 1;
            return None;
        };
        account.used += units;
        account.peak = account.peak.max(account.used);
        Some(Block { allocation: Held(allocation), units })
    }

    /// Takes a block back that no frame reads any more.
    #[allow(clippy::needless_pass_by_value, reason = "a block that was given back cannot be used again")]
    pub fn free(&self, block: Block) {
        if self.poison {
            self.write(&block, &vec![POISON; (block.units * UNIT) as usize]);
        }
        let mut account = self.account();
        account.used -= block.units;
        account.allocator.free(block.allocation.0);
    }

    /// The first word of a block, behind the header: a multiple of 4.
    pub fn address(&self, block: &Block) -> u32 {
        self.first + block.allocation.0.offset * UNIT
    }

    /// Writes the words of a block.
    pub fn write(&self, block: &Block, words: &[u32]) {
        debug_assert!(words.len() <= (block.units * UNIT) as usize);
        self.memory.write(Tree64Header::WORDS + self.address(block), words);
    }

    /// Makes all that was written visible to every frame that is submitted from now on.
    pub fn flush(&self) {
        self.memory.flush();
    }

    /// The address of the full run.
    pub fn full_run(&self) -> u32 {
        self.full_run
    }

    /// Bytes of blocks that there is room for.
    pub fn capacity(&self) -> u64 {
        u64::from(self.capacity * UNIT) * 4
    }

    /// Bytes of blocks that are handed out, most of them at any time, and how often there was no room.
    pub fn usage(&self) -> (u64, u64, u64) {
        let account = self.account();
        let bytes = |units: u32| u64::from(units) * u64::from(UNIT) * 4;
        (bytes(account.used), bytes(account.peak), account.failed)
    }

    fn account(&self) -> std::sync::MutexGuard<'_, Account> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
