//! The sources on a device. Each device has its own [`OnDevice`], so that nothing of a lost device is ever taken for something of the next
//! one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::{self as execute, Builder, ExecuteError, ExternalResource, FRAME_BYTES, Texture};
use raxel_graph::checked::{Fact, Graph, Origin, Resource, Value};
use raxel_graph::plan::{SourceSize, copy_name};
use raxel_graph::{FileContents, FileImage, Plays};
use raxel_layouts::{Encoded, EncodedImage, EncodingLimits, Layout, LayoutError, LiveLayout, Patch};
use raxel_stream::{Refused, WorldStream};
use raxel_timeline::inputs::Heard;
use raxel_world::{Chunk, ChunkPos};

use super::SourceName;
use super::catalog::{EDITS, POSES, VOXEL_FORMAT};
use super::check::no_model;
use super::instances::{LiveInstances, WrittenPoses};
use super::sound::Listener;
use super::video::Player;
use crate::build_error::BuildError;
use crate::world::{SessionWorld, WorldIdentity};

/// The sources of one device. Sources of a world or a file are dropped with it, as soon as no plan uses them any more.
#[derive(Debug, Default)]
pub(crate) struct OnDevice {
    entries: Mutex<Vec<Entry>>,
    /// Streamed worlds are loaded while frames run, instead of being complete before each.
    live: bool,
}

#[derive(Debug)]
struct Entry {
    key: Key,
    source: Arc<ExternalResource>,
    /// The stream that fills it, if it is a streamed world.
    stream: Option<Arc<WorldStream>>,
    /// The part that follows edits of the world, or its params.
    live: Option<Live>,
}

/// The changes that a source follows between frames.
#[derive(Debug)]
enum Live {
    Edits(Box<LiveLayout>),
    Instances(Box<LiveInstances>),
    /// The words that were written last.
    Keys([u32; 24]),
    Video(Box<Player>),
    Sound(Box<Listener>),
}

/// The origin of a source on the device.
#[derive(Clone, Debug)]
enum Key {
    /// Voxels of a world in a layout; those that fill copies apart from those that are only read.
    Voxels { name: SourceName, copied: bool, world: Weak<WorldIdentity> },
    /// The contents of a file.
    File(Weak<FileContents>),
}

impl Key {
    fn is_alive(&self) -> bool {
        match self {
            Key::Voxels { world, .. } => world.strong_count() > 0,
            Key::File(contents) => contents.strong_count() > 0,
        }
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Key::Voxels { name, copied, world },
                Key::Voxels { name: other_name, copied: other_copied, world: other_world },
            ) => (name, copied) == (other_name, other_copied) && world.ptr_eq(other_world),
            (Key::File(contents), Key::File(other)) => contents.ptr_eq(other),
            _ => false,
        }
    }
}

impl OnDevice {
    /// Nothing yet. `live`: streamed worlds are loaded while frames run.
    pub(crate) fn new(live: bool) -> Self {
        Self { live, ..Self::default() }
    }

    /// The stream of a streamed world, if a plan has bound it.
    pub(crate) fn stream(&self, world: &SessionWorld) -> Option<Arc<WorldStream>> {
        world.streamed()?;
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        // A world that was replaced by an edit of its file gives its pool and its threads back at once.
        entries.retain(|entry| entry.key.is_alive());
        let of_world = |entry: &&Entry| matches!(&entry.key, Key::Voxels { world: of, .. } if is(of, world));
        entries.iter().filter(of_world).find_map(|entry| entry.stream.clone())
    }

    /// The source of a resource, or of a copy: encoded and uploaded at its first use. `None` for a resource of the graph's own.
    pub(crate) fn supply(
        &self,
        resource: &Resource,
        world: &SessionWorld,
        builder: &Builder,
    ) -> Result<Option<Arc<ExternalResource>>, BuildError> {
        let Some(name) = resource.kind.supplied_by() else { return Ok(None) };
        let key = match &resource.origin {
            Origin::File(contents) => Key::File(Arc::downgrade(contents)),
            origin => {
                let parsed = SourceName::parse(name).ok_or_else(|| diagnosed(unknown(name, resource)))?;
                let world = Arc::downgrade(world.identity());
                Key::Voxels { name: parsed, copied: *origin == Origin::Copy, world }
            }
        };
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.retain(|entry| entry.key.is_alive());
        if let Some(known) = entries.iter().find(|entry| entry.key == key) {
            return Ok(Some(known.source.clone()));
        }
        if let (Key::Voxels { name: parsed, copied, .. }, Some(streamed)) = (&key, world.streamed().zip(world.tiles()))
            && !matches!(parsed, SourceName::Model(..) | SourceName::Instances | SourceName::Keys)
            // If nothing gives off light, the list of lamps is that of an empty world.
            && (*parsed != SourceName::Lights || *copied || world.holds(&Fact::WorldHasEmission))
        {
            if *copied || ![SourceName::World(Layout::TREE64), SourceName::Lights].contains(parsed) {
                return Err(diagnosed(needs_whole(name, *copied, resource, world)));
            }
            let camera = world.first_camera();
            let stream =
                WorldStream::new(streamed, &camera.eye(1.0), !self.live, builder).map_err(|error| match error {
                    Refused::World(diagnostic) => diagnosed(*diagnostic),
                    Refused::Device(error) => refused(error, resource),
                })?;
            // Voxels and lamps come together, whichever a plan binds first.
            let stream = Arc::new(stream);
            let of = |name| Key::Voxels { name, copied: false, world: Arc::downgrade(world.identity()) };
            let voxels = (of(SourceName::World(Layout::TREE64)), stream.source().clone());
            let lights = stream.lights().map(|lights| (of(SourceName::Lights), lights.clone()));
            for (key, source) in std::iter::once(voxels).chain(lights) {
                entries.push(Entry { key, source, stream: Some(stream.clone()), live: None });
            }
            return Ok(entries.iter().find(|entry| entry.key == key).map(|entry| entry.source.clone()));
        }
        let mut live = None;
        let source = match (&key, &resource.origin) {
            (Key::Voxels { name: parsed @ SourceName::World(layout), copied: false, .. }, _)
                if world.is_edited() && layout.follows_edits() =>
            {
                let (source, follower) = upload_live((name, parsed, *layout), resource, world, builder)?;
                live = Some(Live::Edits(Box::new(follower)));
                source
            }
            (Key::Voxels { name: SourceName::Instances, .. }, _) => {
                let (source, instances) = upload_instances(name, resource, world, builder)?;
                live = Some(Live::Instances(Box::new(instances)));
                source
            }
            (Key::Voxels { name: SourceName::Keys, copied, .. }, _) => {
                let words = [0; 24];
                live = Some(Live::Keys(words));
                let label = if *copied { copy_name(name) } else { name.to_owned() };
                let buffer = builder.upload_buffer(bytemuck::cast_slice(&words), &label);
                builder.source(name, Some(buffer.map_err(|error| refused(error, resource))?), None)
            }
            (Key::Voxels { name: parsed, copied, .. }, _) => {
                upload_voxels(name, parsed, *copied, resource, world, builder)?
            }
            (Key::File(_), Origin::File(contents)) => {
                if let FileContents::Image(FileImage { plays: Some(plays), .. }) = &**contents {
                    live = Some(match plays {
                        Plays::Video(video) => Live::Video(Box::new(Player::new(video))),
                        Plays::Sound(sound) => Live::Sound(Box::new(Listener::new(sound))),
                    });
                }
                upload_file(name, contents, resource, builder)?
            }
            (Key::File(_), _) => return Ok(None),
        };
        entries.push(Entry { key, source: source.clone(), stream: None, live });
        Ok(Some(source))
    }

    /// Follows an edit, after which the world is `world`. Encodings that can are written in place, before the next frame; the others are
    /// dropped, to be made again. True when one was dropped.
    pub(crate) fn edit(&self, world: &SessionWorld, changes: &[(ChunkPos, Option<Arc<Chunk>>)]) -> bool {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let before = entries.len();
        entries.retain_mut(|entry| match &entry.key {
            Key::Voxels { name: SourceName::Model(..) | SourceName::Instances | SourceName::Keys, .. } => true,
            Key::Voxels { world: of, .. } if is(of, world) => entry.follow(world, changes),
            _ => true,
        });
        entries.len() != before
    }

    /// Tells a streamed world on the device which of its chunks are other ones now.
    pub(crate) fn edit_streamed(&self, world: &SessionWorld, chunks: &[ChunkPos]) {
        if let Some(stream) = self.stream(world).filter(|_| !chunks.is_empty()) {
            stream.changed(chunks);
        }
    }

    /// Moves the instances of a world to where passes and the params of a graph say, before the next frame.
    pub(crate) fn move_instances(
        &self,
        world: &SessionWorld,
        graph: &Arc<Graph>,
        values: &[Value],
        written: &WrittenPoses,
    ) {
        if world.instances().list.is_empty() {
            return;
        }
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        for entry in entries.iter_mut() {
            if let (Key::Voxels { world: of, .. }, Some(Live::Instances(live))) = (&entry.key, &mut entry.live)
                && is(of, world)
            {
                live.follow(graph, values, written, &entry.source);
            }
        }
    }

    /// Tells graphs that read them which keys are held, before the next frame.
    pub(crate) fn write_keys(&self, words: [u32; 24]) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        for entry in entries.iter_mut() {
            if let Some(Live::Keys(written)) = &mut entry.live
                && *written != words
                // If too many writes wait already, the next frame tries again.
                && entry.source.write(0, bytemuck::cast_slice(&words)).is_ok()
            {
                *written = words;
            }
        }
    }

    /// Plays videos and sounds to a time, before the next frame. With `waits`, each frame is the one of its time, however long decoding
    /// takes. `microphone` is the sound that the frame hears. Returns a number that differs where other texels are shown, and messages.
    pub(crate) fn play(&self, seconds: f64, waits: bool, microphone: &Heard<'_>) -> (u64, Vec<Diagnostic>) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut shown, mut wrong) = (0_u64, Vec::new());
        for entry in entries.iter_mut().filter(|entry| entry.key.is_alive()) {
            let number = match &mut entry.live {
                Some(Live::Video(player)) => {
                    player.follow(seconds, waits, &entry.source);
                    wrong.extend(player.take_problem());
                    player.shown()
                }
                Some(Live::Sound(listener)) => {
                    listener.follow(seconds, microphone, &entry.source);
                    listener.serial()
                }
                _ => continue,
            };
            shown = shown.wrapping_mul(31).wrapping_add(number);
        }
        (shown, wrong)
    }

    /// Drops everything of a world.
    pub(crate) fn forget(&self, world: &SessionWorld) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.retain(|entry| !matches!(&entry.key, Key::Voxels { world: of, .. } if is(of, world)));
    }

    /// Sizes of a world's sources that are there, by the planner's names.
    pub(crate) fn sizes(&self, world: &SessionWorld) -> BTreeMap<String, SourceSize> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let named = |entry: &Entry| match &entry.key {
            Key::Voxels { name, copied, world: of } if is(of, world) => {
                let name = name.to_string();
                Some((if *copied { copy_name(&name) } else { name }, entry.source.size()))
            }
            _ => None,
        };
        entries.iter().filter_map(named).collect()
    }

    /// The part of a world that is there under a name, e.g. `world.tree64`.
    pub(crate) fn find(&self, name: &str, world: &SessionWorld) -> Option<Arc<ExternalResource>> {
        let wanted = SourceName::parse(name)?;
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let found = entries.iter().find(
            |entry| matches!(&entry.key, Key::Voxels { name, copied: false, world: of } if *name == wanted && is(of, world)),
        );
        found.map(|entry| entry.source.clone())
    }

    /// Drops everything that no plan uses.
    pub(crate) fn clear(&self) {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

impl Entry {
    /// Writes the changes of an edit, if that is possible before one frame.
    fn follow(&mut self, world: &SessionWorld, changes: &[(ChunkPos, Option<Arc<Chunk>>)]) -> bool {
        let Some(Live::Edits(live)) = &mut self.live else { return false };
        let Some(patches) = live.update(world.voxels(), changes.iter().cloned()) else { return false };
        // A part of an edit alone must never be in a frame: its nodes would lead to missing ones.
        let bytes: usize = patches.iter().map(|patch| 4 * patch.words.len()).sum();
        if self.source.waiting_bytes() + bytes > FRAME_BYTES {
            return false;
        }
        let write = |patch: &Patch| self.source.write(4 * patch.at as u64, bytemuck::cast_slice(&patch.words)).is_ok();
        patches.iter().all(write)
    }
}

fn is(identity: &Weak<WorldIdentity>, world: &SessionWorld) -> bool {
    std::ptr::eq(identity.as_ptr(), Arc::as_ptr(world.identity()))
}

/// The world in a buffer that follows edits.
fn upload_live(
    (name, parsed, layout): (&str, &SourceName, Layout),
    resource: &Resource,
    world: &SessionWorld,
    builder: &Builder,
) -> Result<(Arc<ExternalResource>, LiveLayout), BuildError> {
    let limits = layout_limits(builder.device());
    let (live, words) = LiveLayout::new(layout, world.voxels(), limits.buffer_bytes)
        .map_err(|error| diagnosed(too_large(&error, parsed, resource, world)))?;
    let buffer = builder.upload_buffer(bytemuck::cast_slice(&words), name).map_err(|error| refused(error, resource))?;
    Ok((builder.source(name, Some(buffer), None), live))
}

/// The instances of a world in a buffer that follows params.
fn upload_instances(
    name: &str,
    resource: &Resource,
    world: &SessionWorld,
    builder: &Builder,
) -> Result<(Arc<ExternalResource>, LiveInstances), BuildError> {
    let (live, words) = LiveInstances::new(world, layout_limits(builder.device()))
        .map_err(|error| diagnosed(too_large(&error, &SourceName::Instances, resource, world)))?;
    let buffer = builder.upload_buffer(bytemuck::cast_slice(&words), name).map_err(|error| refused(error, resource))?;
    Ok((builder.source(name, Some(buffer), None), live))
}

/// A world or a model that does not fit a layout.
fn too_large(error: &LayoutError, parsed: &SourceName, resource: &Resource, world: &SessionWorld) -> Diagnostic {
    let whose = world.path.as_deref().unwrap_or("the empty world");
    let message = match parsed {
        SourceName::Model(model, _) => format!("model `{model}` of `{whose}` does not fit: {error}"),
        _ => format!("`{whose}` does not fit: {error}"),
    };
    Diagnostic::error(codes::session::LAYOUT_TOO_LARGE, message)
        .label(resource.place.clone(), "for this")
        .help("build a smaller world, or bind a more compact layout (`raxel world info` compares them)")
}

fn upload_voxels(
    name: &str,
    parsed: &SourceName,
    copied: bool,
    resource: &Resource,
    world: &SessionWorld,
    builder: &Builder,
) -> Result<Arc<ExternalResource>, BuildError> {
    let limits = layout_limits(builder.device());
    let words = |(encoded, image): (Encoded, Option<EncodedImage>)| (encoded.words, image);
    let encoded = match parsed {
        SourceName::World(layout) => world.encode(*layout, copied, limits).map(words),
        SourceName::Lights => world.encode_lights(limits).map(|words| (words, None)),
        SourceName::Keys => Ok((vec![0; 24], None)),
        SourceName::Instances => LiveInstances::new(world, limits).map(|(_, words)| (words, None)),
        SourceName::Model(model, layout) => {
            let Some(encoded) = world.encode_model(model, *layout, copied, limits) else {
                return Err(diagnosed(no_model(model, resource, world)));
            };
            encoded.map(words)
        }
    };
    let (words, image) = encoded.map_err(|error| diagnosed(too_large(&error, parsed, resource, world)))?;
    let label = if copied { copy_name(name) } else { name.to_owned() };
    let refused = |error| refused(error, resource);
    let buffer = builder.upload_buffer(bytemuck::cast_slice(&words), &label).map_err(refused)?;
    let upload = |image: EncodedImage| {
        let mips: Vec<&[u8]> = image.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
        let texture = Texture { format: VOXEL_FORMAT, extent: image.size, volume: true };
        builder.upload_image(&label, texture, &mips).map_err(refused)
    };
    let image = image.map(upload).transpose()?.map(|image| (image, VOXEL_FORMAT));
    Ok(builder.source(name, Some(buffer), image))
}

fn upload_file(
    name: &str,
    contents: &FileContents,
    resource: &Resource,
    builder: &Builder,
) -> Result<Arc<ExternalResource>, BuildError> {
    let refused = |error| refused(error, resource);
    match contents {
        FileContents::Bytes(bytes) => {
            let buffer = builder.upload_buffer(bytes, name).map_err(refused)?;
            Ok(builder.source(name, Some(buffer), None))
        }
        FileContents::Image(FileImage { format, extent, volume, mips, plays: _ }) => {
            let mips: Vec<&[u8]> = mips.iter().map(Vec::as_slice).collect();
            let texture = Texture { format: *format, extent: *extent, volume: *volume };
            let image = builder.upload_image(name, texture, &mips).map_err(refused)?;
            Ok(builder.source(name, None, Some((image, *format))))
        }
    }
}

/// Writes all texels of an image into its source, before the next frame. False where too much waits already.
pub(super) fn write_image(image: &FileImage, source: &Arc<ExternalResource>) -> bool {
    let [width, height, depth] = image.extent;
    let side = |side: u32, mip: u32| (side >> mip).max(1);
    let mut mips = image.mips.iter().zip(0..);
    mips.all(|(bytes, mip)| {
        let depth = if image.volume { side(depth, mip) } else { 1 };
        source.write_texels(mip, [0; 3], [side(width, mip), side(height, mip), depth], bytes).is_ok()
    })
}

/// A device's limits for a layout.
pub fn layout_limits(device: &raxel_gpu::Device) -> EncodingLimits {
    let capabilities = device.capabilities();
    EncodingLimits {
        buffer_bytes: u64::from(capabilities.limits.max_storage_buffer_range),
        image_side: capabilities.limits.max_image_dimension3_d,
        image_bytes: execute::largest_image(device, VOXEL_FORMAT),
    }
}

fn needs_whole(name: &str, copied: bool, resource: &Resource, world: &SessionWorld) -> Diagnostic {
    let whose = world.path.as_deref().unwrap_or("the world");
    let message = if copied {
        format!("`{whose}` is streamed, and a streamed world cannot be copied")
    } else {
        format!("`{whose}` is streamed, and `{name}` needs the whole world")
    };
    let diagnostic = Diagnostic::error(codes::world::STREAM_LAYOUT, message).label(resource.place.clone(), "for this");
    let diagnostic = match world.streamed() {
        Some(streamed) => diagnostic.label(streamed.place.clone(), "the world is never whole in memory"),
        None => diagnostic,
    };
    diagnostic.help("bind `world.tree64`, or give the world bounds and take `[stream]` out of its file")
}

fn diagnosed(diagnostic: Diagnostic) -> BuildError {
    BuildError::Diagnosed(vec![diagnostic])
}

/// A device without room or without the format is the author's to deal with; any other error is the device's.
fn refused(error: ExecuteError, resource: &Resource) -> BuildError {
    use raxel_gpu::Error::{FormatUnsupported, OutOfMemory, TooLarge};
    match &error {
        ExecuteError::Gpu(OutOfMemory { .. } | TooLarge { .. } | FormatUnsupported { .. }) => diagnosed(
            Diagnostic::error(codes::session::DEVICE_REFUSES, error.to_string())
                .label(resource.place.clone(), "for this"),
        ),
        _ => BuildError::Device(error),
    }
}

fn unknown(name: &str, resource: &Resource) -> Diagnostic {
    let layouts = raxel_rivals::LAYOUTS.iter().map(|layout| SourceName::World(*layout));
    let names: Vec<String> = layouts
        .chain([SourceName::Lights, SourceName::Instances, SourceName::Keys])
        .map(|name| name.to_string())
        .chain([EDITS, POSES].map(str::to_owned))
        .collect();
    let names = || names.iter().map(String::as_str);
    let diagnostic = Diagnostic::error(codes::session::UNKNOWN_SOURCE, format!("nothing supplies `{name}`"))
        .label(resource.place.clone(), "for this");
    match closest(name, names()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic.help(format!("sources: {}", list(names()))),
    }
}
