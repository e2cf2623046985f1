//! The tail of a save: a small file with the number of the last edit that was acknowledged.
//!
//! A journal that was cut off where a record ends, or removed, looks like one that was never longer. So each edit is noted here as well,
//! after its record is in the journal and before it is acknowledged. A kill leaves a tail behind the journal. A tail ahead of the journal
//! is a loss.
//!
//! The file has two slots, which are written in turn: the magic `RXVT`; the generation of the save (u64), the number of the journal (u64)
//! and of its newest edit (u64); the sum of that edit (u32); the CRC-32C of the slot before it.

use std::io;
use std::path::Path;
use std::sync::Arc;

use super::disk::{Disk, Storage};
use super::record::LARGEST;

/// Name of the file.
pub(super) const TAIL: &str = "tail";

const MAGIC: [u8; 4] = *b"RXVT";

/// Bytes of a slot.
const SLOT: usize = 36;

/// The most reads of a file while another process writes its slot.
const READS: usize = 20;

/// The newest edit that was acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Mark {
    /// The generation of the save.
    pub(super) generation: u64,
    /// The edit.
    pub(super) seq: u64,
    /// The journal that has it.
    pub(super) journal: u64,
    /// Its sum; 0 where it is not known.
    pub(super) sum: u32,
}

impl Mark {
    fn bytes(&self) -> [u8; SLOT] {
        let mut slot = [0; SLOT];
        slot[..4].copy_from_slice(&MAGIC);
        slot[4..12].copy_from_slice(&self.generation.to_le_bytes());
        slot[12..20].copy_from_slice(&self.journal.to_le_bytes());
        slot[20..28].copy_from_slice(&self.seq.to_le_bytes());
        slot[28..32].copy_from_slice(&self.sum.to_le_bytes());
        let crc = crc32c::crc32c(&slot[..32]);
        slot[32..].copy_from_slice(&crc.to_le_bytes());
        slot
    }

    fn read(slot: &[u8]) -> Option<Self> {
        let word = |at: usize| slot.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
        let long = |at: usize| Some(u64::from(word(at)?) | u64::from(word(at + 4)?) << 32);
        let right = slot.get(..4)? == MAGIC && crc32c::crc32c(slot.get(..32)?) == word(32)?;
        let mark = Self { generation: long(4)?, journal: long(12)?, seq: long(20)?, sum: word(28)? };
        let small = [mark.generation, mark.journal, mark.seq].iter().all(|number| *number <= LARGEST);
        (right && small).then_some(mark)
    }
}

/// The file, as its writer knows it.
pub(super) struct Tail {
    storage: Arc<dyn Storage>,
    /// The slot that is written next.
    turn: bool,
}

impl Tail {
    /// Puts a file with a mark in place of the one that is there.
    pub(super) fn create(disk: &dyn Disk, folder: &Path, mark: &Mark) -> io::Result<Self> {
        let path = folder.join("tail.new");
        let storage = disk.create(&path)?;
        storage.append(&[mark.bytes(), mark.bytes()].concat())?;
        storage.sync()?;
        disk.rename(&path, &folder.join(TAIL))?;
        disk.sync_folder(folder)?;
        Ok(Self { storage, turn: false })
    }

    /// Notes an edit. When it returns, that survives the end of the program.
    pub(super) fn set(&mut self, mark: &Mark) -> io::Result<()> {
        self.storage.write_at(SLOT as u64 * u64::from(self.turn), &mark.bytes())?;
        self.turn = !self.turn;
        Ok(())
    }

    pub(super) fn storage(&self) -> &Arc<dyn Storage> {
        &self.storage
    }
}

/// The contents of a folder's file.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// The newer mark.
    pub(super) mark: Option<Mark>,
    /// Slots that are no mark.
    pub(super) broken: Vec<std::ops::Range<u64>>,
    /// Slots that are.
    pub(super) whole: u64,
    pub(super) bytes: u64,
}

/// Reads the file; `None` when there is none.
pub(super) fn read(folder: &Path) -> io::Result<Option<Found>> {
    let mut found = Found::default();
    for _ in 0..READS {
        let bytes = match std::fs::read(folder.join(TAIL)) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        found = Found { bytes: bytes.len() as u64, ..Found::default() };
        for slot in [0, SLOT] {
            match Mark::read(bytes.get(slot..).unwrap_or_default()) {
                Some(mark) => (found.mark, found.whole) = (found.mark.max(Some(mark)), found.whole + 1),
                None => found.broken.push(slot as u64..(slot + SLOT) as u64),
            }
        }
        if found.broken.is_empty() {
            break;
        }
        std::thread::yield_now();
    }
    Ok(Some(found))
}
