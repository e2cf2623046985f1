//! The signatures of the function whose arguments are being typed: of the shader and its includes, of the library, and of GLSL.

use std::ops::Range;

use lsp_types::{
    Documentation, MarkupContent, MarkupKind, ParameterInformation, ParameterLabel, SignatureHelp, SignatureInformation,
};
use raxel_shader::library;

use super::builtins;
use super::documents::{Document, Documents};
use super::glsl::{DeclarationKind, comment_on, is_name};
use super::project_texts::{declared_in, shader};

/// The possible meanings of a call at a byte of a shader.
pub(super) fn help(documents: &Documents, document: &Document, at: usize) -> Option<SignatureHelp> {
    if document.is_toml() {
        return None;
    }
    let (name, argument) = call(document.text.code(), at)?;
    let mut found: Vec<(String, String)> = Vec::new();
    for (text, declared) in declared_in(&shader(documents, document, &document.path)) {
        if declared.kind == DeclarationKind::Function && declared.name == name {
            let signature = text.text[declared.whole.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
            found.push((signature, comment_on(&text.text, &declared.whole)));
        }
    }
    if found.is_empty() {
        let items = library::items();
        let items = items.iter().filter(|item| item.name == name && item.declaration.contains('('));
        found.extend(
            items.map(|item| (item.declaration.clone(), format!("{}\n\n`#include <{}>`", item.about, item.file))),
        );
    }
    if found.is_empty() {
        let of_glsl = builtins::named(name).filter(|builtin| builtin.declarations.contains('('));
        found.extend(of_glsl.into_iter().flat_map(|builtin| {
            builtin.declarations.lines().map(move |line| (line.to_owned(), builtin.meaning.to_owned()))
        }));
    }
    if found.is_empty() {
        return None;
    }
    let takes = |(signature, _): &(String, String)| parameters(signature).len() > argument;
    let active = found.iter().position(takes).unwrap_or(0);
    Some(SignatureHelp {
        signatures: found.into_iter().map(|(signature, about)| information(signature, about)).collect(),
        active_signature: u32::try_from(active).ok(),
        active_parameter: u32::try_from(argument).ok(),
    })
}

fn information(label: String, about: String) -> SignatureInformation {
    let parameters = parameters(&label).into_iter().map(|part| ParameterInformation {
        label: ParameterLabel::Simple(label[part].to_owned()),
        documentation: None,
    });
    let documentation = Documentation::MarkupContent(MarkupContent { kind: MarkupKind::Markdown, value: about });
    SignatureInformation {
        parameters: Some(parameters.collect()),
        label,
        documentation: Some(documentation),
        active_parameter: None,
    }
}

/// The bytes of each parameter of a signature.
fn parameters(signature: &str) -> Vec<Range<usize>> {
    let (Some(open), Some(close)) = (signature.find('('), signature.rfind(')')) else { return Vec::new() };
    let Some(inside) = signature.get(open + 1..close).filter(|inside| !inside.trim().is_empty()) else {
        return Vec::new();
    };
    let mut start = open + 1;
    let mut found = Vec::new();
    for part in inside.split(',') {
        let lead = part.len() - part.trim_start().len();
        found.push(start + lead..start + lead + part.trim().len());
        start += part.len() + 1;
    }
    found
}

/// The function whose arguments a byte is among, and the number of the argument.
pub(super) fn call(code: &str, at: usize) -> Option<(&str, usize)> {
    let before = code.get(..at)?;
    let (mut depth, mut argument) = (0_usize, 0);
    for (place, letter) in before.char_indices().rev() {
        match letter {
            ')' | ']' => depth += 1,
            '[' => depth = depth.saturating_sub(1),
            '(' if depth > 0 => depth -= 1,
            '(' => {
                let head = before[..place].trim_end();
                let start = head.trim_end_matches(is_name).len();
                let name = &head[start..];
                return name.starts_with(|c: char| !c.is_ascii_digit()).then_some((name, argument));
            }
            ',' if depth == 0 => argument += 1,
            ';' | '{' | '}' => return None,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_call_around_a_byte_is_found() {
        let of = |text: &'static str| call(text, text.len());
        assert_eq!(of("x = mix("), Some(("mix", 0)));
        assert_eq!(of("x = mix(a, max(b, c), "), Some(("mix", 2)));
        assert_eq!(of("x = mix(a, max(b"), Some(("max", 0)));
        assert_eq!(of("f(a[g(1, 2)], "), Some(("f", 1)));
        for none in ["", "x = 1", "f(1);", "f(1)", "(1 + ", "void f() { ", ")", "3("] {
            assert_eq!(of(none), None, "{none}");
        }
        let signature = "float far(float near, out vec3 all)";
        let parts: Vec<&str> = parameters(signature).into_iter().map(|part| &signature[part]).collect();
        assert_eq!(parts, ["float near", "out vec3 all"]);
        assert!(
            parameters("void main()").is_empty() && parameters("nothing").is_empty() && parameters(")(").is_empty()
        );
    }
}
