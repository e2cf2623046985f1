//! `raxel shaders`: the SPIR-V of every pass, for other tools.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use raxel_shader::bytes_of;
use serde_json::json;

use crate::args::{Messages, each_once};
use crate::console::{self, Console, Format, To};
use crate::failure::{Exit, Failure, Result};
use crate::front::Front;
use crate::output::{Folders, Pending};

/// Compiles the shaders of all passes of graphs to SPIR-V files, one for each pass: GRAPH.PASS.spv.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel shaders -o spv && spirv-val spv/primary.trace.spv")]
pub(crate) struct Args {
    /// Graphs; all of the project's by default.
    #[arg(value_name = "GRAPH")]
    graphs: Vec<PathBuf>,

    /// The folder to write to; made if it does not exist. By default .raxel/shaders in the project.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let around = args.graphs.first().map_or(Path::new("."), PathBuf::as_path);
    let front = Front::around(around).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let mut paths = Vec::new();
    for named in &args.graphs {
        paths.push(front.project.path_of(named).map_err(|diagnostic| console.stop(&[*diagnostic]))?);
    }
    paths = if paths.is_empty() { front.project.graphs() } else { each_once(paths) };
    let folder = args.output.clone().unwrap_or_else(|| front.project.on_disk(".raxel/shaders"));

    // Every graph is compiled before anything is written.
    let mut modules: BTreeMap<String, (Vec<u8>, String)> = BTreeMap::new();
    let mut failed = false;
    for path in &paths {
        let part = front.loader.graph(path);
        console.diagnostics(part.found(), &part.texts, To::Stderr);
        let Ok(graph) = part.result else {
            failed = true;
            continue;
        };
        let stem = Path::new(path).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        for pass in graph.passes.iter().filter(|pass| !pass.made) {
            let file = format!("{stem}.{}.spv", pass.name);
            modules.insert(file, (bytes_of(&pass.shader.spirv), pass.shader.request.path.clone()));
        }
    }
    if failed {
        return Err(Failure::printed(Exit::Project));
    }
    let _made = Folders::make(&folder)?;
    for (name, (bytes, shader)) in modules {
        let file = folder.join(name);
        Pending::new(&file)?.finish(&bytes)?;
        match console.format() {
            Format::Json => {
                console::json(&json!({ "reason": "shader", "file": file, "shader": shader, "bytes": bytes.len() }));
            }
            _ => console::data(&format!("{}  {shader}, {} bytes\n", file.display(), bytes.len())),
        }
    }
    Ok(())
}
