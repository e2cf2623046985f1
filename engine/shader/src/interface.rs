//! The interface of a compute shader from reflection: its bindings, its push constants, its dispatch. Plain data; every name is the GLSL
//! (or HLSL) name. Offsets, sizes and strides are bytes.

use raxel_diagnostics::Span;
use serde::Serialize;

use crate::format::Format;
pub use crate::format::ScalarKind;
use crate::prints::Prints;

/// Everything the outside must supply to a compute shader.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Interface {
    /// Entry point, `main` by default.
    pub entry: String,
    /// Workgroup size per axis.
    pub local_size: [LocalSize; 3],
    /// The push-constant block, if there is one.
    pub push: Option<Block>,
    /// The instance name of the push-constant block; empty without one.
    pub push_name: String,
    /// The bytes of the push-constant block that the shader may load.
    pub push_reads: ByteRanges,
    /// Every binding that the shader declares and uses, ordered by (set, binding).
    pub bindings: Vec<Binding>,
    /// Bindings that the shader declares and does not use: they need not be given.
    pub unused: Unused,
    /// Specialization constants, ordered by id (workgroup-size constants included).
    pub specialization: Vec<SpecConstant>,
    /// Bytes of `shared` variables, with the defaults of specialization constants.
    pub shared_bytes: u64,
    /// The shader's prints, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prints: Option<Prints>,
    /// Names of SPIR-V capabilities beyond `Shader` that the module declares, e.g. `Int64`.
    pub capabilities: Vec<String>,
}

/// Declarations without a use in the entry point and in the functions that it calls.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Unused {
    /// Bindings, ordered as those in use.
    pub bindings: Vec<Binding>,
    /// The push-constant block.
    pub push: Option<Block>,
}

/// Parts of a block, in bytes from its start.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ByteRanges(Vec<[u32; 2]>);

impl ByteRanges {
    /// From parts in any order, each as its start and its end.
    pub fn new(mut parts: Vec<[u32; 2]>) -> Self {
        parts.retain(|[start, end]| start < end);
        parts.sort_unstable();
        let mut ranges: Vec<[u32; 2]> = Vec::with_capacity(parts.len());
        for [start, end] in parts {
            match ranges.last_mut() {
                Some(last) if last[1] >= start => last[1] = last[1].max(end),
                _ => ranges.push([start, end]),
            }
        }
        Self(ranges)
    }

    /// Start and end of each part; the parts are in order, and no two of them touch.
    pub fn iter(&self) -> impl Iterator<Item = [u32; 2]> {
        self.0.iter().copied()
    }

    /// Whether one of the bytes from `start` up to `end` is in a part.
    pub fn meets(&self, start: u32, end: u32) -> bool {
        self.0.iter().any(|part| part[0] < end && start < part[1])
    }
}

/// One axis of the workgroup size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LocalSize {
    /// The literal, or the default of the specialization constant.
    pub value: u32,
    /// The specialization constant that overrides it, if any.
    pub spec_id: Option<u32>,
}

impl Default for LocalSize {
    fn default() -> Self {
        Self { value: 1, spec_id: None }
    }
}

/// One descriptor (or array of descriptors).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Binding {
    /// The variable's name; for a block without an instance name, the block's name.
    pub name: String,
    /// Descriptor set.
    pub set: u32,
    /// Binding number in the set.
    pub binding: u32,
    /// Array length; 1 when it is no array.
    pub count: u32,
    /// Its kind.
    pub kind: BindingKind,
    /// The shader's accesses, by its `readonly`/`writeonly` qualifiers (none: both).
    pub access: Access,
    /// The bytes of a uniform block that the shader may load; empty for everything else.
    pub reads: ByteRanges,
    /// Where the source declares it, when the source is known.
    pub place: Option<Span>,
}

/// The kinds of bindings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum BindingKind {
    /// `image2D` and its kin. `format` is `None` without a format qualifier.
    StorageImage {
        /// The layout qualifier.
        format: Option<Format>,
        /// Dimension of the image.
        dim: Dim,
        /// Layered.
        arrayed: bool,
        /// The type that a load returns.
        scalar: ScalarKind,
    },
    /// `sampler2D` and its kin: image and sampler in one descriptor.
    SampledImage {
        /// Dimension of the image.
        dim: Dim,
        /// Layered.
        arrayed: bool,
        /// The type that a fetch returns.
        scalar: ScalarKind,
    },
    /// A `buffer` block.
    StorageBuffer(Block),
    /// A `uniform` block.
    UniformBuffer(Block),
    /// Anything raxel does not bind (separate samplers and textures, texel buffers, acceleration structures, …), by its SPIR-V name.
    Unsupported(String),
}

/// Dimension of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum Dim {
    /// One-dimensional.
    D1,
    /// Two-dimensional.
    D2,
    /// Three-dimensional.
    D3,
    /// Six square faces.
    Cube,
}

/// A shader's use of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum Access {
    /// Only loads.
    Read,
    /// Only stores.
    Write,
    /// Both, or not declared.
    ReadWrite,
}

impl Access {
    /// Whether it may load.
    pub const fn reads(self) -> bool {
        matches!(self, Access::Read | Access::ReadWrite)
    }

    /// Whether it may store.
    pub const fn writes(self) -> bool {
        matches!(self, Access::Write | Access::ReadWrite)
    }
}

/// A block of members: push constants, uniform or storage block, or a nested struct.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Block {
    /// Type name (`PC` in `uniform PC { … } pc`).
    pub name: String,
    /// Bytes from 0 to the end of the last sized member.
    pub size: u32,
    /// Members in order of declaration. A trailing runtime array has `Type::Array { len: None, .. }`.
    pub members: Vec<Member>,
}

/// One member of a block.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Member {
    /// Name.
    pub name: String,
    /// Byte offset in the block.
    pub offset: u32,
    /// Type.
    pub ty: Type,
    /// Where the source declares it, when the source is known.
    pub place: Option<Span>,
}

/// Type of a member.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Type {
    /// One scalar.
    Scalar(Scalar),
    /// A vector of 2 to 4 scalars.
    Vector(Scalar, u32),
    /// A matrix; `stride` bytes between columns.
    Matrix {
        /// Component.
        scalar: Scalar,
        /// Number of columns.
        columns: u32,
        /// Number of rows.
        rows: u32,
        /// Bytes from one column (row, if row-major) to the next.
        stride: u32,
        /// Stored row by row.
        row_major: bool,
    },
    /// An array; `len` is `None` for a runtime array.
    Array {
        /// Element.
        element: Box<Type>,
        /// Number of elements.
        len: Option<u32>,
        /// Bytes from one element to the next.
        stride: u32,
    },
    /// A nested struct.
    Struct(Block),
}

impl Type {
    /// Bytes from the first to the last: a runtime array has none.
    pub fn size(&self) -> u32 {
        match self {
            Type::Scalar(scalar) => scalar.size(),
            Type::Vector(scalar, components) => scalar.size().saturating_mul(*components),
            Type::Matrix { columns, rows, stride, row_major, .. } => {
                stride.saturating_mul(if *row_major { *rows } else { *columns })
            }
            Type::Array { len, stride, .. } => stride.saturating_mul(len.unwrap_or(0)),
            Type::Struct(block) => block.size,
        }
    }
}

/// Component type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[allow(missing_docs, reason = "each variant is the type of its name")]
pub enum Scalar {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
    /// A buffer reference (64-bit address).
    Address,
}

impl Scalar {
    /// Bytes. A boolean has the four of the `uint` that holds it.
    pub const fn size(self) -> u32 {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 | Scalar::F16 => 2,
            Scalar::Bool | Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 | Scalar::Address => 8,
        }
    }
}

/// A specialization constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpecConstant {
    /// `constant_id`.
    pub id: u32,
    /// Name; empty for a constant that only sizes the workgroup.
    pub name: String,
    /// Type.
    pub scalar: Scalar,
    /// Bits of the default value.
    pub default: u64,
    /// Where the source declares it, when the source is known.
    pub place: Option<Span>,
}
