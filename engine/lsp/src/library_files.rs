//! Files of the shader library that a project does not have, as files that an editor can open: in the user's cache, where they are only to be read.

use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use raxel_cache::CacheLocation;
use raxel_output::{Folders, Pending};
use raxel_shader::library;

/// The folder in the cache: another library has another one.
static FOLDER: LazyLock<String> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    library::FILES.hash(&mut hasher);
    format!("library-{:016x}", hasher.finish())
});

/// The file on disk of a file of the library, e.g. `raxel/world.glsl`. `None` where the library has no such file, or the user has no cache.
pub(super) fn on_disk(name: &str) -> Option<PathBuf> {
    match CacheLocation::of_environment() {
        CacheLocation::Folder(cache) => written(&cache, name),
        CacheLocation::Off | CacheLocation::Unknown => None,
    }
}

/// Writes the file, unless it is there with the same text.
fn written(cache: &Path, name: &str) -> Option<PathBuf> {
    let text = library::text(name)?;
    let path = std::path::absolute(cache.join(&*FOLDER).join(name)).ok()?;
    if fs::read(&path).is_ok_and(|known| known == text.as_bytes()) {
        return Some(path);
    }
    Folders::make(path.parent()?).ok()?.keep();
    Pending::new(&path).ok()?.finish(text.as_bytes()).ok()?;
    let mut permissions = fs::metadata(&path).ok()?.permissions();
    permissions.set_readonly(true);
    // Without this right the editor would let its user change a file that nothing reads.
    let _ = fs::set_permissions(&path, permissions);
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_the_library_is_written_once_and_again_when_it_was_changed() {
        let cache = raxel_output::Scratch::new().unwrap();
        assert_eq!(written(cache.path(), "raxel/none.glsl"), None);
        let path = written(cache.path(), "raxel/ray.glsl").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), library::text("raxel/ray.glsl").unwrap());
        assert!(fs::metadata(&path).unwrap().permissions().readonly());
        fs::remove_file(&path).unwrap();
        fs::write(&path, "changed").unwrap();
        assert_eq!(written(cache.path(), "raxel/ray.glsl"), Some(path.clone()));
        assert_eq!(fs::read_to_string(&path).unwrap(), library::text("raxel/ray.glsl").unwrap());
    }
}
