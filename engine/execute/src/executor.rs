//! The executor: one running plan, two frames in flight.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use raxel_gpu::{Barrier, Buffer, Device, Image, ReadbackRing, TimelineValue};
use raxel_graph::checked::PassId;
use raxel_graph::plan::{Lifetime, Plan};

use super::FRAMES;
use super::capture::{Captured, Wanted};
use super::error::{ExecuteError, Suspect};
use super::frame::slot_of;
use super::heartbeat::Observed;
use super::lens::Lens;
use super::prepare::{Builder, Prepared};
use super::readback::ReadTicket;
use super::report::{GpuTimes, PassOutcome, PassTime, SwapReport};
use super::shared::{Running, Shared, lock};
use super::slot::FrameSlot;
use super::texel_trace::{TexelTrace, TracedTexel};
use super::thumbnails::Thumbnails;
use super::times::Times;
use super::told::Told;
use super::upload::Uploads;
use super::writers::Writers;

/// The work of an executor besides running passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExecutorOptions {
    /// Whether to skip passes whose results are still valid.
    pub memo: bool,
    /// Whether to measure the GPU time of every pass.
    pub timings: bool,
    /// Whether each pass leaves a mark when it begins and when it ends. After a loss of the device, the marks name the pass that was
    /// running.
    pub markers: bool,
    /// Longest time in which the device may finish no pass before it counts as lost.
    pub watchdog: Duration,
}

impl Default for ExecutorOptions {
    fn default() -> Self {
        Self { memo: true, timings: true, markers: true, watchdog: Duration::from_secs(10) }
    }
}

/// Runs plans on a device.
pub struct Executor {
    pub(super) shared: Arc<Shared>,
    pub(super) running: Option<Prepared>,
    /// The plan of the last frame. Its resources can be read.
    pub(super) ran: Option<Arc<Plan>>,
    pub(super) slots: [FrameSlot; FRAMES],
    /// Frames begun; rotates histories.
    pub(super) frame: u64,
    /// The next recording waits for everything before it: the barriers of the plan cover only frame after frame.
    pub(super) needs_full_barrier: bool,
    /// Passes that the last frame has dispatched.
    pub(super) dispatched: u32,
    pub(super) full: Barrier,
    pub(super) uploads: Uploads,
    /// The versions of the running plan's sources that its memo knows: index of the resource, version.
    pub(super) versions: Vec<(usize, u64)>,
    /// The running plan's copies of sources: indices of resources.
    pub(super) copies: Vec<usize>,
    pub(super) memo: bool,
    times: Times,
    pub(super) readbacks: ReadbackRing,
    /// How the debug target is shown.
    pub(super) lens: Lens,
    /// What the next frame copies of the shown resource.
    pub(super) capture: Option<Wanted>,
    /// The memory of the last copy.
    pub(super) capture_spare: Option<Arc<Buffer>>,
    pub(super) captured: Option<ReadTicket<Captured>>,
    pub(super) traced: Option<TracedTexel>,
    pub(super) trace: Option<ReadTicket<TexelTrace>>,
    pub(super) writers: Writers,
    pub(super) wants_thumbnails: bool,
    pub(super) thumbnails: Option<Thumbnails>,
    /// Reports of passes in finished frames.
    pub(super) told: Told,
    pub(super) progress: Observed,
}

/// The picture of the last frame: RGBA with 8 bits a channel, sRGB-encoded, in the image layout `GENERAL`. The next frame overwrites it,
/// after every copy that was submitted before.
#[derive(Clone, Debug)]
pub struct FramePicture {
    /// The picture, on the device.
    pub image: Arc<Image>,
    /// The device reaches this value when the picture is complete.
    pub finished: TimelineValue,
}

/// The histories of the running plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Histories {
    /// The length of the longest history, in frames.
    pub depth: u32,
    /// One of them is to be filled with its `init` before the next frame.
    pub cleared: bool,
}

/// The progress of the device on the awaited work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The device has finished.
    Done,
    /// The device is working.
    Working {
        /// The running pass, if the crash markers show it.
        pass: Option<String>,
        /// Time since the device last finished something.
        elapsed: Duration,
    },
}

impl Executor {
    /// An executor that has nothing to run yet.
    pub fn new(device: Arc<Device>, options: ExecutorOptions) -> Result<Executor, ExecuteError> {
        let slots = [FrameSlot::new(&device, 0, "even frames")?, FrameSlot::new(&device, 1, "odd frames")?];
        let shared = Arc::new(Shared::new(device, options));
        Ok(Executor {
            slots,
            uploads: Uploads::new(shared.writes.clone()),
            versions: Vec::new(),
            copies: Vec::new(),
            readbacks: ReadbackRing::new(&shared.device),
            lens: Lens::default(),
            capture: None,
            capture_spare: None,
            captured: None,
            traced: None,
            trace: None,
            writers: Writers::default(),
            wants_thumbnails: false,
            thumbnails: None,
            told: Told::default(),
            progress: Observed::from_now(&shared.device),
            shared,
            running: None,
            ran: None,
            frame: 0,
            needs_full_barrier: true,
            dispatched: 0,
            full: Barrier::full(),
            memo: options.memo,
            times: Times::default(),
        })
    }

    /// The device.
    pub fn device(&self) -> &Arc<Device> {
        &self.shared.device
    }

    /// A builder that makes plans ready to be swapped in, on any thread.
    pub fn builder(&self) -> Builder {
        Builder { shared: self.shared.clone() }
    }

    /// The running plan.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.running.as_ref().map(Prepared::plan)
    }

    /// Whether a prepared plan shares its resources with the plan that runs now. One that was prepared before the last swap may hold
    /// contents of earlier frames; it is to be prepared again.
    pub fn is_current(&self, prepared: &Prepared) -> bool {
        lock(&self.shared.running).serial == prepared.swaps_before
    }

    /// Runs another plan from the next frame on. A resource keeps its contents if both plans describe it alike. Resources of the old plan
    /// alone are destroyed when the device has finished with them.
    pub fn swap(&mut self, mut next: Prepared) -> SwapReport {
        let mut report = SwapReport::default();
        let old = self.running.as_ref();
        for (index, physical) in next.resources.iter().enumerate() {
            let before = old.and_then(|old| old.resources.iter().position(|before| Arc::ptr_eq(before, physical)));
            if let (Some(old), Some(before)) = (old, before) {
                let now = &next.plan().resources[index];
                if now.lifetime == Lifetime::Persistent && is_poisoned(old.plan(), before) {
                    // Its contents were made to be noticed, not to be kept.
                    physical.initialized.store(false, Ordering::Relaxed);
                } else {
                    next.replay.memo.carry(index, &old.replay.memo, before);
                }
                report.kept.push(physical.name.clone());
                continue;
            }
            report.created.push(physical.name.clone());
            if let Some(source) = physical.source() {
                next.replay.memo.supply(index, source.version());
            }
        }
        if let Some(old) = old {
            let gone = |name: &String| !next.resources.iter().any(|physical| physical.name == *name);
            report.dropped = old.resources.iter().map(|physical| physical.name.clone()).filter(gone).collect();
            next.replay.carry_ticks(&old.replay);
        }
        next.replay.set_memo(self.memo);
        let plan = next.plan();
        self.times = Times::of_plan(plan);
        self.told.counted.clear();
        for slot in &mut self.slots {
            slot.ran.reserve(plan.passes.len());
        }
        let mut running = lock(&self.shared.running);
        let (resources, picture) = (next.resources.clone(), Some(next.display.picture.clone()));
        *running = Running { serial: running.serial + 1, resources, picture };
        drop(running);
        self.running = Some(next);
        self.lens.swapped();
        self.thumbnails = None;
        self.writers.renew();
        self.shared.pipelines.swapped();
        self.needs_full_barrier = true;
        self.supply_sources();
        report
    }

    /// Whether passes whose results are still valid are left out.
    pub fn set_memo(&mut self, on: bool) {
        self.memo = on;
        if let Some(running) = &mut self.running {
            running.replay.set_memo(on);
        }
    }

    /// Every resource starts again at its `init` before the next frame.
    pub fn reset_history(&mut self) {
        if let Some(running) = &mut self.running {
            for physical in running.resources.iter().filter(|p| p.source().is_none()) {
                physical.initialized.store(false, Ordering::Relaxed);
                if let Some(filling) = &physical.filling {
                    filling.reset();
                }
            }
            running.replay.reset();
            self.supply_sources();
            self.needs_full_barrier = true;
        }
    }

    /// The known histories that passes write.
    pub fn histories(&self) -> Histories {
        let resources = self.running.iter().flat_map(|running| &running.resources);
        let with_history =
            resources.filter(|physical| physical.source().is_none() && physical.count() > 1 && physical.is_written());
        with_history.fold(Histories::default(), |known, physical| Histories {
            depth: known.depth.max(physical.count() - 1),
            cleared: known.cleared || physical.needs_init(),
        })
    }

    /// The picture of the last frame; `None` before the first.
    pub fn picture(&self) -> Option<FramePicture> {
        let picture = &self.running.as_ref()?.display.picture;
        let drawn = picture.initialized.load(Ordering::Relaxed);
        let finished = self.slots.iter().map(|slot| slot.commands.submitted()).max().unwrap_or_default();
        drawn.then(|| FramePicture { image: picture.image.clone(), finished })
    }

    /// Waits at most so long for the picture of the last frame to be whole.
    ///
    /// # Errors
    /// [`ExecuteError::DeviceLost`] when the device has finished nothing for as long as the watchdog allows.
    pub fn wait_picture(&mut self, at_most: Duration) -> Result<Progress, ExecuteError> {
        let finished = self.slots.iter().map(|slot| slot.commands.submitted()).max().unwrap_or_default();
        self.observe(finished, at_most)
    }

    /// Waits at most so long until the next frame can begin without waiting. Errors as for [`Self::wait_picture`].
    pub fn wait_next(&mut self, at_most: Duration) -> Result<Progress, ExecuteError> {
        self.observe(self.slots[slot_of(self.frame)].commands.submitted(), at_most)
    }

    /// Changes how long a frame may take before the device counts as lost.
    pub fn set_watchdog(&mut self, limit: Duration) {
        self.shared.set_watchdog(limit);
    }

    /// Abandons the device without waiting for its work. Nothing more can be run.
    pub fn abandon(&mut self) {
        self.shared.device.abandon();
    }

    /// Waits until the device has finished all frames.
    pub fn wait(&mut self) -> Result<(), ExecuteError> {
        let result = self.wait_at_work(self.shared.device.submitted());
        result.map_err(|error| self.attribute_loss(error.into()))
    }

    /// GPU times of the passes in the last frame that the device has finished; order of the plan's passes.
    pub fn timings(&mut self) -> &[PassTime] {
        self.gpu_times().passes
    }

    /// [`Self::timings`] with the frame that they are of, and its span.
    pub fn gpu_times(&mut self) -> GpuTimes<'_> {
        let order = if self.slots[0].frame < self.slots[1].frame { [0, 1] } else { [1, 0] };
        for slot in order {
            let finished =
                self.shared.device.reached().is_ok_and(|reached| self.slots[slot].commands.submitted() <= reached);
            if finished && self.read_times(slot).is_err() {
                break;
            }
        }
        self.times.get()
    }

    /// The outcome of each pass in the last frame; order of the plan's passes. `disabled` are the passes that are switched off.
    pub fn outcomes(&self, disabled: &[PassId]) -> Vec<PassOutcome> {
        self.running.as_ref().map(|running| running.replay.outcomes(disabled)).unwrap_or_default()
    }

    /// The next frame takes a copy of the shown resource; of a buffer, these bytes of it.
    pub fn capture_shown(&mut self, bytes: Range<u64>) {
        self.capture = Some(Wanted::Shown(bytes));
    }

    /// The next frame takes a copy of another layer or slice of the shown target, at the point of the frame where the target is shown.
    pub fn capture_part(&mut self, mip: u32, layer: u32) {
        self.capture = Some(Wanted::Part { mip, layer });
    }

    /// Frees the memory of copies: none is taken for a while.
    pub fn rest_captures(&mut self) {
        self.capture_spare = None;
    }

    /// The copy that was taken last, once.
    pub fn captured(&mut self) -> Option<ReadTicket<Captured>> {
        self.captured.take()
    }

    /// Abandons the device, and returns its loss with the pass that it works on.
    pub fn cancel(&mut self) -> ExecuteError {
        self.attribute_loss(ExecuteError::DeviceLost { suspect: None, timed_out: true })
    }

    /// Reads the times of a finished frame, if they are of the plan that runs now.
    pub(super) fn read_times(&mut self, slot: usize) -> Result<(), ExecuteError> {
        let slot = &mut self.slots[slot];
        if std::mem::replace(&mut slot.times_read, true) {
            return Ok(());
        }
        let (Some(instrumentation), Some(running)) = (&slot.instrumentation, &self.running) else { return Ok(()) };
        if !Arc::ptr_eq(&running.instrumentation, instrumentation) {
            return Ok(());
        }
        let Some(clock) = self.shared.device.capabilities().clock else { return Ok(()) };
        self.times.read(slot, instrumentation, clock)
    }

    /// Tells the memo the contents of the running plan's sources.
    pub(super) fn supply_sources(&mut self) {
        let Some(running) = &mut self.running else { return };
        self.versions.clear();
        self.copies.clear();
        for (index, physical) in running.resources.iter().enumerate() {
            if physical.filling.is_some() {
                self.copies.push(index);
            }
            if let Some(source) = physical.source() {
                let version = source.version();
                // A pass has written it, so its version does not describe its contents.
                if !physical.is_written() {
                    running.replay.memo.supply(index, version);
                }
                self.versions.push((index, version));
            }
        }
    }

    /// Adds the suspect to a device loss, and gives up a device that hangs.
    pub(super) fn attribute_loss(&self, error: ExecuteError) -> ExecuteError {
        match error {
            ExecuteError::DeviceLost { timed_out, .. } => {
                if timed_out {
                    self.shared.device.abandon();
                }
                ExecuteError::DeviceLost { suspect: self.suspect(), timed_out }
            }
            error => error,
        }
    }

    /// The pass that the device works on: the first one that has begun and not finished, in the older frame in flight, otherwise in the newer one.
    pub fn suspect(&self) -> Option<Suspect> {
        let mut slots: Vec<&FrameSlot> = self.slots.iter().collect();
        slots.sort_by_key(|slot| slot.frame);
        slots.into_iter().find_map(FrameSlot::suspect)
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        // Command buffers must not be freed while they run; those of a hung device are leaked.
        match self.wait_at_work(self.shared.device.submitted()) {
            // A trace has the last frames, too.
            Ok(()) => {
                self.timings();
            }
            Err(raxel_gpu::Error::TimedOut { .. }) => self.shared.device.abandon(),
            Err(_) => {}
        }
    }
}

/// Whether a plan fills a resource although the graph does not clear it.
fn is_poisoned(plan: &Plan, index: usize) -> bool {
    let planned = &plan.resources[index];
    planned.clear.is_some() && !plan.graph.resource(planned.resource).kind.is_cleared()
}
