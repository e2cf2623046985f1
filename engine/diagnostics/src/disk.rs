//! The two places that project files come from: a folder on disk, and a table in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

use crate::files::join;
use crate::{FileError, Files};

/// Largest file that is read: 64 MiB.
const LIMIT: u64 = 64 << 20;
/// Largest .vox file: as many voxels of four bytes as are imported, 2²⁶, and 1 MiB for all else in it.
const VOX_LIMIT: u64 = (4 << 26) + (1 << 20);

/// The most reads of a file that changes each time.
const TRIES: usize = 8;

/// A project folder. Reads nothing outside it, wherever symbolic links lead.
#[derive(Clone, Debug)]
pub struct DiskFiles {
    root: PathBuf,
}

impl DiskFiles {
    /// The project at `root`, which must exist.
    pub fn new(root: &Path) -> io::Result<Self> {
        Ok(Self { root: root.canonicalize()? })
    }
}

impl Files for DiskFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        if join("", path).as_deref() != Some(path) {
            return Err(FileError::OutsideRoot);
        }
        let real = self.root.join(path).canonicalize().map_err(|error| from_io(&error))?;
        if !real.starts_with(&self.root) {
            return Err(FileError::OutsideRoot);
        }
        // Asked before opening: opening a pipe would wait for its other end.
        if !real.metadata().map_err(|error| from_io(&error))?.is_file() {
            return Err(FileError::Io("it is not a file".to_owned()));
        }
        let bytes = settled(limit_of(path), || {
            let file = File::open(&real)?;
            Ok((file.metadata()?.len(), file))
        })?;
        Ok(bytes.into())
    }

    fn root(&self) -> Option<&Path> {
        Some(&self.root)
    }
}

/// The most bytes of the file at a path.
fn limit_of(path: &str) -> u64 {
    let vox = Path::new(path).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vox"));
    if vox { VOX_LIMIT } else { LIMIT }
}

/// Reads a file until it reads the same twice: one that is replaced or written meanwhile gives no mix of before and after.
#[expect(
    clippy::cast_possible_truncation,
    reason = "files over the limit are refused before, and the capacity is a hint"
)]
fn settled<R: Read>(limit: u64, open: impl Fn() -> io::Result<(u64, R)>) -> Result<Vec<u8>, FileError> {
    let open = || open().map_err(|error| from_io(&error));
    for _ in 0..TRIES {
        let (size, file) = open()?;
        if size > limit {
            return Err(FileError::TooLarge { size, limit });
        }
        let mut bytes = Vec::with_capacity(size as usize);
        // The file may grow while it is read.
        file.take(limit + 1).read_to_end(&mut bytes).map_err(|error| from_io(&error))?;
        if bytes.len() as u64 > limit {
            return Err(FileError::TooLarge { size: bytes.len() as u64, limit });
        }
        if holds(open()?.1, &bytes).map_err(|error| from_io(&error))? {
            return Ok(bytes);
        }
    }
    Err(FileError::Io("it changes while it is read".to_owned()))
}

/// Whether a file holds these bytes, and no more.
fn holds(mut file: impl Read, mut bytes: &[u8]) -> io::Result<bool> {
    let mut piece = vec![0; (bytes.len() + 1).min(1 << 16)];
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok(bytes.is_empty()),
            Ok(count) => match bytes.strip_prefix(&piece[..count]) {
                Some(rest) => bytes = rest,
                None => return Ok(false),
            },
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn from_io(error: &io::Error) -> FileError {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FileError::NotFound,
        _ => FileError::Io(error.to_string()),
    }
}

/// Files in memory: for tests, and for tools that hold unsaved text. A clone sees the same files.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    files: Arc<RwLock<BTreeMap<String, Arc<[u8]>>>>,
}

impl MemoryFiles {
    /// With these files: (path, contents).
    pub fn new<P: Into<String>, B: AsRef<[u8]>>(files: impl IntoIterator<Item = (P, B)>) -> Self {
        let memory = Self::default();
        for (path, bytes) in files {
            memory.insert(path, bytes);
        }
        memory
    }

    /// Writes a file.
    pub fn insert(&self, path: impl Into<String>, bytes: impl AsRef<[u8]>) {
        self.write().insert(path.into(), bytes.as_ref().into());
    }

    /// Deletes a file.
    pub fn remove(&self, path: &str) {
        self.write().remove(path);
    }

    fn write(&self) -> std::sync::RwLockWriteGuard<'_, BTreeMap<String, Arc<[u8]>>> {
        // The map is whole after every operation, so a panic elsewhere does not spoil it.
        self.files.write().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Files for MemoryFiles {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        let files = self.files.read().unwrap_or_else(std::sync::PoisonError::into_inner);
        files.get(path).cloned().ok_or(FileError::NotFound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a file that holds another text each time it is opened; the last one stays.
    fn read_changing(texts: &[&'static str], limit: u64) -> Result<Vec<u8>, FileError> {
        let opened = std::cell::Cell::new(0);
        settled(limit, || {
            let text = texts[opened.replace(opened.get() + 1).min(texts.len() - 1)];
            Ok((text.len() as u64, text.as_bytes()))
        })
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_read_again() {
        assert_eq!(read_changing(&["one"], 9).unwrap(), b"one");
        // A mix of before and after, one that only began, and one that was longer before.
        for mix in ["onwo", "tw", "", "two and"] {
            assert_eq!(read_changing(&[mix, "two"], 9).unwrap(), b"two", "{mix:?}");
        }
        assert_eq!(read_changing(&["one", "two", "one", "two", "one", "one"], 9).unwrap(), b"one");
        let ever: Vec<&str> = (0..100).map(|n| ["one", "two"][n % 2]).collect();
        let refused = read_changing(&ever, 9);
        assert_eq!(refused, Err(FileError::Io("it changes while it is read".to_owned())));
        assert_eq!(read_changing(&["one", "two and more"], 9), Err(FileError::TooLarge { size: 12, limit: 9 }));
    }

    #[test]
    fn a_file_that_has_moved_is_found_below_its_first_folder() {
        let root = tempfile::tempdir().unwrap();
        for path in ["graphs/b/c", "graphs/a", "worlds"] {
            std::fs::create_dir_all(root.path().join(path)).unwrap();
        }
        for path in ["graphs/b/c/x.toml", "graphs/b/y.toml", "graphs/b/c/y.toml", "worlds/z.toml"] {
            std::fs::write(root.path().join(path), "").unwrap();
        }
        let files = DiskFiles::new(root.path()).unwrap();
        let help = |path: &str| crate::files::not_found(&files, path, None, "").help;
        assert_eq!(help("graphs/x.toml"), ["did you mean `graphs/b/c/x.toml`?"]);
        assert_eq!(help("graphs/a/y.toml"), ["did you mean `graphs/b/y.toml`?"]);
        assert_eq!(help("x.toml"), ["did you mean `graphs/b/c/x.toml`?"]);
        assert_eq!(help("z.toml"), ["did you mean `worlds/z.toml`?"]);
        for elsewhere in ["graphs/z.toml", "none.toml", "none/x.toml"] {
            assert!(help(elsewhere).is_empty(), "{elsewhere}");
        }
        assert!(crate::files::not_found(&MemoryFiles::default(), "graphs/x.toml", None, "").help.is_empty());
    }

    #[test]
    fn a_misspelt_file_is_found_and_said_as_its_file_would_say_it() {
        let root = tempfile::tempdir().unwrap();
        for path in ["graphs/light", "worlds", "shaders/bench"] {
            std::fs::create_dir_all(root.path().join(path)).unwrap();
        }
        let there = ["graphs/primary.toml", "graphs/light/base.toml", "worlds/valley.demo.toml", "worlds/valley.toml"];
        for path in there.iter().chain(&["shaders/primary.comp", "shaders/bench/hit.comp"]) {
            std::fs::write(root.path().join(path), "").unwrap();
        }
        let files = DiskFiles::new(root.path()).unwrap();
        let help = |path: &str, from: &str| crate::files::not_found(&files, path, None, from).help.join("");
        for (path, from, meant) in [
            ("graphs/primry.toml", "", "graphs/primary.toml"),
            ("graphs/primary", "", "graphs/primary.toml"),
            ("primary", "", "graphs/primary.toml"),
            ("valley", "", "worlds/valley.toml"),
            ("worlds/vally.toml", "", "worlds/valley.toml"),
            ("shaders/primry.comp", "shaders", "primary.comp"),
            ("shaders/primary", "shaders", "primary.comp"),
            ("shaders/shaders/primary.comp", "shaders", "primary.comp"),
            ("shaders/hit.comp", "shaders", "bench/hit.comp"),
            ("graphs/bse.toml", "graphs", "light/base.toml"),
            ("graphs/light/primary.toml", "graphs/light", "../primary.toml"),
        ] {
            assert_eq!(help(path, from), format!("did you mean `{meant}`?"), "{path} from {from:?}");
        }
        // Another ending is another kind of file.
        for strange in ["shaders/primary.toml", "graphs/primary.comp", "shaders/it.comp", "shaders/secondary.comp"] {
            assert_eq!(help(strange, ""), "", "{strange}");
        }
    }

    #[test]
    fn disk_reads_inside_the_root_only() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret"), "s").unwrap();
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("shaders")).unwrap();
        std::fs::write(root.path().join("shaders/a.comp"), "a").unwrap();
        File::create(root.path().join("big")).unwrap().set_len(LIMIT + 1).unwrap();
        File::create(root.path().join("big.vox")).unwrap().set_len(VOX_LIMIT + 1).unwrap();
        let files = DiskFiles::new(root.path()).unwrap();
        assert_eq!(&*files.read("shaders/a.comp").unwrap(), b"a");
        assert_eq!(files.read("shaders/b.comp"), Err(FileError::NotFound));
        assert_eq!(files.read("shaders/a.comp/x"), Err(FileError::NotFound));
        assert_eq!(files.read("../secret"), Err(FileError::OutsideRoot));
        assert_eq!(files.read("/etc/passwd"), Err(FileError::OutsideRoot));
        assert_eq!(files.read("big"), Err(FileError::TooLarge { size: LIMIT + 1, limit: LIMIT }));
        assert_eq!(files.read("big.vox"), Err(FileError::TooLarge { size: VOX_LIMIT + 1, limit: VOX_LIMIT }));
        assert!(matches!(files.read("shaders"), Err(FileError::Io(_))));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(outside.path().join("secret"), root.path().join("link")).unwrap();
            std::os::unix::fs::symlink(outside.path(), root.path().join("folder")).unwrap();
            std::os::unix::fs::symlink(root.path().join("shaders/a.comp"), root.path().join("inner")).unwrap();
            assert_eq!(files.read("link"), Err(FileError::OutsideRoot));
            assert_eq!(files.read("folder/secret"), Err(FileError::OutsideRoot));
            assert_eq!(&*files.read("inner").unwrap(), b"a");
        }
    }
}
