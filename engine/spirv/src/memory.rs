//! How much memory the variables of a module take: those that each thread has for itself, and those that a workgroup shares.

use std::collections::HashMap;

use spirv::{Op, StorageClass};

use crate::instruction::Instruction;

/// Bytes of variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Of each thread, all functions together.
    pub private: u64,
    /// Of each workgroup.
    pub shared: u64,
}

/// Adds up the variables. Arrays whose length is a specialization constant count with its default, those whose length is computed
/// from one with one element.
pub(crate) fn memory(instructions: &[Instruction<'_>]) -> Memory {
    let mut constants: HashMap<u32, u64> = HashMap::new();
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
                let length = constants.get(length).copied().unwrap_or(1);
                (*id, size_of(element).saturating_mul(length))
            }
            (Some(Op::TypeStruct), [id, members @ ..]) => {
                (*id, members.iter().map(size_of).fold(0, u64::saturating_add))
            }
            (Some(Op::TypePointer), [id, _, pointee]) => {
                pointees.insert(*id, size_of(pointee));
                (*id, 8)
            }
            (Some(Op::Constant | Op::SpecConstant), [_, id, low, high @ ..]) => {
                let high = high.first().map_or(0, |high| u64::from(*high) << 32);
                constants.insert(*id, high | u64::from(*low));
                continue;
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
            _ => continue,
        };
        sizes.insert(id, size);
    }
    memory
}
