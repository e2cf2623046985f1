//! The declarations of a shader outside of its functions, as far as they can be read without compiling it: a text that is being typed
//! seldom compiles.

use std::ops::Range;

/// The kinds of declarations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DeclarationKind {
    Function,
    Struct,
    /// A push-constant block.
    Push,
    /// A name for `bind` of a graph: an image, a sampler, a block.
    Binding,
    /// Anything else with a value: a constant, a shared variable, a macro.
    Constant,
}

/// A declaration.
#[derive(Clone, Debug)]
pub(super) struct Declaration {
    /// The name that the shader uses: of a block its instance, or its type where it has none.
    pub name: String,
    pub kind: DeclarationKind,
    /// The bytes of the name.
    pub place: Range<usize>,
    /// The bytes of the declaration, of a function without its body.
    pub whole: Range<usize>,
    /// The type of a block.
    pub block: Option<String>,
    /// The bytes between the braces of a block or a structure.
    pub body: Option<Range<usize>>,
}

impl Declaration {
    /// Whether a graph calls it so: by its instance, or by its type.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        self.name == name || self.block.as_deref() == Some(name)
    }
}

/// The declarations of a text in their order.
pub(super) fn declarations(text: &str) -> Vec<Declaration> {
    let code = without_comments(text);
    let mut found = macros(&code);
    let code = without_directives(&code);
    let mut start = 0;
    while let Some(statement) = next_statement(&code, start) {
        start = statement.end;
        found.extend(declaration(&code, statement));
    }
    found.sort_by_key(|declaration| declaration.place.start);
    found
}

/// The comment on a declaration: the lines directly above it, or else what stands behind it on its last line.
pub(super) fn comment_on(text: &str, declaration: &Range<usize>) -> String {
    let start = text[..declaration.start].rfind('\n').map_or(0, |end| end + 1);
    let above = text[..start].lines().rev().map_while(|line| line.trim().strip_prefix("//"));
    let mut lines: Vec<&str> = above.map(str::trim).collect();
    lines.reverse();
    if lines.is_empty() {
        let behind = text[declaration.end..].lines().next().and_then(|rest| rest.trim().strip_prefix("//"));
        lines.extend(behind.map(str::trim));
    }
    lines.join(" ")
}

/// A member of a block or a structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Member {
    pub name: String,
    /// With the lengths of its arrays: `vec2[4]`.
    pub ty: String,
    /// The bytes of the name.
    pub place: Range<usize>,
    /// The bytes of the declaration with its `;`.
    pub whole: Range<usize>,
}

/// The members between the braces of a block or a structure. The code has no comments.
pub(super) fn members(code: &str, body: Range<usize>) -> Vec<Member> {
    let mut found = Vec::new();
    let mut start = body.start;
    for statement in code.get(body).unwrap_or_default().split_inclusive(';') {
        let whole = start + statement.len() - statement.trim_start().len()..start + statement.trim_end().len();
        start += statement.len();
        let declaration = statement.trim_end_matches(';');
        // The qualifier of a member has commas of its own.
        let qualifier = declaration.trim_start().strip_prefix("layout").and_then(|rest| rest.split_once(')'));
        let plain = qualifier.map_or(declaration, |(_, rest)| rest);
        let mut at = start - statement.len() + declaration.len() - plain.len();
        let mut ty = None;
        for part in plain.split(',') {
            let named = without_lengths(part);
            let begin = at;
            at += part.len() + 1;
            let Some(name) = name_before(named, named.len()) else { continue };
            let ty = ty.get_or_insert_with(|| type_before(&named[..name.start]));
            let lengths = part[named.len()..].trim();
            found.push(Member {
                name: named[name.clone()].to_owned(),
                ty: format!("{ty}{lengths}"),
                place: begin + name.start..begin + name.end,
                whole: whole.clone(),
            });
        }
    }
    found
}

/// The type that a text ends with: `vec2[3]` of `const vec2[3] `. Empty where there is none.
pub(super) fn type_before(text: &str) -> String {
    let named = without_lengths(text);
    let name = name_before(named, named.len()).map_or("", |name| &named[name]);
    format!("{name}{}", text[named.len()..].trim())
}

/// A text without the `[…]` that it ends with.
fn without_lengths(text: &str) -> &str {
    let mut text = text.trim_end();
    while text.ends_with(']')
        && let Some(open) = open_of(text, ['[', ']'])
    {
        text = text[..open].trim_end();
    }
    text
}

/// The text with blanks for its comments: every byte keeps its place.
pub(super) fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("//").into_iter().chain(rest.find("/*")).min() {
        code.push_str(&rest[..at]);
        let comment = &rest[at..];
        let end = match comment.strip_prefix("/*") {
            Some(inside) => inside.find("*/").map_or(comment.len(), |end| end + 4),
            None => comment.find('\n').unwrap_or(comment.len()),
        };
        code.extend(comment[..end].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }));
        rest = &comment[end..];
    }
    code + rest
}

/// The same without lines of the preprocessor.
pub(super) fn without_directives(code: &str) -> String {
    let blank = |line: &str| -> String { line.bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }).collect() };
    let lines = code.split_inclusive('\n');
    lines.map(|line| if line.trim_start().starts_with('#') { blank(line) } else { line.to_owned() }).collect()
}

fn macros(code: &str) -> Vec<Declaration> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in code.split_inclusive('\n') {
        if let Some(rest) = line.trim_start().strip_prefix("#define ") {
            let rest = rest.trim_start();
            let name: String = rest.chars().take_while(|c| is_name(*c)).collect();
            let at = start + line.len() - rest.len();
            if !name.is_empty() {
                let whole = start..start + line.trim_end().len();
                let place = at..at + name.len();
                found.push(Declaration {
                    name,
                    kind: DeclarationKind::Constant,
                    place,
                    whole,
                    block: None,
                    body: None,
                });
            }
        }
        start += line.len();
    }
    found
}

/// The statement that begins at a byte: up to a `;`, or to the brace behind the body of a function.
fn next_statement(code: &str, start: usize) -> Option<Range<usize>> {
    let begin = start + code[start..].find(|c: char| !c.is_whitespace())?;
    let mut depth = 0_usize;
    for (at, letter) in code[begin..].char_indices() {
        match letter {
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        let end = begin + at + letter.len_utf8();
        let is_body = || {
            let head = code[begin..end].split('{').next().unwrap_or_default().trim_end();
            head.ends_with(')')
        };
        if depth == 0 && (letter == ';' || (letter == '}' && is_body())) {
            return Some(begin..end);
        }
    }
    None
}

/// The declaration of a statement.
fn declaration(code: &str, statement: Range<usize>) -> Option<Declaration> {
    let text = &code[statement.clone()];
    let at = |place: Range<usize>| statement.start + place.start..statement.start + place.end;
    let head = text.split(['{', '=', ';']).next()?;
    let opens = text.as_bytes().get(head.len()) == Some(&b'{');
    if opens && head.trim_end().ends_with(')') {
        let place = name_before(head, open_of(head.trim_end(), ['(', ')'])?)?;
        let name = head[place.clone()].to_owned();
        let whole = statement.start..statement.start + head.trim_end().len();
        return Some(Declaration {
            name,
            kind: DeclarationKind::Function,
            place: at(place),
            whole,
            block: None,
            body: None,
        });
    }
    let qualifiers: Vec<&str> = head.split(|c: char| !is_name(c)).collect();
    let has = |word: &str| qualifiers.contains(&word);
    let kind = if has("struct") {
        DeclarationKind::Struct
    } else if has("push_constant") {
        DeclarationKind::Push
    } else if has("uniform") || has("buffer") {
        DeclarationKind::Binding
    } else {
        DeclarationKind::Constant
    };
    if !opens {
        // `layout(…) in;` and a function without its body declare no value.
        let typed = head.strip_prefix("layout").and_then(|rest| rest.split_once(')')).map_or(head, |(_, rest)| rest);
        if typed.contains('(') || typed.trim().is_empty() || typed.trim() == "in" {
            return None;
        }
    }
    let type_end = head.split(if opens { '{' } else { '[' }).next().unwrap_or(head).len();
    // A layout has brackets of its own, never the name.
    let of_head = name_before(head, if opens { head.len() } else { type_end })?;
    let body = opens.then(|| head.len() + 1..text.rfind('}').filter(|end| *end > head.len()).unwrap_or(text.len()));
    let instance = body.as_ref().and_then(|body| {
        let behind = body.end + 1;
        let rest = text.get(behind..)?;
        let begin = behind + rest.find(is_name)?;
        let end = begin + text[begin..].find(|c| !is_name(c))?;
        Some(begin..end)
    });
    let place = instance.filter(|_| kind != DeclarationKind::Struct).unwrap_or_else(|| of_head.clone());
    Some(Declaration {
        name: text[place.clone()].to_owned(),
        kind,
        place: at(place),
        whole: statement.clone(),
        block: opens.then(|| head[of_head].to_owned()),
        body: body.map(at),
    })
}

/// The name that ends before a byte.
pub(super) fn name_before(text: &str, at: usize) -> Option<Range<usize>> {
    let end = text[..at].trim_end().len();
    let (start, _) = text[..end].char_indices().rev().take_while(|(_, letter)| is_name(*letter)).last()?;
    Some(start..end)
}

/// The opening bracket of the closing one that a text ends with.
pub(super) fn open_of(text: &str, [open, close]: [char; 2]) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, letter) in text.char_indices().rev() {
        if letter == close {
            depth += 1;
        } else if letter == open {
            depth -= 1;
            if depth == 0 {
                return Some(at);
            }
        }
    }
    None
}

pub(super) fn is_name(c: char) -> bool {
    c == '_' || c.is_ascii_alphanumeric()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "#version 460
#define WIDTH 8 // texels
layout(local_size_x = 8) in;
// The picture.
layout(rgba16f) uniform writeonly image2D outColor;
uniform sampler2D depth, other[2];
layout(push_constant) uniform Push { float exposure; /* ; */ vec2 size[2]; } push;
layout(std140) uniform Sky { vec4 color; };
readonly buffer List { uint count; uint items[]; } list;
struct Hit { float t; };
const vec2 AT[2] = { vec2(0.0), vec2(1.0) };
shared uint sum[8]; // of the group
float far(float near);
// Twice as far.
float far(float near) {
    for (;;) { if (near > 1.0) { return 2.0; } }
}
void main() {}
";

    #[test]
    fn what_a_shader_declares_is_found_with_its_kind() {
        use DeclarationKind::{Binding, Constant, Function, Push, Struct};
        let found = declarations(TEXT);
        let named: Vec<(&str, DeclarationKind)> = found.iter().map(|found| (found.name.as_str(), found.kind)).collect();
        let expected = [
            ("WIDTH", Constant),
            ("outColor", Binding),
            ("other", Binding),
            ("push", Push),
            ("Sky", Binding),
            ("list", Binding),
            ("Hit", Struct),
            ("AT", Constant),
            ("sum", Constant),
            ("far", Function),
            ("main", Function),
        ];
        assert_eq!(named, expected);
        assert!(found.iter().all(|found| TEXT[found.place.clone()] == found.name));
        let far = &found[9];
        assert_eq!(&TEXT[far.whole.clone()], "float far(float near)");
        assert_eq!(comment_on(TEXT, &far.whole), "Twice as far.");
        let push = &found[3];
        assert_eq!(comment_on(TEXT, &found[8].whole), "of the group");
        assert_eq!(push.block.as_deref(), Some("Push"));
        let code = without_comments(TEXT);
        let of_push = members(&code, push.body.clone().unwrap());
        assert!(of_push.iter().all(|member| TEXT[member.place.clone()] == member.name));
        let found: Vec<(&str, &str)> =
            of_push.iter().map(|member| (member.name.as_str(), member.ty.as_str())).collect();
        assert_eq!(found, [("exposure", "float"), ("size", "vec2[2]")]);
        assert_eq!(&TEXT[of_push[0].whole.clone()], "float exposure;");
        assert_eq!(type_before("const highp vec2 [2] "), "vec2[2]");
        let several = "{ layout(offset = 8, column_major) mat4[2] a, b[3] [N[1]]; highp float c }";
        let found: Vec<String> = members(several, 1..several.len() - 1)
            .into_iter()
            .map(|member| format!("{} {}", member.ty, member.name))
            .collect();
        assert_eq!(found, ["mat4[2] a", "mat4[2][3] [N[1]] b", "float c"]);
    }

    #[test]
    fn half_a_text_is_read_as_far_as_it_goes() {
        assert!(declarations("").is_empty() && declarations("layout(").is_empty() && declarations("}}} ;").is_empty());
        let typed = TEXT.replace("void main() {}", "void main() { push.ex");
        assert_eq!(declarations(&typed).len(), 10);
    }

    /// Every text between two keystrokes: nothing panics, and every range lies in the text.
    #[test]
    fn whatever_is_typed_has_ranges_in_the_text() {
        let holds = |text: &str| {
            for found in declarations(text) {
                assert_eq!(text.get(found.place.clone()), Some(found.name.as_str()), "{text}");
                assert!(text.get(found.whole.clone()).is_some(), "{text}");
                comment_on(text, &found.whole);
                if let Some(body) = found.body {
                    assert!(text.get(body.clone()).is_some(), "a body outside of {text}");
                    for member in members(&without_comments(text), body) {
                        assert_eq!(text.get(member.place), Some(member.name.as_str()), "{text}");
                        assert!(text.get(member.whole).is_some(), "{text}");
                    }
                }
            }
        };
        for (at, letter) in TEXT.char_indices() {
            let (before, after) = TEXT.split_at(at);
            holds(&[before, &after[letter.len_utf8()..]].concat());
            for typed in ["}", ")", "{", "(", ";", "\"", "/*", "//", "#define ", "−", "é"] {
                holds(&[before, typed, after].concat());
            }
        }
        holds("}\nstruct A { float x) ;");
        holds("#define e 1\n");
        assert_eq!(declarations("#define e 1\n")[0].place, 8..9);
    }
}
