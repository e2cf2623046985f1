//! Remembers which files a build asked for, and what it found: exactly the files whose change makes another build worthwhile.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use raxel_diagnostics::{FileError, Files};

/// Contents of a file, as far as they matter here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// No file, or none that can be read.
    Missing,
    /// A file without bytes.
    Empty,
    /// BLAKE3 of the bytes.
    Bytes(blake3::Hash),
}

impl Content {
    /// Of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        if bytes.is_empty() { Content::Empty } else { Content::Bytes(blake3::hash(bytes)) }
    }
}

/// Reads through, and keeps account.
pub struct RecordingFiles {
    files: Arc<dyn Files>,
    seen: Mutex<BTreeMap<String, Content>>,
}

impl RecordingFiles {
    /// Reads `files`.
    pub fn new(files: Arc<dyn Files>) -> Self {
        Self { files, seen: Mutex::default() }
    }

    /// Everything asked for since the last call, files that are missing included.
    pub fn take(&self) -> BTreeMap<String, Content> {
        std::mem::take(&mut *self.seen.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Files for RecordingFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        let result = self.files.read(path);
        let content = content(&result);
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), content);
        result
    }
}

/// What a read found, as far as a later change of it matters.
pub fn content(result: &Result<Arc<[u8]>, FileError>) -> Content {
    match result {
        Ok(bytes) => Content::of(bytes),
        Err(_) => Content::Missing,
    }
}

#[cfg(test)]
mod tests {
    use raxel_diagnostics::MemoryFiles;

    use super::*;

    #[test]
    fn missing_files_count_too() {
        let recorder = RecordingFiles::new(Arc::new(MemoryFiles::new([("a", "1"), ("b", "")])));
        for path in ["a", "b", "c"] {
            let _ = recorder.read(path);
        }
        let seen: Vec<_> = recorder.take().into_iter().collect();
        assert_eq!(
            seen,
            [("a".into(), Content::of(b"1")), ("b".into(), Content::Empty), ("c".into(), Content::Missing)]
        );
        assert!(recorder.take().is_empty());
    }
}
