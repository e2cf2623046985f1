//! Access to project files. Compilers never touch the disk themselves: they are given a [`Files`].

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use crate::{Diagnostic, SourceMap, Span, codes, names};

/// Reads project files for the compilers. Paths are relative to the project root with `/` separators and already normalised (no `.` or `..`
/// components); the implementation must refuse every path that would leave the root (symbolic links included).
pub trait Files: Send + Sync {
    /// The bytes of a file.
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError>;

    /// The folder of the project, where it is one on disk: paths out of the project start there.
    fn root(&self) -> Option<&Path> {
        None
    }
}

/// Why a file could not be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// There is none.
    #[error("no such file")]
    NotFound,
    /// Its real path is outside the project root.
    #[error("it leads outside the project root")]
    OutsideRoot,
    /// It is larger than the cap (both in bytes).
    #[error("it has {size} bytes, more than the {limit} that raxel reads")]
    TooLarge {
        /// Bytes of the file.
        size: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// Any other error of the system.
    #[error("{0}")]
    Io(String),
}

impl FileError {
    /// The diagnostic for a file that could not be had. `named_at` is the place that names it, if a file does.
    pub fn diagnostic(&self, path: &str, named_at: Option<(Span, &str)>) -> Diagnostic {
        let (code, message) = match self {
            FileError::NotFound => (codes::files::NOT_FOUND, format!("`{path}` does not exist")),
            FileError::OutsideRoot => (codes::files::OUTSIDE_ROOT, format!("`{path}` leads outside the project root")),
            FileError::TooLarge { .. } => (codes::files::TOO_LARGE, format!("`{path}` is too large: {self}")),
            FileError::Io(reason) => (codes::files::UNREADABLE, format!("`{path}` cannot be read: {reason}")),
        };
        let diagnostic = Diagnostic::error(code, message);
        match named_at {
            Some((span, text)) => diagnostic.label(span, text),
            None => diagnostic,
        }
    }
}

/// Folders of a project that hold the files of a command line.
const FOLDERS: [&str; 3] = ["graphs", "worlds", "shaders"];

/// The diagnostic for a file that does not exist. Its help names the file that was probably meant, if the project has one below the first
/// folder of the path: a file of the same name, one whose ending was left out, or one with nearly the same name. A bare name is looked for in
/// graphs, worlds and shaders. The help is relative to `from`, the folder that the wrong name was relative to.
pub fn not_found(files: &dyn Files, path: &str, named_at: Option<(Span, &str)>, from: &str) -> Diagnostic {
    let diagnostic = FileError::NotFound.diagnostic(path, named_at);
    let name = path.rsplit('/').next().unwrap_or(path);
    let folders: &[&str] = match path.split_once('/') {
        Some((folder, _)) => &[folder],
        None => &FOLDERS,
    };
    let known: Vec<String> =
        files.root().into_iter().flat_map(|root| folders.iter().flat_map(|folder| files_below(root, folder))).collect();
    match meant(name, &known) {
        Some(there) => diagnostic.help(format!("did you mean `{}`?", seen_from(from, there))),
        None => diagnostic,
    }
}

/// The file that a wrong name means, among those of a project: nearer ones come first.
fn meant<'k>(name: &str, known: &'k [String]) -> Option<&'k str> {
    let name_of = |path: &'k str| path.rsplit('/').next().unwrap_or(path);
    let paths = || known.iter().map(String::as_str);
    if let Some(namesake) = paths().find(|path| name_of(path) == name) {
        return Some(namesake);
    }
    let Some((stem, ending)) = name.split_once('.') else {
        // `valley` is rather `valley.toml` than `valley.demo.toml`.
        let complete = paths().filter(|path| name_of(path).split_once('.').is_some_and(|(stem, _)| stem == name));
        return complete.min_by_key(|path| name_of(path).len());
    };
    // Names of one or two letters are all alike.
    if stem.chars().count() < 3 {
        return None;
    }
    let stem_of = |path: &'k str| name_of(path).split_once('.').filter(|(_, its)| *its == ending).map(|(stem, _)| stem);
    let close = names::closest(stem, paths().filter_map(stem_of))?;
    paths().find(|path| stem_of(path) == Some(close))
}

/// A path of the project as it is written in a file that counts from a folder.
fn seen_from(folder: &str, path: &str) -> String {
    let (mut folders, mut rest) = (folder.split('/').filter(|part| !part.is_empty()).peekable(), path);
    while let (Some(part), Some((first, behind))) = (folders.peek(), rest.split_once('/'))
        && *part == first
    {
        folders.next();
        rest = behind;
    }
    format!("{}{rest}", "../".repeat(folders.count()))
}

/// Folders that are looked into for a file of a name: no project has as many of graphs or shaders.
const MOST_FOLDERS: usize = 256;

/// Paths of the files in a folder of the project and below it: folders that are nearer to the top first, then by name. Links to folders are
/// not followed.
fn files_below(root: &Path, folder: &str) -> Vec<String> {
    let mut folders = VecDeque::from([folder.to_owned()]);
    let mut found = Vec::new();
    for _ in 0..MOST_FOLDERS {
        let Some(folder) = folders.pop_front() else { break };
        let entries = std::fs::read_dir(root.join(&folder)).into_iter().flatten().flatten();
        let is_folder = |entry: &std::fs::DirEntry| entry.file_type().is_ok_and(|kind| kind.is_dir());
        let (below, here): (Vec<_>, Vec<_>) = entries.partition(is_folder);
        let paths = |entries: Vec<std::fs::DirEntry>| {
            let names = entries.into_iter().filter_map(|entry| entry.file_name().into_string().ok());
            let mut paths: Vec<String> = names.map(|name| format!("{folder}/{name}")).collect();
            paths.sort();
            paths
        };
        found.extend(paths(here).into_iter().filter(|path| root.join(path).is_file()));
        folders.extend(paths(below));
    }
    found
}

/// Largest text file that is read, in bytes: 4 MiB. Texts are held whole, and their parsed form is many times as large.
pub const MAX_TEXT: usize = 4 << 20;

/// Reads a text file and remembers its text in `texts`. A file larger than [`MAX_TEXT`] is an error, and a byte that is not UTF-8 is one that
/// points at it.
pub fn read_text(
    files: &dyn Files,
    path: &str,
    named_at: Option<(Span, &str)>,
    texts: &mut SourceMap,
) -> Result<Arc<str>, Box<Diagnostic>> {
    let bytes = match files.read(path) {
        Ok(bytes) if bytes.len() <= MAX_TEXT => bytes,
        Ok(bytes) => {
            let error = FileError::TooLarge { size: bytes.len() as u64, limit: MAX_TEXT as u64 };
            return Err(Box::new(error.diagnostic(path, named_at)));
        }
        Err(FileError::NotFound) => {
            // Names in a file are relative to its folder.
            let from = named_at.as_ref().and_then(|(span, _)| Some(span.file.rsplit_once('/')?.0.to_owned()));
            return Err(Box::new(not_found(files, path, named_at, &from.unwrap_or_default())));
        }
        Err(error) => return Err(Box::new(error.diagnostic(path, named_at))),
    };
    match std::str::from_utf8(&bytes) {
        Ok(text) => {
            // Editors on Windows may save a byte-order mark; it is no part of the text.
            let text: Arc<str> = Arc::from(text.strip_prefix('\u{feff}').unwrap_or(text));
            texts.insert(path, text.clone());
            Ok(text)
        }
        Err(error) => {
            let at = error.valid_up_to();
            texts.insert(path, String::from_utf8_lossy(&bytes).into_owned());
            Err(Box::new(
                Diagnostic::error(
                    codes::files::NOT_UTF8,
                    format!("`{path}` is not UTF-8: byte {:#04x} at offset {at}", bytes[at]),
                )
                .label(Span::new(path, at..at), "the first byte that is not UTF-8"),
            ))
        }
    }
}

/// Joins a path written in a file to the folder it is relative to, and normalises it. `None` when it is absolute (also in the
/// manner of Windows), empty, or climbs out of the root.
pub fn join(folder: &str, path: &str) -> Option<String> {
    if path.is_empty()
        || path.starts_with(['/', '\\'])
        || path.contains(['\\', '\0'])
        || path.chars().nth(1) == Some(':')
    {
        return None;
    }
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            name => parts.push(name),
        }
    }
    if parts.is_empty() { None } else { Some(parts.join("/")) }
}

#[cfg(test)]
mod tests {
    use super::{MAX_TEXT, join, read_text};
    use crate::{MemoryFiles, SourceMap};

    #[test]
    fn texts_have_a_limit() {
        let files = MemoryFiles::new([("least", vec![b'a'; MAX_TEXT]), ("more", vec![b'a'; MAX_TEXT + 1])]);
        assert!(read_text(&files, "least", None, &mut SourceMap::default()).is_ok());
        let refused = read_text(&files, "more", None, &mut SourceMap::default()).unwrap_err();
        assert_eq!(refused.code.as_str(), "RX0004");
        assert!(refused.message.contains("4194305 bytes, more than the 4194304"), "{}", refused.message);
    }

    #[test]
    fn joins_inside_the_root_only() {
        assert_eq!(join("shaders", "a.comp").as_deref(), Some("shaders/a.comp"));
        assert_eq!(join("shaders/include", "../a.comp").as_deref(), Some("shaders/a.comp"));
        assert_eq!(join("", "./x/./y").as_deref(), Some("x/y"));
        for path in ["../../a", "/etc/passwd", "C:/a", "\\\\server\\a", "a\\b", "", "a\0b"] {
            assert_eq!(join("shaders", path), None, "{path:?}");
        }
    }
}
