//! The images and buffers of a plan, shared between plans as long as their description stays the same.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use raxel_gpu::{Backing, Buffer, Device, Image, ImageView, MemoryBlock, ViewInfo, vk};
use raxel_graph::checked::{Clear, Interval, ResourceId};
use raxel_graph::plan::{BlockOffset, Lifetime, Plan, ResourceDesc, ResourcePlan};
use raxel_shader::format::Format;

use super::device::{buffer_info, image_info, vulkan_format};
use super::error::ExecuteError;
use super::fit;
use super::source::{ExternalResource, Sources};

/// All copies of one resource.
#[derive(Debug)]
pub(super) struct Physical {
    pub(super) name: String,
    desc: ResourceDesc,
    init: Clear,
    values: Option<Arc<[u8]>>,
    /// Key of the shared memory block with all its occupants, and the place in it.
    place: Option<(BlockKey, u64)>,
    pub(super) copies: Copies,
    /// The source that it is filled from, if it is a copy of one.
    pub(super) filling: Option<Filling>,
    /// Has its `init` contents, or contents of frames. Resources in shared memory have no contents to begin with.
    pub(super) initialized: AtomicBool,
    /// Some pass of some plan that it was made or taken over for writes it.
    written: AtomicBool,
}

#[derive(Debug)]
pub(super) enum Copies {
    Images(Vec<Arc<Image>>),
    Buffers(Vec<Arc<Buffer>>),
    /// Supplied from outside.
    Source(Arc<ExternalResource>, Supplied),
}

/// The source of a copy.
#[derive(Debug)]
pub(super) struct Filling {
    pub(super) source: Arc<ExternalResource>,
    /// The version that it was filled with last; 0 before the first time.
    filled: AtomicU64,
}

impl Filling {
    fn new(source: &Arc<ExternalResource>) -> Self {
        Self { source: source.clone(), filled: AtomicU64::new(0) }
    }

    /// The version to fill the copy with, if it differs from the version of the last fill.
    pub(super) fn due(&self) -> Option<u64> {
        let version = self.source.version();
        (version != self.filled.load(Ordering::Relaxed)).then_some(version)
    }

    pub(super) fn filled(&self, version: u64) {
        self.filled.store(version, Ordering::Relaxed);
    }

    /// It is to be filled again, changed or not.
    pub(super) fn reset(&self) {
        self.filled(0);
    }
}

/// The part of a source that a resource is.
#[derive(Clone, Debug)]
pub(super) enum Supplied {
    Buffer(Arc<Buffer>),
    Image(Arc<Image>),
}

/// The identity of a shared block: size, alignment, memory types, and every occupant with its offset.
type BlockKey = Arc<str>;

impl Physical {
    pub(super) fn image(&self, copy: usize) -> Option<&Arc<Image>> {
        match &self.copies {
            Copies::Images(images) => images.get(copy),
            Copies::Source(_, Supplied::Image(image)) => Some(image),
            Copies::Buffers(_) | Copies::Source(_, Supplied::Buffer(_)) => None,
        }
    }

    pub(super) fn buffer(&self, copy: usize) -> Option<&Arc<Buffer>> {
        match &self.copies {
            Copies::Images(_) | Copies::Source(_, Supplied::Image(_)) => None,
            Copies::Buffers(buffers) => buffers.get(copy),
            Copies::Source(_, Supplied::Buffer(buffer)) => Some(buffer),
        }
    }

    /// The source that supplies it from outside, if any.
    pub(super) fn source(&self) -> Option<&Arc<ExternalResource>> {
        match &self.copies {
            Copies::Source(source, _) => Some(source),
            Copies::Images(_) | Copies::Buffers(_) => None,
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a history has a few copies")]
    pub(super) fn count(&self) -> u32 {
        match &self.copies {
            Copies::Images(images) => images.len() as u32,
            Copies::Buffers(buffers) => buffers.len() as u32,
            Copies::Source(..) => 1,
        }
    }

    /// Shares memory: its contents do not outlive a frame.
    pub(super) fn is_placed(&self) -> bool {
        self.place.is_some()
    }

    pub(super) fn format(&self) -> Option<Format> {
        match &self.desc {
            ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc) => Some(desc.format),
            ResourceDesc::Buffer(_) | ResourceDesc::Source(_) => None,
        }
    }

    pub(super) fn init(&self) -> Clear {
        self.init
    }

    /// The values of a file that are written into it at creation and on reset, instead of `init`.
    pub(super) fn values(&self) -> Option<&[u8]> {
        self.values.as_deref()
    }

    /// Whether passes write it, or did so.
    pub(super) fn is_written(&self) -> bool {
        self.written.load(Ordering::Relaxed)
    }

    /// Whether frames read contents of it that were not written in the frame.
    pub(super) fn needs_init(&self) -> bool {
        !self.is_placed() && self.source().is_none() && !self.initialized.load(Ordering::Relaxed)
    }

    /// Whether it fits a plan; the contents stay. Not if no pass of that plan writes it and passes wrote it before: a pass that is off
    /// leaves its outputs at `init`. A history that passes begin to write starts over, as if it had not been there before.
    fn suits(
        &self,
        plan: &Plan,
        planned: &ResourcePlan,
        name: &str,
        place: Option<&(BlockKey, u64)>,
        written: bool,
    ) -> bool {
        self.name == name
            && self.desc == planned.desc
            && self.init == planned.init
            && self.values == values_of(plan, planned)
            && self.count() == planned.copies
            && self.place.as_ref() == place
            && (written == self.is_written() || written && planned.copies == 1)
    }
}

/// Makes the resources of a plan, in the order of `plan.resources`. Those that did not change are shared with `running`.
pub(super) fn make(
    device: &Arc<Device>,
    plan: &Plan,
    running: &[Arc<Physical>],
    sources: &Sources,
) -> Result<Vec<Arc<Physical>>, ExecuteError> {
    let keys = block_keys(plan);
    let mut blocks: HashMap<u32, Arc<MemoryBlock>> = HashMap::new();
    let mut made = Vec::with_capacity(plan.resources.len());
    for planned in &plan.resources {
        let name = &plan.graph.resource(planned.resource).name;
        let at = placed(planned);
        let place = at.map(|place| (keys[place.block as usize].clone(), place.offset));
        if let ResourceDesc::Source(source) | ResourceDesc::SourceImage(source, _) = &planned.desc {
            let written = is_written(plan, planned.resource);
            made.push(supplied(plan, name, source, planned, written, running, sources)?);
            continue;
        }
        let written = is_written(plan, planned.resource);
        let filling = match &planned.copy {
            Some(source) => Some(sources.get(name).ok_or_else(|| missing(name, source))?),
            None => None,
        };
        let suits = |old: &&Arc<Physical>| {
            old.suits(plan, planned, name, place.as_ref(), written)
                && old.filling.as_ref().map(|filling| Arc::as_ptr(&filling.source)) == filling.map(Arc::as_ptr)
        };
        if let Some(kept) = running.iter().find(suits) {
            kept.written.fetch_or(written, Ordering::Relaxed);
            made.push(kept.clone());
            continue;
        }
        let block = match at {
            None => None,
            Some(BlockOffset { block, offset }) => {
                if let Some(shared) = blocks.get(&block) {
                    Some((shared.clone(), offset))
                } else {
                    let desc = plan.blocks[block as usize];
                    let label = format!("shared block {block}");
                    let new = MemoryBlock::new(device, &label, desc.size, desc.alignment, desc.type_bits)?;
                    blocks.insert(block, new.clone());
                    Some((new, offset))
                }
            }
        };
        let backing = block.as_ref().map_or(Backing::Own, |(block, offset)| Backing::Placed(block, *offset));
        let label = |copy: u32| if planned.copies == 1 { name.clone() } else { format!("{name}, copy {copy}") };
        let copies = match &planned.desc {
            ResourceDesc::Image(desc) => {
                let info = image_info(device, desc);
                if let Some(error) = fit::image(device, name, desc)? {
                    return Err(error);
                }
                let image = |copy| Image::new(device, &label(copy), &info, backing).map(Arc::new);
                Copies::Images((0..planned.copies).map(image).collect::<Result<_, _>>()?)
            }
            ResourceDesc::Buffer(desc) => {
                let info = buffer_info(desc);
                let buffer = |copy| Buffer::new(device, &label(copy), &info, backing).map(Arc::new);
                Copies::Buffers((0..planned.copies).map(buffer).collect::<Result<_, _>>()?)
            }
            ResourceDesc::Source(_) | ResourceDesc::SourceImage(..) => continue,
        };
        made.push(Arc::new(Physical {
            name: name.clone(),
            desc: planned.desc.clone(),
            init: planned.init,
            values: values_of(plan, planned),
            place,
            copies,
            filling: filling.map(Filling::new),
            initialized: AtomicBool::new(false),
            written: AtomicBool::new(written),
        }));
    }
    Ok(made)
}

fn supplied(
    plan: &Plan,
    name: &str,
    source: &str,
    planned: &ResourcePlan,
    written: bool,
    running: &[Arc<Physical>],
    sources: &Sources,
) -> Result<Arc<Physical>, ExecuteError> {
    let missing = || missing(name, source);
    let source = sources.get(name).ok_or_else(missing)?;
    let supplied = match &planned.desc {
        ResourceDesc::SourceImage(..) => source.image().cloned().map(Supplied::Image),
        _ => source.buffer().cloned().map(Supplied::Buffer),
    };
    let supplied = supplied.ok_or_else(missing)?;
    if let (ResourceDesc::SourceImage(_, desc), Supplied::Image(image)) = (&planned.desc, &supplied)
        && desc.usage.storage
        && !image.info().usage.contains(vk::ImageUsageFlags::STORAGE)
    {
        let (target, format, usage) = (name.to_owned(), desc.format.name(), "a storage image".to_owned());
        return Err(ExecuteError::Format { target, format, usage });
    }
    let same = |old: &&Arc<Physical>| {
        old.suits(plan, planned, name, None, true) && old.source().is_some_and(|old| Arc::ptr_eq(old, source))
    };
    if let Some(kept) = running.iter().find(same) {
        kept.written.fetch_or(written, Ordering::Relaxed);
        return Ok(kept.clone());
    }
    Ok(Arc::new(Physical {
        name: name.to_owned(),
        desc: planned.desc.clone(),
        init: planned.init,
        values: None,
        place: None,
        copies: Copies::Source(source.clone(), supplied),
        filling: None,
        initialized: AtomicBool::new(true),
        written: AtomicBool::new(written),
    }))
}

fn missing(name: &str, source: &str) -> ExecuteError {
    ExecuteError::MissingSource { buffer: name.to_owned(), source_name: source.to_owned() }
}

/// The values of a file for a resource.
fn values_of(plan: &Plan, planned: &ResourcePlan) -> Option<Arc<[u8]>> {
    plan.graph.resource(planned.resource).kind.values().map(|values| values.bytes.clone())
}

/// Whether a pass that runs writes this frame's contents of a resource.
fn is_written(plan: &Plan, resource: ResourceId) -> bool {
    let mut accesses = plan.passes.iter().flat_map(|pass| &plan.graph.pass(pass.pass).accesses);
    accesses.any(|access| access.resource == resource && access.age == 0 && access.access.writes())
}

fn placed(planned: &ResourcePlan) -> Option<BlockOffset> {
    match planned.lifetime {
        Lifetime::Transient { place, .. } => place,
        Lifetime::Persistent => None,
    }
}

fn block_keys(plan: &Plan) -> Vec<BlockKey> {
    let mut keys: Vec<String> = plan.blocks.iter().map(|block| format!("{block:?}")).collect();
    for planned in &plan.resources {
        if let Some(BlockOffset { block, offset }) = placed(planned) {
            let name = &plan.graph.resource(planned.resource).name;
            let occupant = format!("; {name} at {offset}: {:?}", planned.desc);
            keys[block as usize].push_str(&occupant);
        }
    }
    keys.into_iter().map(Arc::from).collect()
}

/// A view of a part of a target, as a shader declares it.
pub(super) fn view(
    device: &Arc<Device>,
    image: &Arc<Image>,
    ty: vk::ImageViewType,
    mips: Interval,
    layers: Interval,
) -> Result<Arc<ImageView>, ExecuteError> {
    let rest = |part: Interval, all: u32| {
        if part.count == 0 { all.saturating_sub(part.first) } else { part.count }
    };
    let (first_layer, layers) = match ty {
        vk::ImageViewType::TYPE_3D => (0, 1),
        vk::ImageViewType::TYPE_2D => (layers.first, 1),
        _ => (layers.first, rest(layers, image.info().layers)),
    };
    let info = ViewInfo { ty, first_mip: mips.first, mips: rest(mips, image.info().mips), first_layer, layers };
    Ok(Arc::new(ImageView::new(device, image, &info)?))
}

/// Whether a device can sample a format with linear filtering.
pub(super) fn filters_linearly(device: &Device, format: Format) -> bool {
    device.format_features(vulkan_format(format)).contains(vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR)
}
