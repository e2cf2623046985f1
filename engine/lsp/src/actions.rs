//! Fixes of diagnostics: the word that "did you mean" names takes the place of the wrong one, an entry without a use is removed, and a binding or
//! member that is given nothing is given something.

use std::collections::HashMap;
use std::ops::Range;

use lsp_types::{CodeAction, CodeActionKind, CodeActionParams, Diagnostic, NumberOrString, TextEdit, WorkspaceEdit};

use super::documents::{Document, Documents, offset, range};
use super::names::declared;
use super::project_texts::{graphs, pass_at};
use super::toml_names::{TomlWord, entries, words};

/// Codes of entries that the shader does not use: a member, a block, a binding.
const UNUSED: [&str; 3] = ["RX0111", "RX0118", "RX0121"];
/// The code of a member without a value.
const MEMBER_MISSING: &str = "RX0110";
/// The code of a binding that is bound to nothing.
const UNBOUND: &str = "RX0120";

/// The fixes of the diagnostics that an editor asks about.
pub(super) fn actions(documents: &Documents, document: &Document, params: &CodeActionParams) -> Vec<CodeAction> {
    let mut found = Vec::new();
    for diagnostic in params.context.diagnostics.iter().filter(|found| found.source.as_deref() == Some("raxel")) {
        let code = match &diagnostic.code {
            Some(NumberOrString::String(code)) => code.as_str(),
            _ => "",
        };
        let at = offset(&document.text, diagnostic.range.start);
        let text: &str = &document.text;
        let meant = meant(text, diagnostic);
        let is_preferred = meant.is_some();
        let removed = || UNUSED.contains(&code).then(|| removed(text, at)).flatten();
        let given = || given(documents, document, at, code, &diagnostic.message);
        for (title, place, new_text) in meant.into_iter().chain(removed()).chain(given()) {
            let edit = TextEdit { range: range(text, &place), new_text };
            #[allow(clippy::mutable_key_type, reason = "addresses are not changed while they are keys")]
            let changes = HashMap::from([(params.text_document.uri.clone(), vec![edit])]);
            found.push(CodeAction {
                title,
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: Some(vec![diagnostic.clone()]),
                edit: Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }),
                is_preferred: Some(is_preferred),
                ..CodeAction::default()
            });
        }
    }
    found
}

/// A title, what is replaced, and by what.
type Fix = (String, Range<usize>, String);

/// Puts the word that "did you mean" names in the place of the wrong one.
fn meant(text: &str, diagnostic: &Diagnostic) -> Option<Fix> {
    let meant = diagnostic.message.split("did you mean `").nth(1)?.split('`').next()?;
    let bytes = offset(text, diagnostic.range.start)..offset(text, diagnostic.range.end);
    let wrong = text.get(bytes.clone())?;
    let quote =
        wrong.chars().next().filter(|first| ['"', '\''].contains(first) && wrong.len() > 1 && wrong.ends_with(*first));
    let inner = quote.map_or(wrong, |quote| wrong.trim_matches(quote));
    // A file is named by its path in the project, and the message means all that is written.
    let named = diagnostic.message.split('`').nth(1)?;
    let below = inner.trim_start_matches("../");
    let is_file = named.strip_suffix(below).is_some_and(|folder| folder.is_empty() || folder.ends_with('/'));
    if !inner.is_empty() && is_file {
        return Some((format!("Change `{inner}` to `{meant}`"), bytes, wrong.replacen(inner, meant, 1)));
    }
    // The text around the word in a value stays: `param.` in `param.sun`, `@1` behind a target.
    let words_of_message = diagnostic.message.split('`').skip(1).step_by(2);
    let candidates: Vec<&str> = words_of_message.filter(|word| *word != meant && !word.is_empty()).collect();
    let in_value = |value: Range<usize>| {
        let places = candidates.iter().filter_map(|word| place_of_word(&text[value.clone()], word));
        let place = places.max_by_key(Range::len)?;
        Some(value.start + place.start..value.start + place.end)
    };
    let start = bytes.start + wrong.find(inner).unwrap_or(0);
    let place =
        in_value(start..start + inner.len()).or_else(|| values_of_table(text, &bytes).into_iter().find_map(in_value));
    let place = place.unwrap_or(start..start + inner.len());
    let word = &text[place.clone()];
    if word.is_empty() || word.contains('\n') {
        return None;
    }
    Some((format!("Change `{word}` to `{meant}`"), place, meant.to_owned()))
}

/// Where a text has a word, with no letters of a name around it.
fn place_of_word(text: &str, word: &str) -> Option<Range<usize>> {
    let name = |c: char| c == '_' || c == '-' || c.is_alphanumeric();
    let is_whole = |(at, _): &(usize, &str)| !text[..*at].ends_with(name) && !text[at + word.len()..].starts_with(name);
    text.match_indices(word).find(is_whole).map(|(at, word)| at..at + word.len())
}

/// The texts in the table whose name stands at these bytes.
fn values_of_table(text: &str, name: &Range<usize>) -> Vec<Range<usize>> {
    let words = words(text);
    let is_name = |word: &TomlWord| word.is_key && name.contains(&word.place.start);
    let Some(at) = words.iter().position(is_name) else { return Vec::new() };
    let table = &words[at].path;
    // Where the name stands again, the next table of an array begins.
    let inside = words[at + 1..].iter().take_while(|word| !word.is_key || word.path != *table);
    inside.filter(|word| !word.is_key && word.path.starts_with(table)).map(|word| word.place.clone()).collect()
}

/// Removes the entry whose key is at a byte: from an inline table with its comma, else with its line.
fn removed(text: &str, at: usize) -> Option<Fix> {
    let around = entries(text).into_iter().filter(|entry| entry.place.contains(&at));
    let entry = around.min_by_key(|entry| entry.place.len())?;
    let key = entry.path.last()?;
    // Not the value of another key.
    let end_of_key = text[entry.place.clone()].find('=')? + entry.place.start;
    if at > end_of_key {
        return None;
    }
    let (before, behind) = (&text[..entry.place.start], &text[entry.place.end..]);
    let blank = [' ', '\t'];
    let place = if let Some(rest) = behind.trim_start_matches(blank).strip_prefix(',') {
        entry.place.start..text.len() - rest.trim_start_matches(blank).len()
    } else if before.trim_end_matches(blank).ends_with(',') {
        before.trim_end_matches(blank).len() - 1..entry.place.end
    } else if before.trim_end_matches(blank).ends_with('{') {
        entry.place.clone()
    } else {
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        start..behind.find('\n').map_or(text.len(), |end| entry.place.end + end + 1)
    };
    Some((format!("Remove `{key}`"), place, String::new()))
}

/// Gives a binding the resource of its name, and a member the param of its name, or zeros.
fn given(documents: &Documents, document: &Document, at: usize, code: &str, message: &str) -> Option<Fix> {
    let name = message.split('`').nth(1)?;
    let declares = |kind: &str| {
        let graphs = graphs(documents, document);
        graphs.iter().any(|graph| declared(&graph.text, kind).iter().any(|(known, _)| *known == name))
    };
    let (table, value) = match code {
        UNBOUND if declares("targets") || declares("buffers") => ("bind", format!("\"{name}\"")),
        MEMBER_MISSING if message.starts_with("push") => {
            let of_param = || declares("params").then(|| format!("\"param.{name}\""));
            ("push", of_param().or_else(|| zeros(message).map(str::to_owned))?)
        }
        _ => return None,
    };
    let (place, new_text) = insertion(&document.text, at, table, &format!("{} = {value}", quoted(name)))?;
    Some((format!("Add `{} = {value}` to `{table}`", quoted(name)), place, new_text))
}

/// A key as TOML has it.
fn quoted(name: &str) -> String {
    let plain = name.chars().all(|c| c == '_' || c == '-' || c.is_ascii_alphanumeric());
    if plain { name.to_owned() } else { format!("\"{name}\"") }
}

/// Zeros of the type that a message gives as an example: `type = "vec3"`.
fn zeros(message: &str) -> Option<&'static str> {
    let ty = message.split("type = \"").nth(1)?.split('"').next()?;
    Some(match ty {
        "f32" => "0.0",
        "i32" | "u32" => "0",
        "bool" => "false",
        "vec2" => "[0.0, 0.0]",
        "vec3" => "[0.0, 0.0, 0.0]",
        "vec4" => "[0.0, 0.0, 0.0, 0.0]",
        "ivec2" | "uvec2" => "[0, 0]",
        "ivec3" | "uvec3" => "[0, 0, 0]",
        "ivec4" | "uvec4" => "[0, 0, 0, 0]",
        _ => return None,
    })
}

/// Where an entry goes in a table of the pass around a byte: into the inline table, below the header, or as a new inline table.
fn insertion(text: &str, at: usize, table: &str, entry: &str) -> Option<(Range<usize>, String)> {
    let pass = pass_at(text, at)?;
    let is_table = |path: &[String]| path.iter().map(String::as_str).eq(["passes", table]);
    let inline = entries(text).into_iter().find(|entry| is_table(&entry.path) && pass.contains(&entry.place.start));
    if let Some(inline) = inline {
        let close = inline.place.end.checked_sub(1).filter(|close| text[*close..].starts_with('}'))?;
        let inner = text[..close].trim_end();
        return Some(match inner.chars().next_back() {
            Some('{') => (inner.len()..close, format!(" {entry} ")),
            Some(',') => (inner.len()..inner.len(), format!(" {entry}")),
            _ => (inner.len()..inner.len(), format!(", {entry}")),
        });
    }
    let header = words(text).into_iter().find(|word| {
        let line = text[..word.place.start].rfind('\n').map_or(0, |end| end + 1);
        word.is_key && is_table(&word.path) && pass.contains(&word.place.start) && text[line..].starts_with('[')
    });
    let (after, new_text) = match header {
        Some(header) => (header.place.end, format!("{entry}\n")),
        None => (at, format!("{table} = {{ {entry} }}\n")),
    };
    let end = text[after..].find('\n').map(|end| after + end + 1)?;
    Some((end..end, new_text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn applied(text: &str, fix: Option<(Range<usize>, String)>) -> String {
        let (place, new_text) = fix.expect("a fix");
        format!("{}{new_text}{}", &text[..place.start], &text[place.end..])
    }

    #[test]
    fn entries_are_removed_with_their_comma_or_line() {
        for (text, left) in [
            ("bind = { a| = \"x\", b = \"y\" }\n", "bind = { b = \"y\" }\n"),
            ("bind = { a = \"x\", b| = { target = \"y\" } }\n", "bind = { a = \"x\" }\n"),
            ("bind = { |a = \"x\" }\n", "bind = {  }\n"),
            ("[passes.bind]\na = 1\n  |b = [1, # c\n 2] # d\nc = 3\n", "[passes.bind]\na = 1\nc = 3\n"),
            ("push.|a = 1", ""),
        ] {
            let at = text.find('|').unwrap();
            let text = text.replace('|', "");
            let fix = removed(&text, at).map(|(_, place, new_text)| (place, new_text));
            assert_eq!(applied(&text, fix), left);
        }
        assert_eq!(removed("bind = { a = \"xyz\" }", 15), None);
    }

    #[test]
    fn an_entry_goes_where_the_pass_has_its_table() {
        for (pass, filled) in [
            ("bind = { a = \"x\" }\n", "bind = { a = \"x\", b = 1 }\n"),
            ("bind = {}\n", "bind = { b = 1 }\n"),
            ("[passes.bind]\na = \"x\"\n", "[passes.bind]\nb = 1\na = \"x\"\n"),
            ("", "bind = { b = 1 }\n"),
        ] {
            let text = format!("[[passes]]\nname = \"p\"\n{pass}[[passes]]\nname = \"q\"\nbind = {{ c = \"z\" }}\n");
            let expected = text.replacen(&format!("\"p\"\n{pass}"), &format!("\"p\"\n{filled}"), 1);
            assert_eq!(applied(&text, insertion(&text, 20, "bind", "b = 1")), expected);
        }
    }
}
