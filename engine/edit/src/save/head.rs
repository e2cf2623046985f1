//! The head of a file of a save: the world that the save belongs to, and the place of the file among the others.

use serde::{Deserialize, Serialize};

use super::SaveError;
use super::record;

/// The format that this program writes. It reads all before it.
pub(super) const FORMAT: u32 = 2;

/// The world that a save belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Meta {
    /// Format of the save.
    pub format: u32,
    /// Project path of the world.
    pub world: String,
    /// Hash of everything that the voxels below the edits are built from.
    pub generator: [u8; 32],
    /// Names of the materials by index.
    pub materials: Vec<String>,
}

/// The role of a file in a save. Its name does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Role {
    /// The file with the chunks.
    Chunks,
    /// A journal.
    Journal,
    /// A whole save in one file.
    Packed,
}

/// The first record of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Head {
    pub(super) meta: Meta,
    pub(super) role: Role,
    /// The number of times that the save was rewritten. Journals of an older generation are superseded.
    pub(super) generation: u64,
    /// The newest edit that was saved when the file was begun.
    pub(super) newest: u64,
    /// The sum of that edit; 0 where it is not known.
    pub(super) sum: u32,
}

impl Head {
    /// Reads a head. `None`: it is none, though its checksums are right. A head of format 1 has the meta alone.
    pub(super) fn read(payload: &[u8], seq: u64) -> Result<Option<Self>, SaveError> {
        match postcard::take_from_bytes::<u32>(payload) {
            Ok((format, _)) if format > FORMAT => Err(SaveError::Newer { found: format, known: FORMAT }),
            Ok((1, _)) => Ok((postcard::from_bytes(payload).ok()).map(|meta| Self {
                meta,
                role: Role::Journal,
                generation: 0,
                newest: seq,
                sum: 0,
            })),
            _ => {
                let head = postcard::from_bytes(payload).ok();
                Ok(head.filter(|head: &Self| head.generation <= record::LARGEST && head.newest <= record::LARGEST))
            }
        }
    }

    /// Appends it to bytes, which it begins. Gives its sum.
    pub(super) fn write(&self, out: &mut Vec<u8>) -> u32 {
        record::write_head(out, self.newest, &postcard::to_stdvec(self).unwrap_or_default())
    }
}
