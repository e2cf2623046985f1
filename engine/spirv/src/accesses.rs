//! Accesses out of bounds, found on demand. In front of each access to an array, vector or matrix by an index, and to an image by integer
//! coordinates, a call compares the index or the coordinates with the size. If they are out of bounds, the call counts, and keeps a
//! record of the first invocation. The access itself stays as it is, so a checked shader computes the same as an unchecked one.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use spirv::{Dim, FunctionControl, ImageOperands, Op, SelectionControl, StorageClass};

use crate::additions::write;
use crate::check::literal;
use crate::instruction::Instruction;
use crate::print::{PrintError, unsupported};
use crate::record::Writer;

/// Records of one access that the buffer has room for, in one run of the pass.
const RECORDS: u32 = 1;

/// Most accesses of a module.
const MAX_ACCESSES: usize = 16_384;

/// An access that is checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// The accessed array or image, by its name in the source: `items`, `block.items`; empty where the module has no names.
    pub name: String,
    /// Whether it is by an index or by coordinates.
    pub kind: AccessKind,
    /// Whether it writes.
    pub writes: bool,
    /// The file as the module names it, and the line, counted from 1. `None` in a module without line numbers.
    pub line: Option<(String, u32)>,
    /// The word of the buffer that counts how often it was out of bounds; a record follows. Its values are the index, or the coordinates, read
    /// as signed, and then as many sizes.
    pub first_word: u32,
}

/// The ways to access something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessKind {
    /// The index of an element.
    Element,
    /// So many coordinates of a texel.
    Texel(u32),
}

impl AccessKind {
    /// How many numbers say where.
    pub fn coordinates(self) -> u32 {
        match self {
            AccessKind::Element => 1,
            AccessKind::Texel(count) => count,
        }
    }
}

impl Access {
    /// Words of a record's values.
    pub fn words(&self) -> u32 {
        2 * self.kind.coordinates()
    }
}

/// The types that an access can step into.
#[derive(Clone, Copy)]
enum Type<'w> {
    /// Width in bits, and whether it has a sign.
    Integer(u32, bool),
    /// Element, and the constant that is the length.
    Array(u32, u32),
    /// Element.
    RuntimeArray(u32),
    /// Component or column, and how many.
    Vector(u32, u32),
    Struct(&'w [u32]),
    /// Storage class and pointee.
    Pointer(u32, u32),
    /// Coordinates, and whether it has several samples; no coordinates where it cannot be checked.
    Image(u32, bool),
    SampledImage,
}

/// The accesses of a module, as they are met.
pub(crate) struct Accesses<'w> {
    types: HashMap<u32, Type<'w>>,
    /// Types of values.
    values: HashMap<u32, u32>,
    /// 32-bit constants that cannot be specialized.
    constants: HashMap<u32, u32>,
    names: HashMap<u32, String>,
    members: HashMap<(u32, u32), String>,
    /// Pointers that are written through.
    written: HashSet<u32>,
    /// Chains of the block so far, by base and indices, with the first result and its checks: `a[i] += 1` makes two of one.
    chains: HashMap<(u32, Vec<u32>), (u32, Range<usize>)>,
    /// Functions that check a number of coordinates.
    checkers: HashMap<u32, u32>,
    pub found: Vec<Access>,
}

impl<'w> Accesses<'w> {
    pub(crate) fn new(instructions: &[Instruction<'w>]) -> Self {
        let mut accesses = Self {
            types: HashMap::new(),
            values: HashMap::new(),
            constants: HashMap::new(),
            names: HashMap::new(),
            members: HashMap::new(),
            written: HashSet::new(),
            chains: HashMap::new(),
            checkers: HashMap::new(),
            found: Vec::new(),
        };
        for instruction in instructions {
            accesses.declaration(instruction);
        }
        accesses
    }

    fn declaration(&mut self, instruction: &Instruction<'w>) {
        let op = Op::from_u32(instruction.opcode);
        let (id, ty) = match (op, instruction.operands) {
            (Some(Op::Name), [id, name @ ..]) => {
                self.names.extend(literal(name).ok().map(|name| (*id, name)));
                return;
            }
            (Some(Op::MemberName), [id, member, name @ ..]) => {
                self.members.extend(literal(name).ok().map(|name| ((*id, *member), name)));
                return;
            }
            (Some(Op::Constant), [ty, id, value]) => {
                self.constants.insert(*id, *value);
                self.values.insert(*id, *ty);
                return;
            }
            (Some(Op::TypeInt), [id, width, signed]) => (id, Type::Integer(*width, *signed != 0)),
            (Some(Op::TypeArray), [id, element, length]) => (id, Type::Array(*element, *length)),
            (Some(Op::TypeRuntimeArray), [id, element]) => (id, Type::RuntimeArray(*element)),
            (Some(Op::TypeVector | Op::TypeMatrix), [id, part, count]) => (id, Type::Vector(*part, *count)),
            (Some(Op::TypeStruct), [id, members @ ..]) => (id, Type::Struct(members)),
            (Some(Op::TypePointer), [id, class, pointee]) => (id, Type::Pointer(*class, *pointee)),
            (Some(Op::TypeSampledImage), [id, ..]) => (id, Type::SampledImage),
            (Some(Op::TypeImage), [id, _, dim, _, arrayed, samples, ..]) => {
                let dimensions = match Dim::from_u32(*dim) {
                    Some(Dim::Dim1D) => 1,
                    Some(Dim::Dim2D) => 2,
                    Some(Dim::Dim3D) => 3,
                    _ => 0,
                };
                let layers = u32::from(dimensions > 0 && *arrayed != 0);
                (id, Type::Image(dimensions + layers, *samples != 0))
            }
            (Some(Op::Store | Op::AtomicStore | Op::AtomicFlagClear | Op::CopyMemory), [pointer, ..]) => {
                self.written.insert(*pointer);
                return;
            }
            (Some(Op::AtomicLoad), _) => return,
            (Some(_), [_, _, pointer, ..])
                if (Op::AtomicExchange as u32..=Op::AtomicXor as u32).contains(&instruction.opcode) =>
            {
                self.written.insert(*pointer);
                return;
            }
            (Some(Op::Variable | Op::SpecConstant | Op::SpecConstantOp), [ty, id, ..]) => {
                self.values.insert(*id, *ty);
                return;
            }
            _ => return,
        };
        self.types.insert(*id, ty);
    }

    /// Writes the checks that an instruction of a function needs in front of it.
    pub(crate) fn check(
        &mut self,
        instruction: &Instruction<'w>,
        line: Option<&(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        // In a function a type only ever comes first as the type of a result.
        if let [ty, id, ..] = instruction.operands
            && self.types.contains_key(ty)
        {
            self.values.insert(*id, *ty);
        }
        match (Op::from_u32(instruction.opcode), instruction.operands) {
            (Some(Op::Label), _) => self.chains.clear(),
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, indices @ ..]) => {
                self.chain(*id, *base, indices, line, writer, function)?;
            }
            // A name follows the loaded value.
            (Some(Op::Load | Op::Image | Op::CopyObject), [_, id, from, ..]) => self.rename(*id, *from),
            (Some(Op::ImageWrite), [image, coordinate, ..]) => {
                self.texel((*image, None), *coordinate, true, line, writer, function)?;
            }
            (Some(Op::ImageRead), [_, _, image, coordinate, ..]) => {
                self.texel((*image, None), *coordinate, false, line, writer, function)?;
            }
            (Some(Op::ImageFetch), [_, _, image, coordinate, operands @ ..]) => {
                // Of the operands the level comes first: a bias there is none.
                let level = match operands {
                    [mask, level, ..] if mask & ImageOperands::LOD.bits() != 0 => *level,
                    _ => writer.constant(0),
                };
                self.texel((*image, Some(level)), *coordinate, false, line, writer, function)?;
            }
            (Some(Op::ImageTexelPointer), [_, _, pointer, coordinate, ..]) => {
                let Some(Type::Pointer(_, image)) = self.type_of(*pointer) else { return Ok(()) };
                let loaded = writer.additions.id();
                write(Op::Load, &[image, loaded, *pointer], function);
                self.values.insert(loaded, image);
                self.rename(loaded, *pointer);
                self.texel((loaded, None), *coordinate, true, line, writer, function)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The checks of the indices of an access chain.
    fn chain(
        &mut self,
        id: u32,
        base: u32,
        indices: &[u32],
        line: Option<&(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        let Some(Type::Pointer(class, mut at)) = self.type_of(base) else { return Ok(()) };
        let known = (base, indices.to_vec());
        if let Some((first, checked)) = self.chains.get(&known).cloned() {
            self.rename(id, first);
            let writes = self.written.contains(&id);
            self.found[checked].iter_mut().for_each(|access| access.writes |= writes);
            return Ok(());
        }
        let before = self.found.len();
        let mut name = self.names.get(&base).cloned().unwrap_or_default();
        // Of the struct around the type that is stepped into: the number of indices of the pointer to it, and the member.
        let mut around = None;
        for (position, index) in indices.iter().enumerate() {
            let constant = self.constants.get(index).copied();
            let size = match self.types.get(&at).copied() {
                Some(Type::Struct(members)) => {
                    let Some(next) = constant.and_then(|index| members.get(index as usize)) else { return Ok(()) };
                    around = constant.map(|member| (position, at, member));
                    if let Some(member) = constant.and_then(|member| self.members.get(&(at, member))) {
                        let dot = if name.is_empty() { "" } else { "." };
                        name = format!("{name}{dot}{member}");
                    }
                    at = *next;
                    continue;
                }
                Some(Type::Array(element, length)) => {
                    at = element;
                    let literal = self.constants.get(&length);
                    let is_inside = literal.zip(constant).is_some_and(|(length, index)| index < *length);
                    if is_inside { None } else { self.unsigned(length, writer, function) }
                }
                Some(Type::Vector(part, count)) => {
                    at = part;
                    if constant.is_some_and(|index| index < count) { None } else { Some(writer.constant(count)) }
                }
                Some(Type::RuntimeArray(element)) => {
                    at = element;
                    Self::length(class, (base, indices), around, writer, function)
                }
                _ => break,
            };
            around = None;
            if let Some(size) = size
                && let Some(index) = self.unsigned(*index, writer, function)
            {
                let access = Access {
                    name: name.clone(),
                    kind: AccessKind::Element,
                    writes: self.written.contains(&id),
                    line: line.cloned(),
                    first_word: 0,
                };
                self.call(access, &[index, size], writer, function)?;
            }
            name.push_str("[]");
        }
        self.names.insert(id, name);
        self.chains.insert(known, (id, before..self.found.len()));
        Ok(())
    }

    /// Writes the number of elements of a runtime array that is the last member of a storage buffer.
    fn length(
        class: u32,
        (base, indices): (u32, &[u32]),
        around: Option<(usize, u32, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Option<u32> {
        let (position, block, member) = around?;
        let buffers = [StorageClass::StorageBuffer, StorageClass::Uniform].map(|class| class as u32);
        if !buffers.contains(&class) {
            return None;
        }
        let pointer = if position == 0 {
            base
        } else {
            let ty = writer.additions.ty(Op::TypePointer, &[class, block]);
            let pointer = writer.additions.id();
            write(Op::AccessChain, &[&[ty, pointer, base], &indices[..position]].concat(), function);
            pointer
        };
        let length = writer.additions.id();
        write(Op::ArrayLength, &[writer.uint, length, pointer, member], function);
        Some(length)
    }

    /// The check of the coordinates of a texel. Of a sampled image the level is given.
    fn texel(
        &mut self,
        (image, level): (u32, Option<u32>),
        coordinate: u32,
        writes: bool,
        line: Option<&(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        let Some(Type::Image(count @ 1.., samples)) = self.type_of(image) else { return Ok(()) };
        let given = match self.type_of(coordinate) {
            Some(Type::Integer(32, _)) => 1,
            Some(Type::Vector(part, given)) if matches!(self.types.get(&part), Some(Type::Integer(32, _))) => given,
            _ => return Ok(()),
        };
        if given < count {
            return Ok(());
        }
        writer.needs_queries();
        let uint = writer.uint;
        let ty = if count == 1 { uint } else { writer.additions.ty(Op::TypeVector, &[uint, count]) };
        let size = writer.additions.id();
        match level.filter(|_| !samples) {
            Some(level) => write(Op::ImageQuerySizeLod, &[ty, size, image, level], function),
            None => write(Op::ImageQuerySize, &[ty, size, image], function),
        }
        let mut words = Vec::new();
        for (value, has) in [(coordinate, given), (size, count)] {
            let part = match self.type_of(value) {
                Some(Type::Vector(part, _)) => part,
                _ => uint,
            };
            for component in 0..count {
                let mut scalar = value;
                if has > 1 {
                    scalar = writer.additions.id();
                    write(Op::CompositeExtract, &[part, scalar, value, component], function);
                    self.values.insert(scalar, part);
                }
                let word = if value == size { Some(scalar) } else { self.unsigned(scalar, writer, function) };
                words.extend(word);
            }
        }
        let name = self.names.get(&image).cloned().unwrap_or_default();
        let access = Access { name, kind: AccessKind::Texel(count), writes, line: line.cloned(), first_word: 0 };
        self.call(access, &words, writer, function)
    }

    /// Writes the call that checks an access: coordinates, then sizes.
    fn call(
        &mut self,
        access: Access,
        words: &[u32],
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        if self.found.len() == MAX_ACCESSES {
            let reason = format!("the shader has more than {MAX_ACCESSES} accesses to check");
            return unsupported(reason, access.line);
        }
        let first_word = writer.part(RECORDS, access.words());
        let (checker, first) = (self.checker(access.kind.coordinates(), writer), writer.constant(first_word));
        let result = writer.additions.id();
        write(Op::FunctionCall, &[&[writer.void, result, checker, first], words].concat(), function);
        self.found.push(Access { first_word, ..access });
        Ok(())
    }

    /// The function that records coordinates outside of an image.
    fn checker(&mut self, count: u32, writer: &mut Writer) -> u32 {
        if let Some(known) = self.checkers.get(&count) {
            return *known;
        }
        let (void, bool, uint) = (writer.void, writer.bool, writer.uint);
        let recorder = writer.recorder(2 * count as usize, RECORDS);
        let values = vec![uint; 2 * count as usize + 1];
        let ty = writer.additions.ty(Op::TypeFunction, &[&[void], values.as_slice()].concat());
        let mut body = Vec::new();
        let mut op = |op: Op, operands: &[u32]| write(op, operands, &mut body);
        let additions = &mut writer.additions;
        let [function, start, then, end, recorded] = [(); 5].map(|()| additions.id());
        let parameters: Vec<u32> = values.iter().map(|_| additions.id()).collect();
        op(Op::Function, &[void, function, FunctionControl::NONE.bits(), ty]);
        for parameter in &parameters {
            op(Op::FunctionParameter, &[uint, *parameter]);
        }
        op(Op::Label, &[start]);
        let (coordinates, sizes) = parameters[1..].split_at(count as usize);
        let mut beyond = None;
        for (coordinate, size) in coordinates.iter().zip(sizes) {
            let one = additions.id();
            op(Op::UGreaterThanEqual, &[bool, one, *coordinate, *size]);
            beyond = Some(match beyond {
                None => one,
                Some(others) => {
                    let any = additions.id();
                    op(Op::LogicalOr, &[bool, any, others, one]);
                    any
                }
            });
        }
        let beyond = beyond.expect("an element has one coordinate, and `texel` checks no image with none");
        op(Op::SelectionMerge, &[end, SelectionControl::NONE.bits()]);
        op(Op::BranchConditional, &[beyond, then, end]);
        op(Op::Label, &[then]);
        op(Op::FunctionCall, &[&[void, recorded, recorder], parameters.as_slice()].concat());
        op(Op::Branch, &[end]);
        op(Op::Label, &[end]);
        op(Op::Return, &[]);
        op(Op::FunctionEnd, &[]);
        writer.functions.extend_from_slice(&body);
        self.checkers.insert(count, function);
        function
    }

    /// A value as an unsigned integer of 32 bits; `None` of any other width.
    fn unsigned(&self, value: u32, writer: &mut Writer, function: &mut Vec<u32>) -> Option<u32> {
        match self.type_of(value)? {
            Type::Integer(32, false) => Some(value),
            Type::Integer(32, true) => {
                let word = writer.additions.id();
                write(Op::Bitcast, &[writer.uint, word, value], function);
                Some(word)
            }
            _ => None,
        }
    }

    fn type_of(&self, value: u32) -> Option<Type<'w>> {
        self.values.get(&value).and_then(|ty| self.types.get(ty)).copied()
    }

    fn rename(&mut self, id: u32, from: u32) {
        if let Some(name) = self.names.get(&from).cloned() {
            self.names.insert(id, name);
        }
    }
}
