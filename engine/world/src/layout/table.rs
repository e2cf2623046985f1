//! The hash table of `shaders/include/raxel/table.glsl`: from places in the world's cube to addresses. Besides the places themselves it
//! has the cubes of 8, 64, 512, … places a side that have one in them, so that a ray leaves empty space in long steps.

use std::collections::BTreeMap;

/// Words of a slot: three of a key, one of a value.
pub(super) const SLOT_WORDS: usize = 4;
/// Value of a slot without an entry.
const NO_ENTRY: u32 = u32::MAX;

type Key = [u32; 3];

/// The entries of a table that is yet to be written.
pub(super) struct Table {
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
        // Larger cubes are there where a cell is in them, and nowhere else.
        assert_eq!(find(&words, table.log2_slots(), key([7, 0, 7], 8)).0, Some(0));
        assert_eq!(find(&words, table.log2_slots(), key([7, 7, 7], 8)).0, None);
        assert_eq!(find(&words, table.log2_slots(), key([1, 0, 0], 11)).0, None);
    }
}
