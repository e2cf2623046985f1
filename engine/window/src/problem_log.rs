//! Diagnostics and prints for the panel of problems: as the terminal has them, each with its place as text.

use raxel_diagnostics::{Diagnostic, Severity, SourceMap, render};
use raxel_execute::PassPrints;
use raxel_panels::view::Problem;
use raxel_terminal::prints::lines;

/// The diagnostics as the panel shows them.
pub(crate) fn problems(diagnostics: &[Diagnostic], texts: &SourceMap) -> Vec<Problem> {
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

/// Lines of one pass that the panel shows.
const LINES: usize = 20;

/// Prints of passes, as the panel shows them below the mistakes.
pub(crate) fn prints(printed: &[PassPrints]) -> Vec<Problem> {
    let problem = |prints: &PassPrints| {
        let place = prints.lines.first().and_then(|line| line.place.as_ref());
        let mut shown = lines(prints);
        let more = shown.len().saturating_sub(LINES);
        shown.truncate(LINES);
        shown.extend((more > 0).then(|| format!("and {more} lines more, in the terminal")));
        Problem {
            error: false,
            place: place.map(|(file, line)| format!("{file}:{line}")),
            title: format!("printed by pass `{}` in frame {}", prints.pass, prints.frame),
            text: shown.join("\n"),
        }
    };
    printed.iter().map(problem).collect()
}
