//! `raxel world info`: size, materials, and what each layout costs.

use std::fmt::Write;
use std::path::PathBuf;

use raxel_diagnostics::names::grouped;
use raxel_layouts::Layout;
use raxel_runtime::project::Project;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::Result;
use raxel_terminal::offline::OfflineProject;
use serde_json::json;

/// Prints a world's size, materials and the bytes of each layout.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world info worlds/valley.toml")]
pub(crate) struct Args {
    /// A world file or a .vox scene; the project's world by default.
    world: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

/// Bytes of one layout, or why the world does not fit it.
struct Cost {
    layout: Layout,
    bytes: std::result::Result<(u64, u64), String>,
}

pub(super) fn run(args: &Args, console: &Console) -> Result {
    let (offline, path) = OfflineProject::of(args.world.as_deref(), Project::default_world, console)?;
    let world = offline.whole_world(&path, console)?;
    let voxels = world.voxels();
    let info = voxels.info();
    let costs: Vec<Cost> = raxel_rivals::LAYOUTS
        .iter()
        .map(|&layout| Cost {
            layout,
            bytes: layout
                .encode(voxels, u64::from(u32::MAX))
                .map(|encoded| (encoded.geometry_bytes, encoded.attribute_bytes))
                .map_err(|error| error.to_string()),
        })
        .collect();

    if console.format() == Format::Json {
        let layouts: serde_json::Map<_, _> = costs
            .iter()
            .map(|cost| {
                let value = match &cost.bytes {
                    Ok((geometry, attributes)) => json!({ "geometry_bytes": geometry, "attribute_bytes": attributes }),
                    Err(error) => json!({ "error": error }),
                };
                (cost.layout.name().to_owned(), value)
            })
            .collect();
        console::json(
            &json!({ "reason": "world", "file": path, "name": world.name(), "info": info, "layouts": layouts }),
        );
        return Ok(());
    }

    let mut text = String::new();
    let _ = writeln!(text, "{} ({path})", world.name());
    if let Some(bounds) = &info.bounds {
        let [x, y, z] = bounds.size();
        let _ = writeln!(text, "  size        {x} × {y} × {z} voxels, from {:?} to {:?}", bounds.min, bounds.max);
    }
    let _ = writeln!(text, "  solid       {} voxels", grouped(info.solids));
    let _ = writeln!(
        text,
        "  chunks      {} of 64³, {} different",
        grouped(info.chunks as u64),
        grouped(info.unique_chunks as u64)
    );
    let _ = writeln!(text, "  in memory   {}", bytes(info.bytes));
    for cost in &costs {
        let name = cost.layout.name();
        let _ = match &cost.bytes {
            Ok((geometry, attributes)) => {
                let per_voxel = (geometry + attributes) as f64 / info.solids.max(1) as f64;
                writeln!(
                    text,
                    "  {name:<11} {} on the device ({} geometry, {} materials), {per_voxel:.2} bytes a voxel",
                    bytes(geometry + attributes),
                    bytes(*geometry),
                    bytes(*attributes)
                )
            }
            Err(error) => writeln!(text, "  {name:<11} {error}"),
        };
    }
    if !info.materials.is_empty() {
        let _ = writeln!(text, "  materials");
    }
    for material in &info.materials {
        let share = 100.0 * material.voxels as f64 / info.solids.max(1) as f64;
        let name = &material.material.name;
        let _ =
            writeln!(text, "    {:>5}  {name:<24} {share:6.2} %  {} voxels", material.index, grouped(material.voxels));
    }
    console::data(&text);
    Ok(())
}

/// Bytes in the unit that suits them.
pub(crate) fn bytes(number: u64) -> String {
    const UNITS: [&str; 4] = ["B", "KiB", "MiB", "GiB"];
    let mut value = number as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{number} B") } else { format!("{value:.1} {}", UNITS[unit]) }
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(3 << 30), "3.0 GiB");
    }
}
