//! A gamepad, as frames see it.

/// Names of the buttons of a gamepad, in the order of their bits in `input.gamepad_buttons`. The four that lie in a diamond on the right have
/// the names of their places, since each maker prints something else on them.
pub const GAMEPAD_BUTTONS: [&str; 15] = [
    "south",
    "east",
    "west",
    "north",
    "left_shoulder",
    "right_shoulder",
    "select",
    "start",
    "home",
    "left_stick",
    "right_stick",
    "up",
    "down",
    "left",
    "right",
];

/// The held buttons, sticks and triggers of a gamepad. At rest, all is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gamepad {
    /// The left stick to the right and up, then the right stick, each in [−1, 1].
    pub sticks: [f64; 4],
    /// Left and right, in [0, 1].
    pub triggers: [f64; 2],
    /// Bits of the buttons that are held.
    pub buttons: u32,
}

/// Names of the buttons of a set of bits.
pub fn gamepad_button_names(buttons: u32) -> impl Iterator<Item = &'static str> {
    GAMEPAD_BUTTONS.iter().enumerate().filter(move |(bit, _)| buttons >> bit & 1 != 0).map(|(_, name)| *name)
}

/// The bit of a button.
pub fn gamepad_button_named(name: &str) -> Option<u32> {
    GAMEPAD_BUTTONS.iter().position(|known| *known == name).map(|bit| 1 << bit)
}
