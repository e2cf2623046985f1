//! Values of uniform blocks and push constants that no driver can fold into a shader. lavapipe compiles a shader again, at each dispatch,
//! for the values that its branches depend on: milliseconds a frame, and memory that it releases only with the pipeline. So each loaded
//! value becomes `value | zero`. `zero` is the number of workgroups shifted right by 31: always 0, but unknown before a dispatch. The bits
//! of floats stay the same.

use std::collections::{HashMap, HashSet};

use spirv::{BuiltIn, Decoration, Op, StorageClass};

use crate::additions::{Additions, built_in, write};
use crate::instruction::Instruction;

/// The module with such values; `None` where nothing is loaded from a uniform block or push constants.
pub(crate) fn opaque(words: &[u32], instructions: &[Instruction<'_>]) -> Option<Vec<u32>> {
    let split = instructions.iter().position(|instruction| instruction.is(Op::Function))?;
    let (declarations, functions) = instructions.split_at(split);
    let mut declared = Declared::of(declarations);
    let mut hider = Hider { additions: Additions::new(words[3], declarations), workgroups: None };
    let mut rewritten = Vec::new();
    for instruction in functions {
        declared.pointer(instruction);
        match declared.uniform_load(instruction) {
            Some(shape) => hider.hide(instruction, shape, declarations, &mut rewritten)?,
            None => instruction.write(&mut rewritten),
        }
    }
    hider.workgroups?;
    hider.additions.assemble(words, declarations, &rewritten).ok()
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

/// The declarations of the module that matter here.
#[derive(Default)]
struct Declared {
    /// Scalars and vectors of 32-bit numbers.
    shapes: HashMap<u32, Shape>,
    /// Pointer types into uniform blocks and push constants.
    pointers: HashSet<u32>,
    /// Pointers of these types.
    uniform: HashSet<u32>,
}

impl Declared {
    fn of(declarations: &[Instruction<'_>]) -> Self {
        let mut declared = Self::default();
        for instruction in declarations {
            match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::TypeInt), [id, 32, _]) => {
                    declared.shapes.insert(*id, Shape { float: false, count: 1 });
                }
                (Some(Op::TypeFloat), [id, 32, ..]) => {
                    declared.shapes.insert(*id, Shape { float: true, count: 1 });
                }
                (Some(Op::TypeVector), [id, part, count @ 2..=4]) => {
                    if let Some(shape) = declared.shapes.get(part).copied() {
                        declared.shapes.insert(*id, Shape { count: *count, ..shape });
                    }
                }
                (Some(Op::TypePointer), [id, class, _])
                    if [StorageClass::Uniform as u32, StorageClass::PushConstant as u32].contains(class) =>
                {
                    declared.pointers.insert(*id);
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
            && self.pointers.contains(ty)
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
}

/// Writes the values that hide others, and the declarations that they need.
struct Hider {
    additions: Additions,
    /// Once a value was written.
    workgroups: Option<Workgroups>,
}

impl Hider {
    /// Writes a load whose result is the value `| zero`. `None` when the module declares the number of workgroups as something odd.
    fn hide(
        &mut self,
        load: &Instruction<'_>,
        shape: Shape,
        declarations: &[Instruction<'_>],
        function: &mut Vec<u32>,
    ) -> Option<()> {
        let Workgroups { variable, triple, uint, shift } = self.workgroups(declarations)?;
        let (ty, result) = (load.operands[0], load.operands[1]);
        let [value, groups, first, mut zero] = [(); 4].map(|()| self.additions.id());
        write(Op::Load, &[&[ty, value], &load.operands[2..]].concat(), function);
        write(Op::Load, &[triple, groups, variable], function);
        write(Op::CompositeExtract, &[uint, first, groups, 0], function);
        write(Op::ShiftRightLogical, &[uint, zero, first, shift], function);
        let bits = if shape.count > 1 { self.additions.ty(Op::TypeVector, &[uint, shape.count]) } else { uint };
        if shape.count > 1 {
            let scalar = std::mem::replace(&mut zero, self.additions.id());
            let parts = vec![scalar; shape.count as usize];
            write(Op::CompositeConstruct, &[&[bits, zero], parts.as_slice()].concat(), function);
        }
        if shape.float {
            let [before, after] = [(); 2].map(|()| self.additions.id());
            write(Op::Bitcast, &[bits, before, value], function);
            write(Op::BitwiseOr, &[bits, after, before, zero], function);
            write(Op::Bitcast, &[ty, result, after], function);
        } else {
            write(Op::BitwiseOr, &[ty, result, value, zero], function);
        }
        Some(())
    }

    fn workgroups(&mut self, declarations: &[Instruction<'_>]) -> Option<Workgroups> {
        if self.workgroups.is_some() {
            return self.workgroups;
        }
        let additions = &mut self.additions;
        let uint = additions.ty(Op::TypeInt, &[32, 0]);
        let triple = additions.ty(Op::TypeVector, &[uint, 3]);
        let class = StorageClass::Input as u32;
        let input = additions.ty(Op::TypePointer, &[class, triple]);
        let variable = match built_in(declarations, BuiltIn::NumWorkgroups) {
            Some((variable, ty)) if ty == input => variable,
            Some(_) => return None,
            None => {
                let variable = additions.id();
                write(Op::Variable, &[input, variable, class], &mut additions.words);
                let decoration = [variable, Decoration::BuiltIn as u32, BuiltIn::NumWorkgroups as u32];
                write(Op::Decorate, &decoration, &mut additions.decorations);
                variable
            }
        };
        additions.interface = vec![variable];
        let shift = additions.constant(uint, 31);
        self.workgroups = Some(Workgroups { variable, triple, uint, shift });
        self.workgroups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::MAX_BOUND;
    use crate::instruction::MAX_OPERANDS;

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
        // No valid vector has that many components.
        assert!(!is_changed(10, u32::MAX, 0));
        // The ids of the added instructions would lie beyond the largest, and an entry point has no room for one more variable.
        assert!(!is_changed(MAX_BOUND, 4, 0));
        assert!(is_changed(10, 4, MAX_OPERANDS - 5) && !is_changed(10, 4, MAX_OPERANDS - 4));
    }
}
