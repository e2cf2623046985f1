//! The types of GLSL's expressions. Read without compiling: a part whose type is not known makes the whole unknown, where it matters.

use std::ops::Range;

use super::glsl::{is_name, name_before, open_of};
use super::glsl_types::{Numeric, element};

/// The meanings of the names in an expression.
pub(super) trait Names {
    /// The type of the variable that a name at a byte of the code means.
    fn variable(&self, name: &str, at: usize) -> Option<String>;

    /// The type of a call of a function, or of a constructor, with arguments of these types.
    fn call(&self, name: &str, arguments: &[Option<String>]) -> Option<String>;

    /// The type of a member of a structure or a vector.
    fn member(&self, owner: &str, name: &str) -> Option<String>;
}

/// The type of the expression that fills a part of a code. `None` where it has none, or none that is known.
pub(super) fn type_of(code: &str, part: Range<usize>, names: &impl Names) -> Option<String> {
    let mut parser = Parser { code: code.get(..part.end)?, at: part.start, depth: 0, names };
    let ty = parser.expression()?;
    parser.skip_space();
    (parser.at == part.end).then_some(ty)?
}

/// Where the operand begins that a code ends with: names, calls and elements behind dots, e.g. `a(b)[c].d`, or something in parentheses.
pub(super) fn operand(code: &str) -> Option<usize> {
    let mut rest = code;
    loop {
        rest = without_brackets(rest.trim_end())?;
        let mut start = None;
        if rest.ends_with(')') {
            let open = open_of(rest, ['(', ')'])?;
            start = Some(open);
            rest = without_brackets(rest[..open].trim_end())?;
        }
        // The word in front of parentheses may be one of a statement.
        let is_named = |name: &Range<usize>| {
            let name = &rest[name.clone()];
            !name.starts_with(|c: char| c.is_ascii_digit()) && !matches!(name, "return" | "case" | "else")
        };
        if let Some(name) = name_before(rest, rest.len()).filter(is_named) {
            start = Some(name.start);
            rest = &rest[..name.start];
        }
        let start = start?;
        match rest.trim_end().strip_suffix('.') {
            Some(before) if rest.len() <= start => rest = before,
            _ => return Some(start),
        }
    }
}

/// A code without the `[…]` that it ends with.
fn without_brackets(code: &str) -> Option<&str> {
    let mut rest = code;
    while rest.ends_with(']') {
        rest = rest[..open_of(rest, ['[', ']'])?].trim_end();
    }
    Some(rest)
}

/// The call whose function's name is a part of a code, up to its `)`.
pub(super) fn call_at(code: &str, name: &Range<usize>) -> Option<Range<usize>> {
    let rest = code.get(name.end..)?;
    let open = rest.len() - rest.trim_start().len();
    let mut depth = 0_usize;
    for (at, letter) in rest[open..].char_indices() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.checked_sub(1)?,
            ';' | '{' | '}' => return None,
            _ => {}
        }
        if depth == 0 {
            return (letter == ')').then_some(name.start..name.end + open + at + 1);
        }
    }
    None
}

/// Operators of two operands: those of a row bind closer than those of the rows above.
const OPERATORS: [&[&str]; 11] = [
    &["||"],
    &["^^"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

/// Marks that begin like an operator and are none.
const OTHER_MARKS: [&str; 12] = ["<<=", ">>=", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="];

/// Expressions within expressions that are followed, at most.
const DEEPEST: usize = 64;

/// The type of a part, if it is known.
type Known = Option<String>;

/// Reads an expression from left to right. Its methods give `None` where there is none.
struct Parser<'c, N> {
    code: &'c str,
    at: usize,
    depth: usize,
    names: &'c N,
}

impl<N: Names> Parser<'_, N> {
    fn skip_space(&mut self) {
        let rest = &self.code[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn rest(&mut self) -> &str {
        self.skip_space();
        &self.code[self.at..]
    }

    /// Goes behind a mark, if it is the next one.
    fn takes(&mut self, mark: &str) -> bool {
        let found = self.rest().starts_with(mark);
        self.at += if found { mark.len() } else { 0 };
        found
    }

    /// The next operator of two operands, and its row.
    fn operator(&mut self) -> Option<(&'static str, usize)> {
        let rest = self.rest();
        if OTHER_MARKS.iter().any(|mark| rest.starts_with(mark)) {
            return None;
        }
        let all = OPERATORS.iter().enumerate().flat_map(|(row, marks)| marks.iter().map(move |mark| (*mark, row)));
        all.filter(|(mark, _)| rest.starts_with(mark)).max_by_key(|(mark, _)| mark.len())
    }

    fn expression(&mut self) -> Option<Known> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        let condition = self.binary(0)?;
        let ty = if self.takes("?") {
            let (yes, no) = (self.expression()?, self.takes(":").then(|| self.expression())??);
            yes.or(no)
        } else {
            condition
        };
        self.depth -= 1;
        Some(ty)
    }

    fn binary(&mut self, row: usize) -> Option<Known> {
        let mut left = self.unary()?;
        while let Some((mark, of)) = self.operator().filter(|(_, of)| *of >= row) {
            self.at += mark.len();
            let right = self.binary(of + 1)?;
            left = combined(mark, left, right);
        }
        Some(left)
    }

    fn unary(&mut self) -> Option<Known> {
        let mut negates = false;
        loop {
            // The marks that take no operand on their left keep its type, but for `!`.
            let mark = ["++", "--", "+", "-", "~", "!"].into_iter().find(|mark| self.takes(mark));
            match mark {
                Some("!") => negates = true,
                Some(_) => {}
                None => break,
            }
        }
        let operand = self.postfix()?;
        Some(if negates { Some("bool".to_owned()) } else { operand })
    }

    fn postfix(&mut self) -> Option<Known> {
        let mut ty = self.primary()?;
        loop {
            if self.takes(".") {
                let name = self.name()?;
                let is_method = self.takes("(");
                ty = if is_method {
                    // GLSL has one method, `length`.
                    self.arguments()?;
                    Some("int".to_owned())
                } else {
                    ty.and_then(|owner| self.names.member(&owner, &name))
                };
            } else if self.takes("[") {
                self.expression()?;
                self.takes("]").then_some(())?;
                ty = ty.and_then(|ty| element(&ty));
            } else if !(self.takes("++") || self.takes("--")) {
                return Some(ty);
            }
        }
    }

    fn primary(&mut self) -> Option<Known> {
        if self.takes("(") {
            return self.arguments()?.pop();
        }
        if self.rest().starts_with(|c: char| c == '.' || c.is_ascii_digit()) {
            return Some(Some(self.number()));
        }
        let name = self.name()?;
        if matches!(name.as_str(), "true" | "false") {
            return Some(Some("bool".to_owned()));
        }
        let at = self.at - name.len();
        if self.takes("(") {
            let arguments = self.arguments()?;
            return Some(self.names.call(&name, &arguments));
        }
        if let Some(lengths) = self.lengths_of_constructor() {
            self.takes("(");
            self.arguments()?;
            return Some(Some(format!("{name}{lengths}")));
        }
        Some(self.names.variable(&name, at))
    }

    /// Reads the expressions behind a `(` up to its `)`.
    fn arguments(&mut self) -> Option<Vec<Known>> {
        let mut found = Vec::new();
        if self.takes(")") {
            return Some(found);
        }
        loop {
            found.push(self.expression()?);
            if self.takes(")") {
                return Some(found);
            }
            self.takes(",").then_some(())?;
        }
    }

    /// The `[…]` of a constructor of an array, such as `vec2[2](…)`. Elsewhere nothing is read.
    fn lengths_of_constructor(&mut self) -> Option<String> {
        let rest = self.rest();
        let open = rest.find('(')?;
        let lengths = rest[..open].trim_end();
        let is_lengths = lengths.starts_with('[') && lengths.ends_with(']') && !lengths.contains([';', ')', '=']);
        if !is_lengths {
            return None;
        }
        let lengths = lengths.to_owned();
        self.at += open;
        Some(lengths)
    }

    fn name(&mut self) -> Option<String> {
        let rest = self.rest();
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        let name = rest[..end].to_owned();
        self.at += end;
        name.starts_with(|c: char| c == '_' || c.is_ascii_alphabetic()).then_some(name)
    }

    /// Reads a number, and gives its type.
    fn number(&mut self) -> String {
        let rest = self.rest();
        let is_hex = rest.starts_with("0x") || rest.starts_with("0X");
        let mut end = 0;
        for (at, letter) in rest.char_indices() {
            let of_exponent = matches!(letter, '+' | '-') && !is_hex && rest[..at].ends_with(['e', 'E']);
            if !(is_name(letter) || letter == '.' || of_exponent) {
                break;
            }
            end = at + letter.len_utf8();
        }
        let text = rest[..end].to_lowercase();
        self.at += end;
        let is_float = !is_hex && text.contains(['.', 'e', 'f']);
        let suffixes: &[(&str, &str)] = if is_float {
            &[("lf", "double"), ("hf", "float16_t"), ("", "float")]
        } else {
            &[("ul", "uint64_t"), ("us", "uint16_t"), ("l", "int64_t"), ("s", "int16_t"), ("u", "uint"), ("", "int")]
        };
        let (_, ty) = suffixes.iter().find(|(suffix, _)| text.ends_with(suffix)).unwrap_or(&("", "int"));
        (*ty).to_owned()
    }
}

/// The type that an operator makes of two.
fn combined(mark: &str, left: Known, right: Known) -> Known {
    match mark {
        "||" | "^^" | "&&" | "==" | "!=" | "<" | ">" | "<=" | ">=" => return Some("bool".to_owned()),
        "<<" | ">>" => return left,
        _ => {}
    }
    let (left, right) = (Numeric::named(&left?)?, Numeric::named(&right?)?);
    let ty = if mark == "*" { left.times(right) } else { left.each_with(right) };
    ty.map(Numeric::name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variables are called by their type, and members too.
    struct ByName;

    impl Names for ByName {
        fn variable(&self, name: &str, _: usize) -> Option<String> {
            name.strip_prefix("a_").map(str::to_owned)
        }

        fn call(&self, name: &str, arguments: &[Option<String>]) -> Option<String> {
            match name {
                "first" => arguments.first()?.clone(),
                name => Numeric::named(name).map(Numeric::name),
            }
        }

        fn member(&self, _: &str, name: &str) -> Option<String> {
            Some(name.to_owned())
        }
    }

    #[test]
    fn an_expression_has_the_type_of_its_parts() {
        let of = |code: &str| type_of(code, 0..code.len(), &ByName);
        for (code, ty) in [
            ("1", "int"),
            ("0x1fu", "uint"),
            ("1e-3", "float"),
            ("2.5lf", "double"),
            (".5", "float"),
            ("-a_vec3 * 2", "vec3"),
            ("a_mat4 * vec4(a_vec3, 1.0)", "vec4"),
            ("a_vec3 + a_ivec3", "vec3"),
            ("a_int << 2u", "int"),
            ("a_vec3 == a_vec3 && !a_bool", "bool"),
            ("a_float < 1.0 ? a_vec2 : vec2(0.0)", "vec2"),
            ("(a_float, a_ivec2)", "ivec2"),
            ("a_mat3[0] [1]", "float"),
            ("a_RxHit.vec2.float", "float"),
            ("a_RxHit.length()", "int"),
            ("first(a_uvec4 & 1u, nothing)", "uvec4"),
            ("vec2[2](vec2(0.0), vec2(1.0))[1]", "vec2"),
        ] {
            assert_eq!(of(code).as_deref(), Some(ty), "{code}");
        }
        for none in [
            "",
            "nothing",
            "a_vec2 + a_vec3",
            "a_float[1]",
            "(a_float",
            "a_float)",
            "a_vec3.",
            "first(",
            "é",
            "1 +",
            "+",
            "f(a,)",
        ] {
            assert_eq!(of(none), None, "{none}");
        }
        let deep = format!("{}1{}", "(".repeat(100_000), ")".repeat(100_000));
        assert_eq!(of(&deep), None);
    }

    #[test]
    fn an_operand_is_read_from_its_end() {
        for (code, found) in [
            ("x = a", Some("a")),
            ("f(x).b [i[0]] [1] . c", Some("f(x).b [i[0]] [1] . c")),
            ("return far(a, (b))", Some("far(a, (b))")),
            ("return (a + b)", Some("(a + b)")),
            ("c * (a + b).x", Some("(a + b).x")),
            ("x = vec2[2](a, b)[1]", Some("vec2[2](a, b)[1]")),
            ("1", None),
            ("a.2", None),
            ("", None),
            (")", None),
            ("]", None),
            ("é", None),
        ] {
            assert_eq!(operand(code).map(|at| &code[at..]), found, "{code}");
        }
        let call = |code: &'static str| call_at(code, &(0..3)).map(|call| &code[call]);
        assert_eq!(call("mix (a, (b), c).x"), Some("mix (a, (b), c)"));
        for none in ["mix", "mix(a", "mix(a; b)", "mix)", "mix + (a)"] {
            assert_eq!(call(none), None, "{none}");
        }
    }
}
