//! The two places that project files come from: a folder on disk, and a table in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

use crate::files::join;
use crate::{FileError, Files};

/// Largest file that is read unless a caller allows more: 64 MiB.
pub const DEFAULT_LIMIT: u64 = 64 << 20;
/// Largest .vox file: as many voxels of four bytes as are imported, 2²⁶, and 1 MiB for all else in it.
const VOX_LIMIT: u64 = (4 << 26) + (1 << 20);

/// A project folder. Reads nothing outside it, wherever symbolic links lead.
#[derive(Clone, Debug)]
pub struct DiskFiles {
    root: PathBuf,
    limit: Option<u64>,
}

impl DiskFiles {
    /// The project at `root`, which must exist.
    pub fn new(root: &Path) -> io::Result<Self> {
        Ok(Self { root: root.canonicalize()?, limit: None })
    }

    /// The same project with another cap on the size of a file, in bytes.
    #[must_use]
    pub fn with_limit(self, limit: u64) -> Self {
        Self { limit: Some(limit), ..self }
    }

    fn limit_of(&self, path: &str) -> u64 {
        let vox = Path::new(path).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vox"));
        self.limit.unwrap_or(if vox { VOX_LIMIT } else { DEFAULT_LIMIT })
    }
}

impl Files for DiskFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        if join("", path).as_deref() != Some(path) {
            return Err(FileError::OutsideRoot);
        }
        let real = self.root.join(path).canonicalize().map_err(|error| from_io(&error))?;
        if !real.starts_with(&self.root) {
            return Err(FileError::OutsideRoot);
        }
        // Asked before opening: opening a pipe would wait for its other end.
        if !real.metadata().map_err(|error| from_io(&error))?.is_file() {
            return Err(FileError::Io("it is not a file".to_owned()));
        }
        let limit = self.limit_of(path);
        let file = File::open(&real).map_err(|error| from_io(&error))?;
        let size = file.metadata().map_err(|error| from_io(&error))?.len();
        if size > limit {
            return Err(FileError::TooLarge { size, limit });
        }
        let mut bytes = Vec::with_capacity(size as usize);
        // The file may grow while it is read.
        file.take(limit + 1).read_to_end(&mut bytes).map_err(|error| from_io(&error))?;
        if bytes.len() as u64 > limit {
            return Err(FileError::TooLarge { size: bytes.len() as u64, limit });
        }
        Ok(bytes.into())
    }

    fn root(&self) -> Option<&Path> {
        Some(&self.root)
    }
}

fn from_io(error: &io::Error) -> FileError {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FileError::NotFound,
        _ => FileError::Io(error.to_string()),
    }
}

/// Files in memory: for tests, and for tools that hold unsaved text. A clone sees the same files.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    files: Arc<RwLock<BTreeMap<String, Arc<[u8]>>>>,
}

impl MemoryFiles {
    /// With these files: (path, contents).
    pub fn new<P: Into<String>, B: AsRef<[u8]>>(files: impl IntoIterator<Item = (P, B)>) -> Self {
        let memory = Self::default();
        for (path, bytes) in files {
            memory.insert(path, bytes);
        }
        memory
    }

    /// Writes a file.
    pub fn insert(&self, path: impl Into<String>, bytes: impl AsRef<[u8]>) {
        self.write().insert(path.into(), bytes.as_ref().into());
    }

    /// Deletes a file.
    pub fn remove(&self, path: &str) {
        self.write().remove(path);
    }

    fn write(&self) -> std::sync::RwLockWriteGuard<'_, BTreeMap<String, Arc<[u8]>>> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.files.write().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Files for MemoryFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        let files = self.files.read().unwrap_or_else(std::sync::PoisonError::into_inner);
        files.get(path).cloned().ok_or(FileError::NotFound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disk_reads_inside_the_root_only() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret"), "s").unwrap();
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("shaders")).unwrap();
        std::fs::write(root.path().join("shaders/a.comp"), "a").unwrap();
        std::fs::write(root.path().join("big"), vec![0; 65]).unwrap();
        let files = DiskFiles::new(root.path()).unwrap().with_limit(64);
        assert_eq!(&*files.read("shaders/a.comp").unwrap(), b"a");
        assert_eq!(files.read("shaders/b.comp"), Err(FileError::NotFound));
        assert_eq!(files.read("shaders/a.comp/x"), Err(FileError::NotFound));
        assert_eq!(files.read("../secret"), Err(FileError::OutsideRoot));
        assert_eq!(files.read("/etc/passwd"), Err(FileError::OutsideRoot));
        assert_eq!(files.read("big"), Err(FileError::TooLarge { size: 65, limit: 64 }));
        assert!(matches!(files.read("shaders"), Err(FileError::Io(_))));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(outside.path().join("secret"), root.path().join("link")).unwrap();
            std::os::unix::fs::symlink(outside.path(), root.path().join("folder")).unwrap();
            std::os::unix::fs::symlink(root.path().join("shaders/a.comp"), root.path().join("inner")).unwrap();
            assert_eq!(files.read("link"), Err(FileError::OutsideRoot));
            assert_eq!(files.read("folder/secret"), Err(FileError::OutsideRoot));
            assert_eq!(&*files.read("inner").unwrap(), b"a");
        }
    }
}
