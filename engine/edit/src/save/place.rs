//! Whether a folder can be that of a save.

use std::io::ErrorKind;
use std::path::Path;

use super::SaveError;
use super::content::{CHUNKS, journal_number};
use super::tail::TAIL;

/// Refuses a folder that is a file, lies in one, or holds other things and no save. One that does not exist can be made.
pub fn check_folder(folder: &Path) -> Result<(), SaveError> {
    let refused = |why: String| Err(SaveError::Place { why });
    for place in folder.ancestors() {
        match std::fs::metadata(place) {
            Ok(about) if about.is_dir() => break,
            Ok(_) => return refused(format!("`{}` is a file", place.display())),
            // A place in a file is no folder, and the file is further up.
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
            // Opening the save reports why.
            Err(_) => return Ok(()),
        }
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let mut other = None;
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if is_ours(&name) {
            return Ok(());
        }
        if !name.starts_with('.') && other.as_deref().is_none_or(|other| *name < *other) {
            other = Some(name.into_owned());
        }
    }
    other.map_or(Ok(()), |other| refused(format!("`{}` holds other things and no save: `{other}`", folder.display())))
}

/// Whether a save has a file of this name.
fn is_ours(name: &str) -> bool {
    [CHUNKS, TAIL, "chunks.new", "tail.new", "lock"].contains(&name) || journal_number(Path::new(name)).is_some()
}
