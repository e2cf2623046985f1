//! Values of uniform blocks and push constants that no driver can fold into a shader. lavapipe compiles a shader again, at each dispatch,
//! for the values that its branches depend on: milliseconds a frame, and memory that it releases only with the pipeline. So each value that
//! is loaded becomes `value | zero`, where `zero` is the number of workgroups shifted right by 31: always 0, and nothing that is known
//! before a dispatch. The bits of floats stay the same.

use std::collections::{HashMap, HashSet};

use spirv::{BuiltIn, Decoration, Op, StorageClass};

use crate::additions::{interface, is_declaration, write};
use crate::binary::HEADER_WORDS;
use crate::check::MAX_BOUND;
use crate::instruction::{Instruction, MAX_OPERANDS};

/// The module with such values; `None` where nothing is loaded from a uniform block or push constants.
pub(crate) fn opaque(words: &[u32], instructions: &[Instruction<'_>]) -> Option<Vec<u32>> {
    let split = instructions.iter().position(|instruction| instruction.is(Op::Function))?;
    let (declarations, functions) = instructions.split_at(split);
    let mut declared = Declared::of(declarations);
    declared.next_id = words[3];
    let mut rewritten = Vec::new();
    let mut loads = 0usize;
    for instruction in functions {
        declared.pointer(instruction);
        match declared.uniform_load(instruction) {
            Some(shape) => {
                declared.hide(instruction, shape, &mut rewritten)?;
                loads += 1;
            }
            None => instruction.write(&mut rewritten),
        }
    }
    if loads == 0 || declared.next_id > MAX_BOUND {
        return None;
    }
    let workgroups = declared.workgroups?;
    let mut opaque = words[..HEADER_WORDS].to_vec();
    opaque[3] = declared.next_id;
    let types = declarations.iter().position(is_declaration).unwrap_or(declarations.len());
    for (at, instruction) in declarations.iter().enumerate() {
        if at == types {
            opaque.extend_from_slice(&declared.decorations);
        }
        if instruction.is(Op::EntryPoint) && !interface(instruction.operands).contains(&workgroups.variable) {
            let operands = [instruction.operands, &[workgroups.variable]].concat();
            if operands.len() > MAX_OPERANDS {
                return None;
            }
            Instruction { opcode: instruction.opcode, operands: &operands }.write(&mut opaque);
        } else {
            instruction.write(&mut opaque);
        }
    }
    opaque.extend_from_slice(&declared.additions);
    opaque.extend_from_slice(&rewritten);
    Some(opaque)
}

/// 32-bit components of a value.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Shape {
    float: bool,
    count: u32,
}

/// The variable with the number of workgroups, its type, that of its components, and the constant 31.
#[derive(Clone, Copy)]
struct Workgroups {
    variable: u32,
    triple: u32,
    uint: u32,
    shift: u32,
}

/// The declarations of the module, and the added ones.
#[derive(Default)]
struct Declared {
    /// Scalars and vectors of 32-bit numbers.
    shapes: HashMap<u32, Shape>,
    /// Pointer types: storage class and pointee.
    pointers: HashMap<u32, (u32, u32)>,
    /// Pointers to uniform blocks and push constants, and into them.
    uniform: HashSet<u32>,
    /// The unsigned 32-bit integer, and vectors of it by their lengths.
    unsigned: HashMap<u32, u32>,
    /// The variable with the number of workgroups and its type, where the module has one.
    built_in: Option<u32>,
    built_in_type: Option<u32>,
    workgroups: Option<Workgroups>,
    next_id: u32,
    decorations: Vec<u32>,
    additions: Vec<u32>,
}

impl Declared {
    fn of(declarations: &[Instruction<'_>]) -> Self {
        let mut declared = Self::default();
        for instruction in declarations {
            match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::Decorate), [id, decoration, built_in])
                    if (*decoration, *built_in) == (Decoration::BuiltIn as u32, BuiltIn::NumWorkgroups as u32) =>
                {
                    declared.built_in = Some(*id);
                }
                (Some(Op::TypeInt), [id, 32, signed]) => {
                    declared.shapes.insert(*id, Shape { float: false, count: 1 });
                    if *signed == 0 {
                        declared.unsigned.insert(1, *id);
                    }
                }
                (Some(Op::TypeFloat), [id, 32, ..]) => {
                    declared.shapes.insert(*id, Shape { float: true, count: 1 });
                }
                (Some(Op::TypeVector), [id, part, count @ 2..=4]) => {
                    if let Some(shape) = declared.shapes.get(part).copied() {
                        declared.shapes.insert(*id, Shape { count: *count, ..shape });
                        if declared.unsigned.get(&1) == Some(part) {
                            declared.unsigned.insert(*count, *id);
                        }
                    }
                }
                (Some(Op::TypePointer), [id, class, pointee]) => {
                    declared.pointers.insert(*id, (*class, *pointee));
                }
                (Some(Op::Variable), [ty, id, ..]) if declared.built_in == Some(*id) => {
                    declared.built_in_type = declared.pointers.get(ty).map(|(_, pointee)| *pointee);
                }
                _ => declared.pointer(instruction),
            }
        }
        declared
    }

    /// Remembers a result that points into a uniform block or push constants.
    fn pointer(&mut self, instruction: &Instruction<'_>) {
        let points = [Op::Variable, Op::AccessChain, Op::InBoundsAccessChain, Op::FunctionParameter, Op::CopyObject];
        if let [ty, id, ..] = instruction.operands
            && points.iter().any(|op| instruction.is(*op))
            && let Some((class, _)) = self.pointers.get(ty)
            && [StorageClass::Uniform as u32, StorageClass::PushConstant as u32].contains(class)
        {
            self.uniform.insert(*id);
        }
    }

    /// The shape that an instruction loads, if it is a number or vector from a uniform block or push constants.
    fn uniform_load(&self, instruction: &Instruction<'_>) -> Option<Shape> {
        let [ty, _, pointer, ..] = instruction.operands else { return None };
        let shape = self.shapes.get(ty).copied()?;
        (instruction.is(Op::Load) && self.uniform.contains(pointer)).then_some(shape)
    }

    /// Writes a load whose result is the value `| zero`. `None` when the module declares the number of workgroups as something odd.
    fn hide(&mut self, load: &Instruction<'_>, shape: Shape, function: &mut Vec<u32>) -> Option<()> {
        let Workgroups { variable, triple, uint, shift } = self.workgroups()?;
        let (ty, result) = (load.operands[0], load.operands[1]);
        let [value, groups, first, mut zero] = [(); 4].map(|()| self.id());
        write(Op::Load, &[&[ty, value], &load.operands[2..]].concat(), function);
        write(Op::Load, &[triple, groups, variable], function);
        write(Op::CompositeExtract, &[uint, first, groups, 0], function);
        write(Op::ShiftRightLogical, &[uint, zero, first, shift], function);
        let bits = self.unsigned(shape.count);
        if shape.count > 1 {
            let scalar = std::mem::replace(&mut zero, self.id());
            write(
                Op::CompositeConstruct,
                &[&[bits, zero], vec![scalar; shape.count as usize].as_slice()].concat(),
                function,
            );
        }
        if shape.float {
            let [before, after] = [(); 2].map(|()| self.id());
            write(Op::Bitcast, &[bits, before, value], function);
            write(Op::BitwiseOr, &[bits, after, before, zero], function);
            write(Op::Bitcast, &[ty, result, after], function);
        } else {
            write(Op::BitwiseOr, &[ty, result, value, zero], function);
        }
        Some(())
    }

    fn workgroups(&mut self) -> Option<Workgroups> {
        if self.workgroups.is_some() {
            return self.workgroups;
        }
        let (uint, triple) = (self.unsigned(1), self.unsigned(3));
        let variable = match self.built_in {
            Some(variable) if self.built_in_type == Some(triple) => variable,
            Some(_) => return None,
            None => {
                let [pointer, variable] = [(); 2].map(|()| self.id());
                let class = StorageClass::Input as u32;
                let known = self.pointers.iter().find(|(_, points)| **points == (class, triple)).map(|(id, _)| *id);
                if known.is_none() {
                    write(Op::TypePointer, &[pointer, class, triple], &mut self.additions);
                }
                write(Op::Variable, &[known.unwrap_or(pointer), variable, class], &mut self.additions);
                let decoration = [variable, Decoration::BuiltIn as u32, BuiltIn::NumWorkgroups as u32];
                write(Op::Decorate, &decoration, &mut self.decorations);
                variable
            }
        };
        let shift = self.id();
        write(Op::Constant, &[uint, shift, 31], &mut self.additions);
        self.workgroups = Some(Workgroups { variable, triple, uint, shift });
        self.workgroups
    }

    /// The unsigned 32-bit integer, or a vector of it.
    fn unsigned(&mut self, count: u32) -> u32 {
        if let Some(id) = self.unsigned.get(&count) {
            return *id;
        }
        let part = if count > 1 { Some(self.unsigned(1)) } else { None };
        let id = self.id();
        match part {
            Some(part) => write(Op::TypeVector, &[id, part, count], &mut self.additions),
            None => write(Op::TypeInt, &[id, 32, 0], &mut self.additions),
        }
        self.unsigned.insert(count, id);
        id
    }

    fn id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Declarations, and a function with one load from a uniform block.
    fn module(bound: u32, components: u32, interface: usize) -> Vec<u32> {
        let mut words = vec![0x0723_0203, 0x0001_0500, 0, bound, 0];
        let name = u32::from_le_bytes(*b"main");
        super::write(Op::EntryPoint, &[&[5, 1, name, 0], vec![1; interface].as_slice()].concat(), &mut words);
        for (op, operands) in [
            (Op::TypeVoid, [2].as_slice()),
            (Op::TypeFunction, &[3, 2]),
            (Op::TypeInt, &[4, 32, 0]),
            (Op::TypeVector, &[5, 4, components]),
            (Op::TypePointer, &[6, StorageClass::PushConstant as u32, 5]),
            (Op::Variable, &[6, 7, StorageClass::PushConstant as u32]),
            (Op::Function, &[2, 1, 0, 3]),
            (Op::Label, &[8]),
            (Op::Load, &[5, 9, 7]),
            (Op::Return, &[]),
            (Op::FunctionEnd, &[]),
        ] {
            super::write(op, operands, &mut words);
        }
        words
    }

    #[test]
    fn what_leaves_no_room_is_left_alone() {
        let is_changed = |bound, components, interface| {
            let words = module(bound, components, interface);
            crate::Module::new(&words, "main").unwrap().with_opaque_uniforms().is_some()
        };
        assert!(is_changed(10, 4, 0));
        // No vector that is valid has so many components.
        assert!(!is_changed(10, u32::MAX, 0));
        // The ids of the added instructions would lie beyond the largest, and an entry point has no room for one more variable.
        assert!(!is_changed(MAX_BOUND, 4, 0));
        assert!(is_changed(10, 4, MAX_OPERANDS - 5) && !is_changed(10, 4, MAX_OPERANDS - 4));
    }
}
