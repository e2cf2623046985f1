//! Looking into a save that no world is open for, and writing it anew.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use raxel_world::ChunkPos;

use super::content::{self, CHUNKS, Content, Damage, FileInfo, Meta};
use super::log::sync_folder;
use super::record::{self, Kind};
use super::worker::write_commit;
use super::{SaveError, described, lock};
use crate::operation::Operation;

/// What is in a save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// What it belongs to; `None` when the folder has no save.
    pub meta: Option<Meta>,
    /// Its files.
    pub files: Vec<FileInfo>,
    /// Chunks in the last checkpoint.
    pub chunks: u64,
    /// Records of chunks that a newer one has replaced: what [`compact`] leaves out.
    pub replaced: u64,
    /// Edits up to here are in chunks.
    pub applied: u64,
    /// The newest edit.
    pub newest: u64,
    /// What is broken, or unfinished.
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

/// Writes the chunks of a save anew without what newer ones have replaced. Gives the bytes before and after.
pub fn compact(folder: &Path) -> Result<(u64, u64), SaveError> {
    let failed = |error| SaveError::Io { path: folder.to_owned(), error };
    let _lock = lock(folder).map_err(|why| SaveError::ReadOnly { why })?;
    let content = Content::read(folder)?;
    let Some(meta) = &content.meta else { return Ok((0, 0)) };
    let size = || std::fs::metadata(folder.join(CHUNKS)).map_or(0, |file| file.len());
    let before = size();
    write_chunks(folder, meta, &content).map_err(failed)?;
    Ok((before, size()))
}

/// The whole save as the bytes of one file, which is a save when it stands as `chunks.log` in a folder of its own.
pub fn pack(folder: &Path) -> Result<Vec<u8>, SaveError> {
    let content = Content::read(folder)?;
    let mut bytes = content.meta.as_ref().map(|meta| described(meta, 0)).unwrap_or_default();
    add_chunks(&mut bytes, &content);
    add_steps(&mut bytes, &content);
    Ok(bytes)
}

/// Puts a file with the chunks in place of the one that is there, and the edits after them into a journal when they were in none.
pub(super) fn write_chunks(folder: &Path, meta: &Meta, content: &Content) -> io::Result<()> {
    let mut bytes = described(meta, 0);
    add_chunks(&mut bytes, content);
    add_steps(&mut bytes, content);
    let path = folder.join("chunks.new");
    let mut file = File::create(&path)?;
    file.write_all(&bytes)?;
    file.sync_data()?;
    std::fs::rename(path, folder.join(CHUNKS))?;
    sync_folder(folder)?;
    // The edits are in the new file; journals that are left over by a stop before this are read once more, and give the same.
    for journal in content::journals(folder).unwrap_or_default() {
        std::fs::remove_file(journal)?;
    }
    sync_folder(folder)
}

fn add_chunks(bytes: &mut Vec<u8>, content: &Content) {
    for (pos, chunk) in &content.chunks {
        // The base needs no record where nothing else was said before.
        if let Some(chunk) = chunk {
            record::write(bytes, Kind::Chunk, content.applied, *pos, chunk.bytes());
        }
    }
    write_commit(bytes, content.applied);
}

fn add_steps(bytes: &mut Vec<u8>, content: &Content) {
    let mut add = |seq: u64, operations: &[Operation]| {
        let payload = postcard::to_stdvec(operations).unwrap_or_default();
        record::write(bytes, Kind::Operations, seq, ChunkPos::new(0, 0, 0), &payload);
    };
    let mut next = content.applied + 1;
    for (&seq, operations) in &content.steps {
        if seq > next {
            // Lost edits were named when the save was read; an empty step says so, and that they are not to be missed again.
            add(seq - 1, &[]);
        }
        add(seq, operations);
        next = seq + 1;
    }
    if content.begun >= next {
        add(content.begun, &[]);
    }
}
