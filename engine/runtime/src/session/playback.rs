//! The inputs of a frame apart from its world: the time, the camera, and the values of params, as the user and a demo set them.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_execute::moment::{Fraction, Moment};
use raxel_execute::{Builtins, Override};
use raxel_graph::checked::{Graph, ParamId, Value};

use crate::camera::Camera;
use crate::clock::{Clock, FrameTime, Pace};
use crate::debug_target::DebugTarget;
use crate::inputs::{DAY, InputState, Microphone, ShownInputs};
use crate::params::{Params, SetError};
use crate::timeline::Demo;
use crate::world::SessionWorld;

use super::members::find_member;
use super::take::TakeSoFar;

/// The clock, and everything that follows it.
pub(super) struct Playback {
    pub clock: Clock,
    pub view: CameraView,
    pub inputs: InputState,
    pub microphone: Microphone,
    pub params: ParamValues,
    pub demo: DemoPlayback,
    /// Records the frames of a take.
    pub take: Option<TakeSoFar>,
}

/// Where the world is seen from.
#[derive(Clone, Copy)]
pub(super) struct CameraView {
    pub camera: Camera,
    /// The camera of the last frame.
    pub previous: Camera,
    /// Shift of all rays in pixels, right and down.
    pub subpixel: [f64; 2],
}

/// Params, and values of members of blocks in place of the graph's.
pub(super) struct ParamValues {
    /// As the user set them.
    pub set: Params,
    /// In this frame: the user's, under those of the demo.
    pub shown: Vec<Value>,
    /// Members of blocks that have a value of the user's, by pass and name.
    members: BTreeMap<(String, String), Value>,
    /// The same in the graph that runs.
    pub overrides: Vec<Override>,
}

/// The demo, and how far it drives.
pub(super) struct DemoPlayback {
    pub demo: Option<Arc<Demo>>,
    /// The user moved: the demo no longer drives.
    pub taken_over: bool,
    /// The target that it asked for in the last frame.
    pub target: Option<DebugTarget>,
    /// It does not change the shown target.
    pub target_held: bool,
    /// The params that it does not drive at the moment: somebody moves them.
    pub released: Vec<String>,
}

/// The changes that a demo makes from one frame to the next, besides camera and params.
#[derive(Default)]
pub(super) struct Followed {
    /// There is no way from the last picture to this one.
    pub cut: bool,
    /// Another debug target is to be shown.
    pub target: Option<DebugTarget>,
}

impl Playback {
    /// Before the first frame.
    pub(crate) fn new(step: Option<f64>, camera: Camera, params: Params, demo: Option<Arc<Demo>>) -> Self {
        Self {
            clock: Clock::new(step.map_or(Pace::Live, |step| Pace::Fixed(Fraction::of(step)))),
            view: CameraView { camera, previous: camera, subpixel: [0.0; 2] },
            inputs: InputState::default(),
            microphone: Microphone::default(),
            params: ParamValues {
                shown: params.values().to_vec(),
                set: params,
                members: BTreeMap::new(),
                overrides: Vec::new(),
            },
            demo: DemoPlayback { demo, taken_over: false, target: None, target_held: false, released: Vec::new() },
            take: None,
        }
    }

    /// Brings camera and params to a time, as the demo has them; `before` is the time of the last frame.
    pub(crate) fn follow_demo(&mut self, before: Option<Moment>, time: Moment, graph: &Graph) -> Followed {
        let mut followed = Followed::default();
        self.params.forget_demo();
        let Some(demo) = self.demo.driving() else { return followed };
        if let Some(camera) = demo.camera(time) {
            self.view.camera = camera;
        }
        let released = |id: ParamId| self.demo.released.contains(&graph.params[id.0 as usize].name);
        for (id, value) in demo.params(time, graph).filter(|(id, _)| !released(*id)) {
            self.params.shown[id.0 as usize] = value;
        }
        followed.cut = before.is_some_and(|before| demo.cuts_between(before, time));
        // A demo changes the shown target at its keys, not in between: a choice of the user's stays until the next key.
        let target = demo.debug_target(time);
        if self.demo.target.as_ref() != target && !self.demo.target_held {
            let target = target.cloned();
            followed.target = Some(target.clone().unwrap_or_default());
            self.demo.target = target;
        }
        followed
    }

    /// Brings the inputs to a time: the demo's, over the live ones. `before` is the time of the last frame.
    pub(crate) fn follow_inputs(&mut self, before: Option<Moment>, time: Moment, output: [u32; 2]) {
        let fixed = matches!(self.clock.pace(), Pace::Fixed(_)) || self.demo.drives();
        self.inputs.advance(fixed.then(|| time.seconds()));
        let Some(demo) = self.demo.driving() else { return };
        let local = demo.local_time(time);
        let Some(inputs) = &demo.inputs else {
            self.inputs.shown.time_of_day = local.rem_euclid(DAY);
            return;
        };
        let before = before.or_else(|| self.clock.before_first()).map(|before| demo.local_time(before));
        let scale = [0, 1].map(|axis| f64::from(output[axis]) / f64::from(demo.size[axis]));
        inputs.lay_over(&mut self.inputs.shown, before, local, scale);
    }

    /// Brings the microphone to a time: to the file of a demo that drives, or to its other source.
    pub(crate) fn follow_microphone(&mut self, time: Moment) {
        let demo = self.demo.driving().and_then(|demo| Some((&demo.heard.as_ref()?.samples, demo.local_time(time))));
        self.microphone.follow(time.seconds(), demo);
    }

    /// The user drives from here on, with the values of this frame. False when no demo drives.
    pub(crate) fn take_over(&mut self, graph: &Graph) -> bool {
        if !self.demo.drives() {
            return false;
        }
        self.demo.taken_over = true;
        let ParamValues { set, shown, .. } = &mut self.params;
        for (param, value) in graph.params.iter().zip(shown.iter()) {
            // Values of this frame; the graph's own types and ranges always fit.
            let _ = set.set(graph, &param.name, *value);
        }
        self.params.forget_demo();
        true
    }
}

impl DemoPlayback {
    /// The demo, while it drives.
    pub(crate) fn driving(&self) -> Option<&Arc<Demo>> {
        self.demo.as_ref().filter(|_| !self.taken_over)
    }

    /// Whether it drives.
    pub(crate) fn drives(&self) -> bool {
        self.driving().is_some()
    }
}

impl ParamValues {
    /// The values are those that the user set.
    pub(crate) fn forget_demo(&mut self) {
        self.shown.clear();
        self.shown.extend_from_slice(self.set.values());
    }

    /// The params with the values of this frame.
    pub(crate) fn of_frame(&self, graph: &Graph) -> Params {
        let mut params = self.set.clone();
        for (param, (shown, set)) in graph.params.iter().zip(self.shown.iter().zip(self.set.values())) {
            if shown != set {
                // A demo's value, which was checked against the param.
                let _ = params.set(graph, &param.name, *shown);
            }
        }
        params
    }

    /// Replaces the value of a member of a pass's blocks.
    pub(crate) fn set_member(&mut self, graph: &Graph, pass: &str, member: &str, value: Value) -> Result<(), SetError> {
        for change in find_member(graph, pass, member, value)? {
            self.overrides
                .retain(|known| (known.pass, known.uniform, known.fill) != (change.pass, change.uniform, change.fill));
            self.overrides.push(change);
        }
        self.members.insert((pass.to_owned(), member.to_owned()), value);
        Ok(())
    }

    /// Gives a member back to the graph.
    pub(crate) fn unset_member(&mut self, graph: &Graph, pass: &str, member: &str) {
        self.members.remove(&(pass.to_owned(), member.to_owned()));
        self.find_overrides(graph);
    }

    /// Another graph runs: values are kept by name.
    pub(crate) fn adopt(&mut self, graph: &Graph) {
        self.set.adopt(graph);
        self.forget_demo();
        self.find_overrides(graph);
    }

    fn find_overrides(&mut self, graph: &Graph) {
        let found =
            self.members.iter().filter_map(|((pass, member), value)| find_member(graph, pass, member, *value).ok());
        self.overrides = found.flatten().collect();
    }
}

impl CameraView {
    /// There is no way from the last picture to the next one.
    pub(crate) fn cut(&mut self) {
        self.previous = self.camera;
    }

    /// The shaders' inputs about time, view and the bounds of the world.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "shaders get 32-bit floats, and the number of the frame modulo 2³²"
    )]
    pub(crate) fn builtins(
        &self,
        time: &FrameTime,
        inputs: &ShownInputs,
        output: [u32; 2],
        world: &SessionWorld,
    ) -> Builtins {
        let mut builtins = Builtins {
            frame_index: time.index as u32,
            frame_time: time.time.seconds() as f32,
            frame_delta: time.delta as f32,
            cursor_position: inputs.cursor.unwrap_or([-1; 2]),
            input_buttons: inputs.buttons,
            input_pressed: inputs.pressed,
            input_drag: inputs.drag,
            input_wheel: inputs.wheel.map(|lines| lines as f32),
            input_gamepad_sticks: inputs.gamepad.sticks.map(|axis| axis as f32),
            input_gamepad_triggers: inputs.gamepad.triggers.map(|axis| axis as f32),
            input_gamepad_buttons: inputs.gamepad.buttons,
            input_gamepad_pressed: inputs.gamepad_pressed,
            input_time_of_day: inputs.time_of_day as f32,
            ..crate::builtins::of(&self.camera, &self.previous, output, world)
        };
        if self.subpixel.iter().any(|offset| *offset != 0.0) {
            let aspect = f64::from(builtins.output_aspect);
            let tan = self.camera.tan_half_fov(aspect).as_dvec2().to_array();
            // A pixel is 2 / extent wide where the picture reaches from −1 to 1.
            let shift = |axis: usize| 2.0 * self.subpixel[axis] / f64::from(output[axis]) * tan[axis];
            let sheared = self.camera.sheared([shift(0), -shift(1)]);
            builtins.camera_view_to_world = sheared.view_to_world.to_cols_array_2d();
            builtins.camera_world_to_view = sheared.world_to_view.to_cols_array_2d();
        }
        builtins
    }
}
