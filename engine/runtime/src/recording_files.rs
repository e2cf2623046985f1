//! Remembers which files a build asked for, and their contents: exactly the files whose change makes another build worthwhile.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use raxel_diagnostics::{FileError, Files};

/// Contents of a file, as far as they matter here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
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
    pub(crate) fn of(bytes: &[u8]) -> Self {
        if bytes.is_empty() { Content::Empty } else { Content::Bytes(blake3::hash(bytes)) }
    }

    /// Takes note of what another read gave.
    fn meets(&mut self, other: Content) {
        if *self != other {
            *self = Content::Mixed;
        }
    }
}

/// Adds the contents of a file. A file whose contents differ from an earlier read is mixed.
pub(crate) fn note(found: &mut BTreeMap<String, Content>, path: String, content: Content) {
    found.entry(path).or_insert(content).meets(content);
}

/// Largest file whose bytes stay in memory while a build goes on, in bytes.
const KEPT: usize = 1 << 20;

/// A file that a build asked for.
struct Seen {
    content: Content,
    /// The result of the first read, unless the file is large.
    kept: Option<Result<Arc<[u8]>, FileError>>,
}

/// Reads through, and keeps account. A build reads a small file once: all its shaders see the same contents.
pub(crate) struct RecordingFiles {
    files: Arc<dyn Files>,
    /// Of the build that goes on.
    seen: Mutex<Option<BTreeMap<String, Seen>>>,
}

impl RecordingFiles {
    /// Reads `files`.
    pub(crate) fn new(files: Arc<dyn Files>) -> Self {
        Self { files, seen: Mutex::default() }
    }

    /// A build begins.
    pub(crate) fn begin(&self) {
        *self.seen() = Some(BTreeMap::new());
    }

    /// The build ends: everything that it asked for, files that are missing included.
    pub(crate) fn end(&self) -> BTreeMap<String, Content> {
        let seen = self.seen().take().unwrap_or_default();
        seen.into_iter().map(|(path, seen)| (path, seen.content)).collect()
    }

    fn seen(&self) -> MutexGuard<'_, Option<BTreeMap<String, Seen>>> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Files for RecordingFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        if let Some(kept) = self.seen().as_ref().and_then(|seen| seen.get(path)?.kept.clone()) {
            return kept;
        }
        let result = self.files.read(path);
        let content = content(&result);
        if let Some(seen) = self.seen().as_mut() {
            let is_small = result.as_ref().map_or(true, |bytes| bytes.len() <= KEPT);
            let new = || Seen { content, kept: is_small.then(|| result.clone()) };
            seen.entry(path.to_owned()).or_insert_with(new).content.meets(content);
        }
        result
    }

    fn root(&self) -> Option<&Path> {
        self.files.root()
    }
}

/// The result of a read, as far as a later change of it matters.
pub(crate) fn content(result: &Result<Arc<[u8]>, FileError>) -> Content {
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
        recorder.begin();
        for path in ["a", "b", "c"] {
            let _ = recorder.read(path);
        }
        let seen: Vec<_> = recorder.end().into_iter().collect();
        assert_eq!(
            seen,
            [("a".into(), Content::of(b"1")), ("b".into(), Content::Empty), ("c".into(), Content::Missing)]
        );
        assert!(recorder.end().is_empty());
    }

    #[test]
    fn a_build_sees_one_state_of_a_small_file() {
        let files = MemoryFiles::new([("a", "1")]);
        let recorder = RecordingFiles::new(Arc::new(files.clone()));
        recorder.begin();
        assert!(recorder.read("b").is_err());
        for text in ["2", "3"] {
            assert_eq!(&*recorder.read("a").unwrap(), b"1");
            files.insert("a", text);
            files.insert("b", text);
        }
        assert!(recorder.read("b").is_err());
        let seen = recorder.end();
        assert_eq!((seen["a"], seen["b"]), (Content::of(b"1"), Content::Missing));
        // The next build starts over, and nothing is kept between them.
        assert_eq!(&*recorder.read("a").unwrap(), b"3");
        files.insert("a", "4");
        recorder.begin();
        assert_eq!(&*recorder.read("a").unwrap(), b"4");
        assert_eq!(recorder.end().len(), 1);
    }

    #[test]
    fn a_large_file_that_is_saved_while_a_build_reads_it_is_never_taken_for_known() {
        let [old, new] = [b'1', b'2'].map(|byte| vec![byte; KEPT + 1]);
        let files = MemoryFiles::new([("a", &old), ("b", &old)]);
        let recorder = RecordingFiles::new(Arc::new(files.clone()));
        recorder.begin();
        for _ in 0..2 {
            recorder.read("b").unwrap();
        }
        recorder.read("a").unwrap();
        files.insert("a", &new);
        assert_eq!(*recorder.read("a").unwrap(), *new);
        let seen = recorder.end();
        assert_eq!((seen["a"], seen["b"]), (Content::Mixed, Content::of(&old)));
        // The next build starts over.
        recorder.begin();
        recorder.read("a").unwrap();
        assert_eq!(recorder.end()["a"], Content::of(&new));
    }
}
