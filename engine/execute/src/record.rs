//! Records a frame into a command buffer of the device.

use raxel_gpu::{Barrier, Descriptors, Recording, vk};
use raxel_graph::plan::CopySelector;

use super::capture::Capture;
use super::device::{color, pattern};
use super::display;
use super::instrumentation::marker_word;
use super::lens::Filler;
use super::physical::{Copies, Physical};
use super::prepare::{Groups, Prepared};
use super::replay::Recorder;
use super::rotations::copy_of;
use super::texel_trace::Tracing;
use super::thumbnails::Making;

/// Records the steps of one frame.
pub(super) struct DeviceRecorder<'a, 'r, 't> {
    pub(super) recording: &'a mut Recording<'r>,
    pub(super) prepared: &'a Prepared,
    /// The number that rotates histories.
    pub(super) frame: u64,
    /// The index of the frame among the frames in flight.
    pub(super) slot: usize,
    /// Passes dispatched, in order.
    pub(super) ran: &'a mut Vec<u32>,
    /// How the debug target is shown.
    pub(super) display: display::Push,
    /// The descriptors for that, one for each copy of the debug target.
    pub(super) display_sets: &'a [Descriptors],
    /// The step that fills the reference that it is compared with.
    pub(super) filler: Option<&'a Filler>,
    /// The copy that is taken of it.
    pub(super) capture: Option<&'a Capture>,
    /// Thumbnails of the outputs of passes.
    pub(super) thumbnails: Option<&'a mut Making<'t>>,
    /// A texel that is followed.
    pub(super) tracing: Option<&'a mut Tracing>,
    /// Why the uniform blocks could not be written: then the frame must not be submitted.
    pub(super) failed: Option<raxel_gpu::Error>,
}

impl DeviceRecorder<'_, '_, '_> {
    fn rotation(&self, selector: CopySelector) -> u64 {
        self.prepared.replay.ticks.rotation(self.frame, selector)
    }

    /// Leaves a crash marker: a pass begins, or has finished.
    fn mark(&mut self, pass: usize, finished: bool) {
        let instrumentation = &self.prepared.instrumentation;
        if let Some(markers) = &instrumentation.markers {
            let offset = instrumentation.marker(self.slot, pass, finished);
            self.recording.mark(markers, offset, marker_word(self.frame), finished);
        }
    }
}

impl Recorder for DeviceRecorder<'_, '_, '_> {
    fn uniforms(&mut self, bytes: &[u8]) {
        if let Some(buffers) = &self.prepared.uniforms {
            // The frame that used this buffer last has finished.
            self.failed = buffers[self.slot].write(0, bytes).err();
        }
    }

    fn barrier(&mut self, step: usize) {
        if let Some(barrier) = &self.prepared.barriers[step] {
            self.recording.barrier(barrier);
        }
    }

    fn clear(&mut self, step: usize, resource: usize) {
        let physical = &self.prepared.resources[resource];
        let plan = self.prepared.replay.plan();
        let planned = &plan.resources[resource];
        let copy = copy_of(self.rotation(plan.selector(step, planned.resource)), 0, physical.count());
        if let Some(clear) = planned.clear {
            fill(self.recording, physical, copy, clear);
        }
    }

    fn copy(&mut self, resource: usize) {
        let physical = &self.prepared.resources[resource];
        let Some(filling) = &physical.filling else { return };
        if let (Some(from), Some(to)) = (filling.source.image(), physical.image(0)) {
            self.recording.copy_image(from, to);
        } else if let (Some(from), Some(to)) = (filling.source.buffer(), physical.buffer(0)) {
            self.recording.copy_buffer((from, 0), (to, 0), from.size().min(to.size()));
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a plan numbers its passes in 32 bits, and has a few copies of each set"
    )]
    fn bind(&mut self, pass: usize) {
        let prepared = &self.prepared.passes[pass];
        self.recording.label(&prepared.label);
        if let Some(timestamps) = &self.prepared.instrumentation.timestamps[self.slot] {
            self.recording.timestamp(timestamps, 2 * pass as u32, false);
        }
        self.mark(pass, false);
        let each = prepared.sets.len() as u64 / prepared.rotations.count();
        let set = prepared.rotations.way(|selector| self.rotation(selector)) * each + self.slot as u64 % each;
        self.recording.bind(&prepared.pipeline, &prepared.sets[set as usize]);
    }

    fn push(&mut self, pass: usize, bytes: &[u8]) {
        self.recording.push(&self.prepared.passes[pass].pipeline, bytes);
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a plan numbers its passes in 32 bits, and has a few copies of each set"
    )]
    fn dispatch(&mut self, pass: usize) {
        match &self.prepared.passes[pass].groups {
            Groups::Direct(groups) => self.recording.dispatch(*groups),
            Groups::Indirect(copies, age, selector, offset) => {
                if let Some(buffer) = copies.get(copy_of(self.rotation(*selector), *age, copies.len() as u32)) {
                    self.recording.dispatch_indirect(buffer, *offset);
                }
            }
        }
        if let Some(timestamps) = &self.prepared.instrumentation.timestamps[self.slot] {
            self.recording.timestamp(timestamps, 2 * pass as u32 + 1, true);
        }
        self.mark(pass, true);
        self.ran.push(pass as u32);
        self.recording.end_label();
        if let Some(making) = &mut self.thumbnails {
            let ticks = &self.prepared.replay.ticks;
            making.record(self.recording, self.prepared, pass, |selector| ticks.rotation(self.frame, selector));
        }
        if let Some(tracing) = &mut self.tracing {
            let ticks = &self.prepared.replay.ticks;
            tracing.record(self.recording, self.prepared, pass, |selector| ticks.rotation(self.frame, selector));
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a plan numbers its passes in 32 bits, and has a few copies of each set"
    )]
    fn present(&mut self) {
        if let Some(filler) = self.filler {
            let ticks = &self.prepared.replay.ticks;
            filler.record(self.recording, self.prepared, |selector| ticks.rotation(self.frame, selector));
        }
        let display = &self.prepared.display;
        self.recording.barrier(&display.before);
        let set = copy_of(self.rotation(display.selector), display.age, self.display_sets.len() as u32);
        self.recording.bind(&display.pipeline, &self.display_sets[set]);
        self.recording.push(&display.pipeline, bytemuck::bytes_of(&self.display));
        self.recording.dispatch(display.groups);
        self.recording.barrier(&display.after);
        if let (Some(capture), Some(index)) = (self.capture, display.resource) {
            let physical = &self.prepared.resources[index];
            capture.record(self.recording, physical.image(set), physical.buffer(set));
        }
    }
}

/// Brings new images into `GENERAL` and fills new resources with `init`. Ends with everything visible to everything.
pub(super) fn initialize_resources(recording: &mut Recording<'_>, prepared: &Prepared) {
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    let before = (all, vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE);
    let clears = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
    let mut barrier = Barrier::full();
    let uninitialized = || prepared.resources.iter().filter(|physical| physical.needs_init());
    for physical in uninitialized() {
        if let Copies::Images(images) = &physical.copies {
            barrier = images.iter().fold(barrier, |barrier, image| barrier.activate(image, before, clears));
        }
    }
    let picture = &prepared.display.picture;
    let new_picture = !picture.initialized.load(std::sync::atomic::Ordering::Relaxed);
    if new_picture {
        barrier = barrier.activate(&picture.image, before, clears);
    }
    recording.barrier(&barrier);
    for physical in uninitialized() {
        for copy in 0..physical.count() as usize {
            fill(recording, physical, copy, physical.init());
        }
    }
    if new_picture {
        recording.clear_image(&picture.image, raxel_gpu::ClearColor::Float([0.0, 0.0, 0.0, 1.0]));
    }
    recording.barrier(&Barrier::full());
}

fn fill(recording: &mut Recording<'_>, physical: &Physical, copy: usize, clear: raxel_graph::checked::Clear) {
    match &physical.copies {
        Copies::Images(images) => {
            if let Some(image) = images.get(copy) {
                recording.clear_image(image, color(clear));
            }
        }
        Copies::Buffers(buffers) => {
            if let Some(buffer) = buffers.get(copy) {
                match physical.values() {
                    Some(bytes) => recording.update_buffer(buffer, 0, bytes),
                    None => recording.fill_buffer(buffer, 0, buffer.size(), pattern(clear)),
                }
            }
        }
        Copies::Source(..) => {}
    }
}
