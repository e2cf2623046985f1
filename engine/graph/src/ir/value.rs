//! Types that a graph can name (`f32`, `ivec3`, `mat4`, …), their names in GLSL, and the layout of their values in memory.

use raxel_shader::interface::{Scalar, Type};
use serde::Serialize;

use crate::ir::checked::Value;

/// A scalar, a vector or a 4×4 matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct ValueType {
    /// Component.
    pub scalar: Scalar,
    /// Rows, which are the components of a vector; 1 in a scalar.
    pub rows: u32,
    /// Columns; 1 in a scalar and in a vector.
    pub columns: u32,
}

/// Every type that a graph can name: its word in a graph, its name in GLSL.
const TYPES: [(&str, &str, ValueType); 14] = [
    ("f32", "float", ValueType::scalar(Scalar::F32)),
    ("i32", "int", ValueType::scalar(Scalar::I32)),
    ("u32", "uint", ValueType::scalar(Scalar::U32)),
    ("bool", "bool", ValueType::scalar(Scalar::Bool)),
    ("vec2", "vec2", ValueType::vector(Scalar::F32, 2)),
    ("vec3", "vec3", ValueType::vector(Scalar::F32, 3)),
    ("vec4", "vec4", ValueType::vector(Scalar::F32, 4)),
    ("ivec2", "ivec2", ValueType::vector(Scalar::I32, 2)),
    ("ivec3", "ivec3", ValueType::vector(Scalar::I32, 3)),
    ("ivec4", "ivec4", ValueType::vector(Scalar::I32, 4)),
    ("uvec2", "uvec2", ValueType::vector(Scalar::U32, 2)),
    ("uvec3", "uvec3", ValueType::vector(Scalar::U32, 3)),
    ("uvec4", "uvec4", ValueType::vector(Scalar::U32, 4)),
    ("mat4", "mat4", ValueType::matrix(Scalar::F32, 4, 4)),
];

impl ValueType {
    /// A scalar.
    pub const fn scalar(scalar: Scalar) -> Self {
        Self::vector(scalar, 1)
    }

    /// A vector of `rows` components; a scalar, if it has one.
    pub const fn vector(scalar: Scalar, rows: u32) -> Self {
        Self::matrix(scalar, rows, 1)
    }

    /// A matrix; a vector, if it has one column.
    pub const fn matrix(scalar: Scalar, rows: u32, columns: u32) -> Self {
        Self { scalar, rows, columns }
    }

    /// The type of that word in a graph.
    pub fn from_word(word: &str) -> Option<Self> {
        TYPES.iter().find(|ty| ty.0 == word).map(|ty| ty.2)
    }

    /// Every word that a graph can use, in the order of the documentation.
    pub fn words() -> impl Iterator<Item = &'static str> + Clone {
        TYPES.iter().map(|ty| ty.0)
    }

    /// The graph's word for a type in GLSL's spelling, e.g. `f32` for `float`.
    pub fn word_of_glsl(name: &str) -> Option<&'static str> {
        TYPES.iter().find(|ty| ty.1 == name).map(|ty| ty.0)
    }

    /// The word in a graph.
    pub fn word(self) -> &'static str {
        TYPES.iter().find(|ty| ty.2 == self).map_or("another type", |ty| ty.0)
    }

    /// The type of a shader's member, if a graph can fill it.
    pub fn of_member(ty: &Type) -> Option<Self> {
        let ty = match *ty {
            Type::Scalar(scalar) => Self::scalar(scalar),
            Type::Vector(scalar, rows) => Self::vector(scalar, rows),
            Type::Matrix { scalar, columns, rows, row_major: false, .. } => Self::matrix(scalar, rows, columns),
            _ => return None,
        };
        TYPES.iter().any(|known| known.2 == ty).then_some(ty)
    }

    /// Whether it is a signed integer; a number of a loop's round suits that too.
    pub fn is_i32(self) -> bool {
        self == Self::scalar(Scalar::I32)
    }

    /// Bytes from one element of an array to the next in `std430`: those of a vector of three are padded to four components.
    pub const fn stride(self) -> u32 {
        let rows = if self.rows == 3 { 4 } else { self.rows };
        4 * rows * self.columns
    }

    /// Whether a value of this type can be put into a member of type `member`. SPIR-V has no booleans in blocks: a shader's `bool`
    /// arrives here as an unsigned integer.
    pub fn fits(self, member: ValueType) -> bool {
        self == member || (self.scalar == Scalar::Bool && member == Self::scalar(Scalar::U32))
    }
}

impl Value {
    /// Its type.
    pub const fn ty(&self) -> ValueType {
        match self {
            Value::Bool(_) => ValueType::scalar(Scalar::Bool),
            Value::I32(_) => ValueType::scalar(Scalar::I32),
            Value::U32(_) => ValueType::scalar(Scalar::U32),
            Value::F32(_) => ValueType::scalar(Scalar::F32),
            Value::IVec2(_) => ValueType::vector(Scalar::I32, 2),
            Value::IVec3(_) => ValueType::vector(Scalar::I32, 3),
            Value::IVec4(_) => ValueType::vector(Scalar::I32, 4),
            Value::UVec2(_) => ValueType::vector(Scalar::U32, 2),
            Value::UVec3(_) => ValueType::vector(Scalar::U32, 3),
            Value::UVec4(_) => ValueType::vector(Scalar::U32, 4),
            Value::Vec2(_) => ValueType::vector(Scalar::F32, 2),
            Value::Vec3(_) => ValueType::vector(Scalar::F32, 3),
            Value::Vec4(_) => ValueType::vector(Scalar::F32, 4),
            Value::Mat4(_) => ValueType::matrix(Scalar::F32, 4, 4),
        }
    }

    /// Appends it as an element of an array in `std430`, padded to [`ValueType::stride`].
    pub fn lay_out(&self, bytes: &mut Vec<u8>) {
        let end = bytes.len() + self.ty().stride() as usize;
        let mut word = |word: u32| bytes.extend(word.to_le_bytes());
        match self {
            Value::Bool(value) => word(u32::from(*value)),
            Value::I32(value) => word((*value).cast_unsigned()),
            Value::U32(value) => word(*value),
            Value::F32(value) => word(value.to_bits()),
            Value::IVec2(value) => value.iter().for_each(|value| word((*value).cast_unsigned())),
            Value::IVec3(value) => value.iter().for_each(|value| word((*value).cast_unsigned())),
            Value::IVec4(value) => value.iter().for_each(|value| word((*value).cast_unsigned())),
            Value::UVec2(value) => value.iter().for_each(|value| word(*value)),
            Value::UVec3(value) => value.iter().for_each(|value| word(*value)),
            Value::UVec4(value) => value.iter().for_each(|value| word(*value)),
            Value::Vec2(value) => value.iter().for_each(|value| word(value.to_bits())),
            Value::Vec3(value) => value.iter().for_each(|value| word(value.to_bits())),
            Value::Vec4(value) => value.iter().for_each(|value| word(value.to_bits())),
            Value::Mat4(columns) => columns.iter().flatten().for_each(|value| word(value.to_bits())),
        }
        bytes.resize(end, 0);
    }
}

/// GLSL's spelling of a type, e.g. `uvec2[8]`.
pub fn glsl(ty: &Type) -> String {
    match ty {
        Type::Scalar(scalar) => glsl_scalar(*scalar).to_owned(),
        Type::Vector(scalar, rows) => format!("{}{rows}", vector_prefix(*scalar)),
        Type::Matrix { scalar, columns, rows, row_major, .. } => {
            let prefix = if *scalar == Scalar::F64 { "dmat" } else { "mat" };
            let size = if columns == rows { columns.to_string() } else { format!("{columns}x{rows}") };
            format!("{}{prefix}{size}", if *row_major { "row_major " } else { "" })
        }
        Type::Array { element, len, .. } => {
            format!("{}[{}]", glsl(element), len.map_or(String::new(), |len| len.to_string()))
        }
        Type::Struct(block) => block.name.clone(),
    }
}

fn glsl_scalar(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Bool => "bool",
        Scalar::I8 => "int8_t",
        Scalar::U8 => "uint8_t",
        Scalar::I16 => "int16_t",
        Scalar::U16 => "uint16_t",
        Scalar::I32 => "int",
        Scalar::U32 => "uint",
        Scalar::I64 => "int64_t",
        Scalar::U64 => "uint64_t",
        Scalar::F16 => "float16_t",
        Scalar::F32 => "float",
        Scalar::F64 => "double",
        Scalar::Address => "buffer reference",
    }
}

fn vector_prefix(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Bool => "bvec",
        Scalar::I8 => "i8vec",
        Scalar::U8 => "u8vec",
        Scalar::I16 => "i16vec",
        Scalar::U16 => "u16vec",
        Scalar::I32 => "ivec",
        Scalar::U32 => "uvec",
        Scalar::I64 => "i64vec",
        Scalar::U64 => "u64vec",
        Scalar::F16 => "f16vec",
        Scalar::F32 | Scalar::Address => "vec",
        Scalar::F64 => "dvec",
    }
}
