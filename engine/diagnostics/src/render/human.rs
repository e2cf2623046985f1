//! For people: the lines that the labels point at, in the form of rustc.

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet};

use super::position::inside;
use super::short::one_line;
use crate::{Diagnostic, Label, Severity, SourceMap};

/// Longest part of a line that is shown, in bytes: a file may be one line of megabytes.
const MAX_LINE: usize = 400;

/// For people: message, the lines of source that the labels point at, notes, help. `color` writes ANSI escape codes.
pub fn human(diagnostics: &[Diagnostic], texts: &SourceMap, color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut out = String::new();
    for diagnostic in diagnostics {
        if !out.is_empty() {
            out.push('\n');
        }
        out.push_str(&renderer.render(&groups(diagnostic, texts)));
        out.push('\n');
    }
    out
}

fn groups<'t>(diagnostic: &'t Diagnostic, texts: &'t SourceMap) -> Vec<Group<'t>> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(one_line(&diagnostic.message)).id(diagnostic.code.as_str());
    let mut main = Group::with_title(title);
    let mut files: Vec<&str> = Vec::new();
    for label in &diagnostic.labels {
        if !files.contains(&&*label.span.file) {
            files.push(&label.span.file);
        }
    }
    for file in files {
        main = main.elements(file_elements(file, &diagnostic.labels, texts));
    }
    main = main.elements(diagnostic.notes.iter().map(|note| Level::NOTE.message(one_line(note))));
    let help = diagnostic.help.iter().map(|help| Group::with_title(Level::HELP.secondary_title(one_line(help))));
    std::iter::once(main).chain(help).collect()
}

/// What is shown of one file: its lines with the labels on them, or its name when the text is not at hand.
fn file_elements<'t>(file: &'t str, labels: &'t [Label], texts: &'t SourceMap) -> Vec<Element<'t>> {
    let of_file = || labels.iter().enumerate().filter(|(_, label)| &*label.span.file == file);
    let Some(text) = texts.get(file).filter(|text| !text.is_empty()) else {
        let notes = of_file().filter(|(_, label)| !label.text.is_empty());
        return std::iter::once(Element::from(Origin::path(one_line(file))))
            .chain(notes.map(|(_, label)| Level::NOTE.message(one_line(&label.text)).into()))
            .collect();
    };
    let marks: Vec<(Range<usize>, AnnotationKind, &Label)> = of_file()
        .map(|(index, label)| {
            let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
            (on_one_line(text, &label.span.range), kind, label)
        })
        .collect();
    // Only the lines between the first and the last mark are handed on: files may be large.
    let first = marks.iter().map(|(range, ..)| range.start).min().unwrap_or(0);
    let last = marks.iter().map(|(range, ..)| range.end).max().unwrap_or(0);
    let mut start = text[..first].rfind('\n').map_or(0, |at| at + 1);
    let mut end = text[last..].find('\n').map_or(text.len(), |at| last + at);
    if !text[start..end].contains('\n') {
        start = start.max(inside(text, &(first.saturating_sub(MAX_LINE)..first)).start);
        end = end.min(inside(text, &(last..last + MAX_LINE)).end);
    }
    let line = text[..start].bytes().filter(|byte| *byte == b'\n').count() + 1;
    let snippet = Snippet::source(&text[start..end]).line_start(line).path(one_line(file)).annotations(
        marks.into_iter().map(|(range, kind, label)| {
            let text = Some(one_line(&label.text)).filter(|text| !text.is_empty());
            kind.span(range.start - start..range.end - start).label(text)
        }),
    );
    vec![snippet.into()]
}

/// The range on character boundaries, cut at the end of its first line: a mark beside many lines says less than one below a word.
fn on_one_line(text: &str, range: &Range<usize>) -> Range<usize> {
    let range = inside(text, range);
    let content = &text[range.clone()];
    let length = content.find('\n').map_or(content.len(), |at| content[..at].trim_end_matches('\r').len());
    let length = inside(content, &(0..length.min(MAX_LINE))).end.min(length);
    range.start..range.start + length
}
