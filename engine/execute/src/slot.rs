//! One of the frames in flight.

use std::sync::Arc;
use std::time::Instant;

use raxel_gpu::{CommandBuffer, Device};

use super::counters::CounterReadback;
use super::error::{ExecuteError, Suspect};
use super::instrumentation::Instrumentation;
use super::prints::PrintReadback;
use super::writers::Watching;

/// One of the frames in flight.
pub(super) struct FrameSlot {
    pub(super) index: usize,
    pub(super) commands: CommandBuffer,
    /// The frame that was recorded into it last.
    pub(super) frame: u64,
    pub(super) instrumentation: Option<Arc<Instrumentation>>,
    /// The passes that were dispatched in that frame: indices into the plan's.
    pub(super) ran: Vec<u32>,
    pub(super) times_read: bool,
    /// The words that are warned of, and which of them that frame has copied; none once they are read.
    pub(super) counted: Option<Arc<CounterReadback>>,
    pub(super) copied: Vec<u32>,
    /// The print buffer and the passes whose prints that frame has copied; none once they are read.
    pub(super) printed: Option<Arc<PrintReadback>>,
    pub(super) printing: Vec<usize>,
    /// The texel whose writes that frame has recorded.
    pub(super) watching: Option<Watching>,
    /// When it was submitted last.
    pub(super) submitted: Instant,
}

impl FrameSlot {
    pub(super) fn new(device: &Arc<Device>, index: usize, name: &str) -> Result<FrameSlot, ExecuteError> {
        Ok(FrameSlot {
            index,
            commands: CommandBuffer::new(device, name)?,
            frame: 0,
            instrumentation: None,
            ran: Vec::new(),
            times_read: true,
            counted: None,
            copied: Vec::new(),
            printed: None,
            printing: Vec::new(),
            watching: None,
            submitted: Instant::now(),
        })
    }

    /// Begins a frame in it, whose passes are watched.
    pub(super) fn begin(&mut self, frame: u64, instrumentation: &Arc<Instrumentation>) {
        self.ran.clear();
        self.frame = frame;
        self.instrumentation = Some(instrumentation.clone());
        self.times_read = false;
    }

    /// The frame was never submitted: there is nothing to be read of it.
    pub(super) fn undo(&mut self) {
        self.ran.clear();
        self.copied.clear();
        self.printing.clear();
        self.watching = None;
        self.times_read = true;
    }

    /// The number of passes of its frame that the device has finished, by its marks.
    pub(super) fn finished(&self) -> usize {
        self.instrumentation.as_ref().map_or(0, |of| of.finished(self.index, self.frame, &self.ran))
    }

    /// The pass of its frame that the device works on.
    pub(super) fn suspect(&self) -> Option<Suspect> {
        self.instrumentation.as_ref()?.suspect(self.index, self.frame, &self.ran)
    }
}
