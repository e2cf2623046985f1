//! Counts of passes that should be 0, e.g. of records without room (`warnings` of a buffer): each is reported once, until it has gone.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::CounterReading;
use raxel_graph::checked::{Graph, ResourceId, Warning};

/// The number of frames without a count before the same warning is reported again. Counts of random rays come and go from frame to frame.
pub(super) const GONE: u32 = 60;

/// The counted words of the running graph.
#[derive(Default)]
pub(super) struct CounterWarnings(Vec<Word>);

/// One word that was not 0.
struct Word {
    resource: ResourceId,
    warning: u32,
    /// In the last frame that counted something, and in the one that counted most.
    last: u32,
    most: u32,
    /// Frames since then that counted nothing.
    none: u32,
    said: bool,
}

impl CounterWarnings {
    /// Takes the counts of a frame.
    pub(super) fn note(&mut self, counted: CounterReading) {
        let CounterReading { resource, warning, count } = counted;
        let known = |word: &Word| (word.resource, word.warning) == (resource, warning);
        match (self.0.iter_mut().find(|word| known(word)), count) {
            (None, 0) => {}
            (None, count) => {
                self.0.push(Word { resource, warning, last: count, most: count, none: 0, said: false });
            }
            (Some(word), 0) => word.none += 1,
            (Some(word), count) => (word.last, word.most, word.none) = (count, word.most.max(count), 0),
        }
        self.0.retain(|word| word.none < GONE || !word.said);
    }

    /// Warnings that were not reported yet.
    pub(super) fn take(&mut self, graph: &Graph) -> Vec<Diagnostic> {
        let say = |word: &mut Word| {
            let said = std::mem::replace(&mut word.said, true);
            word.diagnostic(graph, word.most).filter(|_| !said)
        };
        self.0.iter_mut().filter_map(say).collect()
    }

    /// The present warnings, with the count of the last frame that had any.
    pub(super) fn current(&self, graph: &Graph) -> impl Iterator<Item = Diagnostic> {
        self.0.iter().filter_map(|word| word.diagnostic(graph, word.last))
    }

    /// Another graph runs, or the session starts over: counters that are still not 0 are reported again.
    pub(super) fn forget(&mut self) {
        self.0.clear();
    }
}

impl Word {
    fn diagnostic(&self, graph: &Graph, count: u32) -> Option<Diagnostic> {
        let resource = graph.resources.get(self.resource.0 as usize)?;
        let Warning { says, help, place, .. } = resource.warnings.get(self.warning as usize)?;
        let diagnostic = Diagnostic::warning(codes::session::COUNTED, format!("{says}: {count}"))
            .label(place.clone(), format!("counted by the passes that write `{}`", resource.name))
            .note(format!("raxel repeats this warning only after {GONE} frames that count none"));
        Some(match help {
            Some(help) => diagnostic.help(help.clone()),
            None => diagnostic,
        })
    }
}
