//! Inputs that are several files: a line `#file PATH`, a comment in all our languages, begins the next.

use raxel_diagnostics::MemoryFiles;

/// What begins a file.
pub(crate) const MARK: &str = "#file ";

/// Writes the files of an input into a project. What is before the first mark is the file `first`.
pub(crate) fn add(files: &MemoryFiles, first: &str, input: &[u8]) {
    let mut path = first.to_owned();
    let mut content: Vec<u8> = Vec::new();
    for line in input.split_inclusive(|byte| *byte == b'\n') {
        let mark = line.strip_prefix(MARK.as_bytes()).and_then(|rest| std::str::from_utf8(rest).ok());
        if let Some(next) = mark {
            files.insert(std::mem::replace(&mut path, next.trim().to_owned()), std::mem::take(&mut content));
        } else {
            content.extend(line);
        }
    }
    files.insert(path, content);
}
