//! Output of shaders. `debugPrintfEXT` compiles to an instruction that drivers ignore. Here each of these calls becomes a call of a function
//! that writes a record into a storage buffer, which the caller binds: so shaders print on every device, without an extension of the driver.
//!
//! The buffer begins with a word that numbers the records in the order in which they are written. Then each call has a part of its own: the
//! number of times that it was reached, and the first [`RECORDS`] records. A record is its number, the three components of
//! `gl_GlobalInvocationID`, and the words of the values. A call that prints in every invocation therefore leaves the others their room.

use std::collections::HashMap;

use spirv::{BuiltIn, Decoration, FunctionControl, MemoryModel, Op, Scope, SelectionControl, StorageClass};

use crate::additions::{Additions, interface, is_declaration, write};
use crate::binary::HEADER_WORDS;
use crate::check::{MAX_BOUND, literal};
use crate::instruction::{Instruction, MAX_OPERANDS};

/// Records of one call that the buffer has room for, in one run of the pass.
pub const RECORDS: u32 = 256;

/// Words of a record before its values: its number, and the invocation.
pub const RECORD_HEAD: u32 = 4;

/// Most calls of a module, and most words of the values of one.
const MAX_CALLS: usize = 256;
const MAX_WORDS: u32 = 64;

/// The set of instructions that `debugPrintfEXT` compiles to, and its only instruction.
const PRINTF_SET: &str = "NonSemantic.DebugPrintf";
const PRINTF: u32 = 1;

/// A module that writes what it prints.
#[derive(Debug)]
pub struct Printing {
    /// The module.
    pub words: Vec<u32>,
    /// The calls that print, in the order of the module.
    pub calls: Vec<PrintCall>,
    /// Bytes of the buffer.
    pub bytes: u64,
}

/// One call that prints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintCall {
    /// The text with its conversions.
    pub format: String,
    /// The types of the values.
    pub values: Vec<PrintedType>,
    /// The file as the module names it, and the line, counted from 1. `None` in a module without line numbers.
    pub line: Option<(String, u32)>,
    /// The word of the buffer that counts how often the call was reached; its records follow.
    pub first_word: u32,
}

impl PrintCall {
    /// Words of one record.
    pub fn stride(&self) -> u32 {
        RECORD_HEAD + self.values.iter().map(|value| value.components).sum::<u32>()
    }
}

/// A scalar, or a vector of 2 to 4 of them. Each component takes a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrintedType {
    /// The component.
    pub scalar: PrintedScalar,
    /// How many.
    pub components: u32,
}

/// A component of a printed value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintedScalar {
    /// 0 or 1.
    Bool,
    /// 32 bits, signed.
    Int,
    /// 32 bits, unsigned.
    Uint,
    /// 32 bits.
    Float,
}

/// The module that writes what it prints into the storage buffer at `binding` of set 0; `None` when it prints nothing.
///
/// # Errors
/// For values that are no numbers of 32 bits, booleans or vectors of them, and for modules with too many calls.
pub(crate) fn printing(
    words: &[u32],
    instructions: &[Instruction<'_>],
    binding: u32,
) -> Result<Option<Printing>, PrintError> {
    let Some(set) = printf_set(instructions) else { return Ok(None) };
    let split = instructions.iter().position(|instruction| instruction.is(Op::Function)).unwrap_or(instructions.len());
    let (declarations, functions) = instructions.split_at(split);
    let mut writer = Writer::new(words, declarations, binding)?;
    let mut calls = Calls { shapes: Shapes::of(declarations), strings: strings(declarations), ..Calls::default() };
    let mut rewritten = Vec::new();
    for instruction in functions {
        calls.shapes.value(instruction);
        match instruction.operands {
            [file, line, ..] if instruction.is(Op::Line) => {
                calls.line = calls.strings.get(file).map(|file| (file.clone(), *line));
            }
            _ if instruction.is(Op::NoLine) || instruction.is(Op::Label) => calls.line = None,
            [void, result, from, PRINTF, text, values @ ..] if instruction.is(Op::ExtInst) && *from == set => {
                calls.replace((*void, *result), *text, values, &mut writer, &mut rewritten)?;
                continue;
            }
            _ => {}
        }
        instruction.write(&mut rewritten);
    }
    if calls.found.is_empty() {
        return Ok(None);
    }
    if writer.additions.next_id > MAX_BOUND {
        return unsupported("the module leaves no ids for it", None);
    }
    let mut printing = words[..HEADER_WORDS].to_vec();
    printing[3] = writer.additions.next_id;
    let types = declarations.iter().position(is_declaration).unwrap_or(declarations.len());
    for (at, instruction) in declarations.iter().enumerate() {
        if at == types {
            printing.extend_from_slice(&writer.decorations);
        }
        let is_set = instruction.is(Op::ExtInstImport) && instruction.operands.first() == Some(&set);
        if is_set {
            continue;
        }
        if instruction.is(Op::EntryPoint) {
            let listed = interface(instruction.operands);
            let missing = writer.interface.iter().filter(|variable| !listed.contains(variable));
            let operands: Vec<u32> = instruction.operands.iter().chain(missing).copied().collect();
            if operands.len() > MAX_OPERANDS {
                return unsupported("the entry point has too many variables", None);
            }
            Instruction { opcode: instruction.opcode, operands: &operands }.write(&mut printing);
        } else {
            instruction.write(&mut printing);
        }
    }
    printing.extend_from_slice(&writer.additions.words);
    printing.extend_from_slice(&rewritten);
    printing.extend_from_slice(&writer.functions);
    let bytes = 4 * u64::from(calls.end());
    Ok(Some(Printing { words: printing, calls: calls.found, bytes }))
}

/// The id of the set of instructions that print, if the module has it.
fn printf_set(instructions: &[Instruction<'_>]) -> Option<u32> {
    instructions.iter().find_map(|instruction| match instruction.operands {
        [id, name @ ..] if instruction.is(Op::ExtInstImport) => {
            (literal(name).ok().as_deref() == Some(PRINTF_SET)).then_some(*id)
        }
        _ => None,
    })
}

/// Whether words are of a module that may print. Of broken ones it says no.
pub fn prints(words: &[u32]) -> bool {
    let bytes = PRINTF_SET.as_bytes();
    words.iter().enumerate().any(|(at, first)| {
        first.to_le_bytes() == bytes[..4]
            && words[at..].iter().flat_map(|word| word.to_le_bytes()).take(bytes.len()).eq(bytes.iter().copied())
    })
}

fn strings(declarations: &[Instruction<'_>]) -> HashMap<u32, String> {
    let strings = declarations.iter().filter(|instruction| instruction.is(Op::String));
    let texts = strings.filter_map(|instruction| instruction.operands.split_first());
    texts.filter_map(|(id, text)| Some((*id, literal(text).ok()?))).collect()
}

/// Why what a module prints cannot be written down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintError {
    /// What is wrong, and what to do.
    pub reason: String,
    /// The call, if it is one.
    pub line: Option<(String, u32)>,
}

fn unsupported<T>(reason: impl Into<String>, line: Option<(String, u32)>) -> Result<T, PrintError> {
    Err(PrintError { reason: reason.into(), line })
}

/// Types that can be printed, and the values that have one.
#[derive(Default)]
struct Shapes {
    /// With the type of the component.
    types: HashMap<u32, (PrintedType, u32)>,
    /// Types of values.
    values: HashMap<u32, u32>,
}

impl Shapes {
    fn of(declarations: &[Instruction<'_>]) -> Self {
        let mut shapes = Self::default();
        for instruction in declarations {
            let scalar = match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::TypeBool), [_]) => PrintedScalar::Bool,
                (Some(Op::TypeInt), [_, 32, 0]) => PrintedScalar::Uint,
                (Some(Op::TypeInt), [_, 32, _]) => PrintedScalar::Int,
                (Some(Op::TypeFloat), [_, 32, ..]) => PrintedScalar::Float,
                (Some(Op::TypeVector), [id, part, components @ 2..=4]) => {
                    if let Some((PrintedType { scalar, components: 1 }, _)) = shapes.types.get(part).copied() {
                        shapes.types.insert(*id, (PrintedType { scalar, components: *components }, *part));
                    }
                    continue;
                }
                _ => {
                    let constant = Op::ConstantTrue as u32..=Op::SpecConstantOp as u32;
                    if constant.contains(&instruction.opcode) || instruction.is(Op::Undef) {
                        shapes.value(instruction);
                    }
                    continue;
                }
            };
            let id = instruction.operands[0];
            shapes.types.insert(id, (PrintedType { scalar, components: 1 }, id));
        }
        shapes
    }

    /// Remembers the type of a result. In a function a type only ever comes first as the type of a result.
    fn value(&mut self, instruction: &Instruction<'_>) {
        if let [ty, id, ..] = instruction.operands
            && self.types.contains_key(ty)
        {
            self.values.insert(*id, *ty);
        }
    }
}

/// The calls that print, as they are met.
#[derive(Default)]
struct Calls {
    shapes: Shapes,
    strings: HashMap<u32, String>,
    line: Option<(String, u32)>,
    found: Vec<PrintCall>,
}

impl Calls {
    /// The first word behind the parts of the calls so far.
    fn end(&self) -> u32 {
        self.found.last().map_or(1, |call| call.first_word + 1 + RECORDS * call.stride())
    }

    /// Writes the call of a function that records in the place of one that prints.
    fn replace(
        &mut self,
        (void, result): (u32, u32),
        text: u32,
        values: &[u32],
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
        let line = self.line.clone();
        let Some(format) = self.strings.get(&text).cloned() else {
            return unsupported("it has no text", line);
        };
        if self.found.len() == MAX_CALLS {
            return unsupported(format!("the shader has more than {MAX_CALLS} such calls"), line);
        }
        let mut types = Vec::with_capacity(values.len());
        let mut words = Vec::new();
        for (value, number) in values.iter().zip(1..) {
            let shape = self.shapes.values.get(value).and_then(|ty| self.shapes.types.get(ty));
            let Some((ty, part)) = shape.copied() else {
                let reason = format!("value {number} is no 32-bit number, `bool` or vector of them");
                return unsupported(reason, line);
            };
            types.push(ty);
            writer.words(*value, ty, part, &mut words, function);
        }
        if words.len() > MAX_WORDS as usize {
            return unsupported(format!("its values have {} components, more than {MAX_WORDS}", words.len()), line);
        }
        let first_word = self.end();
        let recorder = writer.recorder(words.len());
        let at = writer.constant(first_word);
        write(Op::FunctionCall, &[&[void, result, recorder, at], words.as_slice()].concat(), function);
        self.found.push(PrintCall { format, values: types, line, first_word });
        Ok(())
    }
}

/// Writes the functions that record, and what they need.
struct Writer {
    additions: Additions,
    decorations: Vec<u32>,
    functions: Vec<u32>,
    /// By number of words.
    recorders: HashMap<usize, u32>,
    /// Variables that an entry point has to list.
    interface: Vec<u32>,
    void: u32,
    bool: u32,
    uint: u32,
    triple: u32,
    /// The variable of the buffer, and the type of a pointer to a word of it.
    buffer: u32,
    word: u32,
    /// `gl_GlobalInvocationID`.
    invocation: u32,
    scope: u32,
}

impl Writer {
    fn new(words: &[u32], declarations: &[Instruction<'_>], binding: u32) -> Result<Self, PrintError> {
        let mut decorations = Vec::new();
        let mut additions = Additions::new(words[3], declarations);
        let void = additions.ty(Op::TypeVoid, &[]);
        let bool = additions.ty(Op::TypeBool, &[]);
        let uint = additions.ty(Op::TypeInt, &[32, 0]);
        let triple = additions.ty(Op::TypeVector, &[uint, 3]);
        let [array, block, pointer, buffer] = [(); 4].map(|()| additions.id());
        let mut decorate = |operands: &[u32]| write(Op::Decorate, operands, &mut decorations);
        decorate(&[array, Decoration::ArrayStride as u32, 4]);
        decorate(&[block, Decoration::Block as u32]);
        decorate(&[buffer, Decoration::DescriptorSet as u32, 0]);
        decorate(&[buffer, Decoration::Binding as u32, binding]);
        write(Op::MemberDecorate, &[block, 0, Decoration::Offset as u32, 0], &mut decorations);
        let storage = StorageClass::StorageBuffer as u32;
        write(Op::TypeRuntimeArray, &[array, uint], &mut additions.words);
        write(Op::TypeStruct, &[block, array], &mut additions.words);
        write(Op::TypePointer, &[pointer, storage, block], &mut additions.words);
        write(Op::Variable, &[pointer, buffer, storage], &mut additions.words);
        let word = additions.ty(Op::TypePointer, &[storage, uint]);
        let input = additions.ty(Op::TypePointer, &[StorageClass::Input as u32, triple]);
        let invocation = match global_invocation(declarations) {
            Some((variable, ty)) if ty == input => variable,
            Some(_) => return unsupported("`gl_GlobalInvocationID` is no vector of three `uint`", None),
            None => {
                let variable = additions.id();
                let built_in = [variable, Decoration::BuiltIn as u32, BuiltIn::GlobalInvocationId as u32];
                write(Op::Decorate, &built_in, &mut decorations);
                write(Op::Variable, &[input, variable, StorageClass::Input as u32], &mut additions.words);
                variable
            }
        };
        // Before version 1.4 an entry point lists inputs and outputs only.
        let lists_all = words[1] >= 0x0001_0400;
        let interface = if lists_all { vec![invocation, buffer] } else { vec![invocation] };
        let vulkan = declarations.iter().any(|instruction| {
            instruction.is(Op::MemoryModel) && instruction.operands.get(1) == Some(&(MemoryModel::Vulkan as u32))
        });
        // With this memory model the scope of a device is a capability of its own.
        let scope = if vulkan { Scope::QueueFamily } else { Scope::Device };
        let scope = additions.constant(uint, scope as u32);
        let recorders = HashMap::new();
        let functions = Vec::new();
        Ok(Self {
            additions,
            decorations,
            functions,
            recorders,
            interface,
            void,
            bool,
            uint,
            triple,
            buffer,
            word,
            invocation,
            scope,
        })
    }

    fn constant(&mut self, value: u32) -> u32 {
        self.additions.constant(self.uint, value)
    }

    /// Takes a value apart into words.
    fn words(&mut self, value: u32, ty: PrintedType, part: u32, words: &mut Vec<u32>, function: &mut Vec<u32>) {
        for component in 0..ty.components {
            let scalar = if ty.components == 1 {
                value
            } else {
                let scalar = self.additions.id();
                write(Op::CompositeExtract, &[part, scalar, value, component], function);
                scalar
            };
            let word = if ty.scalar == PrintedScalar::Uint { scalar } else { self.additions.id() };
            match ty.scalar {
                PrintedScalar::Uint => {}
                PrintedScalar::Bool => {
                    let [one, zero] = [1, 0].map(|value| self.constant(value));
                    write(Op::Select, &[self.uint, word, scalar, one, zero], function);
                }
                PrintedScalar::Int | PrintedScalar::Float => {
                    write(Op::Bitcast, &[self.uint, word, scalar], function);
                }
            }
            words.push(word);
        }
    }

    /// The function that records so many words. Its first parameter is the word at which the part of the call begins.
    #[expect(clippy::cast_possible_truncation, reason = "a call has at most `MAX_WORDS` words")]
    fn recorder(&mut self, count: usize) -> u32 {
        if let Some(known) = self.recorders.get(&count) {
            return *known;
        }
        let (void, bool, uint, word) = (self.void, self.bool, self.uint, self.word);
        let parameters = vec![uint; count + 1];
        let ty = self.additions.ty(Op::TypeFunction, &[&[void], parameters.as_slice()].concat());
        let [zero, one, room] = [0, 1, RECORDS].map(|value| self.constant(value));
        let stride = self.constant(RECORD_HEAD + count as u32);
        let mut body = Vec::new();
        let mut op = |op: Op, operands: &[u32]| write(op, operands, &mut body);
        let additions = &mut self.additions;
        let [function, first, start, then, end] = [(); 5].map(|()| additions.id());
        op(Op::Function, &[void, function, FunctionControl::NONE.bits(), ty]);
        op(Op::FunctionParameter, &[uint, first]);
        let values: Vec<u32> = (0..count).map(|_| additions.id()).collect();
        for value in &values {
            op(Op::FunctionParameter, &[uint, *value]);
        }
        op(Op::Label, &[start]);
        let [counter, reached, fits] = [(); 3].map(|()| additions.id());
        op(Op::AccessChain, &[word, counter, self.buffer, zero, first]);
        op(Op::AtomicIAdd, &[uint, reached, counter, self.scope, zero, one]);
        op(Op::ULessThan, &[bool, fits, reached, room]);
        op(Op::SelectionMerge, &[end, SelectionControl::NONE.bits()]);
        op(Op::BranchConditional, &[fits, then, end]);
        op(Op::Label, &[then]);
        let [order, number, behind, within, mut at, id] = [(); 6].map(|()| additions.id());
        op(Op::AccessChain, &[word, order, self.buffer, zero, zero]);
        op(Op::AtomicIAdd, &[uint, number, order, self.scope, zero, one]);
        op(Op::IAdd, &[uint, behind, first, one]);
        op(Op::IMul, &[uint, within, reached, stride]);
        op(Op::IAdd, &[uint, at, behind, within]);
        op(Op::Load, &[self.triple, id, self.invocation]);
        let mut stored = vec![number];
        for component in 0..3 {
            let part = additions.id();
            op(Op::CompositeExtract, &[uint, part, id, component]);
            stored.push(part);
        }
        for (value, position) in stored.into_iter().chain(values).zip(0..) {
            if position > 0 {
                let next = additions.id();
                op(Op::IAdd, &[uint, next, at, one]);
                at = next;
            }
            let place = additions.id();
            op(Op::AccessChain, &[word, place, self.buffer, zero, at]);
            op(Op::Store, &[place, value]);
        }
        op(Op::Branch, &[end]);
        op(Op::Label, &[end]);
        op(Op::Return, &[]);
        op(Op::FunctionEnd, &[]);
        self.functions.extend_from_slice(&body);
        self.recorders.insert(count, function);
        function
    }
}

/// The variable that is `gl_GlobalInvocationID`, and the type of its pointer.
fn global_invocation(declarations: &[Instruction<'_>]) -> Option<(u32, u32)> {
    let id = declarations.iter().find_map(|instruction| match instruction.operands {
        [id, decoration, built_in] if instruction.is(Op::Decorate) => {
            let wanted = (Decoration::BuiltIn as u32, BuiltIn::GlobalInvocationId as u32);
            ((*decoration, *built_in) == wanted).then_some(*id)
        }
        _ => None,
    })?;
    declarations.iter().find_map(|instruction| match instruction.operands {
        [ty, variable, ..] if instruction.is(Op::Variable) && *variable == id => Some((id, *ty)),
        _ => None,
    })
}
