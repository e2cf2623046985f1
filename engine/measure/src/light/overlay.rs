//! Adds params that move instances to systems that lack them, by a graph that extends the system's.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use raxel_runtime::load::Loader;
use raxel_runtime::project::Project;

use super::LightError;

/// Where these graphs lie in a project.
const FOLDER: &str = ".raxel/cache/light/graphs";

/// The graph itself if it has all params; otherwise a graph that extends it by the missing ones. Mistakes in the graph are reported when it is
/// opened.
pub(super) fn with_params(project: &Path, graph: &str, params: &[String]) -> Result<String, LightError> {
    if params.is_empty() {
        return Ok(graph.to_owned());
    }
    let Some(loader) = Project::at(project).ok().and_then(|project| Loader::new(&project).ok()) else {
        return Ok(graph.to_owned());
    };
    let Ok(known) = loader.graph(graph).result else { return Ok(graph.to_owned()) };
    let lacking = params.iter().filter(|name| known.find_param(name).is_none());
    let mut text = String::new();
    for name in lacking {
        let _ = write!(text, "\n[params.{name:?}]\ntype    = \"f32\"\ndefault = 0.0\n");
    }
    if text.is_empty() {
        return Ok(graph.to_owned());
    }
    let up = "../".repeat(FOLDER.split('/').count());
    let name = graph.rsplit('/').next().unwrap_or(graph).trim_end_matches(".toml");
    let text = format!(
        "# Written by `raxel bench light`: the params that move the instances of a world.\nextends = \"{up}{graph}\"\nname    = \"{name}\"\n{text}"
    );
    let path = format!("{FOLDER}/{name}-{}.toml", &blake3::hash(text.as_bytes()).to_hex()[..8]);
    let file = project.join(&path);
    let part = file.with_extension(format!("{}.part", std::process::id()));
    fs::create_dir_all(project.join(FOLDER))
        .and_then(|()| fs::write(&part, text))
        .and_then(|()| fs::rename(&part, &file))
        .map_err(|error| LightError::Write { path: file, error })?;
    Ok(path)
}
