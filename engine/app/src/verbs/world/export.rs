//! `raxel world export`: a world as a .vox scene.

use std::path::PathBuf;

use raxel_output::{Pending, shown};
use raxel_runtime::Saves;
use raxel_runtime::project::Project;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::OfflineProject;
use serde_json::json;

/// Writes the voxels of a world, with the edits in its save, as a MagicaVoxel scene.
///
/// Instances are left out.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world export worlds/menger.toml -o menger.vox")]
pub(crate) struct Args {
    /// A world file or a .vox scene; the project's world by default.
    world: Option<PathBuf>,

    /// The file to write.
    #[arg(short, long, value_name = "FILE.vox")]
    output: PathBuf,

    #[command(flatten)]
    pub messages: Messages,
}

pub(super) fn run(args: &Args, console: &Console) -> Result {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vox")) {
        return Err(Failure::usage(format!("`{}` does not end in .vox", args.output.display())));
    }
    let pending = Pending::new(&args.output)?;
    let (offline, path) = OfflineProject::of(args.world.as_deref(), Project::default_world, console)?;
    let world = offline.saved_world(&path, Saves::Read, console)?.world();
    offline.whole(&world, &path, None, console)?;
    let bytes = raxel_world::vox::export(world.voxels()).map_err(|error| console.stop(&[error.diagnostic(&path)]))?;
    let size = bytes.len();
    pending.finish(&bytes)?;
    let instances = world.instances().list.len();
    let left_out = match instances {
        0 => String::new(),
        1 => " without its instance, which is not a voxel of it".to_owned(),
        _ => format!(" without its {instances} instances, which are not voxels of it"),
    };
    match console.format() {
        Format::Json => {
            let said = json!({
                "reason": "exported", "world": path, "file": args.output, "bytes": size, "instances_left_out": instances,
            });
            console::json(&said);
        }
        _ => console.message(&format!("wrote {}{left_out} ({size} bytes)", shown(&args.output))),
    }
    Ok(())
}
