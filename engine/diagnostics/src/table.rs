//! Reads TOML so that every mistake in a file is reported, and not only the first. A [`Table`] hands out values by key, and reports a
//! wrong type at its place. [`Table::finish`] reports every key that no reader asked for, with the closest known key.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::names::{closest, list};
use crate::render::brief;
use crate::{Code, Diagnostic, FileError, SourceMap, Span, codes};

/// Most bytes of a name in a message.
const MAX_NAME: usize = 200;

/// Collects the diagnostics of one file.
#[derive(Debug)]
pub struct Reporter {
    file: Arc<str>,
    found: RefCell<Vec<Diagnostic>>,
}

impl Reporter {
    /// For the file of that project path.
    pub fn new(file: impl Into<Arc<str>>) -> Self {
        Self { file: file.into(), found: RefCell::default() }
    }

    /// The file.
    pub fn file(&self) -> &Arc<str> {
        &self.file
    }

    /// Adds a diagnostic.
    pub fn report(&self, diagnostic: Diagnostic) {
        self.found.borrow_mut().push(diagnostic);
    }

    /// The number of diagnostics so far. A reader that compares two counts knows whether something went wrong between them.
    pub fn count(&self) -> usize {
        self.found.borrow().len()
    }

    /// Everything reported, in order.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.found.into_inner()
    }
}

/// Largest TOML text that is parsed, in bytes: 2 MiB. The parsed form of nested tables takes 250 times as much memory as their text.
pub const MAX_TOML: usize = 2 << 20;

/// Parses a TOML text. Syntax errors are reported, all that the parser can recover from; the result is `None` when there is any, or when
/// the text is larger than [`MAX_TOML`].
pub fn parse<'t>(text: &'t str, reporter: &Reporter) -> Option<Spanned<DeTable<'t>>> {
    if text.len() > MAX_TOML {
        let error = FileError::TooLarge { size: text.len() as u64, limit: MAX_TOML as u64 };
        reporter.report(error.diagnostic(&reporter.file, None));
        return None;
    }
    let (table, errors) = DeTable::parse_recoverable(text);
    // A file of another kind is wrong in every line.
    let other = Path::new(&*reporter.file).extension().is_some_and(|extension| extension != "toml");
    // The parser says the same of each level that a missing bracket leaves open.
    let mut said = None;
    for error in errors.iter().take(if other { 1 } else { errors.len() }) {
        let at = error.span().unwrap_or(0..0);
        let end = at.end.min(text.len());
        let range = at.start.min(end)..end;
        if said.replace((range.clone(), error.message())) == Some((range.clone(), error.message())) {
            continue;
        }
        let diagnostic = Diagnostic::error(codes::files::TOML_SYNTAX, format!("TOML syntax: {}", error.message()))
            .label(Span::new(reporter.file.clone(), range), "");
        let help = format!("graphs, worlds and demos are files `NAME.toml`: is `{}` one?", reporter.file);
        reporter.report(if other { diagnostic.help(help) } else { diagnostic });
    }
    errors.is_empty().then_some(table)
}

/// A table being read.
pub struct Table<'a, 't> {
    name: String,
    span: Span,
    entries: &'a DeTable<'t>,
    asked: RefCell<BTreeSet<String>>,
    /// Keys that were reported as missing.
    missing: RefCell<BTreeSet<String>>,
    reporter: &'a Reporter,
}

/// One value with its place.
#[derive(Clone)]
pub struct Node<'a, 't> {
    /// Path of keys, e.g. `targets.hit.format`, for messages.
    pub name: String,
    /// Place of the value.
    pub span: Span,
    /// Place of its key; of the value itself for an array element.
    pub key_span: Span,
    value: &'a DeValue<'t>,
    reporter: &'a Reporter,
}

impl<'a, 't> Table<'a, 't> {
    /// The whole document.
    pub fn root(document: &'a Spanned<DeTable<'t>>, reporter: &'a Reporter) -> Self {
        let span = Span::new(reporter.file.clone(), document.span());
        Self {
            name: String::new(),
            span,
            entries: document.get_ref(),
            asked: RefCell::default(),
            missing: RefCell::default(),
            reporter,
        }
    }

    /// Path of keys, empty for the document.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Place of the table (its header, for a `[table]`).
    pub fn span(&self) -> &Span {
        &self.span
    }

    /// Where diagnostics go.
    pub fn reporter(&self) -> &'a Reporter {
        self.reporter
    }

    fn child(&self, key: &str) -> String {
        // Every entry has the name of its table in its own: whole, a long one would stand in memory as often.
        let key = brief(key, MAX_NAME);
        if self.name.is_empty() {
            key.into_owned()
        } else {
            brief(&format!("{}.{key}", self.name), MAX_NAME).into_owned()
        }
    }

    /// The value of a key, of any type.
    pub fn get(&self, key: &str) -> Option<Node<'a, 't>> {
        self.asked.borrow_mut().insert(key.to_owned());
        let (name, value) = self.entries.get_key_value(key)?;
        Some(self.node(name, value))
    }

    fn node(&self, key: &Spanned<std::borrow::Cow<'t, str>>, value: &'a Spanned<DeValue<'t>>) -> Node<'a, 't> {
        let file = &self.reporter.file;
        Node {
            name: self.child(key.get_ref()),
            span: Span::new(file.clone(), value.span()),
            key_span: Span::new(file.clone(), key.span()),
            value: value.get_ref(),
            reporter: self.reporter,
        }
    }

    /// The value of a key that must be there.
    pub fn need(&self, key: &str) -> Option<Node<'a, 't>> {
        let node = self.get(key);
        if node.is_none() {
            self.missing.borrow_mut().insert(key.to_owned());
            self.reporter.report(self.lacks(key));
        }
        node
    }

    fn lacks(&self, key: &str) -> Diagnostic {
        let whose = if self.name.is_empty() { "the file".to_owned() } else { format!("`{}`", self.name) };
        Diagnostic::error(codes::files::MISSING_KEY, format!("{whose} needs the key `{key}`"))
            .label(self.span.clone(), "missing here")
    }

    /// Reads a value ahead of its turn: whatever is wrong with it, its own reader reports.
    pub fn peek<T>(&self, key: &str, read: impl FnOnce(&Node<'a, 't>) -> Option<T>) -> Option<T> {
        let (name, value) = self.entries.get_key_value(key)?;
        let before = self.reporter.count();
        let read = read(&self.node(name, value));
        self.reporter.found.borrow_mut().truncate(before);
        read
    }

    /// Every entry in the order of the file; they all count as asked for.
    pub fn entries(&self) -> Vec<(String, Node<'a, 't>)> {
        let mut all: Vec<_> =
            self.entries.iter().map(|(key, value)| (key.get_ref().to_string(), self.node(key, value))).collect();
        all.sort_by_key(|(_, node)| node.key_span.range.start);
        self.asked.borrow_mut().extend(all.iter().map(|(key, _)| key.clone()));
        all
    }

    /// Reports two keys that exclude each other. True if both are there.
    pub fn conflict(&self, a: &str, b: &str, why: &str) -> bool {
        let (Some(first), Some(second)) = (self.get(a), self.get(b)) else { return false };
        self.reporter.report(
            Diagnostic::error(codes::files::CONFLICTING_KEYS, format!("`{a}` and `{b}` exclude each other: {why}"))
                .label(second.key_span, "this one")
                .label(first.key_span, "and this one"),
        );
        true
    }

    /// Reports every key that no reader asked for. A key that is missing because it is misspelt is one mistake.
    /// Gives the keys that were meant.
    pub fn finish(&self) -> Vec<String> {
        let mut meant = Vec::new();
        let asked = self.asked.borrow();
        let mut unknown: Vec<_> =
            self.entries.iter().filter(|(key, _)| !asked.contains(key.get_ref().as_ref())).collect();
        unknown.sort_by_key(|(key, _)| key.span().start);
        for (key, _) in unknown {
            let whose = if self.name.is_empty() { "the file".to_owned() } else { format!("`{}`", self.name) };
            let mut diagnostic = Diagnostic::error(
                codes::files::UNKNOWN_KEY,
                format!("{whose} has no key `{}`", brief(key.get_ref(), MAX_NAME)),
            )
            .label(Span::new(self.reporter.file.clone(), key.span()), "unknown key");
            diagnostic = match closest(key.get_ref(), asked.iter().map(String::as_str)) {
                Some(name) => {
                    if self.missing.borrow_mut().remove(name) {
                        let lacks = self.lacks(name);
                        self.reporter.found.borrow_mut().retain(|found| *found != lacks);
                    }
                    meant.push(name.to_owned());
                    diagnostic.help(format!("did you mean `{name}`?"))
                }
                None => diagnostic.help(format!("known keys: {}", list(asked.iter().map(String::as_str)))),
            };
            self.reporter.report(diagnostic);
        }
        meant
    }
}

impl<'a, 't> Node<'a, 't> {
    /// The TOML type, for messages.
    pub fn type_name(&self) -> &'static str {
        match self.value {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a float",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        }
    }

    /// Where diagnostics go.
    pub fn reporter(&self) -> &'a Reporter {
        self.reporter
    }

    /// Reports anything about this value, with its place as the primary label.
    pub fn report(&self, code: Code, message: impl Into<String>, label: impl Into<String>) {
        self.reporter.report(Diagnostic::error(code, message).label(self.span.clone(), label));
    }

    /// Reports that another type is needed. Gives `None` for use as the tail of a reader.
    pub fn wrong_type<T>(&self, expected: &str) -> Option<T> {
        self.report(
            codes::files::WRONG_TYPE,
            format!("`{}` needs {expected}, not {}", self.name, self.type_name()),
            format!("this is {}", self.type_name()),
        );
        None
    }

    /// Reports that the value is not allowed. Gives `None` for use as the tail of a reader.
    pub fn bad_value<T>(&self, message: impl Into<String>) -> Option<T> {
        self.report(codes::files::BAD_VALUE, message, "");
        None
    }

    /// Whether it is a string.
    pub fn is_string(&self) -> bool {
        matches!(self.value, DeValue::String(_))
    }

    /// Whether it is an integer or a float.
    pub fn is_number(&self) -> bool {
        matches!(self.value, DeValue::Integer(_) | DeValue::Float(_))
    }

    /// Whether it is an integer.
    pub fn is_integer(&self) -> bool {
        matches!(self.value, DeValue::Integer(_))
    }

    /// Whether it is a boolean.
    pub fn is_boolean(&self) -> bool {
        matches!(self.value, DeValue::Boolean(_))
    }

    /// Whether it is an array.
    pub fn is_array(&self) -> bool {
        matches!(self.value, DeValue::Array(_))
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        matches!(self.value, DeValue::Table(_))
    }

    /// As text.
    pub fn string(&self) -> Option<String> {
        match self.value {
            DeValue::String(text) => Some(text.to_string()),
            _ => self.wrong_type("a string"),
        }
    }

    /// As a boolean.
    pub fn boolean(&self) -> Option<bool> {
        match self.value {
            DeValue::Boolean(value) => Some(*value),
            _ => self.wrong_type("`true` or `false`"),
        }
    }

    /// As an integer in a range. The range has the type that the value is kept in, so that no reader has to cast it.
    pub fn integer<T: Integer>(&self, range: RangeInclusive<T>) -> Option<T> {
        let DeValue::Integer(integer) = self.value else { return self.wrong_type("an integer") };
        // Underscores and a sign are already normalised by the parser; only the radix is left to say.
        let value =
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().and_then(|value| T::try_from(value).ok());
        match value {
            Some(value) if range.contains(&value) => Some(value),
            _ => self.bad_value(format!("`{}` is {integer}; it must be {}", self.name, range_text(&range))),
        }
    }

    /// As a finite number (integers are taken too) in a range.
    pub fn number(&self, range: RangeInclusive<f64>) -> Option<f64> {
        let value: f64 = match self.value {
            DeValue::Integer(integer) => {
                let Ok(value) = i64::from_str_radix(integer.as_str(), integer.radix()) else {
                    let message = format!("`{}` is {integer}, which does not fit a 64-bit integer", self.name);
                    return self.bad_value(message);
                };
                value as f64
            }
            DeValue::Float(float) => match float.as_str().parse() {
                Ok(value) => value,
                Err(_) => return self.wrong_type("a number"),
            },
            _ => return self.wrong_type("a number"),
        };
        if value.is_finite() && range.contains(&value) {
            Some(value)
        } else if !value.is_finite() {
            self.bad_value(format!("`{}` must be a finite number", self.name))
        } else {
            // In full, 1e300 has 301 digits.
            let value = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
            self.bad_value(format!("`{}` is {value}; it must be in {}…{}", self.name, range.start(), range.end()))
        }
    }

    /// One of a list of words.
    pub fn word<T: Clone>(&self, words: &[(&str, T)]) -> Option<T> {
        let text = self.string()?;
        if let Some((_, value)) = words.iter().find(|(word, _)| *word == text) {
            return Some(value.clone());
        }
        let names = || words.iter().map(|(word, _)| *word);
        let mut diagnostic = Diagnostic::error(
            codes::files::BAD_VALUE,
            format!("`{}` cannot be `{}`", self.name, brief(&text, MAX_NAME)),
        )
        .label(self.span.clone(), "");
        if let Some(name) = closest(&text, names()) {
            diagnostic = diagnostic.help(format!("did you mean `{name}`?"));
        }
        self.reporter.report(diagnostic.help(format!("one of: {}", list(names()))));
        None
    }

    /// As an array.
    pub fn array(&self) -> Option<Vec<Node<'a, 't>>> {
        let DeValue::Array(elements) = self.value else { return self.wrong_type("an array") };
        let file = &self.reporter.file;
        let nodes = elements.iter().enumerate().map(|(i, element)| {
            let span = Span::new(file.clone(), element.span());
            Node {
                name: format!("{}[{i}]", self.name),
                key_span: span.clone(),
                span,
                value: element.get_ref(),
                reporter: self.reporter,
            }
        });
        Some(nodes.collect())
    }

    /// As an array of `N` finite numbers in a range.
    pub fn numbers<const N: usize>(&self, range: RangeInclusive<f64>) -> Option<[f64; N]> {
        let elements = self.array()?;
        if elements.len() != N {
            return self.bad_value(format!("`{}` needs {N} numbers, not {}", self.name, elements.len()));
        }
        let values: Vec<f64> = elements.iter().filter_map(|element| element.number(range.clone())).collect();
        values.try_into().ok()
    }

    /// As an array of `N` integers in a range.
    pub fn integers<T: Integer, const N: usize>(&self, range: RangeInclusive<T>) -> Option<[T; N]> {
        let elements = self.array()?;
        if elements.len() != N {
            return self.bad_value(format!("`{}` needs {N} integers, not {}", self.name, elements.len()));
        }
        let values: Vec<T> = elements.iter().filter_map(|element| element.integer(range.clone())).collect();
        values.try_into().ok()
    }

    /// As a table.
    pub fn table(&self) -> Option<Table<'a, 't>> {
        let DeValue::Table(entries) = self.value else { return self.wrong_type("a table") };
        Some(Table {
            name: self.name.clone(),
            span: self.key_span.clone(),
            entries,
            asked: RefCell::default(),
            missing: RefCell::default(),
            reporter: self.reporter,
        })
    }
}

/// A type that [`Node::integer`] can read an integer of TOML into.
pub trait Integer: Copy + PartialOrd + TryInto<i128> + TryFrom<i64> {}

impl<T: Copy + PartialOrd + TryInto<i128> + TryFrom<i64>> Integer for T {}

fn range_text<T: Integer>(range: &RangeInclusive<T>) -> String {
    const MIN: i128 = i64::MIN as i128;
    const MAX: i128 = i64::MAX as i128;
    match [*range.start(), *range.end()].map(|end| end.try_into().unwrap_or(i128::MAX)) {
        [MIN, MAX] => "a 64-bit integer".to_owned(),
        [start, MAX] => format!("at least {start}"),
        [start, end] => format!("in {start}…{end}"),
    }
}

/// Reads and parses a whole TOML file. `read` gets the document; the result is `Err` with everything found if anything was an error,
/// else the value with the warnings.
pub fn read_document<T>(
    file: &str,
    text: &str,
    texts: &mut SourceMap,
    read: impl FnOnce(&Table<'_, '_>) -> Option<T>,
) -> Result<(T, Vec<Diagnostic>), Vec<Diagnostic>> {
    texts.insert(file, text);
    let reporter = Reporter::new(file);
    let value = parse(text, &reporter).and_then(|document| read(&Table::root(&document, &reporter)));
    let found = reporter.into_diagnostics();
    match value {
        Some(value) if !found.iter().any(Diagnostic::is_error) => Ok((value, found)),
        _ => Err(found),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mistake_is_reported_at_once() {
        let text = "name = 3\nsise = 1\n[t]\ncount = -1\n";
        let found = read_document("g.toml", text, &mut SourceMap::default(), |root| {
            root.need("name").and_then(|node| node.string());
            root.get("size");
            let table = root.get("t")?.table()?;
            table.get("count").and_then(|n| n.integer(0..=9));
            table.need("format");
            table.finish();
            root.finish();
            Some(())
        })
        .unwrap_err();
        let short: Vec<_> = found.iter().map(|d| (d.code.as_str(), d.labels[0].span.range.clone())).collect();
        assert_eq!(short, [("RX0012", 7..8), ("RX0014", 30..32), ("RX0013", 19..20), ("RX0011", 9..13)]);
        assert_eq!(found[3].help, ["did you mean `size`?"]);
    }

    #[test]
    fn a_file_of_another_kind_is_one_mistake() {
        let text = "# Read me\n\nThis is\nno TOML at all\n";
        let found =
            |file: &str| read_document(file, text, &mut SourceMap::default(), |_| Some(())).expect_err("it is no TOML");
        assert!(found("g.toml").len() > 1);
        assert_eq!(found("g.toml")[0].help, [""; 0]);
        let other = found("README.md");
        assert_eq!(other.len(), 1);
        assert_eq!(other[0].help, ["graphs, worlds and demos are files `NAME.toml`: is `README.md` one?"]);
    }

    #[test]
    fn a_misspelt_key_is_one_mistake() {
        let text = "[[show]]\ntagret = 1\n[[show]]\n[[show]]\ntagret = 1\ntargte = 2\n";
        let found = read_document("g.toml", text, &mut SourceMap::default(), |root| {
            for table in root.get("show")?.array()?.iter().filter_map(Node::table) {
                table.need("target");
                table.need("time");
                table.finish();
            }
            Some(())
        })
        .unwrap_err();
        let said: Vec<_> = found.iter().map(|found| found.message.as_str()).collect();
        let expected = [
            "`show[0]` needs the key `time`",
            "`show[0]` has no key `tagret`",
            "`show[1]` needs the key `target`",
            "`show[1]` needs the key `time`",
            "`show[2]` needs the key `time`",
            "`show[2]` has no key `tagret`",
            "`show[2]` has no key `targte`",
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn a_value_read_ahead_is_reported_once() {
        let mut peeked = Vec::new();
        let read = |root: &Table<'_, '_>| {
            let number = |node: &Node<'_, '_>| node.number(0.0..=1.0);
            peeked = ["a", "b", "c"].map(|key| root.peek(key, number)).to_vec();
            root.get("a").and_then(|node| number(&node))
        };
        let found = read_document("g.toml", "a = 2\nb = 1\n", &mut SourceMap::default(), read).unwrap_err();
        assert_eq!((found.len(), peeked), (1, vec![None, Some(1.0), None]));
    }

    #[test]
    fn syntax_errors_have_places() {
        let found = read_document("g.toml", "a = \"x\nb = 1", &mut SourceMap::default(), |_| Some(())).unwrap_err();
        assert_eq!(found[0].code.as_str(), "RX0010");
        assert_eq!(found[0].labels[0].span.file.as_ref(), "g.toml");
    }

    /// A reader that gives nothing and says nothing would leave the key at its default.
    #[test]
    fn no_number_is_passed_over() {
        for value in ["9223372036854775808", "-9223372036854775809", "0xffff_ffff_ffff_ffff", "inf", "nan", "1e999"] {
            let read = |root: &Table<'_, '_>| root.get("a")?.number(f64::MIN..=f64::MAX);
            let found = read_document("g.toml", &format!("a = {value}"), &mut SourceMap::default(), read).unwrap_err();
            assert!(found.iter().any(Diagnostic::is_error), "{value}: {found:?}");
        }
    }

    fn found_in(text: &str) -> Vec<Diagnostic> {
        let read = |root: &Table<'_, '_>| {
            let tables = root.get("t").and_then(|node| node.table());
            let entries = tables.iter().flat_map(Table::entries);
            for table in entries.filter_map(|(_, node)| node.table()) {
                table.get("known");
                table.finish();
            }
            root.finish();
            Some(())
        };
        read_document("g.toml", text, &mut SourceMap::default(), read).map_or_else(|found| found, |((), found)| found)
    }

    #[test]
    fn a_bracket_that_is_missing_thrice_is_said_once() {
        let found = found_in("x = [[[");
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found_in("x = 1\nx = 2\nx = 3\n").len(), 2);
    }

    #[test]
    fn a_text_that_is_too_large_is_not_parsed() {
        let found = found_in(&format!("x = \"{}\"", "y".repeat(MAX_TOML)));
        assert_eq!(found[0].code, codes::files::TOO_LARGE);
        assert_eq!(
            found[0].message,
            "`g.toml` is too large: it has 2097158 bytes, more than the 2097152 that raxel reads"
        );
    }

    /// Each mistake names its table, and would hold as much memory as the name is long.
    #[test]
    fn a_long_name_is_not_held_once_a_mistake() {
        let long = "n".repeat(300_000);
        let keys: String = (0..50_000).fold(String::new(), |keys, index| keys + &format!("k{index} = 1\n"));
        let found = found_in(&format!("[t.{long}]\n{keys}"));
        assert_eq!(found.len(), 50_000);
        assert!(found.iter().all(|found| found.message.len() < 600), "{}", found[0].message);
    }
}
