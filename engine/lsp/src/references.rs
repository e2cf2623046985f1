//! The uses of a name in a project, and the edits that rename it. A local or a parameter is used in its function, a declaration of a shader in
//! every shader that includes it. Graphs also use bindings and members of blocks. Targets, buffers, params, clocks, loops and passes are used in
//! graphs, worlds and demos.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use lsp_types::{Location, TextEdit, Url, WorkspaceEdit};
use raxel_terminal::offline::FileKind;

use super::documents::{Document, Documents, range};
use super::glsl::{Declaration, DeclarationKind, members};
use super::indexed_text::{IndexedText, NamePlace};
use super::names::{bare, identifier, owner, word};
use super::project_texts::{
    ProjectText, declared_in, every, graphs, includers, passes, shader, shader_of_pass, shader_path_of_pass,
    shaders_of_graphs,
};
use super::scopes::local_at;
use super::toml_names::{TomlName, TomlWord, mentions};
use super::{address, builtins};

/// Words that no name may be although a compute shader has no use for them.
const RESERVED: &str = "attribute varying centroid flat smooth noperspective patch sample subroutine discard common partition active asm class union enum \
    typedef template this resource goto inline noinline public static extern external interface long short half fixed unsigned superp input output \
    filter sizeof cast namespace using";

/// Whether GLSL has a name for itself: a keyword, a type, a function, or one that it reserves.
fn is_of_glsl(name: &str) -> bool {
    let opaque = |name: &str| {
        let dimension = ["image", "sampler"].iter().find_map(|kind| name.strip_prefix(kind));
        dimension.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c.is_ascii_uppercase()))
    };
    let reserved = name.starts_with("gl_") || name.contains("__");
    let is_word = builtins::KEYWORDS.iter().chain(builtins::TYPES).any(|word| *word == name);
    let known = is_word || builtins::named(name).is_some() || RESERVED.split_whitespace().any(|word| word == name);
    reserved || known || opaque(name) || name.strip_prefix(['i', 'u']).is_some_and(opaque)
}

/// A name with all its places.
pub(super) struct Uses {
    name: String,
    /// Places in each file of the project.
    files: BTreeMap<String, (Arc<IndexedText>, Vec<Range<usize>>)>,
    /// It is a name of TOML alone, where more letters are allowed.
    in_toml: Option<TomlName>,
    /// Why it cannot have another name, if it cannot.
    fixed: Option<String>,
}

impl Uses {
    fn of(name: &str) -> Self {
        Self { name: name.to_owned(), files: BTreeMap::new(), in_toml: None, fixed: None }
    }

    fn add(&mut self, path: &str, text: &Arc<IndexedText>, places: Vec<Range<usize>>) {
        if !places.is_empty() {
            self.files.insert(path.to_owned(), (text.clone(), places));
        }
    }
}

/// Where the name at a byte is used, its declaration included. The error has the reason if they cannot be found.
pub(super) fn uses(documents: &Documents, document: &Document, at: usize) -> Result<Uses, String> {
    if document.is_toml() {
        return uses_in_toml(documents, document, at);
    }
    let text = &document.text;
    let name = identifier(text, at);
    let code = text.code();
    let start = text[..at].trim_end_matches(|c: char| c == '_' || c.is_ascii_alphanumeric()).len();
    if code.get(..start).is_some_and(|before| before.trim_end().ends_with('.')) {
        let of_structure = || format!("`{name}` is a member of no block; members of structures are not followed");
        let instance = owner(code, start).ok_or_else(of_structure)?;
        let texts = shader(documents, document, &document.path);
        let block = declared_in(&texts).find(|(text, known)| known.name == instance && has_member(text, known, name));
        let (text, known) = block.ok_or_else(of_structure)?;
        return of_member(documents, document, text, known, name);
    }
    let this = ProjectText { path: document.path.clone(), text: text.clone(), on_disk: true };
    let inside = |known: &Declaration| known.body.as_ref().is_some_and(|body| body.contains(&start));
    let around = text.declarations().iter().find(|known| inside(known) && has_member(&this, known, name));
    if let Some(known) = around {
        return of_member(documents, document, &this, known, name);
    }
    if let Some(local) = local_at(text.locals(), name, start) {
        let means = |found: &&NamePlace| {
            let plain = !found.is_member && !found.in_directive;
            plain && local_at(text.locals(), name, found.place.start) == Some(local)
        };
        let places = text.places(name).iter().filter(means).map(|found| found.place.clone());
        let mut uses = Uses::of(name);
        uses.add(&document.path, text, places.collect());
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
    let shaders = includers(documents, document, &[&text.path]);
    for path in &shaders {
        let Some(text) = documents.text(document, path) else { continue };
        uses.add(path, &text, globals(&text, name));
    }
    if known.kind == DeclarationKind::Binding {
        bindings(documents, document, &shaders, known, &mut uses);
    }
    Ok(uses)
}

/// Places of a name in a shader that mean what is declared outside of functions.
fn globals(text: &IndexedText, name: &str) -> Vec<Range<usize>> {
    // Macros use names, too.
    let found = text.places(name).iter().filter(|found| !found.is_member);
    let means = found.filter(|found| local_at(text.locals(), name, found.place.start).is_none());
    let bound = text.places(&format!("RX_BINDS_{name}")).iter();
    let bound = bound.map(|found| found.place.end - name.len()..found.place.end);
    let mut places: Vec<_> = means.map(|found| found.place.clone()).chain(bound).collect();
    places.sort_by_key(|place| place.start);
    places
}

/// Adds the keys of graphs that bind something to a name of these shaders.
fn bindings(
    documents: &Documents,
    document: &Document,
    shaders: &BTreeSet<String>,
    known: &Declaration,
    uses: &mut Uses,
) {
    let mut named = false;
    let name = uses.name.clone();
    let is_key = |path: &[&str]| matches!(path, ["passes", "bind", bound] if *bound == name);
    for (path, text, places) in keys_of_passes(documents, document, shaders, &name, is_key) {
        named = true;
        uses.add(&path, &text, places);
    }
    if known.body.is_some() && named && uses.fixed.is_none() {
        let reason = format!("`{}` is a block, and graphs may name its type, its instance or its members", uses.name);
        uses.fixed = Some(reason);
    }
}

/// The keys in passes of each graph that run one of these shaders.
fn keys_of_passes(
    documents: &Documents,
    document: &Document,
    shaders: &BTreeSet<String>,
    name: &str,
    is_key: impl Fn(&[&str]) -> bool,
) -> Vec<(String, Arc<IndexedText>, Vec<Range<usize>>)> {
    let mut found = Vec::new();
    for path in every(FileKind::Graph, &document.project) {
        let Some(text) = documents.text(document, &path).filter(|text| text.contains(name)) else { continue };
        let graph = Document { project: document.project.clone(), path: path.clone(), text };
        let passes = passes(&graph.text);
        let mut uses_it = vec![None; passes.len()];
        let mut places = Vec::new();
        for word in graph.text.words().iter().filter(|word| word.is_key) {
            let keys: Vec<&str> = word.path.iter().map(String::as_str).collect();
            if !is_key(&keys) {
                continue;
            }
            let Some(pass) = passes.iter().position(|pass| pass.contains(&word.place.start)) else { continue };
            let of_shader = || {
                let path = shader_path_of_pass(documents, &graph, passes[pass].start);
                path.is_some_and(|path| shaders.contains(&path))
            };
            if *uses_it[pass].get_or_insert_with(of_shader) {
                places.push(word.place.clone());
            }
        }
        if !places.is_empty() {
            found.push((path, graph.text, places));
        }
    }
    found
}

/// The uses of what stands at a byte of a graph or demo.
fn uses_in_toml(documents: &Documents, document: &Document, at: usize) -> Result<Uses, String> {
    let text = &document.text;
    let on = |place: &Range<usize>| place.contains(&at) || place.end == at;
    let kind = FileKind::of(&document.path);
    if let Some(word) = text.words().iter().find(|word| word.is_key && on(&word.place)) {
        let keys: Vec<&str> = word.path.iter().map(String::as_str).collect();
        let given = matches!(keys.as_slice(), ["passes", "bind" | "push", _] | ["passes", "uniforms", _, _]);
        if let Some(first) = shader_of_pass(documents, document, at).first().filter(|_| given) {
            return match keys.as_slice() {
                ["passes", "bind", name] => of_shader(documents, document, &first.path, name),
                [.., block, name] => {
                    let texts = shader(documents, document, &first.path);
                    let member = name.split(['.', '[']).next().unwrap_or(name);
                    let found = declared_in(&texts).find(|(text, known)| {
                        let of_push = *block == "push" && known.kind == DeclarationKind::Push;
                        (of_push || known.is_called(block)) && has_member(text, known, member)
                    });
                    let missing = || format!("no block of the shader has a member `{member}`");
                    let (text, known) = found.ok_or_else(missing)?;
                    of_member(documents, document, text, known, member)
                }
                _ => Err("there is no name here".to_owned()),
            };
        }
    }
    let Some(mention) = mentions(text, kind).into_iter().find(|mention| on(&mention.place)) else {
        return Err(format!("`{}` is no name that a graph declares, and no binding or member", bare(word(text, at))));
    };
    let name = text[mention.place].to_owned();
    let declares = |text: &IndexedText| {
        let found = mentions(text, FileKind::Graph);
        found.iter().any(|known| known.declares && known.what == mention.what && text[known.place.clone()] == name)
    };
    let graphs_of = |path: &str, text: &Arc<IndexedText>| {
        let graph = Document { project: document.project.clone(), path: path.to_owned(), text: text.clone() };
        mentionable_graphs(documents, &graph)
    };
    // The graph that declares it first: those that extend that one may change its table.
    let declaring = mentionable_graphs(documents, document).into_iter().rfind(|graph| declares(&graph.text));
    let declaring = declaring.and_then(|graph| {
        graphs_of(&graph.path, &graph.text).into_iter().rfind(|base| declares(&base.text)).map(|base| base.path)
    });
    let article = mention.what.article();
    let declaring = declaring.ok_or_else(|| format!("no graph declares {article} named `{name}`"))?;
    let mut uses = Uses { in_toml: Some(mention.what), ..Uses::of(&name) };
    for kind in [FileKind::Graph, FileKind::Demo, FileKind::World] {
        for path in every(kind, &document.project) {
            let Some(text) = documents.text(document, &path).filter(|text| text.contains(&name)) else { continue };
            let places = named(&text, kind, mention.what, &name);
            if places.is_empty() {
                continue;
            }
            let family = graphs_of(&path, &text);
            if family.iter().all(|graph| graph.path != declaring) {
                continue;
            }
            // The graphs of a demo or world may have nothing in common but this name.
            let other = |graph: &&ProjectText| {
                declares(&graph.text) && graphs_of(&graph.path, &graph.text).iter().all(|base| base.path != declaring)
            };
            if let Some(other) = family.iter().find(other) {
                let other = &other.path;
                uses.fixed = Some(format!("`{path}` means `{name}` of `{declaring}` and of `{other}` by it"));
            }
            uses.add(&path, &text, places);
        }
    }
    Ok(uses)
}

/// The graphs whose names a document may mention. A world may mention params of every graph, since any may run over it.
fn mentionable_graphs(documents: &Documents, document: &Document) -> Vec<ProjectText> {
    if FileKind::of(&document.path) != FileKind::World {
        return graphs(documents, document);
    }
    let text = |path: String| Some(ProjectText { text: documents.text(document, &path)?, path, on_disk: true });
    every(FileKind::Graph, &document.project).into_iter().filter_map(text).collect()
}

/// Places of a name of this kind in a graph, world or demo.
fn named(text: &IndexedText, kind: FileKind, what: TomlName, name: &str) -> Vec<Range<usize>> {
    let found = mentions(text, kind).into_iter().filter(|mention| mention.what == what);
    found.map(|mention| mention.place).filter(|place| text[place.clone()] == *name).collect()
}

/// Whether a block has a member of this name.
fn has_member(text: &ProjectText, known: &Declaration, name: &str) -> bool {
    let body = known.body.clone().filter(|_| matches!(known.kind, DeclarationKind::Push | DeclarationKind::Binding));
    body.is_some_and(|body| members(text.text.code(), body).iter().any(|member| member.name == name))
}

/// The uses of a member of a block: in the shaders that include the declaring file, and in the graphs that fill the block.
fn of_member(
    documents: &Documents,
    document: &Document,
    declaring: &ProjectText,
    known: &Declaration,
    member: &str,
) -> Result<Uses, String> {
    let block = known.block.as_deref().unwrap_or(&known.name);
    if known.name == block {
        return Err(format!("block `{block}` has no instance name, so that its members are plain names of the shader"));
    }
    let mut uses = Uses::of(member);
    if !declaring.on_disk || declaring.path.starts_with("shaders/include/raxel/") {
        uses.fixed = Some(format!("`{member}` belongs to the shader library (`{}`)", declaring.path));
    }
    let shaders = includers(documents, document, &[&declaring.path]);
    for path in &shaders {
        let Some(text) = documents.text(document, path) else { continue };
        let is_declaring = *path == declaring.path;
        let inside =
            |place: &Range<usize>| is_declaring && known.body.as_ref().is_some_and(|body| body.contains(&place.start));
        let found = text.places(member).iter().filter(|found| {
            let of_block = found.is_member && owner(&text, found.place.start) == Some(known.name.as_str());
            of_block || !found.is_member && inside(&found.place)
        });
        uses.add(path, &text, found.map(|found| found.place.clone()).collect());
    }
    let begins = |key: &str| key.split(['.', '[']).next() == Some(member);
    let is_key = |path: &[&str]| match path {
        ["passes", "push", key] => known.kind == DeclarationKind::Push && begins(key),
        ["passes", "uniforms", block, key] => known.is_called(block) && begins(key),
        _ => false,
    };
    for (path, text, places) in keys_of_passes(documents, document, &shaders, member, is_key) {
        // A key such as `sun.direction` begins with the member.
        let places = places.into_iter().map(|place| place.start..place.start + member.len()).collect();
        uses.add(&path, &text, places);
    }
    shared_blocks(documents, document, declaring, known, &mut uses);
    Ok(uses)
}

/// Adds the keys in `[blocks.NAME]` of graphs, which fill the blocks of that name in all their shaders.
fn shared_blocks(
    documents: &Documents,
    document: &Document,
    declaring: &ProjectText,
    known: &Declaration,
    uses: &mut Uses,
) {
    let member = uses.name.clone();
    for path in every(FileKind::Graph, &document.project) {
        let Some(text) = documents.text(document, &path).filter(|text| text.contains(&member)) else { continue };
        let is_key = |word: &TomlWord| {
            let keys: Vec<&str> = word.path.iter().map(String::as_str).collect();
            matches!(keys.as_slice(), ["blocks", block, key] if word.is_key && known.is_called(block)
                && key.split(['.', '[']).next() == Some(&member))
        };
        let keys: Vec<&TomlWord> = text.words().iter().filter(|word| is_key(word)).collect();
        if keys.is_empty() {
            continue;
        }
        let graph = Document { project: document.project.clone(), path: path.clone(), text: text.clone() };
        let shaders = shaders_of_graphs(documents, &graph);
        if shaders.iter().all(|text| text.path != declaring.path) {
            continue;
        }
        let other = |(text, found): &(&ProjectText, &Declaration)| {
            let same =
                known.is_called(&found.name) || found.block.as_deref().is_some_and(|block| known.is_called(block));
            text.path != declaring.path && same && has_member(text, found, &member)
        };
        if let Some((other, _)) = declared_in(&shaders).find(other) {
            let reason = format!("`{path}` fills a member `{member}` of `{}` by the same key", other.path);
            uses.fixed.get_or_insert(reason);
        }
        let places: Vec<_> = keys.into_iter().map(|word| word.place.start..word.place.start + member.len()).collect();
        match uses.files.get_mut(&path) {
            Some((_, known)) => known.extend(places),
            None => uses.add(&path, &text, places),
        }
    }
}

/// Where the name is used.
pub(super) fn locations(document: &Document, uses: &Uses) -> Vec<Location> {
    let file = |(path, (text, places)): (&String, &(Arc<IndexedText>, Vec<Range<usize>>))| {
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
    let letter = |c: char| c == '_' || c.is_ascii_alphanumeric() || (uses.in_toml.is_some() && c == '-');
    if new.is_empty() || !new.chars().all(letter) || new.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(format!("`{new}` is no name: letters, digits and `_`, the first no digit"));
    }
    if uses.in_toml.is_none() && is_of_glsl(new) {
        return Err(format!("`{new}` is a name of GLSL"));
    }
    #[allow(clippy::mutable_key_type, reason = "addresses are not changed while they are keys")]
    let mut changes: std::collections::HashMap<Url, Vec<TextEdit>> = std::collections::HashMap::new();
    for (path, (text, places)) in &uses.files {
        let is_toml = Path::new(path).extension().is_some_and(|extension| extension == "toml");
        let taken = match uses.in_toml {
            Some(what) => !named(text, FileKind::of(path), what, new).is_empty(),
            // The same key of one table; other passes have other shaders.
            None if is_toml => {
                let words = text.words();
                let tables: Vec<_> =
                    words.iter().filter(|word| places.iter().any(|place| place.start == word.place.start)).collect();
                let beside = |word: &TomlWord| {
                    tables.iter().any(|table| {
                        table.path.split_last().map(|(_, path)| path) == word.path.split_last().map(|(_, path)| path)
                    })
                };
                words.iter().any(|word| word.is_key && text[word.place.clone()] == *new && beside(word))
            }
            None => text.places(new).iter().any(|found| !found.is_member),
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
