//! Writes takes as demos of their project.

use raxel_runtime::project::Project;
use raxel_runtime::take::Take;

use crate::error::{OutputError, Result};
use crate::pending::Pending;

/// Writes a take to `worlds/NAME.demo.toml` of a project. A file that is there is never replaced: without a name, the first of `take`,
/// `take-2`, `take-3`, … that is free. Returns the project path.
pub fn write_take(project: &Project, name: Option<&str>, take: &Take) -> Result<String> {
    let path = |name: &str| format!("worlds/{name}.demo.toml");
    let is_there = |path: &str| project.on_disk(path).exists();
    let path = if let Some(name) = name {
        if name.is_empty() || name.len() > 64 || !name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)) {
            return Err(OutputError::new(format!("`{name}` is no name of a take"))
                .help("a name has 1 to 64 letters, digits, `-` and `_`"));
        }
        let path = path(name);
        if is_there(&path) {
            return Err(OutputError::new(format!("`{path}` is there already")).help("give the take another name"));
        }
        path
    } else {
        let names = std::iter::once("take".to_owned()).chain((2..10_000).map(|number| format!("take-{number}")));
        names
            .map(|name| path(&name))
            .find(|path| !is_there(path))
            .ok_or_else(|| OutputError::new("`worlds/` has 9999 takes").help("delete some, or name the take"))?
    };
    Pending::new(&project.on_disk(&path))?.finish(take.text.as_bytes())?;
    Ok(path)
}
