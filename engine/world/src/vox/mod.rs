//! MagicaVoxel's .vox: import of whole scenes, and export. The format is that of `MagicaVoxel-file-format-vox.txt` and
//! `-extension.txt` in ephtracy/voxel-model. Z points up in it; cell (x, y, z) of a scene is cell (x, z, −y − 1) of a world.

mod error;
mod export;
mod palette;
mod reader;
mod scene;

pub use error::{ExportError, VoxError, VoxErrorKind};
pub use export::export;

use crate::material::Material;
use crate::world::World;

/// Imports a scene: every visible model at its place, in the first frame of animations, with the materials that it uses.
pub fn import(bytes: &[u8]) -> Result<World, VoxError> {
    let file = reader::read(bytes)?;
    let materials = palette::materials(&file);
    let (index_of, used): (Vec<u16>, Vec<Material>) = palette::used(&file, materials);
    let voxels = scene::voxels(&file)?;
    Ok(World::from_voxels(used, voxels.into_iter().map(|(cell, color)| (cell, index_of[usize::from(color)]))))
}
