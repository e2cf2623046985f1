//! The world of a session: its newest voxels, its edits, and the output of passes for it.

use std::sync::Arc;

use raxel_world::ChunkPos;

use super::changed::Changed;
use super::shader_output::ShaderOutput;
use crate::editing::{Changes, Editing};
use crate::sources::OnDevice;
use crate::world::SessionWorld;

/// A world that is edited while it is shown.
pub(super) struct WorldState {
    /// With all edits.
    pub shown: Arc<SessionWorld>,
    pub editing: Editing,
    /// Where it has changed since the last frame.
    pub changed: Changed,
    /// The output of passes for it.
    pub output: ShaderOutput,
}

/// The change of its plan that a change of the world requires.
pub(super) enum Edited {
    /// Nothing: bound resources stay.
    InPlace,
    /// To look whether another one is needed.
    Checked,
    /// Another one: other buffers, extents or names. With an error, this world is shown on.
    Replaced {
        /// The world before.
        before: Arc<SessionWorld>,
    },
}

impl WorldState {
    /// A world without changes.
    pub(crate) fn new(shown: Arc<SessionWorld>, editing: Editing) -> Self {
        Self { shown, editing, changed: Changed::new(), output: ShaderOutput::default() }
    }

    /// Makes the world after a change the one that is shown.
    pub(crate) fn change(&mut self, changes: &Changes, on_device: &OnDevice) -> Edited {
        if changes.is_empty() {
            return Edited::InPlace;
        }
        if self.shown.streamed().is_some() {
            // Its tiles have the edit already, and its size and its materials stay the same.
            let chunks: Vec<ChunkPos> = changes.iter().map(|(pos, _)| *pos).collect();
            on_device.edit_streamed(&self.shown, &chunks);
            // Coarser tiles follow, and when, is not known here.
            self.changed.everything();
            return Edited::InPlace;
        }
        self.changed.note(self.shown.voxels(), changes);
        let next = self.editing.world_after(&self.shown, changes);
        let first = !Arc::ptr_eq(self.shown.identity(), next.identity());
        let other_extent = self.shown.input().extent != next.input().extent;
        let before = std::mem::replace(&mut self.shown, next);
        let dropped = on_device.edit(&self.shown, changes);
        if first || other_extent || dropped { Edited::Replaced { before } } else { Edited::Checked }
    }

    /// There is no way from the last picture to the next one.
    pub(crate) fn cut(&mut self) {
        self.output.forget_poses();
        self.changed.everything();
    }

    /// The world was loaded again.
    pub(crate) fn replace(&mut self, world: Arc<SessionWorld>) {
        let other_instances = world.instances().list.len() != self.shown.instances().list.len();
        self.shown = world;
        self.changed.everything();
        if other_instances {
            self.output.forget_poses();
        }
    }
}
