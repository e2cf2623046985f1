//! The texts that an editor has open, saved or not, in front of the files on disk.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lsp_types::{Position, Range, Url};
use raxel_diagnostics::{DiskFiles, FileError, Files};
use raxel_runtime::project::Project;
use raxel_shader::library;

use super::indexed_text::IndexedText;

/// A text in an editor.
#[derive(Clone)]
pub(super) struct Document {
    pub project: Project,
    /// Path in the project.
    pub path: String,
    pub text: Arc<IndexedText>,
}

impl Document {
    /// Whether it is TOML; all else is a shader.
    pub(crate) fn is_toml(&self) -> bool {
        Path::new(&self.path).extension().is_some_and(|extension| extension == "toml")
    }
}

/// Every text that is open and lies in a project, by its place on disk.
#[derive(Clone, Default)]
pub(super) struct Documents {
    open: BTreeMap<PathBuf, Document>,
    /// Texts that were read from disk, and those of the shader library by their names in it.
    read: Arc<Mutex<HashMap<PathBuf, Arc<IndexedText>>>>,
}

impl Documents {
    /// A text was opened or changed. A text outside of all projects is left alone.
    pub(crate) fn set(&mut self, address: &Url, text: String) {
        let Ok(file) = address.to_file_path() else { return };
        let text = Arc::new(IndexedText::new(text));
        if let Some(known) = self.open.get_mut(&file) {
            known.text = text;
            return;
        }
        let Ok(project) = Project::around(&file) else { return };
        if let Ok(path) = project.path_of(&file) {
            self.open.insert(file, Document { project, path, text });
        }
    }

    pub(crate) fn remove(&mut self, address: &Url) {
        if let Ok(file) = address.to_file_path() {
            self.open.remove(&file);
        }
        if self.open.is_empty() {
            self.read().clear();
        }
    }

    /// A text and the byte that a position means.
    pub(crate) fn at(&self, address: &Url, position: Position) -> Option<(&Document, usize)> {
        let document = self.open.get(&address.to_file_path().ok()?)?;
        Some((document, offset(&document.text, position)))
    }

    /// A text by the address of its file.
    pub(crate) fn get(&self, address: &Url) -> Option<&Document> {
        self.open.get(&address.to_file_path().ok()?)
    }

    /// The text of a file of the project that a document is in: as it is open, or else as it is saved.
    pub(crate) fn text(&self, document: &Document, path: &str) -> Option<Arc<IndexedText>> {
        let file = document.project.on_disk(path);
        match self.open.get(&file) {
            Some(open) => Some(open.text.clone()),
            None => std::fs::read_to_string(&file).ok().map(|text| self.indexed(file, &text)),
        }
    }

    /// The text of a file of the shader library.
    pub(crate) fn library_text(&self, name: &str) -> Option<Arc<IndexedText>> {
        library::text(name).map(|text| self.indexed(PathBuf::from(name), text))
    }

    /// A text that was just read: what is known of the same text is kept.
    fn indexed(&self, file: PathBuf, text: &str) -> Arc<IndexedText> {
        let mut read = self.read();
        if let Some(known) = read.get(&file).filter(|known| known[..] == *text) {
            return known.clone();
        }
        let text = Arc::new(IndexedText::new(text.to_owned()));
        read.insert(file, text.clone());
        text
    }

    fn read(&self) -> MutexGuard<'_, HashMap<PathBuf, Arc<IndexedText>>> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a file is open here and there with the same text, or in neither.
    pub(crate) fn is_current(&self, now: &Self, address: &Url) -> bool {
        match (self.get(address), now.get(address)) {
            (Some(then), Some(now)) => Arc::ptr_eq(&then.text, &now.text),
            (then, now) => then.is_none() && now.is_none(),
        }
    }

    /// Whether a document is open here with the same text.
    pub(crate) fn has(&self, document: &Document) -> bool {
        let known = self.open.get(&document.project.on_disk(&document.path));
        known.is_some_and(|known| Arc::ptr_eq(&known.text, &document.text))
    }

    /// Whether every file that is open there is open here.
    pub(crate) fn has_all_of(&self, others: &Self) -> bool {
        others.open.keys().all(|file| self.open.contains_key(file))
    }

    /// The projects that texts are open of, each with those texts in front of its files.
    pub(crate) fn projects(&self) -> Vec<(Project, Vec<&Document>)> {
        let mut projects: Vec<(Project, Vec<&Document>)> = Vec::new();
        for document in self.open.values() {
            match projects.iter_mut().find(|(project, _)| *project == document.project) {
                Some((_, documents)) => documents.push(document),
                None => projects.push((document.project.clone(), vec![document])),
            }
        }
        projects
    }
}

/// The contents of each file that was read.
type Texts = BTreeMap<String, Result<Arc<[u8]>, FileError>>;

/// A project's files with some texts in their place. Each file is read once between two calls of [`Overlay::update`].
pub(super) struct Overlay {
    disk: DiskFiles,
    texts: Mutex<Texts>,
}

impl Overlay {
    pub(crate) fn new(project: &Project) -> std::io::Result<Self> {
        Ok(Self { disk: DiskFiles::new(project.root())?, texts: Mutex::default() })
    }

    /// Takes these texts as they are now, and forgets what was read from disk.
    pub(crate) fn update(&self, documents: &[&Document]) {
        let texts = documents.iter().map(|document| (document.path.clone(), Ok(Arc::from(document.text.as_bytes()))));
        *self.lock() = texts.collect();
    }

    fn lock(&self) -> MutexGuard<'_, Texts> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.texts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Files for Overlay {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        if let Some(known) = self.lock().get(path) {
            return known.clone();
        }
        // Threads read side by side. The first content of a file counts for all of them.
        let content = self.disk.read(path);
        self.lock().entry(path.to_owned()).or_insert(content).clone()
    }

    fn root(&self) -> Option<&Path> {
        self.disk.root()
    }
}

/// The byte at a position, which counts lines and UTF-16 units. A position behind the end of a line is that end.
#[expect(clippy::cast_possible_truncation, reason = "the protocol counts lines and columns in 32 bits")]
pub(super) fn offset(text: &str, position: Position) -> usize {
    let mut start = 0;
    for _ in 0..position.line {
        match text[start..].find('\n') {
            Some(end) => start += end + 1,
            None => return text.len(),
        }
    }
    let mut units = 0;
    let line = text[start..].split('\n').next().unwrap_or_default();
    for (byte, letter) in line.char_indices() {
        if units >= position.character {
            return start + byte;
        }
        units += letter.len_utf16() as u32;
    }
    start + line.len()
}

/// The position of a byte.
#[expect(clippy::cast_possible_truncation, reason = "the protocol counts lines and columns in 32 bits")]
pub(super) fn position(text: &str, byte: usize) -> Position {
    let before = &text[..floor(text, byte)];
    let line = before.matches('\n').count() as u32;
    let in_line = before.rsplit('\n').next().unwrap_or_default();
    Position { line, character: in_line.chars().map(|letter| letter.len_utf16() as u32).sum() }
}

/// The positions of a range of bytes.
pub(super) fn range(text: &str, bytes: &std::ops::Range<usize>) -> Range {
    Range { start: position(text, bytes.start), end: position(text, bytes.end) }
}

/// The start of the letter at a byte.
fn floor(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_utf16_units() {
        let text = "a = 1\n# 𝄞é x\n\nlast";
        for (byte, line, character) in [(0, 0, 0), (5, 0, 5), (6, 1, 0), (12, 1, 4), (14, 1, 5), (17, 2, 0), (22, 3, 4)]
        {
            assert_eq!(position(text, byte), Position { line, character }, "{byte}");
            assert_eq!(offset(text, Position { line, character }), byte);
        }
        // Behind the end, and within a letter.
        assert_eq!(offset(text, Position { line: 0, character: 99 }), 5);
        assert_eq!(offset(text, Position { line: 99, character: 0 }), text.len());
        assert_eq!(position(text, 10), Position { line: 1, character: 2 });
    }
}
