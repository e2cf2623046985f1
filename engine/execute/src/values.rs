//! Writes typed values into the bytes of push-constant and uniform blocks.

use raxel_graph::ValueType;
use raxel_graph::checked::{Fill, Value};
use raxel_shader::interface::Scalar;

/// The place of a value in a block, and its type.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    offset: u32,
    ty: ValueType,
    /// Bytes from column to column.
    stride: u32,
}

impl Member {
    pub(super) fn of(fill: &Fill) -> Member {
        Member { offset: fill.offset, ty: fill.ty, stride: fill.stride }
    }
}

/// One component on its way from a value to a member.
#[derive(Clone, Copy)]
enum Component {
    Float(f32),
    Signed(i32),
    Unsigned(u32),
}

/// Writes a value at its member's place. Components are converted to the member's type. Missing components, and bytes past the end
/// of the block, keep their contents.
pub(super) fn write(block: &mut [u8], member: &Member, value: &Value) {
    let ValueType { scalar, rows, columns } = member.ty;
    for column in 0..columns {
        let offset = (member.offset + column * member.stride) as usize;
        // Nearly every value has the type of its member.
        if let Some(bytes) = same_bytes(value, column as usize, scalar) {
            let count = bytes.len().min(4 * rows as usize);
            if let Some(place) = block.get_mut(offset..offset + count) {
                place.copy_from_slice(&bytes[..count]);
                continue;
            }
        }
        for row in 0..rows {
            let Some(component) = component(value, column as usize, row as usize) else { continue };
            put(block, offset + (row * scalar.size()) as usize, scalar, component);
        }
    }
}

/// A column of a value as the bytes that a member of a type holds, if the value has that type.
fn same_bytes(value: &Value, column: usize, scalar: Scalar) -> Option<&[u8]> {
    match (value, scalar) {
        (Value::Mat4(columns), Scalar::F32) => columns.get(column).map(bytemuck::bytes_of),
        _ if column > 0 => None,
        (Value::F32(value), Scalar::F32) => Some(bytemuck::bytes_of(value)),
        (Value::Vec2(value), Scalar::F32) => Some(bytemuck::bytes_of(value)),
        (Value::Vec3(value), Scalar::F32) => Some(bytemuck::bytes_of(value)),
        (Value::Vec4(value), Scalar::F32) => Some(bytemuck::bytes_of(value)),
        (Value::I32(value), Scalar::I32) => Some(bytemuck::bytes_of(value)),
        (Value::IVec2(value), Scalar::I32) => Some(bytemuck::bytes_of(value)),
        (Value::IVec3(value), Scalar::I32) => Some(bytemuck::bytes_of(value)),
        (Value::IVec4(value), Scalar::I32) => Some(bytemuck::bytes_of(value)),
        (Value::U32(value), Scalar::U32) => Some(bytemuck::bytes_of(value)),
        (Value::UVec2(value), Scalar::U32) => Some(bytemuck::bytes_of(value)),
        (Value::UVec3(value), Scalar::U32) => Some(bytemuck::bytes_of(value)),
        (Value::UVec4(value), Scalar::U32) => Some(bytemuck::bytes_of(value)),
        _ => None,
    }
}

fn component(value: &Value, column: usize, row: usize) -> Option<Component> {
    if let Value::Mat4(columns) = value {
        return columns.get(column)?.get(row).copied().map(Component::Float);
    }
    if column > 0 {
        return None;
    }
    let float = |all: &[f32]| all.get(row).copied().map(Component::Float);
    let signed = |all: &[i32]| all.get(row).copied().map(Component::Signed);
    let unsigned = |all: &[u32]| all.get(row).copied().map(Component::Unsigned);
    match value {
        Value::Bool(value) => unsigned(&[u32::from(*value)]),
        Value::I32(value) => signed(&[*value]),
        Value::U32(value) => unsigned(&[*value]),
        Value::F32(value) => float(&[*value]),
        Value::IVec2(value) => signed(value),
        Value::IVec3(value) => signed(value),
        Value::IVec4(value) => signed(value),
        Value::UVec2(value) => unsigned(value),
        Value::UVec3(value) => unsigned(value),
        Value::UVec4(value) => unsigned(value),
        Value::Vec2(value) => float(value),
        Value::Vec3(value) => float(value),
        Value::Vec4(value) => float(value),
        Value::Mat4(_) => None,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "casts of floats saturate, and a member of 32 bits gets a 32-bit float"
)]
fn put(block: &mut [u8], offset: usize, scalar: Scalar, component: Component) {
    let wide = match component {
        Component::Float(value) => f64::from(value),
        Component::Signed(value) => f64::from(value),
        Component::Unsigned(value) => f64::from(value),
    };
    let integer = match component {
        Component::Float(value) => value as i64,
        Component::Signed(value) => i64::from(value),
        Component::Unsigned(value) => i64::from(value),
    };
    let bytes: [u8; 8] = match scalar {
        Scalar::Bool => u64::from(wide != 0.0).to_le_bytes(),
        Scalar::F32 => match component {
            // Bit by bit, so that a NaN keeps its payload.
            Component::Float(value) => u64::from(value.to_bits()).to_le_bytes(),
            _ => u64::from((wide as f32).to_bits()).to_le_bytes(),
        },
        Scalar::F64 => wide.to_le_bytes(),
        // No value of a graph has this type, and the front end refuses the pair.
        Scalar::F16 | Scalar::Address => return,
        Scalar::I8 | Scalar::U8 | Scalar::I16 | Scalar::U16 | Scalar::I32 | Scalar::U32 | Scalar::I64 | Scalar::U64 => {
            integer.to_le_bytes()
        }
    };
    let size = scalar.size() as usize;
    if let Some(place) = block.get_mut(offset..offset + size) {
        place.copy_from_slice(&bytes[..size]);
    }
}

/// 32 bits of a specialization constant.
pub(super) fn specialization(value: &Value) -> u32 {
    match component(value, 0, 0) {
        Some(Component::Float(value)) => value.to_bits(),
        Some(Component::Signed(value)) => value.cast_unsigned(),
        Some(Component::Unsigned(value)) => value,
        None => 0,
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "every value is exact")]
mod tests {
    use super::*;

    fn member(offset: u32, ty: ValueType, stride: u32) -> Member {
        Member { offset, ty, stride }
    }

    #[test]
    fn vectors_matrices_and_conversions() {
        let mut block = [0u8; 96];
        write(&mut block, &member(4, ValueType::vector(Scalar::I32, 3), 0), &Value::IVec3([-1, 2, 3]));
        write(&mut block, &member(16, ValueType::scalar(Scalar::F32), 0), &Value::I32(-2));
        write(&mut block, &member(20, ValueType::scalar(Scalar::Bool), 0), &Value::Bool(true));
        let matrix = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0], [0.0; 4]];
        write(&mut block, &member(32, ValueType::matrix(Scalar::F32, 3, 3), 16), &Value::Mat4(matrix));
        // A vector that reaches past the end is written as far as there is room for whole components.
        write(&mut block, &member(88, ValueType::vector(Scalar::F32, 4), 0), &Value::Vec4([9.0; 4]));
        let word = |at: usize| u32::from_le_bytes([block[at], block[at + 1], block[at + 2], block[at + 3]]);
        assert_eq!([word(4) as i32, word(8) as i32, word(12) as i32], [-1, 2, 3]);
        assert_eq!(f32::from_bits(word(16)), -2.0);
        assert_eq!(word(20), 1);
        assert_eq!(f32::from_bits(word(48 + 8)), 7.0);
        assert_eq!(word(32 + 12), 0, "the padding of a column is left alone");
        assert_eq!([f32::from_bits(word(88)), f32::from_bits(word(92))], [9.0; 2]);
        // Past the end: nothing is written, nothing panics.
        write(&mut block, &member(94, ValueType::scalar(Scalar::F32), 0), &Value::F32(1.0));
    }
}
