//! Edits that passes write (`source = "world.edits"`): copied at the end of the frame that wrote them, made before the next frame but one.

use std::collections::VecDeque;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_edit::records::{self, Records};
use raxel_graph::checked::ResourceId;

use super::{FrameError, Session};
use crate::execute::{ExecuteError, PassOutcome, ReadTicket};

/// Frames from one that writes edits to the first that can show them. A frame waits for the device to have finished the frame before the
/// last in any case, so that the copy costs no further wait, and what a film shows does not depend on the time.
const FRAMES: u64 = 2;

/// What frames have written and the world does not have yet.
#[derive(Default)]
pub(super) struct Collected {
    /// Frames run.
    frames: u64,
    tickets: VecDeque<(u64, ReadTicket<Vec<u8>>)>,
    /// What was said of the last records: what goes on from frame to frame is said once.
    said: [bool; 2],
}

impl Collected {
    /// Another device, or another beginning: what is on its way is of the past.
    pub(super) fn forget(&mut self) {
        self.tickets.clear();
    }
}

impl Session {
    /// After a frame: asks for what its passes have written.
    pub(super) fn collect_edits(&mut self) -> Result<(), ExecuteError> {
        let frame = self.collected.frames;
        self.collected.frames += 1;
        let Some(resource) = self.graph.collected().next() else { return Ok(()) };
        if self.has_written(resource) {
            let ticket = self.executor.request_buffer(resource, 0, 0..records::BYTES)?;
            self.collected.tickets.push_back((frame, ticket));
        }
        Ok(())
    }

    /// Whether a pass that writes a resource was dispatched in the last frame. One that was not would have written what it did before.
    fn has_written(&self, resource: ResourceId) -> bool {
        let Some(plan) = self.executor.plan() else { return false };
        let outcomes = self.executor.outcomes(&self.disabled);
        plan.passes.iter().zip(outcomes).any(|(pass, outcome)| {
            let accesses = &plan.graph.pass(pass.pass).accesses;
            outcome == PassOutcome::Dispatched
                && accesses.iter().any(|access| access.resource == resource && access.access.writes())
        })
    }

    /// Before a frame: makes the edits that are due.
    pub(super) fn make_collected_edits(&mut self) -> Result<(), FrameError> {
        while self.collected.tickets.front().is_some_and(|(frame, _)| frame + FRAMES <= self.collected.frames) {
            let Some((_, ticket)) = self.collected.tickets.pop_front() else { break };
            match self.executor.redeem(&ticket) {
                Ok(bytes) => self.make_records(&bytes),
                Err(lost @ ExecuteError::DeviceLost { .. }) => self.recover(lost)?,
                Err(error) => return Err(FrameError::Device(error)),
            }
        }
        Ok(())
    }

    fn make_records(&mut self, bytes: &[u8]) {
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let read = Records::read(&words, self.editing.scene());
        let mut wrong = read.why.as_ref().map(|why| wrong(read.wrong, &why.to_string()));
        if !read.operations.is_empty()
            && let Err(failure) = self.edit(&read.operations)
        {
            // All of a frame at once may be too much, although each record is right.
            wrong = Some(self::wrong(read.operations.len() as u64, &failure.to_string()));
        }
        let said = std::mem::replace(&mut self.collected.said, [wrong.is_some(), read.lost > 0]);
        let lost = (read.lost > 0).then(|| lost(read.lost));
        let found = wrong.filter(|_| !said[0]).into_iter().chain(lost.filter(|_| !said[1]));
        found.for_each(|message| self.editing.say(message));
    }
}

fn wrong(count: u64, why: &str) -> Diagnostic {
    let what = if count == 1 { "an edit" } else { "edits" };
    Diagnostic::warning(codes::world::RECORD_WRONG, format!("passes have written {what} that cannot be made: {why}"))
        .note(format!("{count} in this frame"))
        .help("the world is as it was there; this is said once, until a frame writes none")
}

fn lost(count: u64) -> Diagnostic {
    let most = records::CAPACITY;
    Diagnostic::warning(
        codes::world::RECORDS_LOST,
        format!("passes have written {count} more edits than the {most} that one frame can make"),
    )
    .help("cover more voxels by each edit, as boxes and balls, or write a part of them in each frame")
}
