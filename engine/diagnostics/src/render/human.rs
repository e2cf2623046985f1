//! For people: the lines that the labels point at, in the form of rustc.

use std::fmt::Write as _;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet};

use super::extent::{MOST_PARTS, shown};
use super::position::{inside, position};
use super::short::{escaped, one_line};
use crate::{Diagnostic, Label, Severity, SourceMap};

/// Longest part of a line that is shown, in bytes: a file may be one line of megabytes.
const MAX_LINE: usize = 400;
/// Most bytes between two marks that are shown in one piece of source, with the lines between them.
const MAX_GAP: usize = 4000;

/// For people: message, the lines of source that the labels point at, notes, help. `color` writes ANSI escape codes.
pub fn human(diagnostics: &[Diagnostic], texts: &SourceMap, color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut out = String::new();
    let (shown, more) = shown(diagnostics);
    for diagnostic in shown {
        if !out.is_empty() {
            out.push('\n');
        }
        out.push_str(&renderer.render(&groups(diagnostic, texts)));
        out.push('\n');
    }
    if let Some(more) = more {
        let _ = write!(out, "\n{more}\n");
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
    let labels = &diagnostic.labels[..diagnostic.labels.len().min(MOST_PARTS)];
    let mut files: Vec<&str> = Vec::new();
    for label in labels {
        if !files.contains(&&*label.span.file) {
            files.push(&label.span.file);
        }
    }
    for file in files {
        main = main.elements(file_elements(file, labels, texts));
    }
    main = main.elements(diagnostic.notes.iter().take(MOST_PARTS).map(|note| Level::NOTE.message(one_line(note))));
    let help = diagnostic
        .help
        .iter()
        .take(MOST_PARTS)
        .map(|help| Group::with_title(Level::HELP.secondary_title(one_line(help))));
    std::iter::once(main).chain(help).collect()
}

/// The part that shows one file: its lines with the labels on them, or its name when the text is not at hand.
fn file_elements<'t>(file: &'t str, labels: &'t [Label], texts: &'t SourceMap) -> Vec<Element<'t>> {
    let of_file = || labels.iter().enumerate().filter(|(_, label)| &*label.span.file == file);
    let Some(text) = texts.get(file).filter(|text| !text.is_empty()) else {
        let notes = of_file().filter(|(_, label)| !label.text.is_empty());
        return std::iter::once(Element::from(Origin::path(escaped(file))))
            .chain(notes.map(|(_, label)| Level::NOTE.message(one_line(&label.text)).into()))
            .collect();
    };
    let mut marks: Vec<Mark<'t>> = of_file()
        .map(|(index, label)| {
            let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
            Mark { range: on_one_line(text, &label.span.range), kind, label }
        })
        .collect();
    marks.sort_by_key(|mark| mark.range.start);
    let mut pieces: Vec<Vec<Mark<'t>>> = Vec::new();
    for mark in marks {
        match pieces.last_mut() {
            Some(piece) if is_near(text, &piece[piece.len() - 1].range, &mark.range) => piece.push(mark),
            _ => pieces.push(vec![mark]),
        }
    }
    // The piece with the primary label comes first.
    pieces.sort_by_key(|piece| !piece.iter().any(|mark| mark.kind == AnnotationKind::Primary));
    pieces.into_iter().flat_map(|piece| snippet(file, text, piece)).collect()
}

/// A label and the range that is marked for it.
struct Mark<'t> {
    range: Range<usize>,
    kind: AnnotationKind,
    label: &'t Label,
}

/// Whether two marks go into one piece of source: close to each other, and no long line from the one to the other.
fn is_near(text: &str, first: &Range<usize>, second: &Range<usize>) -> bool {
    if second.start.saturating_sub(first.start) > MAX_GAP {
        return false;
    }
    let between = inside(text, &(first.start.saturating_sub(MAX_LINE)..second.end + MAX_LINE));
    first == second || text[between].split('\n').all(|line| line.len() <= MAX_LINE)
}

/// The lines of some marks that are near each other, cut where they are long.
fn snippet<'t>(file: &'t str, text: &'t str, marks: Vec<Mark<'t>>) -> Vec<Element<'t>> {
    let first = marks.iter().map(|mark| mark.range.start).min().unwrap_or(0);
    let last = marks.iter().map(|mark| mark.range.end).max().unwrap_or(0);
    let window = inside(text, &(first.saturating_sub(MAX_LINE)..last.saturating_add(MAX_LINE)));
    let start = text[window.start..first].rfind('\n').map_or(window.start, |at| window.start + at + 1);
    let end = text[last..window.end].find('\n').map_or(window.end, |at| last + at);
    let line = text[..start].bytes().filter(|byte| *byte == b'\n').count() + 1;
    let is_cut = start > 0 && !text[..start].ends_with('\n');
    let named = marks.iter().find(|mark| mark.kind == AnnotationKind::Primary).or(marks.first());
    let place = named.map(|mark| position(text, mark.range.start)).filter(|_| is_cut);
    let snippet = Snippet::source(&text[start..end]).line_start(line).annotations(marks.into_iter().map(|mark| {
        let text = Some(one_line(&mark.label.text)).filter(|text| !text.is_empty());
        mark.kind.span(mark.range.start - start..mark.range.end - start).label(text)
    }));
    match place {
        // The renderer would count columns from the cut.
        Some(place) => {
            vec![Origin::path(escaped(file)).line(place.line).char_column(place.column).into(), snippet.into()]
        }
        None => vec![snippet.path(escaped(file)).into()],
    }
}

/// The range on character boundaries, cut at the end of its first line: a mark beside many lines says less than one below a word.
fn on_one_line(text: &str, range: &Range<usize>) -> Range<usize> {
    let range = inside(text, range);
    let content = &text[range.clone()];
    let length = content.find('\n').map_or(content.len(), |at| content[..at].trim_end_matches('\r').len());
    let length = inside(content, &(0..length.min(MAX_LINE))).end.min(length);
    range.start..range.start + length
}
