//! GPU times of the passes of a frame that the device has finished.

use raxel_graph::plan::Plan;

use super::error::ExecuteError;
use super::instrumentation::Instrumentation;
use super::report::{GpuTimes, PassTime};
use super::slot::FrameSlot;

/// The times of the passes of a plan, in the last frame that was read.
#[derive(Default)]
pub(super) struct Times {
    passes: Vec<PassTime>,
    /// Nanoseconds from the begin of the first pass to the end of the last.
    span: Option<f64>,
    /// The frame that they are of.
    frame: Option<u64>,
    /// Before and after each pass: a tick, and 0 or 1 for whether it was taken.
    ticks: Vec<[u64; 2]>,
}

impl Times {
    /// Room for the times of a plan, none of which was measured yet.
    pub(super) fn of_plan(plan: &Plan) -> Times {
        Times {
            passes: plan.passes.iter().map(|pass| PassTime { pass: pass.pass, nanoseconds: None }).collect(),
            ticks: vec![[0; 2]; 2 * plan.passes.len()],
            ..Times::default()
        }
    }

    /// What was read last.
    pub(super) fn get(&self) -> GpuTimes<'_> {
        GpuTimes { frame: self.frame, span: self.span, passes: &self.passes }
    }

    /// Reads the times of a finished frame of the plan. `period` is the length of a tick in nanoseconds.
    pub(super) fn read(
        &mut self,
        slot: &FrameSlot,
        instrumentation: &Instrumentation,
        period: f64,
    ) -> Result<(), ExecuteError> {
        let Some(timestamps) = &instrumentation.timestamps[slot.index] else { return Ok(()) };
        timestamps.read(&mut self.ticks)?;
        self.frame = Some(slot.frame);
        let (mut first, mut last) = (u64::MAX, 0);
        self.passes.iter_mut().for_each(|time| time.nanoseconds = None);
        // Some drivers call the times of a frame before available still: only what was dispatched in this one counts.
        for &pass in &slot.ran {
            let (Some(time), Some([begin, end])) =
                (self.passes.get_mut(pass as usize), self.ticks.get(2 * pass as usize..2 * pass as usize + 2))
            else {
                continue;
            };
            let there = begin[1] != 0 && end[1] != 0;
            time.nanoseconds = there.then(|| end[0].saturating_sub(begin[0]) as f64 * period);
            if there {
                (first, last) = (first.min(begin[0]), last.max(end[0]));
            }
        }
        self.span = (first <= last).then(|| (last - first) as f64 * period);
        if first <= last {
            self.trace(slot, &instrumentation.plan, first, last, period);
        }
        Ok(())
    }

    /// Tells who listens to traces where the passes of a frame lie in it.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate, and 2⁶⁴ nanoseconds are 584 years"
    )]
    fn trace(&self, slot: &FrameSlot, plan: &Plan, first: u64, last: u64, period: f64) {
        if !tracing::enabled!(target: "raxel::gpu", tracing::Level::TRACE) {
            return;
        }
        let since = |tick: u64| (tick.saturating_sub(first) as f64 * period) as u64;
        let (frame, ago_ns) = (slot.frame, slot.submitted.elapsed().as_nanos() as u64);
        tracing::trace!(target: "raxel::gpu", frame, ago_ns, begin_ns = 0_u64, end_ns = since(last));
        for (time, ticks) in self.passes.iter().zip(self.ticks.chunks_exact(2)) {
            if time.nanoseconds.is_some() {
                let pass = plan.graph.pass(time.pass).name.as_str();
                let (begin_ns, end_ns) = (since(ticks[0][0]), since(ticks[1][0]));
                tracing::trace!(target: "raxel::gpu", frame, pass, begin_ns, end_ns);
            }
        }
    }
}
