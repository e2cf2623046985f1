//! What the files of a save say, and what is wrong with them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use raxel_world::ChunkPos;
use serde::{Deserialize, Serialize};

use super::SaveError;
use super::record::{self, Broken, Kind};
use crate::operation::Operation;
use crate::packed::PackedChunk;

/// The format that this program writes.
pub(super) const FORMAT: u32 = 1;

/// How often a save is read again that another process writes meanwhile.
const READS: usize = 100;

/// Name of the file with the chunks.
pub(super) const CHUNKS: &str = "chunks.log";

/// What a save belongs to.
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

/// Damage to a file of a save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Name of the file.
    pub file: String,
    /// The bytes that are lost; none when the file ends before them, or is gone.
    pub bytes: std::ops::Range<u64>,
    /// What they were.
    pub what: String,
    /// The file ends in it: something was being written when the program or the machine stopped. Nothing that was acknowledged is lost,
    /// but by a power cut.
    pub unfinished: bool,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, bytes, what, .. } = self;
        if bytes.is_empty() {
            return write!(f, "{file}: missing: {what}");
        }
        write!(f, "{file}: bytes {}…{} are lost: {what}", bytes.start, bytes.end)
    }
}

/// Everything in the files of a save.
#[derive(Debug, Default)]
pub(super) struct Content {
    pub(super) meta: Option<Meta>,
    /// The newest content of every chunk; `None` is the base's.
    pub(super) chunks: BTreeMap<ChunkPos, Option<PackedChunk>>,
    /// Edits up to here are in the chunks.
    pub(super) applied: u64,
    /// Edits after them, in order.
    pub(super) steps: BTreeMap<u64, Vec<Operation>>,
    /// The newest edit that was saved when a journal was begun.
    pub(super) begun: u64,
    pub(super) damages: Vec<Damage>,
    pub(super) files: Vec<FileInfo>,
    /// Where the whole part of the file with the chunks ends.
    pub(super) chunks_end: u64,
    /// Records of chunks that a newer one has replaced.
    pub(super) replaced: u64,
    /// Chunks at the end of their file, without the commit that belongs behind them.
    open: Vec<(ChunkPos, Option<PackedChunk>)>,
    /// The edit that the open chunks are of.
    open_seq: u64,
    /// The open chunks count, as nothing else holds their edits: the file with the chunks has to be written anew.
    pub(super) mended: bool,
    /// Edits whose records are damaged.
    damaged: BTreeSet<u64>,
}

/// A file of a save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileInfo {
    /// Its name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// Records in it that are whole.
    pub records: u64,
}

impl Content {
    /// Reads a folder.
    pub(super) fn read(folder: &Path) -> Result<Self, SaveError> {
        for _ in 0..READS {
            if let Some(content) = Self::read_once(folder)? {
                return Ok(content);
            }
        }
        let error = std::io::Error::other("another process writes it all the time");
        Err(SaveError::Io { path: folder.to_owned(), error })
    }

    /// `None` when a journal went while the others were read: a checkpoint of another process has its edits by now, and the chunks that
    /// were read before may not.
    fn read_once(folder: &Path) -> Result<Option<Self>, SaveError> {
        let mut content = Self::default();
        let journals = journals(folder)?;
        for path in std::iter::once(folder.join(CHUNKS)).chain(journals) {
            let name = file_name(&path);
            match std::fs::read(&path) {
                Ok(bytes) => content.add(&name, &bytes)?,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                    if name != CHUNKS {
                        return Ok(None);
                    }
                }
                Err(error) => return Err(SaveError::Io { path, error }),
            }
        }
        content.close();
        content.steps = content.steps.split_off(&(content.applied + 1));
        content.name_missing();
        Ok(Some(content))
    }

    /// Decides about chunks without a commit behind them. While a checkpoint is written, the journals have its edits, and the chunks do not
    /// count. When they have none of them, the checkpoint was finished and its end is damaged.
    fn close(&mut self) {
        let open = std::mem::take(&mut self.open);
        let seq = self.open_seq;
        if open.is_empty() || seq <= self.applied || self.steps.range(self.applied + 1..=seq).next().is_some() {
            return;
        }
        for (pos, chunk) in open {
            self.replaced += u64::from(self.chunks.insert(pos, chunk).is_some());
        }
        self.applied = seq;
        self.mended = true;
        let mut named = false;
        for damage in self.damages.iter_mut().filter(|damage| damage.file == CHUNKS) {
            named |= std::mem::take(&mut damage.unfinished);
        }
        if !named {
            self.damages.push(missing(format!("the end of the checkpoint of edit {seq}")));
        }
    }

    /// Names edits that neither the chunks nor a journal has. An empty step stands for those before it that were named once.
    fn name_missing(&mut self) {
        let mut next = self.applied + 1;
        let steps = self.steps.iter().map(|(&seq, operations)| (seq, operations.is_empty()));
        for (seq, was_named) in steps.chain([(self.begun + 1, false)]) {
            let last = seq - 1;
            let gone = seq.saturating_sub(next);
            next = next.max(seq + 1);
            if gone == 0 || was_named {
                continue;
            }
            let first = seq - gone;
            if self.damaged.range(first..=last).count() as u64 == gone {
                continue;
            }
            let what = if gone == 1 { format!("edit {last}") } else { format!("edits {first}…{last}") };
            self.damages.push(missing(what));
        }
    }

    /// The number of the newest edit.
    pub(super) fn newest(&self) -> u64 {
        self.steps.keys().next_back().copied().unwrap_or(self.applied).max(self.begun)
    }

    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), SaveError> {
        // Chunks count from the commit behind them on.
        let mut waiting: Vec<(ChunkPos, Option<PackedChunk>)> = Vec::new();
        let (mut at, mut records, mut last) = (0, 0, None);
        for found in record::read(bytes) {
            let found = match found {
                Ok(found) => found,
                Err(broken) => {
                    if let Some((Kind::Operations, seq, _)) = broken.record {
                        self.damaged.insert(seq);
                    }
                    self.damages.push(damage(name, &broken, last));
                    at = broken.bytes.end;
                    continue;
                }
            };
            at += (record::HEADER + found.payload.len()) as u64;
            (records, last) = (records + 1, Some(found.seq));
            match found.kind {
                Kind::Meta => {
                    if let Ok((format, _)) = postcard::take_from_bytes::<u32>(found.payload)
                        && format > FORMAT
                    {
                        return Err(SaveError::Newer { found: format, known: FORMAT });
                    }
                    self.meta = self.meta.take().or(postcard::from_bytes(found.payload).ok());
                    if name != CHUNKS {
                        self.begun = self.begun.max(found.seq);
                    }
                }
                Kind::Operations => {
                    if let Ok(operations) = postcard::from_bytes(found.payload) {
                        // Where the chunks were written anew the same edit may be in a journal that was not removed, with other
                        // indices of materials.
                        self.steps.entry(found.seq).or_insert(operations);
                    }
                }
                Kind::Chunk => waiting.push((found.pos, Some(PackedChunk::from_bytes(found.payload)))),
                Kind::Base => waiting.push((found.pos, None)),
                Kind::Commit => {
                    self.applied = self.applied.max(found.seq);
                    for (pos, chunk) in waiting.drain(..) {
                        self.replaced += u64::from(self.chunks.insert(pos, chunk).is_some());
                    }
                }
            }
            if matches!(found.kind, Kind::Chunk | Kind::Base) {
                self.open_seq = found.seq;
            }
            // Where chunks without a commit begin, the next checkpoint does.
            if name == CHUNKS && !matches!(found.kind, Kind::Chunk | Kind::Base) {
                self.chunks_end = at;
            }
        }
        if name == CHUNKS {
            self.open = waiting;
        }
        self.files.push(FileInfo { name: name.to_owned(), bytes: bytes.len() as u64, records });
        Ok(())
    }
}

fn damage(file: &str, broken: &Broken, last: Option<u64>) -> Damage {
    let what = match broken.record {
        Some((Kind::Operations, seq, _)) => format!("edit {seq}"),
        Some((Kind::Chunk | Kind::Base, seq, pos)) => {
            format!("the chunk at {}, {}, {} as edit {seq} left it", pos.x, pos.y, pos.z)
        }
        Some((Kind::Commit, seq, _)) => format!("the end of the checkpoint of edit {seq}"),
        Some((Kind::Meta, ..)) => "the description of the save".to_owned(),
        None => match last {
            Some(seq) => format!("what followed the record of edit {seq}"),
            None => "the beginning of the file".to_owned(),
        },
    };
    Damage { file: file.to_owned(), bytes: broken.bytes.clone(), what, unfinished: broken.at_end }
}

/// What no file of the save has.
fn missing(what: String) -> Damage {
    Damage { file: CHUNKS.to_owned(), bytes: 0..0, what, unfinished: false }
}

/// The journals of a folder, oldest first.
pub(super) fn journals(folder: &Path) -> Result<Vec<PathBuf>, SaveError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(SaveError::Io { path: folder.to_owned(), error }),
    };
    let mut found: Vec<(u64, PathBuf)> =
        (entries.flatten()).filter_map(|entry| Some((journal_number(&entry.path())?, entry.path()))).collect();
    found.sort_unstable();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

pub(super) fn journal_number(path: &Path) -> Option<u64> {
    file_name(path).strip_prefix("journal-")?.strip_suffix(".log")?.parse().ok()
}

pub(super) fn journal_path(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("journal-{number:06}.log"))
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
