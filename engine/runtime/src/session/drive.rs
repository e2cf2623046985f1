//! Driving a session by names: params, push values, camera, debug target, size, clock.

use std::sync::Arc;

use raxel_diagnostics::files::join;
use raxel_execute::moment::Moment;
use raxel_execute::{
    Builder, Comparison, ExternalResource, Mismatch, ReadTicket, Reference, Region, TexelTrace, Thumbnail, TracedTexel,
    WriteError,
};
use raxel_graph::checked::{Display, Param, Value};
use raxel_graph::supply::MICROPHONE;

use super::Session;
use super::renderer::patience;
use crate::build::Selection;
use crate::camera::Camera;
use crate::clock::Clock;
use crate::debug_target::{DebugTarget, DebugTargetError};
use crate::inputs::{Inputs, Microphone};
use crate::params::{self, SetError};
use crate::present::Viewport;
use crate::reload::project_state::BuildSettings;

impl Session {
    /// The params that the graph declares.
    pub fn params(&self) -> &[Param] {
        &self.renderer.graph.params
    }

    /// The value of a param in the last frame.
    pub fn param(&self, name: &str) -> Result<Value, SetError> {
        match self.renderer.graph.find_param(name) {
            Some(id) => Ok(self.playback.params.shown[id.0 as usize]),
            None => Err(SetError::unknown("param", name, self.params().iter().map(|param| param.name.as_str()))),
        }
    }

    /// Sets a param. The value lasts over reloads, as long as the graph declares the name with this type.
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

    /// Returns a param to the default of the graph.
    pub fn unset_param(&mut self, name: &str) -> Result<(), SetError> {
        self.playback.params.set.unset(&self.renderer.graph, name)?;
        self.params_changed();
        Ok(())
    }

    fn params_changed(&mut self) {
        self.playback.params.forget_demo();
        self.settings_changed();
    }

    /// Overrides the value that the graph gives to a member of a pass's push-constant or uniform block. The override lasts over reloads, as
    /// long as the pass has the member.
    pub fn set_push(&mut self, pass: &str, member: &str, value: Value) -> Result<(), SetError> {
        self.playback.params.set_member(&self.renderer.graph, pass, member, value)
    }

    /// Removes the override of [`Self::set_push`], so that the graph gives the value again.
    pub fn unset_push(&mut self, pass: &str, member: &str) {
        self.playback.params.unset_member(&self.renderer.graph, pass, member);
    }

    /// The camera of the next frame.
    pub fn camera(&self) -> &Camera {
        &self.playback.view.camera
    }

    /// Moves the camera. A demo with camera keys overrides it, until [`Session::take_over`].
    pub fn set_camera(&mut self, camera: Camera) {
        self.playback.view.camera = camera;
    }

    /// Sets the cursor: a pixel of the window, counted from the top left, or `None`. Shaders get the pixel of the output under it.
    pub fn set_cursor(&mut self, pixel: Option<[i32; 2]>) {
        self.playback.inputs.live.cursor = pixel.map(|pixel| self.viewport().to_output(pixel));
    }

    /// The inputs that a person holds and turns, for the next frame. Inputs that a demo drives win, until [`Session::take_over`].
    pub fn inputs(&mut self) -> &mut Inputs {
        &mut self.playback.inputs.live
    }

    /// The debug target.
    pub fn debug_target(&self) -> &DebugTarget {
        &self.renderer.shown.debug_target
    }

    /// Shows the debug target that a text names: `depth`, `color@1`, `pyramid,mip=2`, `color,after=sky`.
    pub fn set_debug_target_text(&mut self, text: &str) -> Result<(), DebugTargetError> {
        self.set_debug_target(DebugTarget::parse(text)?)
    }

    /// Shows a debug target. An empty one stands for the target that the graph presents.
    pub fn set_debug_target(&mut self, target: DebugTarget) -> Result<(), DebugTargetError> {
        target.resolve(&self.renderer.graph)?;
        self.renderer.shown.debug_target = target;
        self.settings_changed();
        Ok(())
    }

    /// Shows a debug target that a demo cannot change. At least one graph of the demo must have it. The other graphs show their own target.
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

    /// Overrides the display map, range and channel that the graph declares for the debug target. `None` removes the override.
    pub fn set_display(&mut self, display: Option<Display>) {
        self.renderer.shown.display = display;
        self.renderer.executor.set_display(display);
    }

    /// The override of [`Self::set_display`].
    pub fn display(&self) -> Option<Display> {
        self.renderer.shown.display
    }

    /// Shows a part of the debug target from the next frame on.
    pub fn set_region(&mut self, region: Region) {
        self.renderer.shown.region = region;
        self.renderer.executor.set_region(region);
    }

    /// Makes small pictures of all targets that passes write, from the next frame on, or no more: a few in each frame, right after their passes.
    /// A frame that stands still runs passes again for pictures that are missing or stale, and then stands still again.
    pub fn make_thumbnails(&mut self, on: bool) {
        self.renderer.executor.make_thumbnails(on);
    }

    /// The small pictures that have arrived since the last call.
    pub fn take_thumbnails(&mut self) -> Vec<Thumbnail> {
        self.renderer.executor.take_thumbnails()
    }

    /// Follows a texel of a target from the next frame on, or none: each dispatch that may write it is followed by a copy of it.
    pub fn trace_texel(&mut self, texel: Option<TracedTexel>) {
        self.renderer.executor.trace_texel(texel);
    }

    /// The followed texel in the last frame, once; `None` if no pass wrote it.
    pub fn texel_trace(&mut self) -> Option<ReadTicket<TexelTrace>> {
        self.renderer.executor.texel_trace()
    }

    /// Compares the debug target with a reference from the next frame on, while [`Self::mismatch`] returns `None`. A loss of the device
    /// ends the comparison: upload the reference again with [`Self::builder`].
    pub fn set_comparison(&mut self, compared: Option<(Arc<Reference>, Comparison)>) {
        if self.renderer.shown.live.take().is_some() {
            self.settings_changed();
        }
        self.renderer.executor.set_comparison(compared);
    }

    /// Compares the debug target with another target as both are at the end of each frame, from the next frame on, while
    /// [`Self::live_mismatch`] returns `None`. [`Self::set_comparison`] ends that. Call it again after a reload: it finds the target by its
    /// name.
    pub fn compare_live(&mut self, target: &DebugTarget, comparison: Comparison) -> Result<(), DebugTargetError> {
        let part = target.resolve(&self.renderer.graph)?;
        let name = &self.renderer.graph.resource(part.resource).name;
        if self.renderer.shown.live.as_ref() != Some(name) {
            self.renderer.shown.live = Some(name.clone());
            self.settings_changed();
        }
        self.renderer.executor.compare_live((part, comparison));
        Ok(())
    }

    /// Returns why the debug target cannot be compared with the target of [`Self::compare_live`], or `None` if it can.
    pub fn live_mismatch(&self) -> Option<Mismatch> {
        self.renderer.executor.live_mismatch()
    }

    /// Returns why the debug target cannot be compared with a reference, or `None` if it can.
    pub fn mismatch(&self, reference: &Reference) -> Option<Mismatch> {
        self.renderer.executor.mismatch(reference)
    }

    /// Returns a builder that uploads references to the session's device, from any thread.
    pub fn builder(&self) -> Builder {
        self.renderer.context.builder.clone()
    }

    /// Keeps a resource readable at the end of each frame, from the next frame on. Only [`Observe::Shown`] needs this.
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

    /// Returns a source on the device, such as `world.tree64`: its version, and a way to write parts of it between frames. `None` if no
    /// pass that runs binds it. An edit of the world and a loss of the device replace it.
    pub fn source(&self, name: &str) -> Option<Arc<ExternalResource>> {
        self.renderer.context.sources.find(name, &self.world.shown)
    }

    /// Replaces bytes of the buffer of a source before the next frame, without waiting. `offset` is in bytes. Only the device's copy
    /// changes: the session's world does not.
    pub fn write_source(&mut self, name: &str, offset: u64, bytes: &[u8]) -> Result<(), WriteError> {
        let source = self.source(name).ok_or_else(|| WriteError::NotThere { name: name.to_owned() })?;
        source.write(offset, bytes)
    }

    /// Extent of the output in pixels: the extent of the window times the scale.
    pub fn size(&self) -> [u32; 2] {
        self.viewport().output()
    }

    /// The window's extent and the scale of the output.
    pub fn viewport(&self) -> &Viewport {
        &self.renderer.shown.viewport
    }

    /// Sets the extent of the window in pixels, from the next frame on. If one of the two is 0, the last extent stays.
    pub fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            self.set_viewport(Viewport::new([width, height], self.viewport().scale()));
        }
    }

    /// Sets how many pixels the output has for each pixel of the window, along each axis, from the next frame on. raxel clamps the scale to
    /// [`Viewport::SCALES`].
    pub fn set_scale(&mut self, scale: f64) {
        self.set_viewport(Viewport::new(self.viewport().window(), scale));
    }

    fn set_viewport(&mut self, viewport: Viewport) {
        if viewport != self.renderer.shown.viewport {
            self.renderer.shown.viewport = viewport;
            self.settings_changed();
        }
    }

    /// Sets the longest time in which the device may finish no pass. After it, the device counts as lost. A software device gets six times
    /// as long.
    pub fn set_watchdog(&mut self, limit: std::time::Duration) {
        self.options.watchdog = limit;
        self.renderer.executor.set_watchdog(limit * patience(self.device()));
    }

    /// Abandons the device without waiting for its work, so that the session can be dropped at once.
    pub fn abandon_device(&mut self) {
        self.renderer.executor.abandon();
    }

    /// The microphone, which targets with `source = "input.microphone"` hear.
    pub fn microphone(&mut self) -> &mut Microphone {
        &mut self.playback.microphone
    }

    /// Whether the graph hears the microphone.
    pub fn hears_microphone(&self) -> bool {
        self.renderer.graph.resources.iter().any(|resource| resource.kind.supplied_by() == Some(MICROPHONE))
    }

    /// Whether a device is to capture: the graph hears the microphone, and no file is heard in its place.
    pub fn wants_capture(&self) -> bool {
        let of_demo = self.playback.demo.driving().is_some_and(|demo| demo.heard.is_some());
        self.hears_microphone() && !of_demo && self.playback.microphone.given().is_none()
    }

    /// Lets the microphone hear a file of the project from the start of the session's time on, and silence after its end. None: it hears a
    /// device again. The error has the reason why the file cannot be read; the microphone then keeps its source.
    pub fn give_sound(&mut self, path: Option<&str>) -> Result<(), String> {
        let read = |path: &str| {
            let path = join("", path).ok_or_else(|| format!("`{path}` is not a path inside the project"))?;
            self.files.loader.sound(&path)
        };
        let sound = path.map(read).transpose()?;
        self.playback.microphone.give(sound);
        Ok(())
    }

    /// The clock.
    pub fn clock(&self) -> &Clock {
        &self.playback.clock
    }

    /// Pauses or resumes the clock. While it is paused, frames still run, all at the same time, as after [`Self::again`].
    pub fn pause(&mut self, paused: bool) {
        self.playback.clock.set_paused(paused);
    }

    /// While paused, lets time pass for one frame.
    pub fn step(&mut self) {
        self.playback.clock.step();
    }

    /// Runs the next frame at the time of the last one. `frame.index` goes on, and so do passes that accumulate over frames.
    pub fn again(&mut self) {
        self.playback.clock.again();
    }

    /// Runs the next frame as the last one again: its time and its `frame.index` are the same.
    pub fn repeat(&mut self) {
        self.playback.clock.repeat();
    }

    /// Sets the time of the next frame, in seconds. A float stands for the fraction that it was rounded from, so that `62.0 / 60.0` is
    /// exactly the time of frame 62 at 60 frames a second.
    pub fn seek(&mut self, seconds: impl Into<Moment>) {
        self.playback.clock.seek(seconds.into());
    }

    /// Starts over at a later frame: the next frame is frame `index`, at its time. With a fixed step, the frames after it equal those of a
    /// run from the start, unless the graph uses earlier frames ([`raxel_graph::plan::Plan::uses_history`]).
    pub fn start_at(&mut self, index: u64) {
        self.reset();
        self.playback.clock.start_at(index);
    }

    /// Shifts the rays of all pixels by a part of a pixel, right and down. The mean of pictures with many shifts has smooth edges. A shear
    /// of the camera's matrices makes the shift, so shaders need no change. `[0.0, 0.0]` ends it.
    pub fn set_subpixel(&mut self, offset: [f64; 2]) {
        self.playback.view.subpixel = offset;
    }

    /// Starts over: clock, history and all resources are as before the first frame. Params, camera and debug target stay.
    pub fn reset(&mut self) {
        self.playback.clock.reset();
        self.playback.inputs.reset();
        self.playback.view.cut();
        self.world.cut();
        self.renderer.reset();
        self.renderer.forget_reports();
    }

    /// Stops following the demo: camera and params stay where the demo left them, and the program may change them.
    pub fn take_over(&mut self) {
        if self.playback.take_over(&self.renderer.graph) {
            self.settings_changed();
        }
    }

    /// Follows the demo again.
    pub fn hand_back(&mut self) {
        self.playback.demo.taken_over = false;
        self.renderer.plans.stale = true;
    }

    /// Keeps the demo from driving a param, besides those that were released before. With `None`, the demo drives all of them again. Camera and
    /// other tracks go on.
    pub fn release_param(&mut self, name: Option<&str>) {
        let released = &mut self.playback.demo.released;
        match name {
            Some(name) if released.iter().all(|known| known != name) => released.push(name.to_owned()),
            Some(_) => {}
            None => released.clear(),
        }
    }

    /// Whether the session follows a demo.
    pub fn demo_drives(&self) -> bool {
        self.playback.demo.drives()
    }

    /// The settings of builds.
    pub(super) fn build_settings(&self) -> BuildSettings {
        let shown = &self.renderer.shown;
        BuildSettings {
            graph_path: self.files.state.graph_path.clone(),
            output: shown.viewport.output(),
            debug_target: shown.debug_target.clone(),
            pinned: shown.kept(),
            observe: self.options.observe,
            params: self.playback.params.of_frame(&self.renderer.graph),
            alias: self.options.alias,
            context: self.renderer.context.clone(),
        }
    }

    /// The settings for a plan of the running graph.
    pub(super) fn selection_now(&self) -> Selection {
        self.build_settings().selection(self.graph_path(), &self.renderer.graph, &self.world.shown)
    }

    /// Something was changed that plans depend on: builds must know, and the next frame looks whether another plan is needed.
    pub(super) fn settings_changed(&mut self) {
        self.renderer.plans.stale = true;
        self.files.set_settings(|| self.build_settings());
    }
}
