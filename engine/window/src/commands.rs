//! The commands of keys and panels.

use std::time::{Duration, Instant};

use raxel_diagnostics::SourceMap;
use raxel_edit::EditError;
use raxel_graph::checked::{BufferSize, ResourceKind, Value};
use raxel_panels::view::{Brush, Effect, Lane};
use raxel_panels::{Action, Panel, WriteTo};
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::params::from_components;
use raxel_runtime::{EditFailure, Session};
use raxel_terminal::console::{self, To};
use raxel_terminal::session::{frame_failure, named_camera};
use raxel_workbench::demo::{self, Changed};
use raxel_workbench::tracks;
use raxel_workbench::writes::{self, Applied, InFile, ParamChange};
use winit::event_loop::ActiveEventLoop;

use super::brush::Stroke;
use super::controls::Command;
use super::finding::{Ended, Wanted};
use super::history::{Change, Files, Step};
use super::pins::{self, Pressed};
use super::write_back::Written;
use super::{NextFrame, Viewer, brush, demo_keys, panel_data, write_back};

/// The time that a message stays in the bar.
const NOTICE: Duration = Duration::from_secs(6);

impl Viewer<'_> {
    /// A key.
    pub(super) fn run_command(&mut self, command: Command, event_loop: &ActiveEventLoop) {
        self.titled = None;
        match command {
            Command::NextTarget => self.cycle(1),
            Command::PreviousTarget => self.cycle(-1),
            Command::Pause => self.session.pause(!self.session.clock().paused()),
            Command::Step => {
                self.session.pause(true);
                self.session.step();
            }
            Command::Reset => self.reset(),
            Command::Undo => self.undo(),
            Command::Redo => self.redo(),
            Command::Larger => self.choose(|brush, _| brush::resize(brush, true)),
            Command::Smaller => self.choose(|brush, _| brush::resize(brush, false)),
            Command::NextMaterial => self.choose(brush::next_material),
            Command::Open => self.perform(Action::ListFiles, event_loop),
            Command::Panels => self.panels.toggle(),
            Command::Home => self.go_to(self.home),
            Command::RecordKey => self.perform(Action::RecordKey, event_loop),
            Command::HandBack => self.session.hand_back(),
            Command::CopyCamera => self.perform(Action::CopyCamera, event_loop),
            Command::Pin => self.pin(),
            Command::Look(step) => self.look(step),
            Command::Keep => self.compare(Action::Keep),
            Command::Beside => {
                self.panels.layout.beside = !self.panels.layout.beside;
                self.touched = true;
            }
            Command::KeepLive => self.compare(Action::KeepLive),
            Command::NextComparison => self.next_comparison(),
            Command::Flip => self.compare(Action::Flip),
            Command::Cancel => self.cancel(event_loop),
            Command::Screenshot => {
                if let Err(failure) = self.screenshot() {
                    self.console.failure(&failure);
                }
            }
            Command::Give => self.give_inputs(),
            Command::Record => self.record_take(),
            Command::Capture => self.next_runs = NextFrame::Captured,
            Command::Quit => event_loop.exit(),
        }
    }

    /// Something that a panel asks for.
    pub(super) fn perform(&mut self, action: Action, event_loop: &ActiveEventLoop) {
        (self.titled, self.touched) = (None, true);
        match action {
            Action::Show(shown) => self.show_target(panel_data::debug_target(&shown)),
            Action::ShowDefault => self.show_target(DebugTarget::default()),
            Action::Peek(Some(shown)) => self.peek(panel_data::debug_target(&shown)),
            Action::Peek(None) => self.end_peek(),
            Action::Display(map) => {
                self.history.note_display(self.inspector.map(), map);
                self.inspector.shows(map);
            }
            Action::Rows(first) => self.inspector.rows(first),
            Action::WriteTable => self.write_table(),
            Action::SetParam(name, value) => self.set_param(&name, &value),
            Action::ResetParam(name) => self.reset_param(&name),
            Action::Record(on) => self.recorder.turn(on),
            Action::WriteParams(names, to) => self.write_params(&names, to),
            Action::SavePreset(name) => self.save_preset(&name),
            Action::ApplyPreset(name) => self.apply_preset(&name),
            Action::DeletePreset(name) => self.delete_preset(&name),
            Action::UndoWrite => drop(self.undo_write()),
            Action::Pin(at) => self.pin_at(at),
            Action::MovePin(number, at) => self.inspector.move_pin(number, at),
            Action::ChoosePin(number) => self.inspector.choose_pin(number),
            Action::Unpin(number) => self.inspector.unpin(number),
            Action::Find { sought, channel, forward } => {
                self.inspector.find(&mut self.session, Wanted { sought, channel, forward });
            }
            Action::StopFind => self.inspector.stop(&mut self.session),
            action @ (Action::Keep
            | Action::KeepLive
            | Action::KeepFile(_)
            | Action::ForgetKept
            | Action::CompareMode(_)
            | Action::Flip
            | Action::Gain(_)
            | Action::Measure) => self.compare(action),
            Action::ListFiles => {
                self.files.begin(&self.session);
                self.panels.switch();
            }
            Action::Open(kind, path) => self.open_file(kind, path),
            Action::Pause => self.run_command(Command::Pause, event_loop),
            Action::Step => self.run_command(Command::Step, event_loop),
            Action::Reset => self.reset(),
            Action::Scale(scale) => self.session.set_scale(scale),
            Action::FpsCap(cap) => self.fps_cap = cap,
            Action::Copy(text) => {
                self.notice(format!("copied {text}"));
                self.copy(text);
            }
            Action::Edit(place) => self.open_editor(&place),
            Action::Cancel => self.cancel(event_loop),
            Action::CheckBounds(on) => self.check_bounds(on),
            Action::FindWriters(on) => self.find_writers(on),
            Action::Seek(seconds) => self.seek(seconds),
            Action::Loop(looped) => self.looped = Some(looped),
            Action::HandBack => self.session.hand_back(),
            Action::MoveKey { lane, key, to } => self.move_key(&lane, key, to),
            Action::DeleteKey { lane, key } => self.delete_key(&lane, key),
            Action::RecordKey => self.write_demo("the camera is a key of the demo now", demo_keys::with_camera_key),
            Action::Camera(name) => self.go_to_named(&name),
            Action::Home => self.go_to(self.home),
            Action::CopyCamera => self.copy_camera(),
            Action::WriteCamera(name) => self.write_camera(&name),
            Action::Speed(voxels) => self.controls.set_speed(voxels),
            Action::Brush(brush) => self.brush = brush,
            Action::Undo => self.undo_world(),
            Action::Redo => self.redo_world(),
        }
    }

    /// Shows another target, until a panel asks for another one.
    fn show_target(&mut self, target: DebugTarget) {
        self.before_peek = None;
        self.data.peek(&self.session, false);
        self.select(target);
    }

    /// Shows another target until [`Self::end_peek`].
    fn peek(&mut self, target: DebugTarget) {
        self.data.peek(&self.session, true);
        self.before_peek.get_or_insert_with(|| self.session.debug_target().clone());
        self.select(target);
    }

    fn end_peek(&mut self) {
        self.data.peek(&self.session, false);
        if let Some(target) = self.before_peek.take() {
            self.select(target);
        }
    }

    /// Applies the brush to the voxel under the cursor. Painting goes on while the button is held, from voxel to voxel.
    pub(super) fn stroke(&mut self) {
        let effect = brush::effect(&self.brush, self.modifiers);
        let Some(pixel) = self.controls.cursor() else { return };
        let pixel = self.magnifier.unmagnified(pixel, self.session.viewport().window());
        let hit = match self.session.pick(pixel, brush::REACH) {
            Ok(Some(hit)) => hit,
            Ok(None) => return,
            // The voxel under the cursor is unknown: nothing is edited behind it.
            Err(unavailable) => {
                self.edited(|_| Err(EditError::from(unavailable).into()));
                return;
            }
        };
        if self.painting == Some(hit.exact.voxel) {
            return;
        }
        self.painting = (effect == Effect::Paint).then_some(hit.exact.voxel);
        match brush::stroke(&self.brush, effect, &hit) {
            Stroke::Edit(edit) => {
                if self.edited(|session| session.edit(&[edit]).map(drop)) {
                    self.history.note(Step::World);
                }
            }
            Stroke::Pick(material) => self.choose(|brush, _| brush.material = Some(material)),
        }
    }

    /// Edits the world, and shows the reason of a refusal. False then.
    pub(super) fn edited(&mut self, edit: impl FnOnce(&mut Session) -> std::result::Result<(), EditFailure>) -> bool {
        let result = edit(&mut self.session);
        let made = result.is_ok();
        self.refused = result.as_ref().err().map(ToString::to_string);
        if let Err(failure) = result {
            self.notice(failure.to_string());
            self.console.diagnostics(&failure.into_diagnostics(), &SourceMap::default(), To::Stderr);
        }
        made
    }

    /// Chooses another brush, and names it.
    fn choose(&mut self, change: impl FnOnce(&mut Brush, usize)) {
        change(&mut self.brush, self.session.scene().materials.len());
        self.notice(brush::text(&self.brush, &self.session));
    }

    fn reset(&mut self) {
        self.session.reset();
        self.session.hand_back();
        self.session.set_camera(self.home);
    }

    fn go_to(&mut self, camera: Camera) {
        self.land();
        self.history.fly(self.pose());
        self.session.take_over();
        self.session.set_camera(camera);
        self.land();
    }

    fn go_to_named(&mut self, name: &str) {
        match named_camera(self.session.world(), name) {
            Ok(camera) => self.go_to(camera),
            Err(failure) => self.console.failure(&failure),
        }
    }

    fn copy_camera(&mut self) {
        let lines = write_back::camera_lines("camera", self.session.camera());
        console::data(&lines);
        self.notice("copied the camera, as lines for a world's file".to_owned());
        self.copy(lines);
    }

    fn seek(&mut self, seconds: f64) {
        self.session.hand_back();
        self.session.seek(seconds);
    }

    fn check_bounds(&mut self, on: bool) {
        self.session.check_bounds(on);
        self.notice(format!("compiling the shaders {} checks of bounds", if on { "with" } else { "without" }));
    }

    fn find_writers(&mut self, on: bool) {
        self.inspector.find_writers(&mut self.session, on);
        if self.session.records_writes() != on && self.session.record_writes(on) {
            let records = if on { "with" } else { "without" };
            self.notice(format!("compiling the shaders {records} records of their writes"));
        }
    }

    fn open_editor(&mut self, place: &str) {
        let opened = self.editors.open(self.session.project().root(), place);
        self.said(opened);
    }

    /// Gives up the pass that the device works on, if it has worked on it for long.
    fn cancel(&mut self, event_loop: &ActiveEventLoop) {
        if self.busy.take().is_none() {
            return;
        }
        if let Err(error) = self.session.cancel() {
            let failure = frame_failure(error, self.console);
            self.stop(event_loop, failure);
        }
    }

    fn set_param(&mut self, name: &str, numbers: &[f64]) {
        let Some(param) = self.session.params().iter().find(|param| param.name == name) else { return };
        let (default, before) = (param.default, self.session.param(name).unwrap_or(param.default));
        let Some(value) = from_components(numbers, &default) else { return };
        let set = self.session.set_param(name, value);
        if set.is_ok() {
            tracks::moved(&mut self.session, &mut self.recorder, name, before);
            let change = Change { name: name.to_owned(), before: changed(before, default), after: Some(value) };
            self.history.note_param(change);
        }
        self.said(set);
    }

    fn reset_param(&mut self, name: &str) {
        let before = self.session.param(name).ok();
        let reset = self.session.unset_param(name);
        if reset.is_ok() {
            self.history.note(Step::Params(vec![Change { name: name.to_owned(), before, after: None }]));
        }
        self.said(reset);
    }

    /// Whether something of a panel is pressed.
    pub(super) fn is_held(&self) -> bool {
        self.window.as_ref().is_some_and(|open| open.overlay.is_held())
    }

    /// Keeps the values of all params under a name.
    fn save_preset(&mut self, name: &str) {
        let values = writes::values(&self.session);
        match self.presets.save(self.session.graph_path(), name, &values) {
            Ok(written) => {
                self.note_write([written]);
                self.notice(format!("kept the values as `{name}`"));
            }
            Err(error) => self.warn(error),
        }
    }

    fn delete_preset(&mut self, name: &str) {
        match self.presets.remove(self.session.graph_path(), name) {
            Ok(written) => self.note_write([written]),
            Err(error) => self.warn(error),
        }
    }

    /// Sets the params that the graph has to the values of a preset, and names the others.
    fn apply_preset(&mut self, name: &str) {
        let graph = self.session.graph_path().to_owned();
        let Some(values) = self.presets.of_graph(&graph).find(|(known, _)| *known == name).map(|(_, v)| v.clone())
        else {
            return;
        };
        let Applied { changes, left, refused } = writes::apply(&mut self.session, &values);
        refused.into_iter().for_each(|error| self.warn(error));
        if !changes.is_empty() {
            let changes = changes.into_iter().map(|ParamChange { name, before, after }| {
                let default = self.session.params().iter().find(|param| param.name == name).map(|param| param.default);
                Change { name, before: Some(before).filter(|before| Some(*before) != default), after: Some(after) }
            });
            self.history.note(Step::Params(changes.collect()));
        }
        if left.is_empty() {
            self.notice(format!("set the params to `{name}`"));
        } else {
            let left: Vec<String> = left.iter().map(|name| format!("`{name}`")).collect();
            self.warn(format!("the graph no longer has the params {}", left.join(", ")));
        }
    }

    /// Writes the values of params into the graph's own file, or where each default stands.
    fn write_params(&mut self, names: &[String], to: WriteTo) {
        let to = match to {
            WriteTo::Own => writes::WriteTo::Own,
            WriteTo::Declared => writes::WriteTo::Declared,
        };
        let outcomes = writes::write_params(&self.session, names, to, |param| self.data.default_file(param));
        let mut step = Files::default();
        for InFile { file, params, result } in outcomes {
            let names: Vec<String> = params.iter().map(|(name, _)| name.clone()).collect();
            match result {
                Ok(change) => {
                    self.notice(format!("wrote {} to {file}", names.join(", ")));
                    // raxel does not read an unchanged file again, so no param would follow it.
                    if let Some(change) = change {
                        self.written.extend(params.iter().cloned());
                        step.written.push(change);
                        step.params.extend(params);
                    }
                }
                Err(error) => self.warn(error),
            }
        }
        self.note_files(step);
    }

    /// Notes a write, to be undone.
    pub(super) fn note_write(&mut self, written: impl IntoIterator<Item = Written>) {
        self.note_files(Files { written: written.into_iter().collect(), params: Vec::new() });
    }

    pub(super) fn note_files(&mut self, files: Files) {
        if !files.written.is_empty() {
            self.history.note(Step::Files(files));
        }
    }

    fn write_camera(&mut self, name: &str) {
        match writes::write_camera(&self.session, name) {
            Some(Ok((path, written))) => {
                self.note_write(written);
                self.notice(format!("wrote camera `{name}` to {path}"));
            }
            Some(Err(error)) => self.warn(error),
            // The empty world has no file.
            None => {}
        }
    }

    fn move_key(&mut self, lane: &Lane, key: usize, to: f64) {
        let lane = panel_data::lane(lane);
        self.write_demo(&format!("key {} is at {to:.2} s now", key + 1), |text, _, _| {
            demo_keys::with_time(text, &lane, key, to)
        });
    }

    fn delete_key(&mut self, lane: &Lane, key: usize) {
        let lane = panel_data::lane(lane);
        self.write_demo(&format!("key {} is deleted", key + 1), |text, _, _| demo_keys::without_key(text, &lane, key));
    }

    /// Changes the text of the demo's file, given its time in seconds and the camera, and shows a notice.
    pub(super) fn write_demo(
        &mut self,
        done: &str,
        change: impl FnOnce(&str, f64, &Camera) -> std::result::Result<String, String>,
    ) {
        match demo::change(&self.session, change) {
            Some(Ok(Changed { file, written })) => {
                self.note_write(written);
                self.notice(format!("{done}, in {file}"));
            }
            Some(Err(error)) => self.warn(error),
            None => self.warn("no demo runs: O opens one, or *Record* in Params makes one".to_owned()),
        }
    }

    /// Shows what a search has found, or says that there is nothing.
    pub(super) fn end_search(&mut self) {
        match self.inspector.ended() {
            Some(Ended::Found { shown, .. }) => {
                if shown != panel_data::shown(self.session.debug_target(), self.session.graph()) {
                    self.show_target(panel_data::debug_target(&shown));
                }
                self.reveal_pin();
            }
            Some(Ended::Nothing { sought, slices }) => {
                let slices = if slices == 1 { String::new() } else { format!(" in any of {slices} slices") };
                self.notice(format!("no value of this channel is {}{slices}", sought.word()));
            }
            Some(Ended::Lost) => self.notice("the search has ended: the target cannot be read any more".to_owned()),
            None => {}
        }
    }

    fn pin_at(&mut self, at: [u32; 2]) {
        if !self.inspector.pin(at) {
            self.notice(full());
        }
    }

    /// Pins the texel under the cursor, or lets go of the pin there.
    fn pin(&mut self) {
        let cursor = self.controls.cursor().map(|pixel| self.session.viewport().to_output(pixel));
        if !self.panels.layout.is_open(Panel::Inspect) {
            return self.notice("open Inspect to pin a texel".to_owned());
        }
        match self.inspector.pin_under(cursor, self.session.size(), &self.magnifier.region()) {
            Pressed::Pinned | Pressed::Unpinned => self.touched = true,
            Pressed::Full => self.notice(full()),
            Pressed::Nothing => self.notice("no texel is under the cursor".to_owned()),
        }
    }

    fn copy(&mut self, text: String) {
        if let Some(open) = &mut self.window {
            open.overlay.copy(text);
        }
    }

    pub(super) fn said<E: std::fmt::Display>(&mut self, result: std::result::Result<(), E>) {
        if let Err(error) = result {
            self.warn(error.to_string());
        }
    }

    /// Says something in the bar and on the terminal.
    pub(super) fn warn(&mut self, text: String) {
        self.console.message(&format!("warning: {text}"));
        self.notice(text);
    }

    /// Says something in the bar.
    pub(super) fn notice(&mut self, text: String) {
        self.touched = true;
        self.notice = Some((text, Instant::now() + NOTICE));
    }

    /// Shows the resource, or layer of one, that is `by` places after this one, in the order of the file.
    fn cycle(&mut self, by: isize) {
        let (graph, plan) = (self.session.graph(), self.session.plan());
        let layers = |index: usize| {
            // A target that nothing running uses has no plan, and one layer to be shown.
            plan.and_then(|plan| plan.sizes.get(index)).map_or(1, raxel_graph::size::Size::layers)
        };
        let places: Vec<(&str, u32)> = graph
            .resources
            .iter()
            .enumerate()
            // A world's buffer is no picture.
            .filter(|(_, resource)| {
                !matches!(&resource.kind, ResourceKind::Buffer(b) if matches!(b.size, BufferSize::Source(_)))
            })
            .flat_map(|(index, resource)| (0..layers(index)).map(move |layer| (resource.name.as_str(), layer)))
            .collect();
        let now = (self.target(), self.session.debug_target().layer);
        let at = places.iter().position(|(name, layer)| *name == now.0 && *layer == now.1).unwrap_or(0).cast_signed();
        let next = places.get((at + by).rem_euclid(places.len().max(1).cast_signed()) as usize);
        if let Some(target) = next.map(|(name, layer)| DebugTarget { layer: *layer, ..DebugTarget::resource(*name) }) {
            self.select(target);
        }
    }

    fn select(&mut self, target: DebugTarget) {
        if let Err(error) = self.session.set_debug_target(target) {
            self.console.message(&format!("warning: {error}"));
        }
    }

    /// Name of the resource shown.
    pub(super) fn target(&self) -> String {
        let selected = self.session.debug_target();
        let graph = self.session.graph();
        if selected.resource.is_empty() {
            graph.resource(graph.present).name.clone()
        } else {
            selected.resource.clone()
        }
    }
}

/// There is no room for another pin.
fn full() -> String {
    format!("{} texels are pinned: let go of one first", pins::MOST)
}

/// A value that is not the file's.
fn changed(value: Value, default: Value) -> Option<Value> {
    (value != default).then_some(value)
}
