//! The device's time for the passes of frames.

use raxel_runtime::session::Session;

/// The passes that were seen, in the order in which they first ran.
#[derive(Default)]
pub struct Passes(Vec<String>);

impl Passes {
    /// Milliseconds of the last frame from the begin of its first pass to the end of its last, and of each pass: of those that have not
    /// run yet, nothing. The rounds of a loop count together.
    pub(super) fn take(&mut self, session: &mut Session) -> (Option<f64>, Vec<f64>) {
        let Some(plan) = session.plan().cloned() else { return (None, Vec::new()) };
        let times = session.gpu_times();
        let mut milliseconds = vec![0.0; self.0.len()];
        for time in times.passes {
            let Some(nanoseconds) = time.nanoseconds else { continue };
            let name = plan.graph.declared_name(time.pass);
            let index = self.0.iter().position(|known| known == name).unwrap_or_else(|| {
                self.0.push(name.to_owned());
                milliseconds.push(0.0);
                self.0.len() - 1
            });
            milliseconds[index] += nanoseconds / 1e6;
        }
        (times.span.map(|nanoseconds| nanoseconds / 1e6), milliseconds)
    }

    /// Their names, for the places of the milliseconds.
    pub(super) fn into_names(self) -> Vec<String> {
        self.0
    }
}
