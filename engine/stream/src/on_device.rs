//! A streamed world on a device: its pool, and how frames take its publications.

mod memory;
mod messages;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use glam::{DVec3, IVec3};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_edit::{ChunkCache, EditedChunks};
use raxel_execute::{Builder, ExecuteError, ExternalResource};
use raxel_gpu::{Device, TimelineValue};
use raxel_world::{ChunkPos, ChunkProvider};
use raxel_worldfile::Streamed;

use self::memory::{Uploads, pool_memory};
use self::messages::{incomplete, stopped, too_small, too_small_on_host};
use crate::{Estimate, Missing, Publication, Stats, StreamError, StreamOptions, Streamer, StreamingRange, View};

/// The longest wait for a complete world.
const PATIENCE: Duration = Duration::from_secs(600);

/// Frames whose uploads a staging ring has room for, and its bytes.
const RING_FRAMES: u64 = 4;
const LEAST_RING: u64 = 1 << 20;
const MOST_RING: u64 = 64 << 20;

/// The next frame waits for at most this many chunks of an edit, and at most this long. So a hole dug by hand is in the very next picture.
const SMALL_EDIT: usize = 8;
const SOON: Duration = Duration::from_millis(4);

/// The part of the device's memory that a pool may take at most.
const SHARE: u64 = 2;

/// The numbers of two changes, as [`WorldStream::changed`] gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SeenChanges {
    /// The last change of all.
    pub told: u64,
    /// The last one up to which the last frame saw all of them.
    pub seen: u64,
}

/// CPU time of the world on a frame's thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThreadTime {
    /// Work.
    pub spent: Duration,
    /// How long it waited for a complete world beside that.
    pub waited: Duration,
}

/// A world that is loaded around the camera, on one device.
pub struct WorldStream {
    streamer: Streamer,
    source: Arc<ExternalResource>,
    /// The list of lamps, where a material gives off light.
    lights: Option<Arc<ExternalResource>>,
    device: Arc<Device>,
    complete: bool,
    uploads: Arc<Uploads>,
    frames: Mutex<Frames>,
}

/// The publications that frames have taken.
#[derive(Default)]
struct Frames {
    /// Its header waits to be written by the next frame.
    taken: Option<Arc<Publication>>,
    /// Versions, with the last submission before the frame that was the first to see each.
    unreleased: VecDeque<(u64, TimelineValue)>,
    /// The version that the last frame saw, and the number of the last change of chunks that is in it.
    version: u64,
    changes: u64,
    /// That publication, and the view of the last frame.
    seen: Option<(Arc<Publication>, View)>,
    /// The number of the last change of chunks.
    changed: u64,
    /// The next frame waits for it, for a short while.
    awaited: bool,
    /// Where the camera was in the last frame.
    last: Option<DVec3>,
    told: Told,
    /// The time of the last frame here, and the part of it that waited for a complete world.
    spent: Duration,
    waited: Duration,
}

/// The messages that [`WorldStream::take_message`] has returned.
#[derive(Default)]
struct Told {
    /// That chunks are missing, and not yet that they are there again.
    failing: bool,
    /// That lamps are missing.
    dark: bool,
    /// That nothing is loaded any more.
    stopped: bool,
}

/// Why a streamed world is not there.
#[derive(Debug)]
pub enum Refused {
    /// The author can do something about it.
    World(Box<Diagnostic>),
    /// The device fails.
    Device(ExecuteError),
}

impl From<ExecuteError> for Refused {
    fn from(error: ExecuteError) -> Self {
        Self::Device(error)
    }
}

/// The camera of a frame, as far as loading depends on it. Lengths are in voxels.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    /// Where it is.
    pub position: DVec3,
    /// The voxel that it is in.
    pub cell: IVec3,
    /// The direction that it looks in, of length 1.
    pub forward: DVec3,
    /// From `forward` to a corner of its picture, in radians.
    pub half_angle: f64,
}

impl Eye {
    fn view(&self, velocity: DVec3) -> View {
        View { cell: self.cell, velocity, forward: self.forward, half_angle: self.half_angle }
    }
}

impl WorldStream {
    /// Starts to load a world around a camera. When `complete`, every frame waits until everything that its camera wants is there.
    #[expect(clippy::cast_possible_truncation, reason = "a storage buffer has less than 2³² bytes")]
    pub fn new(
        (streamed, tiles): (&Streamed, &Arc<EditedChunks>),
        eye: &Eye,
        complete: bool,
        builder: &Builder,
    ) -> Result<Self, Refused> {
        let device = builder.device();
        let settings = &streamed.settings;
        let reach = streaming_range(streamed, tiles);
        let capabilities = device.capabilities();
        let there = u64::from(capabilities.limits.max_storage_buffer_range).min(capabilities.memory / SHARE);
        let bytes = settings.gpu_memory.min(there) & !15;
        let loaded = reach.loaded(complete);
        let Estimate { pool: needed, packed } = Streamer::estimate(&**tiles, &loaded, eye.cell, &ChunkCache::bytes_of);
        if needed > bytes {
            return Err(Refused::World(Box::new(too_small(streamed, needed, bytes))));
        }
        if settings.cpu_memory > 0 && packed > settings.cpu_memory {
            return Err(Refused::World(Box::new(too_small_on_host(streamed, packed))));
        }
        let ring = (RING_FRAMES * settings.upload).clamp(LEAST_RING, MOST_RING);
        let uploads = Arc::new(Uploads::default());
        let (buffer, memory) = pool_memory(device, "world.tree64", bytes, ring, &uploads)?;
        let shines = tiles.materials().iter().skip(1).any(|material| material.emission > 0.0);
        let lamps = shines.then(|| {
            let bytes = settings.lamp_memory.min(there) & !15;
            let (buffer, memory) = pool_memory(device, "world.lights", bytes, LEAST_RING, &uploads)?;
            Ok::<_, ExecuteError>((buffer, (memory, (bytes / 4) as u32)))
        });
        let (lights, lamps) = lamps.transpose()?.unzip();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let options = StreamOptions {
            workers: if settings.threads == 0 { cores.saturating_sub(1).max(1) } else { settings.threads as usize },
            complete,
            upload: Some(settings.upload),
            poison: capabilities.validated,
        };
        let source = builder.source("world.tree64", Some(buffer), None);
        let words = (bytes / 4) as u32;
        let view = eye.view(DVec3::ZERO);
        let lights = lights.map(|buffer| builder.source("world.lights", Some(buffer), None));
        let streamer = Streamer::with_lamps(tiles.clone(), (memory, words), lamps, reach, view, options);
        // A thread that has ended since is for the frames to report: how soon it ends is chance.
        if let Some(ended @ StreamError::NotStarted { .. }) = streamer.ended() {
            let diagnostic = stopped(ended).label(streamed.place.clone(), "for this world");
            return Err(Refused::World(Box::new(diagnostic)));
        }
        Ok(Self { streamer, source, lights, device: device.clone(), complete, uploads, frames: Mutex::default() })
    }

    /// The source that passes bind.
    pub fn source(&self) -> &Arc<ExternalResource> {
        &self.source
    }

    /// The list of lamps; `None` where no material gives off light.
    pub fn lights(&self) -> Option<&Arc<ExternalResource>> {
        self.lights.as_ref()
    }

    /// Reports that the source now has other voxels in these chunks.
    pub fn changed(&self, chunks: &[ChunkPos]) {
        let number = self.streamer.changed(chunks);
        let mut frames = self.frames();
        frames.changed = number;
        frames.awaited |= chunks.len() <= SMALL_EDIT;
    }

    /// Whether the last frame saw all changes passed to [`Self::changed`].
    pub fn shows_changes(&self) -> bool {
        let changes = self.changes();
        changes.seen >= changes.told
    }

    /// The changes so far, and the changes that the last frame saw.
    pub fn changes(&self) -> SeenChanges {
        let frames = self.frames();
        SeenChanges { told: frames.changed, seen: frames.changes }
    }

    /// The state of loading.
    pub fn stats(&self) -> Stats {
        self.streamer.stats()
    }

    /// Why nothing is loaded any more: one of the threads that load it cannot start or has ended. The last frames' publication stays.
    pub fn stopped(&self) -> Option<Diagnostic> {
        self.streamer.ended().map(stopped)
    }

    /// Takes the next message for the user, each given once: the source does not have some chunks; it has them again; there are more lamps
    /// than the list has room for; nothing is loaded any more.
    pub fn take_message(&self) -> Option<Diagnostic> {
        let (reason, dark) = (self.streamer.unavailable(), self.stats().unlisted > 0);
        let mut frames = self.frames();
        // A complete world reports that by the error of its frames.
        if !self.complete
            && let Some(stopped) = self.stopped()
        {
            let said = std::mem::replace(&mut frames.told.stopped, true);
            return (!said).then_some(stopped);
        }
        if dark && !frames.told.dark && !self.complete {
            frames.told.dark = true;
            let message = "there are more lamps around the camera than `lamp_memory` has room for";
            return Some(Diagnostic::warning(codes::world::STREAM_LAMPS, message).help(
                "raise `lamp_memory`; the other lamps stay visible, but only rays that hit them find their light",
            ));
        }
        let changed = reason.is_some() != frames.told.failing;
        frames.told.failing = reason.is_some();
        let message = |text: String| Diagnostic::warning(codes::world::STORE_FAILING, text);
        changed.then(|| match reason {
            Some(reason) => message(format!("chunks of the world are missing: {reason}"))
                .help("they are asked for again, and shown as soon as they are there"),
            None => message("the chunks that were missing are there".to_owned()),
        })
    }

    /// Whether everything that the camera wanted in the last frame is there.
    pub fn is_settled(&self) -> bool {
        self.streamer.is_settled()
    }

    /// Whether the missing tiles in [`Self::stats`] were counted for the camera of the last frame.
    pub fn has_looked(&self) -> bool {
        self.streamer.has_looked()
    }

    /// Tiles that the last frame should have seen, as far as they may be in its picture, and did not. `None` where its place was not looked at yet.
    pub fn missing_in_view(&self) -> Option<Missing> {
        let frames = self.frames();
        frames.seen.as_ref().and_then(|(publication, view)| publication.missing_in_view(view))
    }

    /// The publication that the last frame saw.
    pub fn version(&self) -> u64 {
        self.frames().version
    }

    /// Before a frame: follows the camera, `seconds` after the last frame, and gives the frame the newest publication. A complete world is waited for, and for at most
    /// 4 ms an edit of a few chunks; nothing else waits. Returns the version that the frame sees.
    ///
    /// # Errors
    /// The fate of the copies to the device. Words that did not arrive are never sent again. So after one error with the reason, the device
    /// counts as lost, and the world is loaded again for the next one.
    pub fn begin(&self, eye: &Eye, seconds: f64) -> Result<u64, Refused> {
        let began = Instant::now();
        self.uploads.check()?;
        let mut frames = self.frames();
        let velocity = match frames.last.replace(eye.position) {
            Some(last) if seconds > 0.0 && !self.complete => (eye.position - last) / seconds,
            _ => DVec3::ZERO,
        };
        let view = eye.view(velocity);
        self.streamer.follow(view);
        self.release(&mut frames);
        drop(frames);
        let waiting = Instant::now();
        if self.complete {
            self.wait()?;
        }
        let mut frames = self.frames();
        frames.waited = waiting.elapsed();
        if frames.taken.is_none() {
            let number = frames.changed;
            let awaited = std::mem::take(&mut frames.awaited) && frames.changes < number && !self.complete;
            drop(frames);
            let taken = if awaited { self.streamer.take_with(number, SOON) } else { self.streamer.take() };
            frames = self.frames();
            frames.taken = taken;
        }
        if let Some(publication) = &frames.taken
            && publication.version != frames.version
        {
            let lights = self.lights.as_ref().zip(publication.lights.as_ref());
            let lights = lights.map(|(source, words)| (source, bytemuck::cast_slice(words)));
            let voxels = (&self.source, bytemuck::cast_slice(publication.words()));
            let headers: Vec<(&Arc<ExternalResource>, &[u8])> = std::iter::once(voxels).chain(lights).collect();
            // Too many waiting writes: the next frame tries again.
            if ExternalResource::write_together(&headers).is_ok() {
                (frames.version, frames.changes) = (publication.version, publication.changes);
            }
        }
        if let Some(taken) = frames.taken.clone().filter(|taken| taken.version == frames.version) {
            frames.seen = Some((taken, view));
        } else if let Some((_, of)) = &mut frames.seen {
            *of = view;
        }
        frames.spent = began.elapsed().saturating_sub(frames.waited);
        Ok(frames.version)
    }

    /// After a frame that was submitted: `before` is the last submission before it.
    pub fn end(&self, before: TimelineValue) {
        let began = Instant::now();
        let mut frames = self.frames();
        let waiting = self.source.is_waiting() || self.lights.as_ref().is_some_and(|lights| lights.is_waiting());
        let seen = frames.taken.as_ref().is_some_and(|publication| publication.version == frames.version);
        if seen && !waiting {
            frames.taken = None;
            let version = frames.version;
            frames.unreleased.push_back((version, before));
        }
        self.release(&mut frames);
        frames.spent += began.elapsed();
    }

    /// CPU time of the world on the last frame's thread.
    pub fn frame_time(&self) -> ThreadTime {
        let frames = self.frames();
        ThreadTime { spent: frames.spent, waited: frames.waited }
    }

    /// Whether the next frame would see something else than the last one.
    pub fn has_news(&self) -> bool {
        self.streamer.has_pending() || self.frames().taken.is_some()
    }

    fn release(&self, frames: &mut Frames) {
        while let Some((version, before)) = frames.unreleased.front().copied() {
            if !self.device.has_reached(before).unwrap_or(false) {
                return;
            }
            self.streamer.released(version);
            frames.unreleased.pop_front();
        }
    }

    /// Waits until everything that the camera wants is there, and takes it.
    fn wait(&self) -> Result<(), Refused> {
        loop {
            let result = self.streamer.wait(PATIENCE);
            let mut frames = self.frames();
            let newer = self.streamer.take();
            let (found, failed) = (newer.is_some(), result.is_err());
            if let Some(newer) = newer {
                // A publication that was taken before and not shown is never shown.
                frames.taken = Some(newer);
            }
            match result {
                Ok(()) => return Ok(()),
                Err(StreamError::NoRoom { .. } | StreamError::TooManyLamps { .. }) if found && failed => {
                    // Earlier places hold the room: no frame needs them any more once all have finished.
                    self.device.wait_idle(PATIENCE).map_err(ExecuteError::from)?;
                    if let Some(taken) = &frames.taken {
                        self.streamer.released(taken.version);
                    }
                    self.streamer.retry();
                }
                Err(error) => return Err(Refused::World(Box::new(incomplete(&error)))),
            }
        }
    }

    fn frames(&self) -> MutexGuard<'_, Frames> {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl std::fmt::Debug for WorldStream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WorldStream").field("stats", &self.stats()).finish_non_exhaustive()
    }
}

/// The wanted tiles of a world: those of its file, and edited ones.
pub fn streaming_range(streamed: &Streamed, tiles: &EditedChunks) -> StreamingRange {
    let mut reach = StreamingRange::of(&streamed.settings, streamed.generator.height_range().unwrap_or([0, 0]));
    tiles.edited_heights().into_iter().for_each(|heights| reach.include(heights));
    reach
}
