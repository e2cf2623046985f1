//! `raxel shaders`: the SPIR-V of every pass, for other tools.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use raxel_output::{Folders, Pending};
use raxel_shader::{bytes_of, library};
use raxel_terminal::args::{Messages, each_once};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use serde_json::json;

/// Compiles the shaders of graphs to SPIR-V files, one for each pass: GRAPH.PASS.spv.
///
/// If a binding of a pass depends on the world, there are several: GRAPH.PASS.spv without it, GRAPH.PASS.1.spv with it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  raxel shaders -o spv && spirv-val spv/primary.trace.spv\n  \
                        raxel shaders --library raxel/camera.glsl    the text that `#include <raxel/camera.glsl>` reads")]
pub(crate) struct Args {
    /// Graphs; all of the project's by default.
    #[arg(value_name = "GRAPH")]
    graphs: Vec<PathBuf>,

    /// Print the library that `#include <raxel/…>` reads: the names of its files, or those that are named here.
    #[arg(long, value_name = "FILE", num_args = 0.., conflicts_with_all = ["graphs", "output"])]
    library: Option<Vec<String>>,

    /// The folder to write to; made if it does not exist. By default .raxel/shaders in the project.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    if let Some(files) = &args.library {
        return print_library(files);
    }
    let around = args.graphs.first().map_or(Path::new("."), PathBuf::as_path);
    let offline = OfflineProject::around(around).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let mut paths = Vec::new();
    for named in &args.graphs {
        paths.push(offline.project.path_of(named).map_err(|diagnostic| console.stop(&[*diagnostic]))?);
    }
    paths = if paths.is_empty() { offline.project.graphs() } else { each_once(paths) };
    let folder = args.output.clone().unwrap_or_else(|| offline.project.on_disk(".raxel/shaders"));

    // Every graph is compiled before anything is written.
    let mut modules: BTreeMap<String, (Vec<u8>, String)> = BTreeMap::new();
    let mut failed = false;
    for path in &paths {
        let part = offline.loader.graph(path);
        console.diagnostics(part.found(), &part.texts, To::Stderr);
        let Ok(graph) = part.result else {
            failed = true;
            continue;
        };
        let stem = Path::new(path).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        for pass in graph.passes.iter().filter(|pass| !pass.made) {
            // A pass that some worlds run with other bindings has a file for each case.
            let cases = || graph.cases(&pass.name);
            let after = cases().skip_while(|case| !std::ptr::eq(graph.pass(*case), pass)).count();
            let case = if after > 1 { format!(".{}", after - 1) } else { String::new() };
            let file = format!("{stem}.{}{case}.spv", pass.name);
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

/// The texts of the built-in files, or their names.
fn print_library(files: &[String]) -> Result {
    if files.is_empty() {
        for (name, text) in library::FILES.iter().filter(|(name, _)| !library::is_internal(name)) {
            console::data(&format!("{name:40} {}\n", library::purpose(text)));
        }
        return Ok(());
    }
    for file in files {
        let name = file.trim_matches(['<', '>']);
        let Some(text) = library::text(name) else {
            let failure = Failure::usage(format!("the library has no `{name}`"));
            return Err(match library::closest(name) {
                Some(close) => failure.help(format!("did you mean `{close}`?")),
                None => failure.help("`raxel shaders --library` lists its files"),
            });
        };
        console::data(text);
    }
    Ok(())
}
