//! Hints in graphs: the type that the shader has for a value of `push` or of a block.

use std::collections::BTreeMap;
use std::ops::Range;

use lsp_types::{InlayHint, InlayHintKind, InlayHintLabel};

use super::documents::{Document, Documents, position};
use super::glsl::{DeclarationKind, members};
use super::project_texts::{declared_in, passes, shader_of_pass};
use super::toml_place::TomlPlace;

/// The hints in a part of a graph.
pub(super) fn hints(documents: &Documents, document: &Document, part: &Range<usize>) -> Vec<InlayHint> {
    let text = &document.text;
    let mut found = Vec::new();
    for pass in passes(text).into_iter().filter(|pass| pass.start < part.end && pass.end > part.start) {
        let keys = keys(text, pass.clone());
        if keys.is_empty() {
            continue;
        }
        let types = push_types(documents, document, pass.start);
        for (name, place) in keys.into_iter().filter(|(_, place)| part.contains(&place.start)) {
            if let Some(ty) = types.get(name) {
                found.push(InlayHint {
                    position: position(text, place.end),
                    label: InlayHintLabel::String(format!(": {ty}")),
                    kind: Some(InlayHintKind::TYPE),
                    text_edits: None,
                    tooltip: None,
                    padding_left: None,
                    padding_right: None,
                    data: None,
                });
            }
        }
    }
    found
}

/// The members of the push block of the pass at a byte, with their types.
fn push_types(documents: &Documents, document: &Document, at: usize) -> BTreeMap<String, String> {
    let shader = shader_of_pass(documents, document, at);
    let with_push: Vec<_> = shader.into_iter().filter(|text| text.text.contains("push_constant")).collect();
    let blocks = declared_in(&with_push).filter(|(_, declared)| declared.kind == DeclarationKind::Push);
    let members = blocks.flat_map(|(text, known)| members(text.text.code(), known.body.clone().unwrap_or_default()));
    members.map(|member| (member.name, member.ty)).collect()
}

/// Keys in the `push` of a pass, with their places.
fn keys(text: &str, pass: Range<usize>) -> Vec<(&str, Range<usize>)> {
    let inside = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let in_comment = |at: usize| {
        let line = text[..at].rfind('\n').map_or(0, |end| end + 1);
        text[line..at].match_indices('#').any(|(mark, _)| !TomlPlace::of(text, line + mark).in_string)
    };
    let mut found = Vec::new();
    for (at, _) in text[pass.clone()].match_indices('=') {
        let end = text[..pass.start + at].trim_end_matches([' ', '\t']).len();
        let start = text[..end].trim_end_matches(inside).len();
        let place = TomlPlace::of(text, start);
        let in_push = place.table.iter().map(String::as_str).eq(["passes", "push"]);
        if start < end && in_push && place.key.is_none() && !place.in_string && !in_comment(start) {
            found.push((&text[start..end], start..end));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_push_values() {
        let text = "[[passes]]\npush = { sun = \"param.sun\", a = { from = \"x\" } }\nbind = { b = \"c\" }\n[passes.push]\n# d = 1\ne = 1\n";
        let names: Vec<&str> = keys(text, 0..text.len()).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["sun", "a", "e"]);
    }
}
