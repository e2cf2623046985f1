//! Literals of a graph file as typed values.

use raxel_graph::ValueType;
use raxel_graph::checked::Value;
use raxel_shader::interface::Scalar;

use crate::model::{Data, Literal};

/// A description of a literal, for messages: `an integer`, `3 numbers`.
pub(crate) fn describe(literal: &Literal) -> String {
    match &literal.data {
        Data::Bool(_) => "a boolean".to_owned(),
        Data::Int(value) => format!("the integer {value}"),
        Data::Float(value) => format!("the float {value:?}"),
        Data::Array(elements) => format!("an array of {}", elements.len()),
    }
}

/// The value of a literal as type `ty`: a number, a boolean, an array of as many numbers as the vector has, or 4 columns of 4.
/// Integers stand for floats too; nothing else is converted. `None` when it is none of that type.
pub(crate) fn typed(literal: &Literal, ty: ValueType) -> Option<Value> {
    Some(match (ty.scalar, ty.rows, ty.columns) {
        (Scalar::Bool, 1, 1) => match literal.data {
            Data::Bool(value) => Value::Bool(value),
            _ => return None,
        },
        (Scalar::F32, 1, 1) => Value::F32(float(literal)?),
        (Scalar::F32, 2, 1) => Value::Vec2(components(literal, float)?),
        (Scalar::F32, 3, 1) => Value::Vec3(components(literal, float)?),
        (Scalar::F32, 4, 1) => Value::Vec4(components(literal, float)?),
        (Scalar::F32, 4, 4) => Value::Mat4(components(literal, |column| components(column, float))?),
        (Scalar::I32, 1, 1) => Value::I32(integer(literal)?),
        (Scalar::I32, 2, 1) => Value::IVec2(components(literal, integer)?),
        (Scalar::I32, 3, 1) => Value::IVec3(components(literal, integer)?),
        (Scalar::I32, 4, 1) => Value::IVec4(components(literal, integer)?),
        (Scalar::U32, 1, 1) => Value::U32(integer(literal)?),
        (Scalar::U32, 2, 1) => Value::UVec2(components(literal, integer)?),
        (Scalar::U32, 3, 1) => Value::UVec3(components(literal, integer)?),
        (Scalar::U32, 4, 1) => Value::UVec4(components(literal, integer)?),
        _ => return None,
    })
}

/// A finite 32-bit float.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a graph's floats have 32 bits, and what overflows them is refused below"
)]
pub(crate) fn float(literal: &Literal) -> Option<f32> {
    let value = match literal.data {
        Data::Int(value) => value as f32,
        Data::Float(value) => value as f32,
        _ => return None,
    };
    value.is_finite().then_some(value)
}

/// An integer that the type holds.
pub(crate) fn integer<T: TryFrom<i64>>(literal: &Literal) -> Option<T> {
    match literal.data {
        Data::Int(value) => T::try_from(value).ok(),
        _ => None,
    }
}

fn components<T, const N: usize>(literal: &Literal, component: impl Fn(&Literal) -> Option<T>) -> Option<[T; N]> {
    let Data::Array(elements) = &literal.data else { return None };
    let values: Vec<T> = elements.iter().map(component).collect::<Option<_>>()?;
    values.try_into().ok()
}
