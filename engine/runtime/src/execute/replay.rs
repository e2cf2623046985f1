//! The frame as a flat walk: values into bytes, the memo's decision, and the steps of the plan into a [`Recorder`]. Knows nothing
//! of the device; allocates nothing; looks nothing up by name.

use std::sync::Arc;

use raxel_graph::checked::{ClockId, Every, Fill, PassId, ResourceId, Source, Value};
use raxel_graph::plan::{Plan, Step, Turn};
use raxel_shader::interface::ByteRanges;

use super::inputs::FrameInputs;
use super::memo::{Memo, hash_bytes, mix};
use super::ticks::Ticks;
use super::values;

/// What a frame is recorded into: the device's command buffer, or nothing at all to measure the walk itself.
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

/// Where a pass's uniform block lies in the uniform bytes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct UniformPlace {
    pub(super) binding: u32,
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// What a walk recorded.
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
    /// The pass of the file that this is a round of, or that it is.
    declared: PassId,
    push: Vec<u8>,
    places: Vec<UniformPlace>,
    /// Hash of everything but the values: pipeline, workgroups, bindings.
    base: u64,
    /// For `every = { hz }`: the tick of the last run.
    tick: Option<i64>,
    due: bool,
    /// Where each clock of the graph stands when it runs.
    clocks: Vec<Turn>,
}

/// A plan made ready to be walked, with the state that lasts from frame to frame.
pub struct Replay {
    plan: Arc<Plan>,
    passes: Vec<Pass>,
    uniforms: Vec<u8>,
    keys: Vec<Option<u64>>,
    run: Vec<bool>,
    pub(super) memo: Memo,
    pub(super) ticks: Ticks,
    memo_on: bool,
    display: u64,
    any: bool,
}

/// Uniform blocks start at multiples of this: the most that a device may ask for (`minUniformBufferOffsetAlignment`).
const UNIFORM_ALIGNMENT: u64 = 256;

impl Replay {
    /// For a plan whose `init` contents are in place. `display` says how the debug target is shown: equal numbers, equal pictures.
    pub fn new(plan: &Arc<Plan>, display: u64) -> Replay {
        let mut end = 0;
        let passes: Vec<Pass> = plan
            .passes
            .iter()
            .enumerate()
            .map(|(index, planned)| {
                let pass = plan.graph.pass(planned.pass);
                let step = plan.steps.iter().position(|step| *step == Step::Dispatch { pass: index as u32 });
                let clocks = (0..plan.graph.clocks.len() as u32).map(ClockId);
                let clocks = clocks.map(|clock| step.map_or(Turn::After(clock), |step| plan.clock_at(step, clock)));
                let places = pass
                    .uniforms
                    .iter()
                    .map(|block| {
                        let place = UniformPlace { binding: block.binding, offset: end, size: u64::from(block.size) };
                        end = (end + place.size).next_multiple_of(UNIFORM_ALIGNMENT);
                        place
                    })
                    .collect();
                let bytes = pass.shader.interface.push.as_ref().map_or(0, |block| block.size);
                let key = hash_bytes(0, &pass.shader.key);
                let base =
                    format!("{:?}{:?}{:?}{:?}", planned.groups, pass.dispatch, pass.accesses, planned.specialization);
                Pass {
                    declared: plan.graph.declared(planned.pass),
                    push: vec![0; bytes as usize],
                    places,
                    base: hash_bytes(key, base.as_bytes()),
                    tick: None,
                    due: true,
                    clocks: clocks.collect(),
                }
            })
            .collect();
        Replay {
            keys: vec![None; passes.len()],
            run: vec![true; plan.steps.len()],
            memo: Memo::new(plan),
            memo_on: true,
            ticks: Ticks::new(&plan.graph),
            uniforms: vec![0; end as usize],
            any: true,
            plan: plan.clone(),
            passes,
            display,
        }
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    pub(super) fn uniform_places(&self, pass: usize) -> &[UniformPlace] {
        &self.passes[pass].places
    }

    pub(super) fn uniform_bytes(&self) -> u64 {
        self.uniforms.len() as u64
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

    /// Writes the frame's values and decides what runs. `frame` is the number that rotates histories. `false`: nothing need run.
    pub fn decide(&mut self, frame: u64, inputs: &FrameInputs<'_>) -> bool {
        self.ticks.advance(inputs.clock);
        self.schedule(inputs);
        self.fill(inputs);
        if self.memo_on {
            for (i, (pass, planned)) in self.passes.iter().zip(&self.plan.passes).enumerate() {
                let interface = &self.plan.graph.pass(planned.pass).shader.interface;
                self.keys[i] = pass.due.then(|| {
                    let pushed = hash_parts(pass.base, &pass.push, &interface.push_reads);
                    let blocks = pass.places.iter().fold(pushed, |hash, place| {
                        let block = &self.uniforms[place.offset as usize..(place.offset + place.size) as usize];
                        hash_parts(hash, block, &interface.bindings[place.binding as usize].reads)
                    });
                    mix(blocks, 1)
                });
            }
            self.run.copy_from_slice(self.memo.decide(frame, &self.ticks, &self.keys, self.display));
        } else {
            for (index, run) in self.run.iter_mut().enumerate() {
                let tick = self.plan.clock_of(index).zip(self.plan.tick_of(index));
                *run = tick.is_none_or(|(clock, tick)| self.ticks.is_due(clock, tick));
            }
        }
        self.any = self.plan.steps.iter().zip(&self.run).any(|(step, run)| match step {
            Step::Barrier(_) => false,
            Step::Dispatch { pass } => *run && self.passes[*pass as usize].due,
            Step::Copy { resource } => *run && self.memo.copy_due(*resource as usize).is_some(),
            Step::Clear { .. } | Step::Present => *run,
        });
        self.any
    }

    /// Records the steps that were decided to run. Barriers are recorded as planned, whichever passes run between them.
    pub fn walk<R: Recorder>(&self, recorder: &mut R) -> Counts {
        let mut counts = self.counts();
        if !self.any {
            return counts;
        }
        if !self.uniforms.is_empty() {
            recorder.uniforms(&self.uniforms);
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
                Step::Copy { resource } if *run && self.memo.copy_due(*resource as usize).is_some() => {
                    recorder.copy(*resource as usize);
                    counts.copies += 1;
                }
                Step::Dispatch { pass } if *run && self.passes[*pass as usize].due => {
                    let pass = *pass as usize;
                    recorder.bind(pass);
                    let push = &self.passes[pass].push;
                    if !push.is_empty() {
                        recorder.push(pass, push);
                    }
                    recorder.dispatch(pass);
                    counts.dispatched += 1;
                }
                Step::Present if *run => {
                    recorder.present();
                    counts.displayed = true;
                }
                Step::Clear { .. } | Step::Copy { .. } | Step::Dispatch { .. } | Step::Present => {}
            }
        }
        counts
    }

    /// The number that rotates the copies of a resource as the decided frame leaves it behind.
    pub(super) fn rotation_after(&self, frame: u64, resource: ResourceId) -> u64 {
        let turn = self.plan.graph.resource(resource).clock.map_or(Turn::Frame, Turn::After);
        self.ticks.rotation(frame, turn)
    }

    /// Skipped and idle passes of the decided frame.
    fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for (step, run) in self.plan.steps.iter().zip(&self.run) {
            if let Step::Dispatch { pass } = step {
                let due = self.passes[*pass as usize].due;
                counts.idle += u32::from(!due);
                counts.skipped += u32::from(due && !run);
            }
        }
        counts
    }

    /// Which passes are due in this frame.
    fn schedule(&mut self, inputs: &FrameInputs<'_>) {
        for (pass, planned) in self.passes.iter_mut().zip(&self.plan.passes) {
            let disabled = inputs.disabled.contains(&pass.declared);
            pass.due = !disabled
                && match self.plan.graph.pass(planned.pass).every {
                    None => true,
                    Some(Every::Frames(frames)) => {
                        let first = pass.tick.is_none();
                        pass.tick = Some(0);
                        first || inputs.builtins.frame_index.is_multiple_of(frames.max(1))
                    }
                    Some(Every::Still(frames)) => inputs.builtins.frame_still < frames,
                    Some(Every::Clock(clock)) => self.ticks.is_due(clock, planned.tick.unwrap_or(0)),
                    Some(Every::Hz(hz)) => {
                        let tick = (inputs.clock * hz).floor() as i64;
                        let due = pass.tick.is_none_or(|last| tick != last);
                        pass.tick = Some(tick);
                        due
                    }
                };
        }
    }

    /// Writes push constants and uniform blocks.
    fn fill(&mut self, inputs: &FrameInputs<'_>) {
        let Replay { plan, passes, uniforms, ticks, .. } = self;
        for (state, planned) in passes.iter_mut().zip(&plan.passes) {
            let pass = plan.graph.pass(planned.pass);
            let clocks = &state.clocks;
            let value = |fill: &Fill| match fill.from {
                Source::Clock(clock, of_clock) => ticks.value(clocks[clock.0 as usize], of_clock),
                _ => value(plan, fill, inputs),
            };
            for fill in &pass.push {
                values::write(&mut state.push, fill, &value(fill));
            }
            for (block, place) in pass.uniforms.iter().zip(&state.places) {
                let bytes = &mut uniforms[place.offset as usize..(place.offset + place.size) as usize];
                for fill in &block.fills {
                    values::write(bytes, fill, &value(fill));
                }
            }
            for over in inputs.overrides.iter().filter(|over| over.pass == state.declared) {
                match over.uniform {
                    None => {
                        if let Some(fill) = pass.push.get(over.fill as usize) {
                            values::write(&mut state.push, fill, &over.value);
                        }
                    }
                    Some(block) => {
                        let fill = pass.uniforms.get(block as usize).and_then(|b| b.fills.get(over.fill as usize));
                        if let (Some(fill), Some(place)) = (fill, state.places.get(block as usize)) {
                            let bytes = &mut uniforms[place.offset as usize..(place.offset + place.size) as usize];
                            values::write(bytes, fill, &over.value);
                        }
                    }
                }
            }
        }
    }
}

/// Hash of the parts of a block that a shader reads.
fn hash_parts(seed: u64, block: &[u8], parts: &ByteRanges) -> u64 {
    parts.iter().fold(mix(seed, block.len() as u64), |hash, [start, end]| {
        let end = block.len().min(end as usize);
        hash_bytes(hash, &block[end.min(start as usize)..end])
    })
}

fn value(plan: &Plan, fill: &Fill, inputs: &FrameInputs<'_>) -> Value {
    match fill.from {
        Source::Param(param) => inputs
            .params
            .get(param.0 as usize)
            .or_else(|| plan.graph.params.get(param.0 as usize).map(|param| &param.default))
            .copied()
            .unwrap_or(Value::U32(0)),
        Source::Builtin(builtin) => inputs.builtins.value(builtin),
        // Known where the pass stands: see `Replay::fill`.
        Source::Clock(..) => Value::U32(0),
        Source::Value(_) | Source::ExtentOf(_) | Source::CountOf(_) | Source::Material(_) | Source::Round(_) => {
            plan.constant(&fill.from).unwrap_or(Value::U32(0))
        }
    }
}
