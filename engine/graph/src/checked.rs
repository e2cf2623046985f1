//! The checked graph: what the front end (parse → resolve → reflect → check) hands to the back end (cull → order → lifetimes →
//! alias → barriers). Names are gone but for messages; every reference is a typed index; every access is known.
//! It depends on the files only: neither on the output size, nor on the device, nor on the state of conditions.

mod loops;

pub(crate) use loops::accesses_of_round;
pub use loops::{InLoop, Loop, LoopId, MOST_ROUNDS, Round, RoundIndex, Rounds, count_of};

use std::collections::BTreeSet;
use std::sync::Arc;

use raxel_diagnostics::Span;
use raxel_shader::Shader;
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Scalar};
use serde::Serialize;

use crate::supply::FileContents;
use crate::value::ValueType;

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

/// A graph in which everything that can be said without a device has been checked.
#[derive(Clone, Debug, Serialize)]
pub struct Graph {
    /// `name`.
    pub name: String,
    /// `about`.
    pub about: String,
    /// The resource shown by default.
    pub present: ResourceId,
    /// Live values.
    pub params: Vec<Param>,
    /// Clocks that some passes run by.
    pub clocks: Vec<Clock>,
    /// Targets and buffers.
    pub resources: Vec<Resource>,
    /// Groups of passes that are repeated. The graph of a [`crate::plan::Plan`] has none: its passes are written out.
    pub loops: Vec<Loop>,
    /// Passes in program order.
    pub passes: Vec<Pass>,
    /// Every mention of a material of the world, `material.NAME`. What it is the plan knows, which has a world.
    pub materials: Vec<Material>,
    /// Every file that the graph was made from: the graph itself first, bases, shaders, includes.
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
        self.resources.iter().position(|r| r.name == name).map(|i| ResourceId(i as u32))
    }

    /// A pass by name.
    pub fn find_pass(&self, name: &str) -> Option<PassId> {
        self.passes.iter().position(|p| p.name == name).map(|i| PassId(i as u32))
    }

    /// The clock behind an id.
    pub fn clock(&self, id: ClockId) -> &Clock {
        &self.clocks[id.0 as usize]
    }

    /// The pass of the file that a pass is a round of; itself, if it is no round.
    pub fn declared(&self, id: PassId) -> PassId {
        self.pass(id).round.map_or(id, |round| round.pass)
    }

    /// Names of the sources that its resources are filled from or are copies of, e.g. `world.tree64`.
    pub fn source_names(&self) -> BTreeSet<&str> {
        self.resources.iter().filter_map(|resource| resource.kind.supplied_by()).collect()
    }

    /// The buffers that the runtime takes something out of after each frame.
    pub fn collected(&self) -> impl Iterator<Item = ResourceId> + '_ {
        let collected = self.resources.iter().enumerate().filter(|(_, resource)| resource.collected_as().is_some());
        collected.map(|(index, _)| ResourceId(index as u32))
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

    /// Whether conditions of passes ask what the world contains.
    pub fn asks_the_world(&self) -> bool {
        let of_world = |fact: &Fact| !matches!(fact, Fact::Param(_) | Fact::DevicePackets);
        let condition = |pass: &Pass| pass.when.as_ref().is_some_and(|when| of_world(&when.fact));
        self.passes.iter().any(condition)
    }

    /// A param by name.
    pub fn find_param(&self, name: &str) -> Option<ParamId> {
        self.params.iter().position(|p| p.name == name).map(|i| ParamId(i as u32))
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
    /// Text beside the slider; the name when the file gives none.
    pub label: String,
    /// What it does, for whoever rests the pointer on it.
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
    /// A param of which a file says nothing but type and default.
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

/// A target or a buffer.
#[derive(Clone, Debug, Serialize)]
pub struct Resource {
    /// Name.
    pub name: String,
    /// Target or buffer.
    pub kind: ResourceKind,
    /// How many earlier frames (ticks, with a clock) can be read as `name@1` … `name@history`.
    pub history: u32,
    /// It has memory of its own, and keeps its contents from frame to frame unless it is cleared.
    pub keep: bool,
    /// Its history and clears turn with the ticks of this clock, not with the frames.
    pub clock: Option<ClockId>,
    /// Made by raxel for a pass of the file; no file declares it.
    pub made: bool,
    /// Where its contents come from.
    #[serde(skip)]
    pub origin: Origin,
    /// Where it is declared, or the pass it is made for.
    pub place: Span,
}

impl Resource {
    /// Who supplies it from outside, e.g. `world.tree64`. `None` for a copy, which is the graph's own.
    pub fn source(&self) -> Option<&str> {
        self.kind.supplied_by().filter(|_| !matches!(self.origin, Origin::Copy))
    }

    /// What it is filled with when that changes, e.g. `world.tree64`.
    pub fn copied_from(&self) -> Option<&str> {
        self.kind.supplied_by().filter(|_| matches!(self.origin, Origin::Copy))
    }

    /// What the runtime takes out of it after each frame, e.g. `world.edits`.
    pub fn collected_as(&self) -> Option<&str> {
        match &self.origin {
            Origin::Collected(name) => Some(name),
            _ => None,
        }
    }

    /// Whether passes may write it.
    pub fn is_writable(&self) -> bool {
        match &self.origin {
            Origin::Graph | Origin::Copy | Origin::Collected(_) => true,
            Origin::Source(access) => access.writes(),
            Origin::File(_) => false,
        }
    }
}

/// Where the contents of a resource come from, before a pass has written it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Origin {
    /// From the graph: zero, `clear` or `init`.
    #[default]
    Graph,
    /// It is a source itself: no memory of the graph's.
    Source(Access),
    /// From a file of the project, which was read with the graph. It is a source too.
    File(Arc<FileContents>),
    /// It is a copy of a source that passes may write: filled when the source changes, at creation and on reset.
    Copy,
    /// From the graph, zero when a frame begins; what passes write goes outside under this name, e.g. `world.edits`.
    Collected(String),
}

/// What a resource is.
#[derive(Clone, Debug, Serialize)]
pub enum ResourceKind {
    /// An image.
    Target(Target),
    /// A storage buffer.
    Buffer(Buffer),
}

impl ResourceKind {
    /// Whether each frame (tick, with a clock) starts with a clear.
    pub fn is_cleared(&self) -> bool {
        match self {
            ResourceKind::Target(target) => target.clear.is_some(),
            ResourceKind::Buffer(buffer) => buffer.clear.is_some(),
        }
    }

    /// Who supplies it from outside, or supplies what it is a copy of, e.g. `world.tree64`.
    pub fn supplied_by(&self) -> Option<&str> {
        match self {
            ResourceKind::Target(target) => target.source.as_deref(),
            ResourceKind::Buffer(Buffer { size: BufferSize::Source(name), .. }) => Some(name),
            ResourceKind::Buffer(_) => None,
        }
    }

    /// What the file writes into it, if it does.
    pub fn values(&self) -> Option<&Values> {
        match self {
            ResourceKind::Buffer(Buffer { size: BufferSize::Values(values), .. }) => Some(values),
            _ => None,
        }
    }

    /// Whether the file says what it holds at creation.
    pub fn is_initialised(&self) -> bool {
        match self {
            ResourceKind::Target(target) => target.init.is_some(),
            ResourceKind::Buffer(buffer) => buffer.init.is_some(),
        }
    }
}

/// An image that passes read and write.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Texel format.
    pub format: Format,
    /// Extent rule.
    pub extent: Extent,
    /// Supplied from outside under this name, e.g. `world.texture3d`, or a copy of it.
    pub source: Option<String>,
    /// Number of mips; 0 means the full chain down to one texel.
    pub mips: u32,
    /// Array layers; 1 for a plain image.
    pub layers: u32,
    /// Cleared to this at the start of each frame.
    pub clear: Option<Clear>,
    /// Filled with this at creation and on reset; zero when `None`. `Some` makes the contents survive from frame to frame.
    pub init: Option<Clear>,
    /// How it is shown.
    pub display: Option<Display>,
}

/// Extent of a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Extent {
    /// A part of the output: each axis is max(1, round(output × scale)).
    Output {
        /// Scale per axis.
        scale: [f64; 2],
    },
    /// Fixed 2-D extent in texels.
    Fixed2([u32; 2]),
    /// Fixed 3-D extent in texels.
    Fixed3([u32; 3]),
    /// Three dimensions of the supplier's, which are not known before the contents are there.
    Source,
    /// A part of another target's extent (same dimension as that target).
    Of {
        /// The other target.
        target: ResourceId,
        /// Scale on every axis.
        scale: f64,
    },
    /// Three dimensions: a part of the world's bounds in voxels. Each axis is max(1, ⌈extent × scale⌉).
    World {
        /// Texels per voxel, on every axis.
        scale: f64,
    },
}

/// A clear value: four channels in the format's kind (float, signed or unsigned).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Clear {
    /// Float, unorm, snorm.
    Float([f32; 4]),
    /// Signed.
    Int([i32; 4]),
    /// Unsigned; for a buffer, all four are the 32-bit fill pattern.
    Uint([u32; 4]),
}

/// How a resource becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Display {
    /// The map.
    pub map: DisplayMap,
    /// Values shown as the ends of the map.
    pub range: [f32; 2],
    /// The channel that scalar maps read, 0 to 3.
    pub channel: u32,
}

/// The map from texels to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DisplayMap {
    /// Linear colour, tone curve off: clamp to `range`, encode as sRGB. The default of float formats with 3 or 4 channels.
    Color,
    /// Already encoded: clamp to 0…1 and copy. The default of unorm formats.
    Raw,
    /// One channel as grey. The default of float formats with 1 or 2 channels.
    Gray,
    /// One channel through the Turbo colour map.
    Turbo,
    /// One channel through the Viridis colour map.
    Viridis,
    /// xyz in −1…1 as colour.
    Normal,
    /// A hash of the integer channels as colour. The default of integer formats.
    Id,
    /// One channel as an integer over `range`, in grey.
    Integer,
}

/// A storage buffer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Buffer {
    /// Size rule.
    pub size: BufferSize,
    /// Filled with this 32-bit pattern at the start of each frame.
    pub clear: Option<u32>,
    /// Filled with this at creation and on reset; zero when `None`. `Some` makes the contents survive from frame to frame.
    pub init: Option<u32>,
}

/// Size of a buffer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum BufferSize {
    /// Bytes. Nothing is known of elements.
    Bytes(u64),
    /// So many elements.
    Elements {
        /// Number of elements.
        count: u64,
        /// Bytes of an element.
        stride: u32,
    },
    /// Elements for each texel of a target's mip 0 (depth and layers count too), or for each element of another buffer.
    Of {
        /// The target, or a buffer that has elements.
        of: ResourceId,
        /// Elements for each of them.
        per: u32,
        /// Bytes of an element.
        stride: u32,
    },
    /// Elements for each texel of a part of the world's bounds, measured as [`Extent::World`].
    World {
        /// Texels per voxel, on every axis.
        scale: f64,
        /// Elements for each texel.
        per: u32,
        /// Bytes of an element.
        stride: u32,
    },
    /// Supplied from outside under this name, e.g. `world.tree64`, or a copy of it; its bytes are the supplier's.
    Source(String),
    /// Elements written in the file. Passes only read them.
    Values(Values),
}

/// The contents of a buffer, written in the file.
#[derive(Clone, PartialEq, Serialize)]
pub struct Values {
    /// Type of an element.
    #[serde(skip)]
    pub ty: ValueType,
    /// Bytes from one element to the next, as `std430` lays out an array.
    pub stride: u32,
    /// All elements.
    #[serde(skip)]
    pub bytes: Arc<[u8]>,
}

impl Values {
    /// Number of elements.
    pub fn count(&self) -> u64 {
        self.bytes.len() as u64 / u64::from(self.stride.max(1))
    }
}

impl std::fmt::Debug for Values {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Values({} × {})", self.count(), self.ty.word())
    }
}

impl BufferSize {
    /// Bytes, where they depend on the file alone.
    pub fn fixed_bytes(&self) -> Option<u64> {
        match self {
            BufferSize::Bytes(bytes) => Some(*bytes),
            BufferSize::Elements { count, stride } => Some(count * u64::from(*stride)),
            BufferSize::Values(values) => Some(values.bytes.len() as u64),
            BufferSize::Of { .. } | BufferSize::World { .. } | BufferSize::Source(_) => None,
        }
    }

    /// Bytes of an element, where the file says how many elements there are.
    pub fn stride(&self) -> Option<u32> {
        match self {
            BufferSize::Elements { stride, .. } | BufferSize::Of { stride, .. } | BufferSize::World { stride, .. } => {
                Some(*stride)
            }
            BufferSize::Values(values) => Some(values.stride),
            BufferSize::Bytes(_) | BufferSize::Source(_) => None,
        }
    }
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
    /// Specialization constants that the graph sets, by id. Their values are fixed in a plan: [`crate::plan::PassPlan`] has them.
    pub specialization: Vec<(u32, Source)>,
    /// The loop that repeats it. `None` in the graph of a plan.
    pub in_loop: Option<InLoop>,
    /// Where it comes from, when it was written out of a loop or stands beside such passes.
    pub round: Option<Round>,
    /// Runs only while this holds.
    pub when: Option<Condition>,
    /// Runs only on these frames.
    pub every: Option<Every>,
    /// Made by raxel for the pass behind it; no file declares it.
    pub made: bool,
    /// Where it is declared, or the pass it is made for.
    pub place: Span,
}

/// How many workgroups are dispatched.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
    /// At least one thread per element of a buffer. What the device does not take along x goes on along y.
    ElementsOf {
        /// The buffer, which has elements.
        buffer: ResourceId,
    },
    /// At least so many threads.
    Threads([u32; 3]),
    /// Exactly so many workgroups.
    Groups([u32; 3]),
    /// Three `uint`s read from a buffer.
    Indirect {
        /// The buffer.
        buffer: ResourceId,
        /// Byte offset, a multiple of 4.
        offset: u64,
    },
}

/// One access of a pass to one resource.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundAccess {
    /// The resource.
    pub resource: ResourceId,
    /// 0 is this frame's content, n is `name@n`.
    pub age: u32,
    /// Mips touched: first and count; count 0 means all from first. (0, 1) for buffers.
    pub mips: (u32, u32),
    /// Layers touched: first and count; count 0 means all from first. (0, 1) for buffers and 3-D targets.
    pub layers: (u32, u32),
    /// Load, store or both.
    pub access: Access,
    /// By which way.
    pub usage: Usage,
    /// Index into the shader's `interface.bindings`; `None` for indirect arguments.
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

/// One value put at one offset of a push-constant or uniform block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fill {
    /// Member path, e.g. `exposure` or `sun.direction`.
    pub member: String,
    /// Byte offset in the block.
    pub offset: u32,
    /// Component type.
    pub scalar: Scalar,
    /// Rows (components of a vector) and columns; (1, 1) is a scalar.
    pub shape: (u32, u32),
    /// Bytes between columns of a matrix; 0 otherwise.
    pub stride: u32,
    /// Where the value comes from.
    pub from: Source,
}

/// A uniform block that raxel keeps and fills each frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UniformBlock {
    /// Index into the shader's `interface.bindings`.
    pub binding: u32,
    /// Bytes.
    pub size: u32,
    /// Values in order of offset.
    pub fills: Vec<Fill>,
}

/// Where a push or uniform value comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Source {
    /// Written in the file.
    Value(Value),
    /// A param.
    Param(ParamId),
    /// Something the runtime knows.
    Builtin(Builtin),
    /// A number of the round, as `u32`. Not in the graph of a plan.
    Round(RoundIndex),
    /// Extent of a target's mip 0 in texels; the third axis is its depth or number of layers.
    ExtentOf(ResourceId),
    /// Number of elements of a buffer.
    CountOf(ResourceId),
    /// Index of a material of the world: which name is meant, as an index into [`Graph::materials`].
    Material(u32),
    /// Something that a clock knows: `clock.NAME.tick`.
    Clock(ClockId, ClockValue),
}

/// What a clock knows: the last word of `clock.NAME.tick`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum ClockValue {
    /// `tick`, u32: the number of the tick, from 0 at the start. In a pass of the clock the one that runs, elsewhere the last one
    /// that has run.
    Tick,
    /// `delta`, f32: seconds from tick to tick.
    Delta,
    /// `phase`, f32: time since the last tick was due, as a part of `delta`, in [0, 1).
    Phase,
}

impl ClockValue {
    /// Every value with its word.
    pub const ALL: [(ClockValue, &str); 3] =
        [(ClockValue::Tick, "tick"), (ClockValue::Delta, "delta"), (ClockValue::Phase, "phase")];
}

macro_rules! builtins {
    ($($variant:ident = $name:literal, $scalar:ident, $shape:expr, $about:literal;)*) => {
        /// A value that the runtime knows: the `from = "…"` words of a graph file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        pub enum Builtin { $(#[doc = $about] $variant),* }

        impl Builtin {
            /// Every builtin in the order of the documentation.
            pub const ALL: &[Builtin] = &[$(Builtin::$variant),*];

            /// The word in the file, e.g. `camera.cell`.
            pub const fn name(self) -> &'static str {
                match self { $(Builtin::$variant => $name),* }
            }

            /// What it is, in one sentence.
            pub const fn about(self) -> &'static str {
                match self { $(Builtin::$variant => $about),* }
            }

            /// Component type and shape (rows, columns).
            pub const fn ty(self) -> (Scalar, (u32, u32)) {
                match self { $(Builtin::$variant => (Scalar::$scalar, $shape)),* }
            }
        }
    };
}

builtins! {
    CameraCell = "camera.cell", I32, (3, 1), "Voxel that holds the camera.";
    CameraFrac = "camera.frac", F32, (3, 1), "Camera's place in its voxel, each component in [0, 1).";
    CameraViewToWorld = "camera.view_to_world", F32, (4, 4), "Rotation from view space (x right, y up, looking along −z) to world space; no translation.";
    CameraWorldToView = "camera.world_to_view", F32, (4, 4), "The inverse rotation.";
    CameraFov = "camera.fov", F32, (1, 1), "Vertical field of view in radians.";
    CameraTanHalfFov = "camera.tan_half_fov", F32, (2, 1), "Tangent of half the field of view, horizontal and vertical.";
    CameraPreviousCell = "camera.previous.cell", I32, (3, 1), "`camera.cell` of the last frame.";
    CameraPreviousFrac = "camera.previous.frac", F32, (3, 1), "`camera.frac` of the last frame.";
    CameraPreviousViewToWorld = "camera.previous.view_to_world", F32, (4, 4), "`camera.view_to_world` of the last frame.";
    CameraPreviousWorldToView = "camera.previous.world_to_view", F32, (4, 4), "`camera.world_to_view` of the last frame.";
    FrameIndex = "frame.index", U32, (1, 1), "Frames since the last reset.";
    FrameTime = "frame.time", F32, (1, 1), "Seconds since the last reset.";
    FrameDelta = "frame.delta", F32, (1, 1), "Seconds since the last frame.";
    FrameStill = "frame.still", U32, (1, 1), "Frames since anything but the time changed: camera, params, graph, world, size, cursor. 0 in the frame of a change; counts up to 65,535 and stays there.";
    HistoryValid = "history.valid", U32, (1, 1), "1 when all that has a history holds what the frames before this one left there; 0 in the first frame, and after a reset, a cut, or another size or an edit that cleared one, until as many frames have run as it goes back.";
    OutputSize = "output.size", I32, (2, 1), "Extent of the output in pixels.";
    OutputAspect = "output.aspect", F32, (1, 1), "Width of the output over its height.";
    CursorPosition = "cursor.position", I32, (2, 1), "Pixel under the cursor, from the top left; (−1, −1) without one.";
    WorldMin = "world.min", I32, (3, 1), "Smallest voxel coordinate of the world's bounds.";
    WorldMax = "world.max", I32, (3, 1), "Largest voxel coordinate of the world's bounds, plus one.";
    WorldVoxels = "world.voxels", U32, (1, 1), "Number of solid voxels, saturated.";
    WorldSerial = "world.serial", U32, (1, 1), "How often the world has changed since the start.";
    WorldChangedMin = "world.changed_min", I32, (3, 1), "Smallest coordinate of a box around the voxels that have changed since the last frame; a box without a voxel when none has, all that there can be when that cannot be told.";
    WorldChangedMax = "world.changed_max", I32, (3, 1), "Largest coordinate of that box, plus one.";
}

/// A named condition of `when`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Condition {
    /// What is asked.
    pub fact: Fact,
    /// `!`: holds when the fact does not.
    pub negated: bool,
}

/// What a condition can ask.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum Fact {
    /// The world has a material with emission that some voxel uses: `world.has_emission`.
    WorldHasEmission,
    /// The world has a material with transparency that some voxel uses: `world.has_transparency`.
    WorldHasTransparency,
    /// The world has any solid voxel: `world.has_voxels`.
    WorldHasVoxels,
    /// Packets of rays can be traced: the device's subgroups have 32 invocations and the operations that they take, the world is in `tree64`, bounded
    /// and of at most 4096 voxels along each axis (`<raxel/packet.glsl>`): `device.packets`.
    DevicePackets,
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

/// Where `frame.still` stops counting: a graph that reads it comes to rest.
pub const MOST_STILL: u32 = 65_535;
