//! Targets and buffers of a checked graph: their kinds, and the origin of their contents.

use std::sync::Arc;

use raxel_diagnostics::Span;
use raxel_language::Keys;
use raxel_shader::format::Format;
use raxel_shader::interface::Access;
use serde::Serialize;

use super::{ClockId, ResourceId};
use crate::ir::supply::FileContents;
use crate::ir::value::ValueType;

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
    /// Words of a buffer that the runtime warns of while they are not 0.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Warning>,
    /// Where its contents come from.
    #[serde(skip)]
    pub origin: Origin,
    /// Where it is declared, or the pass it is made for.
    pub place: Span,
}

impl Resource {
    /// A resource of the graph's own, without history.
    pub fn new(name: impl Into<String>, kind: ResourceKind, place: Span) -> Self {
        Self {
            name: name.into(),
            kind,
            history: 0,
            keep: false,
            clock: None,
            made: false,
            warnings: Vec::new(),
            origin: Origin::default(),
            place,
        }
    }

    /// Who supplies it from outside, e.g. `world.tree64`. `None` for a copy, which is the graph's own.
    pub fn source(&self) -> Option<&str> {
        self.kind.supplied_by().filter(|_| !matches!(self.origin, Origin::Copy))
    }

    /// The source that it is filled from when that changes, e.g. `world.tree64`.
    pub fn copied_from(&self) -> Option<&str> {
        self.kind.supplied_by().filter(|_| matches!(self.origin, Origin::Copy))
    }

    /// The kind of records that the runtime takes out of it after each frame, e.g. `world.edits`.
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

/// A warning while a word of a buffer is not 0. Passes count unwanted events there, for example elements that found no room.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Byte offset of the `uint`, a multiple of 4.
    pub offset: u64,
    /// The counted thing and its meaning, as a part of a sentence.
    pub says: String,
    /// Advice, if there is any.
    pub help: Option<String>,
    /// The place of the warning in the file.
    #[serde(skip)]
    pub place: Span,
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
    /// From the graph, zero when a frame begins; the output of passes goes outside under this name, e.g. `world.edits`.
    Collected(String),
}

/// The kinds of resources.
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

    /// The name of the source that supplies it from outside, or supplies the original of this copy, e.g. `world.tree64`.
    pub fn supplied_by(&self) -> Option<&str> {
        match self {
            ResourceKind::Target(target) => target.source.as_deref(),
            ResourceKind::Buffer(Buffer { size: BufferSize::Source(name), .. }) => Some(name),
            ResourceKind::Buffer(_) => None,
        }
    }

    /// The values that the file writes into it, if it does.
    pub fn values(&self) -> Option<&Values> {
        match self {
            ResourceKind::Buffer(Buffer { size: BufferSize::Values(values), .. }) => Some(values),
            _ => None,
        }
    }

    /// Whether the file has its contents at creation.
    pub(crate) fn is_initialised(&self) -> bool {
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

impl Clear {
    /// The kind and the bits of each channel: equal if and only if the device is given the same.
    pub fn bits(self) -> (u8, [u32; 4]) {
        match self {
            Self::Float(channels) => (0, channels.map(f32::to_bits)),
            Self::Int(channels) => (1, channels.map(i32::cast_unsigned)),
            Self::Uint(channels) => (2, channels),
        }
    }
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Keys)]
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

    /// Bytes of an element, where the file has a number of elements.
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
