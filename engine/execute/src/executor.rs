//! The executor: one running plan, two frames in flight.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use raxel_gpu::{Barrier, Device, Image, ReadbackRing, TimelineValue};
use raxel_graph::checked::PassId;
use raxel_graph::plan::{Lifetime, Plan};

use super::FRAMES;
use super::capture::{Capture, Captured};
use super::error::{ExecuteError, Suspect};
use super::heartbeat::Heartbeat;
use super::inputs::FrameInputs;
use super::lens::Lens;
use super::physical::Filling;
use super::prepare::{Builder, Prepared, display_key};
use super::readback::ReadTicket;
use super::record::{DeviceRecorder, initialize_resources};
use super::replay::Counts;
use super::report::{FrameReport, GpuTimes, PassOutcome, PassTime, SwapReport};
use super::shared::{Running, Shared, lock};
use super::slot::FrameSlot;
use super::thumbnails::{Making, Thumbnails};
use super::times::Times;
use super::told::Told;
use super::upload::Uploads;

/// What an executor does besides running passes.
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
    /// The plan of the last frame: what can be read is what it left.
    pub(super) ran: Option<Arc<Plan>>,
    pub(super) slots: [FrameSlot; FRAMES],
    /// Frames begun; rotates histories.
    pub(super) frame: u64,
    /// The next recording waits for everything before it: the barriers of the plan cover only frame after frame.
    needs_full_barrier: bool,
    /// Passes that the last frame has dispatched.
    dispatched: u32,
    full: Barrier,
    uploads: Uploads,
    /// The versions of the running plan's sources that its memo knows: index of the resource, version.
    versions: Vec<(usize, u64)>,
    /// The running plan's copies of sources: indices of resources.
    copies: Vec<usize>,
    memo: bool,
    times: Times,
    pub(super) readbacks: ReadbackRing,
    /// How the debug target is shown.
    pub(super) lens: Lens,
    /// The next frame copies what it shows; of a buffer, these bytes.
    capture: Option<Range<u64>>,
    captured: Option<ReadTicket<Captured>>,
    pub(super) wants_thumbnails: bool,
    pub(super) thumbnails: Option<Thumbnails>,
    /// What passes have told in finished frames.
    pub(super) told: Told,
    progress: Observed,
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

/// The histories of what runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Histories {
    /// How many frames back the longest goes.
    pub depth: u32,
    /// One of them is to be filled with its `init` before the next frame.
    pub cleared: bool,
}

/// How far the device has come with the awaited work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The device has finished.
    Done,
    /// The device is working.
    Working {
        /// The running pass, if the crash markers can tell.
        pass: Option<String>,
        /// Time since the device last finished something.
        elapsed: Duration,
    },
}

/// How far the device was seen to have come, and when it was first seen so.
struct Observed {
    beat: Heartbeat,
    since: Instant,
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
            captured: None,
            wants_thumbnails: false,
            thumbnails: None,
            told: Told::default(),
            progress: Observed { beat: Heartbeat::default(), since: Instant::now() },
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

    /// What makes plans ready to be swapped in, on any thread.
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
                    // What it held was made to be noticed, not to be kept.
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

    /// What is known of the histories that passes write.
    pub fn histories(&self) -> Histories {
        let resources = self.running.iter().flat_map(|running| &running.resources);
        let with_history =
            resources.filter(|physical| physical.source().is_none() && physical.count() > 1 && physical.is_written());
        with_history.fold(Histories::default(), |known, physical| Histories {
            depth: known.depth.max(physical.count() - 1),
            cleared: known.cleared || physical.needs_init(),
        })
    }

    /// Runs one frame, up to its picture. Waits for the device only when it still works on the frame before the last.
    #[expect(clippy::cast_possible_truncation, reason = "there are `FRAMES` slots, and 2⁶⁴ nanoseconds are 584 years")]
    pub fn frame(&mut self, inputs: &FrameInputs<'_>) -> Result<FrameReport, ExecuteError> {
        let number = self.frame;
        let result = self.run_frame(inputs);
        if result.is_ok() {
            self.ran = self.plan().cloned();
        }
        result.map_err(|error| {
            // Nothing was submitted: the next frame is this one.
            self.needs_full_barrier = true;
            if let Some(running) = self.running.as_mut().filter(|_| self.frame != number) {
                running.replay.undo();
                // A lost device says by its marks which pass it worked on.
                if !matches!(error, ExecuteError::DeviceLost { .. }) {
                    self.slots[(number % FRAMES as u64) as usize].undo();
                }
            }
            self.frame = number;
            self.supply_sources();
            self.attribute_loss(error)
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "there are `FRAMES` slots, and 2⁶⁴ nanoseconds are 584 years")]
    fn run_frame(&mut self, inputs: &FrameInputs<'_>) -> Result<FrameReport, ExecuteError> {
        let slot_index = (self.frame % FRAMES as u64) as usize;
        let device = self.shared.device.clone();
        self.wait_at_work(self.slots[slot_index].commands.submitted())?;
        device.collect();
        self.read_times(slot_index)?;
        self.read_told(slot_index);
        // The frame that used this slot's staging buffer last has finished.
        let uploads = self.uploads.stage(&device, slot_index)?;

        let start = Instant::now();
        let running = self.running.as_mut().ok_or(ExecuteError::NoPlan)?;
        for (index, known) in &mut self.versions {
            let version = running.resources[*index].source().map_or(*known, |source| source.version());
            if version != std::mem::replace(known, version) {
                running.replay.memo.supply(*index, version);
            }
        }
        for index in &self.copies {
            let due = running.resources[*index].filling.as_ref().and_then(Filling::due);
            running.replay.memo.fill_copy(*index, due);
        }
        let capture = match (self.capture.take(), running.display.resource) {
            (Some(bytes), Some(index)) => {
                Capture::of_shown(&device, running.plan(), &running.resources[index], &bytes)?
            }
            _ => None,
        };
        let (moves, captures) = (self.dispatched > 0, capture.is_some());
        self.lens.prepare_live(&self.shared, running)?;
        let look = self.lens.look(&device, &running.display, (captures, moves))?;
        if let Some(changes) = look.changes {
            let key = display_key(running.plan(), &look.push, changes);
            running.replay.set_display(key);
        }
        let number = self.frame;
        if self.wants_thumbnails && self.thumbnails.is_none() {
            self.thumbnails = Some(Thumbnails::new(&self.shared, running)?);
        }
        let mut making = self
            .thumbnails
            .as_mut()
            .map(|thumbnails| {
                let runs = self.memo.then(|| running.replay.memo.runs());
                thumbnails.begin(&device, runs)
            })
            .transpose()?;
        running.replay.memo.force(making.iter().flat_map(Making::forced));
        let decided = running.replay.decide(number, inputs);
        let uninitialized = running.resources.iter().any(|p| p.needs_init())
            || !running.display.picture.initialized.load(Ordering::Relaxed);
        let slot = &mut self.slots[slot_index];
        let mut report = FrameReport { frame: number, ..FrameReport::default() };
        self.frame += 1;
        if !decided && !uninitialized && !uploads {
            // The barriers of the plan reach from one recorded frame to the next only if none is left out.
            self.needs_full_barrier = true;
            self.dispatched = 0;
            count(&mut report, running.replay.walk(&mut NullRecorder));
            note_filled(running, &self.copies);
            if let Some(making) = making {
                making.submitted(&device, TimelineValue::default(), number, running.replay.memo.runs());
            }
            report.cpu_nanoseconds = start.elapsed().as_nanos() as u64;
            return Ok(report);
        }

        slot.begin(number, &running.instrumentation);
        let mut recording = slot.commands.begin()?;
        if uninitialized {
            initialize_resources(&mut recording, running);
        } else if self.needs_full_barrier {
            recording.barrier(&self.full);
        }
        running.printed.begin(&mut recording);
        self.uploads.record(&mut recording, slot_index, &running.updates);
        if let Some(timestamps) = &running.instrumentation.timestamps[slot_index] {
            recording.reset_timestamps(timestamps);
        }
        let mut recorder = DeviceRecorder {
            recording: &mut recording,
            prepared: running,
            frame: number,
            slot: slot_index,
            ran: &mut slot.ran,
            display: look.push,
            display_sets: look.sets,
            filler: look.filler,
            capture: capture.as_ref(),
            thumbnails: making.as_mut(),
            failed: None,
        };
        let counts = running.replay.walk(&mut recorder);
        if let Some(error) = recorder.failed {
            return Err(error.into());
        }
        count(&mut report, counts);
        running.counted.record(&mut recording, running, (number, slot_index), (&slot.ran, &mut slot.copied));
        slot.counted = Some(running.counted.clone());
        running.printed.record(&mut recording, slot_index, &slot.ran, &mut slot.printing);
        slot.printed = Some(running.printed.clone());
        // Nothing may fail from here on: the frame is a fact.
        let submitted = recording.submit()?;
        slot.submitted = Instant::now();
        running.printed.submitted();
        if let Some(making) = making {
            making.submitted(&device, submitted, number, running.replay.memo.runs());
        }
        if let Some(capture) = capture.filter(|_| counts.displayed) {
            self.captured = Some(capture.ticket(&device, submitted));
        }
        self.progress.since = start;
        self.uploads.submitted();
        note_filled(running, &self.copies);
        if uninitialized {
            running.resources.iter().for_each(|physical| physical.initialized.store(true, Ordering::Relaxed));
            running.display.picture.initialized.store(true, Ordering::Relaxed);
        }
        self.needs_full_barrier = !decided;
        self.dispatched = report.dispatched;
        report.cpu_nanoseconds = start.elapsed().as_nanos() as u64;
        Ok(report)
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
    #[expect(clippy::cast_possible_truncation, reason = "there are `FRAMES` slots, and 2⁶⁴ nanoseconds are 584 years")]
    pub fn wait_next(&mut self, at_most: Duration) -> Result<Progress, ExecuteError> {
        let slot = (self.frame % FRAMES as u64) as usize;
        self.observe(self.slots[slot].commands.submitted(), at_most)
    }

    fn observe(&mut self, until: TimelineValue, at_most: Duration) -> Result<Progress, ExecuteError> {
        let device = self.shared.device.clone();
        match device.wait(until, at_most) {
            Ok(()) => return Ok(Progress::Done),
            Err(raxel_gpu::Error::TimedOut { .. }) => {}
            Err(error) => return Err(self.attribute_loss(error.into())),
        }
        let beat = self.heartbeat().map_err(|error| self.attribute_loss(error.into()))?;
        // Nothing new was finished, or nothing was asked for since all was finished.
        if beat != self.progress.beat {
            self.progress = Observed { beat, since: Instant::now() };
        }
        let elapsed = self.progress.since.elapsed();
        if elapsed >= self.shared.watchdog() {
            return Err(self.attribute_loss(ExecuteError::DeviceLost { suspect: None, timed_out: true }));
        }
        Ok(Progress::Working { pass: self.suspect().map(|suspect| suspect.pass), elapsed })
    }

    /// Changes how long a frame may take before the device counts as lost.
    pub fn set_watchdog(&mut self, limit: Duration) {
        self.shared.set_watchdog(limit);
    }

    /// Gives the device up without waiting for what it works on. Nothing more can be run.
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

    /// What became of each pass in the last frame; order of the plan's passes. `disabled` are the passes that are switched off.
    pub fn outcomes(&self, disabled: &[PassId]) -> Vec<PassOutcome> {
        self.running.as_ref().map(|running| running.replay.outcomes(disabled)).unwrap_or_default()
    }

    /// The next frame takes a copy of what it shows; of a buffer, these bytes of it.
    pub fn capture_shown(&mut self, bytes: Range<u64>) {
        self.capture = Some(bytes);
    }

    /// The copy that was taken last, once.
    pub fn captured(&mut self) -> Option<ReadTicket<Captured>> {
        self.captured.take()
    }

    /// Gives the device up, and says that it is lost with the pass that it works on.
    pub fn cancel(&mut self) -> ExecuteError {
        self.attribute_loss(ExecuteError::DeviceLost { suspect: None, timed_out: true })
    }

    /// Reads the times of a finished frame, if they are of the plan that runs now.
    fn read_times(&mut self, slot: usize) -> Result<(), ExecuteError> {
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

    /// Tells the memo what the running plan's sources hold.
    fn supply_sources(&mut self) {
        let Some(running) = &mut self.running else { return };
        self.versions.clear();
        self.copies.clear();
        for (index, physical) in running.resources.iter().enumerate() {
            if physical.filling.is_some() {
                self.copies.push(index);
            }
            if let Some(source) = physical.source() {
                let version = source.version();
                // What passes made of it is not what its version says.
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

    /// The pass that the device works on: the first of the older frame in flight, or else of the newer one, that has begun and not finished.
    pub fn suspect(&self) -> Option<Suspect> {
        let mut slots: Vec<&FrameSlot> = self.slots.iter().collect();
        slots.sort_by_key(|slot| slot.frame);
        slots.into_iter().find_map(FrameSlot::suspect)
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        // Command buffers must not be freed while they run; what a hung device holds is leaked.
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

/// Copies of sources that were due have been filled, or written over in the frame before anybody looked: they are not due again.
fn note_filled(running: &Prepared, copies: &[usize]) {
    for &index in copies {
        if let (Some(filling), Some(version)) = (&running.resources[index].filling, running.replay.memo.copy_due(index))
        {
            filling.filled(version);
        }
    }
}

fn count(report: &mut FrameReport, counts: Counts) {
    report.dispatched = counts.dispatched;
    report.skipped = counts.skipped;
    report.idle = counts.idle;
    report.barriers = counts.barriers;
    report.clears = counts.clears;
    report.displayed = counts.displayed;
}

/// Records nothing.
struct NullRecorder;

impl super::replay::Recorder for NullRecorder {
    fn uniforms(&mut self, _: &[u8]) {}
    fn barrier(&mut self, _: usize) {}
    fn clear(&mut self, _: usize, _: usize) {}
    fn copy(&mut self, _: usize) {}
    fn bind(&mut self, _: usize) {}
    fn push(&mut self, _: usize, _: &[u8]) {}
    fn dispatch(&mut self, _: usize) {}
    fn present(&mut self) {}
}
