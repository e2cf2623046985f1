//! Mouse, keyboard, gamepad, microphone and time of day, as frames see them. A frame's inputs follow from those of the frame before and
//! from the live ones, or from the tracks of a demo.

mod gamepad;
mod keys;
mod microphone;

pub use gamepad::{GAMEPAD_BUTTONS, Gamepad, gamepad_button_named, gamepad_button_names};
pub use keys::{Key, KeySet};
pub use microphone::{Feed, HISTORY, Heard, Line, Microphone, SAMPLE_RATE, SoundFile, samples_before};

/// Names of mouse buttons, in the order of their bits in `input.buttons`.
pub const BUTTONS: [&str; 5] = ["left", "right", "middle", "back", "forward"];

/// Bit of the button that drags.
pub const LEFT: u32 = 1;

/// Seconds of a day.
pub const DAY: f64 = 86_400.0;

/// No drag so far.
pub(crate) const NO_DRAG: [i32; 4] = [-1; 4];

/// Names of the buttons of a set of bits.
pub fn button_names(buttons: u32) -> impl Iterator<Item = &'static str> {
    BUTTONS.iter().enumerate().filter(move |(bit, _)| buttons >> bit & 1 != 0).map(|(_, name)| *name)
}

/// The bit of a button.
pub fn button_named(name: &str) -> Option<u32> {
    BUTTONS.iter().position(|known| *known == name).map(|bit| 1 << bit)
}

/// Inputs that a person holds and turns. A button or a key that goes down and up between two frames is held in the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// The pixel of the output under the cursor, from the top left.
    pub cursor: Option<[i32; 2]>,
    buttons: u32,
    /// Went down since the last frame.
    tapped: u32,
    wheel: [f64; 2],
    keys: KeySet,
    tapped_keys: KeySet,
    gamepad: Gamepad,
    /// Went down on the gamepad since the last frame.
    tapped_gamepad: u32,
    /// Seconds since midnight: at the start, or with a live clock now.
    time_of_day: f64,
}

impl Inputs {
    /// Mouse buttons went down or up: bits of `input.buttons`.
    pub fn button(&mut self, bits: u32, down: bool) {
        if down {
            self.buttons |= bits;
            self.tapped |= bits;
        } else {
            self.buttons &= !bits;
        }
    }

    /// A key went down or up.
    pub fn key(&mut self, key: Key, down: bool) {
        self.keys.set(key, down);
        if down {
            self.tapped_keys.set(key, true);
        }
    }

    /// The wheel was turned by `lines` lines, to the right and away from the user. Numbers that are not finite turn nothing.
    pub fn turn(&mut self, lines: [f64; 2]) {
        if lines.iter().all(|lines| lines.is_finite()) {
            self.wheel = [0, 1].map(|axis| (self.wheel[axis] + lines[axis]).clamp(-1e6, 1e6));
        }
    }

    /// Buttons of the gamepad went down or up: bits of `input.gamepad_buttons`.
    pub fn gamepad_button(&mut self, bits: u32, down: bool) {
        if down {
            self.gamepad.buttons |= bits;
            self.tapped_gamepad |= bits;
        } else {
            self.gamepad.buttons &= !bits;
        }
    }

    /// Exactly these buttons of the gamepad are held.
    pub fn hold_gamepad_buttons(&mut self, buttons: u32) {
        self.gamepad_button(!buttons, false);
        self.gamepad_button(buttons & !self.gamepad.buttons, true);
    }

    /// Where the sticks of the gamepad are. Numbers that are not finite leave them.
    pub fn set_gamepad_sticks(&mut self, sticks: [f64; 4]) {
        if sticks.iter().all(|axis| axis.is_finite()) {
            self.gamepad.sticks = sticks.map(|axis| axis.clamp(-1.0, 1.0));
        }
    }

    /// Where the triggers of the gamepad are. Numbers that are not finite leave them.
    pub fn set_gamepad_triggers(&mut self, triggers: [f64; 2]) {
        if triggers.iter().all(|axis| axis.is_finite()) {
            self.gamepad.triggers = triggers.map(|axis| axis.clamp(0.0, 1.0));
        }
    }

    /// The gamepad is at rest: nothing of it is held.
    pub fn rest_gamepad(&mut self) {
        self.gamepad = Gamepad::default();
    }

    /// Mouse and keyboard are held no more. A gamepad does not belong to a window.
    pub fn release_all(&mut self) {
        (self.buttons, self.keys) = (0, KeySet::NONE);
    }

    /// Exactly these buttons are held.
    pub fn hold_buttons(&mut self, buttons: u32) {
        self.button(!buttons, false);
        self.button(buttons & !self.buttons, true);
    }

    /// Exactly these keys are held.
    pub fn hold_keys(&mut self, keys: KeySet) {
        self.tapped_keys = self.tapped_keys.or(keys.without(self.keys));
        self.keys = keys;
    }

    /// Lines that the wheel was turned since the start.
    pub fn set_wheel(&mut self, lines: [f64; 2]) {
        self.wheel = [0.0; 2];
        self.turn(lines);
    }

    /// Seconds since midnight, in 0…86,400: at the start, or with a live clock now.
    pub fn set_time_of_day(&mut self, seconds: f64) {
        if seconds.is_finite() {
            self.time_of_day = seconds.rem_euclid(DAY);
        }
    }

    /// Bits of the buttons that are held.
    pub fn buttons(&self) -> u32 {
        self.buttons
    }

    /// The keys that are held.
    pub fn keys(&self) -> KeySet {
        self.keys
    }

    /// The gamepad.
    pub fn gamepad(&self) -> Gamepad {
        self.gamepad
    }

    /// Lines that the wheel was turned since the start, to the right and away from the user.
    pub fn wheel(&self) -> [f64; 2] {
        self.wheel
    }

    /// Seconds since midnight, as they were set.
    pub fn time_of_day(&self) -> f64 {
        self.time_of_day
    }

    /// Time starts over: the wheel was not turned since.
    pub fn reset(&mut self) {
        self.wheel = [0.0; 2];
    }
}

/// The inputs of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownInputs {
    /// The pixel of the output under the cursor, from the top left.
    pub cursor: Option<[i32; 2]>,
    /// `input.buttons`.
    pub buttons: u32,
    /// `input.pressed`.
    pub pressed: u32,
    /// `input.drag`.
    pub drag: [i32; 4],
    /// `input.wheel`, lines.
    pub wheel: [f64; 2],
    /// `input.gamepad_sticks`, `input.gamepad_triggers` and `input.gamepad_buttons`.
    pub gamepad: Gamepad,
    /// `input.gamepad_pressed`.
    pub gamepad_pressed: u32,
    /// `input.time_of_day`, seconds.
    pub time_of_day: f64,
    /// Keys that are held.
    pub keys: KeySet,
    /// Keys that went down since the last frame.
    pub keys_pressed: KeySet,
    /// Keys that went down an odd number of times.
    pub keys_toggled: KeySet,
}

impl Default for ShownInputs {
    fn default() -> Self {
        Self {
            cursor: None,
            buttons: 0,
            pressed: 0,
            drag: NO_DRAG,
            wheel: [0.0; 2],
            gamepad: Gamepad::default(),
            gamepad_pressed: 0,
            time_of_day: 0.0,
            keys: KeySet::NONE,
            keys_pressed: KeySet::NONE,
            keys_toggled: KeySet::NONE,
        }
    }
}

impl ShownInputs {
    /// The words of `input.keys`.
    pub fn key_words(&self) -> [u32; 24] {
        let sets = [self.keys, self.keys_pressed, self.keys_toggled].map(KeySet::words);
        std::array::from_fn(|word| sets[word / 8][word % 8])
    }
}

/// Inputs of the person and of the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputState {
    /// The inputs that the person holds and turns now.
    pub live: Inputs,
    /// The inputs of the last frame.
    pub shown: ShownInputs,
}

impl InputState {
    /// The next frame gets the live inputs. `time` are the seconds since the start where the clock has fixed steps.
    pub fn advance(&mut self, time: Option<f64>) {
        let (live, last) = (&mut self.live, self.shown);
        let (buttons, keys) = (live.buttons | live.tapped, live.keys.or(live.tapped_keys));
        let gamepad = Gamepad { buttons: live.gamepad.buttons | live.tapped_gamepad, ..live.gamepad };
        (live.tapped, live.tapped_keys, live.tapped_gamepad) = (0, KeySet::NONE, 0);
        let pressed = buttons & !last.buttons;
        let keys_pressed = keys.without(last.keys);
        let mut drag = last.drag;
        // The frame in which the button goes up still moves the end.
        if let Some([x, y]) = live.cursor.filter(|_| (buttons | last.buttons) & LEFT != 0) {
            let [from_x, from_y] = if pressed & LEFT != 0 { [x, y] } else { [drag[2], drag[3]] };
            drag = [x, y, from_x, from_y];
        }
        self.shown = ShownInputs {
            cursor: live.cursor,
            buttons,
            pressed,
            drag,
            wheel: live.wheel,
            gamepad,
            gamepad_pressed: gamepad.buttons & !last.gamepad.buttons,
            time_of_day: (live.time_of_day + time.unwrap_or_default()).rem_euclid(DAY),
            keys,
            keys_pressed,
            keys_toggled: last.keys_toggled.xor(keys_pressed),
        };
    }

    /// Time starts over, and nothing was pressed before.
    pub fn reset(&mut self) {
        self.live.reset();
        self.shown = ShownInputs::default();
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    #[test]
    fn a_click_between_two_frames_is_held_in_one() {
        let mut state = InputState::default();
        state.live.cursor = Some([3, 4]);
        state.live.button(LEFT, true);
        state.live.button(LEFT, false);
        let key = Key::named("Space").unwrap();
        state.live.key(key, true);
        state.live.key(key, false);
        state.advance(None);
        let space: KeySet = [key].into_iter().collect();
        assert_eq!((state.shown.buttons, state.shown.pressed, state.shown.drag), (1, 1, [3, 4, 3, 4]));
        assert_eq!([state.shown.keys, state.shown.keys_pressed, state.shown.keys_toggled], [space; 3]);
        state.live.cursor = Some([5, 4]);
        state.advance(None);
        assert_eq!((state.shown.buttons, state.shown.pressed, state.shown.drag), (0, 0, [5, 4, 3, 4]));
        assert_eq!((state.shown.keys, state.shown.keys_pressed), (KeySet::NONE, KeySet::NONE));
        assert_eq!(state.shown.keys_toggled, space, "until it is pressed again");
        state.live.cursor = Some([9, 9]);
        state.advance(None);
        assert_eq!(state.shown.drag, [5, 4, 3, 4], "no button is held");
    }

    #[test]
    fn a_gamepad_is_told_and_goes_to_rest() {
        let mut state = InputState::default();
        let south = gamepad_button_named("south").unwrap();
        state.live.gamepad_button(south, true);
        state.live.gamepad_button(south, false);
        state.live.set_gamepad_sticks([0.25, -3.0, 0.0, 1.0]);
        state.live.set_gamepad_sticks([f64::NAN; 4]);
        state.live.set_gamepad_triggers([-1.0, 0.5]);
        state.advance(None);
        let told = Gamepad { sticks: [0.25, -1.0, 0.0, 1.0], triggers: [0.0, 0.5], buttons: south };
        assert_eq!((state.shown.gamepad, state.shown.gamepad_pressed), (told, south));
        state.live.release_all();
        state.advance(None);
        assert_eq!((state.shown.gamepad, state.shown.gamepad_pressed), (Gamepad { buttons: 0, ..told }, 0));
        state.live.hold_gamepad_buttons(south | 2);
        state.live.rest_gamepad();
        state.advance(None);
        assert_eq!(state.shown.gamepad_pressed, south | 2, "they went down before");
        state.advance(None);
        assert_eq!((state.shown.gamepad, state.shown.gamepad_pressed), (Gamepad::default(), 0));
    }

    #[test]
    fn values_stay_finite_and_in_the_day() {
        let mut live = Inputs::default();
        live.turn([f64::NAN, 1.0]);
        live.turn([1e300, 2.0]);
        assert_eq!(live.wheel, [1e6, 2.0]);
        live.set_time_of_day(f64::INFINITY);
        live.set_time_of_day(-10.0);
        let mut state = InputState { live, ..InputState::default() };
        state.advance(Some(20.0));
        assert!((state.shown.time_of_day - 10.0).abs() < 1e-9, "past midnight");
    }
}
