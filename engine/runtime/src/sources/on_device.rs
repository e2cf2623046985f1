//! What is on a device of the sources. Each device has its own [`OnDevice`], so that nothing of a lost device is ever taken for
//! something of the next one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use raxel_diagnostics::table::{closest, list};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::Resource;
use raxel_graph::plan::SourceSize;
use raxel_world::layout::{EncodedImage, Layout, Limits};

use super::SourceName;
use super::catalog::VOXEL_FORMAT;
use crate::build_error::BuildError;
use crate::execute::{self, Builder, DeviceSource};
use crate::world::{SessionWorld, WorldIdentity};

/// The sources of one device. What belongs to a world goes when the world does, as soon as no plan uses it any more.
#[derive(Debug, Default)]
pub struct OnDevice {
    entries: Mutex<Vec<Entry>>,
}

#[derive(Debug)]
struct Entry {
    name: SourceName,
    world: Weak<WorldIdentity>,
    source: Arc<DeviceSource>,
}

impl OnDevice {
    /// What a name such as `world.tree64` stands for, encoded and uploaded at its first use. `resource` wants it.
    pub fn supply(
        &self,
        name: &str,
        resource: &Resource,
        world: &SessionWorld,
        builder: &Builder,
    ) -> Result<Arc<DeviceSource>, BuildError> {
        let Some(parsed) = SourceName::parse(name) else {
            return Err(BuildError::Diagnosed(vec![unknown(name, resource)]));
        };
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.retain(|entry| entry.world.strong_count() > 0);
        let known = entries.iter().find(|entry| entry.name == parsed && is_of(entry, world));
        if let Some(known) = known {
            return Ok(known.source.clone());
        }
        let source = match parsed {
            SourceName::World(layout) => upload_world(name, layout, resource, world, builder)?,
        };
        entries.push(Entry { name: parsed, world: Arc::downgrade(world.identity()), source: source.clone() });
        Ok(source)
    }

    /// Sizes of what is there of a world, by name.
    pub fn sizes(&self, world: &SessionWorld) -> BTreeMap<String, SourceSize> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let of_world = entries.iter().filter(|entry| is_of(entry, world));
        of_world.map(|entry| (entry.name.to_string(), entry.source.size())).collect()
    }

    /// What is there under a name, of a world.
    pub fn find(&self, name: &str, world: &SessionWorld) -> Option<Arc<DeviceSource>> {
        let name = SourceName::parse(name)?;
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.iter().find(|entry| entry.name == name && is_of(entry, world)).map(|entry| entry.source.clone())
    }

    /// Drops everything that no plan uses.
    pub fn clear(&self) {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

fn is_of(entry: &Entry, world: &SessionWorld) -> bool {
    std::ptr::eq(entry.world.as_ptr(), Arc::as_ptr(world.identity()))
}

fn upload_world(
    name: &str,
    layout: Layout,
    resource: &Resource,
    world: &SessionWorld,
    builder: &Builder,
) -> Result<Arc<DeviceSource>, BuildError> {
    let (encoded, image) = world.encode(layout, layout_limits(builder.device())).map_err(|error| {
        let whose = world.path.as_deref().unwrap_or("the empty world");
        let diagnostic =
            Diagnostic::error(codes::session::LAYOUT_TOO_LARGE, format!("`{whose}` does not fit: {error}"))
                .label(resource.place.clone(), "for this")
                .help("build a smaller world, or bind a more compact layout (`raxel world info` compares them)");
        BuildError::Diagnosed(vec![diagnostic])
    })?;
    let buffer = builder.upload_buffer(bytemuck::cast_slice(&encoded.words), name).map_err(BuildError::Device)?;
    let upload = |image: EncodedImage| {
        let mips: Vec<&[u8]> = image.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
        builder.upload_image(name, VOXEL_FORMAT, image.size, &mips).map_err(BuildError::Device)
    };
    let image = image.map(upload).transpose()?.map(|image| (image, VOXEL_FORMAT));
    Ok(builder.source(name, Some(buffer), image))
}

/// What a device can hold of a layout.
pub fn layout_limits(device: &raxel_gpu::Device) -> Limits {
    let capabilities = device.capabilities();
    Limits {
        buffer_bytes: u64::from(capabilities.limits.max_storage_buffer_range),
        image_side: capabilities.limits.max_image_dimension3_d,
        image_bytes: execute::largest_image(device, VOXEL_FORMAT),
    }
}

fn unknown(name: &str, resource: &Resource) -> Diagnostic {
    let names: Vec<String> = Layout::ALL.iter().map(|layout| SourceName::World(*layout).to_string()).collect();
    let names = || names.iter().map(String::as_str);
    let diagnostic = Diagnostic::error(codes::session::UNKNOWN_SOURCE, format!("nothing supplies `{name}`"))
        .label(resource.place.clone(), "for this buffer");
    match closest(name, names()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("sources: {}", list(names()))),
    }
}
