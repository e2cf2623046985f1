//! Completion: the words that fit at the cursor. `hover.rs` has the meaning of the word under it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use lsp_types::{CompletionItem, CompletionItemKind, Documentation, InsertTextFormat, MarkupContent, MarkupKind};
use raxel_diagnostics::MemoryFiles;
use raxel_graph::checked::Builtin;
use raxel_graph::supply::MICROPHONE;
use raxel_graph::{Catalog, SourceLayout};
use raxel_media::has_texels;
use raxel_runtime::inputs;
use raxel_runtime::sources::SourceCatalog;
use raxel_shader::format::Format;
use raxel_shader::library;
use raxel_terminal::offline::FileKind;
use serde_json::Value;

use super::documents::{Document, Documents};
use super::glsl::{Declaration, DeclarationKind, comment_on};
use super::names::{declared, keys_of, named_passes};
use super::project_texts::{
    ProjectText, declared_in, every, graphs, shader, shader_of_pass, shaders_of_graphs, worlds,
};
use super::toml_place::{TomlPlace, header_at};
use super::{builtins, member_access, signature, symbols};

/// All words that fit at a byte of a text. The editor filters them by the letters that the user has typed.
pub(super) fn items(documents: &Documents, document: &Document, at: usize) -> Vec<CompletionItem> {
    if !document.is_toml() {
        return glsl(documents, document, at);
    }
    let schema = schema(&document.path);
    if let Some(table) = header_at(&document.text, at) {
        return headers(documents, document, &schema, table);
    }
    let place = TomlPlace::of(&document.text, at);
    let within = Within { documents, document, at };
    match &place.key {
        None => given_names(&within, &place).unwrap_or_else(|| keys(&schema, &place)),
        Some(key) => values(&within, &schema, &place, key),
    }
}

/// A place in a document among the others.
struct Within<'a> {
    documents: &'a Documents,
    document: &'a Document,
    at: usize,
}

/// The block that a place is directly in: `push`, or the name of one of `uniforms` and `[blocks.*]`.
fn block_of(place: &TomlPlace) -> Option<&str> {
    match place.table.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["passes", "push"] => Some("push"),
        ["passes", "uniforms", block] | ["blocks", block] => Some(block),
        _ => None,
    }
}

/// The names of a shader that a pass gives something to, where such a name is typed: bindings in `bind`, members in a block.
fn given_names(within: &Within<'_>, place: &TomlPlace) -> Option<Vec<CompletionItem>> {
    let Within { documents, document, at } = *within;
    if FileKind::of(&document.path) != FileKind::Graph {
        return None;
    }
    let named = |label: &str, kind, about: &str| CompletionItem {
        insert_text: Some(format!("{label} = ")),
        ..item(label, kind, about)
    };
    let mut found: BTreeMap<String, CompletionItem> = BTreeMap::new();
    if place.table == ["passes", "bind"] {
        let shader = shader_of_pass(documents, document, at);
        for (text, declared) in declared_in(&shader).filter(|(_, found)| found.kind == DeclarationKind::Binding) {
            let about = format!("```glsl\n{}\n```\n{}", &text.text[declared.whole.clone()], text.path);
            found.insert(declared.name.clone(), named(&declared.name, CompletionItemKind::FIELD, &about));
        }
    } else {
        let block = block_of(place)?;
        let shared = place.table[0] == "blocks";
        let texts =
            if shared { shaders_of_graphs(documents, document) } else { shader_of_pass(documents, document, at) };
        let is_it = |declared: &Declaration| match declared.kind {
            DeclarationKind::Push => block == "push" || shared && declared.is_called(block),
            DeclarationKind::Binding => declared.is_called(block),
            _ => false,
        };
        for (text, declared) in declared_in(&texts).filter(|(_, declared)| is_it(declared)) {
            for member in member_access::members_of(text, declared) {
                let item = named(&member.name, CompletionItemKind::FIELD, &member.about);
                found.insert(member.name, item);
            }
        }
    }
    Some(found.into_values().collect())
}

/// The tables whose header can go on behind these names.
fn headers(documents: &Documents, document: &Document, schema: &Value, table: Vec<String>) -> Vec<CompletionItem> {
    let graphs = graphs(documents, document);
    let names = match table.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        // A track drives params of the graphs. A graph that extends them changes any of their tables.
        ["tracks"] => inherited(&graphs, &["params"]),
        [kind @ ("params" | "clocks" | "targets" | "buffers" | "blocks" | "loops")] => inherited(&graphs, &[kind]),
        _ => Vec::new(),
    };
    if !names.is_empty() {
        return names;
    }
    let is_table = |node: &Value| {
        let is = |node: &Value| node["type"] == "object" || node["properties"].is_object();
        forms(schema, node).into_iter().any(|form| is(form) || is(resolved(schema, &form["items"])))
    };
    let place = TomlPlace { table, ..TomlPlace::default() };
    let tables: BTreeMap<&str, &Value> =
        properties(schema, &place).into_iter().filter(|(_, node)| is_table(node)).collect();
    let described = |(key, node): (&str, &Value)| {
        item(key, CompletionItemKind::STRUCT, &describe(key, resolved(schema, node), node))
    };
    tables.into_iter().map(described).collect()
}

/// Names of tables that graphs declare, the nearest graph first, each once.
fn inherited(graphs: &[ProjectText], kinds: &[&str]) -> Vec<CompletionItem> {
    let mut found: Vec<CompletionItem> = Vec::new();
    for (kind, graph) in kinds.iter().flat_map(|kind| graphs.iter().map(move |graph| (kind, graph))) {
        for (name, _) in declared(&graph.text, kind) {
            if found.iter().all(|known| known.label != name) {
                let about = format!("a {} of `{}`", kind.trim_end_matches('s'), graph.path);
                found.push(item(name, CompletionItemKind::VARIABLE, &about));
            }
        }
    }
    found
}

/// The names that an input of a demo can hold.
pub(super) fn held_inputs(place: &TomlPlace, key: &str) -> Option<Vec<&'static str>> {
    match key {
        _ if place.table != ["inputs"] => None,
        "keys" => Some(inputs::Key::names().collect()),
        "buttons" => Some(inputs::BUTTONS.to_vec()),
        "gamepad_buttons" => Some(inputs::GAMEPAD_BUTTONS.to_vec()),
        _ => None,
    }
}

/// The key's description, which tells its default, with its range.
pub(super) fn describe(key: &str, resolved: &Value, node: &Value) -> String {
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
pub(super) fn schema(path: &str) -> Value {
    match FileKind::of(path) {
        FileKind::Graph => raxel_graphfile::schema(),
        FileKind::World => raxel_worldfile::schema(),
        FileKind::Demo => raxel_runtime::timeline::schema(),
        FileKind::Project => raxel_runtime::manifest::schema(),
    }
}

/// The definition that a reference leads to, or the node itself.
pub(super) fn resolved<'s>(schema: &'s Value, node: &'s Value) -> &'s Value {
    match node["$ref"].as_str().and_then(|path| schema.pointer(path.trim_start_matches('#'))) {
        Some(found) => resolved(schema, found),
        None => node,
    }
}

/// The keys that fit at a place, with their schemas. If a table has several forms, these are the keys of each form that agrees with the keys
/// already written there.
pub(super) fn properties<'s>(schema: &'s Value, place: &TomlPlace) -> Vec<(&'s str, &'s Value)> {
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

/// Whether the written keys agree with this form: a key that has one word in it has that word.
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
    // A key of several forms appears once.
    let keys: BTreeMap<&str, &Value> = properties(schema, place).into_iter().rev().collect();
    keys.into_iter().map(item).collect()
}

fn values(within: &Within<'_>, schema: &Value, place: &TomlPlace, key: &str) -> Vec<CompletionItem> {
    let Within { documents, document, .. } = *within;
    let kind = FileKind::of(&document.path);
    let graph = kind == FileKind::Graph;
    let in_bind = place.table.last().is_some_and(|table| table == "bind");
    let resources = || inherited(&graphs(documents, document), &["targets", "buffers"]);
    let mut found: Vec<CompletionItem> = match key {
        _ if graph && in_bind => resources(),
        // The short form of a member is the text of its `from`.
        _ if graph && block_of(place).is_some() => sources(&graphs(documents, document)),
        "from" if graph => sources(&graphs(documents, document)),
        "present" | "of" | "threads" | "indirect" if graph => resources(),
        "before" | "after" if graph => {
            let graphs = graphs(documents, document);
            let passes: BTreeSet<&str> =
                graphs.iter().flat_map(|graph| named_passes(&graph.text)).map(|(name, _)| name).collect();
            passes.into_iter().map(|name| item(name, CompletionItemKind::FUNCTION, "a pass of this graph")).collect()
        }
        "source" | "copy" if graph => supplied(documents, document, Supplied::of(place, key)),
        "shader" if graph => {
            let mut shaders = files(document, "shaders");
            shaders.retain(|shader| !shader.label.starts_with("include/"));
            shaders
        }
        "extends" if graph => files(document, "graphs"),
        "graph" => files(document, "graphs"),
        "target" if kind == FileKind::Demo => resources(),
        "keys" | "buttons" | "gamepad_buttons" if kind == FileKind::Demo => {
            let names = held_inputs(place, key).into_iter().flatten();
            names.map(|name| item(name, CompletionItemKind::ENUM_MEMBER, "")).collect()
        }
        "material" | "model" if !graph => of_world(&worlds(documents, document), key),
        "world" | "demo" => {
            let mut worlds = files(document, "worlds");
            worlds.retain(|file| file.label.ends_with(".demo.toml") == (key == "demo"));
            worlds
        }
        _ => Vec::new(),
    };
    if found.is_empty() {
        let words = words(schema, place, key).into_iter();
        found = words.map(|(word, meaning)| item(&word, CompletionItemKind::ENUM_MEMBER, &meaning)).collect();
    }
    if !place.in_string {
        for item in &mut found {
            item.insert_text = Some(format!("\"{}\"", item.label));
        }
    }
    found
}

/// The words that the value of a key can be, in any form of its table, with their meanings. The meaning is empty where the schema has none.
pub(super) fn words(schema: &Value, place: &TomlPlace, key: &str) -> BTreeMap<String, String> {
    let nodes = properties(schema, place).into_iter().filter(|(known, _)| *known == key).map(|(_, node)| node);
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let mut found = BTreeMap::new();
    for form in nodes.flat_map(|node| forms(schema, node)) {
        let meanings = &form["x-taplo"]["docs"]["enumValues"];
        for (at, word) in form["enum"].as_array().into_iter().flatten().enumerate().filter(|(_, word)| word.is_string())
        {
            found.insert(text(word), text(&meanings[at]));
        }
        if form["const"].is_string() {
            found.insert(text(&form["const"]), text(&form["description"]));
        }
    }
    found
}

/// The sources of a member, in these graphs.
fn sources(graphs: &[ProjectText]) -> Vec<CompletionItem> {
    let mut found: Vec<CompletionItem> = Builtin::ALL
        .iter()
        .map(|builtin| item(builtin.name(), CompletionItemKind::CONSTANT, builtin.about()))
        .collect();
    for (kind, prefix, suffixes) in [
        ("params", "param", [""].as_slice()),
        ("clocks", "clock", &[".tick", ".delta", ".phase"]),
        ("targets", "target", &[".size"]),
        ("buffers", "buffer", &[".count"]),
    ] {
        for known in inherited(graphs, &[kind]) {
            let named = suffixes.iter().map(|suffix| format!("{prefix}.{}{suffix}", known.label));
            found.extend(named.map(|label| CompletionItem { label, ..known.clone() }));
        }
    }
    found
}

/// The resource that a source is for: a target takes images, a buffer takes blocks and bytes. A copy takes no file, and no source that passes write.
#[derive(Clone, Copy)]
struct Supplied {
    target: bool,
    copy: bool,
}

impl Supplied {
    /// By the table of a resource and the key in it.
    fn of(place: &TomlPlace, key: &str) -> Self {
        Self { target: place.table.first().is_some_and(|table| table == "targets"), copy: key == "copy" }
    }

    fn takes(self, source: &SourceLayout) -> bool {
        (source.image.is_some() || !self.target) && (source.collected.is_none() || !self.copy)
    }

    fn takes_file(self, path: &str) -> bool {
        !self.copy && (!self.target || has_texels(path))
    }
}

/// The sources of a resource: those of the session, of each model of the project's worlds, and files of the project.
fn supplied(documents: &Documents, document: &Document, resource: Supplied) -> Vec<CompletionItem> {
    let catalog = SourceCatalog::new(Arc::new(MemoryFiles::default()));
    let of_session = |name: &str| item(name, CompletionItemKind::VALUE, "supplied by the session");
    let sources = catalog.sources().iter().filter(|source| resource.takes(source));
    let mut found: Vec<CompletionItem> = sources.map(|source| of_session(&source.name)).collect();
    // It has texels, and nothing copies it.
    if resource.target && !resource.copy {
        found.push(of_session(MICROPHONE));
    }
    let text = |path: String| Some(ProjectText { text: documents.text(document, &path)?, path, on_disk: true });
    let worlds: Vec<_> = every(FileKind::World, &document.project).into_iter().filter_map(text).collect();
    for model in of_world(&worlds, "model") {
        let names = raxel_rivals::LAYOUTS.iter().map(|layout| format!("model.{}.{}", model.label, layout.name()));
        let taken = names.filter(|name| catalog.source(name).is_some_and(|source| resource.takes(&source)));
        found.extend(taken.map(|label| CompletionItem { label, ..model.clone() }));
    }
    for file in files(document, "textures").iter().filter(|file| resource.takes_file(&file.label)) {
        found.push(item(&format!("file.textures/{}", file.label), CompletionItemKind::FILE, "a file of the project"));
    }
    found
}

/// The materials or models of a world, as `[materials]` or `[models]` of its file has them.
fn of_world(worlds: &[ProjectText], key: &str) -> Vec<CompletionItem> {
    let table = format!("{key}s");
    let named = worlds.iter().flat_map(|world| {
        let names = keys_of(&world.text, &table).into_iter().chain(declared(&world.text, &table));
        names.map(|(name, _)| (name, world.path.as_str())).collect::<Vec<_>>()
    });
    let names: BTreeMap<&str, &str> = named.collect();
    names.iter().map(|(name, path)| item(name, CompletionItemKind::VALUE, &format!("a {key} of `{path}`"))).collect()
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

/// The names of GLSL, of the library and of the shader; behind a dot members, after `#include` files.
fn glsl(documents: &Documents, document: &Document, at: usize) -> Vec<CompletionItem> {
    let line = document.text[..at].rsplit('\n').next().unwrap_or_default();
    if line.trim_start().starts_with("#include") {
        return includes(document);
    }
    let texts = shader(documents, document, &document.path);
    if member_access::is_behind_dot(&document.text, at) {
        let members = member_access::offered(document, &texts, at).into_iter();
        return members.map(|member| item(&member.name, CompletionItemKind::FIELD, &member.about)).collect();
    }
    let mut found: Vec<CompletionItem> = Vec::new();
    for local in document.text.locals().iter().rev().filter(|local| local.scope.contains(&at)) {
        if found.iter().all(|known| known.label != local.name) {
            let about = format!("```glsl\n{}\n```", local.declaration());
            found.push(item(&local.name, CompletionItemKind::VARIABLE, &about));
        }
    }
    for (text, declared) in declared_in(&texts).filter(|(text, _)| text.on_disk && !text.path.contains("/raxel/")) {
        let about = comment_on(&text.text, &declared.whole);
        let about = format!("```glsl\n{}\n```\n{about}\n\n`{}`", &text.text[declared.whole.clone()], text.path);
        if found.iter().all(|known| known.label != declared.name) {
            found.push(item(&declared.name, symbols::completion_kind(declared.kind), &about));
        }
    }
    if signature::call(document.text.code(), at).is_some_and(|(name, _)| name == "layout") {
        let formats = Format::ALL.iter().map(|format| format.name());
        let words = builtins::LAYOUT_WORDS.iter().copied().chain(formats);
        found.extend(words.map(|word| item(word, CompletionItemKind::KEYWORD, "")));
    }
    let types = builtins::TYPES.iter().map(|name| (*name).to_owned()).chain(builtins::opaque_types());
    found.extend(types.map(|name| item(&name, CompletionItemKind::STRUCT, "")));
    found.extend(builtins::KEYWORDS.iter().map(|word| item(word, CompletionItemKind::KEYWORD, "")));
    for builtin in builtins::BUILTINS.iter() {
        let variable = builtin.name.starts_with("gl_");
        let kind = if variable { CompletionItemKind::VARIABLE } else { CompletionItemKind::FUNCTION };
        found.push(item(builtin.name, kind, &builtin.about()));
    }
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
