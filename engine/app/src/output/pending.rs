//! A file that is made under another name beside its place and moved there when it is whole.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::failure::{Failure, Result};

/// A file that will appear. Dropped unfinished, it leaves nothing behind.
#[derive(Debug)]
pub(crate) struct Pending {
    path: PathBuf,
    /// `None` for a device or pipe, which is written as it is.
    temporary: Option<PathBuf>,
}

impl Pending {
    /// Finds out whether `path` can be written, by making the temporary file.
    pub fn new(path: &Path) -> Result<Self> {
        let fail = |reason: String| Failure::usage(format!("`{}` cannot be written: {reason}", path.display()));
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(fail("it is a folder".to_owned())),
            Ok(found) if !found.is_file() => {
                OpenOptions::new().write(true).open(path).map_err(|error| fail(error.to_string()))?;
                return Ok(Self { path: path.to_owned(), temporary: None });
            }
            Ok(found) if found.permissions().readonly() => return Err(fail("it is write-protected".to_owned())),
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(fail(error.to_string())),
            _ => {}
        }
        let name = path.file_name().ok_or_else(|| fail("it names no file".to_owned()))?.to_string_lossy();
        // The extension stays last: programs that write for raxel go by it.
        let temporary = path.with_file_name(format!(".raxel-{}-{name}", std::process::id()));
        File::create(&temporary).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                let folder = path.parent().map(|f| f.display().to_string()).unwrap_or_default();
                fail(format!("the folder `{folder}` does not exist")).help(format!("mkdir -p {folder}"))
            }
            _ => fail(error.to_string()),
        })?;
        Ok(Self { path: path.to_owned(), temporary: Some(temporary) })
    }

    /// Where to write until it is whole.
    pub fn temporary(&self) -> &Path {
        self.temporary.as_deref().unwrap_or(&self.path)
    }

    /// Writes everything and puts the file in its place.
    pub fn finish(self, bytes: &[u8]) -> Result {
        let written = OpenOptions::new()
            .write(true)
            .truncate(self.temporary.is_some())
            .open(self.temporary())
            .and_then(|mut file| file.write_all(bytes));
        match written {
            Ok(()) => self.rename(),
            Err(error) => Err(self.failure(&error)),
        }
    }

    /// Puts a file that was written by others in its place.
    pub fn rename(mut self) -> Result {
        let Some(temporary) = self.temporary.take() else { return Ok(()) };
        fs::rename(&temporary, &self.path).map_err(|error| {
            let _ = fs::remove_file(&temporary);
            self.failure(&error)
        })
    }

    fn failure(&self, error: &io::Error) -> Failure {
        Failure::usage(format!("`{}` cannot be written: {error}", self.path.display()))
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            let _ = fs::remove_file(temporary);
        }
    }
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
        pending.finish(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| Pending::new(path).unwrap_err().message.unwrap();
        assert!(message(folder.path()).contains("it is a folder"));
        assert!(message(&folder.path().join("no/a.png")).contains("does not exist"));
    }
}
