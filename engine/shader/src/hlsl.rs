//! Mistakes in HLSL that make the compiler stop the process rather than report them.

use std::ops::Range;

use crate::lexer::{Token, tokens};
use crate::request::Request;

/// The place of such a mistake, and its description.
pub(crate) fn mistake(request: &Request, text: &str) -> Option<(Range<usize>, &'static str)> {
    let tokens = tokens(text);
    (0..tokens.len()).find_map(|at| {
        let rest = &tokens[at + 1..];
        let wrong = match (tokens[at].text, rest) {
            ("[", [second, name, ..]) => {
                (second.text == "[" && !name.is_identifier()).then_some("`[[` needs the name of an attribute")
            }
            ("numthreads", [open, ..]) if open.text == "(" => workgroup(request, &tokens, list(rest)),
            (name, [open, ..]) if name == request.entry && open.text == "(" => parameters(list(rest)),
            _ => None,
        };
        wrong.map(|wrong| (tokens[at].range(), wrong))
    })
}

/// The tokens between the `(` that comes first and its `)`.
fn list<'l, 't>(tokens: &'l [Token<'t>]) -> &'l [Token<'t>] {
    let mut depth = 0usize;
    for (at, token) in tokens.iter().enumerate() {
        match token.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return &tokens[1..at];
        }
    }
    &tokens[1..]
}

/// Three constants. A name may come from a definition, and from any file where there is an include.
fn workgroup(request: &Request, all: &[Token<'_>], sizes: &[Token<'_>]) -> Option<&'static str> {
    let known = |name: &str| {
        let includes = all.windows(2).any(|pair| (pair[0].text, pair[1].text) == ("#", "include"));
        let here = all.windows(2).any(|pair| {
            (pair[0].text == "define" && pair[1].text == name) || (pair[0].text == name && pair[1].text == "=")
        });
        includes || here || request.defines.iter().any(|(define, _)| define == name)
    };
    let constant = |token: &Token<'_>| match token.text {
        "+" | "-" | "*" | "/" | "(" | ")" => true,
        name if token.is_identifier() => known(name),
        number => {
            let digits = number.trim_end_matches(['u', 'U']);
            !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
        }
    };
    let sizes: Vec<_> = sizes.split(|token| token.text == ",").collect();
    let good = sizes.len() == 3 && sizes.iter().all(|size| !size.is_empty() && size.iter().all(constant));
    (!good).then_some("`numthreads` needs three constants")
}

/// Every parameter of the entry point has a name after its type.
fn parameters(parameters: &[Token<'_>]) -> Option<&'static str> {
    let unnamed = |parameter: &[Token<'_>]| {
        let words = parameter.iter().take_while(|token| token.text != ":");
        let words =
            words.filter(|token| token.is_identifier() && !matches!(token.text, "in" | "out" | "inout")).count();
        words == 1
    };
    parameters.split(|token| token.text == ",").any(unnamed).then_some("a parameter of the entry point has no name")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mistake_in(text: &str) -> Option<&'static str> {
        let defines = vec![("SIDE".to_owned(), "8".to_owned())];
        let request = Request { path: "shaders/a.hlsl".to_owned(), entry: "shade".to_owned(), defines };
        mistake(&request, text).map(|(_, wrong)| wrong)
    }

    #[test]
    fn what_is_right_passes() {
        let rest = "void shade(uint3 id : SV_DispatchThreadID, in uint group : SV_GroupIndex) { shade2(id[0]); }";
        for size in ["8, 8, 1", "8u,SIDE, 2 * (1 + 1)", "N, M, 1"] {
            let text =
                format!("#define N 4\nstatic const uint M = 2;\n[[vk::binding(0)]]\n[numthreads({size})]\n{rest}");
            assert_eq!(mistake_in(&text), None);
        }
        assert_eq!(mistake_in("#include \"sizes.hlsl\"\n[numthreads(X, 1, 1)] void shade() {}"), None);
    }

    #[test]
    fn what_stops_the_compiler_is_found() {
        for (text, expected) in [
            ("[numthreads(8, 8, float4)] void shade() {}", "`numthreads`"),
            ("[numthreads(8, 8x1)] void shade() {}", "`numthreads`"),
            ("[[.::push_constant]] int a;", "`[[`"),
            ("void shade(uint3: SV_DispatchThreadID) {}", "a parameter"),
        ] {
            let found = mistake_in(text);
            assert!(found.is_some_and(|found| found.starts_with(expected)), "{text}: {found:?}");
        }
    }
}
