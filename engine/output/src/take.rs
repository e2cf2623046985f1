//! Writes takes as demos of their project.

use raxel_runtime::project::Project;
use raxel_runtime::take::Take;

use crate::error::{OutputError, Result};
use crate::pending::Pending;

/// Writes a take to `worlds/NAME.demo.toml` of a project, without a name to [`free_take`]. Never replaces a file. Returns the project path.
pub fn write_take(project: &Project, name: Option<&str>, take: &Take) -> Result<String> {
    let path = if let Some(name) = name {
        if name.is_empty() || name.len() > 64 || !name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)) {
            return Err(OutputError::new(format!("`{name}` cannot be the name of a take"))
                .help("a name has 1 to 64 letters, digits, `-` and `_`"));
        }
        let path = path_of(name);
        if project.on_disk(&path).exists() {
            return Err(OutputError::new(format!("`{path}` is there already")).help("give the take another name"));
        }
        path
    } else {
        free_take(project)?
    };
    Pending::new(&project.on_disk(&path))?.finish(take.text.as_bytes())?;
    Ok(path)
}

/// The project path of the next take without a name: the first of `take`, `take-2`, `take-3`, … in `worlds/` that is free.
///
/// # Errors
/// There are 9999 takes.
pub fn free_take(project: &Project) -> Result<String> {
    std::iter::once("take".to_owned())
        .chain((2..10_000).map(|number| format!("take-{number}")))
        .map(|name| path_of(&name))
        .find(|path| !project.on_disk(path).exists())
        .ok_or_else(|| OutputError::new("`worlds/` has 9999 takes").help("delete some, or name the take"))
}

fn path_of(name: &str) -> String {
    format!("worlds/{name}.demo.toml")
}
