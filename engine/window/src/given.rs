//! The window's events as inputs of shaders: the cursor, mouse buttons, the wheel and keys.

use raxel_runtime::inputs::{Inputs, Key};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

use super::{Holder, Viewer};

/// Tells the inputs of an event. A press that a panel takes goes to the panel alone; a release goes to all.
pub(crate) fn note(inputs: &mut Inputs, event: &WindowEvent, taken: bool) {
    match event {
        WindowEvent::KeyboardInput { event, .. } if !event.repeat => {
            let down = event.state == ElementState::Pressed;
            if let (PhysicalKey::Code(code), true) = (event.physical_key, !(taken && down))
                && let Some(key) = key(code)
            {
                inputs.key(key, down);
            }
        }
        WindowEvent::MouseInput { state, button, .. } => {
            let down = *state == ElementState::Pressed;
            if !(taken && down) {
                inputs.button(bit(*button), down);
            }
        }
        WindowEvent::MouseWheel { delta, .. } if !taken => {
            inputs.turn(lines(*delta));
        }
        WindowEvent::Focused(false) => inputs.release_all(),
        _ => {}
    }
}

/// Whether a key stays the window's while the graph has all others: without these, the user could not take the others back.
pub(crate) fn is_windows(key: PhysicalKey) -> bool {
    use KeyCode::{Escape, F1, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11, F12};
    matches!(key, PhysicalKey::Code(Escape | F1 | F2 | F3 | F4 | F5 | F6 | F7 | F8 | F9 | F10 | F11 | F12))
}

/// Lines that the wheel was turned, to the right and away from the user.
fn lines(delta: MouseScrollDelta) -> [f64; 2] {
    match delta {
        MouseScrollDelta::LineDelta(x, y) => [f64::from(x), f64::from(y)],
        MouseScrollDelta::PixelDelta(pixels) => [pixels.x / 50.0, pixels.y / 50.0],
    }
}

fn bit(button: MouseButton) -> u32 {
    match button {
        MouseButton::Left => 1,
        MouseButton::Right => 2,
        MouseButton::Middle => 4,
        MouseButton::Back => 8,
        MouseButton::Forward => 16,
        MouseButton::Other(_) => 0,
    }
}

/// winit names its keys as browsers do, but for the one with a logo.
fn key(code: KeyCode) -> Option<Key> {
    match code {
        KeyCode::SuperLeft => Key::named("MetaLeft"),
        KeyCode::SuperRight => Key::named("MetaRight"),
        code => Key::named(&format!("{code:?}")),
    }
}

impl Viewer<'_> {
    /// Gives mouse and keyboard to the graph alone, or takes them back.
    pub(super) fn give_inputs(&mut self) {
        self.controls.release_all();
        let (holder, said) = match self.holder {
            Holder::Both => (
                Holder::Graph,
                "the graph alone has mouse and keyboard, but for Escape and F1 to F12; F2 takes them back",
            ),
            Holder::Graph => (Holder::Both, "the window has mouse and keyboard again"),
        };
        self.holder = holder;
        self.console.message(said);
        self.notice(said.to_owned());
    }

    /// Begins a take, or ends it and writes it as a demo.
    pub(super) fn record_take(&mut self) {
        if self.session.recording().is_none() {
            match self.session.record() {
                Ok(()) => self.notice("recording a take from the start: F9 ends it".to_owned()),
                Err(error) => self.warn(error.to_string()),
            }
            return;
        }
        self.write_take_again();
    }

    /// Reads the gamepad, for graphs that use it.
    pub(super) fn read_gamepad(&mut self) {
        let graph = self.session.graph().clone();
        if let Some(said) = self.gamepads.read(&graph, self.session.inputs()) {
            self.console.message(&said);
            self.notice(said);
        }
    }

    /// Lets a device capture for graphs that ask.
    pub(super) fn read_microphone(&mut self) {
        let wanted = self.session.wants_capture();
        match self.capture.follow(wanted, self.session.microphone()) {
            Some(Ok(said)) => {
                self.console.message(&said);
                self.notice(said);
            }
            Some(Err(warning)) => self.warn(warning),
            None => {}
        }
    }

    /// Seconds since midnight, for graphs that ask.
    pub(super) fn note_time_of_day(&mut self) {
        let now = jiff::Zoned::now();
        let whole = 3600 * i32::from(now.hour()) + 60 * i32::from(now.minute()) + i32::from(now.second());
        self.session.inputs().set_time_of_day(f64::from(whole) + f64::from(now.subsec_nanosecond()) / 1e9);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_names() {
        let names = |code| key(code).map(|key| [key].into_iter().collect::<raxel_runtime::inputs::KeySet>());
        for (code, name) in [
            (KeyCode::KeyW, "KeyW"),
            (KeyCode::Digit1, "Digit1"),
            (KeyCode::ArrowUp, "ArrowUp"),
            (KeyCode::ShiftLeft, "ShiftLeft"),
            (KeyCode::SuperLeft, "MetaLeft"),
            (KeyCode::NumpadAdd, "NumpadAdd"),
            (KeyCode::F12, "F12"),
            (KeyCode::Space, "Space"),
        ] {
            assert_eq!(names(code).unwrap().names().collect::<Vec<_>>(), [name]);
        }
        assert_eq!(key(KeyCode::BrowserBack), None);
    }

    #[test]
    fn a_panel_takes_presses_and_no_releases() {
        let mut inputs = Inputs::default();
        let event = |state| WindowEvent::MouseInput {
            device_id: winit::event::DeviceId::dummy(),
            state,
            button: MouseButton::Right,
        };
        note(&mut inputs, &event(ElementState::Pressed), true);
        assert_eq!(inputs.buttons(), 0);
        note(&mut inputs, &event(ElementState::Pressed), false);
        assert_eq!(inputs.buttons(), 2);
        note(&mut inputs, &event(ElementState::Released), true);
        assert_eq!(inputs.buttons(), 0);
    }
}
