//! The hash table of `shaders/include/raxel/internal/table.glsl`: from places in the world's cube to addresses. It also has each cube of 8, 64,
//! 512, … places a side with a place in it. So a ray leaves empty space in long steps.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::live::Patch;

/// Words of a slot: three of a key, one of a value.
pub(super) const SLOT_WORDS: usize = 4;
/// Value of a slot without an entry.
const NO_ENTRY: u32 = u32::MAX;

type Key = [u32; 3];

/// The entries of a table that is yet to be written.
pub struct Table {
    entries: BTreeMap<Key, u32>,
}

impl Table {
    /// From cells of 2^`log2_cell` voxels, counted from the corner of a cube of 2^`log2_size` voxels, with a value for each, which is
    /// less than 2³² − 1.
    pub fn new(cells: impl Iterator<Item = ([u32; 3], u32)>, log2_cell: u32, log2_size: u32) -> Self {
        let mut entries = BTreeMap::new();
        for (cell, value) in cells {
            entries.insert(key(cell, log2_cell), value);
            for level in (log2_cell + 3..log2_size).step_by(3) {
                let known = entries.insert(key(cell.map(|c| c >> (level - log2_cell)), level), 0);
                if known.is_some() {
                    break;
                }
            }
        }
        Self { entries }
    }

    /// Binary logarithm of the slots: at least one, and at most half of them are taken.
    pub fn log2_slots(&self) -> u32 {
        (2 * self.entries.len()).max(2).next_power_of_two().ilog2()
    }

    /// Words that it takes.
    pub fn words(&self) -> usize {
        SLOT_WORDS << self.log2_slots()
    }

    /// Writes it, with `address` of every cell's value; values of larger cubes stay as they are.
    pub fn write(&self, words: &mut [u32], log2_cell: u32, address: impl Fn(u32) -> u32) {
        let log2_slots = self.log2_slots();
        let mask = (1 << log2_slots) - 1;
        for slot in words.chunks_exact_mut(SLOT_WORDS) {
            slot[3] = NO_ENTRY;
        }
        for (key, &value) in &self.entries {
            let mut slot = hash(*key) >> (32 - log2_slots);
            while words[SLOT_WORDS * slot as usize + 3] != NO_ENTRY {
                slot = (slot + 1) & mask;
            }
            let words = &mut words[SLOT_WORDS * slot as usize..][..SLOT_WORDS];
            words[..3].copy_from_slice(key);
            words[3] = if key[0] >> 27 == log2_cell { address(value) } else { value };
        }
    }
}

/// A table with room to spare, in which cells come and go.
pub(super) struct LiveTable {
    slots: Vec<[u32; SLOT_WORDS]>,
    taken: usize,
    /// Cells, or cubes of cells, in each larger cube.
    cubes: HashMap<Key, u32>,
    changed: BTreeSet<usize>,
    log2_cell: u32,
    log2_size: u32,
}

impl LiveTable {
    /// An empty one, for the cells of `table` and more.
    pub(crate) fn with_room(table: &Table, log2_cell: u32, log2_size: u32) -> Self {
        let entries = table.entries.len() + table.entries.len() / 4 + 512;
        let slots = vec![[0, 0, 0, NO_ENTRY]; (2 * entries).next_power_of_two()];
        let changed = (0..slots.len()).collect();
        Self { slots, taken: 0, cubes: HashMap::new(), changed, log2_cell, log2_size }
    }

    /// Binary logarithm of the slots.
    pub(crate) fn log2_slots(&self) -> u32 {
        self.slots.len().ilog2()
    }

    /// Words that it takes.
    pub(crate) fn words(&self) -> usize {
        SLOT_WORDS * self.slots.len()
    }

    /// Gives a cell a value, whether it has one or not. `None` when more than half of the slots would be taken.
    pub(crate) fn insert(&mut self, cell: [u32; 3], value: u32) -> Option<()> {
        if self.set(key(cell, self.log2_cell), value)? {
            for cube in self.cubes_around(cell) {
                let below = self.cubes.entry(cube).or_insert(0);
                *below += 1;
                if *below > 1 {
                    break;
                }
                self.set(cube, 0)?;
            }
        }
        Some(())
    }

    /// Takes a cell out, and the larger cubes in which it was the last.
    pub(crate) fn remove(&mut self, cell: [u32; 3]) {
        if !self.clear(key(cell, self.log2_cell)) {
            return;
        }
        for cube in self.cubes_around(cell) {
            let Some(below) = self.cubes.get_mut(&cube) else { break };
            *below -= 1;
            if *below > 0 {
                break;
            }
            self.cubes.remove(&cube);
            self.clear(cube);
        }
    }

    /// The words that were written since the last call, from the first slot on.
    pub(crate) fn take_changes(&mut self) -> Vec<Patch> {
        let mut patches: Vec<Patch> = Vec::new();
        for slot in std::mem::take(&mut self.changed) {
            let (at, words) = (SLOT_WORDS * slot, self.slots[slot]);
            match patches.last_mut() {
                Some(last) if last.at + last.words.len() == at => last.words.extend(words),
                _ => patches.push(Patch { at, words: words.to_vec() }),
            }
        }
        patches
    }

    /// The larger cubes around a cell, the smallest first.
    fn cubes_around(&self, cell: [u32; 3]) -> impl Iterator<Item = Key> + use<> {
        let log2_cell = self.log2_cell;
        (log2_cell + 3..self.log2_size).step_by(3).map(move |level| key(cell.map(|c| c >> (level - log2_cell)), level))
    }

    /// The slot of a key, or the free one where it would be.
    fn find(&self, key: Key) -> usize {
        let mut slot = self.home(key);
        while self.slots[slot][3] != NO_ENTRY && self.slots[slot][..3] != key {
            slot = (slot + 1) & (self.slots.len() - 1);
        }
        slot
    }

    fn home(&self, key: Key) -> usize {
        (hash(key) >> (32 - self.log2_slots())) as usize
    }

    /// True when the key is new.
    fn set(&mut self, key: Key, value: u32) -> Option<bool> {
        let slot = self.find(key);
        let is_new = self.slots[slot][3] == NO_ENTRY;
        if is_new {
            if 2 * (self.taken + 1) > self.slots.len() {
                return None;
            }
            self.taken += 1;
        }
        self.slots[slot] = [key[0], key[1], key[2], value];
        self.changed.insert(slot);
        Some(is_new)
    }

    /// True when the key was there. Later entries move up, so that no search ends too early (Knuth, "The Art of Computer Programming" 3,
    /// 6.4, algorithm R).
    fn clear(&mut self, key: Key) -> bool {
        let mut hole = self.find(key);
        if self.slots[hole][3] == NO_ENTRY {
            return false;
        }
        self.taken -= 1;
        let mask = self.slots.len() - 1;
        let mut next = hole;
        loop {
            next = (next + 1) & mask;
            let slot = self.slots[next];
            if slot[3] == NO_ENTRY {
                break;
            }
            // It may move up unless its home lies behind the hole.
            let home = self.home([slot[0], slot[1], slot[2]]);
            if (next.wrapping_sub(home) & mask) >= (next.wrapping_sub(hole) & mask) {
                self.slots[hole] = slot;
                self.changed.insert(hole);
                hole = next;
            }
        }
        self.slots[hole] = [0, 0, 0, NO_ENTRY];
        self.changed.insert(hole);
        true
    }
}

/// A cell with its level, the binary logarithm of its size, in the top five bits of x: cells have at most 25.
fn key(cell: [u32; 3], level: u32) -> Key {
    [cell[0] | level << 27, cell[1], cell[2]]
}

/// The primes of Teschner et al., "Optimized spatial hashing for collision detection of deformable objects" (2003), and a step of a
/// multiplicative mixer, since the top bits choose the slot.
fn hash(key: Key) -> u32 {
    let sum = key[0].wrapping_mul(73_856_093) ^ key[1].wrapping_mul(19_349_663) ^ key[2].wrapping_mul(83_492_791);
    (sum ^ sum >> 15).wrapping_mul(0x2c1b_3c6d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raxel_world::random::SplitMix64;

    /// The search of `table.glsl`: the value, and how many slots were looked at.
    fn find(words: &[u32], log2_slots: u32, key: Key) -> (Option<u32>, u32) {
        let mask = (1 << log2_slots) - 1;
        let mut slot = hash(key) >> (32 - log2_slots);
        for looked in 1.. {
            let words = &words[4 * slot as usize..][..4];
            if words[3] == NO_ENTRY {
                return (None, looked);
            }
            if words[..3] == key {
                return (Some(words[3]), looked);
            }
            slot = (slot + 1) & mask;
        }
        unreachable!("half of the slots are free")
    }

    /// As `table.glsl` has them.
    #[test]
    fn hashes_are_those_of_the_shader() {
        assert_eq!([[1, 2, 3], [0x2800_0007, 5, 1 << 20]].map(hash), [0xb746_6249, 0x4cff_9ae5]);
    }

    #[test]
    fn entries_are_found_after_few_slots() {
        // A wavy sheet of cells, as terrain has them, in a cube of 2^20 voxels.
        let cells: Vec<[u32; 3]> = (0..4096).map(|i| [i % 64, (i / 64 + i % 64) / 16, i / 64]).collect();
        let table = Table::new(cells.iter().zip(7..).map(|(cell, value)| (*cell, value)), 5, 20);
        let mut words = vec![0; table.words()];
        table.write(&mut words, 5, |value| 3 * value);
        let mut looked = 0;
        for (cell, value) in cells.iter().zip(7u32..) {
            let (found, slots) = find(&words, table.log2_slots(), key(*cell, 5));
            assert_eq!(found, Some(3 * value));
            looked += slots;
        }
        assert!(looked < 2 * 4096, "{looked} slots for 4096 cells");
        // The table has exactly the larger cubes with a cell in them.
        assert_eq!(find(&words, table.log2_slots(), key([7, 0, 7], 8)).0, Some(0));
        assert_eq!(find(&words, table.log2_slots(), key([7, 7, 7], 8)).0, None);
        assert_eq!(find(&words, table.log2_slots(), key([1, 0, 0], 11)).0, None);
        let three = Table::new((0..3).map(|i| ([i, 0, 0], i)), 5, 8);
        assert_eq!(three.log2_slots(), 3, "the least of which half hold three");
    }

    #[test]
    fn a_table_takes_as_many_as_half_of_its_slots_and_no_more() {
        let mut table = LiveTable::with_room(&Table::new(std::iter::empty(), 5, 8), 5, 8);
        let half = table.slots.len() / 2;
        let inserted = (0..1_000).take_while(|&i| table.insert([i % 8, i / 8, 0], i).is_some()).count();
        assert_eq!((inserted, table.taken), (half, half));
    }

    #[test]
    fn a_table_in_which_cells_come_and_go_finds_what_is_there() {
        let (log2_cell, log2_size) = (5, 14);
        let none = Table::new(std::iter::empty(), log2_cell, log2_size);
        let mut table = LiveTable::with_room(&none, log2_cell, log2_size);
        let mut words = vec![0; table.words()];
        let mut random = SplitMix64::new(4);
        let mut there: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        for round in 0..20_000_u32 {
            // Few places, so that searches are long and places come again; half of the slots are nearly never taken.
            let cell = std::array::from_fn(|_| (random.bits() % 8 * 61 % 512) as u32);
            if random.bits().is_multiple_of(2) && there.len() < 120 {
                table.insert(cell, round).expect("there is room");
                there.insert(cell, round);
            } else {
                table.remove(cell);
                there.remove(&cell);
            }
            for patch in table.take_changes() {
                words[patch.at..patch.at + patch.words.len()].copy_from_slice(&patch.words);
            }
            if round.is_multiple_of(500) {
                let same = Table::new(there.iter().map(|(cell, value)| (*cell, *value)), log2_cell, log2_size);
                let of_words = words.chunks_exact(SLOT_WORDS).filter(|slot| slot[3] != NO_ENTRY).count();
                assert_eq!((of_words, table.taken), (same.entries.len(), same.entries.len()));
                for (key, value) in &same.entries {
                    assert_eq!(find(&words, table.log2_slots(), *key).0, Some(*value), "{key:?}");
                }
            }
        }
        assert_eq!(find(&words, table.log2_slots(), key([3, 3, 3], 5)).0, None);
    }
}
