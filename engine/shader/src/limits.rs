//! What is refused before the compiler sees it, because it would take its stack, its memory or an hour: glslang walks an expression
//! by recursion, and expands macros without a limit. No shader that a person wrote comes near these numbers.

use std::collections::HashMap;
use std::ops::Range;

use crate::lexer::{self, Token};

/// Most operators and commas in one statement, macros written out: each may be a level of the expression's tree.
const MAX_OPERATORS: u64 = 100_000;
/// Most tokens that one macro may expand to.
const MAX_EXPANSION: u64 = 1 << 20;

/// Stack of the thread that compiles, in bytes: enough for an expression of `MAX_OPERATORS` levels at 2.6 KiB each. Only what is
/// used is ever backed by memory.
pub(crate) const STACK: usize = 256 << 20;

/// Sizes of the macros seen so far, in tokens when written out.
#[derive(Default)]
pub(crate) struct Limits {
    macros: HashMap<String, u64>,
}

impl Limits {
    /// Looks at one more text in the order of inclusion. On failure: where, and what is too large.
    pub fn check(&mut self, text: &str) -> Result<(), (Range<usize>, String)> {
        for line in lines(text) {
            if let Some((name, body)) = definition(&line) {
                let size = body.iter().fold(0u64, |size, token| size.saturating_add(self.size_of(token)));
                if size > MAX_EXPANSION {
                    return Err((
                        name.range(),
                        format!("macro `{}` expands to more than {MAX_EXPANSION} tokens", name.text),
                    ));
                }
                // Of several definitions the largest counts: which one holds depends on conditions.
                let known = self.macros.entry(name.text.to_owned()).or_default();
                *known = size.max(*known);
            }
        }
        self.statements(text)
    }

    fn size_of(&self, token: &Token<'_>) -> u64 {
        self.macros.get(token.text).copied().unwrap_or(1)
    }

    fn statements(&self, text: &str) -> Result<(), (Range<usize>, String)> {
        let mut statement = 0u64;
        for line in lines(text) {
            // A definition is counted where it is used; any other directive is a statement of its own.
            let directive = line[0].text == "#";
            if directive && definition(&line).is_some() {
                continue;
            }
            let mut own = 0;
            let operators = if directive { &mut own } else { &mut statement };
            for token in &line {
                if matches!(token.text, ";" | "{" | "}") {
                    *operators = 0;
                }
                let weight = self.macros.get(token.text).copied().unwrap_or(u64::from(!token.is_word()));
                *operators = operators.saturating_add(weight);
                if *operators > MAX_OPERATORS {
                    return Err((token.range(), format!("a statement has more than {MAX_OPERATORS} operators")));
                }
            }
        }
        Ok(())
    }
}

/// The tokens of each line; a line that ends with `\` goes on in the next.
fn lines(text: &str) -> impl Iterator<Item = Vec<Token<'_>>> {
    let mut tokens = lexer::tokens(text).into_iter().peekable();
    std::iter::from_fn(move || {
        let mut line = vec![tokens.next()?];
        while let Some(next) = tokens.peek() {
            let last = &line[line.len() - 1];
            if last.text != "\\" && text[last.range().end..next.at].contains('\n') {
                break;
            }
            line.extend(tokens.next());
        }
        Some(line)
    })
}

/// Name and body of a `#define`, parameters included in the body.
fn definition<'l, 't>(line: &'l [Token<'t>]) -> Option<(&'l Token<'t>, &'l [Token<'t>])> {
    match line {
        [hash, define, name, body @ ..] if hash.text == "#" && define.text == "define" => Some((name, body)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Option<String> {
        Limits::default().check(text).err().map(|(_, reason)| reason)
    }

    #[test]
    fn what_people_write_passes() {
        assert_eq!(refused("#version 460\n#define A(x) \\\n  (x + 1)\nfloat f = A(2) * A(3);\n"), None);
        let table = "1.0, -2.0, ".repeat(30_000);
        assert_eq!(refused(&format!("const float table[] = float[]({table});")), None);
        assert_eq!(refused(&"a = b + c * d;".repeat(100_000)), None);
    }

    #[test]
    fn what_takes_the_stack_is_refused() {
        assert!(refused(&format!("a = a{};", "+a".repeat(110_000))).unwrap().contains("operators"));
        assert!(refused(&format!("#if {}1{}\n#endif", "(".repeat(60_000), ")".repeat(60_000))).is_some());
    }

    #[test]
    fn macros_that_double_are_refused() {
        let defines: Vec<String> = (1..40).map(|i| format!("#define A{i} A{} + A{}\n", i - 1, i - 1)).collect();
        let text = format!("#define A0 a + a\n{}", defines.concat());
        assert!(refused(&text).unwrap().starts_with("macro `A1"));
        let used: String = text.lines().take(18).flat_map(|line| [line, "\n"]).collect();
        assert_eq!(refused(&used), None);
        assert!(refused(&format!("{used}float f = A17;")).unwrap().contains("operators"));
    }
}
