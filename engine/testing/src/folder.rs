//! Folders: those of the repository, and temporary ones of tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The root of the repository.
pub fn repository() -> &'static Path {
    static ROOT: LazyLock<PathBuf> = LazyLock::new(|| {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("this crate is in the repository")
    });
    &ROOT
}

/// A folder that is gone when the test ends.
pub struct Folder {
    folder: tempfile::TempDir,
}

impl Default for Folder {
    fn default() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }
}

impl Folder {
    /// The folder itself.
    pub fn root(&self) -> &Path {
        self.folder.path()
    }

    /// A file in it.
    pub fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    /// Writes a file, and makes the folders that it is in.
    pub fn write(&self, path: &str, bytes: impl AsRef<[u8]>) -> &Self {
        let path = self.path(path);
        fs::create_dir_all(path.parent().expect("a file is in a folder")).unwrap();
        fs::write(path, bytes).unwrap();
        self
    }

    /// Replaces text in a file; the text must be there.
    #[track_caller]
    pub fn edit(&self, path: &str, from: &str, to: &str) -> &Self {
        let old = fs::read_to_string(self.path(path)).unwrap();
        assert!(old.contains(from), "{path} has no {from:?}");
        self.write(path, old.replacen(from, to, 1))
    }

    /// Adds a file of the repository, under the same path.
    pub fn copy_file(&self, path: &str) -> &Self {
        self.write(path, fs::read(repository().join(path)).unwrap())
    }

    /// Adds a folder of the repository, under the same path.
    pub fn copy_folder(&self, folder: &str) -> &Self {
        copy(&repository().join(folder), &self.path(folder));
        self
    }
}

/// Every file below a folder by its path from there, in order, with its bytes.
pub fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("it is below").display().to_string();
                found.push((name, fs::read(path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// Copies a folder with all that is below it.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_holds_what_is_written() {
        let folder = Folder::default();
        folder.write("b/c.txt", "one two two").write("a", [7]).edit("b/c.txt", "two", "three");
        let found = files(folder.root());
        assert_eq!(found, [("a".to_owned(), vec![7]), ("b/c.txt".to_owned(), b"one three two".to_vec())]);
        let other = Folder::default();
        copy(folder.root(), &other.path("d"));
        assert_eq!(files(&other.path("d")), found);
        let root = folder.root().to_owned();
        drop(folder);
        assert!(!root.exists());
    }

    #[test]
    fn the_repository_is_found() {
        assert!(repository().join("engine/testing/src/folder.rs").exists());
    }
}
