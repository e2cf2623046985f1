//! How much memory the variables of a module take: those that each thread has for itself, and those that a workgroup shares.

use std::collections::HashMap;

use spirv::{Op, StorageClass};

use crate::constants::Constants;
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
/// length is not defined, such as a number divided by 0, counts with one element.
pub(crate) fn memory(instructions: &[Instruction<'_>], specialized: &HashMap<u32, u32>) -> Memory {
    let mut constants = Constants::new(instructions, specialized);
    let mut sizes: HashMap<u32, u64> = HashMap::new();
    let mut pointees: HashMap<u32, u64> = HashMap::new();
    let mut memory = Memory::default();
    for instruction in instructions {
        constants.declare(instruction);
        let size_of = |id: &u32| sizes.get(id).copied().unwrap_or(0);
        let (id, size) = match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::TypeInt | Op::TypeFloat), [id, bits, ..]) => (*id, u64::from(bits / 8)),
            (Some(Op::TypeBool), [id, ..]) => (*id, 4),
            (Some(Op::TypeVector | Op::TypeMatrix), [id, element, count]) => {
                (*id, size_of(element).saturating_mul(u64::from(*count)))
            }
            (Some(Op::TypeArray), [id, element, length]) => {
                let length = constants.bits(*length).unwrap_or(1);
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
            _ => continue,
        };
        sizes.insert(id, size);
    }
    memory
}
