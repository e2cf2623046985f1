//! Random damage to a file.

use crate::Random;

/// Numbers that are likely to break things.
const NUMBERS: [&str; 16] = [
    "0",
    "-1",
    "1",
    "2",
    "7",
    "0.0",
    "0.5",
    "-0.5",
    "255",
    "65536",
    "4294967296",
    "-2147483648",
    "1e9",
    "1e300",
    "nan",
    "3.0000001",
];

/// Pieces of graphs, worlds and shaders that stand where they should not.
const PIECES: [&str; 14] = [
    "}",
    "{",
    "\"",
    "'''",
    "[[passes]]\n",
    "[targets.color]\n",
    "#include <raxel/world.glsl>\n",
    "#include \"sky.glsl\"\n",
    "/*",
    "\u{feff}",
    "return;",
    "layout(local_size_x = 1024) in;\n",
    "= =",
    "present = \"depth\"\n",
];

/// A broken version of a file; `None` deletes it.
pub(super) fn broken(good: &[u8], random: &mut Random) -> (&'static str, Option<Vec<u8>>) {
    let mut bytes = good.to_vec();
    let mut lines: Vec<&[u8]> = good.split_inclusive(|byte| *byte == b'\n').collect();
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    match random.below(22) {
        0 => {
            bytes.truncate(random.below(good.len()));
            ("truncated", Some(bytes))
        }
        1 | 2 => {
            let at = random.below(good.len());
            bytes[at] ^= 1 << random.below(8);
            ("a bit flipped", Some(bytes))
        }
        3 | 4 => {
            lines.swap(a, b);
            ("two lines swapped", Some(lines.concat()))
        }
        5 => {
            lines.remove(a);
            ("a line removed", Some(lines.concat()))
        }
        6 => {
            lines.insert(a, lines[b]);
            ("a line repeated", Some(lines.concat()))
        }
        7..=10 => {
            let (start, length) = word(good, random, u8::is_ascii_digit, |byte| byte.is_ascii_digit() || *byte == b'.');
            bytes.splice(start..start + length, random.of(&NUMBERS).bytes());
            ("a number replaced", Some(bytes))
        }
        11 | 12 => {
            let name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
            let (start, length) = word(good, random, u8::is_ascii_alphabetic, name);
            let (from, other) = word(good, random, u8::is_ascii_alphabetic, name);
            bytes.splice(start..start + length, good[from..from + other].iter().copied());
            ("a word replaced", Some(bytes))
        }
        13 => {
            let at = random.below(good.len());
            bytes.splice(at..at, random.of(&PIECES).bytes());
            ("a piece put in", Some(bytes))
        }
        14 => {
            let at = random.below(good.len());
            bytes.splice(at..at, [0xff, 0xfe, 0]);
            ("bytes that are not text", Some(bytes))
        }
        // Most of these are right.
        15..=20 => {
            let digits: Vec<usize> = (0..good.len()).filter(|at| good[*at].is_ascii_digit()).collect();
            let at = *random.of(&digits);
            bytes[at] = b'0' + random.below(10) as u8;
            ("a digit replaced", Some(bytes))
        }
        _ if random.below(2) == 0 => ("emptied", Some(Vec::new())),
        _ => ("deleted", None),
    }
}

/// A word from a random place on: where it begins, and how long it is.
fn word(text: &[u8], random: &mut Random, begins: fn(&u8) -> bool, goes_on: impl Fn(&u8) -> bool) -> (usize, usize) {
    let from = random.below(text.len());
    let Some(start) = text[from..].iter().position(begins).map(|at| from + at) else { return (from, 0) };
    (start, text[start..].iter().take_while(|byte| goes_on(byte)).count())
}
