//! The names in a graph, world or demo that refer to a table of a graph, or declare it: targets and buffers, params, clocks, loops and passes; and the keys
//! that give something to a shader. Read without checking, from texts that may be half typed.

use std::ops::Range;

use raxel_terminal::offline::FileKind;
use toml_parser::decoder::Encoding;
use toml_parser::parser::{EventReceiver, RecursionGuard, parse_document};
use toml_parser::{ErrorSink, Source, Span};

use super::indexed_text::IndexedText;

/// The kind of thing that a name of a graph means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TomlName {
    /// A target or a buffer: they share their names.
    Resource,
    Param,
    Clock,
    Loop,
    Pass,
}

impl TomlName {
    /// With its article, for messages.
    pub(crate) fn article(self) -> &'static str {
        match self {
            Self::Resource => "a target or buffer",
            Self::Param => "a param",
            Self::Clock => "a clock",
            Self::Loop => "a loop",
            Self::Pass => "a pass",
        }
    }
}

/// A place where a name stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mention {
    pub what: TomlName,
    pub place: Range<usize>,
    /// A table of its own, rather than a reference.
    pub declares: bool,
}

/// A key, or a value that is a text, by the keys that lead there. The last of them is its own, if it is a key.
#[derive(Clone, Debug)]
pub(super) struct TomlWord {
    pub path: Vec<String>,
    pub place: Range<usize>,
    pub is_key: bool,
}

/// A key with its value, by the keys that lead there, its own included.
#[derive(Clone, Debug)]
pub(super) struct TomlEntry {
    pub path: Vec<String>,
    /// From the key to the end of its value.
    pub place: Range<usize>,
}

/// Every mention of a graph's name in a graph, world or demo.
pub(super) fn mentions(text: &IndexedText, kind: FileKind) -> Vec<Mention> {
    let mention = |word: &TomlWord| {
        let name = &text[word.place.clone()];
        let path: Vec<&str> = word.path.iter().map(String::as_str).collect();
        let (what, range) = match kind {
            FileKind::Graph if word.is_key => (declared(&path)?, 0..name.len()),
            FileKind::Graph => referred(&path, name)?,
            FileKind::Demo => match (path.as_slice(), word.is_key) {
                (["tracks", _], true) => (TomlName::Param, 0..name.len()),
                (["show", "target"], false) => (TomlName::Resource, plain(name)),
                (["check", "pass"], false) => (TomlName::Pass, 0..name.len()),
                _ => return None,
            },
            FileKind::World => match (path.as_slice(), word.is_key) {
                (["instances", "turn" | "slide", "param"], false) => (TomlName::Param, 0..name.len()),
                _ => return None,
            },
            FileKind::Project => return None,
        };
        let declares = kind == FileKind::Graph && (word.is_key || path == ["passes", "name"]);
        let place = word.place.start + range.start..word.place.start + range.end;
        (!place.is_empty()).then_some(Mention { what, place, declares })
    };
    text.words().iter().filter_map(mention).collect()
}

/// The kind of table that a key declares.
fn declared(path: &[&str]) -> Option<TomlName> {
    match path {
        ["targets" | "buffers", _] => Some(TomlName::Resource),
        ["params", _] => Some(TomlName::Param),
        ["clocks", _] => Some(TomlName::Clock),
        ["loops", _] => Some(TomlName::Loop),
        _ => None,
    }
}

/// The kind of thing that a text refers to, and the part of the text that is the name.
fn referred(path: &[&str], text: &str) -> Option<(TomlName, Range<usize>)> {
    let whole = 0..text.len();
    match path {
        ["about" | "name" | "extends", ..]
        | [.., "label" | "tooltip" | "unit" | "group" | "says" | "help" | "shader"] => None,
        ["passes", "name" | "before" | "after"] => Some((TomlName::Pass, whole)),
        ["passes", "loop"] => Some((TomlName::Loop, whole)),
        ["passes", "every"] | ["targets" | "buffers", _, "clock"] => Some((TomlName::Clock, whole)),
        // A size of the world, which is no resource here.
        ["passes", "dispatch", "threads"] | ["targets" | "buffers", _, "size", "of"] if text == "world" => None,
        ["present"]
        | ["passes", "bind", _]
        | ["passes", "bind", _, "target"]
        | ["passes", "dispatch", "threads" | "groups" | "indirect" | "count"]
        | ["targets" | "buffers", _, "size", "of"]
        | ["loops", _, "swap"]
        | ["loops", _, "count", "mips"] => Some((TomlName::Resource, plain(text))),
        _ => prefixed(text),
    }
}

/// The name before its age: `color` in `color@1`.
fn plain(text: &str) -> Range<usize> {
    0..text.find('@').unwrap_or(text.len())
}

/// A name in a value such as `param.sun`, `!param.sun` or `target.color.size`.
fn prefixed(text: &str) -> Option<(TomlName, Range<usize>)> {
    let start = usize::from(text.starts_with('!'));
    let (what, prefix, suffixed) = [
        (TomlName::Param, "param.", false),
        (TomlName::Resource, "target.", true),
        (TomlName::Resource, "buffer.", true),
        (TomlName::Clock, "clock.", true),
    ]
    .into_iter()
    .find(|(_, prefix, _)| text[start..].starts_with(prefix))?;
    let start = start + prefix.len();
    let end = if suffixed { text.rfind('.').filter(|end| *end > start)? } else { text.len() };
    Some((what, start..end))
}

/// Every key and text of a TOML file in order. Texts with escapes are left out: they are no names.
pub(super) fn words(text: &str) -> Vec<TomlWord> {
    read(text).found
}

/// Every key with its value, those of an inline table before the key of the table.
pub(super) fn entries(text: &str) -> Vec<TomlEntry> {
    read(text).entries
}

fn read(text: &str) -> Reader<'_> {
    /// Tables within tables that are followed, at most.
    const DEEPEST: u32 = 64;
    let source = Source::new(text);
    let tokens = source.lex().into_vec();
    let mut reader = Reader {
        text,
        found: Vec::new(),
        entries: Vec::new(),
        in_header: false,
        header: Vec::new(),
        open: Vec::new(),
        key: Key::default(),
    };
    parse_document(&tokens, &mut RecursionGuard::new(&mut reader, DEEPEST), &mut ());
    reader
}

/// The key that is read, or whose value is read.
#[derive(Clone, Debug, Default)]
struct Key {
    path: Vec<String>,
    /// Where it begins.
    start: usize,
    has_value: bool,
    /// Arrays of its value that are open.
    arrays: usize,
}

struct Reader<'t> {
    text: &'t str,
    found: Vec<TomlWord>,
    entries: Vec<TomlEntry>,
    in_header: bool,
    header: Vec<String>,
    /// The keys that lead to each inline table around, and the key that it is the value of.
    open: Vec<(Vec<String>, Key)>,
    key: Key,
}

impl Reader<'_> {
    fn base(&self) -> Vec<String> {
        self.open.last().map_or_else(|| self.header.clone(), |(base, _)| base.clone())
    }

    fn path(&self) -> Vec<String> {
        let mut path = self.base();
        path.extend(self.key.path.iter().cloned());
        path
    }

    /// A value ends here, or an element of one.
    fn end_value(&mut self, end: usize) {
        if self.key.has_value && self.key.arrays == 0 {
            self.entries.push(TomlEntry { path: self.path(), place: self.key.start..end });
        }
    }

    /// The place of a name within its quotes, if it has some.
    fn inside(&self, span: Span, encoding: Option<Encoding>) -> Option<Range<usize>> {
        let place = match encoding {
            None => span.start()..span.end(),
            Some(Encoding::BasicString | Encoding::LiteralString) => span.start() + 1..span.end().checked_sub(1)?,
            Some(_) => return None,
        };
        let name = self.text.get(place.clone())?;
        (encoding != Some(Encoding::BasicString) || !name.contains('\\')).then_some(place)
    }
}

impl EventReceiver for Reader<'_> {
    fn std_table_open(&mut self, _: Span, _: &mut dyn ErrorSink) {
        (self.in_header, self.header, self.key) = (true, Vec::new(), Key::default());
        self.open.clear();
    }

    fn std_table_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.in_header = false;
    }

    fn array_table_open(&mut self, span: Span, error: &mut dyn ErrorSink) {
        self.std_table_open(span, error);
    }

    fn array_table_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.in_header = false;
    }

    fn inline_table_open(&mut self, _: Span, _: &mut dyn ErrorSink) -> bool {
        let path = self.path();
        self.open.push((path, std::mem::take(&mut self.key)));
        true
    }

    fn inline_table_close(&mut self, span: Span, _: &mut dyn ErrorSink) {
        if let Some((_, key)) = self.open.pop() {
            self.key = key;
            self.end_value(span.end());
        }
    }

    fn array_open(&mut self, _: Span, _: &mut dyn ErrorSink) -> bool {
        self.key.arrays += 1;
        true
    }

    fn array_close(&mut self, span: Span, _: &mut dyn ErrorSink) {
        self.key.arrays = self.key.arrays.saturating_sub(1);
        self.end_value(span.end());
    }

    fn simple_key(&mut self, span: Span, encoding: Option<Encoding>, _: &mut dyn ErrorSink) {
        if self.key.has_value {
            self.key = Key::default();
        }
        if self.key.path.is_empty() {
            self.key.start = span.start();
        }
        let Some(place) = self.inside(span, encoding) else { return };
        let name = self.text[place.clone()].to_owned();
        if self.in_header {
            self.header.push(name);
        } else {
            self.key.path.push(name);
        }
        self.found.push(TomlWord { path: self.path(), place, is_key: true });
    }

    fn key_val_sep(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.key.has_value = true;
    }

    fn scalar(&mut self, span: Span, encoding: Option<Encoding>, _: &mut dyn ErrorSink) {
        // Without quotes it is a number, a date or a truth value.
        if let Some(place) = encoding.and_then(|encoding| self.inside(span, Some(encoding))) {
            self.found.push(TomlWord { path: self.path(), place, is_key: false });
        }
        self.end_value(span.end());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str, kind: FileKind) -> Vec<(TomlName, &str, bool)> {
        let mentions = mentions(&IndexedText::new(text.to_owned()), kind).into_iter();
        mentions.map(|mention| (mention.what, &text[mention.place], mention.declares)).collect()
    }

    #[test]
    fn names_are_found_wherever_a_graph_has_them() {
        use TomlName::{Clock, Loop, Param, Pass, Resource};
        let text = r#"
present = "color"       # color
about = "param.sun"
[params.sun]
label = "color"
[targets.color]
size = { of = "hit", scale = 0.5 }
[targets.color.display]
map = "raw"
[targets."b-2"]
clock = "sim"
size = { of = "world" }
[loops.smooth]
count = { mips = "color" }
swap = [["a", "b"],
        ["c", "d"]]
[[passes]]
name = "see"
loop = "smooth"
every = "sim"
when = "!param.sun"
dispatch = { threads = "color", mip = 1 }
bind = { out = "color", old = { target = "color@1" }, world = "world" }
push = { sun = "param.sun", size = { from = "target.b-2.size" }, t = "clock.sim.delta", n = [1.0, 2.0] }
specialization.N = "buffer.rays.count"
"#;
        let expected = [
            (Resource, "color", false),
            (Param, "sun", true),
            (Resource, "color", true),
            (Resource, "hit", false),
            (Resource, "color", true),
            (Resource, "b-2", true),
            (Clock, "sim", false),
            (Loop, "smooth", true),
            (Resource, "color", false),
            (Resource, "a", false),
            (Resource, "b", false),
            (Resource, "c", false),
            (Resource, "d", false),
            (Pass, "see", true),
            (Loop, "smooth", false),
            (Clock, "sim", false),
            (Param, "sun", false),
            (Resource, "color", false),
            (Resource, "color", false),
            (Resource, "color", false),
            (Resource, "world", false),
            (Param, "sun", false),
            (Resource, "b-2", false),
            (Clock, "sim", false),
            (Resource, "rays", false),
        ];
        assert_eq!(found(text, FileKind::Graph), expected);
        let world = "[[instances]]\nmodel = \"a\"\nturn = { param = \"sun\", default = 0.0 }\n";
        assert_eq!(found(world, FileKind::World), [(Param, "sun", false)]);
        let demo = "graph = \"a.toml\"\n[tracks.sun]\nkeys = [[0, 1]]\n[[show]]\ntarget = \"color\"\n";
        assert_eq!(found(demo, FileKind::Demo), [(Param, "sun", false), (Resource, "color", false)]);
    }

    #[test]
    fn an_entry_reaches_to_the_end_of_its_value() {
        let text = "a = 1 # b\n[t]\nx.y = [{ c = 1 }, [2]]\nz = { d = \"e\", f = { g = [1] } }\n";
        let found: Vec<(String, &str)> =
            entries(text).into_iter().map(|entry| (entry.path.join("."), &text[entry.place])).collect();
        let found: Vec<(&str, &str)> = found.iter().map(|(path, text)| (path.as_str(), *text)).collect();
        let expected = [
            ("a", "a = 1"),
            ("t.x.y.c", "c = 1"),
            ("t.x.y", "x.y = [{ c = 1 }, [2]]"),
            ("t.z.d", "d = \"e\""),
            ("t.z.f.g", "g = [1]"),
            ("t.z.f", "f = { g = [1] }"),
            ("t.z", "z = { d = \"e\", f = { g = [1] } }"),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn half_a_text_and_none_at_all_end_the_reader_nowhere() {
        let text = "[targets.color]\nsize = { of = \"h\npresent = [[\n[[passes]]\nbind = { a = \"é\", \"\\u0041\" = \"b\" }\n[";
        for end in (0..=text.len()).filter(|end| text.is_char_boundary(*end)) {
            for mention in mentions(&IndexedText::new(text[..end].to_owned()), FileKind::Graph) {
                assert!(!text[mention.place].is_empty());
            }
        }
    }
}
