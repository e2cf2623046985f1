//! The inputs of a plan besides the graph: the debug target, the world, and the device.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::back::EstimatedMemory;
use crate::ir::checked::{Fact, Graph, ParamId, PassId, ResourceId};
use crate::ir::plan::{BufferDesc, ImageDesc};

/// The inputs of a plan besides the graph.
#[derive(Clone)]
pub struct PlanInput<'a> {
    /// Extent of the output in pixels, both at least 1.
    pub output: [u32; 2],
    /// The shown resource, and the point of the frame at which it is taken.
    pub present: Present,
    /// Resources whose end-of-frame contents must be readable (kept live, never aliased), besides the presented one.
    pub pinned: &'a [ResourceId],
    /// Resources besides it that can be read at the end of a frame.
    pub observe: Observe,
    /// Whether a fact holds.
    pub facts: &'a dyn Fn(&Fact) -> bool,
    /// Rounds of the loops that follow a param; a param that is not here has its default.
    pub counts: &'a [(ParamId, u32)],
    /// Sizes of each source, e.g. `world.tree64`, and of the needs of copies of a source, under [`copy_name`].
    pub sources: &'a BTreeMap<String, SourceSize>,
    /// The world that sizes follow.
    pub world: WorldInput<'a>,
    /// Memory requirements of images and buffers on the device.
    pub memory: &'a dyn MemoryModel,
    /// Whether transient resources may share memory.
    pub alias: bool,
    /// Whether transient memory is filled with a value that is plainly wrong before its first use in a frame: NaN, magenta or
    /// 0xDEADBEEF.
    pub poison: bool,
    /// Limits of the device.
    pub limits: DeviceLimits,
}

impl<'a> PlanInput<'a> {
    /// The input of a graph with its own presented resource, for a session without a world on a device of the smallest limits. All
    /// conditions hold.
    pub fn on_paper(graph: &Graph, output: [u32; 2], sources: &'a BTreeMap<String, SourceSize>) -> Self {
        Self {
            output,
            present: Present::of(graph.present),
            pinned: &[],
            observe: Observe::Shown,
            facts: &|_| true,
            counts: &[],
            sources,
            world: WorldInput::ON_PAPER,
            memory: &EstimatedMemory,
            alias: true,
            poison: false,
            limits: DeviceLimits::PORTABLE,
        }
    }
}

/// Which resources can be read at the end of a frame, besides pinned ones. The choice never changes later frames: passes whose outputs a
/// later frame may read always run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Observe {
    /// Only the shown resource. raxel culls passes that it does not need, and transient resources may share memory.
    Shown,
    /// Every target and buffer. raxel culls only passes whose `when` is false, and no resources share memory.
    #[default]
    Everything,
}

/// The properties of the world that sizes and values of a plan depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorldInput<'a> {
    /// Voxels along each axis of its bounds; zero for an empty world.
    pub extent: [u32; 3],
    /// Names of its materials by index. `None` without a world: any name is accepted.
    pub materials: Option<&'a [String]>,
}

impl WorldInput<'_> {
    /// The stand-in for plans that are made without a world (`check`, `graph`).
    pub const ON_PAPER: WorldInput<'static> = WorldInput { extent: [256; 3], materials: None };
}

/// The name under which [`PlanInput::sources`] has the size of a copy of a source: a layout that shaders write may need more room.
pub fn copy_name(source: &str) -> String {
    format!("copy of {source}")
}

/// Sizes of the supply from outside under one name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceSize {
    /// Bytes of its buffer.
    pub bytes: u64,
    /// Texels of mip 0 of its 3-D image; `None` when it has none, or is not made yet.
    pub image: Option<[u32; 3]>,
}

impl From<u64> for SourceSize {
    fn from(bytes: u64) -> Self {
        Self { bytes, image: None }
    }
}

/// Device limits that a plan is checked against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeviceLimits {
    /// `maxImageDimension2D`.
    pub image_2d: u32,
    /// `maxImageDimension3D`.
    pub image_3d: u32,
    /// `maxImageArrayLayers`.
    pub image_layers: u32,
    /// `maxStorageBufferRange`, bytes.
    pub storage_buffer: u64,
    /// `maxUniformBufferRange`, bytes.
    pub uniform_buffer: u64,
    /// `maxPushConstantsSize`, bytes.
    pub push_constants: u32,
    /// `maxComputeWorkGroupCount`.
    pub workgroup_count: [u32; 3],
    /// `maxComputeWorkGroupSize`.
    pub workgroup_size: [u32; 3],
    /// `maxComputeWorkGroupInvocations`.
    pub workgroup_invocations: u32,
    /// `maxComputeSharedMemorySize`, bytes.
    pub shared_memory: u32,
    /// Limits of the bindings of one pass.
    pub bindings: BindingLimits,
}

/// How many resources of each kind one pass may bind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BindingLimits {
    /// `maxPerStageDescriptorStorageBuffers`.
    pub storage_buffers: u32,
    /// `maxPerStageDescriptorStorageImages`.
    pub storage_images: u32,
    /// The lesser of `maxPerStageDescriptorSampledImages` and `maxPerStageDescriptorSamplers`.
    pub sampled_images: u32,
    /// `maxPerStageDescriptorUniformBuffers`.
    pub uniform_buffers: u32,
    /// `maxPerStageResources`: all of them together.
    pub resources: u32,
}

impl DeviceLimits {
    /// The least limits of every Vulkan 1.3 device that raxel accepts, used when no device is asked (`check`, `graph`).
    pub const PORTABLE: DeviceLimits = DeviceLimits {
        image_2d: 4096,
        image_3d: 256,
        image_layers: 256,
        storage_buffer: 1 << 27,
        uniform_buffer: 16384,
        push_constants: 128,
        workgroup_count: [65535; 3],
        workgroup_size: [128, 128, 64],
        workgroup_invocations: 128,
        shared_memory: 16384,
        bindings: BindingLimits {
            storage_buffers: 4,
            storage_images: 4,
            sampled_images: 16,
            uniform_buffers: 12,
            resources: 128,
        },
    };
}

/// The debug target: the resource that is shown, and the point of the frame at which it is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Present {
    /// The resource.
    pub resource: ResourceId,
    /// 0 is this frame's content, n is `name@n`.
    pub age: u32,
    /// Mip shown.
    pub mip: u32,
    /// Layer, or slice of a 3-D target.
    pub layer: u32,
    /// Taken right after this pass; at the end of the frame when `None`.
    pub after: Option<PassId>,
    /// Where that pass is in a loop, the round after which it is taken, by its `loop.index`. After the last round when `None`, or when there is
    /// no such round.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub round: Option<u32>,
}

impl Present {
    /// The first mip and layer of a resource, as they are at the end of a frame.
    pub const fn of(resource: ResourceId) -> Self {
        Self { resource, age: 0, mip: 0, layer: 0, after: None, round: None }
    }
}

/// `VkMemoryRequirements`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Requirements {
    /// Bytes.
    pub size: u64,
    /// Power of two, bytes.
    pub alignment: u64,
    /// Bit i is set when memory type i will do.
    pub type_bits: u32,
}

/// The memory of an image or buffer: the device answers in a session, an estimate in `raxel graph`.
pub trait MemoryModel {
    /// Requirements of one copy of an image.
    fn image(&self, image: &ImageDesc) -> Requirements;
    /// Requirements of one copy of a buffer.
    fn buffer(&self, buffer: &BufferDesc) -> Requirements;
    /// `bufferImageGranularity`: a buffer and an image in one block must not share a page of this size.
    fn granularity(&self) -> u64;
}
