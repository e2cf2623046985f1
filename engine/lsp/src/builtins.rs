//! The functions and variables of GLSL that a compute shader has, with their descriptions: the GLSL specification 4.60, chapters 7 and 8. With them are
//! `debugPrintfEXT` and `rx_assert`, which no declaration of the shader library shows. And the words of GLSL's grammar: chapter 3.6.

use std::sync::LazyLock;

/// Keywords of statements and qualifiers.
pub(super) const KEYWORDS: &[&str] = &[
    "break",
    "buffer",
    "case",
    "coherent",
    "const",
    "continue",
    "default",
    "do",
    "else",
    "false",
    "for",
    "highp",
    "if",
    "in",
    "inout",
    "invariant",
    "layout",
    "lowp",
    "mediump",
    "out",
    "precise",
    "precision",
    "readonly",
    "restrict",
    "return",
    "shared",
    "struct",
    "switch",
    "true",
    "uniform",
    "volatile",
    "while",
    "writeonly",
];

/// Types but for those of images and samplers.
pub(super) const TYPES: &[&str] = &[
    "bool", "bvec2", "bvec3", "bvec4", "double", "dvec2", "dvec3", "dvec4", "float", "int", "ivec2", "ivec3", "ivec4",
    "mat2", "mat2x2", "mat2x3", "mat2x4", "mat3", "mat3x2", "mat3x3", "mat3x4", "mat4", "mat4x2", "mat4x3", "mat4x4",
    "uint", "uvec2", "uvec3", "uvec4", "vec2", "vec3", "vec4", "void",
];

/// Types of images and samplers of floats. Those of integers have `i` or `u` in front.
const OPAQUE_TYPES: &[&str] = &[
    "image1D",
    "image1DArray",
    "image2D",
    "image2DArray",
    "image3D",
    "imageBuffer",
    "imageCube",
    "imageCubeArray",
    "sampler1D",
    "sampler1DArray",
    "sampler2D",
    "sampler2DArray",
    "sampler3D",
    "samplerBuffer",
    "samplerCube",
    "samplerCubeArray",
];

/// Words between the brackets of `layout(…)`, without the formats of images.
pub(super) const LAYOUT_WORDS: &[&str] = &[
    "binding",
    "buffer_reference",
    "column_major",
    "constant_id",
    "local_size_x",
    "local_size_y",
    "local_size_z",
    "offset",
    "push_constant",
    "row_major",
    "scalar",
    "set",
    "std140",
    "std430",
];

/// Every type of images and samplers.
pub(super) fn opaque_types() -> impl Iterator<Item = String> {
    ["", "i", "u"].into_iter().flat_map(|kind| OPAQUE_TYPES.iter().map(move |name| format!("{kind}{name}")))
}

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
