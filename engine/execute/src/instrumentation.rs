//! Instruments that observe the passes of a plan while they run: times, and marks that survive the loss of the device.

use std::sync::Arc;

use raxel_gpu::{Backing, Buffer, BufferInfo, Device, DeviceKind, Location, Timestamps, vk};
use raxel_graph::plan::Plan;

use super::FRAMES;
use super::error::{ExecuteError, Suspect};
use super::executor::ExecutorOptions;

/// The instruments of a plan's passes, for each frame in flight.
pub(super) struct Instrumentation {
    pub(super) plan: Arc<Plan>,
    /// Two words for each pass and frame in flight: the frame of its last begin, and the frame of its last end.
    pub(super) markers: Option<Buffer>,
    /// Two for each pass: before and after.
    pub(super) timestamps: [Option<Timestamps>; FRAMES],
}

impl Instrumentation {
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes in 32 bits")]
    pub(super) fn new(
        device: &Arc<Device>,
        options: &ExecutorOptions,
        plan: &Arc<Plan>,
    ) -> Result<Instrumentation, ExecuteError> {
        let passes = plan.passes.len() as u64;
        // On some devices, a marker would be a dependency and a fill after every pass. There, the timestamps, which exist anyway, show
        // the finished passes. A software driver runs one pass after the other, so markers cost little; and reading its timestamps would
        // wait for all work.
        let capabilities = device.capabilities();
        let timeless = capabilities.clock.is_none();
        let by_words = capabilities.buffer_markers || capabilities.kind == DeviceKind::Cpu || timeless;
        let mut timestamps = [const { None }; FRAMES];
        if options.timings || (options.markers && !by_words) {
            for pool in &mut timestamps {
                *pool = Timestamps::new(device, "pass times", 2 * passes as u32)?;
            }
        }
        let info = BufferInfo {
            size: passes * 8 * FRAMES as u64,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: Location::Download,
        };
        let wanted = options.markers && by_words && passes > 0;
        let markers = wanted.then(|| Buffer::new(device, "crash markers", &info, Backing::Own)).transpose()?;
        Ok(Instrumentation { plan: plan.clone(), markers, timestamps })
    }

    /// Byte offset of the word that a pass leaves when it begins, or when it has finished.
    pub(super) fn marker(&self, slot: usize, pass: usize, finished: bool) -> u64 {
        (((slot * self.plan.passes.len() + pass) * 2 + usize::from(finished)) * 4) as u64
    }

    /// The first of these passes, recorded in a frame, that has begun and not finished. Passes with no barrier between them run at once, and
    /// then any of them may be the one.
    pub(super) fn suspect(&self, slot: usize, frame: u64, recorded: &[u32]) -> Option<Suspect> {
        let pass = *recorded.iter().find(|pass| self.is_running(slot, **pass as usize, frame))?;
        let (graph, id) = (&self.plan.graph, self.plan.passes.get(pass as usize)?.pass);
        Some(Suspect {
            pass: graph.pass(id).name.clone(),
            declared: graph.declared_name(id).to_owned(),
            declaration: graph.declaration(id),
        })
    }

    /// The number of these passes, recorded in a frame, that have finished; 0 if this is unknown.
    pub(super) fn finished(&self, slot: usize, frame: u64, recorded: &[u32]) -> usize {
        recorded.iter().filter(|pass| self.reached(slot, **pass as usize, frame, true) == Some(true)).count()
    }

    /// Whether a pass that was recorded in a frame has begun and not finished. False where nothing is known of it.
    fn is_running(&self, slot: usize, pass: usize, frame: u64) -> bool {
        self.reached(slot, pass, frame, false) == Some(true) && self.reached(slot, pass, frame, true) == Some(false)
    }

    /// Whether a pass that was recorded in a frame has begun, or has finished; `None` where nothing is known of it.
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes in 32 bits")]
    fn reached(&self, slot: usize, pass: usize, frame: u64, finished: bool) -> Option<bool> {
        match (&self.markers, &self.timestamps[slot]) {
            (Some(markers), _) => {
                markers.word(self.marker(slot, pass, finished)).map(|word| word == marker_word(frame))
            }
            (None, Some(timestamps)) => timestamps.is_taken(2 * pass as u32 + u32::from(finished)),
            (None, None) => None,
        }
    }
}

/// The word that a pass writes when it begins and when it has finished in a frame; never 0, which is there from the beginning.
#[expect(clippy::cast_possible_truncation, reason = "the remainder is below `u32::MAX`")]
pub(super) fn marker_word(frame: u64) -> u32 {
    (frame % u64::from(u32::MAX)) as u32 + 1
}
