//! Members of push-constant and uniform blocks, and where their values come from.

use raxel_shader::interface::Scalar;
use serde::Serialize;

use crate::ir::value::ValueType;

use super::{ClockId, ParamId, ResourceId, RoundIndex, Value};

/// One value put at one offset of a push-constant or uniform block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fill {
    /// Member path, e.g. `exposure` or `sun.direction`.
    pub member: String,
    /// Byte offset in the block.
    pub offset: u32,
    /// Type of the member.
    pub ty: ValueType,
    /// Bytes between columns of a matrix; 0 otherwise.
    pub stride: u32,
    /// Where the value comes from.
    pub from: ValueOrigin,
}

/// A uniform block that raxel keeps and fills each frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UniformBlock {
    /// Index into the shader's `interface.bindings`.
    pub binding: u32,
    /// Bytes.
    pub size: u32,
    /// Values in order of offset.
    pub fills: Vec<Fill>,
}

/// Where a push or uniform value comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ValueOrigin {
    /// Written in the file.
    Value(Value),
    /// A param.
    Param(ParamId),
    /// Something the runtime knows.
    Builtin(Builtin),
    /// A number of the round, as `u32`. Not in the graph of a plan.
    Round(RoundIndex),
    /// Extent of a target's mip 0 in texels; the third axis is its depth or number of layers.
    ExtentOf(ResourceId),
    /// Number of elements of a buffer.
    CountOf(ResourceId),
    /// Index of a material of the world: which name is meant, as an index into [`Graph::materials`](super::Graph::materials).
    Material(u32),
    /// Something that a clock knows: `clock.NAME.tick`.
    Clock(ClockId, ClockValue),
}

/// The values of a clock: the last word of `clock.NAME.tick`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum ClockValue {
    /// `tick`, u32: the number of the tick, from 0 at the start. In a pass of the clock the one that runs, elsewhere the last one
    /// that has run.
    Tick,
    /// `delta`, f32: seconds from tick to tick.
    Delta,
    /// `phase`, f32: time since the last tick was due, as a part of `delta`, in [0, 1).
    Phase,
}

impl ClockValue {
    /// Every value with its word.
    pub const ALL: [(ClockValue, &str); 3] =
        [(ClockValue::Tick, "tick"), (ClockValue::Delta, "delta"), (ClockValue::Phase, "phase")];
}

macro_rules! builtins {
    ($($variant:ident = $name:literal, $scalar:ident, ($rows:literal, $columns:literal), $about:literal;)*) => {
        /// A value that the runtime knows: the `from = "…"` words of a graph file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        pub enum Builtin { $(#[doc = $about] $variant),* }

        impl Builtin {
            /// Every builtin in the order of the documentation.
            pub const ALL: &[Builtin] = &[$(Builtin::$variant),*];

            /// The word in the file, e.g. `camera.cell`.
            pub const fn name(self) -> &'static str {
                match self { $(Builtin::$variant => $name),* }
            }

            /// Its description, in one sentence.
            pub const fn about(self) -> &'static str {
                match self { $(Builtin::$variant => $about),* }
            }

            /// Its type.
            pub const fn ty(self) -> ValueType {
                match self { $(Builtin::$variant => ValueType::matrix(Scalar::$scalar, $rows, $columns)),* }
            }
        }
    };
}

builtins! {
    CameraCell = "camera.cell", I32, (3, 1), "Voxel that holds the camera.";
    CameraFrac = "camera.frac", F32, (3, 1), "Camera's place in its voxel, each component in [0, 1).";
    CameraViewToWorld = "camera.view_to_world", F32, (4, 4), "Rotation from view space (x right, y up, looking along −z) to world space; no translation.";
    CameraWorldToView = "camera.world_to_view", F32, (4, 4), "The inverse rotation.";
    CameraFov = "camera.fov", F32, (1, 1), "Vertical field of view in radians.";
    CameraTanHalfFov = "camera.tan_half_fov", F32, (2, 1), "Tangent of half the field of view, horizontal and vertical.";
    CameraPreviousCell = "camera.previous.cell", I32, (3, 1), "`camera.cell` of the last frame.";
    CameraPreviousFrac = "camera.previous.frac", F32, (3, 1), "`camera.frac` of the last frame.";
    CameraPreviousViewToWorld = "camera.previous.view_to_world", F32, (4, 4), "`camera.view_to_world` of the last frame.";
    CameraPreviousWorldToView = "camera.previous.world_to_view", F32, (4, 4), "`camera.world_to_view` of the last frame.";
    FrameIndex = "frame.index", U32, (1, 1), "Frames since the last reset. Frames during a pause count.";
    FrameTime = "frame.time", F32, (1, 1), "Seconds since the last reset.";
    FrameDelta = "frame.delta", F32, (1, 1), "Seconds since the last frame.";
    FrameStill = "frame.still", U32, (1, 1), "Frames since something other than time changed: camera, params, graph, world, size, cursor, or an input that the graph reads. 0 in the frame of a change, 65,535 at most.";
    HistoryValid = "history.valid", U32, (1, 1), "1 when every history holds what earlier frames wrote. 0 in the first frame, and after a reset, a cut, or a size or an edit that cleared a history.";
    OutputSize = "output.size", I32, (2, 1), "Extent of the output in pixels.";
    OutputAspect = "output.aspect", F32, (1, 1), "Width of the output over its height.";
    CursorPosition = "cursor.position", I32, (2, 1), "Pixel under the cursor, from the top left; (−1, −1) without one.";
    InputButtons = "input.buttons", U32, (1, 1), "Mouse buttons that are held: bit 0 left, 1 right, 2 middle, 3 back, 4 forward. A click lasts for one frame at least.";
    InputPressed = "input.pressed", U32, (1, 1), "Mouse buttons that went down since the last frame, with the bits of `input.buttons`.";
    InputDrag = "input.drag", I32, (4, 1), "Drag with the left button: pixel where it is or ended, and pixel where it began. (−1, −1, −1, −1) before the first.";
    InputWheel = "input.wheel", F32, (2, 1), "Lines that the wheel was turned since the last reset: to the right, and away from the user.";
    InputGamepadSticks = "input.gamepad_sticks", F32, (4, 1), "Sticks of the gamepad: left stick to the right and up, right stick to the right and up, each in [−1, 1].";
    InputGamepadTriggers = "input.gamepad_triggers", F32, (2, 1), "Triggers of the gamepad, left and right, each in [0, 1].";
    InputGamepadButtons = "input.gamepad_buttons", U32, (1, 1), "Buttons of the gamepad that are held: bit 0 south, 1 east, 2 west, 3 north, 4 and 5 shoulders, 6 select, 7 start, 8 home, 9 and 10 sticks, 11 up, 12 down, 13 left, 14 right.";
    InputGamepadPressed = "input.gamepad_pressed", U32, (1, 1), "Buttons of the gamepad that went down since the last frame, with the bits of `input.gamepad_buttons`.";
    InputTimeOfDay = "input.time_of_day", F32, (1, 1), "Seconds since midnight, in local time. Without a window and in demos: since the midnight at which the session or `[inputs]` begins.";
    WorldMin = "world.min", I32, (3, 1), "Smallest voxel coordinate of the world's bounds.";
    WorldMax = "world.max", I32, (3, 1), "Largest voxel coordinate of the world's bounds, plus one.";
    WorldVoxels = "world.voxels", U32, (1, 1), "Number of solid voxels, at most the largest `u32`.";
    WorldSerial = "world.serial", U32, (1, 1), "Number of changes of the world since the start.";
    WorldEdited = "world.edited", U32, (1, 1), "Number of edits and of changes of the world file since the start; chunks that a streamed world loads and drops do not count.";
    WorldChangedMin = "world.changed_min", I32, (3, 1), "Smallest coordinate of a box around the voxels that changed since the last frame. The box is empty if none changed, and holds all voxels if the change is unknown.";
    WorldChangedMax = "world.changed_max", I32, (3, 1), "Largest coordinate of this box, plus one.";
}
