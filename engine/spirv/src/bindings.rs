//! Gives every binding a place of its own. Graphs bind by name, so the numbers in a shader mean nothing to them: HLSL with `register(t0)`
//! and `register(u0)` has both at binding 0, and a number may be larger than drivers take.

use std::collections::{HashMap, HashSet};

use spirv::{Decoration, Op, StorageClass};

use crate::instruction::Instruction;

/// Sets and bindings below these are left as they are when no two bindings share one (`maxBoundDescriptorSets` is at least 4).
const MOST_SETS: u32 = 4;
const MOST_BINDINGS: u32 = 256;

/// New binding numbers in set 0, by variable, in the order of the module. `None` when every used variable has a good place of its own.
pub(crate) fn renumbered(instructions: &[Instruction<'_>], used: &HashSet<u32>) -> Option<HashMap<u32, u32>> {
    let variables: Vec<u32> = (instructions.iter())
        .take_while(|instruction| !instruction.is(Op::Function))
        .filter(|instruction| instruction.is(Op::Variable))
        .filter_map(|instruction| match instruction.operands {
            [_, id, class, ..] if used.contains(id) => Some((*id, StorageClass::from_u32(*class)?)),
            _ => None,
        })
        .filter(|(_, class)| {
            matches!(class, StorageClass::Uniform | StorageClass::StorageBuffer | StorageClass::UniformConstant)
        })
        .map(|(id, _)| id)
        .collect();
    let mut places: HashMap<u32, [u32; 2]> = variables.iter().map(|id| (*id, [0; 2])).collect();
    for instruction in instructions {
        let Some((id, axis)) = place(instruction) else { continue };
        if let Some(place) = places.get_mut(&id) {
            place[axis] = instruction.operands[2];
        }
    }
    let mut taken = HashSet::new();
    let good = places.values().all(|place| place[0] < MOST_SETS && place[1] < MOST_BINDINGS && taken.insert(*place));
    (!good).then(|| variables.into_iter().zip(0..).collect())
}

/// The instruction of a variable with its new number.
pub(crate) fn write(instruction: &Instruction<'_>, numbers: &HashMap<u32, u32>, words: &mut Vec<u32>) {
    match place(instruction).and_then(|(id, axis)| Some((id, axis, *numbers.get(&id)?))) {
        Some((id, axis, number)) => {
            let number = if axis == 0 { 0 } else { number };
            Instruction { opcode: instruction.opcode, operands: &[id, instruction.operands[1], number] }.write(words);
        }
        None => instruction.write(words),
    }
}

/// The variable whose set (0) or binding (1) an instruction declares.
fn place(instruction: &Instruction<'_>) -> Option<(u32, usize)> {
    match instruction.operands {
        [id, decoration, _] if instruction.is(Op::Decorate) => match Decoration::from_u32(*decoration)? {
            Decoration::DescriptorSet => Some((*id, 0)),
            Decoration::Binding => Some((*id, 1)),
            _ => None,
        },
        _ => None,
    }
}
