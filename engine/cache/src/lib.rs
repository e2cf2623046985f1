//! A cache on disk, from one run of the program to the next: compiled shaders, and what drivers make of them.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! An entry is a file of bytes under a name that covers everything they follow from. So an entry is never stale: it is found under its
//! name, or made again. raxel writes a file whole under another name and renames it, so other programs never read half a file. Nothing
//! depends on the cache: an unusable folder only costs time. A damaged file is removed, with one warning for each process.
//!
//! The folder belongs to the user and not to a project, because drivers and this program trust their own files: a project comes from
//! anywhere.

mod entry;
mod place;

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, SystemTime};

use entry::{decode, encode};
pub use place::{CacheLocation, SWITCH};

/// Most bytes of one entry. Larger ones are not kept.
pub(crate) const MAX_ENTRY: u64 = 64 << 20;

/// Most bytes of all entries. Those that were not used for longest go first.
const MAX_BYTES: u64 = 256 << 20;

/// The files in the folder are counted at the first write of a process, and after this many more.
const WRITES_BETWEEN_COUNTS: u64 = 64;

/// An entry that was used is marked as used when the last mark is older, so that reading seldom writes.
const MARK_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// The extension of files that are being written.
const PART: &str = "part";

/// A file that another process is still writing, for all that is known. Older ones were left behind.
const UNFINISHED: Duration = Duration::from_secs(60 * 60);

/// Called with the first damaged file: its path, and the damage.
pub(crate) type Warn = dyn Fn(&Path, &str) + Send + Sync;

/// A folder of entries. Threads and processes may use it at the same time.
pub struct Cache {
    folder: PathBuf,
    warn: Option<Box<Warn>>,
    warned: AtomicBool,
    writes: AtomicU64,
}

/// How much a cache holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CacheSize {
    /// Number of entries.
    pub entries: usize,
    /// Bytes of their files.
    pub bytes: u64,
}

static OF_PROCESS: OnceLock<Arc<Cache>> = OnceLock::new();

/// Lets everything in this process keep its results in `cache`. The first call counts; a process that makes none keeps nothing.
pub fn use_in_process(cache: Cache) {
    let _ = OF_PROCESS.set(Arc::new(cache));
}

/// The cache of this process, if it has one.
pub fn of_process() -> Option<Arc<Cache>> {
    OF_PROCESS.get().cloned()
}

impl Cache {
    /// In a folder, which is made when the first entry is kept.
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), warn: None, warned: AtomicBool::new(false), writes: AtomicU64::new(0) }
    }

    /// Calls `warn` at the first damaged file.
    #[must_use]
    pub fn with_warning(self, warn: impl Fn(&Path, &str) + Send + Sync + 'static) -> Self {
        Self { warn: Some(Box::new(warn)), ..self }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The bytes that were kept under a name (letters, digits, `-`, `_` and `.`), if they are still there.
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        let path = self.path(name)?;
        let bytes = match read_file(&path) {
            Ok(bytes) => bytes,
            Err(error) => {
                if error.kind() != io::ErrorKind::NotFound {
                    tracing::debug!("{} cannot be read: {error}", path.display());
                }
                return None;
            }
        };
        match decode(name, &bytes) {
            Ok(payload) => {
                mark_as_used(&path);
                Some(payload.to_vec())
            }
            Err(reason) => {
                self.discard(name, reason);
                None
            }
        }
    }

    /// Keeps bytes under a name. An entry of that name is replaced.
    pub fn write(&self, name: &str, payload: &[u8]) {
        let Some(path) = self.path(name) else { return };
        let bytes = encode(name, payload);
        if bytes.len() as u64 > MAX_ENTRY {
            tracing::debug!("{name} is too large to be kept: {} bytes", bytes.len());
            return;
        }
        let count = self.writes.fetch_add(1, Ordering::Relaxed);
        let part = self.folder.join(format!("{name}.{}-{count}.{PART}", std::process::id()));
        let written = make_folder(&self.folder).and_then(|()| write_new(&part, &bytes));
        if let Err(error) = written.and_then(|()| fs::rename(&part, &path)) {
            tracing::debug!("{} is not kept: {error}", path.display());
            let _ = fs::remove_file(&part);
            return;
        }
        if count.is_multiple_of(WRITES_BETWEEN_COUNTS) {
            self.trim(MAX_BYTES);
        }
    }

    /// Removes an entry that was read and turned out to be useless, and warns of it.
    pub fn discard(&self, name: &str, reason: &str) {
        let Some(path) = self.path(name) else { return };
        let _ = fs::remove_file(&path);
        tracing::debug!("{} is not used: {reason}", path.display());
        if !self.warned.swap(true, Ordering::Relaxed)
            && let Some(warn) = &self.warn
        {
            warn(&path, reason);
        }
    }

    /// Removes an entry.
    pub fn remove(&self, name: &str) {
        if let Some(path) = self.path(name) {
            // It may not be there.
            let _ = fs::remove_file(path);
        }
    }

    /// How much it holds.
    pub fn size(&self) -> CacheSize {
        let files = self.files();
        CacheSize { entries: files.len(), bytes: files.iter().map(|file| file.bytes).sum() }
    }

    /// Removes the least recently used files, until no more than `most` bytes are left, and files that were never finished.
    fn trim(&self, most: u64) {
        let mut files = self.files();
        files.sort_by_key(|file| file.used);
        let mut bytes: u64 = files.iter().map(|file| file.bytes).sum();
        for file in files {
            let left_behind = file.unfinished && file.used.elapsed().is_ok_and(|age| age > UNFINISHED);
            if left_behind || (bytes > most && !file.unfinished) {
                // Another process may have removed it.
                let _ = fs::remove_file(&file.path);
                bytes -= file.bytes;
            }
        }
    }

    fn files(&self) -> Vec<File> {
        let Ok(entries) = fs::read_dir(&self.folder) else { return Vec::new() };
        let file = |entry: fs::DirEntry| {
            let about = entry.metadata().ok().filter(fs::Metadata::is_file)?;
            let path = entry.path();
            let ending = path.extension()?;
            let unfinished = ending == PART;
            // A folder that was named by mistake may hold anything; only raxel's own files are counted, and removed.
            if !unfinished && ending != entry::ENDING {
                return None;
            }
            Some(File { unfinished, bytes: about.len(), used: about.modified().ok()?, path })
        };
        entries.filter_map(|entry| file(entry.ok()?)).collect()
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let sound = !name.is_empty() && !name.starts_with('.') && name.len() < 200 && name.chars().all(plain);
        debug_assert!(sound, "{name:?} is not a name of an entry");
        sound.then(|| self.folder.join(format!("{name}.{}", entry::ENDING)))
    }
}

struct File {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
    unfinished: bool,
}

/// The bytes of a file. Opening a pipe would wait for its other end.
fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    use std::io::Read;
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is not a file"));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(MAX_ENTRY + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn mark_as_used(path: &Path) {
    let old = |time: SystemTime| time.elapsed().is_ok_and(|age| age > MARK_AFTER);
    if fs::metadata(path).and_then(|about| about.modified()).is_ok_and(old)
        && let Ok(file) = fs::File::options().write(true).open(path)
    {
        // A mark that cannot be made lets the entry go earlier.
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Other users may not put anything into the folder.
fn make_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache").field("folder", &self.folder).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    fn filled() -> (tempfile::TempDir, Cache, Arc<Mutex<Vec<String>>>) {
        let folder = tempfile::tempdir().unwrap();
        let said = Arc::new(Mutex::new(Vec::new()));
        let log = said.clone();
        let cache = Cache::at(folder.path().join("a/b"))
            .with_warning(move |path, reason| log.lock().unwrap().push(format!("{}: {reason}", path.display())));
        cache.write("one", b"first");
        cache.write("two", &[7; 1000]);
        (folder, cache, said)
    }

    #[test]
    fn what_was_written_is_read_also_by_another() {
        let (_folder, cache, said) = filled();
        assert_eq!(cache.read("one").unwrap(), b"first");
        assert_eq!(Cache::at(cache.folder()).read("two").unwrap(), [7; 1000]);
        assert_eq!(cache.read("three"), None);
        cache.write("one", b"");
        assert_eq!(cache.read("one").unwrap(), b"");
        assert_eq!(cache.size().entries, 2);
        assert!(said.lock().unwrap().is_empty());
    }

    #[test]
    fn every_damage_is_noticed_and_warned_of_once() {
        let (_folder, cache, said) = filled();
        let path = cache.path("two").unwrap();
        let whole = fs::read(&path).unwrap();
        let flipped = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            bytes
        };
        let mut damaged: Vec<Vec<u8>> = (0..whole.len()).step_by(61).map(flipped).collect();
        damaged.extend([
            Vec::new(),
            whole[..20].to_vec(),
            whole[..whole.len() - 1].to_vec(),
            [&whole[..], b"x"].concat(),
        ]);
        // A sound file under another's name.
        damaged.push(fs::read(cache.path("one").unwrap()).unwrap());
        for bytes in damaged {
            fs::write(&path, &bytes).unwrap();
            assert_eq!(cache.read("two"), None, "{} bytes", bytes.len());
            assert!(!path.exists(), "it is removed, and can be made again");
        }
        assert_eq!(said.lock().unwrap().len(), 1, "{said:?}");
        assert_eq!(cache.read("one").unwrap(), b"first", "others are not touched");
    }

    #[test]
    fn what_was_not_used_for_longest_goes_first() {
        let (_folder, cache, _) = filled();
        for (name, days) in [("old", 9), ("older", 10), ("new", 8)] {
            cache.write(name, &[1; 5000]);
            let file = fs::File::options().write(true).open(cache.path(name).unwrap()).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(days * 86400)).unwrap();
        }
        // Reading is a use.
        assert!(cache.read("older").is_some());
        fs::write(cache.folder().join("readme.txt"), [0; 9000]).unwrap();
        cache.trim(12_000);
        assert!(cache.read("old").is_none() && cache.read("new").is_some() && cache.read("older").is_some());
        assert!(cache.folder().join("readme.txt").exists(), "not put there by the cache");
        let part = cache.folder().join("one.1-1.part");
        fs::write(&part, b"half").unwrap();
        cache.trim(u64::MAX);
        assert!(part.exists(), "somebody may be writing it");
        let file = fs::File::options().write(true).open(&part).unwrap();
        file.set_modified(SystemTime::now() - 2 * UNFINISHED).unwrap();
        cache.trim(u64::MAX);
        assert!(!part.exists());
    }

    #[test]
    fn a_folder_that_cannot_be_written_costs_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"").unwrap();
        let cache = Cache::at(file.join("below"))
            .with_warning(|path, reason| panic!("{} is not damaged: {reason}", path.display()));
        cache.write("one", b"first");
        assert_eq!(cache.read("one"), None);
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_in_place_of_an_entry_is_not_waited_for() {
        let (_folder, cache, _) = filled();
        let path = cache.path("two").unwrap();
        fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let before = cache.read("two");
            cache.write("two", b"anew");
            sender.send((before, cache.read("two")))
        });
        let read = receiver.recv_timeout(Duration::from_secs(60)).expect("reading waits for the other end of the pipe");
        assert_eq!(read, (None, Some(b"anew".to_vec())));
    }

    #[test]
    fn readers_never_see_half_of_what_many_write() {
        let (_folder, cache, said) = filled();
        std::thread::scope(|scope| {
            for byte in 0..4u8 {
                let other = Cache::at(cache.folder());
                scope.spawn(move || (0..50).for_each(|_| other.write("shared", &vec![byte; 30_000])));
            }
            for _ in 0..200 {
                if let Some(bytes) = cache.read("shared") {
                    assert!(bytes.len() == 30_000 && bytes.iter().all(|byte| *byte == bytes[0]));
                }
            }
        });
        assert!(cache.read("shared").is_some());
        assert_eq!(said.lock().unwrap().len(), 0, "{said:?}");
    }
}
