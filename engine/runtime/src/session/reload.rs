//! Swapping in edits, at the boundary between two frames.

use std::sync::Arc;
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, codes};

use super::Session;
use crate::build;
use crate::debug_target::DebugTarget;
use crate::editing::Editing;
use crate::reload::builder::{Outcome, Ready};
use crate::reload::project_state::{ProjectFile, ProjectState};
use crate::reload::{Failed, ReloadEvent, Reloaded};
use crate::world::SessionWorld;

impl Session {
    /// Swaps in the newest edit that is ready, and returns the events since the last call. Call it between frames. If the session waits for
    /// files with mistakes to be corrected, this opens them.
    pub fn poll_reload(&mut self) -> Vec<ReloadEvent> {
        self.try_again(Duration::ZERO);
        let outcomes = self.files.poll();
        self.take_outcomes(outcomes)
    }

    /// Waits until an edit is ready, an edit has mistakes, or the time is up. Then does the same as [`Session::poll_reload`].
    pub fn wait_reload(&mut self, timeout: Duration) -> Vec<ReloadEvent> {
        self.try_again(timeout);
        let outcomes = if self.events.is_empty() { self.files.wait(timeout) } else { self.files.poll() };
        self.take_outcomes(outcomes)
    }

    /// Opens another graph, world or demo of the project in place of the running one, on another thread: [`Session::poll_reload`] reports
    /// the result, as of an edit. Until the file is right, the old one runs on, and edits of the new file are followed. A graph runs over
    /// the world that is shown, a world under the graph that runs, and either ends the demo. False where files are not watched
    /// ([`super::Options::watch`]): nothing is opened.
    pub fn open_file(&mut self, file: ProjectFile) -> bool {
        self.files.open(file)
    }

    /// Compiles all shaders again with checks of the bounds of their accesses to arrays and images, or without them, on another thread:
    /// [`Session::poll_reload`] reports the result, as of an edit. Passes compute the same either way; with checks they are slower, and
    /// accesses out of bounds come with [`Session::take_messages`] and [`Session::counted`]. False where files are not watched
    /// ([`super::Options::watch`]): then only [`super::Options::check_bounds`] decides whether shaders have checks.
    pub fn check_bounds(&mut self, on: bool) -> bool {
        self.files.check_bounds(on)
    }

    /// Whether shaders check the bounds of their accesses, or will once they are compiled again.
    pub fn checks_bounds(&self) -> bool {
        self.files.checks_bounds()
    }

    fn take_outcomes(&mut self, outcomes: Vec<Outcome>) -> Vec<ReloadEvent> {
        // Of several edits only the newest runs; the others never were.
        let newest = outcomes.iter().rposition(|outcome| matches!(outcome, Outcome::Ready(_)));
        for (index, outcome) in outcomes.into_iter().enumerate() {
            match outcome {
                Outcome::Failed(failed) => self.events.push(ReloadEvent::Failed(failed)),
                Outcome::Ready(ready) if Some(index) == newest => {
                    let event = self.adopt(*ready);
                    self.events.push(event);
                }
                Outcome::Ready(_) => {}
            }
        }
        std::mem::take(&mut self.events)
    }

    /// Makes an edit the running state.
    fn adopt(&mut self, ready: Ready) -> ReloadEvent {
        let Ready { generation, changed, rebuilt, mut state, selection, context, prepared, since, stages } = ready;
        // The demo may have changed the graph since the build began.
        state.change_graph(self.graph_path());
        let (mut diagnostics, texts) = state.diagnostics();
        let (Ok(graph), Ok(world)) = (&state.graph.result, &state.world.result) else {
            // The builder hands over projects without errors only.
            return ReloadEvent::Failed(Failed { generation, changed, diagnostics, texts });
        };
        let (graph, base) = (graph.clone(), world.clone());
        let opened = state.is_of_other_files(&self.files.state);
        let (editing, edited, found) = self.editing_of(&state, &base);
        diagnostics.extend(found);
        if editing.is_some() && diagnostics.iter().any(Diagnostic::is_error) {
            return ReloadEvent::Failed(Failed { generation, changed, diagnostics, texts });
        }
        // A streamed world may have begun to load before it had the edits.
        let positions = editing.as_ref().unwrap_or(&self.world.editing).positions();
        self.renderer.context.sources.edit_streamed(&base, &positions);
        let world = edited.unwrap_or_else(|| base.clone());
        let (warnings, all_texts) = (diagnostics.clone(), texts.clone());
        // Something may have been chosen since the build began.
        let settings = self.build_settings();
        let wanted = settings.selection(&state.graph_path, &graph, &world);
        let stale = wanted != selection
            || !Arc::ptr_eq(&world, &base)
            || !Arc::ptr_eq(&context.memory, &self.renderer.context.memory)
            || !self.renderer.executor.is_current(&prepared);
        let built = if stale {
            let context = &self.renderer.context;
            build::assemble(&graph, &world, &wanted, context).and_then(|assembly| build::prepare(&assembly, context))
        } else {
            Ok(prepared)
        };
        let prepared = match built {
            Ok(prepared) => prepared,
            Err(error) => {
                let diagnostics = error.into_diagnostics();
                return ReloadEvent::Failed(Failed { generation, changed, diagnostics, texts });
            }
        };
        let resources = self.renderer.executor.swap(prepared);
        if let Some(plan) = self.renderer.executor.plan().cloned() {
            self.renderer.plans.forget();
            self.renderer.plans.remember(wanted, plan);
        }
        if let Err(error) = self.debug_target().resolve(&graph) {
            // Another graph shows its own picture; a target that an edit has taken away is missed.
            if !opened {
                let gone = Diagnostic::warning(codes::session::UNKNOWN_TARGET, error.to_string());
                diagnostics.push(gone.note(format!("`{}` is shown instead", graph.resource(graph.present).name)));
            }
            self.renderer.shown.debug_target = DebugTarget::default();
        }
        let other_world = state.world_path != self.files.state.world_path;
        if let Some(editing) = editing {
            self.world.editing = editing;
        }
        let demo = state.demo.as_ref().and_then(|demo| demo.result.clone().ok());
        let script = demo.as_ref().map(|demo| demo.script(self.scene())).unwrap_or_default();
        self.playback.demo.demo = demo;
        self.world.editing.set_script(script);
        self.world.replace(world);
        self.files.adopt(state, warnings, all_texts);
        self.renderer.plans.forgive();
        self.adopt_graph(graph);
        if opened {
            self.begin_opened(other_world);
        }
        let milliseconds = since.elapsed().as_secs_f64() * 1e3;
        ReloadEvent::Reloaded(Reloaded {
            generation,
            changed,
            opened,
            rebuilt,
            resources,
            milliseconds,
            stages,
            diagnostics,
            texts,
        })
    }

    /// The edits of the next world, if they differ from those of the running one; the world with them, if there are any; and messages.
    fn editing_of(
        &mut self,
        state: &ProjectState,
        base: &Arc<SessionWorld>,
    ) -> (Option<Editing>, Option<Arc<SessionWorld>>, Vec<Diagnostic>) {
        let before = &self.files.state;
        if (&state.world_path, &state.demo_path) == (&before.world_path, &before.demo_path) {
            let (edited, found) = self.world.editing.rebase(base, &self.world.shown);
            return (None, edited, found);
        }
        let mut editing = Editing::new(base.clone());
        // A demo shows the same everywhere, and so it begins with the voxels of the world's file.
        let found = match &state.demo_path {
            Some(_) => Vec::new(),
            None => editing.open_save(self.files.project.root(), &**self.files.loader.files(), self.options.saves),
        };
        let edited = editing.world();
        (Some(editing), edited, found)
    }

    /// Other files run from here on: they begin at their first frame, another world where its first camera is.
    fn begin_opened(&mut self, other_world: bool) {
        if other_world {
            self.playback.view.camera = self.world.shown.first_camera();
        }
        let demo = &mut self.playback.demo;
        (demo.taken_over, demo.target, demo.target_held) = (false, None, false);
        demo.released.clear();
        self.reset();
    }
}
