//! Undo and redo of the window's changes, and keys of params that are recorded.

use raxel_control::Restored;
use raxel_graph::checked::Value;
use raxel_workbench::demo::{self, Changed};
use raxel_workbench::recording::Recording;
use raxel_workbench::tracks;
use raxel_workbench::writes::set_again;

use super::Viewer;
use super::history::{Change, Files, Pose, Step};
use super::write_back::Written;

/// The direction of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Back,
    Again,
}

impl Viewer<'_> {
    /// Takes the newest step back: of the world, of files, of params, of the camera, of the way of showing. Edits that a save had before the
    /// window was opened come last.
    pub(super) fn undo(&mut self) {
        self.land();
        match self.history.take_done() {
            Some(step) => {
                if let Some(step) = self.go(step, Way::Back) {
                    self.history.was_undone(step);
                }
            }
            None if self.session.edit_steps().undo > 0 => self.undo_world(),
            None => self.notice("there is nothing to undo".to_owned()),
        }
    }

    /// Makes the step again that was taken back last.
    pub(super) fn redo(&mut self) {
        self.land();
        match self.history.take_undone() {
            Some(step) => {
                if let Some(step) = self.go(step, Way::Again) {
                    self.history.was_redone(step);
                }
            }
            None if self.session.edit_steps().redo > 0 => self.redo_world(),
            None => self.notice("there is nothing to redo".to_owned()),
        }
    }

    /// Undoes the newest edit of the world, even if other things were changed since.
    pub(super) fn undo_world(&mut self) {
        self.history.take_last(|step| *step == Step::World);
        if let Some(step) = self.go(Step::World, Way::Back) {
            self.history.was_undone(step);
        }
    }

    /// Makes the newest edit of the world again that was taken back.
    pub(super) fn redo_world(&mut self) {
        self.history.take_last_undone(|step| *step == Step::World);
        if let Some(step) = self.go(Step::World, Way::Again) {
            self.history.was_redone(step);
        }
    }

    /// Restores the files that were written last, even if other things were changed since. The step stays if no file was restored.
    ///
    /// # Errors
    /// Why no file was restored, in one line.
    pub(super) fn undo_write(&mut self) -> Result<Restored, String> {
        let Some(Files { written, params }) = self.history.last_write().cloned() else {
            return Ok(Restored::default());
        };
        let (back, refused) = self.restore(&written);
        if back.is_empty() {
            return Err(refused.join("; "));
        }
        self.set_again(&params);
        let files = back.iter().map(|written| written.file.clone()).collect();
        self.history.take_last(|step| matches!(step, Step::Files(_)));
        self.history.was_undone(Step::Files(Files { written: back, params }));
        Ok(Restored { files, refused })
    }

    /// Restores files. Returns the changes that lead the other way, and a line for each file that stays.
    fn restore(&mut self, files: &[Written]) -> (Vec<Written>, Vec<String>) {
        let (mut back, mut refused) = (Vec::new(), Vec::new());
        for written in files.iter().rev() {
            match written.undo() {
                Ok(other) => {
                    self.notice(format!("restored {}", written.file));
                    back.push(other);
                }
                Err(error) => {
                    self.warn(error.clone());
                    refused.push(error);
                }
            }
        }
        let read = self.presets.read();
        self.said(read);
        demo::leave_if_gone(&mut self.session);
        (back, refused)
    }

    /// Goes a step, and gives the one that leads the other way; `None` when that failed.
    fn go(&mut self, step: Step, way: Way) -> Option<Step> {
        match step {
            Step::World => {
                let went = self.edited(|session| match way {
                    Way::Back => session.undo().map(drop),
                    Way::Again => session.redo().map(drop),
                });
                went.then_some(Step::World)
            }
            Step::Files(Files { written, params }) => {
                let (back, _) = self.restore(&written);
                if back.is_empty() {
                    return None;
                }
                match way {
                    Way::Back => self.set_again(&params),
                    // From the next reload on they follow the file.
                    Way::Again => self.written.extend(params.iter().cloned()),
                }
                Some(Step::Files(Files { written: back, params }))
            }
            Step::Params(changes) => {
                let names: Vec<String> = changes.iter().map(|change| format!("`{}`", change.name)).collect();
                for Change { name, before, .. } in &changes {
                    let set = match before {
                        Some(value) => self.session.set_param(name, *value),
                        None => self.session.unset_param(name),
                    };
                    self.said(set);
                }
                self.notice(format!("changed {} back", names.join(", ")));
                let other = |Change { name, before, after }| Change { name, before: after, after: before };
                Some(Step::Params(changes.into_iter().map(other).collect()))
            }
            Step::Camera { before, after } => {
                match before {
                    Pose::Demo => self.session.hand_back(),
                    Pose::At(camera) => {
                        self.session.take_over();
                        self.session.set_camera(camera);
                    }
                }
                self.notice("moved the camera back".to_owned());
                Some(Step::Camera { before: after, after: before })
            }
            Step::Display { before, after } => {
                self.inspector.shows(before);
                self.notice("changed the map back".to_owned());
                Some(Step::Display { before: after, after: before })
            }
        }
    }

    /// Who says where the camera is.
    pub(super) fn pose(&self) -> Pose {
        if self.session.demo_drives() { Pose::Demo } else { Pose::At(*self.session.camera()) }
    }

    /// Ends a flight, which is one step.
    pub(super) fn land(&mut self) {
        let pose = self.pose();
        self.history.land(pose);
    }

    /// Gives params the values that files had taken over from the window, unless they were moved since.
    fn set_again(&mut self, params: &[(String, Value)]) {
        let refused = set_again(&mut self.session, &mut self.written, params);
        refused.into_iter().for_each(|error| self.warn(error));
    }

    /// Before a frame: writes the recordings of params that have ended.
    pub(super) fn record_frame(&mut self) {
        let held = self.is_held();
        let ended = tracks::frame(&self.session, &mut self.recorder, held);
        if !ended.is_empty() {
            self.write_recordings(&ended);
        }
    }

    /// Writes keys into the demo, or makes one that plays them.
    fn write_recordings(&mut self, recordings: &[Recording]) {
        let plays = self.session.demo().is_none();
        match tracks::write(&mut self.session, recordings) {
            Ok(Changed { file, written }) => {
                self.note_write(written);
                let made: Vec<String> = recordings.iter().map(recorded).collect();
                self.notice(format!(
                    "recorded {}, in {file}{}",
                    made.join(", "),
                    if plays { ", which plays now" } else { "" }
                ));
            }
            Err(error) => self.warn(error),
        }
        tracks::give_back(&mut self.session, &mut self.recorder);
    }
}

/// A recording in words.
fn recorded(recording: &Recording) -> String {
    let keys = recording.keys().len();
    format!("{keys} {} of `{}`", if keys == 1 { "key" } else { "keys" }, recording.param)
}
