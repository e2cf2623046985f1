//! What is wrong in the files of the projects that are open, as an editor underlines it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
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
use super::project_texts::{graphs_that_run, includers};

/// The most graphs to check for the shaders that are open. All graphs of a shader that many share would take long.
const MOST_GRAPHS: usize = 8;

/// What is wrong in each file.
pub(super) type Found = BTreeMap<Url, Vec<Diagnostic>>;

/// Remembers where something was said, so that it can be taken back.
#[derive(Default)]
pub(super) struct Said(BTreeSet<Url>);

impl Said {
    /// What to tell an editor after a check of `checked`. What was found in a text that has changed since is left out: its places would be wrong,
    /// and the next check is due.
    pub fn messages(&mut self, mut found: Found, checked: &Documents, now: &Documents) -> Vec<Notification> {
        // What was wrong and is right now is said to be right.
        for url in &self.0 {
            found.entry(url.clone()).or_default();
        }
        found.retain(|url, _| checked.is_current(now, url));
        let mut messages = Vec::new();
        for (uri, diagnostics) in found {
            if diagnostics.is_empty() {
                self.0.remove(&uri);
            } else {
                self.0.insert(uri.clone());
            }
            let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
            messages.push(Notification::new(PublishDiagnostics::METHOD.to_owned(), params));
        }
        messages
    }
}

/// Checks files.
#[derive(Default)]
pub(super) struct Checker {
    /// By their roots. Each keeps what it has compiled and built, since one key changes one file.
    projects: BTreeMap<PathBuf, CheckedProject>,
}

/// A project with the texts that are open in front of its files.
struct CheckedProject {
    files: Arc<Overlay>,
    offline: OfflineProject,
}

impl CheckedProject {
    fn new(project: &Project) -> std::io::Result<Self> {
        let files = Arc::new(Overlay::new(project)?);
        let offline = OfflineProject::new(project.clone(), Loader::with_files(files.clone())).for_checks();
        Ok(Self { files, offline })
    }
}

impl Checker {
    /// Checks all that is open, and the graphs that run a shader that is. Files without mistakes may be left out.
    pub fn check(&mut self, documents: &Documents) -> Found {
        let mut found = Found::new();
        let open = documents.projects();
        self.projects.retain(|root, _| open.iter().any(|(project, _)| project.root() == root));
        for (project, texts) in open {
            let known = self.projects.remove(project.root()).map_or_else(|| CheckedProject::new(&project), Ok);
            // A folder that cannot be read any more has nothing to be checked.
            let Ok(known) = known else { continue };
            check_project(&known, documents, &texts, &mut found);
            self.projects.insert(project.root().to_owned(), known);
        }
        found
    }
}

/// Checks the texts of a project that are open, and graphs that run one of them.
fn check_project(checked: &CheckedProject, documents: &Documents, open: &[&Document], found: &mut Found) {
    let CheckedProject { files, offline } = checked;
    let project = &offline.project;
    files.update(open);
    offline.forget_changed_worlds();
    let (graphs, shaders): (Vec<&Document>, Vec<&Document>) =
        open.iter().copied().partition(|document| document.is_toml());
    let mut paths: BTreeSet<String> = graphs.iter().map(|document| document.path.clone()).collect();
    if let Some(first) = shaders.first() {
        let edited: Vec<&str> = shaders.iter().map(|document| document.path.as_str()).collect();
        let includers = includers(documents, first, &edited);
        paths.extend(graphs_that_run(documents, first, &includers, MOST_GRAPHS));
    }
    let (mut all, mut texts) = (Vec::new(), SourceMap::default());
    for path in &paths {
        // A file in another folder is none of raxel's.
        if FileKind::of(path) == FileKind::Graph && !path.starts_with("graphs/") {
            continue;
        }
        let checked = offline.check(path, None);
        all.extend(checked.found);
        texts.extend(&checked.texts);
    }
    // What was read from disk may be large, such as a video, and the next key may be far away.
    files.update(open);
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
