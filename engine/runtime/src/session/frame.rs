//! One frame, and reading its results.

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_execute::{
    Builtins, Captured, ExecuteError, FrameInputs, FramePicture, FrameReport, GpuTimes, PassOutcome, PassTime,
    Progress, ReadTicket,
};
use raxel_graph::checked::Graph;
use raxel_stream::{Refused, WorldStream};

use super::change_tracker::{Changes, Inputs};
use super::{FrameError, Session};
use crate::build::Selection;
use crate::build_error::BuildError;
use crate::clock::{FrameTime, Pace};
use crate::world::saturated;

impl Session {
    /// Runs the next frame, up to its picture. If the device was lost, opens it again first.
    ///
    /// # Errors
    /// [`FrameError::Plan`] once, if no plan can be made for a new size, debug target or condition. Later frames run the old plan.
    pub fn frame(&mut self) -> Result<FrameReport, FrameError> {
        let _span = tracing::trace_span!("frame").entered();
        let before = (self.playback.clock.clone(), self.playback.inputs);
        // A frame that was refused has not been: the next one has its time and its inputs.
        let result = self.begin_and_run();
        if result.is_err() {
            (self.playback.clock, self.playback.inputs) = before;
        }
        result
    }

    fn begin_and_run(&mut self) -> Result<FrameReport, FrameError> {
        let (time, changes) = self.begin()?;
        loop {
            match self.run(&time, changes) {
                Err(error @ ExecuteError::DeviceLost { .. }) => self.recover(error)?,
                Err(error) => {
                    self.renderer.still.refused();
                    return Err(FrameError::Device(error));
                }
                Ok(report) => return Ok(report),
            }
        }
    }

    /// The picture of the last frame, on the device; `None` before the first. [`crate::present::Presenter`] shows it in a window.
    pub fn picture(&self) -> Option<FramePicture> {
        self.renderer.executor.picture()
    }

    /// Waits until the picture of the last frame is complete, `at_most` so long. If the device finishes no pass within the time of the
    /// watchdog, opens it again.
    pub fn wait_picture(&mut self, at_most: Duration) -> Result<Progress, FrameError> {
        let progress = self.renderer.executor.wait_picture(at_most);
        self.recovered(progress)
    }

    /// Waits until [`Self::frame`] can begin without waiting for the device, `at_most` so long. Errors as for [`Self::wait_picture`].
    pub fn wait_next(&mut self, at_most: Duration) -> Result<Progress, FrameError> {
        let progress = self.renderer.executor.wait_next(at_most);
        self.recovered(progress)
    }

    fn recovered(&mut self, progress: Result<Progress, ExecuteError>) -> Result<Progress, FrameError> {
        match progress {
            Err(error @ ExecuteError::DeviceLost { .. }) => self.recover(error).map(|()| Progress::Done),
            progress => progress.map_err(FrameError::Device),
        }
    }

    /// Waits until the device has finished all frames.
    pub fn wait(&mut self) -> Result<(), FrameError> {
        self.renderer.executor.wait().map_err(FrameError::Device)
    }

    /// GPU times of the passes in the last finished frame, in the order of the plan's passes.
    pub fn timings(&mut self) -> &[PassTime] {
        self.renderer.executor.timings()
    }

    /// [`Self::timings`], the frame that they belong to, and the time from the start of its first pass to the end of its last.
    pub fn gpu_times(&mut self) -> GpuTimes<'_> {
        self.renderer.executor.gpu_times()
    }

    /// The outcome of each pass in the last frame (ran, was skipped, and why), in the order of the plan's passes.
    pub fn outcomes(&self) -> Vec<PassOutcome> {
        self.renderer.executor.outcomes(&self.renderer.off.passes)
    }

    /// Lets the next frame copy the debug target at the point where it is shown. Of a buffer, it copies these bytes.
    pub fn capture_shown(&mut self, bytes: Range<u64>) {
        self.renderer.executor.capture_shown(bytes);
    }

    /// Lets the next frame copy another layer or slice of the shown target, at the point where the target is shown. False if the running plan
    /// leaves out a pass that writes this part, which then has to be shown to be known.
    pub fn capture_part(&mut self, mip: u32, layer: u32) -> bool {
        let plan = self.plan();
        let written = plan.is_some_and(|plan| plan.culled_writer(plan.present.resource, mip, layer).is_none());
        if written {
            self.renderer.executor.capture_part(mip, layer);
        }
        written
    }

    /// Frees the memory that copies were taken into: none is taken for a while.
    pub fn rest_captures(&mut self) {
        self.renderer.executor.rest_captures();
    }

    /// The copy that [`Self::capture_shown`] or [`Self::capture_part`] requested, after a frame has made it.
    pub fn captured(&mut self) -> Option<ReadTicket<Captured>> {
        self.renderer.executor.captured()
    }

    /// Abandons the work of the device and opens the device again. The pass that was running is switched off until its shader or its part
    /// of the graph changes.
    pub fn cancel(&mut self) -> Result<(), FrameError> {
        let lost = self.renderer.executor.cancel();
        self.recover(lost)
    }

    /// Brings everything to the time of the next frame; returns the changes.
    fn begin(&mut self) -> Result<(FrameTime, Changes), FrameError> {
        let before = self.playback.clock.now();
        let time = self.playback.clock.tick(Instant::now());
        let mut cut = before.is_none();
        cut |= self.follow_graphs(time.time)?;
        let followed = self.playback.follow_demo(before.map(|before| before.time), time.time, &self.renderer.graph);
        cut |= followed.cut;
        let output = self.size();
        self.playback.follow_inputs(before.map(|before| before.time), time.time, output);
        if self.hears_microphone() {
            self.playback.follow_microphone(time.time);
        }
        if let Some(target) = followed.target {
            self.renderer.shown.debug_target = target;
            self.renderer.plans.stale = true;
        }
        if let Some(local) = self.playback.demo.driving().map(|demo| demo.local_time(time.time)) {
            self.follow_edits(local)?;
        }
        self.take_output()?;
        self.world.editing.poll_save();
        if cut && time.advanced {
            self.playback.view.cut();
            self.world.cut();
            if before.is_some() {
                self.renderer.reset();
            }
        }
        if self.renderer.plans.are_due(&self.playback.params.shown) {
            self.replan()?;
        }
        self.renderer.history.begin(self.renderer.executor.histories());
        let version = self.begin_stream(&time)?;
        self.world.changed.publication(version);
        let poses = self.world.output.poses();
        let values = &self.playback.params.shown;
        let sources = &self.renderer.context.sources;
        sources.move_instances(&self.world.shown, &self.renderer.graph, values, poses);
        sources.write_keys(self.playback.inputs.shown.key_words());
        let waits = matches!(self.playback.clock.pace(), Pace::Fixed(_));
        let (played, wrong) = sources.play(time.time.seconds(), waits, &self.playback.microphone.heard());
        wrong.into_iter().for_each(|message| self.world.editing.say(message));
        let edited = self.stream().map_or(0, |stream| stream.changes().seen);
        let inputs = Inputs {
            world: &self.world.shown,
            versions: [version, edited, poses.serial(), played],
            // The graph and not its plan: another plan, for another debug target, computes the same.
            graph: &self.renderer.graph,
            builtins: &self.builtins(&time, Changes::default()),
            keys: &self.playback.inputs.shown.key_words(),
            values,
            overrides: &self.playback.params.overrides,
            disabled: &self.renderer.off.passes,
        };
        let changes = self.renderer.still.note(&inputs);
        self.note_take(&time);
        Ok((time, changes))
    }

    /// Gives the frame the newest state of a streamed world; returns its version. A lost device is reopened first.
    fn begin_stream(&mut self, time: &FrameTime) -> Result<u64, FrameError> {
        let [width, height] = self.renderer.plans.running.output;
        let aspect = f64::from(width) / f64::from(height);
        loop {
            let Some(stream) = self.stream() else { return Ok(0) };
            if let Some(message) = stream.take_message() {
                self.world.editing.say(message);
            }
            match stream.begin(&self.playback.view.camera.eye(aspect), time.delta) {
                Ok(version) => return Ok(version),
                Err(Refused::World(diagnostic)) => return Err(self.files.plan_error(vec![*diagnostic])),
                Err(Refused::Device(error)) => self.recover(error)?,
            }
        }
    }

    /// The stream of a streamed world, if a plan has bound the world.
    pub fn stream(&self) -> Option<Arc<WorldStream>> {
        self.renderer.context.sources.stream(&self.world.shown)
    }

    fn run(&mut self, time: &FrameTime, changes: Changes) -> Result<FrameReport, ExecuteError> {
        let builtins = self.builtins(time, changes);
        let inputs = FrameInputs {
            builtins: &builtins,
            params: &self.playback.params.shown,
            overrides: &self.playback.params.overrides,
            clock: time.time,
            disabled: &self.renderer.off.passes,
        };
        let before = self.device().submitted();
        self.renderer.executor.find_writers(self.renderer.writers.texel.clone());
        let report = self.renderer.executor.frame(&inputs)?;
        if let Some(stream) = self.stream() {
            stream.end(before);
        }
        self.world.changed.shown();
        self.world.output.request(&mut self.renderer)?;
        self.renderer.prints.begin(report.frame, time.index);
        self.renderer.note_reports();
        self.playback.view.previous = self.playback.view.camera;
        self.renderer.history.end();
        Ok(report)
    }

    fn builtins(&self, time: &FrameTime, changes: Changes) -> Builtins {
        let changed = self.world.changed.bounds();
        Builtins {
            frame_still: changes.still,
            history_valid: u32::from(self.renderer.history.is_valid()),
            world_serial: changes.serial,
            world_edited: changes.edited,
            world_changed_min: changed.min.map(saturated),
            world_changed_max: changed.max.map(saturated),
            ..self.playback.view.builtins(
                time,
                &self.playback.inputs.shown,
                self.renderer.plans.running.output,
                &self.world.shown,
            )
        }
    }

    /// Makes the plan for the present settings, if the running one is for other ones. A refused plan is not tried again.
    fn replan(&mut self) -> Result<(), FrameError> {
        let wanted = self.selection_now();
        self.note_conditions();
        if !self.renderer.plans.wants(&wanted) {
            return Ok(());
        }
        match self.plan_for(&self.renderer.graph.clone(), &wanted) {
            Ok(()) => {
                self.renderer.plans.accept();
                Ok(())
            }
            Err(BuildError::Device(error @ ExecuteError::DeviceLost { .. })) => {
                self.renderer.plans.stale = true;
                self.recover(error)
            }
            Err(error) if self.renderer.plans.refuse(wanted, &error) => {
                Err(self.files.plan_error(error.into_diagnostics()))
            }
            Err(_) => Ok(()),
        }
    }

    /// Notes the values of the params that the conditions of the graph ask for.
    pub(super) fn note_conditions(&mut self) {
        self.renderer.plans.note_conditions(&self.renderer.graph, &self.playback.params.shown);
    }

    /// Swaps in a plan of a graph for another selection over the same world.
    pub(super) fn plan_for(&mut self, graph: &Arc<Graph>, selection: &Selection) -> Result<(), BuildError> {
        let cleared = self.renderer.plan_for(graph, &self.world.shown, selection)?;
        self.events.extend(cleared);
        Ok(())
    }
}
