//! Where a name of a project is used, and what changes when it gets another one: locals and parameters in their function, what a shader
//! declares in every shader that includes it, bindings also in the graphs that bind them, params in graphs and demos.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use lsp_types::{Location, TextEdit, Url, WorkspaceEdit};

use super::documents::{Document, Documents, range};
use super::glsl::{Declaration, DeclarationKind, without_comments};
use super::names::{bare, declared, identifier, word};
use super::project_texts::{declared_in, graphs, passes, shader, shader_of_pass};
use super::scopes::{code_of, identifiers, local_at, locals};
use super::toml_place::TomlPlace;
use super::{address, builtins};

/// Words of GLSL that no name may be, beside types and functions.
const KEYWORDS: &str = "attribute const uniform varying buffer shared coherent volatile restrict readonly writeonly layout centroid flat smooth \
    noperspective patch sample break continue do for while switch case default if else subroutine in out inout float double int void bool true false \
    invariant precise discard return mat2 mat3 mat4 vec2 vec3 vec4 ivec2 ivec3 ivec4 bvec2 bvec3 bvec4 uint uvec2 uvec3 uvec4 lowp mediump highp \
    precision struct common partition active asm class union enum typedef template this resource goto inline noinline public static extern external \
    interface long short half fixed unsigned superp input output filter sizeof cast namespace using";

/// Whether GLSL has a name for itself: a keyword, a type, a function, or one that it reserves.
fn is_of_glsl(name: &str) -> bool {
    let opaque = |name: &str| {
        let dimension = ["image", "sampler"].iter().find_map(|kind| name.strip_prefix(kind));
        dimension.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c.is_ascii_uppercase()))
    };
    let reserved = name.starts_with("gl_") || name.contains("__");
    let known = builtins::about(name).is_some() || KEYWORDS.split_whitespace().any(|word| word == name);
    reserved || known || opaque(name) || name.strip_prefix(['i', 'u']).is_some_and(opaque)
}

/// A name with all its places.
pub(super) struct Uses {
    name: String,
    /// Places in each file of the project.
    files: BTreeMap<String, (String, Vec<Range<usize>>)>,
    /// It is a name of TOML alone, where more letters are allowed.
    in_toml: bool,
    /// Why it cannot have another name, if it cannot.
    fixed: Option<String>,
}

impl Uses {
    fn of(name: &str) -> Self {
        Self { name: name.to_owned(), files: BTreeMap::new(), in_toml: false, fixed: None }
    }

    fn add(&mut self, path: &str, text: &str, places: Vec<Range<usize>>) {
        if !places.is_empty() {
            self.files.insert(path.to_owned(), (text.to_owned(), places));
        }
    }
}

/// Where the name at a byte is used, its declaration included. The error says why nobody can tell.
pub(super) fn uses(documents: &Documents, document: &Document, at: usize) -> Result<Uses, String> {
    if document.is_toml() {
        return uses_in_toml(documents, document, at);
    }
    let text = &document.text;
    let name = identifier(text, at);
    let code = code_of(text);
    let start = text[..at].trim_end_matches(|c: char| c == '_' || c.is_ascii_alphanumeric()).len();
    if code.get(..start).is_some_and(|before| before.trim_end().ends_with('.')) {
        return Err(format!("`{name}` is a member; only variables, functions, types and bindings are followed"));
    }
    let locals = locals(&code);
    if let Some(local) = local_at(&locals, name, start) {
        let means = |(text, place, member): &(&str, Range<usize>, bool)| {
            *text == name && !member && local_at(&locals, name, place.start) == Some(local)
        };
        let mut uses = Uses::of(name);
        uses.add(
            &document.path,
            text,
            identifiers(&code).into_iter().filter(means).map(|(_, place, _)| place).collect(),
        );
        return Ok(uses);
    }
    of_shader(documents, document, &document.path, name)
}

/// The uses of a name that a shader, or a file that it includes, declares outside of its functions.
fn of_shader(documents: &Documents, document: &Document, path: &str, name: &str) -> Result<Uses, String> {
    if name.is_empty() {
        return Err("there is no name here".to_owned());
    }
    let texts = shader(documents, document, path);
    let known = declared_in(&texts).find(|(_, known)| known.is_called(name));
    let Some((text, known)) = known else {
        let of_glsl = is_of_glsl(name);
        let reason = if of_glsl { "is a name of GLSL" } else { "is declared nowhere in this shader and its includes" };
        return Err(format!("`{name}` {reason}"));
    };
    let mut uses = Uses::of(name);
    if !text.on_disk || text.path.starts_with("shaders/include/raxel/") {
        uses.fixed = Some(format!("`{name}` belongs to the shader library (`{}`)", text.path));
    }
    let declaring = text.path.clone();
    for path in shader_files(document) {
        let Some(text) = documents.text(document, &path).filter(|text| text.contains(name)) else { continue };
        if path != declaring && !shader(documents, document, &path).iter().any(|text| text.path == declaring) {
            continue;
        }
        uses.add(&path, &text, globals(&text, name));
    }
    if known.kind == DeclarationKind::Binding {
        bindings(documents, document, &declaring, &known, &mut uses);
    }
    Ok(uses)
}

/// Places of a name in a shader that mean what is declared outside of functions.
fn globals(text: &str, name: &str) -> Vec<Range<usize>> {
    let locals = locals(&code_of(text));
    // Macros use names, too; the names of files are none.
    let blank =
        |line: &str| if line.trim_start().starts_with("#include") { " ".repeat(line.len()) } else { line.to_owned() };
    let code: String = without_comments(text).split_inclusive('\n').map(blank).collect();
    let found = identifiers(&code).into_iter();
    let means = |(text, place, member): &(&str, Range<usize>, bool)| {
        *text == name && !member && local_at(&locals, name, place.start).is_none()
    };
    found.filter(means).map(|(_, place, _)| place).collect()
}

/// Adds the keys of graphs that bind something to a name.
fn bindings(documents: &Documents, document: &Document, declaring: &str, known: &Declaration, uses: &mut Uses) {
    let mut named = false;
    for path in document.project.graphs() {
        let Some(text) = documents.text(document, &path).filter(|text| text.contains(&uses.name)) else { continue };
        let graph = Document { project: document.project.clone(), path: path.clone(), text };
        let mut places = Vec::new();
        for pass in passes(&graph.text) {
            let keys = keys_in(&graph.text, pass.clone(), &uses.name);
            if keys.is_empty() {
                continue;
            }
            if shader_of_pass(documents, &graph, pass.start).iter().any(|text| text.path == declaring) {
                places.extend(keys);
            }
        }
        named |= !places.is_empty();
        uses.add(&path, &graph.text, places);
    }
    if known.body.is_some() && named && uses.fixed.is_none() {
        let reason = format!("`{}` is a block, and graphs may name its type, its instance or its members", uses.name);
        uses.fixed = Some(reason);
    }
}

/// Keys of this name in the `bind` of a pass.
fn keys_in(text: &str, pass: Range<usize>, name: &str) -> Vec<Range<usize>> {
    let inside = |c: char| c == '_' || c == '-' || c.is_ascii_alphanumeric();
    let found = text[pass.clone()].match_indices(name).map(|(at, _)| pass.start + at..pass.start + at + name.len());
    let is_key = |place: &Range<usize>| {
        let (before, behind) = (&text[..place.start], &text[place.end..]);
        if before.ends_with(inside) || !behind.trim_start_matches([' ', '\t']).starts_with('=') {
            return false;
        }
        let around = TomlPlace::of(text, place.start);
        around.table.iter().map(String::as_str).eq(["passes", "bind"]) && around.key.is_none() && !around.in_string
    };
    found.filter(is_key).collect()
}

/// The uses of a name of a graph or demo: a key of `bind`, or a param.
fn uses_in_toml(documents: &Documents, document: &Document, at: usize) -> Result<Uses, String> {
    let text = &document.text;
    let found = word(text, at);
    let bound = shader_of_pass(documents, document, at);
    let place = TomlPlace::of(text, at);
    if place.table.iter().map(String::as_str).eq(["passes", "bind"])
        && place.key.is_none()
        && let Some(first) = bound.first()
    {
        return of_shader(documents, document, &first.path, found);
    }
    let name = match found.strip_prefix("param.") {
        Some(name) => name,
        None => match found.split_once('.') {
            // The header `params.sun` and `tracks.sun` as one word.
            Some(("params" | "tracks", name)) => name.split('.').next().unwrap_or(name),
            _ => return Err(format!("`{}` is no param and no binding; only these are followed", bare(found))),
        },
    };
    let of_document = graphs(documents, document);
    let declares = |text: &str| declared(text, "params").iter().any(|(known, _)| *known == name);
    let Some(declaring) = of_document.iter().rfind(|text| declares(&text.text)).map(|text| text.path.clone()) else {
        return Err(format!("no graph declares the param `{name}` in a table `[params.{name}]`"));
    };
    let mut uses = Uses { in_toml: true, ..Uses::of(name) };
    for path in document.project.graphs().into_iter().chain(document.project.demos()) {
        let Some(text) = documents.text(document, &path).filter(|text| text.contains(name)) else { continue };
        let file = Document { project: document.project.clone(), path: path.clone(), text };
        if graphs(documents, &file).iter().any(|graph| graph.path == declaring) {
            uses.add(&path, &file.text, params(&file.text, name));
        }
    }
    Ok(uses)
}

/// Places of a param in a graph or demo: `param.NAME` in texts, and in the headers `[params.NAME]` and `[tracks.NAME]`.
fn params(text: &str, name: &str) -> Vec<Range<usize>> {
    let inside = |c: char| c == '_' || c == '-' || c.is_alphanumeric();
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let is_header = line.trim_start().starts_with('[');
        for (at, _) in line.match_indices(name) {
            let (before, behind) = (&line[..at], &line[at + name.len()..]);
            if behind.starts_with(inside) || before.contains('#') && !TomlPlace::of(line, at).in_string {
                continue;
            }
            let value = before.ends_with("param.") && !before[..before.len() - 6].ends_with(inside);
            let header = is_header && ["[params.", "[tracks."].iter().any(|head| before.trim_start() == *head);
            if value || header {
                found.push(start + at..start + at + name.len());
            }
        }
        start += line.len();
    }
    found
}

/// The shaders of a project and what they include, by their paths.
fn shader_files(document: &Document) -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec!["shaders".to_owned()];
    while let Some(folder) = open.pop() {
        let Ok(entries) = std::fs::read_dir(document.project.on_disk(&folder)) else { continue };
        for entry in entries.flatten() {
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                open.push(path);
            } else if Path::new(&path)
                .extension()
                .is_some_and(|extension| ["comp", "glsl"].iter().any(|glsl| extension == *glsl))
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Where the name is used.
pub(super) fn locations(document: &Document, uses: &Uses) -> Vec<Location> {
    let file = |(path, (text, places)): (&String, &(String, Vec<Range<usize>>))| {
        let uri = address(&document.project.on_disk(path))?;
        Some(places.iter().map(|place| Location { uri: uri.clone(), range: range(text, place) }).collect::<Vec<_>>())
    };
    uses.files.iter().filter_map(file).flatten().collect()
}

/// The edits that give the name another one. The error says why it cannot have that name.
pub(super) fn rename(document: &Document, uses: &Uses, new: &str) -> Result<WorkspaceEdit, String> {
    if let Some(fixed) = &uses.fixed {
        return Err(fixed.clone());
    }
    let letter = |c: char| c == '_' || c.is_ascii_alphanumeric() || (uses.in_toml && c == '-');
    if new.is_empty() || !new.chars().all(letter) || new.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(format!("`{new}` is no name: letters, digits and `_`, the first no digit"));
    }
    if !uses.in_toml && is_of_glsl(new) {
        return Err(format!("`{new}` is a name of GLSL"));
    }
    #[allow(clippy::mutable_key_type, reason = "addresses are not changed while they are keys")]
    let mut changes: std::collections::HashMap<Url, Vec<TextEdit>> = std::collections::HashMap::new();
    for (path, (text, places)) in &uses.files {
        let taken = if Path::new(path).extension().is_some_and(|extension| extension == "toml") {
            !params(text, new).is_empty()
                || passes(text).iter().any(|pass| !keys_in(text, pass.clone(), new).is_empty())
        } else {
            identifiers(&without_comments(text)).iter().any(|(name, _, member)| *name == new && !member)
        };
        if taken {
            return Err(format!("`{new}` is a name in `{path}` already"));
        }
        let Some(uri) = address(&document.project.on_disk(path)) else { continue };
        let edits = places.iter().map(|place| TextEdit { range: range(text, place), new_text: new.to_owned() });
        changes.insert(uri, edits.collect());
    }
    Ok(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() })
}
