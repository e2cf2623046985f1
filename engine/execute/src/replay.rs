//! The frame as a flat walk: values into bytes, the memo's decision, and the steps of the plan into a [`Recorder`]. Knows nothing
//! of the device; allocates nothing; looks nothing up by name.

use std::sync::Arc;

use raxel_graph::checked::{ClockId, Every, PassId, ResourceId};
use raxel_graph::plan::{CopySelector, PassPlan, Plan, Step};

use super::blocks::{Blocks, UniformPlace};
use super::digest::{self, Digest};
use super::inputs::FrameInputs;
use super::memo::Memo;
use super::pipelines;
use super::report::PassOutcome;
use super::ticks::Ticks;
use crate::moment::Fraction;

/// The receiver of a frame's commands: the device's command buffer, or nothing at all to measure the walk itself.
pub trait Recorder {
    /// The bytes of all uniform blocks of the frame, at their offsets in the uniform buffer.
    fn uniforms(&mut self, bytes: &[u8]);
    /// The barrier at a step.
    fn barrier(&mut self, step: usize);
    /// The clear of a resource's current copy (index into the plan's resources) at a step.
    fn clear(&mut self, step: usize, resource: usize);
    /// The copy of a source's contents (index into the plan's resources).
    fn copy(&mut self, resource: usize);
    /// Pipeline and descriptors of a pass (index into the plan's passes).
    fn bind(&mut self, pass: usize);
    /// The push constants of the bound pass.
    fn push(&mut self, pass: usize, bytes: &[u8]);
    /// The dispatch of the bound pass.
    fn dispatch(&mut self, pass: usize);
    /// The display of the debug target.
    fn present(&mut self);
}

/// The commands that a walk recorded, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Dispatches, the display's not counted.
    pub dispatched: u32,
    /// Passes whose results are still valid.
    pub skipped: u32,
    /// Passes that are not due or disabled.
    pub idle: u32,
    /// Barriers.
    pub barriers: u32,
    /// Clears.
    pub clears: u32,
    /// Copies of sources that were filled.
    pub copies: u32,
    /// The debug target was displayed.
    pub displayed: bool,
}

struct Pass {
    every: Option<Every>,
    /// Of `every = { hz }`.
    rate: Fraction,
    /// For `every = { hz }`: the tick of the last run.
    tick: Option<u64>,
    /// `tick` as the frame before left it.
    before: Option<u64>,
    due: bool,
    /// Digest of everything but the values: pipeline, workgroups, bindings.
    base: Digest,
    /// The same with the sizes of bound resources: a shader can ask for them.
    sized: Digest,
}

/// A plan made ready to be walked, with the state that lasts from frame to frame.
pub struct Replay {
    plan: Arc<Plan>,
    passes: Vec<Pass>,
    blocks: Blocks,
    keys: Vec<Option<Digest>>,
    /// By step: it is recorded, if anything is.
    run: Vec<bool>,
    /// The steps that belong to a tick.
    ticking: Vec<(usize, ClockId, u32)>,
    pub(super) memo: Memo,
    pub(super) ticks: Ticks,
    memo_on: bool,
    display: Digest,
    any: bool,
}

impl Replay {
    /// For a plan whose `init` contents are in place. `display` is a digest of the display of the debug target: equal numbers, equal
    /// pictures.
    pub fn new(plan: &Arc<Plan>, display: u128) -> Replay {
        let pass = |planned: &PassPlan| {
            let pass = plan.graph.pass(planned.pass);
            let pipeline = pipelines::key(pass, &planned.specialization);
            let base = digest::of_value(0, &(pipeline, planned.groups, &pass.dispatch, &pass.accesses));
            let sizes: Vec<_> = pass.accesses.iter().map(|access| plan.sizes[access.resource.0 as usize]).collect();
            let sized = digest::of_value(0, &(base, sizes));
            let rate = if let Some(Every::Hz(hz)) = pass.every { Fraction::of(hz) } else { Fraction::ZERO };
            Pass { every: pass.every, rate, tick: None, before: None, due: true, base, sized }
        };
        let ticking = |step: usize| Some((step, plan.clock_of(step)?, plan.tick_of(step)?));
        Replay {
            passes: plan.passes.iter().map(pass).collect(),
            blocks: Blocks::new(plan),
            keys: vec![None; plan.passes.len()],
            run: vec![true; plan.steps.len()],
            ticking: (0..plan.steps.len()).filter_map(ticking).collect(),
            memo: Memo::new(plan),
            memo_on: true,
            ticks: Ticks::new(&plan.graph),
            any: true,
            plan: plan.clone(),
            display,
        }
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// How the debug target is shown from now on; equal numbers, equal pictures.
    pub(super) fn set_display(&mut self, display: Digest) {
        self.display = display;
    }

    pub(super) fn uniform_places(&self, pass: usize) -> &[UniformPlace] {
        self.blocks.uniform_places(pass)
    }

    pub(super) fn uniform_bytes(&self) -> u64 {
        self.blocks.uniforms().len() as u64
    }

    /// Whether results that are still valid are kept (on at first), or every pass runs in every frame.
    pub fn set_memo(&mut self, on: bool) {
        if on && !self.memo_on {
            self.memo.forget();
        }
        self.memo_on = on;
    }

    /// Nothing is in place any more but `init`: everything runs in the next frame, passes with `every` too.
    pub fn reset(&mut self) {
        self.memo.forget();
        self.ticks.reset();
        for pass in &mut self.passes {
            pass.tick = None;
        }
    }

    /// Takes over when passes of the same name ran last, so that a swap does not make `every` fire.
    pub(super) fn carry_ticks(&mut self, old: &Replay) {
        self.ticks.carry(&old.ticks);
        for (pass, planned) in self.passes.iter_mut().zip(&self.plan.passes) {
            let now = self.plan.graph.pass(planned.pass);
            let before =
                old.plan.passes.iter().zip(&old.passes).find(|(p, _)| old.plan.graph.pass(p.pass).name == now.name);
            if let Some((before, state)) = before {
                // A pass that was edited runs at once.
                if old.plan.graph.pass(before.pass).every == now.every && state.base == pass.base {
                    pass.tick = state.tick;
                }
            }
        }
    }

    /// Writes the frame's values and decides which passes run. `frame` is the number that rotates histories. `false`: nothing need run.
    pub fn decide(&mut self, frame: u64, inputs: &FrameInputs<'_>) -> bool {
        self.ticks.advance(inputs.clock);
        self.schedule(inputs);
        self.blocks.fill(&self.plan, inputs, &self.ticks);
        if self.memo_on {
            for (index, (pass, key)) in self.passes.iter().zip(&mut self.keys).enumerate() {
                *key = pass.due.then(|| self.blocks.digest(index, pass.sized));
            }
            self.run.copy_from_slice(self.memo.decide(frame, &self.ticks, &self.keys, self.display));
        } else {
            self.run.fill(true);
            for &(step, clock, tick) in &self.ticking {
                self.run[step] = self.ticks.is_due(clock, tick);
            }
        }
        self.any = false;
        for (step, run) in self.plan.steps.iter().zip(&mut self.run) {
            match step {
                Step::Barrier(_) => continue,
                Step::Dispatch { pass } => *run &= self.passes[*pass as usize].due,
                Step::Copy { resource } => *run &= self.memo.copy_due(*resource as usize).is_some(),
                Step::Clear { .. } | Step::Present => {}
            }
            self.any |= *run;
        }
        self.any
    }

    /// The frame that was decided has not been: it was never submitted.
    pub(super) fn undo(&mut self) {
        self.ticks.undo();
        self.memo.forget();
        for pass in &mut self.passes {
            pass.tick = pass.before;
        }
    }

    /// Records the steps that were decided to run. Barriers are recorded as planned, whichever passes run between them.
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes in 32 bits")]
    pub fn walk<R: Recorder>(&self, recorder: &mut R) -> Counts {
        let mut counts = Counts::default();
        if !self.any {
            let due = self.passes.iter().filter(|pass| pass.due).count() as u32;
            return Counts { skipped: due, idle: self.passes.len() as u32 - due, ..counts };
        }
        if !self.blocks.uniforms().is_empty() {
            recorder.uniforms(self.blocks.uniforms());
        }
        for (index, (step, run)) in self.plan.steps.iter().zip(&self.run).enumerate() {
            match step {
                Step::Barrier(_) => {
                    recorder.barrier(index);
                    counts.barriers += 1;
                }
                Step::Clear { resource, .. } if *run => {
                    recorder.clear(index, *resource as usize);
                    counts.clears += 1;
                }
                Step::Copy { resource } if *run => {
                    recorder.copy(*resource as usize);
                    counts.copies += 1;
                }
                Step::Dispatch { pass } if *run => {
                    let pass = *pass as usize;
                    recorder.bind(pass);
                    let push = self.blocks.push(pass);
                    if !push.is_empty() {
                        recorder.push(pass, push);
                    }
                    recorder.dispatch(pass);
                    counts.dispatched += 1;
                }
                Step::Dispatch { pass } if self.passes[*pass as usize].due => counts.skipped += 1,
                Step::Dispatch { .. } => counts.idle += 1,
                Step::Present if *run => {
                    recorder.present();
                    counts.displayed = true;
                }
                Step::Clear { .. } | Step::Copy { .. } | Step::Present => {}
            }
        }
        counts
    }

    /// The number that rotates the copies of a resource as the decided frame leaves it behind.
    pub(super) fn rotation_after(&self, frame: u64, resource: ResourceId) -> u64 {
        let selector = self.plan.graph.resource(resource).clock.map_or(CopySelector::Frame, CopySelector::After);
        self.ticks.rotation(frame, selector)
    }

    /// The outcome of each pass in the decided frame; order of the plan's passes. `disabled` are the passes that are switched off.
    pub(super) fn outcomes(&self, disabled: &[PassId]) -> Vec<PassOutcome> {
        let mut outcomes = vec![PassOutcome::NotDue; self.passes.len()];
        for (step, run) in self.plan.steps.iter().zip(&self.run) {
            if let Step::Dispatch { pass } = step {
                let state = &self.passes[*pass as usize];
                outcomes[*pass as usize] = match (state.due, run) {
                    _ if disabled.contains(&self.blocks.declared(*pass as usize)) => PassOutcome::Off,
                    (false, _) => PassOutcome::NotDue,
                    (true, true) => PassOutcome::Dispatched,
                    (true, false) => PassOutcome::Skipped,
                };
            }
        }
        outcomes
    }

    /// Which passes are due in this frame.
    fn schedule(&mut self, inputs: &FrameInputs<'_>) {
        for (index, (pass, planned)) in self.passes.iter_mut().zip(&self.plan.passes).enumerate() {
            pass.before = pass.tick;
            let disabled = inputs.disabled.contains(&self.blocks.declared(index));
            pass.due = !disabled
                && match pass.every {
                    None => true,
                    Some(Every::Frames(frames)) => {
                        let first = pass.tick.is_none();
                        pass.tick = Some(0);
                        first || inputs.builtins.frame_index.is_multiple_of(frames.max(1))
                    }
                    Some(Every::Still(frames)) => inputs.builtins.frame_still < frames,
                    Some(Every::Clock(clock)) => self.ticks.is_due(clock, planned.tick.unwrap_or(0)),
                    Some(Every::Hz(_)) => {
                        let (tick, _) = inputs.clock.tick(pass.rate);
                        let due = pass.tick.is_none_or(|last| tick != last);
                        pass.tick = Some(tick);
                        due
                    }
                };
        }
    }
}
