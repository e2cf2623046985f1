//! Driving a session by names: params, push values, camera, debug target, size, clock.

use std::sync::Arc;

use raxel_execute::moment::Moment;
use raxel_execute::{Builder, Comparison, ExternalResource, Mismatch, Override, Reference, Region, WriteError};
use raxel_graph::checked::{Display, Fill, Graph, Param, PassId, Value};

use super::{Session, open};
use crate::build::Selection;
use crate::camera::Camera;
use crate::clock::Clock;
use crate::debug_target::{DebugTarget, DebugTargetError};
use crate::params::{self, Params, SetError};
use crate::present::Viewport;
use crate::reload::project_state::BuildSettings;

impl Session {
    /// The params that the graph declares.
    pub fn params(&self) -> &[Param] {
        &self.graph.params
    }

    /// A param's value in the last frame.
    pub fn param(&self, name: &str) -> Result<Value, SetError> {
        match self.graph.find_param(name) {
            Some(id) => Ok(self.values[id.0 as usize]),
            None => Err(SetError::unknown("param", name, self.graph.params.iter().map(|param| param.name.as_str()))),
        }
    }

    /// Sets a param. The value stays, also over reloads, until the graph no longer declares the name with this type.
    pub fn set_param(&mut self, name: &str, value: Value) -> Result<(), SetError> {
        self.params.set(&self.graph, name, value)?;
        self.params_changed();
        Ok(())
    }

    /// Sets a param from text, as the command line does: `0.5`, `true`, `1,2,3`.
    pub fn set_param_text(&mut self, name: &str, text: &str) -> Result<(), SetError> {
        let value = params::parse(&self.graph, name, text)?;
        self.set_param(name, value)
    }

    /// Brings a param back to the graph's default.
    pub fn unset_param(&mut self, name: &str) -> Result<(), SetError> {
        self.params.unset(&self.graph, name)?;
        self.params_changed();
        Ok(())
    }

    fn params_changed(&mut self) {
        self.values.clear();
        self.values.extend_from_slice(self.params.values());
        self.settings_changed();
    }

    /// Replaces the value of a member of a pass's push-constant or uniform block, whatever the graph says. It stays, also over
    /// reloads, as long as the pass has the member.
    pub fn set_push(&mut self, pass: &str, member: &str, value: Value) -> Result<(), SetError> {
        for change in find_member(&self.graph, pass, member, value)? {
            self.overrides
                .retain(|known| (known.pass, known.uniform, known.fill) != (change.pass, change.uniform, change.fill));
            self.overrides.push(change);
        }
        self.pushes.insert((pass.to_owned(), member.to_owned()), value);
        Ok(())
    }

    /// Gives a member back to the graph.
    pub fn unset_push(&mut self, pass: &str, member: &str) {
        self.pushes.remove(&(pass.to_owned(), member.to_owned()));
        self.find_overrides();
    }

    /// Finds the members that have replaced values, in the graph that runs.
    pub(super) fn find_overrides(&mut self) {
        let graph = &self.graph;
        let found =
            self.pushes.iter().filter_map(|((pass, member), value)| find_member(graph, pass, member, *value).ok());
        self.overrides = found.flatten().collect();
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Moves the camera. A demo that moves it too wins, until [`Session::take_over`].
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }

    /// The pixel of the window under the cursor, from the top left. Shaders are told the pixel of the output.
    pub fn set_cursor(&mut self, pixel: Option<[i32; 2]>) {
        self.cursor = pixel.map(|pixel| self.viewport.to_output(pixel));
    }

    /// The debug target.
    pub fn debug_target(&self) -> &DebugTarget {
        &self.debug_target
    }

    /// Chooses the debug target by its text: `depth`, `color@1`, `pyramid,mip=2`, `color,after=sky`.
    pub fn set_debug_target_text(&mut self, text: &str) -> Result<(), DebugTargetError> {
        self.set_debug_target(DebugTarget::parse(text)?)
    }

    /// Chooses the debug target; an empty one is the graph's own.
    pub fn set_debug_target(&mut self, target: DebugTarget) -> Result<(), DebugTargetError> {
        target.resolve(&self.graph)?;
        self.debug_target = target;
        self.settings_changed();
        Ok(())
    }

    /// Chooses the debug target for good: a demo does not change it any more. One of the demo's graphs must have it; the others show their
    /// own.
    pub fn hold_debug_target(&mut self, target: DebugTarget) -> Result<(), DebugTargetError> {
        let others = self.state.other_graphs.values().filter_map(|part| part.result.as_ref().ok());
        if !others.into_iter().any(|graph| target.resolve(graph).is_ok()) {
            target.resolve(&self.graph)?;
        }
        self.debug_target = target;
        self.settings_changed();
        self.target_held = true;
        Ok(())
    }

    /// Shows the debug target in another way than the graph says: another map, range or channel. `None` goes back to the graph's own.
    pub fn set_display(&mut self, display: Option<Display>) {
        self.display = display;
        self.executor.set_display(display);
    }

    /// Shows a part of the debug target from the next frame on.
    pub fn set_region(&mut self, region: Region) {
        self.region = region;
        self.executor.set_region(region);
    }

    /// Shows the debug target together with a reference from the next frame on, as long as [`Self::mismatch`] has nothing against it. A loss of
    /// the device ends the comparison, and the reference is to be uploaded again ([`Self::builder`]).
    pub fn set_comparison(&mut self, compared: Option<(Arc<Reference>, Comparison)>) {
        self.executor.set_comparison(compared);
    }

    /// Why what is shown cannot be compared with a reference; `None` where it can.
    pub fn mismatch(&self, reference: &Reference) -> Option<Mismatch> {
        self.executor.mismatch(reference)
    }

    /// Uploads references for the session's device, on any thread.
    pub fn builder(&self) -> Builder {
        self.context.builder.clone()
    }

    /// Keeps a resource readable at the end of each frame from the next one on, whatever is shown. Needed with [`Observe::Shown`] only.
    ///
    /// [`Observe::Shown`]: raxel_graph::plan::Observe::Shown
    pub fn pin(&mut self, name: &str) -> Result<(), DebugTargetError> {
        DebugTarget::resource(name).resolve(&self.graph)?;
        if !self.pinned.iter().any(|known| known == name) {
            self.pinned.push(name.to_owned());
            self.settings_changed();
        }
        Ok(())
    }

    /// A source that is on the device, e.g. `world.tree64`: its version, and a way to write parts of it between frames. `None` while
    /// nothing that runs binds it. An edit of the world and a loss of the device put another one in its place.
    pub fn source(&self, name: &str) -> Option<Arc<ExternalResource>> {
        self.context.sources.find(name, &self.world)
    }

    /// Replaces bytes of the buffer of a source, before the next frame. Nothing waits. The bytes are the device's alone: the session's
    /// world stays as it is.
    pub fn write_source(&mut self, name: &str, offset: u64, bytes: &[u8]) -> Result<(), WriteError> {
        let source = self.source(name).ok_or_else(|| WriteError::NotThere { name: name.to_owned() })?;
        source.write(offset, bytes)
    }

    /// Extent of the output in pixels: that of the window, scaled.
    pub fn size(&self) -> [u32; 2] {
        self.viewport.output()
    }

    /// The window's extent and the scale of the output.
    pub fn viewport(&self) -> &Viewport {
        &self.viewport
    }

    /// Changes the extent of the window in pixels from the next frame on. A window without area keeps the last extent.
    pub fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            self.set_viewport(Viewport::new([width, height], self.viewport.scale()));
        }
    }

    /// Changes how many pixels the output has for each pixel of the window, along each axis, from the next frame on:
    /// [`Viewport::SCALES`] bounds it.
    pub fn set_scale(&mut self, scale: f64) {
        self.set_viewport(Viewport::new(self.viewport.window(), scale));
    }

    fn set_viewport(&mut self, viewport: Viewport) {
        if viewport != self.viewport {
            self.viewport = viewport;
            self.settings_changed();
        }
    }

    /// Changes how long a frame may take before the device counts as lost; on a software device six times as long.
    pub fn set_watchdog(&mut self, limit: std::time::Duration) {
        self.options.watchdog = limit;
        self.executor.set_watchdog(limit * open::patience(&self.device));
    }

    /// Gives the device up without waiting for what it works on, so that a session can be dropped at once.
    pub fn abandon_device(&mut self) {
        self.executor.abandon();
    }

    /// The clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Stops or starts the clock. Frames are drawn all the same, of the same moment.
    pub fn pause(&mut self, paused: bool) {
        self.clock.set_paused(paused);
    }

    /// While paused: lets one frame pass.
    pub fn step(&mut self) {
        self.clock.step();
    }

    /// The next frame is another one of the moment of the last: what passes add up over frames goes on, and time does not.
    pub fn again(&mut self) {
        self.clock.again();
    }

    /// Puts the next frame at so many seconds. A float is taken for the fraction that it was rounded from, so that `62.0 / 60.0` is the
    /// time of frame 62.
    pub fn seek(&mut self, seconds: impl Into<Moment>) {
        self.clock.seek(seconds.into());
    }

    /// Starts over at a later frame: the next one is frame `index`, at its time. With a fixed step, the frame after it is the one that a run
    /// from the start gives, unless the graph looks back ([`raxel_graph::plan::Plan::uses_history`]).
    pub fn start_at(&mut self, index: u64) {
        self.reset();
        self.clock.start_at(index);
    }

    /// Shifts the rays of all pixels by a part of a pixel, right and down, until it is changed: by a shear of the camera's matrices,
    /// which shaders need not know of. Pictures of many shifts, averaged, have smooth edges. `[0.0, 0.0]` shifts nothing.
    pub fn set_subpixel(&mut self, offset: [f64; 2]) {
        self.subpixel = offset;
    }

    /// Starts over: clock, history and every resource as at the first frame. Params, camera and debug target stay.
    pub fn reset(&mut self) {
        self.clock.reset();
        self.executor.reset_history();
        self.collected.forget_poses();
        self.warned.forget();
        self.prints.forget();
        self.changed.everything();
        self.previous_camera = self.camera;
        self.still.reset();
        self.history.reset();
    }

    /// The user moved something that a demo drives: from here on the demo is only looked at, not followed. Nothing jumps.
    pub fn take_over(&mut self) {
        if self.taken_over || self.demo.is_none() {
            return;
        }
        self.taken_over = true;
        for (param, value) in self.graph.params.iter().zip(&self.values) {
            // Values of this frame; the graph's own types and ranges always fit.
            let _ = self.params.set(&self.graph, &param.name, *value);
        }
        self.params_changed();
    }

    /// Lets the demo drive again.
    pub fn hand_back(&mut self) {
        self.taken_over = false;
        self.needs_replan = true;
    }

    /// Whether a demo drives.
    pub fn demo_drives(&self) -> bool {
        self.demo.is_some() && !self.taken_over
    }

    /// What builds are to be made for.
    pub(super) fn build_settings(&self) -> BuildSettings {
        BuildSettings {
            graph_path: self.state.graph_path.clone(),
            output: self.viewport.output(),
            debug_target: self.debug_target.clone(),
            pinned: self.pinned.clone(),
            observe: self.options.observe,
            params: self.frame_params(),
            alias: self.options.alias,
            context: self.context.clone(),
        }
    }

    /// What a plan of what runs is to be made for.
    pub(super) fn selection_now(&self) -> Selection {
        self.build_settings().selection(&self.state.graph_path, &self.graph, &self.world)
    }

    /// The params with the values of this frame, for conditions.
    fn frame_params(&self) -> Params {
        let mut params = self.params.clone();
        for (param, (shown, set)) in self.graph.params.iter().zip(self.values.iter().zip(self.params.values())) {
            if shown != set {
                // A demo's value, which was checked against the param.
                let _ = params.set(&self.graph, &param.name, *shown);
            }
        }
        params
    }

    /// Something was changed that plans depend on: builds must know, and the next frame looks whether another plan is needed.
    pub(super) fn settings_changed(&mut self) {
        self.needs_replan = true;
        if let Some(reloader) = &self.reloader {
            reloader.set_settings(self.build_settings());
        }
    }
}

/// The member of the blocks of a pass, in each of its cases, as overrides of that value.
fn find_member(graph: &Graph, pass: &str, member: &str, value: Value) -> Result<Vec<Override>, SetError> {
    let mut cases = graph.cases(pass).peekable();
    if cases.peek().is_none() {
        return Err(SetError::unknown("pass", pass, graph.pass_names()));
    }
    cases.map(|id| find_member_of(graph, id, member, value)).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "a shader numbers its bindings and members in 32 bits")]
fn find_member_of(graph: &Graph, id: PassId, member: &str, value: Value) -> Result<Override, SetError> {
    let found = graph.pass(id);
    let in_block = |uniform: Option<u32>, fills: &[Fill]| {
        let fill = fills.iter().position(|fill| fill.member == member)?;
        Some((uniform, fill))
    };
    let blocks = std::iter::once((None, &found.push))
        .chain(found.uniforms.iter().enumerate().map(|(i, block)| (Some(i as u32), &block.fills)));
    let place = blocks.clone().find_map(|(uniform, fills)| in_block(uniform, fills));
    let Some((uniform, fill)) = place else {
        let names: Vec<&str> = blocks.flat_map(|(_, fills)| fills.iter().map(|fill| fill.member.as_str())).collect();
        return Err(SetError::unknown("push member", member, names.into_iter()));
    };
    let fills = uniform.map_or(&found.push, |index| &found.uniforms[index as usize].fills);
    fits(&fills[fill], value)?;
    Ok(Override { pass: PassId(id.0), uniform, fill: fill as u32, value })
}

/// A value must have as many components as the member; their types are converted.
fn fits(fill: &Fill, value: Value) -> Result<(), SetError> {
    let (rows, columns) = fill.shape;
    if params::components(&value).len() == (rows * columns) as usize {
        return Ok(());
    }
    Err(SetError::WrongShape { name: fill.member.clone(), expected: rows * columns, found: params::type_name(&value) })
}
