//! Bounds on arrays in shared memory. An access outside an array that a workgroup shares has no defined effect, and Vulkan's robust buffer
//! access does not cover it: a GPU may lose the device, and a software driver writes into the memory of the process. So every index into a
//! shared array, vector or matrix becomes `min(index, length - 1)`, read as unsigned, unless the index is visibly inside: a constant,
//! `i & 63u`, `i % 64u`, `min(i, 63u)`. One instruction an index; a correct access stays as it is.

use std::collections::HashMap;

use spirv::{GLOp, Op, StorageClass};

use crate::additions::{Additions, write};
use crate::error::ModuleError;
use crate::instruction::Instruction;

/// The module with its shared accesses bounded; `None` when there is nothing to bound.
///
/// # Errors
/// When a bound cannot be written: the length has not 32 bits, or no ids are left.
pub(crate) fn bounded(words: &[u32], instructions: &[Instruction<'_>]) -> Result<Option<Vec<u32>>, ModuleError> {
    let split = instructions.iter().position(|instruction| instruction.is(Op::Function)).unwrap_or(instructions.len());
    let (declarations, functions) = instructions.split_at(split);
    let mut clamper = Clamper {
        declared: Declared::of(instructions),
        additions: Additions::new(words[3], declarations),
        last: HashMap::new(),
    };
    let mut rewritten = Vec::new();
    let mut clamps = 0usize;
    for instruction in functions {
        let chain = instruction.is(Op::AccessChain) || instruction.is(Op::InBoundsAccessChain);
        let bounds = if chain { clamper.declared.bounds(instruction.operands) } else { Vec::new() };
        let mut operands = instruction.operands.to_vec();
        for (position, length) in bounds {
            if let Length::Specialized(id) = length
                && clamper.declared.width(id) != Some(32)
            {
                let message = "the length of an array in shared memory is a constant that has not 32 bits";
                return Err(ModuleError::Unsupported(message.to_owned()));
            }
            operands[position] = clamper.clamp(operands[position], length, &mut rewritten);
            clamps += 1;
        }
        Instruction { opcode: instruction.opcode, operands: &operands }.write(&mut rewritten);
    }
    if clamps == 0 {
        return Ok(None);
    }
    let unsupported =
        |reason| ModuleError::Unsupported(format!("the bounds of its shared memory cannot be written: {reason}"));
    clamper.additions.assemble(words, declarations, &rewritten).map(Some).map_err(unsupported)
}

/// The types that an access can step into.
#[derive(Clone, Copy)]
enum Type<'w> {
    /// Width in bits.
    Integer(u32),
    /// Element, and the constant that is the length.
    Array(u32, u32),
    /// Component or column, and how many.
    Vector(u32, u32),
    Struct(&'w [u32]),
    /// To shared memory.
    SharedPointer(u32),
}

/// Elements of an array, or components of a vector or matrix.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Length {
    Literal(u32),
    /// The id of a specialization constant, of one computed from them, or of a constant of another width.
    Specialized(u32),
}

/// The declarations of the module, as far as they matter here.
#[derive(Default)]
struct Declared<'w> {
    types: HashMap<u32, Type<'w>>,
    /// Types of the values that are integers or pointers to shared memory.
    values: HashMap<u32, u32>,
    /// 32-bit constants that cannot be specialized.
    constants: HashMap<u32, u32>,
    /// Specialization constants that are `length - 1`, with their lengths.
    last: HashMap<u32, u32>,
    /// The largest that a value can be, read as unsigned: a constant, or one of `last`.
    largest: HashMap<u32, u32>,
    /// The largest that a remainder can be.
    remainders: HashMap<u32, u32>,
    /// The extended instruction set of GLSL.
    glsl: Option<u32>,
}

impl<'w> Declared<'w> {
    fn of(instructions: &[Instruction<'w>]) -> Self {
        let mut declared = Self::default();
        let mut in_functions = false;
        for instruction in instructions {
            in_functions |= instruction.is(Op::Function);
            declared.declaration(instruction);
            declared.limit(instruction);
            // In a function a type only ever comes first as the type of a result; before that, constants and variables have one.
            let typed = in_functions
                || instruction.is(Op::Undef)
                || instruction.is(Op::Variable)
                || (Op::ConstantTrue as u32..=Op::SpecConstantOp as u32).contains(&instruction.opcode);
            if let ([ty, id, ..], true) = (instruction.operands, typed)
                && matches!(declared.types.get(ty), Some(Type::Integer(_) | Type::SharedPointer(_)))
            {
                declared.values.insert(*id, *ty);
            }
        }
        declared
    }

    fn declaration(&mut self, instruction: &Instruction<'w>) {
        let declared = match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::ExtInstImport), [id, name @ ..]) => {
                if name == NAME {
                    self.glsl = Some(*id);
                }
                return;
            }
            (Some(Op::Constant), [_, id, value]) => {
                self.constants.insert(*id, *value);
                return;
            }
            (Some(Op::TypeInt), [id, width, _]) => (*id, Type::Integer(*width)),
            (Some(Op::TypeArray), [id, element, length]) => (*id, Type::Array(*element, *length)),
            (Some(Op::TypeVector | Op::TypeMatrix), [id, part, count]) => (*id, Type::Vector(*part, *count)),
            (Some(Op::TypeStruct), [id, members @ ..]) => (*id, Type::Struct(members)),
            (Some(Op::TypePointer), [id, class, pointee]) if *class == StorageClass::Workgroup as u32 => {
                (*id, Type::SharedPointer(*pointee))
            }
            _ => return,
        };
        self.types.insert(declared.0, declared.1);
    }

    /// Remembers an instruction's limit of its result.
    fn limit(&mut self, instruction: &Instruction<'w>) {
        let known = |id: &u32| self.constants.contains_key(id) || self.last.contains_key(id);
        match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::SpecConstantOp), [_, id, op, length, one])
                if *op == Op::ISub as u32 && self.constants.get(one) == Some(&1) =>
            {
                self.last.insert(*id, *length);
            }
            (Some(Op::ExtInst), [_, id, set, number, a, b])
                if Some(*set) == self.glsl && *number == GLOp::UMin as u32 =>
            {
                let limit = [b, a].into_iter().find(|id| known(id)).copied();
                self.largest.extend(limit.map(|limit| (*id, limit)));
            }
            (Some(Op::BitwiseAnd), [_, id, a, b]) => {
                let limit = [b, a].into_iter().find(|id| self.constants.contains_key(id)).copied();
                self.largest.extend(limit.map(|limit| (*id, limit)));
            }
            (Some(Op::UMod), [_, id, _, divisor]) => {
                if let Some(divisor @ 1..) = self.constants.get(divisor).copied() {
                    self.remainders.insert(*id, divisor - 1);
                }
            }
            _ => {}
        }
    }

    /// Bits of an integer.
    fn width(&self, id: u32) -> Option<u32> {
        match self.values.get(&id).and_then(|ty| self.types.get(ty)) {
            Some(Type::Integer(width)) => Some(*width),
            _ => None,
        }
    }

    /// Whether an index is known to be inside.
    fn inside(&self, index: u32, length: Length) -> bool {
        let largest = self.largest.get(&index).copied().unwrap_or(index);
        match length {
            Length::Literal(length) => {
                let value = self.remainders.get(&index).or_else(|| self.constants.get(&largest));
                value.is_some_and(|value| *value < length)
            }
            Length::Specialized(length) => self.last.get(&largest) == Some(&length),
        }
    }

    /// The operands of an access chain that need a bound, with the lengths that bound them: none when it is not into shared memory.
    fn bounds(&self, operands: &[u32]) -> Vec<(usize, Length)> {
        let mut bounds = Vec::new();
        let [_, _, base, indices @ ..] = operands else { return bounds };
        let Some(&Type::SharedPointer(mut at)) = self.values.get(base).and_then(|ty| self.types.get(ty)) else {
            return bounds;
        };
        for (position, index) in (3..).zip(indices) {
            let constant = self.constants.get(index);
            let (next, length) = match self.types.get(&at) {
                Some(Type::Array(element, length)) => {
                    let literal = self.constants.get(length).map(|length| Length::Literal(*length));
                    (*element, literal.unwrap_or(Length::Specialized(*length)))
                }
                Some(Type::Vector(part, count)) => (*part, Length::Literal(*count)),
                Some(Type::Struct(members)) => {
                    let Some(member) = constant.and_then(|index| members.get(*index as usize)) else { return bounds };
                    at = *member;
                    continue;
                }
                _ => return bounds,
            };
            if !self.inside(*index, length) {
                bounds.push((position, length));
            }
            at = next;
        }
        bounds
    }
}

/// `GLSL.std.450` as a literal string (section 2.2.1).
const NAME: &[u32] = &[u32::from_le_bytes(*b"GLSL"), u32::from_le_bytes(*b".std"), u32::from_le_bytes(*b".450"), 0];

/// Writes the clamps, and the declarations that they need.
struct Clamper<'w> {
    declared: Declared<'w>,
    additions: Additions,
    /// `length - 1` of each length that bounds something.
    last: HashMap<Length, u32>,
}

impl Clamper<'_> {
    /// Writes `min(index, length - 1)` and gives its id.
    fn clamp(&mut self, index: u32, length: Length, function: &mut Vec<u32>) -> u32 {
        let uint = self.additions.ty(Op::TypeInt, &[32, 0]);
        let last = self.last(uint, length);
        let glsl = self.glsl();
        let (ty, index) = match self.declared.values.get(&index).copied() {
            Some(ty) if self.declared.width(index) == Some(32) => (ty, index),
            // Of 64 bits the lower half, of 16 or 8 zero-extended: an index inside the bounds stays the same.
            _ => {
                let converted = self.additions.id();
                write(Op::UConvert, &[uint, converted, index], function);
                (uint, converted)
            }
        };
        let clamped = self.additions.id();
        write(Op::ExtInst, &[ty, clamped, glsl, GLOp::UMin as u32, index, last], function);
        clamped
    }

    fn glsl(&mut self) -> u32 {
        *self.declared.glsl.get_or_insert_with(|| {
            let glsl = self.additions.id();
            write(Op::ExtInstImport, &[&[glsl], NAME].concat(), &mut self.additions.imports);
            glsl
        })
    }

    /// The id of `length - 1`.
    fn last(&mut self, uint: u32, length: Length) -> u32 {
        *self.last.entry(length).or_insert_with(|| match length {
            Length::Literal(length) => self.additions.constant(uint, length.saturating_sub(1)),
            Length::Specialized(length) => {
                let one = self.additions.constant(uint, 1);
                let last = self.additions.id();
                let operands = [uint, last, Op::ISub as u32, length, one];
                write(Op::SpecConstantOp, &operands, &mut self.additions.words);
                last
            }
        })
    }
}
