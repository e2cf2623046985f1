//! What can stand at the cursor, and what a key means.

use lsp_types::{CompletionItem, CompletionItemKind, Documentation, InsertTextFormat, MarkupContent, MarkupKind};
use raxel_graph::checked::Builtin;
use raxel_shader::library;
use raxel_world::layout::Layout;
use serde_json::Value;

use super::documents::Document;
use super::names::{declared, named_passes, word};
use super::toml_place::TomlPlace;
use crate::front::FileKind;

/// Everything that can stand at a byte of a text. The editor filters by what was typed.
pub(super) fn items(document: &Document, at: usize) -> Vec<CompletionItem> {
    if !is_toml(&document.path) {
        return glsl(document);
    }
    let place = TomlPlace::of(&document.text, at);
    let schema = schema(&document.path);
    match &place.key {
        None => keys(&schema, &place.table),
        Some(key) => values(document, &schema, &place, key),
    }
}

/// Whether a path names a TOML file.
fn is_toml(path: &str) -> bool {
    std::path::Path::new(path).extension().is_some_and(|extension| extension == "toml")
}

/// What the word at a byte means, in Markdown.
pub(super) fn hover(document: &Document, at: usize) -> Option<String> {
    let found = word(&document.text, at);
    if found.is_empty() {
        return None;
    }
    if let Some(item) = library::items().into_iter().find(|item| item.name == found) {
        return Some(format!("```glsl\n{}\n```\n{}\n\n`#include <{}>`", item.declaration, item.about, item.file));
    }
    if !is_toml(&document.path) {
        return None;
    }
    if let Some(builtin) = Builtin::ALL.iter().find(|builtin| builtin.name() == found) {
        return Some(format!("`{found}`: {}", builtin.about()));
    }
    let schema = schema(&document.path);
    let place = TomlPlace::of(&document.text, at);
    let node = properties(&schema, &place.table)?.get(found)?;
    Some(describe(found, resolved(&schema, node), node))
}

/// The key's description, with its default and its range.
fn describe(key: &str, resolved: &Value, node: &Value) -> String {
    let about = node["description"].as_str().or_else(|| resolved["description"].as_str()).unwrap_or_default();
    let mut text = format!("`{key}`: {about}");
    for (name, what) in [("default", "Default"), ("minimum", "At least"), ("maximum", "At most")] {
        if let Some(value) = [node, resolved].iter().find_map(|node| node.get(name)) {
            text = format!("{text}\n\n{what}: `{value}`");
        }
    }
    text
}

/// The schema of a file of a project.
fn schema(path: &str) -> Value {
    match FileKind::of(path) {
        FileKind::Graph => raxel_graph::schema(),
        FileKind::World => raxel_world::file::schema(),
        FileKind::Demo => raxel_runtime::timeline::schema(),
    }
}

/// What a reference leads to.
fn resolved<'s>(schema: &'s Value, node: &'s Value) -> &'s Value {
    let target = node["$ref"].as_str().or_else(|| node["allOf"][0]["$ref"].as_str());
    match target.and_then(|path| schema.pointer(path.trim_start_matches('#'))) {
        Some(found) => resolved(schema, found),
        None => node,
    }
}

/// The keys of a table that can stand there: those of the first form that has any.
fn properties<'s>(schema: &'s Value, table: &[String]) -> Option<&'s serde_json::Map<String, Value>> {
    let mut node = schema;
    for name in table {
        node = forms(schema, node).into_iter().find_map(|form| {
            let element = resolved(schema, &form["items"]);
            let own = form["properties"].get(name).or_else(|| element["properties"].get(name));
            own.or_else(|| Some(&form["additionalProperties"]).filter(|value| value.is_object()))
        })?;
        node = resolved(schema, node);
    }
    forms(schema, node).into_iter().find_map(|form| {
        let element = resolved(schema, &form["items"]);
        let of_element = forms(schema, element).into_iter().find_map(|form| form["properties"].as_object());
        form["properties"].as_object().or(of_element)
    })
}

/// A node, and the forms that it may have.
fn forms<'s>(schema: &'s Value, node: &'s Value) -> Vec<&'s Value> {
    let node = resolved(schema, node);
    let either = ["anyOf", "oneOf"].into_iter().filter_map(|key| node[key].as_array()).flatten();
    std::iter::once(node).chain(either.map(|form| resolved(schema, form))).collect()
}

fn keys(schema: &Value, table: &[String]) -> Vec<CompletionItem> {
    let Some(properties) = properties(schema, table) else { return Vec::new() };
    let item = |(key, node): (&String, &Value)| {
        let about = describe(key, resolved(schema, node), node);
        CompletionItem { insert_text: Some(format!("{key} = ")), ..item(key, CompletionItemKind::PROPERTY, &about) }
    };
    properties.iter().map(item).collect()
}

fn values(document: &Document, schema: &Value, place: &TomlPlace, key: &str) -> Vec<CompletionItem> {
    let text = &document.text;
    let graph = FileKind::of(&document.path) == FileKind::Graph;
    let in_bind = place.table.last().is_some_and(|table| table == "bind");
    let mut found: Vec<CompletionItem> = match key {
        _ if graph && in_bind => resources(text),
        "from" if graph => {
            let builtins =
                Builtin::ALL.iter().map(|builtin| item(builtin.name(), CompletionItemKind::CONSTANT, builtin.about()));
            let params = declared(text, "params")
                .into_iter()
                .map(|(name, _)| (format!("param.{name}"), "a param of this graph"));
            let clocks = declared(text, "clocks").into_iter().flat_map(|(name, _)| {
                ["tick", "delta", "phase"].map(|value| (format!("clock.{name}.{value}"), "a clock of this graph"))
            });
            let named = params.chain(clocks).map(|(name, about)| item(&name, CompletionItemKind::VARIABLE, about));
            builtins.chain(named).collect()
        }
        "present" | "of" | "threads" | "indirect" if graph => resources(text),
        "before" | "after" if graph => {
            let passes = named_passes(text).into_iter();
            passes.map(|(name, _)| item(name, CompletionItemKind::FUNCTION, "a pass of this graph")).collect()
        }
        "source" if graph => Layout::ALL
            .iter()
            .map(|layout| {
                item(&format!("world.{}", layout.name()), CompletionItemKind::VALUE, "the world in this layout")
            })
            .collect(),
        "shader" if graph => files(document, "shaders"),
        "extends" if graph => files(document, "graphs"),
        "graph" => files(document, "graphs"),
        "world" => files(document, "worlds"),
        _ => Vec::new(),
    };
    if found.is_empty() {
        let node = properties(schema, &place.table).and_then(|properties| properties.get(key));
        let words =
            node.into_iter().flat_map(|node| forms(schema, node)).filter_map(|form| form["enum"].as_array()).flatten();
        found = words.filter_map(Value::as_str).map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect();
    }
    if !place.in_string {
        for item in &mut found {
            item.insert_text = Some(format!("\"{}\"", item.label));
        }
    }
    found
}

fn resources(text: &str) -> Vec<CompletionItem> {
    let of = |kind: &'static str, about: &'static str| {
        declared(text, kind).into_iter().map(move |(name, _)| item(name, CompletionItemKind::VARIABLE, about))
    };
    of("targets", "a target of this graph").chain(of("buffers", "a buffer of this graph")).collect()
}

/// Files in a folder of the project.
fn files(document: &Document, folder: &str) -> Vec<CompletionItem> {
    let Ok(entries) = std::fs::read_dir(document.project.root().join(folder)) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok().filter(|entry| entry.path().is_file())?.file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    names.sort();
    names.iter().map(|name| item(name, CompletionItemKind::FILE, folder)).collect()
}

/// The names of the library.
fn glsl(document: &Document) -> Vec<CompletionItem> {
    let mut found: Vec<CompletionItem> = Vec::new();
    for library::Item { file, name, declaration, about } in library::items() {
        if found.iter().any(|item| item.label == name) {
            continue;
        }
        let kind = if name.starts_with("Rx") { CompletionItemKind::STRUCT } else { CompletionItemKind::FUNCTION };
        let about = format!("```glsl\n{declaration}\n```\n{about}\n\n`#include <{file}>`");
        found.push(item(&name, kind, &about));
    }
    let open = document.text.lines().any(|line| line.trim_start().starts_with("#include"));
    let includes = library::FILES.iter().filter(|_| open);
    found.extend(includes.map(|(file, _)| item(file, CompletionItemKind::FILE, "a file of the shader library")));
    found
}

fn item(label: &str, kind: CompletionItemKind, about: &str) -> CompletionItem {
    let value = about.to_owned();
    CompletionItem {
        label: label.to_owned(),
        kind: Some(kind),
        documentation: Some(Documentation::MarkupContent(MarkupContent { kind: MarkupKind::Markdown, value })),
        insert_text_format: Some(InsertTextFormat::PLAIN_TEXT),
        ..CompletionItem::default()
    }
}
