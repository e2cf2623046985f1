//! Refuses texts that would take the compiler's stack, its memory or an hour, before the compiler sees them: glslang walks an expression by
//! recursion, expands macros without a limit, and visits the members of a struct one by one, however often a type stands in it. No
//! shader that a person wrote comes near these numbers. [`crate::worker`], if it is used, catches texts that get past these limits.

use std::collections::HashMap;
use std::ops::Range;

use crate::lexer::Token;

/// Most operators and commas in one statement, macros written out: each may be a level of the expression's tree.
const MAX_OPERATORS: u64 = 100_000;
/// Most tokens that one macro may expand to.
const MAX_EXPANSION: u64 = 1 << 20;

/// Most members that a struct may have with the structs in it written out: glslang takes half a second and 150 MB for this number, and
/// twice as much for each doubling.
const MAX_MEMBERS: u64 = 1 << 16;

/// Stack of the thread that compiles, in bytes: enough for an expression of `MAX_OPERATORS` levels at 2.6 KiB each. Only used
/// pages take memory.
pub(crate) const STACK: usize = 256 << 20;

/// The declarations of the texts so far.
#[derive(Default)]
pub(crate) struct TextLimits {
    /// Sizes of macros, in tokens when written out.
    macros: HashMap<String, u64>,
    /// Sizes of structs, in members when written out.
    structs: HashMap<String, u64>,
}

impl TextLimits {
    /// Looks at one more text, by its tokens, in the order of inclusion. On failure, returns the place and the exceeded limit.
    pub(crate) fn check(&mut self, text: &str, tokens: &[Token<'_>]) -> Result<(), (Range<usize>, String)> {
        let lines: Vec<&[Token<'_>]> = lines(text, tokens).collect();
        for line in &lines {
            if let Some((name, body)) = definition(line) {
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
        self.statements(&lines)?;
        self.members(tokens)
    }

    fn size_of(&self, token: &Token<'_>) -> u64 {
        self.macros.get(token.text).copied().unwrap_or(1)
    }

    fn statements(&self, lines: &[&[Token<'_>]]) -> Result<(), (Range<usize>, String)> {
        let mut statement = 0u64;
        for line in lines {
            // A definition is counted where it is used; any other directive is a statement of its own.
            let directive = line[0].text == "#";
            if directive && definition(line).is_some() {
                continue;
            }
            let mut own = 0;
            let operators = if directive { &mut own } else { &mut statement };
            for token in *line {
                if matches!(token.text, ";" | "{" | "}") {
                    *operators = 0;
                }
                let weight = if token.is_word() { self.macros.get(token.text).copied().unwrap_or(0) } else { 1 };
                *operators = operators.saturating_add(weight);
                if *operators > MAX_OPERATORS {
                    return Err((token.range(), format!("a statement has more than {MAX_OPERATORS} operators")));
                }
            }
        }
        Ok(())
    }
}

/// A body between braces that is being read.
struct Body<'t> {
    /// The struct or block whose body it is; `None` for code.
    name: Option<&'t Token<'t>>,
    members: u64,
    /// Members of the type of the declaration being read, and how many names it declares.
    ty: u64,
    names: u64,
}

impl<'t> Body<'t> {
    fn new(name: Option<&'t Token<'t>>, members: u64) -> Self {
        Self { name, members, ty: 1, names: 1 }
    }

    /// The declaration ends.
    fn declare(&mut self) {
        self.members = self.members.saturating_add(self.ty.saturating_mul(self.names));
        (self.ty, self.names) = (1, 1);
    }
}

impl TextLimits {
    /// Counts the members of each struct. An array counts once: its elements share their type.
    fn members(&mut self, tokens: &[Token<'_>]) -> Result<(), (Range<usize>, String)> {
        let mut open: Vec<Body<'_>> = Vec::new();
        // The name after the last `struct`, and the members that it inherits (HLSL).
        let mut head: Option<(Option<&Token<'_>>, u64)> = None;
        // Depth of `(` and `[`: a comma in them declares no name.
        let mut nested = 0usize;
        for token in tokens {
            match token.text {
                "struct" => head = Some((None, 0)),
                "{" => {
                    let (name, inherited) = head.take().unwrap_or((None, 0));
                    open.push(Body::new(name, inherited));
                    nested = 0;
                }
                "}" => {
                    nested = 0;
                    let Some(body) = open.pop() else { continue };
                    let Some(name) = body.name else { continue };
                    if body.members > MAX_MEMBERS {
                        let message = format!(
                            "struct `{}` has more than {MAX_MEMBERS} members with the structs in it written out",
                            name.text
                        );
                        return Err((name.range(), message));
                    }
                    // Of several declarations the largest counts: which one holds depends on conditions.
                    let known = self.structs.entry(name.text.to_owned()).or_default();
                    *known = body.members.max(*known);
                    // `struct A { … } a, b;` inside another.
                    if let Some(outer) = open.last_mut() {
                        outer.ty = outer.ty.max(body.members);
                    }
                }
                "(" | "[" => nested += 1,
                ")" | "]" => nested = nested.saturating_sub(1),
                ";" => {
                    head = None;
                    nested = 0;
                    if let Some(body) = open.last_mut() {
                        body.declare();
                    }
                }
                "," if nested == 0 => {
                    if let Some(body) = open.last_mut() {
                        body.names += 1;
                    }
                }
                name => {
                    let size = if token.is_identifier() { self.structs.get(name).copied() } else { None };
                    match (&mut head, open.last_mut()) {
                        (Some((first @ None, _)), _) if token.is_identifier() => *first = Some(token),
                        (Some((_, inherited)), _) => *inherited = inherited.saturating_add(size.unwrap_or(0)),
                        (None, Some(body)) => body.ty = body.ty.max(size.unwrap_or(1)),
                        (None, None) => {}
                    }
                }
            }
        }
        Ok(())
    }
}

/// The tokens of each line of a text; a line that ends with `\` goes on in the next.
pub(crate) fn lines<'l, 't>(text: &'t str, tokens: &'l [Token<'t>]) -> impl Iterator<Item = &'l [Token<'t>]> {
    tokens.chunk_by(|last, next| last.text == "\\" || !text[last.range().end..next.at].contains('\n'))
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
    use crate::lexer;

    fn refused(text: &str) -> Option<String> {
        TextLimits::default().check(text, &lexer::tokens(text)).err().map(|(_, reason)| reason)
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
    fn structs_that_double_are_refused() {
        let doubling = |levels: usize, body: &dyn Fn(usize) -> String| -> String {
            let of = |i: usize| format!("struct A{i} {{ {} }};\n", body(i - 1));
            format!("struct A0 {{ int x; }};\n{}", (1..=levels).map(of).collect::<String>())
        };
        let bodies: [&dyn Fn(usize) -> String; 4] = [
            &|i| format!("A{i} a; A{i} b;"),
            &|i| format!("A{i} a, b;"),
            &|i| format!("layout(offset = 0, align = 16) A{i} a[2], b[f(1, 2)];"),
            &|i| format!("struct B {{ A{i} a; }} a, b; /* A{i} c; */"),
        ];
        for body in bodies {
            assert_eq!(refused(&doubling(16, body)), None);
            let reason = refused(&doubling(17, body)).unwrap();
            assert!(reason.starts_with("struct `A17` has more than 65536"), "{reason}");
        }
        let inheriting = |i| format!("struct A{i} : A{0} {{ A{0} a; }};\n", i - 1);
        assert!(
            refused(&format!("struct A0 {{ int x; }};\n{}", (1..40).map(inheriting).collect::<String>())).is_some()
        );
        // An array has one type, however long; code and names declare nothing.
        let array = "struct A { int x[100000]; }; struct B { A a[100000]; };";
        assert_eq!(refused(&format!("{array}\nvoid f() {{ {} }}", "A a, b, c;".repeat(40_000))), None);
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
