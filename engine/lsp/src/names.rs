//! Names in a project's files, and the places that declare them.

use std::ops::Range;
use std::path::Path;

use lsp_types::Location;

use super::documents::{Document, Documents, range};
use super::indexed_text::{IndexedText, NamePlace};
use super::project_texts::{ProjectText, declared_in, graphs, library_name, shader, shader_of_pass, worlds};
use super::scopes::{Local, local_at};
use super::toml_place::{header_at, quoted};
use super::{address, library_files, member_access};

/// The tables of a graph that declare a name: `targets`, `buffers`, `params`, …
pub(super) fn declared<'t>(text: &'t str, kind: &str) -> Vec<(&'t str, Range<usize>)> {
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

/// Names of passes, loops and other tables with `name = "…"` under `[[kind]]`.
pub(super) fn named_passes(text: &str) -> Vec<(&str, Range<usize>)> {
    let mut found = Vec::new();
    let (mut start, mut in_pass) = (0, false);
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        if trimmed.starts_with('[') {
            in_pass = trimmed.starts_with("[[passes]]");
        } else if let Some(value) = trimmed.strip_prefix("name").map(str::trim_start).filter(|_| in_pass)
            && let Some(name) = value.strip_prefix('=').and_then(quoted)
        {
            let at = start + line.find(&['"', '\''][..]).map_or(0, |at| at + 1);
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

/// The name in a header of a table, or else the word, at a byte of a TOML file.
pub(super) fn named_at(text: &str, at: usize) -> &str {
    let is_separator = |c: char| "[].\"'".contains(c) || c.is_whitespace();
    if header_at(text, at).is_none() {
        return word(text, at);
    }
    let start = text[..at].trim_end_matches(|c| !is_separator(c)).len();
    let end = text[at..].find(is_separator).map_or(text.len(), |end| at + end);
    &text[start..end]
}

/// The expression in front of the dot of the member that is typed at a byte of a shader: `push` in `push.ex`.
pub(super) fn owner(text: &str, at: usize) -> Option<&str> {
    let name = |c: char| c.is_alphanumeric() || c == '_';
    let before = text[..at].trim_end_matches(name).strip_suffix('.')?;
    let owner = &before[before.trim_end_matches(name).len()..];
    // A number has a dot, too.
    owner.starts_with(|c: char| c.is_alphabetic() || c == '_').then_some(owner)
}

/// The name of a resource, param or clock in a value: `hit` in `target.hit.size`.
pub(super) fn bare(word: &str) -> &str {
    let prefixes = ["param.", "target.", "buffer.", "clock.", "material."];
    let rest = prefixes.iter().find_map(|prefix| word.strip_prefix(prefix));
    rest.map_or(word, |rest| rest.split('.').next().unwrap_or(rest))
}

/// Tables whose names other keys refer to.
const TABLES: [&str; 8] = ["targets", "buffers", "params", "clocks", "blocks", "loops", "materials", "models"];

/// Where a text declares a name: a table of any kind, a pass, or a key of `[materials]` or `[models]`.
pub(super) fn declaration(text: &str, name: &str) -> Option<Range<usize>> {
    let tables = TABLES.iter().flat_map(|kind| declared(text, kind)).chain(named_passes(text));
    let keys = ["materials", "models"].into_iter().flat_map(|table| keys_of(text, table));
    tables.chain(keys).find(|(declared, _)| *declared == name).map(|(_, place)| place)
}

/// Keys of the lines under a header `[table]`.
pub(super) fn keys_of<'t>(text: &'t str, table: &str) -> Vec<(&'t str, Range<usize>)> {
    let mut found = Vec::new();
    let (mut start, mut inside) = (0, false);
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        if trimmed.starts_with('[') {
            inside = trimmed
                .strip_prefix('[')
                .and_then(|rest| rest.strip_prefix(table))
                .is_some_and(|rest| rest.starts_with(']'));
        } else if let Some((key, _)) = line.split_once('=').filter(|_| inside && !trimmed.starts_with('#')) {
            let name = key.trim().trim_matches(['"', '\'']);
            let at = start + line.find(name).unwrap_or(0);
            found.push((name, at..at + name.len()));
        }
        start += line.len();
    }
    found
}

/// The declaration of the word under the cursor: the table of a name, also of an inherited one; the declaration of a shader's name; the file of
/// a shader, graph, world or include. A file of the library that the project does not have is in the user's cache.
pub(super) fn definition(documents: &Documents, document: &Document, at: usize) -> Option<Location> {
    let found = if document.is_toml() { named_at(&document.text, at) } else { word(&document.text, at) };
    let inside = |text: &ProjectText, bytes: &Range<usize>| {
        let of_library = || library_files::on_disk(library_name(&text.path));
        let file = if text.on_disk { document.project.on_disk(&text.path) } else { of_library()? };
        let uri = address(&file)?;
        Some(Location { uri, range: range(&text.text, bytes) })
    };
    let in_shaders = |texts: &[ProjectText], name: &str| {
        let declared = declared_in(texts).find(|(_, declared)| declared.name == name);
        declared.and_then(|(text, declared)| inside(text, &declared.place))
    };
    if document.is_toml() {
        let texts = graphs(documents, document).into_iter().chain(worlds(documents, document));
        let name = bare(found);
        let place = texts.map(|text| (declaration(&text.text, name), text)).find(|(place, _)| place.is_some());
        if let Some((Some(place), text)) = place {
            return inside(&text, &place);
        }
        let shader = shader_of_pass(documents, document, at);
        if let Some(place) = in_shaders(&shader, found) {
            return Some(place);
        }
    } else if let Some(local) = local_under(&document.text, at) {
        let uri = address(&document.project.on_disk(&document.path))?;
        return Some(Location { uri, range: range(&document.text, &local.place) });
    } else {
        let texts = shader(documents, document, &document.path);
        if let Some(member) = member_access::under(document, &texts, at) {
            return member.declared.and_then(|(text, place)| inside(text, &place));
        }
        // No name behind a dot is declared elsewhere; that of an included file may have dots.
        let is_member = member_access::is_behind_dot(&document.text, at);
        if let Some(place) = in_shaders(&texts, identifier(&document.text, at)).filter(|_| !is_member) {
            return Some(place);
        }
    }
    // A file: relative to its own folder, or to that of its kind.
    let folder = Path::new(&document.path).parent().unwrap_or(Path::new(""));
    let places = [folder.to_owned(), "shaders".into(), "shaders/include".into(), "graphs".into(), "worlds".into()];
    let mut files = places.iter().map(|folder| document.project.root().join(folder).join(found));
    let file = files.find(|file| file.is_file()).or_else(|| library_files::on_disk(found))?;
    Some(Location { uri: address(&file)?, range: lsp_types::Range::default() })
}

/// The local or parameter that the name at a byte of a shader means.
pub(super) fn local_under(text: &IndexedText, at: usize) -> Option<&Local> {
    let name = identifier(text, at);
    let under = |found: &&NamePlace| found.place.contains(&at) || found.place.end == at;
    let found = text.places(name).iter().find(under).filter(|found| !found.is_member && !found.in_directive)?;
    local_at(text.locals(), name, found.place.start)
}

/// The identifier at a byte of a shader.
pub(super) fn identifier(text: &str, at: usize) -> &str {
    let inside = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let start = text[..at].trim_end_matches(inside).len();
    let end = text[at..].find(|c| !inside(c)).map_or(text.len(), |end| at + end);
    &text[start..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_owner_of_a_member_is_the_name_before_its_dot() {
        for (text, found) in [("a.b.", Some("b")), ("1.", None), ("push", None), (".", None), ("é.x", Some("é"))] {
            assert_eq!(owner(text, text.len()), found, "{text}");
        }
    }

    #[test]
    fn names_in_values_and_keys_of_tables() {
        for (word, name) in
            [("target.hit.size", "hit"), ("param.sun", "sun"), ("camera.fov", "camera.fov"), ("hit", "hit")]
        {
            assert_eq!(bare(word), name);
        }
        let text = "[materials]\nred = { albedo = \"#f00\" }\n# old = 1\n\"b\" = {}\n[materials.c]\n[build]\nno = 1\n";
        let names: Vec<&str> = keys_of(text, "materials").into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["red", "b"]);
        assert_eq!(declaration(text, "c").map(|place| &text[place]), Some("c"));
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
