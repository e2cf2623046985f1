//! Passes that are switched off after a loss of the device, until they are edited.

use raxel_execute::{Executor, Suspect};
use raxel_graph::checked::{Graph, PassId};

/// The passes that a device was lost with.
#[derive(Default)]
pub(super) struct SwitchedOff {
    suspects: Vec<Suspect>,
    /// The same in the graph that runs.
    pub passes: Vec<PassId>,
}

impl SwitchedOff {
    /// Switches a pass off, in the graph that runs and in later ones that have it.
    pub(crate) fn add(&mut self, suspect: Suspect) {
        self.suspects.push(suspect);
    }

    /// Finds the passes in the running graph that are unchanged since they were suspected.
    pub(crate) fn find(&mut self, graph: &Graph, executor: &Executor) {
        self.suspects.retain(|suspect| runs(executor, suspect));
        self.passes = self.suspects.iter().flat_map(|suspect| graph.cases(&suspect.declared)).collect();
    }

    /// Their names.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.suspects.iter().map(|suspect| suspect.declared.as_str())
    }
}

/// Whether a pass of the running plan is unchanged since it was suspected.
pub(super) fn runs(executor: &Executor, suspect: &Suspect) -> bool {
    let planned = executor.plan().map(|plan| &plan.graph);
    let pass = planned.and_then(|graph| Some((graph, graph.find_pass(&suspect.pass)?)));
    pass.is_some_and(|(graph, id)| graph.declaration(id) == suspect.declaration)
}
