//! The inputs of a frame: builtin values, params, overrides, the clock.

use raxel_graph::checked::{Builtin, PassId, Value};

use crate::moment::Moment;

/// Everything that may change from frame to frame without a new plan.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs<'a> {
    /// Values of the `from = "…"` words.
    pub builtins: &'a Builtins,
    /// Values of the params, by `ParamId`; a param past the end has its default.
    pub params: &'a [Value],
    /// Members whose values are replaced, whatever the file has.
    pub overrides: &'a [Override],
    /// Time on the session's clock: decides which passes with `every = { hz }` are due, and how many ticks of each clock.
    pub clock: Moment,
    /// Passes of the file that are switched off, in every round. They leave their outputs as they are.
    pub disabled: &'a [PassId],
}

/// A replaced push-constant or uniform member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Override {
    /// The pass of the file; every round of it is meant.
    pub pass: PassId,
    /// `None` for the push block, else an index into the pass's `uniforms`.
    pub uniform: Option<u32>,
    /// Index into the block's fills.
    pub fill: u32,
    /// The value. Components are converted to the member's type; missing ones are left as they are.
    pub value: Value,
}

/// A value for every [`Builtin`]. Cells and bounds are voxels; lengths are voxels; matrices are columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Builtins {
    /// `camera.cell`.
    pub camera_cell: [i32; 3],
    /// `camera.frac`.
    pub camera_frac: [f32; 3],
    /// `camera.view_to_world`.
    pub camera_view_to_world: [[f32; 4]; 4],
    /// `camera.world_to_view`.
    pub camera_world_to_view: [[f32; 4]; 4],
    /// `camera.fov`, radians.
    pub camera_fov: f32,
    /// `camera.tan_half_fov`, horizontal and vertical.
    pub camera_tan_half_fov: [f32; 2],
    /// `camera.previous.cell`.
    pub camera_previous_cell: [i32; 3],
    /// `camera.previous.frac`.
    pub camera_previous_frac: [f32; 3],
    /// `camera.previous.view_to_world`.
    pub camera_previous_view_to_world: [[f32; 4]; 4],
    /// `camera.previous.world_to_view`.
    pub camera_previous_world_to_view: [[f32; 4]; 4],
    /// `frame.index`; also decides which passes with `every = { frames }` are due.
    pub frame_index: u32,
    /// `frame.time`, seconds.
    pub frame_time: f32,
    /// `frame.delta`, seconds.
    pub frame_delta: f32,
    /// `frame.still`, frames; also decides which passes with `every = { still }` are due.
    pub frame_still: u32,
    /// `history.valid`: 0 or 1.
    pub history_valid: u32,
    /// `output.size`, pixels.
    pub output_size: [i32; 2],
    /// `output.aspect`.
    pub output_aspect: f32,
    /// `cursor.position`, pixels from the top left; (−1, −1) without a cursor.
    pub cursor_position: [i32; 2],
    /// `input.buttons`, a bit each.
    pub input_buttons: u32,
    /// `input.pressed`, a bit each.
    pub input_pressed: u32,
    /// `input.drag`: the pixels of its end and of its beginning.
    pub input_drag: [i32; 4],
    /// `input.wheel`, lines.
    pub input_wheel: [f32; 2],
    /// `input.gamepad_sticks`, each axis in [−1, 1].
    pub input_gamepad_sticks: [f32; 4],
    /// `input.gamepad_triggers`, in [0, 1].
    pub input_gamepad_triggers: [f32; 2],
    /// `input.gamepad_buttons`, a bit each.
    pub input_gamepad_buttons: u32,
    /// `input.gamepad_pressed`, a bit each.
    pub input_gamepad_pressed: u32,
    /// `input.time_of_day`, seconds.
    pub input_time_of_day: f32,
    /// `world.min`.
    pub world_min: [i32; 3],
    /// `world.max`.
    pub world_max: [i32; 3],
    /// `world.voxels`.
    pub world_voxels: u32,
    /// `world.serial`.
    pub world_serial: u32,
    /// `world.edited`.
    pub world_edited: u32,
    /// `world.changed_min`.
    pub world_changed_min: [i32; 3],
    /// `world.changed_max`.
    pub world_changed_max: [i32; 3],
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl Default for Builtins {
    /// A camera at the origin that looks along −Z, a one-pixel output, an empty world.
    fn default() -> Self {
        Self {
            camera_cell: [0; 3],
            camera_frac: [0.0; 3],
            camera_view_to_world: IDENTITY,
            camera_world_to_view: IDENTITY,
            camera_fov: std::f32::consts::FRAC_PI_2,
            camera_tan_half_fov: [1.0; 2],
            camera_previous_cell: [0; 3],
            camera_previous_frac: [0.0; 3],
            camera_previous_view_to_world: IDENTITY,
            camera_previous_world_to_view: IDENTITY,
            frame_index: 0,
            frame_time: 0.0,
            frame_delta: 0.0,
            frame_still: 0,
            history_valid: 0,
            output_size: [1; 2],
            output_aspect: 1.0,
            cursor_position: [-1; 2],
            input_buttons: 0,
            input_pressed: 0,
            input_drag: [-1; 4],
            input_wheel: [0.0; 2],
            input_gamepad_sticks: [0.0; 4],
            input_gamepad_triggers: [0.0; 2],
            input_gamepad_buttons: 0,
            input_gamepad_pressed: 0,
            input_time_of_day: 0.0,
            world_min: [0; 3],
            world_max: [0; 3],
            world_voxels: 0,
            world_serial: 0,
            world_edited: 0,
            world_changed_min: [i32::MIN; 3],
            world_changed_max: [i32::MAX; 3],
        }
    }
}

impl Builtins {
    /// The value of one builtin, in the type [`Builtin::ty`].
    pub fn value(&self, builtin: Builtin) -> Value {
        match builtin {
            Builtin::CameraCell => Value::IVec3(self.camera_cell),
            Builtin::CameraFrac => Value::Vec3(self.camera_frac),
            Builtin::CameraViewToWorld => Value::Mat4(self.camera_view_to_world),
            Builtin::CameraWorldToView => Value::Mat4(self.camera_world_to_view),
            Builtin::CameraFov => Value::F32(self.camera_fov),
            Builtin::CameraTanHalfFov => Value::Vec2(self.camera_tan_half_fov),
            Builtin::CameraPreviousCell => Value::IVec3(self.camera_previous_cell),
            Builtin::CameraPreviousFrac => Value::Vec3(self.camera_previous_frac),
            Builtin::CameraPreviousViewToWorld => Value::Mat4(self.camera_previous_view_to_world),
            Builtin::CameraPreviousWorldToView => Value::Mat4(self.camera_previous_world_to_view),
            Builtin::FrameIndex => Value::U32(self.frame_index),
            Builtin::FrameTime => Value::F32(self.frame_time),
            Builtin::FrameDelta => Value::F32(self.frame_delta),
            Builtin::FrameStill => Value::U32(self.frame_still),
            Builtin::HistoryValid => Value::U32(self.history_valid),
            Builtin::OutputSize => Value::IVec2(self.output_size),
            Builtin::OutputAspect => Value::F32(self.output_aspect),
            Builtin::CursorPosition => Value::IVec2(self.cursor_position),
            Builtin::InputButtons => Value::U32(self.input_buttons),
            Builtin::InputPressed => Value::U32(self.input_pressed),
            Builtin::InputDrag => Value::IVec4(self.input_drag),
            Builtin::InputWheel => Value::Vec2(self.input_wheel),
            Builtin::InputGamepadSticks => Value::Vec4(self.input_gamepad_sticks),
            Builtin::InputGamepadTriggers => Value::Vec2(self.input_gamepad_triggers),
            Builtin::InputGamepadButtons => Value::U32(self.input_gamepad_buttons),
            Builtin::InputGamepadPressed => Value::U32(self.input_gamepad_pressed),
            Builtin::InputTimeOfDay => Value::F32(self.input_time_of_day),
            Builtin::WorldMin => Value::IVec3(self.world_min),
            Builtin::WorldMax => Value::IVec3(self.world_max),
            Builtin::WorldVoxels => Value::U32(self.world_voxels),
            Builtin::WorldSerial => Value::U32(self.world_serial),
            Builtin::WorldEdited => Value::U32(self.world_edited),
            Builtin::WorldChangedMin => Value::IVec3(self.world_changed_min),
            Builtin::WorldChangedMax => Value::IVec3(self.world_changed_max),
        }
    }
}
