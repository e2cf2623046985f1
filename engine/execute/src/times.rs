//! GPU times of the passes of a frame that the device has finished.

use raxel_gpu::QueueClock;
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
    /// Room for the times of a plan. No time is measured yet.
    pub(super) fn of_plan(plan: &Plan) -> Times {
        Times {
            passes: plan.passes.iter().map(|pass| PassTime { pass: pass.pass, nanoseconds: None }).collect(),
            ticks: vec![[0; 2]; 2 * plan.passes.len()],
            ..Times::default()
        }
    }

    /// The latest times that were read.
    pub(super) fn get(&self) -> GpuTimes<'_> {
        GpuTimes { frame: self.frame, span: self.span, passes: &self.passes }
    }

    /// Reads the times of a finished frame of the plan.
    pub(super) fn read(
        &mut self,
        slot: &FrameSlot,
        instrumentation: &Instrumentation,
        clock: QueueClock,
    ) -> Result<(), ExecuteError> {
        let Some(timestamps) = &instrumentation.timestamps[slot.index] else { return Ok(()) };
        timestamps.read(&mut self.ticks)?;
        self.frame = Some(slot.frame);
        // The first and the last time of the frame.
        let mut ends: Option<[u64; 2]> = None;
        self.passes.iter_mut().for_each(|time| time.nanoseconds = None);
        // Some drivers call the times of a frame before available still: only passes that were dispatched in this one count.
        for &pass in &slot.ran {
            let (Some(time), Some([begin, end])) =
                (self.passes.get_mut(pass as usize), self.ticks.get(2 * pass as usize..2 * pass as usize + 2))
            else {
                continue;
            };
            let there = begin[1] != 0 && end[1] != 0;
            time.nanoseconds = there.then(|| clock.nanoseconds(begin[0], end[0]).max(0.0));
            if there {
                let [first, last] = ends.get_or_insert([begin[0], end[0]]);
                if clock.nanoseconds(*first, begin[0]) < 0.0 {
                    *first = begin[0];
                }
                if clock.nanoseconds(*last, end[0]) > 0.0 {
                    *last = end[0];
                }
            }
        }
        self.span = ends.map(|[first, last]| clock.nanoseconds(first, last).max(0.0));
        if let Some(ends) = ends {
            self.trace(slot, &instrumentation.plan, ends, clock);
        }
        Ok(())
    }

    /// Reports the places of a frame's passes in it to traces.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate, and 2⁶⁴ nanoseconds are 584 years"
    )]
    fn trace(&self, slot: &FrameSlot, plan: &Plan, [first, last]: [u64; 2], clock: QueueClock) {
        if !tracing::enabled!(target: "raxel::gpu", tracing::Level::TRACE) {
            return;
        }
        let since = |tick: u64| clock.nanoseconds(first, tick) as u64;
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
