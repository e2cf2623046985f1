//! The writer of a save: its journal, its tail, and the thread of its checkpoints.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_world::ChunkPos;

use super::content::{self, CHUNKS, Content};
use super::disk::Disk;
use super::head::{Head, Meta, Role};
use super::log::Log;
use super::record::{self, Kind};
use super::tail::{Mark, Tail};
use super::verify;
use super::worker::{Checkpoint, Files, Worker};
use crate::history::Stored;
use crate::operation::Operation;

/// Bytes of steps that wait for a disk with room; with more, the next checkpoint takes their place.
const MOST_WAITING: usize = 64 << 20;

pub(super) struct Writer {
    disk: Arc<dyn Disk>,
    folder: PathBuf,
    meta: Meta,
    journal: Log,
    /// The sum of the last record of the journal.
    journal_sum: u32,
    tail: Tail,
    /// The newest edit that was written, its sum, the journal, the generation.
    mark: Mark,
    /// The tail has the mark.
    is_marked: bool,
    pub(super) worker: Worker,
    /// Steps that could not be written yet, with their numbers.
    waiting: Vec<(u64, Vec<u8>)>,
    waiting_bytes: usize,
    /// More could not be written than is kept: only a checkpoint saves it.
    pub(super) overflown: bool,
    pub(super) failing: Option<Instant>,
    /// Held as long as the save is open; the system lets go of it when the process ends.
    _lock: File,
}

impl std::fmt::Debug for Writer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Writer({:?}, {} bytes)", self.mark, self.journal.bytes())
    }
}

impl Writer {
    pub(super) fn open(
        disk: Arc<dyn Disk>,
        folder: &Path,
        meta: Meta,
        content: &Content,
        rewrite: bool,
        sync: Duration,
        lock: File,
    ) -> io::Result<Self> {
        let path = folder.join(CHUNKS);
        let seq = content.newest();
        let (mut generation, mut sum, mut end) = (content.generation, content.sum(seq), content.chunks_end);
        if rewrite {
            let whole = verify::rewrite(&*disk, folder, &meta, content)?;
            (generation, sum, end) = (whole.generation, whole.newest_sum, whole.end);
        }
        // A checkpoint that was not finished is cut off; its edits are in the journals.
        let mut chunks = Log::open(&*disk, &path, end.0)?;
        if chunks.bytes() == 0 {
            let mut head = Vec::new();
            end.1 = Head { meta: meta.clone(), role: Role::Chunks, generation, newest: 0, sum: 0 }.write(&mut head);
            chunks.append(&head)?;
        }
        // A journal is never appended to by another run, because its end is unknown.
        let newest = content::journals(folder).map_err(io::Error::other)?;
        let number = newest.last().and_then(|path| content::journal_number(path)).unwrap_or(0) + 1;
        let mark = Mark { generation, seq, journal: number, sum };
        let tail = Tail::create(&*disk, folder, &mark)?;
        let (journal, journal_sum) = new_journal(&*disk, folder, &meta, &mark)?;
        disk.sync_folder(folder)?;
        let files = Files {
            disk: disk.clone(),
            folder: folder.to_owned(),
            chunks,
            chunks_sum: end.1,
            journal: journal.storage().clone(),
            number,
            tail: tail.storage().clone(),
        };
        Ok(Self {
            disk,
            folder: folder.to_owned(),
            meta,
            journal,
            journal_sum,
            tail,
            mark,
            is_marked: true,
            worker: Worker::start(files, sync)?,
            waiting: Vec::new(),
            waiting_bytes: 0,
            overflown: false,
            failing: None,
            _lock: lock,
        })
    }

    /// Writes a step into the journal. On an error it is kept, and written with a later one.
    pub(super) fn commit(&mut self, seq: u64, operations: &[Operation]) -> io::Result<()> {
        let payload = postcard::to_stdvec(operations).map_err(io::Error::other)?;
        self.waiting_bytes += record::HEADER + payload.len();
        self.waiting.push((seq, payload));
        if self.failing.is_some() {
            self.bound_waiting();
            return Err(io::Error::other("the save is waiting for room on its disk"));
        }
        self.write_waiting()
    }

    /// Writes the waiting records.
    pub(super) fn write_waiting(&mut self) -> io::Result<()> {
        let written = self.append_waiting().and_then(|()| self.set_mark());
        if written.is_ok() {
            if !self.overflown {
                self.failing = None;
            }
        } else {
            self.failing = Some(Instant::now());
            self.bound_waiting();
        }
        written
    }

    fn append_waiting(&mut self) -> io::Result<()> {
        let Some(&(seq, _)) = self.waiting.last() else { return Ok(()) };
        self.waiting.iter().try_for_each(|(seq, payload)| record::check_length(*seq, payload.len()))?;
        let mut bytes = Vec::with_capacity(self.waiting_bytes);
        let sum = self.waiting.iter().fold(self.journal_sum, |sum, (seq, payload)| {
            record::write(&mut bytes, sum, Kind::Operations, *seq, ChunkPos::new(0, 0, 0), payload)
        });
        self.journal.append(&bytes)?;
        self.journal_sum = sum;
        self.drop_waiting();
        self.mark = Mark { seq, sum, ..self.mark };
        self.is_marked = false;
        self.worker.unsynced();
        Ok(())
    }

    fn set_mark(&mut self) -> io::Result<()> {
        if !self.is_marked {
            self.tail.set(&self.mark)?;
            self.is_marked = true;
        }
        Ok(())
    }

    fn bound_waiting(&mut self) {
        if self.waiting_bytes > MOST_WAITING {
            self.drop_waiting();
            self.overflown = true;
        }
    }

    fn drop_waiting(&mut self) {
        self.waiting.clear();
        self.waiting_bytes = 0;
    }

    /// Goes on in another journal, so that a checkpoint can take the place of those before.
    pub(super) fn next_journal(&mut self) -> io::Result<()> {
        let mark = Mark { journal: self.mark.journal + 1, ..self.mark };
        let (journal, sum) = new_journal(&*self.disk, &self.folder, &self.meta, &mark)?;
        self.worker.journal(journal.storage().clone(), mark.journal);
        (self.journal, self.journal_sum, self.mark) = (journal, sum, mark);
        Ok(())
    }

    /// Begins a checkpoint of the edits up to a number, which takes the place of all journals but the newest.
    pub(super) fn checkpoint(&mut self, chunks: Vec<(ChunkPos, Option<Stored>)>, seq: u64) {
        let sum = if seq == self.mark.seq { self.mark.sum } else { 0 };
        self.worker.checkpoint(Checkpoint { chunks, seq, sum, removes_up_to: self.mark.journal - 1 });
        self.overflown = false;
    }

    /// A checkpoint holds the edits up to a number. True when everything is saved again that could not be.
    pub(super) fn holds(&mut self, seq: u64) -> bool {
        if seq > self.mark.seq {
            // Edits that the journal had no room for.
            self.mark = Mark { seq, sum: 0, ..self.mark };
            self.is_marked = false;
        }
        self.waiting.retain(|(waiting, _)| *waiting > seq);
        self.waiting_bytes = self.waiting.iter().map(|(_, payload)| record::HEADER + payload.len()).sum();
        let recovered = self.failing.is_some() && self.waiting.is_empty() && self.set_mark().is_ok();
        if recovered {
            self.failing = None;
        }
        recovered
    }

    pub(super) fn journal_bytes(&self) -> u64 {
        self.journal.bytes()
    }

    /// Brings everything to the disk that was written.
    pub(super) fn sync(&self) -> io::Result<()> {
        if self.worker.lost() > 0 {
            return Err(io::Error::other("the disk has refused a journal, and no checkpoint has its edits yet"));
        }
        let synced = self.journal.storage().sync().and_then(|()| self.tail.storage().sync());
        if synced.is_err() {
            self.worker.lose(self.mark.journal);
        }
        synced
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        // The last try. No message has called these steps saved.
        let _ = self.write_waiting();
    }
}

/// Begins a journal of the edits after a mark. Gives the sum of its last record as well.
fn new_journal(disk: &dyn Disk, folder: &Path, meta: &Meta, mark: &Mark) -> io::Result<(Log, u32)> {
    let Mark { generation, seq: newest, sum, journal: number } = *mark;
    let mut journal = Log::open(disk, &content::journal_path(folder, number), 0)?;
    let mut head = Vec::new();
    let sum = Head { meta: meta.clone(), role: Role::Journal, generation, newest, sum }.write(&mut head);
    journal.append(&head)?;
    Ok((journal, sum))
}
