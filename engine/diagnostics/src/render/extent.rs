//! Limits on printed diagnostics: a file can hold a hundred thousand mistakes, or one mistake in a word of megabytes.

use std::borrow::Cow;

use super::position::inside;
use crate::names::grouped;
use crate::{Diagnostic, Severity};

/// Most diagnostics that are shown at once.
pub const MOST: usize = 20;
/// Most labels, notes and pieces of advice that are shown of one diagnostic.
pub(super) const MOST_PARTS: usize = 40;
/// Longest word, and longest text, that is shown, in bytes.
const MAX_WORD: usize = 200;
const MAX_TEXT: usize = 2000;

/// How many diagnostics are not shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct More {
    pub errors: usize,
    pub warnings: usize,
}

impl More {
    pub(crate) fn count(self) -> usize {
        self.errors + self.warnings
    }
}

impl std::fmt::Display for More {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kinds = match (self.errors, self.warnings) {
            (_, 0) => "errors",
            (0, _) => "warnings",
            _ => "errors and warnings",
        };
        write!(f, "and {} more {kinds}", grouped(self.count()))
    }
}

/// The diagnostics that are shown, in their order, and how many are not, if any. Errors go before warnings.
pub(super) fn shown(diagnostics: &[Diagnostic]) -> (Vec<&Diagnostic>, Option<More>) {
    if diagnostics.len() <= MOST {
        return (diagnostics.iter().collect(), None);
    }
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
    let of_each = |severity| if severity == Severity::Error { errors.min(MOST) } else { MOST.saturating_sub(errors) };
    let mut left = [of_each(Severity::Error), of_each(Severity::Warning)];
    let mut shown = Vec::with_capacity(MOST);
    for diagnostic in diagnostics {
        let left = &mut left[usize::from(!diagnostic.is_error())];
        if *left > 0 {
            *left -= 1;
            shown.push(diagnostic);
        }
    }
    let shown_errors = errors.min(MOST);
    let warnings = diagnostics.len() - errors - (shown.len() - shown_errors);
    (shown, Some(More { errors: errors - shown_errors, warnings }))
}

/// A word of at most `most` bytes: a longer one is cut in the middle.
pub(crate) fn brief(word: &str, most: usize) -> Cow<'_, str> {
    if word.len() <= most {
        return Cow::Borrowed(word);
    }
    let start = inside(word, &(0..most * 2 / 3));
    let end = inside(word, &(word.len() - most / 4..word.len()));
    Cow::Owned(format!("{}…{}", &word[start], &word[end]))
}

/// A text with its long words cut, and with its end cut when it is long all the same.
pub(super) fn brief_text(text: &str) -> Cow<'_, str> {
    if text.len() <= MAX_WORD {
        return Cow::Borrowed(text);
    }
    let mut out = String::new();
    for word in text.split_inclusive(char::is_whitespace) {
        if out.len() + word.len().min(MAX_WORD) > MAX_TEXT {
            out.push('…');
            break;
        }
        out.push_str(&brief(word, MAX_WORD));
    }
    Cow::Owned(out)
}
