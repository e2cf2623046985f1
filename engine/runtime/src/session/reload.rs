//! Swapping in edits, at the boundary between two frames.

use std::sync::Arc;
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, codes};

use super::Session;
use crate::build;
use crate::debug_target::DebugTarget;
use crate::reload::builder::{Outcome, Ready};
use crate::reload::{Failed, ReloadEvent, Reloaded};

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

    /// Makes an edit what runs.
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
        let (edited, found) = self.world.editing.rebase(&base, &self.world.shown);
        diagnostics.extend(found);
        // A streamed world may have begun to load before it had the edits.
        self.renderer.context.sources.edit_streamed(&base, &self.world.editing.positions());
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
            let gone = Diagnostic::warning(codes::session::UNKNOWN_TARGET, error.to_string());
            diagnostics.push(gone.note(format!("`{}` is shown instead", graph.resource(graph.present).name)));
            self.renderer.shown.debug_target = DebugTarget::default();
        }
        let demo = state.demo.as_ref().and_then(|demo| demo.result.clone().ok());
        let script = demo.as_ref().map(|demo| demo.script(self.scene())).unwrap_or_default();
        self.playback.demo.demo = demo;
        self.world.editing.set_script(script);
        self.world.replace(world);
        self.files.adopt(state, warnings, all_texts);
        self.renderer.plans.forgive();
        self.adopt_graph(graph);
        let milliseconds = since.elapsed().as_secs_f64() * 1e3;
        ReloadEvent::Reloaded(Reloaded {
            generation,
            changed,
            rebuilt,
            resources,
            milliseconds,
            stages,
            diagnostics,
            texts,
        })
    }
}
