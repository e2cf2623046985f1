//! A full disk, for programs that a test starts.

use std::path::PathBuf;
use std::process::Command;

use super::{Project, shared_library};

/// Answers a write as a full disk does where it would make its file larger than `ROOM_FOR_FILES` bytes. Memory that a driver keeps in files without
/// a name may grow.
const FULL: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>
static int full(int to, off64_t at, size_t size) {
    struct stat about;
    char link[64], name[512] = "";
    if (!size || fstat(to, &about) || !S_ISREG(about.st_mode)) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", to);
    if (readlink(link, name, sizeof name - 1) < 0 || !strncmp(name, "/memfd:", 7)) return 0;
    if (at < 0) at = lseek64(to, 0, SEEK_CUR);
    const char *room = getenv("ROOM_FOR_FILES");
    if (room && at + (off64_t)size <= atoll(room)) return 0;
    errno = ENOSPC;
    return 1;
}
#define REAL(function) ((__typeof__(&function))dlsym(RTLD_NEXT, #function))
ssize_t write(int to, const void *from, size_t size) { return full(to, -1, size) ? -1 : REAL(write)(to, from, size); }
ssize_t writev(int to, const struct iovec *from, int count) {
    size_t size = 0;
    for (int i = 0; i < count; i++) size += from[i].iov_len;
    return full(to, -1, size) ? -1 : REAL(writev)(to, from, count);
}
ssize_t pwrite64(int to, const void *from, size_t size, off64_t at) { return full(to, at, size) ? -1 : REAL(pwrite64)(to, from, size, at); }
ssize_t copy_file_range(int from, off64_t *at, int to, off64_t *place, size_t size, unsigned flags) {
    return full(to, place ? *place : -1, size) ? -1 : REAL(copy_file_range)(from, at, to, place, size, flags);
}
"#;

/// A disk on which a file has room for so many bytes, and no more.
pub struct FullDisk {
    library: PathBuf,
    room: u64,
    /// The folder of the library.
    _project: Project,
}

impl FullDisk {
    pub fn with_room(room: u64) -> Self {
        let project = Project::empty();
        Self { library: shared_library(&project, "libfull.so", FULL), room, _project: project }
    }

    /// Lets a program and all that it starts write to this disk alone.
    pub fn under<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command.env("LD_PRELOAD", &self.library).env("ROOM_FOR_FILES", self.room.to_string())
    }
}
