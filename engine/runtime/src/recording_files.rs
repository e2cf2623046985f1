//! Remembers which files a build asked for, and their contents: exactly the files whose change makes another build worthwhile.

use std::collections::BTreeMap;
use std::path::Path;
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
    /// Another one each time it was read: a build of it is of no state of the file, and must be made again.
    Mixed,
}

impl Content {
    /// Of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        if bytes.is_empty() { Content::Empty } else { Content::Bytes(blake3::hash(bytes)) }
    }
}

/// Adds the contents of a file. A file whose contents differ from an earlier read is mixed.
pub fn note(found: &mut BTreeMap<String, Content>, path: String, content: Content) {
    let known = found.entry(path).or_insert(content);
    if *known != content {
        *known = Content::Mixed;
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
        note(&mut self.seen.lock().unwrap_or_else(PoisonError::into_inner), path.to_owned(), content);
        result
    }

    fn root(&self) -> Option<&Path> {
        self.files.root()
    }
}

/// The result of a read, as far as a later change of it matters.
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
    #[test]
    fn a_file_that_is_saved_while_a_build_reads_it_is_never_taken_for_known() {
        let files = MemoryFiles::new([("a", "1"), ("b", "1")]);
        let recorder = RecordingFiles::new(Arc::new(files.clone()));
        for _ in 0..2 {
            recorder.read("b").unwrap();
        }
        recorder.read("a").unwrap();
        files.insert("a", "2");
        recorder.read("a").unwrap();
        let seen = recorder.take();
        assert_eq!((seen["a"], seen["b"]), (Content::Mixed, Content::of(b"1")));
        // The next build starts over.
        recorder.read("a").unwrap();
        assert_eq!(recorder.take()["a"], Content::of(b"2"));
    }
}
