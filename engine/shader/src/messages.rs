//! Turns messages of the shader compiler into diagnostics. It names a file and a line, and often a word in quotes, but no column: the word
//! is looked for on its line.

use std::collections::HashSet;
use std::ops::Range;

use raxel_diagnostics::{Code, Diagnostic, Severity, Span, codes};
use raxel_spirv::Undefined;

use crate::functions;
use crate::lexer;
use crate::sources::{Source, Sources};

/// Most errors that are reported of one shader; one mistake often makes many.
const MAX_ERRORS: usize = 8;
/// Most errors of one shader that are looked at for being consequences of each other.
const MAX_COMPARED: usize = 256;
/// Most warnings that are reported of one shader.
const MAX_WARNINGS: usize = 16;

/// Most functions that are shown where the arguments of a call fit none.
const MAX_DEFINITIONS: usize = 3;

/// One line of the compiler's output.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Message<'t> {
    severity: Severity,
    file: &'t str,
    /// From 1; `None` when the message is about the whole shader.
    line: Option<usize>,
    /// The word in quotes, if it is not empty.
    token: Option<&'t str>,
    text: String,
}

/// The diagnostics in the compiler's output, errors first by order of appearance.
pub(crate) fn diagnostics(output: &str, sources: &Sources<'_>) -> Vec<Diagnostic> {
    let mut seen = HashSet::new();
    let mut messages: Vec<Message<'_>> = output
        .lines()
        .filter(|line| seen.insert(*line))
        .filter_map(Message::parse)
        .filter(|message| !message.is_noise())
        .collect();
    // The compiler reads on behind an `#error`, without the thing that its author was missing. Its messages about the text there are no
    // mistakes of their own.
    if let Some(first) = messages.iter().position(Message::is_directive) {
        let mut at = 0..;
        messages.retain(|message| {
            at.next() <= Some(first) || message.severity == Severity::Warning || message.is_directive()
        });
    }
    // If no text in quotes is expected, the text after it is not expected either.
    let quoted: Vec<_> = messages.iter().filter(|message| message.is_quoted_text()).map(Message::place).collect();
    messages.retain(|message| !message.text.starts_with("syntax error") || !quoted.contains(&message.place()));
    drop_consequences(&mut messages, sources);
    let mut found = some(&messages, Severity::Error, MAX_ERRORS, sources);
    found.extend(some(&messages, Severity::Warning, MAX_WARNINGS, sources));
    found
}

/// Warnings about calls whose result is undefined: drivers differ there.
pub(crate) fn undefined(calls: &[Undefined], sources: &Sources<'_>) -> Vec<Diagnostic> {
    let mut seen = HashSet::new();
    let fresh = calls.iter().filter(|call| seen.insert((&call.line, &call.reason)));
    let found = fresh.take(MAX_WARNINGS).map(|call| {
        let message = format!("`{}` is undefined here: {}", call.operation, call.reason);
        let diagnostic = Diagnostic::warning(codes::shader::UNDEFINED, message);
        let Some((file, line)) = &call.line else { return diagnostic };
        let Some(text) = sources.text(file) else { return diagnostic.note(format!("at {file}:{line}")) };
        let range = place(text, *line as usize, Some(call.operation));
        let diagnostic = diagnostic.label(Span::new(file.as_str(), range), "drivers differ in what this gives");
        let diagnostic = match call.operation {
            "smoothstep" => {
                diagnostic.help("swap the edges, and take the result from 1: `1.0 - smoothstep(low, high, x)`")
            }
            "clamp" => diagnostic.help("swap the bounds"),
            _ => diagnostic,
        };
        sources.with_chain(diagnostic, file)
    });
    found.collect()
}

/// Leaves one error of each mistake. After a wrong part of a statement, the compiler reads on with a value of another type in its place,
/// and finds further errors around it. A name that it has called undeclared is a variable without a type from then on.
fn drop_consequences(messages: &mut Vec<Message<'_>>, sources: &Sources<'_>) {
    // Lines of the statements that are wrong.
    let mut wrong: Vec<(&str, Range<usize>)> = Vec::new();
    let (mut missing, mut told) = (HashSet::new(), HashSet::new());
    messages.retain(|message| {
        let Some(line) = message.line.filter(|_| message.severity == Severity::Error) else { return true };
        if wrong.len() == MAX_COMPARED || message.text.starts_with("syntax error") || message.is_directive() {
            return true;
        }
        let text: Option<&str> = sources.text(message.file).map(|text| &**text);
        let lines = text.map_or(line..line + 1, |text| statement(text, line, message.token));
        let mut follows = wrong.iter().any(|(file, lines)| *file == message.file && lines.contains(&line));
        if let Some(text) = text.filter(|_| !follows && !message.is_missing()) {
            let ranges = lexer::line_ranges(text);
            let mut tokens = ranges
                .iter()
                .take(lines.end.saturating_sub(1))
                .skip(lines.start.saturating_sub(1))
                .flat_map(|line| lexer::tokens(&text[line.clone()]));
            follows = tokens.any(|token| missing.contains(token.text));
        }
        wrong.push((message.file, lines));
        if message.is_missing() {
            missing.insert(message.token.unwrap_or_default());
            return told.insert((message.token, message.text.clone()));
        }
        !follows
    });
}

/// The lines of the statement around a token of a line, from 1.
fn statement(text: &str, line: usize, token: Option<&str>) -> Range<usize> {
    let at = place(text, line, token).start;
    let ends = |token: &lexer::Token<'_>| matches!(token.text, ";" | "{" | "}");
    let tokens = lexer::tokens(text);
    if tokens.is_empty() {
        return line..line + 1;
    }
    let behind = tokens.partition_point(|token| token.at < at);
    let first = tokens[..behind].iter().rposition(ends).map_or(0, |end| end + 1);
    let last = tokens[behind..].iter().position(ends).map_or(tokens.len(), |end| behind + end + 1);
    let [first, last] =
        [first, last - 1].map(|token| tokens.get(token).map_or(line, |token| lexer::line_of(text, token.at)));
    first.min(line)..last.max(line) + 1
}

fn some(messages: &[Message<'_>], severity: Severity, most: usize, sources: &Sources<'_>) -> Vec<Diagnostic> {
    let mut of_kind = messages.iter().filter(|message| message.severity == severity);
    let mut found: Vec<_> = of_kind.by_ref().take(most).map(|message| message.diagnostic(sources)).collect();
    let more = of_kind.count();
    if more > 0
        && let Some(last) = found.pop()
    {
        let kind = if severity == Severity::Error { "errors" } else { "warnings" };
        found.push(last.note(format!("+{more} more {kind} in this shader")));
    }
    found
}

impl<'t> Message<'t> {
    /// `file:line: error: 'token' : text`, or `file: error: text`.
    fn parse(line: &'t str) -> Option<Self> {
        let (error, warning) = (line.find(": error: "), line.find(": warning: "));
        let (severity, at, length) = match (error, warning) {
            (Some(at), warning) if warning.is_none_or(|other| at < other) => (Severity::Error, at, ": error: ".len()),
            (_, Some(at)) => (Severity::Warning, at, ": warning: ".len()),
            _ => return None,
        };
        let (place, text) = (&line[..at], line[at + length..].trim());
        let (file, line) = match place.rsplit_once(':').map(|(file, line)| (file, line.parse::<usize>())) {
            Some((file, Ok(line))) => (file, Some(line)),
            _ => (place, None),
        };
        let (token, text) = match text.strip_prefix('\'').and_then(|rest| rest.split_once("' :")) {
            Some((token, text)) => (Some(token.trim()).filter(|token| !token.is_empty()), text.trim()),
            None => (None, text),
        };
        if token.is_none() && text.is_empty() {
            return None;
        }
        Some(Self { severity, file, line, token, text: tidy(text) })
    }

    /// A message that only counts errors.
    fn is_noise(&self) -> bool {
        self.text.contains("compilation terminated") || self.text.ends_with("compilation errors.  No code generated.")
    }

    /// Whether it is an `#error`.
    fn is_directive(&self) -> bool {
        self.token == Some("#error")
    }

    /// A text in quotes, and nothing that prints it is switched on.
    fn is_quoted_text(&self) -> bool {
        self.token == Some("string literal") && self.text.starts_with("required extension not requested")
    }

    fn place(&self) -> (&'t str, Option<usize>) {
        (self.file, self.line)
    }

    fn code(&self) -> Code {
        match self.severity {
            Severity::Error if self.text.contains("Missing entry point") => codes::shader::NO_ENTRY,
            Severity::Error => codes::shader::COMPILE,
            Severity::Warning => codes::shader::WARNING,
        }
    }

    fn diagnostic(&self, sources: &Sources<'_>) -> Diagnostic {
        let message = match self.token {
            _ if self.code() == codes::shader::NO_ENTRY => "there is no `void main()`".to_owned(),
            _ if self.is_quoted_text() => "only a shader that prints has texts in quotes".to_owned(),
            _ if self.is_directive() => format!("`#error`: {}", self.author(sources).unwrap_or(&self.text)),
            Some(token) => format!("`{token}`: {}", self.text),
            None => self.text.clone(),
        };
        let mut diagnostic = Diagnostic::error(self.code(), message);
        diagnostic.severity = self.severity;
        let Some(text) = sources.text(self.file) else {
            // A `#line` may name a file that does not belong to the shader.
            return match (self.line, self.file) {
                (Some(line), file) => diagnostic.note(format!("at {file}:{line}")),
                (None, _) => diagnostic,
            };
        };
        let syntax = self.text.starts_with("syntax error");
        let token = if self.is_quoted_text() { Some("\"") } else { self.token };
        let range = self.line.map_or(0..0, |line| place(text, line, token));
        let range = if self.token.is_none() { self.unexpected(text).unwrap_or(range) } else { range };
        let before = lexer::tokens(text).into_iter().take_while(|token| token.at < range.start).last();
        let label = match self.text.as_str() {
            "undeclared identifier" => "not declared",
            _ if self.is_quoted_text() => "not switched on",
            _ if syntax && self.token.is_none() => "noticed here; the mistake may be just above",
            _ => "",
        };
        let before = before.filter(|_| syntax && self.text.contains("SEMICOLON"));
        if let Some(end) = before.as_ref().and_then(|before| self.unfinished_include(text, before.at, sources)) {
            let file = end.file.clone();
            diagnostic = diagnostic.label(end, "a `;` may be missing here").label(Span::new(self.file, range), label);
            return sources.with_chain(diagnostic, &file);
        }
        diagnostic = diagnostic.label(Span::new(self.file, range), label);
        if let Some(before) = before {
            let end = before.range().end;
            diagnostic = diagnostic.label(Span::new(self.file, end..end), "a `;` may be missing here");
        }
        if self.is_quoted_text() {
            diagnostic =
                diagnostic.help("write `#include <raxel/print.glsl>`, which has `debugPrintfEXT` and `rx_assert`");
        }
        let called = self.token.filter(|_| self.is_unknown_function());
        let defined = called.map_or_else(Vec::new, |name| definitions(name, sources));
        let is_known = !defined.is_empty() || called.is_some_and(functions::is_built_in);
        for place in defined.into_iter().take(MAX_DEFINITIONS) {
            diagnostic = diagnostic.label(place, "it takes these");
        }
        if let Some(token) = self.token.filter(|_| self.is_missing() || (called.is_some() && !is_known))
            && let Some(close) = closest(token, sources)
        {
            diagnostic = diagnostic.help(format!("did you mean `{close}`?"));
        }
        sources.with_chain(diagnostic, self.file)
    }

    /// The place of the token that the grammar did not expect: the compiler prints its kind and its line.
    fn unexpected(&self, text: &str) -> Option<Range<usize>> {
        let kind = self.text.strip_prefix("syntax error, unexpected ")?.split(',').next()?;
        let word = match kind {
            "RIGHT_BRACE" => "}".to_owned(),
            "LEFT_BRACE" => "{".to_owned(),
            "RIGHT_PAREN" => ")".to_owned(),
            keyword => keyword.to_ascii_lowercase(),
        };
        let tokens = lexer::tokens(text);
        let wrong = |pair: &&[lexer::Token<'_>]| {
            let [before, token] = pair else { return false };
            let value = before.text.starts_with(|c: char| c.is_ascii_digit()) || matches!(before.text, ")" | "]");
            let is_it = if kind == "IDENTIFIER" {
                value && token.is_identifier()
            } else {
                token.text == word && !matches!(before.text, ";" | "{" | "}")
            };
            is_it && Some(lexer::line_of(text, token.at)) == self.line
        };
        tokens.windows(2).find(wrong).map(|pair| pair[1].range())
    }

    /// The end of a file that ends within a statement, if it is included on the line of a byte of the blamed file.
    fn unfinished_include(&self, text: &str, at: usize, sources: &Sources<'_>) -> Option<Span> {
        let included = sources.included_on_line(self.file, lexer::line_of(text, at))?;
        let last = lexer::tokens(&included.text).into_iter().last()?;
        let line = lexer::line_ranges(&included.text).into_iter().nth(lexer::line_of(&included.text, last.at) - 1)?;
        let finished = matches!(last.text, ";" | "}") || included.text[line].trim_start().starts_with('#');
        let end = last.range().end;
        (!finished).then(|| Span::new(included.name.as_str(), end..end))
    }

    /// The text of an `#error`: the compiler prints its tokens with spaces between them.
    fn author<'s>(&self, sources: &'s Sources<'_>) -> Option<&'s str> {
        let text: &str = sources.text(self.file)?;
        let range = lexer::line_ranges(text).into_iter().nth(self.line?.checked_sub(1)?)?;
        let directive = text[range].trim_start().strip_prefix('#')?.trim_start().strip_prefix("error")?;
        let said = directive.split("//").next()?.trim();
        (!said.is_empty()).then_some(said)
    }

    /// A name that stands for nothing: `undeclared identifier`, or a member that a block or structure has not.
    fn is_missing(&self) -> bool {
        self.text == "undeclared identifier" || self.text.starts_with("no such field in structure")
    }

    /// No function of that name takes these arguments, or no function has that name.
    fn is_unknown_function(&self) -> bool {
        self.text.starts_with("no matching overloaded function")
    }
}

/// Where the shader's texts define functions of a name.
fn definitions(name: &str, sources: &Sources<'_>) -> Vec<Span> {
    let of_source = |source: &Source| {
        let found = functions::definitions(&source.text, name).into_iter();
        found.map(|range| Span::new(source.name.as_str(), range)).collect::<Vec<_>>()
    };
    sources.found.iter().flat_map(of_source).collect()
}

/// The name in the shader's texts that is most like `name`, if one is.
fn closest(name: &str, sources: &Sources<'_>) -> Option<String> {
    let most = name.chars().count() / 3;
    let texts = sources.found.iter().map(|source| lexer::tokens(&source.text));
    texts
        .flatten()
        .filter(|token| token.is_identifier() && token.text != name)
        .map(|token| (strsim::damerau_levenshtein(token.text, name), token.text))
        .filter(|(distance, _)| *distance <= most)
        .min()
        .map(|(_, close)| close.to_owned())
}

/// glslang's words without double spaces, and its types by their GLSL names: `' const 3-component vector of float'` is `vec3`.
fn tidy(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (index, part) in text.split('\'').enumerate() {
        let words: Vec<&str> = part.split_whitespace().collect();
        // Odd parts are inside quotes, unless the last quote is not closed.
        if index % 2 == 1 {
            let closed = text.matches('\'').count() > index;
            out.push_str(if closed { "`" } else { "'" });
            out.push_str(&if closed { glsl_type(&words) } else { words.join(" ") });
            out.push_str(if closed { "`" } else { "" });
        } else {
            if index > 0 && part.starts_with(char::is_whitespace) {
                out.push(' ');
            }
            out.push_str(&words.join(" "));
            if part.len() > 1 && part.ends_with(char::is_whitespace) && !words.is_empty() {
                out.push(' ');
            }
        }
    }
    out.trim().to_owned()
}

fn glsl_type(words: &[&str]) -> String {
    // `layout( std430 push_constant) uniform block{layout( offset=0) uniform highp float fog}`: the kind suffices, the text has the rest.
    if let Some((kind, _)) = words.iter().find_map(|word| word.split_once('{')) {
        return kind.to_owned();
    }
    let layout = words.first().is_some_and(|word| word.starts_with("layout("));
    let behind = words.iter().position(|word| layout && word.ends_with(')')).map_or(0, |end| end + 1);
    let words = &words[behind..];
    let qualifiers = [
        "const",
        "temp",
        "global",
        "in",
        "out",
        "inout",
        "highp",
        "mediump",
        "lowp",
        "uniform",
        "buffer",
        "shared",
        "readonly",
        "writeonly",
        "coherent",
        "restrict",
        "volatile",
    ];
    let start = words.iter().position(|word| !qualifiers.contains(word)).unwrap_or(0);
    let words = &words[start..];
    let prefix = |scalar: &str| match scalar {
        "float" => Some(""),
        "int" => Some("i"),
        "uint" => Some("u"),
        "bool" => Some("b"),
        "double" => Some("d"),
        _ => None,
    };
    if let [size, "vector", "of", scalar] = words
        && let (Some(size), Some(prefix)) = (size.strip_suffix("-component"), prefix(scalar))
    {
        return format!("{prefix}vec{size}");
    }
    if let [size, "matrix", "of", "float"] = words {
        return format!("mat{}", size.trim_end_matches("X1").replace('X', "x"));
    }
    words.join(" ")
}

/// The range of `token` on line `line` (from 1), or of the line's first word, or of the whole line.
pub(crate) fn place(text: &str, line: usize, token: Option<&str>) -> Range<usize> {
    let lines = lexer::line_ranges(text);
    // The compiler may blame the line after the last.
    let Some(range) = lines.get(line.saturating_sub(1)).or(lines.last()) else { return 0..0 };
    let content = &text[range.clone()];
    let trimmed = content.trim();
    let start = range.start + (content.len() - content.trim_start().len());
    let whole = start..start + trimmed.len();
    match token {
        None => {
            let word = trimmed.find(|c: char| !lexer::is_word(c)).unwrap_or(trimmed.len());
            let first = trimmed.chars().next().map_or(0, char::len_utf8);
            start..start + word.max(first)
        }
        Some(token) => {
            lexer::find_word(content, token).map_or(whole, |at| range.start + at..range.start + at + token.len())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_what_the_compiler_prints() {
        let message = Message::parse("shaders/a.comp:12: error: 'foo' : undeclared identifier ").unwrap();
        assert_eq!((message.file, message.line, message.token), ("shaders/a.comp", Some(12), Some("foo")));
        assert_eq!(message.text, "undeclared identifier");
        let message =
            Message::parse("<raxel/world.glsl>:3: error: '' :  syntax error, unexpected RIGHT_BRACE").unwrap();
        assert_eq!((message.file, message.line, message.token), ("<raxel/world.glsl>", Some(3), None));
        let message =
            Message::parse("a.comp:6: error: 'assign' :  cannot convert from ' const float' to ' temp int'").unwrap();
        assert_eq!(message.text, "cannot convert from `float` to `int`");
        assert_eq!(
            tidy("cannot  convert from ' const 3-component vector of float' to 'x'"),
            "cannot convert from `vec3` to `x`"
        );
        assert_eq!(
            tidy("of ' layout( column_major std430) uniform block{layout( offset=0) uniform highp float a}'"),
            "of `block`"
        );
        assert_eq!(tidy("of 'layout( binding=0 r32f) uniform writeonly image2D'"), "of `image2D`");
        assert_eq!(tidy("'a' 4X4 matrix of float isn't"), "`a` 4X4 matrix of float isn't");
        let message = Message::parse("a.comp: error: Linking compute stage: Missing entry point: x").unwrap();
        assert_eq!((message.line, message.code()), (None, codes::shader::NO_ENTRY));
        for nothing in ["2 errors generated.", "a.comp:3: error: ", "a.comp:3: error: '' : "] {
            assert_eq!(Message::parse(nothing), None);
        }
    }

    #[test]
    fn finds_the_token_on_its_line() {
        let text = "void main() {\n    int foobar = foo;\n\té = 1;\n}";
        let at = |line, token| &text[place(text, line, token)];
        assert_eq!(at(2, Some("foo")), "foo");
        assert_eq!(place(text, 2, Some("foo")).start, 31);
        assert_eq!(at(2, Some("assign")), "int foobar = foo;");
        assert_eq!(at(2, None), "int");
        assert_eq!(at(3, None), "é");
        assert_eq!(at(99, None), "}");
        assert_eq!(place("", 1, Some("x")), 0..0);
    }
}
