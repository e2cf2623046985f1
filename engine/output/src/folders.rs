//! Folders that are made for an output, and taken away again if nothing comes to lie in them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::leftovers::{Listed, on_stop};
use crate::error::{OutputError, Result};

/// Folders that were made. On drop, raxel removes the empty ones.
#[derive(Debug)]
pub struct Folders {
    /// The deepest first.
    made: Arc<[PathBuf]>,
    _listed: Listed,
}

impl Folders {
    /// Makes a folder and those that it lies in, as far as they do not exist.
    pub fn make(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().filter(|f| !f.as_os_str().is_empty()).take_while(|f| !f.exists());
        let made: Arc<[PathBuf]> = missing.map(Path::to_owned).collect();
        let (listed, folders) = (made.clone(), made.clone());
        let folders = Self { made: folders, _listed: on_stop(move || remove_empty(&listed)) };
        std::fs::create_dir_all(folder)
            .map_err(|error| OutputError::new(format!("the folder `{}` cannot be made: {error}", folder.display())))?;
        Ok(folders)
    }

    /// They stay, empty or not.
    pub fn keep(mut self) {
        self.made = Arc::default();
    }
}

/// A folder for temporary files. It is removed with all that is in it.
#[derive(Debug)]
pub struct Scratch {
    folder: tempfile::TempDir,
    _listed: Listed,
}

impl Scratch {
    /// An empty folder among the system's temporary files.
    pub fn new() -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("raxel-").tempdir();
        let folder = folder.map_err(|error| OutputError::new(format!("no temporary folder can be made: {error}")))?;
        let leftover = folder.path().to_owned();
        Ok(Self { folder, _listed: on_stop(move || remove_in_use(&leftover)) })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        remove_empty(&self.made);
    }
}

/// Removes a folder that other threads may be writing into. They do not know its new name, so nothing comes into it while it is emptied.
fn remove_in_use(folder: &Path) {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push("-removed");
    let renamed = folder.with_file_name(name);
    // A thread that has found the folder already may put another file into it. A thread that makes folders with their parents may make it again.
    for _ in 0..8 {
        let _ = std::fs::rename(folder, &renamed);
        let _ = std::fs::remove_dir_all(&renamed);
        if !folder.exists() && !renamed.exists() {
            break;
        }
    }
}

/// A folder with contents cannot and must not be removed.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        let _ = std::fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_folders_that_were_made_and_stay_empty_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let (old, new) = (root.path().join("old"), root.path().join("old/a/b"));
        std::fs::create_dir(&old).unwrap();
        drop(Folders::make(&new).unwrap());
        assert!(old.is_dir() && !root.path().join("old/a").exists());
        let folders = Folders::make(&new).unwrap();
        std::fs::write(root.path().join("old/a/file"), "").unwrap();
        drop(folders);
        assert!(root.path().join("old/a").is_dir() && !new.exists());
    }

    #[test]
    fn a_folder_is_removed_while_files_are_written_into_it() {
        let root = tempfile::tempdir().unwrap();
        for round in 0..20 {
            let folder = root.path().join(format!("raxel-{round}"));
            std::fs::create_dir(&folder).unwrap();
            let path = folder.clone();
            let writer = std::thread::spawn(move || {
                let mut written = 0;
                while std::fs::write(path.join(format!("{written}")), "").is_ok() {
                    written += 1;
                }
                written
            });
            while std::fs::read_dir(&folder).unwrap().count() < 20 {
                std::thread::yield_now();
            }
            remove_in_use(&folder);
            assert!(writer.join().unwrap() >= 20);
            assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
        }
    }
}
