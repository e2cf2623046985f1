//! The save of an edited world: a journal of operations and, now and then, the whole chunks that they changed.
//!
//! A save is a folder. An edit is acknowledged when its record is in the newest journal and its number is in the tail. Each is one
//! `write`. So the edit survives the end of the program at any moment, and its loss would be noticed. A thread brings both to the disk
//! every [`SaveOptions::sync`]. A power cut may cost the edits since then. When the journal has grown, a checkpoint appends the changed
//! chunks to `chunks.log` and syncs them to the disk. Only then does it remove the journals, whose edits are in the chunks now. Snapshots in a
//! database were measured and not taken: one flipped byte in a page of its tree would lose more than one record.

mod content;
mod damage;
mod disk;
#[cfg(test)]
mod faults;
mod head;
mod log;
mod place;
mod record;
mod tail;
mod verify;
mod worker;
mod writer;

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_world::{ChunkPos, MaterialIndex};

pub use content::FileInfo;
pub use damage::Damage;
pub use head::Meta;
pub use place::check_folder;
pub use verify::{Compacted, Report, compact, pack, verify};

use crate::edits::{Change, Edits};
use crate::operation::Operation;
use crate::packed::PackedChunk;
use content::Content;
use disk::{Disk, System};
use head::FORMAT;
use worker::Done;
use writer::Writer;

/// Time between two tries of a failed write.
const RETRY: Duration = if cfg!(test) { Duration::ZERO } else { Duration::from_secs(1) };

/// How a save is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaveOptions {
    /// Time after which an edit is on the disk in any case.
    pub sync: Duration,
    /// A checkpoint is made when the journal has this many bytes,
    pub journal_bytes: u64,
    /// and when this much time has passed since the last one and there is something new.
    pub checkpoint: Duration,
    /// A generator that is not the save's is accepted, and the edited chunks stay as they are.
    pub keep_on_generator_change: bool,
    /// Nothing is written, and another process may have the save open.
    pub read_only: bool,
}

impl Default for SaveOptions {
    /// One second, 16 MiB, thirty seconds, refused.
    fn default() -> Self {
        Self {
            sync: Duration::from_secs(1),
            journal_bytes: 16 << 20,
            checkpoint: Duration::from_secs(30),
            keep_on_generator_change: false,
            read_only: false,
        }
    }
}

/// Why a save cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// A newer program wrote it.
    #[error("the save has format {found}; this program knows formats up to {known}")]
    Newer {
        /// Its format.
        found: u32,
        /// The newest known.
        known: u32,
    },
    /// The world below the edits is built otherwise than when they were made.
    #[error("the world is built otherwise than when the save was made: {saved} then, {now} now")]
    Generator {
        /// Hash then.
        saved: String,
        /// Hash now.
        now: String,
    },
    /// Materials that the edits use are gone.
    #[error("the save uses materials that the world no longer has: {}", names.join(", "))]
    Materials {
        /// Their names.
        names: Vec<String>,
    },
    /// It cannot be written: its folder cannot, or another process has it open.
    #[error("{why}")]
    ReadOnly {
        /// Which of the two.
        why: String,
    },
    /// The folder cannot be one of a save.
    #[error("{why}")]
    Place {
        /// The state of the save.
        why: String,
    },
    /// A file cannot be read.
    #[error("`{}`: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
}

/// Something that happened to a save while it was in use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SaveEvent {
    /// Edits are not saved for the time being: kept in memory, and tried again.
    Failing {
        /// Why.
        why: String,
    },
    /// Everything is saved again.
    Recovered,
    /// A checkpoint was made.
    Checkpoint {
        /// Chunks written.
        chunks: usize,
        /// The newest edit in them.
        seq: u64,
    },
}

/// An opened save, and its contents.
#[derive(Debug)]
pub struct Opened {
    /// The save.
    pub save: Save,
    /// The chunks of its last checkpoint.
    pub chunks: Vec<(ChunkPos, PackedChunk)>,
    /// The edits after it, to be replayed in order.
    pub steps: Vec<(u64, Vec<Operation>)>,
    /// The damaged parts.
    pub damages: Vec<Damage>,
    /// Why nothing is saved, when nothing can be: the folder cannot be written, or another process has the save open.
    pub read_only: Option<String>,
}

/// An open save. Dropping it brings everything to the disk.
#[derive(Debug)]
pub struct Save {
    folder: PathBuf,
    options: SaveOptions,
    /// The newest edit.
    seq: u64,
    /// Chunks changed since the last checkpoint began.
    dirty: BTreeSet<ChunkPos>,
    /// None of a save that is only read.
    writer: Option<Writer>,
    /// None: the next one is due now.
    last_checkpoint: Option<Instant>,
    /// The system failed to bring a journal to the disk: a checkpoint has to hold its edits.
    is_refused: bool,
}

impl Save {
    /// Opens the save in a folder, which is made if there is none.
    pub fn open(folder: &Path, meta: &Meta, options: SaveOptions) -> Result<Opened, SaveError> {
        Self::open_on(Arc::new(System), folder, meta, options)
    }

    fn open_on(disk: Arc<dyn Disk>, folder: &Path, meta: &Meta, options: SaveOptions) -> Result<Opened, SaveError> {
        check_folder(folder)?;
        let meta = Meta { format: FORMAT, ..meta.clone() };
        let lock = if options.read_only { Err("it is only read".to_owned()) } else { lock(folder) };
        let mut content = Content::read(folder)?;
        let mut rewrite = content.rewrite;
        if let Some(saved) = &content.meta {
            if saved.generator != meta.generator {
                if !options.keep_on_generator_change {
                    return Err(SaveError::Generator { saved: short(&saved.generator), now: short(&meta.generator) });
                }
                rewrite = true;
            }
            if saved.materials != meta.materials {
                let indices = indices(&saved.materials, &meta.materials)?;
                remap(&mut content, &indices);
                rewrite = true;
            }
        }
        let (lock, mut read_only) = match lock {
            Ok(lock) => (Some(lock), None),
            Err(why) => (None, Some(why)),
        };
        let seq = content.newest();
        let writer =
            lock.and_then(|lock| match Writer::open(disk, folder, meta, &content, rewrite, options.sync, lock) {
                Ok(writer) => Some(writer),
                Err(error) => {
                    read_only = Some(error.to_string());
                    None
                }
            });
        let save = Self {
            folder: folder.to_owned(),
            options,
            seq,
            dirty: BTreeSet::new(),
            writer,
            last_checkpoint: Some(Instant::now()),
            is_refused: false,
        };
        let chunks = content.chunks.into_iter().filter_map(|(pos, chunk)| Some((pos, chunk?))).collect();
        let steps = content.steps.into_iter().filter(|(_, operations)| !operations.is_empty()).collect();
        Ok(Opened { save, chunks, steps, damages: content.damages, read_only })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The number of the newest edit.
    pub fn seq(&self) -> u64 {
        self.seq
    }

    /// Whether nothing is written.
    pub fn is_read_only(&self) -> bool {
        self.writer.is_none()
    }

    /// Notes the changes of a replayed step: it is in no checkpoint yet.
    pub fn replayed(&mut self, change: &Change) {
        self.dirty.extend(change.chunks.iter().map(|chunk| chunk.pos));
    }

    /// Saves a step. When this returns `Ok(true)`, it survives the end of the program; with `Ok(false)` the save is read only. On an error
    /// it is kept in memory and tried again by [`Save::poll`].
    pub fn commit(&mut self, operations: &[Operation], change: &Change) -> io::Result<bool> {
        self.seq += 1;
        self.dirty.extend(change.chunks.iter().map(|chunk| chunk.pos));
        let Some(writer) = &mut self.writer else { return Ok(false) };
        writer.commit(self.seq, operations).map(|()| true)
    }

    /// Retries failed writes, and begins a checkpoint when one is due. Call it once a frame; it never waits.
    pub fn poll(&mut self, edits: &Edits) -> Vec<SaveEvent> {
        let mut events = Vec::new();
        self.take_done(&mut events);
        let Some(writer) = &mut self.writer else { return events };
        if writer.failing.is_some_and(|since| since.elapsed() >= RETRY) {
            match writer.write_waiting() {
                Ok(()) if !writer.overflown => events.push(SaveEvent::Recovered),
                Ok(()) => self.last_checkpoint = None,
                Err(_) => return events,
            }
        }
        let is_refused = writer.worker.lost() > 0;
        if is_refused != self.is_refused {
            self.is_refused = is_refused;
            if is_refused {
                self.last_checkpoint = None;
                events.push(SaveEvent::Failing { why: "the journal cannot be brought to the disk".to_owned() });
            } else {
                events.push(SaveEvent::Recovered);
            }
        }
        let due = writer.overflown
            || writer.journal_bytes() >= self.options.journal_bytes
            || self.last_checkpoint.is_none_or(|last| last.elapsed() >= self.options.checkpoint);
        if due && (is_refused || !self.dirty.is_empty()) && !writer.worker.is_busy() {
            self.begin_checkpoint(edits);
        }
        events
    }

    /// Makes a checkpoint of everything now, and waits for it.
    pub fn checkpoint(&mut self, edits: &Edits) -> Vec<SaveEvent> {
        let mut events = Vec::new();
        self.wait_done(&mut events);
        self.begin_checkpoint(edits);
        self.wait_done(&mut events);
        events
    }

    /// Waits until everything that was acknowledged is on the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        match &self.writer {
            Some(writer) => writer.sync(),
            None => Ok(()),
        }
    }

    fn begin_checkpoint(&mut self, edits: &Edits) {
        let Some(writer) = &mut self.writer else { return };
        self.last_checkpoint = Some(Instant::now());
        if writer.next_journal().is_err() {
            // The journal goes on; another try comes with the next poll.
            return;
        }
        let chunks = std::mem::take(&mut self.dirty).into_iter().map(|pos| (pos, edits.stored(pos))).collect();
        writer.checkpoint(chunks, self.seq);
    }

    fn take_done(&mut self, events: &mut Vec<SaveEvent>) {
        let done: Vec<Done> = self.writer.iter_mut().filter_map(|writer| writer.worker.done()).collect();
        done.into_iter().for_each(|done| self.note(done, events));
    }

    fn wait_done(&mut self, events: &mut Vec<SaveEvent>) {
        if let Some(done) = self.writer.as_mut().and_then(|writer| writer.worker.wait()) {
            self.note(done, events);
        }
    }

    fn note(&mut self, done: Done, events: &mut Vec<SaveEvent>) {
        match done.result {
            Ok(()) => {
                events.push(SaveEvent::Checkpoint { chunks: done.positions.len(), seq: done.seq });
                if self.writer.as_mut().is_some_and(|writer| writer.holds(done.seq)) {
                    events.push(SaveEvent::Recovered);
                }
            }
            Err(why) => {
                // The journals that hold these edits are still there.
                self.dirty.extend(done.positions);
                events.push(SaveEvent::Failing { why });
            }
        }
    }
}

/// The lock of a save, or why it cannot be had.
fn lock(folder: &Path) -> Result<File, String> {
    let failed = |error: io::Error| format!("`{}` cannot be written: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(failed)?;
    let path = folder.join("lock");
    let file = File::options().create(true).truncate(false).write(true).open(path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(format!("another process has `{}` open", folder.display())),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// First digits of a hash.
fn short(hash: &[u8; 32]) -> String {
    let first: [u8; 8] = std::array::from_fn(|i| hash[i]);
    format!("{:016x}", u64::from_be_bytes(first))
}

/// Where the materials of a save are in the world.
#[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
fn indices(saved: &[String], now: &[String]) -> Result<Vec<MaterialIndex>, SaveError> {
    let find = |(index, name): (usize, &String)| match index {
        0 => Ok(0),
        _ => now.iter().skip(1).position(|known| known == name).map(|at| at as MaterialIndex + 1).ok_or(name.clone()),
    };
    let (found, missing): (Vec<_>, Vec<_>) = saved.iter().enumerate().map(find).partition(Result::is_ok);
    let names: Vec<String> = missing.into_iter().filter_map(Result::err).collect();
    if names.is_empty() { Ok(found.into_iter().flatten().collect()) } else { Err(SaveError::Materials { names }) }
}

fn remap(content: &mut Content, indices: &[MaterialIndex]) {
    content.chunks.retain(|_, chunk| {
        let Some(packed) = chunk else { return true };
        match packed.remapped(indices) {
            Some(other) => *packed = other,
            None => return false,
        }
        true
    });
    for operations in content.steps.values_mut() {
        *operations = operations.iter().filter_map(|operation| operation.remapped(indices)).collect();
    }
}
