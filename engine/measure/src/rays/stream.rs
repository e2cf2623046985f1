//! Rays to the device and hits back, part by part, in two slots of bounded size.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use bytemuck::Zeroable;
use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, CommandBuffer, Descriptors, Device, DeviceKind, Location, Resource,
    TimelineValue, Timestamps, vk,
};
use rayon::prelude::*;

use super::error::RayError;
use super::tracer::{DeviceWorld, Tracer};
use super::words::{HitWords, RayWords, Work};

/// Rays a workgroup of `trace_rays.comp`.
const GROUP: usize = 64;
/// How long one submission should keep the device: long beside the cost of submitting, short beside any watchdog.
const BUSY: Range<f64> = 0.004..0.1;
/// Longer than any submission of rays takes that ends at all.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);

/// How many rays of a tracer are submitted at once: as many as keep the device busy for a while, found by trying.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    rays: usize,
    /// The first submission may wait for the driver's compiler: its time does not count.
    warm: bool,
}

impl Default for Pace {
    fn default() -> Self {
        Self { rays: 4096, warm: false }
    }
}

impl Pace {
    /// Learns from one submission.
    fn learn(&mut self, rays: usize, seconds: f64, capacity: usize) {
        if !self.warm {
            self.warm = true;
            return;
        }
        if seconds > BUSY.end {
            self.rays = (self.rays / 2).max(GROUP);
        } else if seconds < BUSY.start && rays == self.rays {
            self.rays = (self.rays * 4).min(capacity);
        } else if seconds < BUSY.end / 4.0 && rays == self.rays {
            self.rays = (self.rays * 2).min(capacity);
        }
    }
}

/// One part of a list of rays or tiles, traced.
#[derive(Clone, Debug)]
pub struct Traced<'a> {
    /// Which of the list.
    pub range: Range<usize>,
    /// Their hits, those of a tile one after another.
    pub hits: &'a [HitWords],
    /// How long the device took; `None` if it has no clock, and for a tracer's first part, which may wait for the driver's compiler.
    pub seconds: Option<f64>,
}

/// A part that the device has.
struct Flight {
    range: Range<usize>,
    finished_at: TimelineValue,
    slot: usize,
}

struct SlotBuffers {
    staging: Buffer,
    rays: Arc<Buffer>,
    hits: Arc<Buffer>,
    back: Buffer,
    /// The hits on the host.
    host: Vec<HitWords>,
    commands: CommandBuffer,
    timestamps: Option<Timestamps>,
}

/// Two slots for rays and hits on a device.
pub struct Stream {
    device: Arc<Device>,
    slots: [SlotBuffers; 2],
    capacity: usize,
    /// The time for one submission, after which the device counts as hung.
    patience: Duration,
}

impl Stream {
    /// Slots that suit the device.
    pub fn new(device: &Arc<Device>) -> Result<Self, RayError> {
        let software = device.capabilities().kind == DeviceKind::Cpu;
        Self::with_capacity(device, if software { 1 << 15 } else { 1 << 19 })
    }

    /// Slots of at most `capacity` rays each, 192 bytes a ray; less where the device binds or dispatches less.
    pub fn with_capacity(device: &Arc<Device>, capacity: usize) -> Result<Self, RayError> {
        let limits = &device.capabilities().limits;
        let bound = limits.max_storage_buffer_range as usize / size_of::<HitWords>();
        let dispatched = (limits.max_compute_work_group_count[0] as usize).saturating_mul(GROUP);
        let capacity = capacity.min(bound).min(dispatched).max(GROUP);
        let slots = [Self::slot(device, capacity)?, Self::slot(device, capacity)?];
        Ok(Self { device: device.clone(), slots, capacity, patience: PATIENCE })
    }

    /// The same with another time for one submission, after which the device counts as hung.
    #[must_use]
    pub(crate) fn with_patience(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    fn slot(device: &Arc<Device>, capacity: usize) -> Result<SlotBuffers, RayError> {
        let (from, to) = (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let buffer = |name: &str, stride: usize, usage, location| {
            Buffer::new(device, name, &BufferInfo { size: (capacity * stride) as u64, usage, location }, Backing::Own)
        };
        let (ray, hit) = (size_of::<RayWords>(), size_of::<HitWords>());
        Ok(SlotBuffers {
            staging: buffer("rays, staging", ray, from, Location::Upload)?,
            rays: Arc::new(buffer("rays", ray, storage | to, Location::Device)?),
            hits: Arc::new(buffer("hits", hit, storage | from | to, Location::Device)?),
            back: buffer("hits, read-back", hit, to, Location::Download)?,
            host: vec![HitWords::zeroed(); capacity],
            commands: CommandBuffer::new(device, "rays")?,
            timestamps: Timestamps::new(device, "rays", 2)?,
        })
    }

    /// Most rays that are on the device at once in one slot.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Traces a list of rays or tiles, and gives each part to `look` in order, while the device traces the part after it. The device's
    /// results are poisoned before each dispatch, so [`super::State::Unwritten`] is a hit that the tracer did not write.
    pub fn trace<W: Work, E: From<RayError>>(
        &mut self,
        tracer: &mut Tracer,
        world: &DeviceWorld,
        list: &[W],
        mut look: impl FnMut(Traced<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let bound = [self.bind(tracer, world, 0)?, self.bind(tracer, world, 1)?];
        let mut flight: Option<Flight> = None;
        let (mut next, mut slot) = (0, 0);
        loop {
            let end = list.len().min(next + (tracer.pace.rays.min(self.capacity) / W::RAYS).max(1));
            let ahead = if next < end { Some(self.submit(tracer, &bound[slot], slot, list, next..end)?) } else { None };
            (next, slot) = (end, 1 - slot);
            let Some(landing) = std::mem::replace(&mut flight, ahead) else {
                if flight.is_none() {
                    return Ok(());
                }
                continue;
            };
            let looked = self.land(tracer, landing, W::RAYS, &mut look);
            if looked.is_err() {
                // The part after it may not outlive its input. If this wait fails too, the first error has the reason.
                if let Some(flight) = &flight
                    && let Err(raxel_gpu::Error::TimedOut { .. }) = self.device.wait(flight.finished_at, self.patience)
                {
                    self.device.abandon();
                }
                return looked;
            }
        }
    }

    /// Traces a list of rays or tiles, and keeps all hits.
    pub fn trace_all<W: Work>(
        &mut self,
        tracer: &mut Tracer,
        world: &DeviceWorld,
        list: &[W],
    ) -> Result<Vec<HitWords>, RayError> {
        let mut all = Vec::with_capacity(list.len() * W::RAYS);
        self.trace(tracer, world, list, |part| {
            all.extend_from_slice(part.hits);
            Ok::<_, RayError>(())
        })?;
        Ok(all)
    }

    fn bind(&self, tracer: &Tracer, world: &DeviceWorld, slot: usize) -> Result<Descriptors, RayError> {
        let slot = &self.slots[slot];
        let resources = tracer.resources(world, &Resource::whole(&slot.rays), &Resource::whole(&slot.hits))?;
        Ok(Descriptors::new(&self.device, "rays", &tracer.pipeline, &resources)?)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a part is bounded by the buffers of a submission")]
    fn submit<W: Work>(
        &mut self,
        tracer: &Tracer,
        descriptors: &Descriptors,
        slot: usize,
        list: &[W],
        range: Range<usize>,
    ) -> Result<Flight, RayError> {
        let SlotBuffers { staging, rays: on_device, hits, back, commands, timestamps, .. } = &mut self.slots[slot];
        let part = &list[range.clone()];
        let mut words = vec![RayWords::zeroed(); part.len() * W::LINES];
        let lines = words.par_chunks_exact_mut(W::LINES).with_min_len(4096 / W::LINES);
        lines.zip(part).for_each(|(lines, work)| work.write(lines));
        let count = (part.len() * W::RAYS) as u32;
        staging.write(0, bytemuck::cast_slice(&words))?;
        let (copy, clear, compute) =
            (vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::CLEAR, vk::PipelineStageFlags2::COMPUTE_SHADER);
        let (read, write) = (vk::AccessFlags2::SHADER_STORAGE_READ, vk::AccessFlags2::SHADER_STORAGE_WRITE);
        let bytes = u64::from(count) * size_of::<HitWords>() as u64;
        let mut recording = commands.begin()?;
        recording.copy_buffer((staging, 0), (on_device, 0), size_of_val(words.as_slice()) as u64);
        recording.fill_buffer(hits, 0, bytes, HitWords::POISON);
        recording.barrier(
            &Barrier::default().memory((copy | clear, vk::AccessFlags2::TRANSFER_WRITE), (compute, read | write)),
        );
        if let Some(timestamps) = timestamps {
            recording.reset_timestamps(timestamps);
            recording.timestamp(timestamps, 0, false);
        }
        recording.bind(&tracer.pipeline, descriptors);
        recording.push(&tracer.pipeline, bytemuck::bytes_of(&count));
        recording.dispatch([count.div_ceil(GROUP as u32), 1, 1]);
        if let Some(timestamps) = timestamps {
            recording.timestamp(timestamps, 1, true);
        }
        recording.barrier(&Barrier::default().memory((compute, write), (copy, vk::AccessFlags2::TRANSFER_READ)));
        recording.copy_buffer((hits, 0), (back, 0), bytes);
        recording.barrier(&Barrier::default().memory(
            (copy, vk::AccessFlags2::TRANSFER_WRITE),
            (vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_READ),
        ));
        let finished_at = recording.submit()?;
        Ok(Flight { range, finished_at, slot })
    }

    fn land<E: From<RayError>>(
        &mut self,
        tracer: &mut Tracer,
        flight: Flight,
        rays_each: usize,
        look: &mut impl FnMut(Traced<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        if let Err(error) = self.device.wait(flight.finished_at, self.patience) {
            if matches!(error, raxel_gpu::Error::TimedOut { .. }) {
                self.device.abandon();
            }
            return Err(RayError::from(error).into());
        }
        let slot = &mut self.slots[flight.slot];
        let mut ticks = [[0; 2]; 2];
        let mut seconds = None;
        if let (Some(timestamps), Some(clock)) = (&slot.timestamps, self.device.capabilities().clock) {
            timestamps.read(&mut ticks).map_err(RayError::from)?;
            seconds = (ticks[0][1] == 1 && ticks[1][1] == 1)
                .then(|| clock.nanoseconds(ticks[0][0], ticks[1][0]).max(0.0) * 1e-9);
        }
        let count = flight.range.len() * rays_each;
        seconds = seconds.filter(|_| tracer.pace.warm);
        tracer.pace.learn(count, seconds.unwrap_or(BUSY.start), self.capacity);
        let hits = &mut slot.host[..count];
        if !slot.back.read(0, bytemuck::cast_slice_mut(hits)) {
            let size = slot.back.size();
            let name = "hits, host-visible".to_owned();
            return Err(RayError::from(raxel_gpu::Error::OutOfMemory { name, size }).into());
        }
        look(Traced { range: flight.range, hits, seconds })
    }
}
