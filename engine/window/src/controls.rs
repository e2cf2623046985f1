//! Keys and mouse as the window sees them, turned into commands and into motion of the camera.

use std::collections::HashSet;

use raxel_control::FLY_SPEEDS;
use raxel_runtime::camera::{FlyInput, FlySpeed};
use winit::keyboard::{Key, KeyCode, ModifiersState, NamedKey, PhysicalKey};

use super::looking::Move;

/// One thing that a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// Show the next debug target.
    NextTarget,
    /// Show the debug target before.
    PreviousTarget,
    /// Stop or start the clock.
    Pause,
    /// Let one frame pass; pauses first.
    Step,
    /// Start over: history, clock, frame 0.
    Reset,
    /// Take the newest edit back.
    Undo,
    /// Make the edit again that was taken back last.
    Redo,
    /// A larger brush.
    Larger,
    /// A smaller one.
    Smaller,
    /// Of another material.
    NextMaterial,
    /// List the files of the project, to open one of them.
    Open,
    /// Show or hide the panels.
    Panels,
    /// Pin the texel under the cursor, or let go of the pin there.
    Pin,
    /// Zoom or pan.
    Look(Move),
    /// Keep the shown picture, to compare with it.
    Keep,
    /// Compare with the target that is shown now, as it goes on.
    KeepLive,
    /// Another way of comparing.
    NextComparison,
    /// Show the kept picture alone, or not any more.
    Flip,
    /// Put the camera where it began.
    Home,
    /// Write the camera to stdout and to the clipboard.
    CopyCamera,
    /// Write the camera into the demo's file, as a key at this time.
    RecordKey,
    /// Let the demo drive again.
    HandBack,
    /// Give up the pass that the device works on.
    Cancel,
    /// Write the picture to a PNG.
    Screenshot,
    /// Put the picture beside the panels, or under them.
    Beside,
    /// Give mouse and keyboard to the graph alone, or take them back.
    Give,
    /// Begin a take, or end it.
    Record,
    /// Capture the next frame by RenderDoc.
    Capture,
    /// Leave.
    Quit,
}

/// The keys of the window, for `raxel run --help` and the README.
pub const KEYS: &str = "\
W A S D, Q E    fly, down and up; Shift flies faster
mouse           drag with the left button to look around; the wheel sets the speed
right button    the brush: digs a ball out of the world; with Shift, places one; with Ctrl, picks the material
[ ]  M          size and material of the brush;  Ctrl+Z undo, Ctrl+Y redo
Home            back to where the camera began
C               the camera as the lines of a world's file, on stdout and on the clipboard
K  G            the camera as a key in the demo's file;  give the camera back to the demo
P               pin the texel under the cursor in Inspect, or let go of the pin there
+ -  0          magnify twice, half as much; the whole picture. Ctrl and the wheel magnify, too; in a magnified picture, the wheel alone,
                a drag and the arrow keys move the picture
B  X  V         keep what is shown; ways to compare with it: wipe, difference, off;  the kept picture alone
Shift+B         compare with the shown target as it goes on: show another one then
Tab             next debug target or layer of one; Shift+Tab the one before
O               open another graph, world or demo of the project
F1              show or hide the panels; Ctrl+Plus and Ctrl+Minus change their size
Space           pause;  .  one frame;  R  start over
Delete          give up a pass that the device has worked on for long
F3              put the picture beside the panels, or under them
F2              give mouse and keyboard to the graph alone, and take them back
F9              start over and record a take; end it, and write it as a demo
F11             capture the next frame, under RenderDoc
F12             screenshot
Escape          quit";

/// Keys held and mouse motion since the last frame.
#[derive(Clone, Debug)]
pub(crate) struct Controls {
    held: HashSet<KeyCode>,
    dragging: bool,
    look: [f64; 2],
    cursor: Option<[f64; 2]>,
    /// The pixel of the window at the top left of the picture.
    origin: [u32; 2],
    /// Voxels a second.
    speed: f64,
}

impl Default for Controls {
    fn default() -> Self {
        let speed = FlySpeed::default().voxels;
        Self { held: HashSet::new(), dragging: false, look: [0.0; 2], cursor: None, origin: [0; 2], speed }
    }
}

impl Controls {
    /// Voxels that the camera flies in a second.
    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    /// The speed in words, with two significant digits or whole voxels.
    pub(crate) fn speed_text(&self) -> String {
        let decimals = if self.speed < 1.0 { 2 } else { usize::from(self.speed < 10.0) };
        format!("flies at {:.decimals$} voxels a second", self.speed)
    }

    /// Sets the voxels a second.
    pub(crate) fn set_speed(&mut self, voxels: f64) {
        if voxels.is_finite() {
            self.speed = voxels.clamp(*FLY_SPEEDS.start(), *FLY_SPEEDS.end());
        }
    }

    /// The wheel was turned by `lines` lines, away from the user where positive.
    pub(crate) fn wheel(&mut self, lines: f64) {
        self.set_speed(self.speed * 1.2_f64.powf(lines.clamp(-20.0, 20.0)));
    }

    /// A key went down or up. Returns its command, once a press.
    pub(crate) fn key(
        &mut self,
        physical: PhysicalKey,
        logical: &Key,
        modifiers: ModifiersState,
        pressed: bool,
        repeat: bool,
    ) -> Option<Command> {
        if let PhysicalKey::Code(code) = physical {
            if pressed {
                self.held.insert(code);
            } else {
                self.held.remove(&code);
            }
        }
        if !pressed {
            return None;
        }
        // A key's place moves the camera; its label gives a command.
        let command = match logical {
            Key::Named(NamedKey::Tab) if modifiers.shift_key() => Command::PreviousTarget,
            Key::Named(NamedKey::Tab) => Command::NextTarget,
            Key::Named(NamedKey::Space) => Command::Pause,
            Key::Named(NamedKey::F1) => Command::Panels,
            Key::Named(NamedKey::F2) => Command::Give,
            Key::Named(NamedKey::F3) => Command::Beside,
            Key::Named(NamedKey::F9) => Command::Record,
            Key::Named(NamedKey::Home) => Command::Home,
            Key::Named(NamedKey::Delete) => Command::Cancel,
            Key::Named(NamedKey::F11) => Command::Capture,
            Key::Named(NamedKey::F12) => Command::Screenshot,
            Key::Named(NamedKey::Escape) => Command::Quit,
            Key::Named(NamedKey::ArrowLeft) => Command::Look(Move::Step { right: -1, down: 0 }),
            Key::Named(NamedKey::ArrowRight) => Command::Look(Move::Step { right: 1, down: 0 }),
            Key::Named(NamedKey::ArrowUp) => Command::Look(Move::Step { right: 0, down: -1 }),
            Key::Named(NamedKey::ArrowDown) => Command::Look(Move::Step { right: 0, down: 1 }),
            // With Ctrl they change the size of the panels.
            Key::Character(text) if (text == "+" || text == "=") && !modifiers.control_key() => Command::Look(Move::In),
            Key::Character(text) if text == "-" && !modifiers.control_key() => Command::Look(Move::Out),
            Key::Character(text) if text == "0" && !modifiers.control_key() => Command::Look(Move::Whole),
            Key::Character(text) if text.eq_ignore_ascii_case("b") && !modifiers.control_key() => {
                if modifiers.shift_key() { Command::KeepLive } else { Command::Keep }
            }
            Key::Character(text) if text.eq_ignore_ascii_case("x") && !modifiers.control_key() => {
                Command::NextComparison
            }
            Key::Character(text) if text.eq_ignore_ascii_case("v") && !modifiers.control_key() => Command::Flip,
            Key::Character(text) if text.eq_ignore_ascii_case("o") && !modifiers.control_key() => Command::Open,
            Key::Character(text) if text == "." => Command::Step,
            Key::Character(text) if text == "[" => Command::Smaller,
            Key::Character(text) if text == "]" => Command::Larger,
            Key::Character(text) if text.eq_ignore_ascii_case("m") => Command::NextMaterial,
            Key::Character(text) if text.eq_ignore_ascii_case("z") && modifiers.control_key() => Command::Undo,
            Key::Character(text) if text.eq_ignore_ascii_case("y") && modifiers.control_key() => Command::Redo,
            Key::Character(text) if text.eq_ignore_ascii_case("k") && !modifiers.control_key() => Command::RecordKey,
            Key::Character(text) if text.eq_ignore_ascii_case("p") && !modifiers.control_key() => Command::Pin,
            Key::Character(text) if text.eq_ignore_ascii_case("g") && !modifiers.control_key() => Command::HandBack,
            Key::Character(text) if text.eq_ignore_ascii_case("c") && !modifiers.control_key() => Command::CopyCamera,
            Key::Character(text) if text.eq_ignore_ascii_case("r") && !modifiers.control_key() => Command::Reset,
            _ => return None,
        };
        // A held key repeats; only stepping and cycling are meant to.
        let repeats = matches!(
            command,
            Command::Look(_)
                | Command::Step
                | Command::NextTarget
                | Command::PreviousTarget
                | Command::Undo
                | Command::Redo
        );
        (!repeat || repeats).then_some(command)
    }

    /// The left mouse button went down or up.
    pub(crate) fn drag(&mut self, pressed: bool) {
        self.dragging = pressed;
    }

    /// The cursor moved to a pixel (from the top left).
    pub(crate) fn cursor_moved(&mut self, to: [f64; 2]) {
        if let (Some(from), true) = (self.cursor, self.dragging) {
            self.look = [self.look[0] + to[0] - from[0], self.look[1] + to[1] - from[1]];
        }
        self.cursor = Some(to);
    }

    /// The cursor left the window. A drag goes on when it comes back.
    pub(crate) fn cursor_left(&mut self) {
        self.cursor = None;
    }

    /// The window lost the keyboard: nothing is held any more.
    pub(crate) fn release_all(&mut self) {
        self.held.clear();
        self.dragging = false;
    }

    /// The picture begins at another pixel of the window.
    pub(crate) fn set_origin(&mut self, origin: [u32; 2]) {
        self.origin = origin;
    }

    /// Where the cursor is, in pixels from the top left of the picture.
    pub(crate) fn on_picture(&self) -> Option<[f64; 2]> {
        self.cursor.map(|cursor| [0, 1].map(|axis| cursor[axis] - f64::from(self.origin[axis])))
    }

    /// Where the cursor is, in pixels from the top left of the window.
    pub(crate) fn pointer(&self) -> Option<[f64; 2]> {
        self.cursor
    }

    /// The pixel of the picture under the cursor.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a cast of a float saturates, and pixels beyond 2³¹ are outside every window"
    )]
    pub(crate) fn cursor(&self) -> Option<[i32; 2]> {
        self.on_picture().map(|[x, y]| [x.floor() as i32, y.floor() as i32])
    }

    /// Whether a key or a drag moves the camera, or could at any moment.
    pub(crate) fn is_flying(&self) -> bool {
        let keys = [KeyCode::KeyW, KeyCode::KeyA, KeyCode::KeyS, KeyCode::KeyD, KeyCode::KeyQ, KeyCode::KeyE];
        self.dragging || keys.iter().any(|key| self.held.contains(key))
    }

    /// The camera's motion since the last call, and its speed.
    pub(crate) fn fly(&mut self) -> (FlyInput, FlySpeed) {
        let axis = |plus: KeyCode, minus: KeyCode| {
            f64::from(i8::from(self.held.contains(&plus)) - i8::from(self.held.contains(&minus)))
        };
        let motion = [
            axis(KeyCode::KeyD, KeyCode::KeyA),
            axis(KeyCode::KeyE, KeyCode::KeyQ),
            axis(KeyCode::KeyW, KeyCode::KeyS),
        ];
        let speed = FlySpeed { voxels: self.speed, ..FlySpeed::default() };
        let faster = self.held.contains(&KeyCode::ShiftLeft) || self.held.contains(&KeyCode::ShiftRight);
        let input = FlyInput { motion, look: std::mem::take(&mut self.look) };
        (input, FlySpeed { voxels: if faster { speed.voxels * 6.0 } else { speed.voxels }, ..speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(
        controls: &mut Controls,
        code: KeyCode,
        key: &Key,
        modifiers: ModifiersState,
        repeat: bool,
    ) -> Option<Command> {
        controls.key(PhysicalKey::Code(code), key, modifiers, true, repeat)
    }

    #[test]
    fn keys_are_commands_once() {
        let mut c = Controls::default();
        let none = ModifiersState::empty();
        let space = Key::Named(NamedKey::Space);
        assert_eq!(press(&mut c, KeyCode::Space, &space, none, false), Some(Command::Pause));
        assert_eq!(press(&mut c, KeyCode::Space, &space, none, true), None);
        let tab = Key::Named(NamedKey::Tab);
        assert_eq!(press(&mut c, KeyCode::Tab, &tab, none, true), Some(Command::NextTarget));
        assert_eq!(press(&mut c, KeyCode::Tab, &tab, ModifiersState::SHIFT, false), Some(Command::PreviousTarget));
        assert_eq!(press(&mut c, KeyCode::KeyR, &Key::Character("R".into()), none, false), Some(Command::Reset));
        assert_eq!(press(&mut c, KeyCode::Period, &Key::Character(".".into()), none, true), Some(Command::Step));
    }

    #[test]
    fn held_keys_and_drags_fly() {
        let mut c = Controls::default();
        press(&mut c, KeyCode::KeyW, &Key::Character("w".into()), ModifiersState::empty(), false);
        press(&mut c, KeyCode::KeyA, &Key::Character("a".into()), ModifiersState::empty(), false);
        c.cursor_moved([10.0, 10.0]);
        c.drag(true);
        c.cursor_moved([13.0, 9.0]);
        let (input, slow) = c.fly();
        assert_eq!(input, FlyInput { motion: [-1.0, 0.0, 1.0], look: [3.0, -1.0] });
        press(&mut c, KeyCode::ShiftLeft, &Key::Named(NamedKey::Shift), ModifiersState::SHIFT, false);
        let (input, fast) = c.fly();
        assert_eq!(input, FlyInput { motion: input.motion, ..FlyInput::default() });
        assert!(fast.voxels > slow.voxels);
        c.wheel(2.0);
        assert!(c.fly().1.voxels > fast.voxels);
        c.wheel(1e9);
        c.wheel(f64::NAN);
        c.set_speed(f64::INFINITY);
        assert!(FLY_SPEEDS.contains(&c.speed()));
        c.release_all();
        assert_eq!(c.fly().0, FlyInput::default());
    }

    #[test]
    fn the_wheel_says_the_speed() {
        let mut c = Controls::default();
        c.set_speed(48.0);
        c.wheel(1.0);
        assert_eq!(c.speed_text(), "flies at 58 voxels a second");
        c.set_speed(1.5);
        assert_eq!(c.speed_text(), "flies at 1.5 voxels a second");
        c.set_speed(0.1);
        assert_eq!(c.speed_text(), "flies at 0.10 voxels a second");
    }
}
