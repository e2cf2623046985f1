//! The gamepad, as input of shaders. Reading gamepads is a feature, since it needs a library of the system on Linux.

use raxel_graph::checked::{Builtin, Graph};
use raxel_runtime::inputs::Inputs;

/// Whether a graph reads a gamepad.
fn is_read(graph: &Graph) -> bool {
    let of_gamepad = [
        Builtin::InputGamepadSticks,
        Builtin::InputGamepadTriggers,
        Builtin::InputGamepadButtons,
        Builtin::InputGamepadPressed,
    ];
    graph.reads().any(|builtin| of_gamepad.contains(&builtin))
}

/// The gamepads of the system. One is used at a time.
#[derive(Default)]
pub(crate) enum Gamepads {
    /// No graph has read one so far.
    #[default]
    Unasked,
    /// They are read.
    #[cfg(feature = "gamepad")]
    Read(Box<of_system::Reader>),
    /// They cannot be read, which was reported.
    Refused,
}

impl Gamepads {
    /// Passes events since the last call to the inputs, once a graph reads a gamepad. Returns a message for the user.
    pub(crate) fn read(&mut self, graph: &Graph, inputs: &mut Inputs) -> Option<String> {
        match self {
            Self::Unasked if is_read(graph) => {
                let (opened, said) = Self::open();
                *self = opened;
                said
            }
            #[cfg(feature = "gamepad")]
            Self::Read(reader) => reader.read(inputs),
            Self::Unasked | Self::Refused => {
                // Without the feature for gamepads, nothing reads them.
                let _ = inputs;
                None
            }
        }
    }

    #[cfg(feature = "gamepad")]
    fn open() -> (Self, Option<String>) {
        match of_system::Reader::open() {
            Ok(reader) => (Self::Read(Box::new(reader)), None),
            Err(error) => (Self::Refused, Some(error)),
        }
    }

    #[cfg(not(feature = "gamepad"))]
    fn open() -> (Self, Option<String>) {
        let said = "the graph reads a gamepad, and this raxel reads none: build it with `--features gamepad`";
        (Self::Refused, Some(said.to_owned()))
    }
}

#[cfg(feature = "gamepad")]
mod of_system {
    use gilrs::{Axis, Button, EventType, GamepadId, Gilrs};
    use raxel_runtime::inputs::{Inputs, gamepad_button_named};

    /// The change of a gamepad, in the terms of `input.gamepad_*`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Happened {
        /// It was unplugged.
        Gone,
        /// A button, by its bit.
        Button(u32, bool),
        /// An axis of the sticks.
        Stick(usize, f64),
        /// Left or right.
        Trigger(usize, f64),
    }

    /// Passes an event to the inputs.
    fn note(inputs: &mut Inputs, happened: Happened) {
        let gamepad = inputs.gamepad();
        match happened {
            Happened::Gone => inputs.rest_gamepad(),
            Happened::Button(bit, down) => inputs.gamepad_button(bit, down),
            Happened::Stick(axis, value) => {
                let mut sticks = gamepad.sticks;
                sticks[axis] = value;
                inputs.set_gamepad_sticks(sticks);
            }
            Happened::Trigger(axis, value) => {
                let mut triggers = gamepad.triggers;
                triggers[axis] = value;
                inputs.set_gamepad_triggers(triggers);
            }
        }
    }

    /// The gamepad that was touched first, until it is unplugged.
    struct Used<Id>(Option<Id>);

    impl<Id: PartialEq + Copy> Used<Id> {
        /// Passes a change of a gamepad to the inputs, if it is the one that is used. Returns a message for the user.
        fn take(&mut self, id: Id, name: &str, happened: Happened, inputs: &mut Inputs) -> Option<String> {
            let said = match (self.0, happened) {
                (Some(used), Happened::Gone) if used == id => {
                    self.0 = None;
                    Some(format!("gamepad `{name}` is gone: its values are at rest"))
                }
                (_, Happened::Gone) => return None,
                (Some(used), _) if used != id => return None,
                (Some(_), _) => None,
                (None, _) => {
                    self.0 = Some(id);
                    Some(format!("gamepad `{name}`"))
                }
            };
            note(inputs, happened);
            said
        }
    }

    /// Reads the used gamepad.
    pub(crate) struct Reader {
        gilrs: Gilrs,
        used: Used<GamepadId>,
    }

    impl Reader {
        pub(crate) fn open() -> Result<Self, String> {
            match Gilrs::new() {
                Ok(gilrs) => Ok(Self { gilrs, used: Used(None) }),
                Err(error) => Err(format!("gamepads cannot be read: {error}")),
            }
        }

        /// Passes events since the last call to the inputs. Returns a message for the user.
        pub(crate) fn read(&mut self, inputs: &mut Inputs) -> Option<String> {
            let mut said = Vec::new();
            while let Some(event) = self.gilrs.next_event() {
                if let Some(happened) = happened(event.event) {
                    said.extend(self.used.take(event.id, self.gilrs.gamepad(event.id).name(), happened, inputs));
                }
            }
            // One may go and another be touched between two frames.
            (!said.is_empty()).then(|| said.join("; "))
        }
    }

    fn happened(event: EventType) -> Option<Happened> {
        match event {
            EventType::Disconnected => Some(Happened::Gone),
            EventType::ButtonPressed(button, _) => Some(Happened::Button(bit(button)?, true)),
            EventType::ButtonReleased(button, _) => Some(Happened::Button(bit(button)?, false)),
            EventType::ButtonChanged(Button::LeftTrigger2, value, _) => Some(Happened::Trigger(0, value.into())),
            EventType::ButtonChanged(Button::RightTrigger2, value, _) => Some(Happened::Trigger(1, value.into())),
            EventType::AxisChanged(axis, value, _) => {
                let axis = [Axis::LeftStickX, Axis::LeftStickY, Axis::RightStickX, Axis::RightStickY]
                    .iter()
                    .position(|known| *known == axis)?;
                Some(Happened::Stick(axis, value.into()))
            }
            _ => None,
        }
    }

    fn bit(button: Button) -> Option<u32> {
        gamepad_button_named(match button {
            Button::South => "south",
            Button::East => "east",
            Button::West => "west",
            Button::North => "north",
            Button::LeftTrigger => "left_shoulder",
            Button::RightTrigger => "right_shoulder",
            Button::Select => "select",
            Button::Start => "start",
            Button::Mode => "home",
            Button::LeftThumb => "left_stick",
            Button::RightThumb => "right_stick",
            Button::DPadUp => "up",
            Button::DPadDown => "down",
            Button::DPadLeft => "left",
            Button::DPadRight => "right",
            _ => return None,
        })
    }

    #[cfg(test)]
    #[allow(clippy::float_cmp, reason = "these values are exact")]
    mod tests {
        use super::*;

        #[test]
        fn what_happens_is_told() {
            let mut inputs = Inputs::default();
            for happened in [
                Happened::Button(4, true),
                Happened::Button(8, true),
                Happened::Button(4, false),
                Happened::Stick(2, -0.5),
                Happened::Trigger(1, 0.25),
            ] {
                note(&mut inputs, happened);
            }
            let told = inputs.gamepad();
            assert_eq!((told.buttons, told.sticks, told.triggers), (8, [0.0, 0.0, -0.5, 0.0], [0.0, 0.25]));
        }

        #[test]
        fn an_unplugged_gamepad_is_at_rest_and_said_once() {
            assert_eq!(happened(EventType::Disconnected), Some(Happened::Gone));
            let (mut inputs, mut used) = (Inputs::default(), Used(None));
            let mut take = |id: u32, happened| {
                let said = used.take(id, &format!("pad {id}"), happened, &mut inputs);
                (said, inputs.gamepad().buttons, inputs.gamepad().sticks, inputs.gamepad().triggers)
            };
            let press = Happened::Button(4, true);
            let rest = ([0.0; 4], [0.0; 2]);
            assert_eq!(take(1, Happened::Gone), (None, 0, rest.0, rest.1), "none was used");
            assert_eq!(take(1, press), (Some("gamepad `pad 1`".to_owned()), 4, rest.0, rest.1));
            take(1, Happened::Stick(0, 0.5));
            take(1, Happened::Trigger(1, 0.25));
            let held = (None, 4, [0.5, 0.0, 0.0, 0.0], [0.0, 0.25]);
            assert_eq!(take(2, Happened::Button(8, true)), held, "another one is not used");
            assert_eq!(take(2, Happened::Gone), held, "nor missed");
            let gone = "gamepad `pad 1` is gone: its values are at rest".to_owned();
            assert_eq!(take(1, Happened::Gone), (Some(gone), 0, rest.0, rest.1));
            assert_eq!(take(1, Happened::Gone), (None, 0, rest.0, rest.1), "it is said once");
            assert_eq!(take(2, press), (Some("gamepad `pad 2`".to_owned()), 4, rest.0, rest.1), "the next one is used");
        }

        #[test]
        fn every_button_has_its_bit() {
            let buttons = [
                Button::South,
                Button::East,
                Button::West,
                Button::North,
                Button::LeftTrigger,
                Button::RightTrigger,
                Button::Select,
                Button::Start,
                Button::Mode,
                Button::LeftThumb,
                Button::RightThumb,
                Button::DPadUp,
                Button::DPadDown,
                Button::DPadLeft,
                Button::DPadRight,
            ];
            for (at, button) in buttons.into_iter().enumerate() {
                assert_eq!(bit(button), Some(1 << at));
            }
            assert_eq!(bit(Button::LeftTrigger2), None, "it is a trigger");
        }
    }
}
