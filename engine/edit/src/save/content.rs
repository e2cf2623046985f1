//! The contents of the files of a save.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use raxel_world::ChunkPos;

use super::SaveError;
use super::damage::{Damage, between};
use super::head::{FORMAT, Head, Meta, Role};
use super::record::{self, Broken, Kind, LARGEST, Record};
use super::tail::{self, Mark, TAIL};
use crate::operation::Operation;
use crate::packed::PackedChunk;

/// The most reads of a save that another process is writing.
const READS: usize = 100;

/// Name of the file with the chunks.
pub(super) const CHUNKS: &str = "chunks.log";

/// Everything in the files of a save.
#[derive(Debug, Default)]
pub(super) struct Content {
    pub(super) meta: Option<Meta>,
    /// The number of times that the save was rewritten.
    pub(super) generation: u64,
    /// The newest content of every chunk; `None` is the base's.
    pub(super) chunks: BTreeMap<ChunkPos, Option<PackedChunk>>,
    /// Edits up to here are in the chunks.
    pub(super) applied: u64,
    /// Edits after them, in order.
    pub(super) steps: BTreeMap<u64, Vec<Operation>>,
    /// The newest edit that was saved when a journal was begun.
    begun: u64,
    /// The newest edit that was acknowledged.
    pub(super) tail: Option<Mark>,
    pub(super) damages: Vec<Damage>,
    pub(super) files: Vec<FileInfo>,
    /// The end of the undamaged part of the file with the chunks, and the sum of the last record in it.
    pub(super) chunks_end: (u64, u32),
    /// Records of chunks that a newer one has replaced.
    pub(super) replaced: u64,
    /// Whether the file with the chunks must be rewritten. It is of an older format, a packed save or a journal; or its last checkpoint has no end
    /// but counts, because nothing else holds the edits.
    pub(super) rewrite: bool,
    /// The sums of edits.
    sums: BTreeMap<u64, u32>,
    /// Chunks at the end of their file, without the commit that belongs behind them.
    open: Vec<(ChunkPos, Option<PackedChunk>)>,
    /// The edit that the open chunks are of.
    open_seq: u64,
    /// Edits whose records are damaged.
    damaged: BTreeSet<u64>,
    /// Damages that are edits whose records were being written.
    torn: Vec<(usize, u64)>,
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

/// A file that was read.
struct Part {
    name: String,
    bytes: Vec<u8>,
    head: Option<Head>,
}

impl Part {
    fn generation(&self) -> Option<u64> {
        self.head.as_ref().map(|head| head.generation)
    }
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

    /// `None` if a journal disappeared during the reads. A checkpoint of another process has its edits by now, but the chunks read
    /// before may lack them.
    fn read_once(folder: &Path) -> Result<Option<Self>, SaveError> {
        let mut content = Self::default();
        // First, as it must not be ahead of journals that are read before another process writes on.
        let tail = tail::read(folder).map_err(|error| SaveError::Io { path: folder.join(TAIL), error })?;
        let journals = journals(folder)?;
        let mut parts = Vec::new();
        for path in std::iter::once(folder.join(CHUNKS)).chain(journals) {
            let name = file_name(&path);
            match std::fs::read(&path) {
                Ok(bytes) => parts.push(Part { head: first_head(&bytes)?, name, bytes }),
                Err(error) if error.kind() == ErrorKind::NotFound && name == CHUNKS => {}
                Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(SaveError::Io { path, error }),
            }
        }
        content.add_all(&parts);
        content.close();
        content.add_tail(tail, &parts);
        content.steps = content.steps.split_off(&(content.applied + 1));
        content.name_missing();
        Ok(Some(content))
    }

    fn add_all(&mut self, parts: &[Part]) {
        // Of the file with the chunks, where several are of the newest generation.
        let newest = parts.iter().rev().filter_map(|part| part.head.as_ref()).max_by_key(|head| head.generation);
        self.meta = newest.map(|head| head.meta.clone());
        self.generation = newest.map_or(0, |head| head.generation);
        self.rewrite = newest.is_none_or(|head| head.meta.format < FORMAT);
        for part in parts {
            let is_chunks = part.name == CHUNKS;
            let mut used = true;
            if part.generation().is_some_and(|generation| generation < self.generation) {
                // The edits of a journal are in the chunks that were rewritten after it.
                let materials = part.head.as_ref().map(|head| &head.meta.materials);
                used = is_chunks && materials == self.meta.as_ref().map(|meta| &meta.materials);
                if is_chunks {
                    self.damages
                        .push(Damage::missing(CHUNKS, "what was saved last: the file is older than the journals"));
                    self.rewrite = true;
                }
            }
            if used {
                self.add(part);
            } else {
                let records = record::read(&part.bytes).flatten().count() as u64;
                self.note_file(&part.name, part.bytes.len(), records);
            }
            if let Some(head) = part.head.as_ref().filter(|head| is_chunks && head.meta.format >= FORMAT) {
                self.rewrite |= head.role != Role::Chunks;
            }
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "the file is in memory, so that `usize` holds its length")]
    fn add_tail(&mut self, tail: Option<tail::Found>, parts: &[Part]) {
        let newest = self.newest();
        let unknown = || format!("the number of the newest edit: edits after {newest} may be lost");
        let Some(tail) = tail else {
            let mut heads = parts.iter().filter_map(|part| part.head.as_ref());
            if heads.any(|head| head.meta.format >= FORMAT && head.role != Role::Packed) {
                self.damages.push(Damage::missing(TAIL, unknown()));
            }
            return;
        };
        self.note_file(TAIL, tail.bytes as usize, tail.whole);
        for bytes in tail.broken {
            let what = if tail.mark.is_some() { "a note of the newest edit".to_owned() } else { unknown() };
            self.damages.push(Damage { file: TAIL.to_owned(), bytes, what, unfinished: false });
        }
        self.tail = tail.mark;
        if let Some(mark) = tail.mark.filter(|mark| mark.generation == self.generation) {
            self.note_sum(TAIL, mark.seq, mark.sum);
        }
    }

    /// Decides about chunks without a commit behind them. While a checkpoint is written, the journals have its edits, and the chunks do not
    /// count. If the journals lack them, the checkpoint was finished and its end is damaged.
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
        self.rewrite = true;
        let mut named = false;
        for damage in self.damages.iter_mut().filter(|damage| damage.file == CHUNKS) {
            named |= std::mem::take(&mut damage.unfinished);
        }
        if !named {
            self.damages.push(Damage::missing(CHUNKS, format!("the end of the checkpoint of edit {seq}")));
        }
    }

    /// Names edits that were saved once, but are now missing in the chunks and in the journals.
    fn name_missing(&mut self) {
        let gaps = self.gaps();
        for &(index, seq) in &self.torn {
            if gaps.iter().any(|gap| gap.contains(&seq)) {
                let damage = &mut self.damages[index];
                (damage.unfinished, damage.what) = (false, format!("edit {seq}"));
                self.damaged.insert(seq);
            }
        }
        let newest = self.tail.map(|mark| file_name(&journal_path(Path::new(""), mark.journal)));
        for gap in gaps {
            let (first, last) = gap.into_inner();
            let old = first..=last.min(self.begun);
            let young = first.max(self.begun + 1)..=last;
            for (gap, file) in [(old, CHUNKS), (young, newest.as_deref().unwrap_or(CHUNKS))] {
                self.damages.extend(between(&gap, &self.damaged).iter().map(|edits| Damage::edits(file, edits)));
            }
        }
    }

    /// Edits that no file has. An empty step stands for those before it that were named once.
    fn gaps(&self) -> Vec<RangeInclusive<u64>> {
        let mut next = self.applied + 1;
        let mut gaps = Vec::new();
        for (&seq, operations) in &self.steps {
            gaps.extend((next < seq && !operations.is_empty()).then(|| next..=seq - 1));
            next = seq + 1;
        }
        gaps.extend((next <= self.newest()).then(|| next..=self.newest()));
        gaps
    }

    /// The number of the newest edit, whether a file has it or not.
    pub(super) fn newest(&self) -> u64 {
        let step = self.steps.keys().next_back().copied().unwrap_or(0);
        step.max(self.applied).max(self.begun).max(self.tail.map_or(0, |mark| mark.seq))
    }

    /// The sum of an edit; 0 where it is not known.
    pub(super) fn sum(&self, seq: u64) -> u32 {
        self.sums.get(&seq).copied().unwrap_or(0)
    }

    /// Takes note of the sum that a file gives an edit. If another file has a different sum, the two files do not belong together.
    fn note_sum(&mut self, file: &str, seq: u64, sum: u32) {
        if sum == 0 || seq == 0 {
            return;
        }
        if *self.sums.entry(seq).or_insert(sum) != sum {
            let what = format!(
                "edit {seq}, which another file has otherwise: the two files are of different times or different saves"
            );
            self.damages.push(Damage::missing(file, what));
        }
    }

    fn note_file(&mut self, name: &str, bytes: usize, records: u64) {
        self.files.push(FileInfo { name: name.to_owned(), bytes: bytes as u64, records });
    }

    fn note_broken(&mut self, name: &str, broken: &Broken, last: Option<u64>) {
        let seq = match broken.record {
            Some((Kind::Operations, seq, _)) => Some(seq),
            Some(_) => None,
            None => last.map(|last| last + 1).filter(|_| name != CHUNKS),
        };
        if let Some(seq) = seq
            && broken.short
        {
            self.torn.push((self.damages.len(), seq));
        } else if broken.record.is_some() {
            self.damaged.extend(seq);
        }
        self.damages.push(Damage::broken(name, broken, last));
    }

    fn add(&mut self, part: &Part) {
        let Part { name, bytes, head } = part;
        let is_chunks = name == CHUNKS;
        // Sums mean something among files of one generation, and not before there were any.
        let has_sums =
            head.as_ref().is_some_and(|head| head.meta.format >= FORMAT && head.generation == self.generation);
        // Chunks count from the commit behind them on.
        let mut waiting: Vec<(ChunkPos, Option<PackedChunk>)> = Vec::new();
        let (mut records, mut last, mut cut) = (0, None, None);
        for found in record::read(bytes) {
            let found = match found {
                Ok(found) => found,
                Err(broken) if broken.bytes.is_empty() => {
                    cut = Some(broken);
                    continue;
                }
                Err(broken) => {
                    self.note_broken(name, &broken, last);
                    continue;
                }
            };
            // Edits that were cut out are named by their numbers.
            let is_gap = found.kind == Kind::Operations && last.is_some_and(|last| found.seq > last + 1);
            if let Some(cut) = cut.take().filter(|_| !is_gap) {
                self.note_broken(name, &cut, last);
            }
            (records, last) = (records + 1, Some(found.seq));
            let Record { kind, seq, pos, payload, sum, end } = found;
            match kind {
                Kind::Head => {
                    if let Ok(Some(head)) = Head::read(payload, seq)
                        && (!is_chunks || head.meta.format >= FORMAT)
                    {
                        self.begun = self.begun.max(head.newest);
                        if has_sums {
                            self.note_sum(name, head.newest, head.sum);
                        }
                    }
                }
                Kind::Operations => {
                    if let Ok(operations) = postcard::from_bytes(payload) {
                        // If the chunks of format 1 were rewritten, the same edit may be in a journal that was not removed, with other indices of
                        // materials.
                        self.steps.entry(seq).or_insert(operations);
                    }
                    if has_sums {
                        self.note_sum(name, seq, sum);
                    }
                }
                Kind::Chunk => waiting.push((pos, Some(PackedChunk::from_bytes(payload)))),
                Kind::Base => waiting.push((pos, None)),
                Kind::Commit => {
                    self.applied = self.applied.max(seq);
                    for (pos, chunk) in waiting.drain(..) {
                        self.replaced += u64::from(self.chunks.insert(pos, chunk).is_some());
                    }
                    if let (true, Some(sum)) = (has_sums, payload.first_chunk()) {
                        self.note_sum(name, seq, u32::from_le_bytes(*sum));
                    }
                }
            }
            if matches!(kind, Kind::Chunk | Kind::Base) {
                self.open_seq = seq;
            } else if is_chunks {
                // The next checkpoint begins at the first chunk without a commit.
                self.chunks_end = (end, sum);
            }
        }
        if is_chunks {
            self.open = waiting;
        }
        self.note_file(name, bytes.len(), records);
    }
}

/// The first head of a file that is whole.
fn first_head(bytes: &[u8]) -> Result<Option<Head>, SaveError> {
    let found = record::read(bytes).flatten().find(|found| found.kind == Kind::Head);
    found.map_or(Ok(None), |found| Head::read(found.payload, found.seq))
}

/// The journals of a folder, oldest first.
pub(super) fn journals(folder: &Path) -> Result<Vec<PathBuf>, SaveError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(SaveError::Io { path: folder.to_owned(), error }),
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| SaveError::Io { path: folder.to_owned(), error })?.path();
        found.extend(journal_number(&path).map(|number| (number, path)));
    }
    found.sort_unstable();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

pub(super) fn journal_number(path: &Path) -> Option<u64> {
    file_name(path).strip_prefix("journal-")?.strip_suffix(".log")?.parse().ok().filter(|number| *number <= LARGEST)
}

pub(super) fn journal_path(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("journal-{number:06}.log"))
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
