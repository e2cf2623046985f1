//! Hover: the meaning of the word under the cursor.

use std::sync::Arc;

use raxel_diagnostics::MemoryFiles;
use raxel_graph::checked::Builtin;
use raxel_graph::{Catalog, SourceLayout};
use raxel_runtime::sources::SourceCatalog;
use raxel_shader::format::{Format, ScalarKind};
use raxel_shader::library;
use serde_json::Value;

use super::complete::{describe, held_inputs, properties, resolved, schema, words};
use super::documents::{Document, Documents};
use super::glsl::{DeclarationKind, comment_on};
use super::names::{bare, declaration, identifier, local_under, named_at};
use super::project_texts::{ProjectText, bound_by, declared_in, graphs, shader, shader_of_pass, worlds};
use super::scopes::Local;
use super::toml_place::TomlPlace;
use super::{builtins, member_access};

/// The meaning of the word at a byte, in Markdown.
pub(super) fn hover(documents: &Documents, document: &Document, at: usize) -> Option<String> {
    let toml = document.is_toml();
    let found = if toml { named_at(&document.text, at) } else { identifier(&document.text, at) };
    if found.is_empty() {
        return None;
    }
    if let Some((local, about)) = local(document, at) {
        let kind = if local.parameter { "A parameter." } else { "A local variable." };
        return Some(format!("```glsl\n{}\n```\n{kind} {about}", local.declaration()));
    }
    let texts = if toml { Vec::new() } else { shader(documents, document, &document.path) };
    if !toml {
        if let Some(member) = member_access::under(document, &texts, at) {
            return Some(member.about);
        }
        // No name behind a dot is one of a function or a variable.
        if member_access::is_behind_dot(&document.text, at) {
            return None;
        }
    }
    if let Some(item) = library::items().into_iter().find(|item| item.name == found) {
        return Some(format!("```glsl\n{}\n```\n{}\n\n`#include <{}>`", item.declaration, item.about, item.file));
    }
    if !toml {
        let Some(builtin) = builtins::named(found) else {
            return hover_declared(documents, document, &texts, found);
        };
        let ty = member_access::call_under(document, &texts, at);
        let of_call = ty.map_or_else(String::new, |ty| format!("\n\nThe type of this call: `{ty}`"));
        return Some(format!("{}{of_call}", builtin.about()));
    }
    if let Some(builtin) = Builtin::ALL.iter().find(|builtin| builtin.name() == found) {
        return Some(format!("`{found}`: {}", builtin.about()));
    }
    let schema = schema(&document.path);
    let place = TomlPlace::of(&document.text, at);
    if let Some(about) = hover_value(&schema, &place, found) {
        return Some(about);
    }
    if let Some((_, node)) = properties(&schema, &place).into_iter().find(|(key, _)| *key == found) {
        return Some(describe(found, resolved(&schema, node), node));
    }
    hover_table(documents, document, bare(found))
        .or_else(|| hover_declared(documents, document, &shader_of_pass(documents, document, at), found))
}

/// What a word means as the value of a key. Where nothing says more of the word, the description of its key does.
fn hover_value(schema: &Value, place: &TomlPlace, found: &str) -> Option<String> {
    let key = place.key.as_deref().filter(|_| place.in_string)?;
    let (_, node) = properties(schema, place).into_iter().find(|(known, _)| *known == key)?;
    if key == "format"
        && let Some(format) = Format::from_name(found)
    {
        let kind = match format.scalar() {
            ScalarKind::Float => "floats",
            ScalarKind::Int => "integers",
            ScalarKind::Uint => "unsigned integers",
        };
        let (channels, bytes) = (format.channels(), format.bytes());
        return Some(format!("`{found}`: channels: {channels}, read as {kind}; bytes of a texel: {bytes}"));
    }
    if matches!(key, "source" | "copy")
        && let Some(source) = SourceCatalog::new(Arc::new(MemoryFiles::default())).source(found)
    {
        return Some(about_source(&source));
    }
    let of_key = || describe(key, resolved(schema, node), node);
    if held_inputs(place, key).is_some_and(|names| names.contains(&found)) {
        return Some(of_key());
    }
    let meaning = words(schema, place, key).remove(found)?;
    Some(if meaning.is_empty() { of_key() } else { format!("`{found}`: {meaning}") })
}

/// The description of a source that the session supplies.
fn about_source(source: &SourceLayout) -> String {
    let mut said = format!("`{}`: supplied by the session.", source.name);
    if let Some(format) = source.image {
        said = format!("{said} A target with this source has the format `{}`.", format.name());
    }
    if let Some(bytes) = source.collected {
        said = format!("{said} Passes fill it, at most {bytes} bytes, and raxel takes the contents after the frame.");
    }
    said
}

/// The local or parameter that a byte of a shader means, with the comment on its line.
fn local(document: &Document, at: usize) -> Option<(Local, String)> {
    if document.is_toml() {
        return None;
    }
    let local = local_under(&document.text, at)?.clone();
    let about = comment_on(&document.text, &local.place);
    Some((local, about))
}

/// The declaration of a shader's name, with the comment on it, and the resources that graphs bind to it.
fn hover_declared(documents: &Documents, document: &Document, texts: &[ProjectText], name: &str) -> Option<String> {
    let (text, declared) = declared_in(texts).find(|(_, declared)| declared.name == name)?;
    let mut said = format!("```glsl\n{}\n```\n", &text.text[declared.whole.clone()]);
    for more in [comment_on(&text.text, &declared.whole), format!("`{}`", text.path)] {
        if !more.is_empty() {
            said = format!("{said}\n{more}\n");
        }
    }
    if declared.kind == DeclarationKind::Binding {
        for bound in bound_by(documents, document, name) {
            said = format!("{said}\n{bound}\n");
        }
    }
    Some(said)
}

/// The table that declares a name, in the nearest file that does.
fn hover_table(documents: &Documents, document: &Document, name: &str) -> Option<String> {
    let mut texts = graphs(documents, document).into_iter().chain(worlds(documents, document));
    texts.find_map(|text| {
        let place = declaration(&text.text, name)?;
        let start = text.text[..place.start].rfind('\n').map_or(0, |end| end + 1);
        let lines = text.text[start..].lines().enumerate();
        let is_table = text.text[start..].starts_with('[');
        let own = lines
            .take_while(|(line, text)| *line == 0 || (is_table && !text.starts_with('[') && !text.trim().is_empty()));
        let own: Vec<&str> = own.map(|(_, line)| line).collect();
        Some(format!("```toml\n{}\n```\n`{}`", own.join("\n"), text.path))
    })
}
