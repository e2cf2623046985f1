//! Verifying and rewriting a save that no world is open for.

use std::io;
use std::path::Path;

use raxel_world::ChunkPos;

use super::content::{self, CHUNKS, Content, FileInfo};
use super::damage::Damage;
use super::disk::{Disk, System};
use super::head::{FORMAT, Head, Meta, Role};
use super::record::{self, Kind};
use super::tail::{Mark, Tail};
use super::worker::write_commit;
use super::{SaveError, lock};
use crate::operation::Operation;

/// The contents of a save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The world that it belongs to; `None` when the folder has no save.
    pub meta: Option<Meta>,
    /// Its files.
    pub files: Vec<FileInfo>,
    /// Chunks in the last checkpoint.
    pub chunks: u64,
    /// Records of chunks that a newer one has replaced. [`compact`] leaves them out.
    pub replaced: u64,
    /// Edits up to here are in chunks.
    pub applied: u64,
    /// The newest edit.
    pub newest: u64,
    /// Broken or unfinished parts.
    pub damages: Vec<Damage>,
}

impl Report {
    /// Bytes of all files.
    pub fn bytes(&self) -> u64 {
        self.files.iter().map(|file| file.bytes).sum()
    }
}

/// Reads every record of a save and checks it.
pub fn verify(folder: &Path) -> Result<Report, SaveError> {
    let content = Content::read(folder)?;
    let newest = content.newest();
    Ok(Report {
        chunks: content.chunks.values().flatten().count() as u64,
        replaced: content.replaced,
        applied: content.applied,
        newest,
        meta: content.meta,
        files: content.files,
        damages: content.damages,
    })
}

/// Bytes of the chunks of a save.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compacted {
    /// Before it was compacted.
    pub before: u64,
    /// Afterwards.
    pub after: u64,
}

/// Rewrites the chunks of a save, and drops replaced ones.
pub fn compact(folder: &Path) -> Result<Compacted, SaveError> {
    compact_on(&System, folder)
}

pub(super) fn compact_on(disk: &dyn Disk, folder: &Path) -> Result<Compacted, SaveError> {
    let failed = |error| SaveError::Io { path: folder.to_owned(), error };
    let _lock = lock(folder).map_err(|why| SaveError::ReadOnly { why })?;
    let content = Content::read(folder)?;
    let Some(meta) = &content.meta else { return Ok(Compacted::default()) };
    let size = || std::fs::metadata(folder.join(CHUNKS)).map_or(0, |file| file.len());
    let before = size();
    rewrite(disk, folder, meta, &content).map_err(failed)?;
    Ok(Compacted { before, after: size() })
}

/// The whole save as the bytes of one file, which is a save when it stands as `chunks.log` in a folder of its own.
pub fn pack(folder: &Path) -> Result<Vec<u8>, SaveError> {
    let content = Content::read(folder)?;
    Ok(content.meta.as_ref().map(|meta| Whole::of(&content, meta, Role::Packed).bytes).unwrap_or_default())
}

/// Puts a file with everything in place of all that are there.
pub(super) fn rewrite(disk: &dyn Disk, folder: &Path, meta: &Meta, content: &Content) -> io::Result<Whole> {
    let whole = Whole::of(content, meta, Role::Chunks);
    let path = folder.join("chunks.new");
    let file = disk.create(&path)?;
    file.append(&whole.bytes)?;
    file.sync()?;
    // A file with the chunks is never without a tail. Should the program end here, this one goes with the files that are there.
    let mark = Mark { generation: whole.generation, seq: content.newest(), journal: 0, sum: whole.newest_sum };
    Tail::create(disk, folder, &mark)?;
    disk.rename(&path, &folder.join(CHUNKS))?;
    disk.sync_folder(folder)?;
    // The edits are in the new file. Journals that are left over by a stop before this are of an older generation.
    for journal in content::journals(folder).unwrap_or_default() {
        disk.remove(&journal)?;
    }
    disk.sync_folder(folder)?;
    Ok(whole)
}

/// A save in one file.
pub(super) struct Whole {
    bytes: Vec<u8>,
    pub(super) generation: u64,
    /// The sum of the newest edit.
    pub(super) newest_sum: u32,
    /// The end of the file, and the sum of its last record.
    pub(super) end: (u64, u32),
}

impl Whole {
    fn of(content: &Content, meta: &Meta, role: Role) -> Self {
        let generation = content.generation.max(content.tail.map_or(0, |mark| mark.generation)) + 1;
        let meta = Meta { format: FORMAT, ..meta.clone() };
        let head = Head { meta, role, generation, newest: content.newest(), sum: 0 };
        let mut bytes = Vec::new();
        let sum = head.write(&mut bytes);
        let mut whole = Self { bytes, generation, newest_sum: 0, end: (0, sum) };
        whole.add_chunks(content);
        whole.add_steps(content);
        whole.end.0 = whole.bytes.len() as u64;
        whole
    }

    fn add_chunks(&mut self, content: &Content) {
        for (pos, chunk) in &content.chunks {
            // The base needs no record unless an older record replaced it.
            if let Some(chunk) = chunk {
                self.end.1 =
                    record::write(&mut self.bytes, self.end.1, Kind::Chunk, content.applied, *pos, chunk.bytes());
            }
        }
        // The sum of the edit was that of an older generation; from now on it is that of the chunks.
        self.newest_sum = self.end.1;
        self.end.1 = write_commit(&mut self.bytes, self.end.1, content.applied, self.newest_sum);
    }

    fn add_steps(&mut self, content: &Content) {
        let mut next = content.applied + 1;
        for (&seq, operations) in &content.steps {
            if seq > next {
                // Lost edits were named when the save was read. An empty step records that, so that they are not missed again.
                self.add_step(seq - 1, &[]);
            }
            self.add_step(seq, operations);
            next = seq + 1;
        }
        if content.newest() >= next {
            self.add_step(content.newest(), &[]);
        }
    }

    fn add_step(&mut self, seq: u64, operations: &[Operation]) {
        let payload = postcard::to_stdvec(operations).unwrap_or_default();
        self.end.1 =
            record::write(&mut self.bytes, self.end.1, Kind::Operations, seq, ChunkPos::new(0, 0, 0), &payload);
        self.newest_sum = self.end.1;
    }
}
