//! A full disk, for programs that a test starts.

use std::path::PathBuf;
use std::process::Command;

use super::{Project, shared_library};

/// Answers a write as a full disk does where it would make its file larger than `ROOM_FOR_FILES` bytes. Memory that a driver keeps in files without
/// a name may grow.
const FULL: &str = include_str!("full_disk.c");

/// A disk on which a file has room for so many bytes, and no more.
pub(crate) struct FullDisk {
    library: PathBuf,
    room: u64,
    /// The folder of the library.
    _project: Project,
}

impl FullDisk {
    pub(crate) fn with_room(room: u64) -> Self {
        let project = Project::empty();
        Self { library: shared_library(&project, "libfull.so", FULL), room, _project: project }
    }

    /// Lets a program and all that it starts write to this disk alone.
    pub(crate) fn under<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command.env("LD_PRELOAD", &self.library).env("ROOM_FOR_FILES", self.room.to_string())
    }
}
