//! The files that raxel ships, as a project on disk. A binary alone has them, wherever it stands.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};

use raxel_cache::CacheLocation;
use raxel_output::{Folders, Pending, Scratch};
use raxel_terminal::console::Console;
use raxel_terminal::failure::Result;

/// A project with every file that raxel ships.
pub(crate) struct Unpacked {
    root: PathBuf,
    /// Set where the files last only as long as this.
    scratch: Option<Scratch>,
}

impl Unpacked {
    /// In the user's cache, or for this process alone where there is none. A file that is there stays as it is: it may have been edited.
    pub(crate) fn new(console: &Console) -> Result<Self> {
        if let CacheLocation::Folder(cache) = CacheLocation::of_environment() {
            let root = cache.join(format!("shipped-{:016x}", fingerprint()));
            match write(&root) {
                Ok(()) => return Ok(Self { root, scratch: None }),
                Err(failure) => console.detail(&failure.message.unwrap_or_default()),
            }
        }
        let scratch = Scratch::new()?;
        write(scratch.path())?;
        Ok(Self { root: scratch.path().to_owned(), scratch: Some(scratch) })
    }

    /// The folder of the project.
    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Whether it is there after this process.
    pub(crate) fn stays(&self) -> bool {
        self.scratch.is_none()
    }
}

/// The same for the same files.
fn fingerprint() -> u64 {
    let mut hasher = DefaultHasher::new();
    raxel_shipped::FILES.hash(&mut hasher);
    hasher.finish()
}

fn write(root: &Path) -> Result {
    for (path, bytes) in raxel_shipped::FILES {
        let path = root.join(path);
        if path.exists() {
            continue;
        }
        if let Some(folder) = path.parent() {
            Folders::make(folder)?.keep();
        }
        Pending::new(&path)?.finish(bytes)?;
    }
    Ok(())
}
