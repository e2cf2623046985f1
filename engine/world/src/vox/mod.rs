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
    import_frame(bytes, 0)
}

/// The same in another frame, from 0. Frames are the models of a file without a scene graph, and the keys of a scene graph: at each frame
/// the last key before it counts.
pub fn import_frame(bytes: &[u8], frame: u32) -> Result<World, VoxError> {
    let file = reader::read(bytes)?;
    let frames = scene::frames(&file);
    if frame > 0 && frame >= frames {
        let has = if frames == 1 { "one frame, 0".to_owned() } else { format!("{frames} frames, 0 to {}", frames - 1) };
        return Err(VoxError::no_frame(format!("there is no frame {frame}: the file has {has}")));
    }
    let materials = palette::materials(&file);
    let (index_of, used): (Vec<u16>, Vec<Material>) = palette::used(&file, materials);
    let voxels = scene::voxels(&file, frame)?;
    Ok(World::from_voxels(used, voxels.into_iter().map(|(cell, color)| (cell, index_of[usize::from(color)]))))
}
