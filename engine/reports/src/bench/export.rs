//! `raxel bench --export DIR`: exactly the same work for other tracers, as `docs/bench-export.md` describes it.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use raxel_measure::bench::{Matrix, cameras, pinhole};
use raxel_oracle::export::ExportFiles;
use raxel_oracle::{Oracle, export};
use raxel_output::{Pending, shown};
use raxel_runtime::world::SessionWorld;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Exit, Failure, Result};
use serde_json::json;

use super::labels::stem;

/// Writes the voxels of each world, and the rays and hits of each camera. A combination that cannot be exported is left out with a message,
/// like those that `raxel bench` cannot measure; if nothing is left, it is an error.
pub(super) fn run(folder: &Path, matrix: &Matrix, worlds: &[Arc<SessionWorld>], console: &Console) -> Result {
    let mut exports = Vec::new();
    let mut refused = Vec::new();
    for world in worlds {
        let path = world.path.as_deref().unwrap_or_default();
        let corner = match export::corner(world.voxels()) {
            Ok(corner) => corner,
            Err(error) => {
                refused.push(json!({ "world": path, "reason": format!("`{path}` cannot be exported: {error}") }));
                continue;
            }
        };
        let voxels = format!("{}.voxels", stem(path));
        write(folder, [voxels.as_str()], |[to]| export::voxels(world.voxels(), corner, to), console)?;
        let oracle = Oracle::new(world.voxels());
        for (camera, pose) in cameras(world, &matrix.cameras) {
            for &size in &matrix.sizes {
                let rays: Vec<_> = pinhole(&pose, size).rays(size);
                let rays: Option<Vec<_>> = rays.iter().map(|ray| export::representable(ray, corner)).collect();
                let Some(rays) = rays else {
                    let reason = format!("camera `{camera}` of `{path}` is too far away to be exported");
                    refused.push(json!({ "world": path, "camera": camera, "size": size, "reason": reason }));
                    continue;
                };
                let [width, height] = size;
                let base = format!("{}-{camera}-{width}x{height}", stem(path));
                let names = ["rays", "hits", "ties"].map(|ending| format!("{base}.{ending}"));
                let put = |[rays_to, hits, ties]: [&mut dyn Write; 3]| {
                    export::rays_and_hits(&oracle, corner, &rays, &mut ExportFiles { rays: rays_to, hits, ties })
                };
                write(folder, names.each_ref().map(String::as_str), put, console)?;
                exports.push(json!({
                    "world": path,
                    "camera": camera,
                    "size": size,
                    "corner": corner,
                    "voxels": voxels,
                    "rays": names[0],
                    "hits": names[1],
                    "ties": names[2],
                }));
            }
        }
    }
    for refusal in &refused {
        console.message(&format!("left out: {}", refusal["reason"].as_str().unwrap_or_default()));
    }
    let nothing = exports.is_empty();
    let index = json!({
        "version": export::VERSION,
        "raxel": env!("CARGO_PKG_VERSION"),
        "exports": exports,
        "refused": refused,
    });
    let path = folder.join("export.json");
    Pending::new(&path)?.finish(format!("{index:#}\n").as_bytes())?;
    match console.format() {
        Format::Json => console::json(&json!({ "reason": "exported", "index": path })),
        _ => console.message(&format!("wrote {}", shown(&path))),
    }
    if nothing {
        return Err(Failure::new(Exit::Project, "nothing could be exported; see the reasons above"));
    }
    Ok(())
}

/// Writes files that appear when all of them are whole.
fn write<const N: usize>(
    folder: &Path,
    names: [&str; N],
    put: impl FnOnce([&mut dyn Write; N]) -> std::io::Result<()>,
    console: &Console,
) -> Result {
    let paths = names.map(|name| folder.join(name));
    let pending: Vec<Pending> = paths.iter().map(|path| Pending::new(path)).collect::<raxel_output::Result<_>>()?;
    let fill = || -> std::io::Result<()> {
        let mut files = Vec::with_capacity(N);
        for pending in &pending {
            files.push(BufWriter::new(File::create(pending.temporary())?));
        }
        let sinks: Vec<&mut dyn Write> = files.iter_mut().map(|file| file as &mut dyn Write).collect();
        // As many as names, which are N.
        if let Ok(sinks) = sinks.try_into() {
            put(sinks)?;
        }
        files.iter_mut().try_for_each(Write::flush)
    };
    fill().map_err(|error| Failure::usage(format!("`{}` cannot be written: {error}", paths[0].display())))?;
    for (pending, path) in pending.into_iter().zip(&paths) {
        pending.rename()?;
        console.detail(&format!("wrote {}", shown(path)));
    }
    Ok(())
}
