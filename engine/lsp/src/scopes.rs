//! Parameters and local variables of a shader's functions, each with the part of the text in which its name means it. Read without compiling,
//! from texts that may be half typed: a scope without its end reaches to the end of the text.

use std::ops::Range;

use super::glsl::{is_name, without_comments, without_directives};

/// A parameter or a local variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Local {
    pub name: String,
    /// Its type with the qualifiers, e.g. `inout vec3`.
    pub ty: String,
    pub parameter: bool,
    /// The bytes of the name where it is declared.
    pub place: Range<usize>,
    /// The bytes in which the name means it, from behind its declarator.
    pub scope: Range<usize>,
}

impl Local {
    /// The declaration as a hover shows it.
    pub(crate) fn declaration(&self) -> String {
        format!("{} {}", self.ty, self.name)
    }
}

/// A name, a number or a mark of a text.
#[derive(Clone, Copy)]
struct Token<'t> {
    text: &'t str,
    at: usize,
}

impl Token<'_> {
    fn is_identifier(&self) -> bool {
        self.text.starts_with(|c: char| c == '_' || c.is_ascii_alphabetic())
    }

    fn end(&self) -> usize {
        self.at + self.text.len()
    }
}

/// Words that begin a statement and are no types.
const STATEMENTS: [&str; 11] =
    ["return", "else", "if", "for", "while", "do", "switch", "case", "default", "break", "discard"];

/// Words in front of a type.
const QUALIFIERS: [&str; 9] = ["const", "in", "out", "inout", "highp", "mediump", "lowp", "precise", "shared"];

/// The code without comments and directives, of the same length.
pub(super) fn code_of(text: &str) -> String {
    without_directives(&without_comments(text))
}

/// Every identifier of a code, in order, with its place. Members, which stand behind a dot, are marked.
pub(super) fn identifiers(code: &str) -> Vec<(&str, Range<usize>, bool)> {
    let mut behind_dot = false;
    let mut found = Vec::new();
    for token in tokens(code) {
        if token.is_identifier() {
            found.push((token.text, token.at..token.end(), behind_dot));
        }
        behind_dot = token.text == ".";
    }
    found
}

/// The local that an identifier at a byte means: the innermost one in whose scope, or on whose declaration, it stands.
pub(super) fn local_at<'l>(locals: &'l [Local], name: &str, at: usize) -> Option<&'l Local> {
    let means = |local: &&Local| local.name == name && (local.scope.contains(&at) || local.place.contains(&at));
    locals.iter().filter(means).max_by_key(|local| local.place.start)
}

/// The parameters and local variables of a code, in order. `code` is what [`code_of`] makes of a text.
pub(super) fn locals(code: &str) -> Vec<Local> {
    let tokens: Vec<Token<'_>> = tokens(code).collect();
    let mut reader = Reader { tokens: &tokens, end: code.len(), scopes: Vec::new(), found: Vec::new() };
    reader.read();
    reader.found
}

/// An open scope: the locals that it ends are those from `first` on.
struct Scope {
    first: usize,
    /// A statement like `for` ends its scope behind its body, which may have no braces.
    of_statement: bool,
}

struct Reader<'t> {
    tokens: &'t [Token<'t>],
    end: usize,
    scopes: Vec<Scope>,
    found: Vec<Local>,
}

impl Reader<'_> {
    fn read(&mut self) {
        let mut at = 0;
        let mut begins = true;
        while let Some(token) = self.tokens.get(at).copied() {
            let inside = !self.scopes.is_empty();
            let before = at;
            match token.text {
                // Members of a block or structure are no variables.
                "{" if !inside || at >= 2 && self.text(at - 2) == "struct" => {
                    at = self.behind_braces(at + 1);
                    continue;
                }
                "{" => {
                    self.open(false);
                    begins = true;
                }
                "}" => {
                    self.close(token.at);
                    begins = true;
                }
                ";" => {
                    self.end_statements(token.at);
                    begins = true;
                }
                "for" if inside && self.text(at + 1) == "(" => {
                    self.open(true);
                    at += 2;
                    at = self.declarators(at).unwrap_or(at);
                    at = self.behind_parentheses(at);
                    begins = true;
                    continue;
                }
                "(" if !inside && at > 0 && self.tokens[at - 1].is_identifier() => {
                    at = self.function(at);
                    continue;
                }
                _ if inside && begins => {
                    begins = matches!(token.text, ":" | "else" | "do");
                    if let Some(next) = self.declarators(at) {
                        at = next;
                        continue;
                    }
                }
                ")" | ":" => begins = true,
                _ => {}
            }
            at = before + 1;
        }
        let end = self.end;
        while !self.scopes.is_empty() {
            self.pop(end);
        }
    }

    fn text(&self, at: usize) -> &str {
        self.tokens.get(at).map_or("", |token| token.text)
    }

    fn open(&mut self, of_statement: bool) {
        self.scopes.push(Scope { first: self.found.len(), of_statement });
    }

    fn pop(&mut self, end: usize) {
        if let Some(scope) = self.scopes.pop() {
            for local in self.found.iter_mut().skip(scope.first) {
                // Those of inner scopes have ended already.
                local.scope.end = local.scope.end.min(end).max(local.scope.start);
            }
        }
    }

    /// A `}` ends the innermost braces, and statements whose body they are.
    fn close(&mut self, end: usize) {
        while self.scopes.last().is_some_and(|scope| scope.of_statement) {
            self.pop(end);
        }
        self.pop(end);
        self.end_statements(end);
    }

    /// A statement has ended: so have those whose body it is.
    fn end_statements(&mut self, end: usize) {
        while self.scopes.last().is_some_and(|scope| scope.of_statement) {
            self.pop(end);
        }
    }

    /// Reads the parameters of a function from its `(`. Gives the token to go on at: the one behind its `{`.
    fn function(&mut self, open: usize) -> usize {
        let close = self.behind_parentheses(open + 1);
        if self.text(close) != "{" {
            return close.max(open + 1);
        }
        self.open(false);
        let mut start = open + 1;
        for at in open + 1..close {
            if !matches!(self.text(at), "," | ")") {
                continue;
            }
            // Everything before the name is its type; an array has its length behind it.
            let part = &self.tokens[start..at];
            start = at + 1;
            let sized = part.iter().position(|token| token.text == "[").unwrap_or(part.len());
            let named = if sized > 0 && part[..sized].iter().filter(|token| token.is_identifier()).count() > 1 {
                sized - 1
            } else {
                part.len().saturating_sub(1)
            };
            let is_type = |token: &Token<'_>| token.is_identifier() && !QUALIFIERS.contains(&token.text);
            if let (Some(name), true) =
                (part.get(named).filter(|name| name.is_identifier()), part[..named].iter().any(is_type))
            {
                let ty: Vec<&str> = part[..named].iter().map(|token| token.text).collect();
                self.add(*name, ty.join(" "), true);
            }
        }
        close + 1
    }

    /// The token behind the `)` of the parentheses that are open at a token; the last one where there is none.
    fn behind_parentheses(&self, mut at: usize) -> usize {
        let mut depth = 1_usize;
        while let Some(token) = self.tokens.get(at) {
            at += 1;
            match token.text {
                "(" => depth += 1,
                ")" => depth -= 1,
                // A half-typed text ends with its statement.
                "{" | "}" => return at - 1,
                _ => {}
            }
            if depth == 0 {
                break;
            }
        }
        at
    }

    /// The token behind the `}` of the braces that are open at a token; the end where there is none.
    fn behind_braces(&self, mut at: usize) -> usize {
        let mut depth = 1_usize;
        while depth > 0
            && let Some(token) = self.tokens.get(at)
        {
            at += 1;
            match token.text {
                "{" => depth += 1,
                "}" => depth -= 1,
                _ => {}
            }
        }
        at
    }

    /// Reads `type a = …, b[2];` at a token. Gives the token that ends it, or `None` where something else stands.
    fn declarators(&mut self, mut at: usize) -> Option<usize> {
        let mut ty = Vec::new();
        while QUALIFIERS.contains(&self.text(at)) {
            ty.push(self.text(at).to_owned());
            at += 1;
        }
        let first = self.tokens.get(at).filter(|token| token.is_identifier() && !STATEMENTS.contains(&token.text))?;
        ty.push(first.text.to_owned());
        at += 1;
        while self.text(at) == "[" {
            at = self.behind_brackets(at + 1);
            ty.push("[]".to_owned());
        }
        let ty = ty.join(" ").replace(" []", "[]");
        let is_declarator = |text: &str| matches!(text, "=" | ";" | "," | "[" | "" | ":" | "}");
        let named = self.tokens.get(at).filter(|token| token.is_identifier())?;
        if !is_declarator(self.text(at + 1)) {
            return None;
        }
        self.add(*named, ty.clone(), false);
        at += 1;
        let mut depth = 0_usize;
        while let Some(token) = self.tokens.get(at).copied() {
            match token.text {
                "(" | "[" => depth += 1,
                ")" | "]" if depth > 0 => depth -= 1,
                ")" | ";" | "{" | "}" if depth == 0 && token.text != "{" => return Some(at),
                ";" => return Some(at),
                "," if depth == 0 => {
                    if let Some(next) = self.tokens.get(at + 1).filter(|next| next.is_identifier()).copied() {
                        self.add(next, ty.clone(), false);
                        at += 1;
                    }
                }
                _ => {}
            }
            at += 1;
        }
        Some(at)
    }

    fn behind_brackets(&self, mut at: usize) -> usize {
        while !matches!(self.text(at), "]" | ";" | "") {
            at += 1;
        }
        (at + 1).min(self.tokens.len())
    }

    fn add(&mut self, name: Token<'_>, ty: String, parameter: bool) {
        let (place, scope) = (name.at..name.end(), name.end()..self.end);
        self.found.push(Local { name: name.text.to_owned(), ty, parameter, place, scope });
    }
}

/// The names, numbers and marks of a code.
fn tokens(code: &str) -> impl Iterator<Item = Token<'_>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        at += code[at..].find(|c: char| !c.is_whitespace())?;
        let rest = &code[at..];
        let first = rest.chars().next()?;
        let length = match first {
            '"' => rest[1..].find(['"', '\n']).map_or(rest.len(), |end| end + 2),
            c if is_name(c) => rest.find(|c| !is_name(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let token = Token { text: &rest[..length], at };
        at += length;
        Some(token)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "#version 460
const vec2 GLOBAL = vec2(1.0);
float far(in float near, inout vec3 all[2], const int) {
    float a = near * 2.0, b[2], c = max(a, b[0]); // float d;
    for (int i = 0, n = 3; i < n; i++) a += float(i);
    for (uint i = 0u; i < 3u; i++) {
        vec4 inner = vec4(i);
        if (a > 1.0) { float a = inner.x; a += 1.0; }
    }
    const ivec2 size = ivec2(0);
    RxHit hit; far(a, all, 1);
    return a;
}
void main() { bool near = true; near = false; }
";

    fn found(text: &str) -> Vec<(String, String)> {
        locals(&code_of(text)).into_iter().map(|local| (local.ty, local.name)).collect()
    }

    #[test]
    fn members_are_no_locals() {
        let text = "layout(push_constant) uniform Push { float time; } push;
struct Pair { int a, b; };
void main() { struct Own { int c; }; int d = 1; }
uniform Half { float open";
        assert_eq!(found(text), [("int".to_owned(), "d".to_owned())]);
    }

    #[test]
    fn parameters_and_locals_are_found_with_their_types() {
        let expected = [
            ("in float", "near"),
            ("inout vec3", "all"),
            ("float", "a"),
            ("float", "b"),
            ("float", "c"),
            ("int", "i"),
            ("int", "n"),
            ("uint", "i"),
            ("vec4", "inner"),
            ("float", "a"),
            ("const ivec2", "size"),
            ("RxHit", "hit"),
            ("bool", "near"),
        ];
        let expected: Vec<_> = expected.iter().map(|(ty, name)| ((*ty).to_owned(), (*name).to_owned())).collect();
        assert_eq!(found(TEXT), expected);
        let parameters = locals(&code_of(TEXT)).into_iter().filter(|local| local.parameter).count();
        assert_eq!(parameters, 2);
    }

    /// The declaration that the `n`th `name` of the text means, by its line.
    fn line_of(name: &str, n: usize) -> Option<usize> {
        let code = code_of(TEXT);
        let locals = locals(&code);
        let uses: Vec<usize> = identifiers(&code)
            .into_iter()
            .filter(|(text, ..)| *text == name)
            .map(|(_, place, _)| place.start)
            .collect();
        local_at(&locals, name, uses[n]).map(|local| TEXT[..local.place.start].matches('\n').count() + 1)
    }

    #[test]
    fn a_name_means_the_innermost_declaration() {
        assert_eq!(line_of("near", 0), Some(3));
        assert_eq!(line_of("near", 1), Some(3));
        assert_eq!(line_of("near", 2), Some(14));
        assert_eq!(line_of("near", 3), Some(14));
        assert_eq!(line_of("i", 3), Some(5), "the body of a loop without braces");
        assert_eq!(line_of("i", 4), Some(6));
        assert_eq!(line_of("a", 3), Some(4), "the condition before the inner one");
        assert_eq!(line_of("a", 5), Some(8));
        assert_eq!(line_of("a", 7), Some(4), "behind the inner one");
        assert_eq!(line_of("GLOBAL", 0), None);
    }

    /// Every text between two keystrokes: nothing panics, and every range lies in the text.
    #[test]
    fn whatever_is_typed_has_ranges_in_the_text() {
        let holds = |text: &str| {
            for local in locals(&code_of(text)) {
                assert_eq!(text.get(local.place.clone()), Some(local.name.as_str()), "{text}");
                assert!(text.get(local.scope.clone()).is_some(), "{text}");
            }
        };
        for (at, letter) in TEXT.char_indices() {
            let (before, after) = TEXT.split_at(at);
            holds(before);
            holds(&[before, &after[letter.len_utf8()..]].concat());
            for typed in ["}", ")", "{", "(", ";", "\"", "/*", "for (", "float x", "−", "é"] {
                holds(&[before, typed, after].concat());
            }
        }
        assert_eq!(found("void main() { float half"), [("float".to_owned(), "half".to_owned())]);
    }
}
