//! One frame: decides which passes run, records them, and submits them.

use std::sync::atomic::Ordering;
use std::time::Instant;

use raxel_gpu::{Barrier, TimelineValue};

use super::FRAMES;
use super::capture::Capture;
use super::error::ExecuteError;
use super::executor::Executor;
use super::inputs::FrameInputs;
use super::lens::Look;
use super::physical::Filling;
use super::prepare::{Prepared, display_key};
use super::record::{DeviceRecorder, initialize_resources};
use super::replay::{Counts, Recorder};
use super::report::FrameReport;
use super::slot::FrameSlot;
use super::texel_trace::Tracing;
use super::thumbnails::{Making, Thumbnails};
use super::upload::Uploads;
use super::writers::Watching;

/// The work before the passes of a frame that is recorded.
#[derive(Clone, Copy)]
enum Before<'a> {
    /// Nothing: the barriers of the plan order this frame after the last one.
    Nothing,
    /// A wait for everything recorded before.
    Wait(&'a Barrier),
    /// The `init` of resources, which waits for everything before, too.
    Init,
}

/// A frame that is decided, and is to be recorded.
struct DecidedFrame<'a, 't> {
    number: u64,
    /// Which of the frames in flight.
    slot: usize,
    running: &'a Prepared,
    before: Before<'a>,
    uploads: &'a Uploads,
    look: Look<'a>,
    capture: Option<&'a Capture>,
    making: Option<&'a mut Making<'t>>,
    tracing: Option<&'a mut Tracing>,
    watching: Option<Watching>,
}

impl Executor {
    /// Runs one frame, up to its picture. Waits for the device only when it still works on the frame before the last.
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
                // The marks of a lost device show which pass it worked on.
                if !matches!(error, ExecuteError::DeviceLost { .. }) {
                    self.slots[slot_of(number)].undo();
                }
            }
            self.frame = number;
            self.supply_sources();
            self.attribute_loss(error)
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "2⁶⁴ nanoseconds are 584 years")]
    fn run_frame(&mut self, inputs: &FrameInputs<'_>) -> Result<FrameReport, ExecuteError> {
        let number = self.frame;
        let slot = slot_of(number);
        self.free_slot(slot)?;
        let device = self.shared.device.clone();
        // The frame that used this slot's staging buffer last has finished.
        let uploads = self.uploads.stage(&device, slot)?;

        let start = Instant::now();
        self.note_sources()?;
        let capture = self.prepare_views()?;
        let mut tracing = self.begin_trace()?;
        let watching = self.writers.begin(self.running.as_ref());
        let running = self.running.as_mut().ok_or(ExecuteError::NoPlan)?;
        let moves = self.dispatched > 0;
        let look = self.lens.look(&device, &running.display, (capture.is_some(), moves))?;
        if let Some(changes) = look.changes {
            let key = display_key(running.plan(), &look.push, changes);
            running.replay.set_display(key);
        }
        let runs = self.memo.then(|| running.replay.memo.runs());
        let begun = self.thumbnails.as_mut().map(|thumbnails| thumbnails.begin(&device, runs));
        let mut making = begun.transpose()?;
        running.replay.memo.force(making.iter().flat_map(Making::forced).chain(self.writers.forced()));
        let decided = running.replay.decide(number, inputs);

        let running = &*running;
        let uninitialized = running.resources.iter().any(|physical| physical.needs_init())
            || !running.display.picture.initialized.load(Ordering::Relaxed);
        self.frame += 1;
        let (counts, submitted) = if decided || uninitialized || uploads {
            let before = match (uninitialized, self.needs_full_barrier) {
                (true, _) => Before::Init,
                (false, true) => Before::Wait(&self.full),
                (false, false) => Before::Nothing,
            };
            let (capture, making, uploads) = (capture.as_ref(), making.as_mut(), &self.uploads);
            let tracing = tracing.as_mut();
            let frame =
                DecidedFrame { number, slot, running, before, uploads, look, capture, making, tracing, watching };
            let (counts, submitted) = frame.submit(&mut self.slots[slot])?;
            self.progress.begin(&device);
            self.uploads.submitted();
            self.writers.ran(&self.slots[slot].ran);
            (counts, Some(submitted))
        } else {
            (running.replay.walk(&mut NullRecorder), None)
        };
        if let Some(making) = making {
            making.submitted(&device, submitted.unwrap_or_default(), number, running.replay.memo.runs());
        }
        if let (Some(capture), Some(submitted), true) = (capture, submitted, counts.displayed) {
            self.captured = Some(capture.ticket(&device, submitted));
        }
        self.trace = tracing.zip(submitted).and_then(|(tracing, submitted)| tracing.ticket(&device, submitted, number));
        note_filled(running, &self.copies);
        if uninitialized {
            running.resources.iter().for_each(|physical| physical.initialized.store(true, Ordering::Relaxed));
            running.display.picture.initialized.store(true, Ordering::Relaxed);
        }
        // The barriers of the plan reach from one recorded frame to the next only if none is left out.
        self.needs_full_barrier = !decided;
        self.dispatched = counts.dispatched;
        Ok(FrameReport { cpu_nanoseconds: start.elapsed().as_nanos() as u64, ..report(number, counts) })
    }

    /// Waits until the device has finished the frame that used a slot last, and reads the results of that frame.
    fn free_slot(&mut self, slot: usize) -> Result<(), ExecuteError> {
        self.wait_at_work(self.slots[slot].commands.submitted())?;
        self.shared.device.collect();
        self.read_times(slot)?;
        self.read_told(slot);
        Ok(())
    }

    /// Tells the memo which sources have changed since the last frame, and which copies of sources are due.
    fn note_sources(&mut self) -> Result<(), ExecuteError> {
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
        Ok(())
    }

    /// Prepares the views of the frame: a copy of the shown resource, a live target to compare with, thumbnails.
    fn prepare_views(&mut self) -> Result<Option<Capture>, ExecuteError> {
        let running = self.running.as_ref().ok_or(ExecuteError::NoPlan)?;
        let capture = match (self.capture.take(), running.display.resource) {
            (Some(wanted), Some(index)) => Capture::of_shown(
                &self.shared.device,
                running.plan(),
                &running.resources[index],
                &wanted,
                &mut self.capture_spare,
            )?,
            _ => None,
        };
        self.lens.prepare_live(&self.shared, running)?;
        if self.wants_thumbnails && self.thumbnails.is_none() {
            self.thumbnails = Some(Thumbnails::new(&self.shared, running)?);
        }
        Ok(capture)
    }
}

impl DecidedFrame<'_, '_> {
    /// Records the frame and hands it to the device.
    fn submit(self, slot: &mut FrameSlot) -> Result<(Counts, TimelineValue), ExecuteError> {
        let Self { number, slot: index, running, before, uploads, look, capture, making, tracing, watching } = self;
        slot.begin(number, &running.instrumentation);
        let mut recording = slot.commands.begin()?;
        match before {
            Before::Nothing => {}
            Before::Wait(barrier) => recording.barrier(barrier),
            Before::Init => initialize_resources(&mut recording, running),
        }
        running.printed.begin(&mut recording, watching.as_ref());
        uploads.record(&mut recording, index, &running.updates);
        if let Some(timestamps) = &running.instrumentation.timestamps[index] {
            recording.reset_timestamps(timestamps);
        }
        let mut recorder = DeviceRecorder {
            recording: &mut recording,
            prepared: running,
            frame: number,
            slot: index,
            ran: &mut slot.ran,
            display: look.push,
            display_sets: look.sets,
            filler: look.filler,
            capture,
            thumbnails: making,
            tracing,
            failed: None,
        };
        let counts = running.replay.walk(&mut recorder);
        if let Some(error) = recorder.failed {
            return Err(error.into());
        }
        running.counted.record(&mut recording, running, (number, index), (&slot.ran, &mut slot.copied));
        slot.counted = Some(running.counted.clone());
        running.printed.record(&mut recording, index, (&slot.ran, watching.as_ref()), &mut slot.printing);
        slot.watching = watching;
        slot.printed = Some(running.printed.clone());
        // Nothing may fail from here on: the frame is a fact.
        let submitted = recording.submit()?;
        slot.submitted = Instant::now();
        running.printed.submitted();
        Ok((counts, submitted))
    }
}

/// The index of a frame among the frames in flight.
#[expect(clippy::cast_possible_truncation, reason = "there are `FRAMES` slots")]
pub(super) fn slot_of(frame: u64) -> usize {
    (frame % FRAMES as u64) as usize
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

fn report(frame: u64, counts: Counts) -> FrameReport {
    let Counts { dispatched, skipped, idle, barriers, clears, copies: _, displayed } = counts;
    FrameReport { frame, dispatched, skipped, idle, barriers, clears, displayed, cpu_nanoseconds: 0 }
}

/// Records nothing.
struct NullRecorder;

impl Recorder for NullRecorder {
    fn uniforms(&mut self, _: &[u8]) {}
    fn barrier(&mut self, _: usize) {}
    fn clear(&mut self, _: usize, _: usize) {}
    fn copy(&mut self, _: usize) {}
    fn bind(&mut self, _: usize) {}
    fn push(&mut self, _: usize, _: &[u8]) {}
    fn dispatch(&mut self, _: usize) {}
    fn present(&mut self) {}
}
