//! The functions and variables of GLSL that a compute shader has, with their descriptions: the GLSL specification 4.60, chapters 7 and 8.

use std::sync::LazyLock;

/// A function or a variable of GLSL.
#[derive(Clone, Copy)]
pub(super) struct Builtin {
    pub(super) name: &'static str,
    /// One for each set of parameters, a line each. `T` is `float` or a vector of floats, `I` an integer or a vector of them, `B` a vector of
    /// booleans; `g` before a name of a type stands for nothing, `i` or `u`.
    pub(super) declarations: &'static str,
    pub(super) meaning: &'static str,
}

impl Builtin {
    /// In Markdown.
    pub(super) fn about(&self) -> String {
        format!("```glsl\n{}\n```\n{}", self.declarations, self.meaning)
    }
}

/// All of them: in the file, the lines of declarations come before the line of their meaning, which is indented.
pub(super) static BUILTINS: LazyLock<Vec<Builtin>> = LazyLock::new(|| {
    let mut rest = include_str!("builtins.txt");
    let mut found = Vec::new();
    while let Some((declarations, after)) = rest.split_once("\n    ") {
        let (meaning, after) = after.split_once('\n').unwrap_or((after, ""));
        let head = declarations.split(['(', '\n']).next().unwrap_or(declarations);
        let name = head.rsplit(' ').next().unwrap_or(head);
        found.push(Builtin { name, declarations, meaning });
        rest = after;
    }
    found
});

/// The builtin of that name.
pub(super) fn named(name: &str) -> Option<Builtin> {
    BUILTINS.iter().find(|builtin| builtin.name == name).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_a_name_its_declarations_and_a_meaning() {
        assert_eq!(BUILTINS.len(), include_str!("builtins.txt").matches("\n    ").count());
        for Builtin { name, declarations, meaning } in BUILTINS.iter() {
            let declares = |line: &str| line.split('(').next().is_some_and(|head| head.ends_with(&format!(" {name}")));
            assert!(declarations.lines().all(declares), "{declarations}");
            assert!(meaning.ends_with('.') && !meaning.starts_with(' '), "{name}: {meaning}");
        }
        let atan = named("atan").unwrap();
        assert_eq!(atan.declarations.lines().count(), 2);
        assert!(atan.about().contains("T atan(T y_over_x)\n```\nArc tangent"), "{}", atan.about());
    }
}
