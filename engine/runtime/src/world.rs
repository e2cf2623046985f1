//! The world of a session: its voxels, the facts about them for conditions and cameras, and their encodings.

mod baked;
mod generator;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use raxel_diagnostics::{Diagnostic, Files, SourceMap};
use raxel_edit::{Base, ChunkCache, ChunkCacheStats, EditedChunks, Scene};
use raxel_graph::checked::Fact;
use raxel_graph::plan::WorldInput;
use raxel_layouts::instances::Instances;
use raxel_layouts::{Encoded, EncodedImage, EncodingLimits, Layout, LayoutError};
use raxel_world::{Bounds, Chunk, ChunkPos, ChunkProvider as _, Material};
use raxel_worldfile::Streamed;
use raxel_worldfile::{Aim, CameraHint, Effort, Loaded};

pub use baked::store_refused;

use crate::camera::Camera;
use crate::editing::misplaced;

/// Bytes of chunks that are kept where the file wants none, in a world with lamps: those of a chunk follow from the six around it, which
/// would each be made up to seven times.
const LAMP_NEIGHBOURS: u64 = 8 << 20;

/// A world, and the costs of its encodings.
pub struct SessionWorld {
    /// Project path of its file; `None` for the empty world of a session without one.
    pub path: Option<String>,
    loaded: Loaded,
    identity: Arc<WorldIdentity>,
    costs: Mutex<BTreeMap<Layout, LayoutCost>>,
    /// Names of the materials by index.
    materials: Vec<String>,
    /// The tiles of a streamed world, with its edits.
    tiles: Option<Arc<EditedChunks>>,
    /// Those of them that were made, packed, without edits.
    kept: Option<Arc<ChunkCache>>,
    /// Whether it has edits, and encodings are made to follow them.
    edited: bool,
}

/// Tells a world from every other one, those of the same file before and after an edit included. It lives as long as the world.
#[derive(Debug, Default)]
pub(crate) struct WorldIdentity(());

/// A world in a layout: the buffer, and the image of a layout that has one.
pub(crate) type EncodeResult = Result<(Encoded, Option<EncodedImage>), LayoutError>;

/// The cost of bringing a world into a layout.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LayoutCost {
    /// Bytes that say where solid voxels are.
    pub geometry_bytes: u64,
    /// Bytes that describe their materials.
    pub attribute_bytes: u64,
    /// Seconds of encoding, the upload not counted.
    pub encode_seconds: f64,
}

impl SessionWorld {
    /// A world without voxels.
    pub fn empty() -> Self {
        Self::new(None, Loaded::new("empty", raxel_world::World::empty(), Vec::new()))
    }

    /// Loads the world at a project path, with its warnings.
    pub fn load(
        path: &str,
        files: &dyn Files,
        texts: &mut SourceMap,
        effort: Effort,
    ) -> Result<(Self, Vec<Diagnostic>), Vec<Diagnostic>> {
        let open = |address: &str| baked::open(address, files);
        let (loaded, mut found) = raxel_worldfile::load_with(path, files, texts, effort, &open)?;
        if let Some(misplaced) = misplaced(&loaded, files.root()) {
            found.push(misplaced);
            return Err(found);
        }
        Ok((Self::new(Some(path.to_owned()), loaded), found))
    }

    fn new(path: Option<String>, loaded: Loaded) -> Self {
        let mut materials = loaded.world.materials().to_vec();
        let shines = materials.iter().any(|material| material.emission > 0.0);
        let kept = loaded.stream.as_ref().map(|streamed| {
            let bytes = match streamed.settings.cpu_memory {
                0 if shines => LAMP_NEIGHBOURS,
                bytes => bytes,
            };
            Arc::new(ChunkCache::new(streamed.generator.clone(), bytes))
        });
        let tiles = kept.as_ref().map(|kept| {
            // The palette of a streamed world never changes: materials that models may bring are in it from the beginning.
            materials = Scene::new(&materials, &loaded.models).materials;
            Arc::new(EditedChunks::new(kept.clone(), materials.clone()))
        });
        let materials = materials.into_iter().map(|material| material.name).collect();
        Self { path, loaded, identity: Arc::default(), costs: Mutex::default(), materials, tiles, kept, edited: false }
    }

    /// The same world with other chunks. All worlds that edits make of one file share an identity, since their encodings follow the edits.
    pub(crate) fn edited(
        &self,
        identity: &Arc<WorldIdentity>,
        materials: &[Material],
        changes: impl IntoIterator<Item = (ChunkPos, Option<Arc<Chunk>>)>,
    ) -> Self {
        let world = self.loaded.world.with_chunks(materials, changes);
        let loaded = Loaded { world, ..self.loaded.clone_without_voxels() };
        Self { identity: identity.clone(), edited: true, ..Self::new(self.path.clone(), loaded) }
    }

    /// Whether it has edits, or had some.
    pub(crate) fn is_edited(&self) -> bool {
        self.edited
    }

    /// The contents of its file.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.loaded.name
    }

    /// A hash of everything that its voxels are built from; `files` are those that it was loaded from.
    pub fn fingerprint(&self, files: &dyn Files) -> [u8; 32] {
        generator::hash(&self.loaded, files)
    }

    /// How it comes into being around the camera, if it is never whole in memory.
    pub fn streamed(&self) -> Option<&Streamed> {
        self.loaded.stream.as_ref()
    }

    /// The tiles of a streamed world, with its edits.
    pub fn tiles(&self) -> Option<&Arc<EditedChunks>> {
        self.tiles.as_ref()
    }

    /// The tiles of a streamed world that the host holds.
    pub fn kept(&self) -> Option<ChunkCacheStats> {
        self.kept.as_ref().map(|kept| kept.stats())
    }

    /// The newest voxels, chunk by chunk. Those of a streamed world are made when they are asked for.
    pub fn newest(&self) -> &dyn Base {
        match &self.tiles {
            Some(tiles) => &**tiles,
            None => &self.loaded.world,
        }
    }

    /// The voxels below edits: of a streamed world, without any; of others, these.
    pub(crate) fn base(&self) -> &dyn Base {
        match &self.tiles {
            Some(tiles) => tiles.unedited(),
            None => &self.loaded.world,
        }
    }

    /// The voxels; empty for a streamed world.
    pub fn voxels(&self) -> &raxel_world::World {
        &self.loaded.world
    }

    /// The materials and models that edits can use.
    pub fn scene(&self) -> Scene {
        Scene::new(self.voxels().materials(), &self.loaded.models)
    }

    /// Whether a fact about worlds holds. Facts about devices and params are not the world's.
    pub fn holds(&self, fact: &Fact) -> bool {
        let unbuilt = self.loaded.unbuilt.map(|_| self.loaded.world.materials());
        if let Some(declared) = self.tiles.as_ref().map(|tiles| tiles.materials()).or(unbuilt) {
            // Every declared material may come into view.
            let any = |of: fn(&Material) -> f32| declared.iter().skip(1).any(|material| of(material) > 0.0);
            return match fact {
                Fact::WorldHasEmission => any(|material| material.emission),
                Fact::WorldHasTransparency => any(|material| material.transparency),
                Fact::WorldHasVoxels => true,
                Fact::WorldHasInstances => self.has_instances(),
                Fact::DevicePackets | Fact::DeviceBallots | Fact::Param(_) => false,
            };
        }
        match fact {
            Fact::WorldHasEmission => {
                self.loaded.world.has_emission() || self.loaded.instances.has_emission(self.palette())
            }
            Fact::WorldHasTransparency => self.loaded.world.has_transparency(),
            Fact::WorldHasVoxels => self.loaded.world.bounds().is_some(),
            Fact::WorldHasInstances => self.has_instances(),
            Fact::DevicePackets | Fact::DeviceBallots | Fact::Param(_) => false,
        }
    }

    /// Smallest voxel and one past the largest, within `i32`; zero for an empty world. Of a world that was not built, the box that its
    /// operations reach over.
    pub fn bounds(&self) -> Bounds {
        let bounds = match self.loaded.unbuilt {
            Some(reach) => reach.bounds,
            None => self.loaded.world.bounds(),
        };
        bounds.map_or(NOWHERE, clamped)
    }

    /// As [`Self::bounds`]; of a streamed world, the box around a voxel with the tiles within `near`, to whole chunks.
    pub fn bounds_around(&self, cell: glam::IVec3) -> Bounds {
        let Some(streamed) = self.streamed() else { return self.bounds() };
        let near = i64::from(streamed.settings.near);
        let chunk = cell.to_array().map(|c| i64::from(c & !63));
        clamped(Bounds { min: chunk.map(|c| c - near), max: chunk.map(|c| c + 64 + near) })
    }

    /// The input that plans follow.
    pub fn input(&self) -> WorldInput<'_> {
        let size = self.bounds_around(glam::IVec3::ZERO).size();
        WorldInput {
            extent: size.map(|voxels| u32::try_from(voxels).expect("both corners are in 32 bits")),
            materials: Some(&self.materials),
        }
    }

    /// The first camera: that of the world's file, or one above a corner that sees the world whole.
    pub fn first_camera(&self) -> Camera {
        if let Some(hint) = &self.loaded.camera {
            return camera_of(hint);
        }
        if let Some(streamed) = self.streamed() {
            let top = streamed.generator.height_range().map_or(0, |[_, high]| high);
            return Camera::at([0.5, top as f64 + 8.5, 0.5]);
        }
        let Some(bounds) = self.loaded.world.bounds() else { return Camera::default() };
        let (min, max) = (bounds.min.map(|cell| cell as f64), bounds.max.map(|cell| cell as f64));
        let centre: [f64; 3] = std::array::from_fn(|axis| f64::midpoint(min[axis], max[axis]));
        let radius = (0..3).map(|axis| (max[axis] - min[axis]).powi(2)).sum::<f64>().sqrt() * 0.5;
        let distance = radius / (Camera::default().fov * 0.5).tan();
        let from = glam::DVec3::new(0.5, 0.55, 0.67).normalize() * distance;
        let mut camera = Camera::at((glam::DVec3::from_array(centre) + from).to_array());
        camera.look_at(centre);
        camera
    }

    /// Names of the file's other cameras, in its order.
    pub fn camera_names(&self) -> impl Iterator<Item = &str> {
        self.loaded.cameras.iter().map(|(name, _)| name.as_str())
    }

    /// The file's camera of that name.
    pub fn camera(&self, name: &str) -> Option<Camera> {
        self.loaded.cameras.iter().find(|(known, _)| known == name).map(|(_, hint)| camera_of(hint))
    }

    /// Its identity among all worlds.
    pub(crate) fn identity(&self) -> &Arc<WorldIdentity> {
        &self.identity
    }

    /// The world in a layout, for reading or for a copy that passes write: the words of its buffer, and the image of a layout that has
    /// one.
    pub fn encode(&self, layout: Layout, copied: bool, limits: EncodingLimits) -> EncodeResult {
        let began = Instant::now();
        let (encoded, image) = encode(&self.loaded.world, layout, copied, limits)?;
        let cost = LayoutCost {
            geometry_bytes: encoded.geometry_bytes,
            attribute_bytes: encoded.attribute_bytes,
            encode_seconds: began.elapsed().as_secs_f64(),
        };
        // A copy may be encoded more loosely than a source that is only read.
        if !copied {
            self.costs.lock().unwrap_or_else(PoisonError::into_inner).insert(layout, cost);
        }
        Ok((encoded, image))
    }

    /// The words of the buffer of `world.lights`.
    pub(crate) fn encode_lights(&self, limits: EncodingLimits) -> Result<Vec<u32>, LayoutError> {
        raxel_layouts::lights::encode(&self.loaded.world, limits)
    }

    /// Its materials; of a streamed world, or one that was not built, those that its file declares.
    pub fn palette(&self) -> &[Material] {
        self.tiles.as_ref().map_or_else(|| self.loaded.world.materials(), |tiles| tiles.materials())
    }

    /// The models that stand in it.
    pub fn instances(&self) -> &Instances {
        &self.loaded.instances
    }

    /// Whether there are any.
    pub fn has_instances(&self) -> bool {
        !self.loaded.instances.list.is_empty()
    }

    /// The same of a model of its file; `None` when it has no model of that name.
    pub(crate) fn encode_model(
        &self,
        model: &str,
        layout: Layout,
        copied: bool,
        limits: EncodingLimits,
    ) -> Option<EncodeResult> {
        let (_, voxels) = self.loaded.models.iter().find(|(name, _)| name == model)?;
        Some(encode(voxels, layout, copied, limits))
    }

    /// Names of the models of its file.
    pub(crate) fn model_names(&self) -> impl Iterator<Item = &str> {
        self.loaded.models.iter().map(|(name, _)| name.as_str())
    }

    /// The cost of encoding a layout; `None` when it never was.
    pub fn cost(&self, layout: Layout) -> Option<LayoutCost> {
        self.costs.lock().unwrap_or_else(PoisonError::into_inner).get(&layout).copied()
    }
}

impl std::fmt::Debug for SessionWorld {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SessionWorld")
            .field("path", &self.path)
            .field("name", &self.loaded.name)
            .finish_non_exhaustive()
    }
}

fn encode(world: &raxel_world::World, layout: Layout, copied: bool, limits: EncodingLimits) -> EncodeResult {
    let encoded = if copied { layout.encode_writable(world, limits) } else { layout.encode(world, limits) }?;
    Ok((encoded, layout.encode_image(world, limits)?))
}

fn camera_of(hint: &CameraHint) -> Camera {
    let mut camera = Camera::at(hint.position);
    match hint.aim {
        Aim::LookAt(target) => camera.look_at(target),
        Aim::Angles { yaw, pitch } => {
            camera.yaw = yaw.to_radians();
            camera.pitch = pitch.to_radians();
        }
    }
    if let Some(fov) = hint.fov {
        camera.fov = fov.to_radians();
    }
    camera
}

/// The box of an empty world.
pub(crate) const NOWHERE: Bounds = Bounds { min: [0; 3], max: [0; 3] };

/// The part of a box that 32 bits can hold.
fn clamped(bounds: Bounds) -> Bounds {
    let clamp = |corner: [i64; 3]| corner.map(|cell| i64::from(saturated(cell)));
    Bounds { min: clamp(bounds.min), max: clamp(bounds.max) }
}

/// The coordinate nearest to a cell that 32 bits can hold.
#[expect(clippy::cast_possible_truncation, reason = "the coordinate is clamped to 32 bits")]
pub(crate) fn saturated(cell: i64) -> i32 {
    cell.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_is_seen_whole_at_first() {
        let voxels = [[-10, 0, 5], [90, 40, 60]].map(|cell| (glam::IVec3::from_array(cell), 1));
        let materials = vec![raxel_world::Material::air(); 2];
        let mut world = SessionWorld::empty();
        world.loaded.world = raxel_world::World::from_voxels(materials, voxels);
        let camera = world.first_camera();
        let to_centre = glam::DVec3::new(40.5, 20.5, 33.0) - camera.position();
        assert!((camera.rotation() * glam::DVec3::NEG_Z).abs_diff_eq(to_centre.normalize(), 1e-6));
        assert!(to_centre.length() > 60.0);
        assert_eq!(world.bounds(), Bounds { min: [-10, 0, 5], max: [91, 41, 61] });
        assert!(world.holds(&Fact::WorldHasVoxels) && !world.holds(&Fact::WorldHasEmission));
    }
}
