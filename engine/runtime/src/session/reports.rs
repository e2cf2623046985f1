//! Reports of passes to the user: prints, counters that should be 0, and failed assertions.

use raxel_diagnostics::Diagnostic;
use raxel_execute::PassPrints;

use super::Session;
use super::renderer::Renderer;

impl Session {
    /// The prints of passes in frames that the device has finished, since the last call; frame after frame. 65,536 lines wait for this
    /// call; older ones are lost. Assertions that fail come with [`Session::take_messages`].
    pub fn take_prints(&mut self) -> Vec<PassPrints> {
        self.renderer.note_reports();
        self.renderer.prints.take()
    }

    /// The prints of each pass of the running graph when it ran last, if it printed something then.
    pub fn printed(&self) -> &[PassPrints] {
        self.renderer.prints.latest()
    }

    /// Whether a pass of the running plan prints, or asserts something.
    pub fn has_prints(&self) -> bool {
        self.renderer.has_prints()
    }

    /// Present counts of passes that should be 0, with the count of the last frame that had any: each for as long as it has not been 0 for
    /// 60 frames. Then the assertions of shaders that fail, for as long as they have not held for 60 frames.
    pub fn counted(&self) -> Vec<Diagnostic> {
        let Renderer { counters, prints, graph, .. } = &self.renderer;
        counters.current(graph).chain(prints.failing()).collect()
    }

    /// Reports counts and failed assertions that were not reported yet.
    pub(super) fn say_reports(&mut self) {
        for message in self.renderer.take_reports() {
            self.world.editing.say(message);
        }
    }
}

impl Renderer {
    /// Notes the counts and prints of finished frames. Waits for none.
    pub(super) fn note_reports(&mut self) {
        for counted in self.executor.take_counted() {
            self.counters.note(counted);
        }
        for prints in self.executor.take_prints() {
            if let Some(written) = self.prints.note(prints) {
                self.writers.note(written);
            }
        }
    }

    /// Reports that were not made yet.
    fn take_reports(&mut self) -> Vec<Diagnostic> {
        self.note_reports();
        let mut found = self.counters.take(&self.graph);
        found.extend(self.prints.take_failed());
        found
    }

    /// Another graph runs, or the session starts over: present reports are made again.
    pub(super) fn forget_reports(&mut self) {
        self.counters.forget();
        self.prints.forget();
        self.writers.forget();
        self.executor.find_writers_again();
    }

    fn has_prints(&self) -> bool {
        let Some(plan) = self.executor.plan() else { return false };
        plan.passes.iter().any(|pass| plan.graph.pass(pass.pass).shader.interface.prints.is_some())
    }
}
