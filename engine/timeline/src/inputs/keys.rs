//! Keys of a keyboard: their names in files, and sets of them.

/// Names of keys, as the W3C standard `uievents-code` has them, and their usages in USB HID, page 7. A key is a place on the keyboard,
/// independent of its label.
const NAMES: [(&str, u8); 105] = [
    ("KeyA", 4),
    ("KeyB", 5),
    ("KeyC", 6),
    ("KeyD", 7),
    ("KeyE", 8),
    ("KeyF", 9),
    ("KeyG", 10),
    ("KeyH", 11),
    ("KeyI", 12),
    ("KeyJ", 13),
    ("KeyK", 14),
    ("KeyL", 15),
    ("KeyM", 16),
    ("KeyN", 17),
    ("KeyO", 18),
    ("KeyP", 19),
    ("KeyQ", 20),
    ("KeyR", 21),
    ("KeyS", 22),
    ("KeyT", 23),
    ("KeyU", 24),
    ("KeyV", 25),
    ("KeyW", 26),
    ("KeyX", 27),
    ("KeyY", 28),
    ("KeyZ", 29),
    ("Digit1", 30),
    ("Digit2", 31),
    ("Digit3", 32),
    ("Digit4", 33),
    ("Digit5", 34),
    ("Digit6", 35),
    ("Digit7", 36),
    ("Digit8", 37),
    ("Digit9", 38),
    ("Digit0", 39),
    ("Enter", 40),
    ("Escape", 41),
    ("Backspace", 42),
    ("Tab", 43),
    ("Space", 44),
    ("Minus", 45),
    ("Equal", 46),
    ("BracketLeft", 47),
    ("BracketRight", 48),
    ("Backslash", 49),
    ("Semicolon", 51),
    ("Quote", 52),
    ("Backquote", 53),
    ("Comma", 54),
    ("Period", 55),
    ("Slash", 56),
    ("CapsLock", 57),
    ("F1", 58),
    ("F2", 59),
    ("F3", 60),
    ("F4", 61),
    ("F5", 62),
    ("F6", 63),
    ("F7", 64),
    ("F8", 65),
    ("F9", 66),
    ("F10", 67),
    ("F11", 68),
    ("F12", 69),
    ("PrintScreen", 70),
    ("ScrollLock", 71),
    ("Pause", 72),
    ("Insert", 73),
    ("Home", 74),
    ("PageUp", 75),
    ("Delete", 76),
    ("End", 77),
    ("PageDown", 78),
    ("ArrowRight", 79),
    ("ArrowLeft", 80),
    ("ArrowDown", 81),
    ("ArrowUp", 82),
    ("NumLock", 83),
    ("NumpadDivide", 84),
    ("NumpadMultiply", 85),
    ("NumpadSubtract", 86),
    ("NumpadAdd", 87),
    ("NumpadEnter", 88),
    ("Numpad1", 89),
    ("Numpad2", 90),
    ("Numpad3", 91),
    ("Numpad4", 92),
    ("Numpad5", 93),
    ("Numpad6", 94),
    ("Numpad7", 95),
    ("Numpad8", 96),
    ("Numpad9", 97),
    ("Numpad0", 98),
    ("NumpadDecimal", 99),
    ("IntlBackslash", 100),
    ("ContextMenu", 101),
    ("ControlLeft", 224),
    ("ShiftLeft", 225),
    ("AltLeft", 226),
    ("MetaLeft", 227),
    ("ControlRight", 228),
    ("ShiftRight", 229),
    ("AltRight", 230),
    ("MetaRight", 231),
];

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u8);

impl Key {
    /// The key of that name, e.g. `KeyW` or `ArrowLeft`.
    pub fn named(name: &str) -> Option<Self> {
        NAMES.iter().find(|(known, _)| *known == name).map(|(_, usage)| Self(*usage))
    }

    /// All names.
    pub fn names() -> impl Iterator<Item = &'static str> + Clone {
        NAMES.iter().map(|(name, _)| *name)
    }
}

/// A set of keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KeySet([u32; 8]);

impl KeySet {
    /// No key.
    pub const NONE: Self = Self([0; 8]);

    /// Puts a key in, or takes it out.
    pub fn set(&mut self, key: Key, held: bool) {
        let (word, bit) = (usize::from(key.0 / 32), 1 << (key.0 % 32));
        if held {
            self.0[word] |= bit;
        } else {
            self.0[word] &= !bit;
        }
    }

    /// Names of the keys in it, in the order of the table of names.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        NAMES
            .iter()
            .filter(move |(_, usage)| self.0[usize::from(usage / 32)] >> (usage % 32) & 1 != 0)
            .map(|(name, _)| *name)
    }

    /// A bit for each usage.
    pub fn words(self) -> [u32; 8] {
        self.0
    }

    /// Keys of either set.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] | other.0[word]))
    }

    /// Keys that are in one of the sets alone.
    #[must_use]
    pub(crate) fn xor(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] ^ other.0[word]))
    }

    /// Keys that the other set does not have.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] & !other.0[word]))
    }
}

impl FromIterator<Key> for KeySet {
    fn from_iter<I: IntoIterator<Item = Key>>(keys: I) -> Self {
        let mut set = Self::NONE;
        keys.into_iter().for_each(|key| set.set(key, true));
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_the_keys_that_were_put_in() {
        let mut set: KeySet = ["KeyW", "ShiftLeft", "KeyW"].into_iter().filter_map(Key::named).collect();
        assert_eq!(set.names().collect::<Vec<_>>(), ["KeyW", "ShiftLeft"]);
        set.set(Key::named("KeyW").unwrap(), false);
        assert_eq!(set.names().collect::<Vec<_>>(), ["ShiftLeft"]);
        assert_eq!(Key::named("W"), None);
        for name in Key::names() {
            let alone: KeySet = Key::named(name).into_iter().collect();
            assert_eq!(alone.names().collect::<Vec<_>>(), [name], "no other key has its number");
        }
    }

    /// `BracketLeft` is `RX_KEY_BRACKET_LEFT` in shaders.
    #[test]
    fn the_shader_library_has_the_same_numbers() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/include/raxel/keys.glsl");
        let library = std::fs::read_to_string(path).unwrap();
        for (name, usage) in NAMES {
            let plain = name.strip_prefix("Key").or(name.strip_prefix("Digit")).unwrap_or(name);
            let mut word = String::from("RX_KEY_");
            let function = plain.starts_with('F') && plain.len() <= 3;
            for (at, c) in plain.chars().enumerate() {
                if at > 0 && (c.is_uppercase() || (c.is_ascii_digit() && !function)) {
                    word.push('_');
                }
                word.extend(c.to_uppercase());
            }
            assert!(library.contains(&format!("const uint {word} = {usage}u;\n")), "{word}");
        }
        assert_eq!(library.matches("const uint RX_KEY_").count(), NAMES.len());
    }
}
