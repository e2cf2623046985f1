//! Says where the pages of the codes are: in `pages`, a link to `docs/errors`. So `cargo package` puts them into the crate's archive.

use std::path::PathBuf;
use std::{env, io};

fn main() -> io::Result<()> {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or(io::ErrorKind::NotFound)?);
    println!("cargo:rerun-if-changed=build.rs");
    let link = manifest.join("pages");
    // On systems without links, git writes a file instead.
    let pages = if link.is_dir() { link } else { manifest.join("../../docs/errors") };
    // A repository that was moved has another path: then cargo finds nothing at this one and runs the script again.
    println!("cargo:rerun-if-changed={}", pages.display());
    println!("cargo:rustc-env=RAXEL_ERROR_PAGES={}", pages.display());
    Ok(())
}
