//! Makes the table of the files that are embedded. In the repository the folders are links to those at its root, so that `cargo package`
//! puts the files themselves into the crate's archive.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// What is embedded, in the order of the table.
const ROOTS: [&str; 5] = ["graphs", "raxel.toml", "shaders", "textures", "worlds"];
/// Embedded by `raxel-shader`.
const LIBRARY: &str = "shaders/include/raxel";

fn main() -> io::Result<()> {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or(io::ErrorKind::NotFound)?);
    println!("cargo:rerun-if-changed=build.rs");
    let mut found = Vec::new();
    for root in ROOTS {
        let link = manifest.join(root);
        // On systems without links, git writes a file with the target in it.
        let is_text = fs::read(&link).is_ok_and(|bytes| bytes.starts_with(b"../../"));
        collect(&if is_text { manifest.join("../..").join(root) } else { link }, root, &mut found)?;
    }
    let mut table = String::from("&[\n");
    for (name, path) in found {
        let path = path.canonicalize()?.display().to_string();
        writeln!(table, "    ({name:?}, include_bytes!({path:?})),").map_err(io::Error::other)?;
    }
    table.push(']');
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?);
    fs::write(out.join("files.rs"), table)
}

fn collect(path: &Path, name: &str, found: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    println!("cargo:rerun-if-changed={}", path.display());
    if name == LIBRARY {
        return Ok(());
    }
    if !path.is_dir() {
        found.push((name.to_owned(), path.to_owned()));
        return Ok(());
    }
    let mut entries: Vec<PathBuf> = fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort();
    for entry in entries {
        let Some(file) = entry.file_name().and_then(|file| file.to_str()) else { continue };
        collect(&entry, &format!("{name}/{file}"), found)?;
    }
    Ok(())
}
