//! The checked graph: the front end (parse → resolve → reflect → check) hands it to the back end (cull → order → lifetimes → alias →
//! barriers). Names are gone but for messages; every reference is a typed index; every access is known. It depends only on the files, not
//! on the output size, the device or the state of conditions.

mod declaration;
mod fill;
mod loops;
mod resource;

pub use fill::{Builtin, ClockValue, Fill, UniformBlock, ValueOrigin};
pub use loops::accesses_of_round;
pub use loops::{InLoop, Loop, LoopId, MOST_ROUNDS, Round, RoundIndex, Rounds, count_of};
pub use resource::{
    Buffer, BufferSize, Clear, Display, DisplayMap, Extent, Origin, Resource, ResourceKind, Target, Values, Warning,
};

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::Span;
use raxel_shader::Shader;
use raxel_shader::interface::Access;
use serde::Serialize;

use crate::ir::index::index32;

/// Index into [`Graph::resources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ResourceId(pub u32);

/// Index into [`Graph::passes`] (order of the file, after `extends`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct PassId(pub u32);

/// Index into [`Graph::params`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ParamId(pub u32);

/// Index into [`Graph::clocks`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ClockId(pub u32);

/// A checked graph: all checks that need no device have passed.
#[derive(Clone, Debug, Serialize)]
pub struct Graph {
    /// Name of the graph.
    pub name: String,
    /// A sentence about the graph.
    pub about: String,
    /// The resource shown by default.
    pub present: ResourceId,
    /// Params: live values.
    pub params: Vec<Param>,
    /// Clocks that some passes run by.
    pub clocks: Vec<Clock>,
    /// Targets and buffers.
    pub resources: Vec<Resource>,
    /// Groups of passes that are repeated. The graph of a [`crate::ir::plan::Plan`] has none: its passes are written out.
    pub loops: Vec<Loop>,
    /// Passes in program order.
    pub passes: Vec<Pass>,
    /// Every `material.NAME`. The plan, which knows the world, gives each its index.
    pub materials: Vec<Material>,
    /// Every file of the graph: the graph itself first, then bases, shaders and includes.
    pub files: Vec<String>,
}

impl Graph {
    /// The resource behind an id.
    pub fn resource(&self, id: ResourceId) -> &Resource {
        &self.resources[id.0 as usize]
    }

    /// The pass behind an id.
    pub fn pass(&self, id: PassId) -> &Pass {
        &self.passes[id.0 as usize]
    }

    /// A resource by name.
    pub fn find_resource(&self, name: &str) -> Option<ResourceId> {
        self.resources.iter().position(|r| r.name == name).map(|i| ResourceId(index32(i)))
    }

    /// A pass by name.
    pub fn find_pass(&self, name: &str) -> Option<PassId> {
        self.passes.iter().position(|p| p.name == name).map(|i| PassId(index32(i)))
    }

    /// All passes of a name: one for each case of the buffers that only some worlds have. A plan has at most one of them.
    pub fn cases(&self, name: &str) -> impl Iterator<Item = PassId> {
        self.passes.iter().enumerate().filter(move |(_, pass)| pass.name == name).map(|(i, _)| PassId(index32(i)))
    }

    /// Names of the passes of the file in order. A name stands for all its cases.
    pub fn pass_names(&self) -> impl Iterator<Item = &str> + Clone {
        let first = |(i, pass): &(usize, &Pass)| self.cases(&pass.name).next() == Some(PassId(index32(*i)));
        self.passes.iter().enumerate().filter(first).filter(|(_, pass)| !pass.made).map(|(_, pass)| pass.name.as_str())
    }

    /// The clock behind an id.
    pub fn clock(&self, id: ClockId) -> &Clock {
        &self.clocks[id.0 as usize]
    }

    /// The pass of the file that a pass is a round of; itself, if it is no round.
    pub fn declared(&self, id: PassId) -> PassId {
        self.pass(id).round.map_or(id, |round| round.pass)
    }

    /// The name of that pass: of a round, without its number.
    pub fn declared_name(&self, id: PassId) -> &str {
        let pass = self.pass(id);
        let number = pass.round.and_then(|round| round.index).map(|index| format!("[{index}]"));
        number.and_then(|number| pass.name.strip_suffix(number.as_str())).unwrap_or(&pass.name)
    }

    /// The queue whose count becomes the workgroups of a pass that dispatches indirectly by these arguments, and the byte offset of the
    /// count; `None` for arguments that the file itself declares.
    pub(crate) fn queue_of(&self, arguments: ResourceId) -> Option<(ResourceId, u32)> {
        let writes = |access: &BoundAccess| access.resource == arguments && access.access.writes();
        let maker = self.passes.iter().find(|pass| pass.made && pass.accesses.iter().any(writes))?;
        let queue = maker.accesses.iter().find(|access| access.access.reads())?.resource;
        let ValueOrigin::Value(Value::U32(word)) = maker.push.first()?.from else { return None };
        Some((queue, word.saturating_mul(4)))
    }

    /// Names of the sources that its resources are filled from or are copies of, e.g. `world.tree64`.
    pub fn source_names(&self) -> BTreeSet<&str> {
        self.resources.iter().filter_map(|resource| resource.kind.supplied_by()).collect()
    }

    /// Values of the runtime that its passes read; one that several members hold comes several times.
    pub fn reads(&self) -> impl Iterator<Item = Builtin> + '_ {
        let blocks = self.passes.iter().flat_map(|pass| &pass.uniforms);
        let fills = self.passes.iter().flat_map(|pass| &pass.push).chain(blocks.flat_map(|block| &block.fills));
        fills.filter_map(|fill| match fill.from {
            ValueOrigin::Builtin(builtin) => Some(builtin),
            _ => None,
        })
    }

    /// The buffers that the runtime takes something out of after each frame.
    pub fn collected(&self) -> impl Iterator<Item = ResourceId> + '_ {
        let collected = self.resources.iter().enumerate().filter(|(_, resource)| resource.collected_as().is_some());
        collected.map(|(index, _)| ResourceId(index32(index)))
    }

    /// Whether sizes, dispatches or values follow the bounds or the materials of the world: a plan must know them.
    pub fn is_sized_by_world(&self) -> bool {
        let resource = |resource: &Resource| match &resource.kind {
            ResourceKind::Target(target) => matches!(target.extent, Extent::World { .. }),
            ResourceKind::Buffer(buffer) => matches!(buffer.size, BufferSize::World { .. }),
        };
        let pass = |pass: &Pass| matches!(pass.dispatch, Dispatch::ThreadsOfWorld);
        !self.materials.is_empty() || self.resources.iter().any(resource) || self.passes.iter().any(pass)
    }

    /// Whether conditions of passes depend on the world.
    pub fn asks_the_world(&self) -> bool {
        let of_world = |fact: &Fact| !matches!(fact, Fact::Param(_) | Fact::DevicePackets | Fact::DeviceBallots);
        let condition = |pass: &Pass| pass.when.iter().any(|when| of_world(&when.fact));
        self.passes.iter().any(condition)
    }

    /// A param by name.
    pub fn find_param(&self, name: &str) -> Option<ParamId> {
        self.params.iter().position(|p| p.name == name).map(|i| ParamId(index32(i)))
    }
}

/// A material of the world that a value names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Its name in the world's file.
    pub name: String,
    /// Where it is named.
    pub place: Span,
}

/// A live, typed, named value.
#[derive(Clone, Debug, Serialize)]
pub struct Param {
    /// Name, e.g. `exposure`.
    pub name: String,
    /// Its default value, which also gives its type.
    pub default: Value,
    /// Smallest and largest value, per component; of choices the first and the last. `None` for bools and where the file gives none.
    pub range: Option<[f64; 2]>,
    /// Step of a slider.
    pub step: Option<f64>,
    /// Text beside the slider. Default: the name.
    pub label: String,
    /// Text that the window shows under the pointer.
    pub tooltip: Option<String>,
    /// Unit of the value, e.g. `°`.
    pub unit: Option<String>,
    /// Title of the group that it stands in.
    pub group: Option<String>,
    /// Names of the values 0, 1, 2, …; empty for a param that is just a number.
    pub choices: Vec<String>,
    /// Three or four floats that are a linear colour.
    pub color: bool,
    /// Where it is declared.
    pub place: Span,
}

impl Param {
    /// A param with only a type and a default.
    pub fn new(name: impl Into<String>, default: Value, place: Span) -> Self {
        let name = name.into();
        Self {
            label: name.clone(),
            name,
            default,
            range: None,
            step: None,
            tooltip: None,
            unit: None,
            group: None,
            choices: Vec::new(),
            color: false,
            place,
        }
    }
}

/// A rhythm of its own, apart from the frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clock {
    /// Name, e.g. `sim`.
    pub name: String,
    /// Ticks a second, 0.001 to 10,000; thousandths count.
    pub hz: f64,
    /// Ticks that one frame catches up at most, 1 to 16; time beyond them is dropped.
    pub most: u32,
    /// Where it is declared.
    pub place: Span,
}

/// A typed value: of a param, a push member, a uniform member or a specialization constant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "each variant is the GLSL type of its name")]
#[serde(rename_all = "lowercase", tag = "type", content = "value")]
pub enum Value {
    Bool(bool),
    I32(i32),
    U32(u32),
    F32(f32),
    IVec2([i32; 2]),
    IVec3([i32; 3]),
    IVec4([i32; 4]),
    UVec2([u32; 2]),
    UVec3([u32; 3]),
    UVec4([u32; 4]),
    Vec2([f32; 2]),
    Vec3([f32; 3]),
    Vec4([f32; 4]),
    /// Columns.
    Mat4([[f32; 4]; 4]),
}

/// One dispatch of one shader.
#[derive(Clone, Debug, Serialize)]
pub struct Pass {
    /// Name.
    pub name: String,
    /// The compiled shader.
    #[serde(skip)]
    pub shader: Arc<Shader>,
    /// How many workgroups.
    pub dispatch: Dispatch,
    /// Every access of the dispatch, the indirect arguments included.
    pub accesses: Vec<BoundAccess>,
    /// Values of the push-constant block in order of offset; empty without a block.
    pub push: Vec<Fill>,
    /// Uniform blocks that raxel fills.
    pub uniforms: Vec<UniformBlock>,
    /// Specialization constants that the graph sets, by id. Their values are fixed in a plan: [`crate::ir::plan::PassPlan`] has them.
    pub specialization: Vec<(u32, ValueOrigin)>,
    /// Invocations in a subgroup that the driver is asked for, where the device lets one ask.
    pub subgroup_size: Option<u32>,
    /// The loop that repeats it. `None` in the graph of a plan.
    pub in_loop: Option<InLoop>,
    /// The loop and round that the pass comes from, if any.
    pub round: Option<Round>,
    /// Runs only while all of these hold: its own condition, and those of the buffers that it binds.
    pub when: Vec<Condition>,
    /// Runs only on these frames.
    pub every: Option<Every>,
    /// Made by raxel for the pass behind it; no file declares it.
    pub made: bool,
    /// Where it is declared, or the pass it is made for.
    pub place: Span,
}

/// How many workgroups are dispatched.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum Dispatch {
    /// At least one thread per texel of mip `mip` of the target (depth or layers are the third axis).
    ThreadsOf {
        /// The target.
        target: ResourceId,
        /// The mip.
        mip: u32,
    },
    /// At least one thread per voxel of the world's bounds.
    ThreadsOfWorld,
    /// One workgroup for each tile of mip `mip` of the target, those that reach over its edge included.
    GroupsOf {
        /// The target.
        target: ResourceId,
        /// The mip.
        mip: u32,
        /// Texels of a tile, each at least 1.
        tile: [u32; 3],
    },
    /// At least one thread per element of a buffer. Workgroups beyond the device's limit along x continue along y.
    ElementsOf {
        /// The buffer, which has elements.
        buffer: ResourceId,
    },
    /// At least these threads.
    Threads([u32; 3]),
    /// Exactly these workgroups.
    Groups([u32; 3]),
    /// Three `uint`s read from a buffer.
    Indirect {
        /// The buffer.
        buffer: ResourceId,
        /// Byte offset, a multiple of 4.
        offset: u64,
    },
}

/// Mips, or layers, in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Interval {
    /// The first of them.
    pub first: u32,
    /// How many; 0 for all from the first on.
    pub count: u32,
}

impl Interval {
    /// All of them.
    pub const ALL: Self = Self { first: 0, count: 0 };

    /// One of them.
    pub const fn one(first: u32) -> Self {
        Self { first, count: 1 }
    }

    /// One past the last; larger than any number of mips or layers if there is no count.
    pub const fn end(self) -> u32 {
        if self.count == 0 { u32::MAX } else { self.first.saturating_add(self.count) }
    }

    /// Whether two have one in common.
    pub const fn meets(self, other: Self) -> bool {
        self.first < other.end() && other.first < self.end()
    }
}

/// One access of a pass to one resource.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct BoundAccess {
    /// The resource.
    pub resource: ResourceId,
    /// 0 is this frame's content, n is `name@n`.
    pub age: u32,
    /// Mips touched; the first for buffers.
    pub mips: Interval,
    /// Layers touched; the first for buffers and 3-D targets.
    pub layers: Interval,
    /// Load, store or both.
    pub access: Access,
    /// By which way.
    pub usage: Usage,
    /// Index into the shader's `interface.bindings`; `None` for indirect arguments, and for a binding that the shader declares without a use.
    pub binding: Option<u32>,
    /// Sampler of a sampled image.
    pub sampler: Option<Sampler>,
}

/// By which way a resource is accessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[allow(missing_docs, reason = "each variant is the Vulkan usage of its name")]
pub enum Usage {
    SampledImage,
    StorageImage,
    StorageBuffer,
    UniformBuffer,
    IndirectArguments,
}

/// How a sampled image is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Sampler {
    /// Linear, else nearest.
    pub linear: bool,
    /// Repeat, else clamp to edge.
    pub repeat: bool,
}

impl Pass {
    /// Whether its conditions hold, given the facts that do.
    pub fn runs_where(&self, holds: impl Fn(&Fact) -> bool) -> bool {
        self.when.iter().all(|when| holds(&when.fact) != when.negated)
    }
}

/// A named condition of `when`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Condition {
    /// The fact to ask for.
    pub fact: Fact,
    /// `!`: holds when the fact does not.
    pub negated: bool,
}

/// The facts that a condition can ask for.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum Fact {
    /// The world has a material with emission that some voxel uses: `world.has_emission`.
    WorldHasEmission,
    /// The world has a material with transparency that some voxel uses: `world.has_transparency`.
    WorldHasTransparency,
    /// The world has any solid voxel: `world.has_voxels`.
    WorldHasVoxels,
    /// The world's file has `[[instances]]`: `world.has_instances`.
    WorldHasInstances,
    /// Packets of rays can be traced: the device's subgroups have 32 invocations, or 64, and the operations that they take, the world is in `tree64`, bounded
    /// and of at most 4096 voxels along each axis (`<raxel/packet.glsl>`): `device.packets`.
    DevicePackets,
    /// Shaders may use the ballots and votes of `GL_ARB_shader_ballot` and `GL_ARB_shader_group_vote`, in subgroups of 32 at most: `device.ballots`.
    DeviceBallots,
    /// A param of type bool is true: `param.NAME`.
    Param(ParamId),
}

/// When a pass runs, if not once in every frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Every {
    /// So many times a second of the clock, apart from the frame rate; at most once a frame.
    Hz(f64),
    /// Frame indices that this divides.
    Frames(u32),
    /// Frames in which `frame.still` is less than this: until everything has stood still for so long.
    Still(u32),
    /// Ticks of a clock, several in one frame or none.
    Clock(ClockId),
}

/// `frame.still` stops counting here, so a graph that reads it comes to rest.
pub const MOST_STILL: u32 = 65_535;

/// Invocations in the largest subgroup that Vulkan has (`VkPhysicalDeviceSubgroupSizeControlProperties`).
pub const LARGEST_SUBGROUP: u32 = 128;
