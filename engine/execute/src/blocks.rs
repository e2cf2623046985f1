//! The bytes of the push-constant and uniform blocks of all passes: constant ones are written once, the rest in each frame.

use std::ops::Range;

use raxel_graph::checked::{Builtin, ClockId, ClockValue, Fill, ParamId, PassId, Value, ValueOrigin};
use raxel_graph::plan::{CopySelector, Plan, Step};
use raxel_shader::interface::ByteRanges;

use super::digest::{self, Digest};
use super::inputs::FrameInputs;
use super::ticks::Ticks;
use super::values::{self, Member};

/// Uniform blocks start at multiples of this: the most that a device may ask for (`minUniformBufferOffsetAlignment`).
const UNIFORM_ALIGNMENT: usize = 256;

/// Where a pass's uniform block lies in the uniform bytes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct UniformPlace {
    pub(super) binding: u32,
    pub(super) offset: u64,
    pub(super) size: u64,
}

impl UniformPlace {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a uniform block is in memory that is mapped, which `usize` holds"
    )]
    fn bytes(&self) -> Range<usize> {
        self.offset as usize..(self.offset + self.size) as usize
    }
}

/// The blocks of all passes of a plan.
pub(super) struct Blocks {
    /// The uniform blocks of all passes, then the push constants of all passes.
    bytes: Vec<u8>,
    uniform_bytes: usize,
    passes: Vec<PassBlocks>,
    constants: Vec<(Range<usize>, Member, Value)>,
    changing: Vec<Changing>,
    /// Overrides were written over constants.
    overridden: bool,
    /// Scratch memory for the bytes that are hashed.
    scratch: Vec<u8>,
}

struct PassBlocks {
    /// The pass of the file that this is a round of, or that it is.
    declared: PassId,
    push: Range<usize>,
    uniforms: Vec<UniformPlace>,
    /// The bytes that its shader reads.
    reads: Vec<Range<usize>>,
}

/// A member whose value may differ from frame to frame.
struct Changing {
    /// The block that it is in.
    block: Range<usize>,
    member: Member,
    from: ChangingSource,
}

enum ChangingSource {
    Param(ParamId),
    Builtin(Builtin),
    /// Where the clock stands when the pass runs.
    Clock(CopySelector, ClockValue),
}

impl Blocks {
    /// With all constants written.
    #[expect(clippy::cast_possible_truncation, reason = "a plan numbers its passes in 32 bits")]
    pub(super) fn new(plan: &Plan) -> Blocks {
        let mut blocks = Blocks {
            bytes: Vec::new(),
            uniform_bytes: 0,
            passes: Vec::new(),
            constants: Vec::new(),
            changing: Vec::new(),
            overridden: false,
            scratch: Vec::new(),
        };
        let mut end = 0;
        for planned in &plan.passes {
            let pass = plan.graph.pass(planned.pass);
            let place = |block: &raxel_graph::checked::UniformBlock| {
                let place = UniformPlace { binding: block.binding, offset: end as u64, size: u64::from(block.size) };
                end = place.bytes().end.next_multiple_of(UNIFORM_ALIGNMENT);
                place
            };
            let uniforms = pass.uniforms.iter().map(place).collect();
            let declared = plan.graph.declared(planned.pass);
            blocks.passes.push(PassBlocks { declared, push: 0..0, uniforms, reads: Vec::new() });
        }
        blocks.uniform_bytes = end;
        for (index, planned) in plan.passes.iter().enumerate() {
            let pass = plan.graph.pass(planned.pass);
            let interface = &pass.shader.interface;
            let step = plan.steps.iter().position(|step| *step == Step::Dispatch { pass: index as u32 });
            let selector = |clock: ClockId| step.map_or(CopySelector::After(clock), |step| plan.clock_at(step, clock));
            let push = end..end + interface.push.as_ref().map_or(0, |block| block.size) as usize;
            end = push.end;
            blocks.add(plan, selector, &pass.push, &push);
            blocks.passes[index].reads.extend(within(&push, &interface.push_reads));
            for (block, place) in pass.uniforms.iter().zip(blocks.passes[index].uniforms.clone()) {
                blocks.add(plan, selector, &block.fills, &place.bytes());
                let reads = &interface.bindings[place.binding as usize].reads;
                blocks.passes[index].reads.extend(within(&place.bytes(), reads));
            }
            blocks.passes[index].push = push;
        }
        blocks.bytes = vec![0; end];
        let hashed = |pass: &PassBlocks| pass.reads.iter().map(Range::len).sum::<usize>();
        let most = blocks.passes.iter().map(hashed).max().unwrap_or(0);
        blocks.scratch.reserve(size_of::<Digest>() + most);
        blocks.write_constants();
        blocks
    }

    fn add(&mut self, plan: &Plan, selector: impl Fn(ClockId) -> CopySelector, fills: &[Fill], block: &Range<usize>) {
        for fill in fills {
            let from = match fill.from {
                ValueOrigin::Param(param) => ChangingSource::Param(param),
                ValueOrigin::Builtin(builtin) => ChangingSource::Builtin(builtin),
                ValueOrigin::Clock(clock, value) => ChangingSource::Clock(selector(clock), value),
                ValueOrigin::Value(_)
                | ValueOrigin::ExtentOf(_)
                | ValueOrigin::CountOf(_)
                | ValueOrigin::Material(_)
                | ValueOrigin::Round(_) => {
                    let value = plan.constant(&fill.from).unwrap_or(Value::U32(0));
                    self.constants.push((block.clone(), Member::of(fill), value));
                    continue;
                }
            };
            self.changing.push(Changing { block: block.clone(), member: Member::of(fill), from });
        }
    }

    fn write_constants(&mut self) {
        for (block, member, value) in &self.constants {
            values::write(&mut self.bytes[block.clone()], member, value);
        }
    }

    /// Writes the values of a frame.
    pub(super) fn fill(&mut self, plan: &Plan, inputs: &FrameInputs<'_>, ticks: &Ticks) {
        // A value that was overridden in the last frame may not be overridden in this one.
        if self.overridden {
            self.write_constants();
        }
        for changing in &self.changing {
            let value = match changing.from {
                ChangingSource::Builtin(builtin) => inputs.builtins.value(builtin),
                ChangingSource::Clock(selector, value) => ticks.value(selector, value),
                ChangingSource::Param(param) => {
                    let default = || plan.graph.params.get(param.0 as usize).map(|param| &param.default);
                    inputs.params.get(param.0 as usize).or_else(default).copied().unwrap_or(Value::U32(0))
                }
            };
            values::write(&mut self.bytes[changing.block.clone()], &changing.member, &value);
        }
        self.overridden = !inputs.overrides.is_empty();
        for over in inputs.overrides {
            for (state, planned) in
                self.passes.iter().zip(&plan.passes).filter(|(state, _)| state.declared == over.pass)
            {
                let pass = plan.graph.pass(planned.pass);
                let (block, fills) = match over.uniform {
                    None => (Some(state.push.clone()), Some(&pass.push)),
                    Some(block) => (
                        state.uniforms.get(block as usize).map(UniformPlace::bytes),
                        pass.uniforms.get(block as usize).map(|block| &block.fills),
                    ),
                };
                let fill = fills.and_then(|fills| fills.get(over.fill as usize));
                if let (Some(block), Some(fill)) = (block, fill) {
                    values::write(&mut self.bytes[block], &Member::of(fill), &over.value);
                }
            }
        }
    }

    /// The digest of `base` and of the bytes that the shader of a pass reads.
    pub(super) fn digest(&mut self, pass: usize, base: Digest) -> Digest {
        self.scratch.clear();
        self.scratch.extend_from_slice(&base.to_ne_bytes());
        for read in &self.passes[pass].reads {
            self.scratch.extend_from_slice(&self.bytes[read.clone()]);
        }
        digest::of_bytes(0, &self.scratch)
    }

    /// All uniform blocks, at their offsets in the uniform buffer.
    pub(super) fn uniforms(&self) -> &[u8] {
        &self.bytes[..self.uniform_bytes]
    }

    /// The push constants of a pass.
    pub(super) fn push(&self, pass: usize) -> &[u8] {
        &self.bytes[self.passes[pass].push.clone()]
    }

    /// Where the uniform blocks of a pass lie.
    pub(super) fn uniform_places(&self, pass: usize) -> &[UniformPlace] {
        &self.passes[pass].uniforms
    }

    /// The pass of the file that a pass of the plan is a round of, or that it is.
    pub(super) fn declared(&self, pass: usize) -> PassId {
        self.passes[pass].declared
    }
}

/// The parts of a block that a shader reads, as ranges of all bytes.
fn within(block: &Range<usize>, parts: &ByteRanges) -> impl Iterator<Item = Range<usize>> {
    let (start, end) = (block.start, block.end);
    let at = move |offset: u32| (start + offset as usize).min(end);
    parts.iter().map(move |[first, last]| at(first)..at(last))
}
