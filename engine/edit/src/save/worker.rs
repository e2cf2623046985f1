//! The thread that brings a save to the disk: journals every now and then, and checkpoints.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use raxel_world::ChunkPos;
use rayon::prelude::*;

use super::content;
use super::disk::{Disk, Storage};
use super::log::Log;
use super::record::{self, Kind};
use crate::history::Stored;

/// The chunks to be written.
pub(super) struct Checkpoint {
    /// `None` is the base's.
    pub(super) chunks: Vec<(ChunkPos, Option<Stored>)>,
    /// The newest edit in them, and its sum.
    pub(super) seq: u64,
    pub(super) sum: u32,
    /// The newest journal that they take the place of.
    pub(super) removes_up_to: u64,
}

/// A checkpoint that was made, or was not.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) positions: Vec<ChunkPos>,
    pub(super) seq: u64,
    pub(super) result: Result<(), String>,
}

enum Message {
    Checkpoint(Checkpoint),
    Journal(Arc<dyn Storage>, u64),
}

/// The files that the thread writes, or brings to the disk.
pub(super) struct Files {
    pub(super) disk: Arc<dyn Disk>,
    pub(super) folder: PathBuf,
    pub(super) chunks: Log,
    /// The sum of the last record of the chunks.
    pub(super) chunks_sum: u32,
    pub(super) journal: Arc<dyn Storage>,
    /// The number of the journal.
    pub(super) number: u64,
    pub(super) tail: Arc<dyn Storage>,
}

/// The thread, as the save knows it.
#[derive(Debug)]
pub(super) struct Worker {
    messages: Option<Sender<Message>>,
    done: Receiver<Done>,
    busy: bool,
    unsynced: Arc<AtomicBool>,
    lost: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub(super) fn start(files: Files, sync: Duration) -> io::Result<Self> {
        let (messages, inbox) = channel();
        let (outbox, done) = channel();
        let unsynced = Arc::new(AtomicBool::new(true));
        let lost = Arc::new(AtomicU64::new(0));
        let mut state = State { files, unsynced: unsynced.clone(), lost: lost.clone() };
        let thread =
            std::thread::Builder::new().name("save".to_owned()).spawn(move || state.run(&inbox, &outbox, sync))?;
        Ok(Self { messages: Some(messages), done, busy: false, unsynced, lost, thread: Some(thread) })
    }

    pub(super) fn is_busy(&self) -> bool {
        self.busy
    }

    /// The journal has bytes that are not on the disk.
    pub(super) fn unsynced(&self) {
        self.unsynced.store(true, Ordering::Release);
    }

    /// The newest journal that the system failed to bring to the disk, until a checkpoint has its edits; 0 where there is none. The system may have
    /// dropped data that it failed to write: a later sync that succeeds proves nothing about it.
    pub(super) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Acquire)
    }

    /// A journal could not be brought to the disk.
    pub(super) fn lose(&self, journal: u64) {
        self.lost.fetch_max(journal, Ordering::AcqRel);
    }

    /// Another journal takes the place of the one before.
    pub(super) fn journal(&self, journal: Arc<dyn Storage>, number: u64) {
        self.send(Message::Journal(journal, number));
    }

    pub(super) fn checkpoint(&mut self, checkpoint: Checkpoint) {
        self.busy = true;
        self.send(Message::Checkpoint(checkpoint));
    }

    fn send(&self, message: Message) {
        if let Some(messages) = &self.messages {
            // The thread ends only when this end of the channel does.
            let _ = messages.send(message);
        }
    }

    /// The checkpoint that was asked for, if it is over.
    pub(super) fn done(&mut self) -> Option<Done> {
        let done = self.done.try_recv().ok()?;
        self.busy = false;
        Some(done)
    }

    /// Waits for the checkpoint that was asked for.
    pub(super) fn wait(&mut self) -> Option<Done> {
        let done = if self.busy { self.done.recv().ok() } else { None };
        self.busy = false;
        done
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.messages = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct State {
    files: Files,
    unsynced: Arc<AtomicBool>,
    lost: Arc<AtomicU64>,
}

impl State {
    fn run(&mut self, inbox: &Receiver<Message>, outbox: &Sender<Done>, sync: Duration) {
        loop {
            match inbox.recv_timeout(sync) {
                Ok(Message::Checkpoint(checkpoint)) => {
                    let positions = checkpoint.chunks.iter().map(|(pos, _)| *pos).collect();
                    let result = self.write(&checkpoint).map_err(|error| error.to_string());
                    // The receiver may be gone.
                    let _ = outbox.send(Done { positions, seq: checkpoint.seq, result });
                }
                Ok(Message::Journal(journal, number)) => {
                    self.sync();
                    (self.files.journal, self.files.number) = (journal, number);
                    self.unsynced.store(true, Ordering::Release);
                }
                Err(RecvTimeoutError::Timeout) => self.sync(),
                Err(RecvTimeoutError::Disconnected) => return self.sync(),
            }
        }
    }

    fn sync(&mut self) {
        let Files { journal, tail, number, .. } = &self.files;
        // The tail last, so that a power cut seldom leaves it ahead of the journal.
        if self.unsynced.swap(false, Ordering::AcqRel) && journal.sync().and_then(|()| tail.sync()).is_err() {
            self.unsynced.store(true, Ordering::Release);
            self.lost.fetch_max(*number, Ordering::AcqRel);
        }
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()> {
        let before = (self.files.chunks.bytes(), self.files.chunks_sum);
        let written = self.append(checkpoint).and_then(|()| self.files.chunks.storage().sync());
        if let Err(error) = written {
            self.files.chunks_sum = before.1;
            self.files.chunks.truncate(before.0)?;
            return Err(error);
        }
        // Only now are the journals no longer needed.
        for path in content::journals(&self.files.folder).unwrap_or_default() {
            if content::journal_number(&path).is_some_and(|number| number <= checkpoint.removes_up_to) {
                self.files.disk.remove(&path)?;
            }
        }
        let held = |lost: u64| (lost <= checkpoint.removes_up_to).then_some(0);
        // `Err` means that a journal is newer than those that the checkpoint holds.
        let _ = self.lost.fetch_update(Ordering::AcqRel, Ordering::Acquire, held);
        self.files.disk.sync_folder(&self.files.folder)
    }

    fn append(&mut self, checkpoint: &Checkpoint) -> io::Result<()> {
        let Files { chunks: log, chunks_sum: sum, .. } = &mut self.files;
        for chunks in checkpoint.chunks.chunks(64) {
            let packed: Vec<_> =
                chunks.par_iter().map(|(pos, stored)| (*pos, stored.as_ref().map(Stored::packed))).collect();
            let mut bytes = Vec::new();
            for (pos, packed) in packed {
                let (kind, payload) =
                    packed.as_ref().map_or((Kind::Base, &[][..]), |packed| (Kind::Chunk, packed.bytes()));
                *sum = record::write(&mut bytes, *sum, kind, checkpoint.seq, pos, payload);
            }
            log.append(&bytes)?;
        }
        let mut bytes = Vec::new();
        *sum = write_commit(&mut bytes, *sum, checkpoint.seq, checkpoint.sum);
        log.append(&bytes)
    }
}

/// The end of a checkpoint: twice, so that no single byte takes it away. Gives the sum of the last record.
pub(super) fn write_commit(bytes: &mut Vec<u8>, before: u32, seq: u64, sum: u32) -> u32 {
    (0..2).fold(before, |before, _| {
        record::write(bytes, before, Kind::Commit, seq, ChunkPos::new(0, 0, 0), &sum.to_le_bytes())
    })
}
