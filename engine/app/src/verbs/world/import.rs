//! `raxel world import`: a .vox scene becomes a model of the project and a world that places it.

use std::path::{Path, PathBuf};

use raxel_diagnostics::DiskFiles;
use raxel_diagnostics::Files;
use raxel_output::{Folders, Pending, shown};
use raxel_runtime::project::Project;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_world::World;
use serde_json::json;

/// Copies a MagicaVoxel scene into the project and writes a world around it.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: raxel world import castle.vox   (makes worlds/castle.toml and worlds/models/castle.vox)"
)]
pub(crate) struct Args {
    /// The .vox file.
    model: PathBuf,

    /// The world to write; worlds/NAME.toml in the project around the current folder by default.
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,

    /// Which frame of an animation, from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u32,

    /// Replace files that exist.
    #[arg(long)]
    force: bool,

    #[command(flatten)]
    pub messages: Messages,
}

pub(super) fn run(args: &Args, console: &Console) -> Result {
    let stem = name_of(&args.model)?;
    // The scene is read whole before anything is written: a broken one changes nothing.
    let bytes = read(&args.model, console)?;
    let world = scene(&bytes, &args.model, args.frame, console)?;

    let around = args.output.as_deref().and_then(Path::parent).filter(|f| !f.as_os_str().is_empty());
    let project =
        Project::around(around.unwrap_or(Path::new("."))).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let toml = args.output.clone().unwrap_or_else(|| project.on_disk(&format!("worlds/{stem}.toml")));
    let model = project.on_disk(&format!("worlds/models/{stem}.vox"));
    for file in [&toml, &model] {
        if file.exists() && !args.force && !same_file(file, &args.model) {
            return Err(Failure::usage(format!("`{}` exists", file.display())).help("--force replaces it"));
        }
    }
    let folder = |file: &Path| Folders::make(file.parent().unwrap_or(Path::new("")));
    let _made = [folder(&toml)?, folder(&model)?];
    let (pending_model, pending_toml) = (Pending::new(&model)?, Pending::new(&toml)?);
    pending_model.finish(&bytes)?;
    pending_toml.finish(description(&stem, &args.model, args.frame).as_bytes())?;

    let voxels = world.info().solids;
    match console.format() {
        Format::Json => {
            console::json(&json!({ "reason": "imported", "world": toml, "model": model, "voxels": voxels }));
        }
        _ => console.message(&format!("wrote {} and {} ({voxels} voxels)", shown(&toml), shown(&model))),
    }
    Ok(())
}

/// The name that a model of this file has: a bare TOML key. A name without a letter or digit of one, such as `家.vox`, becomes `model`.
pub(crate) fn name_of(model: &Path) -> Result<String> {
    let Some(stem) = model.file_stem() else {
        return Err(Failure::usage(format!("`{}` names no file", model.display())));
    };
    let name = clean(&stem.to_string_lossy());
    Ok(if name.is_empty() { "model".to_owned() } else { name })
}

/// The voxels of a scene, or its mistake.
pub(crate) fn scene(bytes: &[u8], model: &Path, frame: u32, console: &Console) -> Result<World> {
    raxel_world::vox::import_frame(bytes, frame)
        .map_err(|error| console.stop(&[error.diagnostic(&model.display().to_string(), None)]))
}

/// The scene's bytes, under the same cap as any file that raxel reads.
pub(crate) fn read(model: &Path, console: &Console) -> Result<Vec<u8>> {
    let folder = model.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = model.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let files = DiskFiles::new(folder)
        .map_err(|error| Failure::usage(format!("`{}` cannot be read: {error}", folder.display())))?;
    match files.read(&name) {
        Ok(bytes) => Ok(bytes.to_vec()),
        Err(error) => Err(console.stop(&[error.diagnostic(&model.display().to_string(), None)])),
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// A name that is a bare TOML key and a file name everywhere.
fn clean(stem: &str) -> String {
    let cleaned: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' }).collect();
    cleaned.trim_matches('_').to_owned()
}

fn description(stem: &str, model: &Path, frame: u32) -> String {
    let frame = if frame == 0 { String::new() } else { format!("frame = {frame}\n") };
    let from = model.file_name().unwrap_or_default().to_string_lossy().replace(['"', '\\', '\n', '\r'], "_");
    format!(
        "#:schema ../.raxel/world.schema.json\n\
         name  = \"{stem}\"\n\
         about = \"imported from {from}\"\n\n\
         [models.{stem}]\n\
         file = \"models/{stem}.vox\"\n\
         {frame}\n\
         [[build]]\n\
         op     = \"model\"\n\
         model  = \"{stem}\"\n\
         origin = [0, 0, 0]\n"
    )
}

#[cfg(test)]
mod tests {
    use super::clean;

    #[test]
    fn names_become_keys() {
        assert_eq!(clean("My Castle (2)"), "My_Castle__2");
        assert_eq!(clean("../x"), "x");
        assert_eq!(clean("ü"), "");
    }
}
