//! The diagnostic itself: plain data that names every place involved. Rendering lives in `render`.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use serde::Serialize;

use crate::{Code, codes};

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// raxel builds nothing new; the last good state stays.
    Error,
    /// raxel goes on, but the author should look.
    Warning,
}

/// A place in a file: the path as the project names it (relative, `/` separators) and a byte range of its text.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Span {
    /// Path relative to the project root, with `/` separators.
    pub file: Arc<str>,
    /// Byte range in the file's text. An empty range points at a position.
    pub range: Range<usize>,
}

impl Span {
    /// A place in `file`.
    pub fn new(file: impl Into<Arc<str>>, range: Range<usize>) -> Self {
        Self { file: file.into(), range }
    }
}

/// A value with the place at which it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it is written.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// A value written at `span`.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }

    /// If the value is the path of a file: adds this place to every error about that file missing.
    pub fn point_at_missing(&self, found: &mut [Diagnostic]) {
        for diagnostic in found {
            if diagnostic.code == codes::files::NOT_FOUND && diagnostic.labels.is_empty() {
                *diagnostic = diagnostic.clone().label(self.span.clone(), "named here");
            }
        }
    }
}

/// A place with a few words about it. The first label of a diagnostic is the primary one.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// A few words, e.g. `declared here`. May be empty.
    pub text: String,
}

/// One thing that is wrong, with every place that disagrees.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Diagnostic {
    /// Stable code; `raxel explain CODE` prints its page.
    pub code: Code,
    /// Error or warning.
    pub severity: Severity,
    /// One line, lower case, names in backticks, the two values that disagree.
    pub message: String,
    /// Places; the first is the primary one. Empty when there is no file to point at.
    pub labels: Vec<Label>,
    /// Further facts, e.g. `included from shaders/a.comp:6`.
    pub notes: Vec<String>,
    /// A remedy, e.g. `did you mean `hit`?`.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// An error with no places yet.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: message.into(),
            labels: Vec::new(),
            notes: Vec::new(),
            help: Vec::new(),
        }
    }

    /// A warning with no places yet.
    pub fn warning(code: Code, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// Adds a place. The first one added is the primary one.
    #[must_use]
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds a fact.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Adds advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }

    /// Whether this is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// Removes repeated diagnostics and keeps the order. A file that several passes read reports its mistakes several times.
pub fn each_once(diagnostics: impl IntoIterator<Item = Diagnostic>) -> Vec<Diagnostic> {
    let all: Vec<Diagnostic> = diagnostics.into_iter().collect();
    let mut seen = HashSet::new();
    let first: Vec<bool> = all.iter().map(|diagnostic| seen.insert(diagnostic)).collect();
    all.into_iter().zip(first).filter_map(|(diagnostic, first)| first.then_some(diagnostic)).collect()
}

/// The texts that diagnostics point into: path → text. A file that is not UTF-8 is held with its broken bytes replaced.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    texts: BTreeMap<Arc<str>, Arc<str>>,
}

impl SourceMap {
    /// Remembers the text of a file, replacing an earlier one.
    pub fn insert(&mut self, file: impl Into<Arc<str>>, text: impl Into<Arc<str>>) {
        self.texts.insert(file.into(), text.into());
    }

    /// The text of a file.
    pub fn get(&self, file: &str) -> Option<&Arc<str>> {
        self.texts.get(file)
    }

    /// All files in order of their path.
    pub fn iter(&self) -> impl Iterator<Item = (&Arc<str>, &Arc<str>)> {
        self.texts.iter()
    }

    /// Takes over every text of `other`.
    pub fn extend(&mut self, other: &SourceMap) {
        for (file, text) in other.iter() {
            self.texts.insert(file.clone(), text.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Diagnostic, Span, each_once};
    use crate::codes::files;

    #[test]
    fn says_everything_once() {
        let at = |start| Diagnostic::error(files::BAD_VALUE, "m").label(Span::new("f", start..9), "");
        assert_eq!(each_once([at(1), at(2), at(1)]), [at(1), at(2)]);
    }
}
