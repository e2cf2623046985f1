//! The files that raxel ships: graphs, shaders, worlds and textures, as bytes in the binary. The shader library is embedded by
//! `raxel-shader`.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

/// Every file: its path in a project, with `/` separators, and its bytes. Sorted by path.
pub const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// The bytes of a file, by its path in a project.
pub fn file(path: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, bytes)| *bytes)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Every file on disk is embedded, byte for byte, but those of the shader library.
    #[test]
    fn every_shipped_file_is_embedded() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut count = 0;
        let mut folders: Vec<_> = ["graphs", "shaders", "textures", "worlds"].map(|name| root.join(name)).into();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.ends_with("shaders/include/raxel") {
                    continue;
                }
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
                assert_eq!(file(&name), Some(std::fs::read(&path).unwrap().as_slice()), "{name}");
                count += 1;
            }
        }
        assert_eq!(count + 1, FILES.len(), "raxel.toml is the one file beside the folders");
        assert!(count > 200 && file("raxel.toml").is_some() && file("nothing").is_none());
    }
}
