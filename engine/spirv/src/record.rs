//! Records that a shader writes into a storage buffer, which the caller binds: its prints, its accesses out of bounds, and its writes of one
//! texel.
//!
//! The buffer begins with a word that numbers the records in the order in which they are written. Then each call has a part of its own: the
//! number of times that it was reached, and its first records. A record is its number, the three components of `gl_GlobalInvocationID`, and
//! the words of the values. A call that records in every invocation therefore leaves the others their room.

use std::collections::HashMap;

use spirv::{BuiltIn, Capability, Decoration, FunctionControl, MemoryModel, Op, Scope, SelectionControl, StorageClass};

use crate::accesses::{Access, Accesses};
use crate::additions::{Additions, built_in, write};
use crate::check::literal;
use crate::instruction::Instruction;
use crate::print::{self, PrintCall, PrintError, PrintedScalar, PrintedType, unsupported};
use crate::writes::{TexelWrites, Writes};

/// Words of a record before its values: its number, and the invocation.
pub const RECORD_HEAD: u32 = 4;

/// What a module records besides its prints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Checks {
    /// Its accesses out of bounds.
    pub bounds: bool,
    /// Its writes of one texel.
    pub writes: bool,
}

impl Checks {
    /// Whether it records anything.
    pub fn any(self) -> bool {
        self.bounds || self.writes
    }
}

/// A module that records its prints, accesses and writes.
#[derive(Debug)]
pub struct Recording {
    /// The module.
    pub words: Vec<u32>,
    /// The calls that print, in the order of the module.
    pub calls: Vec<PrintCall>,
    /// The accesses that are checked, in the order of the module.
    pub accesses: Vec<Access>,
    /// The writes to storage images that are compared with a texel, if there are any.
    pub writes: Option<TexelWrites>,
    /// Bytes of the buffer.
    pub bytes: u64,
}

/// The module that records into the storage buffer at `binding` of set 0 its prints and what `checks` asks for; `None` when it records
/// nothing.
///
/// # Errors
/// For printed values that are no numbers of 32 bits, booleans or vectors of them, and for modules with too many calls, accesses or writes.
pub(crate) fn recording(
    words: &[u32],
    instructions: &[Instruction<'_>],
    binding: u32,
    checks: Checks,
) -> Result<Option<Recording>, PrintError> {
    let set = print::set(instructions);
    if set.is_none() && !checks.any() {
        return Ok(None);
    }
    let split = instructions.iter().position(|instruction| instruction.is(Op::Function)).unwrap_or(instructions.len());
    let (declarations, functions) = instructions.split_at(split);
    let mut writer = Writer::new(words, declarations, binding)?;
    let strings = strings(declarations);
    let mut calls = print::Calls::new(declarations, strings.clone());
    let mut accesses = checks.bounds.then(|| Accesses::new(instructions));
    let mut writes = if checks.writes { Writes::new(instructions, &mut writer) } else { None };
    let mut line = None;
    let mut rewritten = Vec::new();
    for instruction in functions {
        calls.value(instruction);
        match instruction.operands {
            [file, number, ..] if instruction.is(Op::Line) => {
                line = strings.get(file).map(|file| (file.clone(), *number));
            }
            // glslang repeats a line only where it is another one, in the order of the module and across its blocks.
            _ if instruction.is(Op::NoLine) || instruction.is(Op::Function) => line = None,
            [void, result, from, print::PRINTF, text, values @ ..]
                if instruction.is(Op::ExtInst) && Some(*from) == set =>
            {
                calls.replace((*void, *result), *text, values, line.clone(), &mut writer, &mut rewritten)?;
                continue;
            }
            _ => {}
        }
        if let Some(accesses) = &mut accesses {
            accesses.check(instruction, line.as_ref(), &mut writer, &mut rewritten)?;
        }
        if let Some(writes) = &mut writes {
            writes.before(instruction, &mut writer, &mut rewritten);
        }
        instruction.write(&mut rewritten);
        if let Some(writes) = &mut writes {
            writes.after(instruction, line.as_ref(), &mut writer, &mut rewritten)?;
        }
    }
    let (calls, accesses) = (calls.found, accesses.map(|accesses| accesses.found).unwrap_or_default());
    let writes = writes.and_then(Writes::found);
    if calls.is_empty() && accesses.is_empty() && writes.is_none() {
        return Ok(None);
    }
    let words = writer.assemble(words, declarations, set, &rewritten)?;
    Ok(Some(Recording { words, calls, accesses, writes, bytes: 4 * u64::from(writer.end) }))
}

fn strings(declarations: &[Instruction<'_>]) -> HashMap<u32, String> {
    let strings = declarations.iter().filter(|instruction| instruction.is(Op::String));
    let texts = strings.filter_map(|instruction| instruction.operands.split_first());
    texts.filter_map(|(id, text)| Some((*id, literal(text).ok()?))).collect()
}

/// Writes the functions that record, and their declarations.
pub(crate) struct Writer {
    pub additions: Additions,
    /// Functions that stand behind those of the module.
    pub functions: Vec<u32>,
    /// By number of words, and by the records that are kept.
    recorders: HashMap<(usize, u32), u32>,
    /// The first word behind the parts of the calls so far.
    end: u32,
    /// The module asks images for their extents.
    queries: bool,
    /// Entry points list all their variables, not inputs and outputs only.
    lists_all: bool,
    pub void: u32,
    pub bool: u32,
    pub uint: u32,
    triple: u32,
    /// The variable of the buffer, and the type of a pointer to a word of it.
    pub buffer: u32,
    pub word: u32,
    /// `gl_GlobalInvocationID`.
    invocation: u32,
    scope: u32,
}

impl Writer {
    pub(crate) fn new(words: &[u32], declarations: &[Instruction<'_>], binding: u32) -> Result<Self, PrintError> {
        let mut additions = Additions::new(words[3], declarations);
        let void = additions.ty(Op::TypeVoid, &[]);
        let bool = additions.ty(Op::TypeBool, &[]);
        let uint = additions.ty(Op::TypeInt, &[32, 0]);
        let triple = additions.ty(Op::TypeVector, &[uint, 3]);
        let [array, block, pointer, buffer] = [(); 4].map(|()| additions.id());
        let mut decorate = |operands: &[u32]| write(Op::Decorate, operands, &mut additions.decorations);
        decorate(&[array, Decoration::ArrayStride as u32, 4]);
        decorate(&[block, Decoration::Block as u32]);
        decorate(&[buffer, Decoration::DescriptorSet as u32, 0]);
        decorate(&[buffer, Decoration::Binding as u32, binding]);
        write(Op::MemberDecorate, &[block, 0, Decoration::Offset as u32, 0], &mut additions.decorations);
        let storage = StorageClass::StorageBuffer as u32;
        write(Op::TypeRuntimeArray, &[array, uint], &mut additions.words);
        write(Op::TypeStruct, &[block, array], &mut additions.words);
        write(Op::TypePointer, &[pointer, storage, block], &mut additions.words);
        write(Op::Variable, &[pointer, buffer, storage], &mut additions.words);
        let word = additions.ty(Op::TypePointer, &[storage, uint]);
        let input = additions.ty(Op::TypePointer, &[StorageClass::Input as u32, triple]);
        let invocation = match built_in(declarations, BuiltIn::GlobalInvocationId) {
            Some((variable, ty)) if ty == input => variable,
            Some(_) => return unsupported("`gl_GlobalInvocationID` is no vector of three `uint`", None),
            None => {
                let variable = additions.id();
                let built_in = [variable, Decoration::BuiltIn as u32, BuiltIn::GlobalInvocationId as u32];
                write(Op::Decorate, &built_in, &mut additions.decorations);
                write(Op::Variable, &[input, variable, StorageClass::Input as u32], &mut additions.words);
                variable
            }
        };
        // Before version 1.4 an entry point lists inputs and outputs only.
        let lists_all = words[1] >= 0x0001_0400;
        additions.interface = if lists_all { vec![invocation, buffer] } else { vec![invocation] };
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
            functions,
            recorders,
            end: 1,
            queries: false,
            lists_all,
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

    pub(crate) fn constant(&mut self, value: u32) -> u32 {
        self.additions.constant(self.uint, value)
    }

    /// The first word of a new part: of a call that keeps `records` records, each with `words` words of values.
    pub(crate) fn part(&mut self, records: u32, words: u32) -> u32 {
        let first = self.end;
        self.end += 1 + records * (RECORD_HEAD + words);
        first
    }

    /// The word at which the words of a texel begin that the caller puts into the buffer.
    pub(crate) fn words_of_texel(&self) -> u32 {
        self.end
    }

    /// Parts begin at this word from here on.
    pub(crate) fn reserve(&mut self, end: u32) {
        self.end = end;
    }

    /// A variable of an invocation: a `uint`.
    pub(crate) fn private(&mut self) -> u32 {
        let class = StorageClass::Private as u32;
        let pointer = self.additions.ty(Op::TypePointer, &[class, self.uint]);
        let variable = self.additions.id();
        write(Op::Variable, &[pointer, variable, class], &mut self.additions.words);
        if self.lists_all {
            self.additions.interface.push(variable);
        }
        variable
    }

    /// The module will ask images for their extents.
    pub(crate) fn needs_queries(&mut self) {
        self.queries = true;
    }

    /// The module with all that was written.
    fn assemble(
        &mut self,
        words: &[u32],
        declarations: &[Instruction<'_>],
        set: Option<u32>,
        functions: &[u32],
    ) -> Result<Vec<u32>, PrintError> {
        let query = Capability::ImageQuery as u32;
        let has_query = declarations.iter().any(|of| of.is(Op::Capability) && of.operands == [query]);
        if self.queries && !has_query {
            write(Op::Capability, &[query], &mut self.additions.capabilities);
        }
        let is_set =
            |of: &&Instruction<'_>| of.is(Op::ExtInstImport) && set.is_some() && of.operands.first() == set.as_ref();
        let declarations: Vec<Instruction<'_>> = declarations.iter().filter(|of| !is_set(of)).copied().collect();
        let functions = [functions, &self.functions].concat();
        self.additions.assemble(words, &declarations, &functions).or_else(|reason| unsupported(reason, None))
    }

    /// Takes a value apart into words.
    pub(crate) fn words(
        &mut self,
        value: u32,
        ty: PrintedType,
        part: u32,
        words: &mut Vec<u32>,
        function: &mut Vec<u32>,
    ) {
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

    /// The function that records `count` words, and keeps `records` records. Its first parameter is the word at which the part of the call
    /// begins.
    #[expect(clippy::cast_possible_truncation, reason = "a call has at most `MAX_WORDS` words")]
    pub(crate) fn recorder(&mut self, count: usize, records: u32) -> u32 {
        if let Some(known) = self.recorders.get(&(count, records)) {
            return *known;
        }
        let (void, bool, uint, word) = (self.void, self.bool, self.uint, self.word);
        let parameters = vec![uint; count + 1];
        let ty = self.additions.ty(Op::TypeFunction, &[&[void], parameters.as_slice()].concat());
        let [zero, one, room] = [0, 1, records].map(|value| self.constant(value));
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
        self.recorders.insert((count, records), function);
        function
    }
}
