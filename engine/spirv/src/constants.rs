//! The values of a module's constants, also of those that it computes from specialization constants. Operations are those that
//! `OpSpecConstantOp` may have in a shader (SPIR-V 1.6, section 3.3.7), except those of floats.

use std::collections::HashMap;

use spirv::{Decoration, Op};

use crate::instruction::Instruction;

/// The most scalars and groups of a constant whose value is kept. Lengths of arrays come from vectors and small structures.
const MOST_PARTS: usize = 64;

/// The most of them in all constants of a module that are no scalars.
const MOST_IN_ALL: usize = 1 << 16;

/// A constant.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Value {
    /// Bits of a number, zero-extended, and how many it has. A boolean has one.
    Scalar { bits: u64, width: u32 },
    /// Components of a vector, elements or members.
    Parts(Vec<Value>),
}

/// Types of constants.
#[derive(Clone, Copy)]
enum Type<'w> {
    /// Bits of a number; a boolean has one.
    Scalar(u32),
    /// Part, and how many.
    Vector(u32, u32),
    Struct(&'w [u32]),
}

/// The constants that are declared so far.
pub(crate) struct Constants<'w> {
    types: HashMap<u32, Type<'w>>,
    values: HashMap<u32, Value>,
    /// The bits of those that have other values than their defaults, by id.
    specialized: HashMap<u32, u32>,
    /// What is left of [`MOST_IN_ALL`].
    room: usize,
}

impl<'w> Constants<'w> {
    /// No constants yet. `specialized` has bits of specialization constants by their number; the others will have their defaults.
    pub(crate) fn new(instructions: &[Instruction<'_>], specialized: &HashMap<u32, u32>) -> Self {
        let number = |instruction: &Instruction<'_>| match instruction.operands {
            [id, decoration, number] if instruction.is(Op::Decorate) && *decoration == Decoration::SpecId as u32 => {
                specialized.get(number).map(|bits| (*id, *bits))
            }
            _ => None,
        };
        let specialized = instructions.iter().filter_map(number).collect();
        Self { types: HashMap::new(), values: HashMap::new(), specialized, room: MOST_IN_ALL }
    }

    /// The bits of a number, zero-extended; `None` if its value is not known.
    pub(crate) fn bits(&self, id: u32) -> Option<u64> {
        self.values.get(&id).and_then(Value::bits)
    }

    /// The words of a number, as `OpConstant` has them.
    #[expect(clippy::cast_possible_truncation, reason = "the two halves of a number")]
    pub(crate) fn words(&self, id: u32) -> Option<Vec<u32>> {
        match *self.values.get(&id)? {
            Value::Scalar { bits, width: 1..=32 } => Some(vec![bits as u32]),
            Value::Scalar { bits, .. } => Some(vec![bits as u32, (bits >> 32) as u32]),
            Value::Parts(_) => None,
        }
    }

    /// Takes note of a declaration; `None` if it has no value that is known.
    pub(crate) fn declare(&mut self, instruction: &Instruction<'w>) -> Option<()> {
        let op = Op::from_u32(instruction.opcode)?;
        let ty = match (op, instruction.operands) {
            (Op::TypeBool, [id]) => Some((*id, Type::Scalar(1))),
            (Op::TypeInt | Op::TypeFloat, [id, width @ 1..=64, ..]) => Some((*id, Type::Scalar(*width))),
            (Op::TypeVector, [id, part, count]) => Some((*id, Type::Vector(*part, *count))),
            (Op::TypeStruct, [id, members @ ..]) => Some((*id, Type::Struct(members))),
            _ => None,
        };
        if let Some((id, ty)) = ty {
            self.types.insert(id, ty);
            return Some(());
        }
        let [ty, id, operands @ ..] = instruction.operands else { return None };
        let specialized = self.specialized.get(id).copied().map(u64::from);
        let value = match op {
            Op::ConstantTrue => Value::boolean(true),
            Op::ConstantFalse => Value::boolean(false),
            Op::SpecConstantTrue => Value::boolean(specialized != Some(0)),
            Op::SpecConstantFalse => Value::boolean(specialized.is_some_and(|bits| bits != 0)),
            Op::Constant | Op::SpecConstant => {
                let Type::Scalar(width) = *self.types.get(ty)? else { return None };
                let low = u64::from(*operands.first()?);
                let default = operands.get(1).map_or(0, |high| u64::from(*high) << 32) | low;
                Value::number(specialized.unwrap_or(default), width)
            }
            Op::ConstantNull => self.zero(*ty, &mut { MOST_PARTS })?,
            Op::ConstantComposite | Op::SpecConstantComposite => {
                let parts = operands.iter().map(|part| self.values.get(part)).collect::<Option<Vec<_>>>()?;
                if parts.iter().map(|part| part.size()).sum::<usize>() >= MOST_PARTS {
                    return None;
                }
                Value::Parts(parts.into_iter().cloned().collect())
            }
            Op::SpecConstantOp => {
                let (op, operands) = operands.split_first()?;
                self.computed(*ty, Op::from_u32(*op)?, operands)?
            }
            _ => return None,
        };
        let size = value.size();
        if size > MOST_PARTS {
            return None;
        }
        if size > 1 {
            self.room = self.room.checked_sub(size)?;
        }
        self.values.insert(*id, value);
        Some(())
    }

    /// Zero of a type, of at most `room` parts.
    fn zero(&self, ty: u32, room: &mut usize) -> Option<Value> {
        *room = room.checked_sub(1)?;
        let mut part = |ty: u32| self.zero(ty, room);
        Some(match *self.types.get(&ty)? {
            Type::Scalar(width) => Value::number(0, width),
            Type::Vector(ty, count) => Value::Parts((0..count).map(|_| part(ty)).collect::<Option<_>>()?),
            Type::Struct(members) => Value::Parts(members.iter().map(|member| part(*member)).collect::<Option<_>>()?),
        })
    }

    /// The bits of the numbers of a type.
    fn width(&self, ty: u32) -> Option<u32> {
        match *self.types.get(&ty)? {
            Type::Scalar(width) => Some(width),
            Type::Vector(part, _) => match self.types.get(&part)? {
                Type::Scalar(width) => Some(*width),
                _ => None,
            },
            Type::Struct(_) => None,
        }
    }

    /// The value of a computed constant.
    fn computed(&self, ty: u32, op: Op, operands: &[u32]) -> Option<Value> {
        let value = |at: usize| self.values.get(operands.get(at)?);
        match op {
            Op::CompositeExtract => value(0)?.part(&operands[1..]).cloned(),
            Op::CompositeInsert => {
                let mut whole = value(1)?.clone();
                *whole.part_mut(&operands[2..])? = value(0)?.clone();
                Some(whole)
            }
            Op::VectorShuffle => {
                let (Value::Parts(first), Value::Parts(second)) = (value(0)?, value(1)?) else { return None };
                if operands.len() > MOST_PARTS {
                    return None;
                }
                let both: Vec<&Value> = first.iter().chain(second).collect();
                let pick = |index: &u32| both.get(*index as usize).map(|part| (*part).clone());
                Some(Value::Parts(operands[2..].iter().map(pick).collect::<Option<_>>()?))
            }
            Op::Select => value(0)?.select(value(1)?, value(2)?),
            _ => {
                let width = self.width(ty)?;
                let second = operands.get(1).map(|id| self.values.get(id));
                let arithmetic = |first: &Number, second: &Number| number(op, width, first, second);
                match second {
                    Some(second) => value(0)?.with(second?, &arithmetic),
                    None => value(0)?.with(value(0)?, &|only, _| single(op, width, only)),
                }
            }
        }
    }
}

/// The bits of a scalar, and how many it has.
struct Number {
    bits: u64,
    width: u32,
}

impl Number {
    /// As a signed number.
    fn signed(&self) -> i64 {
        let unused = 64 - self.width;
        (self.bits << unused).cast_signed() >> unused
    }
}

impl Value {
    fn boolean(value: bool) -> Self {
        Self::number(u64::from(value), 1)
    }

    /// A scalar of the lowest bits; `width` is 1 to 64.
    fn number(bits: u64, width: u32) -> Self {
        Self::Scalar { bits: bits & (u64::MAX >> (64 - width)), width }
    }

    fn bits(&self) -> Option<u64> {
        match self {
            Self::Scalar { bits, .. } => Some(*bits),
            Self::Parts(_) => None,
        }
    }

    /// Its scalars and groups.
    fn size(&self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Parts(parts) => 1 + parts.iter().map(Self::size).sum::<usize>(),
        }
    }

    fn part(&self, path: &[u32]) -> Option<&Self> {
        path.iter().try_fold(self, |at, index| match at {
            Self::Parts(parts) => parts.get(*index as usize),
            Self::Scalar { .. } => None,
        })
    }

    fn part_mut(&mut self, path: &[u32]) -> Option<&mut Self> {
        path.iter().try_fold(self, |at, index| match at {
            Self::Parts(parts) => parts.get_mut(*index as usize),
            Self::Scalar { .. } => None,
        })
    }

    /// An operation on each pair of scalars.
    fn with(&self, other: &Self, operation: &dyn Fn(&Number, &Number) -> Option<Self>) -> Option<Self> {
        match (self, other) {
            (Self::Scalar { bits, width }, Self::Scalar { bits: other, width: other_width }) => {
                operation(&Number { bits: *bits, width: *width }, &Number { bits: *other, width: *other_width })
            }
            (Self::Parts(parts), Self::Parts(others)) if parts.len() == others.len() => {
                let pairs = parts.iter().zip(others);
                Some(Self::Parts(pairs.map(|(part, other)| part.with(other, operation)).collect::<Option<_>>()?))
            }
            _ => None,
        }
    }

    /// One of two values by this condition, or for each part one of its own.
    fn select(&self, yes: &Self, no: &Self) -> Option<Self> {
        match (self, yes, no) {
            (Self::Scalar { bits, .. }, _, _) => Some(if *bits == 0 { no } else { yes }.clone()),
            (Self::Parts(conditions), Self::Parts(yes), Self::Parts(no)) => {
                let parts = conditions.iter().zip(yes.iter().zip(no));
                Some(Self::Parts(parts.map(|(part, (yes, no))| part.select(yes, no)).collect::<Option<_>>()?))
            }
            _ => None,
        }
    }
}

/// An operation on one number; `width` has the bits of the result.
fn single(op: Op, width: u32, only: &Number) -> Option<Value> {
    let bits = match op {
        Op::UConvert => only.bits,
        Op::SConvert => only.signed().cast_unsigned(),
        Op::Not => !only.bits,
        Op::SNegate => only.bits.wrapping_neg(),
        Op::LogicalNot => u64::from(only.bits == 0),
        _ => return None,
    };
    Some(Value::number(bits, width))
}

/// An operation on two numbers; `width` has the bits of the result. A result without a definition, such as that of a division by 0, is `None`.
fn number(op: Op, width: u32, a: &Number, b: &Number) -> Option<Value> {
    let is = |condition: bool| u64::from(condition);
    // A shift by as many bits as there are has no defined result.
    let shift = u32::try_from(b.bits).ok().filter(|shift| *shift < width);
    let bits = match op {
        Op::IAdd => a.bits.wrapping_add(b.bits),
        Op::ISub => a.bits.wrapping_sub(b.bits),
        Op::IMul => a.bits.wrapping_mul(b.bits),
        Op::UDiv => a.bits.checked_div(b.bits)?,
        Op::UMod => a.bits.checked_rem(b.bits)?,
        Op::SDiv => {
            let quotient = a.signed().checked_div(b.signed())?;
            // The least number by -1 has no place in as many bits.
            if width < 64 && quotient == 1 << (width - 1) {
                return None;
            }
            quotient.cast_unsigned()
        }
        // The remainder has the sign of the first, the modulus that of the second.
        Op::SRem => a.signed().checked_rem(b.signed())?.cast_unsigned(),
        Op::SMod => {
            let rest = a.signed().checked_rem(b.signed())?;
            let other_sign = rest != 0 && (rest < 0) != (b.signed() < 0);
            if other_sign { rest.wrapping_add(b.signed()) } else { rest }.cast_unsigned()
        }
        Op::ShiftLeftLogical => a.bits << shift?,
        Op::ShiftRightLogical => a.bits >> shift?,
        Op::ShiftRightArithmetic => (a.signed() >> shift?).cast_unsigned(),
        Op::BitwiseAnd | Op::LogicalAnd => a.bits & b.bits,
        Op::BitwiseOr | Op::LogicalOr => a.bits | b.bits,
        Op::BitwiseXor => a.bits ^ b.bits,
        Op::IEqual | Op::LogicalEqual => is(a.bits == b.bits),
        Op::INotEqual | Op::LogicalNotEqual => is(a.bits != b.bits),
        Op::ULessThan => is(a.bits < b.bits),
        Op::ULessThanEqual => is(a.bits <= b.bits),
        Op::UGreaterThan => is(a.bits > b.bits),
        Op::UGreaterThanEqual => is(a.bits >= b.bits),
        Op::SLessThan => is(a.signed() < b.signed()),
        Op::SLessThanEqual => is(a.signed() <= b.signed()),
        Op::SGreaterThan => is(a.signed() > b.signed()),
        Op::SGreaterThanEqual => is(a.signed() >= b.signed()),
        _ => return None,
    };
    Some(Value::number(bits, width))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn declare(constants: &mut Constants<'static>, op: Op, operands: &[u32]) -> bool {
        constants.declare(&Instruction { opcode: op as u32, operands: operands.to_vec().leak() }).is_some()
    }

    /// A 32-bit integer (type 1), a vector of four of them (type 2), and the constant 3 with the value 7.
    fn some() -> Constants<'static> {
        let mut constants = Constants::new(&[], &HashMap::new());
        for (op, operands) in
            [(Op::TypeInt, [1, 32, 1].as_slice()), (Op::TypeVector, &[2, 1, 4]), (Op::Constant, &[1, 3, 7])]
        {
            assert!(declare(&mut constants, op, operands));
        }
        constants
    }

    #[test]
    fn large_constants_have_no_value() {
        let mut constants = some();
        // Each has the last one twice.
        let known = (4..60_u32)
            .take_while(|id| declare(&mut constants, Op::ConstantComposite, &[2, *id, id - 1, id - 1]))
            .count();
        assert_eq!(known, 5, "2 + 4 + 8 + 16 + 32 scalars and groups are the most");
        // Each has the last one once, deeper and deeper.
        let mut constants = some();
        let known =
            (4..200_u32).take_while(|id| declare(&mut constants, Op::ConstantComposite, &[2, *id, id - 1])).count();
        assert!(known < MOST_PARTS, "{known}");
        let mut constants = some();
        let members: Vec<u32> = std::iter::once(4).chain([2; 40]).collect();
        assert!(declare(&mut constants, Op::TypeStruct, &members));
        assert!(
            declare(&mut constants, Op::ConstantNull, &[2, 5]) && !declare(&mut constants, Op::ConstantNull, &[4, 6])
        );
        // All of them together have room, too.
        let known = (10..1_000_000_u32).take_while(|id| declare(&mut constants, Op::ConstantNull, &[2, *id])).count();
        assert!(known <= MOST_IN_ALL, "{known}");
    }

    #[test]
    fn a_quotient_without_a_place_has_no_value() {
        let mut constants = some();
        assert!(
            declare(&mut constants, Op::Constant, &[1, 4, 1 << 31])
                && declare(&mut constants, Op::Constant, &[1, 5, u32::MAX])
        );
        assert!(!declare(&mut constants, Op::SpecConstantOp, &[1, 6, Op::SDiv as u32, 4, 5]));
        assert!(declare(&mut constants, Op::SpecConstantOp, &[1, 7, Op::SDiv as u32, 3, 5]));
        assert_eq!(constants.bits(7), Some(u64::from((-7_i32).cast_unsigned())));
    }
}
