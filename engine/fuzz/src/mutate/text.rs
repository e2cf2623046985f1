//! Changes of TOML and JSON, word by word: a change of single bytes is hardly ever TOML again.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use raxel_world::random::SplitMix64;
use serde_json::Value;

use super::pick;

/// Values that are on the edge of something.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "16",
    "63",
    "64",
    "65",
    "100",
    "255",
    "256",
    "1000",
    "4096",
    "4097",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "-2147483649",
    "4294967295",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551616",
    "0.0",
    "-0.0",
    "0.5",
    "0.001",
    "1e-9",
    "1e-300",
    "5e-324",
    "1e9",
    "1e18",
    "1e19",
    "1e38",
    "1e39",
    "1e300",
    "1.7976931348623157e308",
    "1e309",
    "nan",
    "inf",
    "-inf",
];

/// Values of every other type.
const VALUES: &[&str] = &[
    "true",
    "false",
    "\"\"",
    "\" \"",
    "\"a\"",
    "\"\\u0000\"",
    "\"\\u001b[31m\"",
    "\"a\\nb\"",
    "\"é漢𝄞\"",
    "\"\\u202e\"",
    "\"../..\"",
    "\"/\"",
    "\"C:/a\"",
    "\"#ff8000\"",
    "\"full\"",
    "\"a@1\"",
    "\"a@99999999999\"",
    "[]",
    "[[]]",
    "{}",
    "[0]",
    "[0, 0]",
    "[0, 0, 0]",
    "[1, 1, 1, 1]",
    "[-1, -1, -1]",
    "[0.5, 0.5, 0.5]",
    "[[0, 0, 0], [1, 1, 1]]",
    "{ a = 1 }",
    "1979-05-27",
    "0xffffffffffffffff",
    "0o17",
    "0b1",
];

/// A piece of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Token {
    kind: Kind,
    at: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Number,
    Text,
    Word,
    Mark,
}

/// Changes a text one to four times.
pub(super) fn mutated(text: &str, other: &str, words: &[String], random: &mut SplitMix64) -> String {
    let mut text = text.to_owned();
    for _ in 0..=random.below(4) {
        text = changed(&text, other, words, random);
    }
    text
}

/// Changes a text of any language one to six times: its lines, its numbers and texts, and words of the language anywhere.
pub(super) fn pasted(text: &str, other: &str, words: &[&str], random: &mut SplitMix64) -> String {
    let mut text = text.to_owned();
    for _ in 0..=random.below(6) {
        let [from, to] = [(); 2].map(|()| boundary(&text, random));
        text = match random.below(10) {
            0..=3 => splice(&text, from..from, pick(random, words).copied().unwrap_or_default()),
            4 => splice(&text, from..(from + 12).min(to).max(from), pick(random, words).copied().unwrap_or_default()),
            5 => splice(&text, from.min(to)..to.max(from).min(from.min(to) + 40), ""),
            6 => without_lines(&text, random),
            7 => with_lines(&text, other, random),
            _ => changed(&text, other, &[], random),
        };
    }
    text
}

/// Bytes as text.
pub(super) fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn changed(text: &str, other: &str, words: &[String], random: &mut SplitMix64) -> String {
    let tokens = tokens(text);
    let of = |kinds: &[Kind]| -> Vec<&Token> { tokens.iter().filter(|token| kinds.contains(&token.kind)).collect() };
    let numbers = of(&[Kind::Number]);
    let values = of(&[Kind::Number, Kind::Text]);
    let names = of(&[Kind::Word, Kind::Text]);
    let replaced = |token: Option<&&Token>, with: &str| match token {
        Some(token) => splice(text, token.at.clone(), with),
        None => format!("{text}{with}"),
    };
    match random.below(16) {
        0..=2 => {
            let with = pick(random, NUMBERS).copied().unwrap_or_default();
            replaced(pick(random, &numbers), with)
        }
        3 => {
            let token = pick(random, &numbers);
            let with = token.map(|token| nearby(&text[token.at.clone()], random)).unwrap_or_default();
            replaced(token, &with)
        }
        4 => {
            let with = pick(random, VALUES).copied().unwrap_or_default();
            replaced(pick(random, &values), with)
        }
        5 => {
            let with = extreme(random);
            replaced(pick(random, &values), &with)
        }
        // Another value of the same text: references that lead elsewhere, or in a circle.
        6 | 7 => {
            let with = pick(random, &values).map(|token| text[token.at.clone()].to_owned()).unwrap_or_default();
            replaced(pick(random, &values), &with)
        }
        8 => {
            let with = pick(random, words).cloned().unwrap_or_default();
            let token = pick(random, &names);
            let quoted = token.is_some_and(|token| token.kind == Kind::Text);
            replaced(token, &if quoted { format!("\"{with}\"") } else { with })
        }
        9 => {
            let with = pick(random, &names).map(|token| text[token.at.clone()].to_owned()).unwrap_or_default();
            replaced(pick(random, &names), &with)
        }
        10 => without_lines(text, random),
        11 => with_lines(text, text, random),
        12 => with_lines(text, other, random),
        // A key of the language with a value of some kind.
        13 => {
            let key = pick(random, words).cloned().unwrap_or_default();
            let all: &[&str] = if random.below(2) == 0 { NUMBERS } else { VALUES };
            let value = pick(random, all).copied().unwrap_or_default();
            with_lines(text, &format!("{key} = {value}\n"), random)
        }
        14 => {
            let marks = of(&[Kind::Mark]);
            let with = pick(random, &["[", "]", "{", "}", "=", ",", ".", "\"", "\n", "#", ""]).copied();
            replaced(pick(random, &marks), with.unwrap_or_default())
        }
        _ => {
            let at = boundary(text, random);
            let with = pick(random, &["\0", "\u{7f}", "\u{feff}", "é", "𝄞", "\r", "\t", " ", "x", "9", "-", "\""]);
            splice(text, at..at, with.copied().unwrap_or_default())
        }
    }
}

/// A number near another.
fn nearby(number: &str, random: &mut SplitMix64) -> String {
    let change = random.below(6);
    if let Ok(value) = number.parse::<i64>() {
        let value = match change {
            0 => value.wrapping_add(1),
            1 => value.wrapping_sub(1),
            2 => value.wrapping_neg(),
            3 => value.wrapping_mul(2),
            4 => value / 2,
            _ => value.wrapping_mul(1000),
        };
        return value.to_string();
    }
    let Ok(value) = number.parse::<f64>() else { return "1".to_owned() };
    let value = match change {
        0 => value + 1.0,
        1 => value - 1.0,
        2 => -value,
        3 => value * 2.0,
        4 => value / 2.0,
        _ => value * 1e6,
    };
    format!("{value:?}")
}

/// A value that is deep, long or wide.
fn extreme(random: &mut SplitMix64) -> String {
    let size = 1 << random.below(13);
    match random.below(5) {
        0 => format!("{}1{}", "[".repeat(size), "]".repeat(size)),
        1 => format!("\"{}\"", "x".repeat(size)),
        2 => format!("\"{}\"", "../".repeat(size)),
        3 => format!("[{}]", vec!["1"; size].join(", ")),
        _ => format!("{}1{}", "{ a = ".repeat(size), " }".repeat(size)),
    }
}

/// The text with some of its lines, or none.
fn without_lines(text: &str, random: &mut SplitMix64) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let (from, count) = some(lines.len(), random);
    lines.drain(from..from + count);
    lines.concat()
}

/// The text with some lines of another somewhere.
fn with_lines(text: &str, other: &str, random: &mut SplitMix64) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let others: Vec<&str> = other.split_inclusive('\n').collect();
    let (from, count) = some(others.len(), random);
    let at = random.index(lines.len() + 1);
    // Rarely a great many times.
    let times = if random.below(20) == 0 { 1 << random.below(8) } else { 1 };
    let copies = others[from..from + count].repeat(times);
    lines.splice(at..at, copies);
    lines.concat()
}

/// A short range within `of` things, as its start and its length.
fn some(of: usize, random: &mut SplitMix64) -> (usize, usize) {
    let from = random.index(of + 1);
    let most = 1 + random.index(12);
    (from, most.min(of - from))
}

fn boundary(text: &str, random: &mut SplitMix64) -> usize {
    let mut at = random.index(text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// The text with something in place of a range, whose ends are moved to the letters they lie in.
fn splice(text: &str, at: Range<usize>, with: &str) -> String {
    let floor = |mut at: usize| {
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let at = floor(at.start)..floor(at.end);
    [&text[..at.start], with, &text[at.end..]].concat()
}

/// The pieces of a text that is about TOML or JSON. Comments and blanks are none.
fn tokens(text: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        let is_word = |byte: u8| byte.is_ascii_alphanumeric() || b"_-+.".contains(&byte);
        let kind = match bytes[at] {
            b'#' => {
                while at < bytes.len() && bytes[at] != b'\n' {
                    at += 1;
                }
                continue;
            }
            quote @ (b'"' | b'\'') => {
                at += 1;
                while at < bytes.len() && bytes[at] != quote && bytes[at] != b'\n' {
                    at += if bytes[at] == b'\\' && quote == b'"' { 2 } else { 1 };
                }
                // The end of the text may be within an escape, and a letter may follow a backslash.
                at = (at + 1).min(bytes.len());
                while !text.is_char_boundary(at) {
                    at += 1;
                }
                Kind::Text
            }
            byte if is_word(byte) => {
                while at < bytes.len() && is_word(bytes[at]) {
                    at += 1;
                }
                let number = byte.is_ascii_digit() || b"+-.".contains(&byte);
                if number || ["nan", "inf"].contains(&&text[start..at]) { Kind::Number } else { Kind::Word }
            }
            byte if b"[]{}=,:".contains(&byte) => {
                at += 1;
                Kind::Mark
            }
            _ => {
                at += 1;
                continue;
            }
        };
        found.push(Token { kind, at: start..at });
    }
    found
}

/// The words of a language: keys and named values of its schema.
pub(super) fn words_of(schema: fn() -> Value) -> Arc<[String]> {
    static KNOWN: Mutex<Option<HashMap<usize, Arc<[String]>>>> = Mutex::new(None);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let words = known.get_or_insert_default().entry(schema as usize);
    let words = words.or_insert_with(|| {
        let mut words = BTreeSet::new();
        collect(&schema(), &mut words);
        words.into_iter().collect()
    });
    words.clone()
}

fn collect(schema: &Value, words: &mut BTreeSet<String>) {
    match schema {
        Value::Object(fields) => {
            if let Some(properties) = fields.get("properties").and_then(Value::as_object) {
                words.extend(properties.keys().cloned());
            }
            let named = fields.get("enum").and_then(Value::as_array).into_iter().flatten().chain(fields.get("const"));
            words.extend(named.filter_map(|value| value.as_str().map(str::to_owned)));
            fields.values().for_each(|value| collect(value, words));
        }
        Value::Array(elements) => elements.iter().for_each(|value| collect(value, words)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_fall_into_pieces() {
        let text = "a.b = [1, -2.5e3] # 7\n[x]\n\"é\\\"\" = 'y'\nz = inf";
        let found: Vec<(Kind, &str)> = tokens(text).iter().map(|token| (token.kind, &text[token.at.clone()])).collect();
        let kind = |kind: Kind| -> Vec<&str> { found.iter().filter(|(k, _)| *k == kind).map(|(_, t)| *t).collect() };
        assert_eq!(kind(Kind::Number), ["1", "-2.5e3", "inf"]);
        assert_eq!(kind(Kind::Text), ["\"é\\\"\"", "'y'"]);
        assert_eq!(kind(Kind::Word), ["a.b", "x", "z"]);
        for broken in ["\"\\", "\"\\é", "'", "\"é"] {
            tokens(broken).iter().for_each(|token| assert!(broken.get(token.at.clone()).is_some(), "{broken}"));
        }
    }

    #[test]
    fn a_language_has_its_words() {
        let words = words_of(raxel_graphfile::schema);
        for word in ["passes", "rgba16f", "linear", "dispatch"] {
            assert!(words.iter().any(|known| known == word), "{word} is none of {words:?}");
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_text() {
        let text = "[a]\nb = 1\nc = \"d\"\n";
        let words = ["e".to_owned()];
        let made = |seed| mutated(text, text, &words, &mut SplitMix64::new(seed));
        let all: BTreeSet<String> = (0..1000).map(made).collect();
        assert!(all.len() > 500, "{} different texts", all.len());
        assert!((0..100).all(|seed| made(seed) == made(seed)));
    }
}
