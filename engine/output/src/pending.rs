//! A file that is made under another name beside its place and moved there when it is whole.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use super::leftovers::{Listed, on_stop};
use crate::error::{OutputError, Result};

/// A file that will appear. Dropped unfinished, or when a signal ends the process, it leaves nothing behind.
#[derive(Debug)]
pub struct Pending {
    path: PathBuf,
    to: To,
}

#[derive(Debug)]
enum To {
    /// The file is moved into its place at the end.
    Temporary { file: File, temporary: TempPath, place: Claimed, _listed: Listed },
    /// A device or a pipe, which is written as it is. It stays open: a reader of a pipe goes away with its last writer.
    Stream(File),
}

/// The place of a file that will appear. No other file of this process gets it meanwhile, since one would replace the other.
#[derive(Debug)]
struct Claimed(PathBuf);

static CLAIMED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn claimed() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // The set is whole after every operation, so a panic elsewhere does not spoil it.
    CLAIMED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Claimed {
    /// A file in a folder without links; `None` if it is claimed already.
    fn new(place: PathBuf) -> Option<Self> {
        // `then_some` would make a `Claimed` even where the place is taken, and drop it: that would release the place.
        let is_free = claimed().insert(place.clone());
        is_free.then(|| Self(place))
    }
}

impl Drop for Claimed {
    fn drop(&mut self) {
        claimed().remove(&self.0);
    }
}

impl Pending {
    /// Finds out whether `path` can be written, by making the temporary file.
    pub fn new(path: &Path) -> Result<Self> {
        let fail = |reason: String| OutputError::new(format!("`{}` cannot be written: {reason}", path.display()));
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(fail("it is a folder".to_owned())),
            Ok(found) if !found.is_file() => {
                let stream = open_stream(path).map_err(|error| fail(reason_of_stream(&error)))?;
                return Ok(Self { path: path.to_owned(), to: To::Stream(stream) });
            }
            Ok(found) if found.permissions().readonly() => return Err(fail("it is write-protected".to_owned())),
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(fail(error.to_string())),
            _ => {}
        }
        let place = behind_links(path);
        let name = place.file_name().ok_or_else(|| fail("it names no file".to_owned()))?;
        let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            let folder = folder.display();
            return Err(fail(format!("the folder `{folder}` does not exist")).help(format!("mkdir -p {folder}")));
        }
        let real = folder.canonicalize().map_err(|error| fail(error.to_string()))?.join(name);
        let claimed = Claimed::new(real).ok_or_else(|| {
            fail("raxel is writing another file there".to_owned()).help("give one of them another name")
        })?;
        let (file, temporary) = temporary(folder, name)
            .map_err(|error| fail(format!("no file can be made in `{}`: {}", folder.display(), error.kind())))?
            .into_parts();
        let leftover = temporary.to_path_buf();
        let listed = on_stop(move || drop(fs::remove_file(leftover)));
        Ok(Self { path: path.to_owned(), to: To::Temporary { file, temporary, place: claimed, _listed: listed } })
    }

    /// The place where writers write until the file is whole.
    pub fn temporary(&self) -> &Path {
        match &self.to {
            To::Temporary { temporary, .. } => temporary,
            To::Stream(_) => &self.path,
        }
    }

    /// Writes everything and puts the file in its place.
    pub fn finish(self, bytes: &[u8]) -> Result {
        self.written(bytes)?.rename()
    }

    /// The same for a new file: one that others have put there meanwhile stays, and is an error.
    pub(crate) fn finish_new(self, bytes: &[u8]) -> Result {
        let Self { path, to } = self.written(bytes)?;
        match to {
            To::Temporary { temporary, place, .. } => {
                temporary.persist_noclobber(&place.0).map_err(|error| failure(&path, &error.error))
            }
            To::Stream(_) => Ok(()),
        }
    }

    fn written(mut self, bytes: &[u8]) -> Result<Self> {
        let (To::Temporary { file, .. } | To::Stream(file)) = &mut self.to;
        match file.write_all(bytes) {
            Ok(()) => Ok(self),
            Err(error) => Err(failure(&self.path, &error)),
        }
    }

    /// Puts a file that was written by others in its place.
    pub fn rename(self) -> Result {
        let Self { path, to } = self;
        match to {
            To::Temporary { temporary, place, .. } => {
                temporary.persist(&place.0).map_err(|error| failure(&path, &error.error))
            }
            To::Stream(_) => Ok(()),
        }
    }
}

fn failure(path: &Path, error: &io::Error) -> OutputError {
    OutputError::new(format!("`{}` cannot be written: {error}", path.display()))
}

/// The place that a path leads to: a link stays as it is, and the file behind it is replaced.
fn behind_links(path: &Path) -> PathBuf {
    /// As many as Linux follows.
    const MOST: usize = 40;
    let mut place = path.to_owned();
    for _ in 0..MOST {
        let Ok(target) = fs::read_link(&place) else { break };
        place = place.parent().unwrap_or(Path::new("")).join(target);
    }
    place
}

/// An empty file in a folder. The extension stays last: programs that write for raxel go by it.
fn temporary(folder: &Path, name: &OsStr) -> io::Result<NamedTempFile> {
    let extension = Path::new(name).extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    let mut builder = tempfile::Builder::new();
    builder.prefix(".raxel-").suffix(&extension);
    // Readable by others as any new file is; the process's mask is taken off.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Opens a device or a pipe. Without waiting: the writer of a pipe waits for its reader, which may never come.
#[cfg(unix)]
fn open_stream(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
    let file = open(path, OFlags::WRONLY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
    // It is there, and may take its time.
    fcntl_setfl(&file, OFlags::empty())?;
    Ok(File::from(file))
}

#[cfg(not(unix))]
fn open_stream(path: &Path) -> io::Result<File> {
    File::options().write(true).open(path)
}

fn reason_of_stream(error: &io::Error) -> String {
    #[cfg(unix)]
    if error.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error()) {
        return "it is a pipe without a reader".to_owned();
    }
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_behind_and_nothing_half_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        drop(Pending::new(&path).unwrap());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

        fs::write(&path, "old").unwrap();
        let pending = Pending::new(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(pending.temporary().extension(), path.extension());
        pending.finish(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_new_file_replaces_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let pending = Pending::new(&path).unwrap();
        fs::write(&path, "of another program").unwrap();
        pending.finish_new(b"new").unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"of another program");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| Pending::new(path).unwrap_err().message;
        assert!(message(folder.path()).contains("it is a folder"));
        assert!(message(&folder.path().join("no/a.png")).contains("does not exist"));
    }

    #[test]
    fn one_place_is_for_one_file_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let first = Pending::new(&path).unwrap();
        let same = folder.path().join(".").join("a.png");
        let refused = Pending::new(&same).unwrap_err();
        assert!(refused.message.contains("raxel is writing another file there"), "{refused:?}");
        first.finish(b"first").unwrap();
        Pending::new(&same).unwrap().finish(b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_stays_and_the_file_behind_it_is_replaced() {
        use std::os::unix::fs::symlink;

        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("far")).unwrap();
        let [link, to_link, real] = ["link.png", "latest.png", "far/real.png"].map(|name| folder.path().join(name));
        symlink("far/real.png", &link).unwrap();
        symlink(&link, &to_link).unwrap();
        // Also if there is no such file yet.
        for text in ["first", "second"] {
            Pending::new(&to_link).unwrap().finish(text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&real).unwrap(), text);
            assert_eq!([&link, &to_link].map(|path| path.is_symlink()), [true; 2]);
        }
        // Both folders contain nothing else.
        assert_eq!(
            [folder.path(), &folder.path().join("far")].map(|folder| fs::read_dir(folder).unwrap().count()),
            [3, 1]
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_reason_is_the_right_one_where_no_file_can_be_made() {
        let message = Pending::new(Path::new("/proc/a.png")).unwrap_err().message;
        assert!(message.contains("no file can be made in `/proc`") && !message.contains("does not exist"), "{message}");
    }
}
