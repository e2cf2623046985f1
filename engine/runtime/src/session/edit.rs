//! Editing the world of a session, and asking about its newest voxels.

use std::collections::BTreeMap;

use raxel_diagnostics::{Diagnostic, SourceMap, codes};
use raxel_edit::query::{CastHit, cast};
use raxel_edit::{Change, EditError, Operation, Scene, Steps};
use raxel_ray::Ray;
use raxel_ray::camera::Pinhole;
use raxel_world::Unavailable;

use super::world::Edited;
use super::{FrameError, Session};
use crate::build_error::BuildError;
use crate::builtins;
use crate::editing::{Changes, Editing};

/// Why an edit was not made, undone or redone. The world and the steps that can be undone have not changed. After an edit that was too
/// large, nothing can be redone.
#[derive(Debug, thiserror::Error)]
pub enum EditFailure {
    /// The edit is invalid, or covers too much.
    #[error(transparent)]
    Refused(#[from] EditError),
    /// The device has no room for the edited world.
    #[error("{}", .diagnostics.first().map_or_else(String::new, |first| first.message.clone()))]
    TooLarge {
        /// The refusals of the device, one diagnostic for each buffer.
        diagnostics: Vec<Diagnostic>,
    },
}

impl EditFailure {
    /// The failure as diagnostics without a place in a file.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        match self {
            Self::Refused(EditError::Unavailable(reason)) => {
                vec![Diagnostic::error(codes::world::STORE_FAILING, format!("the edit was not made: {reason}"))]
            }
            Self::Refused(error) => vec![Diagnostic::error(codes::world::EDIT, error.to_string())],
            Self::TooLarge { diagnostics } => diagnostics,
        }
    }
}

impl Session {
    /// Edits the world before the next frame: applies the operations in order, as one step of undo. Returns the number of chunks that
    /// changed. raxel saves the edit if the world has a save and [`super::Options::saves`] allows it.
    pub fn edit(&mut self, operations: &[Operation]) -> Result<usize, EditFailure> {
        let change = self.world.editing.apply(operations)?;
        let changed = self.show_edit(operations, &change, Editing::take_back)?;
        if let Some(take) = self.playback.take.as_mut().filter(|_| changed > 0) {
            take.recorder.edited(operations, self.world.editing.scene());
        }
        Ok(changed)
    }

    /// Undoes the newest step. Returns `false` if there is none.
    pub fn undo(&mut self) -> Result<bool, EditFailure> {
        let Some(change) = self.world.editing.undo().map_err(EditError::from)? else { return Ok(false) };
        self.show_step(&change, Editing::redo)
    }

    /// Redoes the step that was undone last. Returns `false` if there is none, or if an edit came after the undo.
    pub fn redo(&mut self) -> Result<bool, EditFailure> {
        let Some(change) = self.world.editing.redo().map_err(EditError::from)? else { return Ok(false) };
        self.show_step(&change, Editing::undo)
    }

    /// How many steps can be undone and redone.
    pub fn edit_steps(&self) -> Steps {
        self.world.editing.steps()
    }

    /// The materials and models that edits can use.
    pub fn scene(&self) -> &Scene {
        self.world.editing.scene()
    }

    /// Returns the first solid voxel along a ray, exactly, in the newest voxels, or `None` if there is none within `reach` voxels.
    ///
    /// # Errors
    /// If the ray meets an unavailable chunk before a voxel.
    pub fn cast(&self, ray: &Ray, reach: f64) -> Result<Option<CastHit>, Unavailable> {
        cast(self.world.shown.newest(), ray, reach)
    }

    /// As [`Session::cast`], along the camera's ray through a pixel of the window, counted from the top left.
    ///
    /// # Errors
    /// As [`Session::cast`].
    pub fn pick(&self, pixel: [i32; 2], reach: f64) -> Result<Option<CastHit>, Unavailable> {
        let output = self.viewport().output();
        let pixel = self.viewport().to_output(pixel);
        let inside: [u32; 2] =
            std::array::from_fn(|i| u32::try_from(pixel[i]).unwrap_or(0).min(output[i].saturating_sub(1)));
        let view = &self.playback.view;
        let camera = builtins::of(&view.camera, &view.previous, output, &self.world.shown);
        let pinhole = Pinhole {
            cell: camera.camera_cell.into(),
            frac: camera.camera_frac.into(),
            view_to_world: glam::Mat4::from_cols_array_2d(&camera.camera_view_to_world),
            tan_half_fov: camera.camera_tan_half_fov.into(),
        };
        self.cast(&pinhole.ray(inside, output), reach)
    }

    /// Counts the voxels of a box by material, in the newest voxels.
    ///
    /// # Errors
    /// As [`raxel_edit::query::histogram`]. Also if a chunk of the box is unavailable.
    pub fn region(&self, bounds: &raxel_world::Bounds) -> Result<BTreeMap<u16, u64>, EditError> {
        raxel_edit::query::histogram(self.world.shown.newest(), bounds)
    }

    /// Returns the messages since the last call. Their places point into [`Session::texts`]. They report:
    ///
    /// * that edits cannot be saved, or are saved again,
    /// * invalid edits and poses that passes wrote,
    /// * chunks that a store does not give, or gives again,
    /// * counters that the graph warns of,
    /// * failed assertions of shaders.
    pub fn take_messages(&mut self) -> Vec<Diagnostic> {
        self.say_reports();
        self.world.editing.take_messages()
    }

    /// Writes all edits of the save into a checkpoint, and waits until it is on the disk.
    pub fn checkpoint(&mut self) {
        self.world.editing.checkpoint();
    }

    /// Shows and saves a change. If there is no room for it, `reverse` takes it out of the edits again.
    fn show_edit(
        &mut self,
        operations: &[Operation],
        change: &Change,
        reverse: fn(&mut Editing) -> Result<Option<Change>, Unavailable>,
    ) -> Result<usize, EditFailure> {
        match self.show(&change.after().collect()) {
            Ok(()) => {
                if !change.chunks.is_empty() {
                    self.world.editing.commit(operations, change);
                }
                Ok(change.chunks.len())
            }
            Err(error) => {
                // The chunks were available for the change. If they are not available now, the step stays, and can be undone.
                let _ = reverse(&mut self.world.editing);
                Err(EditFailure::TooLarge { diagnostics: error.into_diagnostics() })
            }
        }
    }

    /// Shows a step that was undone or made again.
    fn show_step(
        &mut self,
        change: &Change,
        reverse: fn(&mut Editing) -> Result<Option<Change>, Unavailable>,
    ) -> Result<bool, EditFailure> {
        let put = [change.as_put()];
        self.show_edit(&put, change, reverse)?;
        if let Some(take) = &mut self.playback.take {
            take.recorder.edited(&put, self.world.editing.scene());
        }
        Ok(true)
    }

    /// Brings the demo's edits to a time.
    pub(super) fn follow_edits(&mut self, time: f64) -> Result<(), FrameError> {
        let refused = |diagnostics| FrameError::Plan { diagnostics, texts: Box::new(SourceMap::default()) };
        let followed = self.world.editing.follow_script(time);
        for changes in followed.steps {
            self.show(&changes).map_err(|error| refused(error.into_diagnostics()))?;
        }
        match followed.unavailable {
            // A film without an edit of its demo would be wrong without a word.
            Some(unavailable) if self.options.step.is_some() => {
                Err(refused(EditFailure::from(EditError::from(unavailable)).into_diagnostics()))
            }
            unavailable => {
                self.world.editing.say_waiting(unavailable.as_ref());
                Ok(())
            }
        }
    }

    /// Makes the world after a change the one that is shown. With an error, the one before is shown on.
    fn show(&mut self, changes: &Changes) -> Result<(), BuildError> {
        let before = match self.world.change(changes, &self.renderer.context.sources) {
            Edited::InPlace => return Ok(()),
            Edited::Checked => {
                self.renderer.plans.stale = true;
                return Ok(());
            }
            Edited::Replaced { before } => before,
        };
        self.renderer.plans.stale = true;
        self.renderer.plans.forget();
        let made = self.plan_for(&self.renderer.graph.clone(), &self.selection_now());
        if made.is_err() {
            // The parts of it that were written already are not of the world before.
            self.renderer.context.sources.forget(&self.world.shown);
            self.world.shown = before;
            let _ = self.plan_for(&self.renderer.graph.clone(), &self.selection_now());
        }
        made
    }
}
