//! Reports of passes in finished frames: the counters that the graph warns of, and their prints.

use std::sync::Arc;

use super::counters::CounterReading;
use super::executor::Executor;
use super::prints::PassPrints;

/// Reports that were read and not taken yet.
#[derive(Default)]
pub(super) struct Told {
    /// The counts of frames of the running plan in words that are warned of, in their order.
    pub(super) counted: Vec<CounterReading>,
    /// The prints of passes in finished frames, in their order.
    printed: Vec<PassPrints>,
}

impl Executor {
    /// The counts of frames that the device has finished in words that the graph warns of, since the last call; frame after frame.
    pub fn take_counted(&mut self) -> Vec<CounterReading> {
        self.read_finished();
        std::mem::take(&mut self.told.counted)
    }

    /// The prints of passes in frames that the device has finished, since the last call; frame after frame. Also the prints of a plan that
    /// no longer runs.
    pub fn take_prints(&mut self) -> Vec<PassPrints> {
        self.read_finished();
        std::mem::take(&mut self.told.printed)
    }

    /// Reads the counts and prints of finished frames.
    fn read_finished(&mut self) {
        let order = if self.slots[0].frame < self.slots[1].frame { [0, 1] } else { [1, 0] };
        for slot in order {
            let submitted = self.slots[slot].commands.submitted();
            if !self.shared.device.has_reached(submitted).unwrap_or(false) {
                break;
            }
            self.read_told(slot);
        }
    }

    /// Reads the counters of a finished frame, if they are of the running plan, and its prints. Does so once.
    pub(super) fn read_told(&mut self, slot: usize) {
        let slot = &mut self.slots[slot];
        if let (Some(counted), Some(running)) = (&slot.counted, &self.running)
            && Arc::ptr_eq(counted, &running.counted)
        {
            self.told.counted.extend(counted.read(slot.index, &slot.copied));
        }
        slot.copied.clear();
        if let Some(printed) = slot.printed.take() {
            let watching = slot.watching.take();
            self.told.printed.extend(printed.read(slot.index, slot.frame, (&slot.printing, watching.as_ref())));
        }
        slot.printing.clear();
    }
}
