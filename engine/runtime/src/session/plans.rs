//! The running plan, the selection that it should have, and the one that cannot be made.

use std::sync::Arc;

use raxel_graph::checked::{Fact, Graph, ParamId, Value};
use raxel_graph::plan::Plan;

use super::retry::Retry;
use crate::build::Selection;
use crate::build_error::BuildError;

/// Most plans that are kept for the time when they are wanted again: debug targets that are looked at in turn.
const MOST_KEPT: usize = 16;

/// The plans of one graph over one world.
pub(super) struct Plans {
    /// The inputs of the running plan.
    pub running: Selection,
    kept: Vec<(Selection, Arc<Plan>)>,
    /// The selection that has no possible plan; reported once, and not tried again unless the device refused it.
    refused: Option<Selection>,
    /// The time of the next try after a refusal of the device.
    retry: Retry,
    /// The graph of the demo that has no possible plan; reported once, and not tried again until an edit.
    pub refused_graph: Option<String>,
    /// Something was changed that a plan depends on.
    pub stale: bool,
    /// Params that conditions of passes ask for, with the values for which the plan was made.
    conditions: Vec<(ParamId, Value)>,
}

impl Plans {
    /// With the first plan.
    pub(crate) fn new(running: Selection, plan: Arc<Plan>) -> Self {
        Self {
            kept: vec![(running.clone(), plan)],
            running,
            refused: None,
            retry: Retry::default(),
            refused_graph: None,
            stale: false,
            conditions: Vec::new(),
        }
    }

    /// Notes the plan that runs.
    pub(crate) fn remember(&mut self, selection: Selection, plan: Arc<Plan>) {
        self.kept.retain(|(known, _)| *known != selection);
        if self.kept.len() == MOST_KEPT {
            self.kept.remove(0);
        }
        self.kept.push((selection.clone(), plan));
        self.running = selection;
    }

    /// A plan that was made before.
    pub(crate) fn find(&self, selection: &Selection) -> Option<Arc<Plan>> {
        self.kept.iter().find(|(known, _)| known == selection).map(|(_, plan)| plan.clone())
    }

    /// Plans for other sizes of their bound resources are stale.
    pub(crate) fn forget(&mut self) {
        self.kept.clear();
    }

    /// On another device, a refused plan may be possible.
    pub(crate) fn allow(&mut self) {
        self.refused = None;
    }

    /// Another graph runs, or other files: nothing is refused any more.
    pub(crate) fn forgive(&mut self) {
        (self.refused, self.refused_graph) = (None, None);
    }

    /// Whether the present selection has no possible plan.
    pub(crate) fn is_refused(&self) -> bool {
        self.refused.is_some()
    }

    /// Whether a frame with these values of params is to look whether another plan is needed.
    pub(crate) fn are_due(&mut self, values: &[Value]) -> bool {
        let decided = |(id, value): &(ParamId, Value)| values[id.0 as usize] == *value;
        self.stale || self.retry.due() || !self.conditions.iter().all(decided)
    }

    /// Notes the values of the params that conditions ask for: when one changes, another plan may be needed.
    pub(crate) fn note_conditions(&mut self, graph: &Graph, values: &[Value]) {
        self.conditions.clear();
        for condition in graph.passes.iter().flat_map(|pass| &pass.when) {
            if let Fact::Param(id) = &condition.fact {
                self.conditions.push((*id, values[id.0 as usize]));
            }
        }
    }

    /// Whether to make a plan: it must not run already, and must not have been refused.
    pub(crate) fn wants(&mut self, wanted: &Selection) -> bool {
        self.stale = false;
        if *wanted == self.running {
            self.accept();
            return false;
        }
        let again = self.refused.as_ref() == Some(wanted);
        if !again {
            self.retry = Retry::default();
        }
        !again || self.retry.due()
    }

    /// The plan that was wanted runs.
    pub(crate) fn accept(&mut self) {
        (self.refused, self.retry) = (None, Retry::default());
    }

    /// The present selection has no possible plan. True if that must be reported; memory may be free later.
    pub(crate) fn refuse(&mut self, wanted: Selection, error: &BuildError) -> bool {
        let again = self.refused.as_ref() == Some(&wanted);
        let first = !matches!(error, BuildError::Device(_)) || self.retry.refused();
        self.refused = Some(wanted);
        first || !again
    }
}
