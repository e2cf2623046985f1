//! One line a diagnostic: `path:line:col: error[RX0113]: message`.

use std::fmt::Write as _;

use super::extent::{brief_text, shown};
use super::position::position;
use crate::{Diagnostic, Severity, SourceMap};

/// One line a diagnostic, in the form that editors and grep understand. The place is left out when there is none, and line and
/// column when the text is not at hand.
pub fn short(diagnostics: &[Diagnostic], texts: &SourceMap) -> String {
    let mut out = String::new();
    let (shown, more) = shown(diagnostics);
    for diagnostic in shown {
        if let Some(label) = diagnostic.labels.first() {
            out.push_str(&escaped(&label.span.file));
            if let Some(text) = texts.get(&label.span.file) {
                let at = position(text, label.span.range.start);
                let _ = write!(out, ":{}:{}", at.line, at.column);
            }
            out.push_str(": ");
        }
        let _ = writeln!(
            out,
            "{}[{}]: {}",
            severity_name(diagnostic.severity),
            diagnostic.code,
            one_line(&diagnostic.message)
        );
    }
    if let Some(more) = more {
        let _ = writeln!(out, "{more}");
    }
    out
}

pub(super) fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

/// The text with control characters written out, and cut where it is long: a file name or a message may quote anything.
pub(super) fn one_line(text: &str) -> String {
    escaped(&brief_text(text))
}

/// The text with control characters written out, however long: of a path each character counts.
pub(super) fn escaped(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        if c.is_control() {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
        out
    })
}
