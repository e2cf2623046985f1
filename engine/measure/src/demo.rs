//! Times of a demo's frames and of their passes, for `raxel bench --demo` and the checks of `raxel test`.

use std::time::Instant;

use raxel_runtime::session::{FrameError, Session};
use raxel_runtime::timeline::{Claim, Demo};
use serde::Serialize;

use crate::Times;

/// GPU times of a pass over the frames in which it was dispatched.
#[derive(Clone, Debug, Serialize)]
pub struct PassTimes {
    /// Project path of its graph.
    pub graph: String,
    /// Its name; rounds of a loop are passes of their own.
    pub pass: String,
    /// One time a frame.
    #[serde(flatten)]
    pub times: Times,
}

/// Times of the frames of a session.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FrameTimes {
    /// From the start of a frame to the end of its picture on the device, waited for one by one.
    pub frame: Times,
    /// From the begin of a frame's first pass to the end of its last on the device; frames in which no pass ran are left out.
    pub gpu: Times,
    /// The passes in the order in which they first ran.
    pub passes: Vec<PassTimes>,
}

impl FrameTimes {
    /// Runs a frame and takes its times.
    pub fn frame(&mut self, session: &mut Session) -> Result<(), FrameError> {
        let start = Instant::now();
        session.frame()?;
        session.wait()?;
        self.frame.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        let Some(plan) = session.plan().cloned() else { return Ok(()) };
        let graph = session.graph_path().to_owned();
        let times = session.gpu_times();
        self.gpu.milliseconds.extend(times.span.map(|nanoseconds| nanoseconds / 1e6));
        for time in times.passes {
            let Some(nanoseconds) = time.nanoseconds else { continue };
            let name = &plan.graph.pass(time.pass).name;
            let known = self.passes.iter().position(|known| known.pass == *name && known.graph == graph);
            let index = known.unwrap_or(self.passes.len());
            if known.is_none() {
                self.passes.push(PassTimes { graph: graph.clone(), pass: name.clone(), times: Times::default() });
            }
            self.passes[index].times.milliseconds.push(nanoseconds / 1e6);
        }
        Ok(())
    }

    /// The outcomes of the demo's checks that are about passes: their indices with the median of the pass over all graphs, `None` when it
    /// never ran or the device has no clock.
    pub fn judge<'d>(&self, demo: &'d Demo) -> impl Iterator<Item = PassVerdict<'d>> {
        demo.checks.iter().enumerate().filter_map(|(index, check)| {
            let Claim::Pass { pass, below_ms } = &check.claim else { return None };
            let of = self.passes.iter().filter(|times| times.pass == pass.value);
            let all = Times { milliseconds: of.flat_map(|times| times.times.milliseconds.iter().copied()).collect() };
            let median_ms = Some(all.percentile(0.5)).filter(|median| median.is_finite());
            let holds = median_ms.is_some_and(|median| median < *below_ms);
            Some(PassVerdict { index, pass: &pass.value, median_ms, below_ms: *below_ms, holds })
        })
    }
}

/// The outcome of a check about a pass.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PassVerdict<'d> {
    /// Of the demo's checks.
    pub index: usize,
    /// Name of the pass.
    pub pass: &'d str,
    /// Median of its GPU times; `None` when it never ran, or the device has no clock.
    pub median_ms: Option<f64>,
    /// The bound.
    pub below_ms: f64,
    /// Whether the median is below it.
    pub holds: bool,
}
