//! The page of the Rust API: every name that the library exports, with the first sentence of its docs.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::common::repository;

/// The words after `pub` in the declaration of something that a program can name.
const KINDS: [&str; 6] = ["struct", "enum", "type", "trait", "fn", "const"];

/// The tables of the page, from `engine/lib.rs`: names, modules that are whole crates, and the names of each other module.
pub(crate) fn tables() -> String {
    let library = std::fs::read_to_string(repository().join("engine/lib.rs")).unwrap();
    let mut parts = library.split("\npub mod ");
    let top = parts.next().unwrap();
    let crates: String = exports(top).into_iter().filter_map(Export::row).collect();
    let mut page = format!(
        "\n| name | meaning |\n|---|---|\n{}\n## Modules that are crates\n\n`cargo doc` lists their names.\n\n\
         | module | content |\n|---|---|\n{crates}",
        names(top)
    );
    let mut docs = docs_before(top);
    for part in parts {
        let (name, rest) = part.split_once(" {").unwrap();
        let (body, after) = rest.split_once("\n}").unwrap();
        let _ =
            write!(page, "\n## raxel::{name}\n\n{}\n\n| name | meaning |\n|---|---|\n{}", sentence(&docs), names(body));
        docs = docs_before(after);
    }
    page
}

/// Rows of the names that a text exports, in order of the alphabet.
fn names(text: &str) -> String {
    let mut rows: Vec<(String, String)> = Vec::new();
    for export in exports(text).into_iter().filter(|export| export.renamed.is_none()) {
        for name in export.names {
            let docs =
                declaration(&export.crate_name, &export.module, &name).or_else(|| module(&export.crate_name, &name));
            let docs = docs.unwrap_or_else(|| panic!("{name} has no docs"));
            rows.push((name, sentence(&docs)));
        }
    }
    rows.sort();
    rows.iter().fold(String::new(), |mut table, (name, meaning)| {
        let _ = writeln!(table, "| `{name}` | {meaning} |");
        table
    })
}

/// One `pub use`.
struct Export {
    crate_name: String,
    /// The module that the names are in, or the crate.
    module: String,
    names: Vec<String>,
    renamed: Option<String>,
    docs: String,
}

impl Export {
    /// The row of a crate that is exported under another name.
    fn row(self) -> Option<String> {
        let name = self.renamed?;
        Some(format!("| `raxel::{name}` | {} |\n", sentence(&self.docs)))
    }
}

fn exports(text: &str) -> Vec<Export> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find("pub use ") {
        let docs = docs_before(&rest[..at]);
        let (path, after) = rest[at + "pub use ".len()..].split_once(';').unwrap();
        let (path, renamed) = match path.split_once(" as ") {
            Some((path, name)) => (path, Some(name.to_owned())),
            None => (path, None),
        };
        let crate_name = path.split("::").next().unwrap().trim().to_owned();
        let mut segments = path.rsplit("::");
        let last = segments.next().unwrap().trim_matches(['{', '}']);
        let module = segments.next().unwrap_or_default().trim().to_owned();
        let names = last.split(',').map(|name| name.trim_matches(['{', '}', ' ', '\n']).to_owned());
        found.push(Export {
            crate_name,
            module,
            names: names.filter(|name| !name.is_empty()).collect(),
            renamed,
            docs,
        });
        rest = after;
    }
    found
}

/// The doc comment at the end of a text, attributes left out, as one line.
fn docs_before(text: &str) -> String {
    let lines = text.lines().rev().map(str::trim).skip_while(|line| line.is_empty() || line.starts_with('#'));
    let mut docs: Vec<&str> = lines.map_while(|line| line.strip_prefix("///")).map(str::trim).collect();
    docs.reverse();
    docs.join(" ")
}

/// The docs at the head of a file.
fn inner_docs(file: &Path) -> String {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).collect::<Vec<_>>().join(" ")
}

/// The docs of a module of a crate.
fn module(crate_name: &str, name: &str) -> Option<String> {
    let files = [format!("src/{name}.rs"), format!("src/{name}/mod.rs")].map(|file| folder(crate_name).join(file));
    files.iter().find(|file| file.is_file()).map(|file| inner_docs(file))
}

/// The docs of a name where it is declared: in the crate that exports it, or in one that this crate passes on. There, the file of its module
/// comes first.
fn declaration(crate_name: &str, module: &str, name: &str) -> Option<String> {
    let own = sources(&folder(crate_name));
    let all = sources(&repository().join("engine"));
    let files = [format!("{module}.rs"), format!("{module}/mod.rs")];
    let near = all.iter().filter(|file| files.iter().any(|name| file.ends_with(name)));
    own.iter().chain(near).chain(&all).find_map(|file| {
        let text = std::fs::read_to_string(file).unwrap();
        KINDS.iter().find_map(|kind| {
            let start = text.match_indices(&format!("pub {kind} {name}")).find(|(at, found)| {
                !text[at + found.len()..].starts_with(|next: char| next.is_alphanumeric() || next == '_')
            });
            start.map(|(at, _)| docs_before(&text[..at])).filter(|docs| !docs.is_empty())
        })
    })
}

fn folder(crate_name: &str) -> PathBuf {
    repository().join("engine").join(crate_name.trim_start_matches("raxel_").replace('_', "-"))
}

/// The Rust files of a folder, in order of name.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for entry in entries {
        if entry.is_dir() {
            files.extend(sources(&entry));
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            files.push(entry);
        }
    }
    files
}

/// The first sentence, with the names of its links as code.
fn sentence(docs: &str) -> String {
    let first = docs.split_once(". ").map_or(docs, |(first, _)| first).trim_end_matches('.');
    let mut text = String::new();
    let mut rest = first;
    while let Some((before, link)) = rest.split_once('[') {
        let (name, after) = link.split_once(']').unwrap();
        text += before;
        text += name;
        rest = after.strip_prefix('(').and_then(|target| target.split_once(')')).map_or(after, |(_, after)| after);
    }
    text + rest + "."
}
