//! Texts without the parts that no module follows from: comments, and white space beyond separators. Texts that are equal without these
//! give the same module, as long as the number of a line is not asked for.

use crate::lexer::{comment, line_comment};

/// The stand-in for a comment of several lines. It is in no text that compiles.
const LINES: char = '\u{1}';

/// The text without comments, indentation, trailing and repeated white space, and empty lines. The names of includes stay as they are.
pub(crate) fn stripped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    while let Some(&first) = text.as_bytes().get(at) {
        let rest = &text[at..];
        at += match (first, rest.as_bytes().get(1)) {
            (b'/', Some(b'/')) => line_comment(rest),
            (b'/', Some(b'*')) => {
                let end = comment(rest);
                // The compiler decides whether a directive goes on after such a comment.
                if rest[..end].contains('\n') {
                    out.push(LINES);
                } else {
                    space(&mut out);
                }
                end
            }
            (b'\n', _) => {
                // A line that a `\` carries on keeps it at its end: the white space before is not that of a line that ends.
                end_line(&mut out);
                1
            }
            _ if first.is_ascii_whitespace() => {
                space(&mut out);
                1
            }
            _ => {
                let end = match first {
                    b'"' => quoted(rest, '"'),
                    b'<' if is_include(&out) => quoted(rest, '>'),
                    _ => plain(rest),
                };
                out.push_str(&rest[..end]);
                end
            }
        };
    }
    end_line(&mut out);
    out
}

/// Bytes of what stays as it is, at least the first.
fn plain(rest: &str) -> usize {
    let special = |byte: u8| matches!(byte, b'/' | b'"' | b'<') || byte.is_ascii_whitespace();
    rest.bytes().skip(1).position(special).map_or(rest.len(), |at| at + 1)
}

/// Bytes of a name between marks, both included; without the second mark, up to the end of the line.
fn quoted(rest: &str, mark: char) -> usize {
    let line = rest.find('\n').unwrap_or(rest.len());
    rest[1..line].find(mark).map_or(line, |at| at + 2)
}

/// Whether the last line is an `#include` so far.
fn is_include(out: &str) -> bool {
    let line = out.rsplit('\n').next().unwrap_or(out);
    line.strip_prefix('#').is_some_and(|directive| directive.trim() == "include")
}

fn space(out: &mut String) {
    if !out.is_empty() && !out.ends_with([' ', '\n']) {
        out.push(' ');
    }
}

fn end_line(out: &mut String) {
    if out.ends_with(' ') {
        out.pop();
    }
    if !out.is_empty() && !out.ends_with('\n') {
        out.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::stripped;

    #[test]
    fn what_means_nothing_is_left_out() {
        let text =
            "// head \\\n still head\n#version 460\n\n\tint  a; // one\r\n  int/* b */c;\n#include <a//b.glsl> // c\n";
        assert_eq!(stripped(text), "#version 460\nint a;\nint c;\n#include <a//b.glsl>\n");
        assert_eq!(stripped("a // b"), stripped("a\n\n// c\n"));
        assert_eq!(stripped("a\n/* one\ntwo */ b"), stripped("a\n/* else\n\n */ b"));
        assert_eq!(stripped("/* open"), "");
        assert_eq!(stripped("// open"), "");
        assert_eq!(stripped(""), "");
    }

    #[test]
    fn what_means_something_stays() {
        for (a, b) in [
            ("a--b", "a- -b"),
            ("#define F(x) 1", "#define F (x) 1"),
            ("int a", "inta"),
            ("int/**/a", "inta"),
            ("a / b", "a // b"),
            ("#define A 1\n2", "#define A 1 2"),
            ("#define A \\\n2\n", "#define A 2\n"),
            ("#define A \\\n2\n", "#define A\n2\n"),
            ("#define A /*\n*/ 2", "#define A 2"),
            ("#define A /*\n*/ 2", "#define A\n2"),
            ("#include \"a//b.glsl\"", "#include \"a//c.glsl\""),
            ("#include <a//b.glsl>", "#include <a//c.glsl>"),
            ("#include \"a  b\"", "#include \"a b\""),
            ("a < b // c\n", "a > b // c\n"),
        ] {
            assert_ne!(stripped(a), stripped(b), "{a:?} {b:?}");
        }
    }
}
