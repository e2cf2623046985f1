//! The texts that a document depends on, unsaved ones included: what a graph extends, the graphs and the world of a demo, the shader of a pass, what
//! a shader includes.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::files::join;
use raxel_runtime::project::Project;
use raxel_shader::library;
use raxel_terminal::offline::FileKind;

use super::documents::{Document, Documents};
use super::glsl::Declaration;
use super::indexed_text::IndexedText;
use super::toml_place::quoted;

/// Files that are followed from one document, at most.
const MOST_FILES: usize = 64;

/// A text of the project, or of the shader library.
pub(super) struct ProjectText {
    /// Path in the project; of a library file that the project does not have, its name.
    pub path: String,
    pub text: Arc<IndexedText>,
    /// It is in the project, and not only in the library.
    pub on_disk: bool,
}

/// Project paths of all files of this kind, those in folders below included.
pub(super) fn every(kind: FileKind, project: &Project) -> Vec<String> {
    let paths = project.every_file().into_iter().map(|file| file.path().to_owned());
    paths.filter(|path| FileKind::of(path) == kind).collect()
}

/// The graphs that a document knows the names of, the nearest first: a graph itself and what it extends, or those of a demo.
pub(super) fn graphs(documents: &Documents, document: &Document) -> Vec<ProjectText> {
    let mut paths = match FileKind::of(&document.path) {
        FileKind::Graph => vec![document.path.clone()],
        FileKind::Demo => named(&document.text, "graph", "graphs"),
        FileKind::World | FileKind::Project => Vec::new(),
    };
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(path) = paths.get(at).cloned().filter(|_| at < MOST_FILES) {
        at += 1;
        let Some(text) = documents.text(document, &path) else { continue };
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for base in named(&text, "extends", folder) {
            // Two graphs may share a base, and a broken one may extend itself.
            if !paths.contains(&base) {
                paths.push(base);
            }
        }
        found.push(ProjectText { path, text, on_disk: true });
    }
    found
}

/// The worlds that a document knows the materials of: a world itself, or that of a demo.
pub(super) fn worlds(documents: &Documents, document: &Document) -> Vec<ProjectText> {
    let paths = match FileKind::of(&document.path) {
        FileKind::World => vec![document.path.clone()],
        FileKind::Demo => named(&document.text, "world", "worlds"),
        FileKind::Graph | FileKind::Project => Vec::new(),
    };
    let text = |path: String| documents.text(document, &path).map(|text| ProjectText { path, text, on_disk: true });
    paths.into_iter().filter_map(text).collect()
}

/// Paths of the files that lines `key = "file"` of a text name, relative to a folder.
fn named(text: &str, key: &str, folder: &str) -> Vec<String> {
    let values = text.lines().filter_map(|line| line.trim().strip_prefix(key)?.trim_start().strip_prefix('='));
    values.filter_map(|value| join(folder, quoted(value)?)).collect()
}

/// A shader and what it includes, the shader first.
pub(super) fn shader(documents: &Documents, document: &Document, path: &str) -> Vec<ProjectText> {
    let mut found: Vec<ProjectText> = Vec::new();
    let mut seen = BTreeSet::from([path.to_owned()]);
    let mut wanted = vec![path.to_owned()];
    let is_there = |path: &str| {
        document.project.on_disk(path).is_file()
            || library::text(library_name(path)).is_some()
            || documents.text(document, path).is_some()
    };
    while let Some(path) = wanted.pop().filter(|_| found.len() < MOST_FILES) {
        let in_project = documents.text(document, &path);
        let on_disk = in_project.is_some();
        let Some(text) = in_project.or_else(|| documents.library_text(library_name(&path))) else { continue };
        for include in text.includes() {
            if let Some(path) = include_path(&path, include, is_there)
                && seen.insert(path.clone())
            {
                wanted.push(path);
            }
        }
        found.push(ProjectText { path, text, on_disk });
    }
    found
}

/// The name in the shader library that a project path would have there.
pub(super) fn library_name(path: &str) -> &str {
    path.strip_prefix("shaders/include/").unwrap_or(path)
}

/// The path of a file that a shader includes: beside it, in `shaders/include` or in `shaders`.
fn include_path(shader: &str, include: &str, is_there: impl Fn(&str) -> bool) -> Option<String> {
    let folder = shader.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut paths = [folder, "shaders/include", "shaders"].into_iter().filter_map(|folder| join(folder, include));
    paths.find(|path| is_there(path))
}

/// The shaders of a project and what they include, by their paths.
pub(super) fn shader_files(project: &Project) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec!["shaders".to_owned()];
    while let Some(folder) = open.pop() {
        let Ok(entries) = std::fs::read_dir(project.on_disk(&folder)) else { continue };
        for entry in entries.flatten() {
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                open.push(path);
            } else if Path::new(&path)
                .extension()
                .is_some_and(|extension| ["comp", "glsl", "hlsl"].iter().any(|shader| extension == *shader))
            {
                found.insert(path);
            }
        }
    }
    found
}

/// The shaders of a project, and of the library, that include one of these files directly or through others; these files among them.
pub(super) fn includers(documents: &Documents, document: &Document, files: &[&str]) -> BTreeSet<String> {
    let mut known = shader_files(&document.project);
    known.extend(library::FILES.iter().map(|(name, _)| format!("shaders/include/{name}")));
    let mut included_by: BTreeMap<String, Vec<&String>> = BTreeMap::new();
    for path in &known {
        let in_project = documents.text(document, path);
        let Some(text) = in_project.or_else(|| documents.library_text(library_name(path))) else { continue };
        for include in text.includes() {
            if let Some(included) = include_path(path, include, |path| known.contains(path)) {
                included_by.entry(included).or_default().push(path);
            }
        }
    }
    let mut found = BTreeSet::new();
    let mut open: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
    while let Some(path) = open.pop() {
        if found.contains(&path) {
            continue;
        }
        open.extend(included_by.get(&path).into_iter().flatten().map(|path| (*path).clone()));
        found.insert(path);
    }
    found
}

/// Graphs of a project that run one of these shaders or extend one that does: those at the top first, and no more than `most`.
pub(super) fn graphs_that_run(
    documents: &Documents,
    document: &Document,
    shaders: &BTreeSet<String>,
    most: usize,
) -> Vec<String> {
    let runs = |path: &String| {
        let Some(text) = documents.text(document, path) else { return false };
        let graph = Document { project: document.project.clone(), path: path.clone(), text };
        let family = graphs(documents, &graph);
        family.iter().flat_map(|graph| named(&graph.text, "shader", "shaders")).any(|path| shaders.contains(&path))
    };
    every(FileKind::Graph, &document.project).into_iter().filter(runs).take(most).collect()
}

/// Bytes of each pass of a graph, from its `[[passes]]` to the next table of an array.
pub(super) fn passes(text: &str) -> Vec<Range<usize>> {
    let starts = text.match_indices("[[passes]]").map(|(at, _)| at);
    let of_lines = starts.filter(|at| text[..*at].rsplit('\n').next().is_some_and(|before| before.trim().is_empty()));
    of_lines.filter_map(|at| pass_at(text, at)).collect()
}

/// Bytes of the pass around a byte of a graph, from its `[[passes]]` to the next.
pub(super) fn pass_at(text: &str, at: usize) -> Option<Range<usize>> {
    let line_end = text[at..].find('\n').map_or(text.len(), |end| at + end);
    let start = text[..line_end].rfind("[[passes]]")?;
    let end = text[start + 2..].find("\n[[").map_or(text.len(), |end| start + 2 + end);
    (at <= end).then_some(start..end)
}

/// The value of a line `key = "value"` of a pass.
fn value_of<'t>(pass: &'t str, key: &str) -> Option<&'t str> {
    let line = |line: &'t str| quoted(line.trim().strip_prefix(key)?.trim_start().strip_prefix('=')?);
    pass.lines().find_map(line)
}

/// The path of the shader of the pass around a byte of a graph; its base says which if it does not.
pub(super) fn shader_path_of_pass(documents: &Documents, document: &Document, at: usize) -> Option<String> {
    let pass = &document.text[pass_at(&document.text, at)?];
    let inherited = || {
        let name = value_of(pass, "name")?;
        let graphs = graphs(documents, document);
        let bases = graphs.iter().filter(|graph| graph.path != document.path);
        let passes = bases.flat_map(|graph| graph.text.split("[[passes]]").skip(1));
        let mut same = passes.filter(|pass| value_of(pass, "name") == Some(name));
        same.find_map(|pass| value_of(pass, "shader").map(str::to_owned))
    };
    let file = value_of(pass, "shader").map(str::to_owned).or_else(inherited)?;
    join("shaders", &file)
}

/// The texts of that shader.
pub(super) fn shader_of_pass(documents: &Documents, document: &Document, at: usize) -> Vec<ProjectText> {
    let path = shader_path_of_pass(documents, document, at);
    path.map_or_else(Vec::new, |path| shader(documents, document, &path))
}

/// The texts of every shader that the graphs of a document name.
pub(super) fn shaders_of_graphs(documents: &Documents, document: &Document) -> Vec<ProjectText> {
    let graphs = graphs(documents, document);
    let named = graphs.iter().flat_map(|graph| named(&graph.text, "shader", "shaders"));
    let paths: BTreeSet<String> = named.collect();
    paths.iter().flat_map(|path| shader(documents, document, path)).collect()
}

/// Declarations of these texts, each with its text.
pub(super) fn declared_in(texts: &[ProjectText]) -> impl Iterator<Item = (&ProjectText, &Declaration)> {
    texts.iter().flat_map(|text| text.text.declarations().iter().map(move |declaration| (text, declaration)))
}

/// The bindings of a shader's name: graph, pass and the line of the entry, in every graph of the project.
pub(super) fn bound_by(documents: &Documents, document: &Document, name: &str) -> Vec<String> {
    let Some(shader) = document.path.strip_prefix("shaders/") else { return Vec::new() };
    let mut found = Vec::new();
    for path in every(FileKind::Graph, &document.project) {
        let Some(text) = documents.text(document, &path) else { continue };
        for pass in text.split("[[passes]]").skip(1).filter(|pass| value_of(pass, "shader") == Some(shader)) {
            let entry = pass.split([',', '{', '\n']).find_map(|entry| {
                let (key, value) = entry.split_once('=')?;
                (key.trim() == name).then(|| value.trim().trim_end_matches('}').trim().to_owned())
            });
            if let (Some(value), Some(pass)) = (entry, value_of(pass, "name")) {
                found.push(format!("`{name} = {value}` in pass `{pass}` of `{path}`"));
            }
        }
    }
    found
}
