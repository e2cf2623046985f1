//! The diagnostics of the open projects, which an editor underlines in their files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use lsp_server::Notification;
use lsp_types::notification::{Notification as _, PublishDiagnostics};
use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, PublishDiagnosticsParams,
    Url,
};
use raxel_diagnostics::{Severity, SourceMap, Span, codes, each_once};
use raxel_runtime::load::Loader;
use raxel_runtime::project::Project;
use raxel_terminal::offline::{FileKind, OfflineProject};

use super::address;
use super::documents::{Document, Documents, Overlay, range};
use super::project_texts::{graphs_that_run, includers};

/// The most graphs to check for the shaders that are open. All graphs of a shader that many share would take long.
const MOST_GRAPHS: usize = 8;

/// The diagnostics of each file.
pub(super) type Found = BTreeMap<Url, Vec<Diagnostic>>;

/// The errors that a first look finds in the shaders that were edited since the last check.
pub(super) struct Look {
    /// By file. A file without errors is in it too.
    found: Found,
    /// These files have no other errors, as far as the look can tell.
    is_sure: bool,
}

/// The diagnostics that an editor shows.
#[derive(Default)]
pub(super) struct Said {
    /// Files that have diagnostics.
    last: Found,
    /// Files whose diagnostics come from a first look since the last check.
    looked: BTreeSet<Url>,
}

impl Said {
    /// The messages to an editor after a check of `checked`. They leave out the files that have changed since: the places in them would be wrong,
    /// and the next check is due.
    pub(crate) fn messages(&mut self, mut found: Found, checked: &Documents, now: &Documents) -> Vec<Notification> {
        // A file that has no diagnostics any more gets an empty list, which clears it.
        for url in self.last.keys() {
            found.entry(url.clone()).or_default();
        }
        let looked = std::mem::take(&mut self.looked);
        found.retain(|url, found| {
            let is_known = looked.contains(url) && self.last.get(url) == Some(found);
            checked.is_current(now, url) && !is_known
        });
        found.into_iter().map(|(url, found)| self.message(url, found)).collect()
    }

    /// The messages to an editor after a first look at `checked`. They show new errors at once. They clear a file only if all of its errors are the
    /// compiler's: a look finds no others.
    pub(crate) fn first_messages(&mut self, look: Look, checked: &Documents, now: &Documents) -> Vec<Notification> {
        let compile = Some(NumberOrString::String(codes::shader::COMPILE.as_str().to_owned()));
        let of_compiler = |last: &Vec<Diagnostic>| last.iter().all(|found| found.code == compile);
        let mut messages = Vec::new();
        for (url, found) in look.found {
            let is_mended = look.is_sure && self.last.get(&url).is_some_and(of_compiler);
            if checked.is_current(now, &url) && (is_mended || !found.is_empty()) {
                self.looked.insert(url.clone());
                messages.push(self.message(url, found));
            }
        }
        messages
    }

    fn message(&mut self, uri: Url, diagnostics: Vec<Diagnostic>) -> Notification {
        if diagnostics.is_empty() {
            self.last.remove(&uri);
        } else {
            self.last.insert(uri.clone(), diagnostics.clone());
        }
        let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
        Notification::new(PublishDiagnostics::METHOD.to_owned(), params)
    }
}

/// Checks files.
#[derive(Default)]
pub(super) struct Checker {
    /// By their roots. Each keeps what it has compiled and built, since one key changes one file.
    projects: BTreeMap<PathBuf, CheckedProject>,
    /// The texts of the last check.
    checked: Documents,
}

/// A project with the texts that are open in front of its files.
struct CheckedProject {
    files: Arc<Overlay>,
    offline: OfflineProject,
    /// The files that the last check began with: open ones, and graphs that run an open shader.
    paths: BTreeSet<String>,
    /// Files in which the last check found errors.
    wrong: BTreeSet<String>,
}

impl CheckedProject {
    fn new(project: &Project) -> std::io::Result<Self> {
        let files = Arc::new(Overlay::new(project)?);
        let offline = OfflineProject::new(project.clone(), Loader::with_files(files.clone())).for_checks();
        Ok(Self { files, offline, paths: BTreeSet::new(), wrong: BTreeSet::new() })
    }
}

impl Checker {
    /// Checks all open files, and the graphs that run an open shader. The result may leave out files without mistakes.
    pub(crate) fn check(&mut self, documents: &Documents) -> Found {
        let mut found = Found::new();
        let open = documents.projects();
        self.projects.retain(|root, _| open.iter().any(|(project, _)| project.root() == root));
        for (project, texts) in open {
            let known = self.projects.remove(project.root()).map_or_else(|| CheckedProject::new(&project), Ok);
            // The check skips a project whose folder it cannot read any more.
            let Ok(mut known) = known else { continue };
            known.check(documents, &texts, &mut found);
            self.projects.insert(project.root().to_owned(), known);
        }
        self.checked = documents.clone();
        found
    }

    /// Looks at the shaders that were edited since the last check. If anything else has changed, only a check can tell.
    pub(crate) fn first_look(&self, documents: &Documents) -> Look {
        let mut look = Look { found: Found::new(), is_sure: true };
        if documents.has_all_of(&self.checked) {
            for (project, open) in documents.projects() {
                let edited = open.iter().copied().filter(|document| !self.checked.has(document));
                let edited: Vec<&Document> = edited.collect();
                if let Some(known) = self.projects.get(project.root())
                    && !edited.iter().any(|document| document.is_toml())
                {
                    known.first_look(&open, &edited, &mut look);
                }
            }
        }
        look
    }
}

impl CheckedProject {
    /// Checks the texts of a project that are open, and graphs that run one of them.
    fn check(&mut self, documents: &Documents, open: &[&Document], found: &mut Found) {
        self.files.update(open);
        self.offline.forget_changed_worlds();
        let (graphs, shaders): (Vec<&Document>, Vec<&Document>) =
            open.iter().copied().partition(|document| document.is_toml());
        self.paths = graphs.iter().map(|document| document.path.clone()).collect();
        if let Some(first) = shaders.first() {
            let edited: Vec<&str> = shaders.iter().map(|document| document.path.as_str()).collect();
            let includers = includers(documents, first, &edited);
            self.paths.extend(graphs_that_run(documents, first, &includers, MOST_GRAPHS));
        }
        // A file in another folder is none of raxel's.
        self.paths.retain(|path| FileKind::of(path) != FileKind::Graph || path.starts_with("graphs/"));
        let (mut all, mut texts) = (Vec::new(), SourceMap::default());
        for path in &self.paths {
            let checked = self.offline.check(path, None);
            all.extend(checked.found);
            texts.extend(&checked.texts);
        }
        // The overlay forgets the files that it has read: one may be large, such as a video, and the next key may be far away.
        self.files.update(open);
        let errors = all.iter().filter(|diagnostic| diagnostic.is_error());
        self.wrong = errors.filter_map(|error| Some(error.labels.first()?.span.file.to_string())).collect();
        self.place(all, &texts, found);
    }

    /// Looks at shaders that were edited.
    fn first_look(&self, open: &[&Document], edited: &[&Document], look: &mut Look) {
        let addresses = edited.iter().filter_map(|document| address(&self.offline.project.on_disk(&document.path)));
        let addresses: BTreeSet<Url> = addresses.collect();
        // Behind an error of another file the compiler may find none at all.
        let whole = edited.iter().map(|document| document.path.clone()).chain(self.wrong.iter().cloned()).collect();
        self.files.update(open);
        let first_look = self.offline.loader.first_look(&whole);
        let (mut all, mut texts) = (Vec::new(), SourceMap::default());
        for path in self.paths.iter().filter(|path| FileKind::of(path) == FileKind::Graph) {
            let looked = self.offline.loader.looked_at(path, &first_look);
            all.extend_from_slice(looked.found());
            texts.extend(&looked.texts);
        }
        self.files.update(open);
        let mut found = Found::new();
        self.place(all, &texts, &mut found);
        found.retain(|url, _| addresses.contains(url));
        for url in addresses {
            found.entry(url).or_default();
        }
        look.found.extend(found);
        look.is_sure &= first_look.is_sure();
    }

    /// Puts diagnostics where an editor shows them.
    fn place(&self, all: Vec<raxel_diagnostics::Diagnostic>, texts: &SourceMap, found: &mut Found) {
        let project = &self.offline.project;
        for diagnostic in each_once(all) {
            let Some(first) = diagnostic.labels.first() else { continue };
            let Some(place) = location(project, texts, &first.span) else { continue };
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
                let location = location(project, texts, &label.span)?;
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
}

fn location(project: &Project, texts: &SourceMap, span: &Span) -> Option<Location> {
    let text = texts.get(&span.file)?;
    Some(Location { uri: address(&project.on_disk(&span.file))?, range: range(text, &span.range) })
}
