//! Diagnostics as text.

use crate::{Diagnostic, SourceMap};

/// For people: with the lines of source that the labels point at.
pub fn human(diagnostics: &[Diagnostic], _texts: &SourceMap, _color: bool) -> String {
    diagnostics.iter().map(|d| format!("{}: {} {:?} {:?} {:?}\n", d.code, d.message, d.labels, d.notes, d.help)).collect()
}
