//! Changing the graph: a demo may run several in turn.

use std::sync::Arc;

use raxel_execute::ExecuteError;
use raxel_execute::moment::Moment;
use raxel_graph::checked::Graph;

use super::{FrameError, Session};
use crate::build_error::BuildError;
use crate::debug_target::DebugTarget;
use crate::reload::project_state::BuildSettings;
use crate::sources::POSES;

impl Session {
    /// Lets the graph run that the demo wants at a time on the clock. True when it is another one.
    pub(super) fn follow_graphs(&mut self, time: Moment) -> Result<bool, FrameError> {
        let Some(demo) = self.playback.demo.driving().filter(|_| !self.files.state.named.graph) else {
            return Ok(false);
        };
        let path = &demo.graph_at(time).value;
        if path == self.graph_path() || self.renderer.plans.refused_graph.as_ref() == Some(path) {
            return Ok(false);
        }
        let path = path.clone();
        self.change_graph(&path)
    }

    /// Lets another graph of the demo run. A graph without a possible plan is reported once, and the graph before runs on.
    fn change_graph(&mut self, path: &str) -> Result<bool, FrameError> {
        let graph = self.files.state.graph_at(path).and_then(|part| part.result.as_ref().ok()).cloned();
        let Some(graph) = graph else { return Ok(false) };
        // It begins with its own picture.
        let held = self.playback.demo.target_held;
        let debug_target = if held { self.debug_target().clone() } else { DebugTarget::default() };
        let settings = BuildSettings { debug_target: debug_target.clone(), ..self.build_settings() };
        let selection = settings.selection(path, &graph, &self.world.shown);
        match self.plan_for(&graph, &selection) {
            Ok(()) => {}
            Err(BuildError::Device(error @ ExecuteError::DeviceLost { .. })) => {
                self.recover(error)?;
                return Ok(false);
            }
            Err(error) => {
                self.renderer.plans.refused_graph = Some(path.to_owned());
                return Err(self.files.plan_error(error.into_diagnostics()));
            }
        }
        // Places are those of the graph that ran.
        self.say_reports();
        self.files.state.change_graph(path);
        self.renderer.shown.debug_target = debug_target;
        self.playback.demo.target = None;
        self.renderer.plans.forgive();
        self.adopt_graph(graph);
        Ok(true)
    }

    /// Brings all that follows the graph to the one that runs now.
    pub(super) fn adopt_graph(&mut self, graph: Arc<Graph>) {
        if !graph.collected().any(|id| graph.resource(id).collected_as() == Some(POSES)) {
            self.world.output.forget_poses();
        }
        self.playback.params.adopt(&graph);
        self.renderer.graph = graph;
        self.renderer.forget_reports();
        self.renderer.find_off();
        self.note_conditions();
        self.settings_changed();
    }
}
