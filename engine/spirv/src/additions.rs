//! The additions of a pass to a module: ids, types and constants. A type that the module has already is used again, since a module may
//! declare it only once (section 2.8).

use std::collections::HashMap;

use spirv::Op;

use crate::instruction::Instruction;

/// Types and constants that are added behind those of a module.
pub(crate) struct Additions {
    pub next_id: u32,
    /// The instructions that declare them.
    pub words: Vec<u32>,
    /// By opcode and by the operands without the result.
    known: HashMap<(u32, Vec<u32>), u32>,
}

impl Additions {
    pub fn new(next_id: u32, declarations: &[Instruction<'_>]) -> Self {
        let types = Op::TypeVoid as u32..=Op::TypeForwardPointer as u32;
        let mut known = HashMap::new();
        for instruction in declarations {
            match instruction.operands {
                [id, rest @ ..] if types.contains(&instruction.opcode) => {
                    known.entry((instruction.opcode, rest.to_vec())).or_insert(*id);
                }
                [ty, id, value] if instruction.is(Op::Constant) => {
                    known.entry((instruction.opcode, vec![*ty, *value])).or_insert(*id);
                }
                _ => {}
            }
        }
        Self { next_id, words: Vec::new(), known }
    }

    pub fn id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id - 1
    }

    /// A type of these parts that has no decorations.
    pub fn ty(&mut self, op: Op, parts: &[u32]) -> u32 {
        let key = (op as u32, parts.to_vec());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let id = self.id();
        write(op, &[&[id], parts].concat(), &mut self.words);
        self.known.insert(key, id);
        id
    }

    /// A constant of a type of 32 bits.
    pub fn constant(&mut self, ty: u32, value: u32) -> u32 {
        let key = (Op::Constant as u32, vec![ty, value]);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let id = self.id();
        write(Op::Constant, &[ty, id, value], &mut self.words);
        self.known.insert(key, id);
        id
    }
}

/// Appends an instruction.
pub(crate) fn write(op: Op, operands: &[u32], words: &mut Vec<u32>) {
    Instruction { opcode: op as u32, operands }.write(words);
}

/// Whether an instruction is a type, constant or global variable: the section that follows the decorations (section 2.4).
pub(crate) fn is_declaration(instruction: &Instruction<'_>) -> bool {
    let sections =
        [Op::TypeVoid as u32..=Op::TypeForwardPointer as u32, Op::ConstantTrue as u32..=Op::SpecConstantOp as u32];
    sections.iter().any(|section| section.contains(&instruction.opcode))
        || instruction.is(Op::Variable)
        || instruction.is(Op::Undef)
}

/// The variables that an entry point lists, behind its name.
pub(crate) fn interface(operands: &[u32]) -> &[u32] {
    let name = operands.get(2..).unwrap_or(&[]);
    let end = name.iter().position(|word| word.to_le_bytes().contains(&0)).map_or(name.len(), |last| last + 1);
    &name[end..]
}
