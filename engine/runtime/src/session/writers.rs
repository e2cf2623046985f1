//! The invocations that wrote a texel: what the shaders that record it have told.

use raxel_execute::{PassWrites, TracedTexel};
use raxel_graph::plan::Plan;

use super::Session;

/// The writes of a texel.
#[derive(Default)]
pub(super) struct Writers {
    pub texel: Option<TracedTexel>,
    /// Of each pass those of the last frame in which it ran.
    known: Vec<PassWrites>,
}

impl Writers {
    /// Takes the writes of a pass in a frame.
    pub(crate) fn note(&mut self, written: PassWrites) {
        if self.texel.as_ref() == Some(&*written.texel) {
            // A clock may run a pass several times in a frame.
            self.known.retain(|known| known.pass != written.pass || known.frame == written.frame);
            self.known.push(written);
        }
    }

    /// Forgets the known writes: they are those of other shaders or of another texel.
    pub(crate) fn forget(&mut self) {
        self.known.clear();
    }

    /// The known writes of the passes of a plan, in its order.
    fn of(&self, plan: &Plan) -> Vec<PassWrites> {
        let mut found: Vec<PassWrites> = Vec::new();
        for planned in &plan.passes {
            let name = &plan.graph.pass(planned.pass).name;
            // A pass of a clock stands in the plan once for each tick.
            if found.iter().all(|known| known.pass != *name) {
                found.extend(self.known.iter().filter(|known| known.pass == *name).cloned());
            }
        }
        found
    }
}

impl Session {
    /// Compiles all shaders again with records of their writes of the texel of [`Session::find_writers`], or without them, on another
    /// thread: [`Session::poll_reload`] reports the result, as of an edit. Passes compute the same either way; with records they are slower.
    /// False where files are not watched ([`super::Options::watch`]): then only [`super::Options::record_writes`] decides whether shaders
    /// have records.
    pub fn record_writes(&mut self, on: bool) -> bool {
        self.files.record_writes(on)
    }

    /// Whether shaders record their writes, or will once they are compiled again.
    pub fn records_writes(&self) -> bool {
        self.files.records_writes()
    }

    /// Finds the invocations that write a texel from the next frame on, or of none. [`Session::record_writes`] makes the shaders that tell;
    /// another texel needs no other shaders. For a new texel passes that write it and no buffer run once even if their results are still
    /// valid: they make the same contents again, so that a paused frame tells, too.
    pub fn find_writers(&mut self, texel: Option<TracedTexel>) {
        let writers = &mut self.renderer.writers;
        if writers.texel != texel {
            writers.texel = texel;
            writers.forget();
        }
    }

    /// The writes of the texel of [`Session::find_writers`] by passes of the running plan, in its order: of each pass those of the last
    /// frame in which it ran, as far as the device has finished it. A pass without writes ran and did not write the texel. Nothing is known of
    /// passes whose shaders have no records, or that have not run since the texel was chosen.
    pub fn writers(&mut self) -> Vec<PassWrites> {
        self.renderer.note_reports();
        let Some(plan) = self.renderer.executor.plan() else { return Vec::new() };
        self.renderer.writers.of(plan)
    }
}
