//! The files of a session: the project, the loaded files, and the thread that follows their edits.

use std::sync::Arc;
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, SourceMap, codes};

use super::{FrameError, OpenError, Options};
use crate::load::Loader;
use crate::project::Project;
use crate::reload::builder::{Outcome, Reloader};
use crate::reload::project_state::{BuildSettings, ProjectFile, ProjectState};

/// A project with its loaded files.
pub(super) struct ProjectFiles {
    pub project: Project,
    pub loader: Arc<Loader>,
    pub state: ProjectState,
    /// Warnings of the running files.
    pub warnings: Vec<Diagnostic>,
    /// The texts of the running files, which their warnings and places point into.
    pub texts: SourceMap,
    /// Rebuilds after edits, where files are watched.
    reloader: Option<Reloader>,
    /// Whether shaders check their accesses, or will once they are compiled again.
    checks_bounds: bool,
    /// Whether shaders record their writes, or will once they are compiled again.
    records_writes: bool,
}

impl ProjectFiles {
    /// Files that nothing watches yet.
    pub(crate) fn new(project: Project, loader: Arc<Loader>, state: ProjectState) -> Self {
        let (warnings, texts) = state.diagnostics();
        let (checks_bounds, records_writes) = (loader.checks_bounds(), loader.records_writes());
        Self { project, loader, state, warnings, texts, reloader: None, checks_bounds, records_writes }
    }

    /// Watches the files from here on, and rebuilds for these settings.
    pub(crate) fn watch(&mut self, settings: BuildSettings, options: &Options) -> Result<(), OpenError> {
        let (root, waker) = (self.project.root(), options.waker.clone());
        let started = Reloader::start(root, self.loader.clone(), self.state.clone(), settings, options.poll, waker);
        self.reloader = Some(started.map_err(|error| {
            let message = format!("files cannot be watched: {error}");
            Box::new(Diagnostic::error(codes::session::NO_PROJECT, message))
        })?);
        Ok(())
    }

    /// Sets the settings of later builds, if anything builds them.
    pub(crate) fn set_settings(&self, settings: impl FnOnce() -> BuildSettings) {
        if let Some(reloader) = &self.reloader {
            reloader.set_settings(settings());
        }
    }

    /// Loads another file in place of the running one. False where nothing builds it.
    pub(crate) fn open(&self, file: ProjectFile) -> bool {
        self.reloader.as_ref().map(|reloader| reloader.open(file)).is_some()
    }

    /// Compiles all shaders again, with or without checks of bounds. False where nothing builds them.
    pub(crate) fn check_bounds(&mut self, on: bool) -> bool {
        let Some(reloader) = &self.reloader else { return false };
        reloader.check_bounds(on);
        self.checks_bounds = on;
        true
    }

    /// Compiles all shaders again, with or without records of their writes. False where nothing builds them.
    pub(crate) fn record_writes(&mut self, on: bool) -> bool {
        let Some(reloader) = &self.reloader else { return false };
        reloader.record_writes(on);
        self.records_writes = on;
        true
    }

    /// Whether shaders check their accesses, or will once they are compiled again.
    pub(crate) fn checks_bounds(&self) -> bool {
        self.checks_bounds
    }

    /// Whether shaders record their writes, or will once they are compiled again.
    pub(crate) fn records_writes(&self) -> bool {
        self.records_writes
    }

    /// The edits that were built since the last call.
    pub(crate) fn poll(&self) -> Vec<Outcome> {
        self.reloader.as_ref().map(Reloader::poll).unwrap_or_default()
    }

    /// The same; waits for the first of them.
    pub(crate) fn wait(&self, timeout: Duration) -> Vec<Outcome> {
        self.reloader.as_ref().map(|reloader| reloader.wait(timeout)).unwrap_or_default()
    }

    /// Other files run.
    pub(crate) fn adopt(&mut self, state: ProjectState, warnings: Vec<Diagnostic>, texts: SourceMap) {
        (self.state, self.warnings, self.texts) = (state, warnings, texts);
    }

    /// The loaded files cannot run.
    pub(crate) fn open_error(&self, diagnostics: Vec<Diagnostic>) -> OpenError {
        OpenError::Project { diagnostics, texts: Box::new(self.texts.clone()) }
    }

    /// The loaded files have no plan.
    pub(crate) fn plan_error(&self, diagnostics: Vec<Diagnostic>) -> FrameError {
        FrameError::Plan { diagnostics, texts: Box::new(self.texts.clone()) }
    }
}
