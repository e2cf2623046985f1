//! Mouse, keyboard, gamepad, microphone and time of day over the time of a demo.

use raxel_diagnostics::Spanned;
use raxel_diagnostics::names::closest;
use raxel_diagnostics::table::Node;
use raxel_language::{Keys, Shape, Value, describe};
use serde_json::json;

use crate::curve::{Interpolation, sample, segment};
use crate::inputs::{
    BUTTONS, DAY, GAMEPAD_BUTTONS, Key, KeySet, LEFT, NO_DRAG, ShownInputs, button_named, gamepad_button_named,
};
use crate::read::{Clock, ordered, project_path, time};

/// Inputs that are held and turned over time. Inputs that are left out come from the window.
#[derive(Clone, Debug, Default, PartialEq, Keys)]
#[keys(context = Clock)]
pub struct DemoInputs {
    /// Cursor: [seconds, pixel] in order of time, in pixels of a picture of `size`; `[]` for no cursor. It moves in straight lines.
    /// From the window when left out.
    pub cursor: Option<CursorKeys>,
    /// Mouse buttons that are held from then on: [seconds, names] in order of time. Names are `left`, `right`, `middle`, `back` and
    /// `forward`. From the window when left out.
    pub buttons: Option<ButtonKeys>,
    /// Lines that the wheel was turned since the start, to the right and away from the user: [seconds, lines] in order of time.
    /// From the window when left out.
    pub wheel: Option<WheelKeys>,
    /// Keys that are held from then on: [seconds, names] in order of time. Names are those of browsers, e.g. `KeyW` or `ArrowLeft`.
    /// From the window when left out.
    pub keys: Option<KeyboardKeys>,
    /// Sticks of a gamepad, each axis in [−1, 1]: [seconds, [left stick to the right, up, right stick to the right, up]] in order of
    /// time. They move in straight lines. From the window when left out.
    pub gamepad_sticks: Option<StickKeys>,
    /// Triggers of a gamepad, in [0, 1]: [seconds, [left, right]] in order of time. They move in straight lines. From the window when
    /// left out.
    pub gamepad_triggers: Option<TriggerKeys>,
    /// Buttons of a gamepad that are held from then on: [seconds, names] in order of time, e.g. `south` or `left_shoulder`. From the
    /// window when left out.
    pub gamepad_buttons: Option<GamepadButtonKeys>,
    /// Sound that the microphone hears from the start on: a file, relative to worlds/. From the window when left out.
    #[keys(read = project_path("worlds"))]
    pub microphone: Option<Spanned<String>>,
    /// Seconds since midnight at the start.
    #[keys(range = 0.0..=DAY, default = 0.0, unit = "seconds")]
    pub time_of_day: f64,
}

/// Times and pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct CursorKeys(Vec<(f64, Option<[f64; 2]>)>);

/// Times and bits of buttons.
#[derive(Clone, Debug, PartialEq)]
pub struct ButtonKeys(Vec<(f64, u32)>);

/// Times and lines.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelKeys(Vec<(f64, [f64; 2])>);

/// Times and sticks.
#[derive(Clone, Debug, PartialEq)]
pub struct StickKeys(Vec<(f64, [f64; 4])>);

/// Times and triggers.
#[derive(Clone, Debug, PartialEq)]
pub struct TriggerKeys(Vec<(f64, [f64; 2])>);

/// Times and bits of buttons of a gamepad.
#[derive(Clone, Debug, PartialEq)]
pub struct GamepadButtonKeys(Vec<(f64, u32)>);

/// Times and keys that are held.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyboardKeys(Vec<(f64, KeySet)>);

impl DemoInputs {
    /// Replaces the live inputs of a frame by those of the demo. `time` are seconds into the timeline, and `before` those of the frame
    /// before; `scale` are pixels of the output for each of the demo's.
    pub fn lay_over(&self, shown: &mut ShownInputs, before: Option<f64>, time: f64, scale: [f64; 2]) {
        if let Some(cursor) = &self.cursor {
            shown.cursor = cursor.at(time).map(|pixel| scaled(pixel, scale));
        }
        if let Some(buttons) = &self.buttons {
            shown.buttons = held(&buttons.0, time).copied().unwrap_or_default();
            shown.pressed = pressed(&buttons.0, before, time);
            shown.drag = self.drag(buttons, time, scale);
        }
        if let Some(wheel) = &self.wheel {
            shown.wheel = in_lines(&wheel.0, time);
        }
        if let Some(sticks) = &self.gamepad_sticks {
            shown.gamepad.sticks = in_lines(&sticks.0, time);
        }
        if let Some(triggers) = &self.gamepad_triggers {
            shown.gamepad.triggers = in_lines(&triggers.0, time);
        }
        if let Some(buttons) = &self.gamepad_buttons {
            shown.gamepad.buttons = held(&buttons.0, time).copied().unwrap_or_default();
            shown.gamepad_pressed = pressed(&buttons.0, before, time);
        }
        if let Some(keys) = &self.keys {
            shown.keys = held(&keys.0, time).copied().unwrap_or_default();
            (shown.keys_pressed, shown.keys_toggled) = (KeySet::NONE, KeySet::NONE);
            for (at, down) in presses(&keys.0, time, KeySet::without) {
                shown.keys_toggled = shown.keys_toggled.xor(down);
                if is_between(before, at, time) {
                    shown.keys_pressed = shown.keys_pressed.or(down);
                }
            }
        }
        shown.time_of_day = (self.time_of_day + time).rem_euclid(DAY);
    }

    /// The times of the keys of each input that the demo has, by the name of the input.
    pub fn times(&self) -> Vec<(&'static str, Vec<f64>)> {
        fn of<T>(keys: &[(f64, T)]) -> Vec<f64> {
            keys.iter().map(|(time, _)| *time).collect()
        }
        let named = [
            ("cursor", self.cursor.as_ref().map(|keys| of(&keys.0))),
            ("buttons", self.buttons.as_ref().map(|keys| of(&keys.0))),
            ("wheel", self.wheel.as_ref().map(|keys| of(&keys.0))),
            ("keys", self.keys.as_ref().map(|keys| of(&keys.0))),
            ("gamepad_sticks", self.gamepad_sticks.as_ref().map(|keys| of(&keys.0))),
            ("gamepad_triggers", self.gamepad_triggers.as_ref().map(|keys| of(&keys.0))),
            ("gamepad_buttons", self.gamepad_buttons.as_ref().map(|keys| of(&keys.0))),
        ];
        named.into_iter().filter_map(|(name, times)| Some((name, times?))).collect()
    }

    /// The last drag: where it is or ended, and where it began.
    fn drag(&self, buttons: &ButtonKeys, time: f64, scale: [f64; 2]) -> [i32; 4] {
        let began = presses(&buttons.0, time, |now, then| now & !then).filter(|(_, down)| down & LEFT != 0).last();
        let Some((began, _)) = began else { return NO_DRAG };
        let ended = buttons.0.iter().find(|(at, held)| *at > began && held & LEFT == 0).map_or(time, |(at, _)| *at);
        let pixel = |at| self.cursor.as_ref()?.last(at).map(|pixel| scaled(pixel, scale));
        let ([to_x, to_y], [from_x, from_y]) =
            (pixel(ended.min(time)).unwrap_or([-1; 2]), pixel(began).unwrap_or([-1; 2]));
        [to_x, to_y, from_x, from_y]
    }
}

/// Whether a moment belongs to the frame at `time`. A frame before it that is later is that of the round before.
fn is_between(before: Option<f64>, at: f64, time: f64) -> bool {
    at <= time && before.is_none_or(|before| before > time || before < at)
}

/// The value of the last key at or before a time.
fn held<T>(keys: &[(f64, T)], time: f64) -> Option<&T> {
    keys.iter().take_while(|(at, _)| *at <= time).last().map(|(_, value)| value)
}

/// Bits that went down in a frame.
fn pressed(keys: &[(f64, u32)], before: Option<f64>, time: f64) -> u32 {
    let presses = presses(keys, time, |now, then| now & !then).filter(|(at, _)| is_between(before, *at, time));
    presses.fold(0, |pressed, (_, down)| pressed | down)
}

/// Numbers that move in straight lines, and are zero before their first key.
fn in_lines<const N: usize>(keys: &[(f64, [f64; N])], time: f64) -> [f64; N] {
    if time < keys[segment(keys.iter().map(|(at, _)| *at), time)].0 {
        return [0.0; N];
    }
    std::array::from_fn(|axis| sample(keys.len(), |i| (keys[i].0, keys[i].1[axis]), time, Interpolation::Linear))
}

/// The buttons that go down with each key up to a time.
fn presses<T: Copy + Default>(
    keys: &[(f64, T)],
    time: f64,
    rising: impl Fn(T, T) -> T,
) -> impl Iterator<Item = (f64, T)> {
    let mut then = T::default();
    keys.iter().take_while(move |(at, _)| *at <= time).map(move |(at, now)| {
        let down = rising(*now, then);
        then = *now;
        (*at, down)
    })
}

/// The pixel of an output with `scale` pixels for one of the demo's.
#[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates")]
fn scaled(pixel: [f64; 2], scale: [f64; 2]) -> [i32; 2] {
    [0, 1].map(|axis| ((pixel[axis].round() + 0.5) * scale[axis]).floor() as i32)
}

impl CursorKeys {
    fn at(&self, time: f64) -> Option<[f64; 2]> {
        let keys = &self.0;
        let now = keys.iter().take_while(|(at, _)| *at <= time).count().checked_sub(1)?;
        let from = keys[now].1?;
        match keys.get(now + 1) {
            Some((end, Some(to))) => {
                let part = (time - keys[now].0) / (end - keys[now].0);
                Some([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part))
            }
            _ => Some(from),
        }
    }

    /// Where it was last, up to a time.
    fn last(&self, time: f64) -> Option<[f64; 2]> {
        self.at(time).or_else(|| self.0.iter().rev().filter(|(at, _)| *at <= time).find_map(|(_, pixel)| *pixel))
    }
}

fn pairs(about: &str) -> Shape {
    let key = json!({ "type": "array", "minItems": 2, "maxItems": 2, "description": about });
    Shape::Schema(json!({ "type": "array", "minItems": 1, "items": key }))
}

describe! {
    CursorKeys => pairs("[seconds, [x, y]], or [seconds, []] for no cursor");
    ButtonKeys => pairs("[seconds, [names of buttons]]");
    WheelKeys => pairs("[seconds, [lines to the right, lines away]]");
    StickKeys => pairs("[seconds, [left stick to the right, up, right stick to the right, up]]");
    TriggerKeys => pairs("[seconds, [left, right]]");
    GamepadButtonKeys => pairs("[seconds, [names of buttons]]");
    KeyboardKeys => pairs("[seconds, [names of keys]]");
}

/// Reads `[[seconds, value], …]` in order of time.
fn read_keys<T>(
    node: &Node<'_, '_>,
    clock: &Clock,
    value: impl Fn(&Node<'_, '_>) -> Option<T>,
) -> Option<Vec<(f64, T)>> {
    let nodes = node.array()?;
    if nodes.is_empty() {
        return node.bad_value(format!("`{}` needs one key at least", node.name));
    }
    let key = |node: &Node<'_, '_>| {
        let parts = node.array()?;
        let [at, of] = parts.as_slice() else {
            return node.bad_value(format!("`{}` must be [seconds, value]", node.name));
        };
        let (at, of) = (time(at, clock), value(of));
        Some((at?, of?))
    };
    let read: Vec<Option<(Spanned<f64>, T)>> = nodes.iter().map(key).collect();
    let keys = ordered(node.reporter(), read, |(at, _)| at)?;
    Some(keys.into_iter().map(|(at, of)| (at.value, of)).collect())
}

/// Reads names of buttons or keys.
fn named<T>(node: &Node<'_, '_>, of: impl Fn(&str) -> Option<T>, what: &str, known: &[&'static str]) -> Option<Vec<T>> {
    let name = |node: &Node<'_, '_>| {
        let name = node.string()?;
        let found = of(&name);
        if found.is_none() {
            let like = closest(&name, known.iter().copied())
                .map_or_else(String::new, |like| format!("; did you mean `{like}`?"));
            return node.bad_value(format!("`{name}` is no {what}{like}"));
        }
        found
    };
    node.array()?.iter().map(name).collect()
}

impl Value<Clock> for CursorKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        let pixel = |node: &Node<'_, '_>| match node.array()?.as_slice() {
            [] => Some(None),
            _ => node.numbers(-1e6..=1e6).map(Some),
        };
        read_keys(node, clock, pixel).map(Self)
    }
}

impl Value<Clock> for ButtonKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        let buttons = |node: &Node<'_, '_>| {
            Some(named(node, button_named, "mouse button", &BUTTONS)?.into_iter().fold(0, |held, bit| held | bit))
        };
        read_keys(node, clock, buttons).map(Self)
    }
}

impl Value<Clock> for WheelKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        read_keys(node, clock, |node| node.numbers(-1e6..=1e6)).map(Self)
    }
}

impl Value<Clock> for StickKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        read_keys(node, clock, |node| node.numbers(-1.0..=1.0)).map(Self)
    }
}

impl Value<Clock> for TriggerKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        read_keys(node, clock, |node| node.numbers(0.0..=1.0)).map(Self)
    }
}

impl Value<Clock> for GamepadButtonKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        let buttons = |node: &Node<'_, '_>| {
            let bits = named(node, gamepad_button_named, "button of a gamepad", &GAMEPAD_BUTTONS)?;
            Some(bits.into_iter().fold(0, |held, bit| held | bit))
        };
        read_keys(node, clock, buttons).map(Self)
    }
}

impl Value<Clock> for KeyboardKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        let known: Vec<&str> = Key::names().collect();
        let keys = |node: &Node<'_, '_>| Some(named(node, Key::named, "key", &known)?.into_iter().collect());
        read_keys(node, clock, keys).map(Self)
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use raxel_diagnostics::SourceMap;
    use raxel_diagnostics::disk::MemoryFiles;

    use super::*;
    use crate::{Demo, read};

    fn demo(inputs: &str) -> Result<Demo, Vec<String>> {
        let text =
            format!("world = \"a.toml\"\ngraph = \"b.toml\"\nduration = 4.0\nsize = [100, 100]\n[inputs]\n{inputs}");
        let files = MemoryFiles::new([("worlds/a.demo.toml", text.as_str())]);
        let found = read(&files, "worlds/a.demo.toml", &mut SourceMap::default());
        found.map(|(demo, _)| demo).map_err(|found| found.into_iter().map(|found| found.message).collect())
    }

    fn at(demo: &Demo, before: Option<f64>, time: f64, scale: f64) -> ShownInputs {
        let mut shown = ShownInputs::default();
        demo.inputs.as_ref().unwrap().lay_over(&mut shown, before, time, [scale; 2]);
        shown
    }

    #[test]
    fn a_drag_is_a_function_of_time() {
        let demo = demo(
            "cursor = [[0.0, [10, 20]], [2.0, [30, 20]], [3.0, []]]\nbuttons = [[0.5, [\"left\"]], [1.5, [\"right\"]], [3.5, [\"left\"]]]\n\
             wheel = [[1.0, [0, 0]], [2.0, [0, 4]]]\ntime_of_day = 86399.0\n",
        )
        .unwrap();
        let first = at(&demo, None, 0.0, 1.0);
        assert_eq!((first.cursor, first.buttons, first.drag, first.time_of_day), (Some([10, 20]), 0, NO_DRAG, 86399.0));
        let pressed = at(&demo, Some(0.4), 0.5, 1.0);
        assert_eq!((pressed.buttons, pressed.pressed, pressed.drag), (1, 1, [15, 20, 15, 20]));
        let held = at(&demo, Some(0.5), 1.0, 2.0);
        assert_eq!((held.buttons, held.pressed, held.drag, held.cursor), (1, 0, [41, 41, 31, 41], Some([41, 41])));
        let over = at(&demo, Some(1.9), 2.5, 1.0);
        assert_eq!((over.buttons, over.drag, over.wheel), (2, [25, 20, 15, 20], [0.0, 4.0]));
        assert!((over.time_of_day - 1.5).abs() < 1e-9, "past midnight");
        // Without a cursor, a drag begins where it was last.
        assert_eq!((at(&demo, None, 3.5, 1.0).cursor, at(&demo, None, 3.5, 1.0).drag), (None, [30, 20, 30, 20]));
        assert_eq!((at(&demo, Some(0.5), 1.5, 1.0).wheel, at(&demo, None, 0.5, 1.0).wheel), ([0.0, 2.0], [0.0, 0.0]));
    }

    #[test]
    fn keys_are_pressed_and_toggled() {
        let demo = demo("keys = [[0.0, [\"KeyW\"]], [1.0, []], [2.0, [\"KeyW\", \"Space\"]]]").unwrap();
        let names = |set: KeySet| set.names().collect::<Vec<_>>();
        let told = |before, time| {
            let shown = at(&demo, before, time, 1.0);
            [names(shown.keys), names(shown.keys_pressed), names(shown.keys_toggled)]
        };
        assert_eq!(told(None, 0.0), [vec!["KeyW"], vec!["KeyW"], vec!["KeyW"]]);
        assert_eq!(told(Some(0.0), 0.5), [vec!["KeyW"], vec![], vec!["KeyW"]]);
        assert_eq!(told(Some(0.5), 1.5), [vec![], vec![], vec!["KeyW"]]);
        assert_eq!(told(Some(1.5), 2.5), [vec!["KeyW", "Space"], vec!["KeyW", "Space"], vec!["Space"]]);
        // A frame in which a demo starts over.
        assert_eq!(told(Some(3.9), 0.1)[1], ["KeyW"]);
    }

    #[test]
    fn a_gamepad_is_a_function_of_time() {
        let demo = demo(
            "gamepad_sticks = [[1.0, [0, 0, 0, 0]], [2.0, [1, -0.5, 0, 0]]]\ngamepad_triggers = [[0.0, [0, 1]]]\n\
             gamepad_buttons = [[0.5, [\"south\", \"up\"]], [1.0, [\"up\"]], [1.5, [\"south\"]]]\n",
        )
        .unwrap();
        let told = |before, time| {
            let shown = at(&demo, before, time, 1.0);
            (shown.gamepad.sticks, shown.gamepad.triggers, shown.gamepad.buttons, shown.gamepad_pressed)
        };
        let (south, up) = (gamepad_button_named("south").unwrap(), gamepad_button_named("up").unwrap());
        assert_eq!(told(None, 0.0), ([0.0; 4], [0.0, 1.0], 0, 0));
        assert_eq!(told(Some(0.4), 0.5), ([0.0; 4], [0.0, 1.0], south | up, south | up));
        assert_eq!(told(Some(1.4), 1.5), ([0.5, -0.25, 0.0, 0.0], [0.0, 1.0], south, south));
        assert_eq!(told(Some(3.0), 3.5), ([1.0, -0.5, 0.0, 0.0], [0.0, 1.0], south, 0));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, said) in [
            ("keys = [[0.0, [\"W\"]]]", "`W` is no key"),
            ("keys = [[0.0, [\"keyW\"]]]", "did you mean `KeyW`?"),
            ("buttons = [[0.0, [\"lefft\"]]]", "`lefft` is no mouse button; did you mean `left`?"),
            ("buttons = [[2.0, []], [1.0, []]]", "keys must be in order of time"),
            ("cursor = [[5.0, [1, 2]]]", "outside the demo"),
            ("cursor = [[0.0, [1]]]", "cursor"),
            ("cursor = []", "needs one key at least"),
            ("wheel = [[0.0]]", "must be [seconds, value]"),
            ("time_of_day = -1.0", "must be in 0…86400"),
            ("gamepad_sticks = [[0.0, [0, 0, 0, 1.5]]]", "gamepad_sticks"),
            ("gamepad_triggers = [[0.0, [-0.5, 0]]]", "gamepad_triggers"),
            ("gamepad_buttons = [[0.0, [\"soth\"]]]", "`soth` is no button of a gamepad; did you mean `south`?"),
            ("microphone = 1", "microphone"),
            ("microphone = \"../../a.wav\"", "`../../a.wav` leads outside the project root"),
            ("pad = 1", "no key `pad`"),
        ] {
            let found = demo(text).unwrap_err();
            assert!(found[0].contains(said), "{text}: {found:?}");
        }
    }
}
