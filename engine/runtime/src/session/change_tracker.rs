//! Counts the frames in which only the time changed, and changes of the world: `frame.still`, `world.serial` and `world.edited`.

use std::sync::Arc;

use raxel_execute::{Builtins, Override};
use raxel_graph::checked::{Builtin, Graph, MOST_STILL, PassId, Value};

use crate::world::SessionWorld;

/// Compares each frame with the one before it.
#[derive(Default)]
pub(super) struct ChangeTracker {
    now: Changes,
    last: Option<Last>,
    /// The frame that was noted last has not been.
    refused: bool,
    /// The inputs that count.
    reads: Option<Reads>,
}

/// The inputs that a graph reads.
struct Reads {
    graph: Arc<Graph>,
    /// Clears each builtin that it does not read.
    unread: Vec<Clear>,
    keys: bool,
}

/// Gives a builtin the value that it has in other builtins.
type Clear = fn(&mut Builtins, &Builtins);

const INPUTS: [(Builtin, Clear); 8] = [
    (Builtin::InputButtons, |to, none| to.input_buttons = none.input_buttons),
    (Builtin::InputPressed, |to, none| to.input_pressed = none.input_pressed),
    (Builtin::InputDrag, |to, none| to.input_drag = none.input_drag),
    (Builtin::InputWheel, |to, none| to.input_wheel = none.input_wheel),
    (Builtin::InputGamepadSticks, |to, none| to.input_gamepad_sticks = none.input_gamepad_sticks),
    (Builtin::InputGamepadTriggers, |to, none| to.input_gamepad_triggers = none.input_gamepad_triggers),
    (Builtin::InputGamepadButtons, |to, none| to.input_gamepad_buttons = none.input_gamepad_buttons),
    (Builtin::InputGamepadPressed, |to, none| to.input_gamepad_pressed = none.input_gamepad_pressed),
];

impl Reads {
    fn of(graph: &Arc<Graph>) -> Self {
        let is_unread = |input: Builtin| !graph.reads().any(|builtin| builtin == input);
        Self {
            graph: graph.clone(),
            unread: INPUTS.into_iter().filter(|(input, _)| is_unread(*input)).map(|(_, clear)| clear).collect(),
            keys: graph.source_names().contains("input.keys"),
        }
    }

    /// The builtins whose change changes the picture. Time does not count, and contents of earlier frames do not count either. An input
    /// that the graph does not read does not count either: a key that moves no camera must not restart a sum.
    fn counted(&self, builtins: &Builtins) -> Builtins {
        let mut counted = Builtins {
            // The camera of the frame before follows the camera.
            camera_previous_cell: builtins.camera_cell,
            camera_previous_frac: builtins.camera_frac,
            camera_previous_view_to_world: builtins.camera_view_to_world,
            camera_previous_world_to_view: builtins.camera_world_to_view,
            frame_index: 0,
            frame_time: 0.0,
            frame_delta: 0.0,
            history_valid: 0,
            input_time_of_day: 0.0,
            world_changed_min: [0; 3],
            world_changed_max: [0; 3],
            ..*builtins
        };
        let none = Builtins::default();
        self.unread.iter().for_each(|clear| clear(&mut counted, &none));
        counted
    }
}

/// The builtins that report changes to a frame.
#[derive(Clone, Copy, Default)]
pub(super) struct Changes {
    /// `frame.still`.
    pub(super) still: u32,
    /// `world.serial`.
    pub(super) serial: u32,
    /// `world.edited`.
    pub(super) edited: u32,
}

/// The inputs of a picture besides the time.
pub(super) struct Inputs<'a> {
    pub(super) world: &'a Arc<SessionWorld>,
    /// The publication of a streamed world, the last edit in it, how often passes have moved instances, and the present texels of videos
    /// and sounds.
    pub(super) versions: [u64; 4],
    pub(super) graph: &'a Arc<Graph>,
    /// Those of the frame without the tracker's own.
    pub(super) builtins: &'a Builtins,
    /// The words of `input.keys`.
    pub(super) keys: &'a [u32; 24],
    pub(super) values: &'a [Value],
    pub(super) overrides: &'a [Override],
    pub(super) disabled: &'a [PassId],
}

/// The same, as the last frame had it.
struct Last {
    world: Arc<SessionWorld>,
    versions: [u64; 4],
    graph: Arc<Graph>,
    builtins: Builtins,
    keys: [u32; 24],
    values: Vec<Value>,
    overrides: Vec<Override>,
    disabled: Vec<PassId>,
}

impl ChangeTracker {
    /// Notes a frame, and returns its changes.
    pub(super) fn note(&mut self, inputs: &Inputs<'_>) -> Changes {
        let Inputs { world, versions, graph, builtins, keys, values, overrides, disabled } = *inputs;
        let reads = match &mut self.reads {
            Some(reads) if Arc::ptr_eq(&reads.graph, graph) => reads,
            reads => reads.insert(Reads::of(graph)),
        };
        let builtins = reads.counted(builtins);
        let keys = if reads.keys { *keys } else { [0; 24] };
        let Some(last) = &mut self.last else {
            self.last = Some(Last {
                world: world.clone(),
                versions,
                graph: graph.clone(),
                builtins,
                keys,
                values: values.to_vec(),
                overrides: overrides.to_vec(),
                disabled: disabled.to_vec(),
            });
            self.now.still = 0;
            return self.now;
        };
        let same_world = Arc::ptr_eq(&last.world, world) && last.versions[0] == versions[0];
        if !same_world {
            self.now.serial = self.now.serial.wrapping_add(1);
        }
        if !(Arc::ptr_eq(&last.world, world) && last.versions[1] == versions[1]) {
            self.now.edited = self.now.edited.wrapping_add(1);
        }
        let same = same_world
            && last.versions == versions
            && Arc::ptr_eq(&last.graph, graph)
            && last.builtins == builtins
            && last.keys == keys
            && last.values == values
            && last.overrides == overrides
            && last.disabled == disabled;
        if std::mem::take(&mut self.refused) && same {
            return self.now;
        }
        if same {
            self.now.still = (self.now.still + 1).min(MOST_STILL);
        } else {
            self.now.still = 0;
            // In place: a frame allocates nothing while the numbers of params stay the same.
            (last.world, last.versions, last.graph, last.builtins) = (world.clone(), versions, graph.clone(), builtins);
            last.keys = keys;
            last.values.clear();
            last.values.extend_from_slice(values);
            last.overrides.clear();
            last.overrides.extend_from_slice(overrides);
            last.disabled.clear();
            last.disabled.extend_from_slice(disabled);
        }
        self.now
    }

    /// The frame that was noted has not been: the next one is noted in its place.
    pub(super) fn refused(&mut self) {
        self.refused = true;
    }

    /// The next frame is the first that is still.
    pub(super) fn reset(&mut self) {
        self.now.still = 0;
        self.last = None;
    }
}
