//! Faults in GLSL: the list of rewrites, and every place of a source where one of them fits.

use std::cmp::Ordering;
use std::ops::Range;

/// One fault.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    /// The bytes that it replaces.
    pub range: Range<usize>,
    pub from: String,
    pub to: String,
}

impl Fault {
    /// The source with the fault in it.
    pub(crate) fn planted(&self, source: &str) -> String {
        format!("{}{}{}", &source[..self.range.start], self.to, &source[self.range.end..])
    }

    /// The number of its line, from 1, and the text of that line.
    pub(crate) fn line<'a>(&self, source: &'a str) -> (usize, &'a str) {
        let before = &source[..self.range.start];
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let text = source[start..].lines().next().unwrap_or_default();
        (before.matches('\n').count() + 1, text.trim())
    }

    /// Its column in bytes, from 1.
    pub(crate) fn column(&self, source: &str) -> usize {
        self.range.start - source[..self.range.start].rfind('\n').map_or(0, |end| end + 1) + 1
    }

    /// The name of the function that it is in.
    pub(crate) fn function<'a>(&self, source: &'a str) -> Option<&'a str> {
        // Functions begin and end at the first column.
        let begins = |line: &&str| line.starts_with(|c: char| c.is_ascii_alphabetic() || c == '}');
        let head = source[..self.range.start].lines().rev().find(begins)?;
        let (front, _) = head.split_once('(').filter(|_| head.ends_with('{'))?;
        front.split_whitespace().last()
    }

    /// How the new number compares with the old one.
    pub(crate) fn order(&self) -> Option<Ordering> {
        number(&self.to)?.partial_cmp(&number(&self.from)?)
    }
}

/// A number of GLSL.
fn number(text: &str) -> Option<f64> {
    let digits = text.strip_suffix('u').unwrap_or(text);
    match digits.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok().map(f64::from),
        None => digits.parse().ok(),
    }
}

/// Words and operators, each with its replacements. Longer operators stand before their own beginnings.
const SWAPS: &[(&str, &[&str])] = &[
    ("<<=", &[]),
    (">>=", &[]),
    ("<<", &[">>"]),
    (">>", &["<<"]),
    ("<=", &["<"]),
    (">=", &[">"]),
    ("==", &["!="]),
    ("!=", &["=="]),
    ("&&", &["||"]),
    ("||", &["&&"]),
    ("++", &[]),
    ("--", &[]),
    ("+=", &["-="]),
    ("-=", &["+="]),
    ("*=", &["/="]),
    ("/=", &["*="]),
    ("|=", &["&=", "^="]),
    ("&=", &["|="]),
    ("^=", &["|="]),
    ("<", &["<="]),
    (">", &[">="]),
    ("&", &["|"]),
    ("|", &["&", "^"]),
    ("^", &["|"]),
    ("+", &["-"]),
    ("-", &["+"]),
    ("*", &["/"]),
    ("/", &["*"]),
    ("!", &[""]),
    ("~", &[""]),
    ("min", &["max"]),
    ("max", &["min"]),
    ("lessThan", &["lessThanEqual"]),
    ("lessThanEqual", &["lessThan"]),
    ("greaterThan", &["greaterThanEqual"]),
    ("greaterThanEqual", &["greaterThan"]),
    ("equal", &["notEqual"]),
    ("notEqual", &["equal"]),
    ("any", &["all"]),
    ("all", &["any"]),
    ("floor", &["ceil"]),
    ("ceil", &["floor"]),
    ("findLSB", &["findMSB"]),
    ("findMSB", &["findLSB"]),
    ("true", &["false"]),
    ("false", &["true"]),
    ("continue", &["break"]),
    ("subgroupMin", &["subgroupMax"]),
    ("subgroupMax", &["subgroupMin"]),
    ("subgroupAny", &["subgroupAll"]),
    ("subgroupAll", &["subgroupAny"]),
    ("RX_FAR", &["0.0"]),
];

/// Every fault that fits into a source. Comments, preprocessor lines and lines with `layout` have none.
pub(crate) fn faults(source: &str) -> Vec<Fault> {
    let mut found = Vec::new();
    let tokens = tokens(source);
    for (n, token) in tokens.iter().enumerate() {
        let text = &source[token.clone()];
        let mut add = |to: String| found.push(Fault { range: token.clone(), from: text.to_owned(), to });
        if let Some((_, becomes)) = SWAPS.iter().find(|(from, _)| *from == text) {
            becomes.iter().for_each(|to| add((*to).to_owned()));
        } else if text.starts_with(|first: char| first.is_ascii_digit()) {
            numbers(text).into_iter().for_each(add);
        } else if n > 0 && &source[tokens[n - 1].clone()] == "." && ["x", "y", "z"].contains(&text) {
            // One axis for another.
            add(["y", "z", "x"][usize::from(text.as_bytes()[0] - b'x')].to_owned());
        }
    }
    found.extend(statements(source, &tokens));
    found
}

/// Numbers beside a number.
fn numbers(text: &str) -> Vec<String> {
    let (digits, suffix) = text.strip_suffix('u').map_or((text, ""), |digits| (digits, "u"));
    if let Some(number) = digits.strip_prefix("0x").map(|digits| u64::from_str_radix(digits, 16)) {
        return number
            .map_or(Vec::new(), |number| [number + 1, number >> 1].map(|n| format!("{n:#x}{suffix}")).to_vec());
    }
    if let Ok(number) = digits.parse::<u64>() {
        let below = number.checked_sub(1).map(|n| format!("{n}{suffix}"));
        return std::iter::once(format!("{}{suffix}", number + 1)).chain(below).collect();
    }
    let Ok(number) = digits.parse::<f64>() else { return Vec::new() };
    if number == 0.0 { vec!["1.0".to_owned()] } else { vec![format!("{:?}", number * 2.0), "0.0".to_owned()] }
}

/// Statements that are gone: assignments, calls and `if` on one line.
fn statements<'a>(source: &'a str, tokens: &'a [Range<usize>]) -> impl Iterator<Item = Fault> + 'a {
    let word = |token: &Range<usize>| source[token.clone()].starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    tokens.split_inclusive(|token| [";", "{", "}"].contains(&&source[token.clone()])).filter_map(move |statement| {
        let [first, second, .., last] = statement else { return None };
        let begins =
            word(first) && !word(second) && &source[first.clone()] != "return" && &source[first.clone()] != "for";
        let range = first.start..last.end;
        let text = &source[range.clone()];
        (begins && text.ends_with(';') && !text.contains('\n')).then(|| Fault {
            range,
            from: text.to_owned(),
            to: ";".to_owned(),
        })
    })
}

/// The places of all words, numbers and operators that a fault may change.
fn tokens(source: &str) -> Vec<Range<usize>> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < source.len() {
        let rest = &source[at..];
        let first = rest.chars().next().expect("there is a rest");
        let begins_line =
            source[..at].lines().last().is_none_or(|line| line.trim().is_empty()) || source[..at].ends_with('\n');
        let line = rest.find('\n').unwrap_or(rest.len());
        let length = if rest.starts_with("//") || begins_line && (first == '#' || rest.starts_with("layout")) {
            at += line;
            continue;
        } else if rest.starts_with("/*") {
            at += rest.find("*/").map_or(rest.len(), |end| end + 2);
            continue;
        } else if first.is_ascii_alphabetic() || first == '_' {
            rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len())
        } else if first.is_ascii_digit() {
            let exponent = |end: usize| end > 0 && !rest.starts_with("0x") && matches!(&rest[end - 1..end], "e" | "E");
            rest.char_indices()
                .find(|&(end, c)| !(c.is_ascii_alphanumeric() || c == '.' || matches!(c, '+' | '-') && exponent(end)))
                .map_or(rest.len(), |(end, _)| end)
        } else {
            let operator = SWAPS.iter().map(|(from, _)| *from).find(|from| rest.starts_with(from));
            operator.map_or(first.len_utf8(), str::len)
        };
        if !first.is_whitespace() {
            tokens.push(at..at + length);
        }
        at += length;
    }
    tokens
}

#[test]
fn every_rewrite_finds_its_places() {
    let source = r"#define LEAVE 1 < 2
// a < b
layout(std430) buffer B { uint x[8]; };
float f(vec3 a, uint n) {
    if (a.x < 1e-3 && !(n != 0x7fu)) a.y += 2.0;
    return min(a.y, 0.0);
}
";
    let all: Vec<String> = faults(source)
        .iter()
        .map(|fault| {
            assert_eq!(&source[fault.range.clone()], fault.from);
            assert!(fault.planted(source).len() + fault.from.len() == source.len() + fault.to.len());
            format!("{}: {} -> {}", fault.line(source).0, fault.from, fault.to)
        })
        .collect();
    let expected = [
        "5: x -> y",
        "5: < -> <=",
        "5: 1e-3 -> 0.002",
        "5: 1e-3 -> 0.0",
        "5: && -> ||",
        "5: ! -> ",
        "5: != -> ==",
        "5: 0x7fu -> 0x80u",
        "5: 0x7fu -> 0x3fu",
        "5: y -> z",
        "5: += -> -=",
        "5: 2.0 -> 4.0",
        "5: 2.0 -> 0.0",
        "6: min -> max",
        "6: y -> z",
        "6: 0.0 -> 1.0",
        "5: if (a.x < 1e-3 && !(n != 0x7fu)) a.y += 2.0; -> ;",
    ];
    assert_eq!(all, expected);
}
