//! Inputs that are several files: a line `#file PATH`, a comment in all our languages, begins the next.

use raxel_diagnostics::MemoryFiles;

/// The line that begins a file.
pub(crate) const MARK: &str = "#file ";

/// Writes the files of an input into a project. The text before the first mark is the file `first`.
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

/// The files of an input whose files may hold any bytes: each is the length of its name (u8), the name, the length of its content (u32,
/// little-endian), the content. A part that is cut off is left out.
pub(crate) fn parts(mut input: &[u8]) -> impl Iterator<Item = (String, Vec<u8>)> {
    std::iter::from_fn(move || {
        let (length, rest) = input.split_first()?;
        let (name, rest) = rest.split_at_checked(usize::from(*length))?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let content = rest.get(..u32::from_le_bytes(*length) as usize)?;
        input = &rest[content.len()..];
        Some((String::from_utf8_lossy(name).into_owned(), content.to_vec()))
    })
}

/// The input with these files.
#[expect(clippy::cast_possible_truncation, reason = "names and contents of a project are short")]
pub(crate) fn whole(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut input = Vec::new();
    for (name, content) in files {
        let name = &name.as_bytes()[..name.len().min(255)];
        input.push(name.len() as u8);
        input.extend(name);
        input.extend((content.len() as u32).to_le_bytes());
        input.extend(content);
    }
    input
}
