//! Makes the table of the shader library that is embedded in the binary: every `.glsl` in `library`, a link to `shaders/include/raxel`, so
//! that `cargo package` puts the files themselves into the crate's archive. And names the libraries of the shader compiler that the binary
//! is linked with, because modules are kept on disk for as long as these are the same.

use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or(io::ErrorKind::NotFound)?);
    println!("cargo:rerun-if-env-changed=SHADERC_LIB_DIR");
    println!("cargo:rustc-env=RAXEL_SHADERC_LIBRARIES={}", shaderc_libraries());
    let link = manifest.join("library");
    // On systems without links, git writes a file instead.
    let library = if link.is_dir() { link } else { manifest.join("../../shaders/include/raxel") };
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={}", library.display());

    let mut found = Vec::new();
    collect(&library, "raxel", &mut found)?;
    found.sort();
    let mut table = String::from("&[\n");
    for (name, path) in found {
        println!("cargo:rerun-if-changed={}", path.display());
        let path = path.canonicalize()?.display().to_string();
        writeln!(table, "    ({name:?}, include_str!({path:?})),").map_err(io::Error::other)?;
    }
    table.push(']');
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?);
    fs::write(out.join("library_table.rs"), table)
}

/// A hash of the linked libraries; for those that cargo builds from source the version of the crate suffices.
fn shaderc_libraries() -> String {
    let Some(folder) = env::var_os("SHADERC_LIB_DIR") else { return "built".to_owned() };
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    let mut hasher = DefaultHasher::new();
    for bytes in files.iter().filter_map(|path| fs::read(path).ok()) {
        hasher.write(&bytes);
    }
    format!("{:016x}", hasher.finish())
}

fn collect(folder: &Path, name: &str, found: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let Some(file) = path.file_name().and_then(|file| file.to_str()) else { continue };
        let name = format!("{name}/{file}");
        if path.is_dir() {
            collect(&path, &name, found)?;
        } else if path.extension().is_some_and(|extension| extension == "glsl") {
            found.push((name, path));
        }
    }
    Ok(())
}
