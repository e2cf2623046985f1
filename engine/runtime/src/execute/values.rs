//! Writes typed values into the bytes of push-constant and uniform blocks.

use raxel_graph::checked::{Fill, Value};
use raxel_shader::interface::Scalar;

/// One component on its way from a value to a member.
#[derive(Clone, Copy)]
enum Component {
    Float(f32),
    Signed(i32),
    Unsigned(u32),
}

/// Writes a value at its member's place. Components are converted to the member's type where they differ; components that the value
/// lacks, and bytes past the end of the block, are left alone.
pub(super) fn write(block: &mut [u8], fill: &Fill, value: &Value) {
    let (rows, columns) = fill.shape;
    for column in 0..columns {
        for row in 0..rows {
            let Some(component) = component(value, column as usize, row as usize) else { continue };
            let offset = fill.offset + column * fill.stride + row * size(fill.scalar);
            put(block, offset as usize, fill.scalar, component);
        }
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

fn size(scalar: Scalar) -> u32 {
    match scalar {
        Scalar::I8 | Scalar::U8 => 1,
        Scalar::I16 | Scalar::U16 | Scalar::F16 => 2,
        Scalar::Bool | Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
        Scalar::I64 | Scalar::U64 | Scalar::F64 | Scalar::Address => 8,
    }
}

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
    let size = size(scalar) as usize;
    if let Some(place) = block.get_mut(offset..offset + size) {
        place.copy_from_slice(&bytes[..size]);
    }
}

/// 32 bits of a specialization constant.
pub(super) fn specialization(value: &Value) -> u32 {
    match component(value, 0, 0) {
        Some(Component::Float(value)) => value.to_bits(),
        Some(Component::Signed(value)) => value as u32,
        Some(Component::Unsigned(value)) => value,
        None => 0,
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "every value is exact")]
mod tests {
    use super::*;
    use raxel_graph::checked::Source;

    fn fill(offset: u32, scalar: Scalar, shape: (u32, u32), stride: u32) -> Fill {
        let from = Source::Value(Value::Bool(false));
        Fill { member: String::new(), offset, scalar, shape, stride, from }
    }

    #[test]
    fn vectors_matrices_and_conversions() {
        let mut block = [0u8; 96];
        write(&mut block, &fill(4, Scalar::I32, (3, 1), 0), &Value::IVec3([-1, 2, 3]));
        write(&mut block, &fill(16, Scalar::F32, (1, 1), 0), &Value::I32(-2));
        write(&mut block, &fill(20, Scalar::Bool, (1, 1), 0), &Value::Bool(true));
        let matrix = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0], [0.0; 4]];
        write(&mut block, &fill(32, Scalar::F32, (3, 3), 16), &Value::Mat4(matrix));
        let word = |at: usize| u32::from_le_bytes([block[at], block[at + 1], block[at + 2], block[at + 3]]);
        assert_eq!([word(4) as i32, word(8) as i32, word(12) as i32], [-1, 2, 3]);
        assert_eq!(f32::from_bits(word(16)), -2.0);
        assert_eq!(word(20), 1);
        assert_eq!(f32::from_bits(word(48 + 8)), 7.0);
        assert_eq!(word(32 + 12), 0, "the padding of a column is left alone");
        // Past the end: nothing is written, nothing panics.
        write(&mut block, &fill(94, Scalar::F32, (1, 1), 0), &Value::F32(1.0));
    }
}
