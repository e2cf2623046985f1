//! Undo and redo of the window's changes, and keys of params that are recorded.

use std::sync::Arc;

use raxel_control::Restored;
use raxel_graph::checked::Value;
use raxel_output::{demo_path, take_name};
use raxel_runtime::reload::ProjectFile;
use raxel_runtime::timeline::Demo;
use raxel_workbench::demo;
use raxel_workbench::writes::set_again;

use super::history::{Change, Files, Pose, Step};
use super::recording::Recording;
use super::write_back::Written;
use super::{Viewer, demo_keys, write_back};

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
        self.leave_demo();
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

    /// Goes on without the demo where its file is gone: undo has taken back that it was made.
    fn leave_demo(&mut self) {
        let project = self.session.project();
        if self.session.demo().is_some_and(|demo| !project.on_disk(&demo.file).exists()) {
            let graph = self.session.graph_path().to_owned();
            self.session.open_file(ProjectFile::Graph(graph));
        }
    }

    /// Notes that a param is moved, if that is recorded. A demo that drives the param must not change it meanwhile; its camera and its other
    /// tracks go on.
    pub(super) fn record_param(&mut self, name: &str, before: Value, numbers: &[f64]) {
        if !self.recorder.is_on() {
            return;
        }
        let tracked = |demo: &Arc<Demo>| demo.tracks.iter().any(|track| track.param.value == name);
        if self.session.demo_drives() && self.session.demo().is_some_and(tracked) {
            self.session.release_param(Some(name));
            self.recorder.release();
        }
        let time = demo::seconds(&self.session);
        if let Some(recording) = self.recorder.moved(name, before, time, numbers) {
            self.write_keys(&recording);
        }
    }

    /// Before a frame: writes the recording, once the param is released.
    pub(super) fn record_frame(&mut self) {
        let (time, held) = (demo::seconds(&self.session), self.is_held());
        if let Some(recording) = self.recorder.frame(time, held) {
            self.write_keys(&recording);
        }
    }

    /// Writes keys into the demo, or makes one that plays them.
    fn write_keys(&mut self, recording: &Recording) {
        let keys = recording.keys().len();
        let done = format!("recorded {keys} {} of `{}`", if keys == 1 { "key" } else { "keys" }, recording.param);
        if self.session.demo().is_some() {
            self.write_demo(&done, |text, _, _| demo_keys::with_param_keys(text, recording));
        } else {
            match self.new_demo(recording) {
                Ok(file) => {
                    self.notice(format!("{done}, in {file}, which plays now"));
                    self.session.open_file(ProjectFile::Demo(file));
                }
                Err(error) => self.warn(error),
            }
        }
        if self.recorder.gives_back() {
            self.session.release_param(None);
        }
    }

    /// Makes a demo of the running files with the keys of a recording, and returns its project path.
    fn new_demo(&mut self, recording: &Recording) -> Result<String, String> {
        let world = self.session.world().path.as_deref().ok_or("a demo needs a world: `--world` names one")?;
        let text = demo_keys::new_demo(self.session.graph_path(), world, recording, self.session.camera())?;
        let project = self.session.project();
        let file = demo_path(&take_name(project, None).map_err(|error| error.message)?);
        let written = write_back::create(project, &file, &text)?;
        self.note_write([written]);
        Ok(file)
    }
}
