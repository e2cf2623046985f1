//! The additions of a pass to a module: ids, types and constants. A type that the module has already is used again, since a module may
//! declare it only once (section 2.8).

use std::collections::HashMap;

use spirv::{BuiltIn, Decoration, Op};

use crate::binary::HEADER_WORDS;
use crate::check::MAX_BOUND;
use crate::instruction::{Instruction, MAX_OPERANDS};

/// Instructions that are added to the sections of a module (section 2.4).
pub(crate) struct Additions {
    next_id: u32,
    pub capabilities: Vec<u32>,
    pub imports: Vec<u32>,
    pub decorations: Vec<u32>,
    /// Types, constants and variables, behind those of the module.
    pub words: Vec<u32>,
    /// Variables that an entry point has to list.
    pub interface: Vec<u32>,
    /// By opcode and by the operands without the result.
    known: HashMap<(u32, Vec<u32>), u32>,
}

impl Additions {
    pub(crate) fn new(next_id: u32, declarations: &[Instruction<'_>]) -> Self {
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
        let [capabilities, imports, decorations, words, interface] = [const { Vec::new() }; 5];
        Self { next_id, capabilities, imports, decorations, words, interface, known }
    }

    pub(crate) fn id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id - 1
    }

    /// A type of these parts that has no decorations.
    pub(crate) fn ty(&mut self, op: Op, parts: &[u32]) -> u32 {
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
    pub(crate) fn constant(&mut self, ty: u32, value: u32) -> u32 {
        let key = (Op::Constant as u32, vec![ty, value]);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let id = self.id();
        write(Op::Constant, &[ty, id, value], &mut self.words);
        self.known.insert(key, id);
        id
    }

    /// The module with all additions. `words` are its header, and `functions` those of the module or of a copy.
    ///
    /// # Errors
    /// When no ids are left, or an entry point has no room for the variables that it has to list.
    pub(crate) fn assemble(
        &self,
        words: &[u32],
        declarations: &[Instruction<'_>],
        functions: &[u32],
    ) -> Result<Vec<u32>, &'static str> {
        if self.next_id > MAX_BOUND {
            return Err("the module leaves no ids for it");
        }
        let mut assembled = words[..HEADER_WORDS].to_vec();
        assembled[3] = self.next_id;
        assembled.extend_from_slice(&self.capabilities);
        let types = declarations.iter().position(is_declaration).unwrap_or(declarations.len());
        for (at, instruction) in declarations.iter().enumerate() {
            if at == types {
                assembled.extend_from_slice(&self.decorations);
            }
            if instruction.is(Op::MemoryModel) {
                assembled.extend_from_slice(&self.imports);
            }
            if instruction.is(Op::EntryPoint) {
                let listed = interface(instruction.operands);
                let missing = self.interface.iter().filter(|variable| !listed.contains(variable));
                let operands: Vec<u32> = instruction.operands.iter().chain(missing).copied().collect();
                if operands.len() > MAX_OPERANDS {
                    return Err("the entry point has too many variables");
                }
                Instruction { opcode: instruction.opcode, operands: &operands }.write(&mut assembled);
            } else {
                instruction.write(&mut assembled);
            }
        }
        assembled.extend_from_slice(&self.words);
        assembled.extend_from_slice(functions);
        Ok(assembled)
    }
}

/// The variable that is a built-in, and the type of its pointer.
pub(crate) fn built_in(declarations: &[Instruction<'_>], wanted: BuiltIn) -> Option<(u32, u32)> {
    let id = declarations.iter().find_map(|instruction| match instruction.operands {
        [id, decoration, built_in] if instruction.is(Op::Decorate) => {
            let is_wanted = (*decoration, *built_in) == (Decoration::BuiltIn as u32, wanted as u32);
            is_wanted.then_some(*id)
        }
        _ => None,
    })?;
    declarations.iter().find_map(|instruction| match instruction.operands {
        [ty, variable, ..] if instruction.is(Op::Variable) && *variable == id => Some((id, *ty)),
        _ => None,
    })
}

/// Appends an instruction.
pub(crate) fn write(op: Op, operands: &[u32], words: &mut Vec<u32>) {
    Instruction { opcode: op as u32, operands }.write(words);
}

/// Whether an instruction stands in the section that follows the decorations (section 2.4): types, constants and global variables, and what may
/// stand between them.
fn is_declaration(instruction: &Instruction<'_>) -> bool {
    let sections =
        [Op::TypeVoid as u32..=Op::TypeForwardPointer as u32, Op::ConstantTrue as u32..=Op::SpecConstantOp as u32];
    let others = [Op::Variable, Op::Undef, Op::Line, Op::NoLine, Op::ExtInst];
    sections.iter().any(|section| section.contains(&instruction.opcode)) || others.iter().any(|op| instruction.is(*op))
}

/// The variables that an entry point lists, behind its name.
fn interface(operands: &[u32]) -> &[u32] {
    let name = operands.get(2..).unwrap_or(&[]);
    let end = name.iter().position(|word| word.to_le_bytes().contains(&0)).map_or(name.len(), |last| last + 1);
    &name[end..]
}
