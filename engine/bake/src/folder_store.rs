//! A store that is a folder.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use crate::store::{DOCUMENT, Store, StoreError, Wanted};

/// Objects as files of a folder, which is made when the first one is written.
#[derive(Clone, Debug)]
pub struct FolderStore {
    root: PathBuf,
}

impl FolderStore {
    /// The store in a folder.
    pub fn new(root: PathBuf) -> Self {
        Self { root }
    }
}

impl Store for FolderStore {
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError> {
        match File::open(self.root.join(key)) {
            Ok(file) => read(file, &wanted).map(Some).map_err(|error| failed(key, &error)),
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
            Err(error) => Err(failed(key, &error)),
        }
    }

    /// Writes to another name in the same folder first, and renames. A killed process leaves a file `.KEY.….part` at most.
    fn put(&self, key: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.write(key, bytes).map_err(|error| failed(key, &error))
    }

    /// A file is there or not, and waiting mends nothing. It may have been replaced between two reads.
    fn pauses(&self) -> &[Duration] {
        &[Duration::ZERO]
    }
}

impl FolderStore {
    fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.root.join(key);
        let folder = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder)?;
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let prefix = format!(".{name}.");
        let mut options = tempfile::Builder::new();
        options.prefix(&prefix).suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // Without the bits of the user's umask: others may read a store.
            options.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut part = options.tempfile_in(folder)?;
        part.write_all(bytes)?;
        part.as_file().sync_all()?;
        part.persist(&path).map_err(|error| error.error)?;
        Ok(())
    }
}

fn read(mut file: File, wanted: &Wanted) -> io::Result<Vec<u8>> {
    if !file.metadata()?.is_file() {
        return Err(io::Error::other("it is not a file"));
    }
    let mut bytes = Vec::new();
    let size = file.metadata()?.len();
    let (from, most) = match wanted {
        Wanted::Document if size > DOCUMENT => return Err(io::Error::other(format!("it has {size} bytes"))),
        Wanted::Whole | Wanted::Document => (0, size),
        Wanted::Bytes(range) => (range.start, range.end.saturating_sub(range.start)),
        Wanted::Last(count) => (size.saturating_sub(*count), *count),
    };
    file.seek(SeekFrom::Start(from))?;
    file.take(most).read_to_end(&mut bytes)?;
    match wanted {
        Wanted::Bytes(range) if bytes.len() as u64 != most => {
            let (start, end) = (range.start, range.end);
            Err(io::Error::other(format!("it has {size} bytes, and those from {start} to {end} were wanted")))
        }
        _ => Ok(bytes),
    }
}

fn failed(key: &str, error: &io::Error) -> StoreError {
    let passing = matches!(error.kind(), io::ErrorKind::Interrupted | io::ErrorKind::TimedOut);
    StoreError { key: key.to_owned(), reason: error.to_string(), passing }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_is_what_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let store = FolderStore::new(folder.path().join("store"));
        assert_eq!(store.get("0/c/1", Wanted::Whole), Ok(None));
        store.put("0/c/1", b"first").unwrap();
        store.put("0/c/1", b"a longer second").unwrap();
        let get = |wanted| store.get("0/c/1", wanted);
        assert_eq!(get(Wanted::Whole).unwrap().unwrap(), b"a longer second");
        assert_eq!(get(Wanted::Bytes(2..8)).unwrap().unwrap(), b"longer");
        assert_eq!(get(Wanted::Last(6)).unwrap().unwrap(), b"second");
        assert_eq!(get(Wanted::Last(60)).unwrap().unwrap(), b"a longer second");
        let short = get(Wanted::Bytes(10..16)).unwrap_err();
        assert!(short.reason.contains("15 bytes") && !short.passing, "{short}");
        // Below a file there is nothing, and a folder is no object.
        assert_eq!(store.get("0/c/1/2", Wanted::Whole), Ok(None));
        assert!(store.get("0/c", Wanted::Whole).is_err());
        assert!(store.put("0/c/1/2", &[]).is_err());
        assert_eq!(fs::read_dir(folder.path().join("store/0/c")).unwrap().count(), 1, "a part was left behind");
    }
}
