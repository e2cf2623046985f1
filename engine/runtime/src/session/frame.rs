//! One frame, and what can be read of it.

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_execute::{
    Builtins, Captured, ExecuteError, FrameInputs, FramePicture, FrameReport, GpuTimes, PassOutcome, PassTime, Picture,
    Pipelined, Progress, ReadTicket, Texels,
};
use raxel_graph::checked::{Fact, Graph, ParamId, ResourceId, Value};
use raxel_stream::{Refused, WorldStream};

use super::change_tracker::Changes;
use super::retry::Retry;
use super::{FrameError, ReadError, Session};
use crate::build::{self, Assembly, Selection};
use crate::build_error::BuildError;
use crate::clock::FrameTime;
use crate::params::SetError;
use crate::reload::ReloadEvent;

/// Most plans that are kept for the time when they are wanted again: debug targets that are looked at in turn.
const KEPT_PLANS: usize = 16;

impl Session {
    /// Runs the next frame, up to its picture. A device that was lost is opened anew first.
    ///
    /// # Errors
    /// [`FrameError::Plan`] once, when no plan can be made for a new size, debug target or condition; the frames after it run the plan
    /// before.
    pub fn frame(&mut self) -> Result<FrameReport, FrameError> {
        let _span = tracing::trace_span!("frame").entered();
        let before = self.clock.clone();
        // A frame that was refused has not been: the next one has its time.
        let result = self.begin_and_run();
        if result.is_err() {
            self.clock = before;
        }
        result
    }

    fn begin_and_run(&mut self) -> Result<FrameReport, FrameError> {
        let (time, changes) = self.begin()?;
        loop {
            match self.run(&time, changes) {
                Err(error @ ExecuteError::DeviceLost { .. }) => self.recover(error)?,
                Err(error) => {
                    self.still.refused();
                    return Err(FrameError::Device(error));
                }
                Ok(report) => return Ok(report),
            }
        }
    }

    /// The picture of the last frame, on the device; `None` before the first. [`crate::present::Presenter`] shows it in a window.
    pub fn picture(&self) -> Option<FramePicture> {
        self.executor.picture()
    }

    /// Waits at most so long for the picture of the last frame to be whole. A device that has finished nothing for as long as the
    /// watchdog allows is opened anew.
    pub fn wait_picture(&mut self, at_most: Duration) -> Result<Progress, FrameError> {
        let progress = self.executor.wait_picture(at_most);
        self.recovered(progress)
    }

    /// Waits at most so long until [`Self::frame`] can begin without waiting for the device. Errors as for [`Self::wait_picture`].
    pub fn wait_next(&mut self, at_most: Duration) -> Result<Progress, FrameError> {
        let progress = self.executor.wait_next(at_most);
        self.recovered(progress)
    }

    fn recovered(&mut self, progress: Result<Progress, ExecuteError>) -> Result<Progress, FrameError> {
        match progress {
            Err(error @ ExecuteError::DeviceLost { .. }) => self.recover(error).map(|()| Progress::Done),
            progress => progress.map_err(FrameError::Device),
        }
    }

    /// Waits for all frames.
    pub fn wait(&mut self) -> Result<(), FrameError> {
        self.executor.wait().map_err(FrameError::Device)
    }

    /// GPU times of the passes in the last frame that the device has finished; order of the plan's passes.
    pub fn timings(&mut self) -> &[PassTime] {
        self.executor.timings()
    }

    /// [`Self::timings`] with the frame that they are of, and the time from the begin of its first pass to the end of its last.
    pub fn gpu_times(&mut self) -> GpuTimes<'_> {
        self.executor.gpu_times()
    }

    /// What became of each pass in the last frame; order of the plan's passes.
    pub fn outcomes(&self) -> Vec<PassOutcome> {
        self.executor.outcomes(&self.disabled)
    }

    /// Asks the next frame for a copy of what it shows, as it is at that point of the frame; of a buffer, these bytes.
    pub fn capture_shown(&mut self, bytes: Range<u64>) {
        self.executor.capture_shown(bytes);
    }

    /// The copy that [`Self::capture_shown`] asked for, once a frame has taken it.
    pub fn captured(&mut self) -> Option<ReadTicket<Captured>> {
        self.executor.captured()
    }

    /// Gives up what the device works on: it is opened anew, and the pass that it worked on is switched off until its shader or its part of the graph changes.
    pub fn cancel(&mut self) -> Result<(), FrameError> {
        let lost = self.executor.cancel();
        self.recover(lost)
    }

    /// Brings everything to the time of the next frame; gives what has changed with it.
    fn begin(&mut self) -> Result<(FrameTime, Changes), FrameError> {
        let before = self.clock.now();
        let time = self.clock.tick(Instant::now());
        let mut cut = before.is_none();
        cut |= self.follow_graphs(time.time)?;
        self.values.clear();
        self.values.extend_from_slice(self.params.values());
        if let Some(demo) = self.demo.as_ref().filter(|_| !self.taken_over) {
            if let Some(camera) = demo.camera(time.time) {
                self.camera = camera;
            }
            for (id, value) in demo.params(time.time, &self.graph) {
                self.values[id.0 as usize] = value;
            }
            cut |= before.is_some_and(|before| demo.cuts_between(before.time, time.time));
            // A demo changes what is shown at its keys, not in between: a choice of the user's stays until the next key.
            let target = demo.debug_target(time.time);
            if self.demo_target.as_ref() != target && !self.target_held {
                self.debug_target = target.cloned().unwrap_or_default();
                self.demo_target = target.cloned();
                self.needs_replan = true;
            }
        }
        if let Some(demo) = self.demo.clone().filter(|_| !self.taken_over) {
            self.follow_edits(demo.local_time(time.time))?;
        }
        self.take_collected()?;
        self.editing.poll_save();
        if cut && time.advanced {
            // There is no way from the last picture to this one.
            self.previous_camera = self.camera;
            self.collected.forget_poses();
            self.changed.everything();
            if before.is_some() {
                self.executor.reset_history();
                self.still.reset();
                self.history.reset();
            }
        }
        let decided = |(id, value): &(ParamId, Value)| self.values[id.0 as usize] == *value;
        if self.needs_replan || self.retry.due() || !self.condition_params.iter().all(decided) {
            self.replan()?;
        }
        self.history.begin(self.executor.histories());
        let version = self.begin_stream(&time)?;
        self.changed.publication(version);
        self.context.sources.move_instances(&self.world, &self.graph, &self.values, self.collected.poses());
        let builtins = self.builtins(&time, Changes::default());
        let moved = self.collected.poses().serial();
        let given = (&self.values[..], &self.overrides[..], &self.disabled[..]);
        let [_, edited] = self.stream().map_or([0; 2], |stream| stream.changes());
        // The graph and not its plan: another plan, for another debug target, computes the same.
        let changes = self.still.note((&self.world, [version, edited, moved]), &self.graph, &builtins, given);
        Ok((time, changes))
    }

    /// Gives the frame the newest state of a streamed world; returns its version. A device that was lost is opened anew first.
    fn begin_stream(&mut self, time: &FrameTime) -> Result<u64, FrameError> {
        let [width, height] = self.selection.output;
        let aspect = f64::from(width) / f64::from(height);
        loop {
            let Some(stream) = self.stream() else { return Ok(0) };
            if let Some(message) = stream.take_message() {
                self.editing.say(message);
            }
            match stream.begin(&self.camera.eye(aspect), time.delta) {
                Ok(version) => return Ok(version),
                Err(Refused::World(diagnostic)) => {
                    let texts = Box::new(self.state.diagnostics().1);
                    return Err(FrameError::Plan { diagnostics: vec![*diagnostic], texts });
                }
                Err(Refused::Device(error)) => self.recover(error)?,
            }
        }
    }

    /// What brings the world, if it is streamed and a plan has bound it.
    pub fn stream(&self) -> Option<Arc<WorldStream>> {
        self.context.sources.stream(&self.world)
    }

    fn run(&mut self, time: &FrameTime, changes: Changes) -> Result<FrameReport, ExecuteError> {
        let builtins = self.builtins(time, changes);
        let inputs = FrameInputs {
            builtins: &builtins,
            params: &self.values,
            overrides: &self.overrides,
            clock: time.time,
            disabled: &self.disabled,
        };
        let before = self.device.submitted();
        let report = self.executor.frame(&inputs)?;
        if let Some(stream) = self.stream() {
            stream.end(before);
        }
        self.changed.shown();
        self.collect()?;
        self.prints.begin(report.frame, time.index);
        self.note_counted();
        self.note_prints();
        self.previous_camera = self.camera;
        self.history.end();
        Ok(report)
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "shaders get 32-bit floats, and the number of the frame modulo 2³²"
    )]
    fn builtins(&self, time: &FrameTime, changes: Changes) -> Builtins {
        let [world_changed_min, world_changed_max] = self.changed.bounds();
        let mut builtins = Builtins {
            frame_index: time.index as u32,
            frame_time: time.time.seconds() as f32,
            frame_delta: time.delta as f32,
            frame_still: changes.still,
            history_valid: u32::from(self.history.is_valid()),
            world_serial: changes.serial,
            world_edited: changes.edited,
            world_changed_min,
            world_changed_max,
            cursor_position: self.cursor.unwrap_or([-1; 2]),
            ..crate::builtins::of(&self.camera, &self.previous_camera, self.selection.output, &self.world)
        };
        if self.subpixel.iter().any(|offset| *offset != 0.0) {
            let aspect = f64::from(builtins.output_aspect);
            let tan = self.camera.tan_half_fov(aspect).as_dvec2().to_array();
            // A pixel is 2 / extent wide where the picture reaches from −1 to 1.
            let shift = |axis: usize| 2.0 * self.subpixel[axis] / f64::from(self.selection.output[axis]) * tan[axis];
            let (view_to_world, world_to_view) = self.camera.sheared([shift(0), -shift(1)]);
            builtins.camera_view_to_world = view_to_world.to_cols_array_2d();
            builtins.camera_world_to_view = world_to_view.to_cols_array_2d();
        }
        builtins
    }

    /// Makes the plan for what is wanted now, if the running one is for something else. What was refused is not tried again.
    fn replan(&mut self) -> Result<(), FrameError> {
        let selection = self.selection_now();
        self.needs_replan = false;
        self.note_conditions();
        if selection == self.selection {
            (self.refused, self.retry) = (None, Retry::default());
            return Ok(());
        }
        let again = self.refused.as_ref() == Some(&selection);
        if again && !self.retry.due() {
            return Ok(());
        }
        if !again {
            self.retry = Retry::default();
        }
        match self.plan_for(&self.graph.clone(), &selection) {
            Ok(()) => {
                (self.refused, self.retry) = (None, Retry::default());
                Ok(())
            }
            Err(BuildError::Device(error @ ExecuteError::DeviceLost { .. })) => {
                self.needs_replan = true;
                self.recover(error)
            }
            // Memory may be free later.
            Err(BuildError::Device(_)) if again && !self.retry.refused() => Ok(()),
            Err(error) => {
                if matches!(error, BuildError::Device(_)) {
                    self.retry.refused();
                }
                self.refused = Some(selection);
                let texts = Box::new(self.state.diagnostics().1);
                Err(FrameError::Plan { diagnostics: error.into_diagnostics(), texts })
            }
        }
    }

    /// Notes the values of the params that conditions ask for: when one changes, another plan may be needed.
    pub(super) fn note_conditions(&mut self) {
        self.condition_params.clear();
        for condition in self.graph.passes.iter().flat_map(|pass| &pass.when) {
            if let Fact::Param(id) = &condition.fact {
                self.condition_params.push((*id, self.values[id.0 as usize]));
            }
        }
    }

    /// Swaps in a plan of a graph for another selection over the same world.
    pub(super) fn plan_for(&mut self, graph: &Arc<Graph>, selection: &Selection) -> Result<(), BuildError> {
        let known = self.plans.iter().find(|(known, _)| known == selection).map(|(_, plan)| plan.clone());
        let assembly = match known {
            Some(plan) => build::sources(&plan, &self.world, &self.context).map(|sources| Assembly {
                plan,
                sources,
                pipelined: Pipelined::default(),
            }),
            None => build::assemble(graph, &self.world, selection, &self.context),
        }?;
        let prepared = build::prepare(&assembly, &self.context)?;
        let resized = self.selection.graph == selection.graph && self.selection.output != selection.output;
        let before = if resized { self.kept_over_frames() } else { Vec::new() };
        let swapped = self.executor.swap(prepared);
        let cleared: Vec<String> = before.into_iter().filter(|name| swapped.created.contains(name)).collect();
        if self.history.is_news(&cleared) {
            self.events.push(ReloadEvent::HistoryCleared { size: selection.output, resources: cleared });
        }
        self.remember(selection.clone(), assembly.plan);
        Ok(())
    }

    /// Names of what the running plan carries from frame to frame, apart from what comes from outside.
    fn kept_over_frames(&self) -> Vec<String> {
        let Some(plan) = self.executor.plan() else { return Vec::new() };
        let carries = |resource: &&raxel_graph::plan::ResourcePlan| resource.copies > 1;
        let names = plan.resources.iter().filter(carries).map(|r| plan.graph.resource(r.resource).name.clone());
        names.collect()
    }

    /// Notes the plan that runs.
    pub(super) fn remember(&mut self, selection: Selection, plan: Arc<raxel_graph::plan::Plan>) {
        self.plans.retain(|(known, _)| *known != selection);
        if self.plans.len() == KEPT_PLANS {
            self.plans.remove(0);
        }
        self.plans.push((selection.clone(), plan));
        self.selection = selection;
    }

    /// The picture of the last frame: what is shown, through its display map. Waits for the device.
    pub fn read_presented(&mut self) -> Result<Picture, ReadError> {
        Ok(self.executor.read_presented()?)
    }

    /// Texels of mip 0, layer 0 of a target, as the last frame left them. What is not shown must be pinned. Waits for the device.
    pub fn read_target(&mut self, name: &str) -> Result<Texels, ReadError> {
        self.read_texels(name, 0, 0, 0)
    }

    /// Texels of a target: of so many frames ago, of a mip, of a layer or slice. Waits for the device.
    pub fn read_texels(&mut self, name: &str, age: u32, mip: u32, layer: u32) -> Result<Texels, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.read_target(resource, age, mip, layer)?)
    }

    /// Bytes of a buffer, as the last frame left them. Waits for the device.
    pub fn read_buffer(&mut self, name: &str, bytes: Range<u64>) -> Result<Vec<u8>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.read_buffer(resource, 0, bytes)?)
    }

    /// Asks for the picture of the last frame without waiting for it; the ticket says when it is there. At most eight tickets can be out.
    pub fn request_picture(&mut self) -> Result<ReadTicket<Picture>, ReadError> {
        Ok(self.executor.request_picture()?)
    }

    /// As [`Self::read_texels`], without waiting.
    pub fn request_texels(
        &mut self,
        name: &str,
        age: u32,
        mip: u32,
        layer: u32,
    ) -> Result<ReadTicket<Texels>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.request_target(resource, age, mip, layer)?)
    }

    /// As [`Self::read_buffer`], without waiting.
    pub fn request_buffer(&mut self, name: &str, bytes: Range<u64>) -> Result<ReadTicket<Vec<u8>>, ReadError> {
        let resource = self.resource(name)?;
        Ok(self.executor.request_buffer(resource, 0, bytes)?)
    }

    /// Waits for something that was asked for.
    pub fn redeem<T>(&self, ticket: &ReadTicket<T>) -> Result<T, ReadError> {
        Ok(self.executor.redeem(ticket)?)
    }

    fn resource(&self, name: &str) -> Result<ResourceId, SetError> {
        let names = self.graph.resources.iter().filter(|r| !r.made).map(|resource| resource.name.as_str());
        self.graph.find_resource(name).ok_or_else(|| SetError::unknown("resource", name, names))
    }
}
