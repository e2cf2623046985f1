//! The scene below the edits: the voxels that a world's file builds, its materials and its models.

use std::sync::Arc;

use raxel_world::{AIR, Chunk, ChunkPos, MAX_MATERIALS, Material, MaterialIndex, Unavailable, World};

/// The voxels below the edits: a pure function of the position.
pub trait Base: Send + Sync {
    /// The chunk at a position; `None` when it has no solid voxel.
    ///
    /// # Errors
    /// When the base cannot know the voxels, as [`raxel_world::ChunkProvider::try_chunk`]. Such a chunk is never `None`.
    fn try_chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable>;
}

impl Base for World {
    fn try_chunk(&self, pos: ChunkPos) -> Result<Option<Arc<Chunk>>, Unavailable> {
        Ok(self.chunk(pos).cloned())
    }
}

/// A model that edits can place.
#[derive(Clone, Debug)]
pub struct EditModel {
    /// Its name in the world's file.
    pub name: String,
    /// Its voxels.
    pub voxels: Arc<World>,
    /// Palette index in the scene, by the model's own palette index.
    pub materials: Arc<[MaterialIndex]>,
}

/// The materials and models of an edited world.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Materials. Index 0 is air. Those of the world come first, in their order.
    pub materials: Vec<Material>,
    /// Models.
    pub models: Vec<EditModel>,
}

impl Scene {
    /// Makes a scene of the materials of a world and the models of its file. Materials of unplaced models follow those of the world, so the
    /// world's indices stay.
    pub fn new(materials: &[Material], models: &[(String, Arc<World>)]) -> Self {
        let mut scene = Self { materials: materials.to_vec(), models: Vec::new() };
        for (name, voxels) in models {
            if let Some(materials) = scene.adopt(name, voxels) {
                scene.models.push(EditModel { name: name.clone(), voxels: voxels.clone(), materials });
            }
        }
        scene
    }

    /// Palette indices of a model's materials, which join the palette. `None` when there is no room for them.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
    fn adopt(&mut self, name: &str, voxels: &World) -> Option<Arc<[MaterialIndex]>> {
        let index_of = |(index, material): (usize, &Material)| {
            if index == 0 || voxels.counts()[index] == 0 {
                return Some(AIR);
            }
            let full = format!("{name}.{}", material.name);
            let known = self.materials.iter().position(|known| known.name == full && known.same_look(material));
            let index = known.unwrap_or(self.materials.len());
            if index > MAX_MATERIALS {
                return None;
            }
            if known.is_none() {
                self.materials.push(Material { name: full, ..material.clone() });
            }
            Some(index as MaterialIndex)
        };
        voxels.materials().iter().enumerate().map(index_of).collect()
    }

    /// The model of a name.
    pub fn model(&self, name: &str) -> Option<&EditModel> {
        self.models.iter().find(|model| model.name == name)
    }

    /// Palette index of a material, by its name.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
    pub fn material(&self, name: &str) -> Option<MaterialIndex> {
        let index = self.materials.iter().skip(1).position(|material| material.name == name)?;
        Some(index as MaterialIndex + 1)
    }
}
