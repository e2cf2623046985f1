//! A session whose files have mistakes from the beginning: nothing runs until they are mended.

use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_diagnostics::{Diagnostic, MemoryFiles, SourceMap, codes};
use raxel_graph::plan::Observe;

use super::files::ProjectFiles;
use super::open::find_project;
use super::renderer::open_device;
use super::{OpenError, Options, Session};
use crate::debug_target::DebugTarget;
use crate::load::Loader;
use crate::manifest;
use crate::reload::ReloadEvent;
use crate::reload::mend::{Change, MendWatch};
use crate::reload::project_state::ProjectState;

/// The graph that runs meanwhile: no pass, over the empty world.
const NOTHING: &str = r#"
name = "nothing"
present = "nothing"
[targets.nothing]
format = "rgba8"
init = [0.0, 0.0, 0.0, 1.0]
"#;

/// The files to open, and the reason why they are not open.
pub(super) struct Waiting {
    options: Options,
    /// The mistakes, as reported last.
    found: Vec<Diagnostic>,
    watch: MendWatch,
}

impl Session {
    /// Whether nothing runs because files have mistakes ([`Options::wait`]). Graph and world are empty until then. [`Session::poll_reload`]
    /// returns the mistakes, and later an event when they are corrected.
    pub fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }

    /// A session that waits for the mend of these mistakes.
    pub(super) fn wait_for_mend(
        options: Options,
        found: Vec<Diagnostic>,
        texts: Box<SourceMap>,
    ) -> Result<Self, OpenError> {
        let project = find_project(&options)?;
        let said = texts.get(manifest::PATH).is_some_and(|text| !text.is_empty());
        let watch = MendWatch::start(project.root(), said, options.waker.clone()).map_err(|error| {
            let message = format!("files cannot be watched: {error}");
            Box::new(Diagnostic::error(codes::session::NO_PROJECT, message))
        })?;
        let loader = Loader::with_files(Arc::new(MemoryFiles::new([("nothing.toml", NOTHING)])));
        let state = ProjectState::of_graph("nothing.toml", &loader);
        let files = ProjectFiles::new(project, Arc::new(loader), state);
        let nothing = Options {
            debug_target: DebugTarget::default(),
            pinned: Vec::new(),
            observe: Observe::Shown,
            watch: false,
            ..options.clone()
        };
        let mut session = Self::start(nothing, files, open_device(&options))?;
        session.waiting = Some(Waiting { options, found: found.clone(), watch });
        session.events.push(ReloadEvent::NotOpened(OpenError::Project { diagnostics: found, texts }));
        Ok(session)
    }

    /// Opens the files again if they have changed, and waits for that at most `at_most`, or until there is something to report. The window
    /// keeps its size.
    pub(super) fn try_again(&mut self, at_most: Duration) {
        let until = Instant::now() + at_most;
        while let Some(waiting) = self.waiting.as_ref().filter(|_| self.events.is_empty()) {
            let left = until.saturating_duration_since(Instant::now());
            let Some(change) = waiting.watch.wait(left) else { return };
            self.open_again(&change);
        }
    }

    fn open_again(&mut self, change: &Change) {
        let Some(waiting) = &mut self.waiting else { return };
        let device = self.renderer.executor.device();
        let device = (!device.is_lost()).then(|| device.clone());
        let mut options = waiting.options.clone();
        options.size = self.renderer.shown.viewport.window();
        options.manifest.iter_mut().for_each(|defaults| defaults.size = false);
        match Self::open_on(options, device) {
            // A project that was opened between two steps of a save does not match its manifest.
            Ok(_) if !waiting.watch.manifest_holds(change) => {}
            Ok(session) => {
                *self = session;
                self.events.push(ReloadEvent::Opened);
            }
            Err(OpenError::Project { diagnostics, .. }) if diagnostics == waiting.found => {}
            Err(error) => {
                if let OpenError::Project { diagnostics, .. } = &error {
                    waiting.found.clone_from(diagnostics);
                }
                self.events.push(ReloadEvent::NotOpened(error));
            }
        }
    }
}
