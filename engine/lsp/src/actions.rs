//! Fixes that diagnostics name: "did you mean" puts the other word in the place of the wrong one.

use std::collections::HashMap;

use lsp_types::{CodeAction, CodeActionKind, CodeActionParams, Diagnostic, TextEdit, WorkspaceEdit};

use super::documents::{Document, offset};

/// The fixes of the diagnostics that an editor asks about.
pub(super) fn actions(document: &Document, params: &CodeActionParams) -> Vec<CodeAction> {
    let ours = params.context.diagnostics.iter().filter(|diagnostic| diagnostic.source.as_deref() == Some("raxel"));
    ours.filter_map(|diagnostic| fix(document, params, diagnostic)).collect()
}

fn fix(document: &Document, params: &CodeActionParams, diagnostic: &Diagnostic) -> Option<CodeAction> {
    let meant = diagnostic.message.split("did you mean `").nth(1)?.split('`').next()?;
    let bytes = offset(&document.text, diagnostic.range.start)..offset(&document.text, diagnostic.range.end);
    let wrong = document.text.get(bytes)?;
    let quote =
        wrong.chars().next().filter(|first| ['"', '\''].contains(first) && wrong.len() > 1 && wrong.ends_with(*first));
    let inner = quote.map_or(wrong, |quote| wrong.trim_matches(quote));
    // What stands around the word in a value stays: `param.` in `param.sun`, `@1` behind a target.
    let name = |c: char| c == '_' || c == '-' || c.is_alphanumeric();
    let named = diagnostic.message.split('`').skip(1).step_by(2).filter(|word| *word != meant && !word.is_empty());
    let word = named.filter(|word| whole_word(inner, word, name)).max_by_key(|word| word.len()).unwrap_or(inner);
    if word.is_empty() || word.contains('\n') {
        return None;
    }
    let new_text = wrong.replacen(word, meant, 1);
    #[allow(clippy::mutable_key_type, reason = "addresses are not changed while they are keys")]
    let changes =
        HashMap::from([(params.text_document.uri.clone(), vec![TextEdit { range: diagnostic.range, new_text }])]);
    Some(CodeAction {
        title: format!("Change `{word}` to `{meant}`"),
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: Some(vec![diagnostic.clone()]),
        edit: Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }),
        is_preferred: Some(true),
        ..CodeAction::default()
    })
}

/// Whether a text has a word, with no letters of a name around it.
fn whole_word(text: &str, word: &str, name: impl Fn(char) -> bool) -> bool {
    let is_whole = |(at, _): (usize, &str)| !text[..at].ends_with(&name) && !text[at + word.len()..].starts_with(&name);
    text.match_indices(word).any(is_whole)
}
