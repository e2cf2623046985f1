//! Changing the graph: a demo may run several in turn.

use raxel_execute::ExecuteError;
use raxel_execute::moment::Moment;

use super::{FrameError, Session};
use crate::build_error::BuildError;
use crate::debug_target::DebugTarget;
use crate::reload::project_state::BuildSettings;
use crate::sources::POSES;

impl Session {
    /// Lets the graph run that the demo wants at a time on the clock. True when it is another one.
    pub(super) fn follow_graphs(&mut self, time: Moment) -> Result<bool, FrameError> {
        let Some(demo) = self.demo.as_ref().filter(|_| !self.taken_over && !self.state.named.graph) else {
            return Ok(false);
        };
        let path = &demo.graph_at(time).value;
        if *path == self.state.graph_path || self.refused_graph.as_ref() == Some(path) {
            return Ok(false);
        }
        let path = path.clone();
        self.change_graph(&path)
    }

    /// Lets another graph of the demo run. What no plan can be made for is said once, and the graph before runs on.
    fn change_graph(&mut self, path: &str) -> Result<bool, FrameError> {
        let graph = self.state.graph_at(path).and_then(|part| part.result.as_ref().ok()).cloned();
        let Some(graph) = graph else { return Ok(false) };
        // It begins with its own picture.
        let debug_target = if self.target_held { self.debug_target.clone() } else { DebugTarget::default() };
        let settings = BuildSettings { debug_target: debug_target.clone(), ..self.build_settings() };
        let selection = settings.selection(path, &graph, &self.world);
        match self.plan_for(&graph, &selection) {
            Ok(()) => {}
            Err(BuildError::Device(error @ ExecuteError::DeviceLost { .. })) => {
                self.recover(error)?;
                return Ok(false);
            }
            Err(error) => {
                self.refused_graph = Some(path.to_owned());
                let texts = Box::new(self.state.diagnostics().1);
                return Err(FrameError::Plan { diagnostics: error.into_diagnostics(), texts });
            }
        }
        // Places are those of the graph that ran.
        self.say_counted();
        self.say_failed();
        self.state.change_graph(path);
        self.graph = graph;
        (self.debug_target, self.demo_target) = (debug_target, None);
        (self.refused, self.refused_graph) = (None, None);
        self.adopt_graph();
        Ok(true)
    }

    /// Brings all that follows the graph to the one that runs now.
    pub(super) fn adopt_graph(&mut self) {
        self.warned.forget();
        self.prints.forget();
        if !self.graph.collected().any(|id| self.graph.resource(id).collected_as() == Some(POSES)) {
            self.collected.forget_poses();
        }
        self.params.adopt(&self.graph);
        self.values.clear();
        self.values.extend_from_slice(self.params.values());
        self.note_conditions();
        self.find_overrides();
        self.find_disabled();
        self.settings_changed();
    }
}
