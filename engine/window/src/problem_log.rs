//! Diagnostics for the panel of problems: as the terminal has them, each with its place as text.

use raxel_diagnostics::{Diagnostic, Severity, SourceMap, render};
use raxel_panels::view::Problem;

/// The diagnostics as the panel shows them.
pub fn problems(diagnostics: &[Diagnostic], texts: &SourceMap) -> Vec<Problem> {
    let problem = |diagnostic: &Diagnostic| Problem {
        error: diagnostic.severity == Severity::Error,
        place: diagnostic.labels.first().map(|label| match texts.get(&label.span.file) {
            Some(text) => {
                let at = render::position(text, label.span.range.start);
                format!("{}:{}:{}", label.span.file, at.line, at.column)
            }
            None => label.span.file.to_string(),
        }),
        title: format!("{}: {}", diagnostic.code, diagnostic.message.lines().next().unwrap_or_default()),
        text: render::human(std::slice::from_ref(diagnostic), texts, false).trim_end().to_owned(),
    };
    diagnostics.iter().map(problem).collect()
}
