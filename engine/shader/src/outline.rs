//! A text without the work of its functions: each body only returns a value of the right type. The compiler reads such a text in a fraction of
//! the time. Code that calls the functions is as right or wrong as before, and every line keeps its number.

use std::ops::Range;

use crate::lexer::{self, Token};
use crate::limits;

/// The text with a short body for each function. A function is left as it is where the preprocessor has a say in it.
pub(crate) fn outline(text: &str) -> String {
    let tokens = lexer::tokens(text);
    // Of each directive its `#` alone: no declaration goes on behind it.
    let code: Vec<&Token<'_>> =
        limits::lines(text, &tokens).flat_map(|line| if line[0].text == "#" { &line[..1] } else { line }).collect();
    let mut out = String::with_capacity(text.len());
    let (mut at, mut start, mut copied) = (0, 0, 0);
    while let Some(token) = code.get(at) {
        if token.text == "{" {
            let Some(length) = closing(&code[at..]) else { break };
            let body = &code[at..=at + length];
            let return_type = return_type(&code[start..at]).filter(|_| body.iter().all(|token| token.text != "#"));
            if let Some(range) = return_type {
                let end = body[length].range().end;
                out.push_str(&text[copied..token.at]);
                out.push('{');
                if text[range.clone()] != *"void" {
                    out.push_str(&format!(" {} rx_any; return rx_any; ", &text[range]));
                }
                out.extend(text[token.at..end].matches('\n'));
                out.push('}');
                copied = end;
            }
            at += length;
            start = at + 1;
        } else if matches!(token.text, ";" | "#" | "}") {
            start = at + 1;
        }
        at += 1;
    }
    out.push_str(&text[copied..]);
    out
}

/// The bytes of the type before `name(…)`, if that is all there is.
fn return_type(head: &[&Token<'_>]) -> Option<Range<usize>> {
    let open = head.iter().position(|token| token.text == "(")?;
    let (name, ty) = head[..open].split_last()?;
    let named = name.is_identifier() && !matches!(name.text, "if" | "for" | "while" | "switch");
    let typed = ty.iter().all(|token| token.is_word() || matches!(token.text, "[" | "]"));
    let whole = head.last().is_some_and(|last| last.text == ")") && named && typed;
    whole.then_some(())?;
    Some(ty.first()?.at..ty.last()?.range().end)
}

/// The place of the brace that closes the one at the beginning.
fn closing(code: &[&Token<'_>]) -> Option<usize> {
    let mut depth = 0_usize;
    code.iter().position(|token| {
        match token.text {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
        depth == 0
    })
}

#[cfg(test)]
mod tests {
    use super::outline;

    #[test]
    fn bodies_are_short_and_lines_stay() {
        let text = "#define F(x) { x; }\nstruct A { float b; };\nconst vec2 C[1] = { vec2(0.0) };\n\
                    highp float f(float a, out vec2 b) { // why {\n    if (a > 0.0) { return 1.0; }\n    return 2.0;\n}\n\
                    void main() {\n    f(1.0);\n}\nvec3[2] g() { return h(); } int i = 0;\n";
        let outlined = "#define F(x) { x; }\nstruct A { float b; };\nconst vec2 C[1] = { vec2(0.0) };\n\
                        highp float f(float a, out vec2 b) { highp float rx_any; return rx_any; \n\n\n}\n\
                        void main() {\n\n}\nvec3[2] g() { vec3[2] rx_any; return rx_any; } int i = 0;\n";
        assert_eq!(outline(text), outlined);
        assert_eq!(outline(outlined), outlined);
    }

    #[test]
    fn what_the_preprocessor_may_change_stays() {
        for text in [
            "float f() {\n#ifdef A\n    return 1.0;\n#endif\n    return 2.0;\n}\n",
            "float\n#ifdef A\nf() {\n#else\ng() {\n#endif\n    return 2.0;\n}\n",
            "MAKES(a) float f() { return 1.0; }",
            "f() { return 1.0; }",
            "float f() { return 1.0;",
            "buffer B { float a[]; } b; uniform C { float d; };",
        ] {
            assert_eq!(outline(text), text);
        }
    }
}
