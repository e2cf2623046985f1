//! Promises that hold for every reader of text: errors are there, are in the text, and can be printed.

use raxel_diagnostics::{Diagnostic, SourceMap, render};

/// The result of a reader of project files.
pub(crate) type Outcome<T> = Result<(T, Vec<Diagnostic>), Vec<Diagnostic>>;

/// Checks the diagnostics, and returns the value if there is one.
pub(crate) fn outcome<T>(outcome: Outcome<T>, texts: &SourceMap) -> Option<T> {
    match outcome {
        Ok((value, warnings)) => {
            assert!(!warnings.iter().any(Diagnostic::is_error), "a value in spite of an error: {warnings:?}");
            diagnostics(&warnings, texts);
            Some(value)
        }
        Err(found) => {
            assert!(found.iter().any(Diagnostic::is_error), "refused without an error: {found:?}");
            diagnostics(&found, texts);
            None
        }
    }
}

/// Every diagnostic has a message and lies in a text, and each form of output takes it.
pub(crate) fn diagnostics(found: &[Diagnostic], texts: &SourceMap) {
    for diagnostic in found {
        let Diagnostic { message, labels, .. } = diagnostic;
        assert!(!message.trim().is_empty(), "{diagnostic:?} says nothing");
        for label in labels {
            let text = texts.get(&label.span.file).unwrap_or_else(|| panic!("no text for {diagnostic:?}"));
            assert!(text.get(label.span.range.clone()).is_some(), "{diagnostic:?} points outside of its text");
        }
    }
    let json = render::json(found, texts);
    for line in json.lines() {
        let parsed: Result<serde_json::Value, _> = serde_json::from_str(line);
        assert!(parsed.is_ok_and(|value| value.is_object()), "no JSON object: {line}");
    }
    assert_eq!(json.is_empty(), found.is_empty());
    for text in [render::human(found, texts, false), render::short(found, texts)] {
        assert_eq!(text.is_empty(), found.is_empty());
        let control = |c: char| c.is_control() && !matches!(c, '\n' | '\t' | '\r');
        assert!(!text.contains(control), "control characters reach the terminal: {text:?}");
    }
}
