//! One JSON object a line and diagnostic, in the manner of cargo's `--message-format=json`.

use serde::Serialize;

use super::human::human;
use super::position::position;
use crate::{Diagnostic, SourceMap};

#[derive(Serialize)]
struct Line<'d> {
    /// Always `diagnostic`: other lines of the same stream have other reasons.
    reason: &'static str,
    code: &'static str,
    severity: crate::Severity,
    message: &'d str,
    spans: Vec<Place<'d>>,
    notes: &'d [String],
    help: &'d [String],
    /// What `human` would print, without colour.
    rendered: String,
}

#[derive(Serialize)]
struct Place<'d> {
    file: &'d str,
    /// From 1; 0 when the text is not at hand. Columns count characters.
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    byte_start: usize,
    byte_end: usize,
    label: &'d str,
    primary: bool,
}

/// One JSON object a line and diagnostic.
pub fn json(diagnostics: &[Diagnostic], texts: &SourceMap) -> String {
    let mut out = String::new();
    for diagnostic in diagnostics {
        let spans = diagnostic.labels.iter().enumerate().map(|(index, label)| {
            let range = &label.span.range;
            let at = |offset| texts.get(&label.span.file).map(|text| position(text, offset));
            let (start, end) = (at(range.start), at(range.end.max(range.start)));
            Place {
                file: &label.span.file,
                line: start.map_or(0, |start| start.line),
                column: start.map_or(0, |start| start.column),
                end_line: end.map_or(0, |end| end.line),
                end_column: end.map_or(0, |end| end.column),
                byte_start: range.start,
                byte_end: range.end,
                label: &label.text,
                primary: index == 0,
            }
        });
        let line = Line {
            reason: "diagnostic",
            code: diagnostic.code.as_str(),
            severity: diagnostic.severity,
            message: &diagnostic.message,
            spans: spans.collect(),
            notes: &diagnostic.notes,
            help: &diagnostic.help,
            rendered: human(std::slice::from_ref(diagnostic), texts, false),
        };
        // Strings, numbers and lists have no way to fail.
        out.push_str(&serde_json::to_string(&line).unwrap_or_default());
        out.push('\n');
    }
    out
}
