//! One JSON object a line and diagnostic, in the manner of cargo's `--message-format=json`.

use std::borrow::Cow;

use serde::Serialize;

use super::extent::{MOST_PARTS, More, brief_text, shown};
use super::human::human;
use super::position::position;
use crate::{Diagnostic, SourceMap};

#[derive(Serialize)]
struct Line<'d> {
    /// Always `diagnostic`: other lines of the same stream have other reasons.
    reason: &'static str,
    code: &'static str,
    severity: crate::Severity,
    message: Cow<'d, str>,
    spans: Vec<Place<'d>>,
    notes: Vec<String>,
    help: Vec<String>,
    /// The text that `human` would print, without colour.
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
    label: Cow<'d, str>,
    primary: bool,
}

/// The last line if some diagnostics are left out: their number.
#[derive(Serialize)]
struct Omitted {
    reason: &'static str,
    errors: usize,
    warnings: usize,
}

/// One JSON object a line and diagnostic.
pub fn json(diagnostics: &[Diagnostic], texts: &SourceMap) -> String {
    let mut out = String::new();
    let (shown, more) = shown(diagnostics);
    for diagnostic in shown {
        let texts_of =
            |parts: &[String]| parts.iter().take(MOST_PARTS).map(|part| brief_text(part).into_owned()).collect();
        let spans = diagnostic.labels.iter().take(MOST_PARTS).enumerate().map(|(index, label)| {
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
                label: brief_text(&label.text),
                primary: index == 0,
            }
        });
        let line = Line {
            reason: "diagnostic",
            code: diagnostic.code.as_str(),
            severity: diagnostic.severity,
            message: brief_text(&diagnostic.message),
            spans: spans.collect(),
            notes: texts_of(&diagnostic.notes),
            help: texts_of(&diagnostic.help),
            rendered: human(std::slice::from_ref(diagnostic), texts, false),
        };
        // Strings, numbers and lists have no way to fail.
        out.push_str(&serde_json::to_string(&line).unwrap_or_default());
        out.push('\n');
    }
    if let Some(More { errors, warnings }) = more {
        let line = Omitted { reason: "more-diagnostics", errors, warnings };
        out.push_str(&serde_json::to_string(&line).unwrap_or_default());
        out.push('\n');
    }
    out
}
