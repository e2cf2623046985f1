//! The ways to write a texel, and what each leaves there.

use spirv::Op;

/// The ways to write a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each variant but `Store` is the atomic instruction of its name")]
pub enum WriteKind {
    /// No atomic operation: all of the texel.
    Store,
    AtomicStore,
    Exchange,
    CompareExchange,
    Increment,
    Decrement,
    Add,
    Subtract,
    SignedMin,
    UnsignedMin,
    SignedMax,
    UnsignedMax,
    And,
    Or,
    Xor,
    FloatMin,
    FloatMax,
    FloatAdd,
}

impl WriteKind {
    /// The kind of an instruction that is atomic and may write.
    pub(super) fn of(op: Op) -> Option<Self> {
        Some(match op {
            Op::AtomicStore => Self::AtomicStore,
            Op::AtomicExchange => Self::Exchange,
            Op::AtomicCompareExchange => Self::CompareExchange,
            Op::AtomicIIncrement => Self::Increment,
            Op::AtomicIDecrement => Self::Decrement,
            Op::AtomicIAdd => Self::Add,
            Op::AtomicISub => Self::Subtract,
            Op::AtomicSMin => Self::SignedMin,
            Op::AtomicUMin => Self::UnsignedMin,
            Op::AtomicSMax => Self::SignedMax,
            Op::AtomicUMax => Self::UnsignedMax,
            Op::AtomicAnd => Self::And,
            Op::AtomicOr => Self::Or,
            Op::AtomicXor => Self::Xor,
            Op::AtomicFMinEXT => Self::FloatMin,
            Op::AtomicFMaxEXT => Self::FloatMax,
            Op::AtomicFAddEXT => Self::FloatAdd,
            _ => return None,
        })
    }

    /// The words that were written, of the words of a record's value; `None` if nothing was. Of an atomic operation they are the texel before
    /// it, the operand, and of a comparison the value that it expects.
    pub fn written(self, words: [u32; 4]) -> Option<[u32; 4]> {
        let [old, operand, expected, _] = words;
        let (signed_old, signed) = (old.cast_signed(), operand.cast_signed());
        let (float_old, float) = (f32::from_bits(old), f32::from_bits(operand));
        let new = match self {
            Self::Store => return Some(words),
            Self::CompareExchange => return (old == expected).then_some([operand, 0, 0, 0]),
            Self::AtomicStore | Self::Exchange => operand,
            Self::Increment => old.wrapping_add(1),
            Self::Decrement => old.wrapping_sub(1),
            Self::Add => old.wrapping_add(operand),
            Self::Subtract => old.wrapping_sub(operand),
            Self::SignedMin => signed_old.min(signed).cast_unsigned(),
            Self::UnsignedMin => old.min(operand),
            Self::SignedMax => signed_old.max(signed).cast_unsigned(),
            Self::UnsignedMax => old.max(operand),
            Self::And => old & operand,
            Self::Or => old | operand,
            Self::Xor => old ^ operand,
            Self::FloatMin => float_old.min(float).to_bits(),
            Self::FloatMax => float_old.max(float).to_bits(),
            Self::FloatAdd => (float_old + float).to_bits(),
        };
        Some([new, 0, 0, 0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_that_an_atomic_operation_leaves_is_computed() {
        let float = f32::to_bits;
        for (kind, words, left) in [
            (WriteKind::Store, [1, 2, 3, 4], Some([1, 2, 3, 4])),
            (WriteKind::AtomicStore, [0, 7, 0, 0], Some([7, 0, 0, 0])),
            (WriteKind::Exchange, [5, 7, 0, 0], Some([7, 0, 0, 0])),
            (WriteKind::CompareExchange, [5, 7, 5, 0], Some([7, 0, 0, 0])),
            (WriteKind::CompareExchange, [5, 7, 6, 0], None),
            (WriteKind::Increment, [u32::MAX, 0, 0, 0], Some([0, 0, 0, 0])),
            (WriteKind::Decrement, [0, 0, 0, 0], Some([u32::MAX, 0, 0, 0])),
            (WriteKind::Add, [u32::MAX, 2, 0, 0], Some([1, 0, 0, 0])),
            (WriteKind::Subtract, [1, 2, 0, 0], Some([u32::MAX, 0, 0, 0])),
            (WriteKind::SignedMin, [u32::MAX, 1, 0, 0], Some([u32::MAX, 0, 0, 0])),
            (WriteKind::UnsignedMin, [u32::MAX, 1, 0, 0], Some([1, 0, 0, 0])),
            (WriteKind::SignedMax, [u32::MAX, 1, 0, 0], Some([1, 0, 0, 0])),
            (WriteKind::UnsignedMax, [u32::MAX, 1, 0, 0], Some([u32::MAX, 0, 0, 0])),
            (WriteKind::And, [6, 3, 0, 0], Some([2, 0, 0, 0])),
            (WriteKind::Or, [6, 3, 0, 0], Some([7, 0, 0, 0])),
            (WriteKind::Xor, [6, 3, 0, 0], Some([5, 0, 0, 0])),
            (WriteKind::FloatMin, [float(2.0), float(-1.0), 0, 0], Some([float(-1.0), 0, 0, 0])),
            (WriteKind::FloatMax, [float(2.0), float(-1.0), 0, 0], Some([float(2.0), 0, 0, 0])),
            (WriteKind::FloatAdd, [float(2.0), float(-1.0), 0, 0], Some([float(1.0), 0, 0, 0])),
        ] {
            assert_eq!(kind.written(words), left, "{kind:?}");
        }
    }
}
