//! Where a user's cache is.

use std::path::PathBuf;

/// The variable of the environment that names another folder, or turns the cache off.
pub const SWITCH: &str = "RAXEL_CACHE";

/// Where the cache of the user who runs this process is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CacheLocation {
    /// In this folder.
    Folder(PathBuf),
    /// Nowhere: [`SWITCH`] says `off`.
    Off,
    /// Nowhere: the environment names no home.
    Unknown,
}

impl CacheLocation {
    /// From the environment: [`SWITCH`] if it is set, else `raxel` in the folder that the system has for caches: `XDG_CACHE_HOME` or
    /// `~/.cache`, `~/Library/Caches`, `%LOCALAPPDATA%`.
    pub fn of_environment() -> Self {
        Self::by(|name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from))
    }

    fn by(variable: impl Fn(&str) -> Option<PathBuf>) -> Self {
        match variable(SWITCH) {
            Some(value) if value.as_os_str() == "off" => return Self::Off,
            Some(folder) => return Self::Folder(folder),
            None => {}
        }
        // A relative path is not valid there ("XDG Base Directory Specification").
        let absolute = |name: &str| variable(name).filter(|path| path.is_absolute());
        let caches = if cfg!(windows) {
            absolute("LOCALAPPDATA")
        } else if cfg!(target_os = "macos") {
            absolute("HOME").map(|home| home.join("Library/Caches"))
        } else {
            absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        };
        caches.map_or(Self::Unknown, |folder| Self::Folder(folder.join("raxel")))
    }
}

#[cfg(all(test, unix, not(target_os = "macos")))]
mod tests {
    use super::*;

    fn place(variables: &[(&str, &str)]) -> CacheLocation {
        CacheLocation::by(|name| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| PathBuf::from(value))
        })
    }

    #[test]
    fn the_switch_wins_then_the_system_and_a_home_is_not_needed() {
        let folder = |path: &str| CacheLocation::Folder(PathBuf::from(path));
        assert_eq!(place(&[("HOME", "/home/a")]), folder("/home/a/.cache/raxel"));
        assert_eq!(place(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "/var/b")]), folder("/var/b/raxel"));
        assert_eq!(place(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "b")]), folder("/home/a/.cache/raxel"));
        assert_eq!(place(&[("HOME", "/home/a"), (SWITCH, "kept")]), folder("kept"));
        assert_eq!(place(&[("HOME", "/home/a"), (SWITCH, "off")]), CacheLocation::Off);
        assert_eq!(place(&[]), CacheLocation::Unknown);
    }
}
