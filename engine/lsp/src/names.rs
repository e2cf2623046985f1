//! Names in a project's files: what a graph declares, and where.

use std::path::Path;

use lsp_types::Location;
use raxel_diagnostics::DiskFiles;
use raxel_diagnostics::files::{Files, join};

use super::address;
use super::documents::{Document, range};

/// The tables of a graph that declare a name: `targets`, `buffers`, `params`, …
pub(super) fn declared<'t>(text: &'t str, kind: &str) -> Vec<(&'t str, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        let name = (trimmed.strip_prefix('[').and_then(|rest| rest.strip_prefix(kind)))
            .and_then(|rest| rest.strip_prefix('.'))
            .and_then(|rest| rest.split([']', '.']).next());
        if let Some(name) = name.map(|name| name.trim_matches(['"', '\''])).filter(|name| !name.is_empty()) {
            let at = start + line.find(name).unwrap_or(0);
            if found.iter().all(|(known, _)| *known != name) {
                found.push((name, at..at + name.len()));
            }
        }
        start += line.len();
    }
    found
}

/// The texts of the graphs that a demo names, as they are saved, and of those that they extend.
pub(super) fn graphs_of(demo: &Document) -> Vec<String> {
    let Ok(files) = DiskFiles::new(demo.project.root()) else { return Vec::new() };
    let named = |text: &str, key: &str, folder: &str| -> Vec<String> {
        let values = text.lines().filter_map(|line| line.trim().strip_prefix(key)?.trim_start().strip_prefix('='));
        values.filter_map(|value| join(folder, value.split('"').nth(1)?)).collect()
    };
    let mut paths = named(&demo.text, "graph", "graphs");
    let mut texts = Vec::new();
    let mut at = 0;
    while let Some(path) = paths.get(at).cloned() {
        at += 1;
        let Some(text) = files.read(&path).ok().and_then(|bytes| String::from_utf8(bytes.to_vec()).ok()) else {
            continue;
        };
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for base in named(&text, "extends", folder) {
            // Two graphs may share a base, and a broken one may extend itself.
            if !paths.contains(&base) {
                paths.push(base);
            }
        }
        texts.push(text);
    }
    texts
}

/// Names of passes, loops and other tables with `name = "…"` under `[[kind]]`.
pub(super) fn named_passes(text: &str) -> Vec<(&str, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    let (mut start, mut in_pass) = (0, false);
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        if trimmed.starts_with('[') {
            in_pass = trimmed.starts_with("[[passes]]");
        } else if let Some(value) = trimmed.strip_prefix("name").map(str::trim_start).filter(|_| in_pass)
            && let Some(name) = value.strip_prefix('=').and_then(|rest| rest.split('"').nth(1))
        {
            let at = start + line.find(&format!("\"{name}\"")).map_or(0, |at| at + 1);
            found.push((name, at..at + name.len()));
        }
        start += line.len();
    }
    found
}

/// The word at a byte: letters, digits, and what names of files, resources and builtins have besides.
pub(super) fn word(text: &str, at: usize) -> &str {
    let inside = |c: char| c.is_alphanumeric() || "_./-".contains(c);
    let start =
        text[..at].rfind(|c| !inside(c)).map_or(0, |end| end + text[end..].chars().next().map_or(1, char::len_utf8));
    let end = text[at..].find(|c| !inside(c)).map_or(text.len(), |end| at + end);
    &text[start..end]
}

/// What stands in front of the dot of the member that is typed at a byte of a shader: `push` in `push.ex`.
pub(super) fn owner(text: &str, at: usize) -> Option<&str> {
    let name = |c: char| c.is_alphanumeric() || c == '_';
    let before = text[..at].trim_end_matches(name).strip_suffix('.')?;
    let owner = &before[before.trim_end_matches(name).len()..];
    // A number has a dot, too.
    owner.starts_with(|c: char| c.is_alphabetic() || c == '_').then_some(owner)
}

/// The members of the block that a shader knows by a name (`uniform Push { float exposure; } push;`), with their declarations.
pub(super) fn members(text: &str, block: &str) -> Vec<(String, String)> {
    let named = |(at, _): &(usize, &str)| {
        let rest = text[at + 1..].trim_start().strip_prefix(block);
        rest.is_some_and(|rest| rest.trim_start().starts_with([';', '[']))
    };
    let Some((end, _)) = text.match_indices('}').find(named) else { return Vec::new() };
    let Some(start) = text[..end].rfind('{') else { return Vec::new() };
    let code: String = text[start + 1..end].lines().map(|line| line.split("//").next().unwrap_or("")).collect();
    let mut found = Vec::new();
    for declaration in code.split(';').map(str::trim).filter(|declaration| !declaration.is_empty()) {
        // The qualifier of a member has commas of its own.
        let plain = declaration.strip_prefix("layout").and_then(|rest| rest.split_once(')'));
        for part in plain.map_or(declaration, |(_, rest)| rest).split(',') {
            let name = part.split('[').next().unwrap_or(part).split_whitespace().next_back();
            found.extend(name.map(|name| (name.to_owned(), declaration.to_owned())));
        }
    }
    found
}

/// Where what the cursor is on is declared: the table of a name, the file of a shader, graph, world or include.
pub(super) fn definition(document: &Document, at: usize) -> Option<Location> {
    let found = word(&document.text, at);
    let here = |bytes: &std::ops::Range<usize>| {
        Some(Location { uri: address(&document.project.on_disk(&document.path))?, range: range(&document.text, bytes) })
    };
    let name = found.strip_prefix("param.").unwrap_or(found);
    let tables = ["targets", "buffers", "params", "clocks", "blocks", "loops", "materials"];
    for (declared, place) in
        tables.iter().flat_map(|kind| declared(&document.text, kind)).chain(named_passes(&document.text))
    {
        if declared == name {
            return here(&place);
        }
    }
    // A file: relative to its own folder, or to that of its kind.
    let folder = Path::new(&document.path).parent().unwrap_or(Path::new(""));
    let places = [folder.to_owned(), "shaders".into(), "shaders/include".into(), "graphs".into(), "worlds".into()];
    let file =
        places.iter().map(|folder| document.project.root().join(folder).join(found)).find(|file| file.is_file())?;
    Some(Location { uri: address(&file)?, range: lsp_types::Range::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_of_a_block_are_found_by_its_name() {
        let text = "layout(push_constant) uniform Push {\n  float exposure; // in stops; of light\n  layout(offset = 16, row_major) mat4 turn;\n  vec2 a, b[2];\n} push;\n                    buffer List { uint count; } lists[3];\nvoid main() { push.ex";
        let names = |block| members(text, block).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names("push"), ["exposure", "turn", "a", "b"]);
        assert_eq!(names("lists"), ["count"]);
        assert!(names("pus").is_empty() && names("main").is_empty());
        assert_eq!(owner(text, text.len()), Some("push"));
        for (text, found) in [("a.b.", Some("b")), ("1.", None), ("push", None), (".", None), ("é.x", Some("é"))] {
            assert_eq!(owner(text, text.len()), found, "{text}");
        }
    }

    #[test]
    fn declared_names_are_found_in_order_and_once() {
        let text =
            "[targets.color]\nformat = \"r8\"\n[targets.color.display]\n[targets.\"b-2\"]\n[[passes]]\nname = \"p\"\n";
        let names: Vec<&str> = declared(text, "targets").into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["color", "b-2"]);
        let passes = named_passes(text);
        assert_eq!((passes[0].0, &text[passes[0].1.clone()]), ("p", "p"));
        assert_eq!(word("from = \"param.sun_height\"", 12), "param.sun_height");
        assert_eq!(word("é", 0), "é");
    }
}
