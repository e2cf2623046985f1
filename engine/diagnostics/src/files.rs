//! Access to project files. Compilers never touch the disk themselves: they are given a [`Files`].

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use crate::{Diagnostic, SourceMap, Span, codes};

/// Reads project files for the compilers. Paths are relative to the project root with `/` separators and already normalised
/// (no `.` or `..` components); the implementation must refuse whatever would leave the root (symbolic links included).
pub trait Files: Send + Sync {
    /// The bytes of a file.
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError>;

    /// The folder of the project, where it is one on disk: what a project names outside of itself is found from there.
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
    /// Anything else the system says.
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

/// Folders of a project that hold what a command line names.
const FOLDERS: [&str; 3] = ["graphs", "worlds", "shaders"];

/// The diagnostic for a file that does not exist. Its help names a file of the same name in another folder below the first folder of the
/// path, where the project has one: files move, and whoever names them finds them again. A bare name is looked for in graphs, worlds and shaders.
pub fn not_found(files: &dyn Files, path: &str, named_at: Option<(Span, &str)>) -> Diagnostic {
    let diagnostic = FileError::NotFound.diagnostic(path, named_at);
    let name = path.rsplit('/').next().unwrap_or(path);
    let folders: &[&str] = match path.split_once('/') {
        Some((folder, _)) => &[folder],
        None => &FOLDERS,
    };
    match files.root().and_then(|root| folders.iter().find_map(|folder| namesake(root, folder, name))) {
        Some(there) => diagnostic.help(format!("did you mean `{there}`?")),
        None => diagnostic,
    }
}

/// Folders that are looked into for a file of a name: no project has as many of graphs or shaders.
const MOST_FOLDERS: usize = 256;

/// Path of the first file of that name in a folder of the project or below it: folders that are nearer to the top first, then by name.
/// Links are not followed.
fn namesake(root: &Path, folder: &str, name: &str) -> Option<String> {
    let mut folders = VecDeque::from([folder.to_owned()]);
    for _ in 0..MOST_FOLDERS {
        let folder = folders.pop_front()?;
        if root.join(&folder).join(name).is_file() {
            return Some(format!("{folder}/{name}"));
        }
        let entries = std::fs::read_dir(root.join(&folder)).into_iter().flatten().flatten();
        let below = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        let mut below: Vec<String> = below.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        below.sort();
        folders.extend(below.into_iter().map(|name| format!("{folder}/{name}")));
    }
    None
}

/// Largest text file that is read, in bytes: 4 MiB. Texts are held whole, and what is made of them is many times as large.
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
        Err(FileError::NotFound) => return Err(Box::new(not_found(files, path, named_at))),
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
