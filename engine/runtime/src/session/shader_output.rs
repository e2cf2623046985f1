//! Buffers of passes that the runtime takes (`source = "world.edits"`, `source = "world.poses"`): copied at the end of the frame that wrote
//! it, taken before the next frame but one.

use std::collections::VecDeque;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_edit::records::{self, Records};
use raxel_execute::{ExecuteError, PassOutcome, ReadTicket};
use raxel_graph::checked::ResourceId;
use raxel_layouts::instances::records::{self as poses, PoseRecords};
use raxel_layouts::instances::{Frame, Instances};

use super::renderer::Renderer;
use super::world::WorldState;
use super::{FrameError, Session};
use crate::sources::{EDITS, WrittenPoses, instance_frames};

/// Frames from one that writes something to the first that can show it. A frame always waits until the device has finished the frame
/// before the last. So the copy costs no further wait, and the picture of a film does not depend on timing.
const FRAMES: u64 = 2;

/// The purpose of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Edits,
    Poses,
}

/// Edits that frames have written and the world does not have yet, and the poses that they have written so far.
#[derive(Default)]
pub(super) struct ShaderOutput {
    /// Frames run.
    frames: u64,
    tickets: VecDeque<Ticket>,
    poses: WrittenPoses,
    edits_said: Said,
    poses_said: Said,
}

/// A copy that was asked for.
struct Ticket {
    frame: u64,
    what: What,
    bytes: ReadTicket<Vec<u8>>,
}

/// Reports about the last records, that some are wrong and that some are lost: a state that lasts from frame to frame is reported once.
#[derive(Default)]
struct Said([bool; 2]);

impl ShaderOutput {
    /// Another device: records on their way are lost.
    pub(super) fn forget(&mut self) {
        self.tickets.clear();
    }

    /// Another beginning, or another graph: instances go back to where the world's file and params put them.
    pub(super) fn forget_poses(&mut self) {
        self.tickets.retain(|ticket| ticket.what != What::Poses);
        self.poses.forget();
    }

    /// After a frame: asks for the output of its passes.
    pub(super) fn request(&mut self, renderer: &mut Renderer) -> Result<(), ExecuteError> {
        let frame = self.frames;
        self.frames += 1;
        let graph = renderer.graph.clone();
        let written: Vec<ResourceId> = graph.collected().filter(|id| has_written(renderer, *id)).collect();
        for resource in written {
            let (what, bytes) = match graph.resource(resource).collected_as() {
                Some(EDITS) => (What::Edits, records::BYTES),
                _ => (What::Poses, poses::BYTES),
            };
            let bytes = renderer.executor.request_buffer(resource, 0, 0..bytes)?;
            self.tickets.push_back(Ticket { frame, what, bytes });
        }
        Ok(())
    }

    /// The next copy that is to be taken before the frame that begins.
    fn due(&mut self) -> Option<Ticket> {
        let is_due = self.tickets.front().is_some_and(|ticket| ticket.frame + FRAMES <= self.frames);
        if is_due { self.tickets.pop_front() } else { None }
    }

    /// The poses that passes have written.
    pub(super) fn poses(&self) -> &WrittenPoses {
        &self.poses
    }
}

impl Said {
    /// Messages that the records before did not have.
    fn only_new(&mut self, found: [Option<Diagnostic>; 2]) -> impl Iterator<Item = Diagnostic> + use<> {
        let before = std::mem::replace(&mut self.0, found.each_ref().map(Option::is_some));
        found.into_iter().zip(before).filter_map(|(message, said)| message.filter(|_| !said))
    }
}

impl Session {
    /// The poses of the world's instances in the last frame: by the world's file, params, and records of passes.
    pub fn instance_frames(&self) -> Vec<Frame> {
        let (instances, values) = (self.world.shown.instances(), &self.playback.params.shown);
        instance_frames(instances, &self.renderer.graph, values, self.world.output.poses())
    }

    /// Before a frame: takes the due records.
    pub(super) fn take_output(&mut self) -> Result<(), FrameError> {
        while let Some(ticket) = self.world.output.due() {
            match self.renderer.executor.redeem(&ticket.bytes) {
                Ok(bytes) => {
                    let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
                    match ticket.what {
                        What::Edits => self.make_edits(&words),
                        What::Poses => self.world.take_poses(&words),
                    }
                }
                Err(lost @ ExecuteError::DeviceLost { .. }) => self.recover(lost)?,
                Err(error) => return Err(FrameError::Device(error)),
            }
        }
        Ok(())
    }

    fn make_edits(&mut self, words: &[u32]) {
        let read = Records::read(words, self.scene());
        let mut wrong = read.why.as_ref().map(|why| edit_wrong(read.wrong, &why.to_string()));
        if !read.operations.is_empty()
            && let Err(failure) = self.edit(&read.operations)
        {
            // All of a frame at once may be too much, although each record is right.
            wrong = Some(edit_wrong(read.operations.len() as u64, &failure.to_string()));
        }
        let lost = (read.lost > 0).then(|| edits_lost(read.lost));
        let found = self.world.output.edits_said.only_new([wrong, lost]);
        found.for_each(|message| self.world.editing.say(message));
    }
}

impl WorldState {
    fn take_poses(&mut self, words: &[u32]) {
        let instances: &Instances = self.shown.instances();
        let read = PoseRecords::read(words, instances);
        let wrong = read.why.as_ref().map(|why| pose_wrong(read.wrong, &why.to_string()));
        let lost = (read.lost > 0).then(|| poses_lost(read.lost));
        self.output.poses.take(&read.poses);
        let found = self.output.poses_said.only_new([wrong, lost]);
        found.for_each(|message| self.editing.say(message));
    }
}

/// Whether a pass that writes a resource was dispatched in the last frame. One that was not would have written the same as before.
fn has_written(renderer: &Renderer, resource: ResourceId) -> bool {
    let Some(plan) = renderer.executor.plan() else { return false };
    let outcomes = renderer.executor.outcomes(&renderer.off.passes);
    plan.passes.iter().zip(outcomes).any(|(pass, outcome)| {
        let accesses = &plan.graph.pass(pass.pass).accesses;
        outcome == PassOutcome::Dispatched
            && accesses.iter().any(|access| access.resource == resource && access.access.writes())
    })
}

fn edit_wrong(count: u64, why: &str) -> Diagnostic {
    let what = if count == 1 { "an edit" } else { "edits" };
    Diagnostic::warning(codes::world::RECORD_WRONG, format!("passes have written {what} that cannot be made: {why}"))
        .note(format!("{count} in this frame"))
        .help("raxel skips such edits, and repeats this warning only after a frame without them")
}

fn edits_lost(count: u64) -> Diagnostic {
    let most = records::CAPACITY;
    Diagnostic::warning(
        codes::world::RECORDS_LOST,
        format!("passes have written {count} more edits than the {most} that one frame can make"),
    )
    .help("cover more voxels by each edit, as boxes and balls, or write a part of them in each frame")
}

fn pose_wrong(count: u64, why: &str) -> Diagnostic {
    let what = if count == 1 { "a pose that is" } else { "poses that are" };
    Diagnostic::warning(codes::world::POSE_WRONG, format!("passes have written {what} wrong: {why}"))
        .note(format!("{count} in this frame"))
        .help("raxel skips such poses, and repeats this warning only after a frame without them")
}

fn poses_lost(count: u64) -> Diagnostic {
    let most = poses::CAPACITY;
    Diagnostic::warning(
        codes::world::POSES_LOST,
        format!("passes have written {count} more poses than the {most} that one frame can take"),
    )
    .help("write one pose for each instance in a frame: a world has at most that many")
}
