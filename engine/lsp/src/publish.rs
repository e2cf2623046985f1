//! What is wrong in the files of the projects that are open, as an editor underlines it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use lsp_server::Notification;
use lsp_types::notification::{Notification as _, PublishDiagnostics};
use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, PublishDiagnosticsParams,
    Url,
};
use raxel_diagnostics::{Severity, SourceMap, Span, each_once};
use raxel_runtime::load::Loader;
use raxel_runtime::project::Project;
use raxel_terminal::offline::{FileKind, OfflineProject};

use super::address;
use super::documents::{Document, Documents, Overlay, range};

/// Checks files, and remembers where something was said, so that it can be taken back.
#[derive(Default)]
pub(super) struct Publisher {
    said: BTreeSet<Url>,
}

impl Publisher {
    /// Checks all that is open, and all graphs if a shader is. Gives what is to be told.
    pub fn check(&mut self, documents: &Documents) -> Vec<Notification> {
        let mut found: BTreeMap<Url, Vec<Diagnostic>> = BTreeMap::new();
        for (project, documents) in documents.projects() {
            check_project(&project, &documents, &mut found);
        }
        // What was wrong and is right now is said to be right.
        for url in std::mem::take(&mut self.said) {
            found.entry(url).or_default();
        }
        self.said = found.iter().filter(|(_, found)| !found.is_empty()).map(|(url, _)| url.clone()).collect();
        found
            .into_iter()
            .map(|(uri, diagnostics)| {
                let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
                Notification::new(PublishDiagnostics::METHOD.to_owned(), params)
            })
            .collect()
    }
}

fn check_project(project: &Project, documents: &[&Document], found: &mut BTreeMap<Url, Vec<Diagnostic>>) {
    let Ok(overlay) = Overlay::new(project, documents) else { return };
    let front = OfflineProject::new(project.clone(), Loader::with_files(Arc::new(overlay))).for_checks();
    let mut paths: BTreeSet<String> = BTreeSet::new();
    for document in documents {
        if document.is_toml() {
            paths.insert(document.path.clone());
        } else {
            // Which graphs a shader belongs to is known when they are compiled.
            paths.extend(project.graphs());
        }
    }
    let (mut all, mut texts) = (Vec::new(), SourceMap::default());
    for path in &paths {
        // A file in another folder is none of raxel's.
        if FileKind::of(path) == FileKind::Graph && !path.starts_with("graphs/") {
            continue;
        }
        let checked = front.check(path, None);
        all.extend(checked.found);
        texts.extend(&checked.texts);
    }
    for diagnostic in each_once(all) {
        let Some(first) = diagnostic.labels.first() else { continue };
        let Some(place) = location(project, &texts, &first.span) else { continue };
        let mut message = diagnostic.message.clone();
        if !first.text.is_empty() {
            message = format!("{message}: {}", first.text);
        }
        for more in diagnostic.notes.iter().map(|note| format!("note: {note}")) {
            message = format!("{message}\n{more}");
        }
        for more in diagnostic.help.iter().map(|help| format!("help: {help}")) {
            message = format!("{message}\n{more}");
        }
        let related = diagnostic.labels[1..].iter().filter_map(|label| {
            let location = location(project, &texts, &label.span)?;
            Some(DiagnosticRelatedInformation { location, message: label.text.clone() })
        });
        found.entry(place.uri).or_default().push(Diagnostic {
            range: place.range,
            severity: Some(match diagnostic.severity {
                Severity::Error => DiagnosticSeverity::ERROR,
                Severity::Warning => DiagnosticSeverity::WARNING,
            }),
            code: Some(NumberOrString::String(diagnostic.code.as_str().to_owned())),
            source: Some("raxel".to_owned()),
            message,
            related_information: Some(related.collect()),
            ..Diagnostic::default()
        });
    }
}

fn location(project: &Project, texts: &SourceMap, span: &Span) -> Option<Location> {
    let text = texts.get(&span.file)?;
    Some(Location { uri: address(&project.on_disk(&span.file))?, range: range(text, &span.range) })
}
