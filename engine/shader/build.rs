//! Makes the table of the shader library that is embedded in the binary: every `.glsl` under `shaders/include/raxel`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or(io::ErrorKind::NotFound)?);
    let include = manifest.join("../../shaders/include");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={}", include.join("raxel").display());

    let mut found = Vec::new();
    collect(&include.join("raxel"), "raxel", &mut found)?;
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

fn collect(folder: &Path, name: &str, found: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    if !folder.is_dir() {
        return Ok(());
    }
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
