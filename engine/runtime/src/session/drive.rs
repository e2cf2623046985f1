//! Driving a session by names: params, push values, camera, debug target, size, clock.

use std::sync::Arc;

use raxel_execute::moment::Moment;
use raxel_execute::{Builder, Comparison, ExternalResource, Mismatch, Reference, Region, WriteError};
use raxel_graph::checked::{Display, Param, Value};

use super::Session;
use super::renderer::patience;
use crate::build::Selection;
use crate::camera::Camera;
use crate::clock::Clock;
use crate::debug_target::{DebugTarget, DebugTargetError};
use crate::inputs::{Inputs, ShownInputs};
use crate::params::{self, SetError};
use crate::present::Viewport;
use crate::reload::project_state::BuildSettings;

impl Session {
    /// The params that the graph declares.
    pub fn params(&self) -> &[Param] {
        &self.renderer.graph.params
    }

    /// A param's value in the last frame.
    pub fn param(&self, name: &str) -> Result<Value, SetError> {
        match self.renderer.graph.find_param(name) {
            Some(id) => Ok(self.playback.params.shown[id.0 as usize]),
            None => Err(SetError::unknown("param", name, self.params().iter().map(|param| param.name.as_str()))),
        }
    }

    /// Sets a param. The value stays, also over reloads, until the graph no longer declares the name with this type.
    pub fn set_param(&mut self, name: &str, value: Value) -> Result<(), SetError> {
        self.playback.params.set.set(&self.renderer.graph, name, value)?;
        self.params_changed();
        Ok(())
    }

    /// Sets a param from text, as the command line does: `0.5`, `true`, `1,2,3`.
    pub fn set_param_text(&mut self, name: &str, text: &str) -> Result<(), SetError> {
        let value = params::parse(&self.renderer.graph, name, text)?;
        self.set_param(name, value)
    }

    /// Brings a param back to the graph's default.
    pub fn unset_param(&mut self, name: &str) -> Result<(), SetError> {
        self.playback.params.set.unset(&self.renderer.graph, name)?;
        self.params_changed();
        Ok(())
    }

    fn params_changed(&mut self) {
        self.playback.params.forget_demo();
        self.settings_changed();
    }

    /// Replaces the value of a member of a pass's push-constant or uniform block, whatever the graph says. It stays, also over
    /// reloads, as long as the pass has the member.
    pub fn set_push(&mut self, pass: &str, member: &str, value: Value) -> Result<(), SetError> {
        self.playback.params.set_member(&self.renderer.graph, pass, member, value)
    }

    /// Gives a member back to the graph.
    pub fn unset_push(&mut self, pass: &str, member: &str) {
        self.playback.params.unset_member(&self.renderer.graph, pass, member);
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.playback.view.camera
    }

    /// Moves the camera. A demo that moves it too wins, until [`Session::take_over`].
    pub fn set_camera(&mut self, camera: Camera) {
        self.playback.view.camera = camera;
    }

    /// The pixel of the window under the cursor, from the top left. Shaders are told the pixel of the output.
    pub fn set_cursor(&mut self, pixel: Option<[i32; 2]>) {
        self.playback.inputs.live.cursor = pixel.map(|pixel| self.viewport().to_output(pixel));
    }

    /// What a person holds and turns, for the next frame. What a demo drives wins, until [`Session::take_over`].
    pub fn inputs(&mut self) -> &mut Inputs {
        &mut self.playback.inputs.live
    }

    /// The inputs of the last frame.
    pub fn shown_inputs(&self) -> &ShownInputs {
        &self.playback.inputs.shown
    }

    /// The debug target.
    pub fn debug_target(&self) -> &DebugTarget {
        &self.renderer.shown.debug_target
    }

    /// Chooses the debug target by its text: `depth`, `color@1`, `pyramid,mip=2`, `color,after=sky`.
    pub fn set_debug_target_text(&mut self, text: &str) -> Result<(), DebugTargetError> {
        self.set_debug_target(DebugTarget::parse(text)?)
    }

    /// Chooses the debug target; an empty one is the graph's own.
    pub fn set_debug_target(&mut self, target: DebugTarget) -> Result<(), DebugTargetError> {
        target.resolve(&self.renderer.graph)?;
        self.renderer.shown.debug_target = target;
        self.settings_changed();
        Ok(())
    }

    /// Chooses the debug target for good: a demo does not change it any more. One of the demo's graphs must have it; the others show their
    /// own.
    pub fn hold_debug_target(&mut self, target: DebugTarget) -> Result<(), DebugTargetError> {
        let others = self.files.state.other_graphs.values().filter_map(|part| part.result.as_ref().ok());
        if !others.into_iter().any(|graph| target.resolve(graph).is_ok()) {
            target.resolve(&self.renderer.graph)?;
        }
        self.renderer.shown.debug_target = target;
        self.settings_changed();
        self.playback.demo.target_held = true;
        Ok(())
    }

    /// Shows the debug target in another way than the graph says: another map, range or channel. `None` goes back to the graph's own.
    pub fn set_display(&mut self, display: Option<Display>) {
        self.renderer.shown.display = display;
        self.renderer.executor.set_display(display);
    }

    /// Shows a part of the debug target from the next frame on.
    pub fn set_region(&mut self, region: Region) {
        self.renderer.shown.region = region;
        self.renderer.executor.set_region(region);
    }

    /// Shows the debug target together with a reference from the next frame on, as long as [`Self::mismatch`] has nothing against it. A loss of
    /// the device ends the comparison, and the reference is to be uploaded again ([`Self::builder`]).
    pub fn set_comparison(&mut self, compared: Option<(Arc<Reference>, Comparison)>) {
        self.renderer.executor.set_comparison(compared);
    }

    /// Why what is shown cannot be compared with a reference; `None` where it can.
    pub fn mismatch(&self, reference: &Reference) -> Option<Mismatch> {
        self.renderer.executor.mismatch(reference)
    }

    /// Uploads references for the session's device, on any thread.
    pub fn builder(&self) -> Builder {
        self.renderer.context.builder.clone()
    }

    /// Keeps a resource readable at the end of each frame from the next one on, whatever is shown. Needed with [`Observe::Shown`] only.
    ///
    /// [`Observe::Shown`]: raxel_graph::plan::Observe::Shown
    pub fn pin(&mut self, name: &str) -> Result<(), DebugTargetError> {
        DebugTarget::resource(name).resolve(&self.renderer.graph)?;
        let pinned = &mut self.renderer.shown.pinned;
        if !pinned.iter().any(|known| known == name) {
            pinned.push(name.to_owned());
            self.settings_changed();
        }
        Ok(())
    }

    /// A source that is on the device, e.g. `world.tree64`: its version, and a way to write parts of it between frames. `None` while
    /// nothing that runs binds it. An edit of the world and a loss of the device put another one in its place.
    pub fn source(&self, name: &str) -> Option<Arc<ExternalResource>> {
        self.renderer.context.sources.find(name, &self.world.shown)
    }

    /// Replaces bytes of the buffer of a source, before the next frame. Nothing waits. The bytes are the device's alone: the session's
    /// world stays as it is.
    pub fn write_source(&mut self, name: &str, offset: u64, bytes: &[u8]) -> Result<(), WriteError> {
        let source = self.source(name).ok_or_else(|| WriteError::NotThere { name: name.to_owned() })?;
        source.write(offset, bytes)
    }

    /// Extent of the output in pixels: that of the window, scaled.
    pub fn size(&self) -> [u32; 2] {
        self.viewport().output()
    }

    /// The window's extent and the scale of the output.
    pub fn viewport(&self) -> &Viewport {
        &self.renderer.shown.viewport
    }

    /// Changes the extent of the window in pixels from the next frame on. A window without area keeps the last extent.
    pub fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            self.set_viewport(Viewport::new([width, height], self.viewport().scale()));
        }
    }

    /// Changes how many pixels the output has for each pixel of the window, along each axis, from the next frame on:
    /// [`Viewport::SCALES`] bounds it.
    pub fn set_scale(&mut self, scale: f64) {
        self.set_viewport(Viewport::new(self.viewport().window(), scale));
    }

    fn set_viewport(&mut self, viewport: Viewport) {
        if viewport != self.renderer.shown.viewport {
            self.renderer.shown.viewport = viewport;
            self.settings_changed();
        }
    }

    /// Changes how long a frame may take before the device counts as lost; on a software device six times as long.
    pub fn set_watchdog(&mut self, limit: std::time::Duration) {
        self.options.watchdog = limit;
        self.renderer.executor.set_watchdog(limit * patience(self.device()));
    }

    /// Gives the device up without waiting for what it works on, so that a session can be dropped at once.
    pub fn abandon_device(&mut self) {
        self.renderer.executor.abandon();
    }

    /// The clock.
    pub fn clock(&self) -> &Clock {
        &self.playback.clock
    }

    /// Stops or starts the clock. Frames are drawn all the same, of the same moment.
    pub fn pause(&mut self, paused: bool) {
        self.playback.clock.set_paused(paused);
    }

    /// While paused: lets one frame pass.
    pub fn step(&mut self) {
        self.playback.clock.step();
    }

    /// The next frame is another one of the moment of the last: what passes add up over frames goes on, and time does not.
    pub fn again(&mut self) {
        self.playback.clock.again();
    }

    /// Puts the next frame at so many seconds. A float is taken for the fraction that it was rounded from, so that `62.0 / 60.0` is the
    /// time of frame 62.
    pub fn seek(&mut self, seconds: impl Into<Moment>) {
        self.playback.clock.seek(seconds.into());
    }

    /// Starts over at a later frame: the next one is frame `index`, at its time. With a fixed step, the frame after it is the one that a run
    /// from the start gives, unless the graph looks back ([`raxel_graph::plan::Plan::uses_history`]).
    pub fn start_at(&mut self, index: u64) {
        self.reset();
        self.playback.clock.start_at(index);
    }

    /// Shifts the rays of all pixels by a part of a pixel, right and down, until it is changed: by a shear of the camera's matrices,
    /// which shaders need not know of. Pictures of many shifts, averaged, have smooth edges. `[0.0, 0.0]` shifts nothing.
    pub fn set_subpixel(&mut self, offset: [f64; 2]) {
        self.playback.view.subpixel = offset;
    }

    /// Starts over: clock, history and every resource as at the first frame. Params, camera and debug target stay.
    pub fn reset(&mut self) {
        self.playback.clock.reset();
        self.playback.inputs.reset();
        self.playback.view.cut();
        self.world.cut();
        self.renderer.reset();
        self.renderer.forget_reports();
    }

    /// The user moved something that a demo drives: from here on the demo is only looked at, not followed. Nothing jumps.
    pub fn take_over(&mut self) {
        if self.playback.take_over(&self.renderer.graph) {
            self.settings_changed();
        }
    }

    /// Lets the demo drive again.
    pub fn hand_back(&mut self) {
        self.playback.demo.taken_over = false;
        self.renderer.plans.stale = true;
    }

    /// Whether a demo drives.
    pub fn demo_drives(&self) -> bool {
        self.playback.demo.drives()
    }

    /// What builds are to be made for.
    pub(super) fn build_settings(&self) -> BuildSettings {
        let shown = &self.renderer.shown;
        BuildSettings {
            graph_path: self.files.state.graph_path.clone(),
            output: shown.viewport.output(),
            debug_target: shown.debug_target.clone(),
            pinned: shown.pinned.clone(),
            observe: self.options.observe,
            params: self.playback.params.of_frame(&self.renderer.graph),
            alias: self.options.alias,
            context: self.renderer.context.clone(),
        }
    }

    /// What a plan of what runs is to be made for.
    pub(super) fn selection_now(&self) -> Selection {
        self.build_settings().selection(self.graph_path(), &self.renderer.graph, &self.world.shown)
    }

    /// Something was changed that plans depend on: builds must know, and the next frame looks whether another plan is needed.
    pub(super) fn settings_changed(&mut self) {
        self.renderer.plans.stale = true;
        self.files.set_settings(|| self.build_settings());
    }
}
