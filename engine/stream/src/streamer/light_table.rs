//! The list of lamps as publications show it: the table of their groups, and the tiles whose lamps there was no room for.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use raxel_layouts::lights::{HEADER_WORDS, LightGroup, grouped_header, grouped_words};

use crate::pool::{Pool, PoolBlock};
use crate::reach::TileKey;

#[derive(Default)]
pub(super) struct LightTable {
    /// Blocks of lamps and of tables that no publication from this version on reaches.
    retired: VecDeque<(u64, PoolBlock)>,
    /// The shown groups, their table, and the header in front of the list.
    groups: Vec<LightGroup>,
    table: Option<PoolBlock>,
    header: [u32; HEADER_WORDS],
    /// There was no room for the table of the last publication.
    no_table: bool,
    /// Tiles whose lamps there was no room for, with the words that these take.
    left_out: BTreeMap<TileKey, u32>,
    /// Those of them that are rebuilt, since there is room for their lamps now. Nothing waits for them.
    again: BTreeSet<TileKey>,
    /// Lamps were refused since the last message.
    refused: bool,
}

impl LightTable {
    /// Gives up a block that publications before this version may reach.
    pub(super) fn retire(&mut self, version: u64, block: Option<PoolBlock>) {
        self.retired.extend(block.map(|block| (version, block)));
    }

    /// Whether a block can be taken back once a version is released.
    pub(super) fn can_free(&self, released: u64) -> bool {
        self.retired.front().is_some_and(|(version, _)| *version <= released)
    }

    /// Whether a block waits for a publication after this version.
    pub(super) fn waits_for_more_than(&self, version: u64) -> bool {
        self.retired.iter().any(|(of, _)| *of > version)
    }

    /// Takes back the blocks that no frame reads.
    pub(super) fn free(&mut self, pool: &Pool, released: u64) {
        while self.can_free(released) {
            if let Some((_, block)) = self.retired.pop_front() {
                pool.free(block);
            }
        }
    }

    /// A tile has changed.
    pub(super) fn forget(&mut self, key: TileKey) {
        self.left_out.remove(&key);
        self.again.remove(&key);
    }

    /// A tile could not be rebuilt.
    pub(super) fn unmade(&mut self, key: TileKey) {
        self.again.remove(&key);
    }

    /// There was no room for the lamps of a tile, which take `words` words.
    pub(super) fn leave_out(&mut self, key: TileKey, words: u32) {
        self.left_out.insert(key, words);
        self.refused = true;
    }

    /// Tiles whose lamps are left out.
    pub(super) fn left_out(&self) -> usize {
        self.left_out.len()
    }

    /// Whether lamps were refused since this was asked last.
    pub(super) fn take_refused(&mut self) -> bool {
        std::mem::take(&mut self.refused)
    }

    /// Whether all lamps are listed.
    pub(super) fn is_whole(&self) -> bool {
        self.left_out.is_empty() && !self.no_table
    }

    /// Whether there was no room for the table of the last publication.
    pub(super) fn lacks_table(&self) -> bool {
        self.no_table
    }

    /// The tiles that are rebuilt for their lamps.
    pub(super) fn again(&self) -> &BTreeSet<TileKey> {
        &self.again
    }

    /// Chooses the tiles to rebuild for their lamps, which fit into `room` words. Says whether there are more of them than before.
    pub(super) fn list_again(&mut self, mut room: u64) -> bool {
        let before = self.again.len();
        for (key, words) in &self.left_out {
            if let Some(left) = room.checked_sub(u64::from(*words)) {
                room = left;
                self.again.insert(*key);
            }
        }
        self.again.len() > before
    }

    /// The next publication tries to find room for a table again, if the last one found none: then it reports that.
    pub(super) fn try_table_again(&mut self) -> bool {
        let again = std::mem::take(&mut self.no_table);
        if again {
            self.groups.clear();
        }
        again
    }

    /// Writes the table of the groups that a publication shows, if they are not those of the last one, and gives the words that it took.
    /// The table before stays until that version is released.
    pub(super) fn publish(&mut self, pool: &Pool, groups: &[LightGroup], version: u64) -> u64 {
        if self.groups == groups {
            return 0;
        }
        self.groups = groups.to_vec();
        self.header = [0; HEADER_WORDS];
        let words = grouped_words(groups);
        let table = if groups.is_empty() { None } else { pool.allocate(words.len() as u32) };
        let mut written = 0;
        if let Some(table) = &table {
            pool.write(table, &words);
            written = words.len() as u64;
            self.header = grouped_header(groups, pool.address(table) / 4);
        }
        self.no_table = table.is_none() && !groups.is_empty();
        self.refused |= self.no_table;
        let before = std::mem::replace(&mut self.table, table);
        self.retire(version, before);
        written
    }

    /// The header in front of the list.
    pub(super) fn header(&self) -> [u32; HEADER_WORDS] {
        self.header
    }
}
