//! `raxel bench --export DIR`: exactly the same work for other tracers, as `docs/bench-export.md` describes it.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use raxel_measure::bench::{Matrix, cameras, pinhole};
use raxel_oracle::{Oracle, export};
use raxel_runtime::world::SessionWorld;
use serde_json::json;

use super::labels::stem;
use crate::failure::{Exit, Failure, Result};
use crate::output::{Pending, shown};
use crate::talk::{self, Format, Talk};

/// Writes the voxels of each world, and the rays and hits of each camera.
pub(super) fn run(folder: &Path, matrix: &Matrix, worlds: &[Arc<SessionWorld>], talk: &Talk) -> Result {
    // All of them are looked at before anything is written.
    let corners: Vec<[i32; 3]> = worlds.iter().map(|world| corner(world)).collect::<Result<_>>()?;
    let mut index = Vec::new();
    for (world, corner) in worlds.iter().zip(corners) {
        let path = world.path.as_deref().unwrap_or_default();
        let voxels = format!("{}.voxels", stem(path));
        write(folder, [voxels.as_str()], |[to]| export::voxels(world.voxels(), corner, to), talk)?;
        let oracle = Oracle::new(world.voxels());
        for (camera, pose) in cameras(world, &matrix.cameras) {
            for &size in &matrix.sizes {
                let rays: Vec<_> = pinhole(&pose, size).rays(size);
                let rays: Option<Vec<_>> = rays.iter().map(|ray| export::representable(ray, corner)).collect();
                let rays = rays.ok_or_else(|| {
                    Failure::new(Exit::Project, format!("camera `{camera}` of `{path}` is too far away to be exported"))
                })?;
                let [width, height] = size;
                let base = format!("{}-{camera}-{width}x{height}", stem(path));
                let names = ["rays", "hits", "ties"].map(|ending| format!("{base}.{ending}"));
                let put = |to: [&mut dyn Write; 3]| export::rays_and_hits(&oracle, corner, &rays, to);
                write(folder, names.each_ref().map(String::as_str), put, talk)?;
                index.push(json!({
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
    let index = json!({ "version": export::VERSION, "raxel": env!("CARGO_PKG_VERSION"), "exports": index });
    let path = folder.join("export.json");
    Pending::new(&path)?.finish(format!("{index:#}\n").as_bytes())?;
    match talk.format() {
        Format::Json => talk::json(&json!({ "reason": "exported", "index": path })),
        _ => talk.say(&format!("wrote {}", shown(&path))),
    }
    Ok(())
}

fn corner(world: &SessionWorld) -> Result<[i32; 3]> {
    export::corner(world.voxels()).map_err(|error| {
        let path = world.path.as_deref().unwrap_or("the empty world");
        Failure::new(Exit::Project, format!("`{path}` cannot be exported: {error}"))
    })
}

/// Writes files that appear when all of them are whole.
fn write<const N: usize>(
    folder: &Path,
    names: [&str; N],
    put: impl FnOnce([&mut dyn Write; N]) -> std::io::Result<()>,
    talk: &Talk,
) -> Result {
    let paths = names.map(|name| folder.join(name));
    let pending: Vec<Pending> = paths.iter().map(|path| Pending::new(path)).collect::<Result<_>>()?;
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
        talk.detail(&format!("wrote {}", shown(path)));
    }
    Ok(())
}
