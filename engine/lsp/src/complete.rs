//! What can stand at the cursor, and what a key means.

use std::collections::{BTreeMap, BTreeSet};

use lsp_types::{CompletionItem, CompletionItemKind, Documentation, InsertTextFormat, MarkupContent, MarkupKind};
use raxel_graph::checked::Builtin;
use raxel_shader::library;
use raxel_terminal::offline::FileKind;
use serde_json::Value;

use super::documents::Document;
use super::names::{declared, graphs_of, members, named_passes, owner, word};
use super::toml_place::TomlPlace;

/// Everything that can stand at a byte of a text. The editor filters by what was typed.
pub(super) fn items(document: &Document, at: usize) -> Vec<CompletionItem> {
    if !is_toml(&document.path) {
        return glsl(document, at);
    }
    let place = TomlPlace::of(&document.text, at);
    let schema = schema(&document.path);
    match &place.key {
        None => keys(&schema, &place),
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
    let (_, node) = properties(&schema, &place).into_iter().find(|(key, _)| *key == found)?;
    Some(describe(found, resolved(&schema, node), node))
}

/// The key's description, which tells its default, with its range.
fn describe(key: &str, resolved: &Value, node: &Value) -> String {
    let about = node["description"].as_str().or_else(|| resolved["description"].as_str()).unwrap_or_default();
    let mut text = format!("`{key}`: {about}");
    for (name, what) in [("minimum", "At least"), ("maximum", "At most")] {
        if let Some(value) = [node, resolved].iter().find_map(|node| node.get(name)) {
            text = format!("{text}\n\n{what}: `{value}`");
        }
    }
    text
}

/// The schema of a file of a project.
fn schema(path: &str) -> Value {
    match FileKind::of(path) {
        FileKind::Graph => raxel_graphfile::schema(),
        FileKind::World => raxel_worldfile::schema(),
        FileKind::Demo => raxel_runtime::timeline::schema(),
        FileKind::Project => raxel_runtime::manifest::schema(),
    }
}

/// What a reference leads to.
fn resolved<'s>(schema: &'s Value, node: &'s Value) -> &'s Value {
    match node["$ref"].as_str().and_then(|path| schema.pointer(path.trim_start_matches('#'))) {
        Some(found) => resolved(schema, found),
        None => node,
    }
}

/// The keys that can stand at a place, with what they are. Where a table has several forms, of each form that what is written there
/// fits.
fn properties<'s>(schema: &'s Value, place: &TomlPlace) -> Vec<(&'s str, &'s Value)> {
    let mut node = schema;
    for name in &place.table {
        let next = forms(schema, node).into_iter().find_map(|form| {
            let element = resolved(schema, &form["items"]);
            let own = form["properties"].get(name).or_else(|| element["properties"].get(name));
            own.or_else(|| Some(&form["additionalProperties"]).filter(|value| value.is_object()))
        });
        let Some(next) = next else { return Vec::new() };
        node = resolved(schema, next);
    }
    let mut found = Vec::new();
    for form in forms(schema, node) {
        let elements = forms(schema, &form["items"]);
        let tables = std::iter::once(form).chain(elements).filter_map(|form| form["properties"].as_object());
        for table in tables.filter(|table| fits(table, &place.written)) {
            found.extend(table.iter().map(|(key, value)| (key.as_str(), value)));
        }
    }
    found
}

/// Whether no text that is written contradicts the one word that a key has in this form.
fn fits(table: &serde_json::Map<String, Value>, written: &[(String, String)]) -> bool {
    let word = |key: &String| table.get(key).and_then(|value| value["const"].as_str());
    written.iter().all(|(key, text)| word(key).is_none_or(|word| word == text))
}

/// A node, and the forms that it may have.
fn forms<'s>(schema: &'s Value, node: &'s Value) -> Vec<&'s Value> {
    let node = resolved(schema, node);
    let either = ["anyOf", "oneOf"].into_iter().filter_map(|key| node[key].as_array()).flatten();
    std::iter::once(node).chain(either.map(|form| resolved(schema, form))).collect()
}

fn keys(schema: &Value, place: &TomlPlace) -> Vec<CompletionItem> {
    let item = |(key, node): (&str, &Value)| {
        let about = describe(key, resolved(schema, node), node);
        CompletionItem { insert_text: Some(format!("{key} = ")), ..item(key, CompletionItemKind::PROPERTY, &about) }
    };
    // What several forms have is offered once.
    let keys: BTreeMap<&str, &Value> = properties(schema, place).into_iter().rev().collect();
    keys.into_iter().map(item).collect()
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
        "source" if graph => raxel_rivals::LAYOUTS
            .iter()
            .map(|layout| {
                item(&format!("world.{}", layout.name()), CompletionItemKind::VALUE, "the world in this layout")
            })
            .collect(),
        "shader" if graph => {
            let mut shaders = files(document, "shaders");
            shaders.retain(|shader| !shader.label.starts_with("include/"));
            shaders
        }
        "extends" if graph => files(document, "graphs"),
        "graph" => files(document, "graphs"),
        "target" if FileKind::of(&document.path) == FileKind::Demo => shown_by(document),
        "world" => files(document, "worlds"),
        _ => Vec::new(),
    };
    if found.is_empty() {
        found = words(schema, place, key).iter().map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect();
    }
    if !place.in_string {
        for item in &mut found {
            item.insert_text = Some(format!("\"{}\"", item.label));
        }
    }
    found
}

/// The words that the value of a key can be, in any form of its table.
fn words(schema: &Value, place: &TomlPlace, key: &str) -> BTreeSet<String> {
    let nodes = properties(schema, place).into_iter().filter(|(known, _)| *known == key).map(|(_, node)| node);
    let words = |form: &Value| {
        let several = form["enum"].as_array().into_iter().flatten();
        let all: Vec<String> = several.chain(form.get("const")).filter_map(Value::as_str).map(str::to_owned).collect();
        all
    };
    nodes.flat_map(|node| forms(schema, node)).flat_map(words).collect()
}

fn resources(text: &str) -> Vec<CompletionItem> {
    let of = |kind: &'static str, about: &'static str| {
        declared(text, kind).into_iter().map(move |(name, _)| item(name, CompletionItemKind::VARIABLE, about))
    };
    of("targets", "a target of this graph").chain(of("buffers", "a buffer of this graph")).collect()
}

/// What a demo can show: the targets and buffers of the graphs that it names.
fn shown_by(document: &Document) -> Vec<CompletionItem> {
    let mut names = BTreeMap::new();
    for text in graphs_of(document) {
        for (kind, about) in [("targets", "a target of the demo's graph"), ("buffers", "a buffer of the demo's graph")]
        {
            names.extend(declared(&text, kind).into_iter().map(|(name, _)| (name.to_owned(), about)));
        }
    }
    names.iter().map(|(name, about)| item(name, CompletionItemKind::VARIABLE, about)).collect()
}

/// Files in a folder of the project and in those that it holds, relative to it.
fn files(document: &Document, folder: &str) -> Vec<CompletionItem> {
    /// Folders within folders, at most: a link may lead back.
    const DEEPEST: usize = 4;
    let mut names = Vec::new();
    let mut folders = vec![(document.project.root().join(folder), String::new(), 0)];
    while let Some((path, before, depth)) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(path) else { continue };
        for entry in entries.flatten() {
            let Some(name) = entry.file_name().into_string().ok().filter(|name| !name.starts_with('.')) else {
                continue;
            };
            let (path, name) = (entry.path(), format!("{before}{name}"));
            if path.is_file() {
                names.push(name);
            } else if depth < DEEPEST {
                folders.push((path, format!("{name}/"), depth + 1));
            }
        }
    }
    names.sort();
    names.iter().map(|name| item(name, CompletionItemKind::FILE, folder)).collect()
}

/// The names of the library; after `push.` those of the members of that block, after `#include` files.
fn glsl(document: &Document, at: usize) -> Vec<CompletionItem> {
    if let Some(instance) = owner(&document.text, at) {
        let member = |(name, declaration): (String, String)| {
            item(&name, CompletionItemKind::FIELD, &format!("```glsl\n{declaration}\n```"))
        };
        return members(&document.text, instance).into_iter().map(member).collect();
    }
    let line = document.text[..at].rsplit('\n').next().unwrap_or_default();
    if line.trim_start().starts_with("#include") {
        return includes(document);
    }
    let mut found: Vec<CompletionItem> = Vec::new();
    for library::Item { file, name, declaration, about } in library::items() {
        if found.iter().any(|item| item.label == name) {
            continue;
        }
        let kind = if name.starts_with("Rx") { CompletionItemKind::STRUCT } else { CompletionItemKind::FUNCTION };
        let about = format!("```glsl\n{declaration}\n```\n{about}\n\n`#include <{file}>`");
        found.push(item(&name, kind, &about));
    }
    found
}

/// The files that a shader can include: those of the library and those of the project.
fn includes(document: &Document) -> Vec<CompletionItem> {
    let mut found: Vec<CompletionItem> = library::FILES
        .iter()
        .filter(|(file, _)| !library::is_internal(file))
        .map(|(file, _)| item(file, CompletionItemKind::FILE, "a file of the shader library"))
        .collect();
    for file in files(document, "shaders") {
        let name = file.label.strip_prefix("include/").unwrap_or(&file.label);
        let is_glsl = std::path::Path::new(name).extension().is_some_and(|extension| extension == "glsl");
        if is_glsl && library::text(name).is_none() {
            found.push(item(name, CompletionItemKind::FILE, "shaders"));
        }
    }
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
