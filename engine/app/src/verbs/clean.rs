//! `raxel clean`: removes raxel's own files from `.raxel/`, and nothing else.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use raxel_runtime::project::Project;
use raxel_terminal::args::Messages;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};

/// Folders in `.raxel/` that can always be made again.
const MADE_BY_RAXEL: &[&str] = &["cache", "demo", "shaders"];

/// Removes a project's caches and demo pictures (`.raxel/cache`, `.raxel/demo`, `.raxel/shaders`).
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The project; the one around the current folder by default.
    #[arg(value_name = "DIR")]
    project: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let place = args.project.as_deref().unwrap_or(Path::new("."));
    let project = Project::around(place).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let folder = project.root().join(".raxel");
    match fs::symlink_metadata(&folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            console.message("nothing to remove");
            return Ok(());
        }
        // The target of a link was not made here.
        Ok(found) if found.is_symlink() => {
            return Err(Failure::usage(format!("`{}` is a link; remove it by hand", folder.display())));
        }
        _ => {}
    }
    let mut removed = false;
    for name in MADE_BY_RAXEL {
        let path = folder.join(name);
        match fs::remove_dir_all(&path) {
            Ok(()) => {
                removed = true;
                console.message(&format!("removed {}", path.display()));
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => {
                return Err(Failure::usage(format!("`{}` cannot be removed: {error}", path.display())));
            }
        }
    }
    if !removed {
        console.message("nothing to remove");
    }
    Ok(())
}
