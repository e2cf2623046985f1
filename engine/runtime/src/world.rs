//! The world of a session: its voxels, what conditions and cameras ask about them, and the layouts that passes bind.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use raxel_diagnostics::{Diagnostic, Files, SourceMap, codes, table};
use raxel_graph::SourceLayout;
use raxel_graph::checked::{Fact, Resource};
use raxel_graph::plan::SourceSize;
use raxel_shader::format::Format;
use raxel_shader::interface::{Block, Member, Scalar, Type};
use raxel_world::file::{Aim, CameraHint, Loaded};
use raxel_world::layout::{BlockMember, EncodedImage, Layout, LayoutError, Limits};

use crate::camera::Camera;
use crate::execute;

/// What stands before a layout's name in `source = "world.tree64"`.
const PREFIX: &str = "world.";
/// The texels of a layout's image.
pub const IMAGE_FORMAT: Format = Format::R16ui;

/// A world with its encodings for the device.
pub struct SessionWorld {
    /// Project path of its file; `None` for the empty world of a session without one.
    pub path: Option<String>,
    loaded: Loaded,
    on_device: Mutex<BTreeMap<Layout, OnDevice>>,
    costs: Mutex<BTreeMap<Layout, LayoutCost>>,
}

/// A world in one layout on the device.
#[derive(Clone, Debug)]
pub struct OnDevice {
    /// The buffer that shaders know as `world`.
    pub buffer: Arc<raxel_gpu::Buffer>,
    /// The image that shaders know as `world_voxels`, of a layout that has one.
    pub image: Option<Arc<raxel_gpu::Image>>,
}

impl OnDevice {
    fn size(&self) -> SourceSize {
        SourceSize { bytes: self.buffer.size(), image: self.image.as_ref().map(|image| image.info().extent) }
    }
}

/// What it took to bring a world into a layout.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LayoutCost {
    /// Bytes that say where solid voxels are.
    pub geometry_bytes: u64,
    /// Bytes that say what they are made of.
    pub attribute_bytes: u64,
    /// Seconds of encoding, the upload not counted.
    pub encode_seconds: f64,
}

impl SessionWorld {
    /// A world without voxels.
    pub fn empty() -> Self {
        let loaded = Loaded {
            name: "empty".to_owned(),
            about: None,
            world: raxel_world::World::empty(),
            camera: None,
            cameras: Vec::new(),
            files: Vec::new(),
        };
        Self { path: None, loaded, on_device: Mutex::default(), costs: Mutex::default() }
    }

    /// Loads the world at a project path, with its warnings.
    pub fn load(
        path: &str,
        files: &dyn Files,
        texts: &mut SourceMap,
    ) -> Result<(Self, Vec<Diagnostic>), Vec<Diagnostic>> {
        let (loaded, warnings) = raxel_world::file::load(path, files, texts)?;
        Ok((
            Self { path: Some(path.to_owned()), loaded, on_device: Mutex::default(), costs: Mutex::default() },
            warnings,
        ))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.loaded.name
    }

    /// The voxels.
    pub fn voxels(&self) -> &raxel_world::World {
        &self.loaded.world
    }

    /// Whether a fact about worlds holds. Facts about params are not the world's.
    pub fn holds(&self, fact: &Fact) -> bool {
        match fact {
            Fact::WorldHasEmission => self.loaded.world.has_emission(),
            Fact::WorldHasTransparency => self.loaded.world.has_transparency(),
            Fact::WorldHasVoxels => self.loaded.world.bounds().is_some(),
            Fact::Param(_) => false,
        }
    }

    /// Smallest voxel and one past the largest, in what `i32` can hold; zero for an empty world.
    pub fn bounds(&self) -> [[i32; 3]; 2] {
        let bounds = self.loaded.world.bounds();
        bounds.map_or([[0; 3]; 2], |bounds| [bounds.min, bounds.max].map(|corner| corner.map(saturated)))
    }

    /// From where to look at it first: where its file says, else from a corner above, at a distance from which it is seen whole.
    pub fn first_camera(&self) -> Camera {
        if let Some(hint) = &self.loaded.camera {
            return camera_of(hint);
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

    /// What a source such as `world.tree64` supplies, encoded and uploaded at its first use. `resource` wants it.
    pub fn source(
        &self,
        source: &str,
        resource: &Resource,
        builder: &execute::Builder,
    ) -> Result<OnDevice, SourceError> {
        let layout =
            layout_of(source).ok_or_else(|| SourceError::Diagnosed(Box::new(unknown_source(source, resource))))?;
        let mut on_device = self.on_device.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(there) = on_device.get(&layout) {
            return Ok(there.clone());
        }
        let limits = layout_limits(builder.device());
        let refused = |error: LayoutError| SourceError::Diagnosed(Box::new(self.does_not_fit(&error, resource)));
        let began = Instant::now();
        let encoded = layout.encode(&self.loaded.world, limits).map_err(refused)?;
        let image = layout.encode_image(&self.loaded.world, limits).map_err(refused)?;
        let cost = LayoutCost {
            geometry_bytes: encoded.geometry_bytes,
            attribute_bytes: encoded.attribute_bytes,
            encode_seconds: began.elapsed().as_secs_f64(),
        };
        self.costs.lock().unwrap_or_else(PoisonError::into_inner).insert(layout, cost);
        let buffer =
            builder.upload_buffer(bytemuck::cast_slice(&encoded.words), source).map_err(SourceError::Device)?;
        let upload = |image: EncodedImage| {
            let mips: Vec<&[u8]> = image.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
            builder.upload_image(source, IMAGE_FORMAT, image.size, &mips).map_err(SourceError::Device)
        };
        let made = OnDevice { buffer, image: image.map(upload).transpose()? };
        on_device.insert(layout, made.clone());
        Ok(made)
    }

    /// What a layout took when it was encoded; `None` when it never was.
    pub fn cost(&self, layout: Layout) -> Option<LayoutCost> {
        self.costs.lock().unwrap_or_else(PoisonError::into_inner).get(&layout).copied()
    }

    /// Sizes of the layouts that are on the device, by source name.
    pub fn sizes(&self) -> BTreeMap<String, SourceSize> {
        let on_device = self.on_device.lock().unwrap_or_else(PoisonError::into_inner);
        on_device.iter().map(|(layout, made)| (source_of(*layout), made.size())).collect()
    }

    /// Forgets what is on the device, since the device is gone.
    pub fn forget_device(&self) {
        self.on_device.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    fn does_not_fit(&self, error: &LayoutError, resource: &Resource) -> Diagnostic {
        let whose = self.path.as_deref().unwrap_or("the empty world");
        Diagnostic::error(codes::session::LAYOUT_TOO_LARGE, format!("`{whose}` does not fit: {error}"))
            .label(resource.place.clone(), "for this")
            .help("build a smaller world, or bind a more compact layout (`raxel world info` compares them)")
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

/// Why a source cannot be supplied.
#[derive(Debug)]
pub enum SourceError {
    /// The author can change something about it.
    Diagnosed(Box<Diagnostic>),
    /// The device refuses.
    Device(execute::ExecuteError),
}

fn camera_of(hint: &CameraHint) -> Camera {
    let mut camera = Camera::at(hint.position);
    match hint.aim {
        Aim::LookAt(target) => camera.look_at(target),
        Aim::Angles { yaw, pitch } => {
            camera.yaw = yaw.to_radians();
            camera.pitch = pitch.to_radians().clamp(-Camera::MAX_PITCH, Camera::MAX_PITCH);
        }
    }
    if let Some(fov) = hint.fov {
        camera.fov = fov.to_radians();
    }
    camera
}

fn saturated(cell: i64) -> i32 {
    cell.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// What a device can hold of a layout.
pub fn layout_limits(device: &raxel_gpu::Device) -> Limits {
    let capabilities = device.capabilities();
    Limits {
        buffer_bytes: u64::from(capabilities.limits.max_storage_buffer_range),
        image_side: capabilities.limits.max_image_dimension3_d,
        image_bytes: execute::largest_image(device, IMAGE_FORMAT),
    }
}

/// The layout that a source such as `world.tree64` names.
pub fn layout_of(source: &str) -> Option<Layout> {
    Layout::from_name(source.strip_prefix(PREFIX)?)
}

/// The source of a layout.
pub fn source_of(layout: Layout) -> String {
    format!("{PREFIX}{}", layout.name())
}

fn unknown_source(source: &str, resource: &Resource) -> Diagnostic {
    let names: Vec<String> = Layout::ALL.iter().map(|layout| format!("{PREFIX}{}", layout.name())).collect();
    let names = || names.iter().map(String::as_str);
    let diagnostic = Diagnostic::error(codes::session::UNKNOWN_SOURCE, format!("nothing supplies `{source}`"))
        .label(resource.place.clone(), "for this buffer");
    match table::closest(source, names()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("sources: {}", table::list(names()))),
    }
}

/// What a session can supply, for the graph compiler: every layout with the block that shaders must declare.
pub fn source_layouts() -> Vec<SourceLayout> {
    Layout::ALL
        .iter()
        .map(|layout| SourceLayout {
            name: source_of(*layout),
            block: block(&layout.block()),
            image: layout.has_image().then_some(IMAGE_FORMAT),
        })
        .collect()
}

fn block(members: &[BlockMember]) -> Block {
    let sized_end = |member: &BlockMember| match member.stride {
        Some(_) => member.offset,
        None => member.offset + if member.ty == "ivec3" { 12 } else { 4 },
    };
    Block {
        name: "RxWorld".to_owned(),
        size: members.iter().map(sized_end).max().unwrap_or(0),
        members: members
            .iter()
            .map(|member| {
                let element = match member.ty {
                    "ivec3" => Type::Vector(Scalar::I32, 3),
                    "uvec4" => Type::Vector(Scalar::U32, 4),
                    _ => Type::Scalar(Scalar::U32),
                };
                Member {
                    name: member.name.to_owned(),
                    offset: member.offset,
                    ty: match member.stride {
                        Some(stride) => Type::Array { element: Box::new(element), len: None, stride },
                        None => element,
                    },
                    place: None,
                }
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layout_is_offered_with_its_runtime_array() {
        let sources = source_layouts();
        let names: Vec<String> = Layout::ALL.iter().map(|layout| format!("world.{}", layout.name())).collect();
        assert_eq!(sources.iter().map(|source| &source.name).collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        for source in sources {
            let last = source.block.members.last().unwrap();
            assert!(matches!(last.ty, Type::Array { len: None, stride: 4 | 16, .. }), "{last:?}");
            assert_eq!(source.block.size, last.offset);
        }
    }

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
        assert_eq!(world.bounds(), [[-10, 0, 5], [91, 41, 61]]);
        assert!(world.holds(&Fact::WorldHasVoxels) && !world.holds(&Fact::WorldHasEmission));
    }
}
