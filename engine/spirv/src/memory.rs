//! How much memory the variables of a module take: those that each thread has for itself, and those that a workgroup shares.

use std::collections::HashMap;

use spirv::{Decoration, Op, StorageClass};

use crate::instruction::Instruction;

/// Bytes of variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Of each thread, all functions together.
    pub private: u64,
    /// Of each workgroup.
    pub shared: u64,
}

/// Adds up the variables. `specialized` has the bits of specialization constants by their number; the others have their defaults. An array whose
/// length is computed in a way that is unknown here counts with one element.
pub(crate) fn memory(instructions: &[Instruction<'_>], specialized: &HashMap<u32, u32>) -> Memory {
    let mut constants = Constants::new(instructions, specialized);
    let mut sizes: HashMap<u32, u64> = HashMap::new();
    let mut pointees: HashMap<u32, u64> = HashMap::new();
    let mut memory = Memory::default();
    for instruction in instructions {
        let size_of = |id: &u32| sizes.get(id).copied().unwrap_or(0);
        let (id, size) = match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::TypeInt | Op::TypeFloat), [id, bits, ..]) => (*id, u64::from(bits / 8)),
            (Some(Op::TypeBool), [id, ..]) => (*id, 4),
            (Some(Op::TypeVector | Op::TypeMatrix), [id, element, count]) => {
                (*id, size_of(element).saturating_mul(u64::from(*count)))
            }
            (Some(Op::TypeArray), [id, element, length]) => {
                let length = constants.value(*length).unwrap_or(1);
                (*id, size_of(element).saturating_mul(length))
            }
            (Some(Op::TypeStruct), [id, members @ ..]) => {
                (*id, members.iter().map(size_of).fold(0, u64::saturating_add))
            }
            (Some(Op::TypePointer), [id, _, pointee]) => {
                pointees.insert(*id, size_of(pointee));
                (*id, 8)
            }
            (Some(Op::Variable), [ty, _, class, ..]) => {
                let size = pointees.get(ty).copied().unwrap_or(0);
                match StorageClass::from_u32(*class) {
                    Some(StorageClass::Private | StorageClass::Function) => {
                        memory.private = memory.private.saturating_add(size);
                    }
                    Some(StorageClass::Workgroup) => memory.shared = memory.shared.saturating_add(size),
                    _ => {}
                }
                continue;
            }
            _ => {
                constants.declare(instruction);
                continue;
            }
        };
        sizes.insert(id, size);
    }
    memory
}

/// The constants that are declared so far.
struct Constants {
    values: HashMap<u32, u64>,
    /// The bits of those that have other values than their defaults, by id.
    specialized: HashMap<u32, u32>,
}

impl Constants {
    fn new(instructions: &[Instruction<'_>], specialized: &HashMap<u32, u32>) -> Self {
        let number = |instruction: &Instruction<'_>| match instruction.operands {
            [id, decoration, number] if instruction.is(Op::Decorate) && *decoration == Decoration::SpecId as u32 => {
                specialized.get(number).map(|bits| (*id, *bits))
            }
            _ => None,
        };
        let specialized = instructions.iter().filter_map(number).collect();
        Self { values: HashMap::new(), specialized }
    }

    fn value(&self, id: u32) -> Option<u64> {
        self.values.get(&id).copied()
    }

    fn declare(&mut self, instruction: &Instruction<'_>) {
        match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::Constant | Op::SpecConstant), [_, id, low, high @ ..]) => {
                let default = high.first().map_or(0, |high| u64::from(*high) << 32) | u64::from(*low);
                self.values.insert(*id, self.specialized.get(id).map_or(default, |bits| u64::from(*bits)));
            }
            (Some(Op::SpecConstantOp), [_, id, op, operands @ ..]) => {
                if let Some(value) = self.computed(*op, operands) {
                    self.values.insert(*id, value);
                }
            }
            _ => {}
        }
    }

    /// The value of a computed constant of 32 bits.
    #[expect(clippy::cast_possible_truncation, reason = "lengths are of 32 bits")]
    fn computed(&self, op: u32, operands: &[u32]) -> Option<u64> {
        let number = |at: usize| self.value(*operands.get(at)?).map(|value| value as u32);
        let both = || Some((number(0)?, number(1)?));
        let value = match Op::from_u32(op)? {
            Op::IAdd => both().map(|(a, b)| a.wrapping_add(b))?,
            Op::ISub => both().map(|(a, b)| a.wrapping_sub(b))?,
            Op::IMul => both().map(|(a, b)| a.wrapping_mul(b))?,
            Op::UDiv => both().and_then(|(a, b)| a.checked_div(b))?,
            Op::UMod => both().and_then(|(a, b)| a.checked_rem(b))?,
            Op::SDiv => both().and_then(|(a, b)| a.cast_signed().checked_div(b.cast_signed()))?.cast_unsigned(),
            Op::ShiftLeftLogical => both().and_then(|(a, b)| a.checked_shl(b))?,
            Op::ShiftRightLogical => both().and_then(|(a, b)| a.checked_shr(b))?,
            Op::BitwiseAnd => both().map(|(a, b)| a & b)?,
            Op::BitwiseOr => both().map(|(a, b)| a | b)?,
            _ => return None,
        };
        Some(value.into())
    }
}
