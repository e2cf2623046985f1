//! The plan: the immutable result of compiling a graph for one output size, one present point and one state of the conditions.
//! A frame is the walk over [`Plan::steps`]; everything in it is an index or a number.
//!
//! Synchronisation model. All passes run on one queue in program order. Images stay in `GENERAL` from their creation on. A gap
//! between two steps holds at most one [`Barrier`], recorded as one `vkCmdPipelineBarrier2`: at most one global memory barrier (a
//! compute graph has no use for narrower ones: no layout changes, and execution dependencies are never per resource), and one
//! image barrier per aliased image that becomes live there (`UNDEFINED` → `GENERAL`). The plan is cyclic: barriers also cover the
//! hazards of a frame with the frames before it, so that frames follow each other with no barrier of their own in between. A pass
//! that does not run in a frame (`every`, or its result is still valid) leaves its barriers in place, which keeps all others covered.

use std::fmt;
use std::sync::Arc;

use bitflags::bitflags;
use raxel_shader::format::Format;
use serde::Serialize;

use crate::ir::checked::{BoundAccess, Clear, ClockId, Graph, PassId, ResourceId, Value, ValueOrigin};
use crate::ir::index::index32;
pub use crate::ir::input::{
    BindingLimits, DeviceLimits, MemoryModel, Observe, PlanInput, Present, Requirements, SourceSize, WorldInput,
    copy_name,
};
use crate::ir::size::Size;
use crate::ir::subresources::SubresourceRange;

/// The image of each copy of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct ImageDesc {
    /// Texel format.
    pub format: Format,
    /// 3-D image; else 2-D.
    pub volume: bool,
    /// Texels of mip 0; the third is 1 unless `volume`.
    pub extent: [u32; 3],
    /// Mips.
    pub mips: u32,
    /// Array layers.
    pub layers: u32,
    /// Usages beyond transfer source and destination, which every image has.
    pub usage: ImageUsage,
}

/// Usages derived from the accesses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct ImageUsage {
    /// Bound as a storage image.
    pub storage: bool,
    /// Bound as a sampled image.
    pub sampled: bool,
}

/// The buffer of each copy of a buffer. All buffers have storage and transfer usage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct BufferDesc {
    /// Bytes.
    pub size: u64,
    /// Bound as a uniform buffer.
    pub uniform: bool,
    /// Read as indirect arguments.
    pub indirect: bool,
}

/// The immutable result of compiling a graph.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// The graph it was made from, its loops written out: [`Graph::declared`] leads back to the passes of the file.
    #[serde(skip)]
    pub graph: Arc<Graph>,
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// The debug target.
    pub present: Present,
    /// The created resources: only those that live passes, the present point or pins use. Order of [`Graph::resources`].
    pub resources: Vec<ResourcePlan>,
    /// Memory blocks that transient resources share.
    pub blocks: Vec<BlockPlan>,
    /// Sizes of all resources of the graph, created or not, in order of [`Graph::resources`].
    #[serde(skip)]
    pub sizes: Vec<Size>,
    /// Indices of the materials that the graph names, in order of [`Graph::materials`].
    pub materials: Vec<u32>,
    /// Live passes in program order, those of a clock once for each tick that a frame may catch up.
    pub passes: Vec<PassPlan>,
    /// Where the ticks of each clock are, in order of [`Graph::clocks`].
    pub clocks: Vec<ClockPlan>,
    /// Passes that are left out, with the reason.
    pub culled: Vec<Culled>,
    /// The frame.
    pub steps: Vec<Step>,
    /// Barriers in front of the steps in a frame in which the runtime writes parts of sources.
    pub updates: SourceUpdates,
    /// Whether a frame depends on more of the frames before it than the camera of the last one. If not, any frame can be made without those
    /// before it.
    #[serde(skip)]
    pub uses_history: bool,
}

/// How writes of sources by the runtime are ordered. A frame that has some records `before`, the writes and `after`, and then the steps
/// with their own barriers, which know nothing of updates. All of it is on the queue of the frames, so nothing waits on the CPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceUpdates {
    /// From earlier frames' uses of sources to the writes.
    pub before: Dependency,
    /// From the writes to the uses of sources by this frame and later ones. Empty when nothing uses any.
    pub after: Dependency,
}

impl SourceUpdates {
    /// From a write to a later one in the same frame that meets it.
    pub const BETWEEN: Dependency = Dependency {
        src: Scope { stages: Stages::CLEAR, access: AccessMask::TRANSFER_WRITE },
        dst: Scope { stages: Stages::CLEAR, access: AccessMask::TRANSFER_WRITE },
    };
}

/// The ticks of a clock in a frame: steps in a row, tick after tick. A frame with n ticks due runs the first n of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ClockPlan {
    /// The first of the steps (index into [`Plan::steps`]).
    pub first: u32,
    /// One past the last; equal to `first` when the clock has nothing to do.
    pub end: u32,
}

/// The counter that selects the current copy of a resource at one step: copy `counter % copies` is the current one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum CopySelector {
    /// The number of the frame.
    Frame,
    /// In front of the ticks of a clock: the number of the last tick that an earlier frame ran.
    Before(ClockId),
    /// In tick i of a clock in this frame: the number of that tick.
    Tick(ClockId, u32),
    /// Behind the ticks of a clock: the number of the last tick that ran.
    After(ClockId),
}

impl Plan {
    /// The value of a source that stays the same while the plan runs; `None` for a value that changes from frame to frame.
    pub fn constant(&self, source: &ValueOrigin) -> Option<Value> {
        crate::ir::size::constant(source, &self.sizes, &self.materials)
    }

    /// A pass that writes this mip and layer (or slice) of a resource and was culled because nothing shown depends on it: the resource does
    /// not hold the graph's result.
    pub fn culled_writer(&self, resource: ResourceId, mip: u32, layer: u32) -> Option<PassId> {
        let unused = self.culled.iter().filter(|culled| culled.reason == CullReason::Unused);
        unused.map(|culled| culled.pass).find(|&pass| self.may_write(pass, resource, mip, layer))
    }

    /// Whether a pass has write access to this mip and layer (or slice) of a resource.
    pub fn may_write(&self, pass: PassId, resource: ResourceId, mip: u32, layer: u32) -> bool {
        let size = &self.sizes[resource.0 as usize];
        // The slices of a volume are one subresource.
        let layer = if matches!(size, Size::Image { volume: true, .. }) { 0 } else { layer };
        let sought = SubresourceRange::one(mip, layer);
        let writes = |access: &BoundAccess| {
            access.resource == resource
                && access.access.writes()
                && SubresourceRange::of(access, size).overlaps(&sought)
        };
        self.graph.pass(pass).accesses.iter().any(writes)
    }

    /// Whether lists of passes show this one: of the cases of a name, the one that the plan runs, else the first.
    pub fn shows(&self, pass: PassId) -> bool {
        let cases = || self.graph.cases(&self.graph.pass(pass).name);
        let runs = |case: &PassId| self.passes.iter().any(|planned| planned.pass == *case);
        cases().find(runs).or_else(|| cases().next()) == Some(pass)
    }

    /// Which counter selects the current copy of a resource at a step.
    pub fn selector(&self, step: usize, resource: ResourceId) -> CopySelector {
        self.graph.resource(resource).clock.map_or(CopySelector::Frame, |clock| self.clock_at(step, clock))
    }

    /// Where a clock stands at a step.
    pub fn clock_at(&self, step: usize, clock: ClockId) -> CopySelector {
        let planned = self.clocks[clock.0 as usize];
        if index32(step) < planned.first {
            return CopySelector::Before(clock);
        }
        match self.tick_of(step) {
            Some(tick) if index32(step) < planned.end => CopySelector::Tick(clock, tick),
            _ => CopySelector::After(clock),
        }
    }

    /// The index of the step's tick among the frame's ticks of its clock, if it has one.
    pub fn tick_of(&self, step: usize) -> Option<u32> {
        match self.steps[step] {
            Step::Clear { tick, .. } => tick,
            Step::Dispatch { pass } => self.passes[pass as usize].tick,
            Step::Barrier(_) | Step::Copy { .. } | Step::Present => None,
        }
    }

    /// The clock whose tick a step belongs to.
    pub fn clock_of(&self, step: usize) -> Option<ClockId> {
        self.tick_of(step)?;
        let within = |planned: &ClockPlan| (planned.first..planned.end).contains(&index32(step));
        self.clocks.iter().position(within).map(|clock| ClockId(index32(clock)))
    }
}

/// One resource that exists while the plan runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResourcePlan {
    /// Which.
    pub resource: ResourceId,
    /// The object that is created for each copy.
    pub desc: ResourceDesc,
    /// The memory of each copy, as [`PlanInput::memory`] requires it; for a source only its bytes.
    pub memory: Requirements,
    /// `history + 1` copies; frame (or tick) f writes copy f mod copies, and `@n` reads copy (f − n) mod copies. See [`CopySelector`].
    pub copies: u32,
    /// Contents at the start of each frame, if it is cleared (or filled for [`PlanInput::poison`]).
    pub clear: Option<Clear>,
    /// The source that it is filled from, if it is a copy of one, e.g. `world.octree`.
    pub copy: Option<String>,
    /// Contents at creation and on reset.
    pub init: Clear,
    /// Whether the contents must survive the frame.
    pub lifetime: Lifetime,
    /// Whether they depend on the camera, the cursor, the frame or a clock. Contents that do not are the same in most frames, and are kept
    /// apart, so that they need not be made again.
    pub varies: bool,
}

/// Image or buffer, made or supplied.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ResourceDesc {
    /// An image.
    Image(ImageDesc),
    /// A buffer.
    Buffer(BufferDesc),
    /// A buffer that the runtime supplies under this name.
    Source(String),
    /// An image that the runtime supplies under this name.
    SourceImage(String, ImageDesc),
}

/// The time for which the contents of a resource matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Lifetime {
    /// From frame to frame: it has memory of its own.
    Persistent,
    /// From its first to its last step in a frame; memory may be shared.
    Transient {
        /// First step (index into [`Plan::steps`]) that accesses it.
        first: u32,
        /// Last step that accesses it.
        last: u32,
        /// Its place, or `None` when it has memory of its own.
        place: Option<BlockOffset>,
    },
}

/// A place in a shared memory block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BlockOffset {
    /// Index into [`Plan::blocks`].
    pub block: u32,
    /// Byte offset in it.
    pub offset: u64,
}

/// A memory block shared by transient resources.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BlockPlan {
    /// Bytes.
    pub size: u64,
    /// Alignment of the block.
    pub alignment: u64,
    /// Memory types that suit every occupant.
    pub type_bits: u32,
}

/// A pass that runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassPlan {
    /// Which.
    pub pass: PassId,
    /// The number of the tick among those that the frame catches up, for a pass of a clock; it runs when at least that many are due.
    pub tick: Option<u32>,
    /// Workgroups, or `None` for an indirect dispatch.
    pub groups: Option<[u32; 3]>,
    /// Specialization constants that the graph sets, by id.
    pub specialization: Vec<(u32, Value)>,
}

/// A pass that is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Culled {
    /// Which.
    pub pass: PassId,
    /// Why.
    pub reason: CullReason,
}

/// Why a pass is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CullReason {
    /// Nothing presented depends on its output, and it leaves nothing for later frames.
    Unused,
    /// Its `when` does not hold.
    Condition,
}

/// One step of a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Step {
    /// One `vkCmdPipelineBarrier2`.
    Barrier(Barrier),
    /// `vkCmdClearColorImage` of all mips and layers, or `vkCmdFillBuffer`, of this frame's copy.
    Clear {
        /// Index into [`Plan::resources`].
        resource: u32,
        /// The tick at whose start it is cleared, for a resource with a clock.
        tick: Option<u32>,
    },
    /// `vkCmdCopyBuffer`, or `vkCmdCopyImage` of all mips, from the source of a copy ([`ResourcePlan::copy`]). Runs in frames in which the
    /// source has changed since the last time, and after creation and reset; its barriers are there in every frame.
    Copy {
        /// Index into [`Plan::resources`].
        resource: u32,
    },
    /// A dispatch.
    Dispatch {
        /// Index into [`Plan::passes`].
        pass: u32,
    },
    /// The debug target is read by a compute dispatch of the runtime (as a sampled image or storage buffer).
    Present,
}

/// One batched barrier.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Barrier {
    /// The global memory barrier; `None` when only images become live.
    pub memory: Option<Dependency>,
    /// Images that take over shared memory here, `UNDEFINED` → `GENERAL`.
    pub activate: Vec<Activation>,
    /// The hazards that it was placed for, for `raxel graph`. Not needed to run.
    pub hazards: Vec<Hazard>,
}

/// Scopes of a dependency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Dependency {
    /// First scope.
    pub src: Scope,
    /// Second scope.
    pub dst: Scope,
}

/// Stages and accesses. Accesses are empty in a pure execution dependency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Scope {
    /// `COMPUTE_SHADER`, `CLEAR`, `DRAW_INDIRECT`.
    pub stages: Stages,
    /// `SHADER_STORAGE_READ`, `SHADER_STORAGE_WRITE`, …
    pub access: AccessMask,
}

bitflags! {
    /// Pipeline stages that a plan uses, by their Vulkan names.
    #[derive(Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub struct Stages: u32 {
        /// Dispatches.
        const COMPUTE_SHADER = 1;
        /// Image clears, buffer fills, copies, and updates of sources.
        const CLEAR = 2;
        /// Fetch of indirect arguments.
        const DRAW_INDIRECT = 4;
    }
}

bitflags! {
    /// Accesses that a plan uses, by their Vulkan names.
    #[derive(Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub struct AccessMask: u32 {
        /// Storage image or storage buffer load.
        const SHADER_STORAGE_READ = 1;
        /// Storage image or storage buffer store.
        const SHADER_STORAGE_WRITE = 2;
        /// Sampled image fetch.
        const SHADER_SAMPLED_READ = 4;
        /// Uniform buffer load.
        const UNIFORM_READ = 8;
        /// Clear, fill, copy or update.
        const TRANSFER_WRITE = 16;
        /// Fetch of indirect arguments.
        const INDIRECT_COMMAND_READ = 32;
        /// The source of a copy.
        const TRANSFER_READ = 64;
    }
}

/// `A|B`, or `NONE`: in text, in JSON and in debug output alike.
macro_rules! names_joined {
    ($($flags:ident)*) => {$(
        impl fmt::Display for $flags {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                if self.is_empty() {
                    return f.write_str("NONE");
                }
                for (i, (name, _)) in self.iter_names().enumerate() {
                    write!(f, "{}{name}", if i > 0 { "|" } else { "" })?;
                }
                Ok(())
            }
        }

        impl fmt::Debug for $flags {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{self}")
            }
        }

        impl Serialize for $flags {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }
    )*};
}
names_joined!(Stages AccessMask);

/// An aliased resource that becomes live. For an image it is recorded as an image barrier `UNDEFINED` → `GENERAL` over all of its mips and
/// layers; for a buffer the same dependency is part of the memory barrier and this entry is only the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Activation {
    /// Index into [`Plan::resources`].
    pub resource: u32,
    /// Accesses of the former occupants → first accesses of this one.
    pub dependency: Dependency,
}

/// Why a barrier is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Hazard {
    /// The resource (of the later access).
    pub resource: ResourceId,
    /// Kind.
    pub kind: HazardKind,
    /// The earlier step's pass, or `None` for a clear or the present read.
    pub from: Option<PassId>,
    /// The later step's pass, or `None` for a clear or the present read.
    pub to: Option<PassId>,
    /// The earlier access is in a former frame.
    pub wraps: bool,
}

/// Kind of a hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum HazardKind {
    /// A load after a store.
    ReadAfterWrite,
    /// A store after a load.
    WriteAfterRead,
    /// A store after a store.
    WriteAfterWrite,
    /// Memory taken over from another resource.
    Alias,
}
