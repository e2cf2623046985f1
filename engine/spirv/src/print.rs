//! Output of shaders. `debugPrintfEXT` compiles to an instruction that drivers ignore. Here each of these calls becomes a call of a function
//! that writes a record into a storage buffer: so shaders print on every device, without an extension of the driver.

use std::collections::HashMap;

use spirv::Op;

use crate::additions::write;
use crate::check::literal;
use crate::instruction::Instruction;
use crate::record::{RECORD_HEAD, Writer};

/// Records of one call that the buffer has room for, in one run of the pass.
pub const RECORDS: u32 = 256;

/// Most calls of a module, and most words of the values of one.
const MAX_CALLS: usize = 256;
const MAX_WORDS: u32 = 64;

/// The set of instructions that `debugPrintfEXT` compiles to, and its only instruction.
const PRINTF_SET: &str = "NonSemantic.DebugPrintf";
pub(crate) const PRINTF: u32 = 1;

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

/// The id of the set of instructions that print, if the module has it.
pub(crate) fn set(instructions: &[Instruction<'_>]) -> Option<u32> {
    instructions.iter().find_map(|instruction| match instruction.operands {
        [id, name @ ..] if instruction.is(Op::ExtInstImport) => {
            (literal(name).ok().as_deref() == Some(PRINTF_SET)).then_some(*id)
        }
        _ => None,
    })
}

/// Whether words are of a module that may print. False for broken ones.
pub fn prints(words: &[u32]) -> bool {
    let bytes = PRINTF_SET.as_bytes();
    words.iter().enumerate().any(|(at, first)| {
        first.to_le_bytes() == bytes[..4]
            && words[at..].iter().flat_map(|word| word.to_le_bytes()).take(bytes.len()).eq(bytes.iter().copied())
    })
}

/// Why a print of a module cannot be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintError {
    /// The reason, and advice.
    pub reason: String,
    /// The call, if it is one.
    pub line: Option<(String, u32)>,
}

pub(crate) fn unsupported<T>(reason: impl Into<String>, line: Option<(String, u32)>) -> Result<T, PrintError> {
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
pub(crate) struct Calls {
    shapes: Shapes,
    strings: HashMap<u32, String>,
    pub found: Vec<PrintCall>,
}

impl Calls {
    pub(crate) fn new(declarations: &[Instruction<'_>], strings: HashMap<u32, String>) -> Self {
        Self { shapes: Shapes::of(declarations), strings, found: Vec::new() }
    }

    /// Remembers the type of a result.
    pub(crate) fn value(&mut self, instruction: &Instruction<'_>) {
        self.shapes.value(instruction);
    }

    /// Writes the call of a function that records in the place of one that prints.
    #[expect(clippy::cast_possible_truncation, reason = "a call has at most `MAX_WORDS` words")]
    pub(crate) fn replace(
        &mut self,
        (void, result): (u32, u32),
        text: u32,
        values: &[u32],
        line: Option<(String, u32)>,
        writer: &mut Writer,
        function: &mut Vec<u32>,
    ) -> Result<(), PrintError> {
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
        let first_word = writer.part(RECORDS, words.len() as u32);
        let recorder = writer.recorder(words.len(), RECORDS);
        let at = writer.constant(first_word);
        write(Op::FunctionCall, &[&[void, result, recorder, at], words.as_slice()].concat(), function);
        self.found.push(PrintCall { format, values: types, line, first_word });
        Ok(())
    }
}
