//! Calls whose result GLSL and SPIR-V leave undefined for all their other arguments: `smoothstep` with edges that do not ascend, `clamp`
//! with bounds that do not, integers divided by zero or shifted by their width. Drivers differ there, and report nothing. The
//! rules are those of the extended instructions of GLSL (`GLSL.std.450`) and of the core specification, sections 3.42.13 and 3.42.14.

use std::collections::HashMap;

use spirv::{GLOp, Op};

use crate::instruction::Instruction;

/// A call with an undefined result, or one that no driver needs to agree with another about.
#[derive(Clone, Debug, PartialEq)]
pub struct Undefined {
    /// The name in GLSL: `smoothstep`, `clamp`, `/`, `%`, `<<`, `>>`, `bitfieldInsert`, `bitfieldExtract`.
    pub operation: &'static str,
    /// The two facts that disagree, in words.
    pub reason: String,
    /// The file as the module names it, and the line, counted from 1. `None` in a module without line numbers.
    pub line: Option<(String, u32)>,
}

/// The undefined calls in the functions that the entry point reaches.
pub(crate) fn undefined<'w>(
    declarations: &[Instruction<'_>],
    bodies: impl Iterator<Item = &'w [Instruction<'w>]>,
) -> Vec<Undefined> {
    let constants = Constants::of(declarations);
    let mut found = Vec::new();
    for body in bodies {
        let mut line = None;
        for instruction in body {
            match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::Line), [file, number, ..]) => line = Some((*file, *number)),
                (Some(Op::NoLine | Op::Label), _) => line = None,
                _ => {}
            }
            if let Some((operation, reason)) = constants.judge(instruction) {
                let named = |(file, number)| Some((constants.strings.get(&file)?.clone(), number));
                found.push(Undefined { operation, reason, line: line.and_then(named) });
            }
        }
    }
    found
}

/// The constants of a module, lane by lane.
#[derive(Default)]
struct Constants {
    /// Integers by their bits, floats as they are; both are exact in `f64` up to 32 bits.
    lanes: HashMap<u32, Vec<f64>>,
    strings: HashMap<u32, String>,
    /// Width in bits of scalar types, and of the components of vectors.
    widths: HashMap<u32, u32>,
    glsl: Option<u32>,
}

impl Constants {
    fn of(declarations: &[Instruction<'_>]) -> Self {
        let mut known = Self::default();
        let mut floats: HashMap<u32, u32> = HashMap::new();
        for instruction in declarations {
            match (Op::from_u32(instruction.opcode), instruction.operands) {
                (Some(Op::ExtInstImport), [id, name @ ..]) if text(name) == "GLSL.std.450" => known.glsl = Some(*id),
                (Some(Op::String), [id, words @ ..]) => {
                    known.strings.insert(*id, text(words));
                }
                (Some(Op::TypeInt), [id, width, ..]) => {
                    known.widths.insert(*id, *width);
                }
                (Some(Op::TypeFloat), [id, width, ..]) => {
                    floats.insert(*id, *width);
                }
                (Some(Op::TypeVector), [id, component, _]) => {
                    if let Some(width) = known.widths.get(component).copied() {
                        known.widths.insert(*id, width);
                    }
                }
                (Some(Op::Constant), [ty, id, value @ ..]) => {
                    let number = match (floats.get(ty), value) {
                        (Some(32), [bits]) => f64::from(f32::from_bits(*bits)),
                        (Some(64), [low, high]) => f64::from_bits(u64::from(*high) << 32 | u64::from(*low)),
                        (None, [bits]) => f64::from(*bits),
                        _ => continue,
                    };
                    known.lanes.insert(*id, vec![number]);
                }
                (Some(Op::ConstantComposite), [_, id, parts @ ..]) => {
                    let lanes: Option<Vec<&Vec<f64>>> = parts.iter().map(|part| known.lanes.get(part)).collect();
                    if let Some(lanes) = lanes {
                        known.lanes.insert(*id, lanes.into_iter().flatten().copied().collect());
                    }
                }
                _ => {}
            }
        }
        known
    }

    /// The operation and the fault of its arguments, if there is one.
    fn judge(&self, instruction: &Instruction<'_>) -> Option<(&'static str, String)> {
        let lanes = |id: &u32| self.lanes.get(id);
        let zero = |id: &u32| lanes(id).is_some_and(|lanes| lanes.contains(&0.0));
        let signed = |bits: f64| if bits >= f64::from(1u32 << 31) { bits - 4_294_967_296.0 } else { bits };
        match (Op::from_u32(instruction.opcode)?, instruction.operands) {
            (Op::ExtInst, [_, _, set, number, arguments @ ..]) if Some(*set) == self.glsl => {
                let number = GLOp::from_u32(*number)?;
                let (operation, low, high, strict) = match (number, arguments) {
                    (GLOp::SmoothStep, [low, high, _]) => ("smoothstep", low, high, true),
                    (GLOp::FClamp | GLOp::UClamp | GLOp::SClamp, [_, low, high]) => ("clamp", low, high, false),
                    _ => return None,
                };
                let read = |value: &f64| if number == GLOp::SClamp { signed(*value) } else { *value };
                let mut pairs = lanes(low)?.iter().map(read).zip(lanes(high)?.iter().map(read));
                let (low, high) = pairs.find(|(low, high)| if strict { low >= high } else { low > high })?;
                let (low, high) = (shown(low), shown(high));
                let reason = if strict {
                    format!("its first edge is {low} and its second one {high}; the first must be smaller")
                } else {
                    format!("its lower bound is {low} and its upper one {high}")
                };
                Some((operation, reason))
            }
            (Op::UDiv | Op::SDiv, [_, _, _, divisor]) if zero(divisor) => {
                Some(("/", "an integer is divided by 0".to_owned()))
            }
            (Op::UMod | Op::SMod | Op::SRem, [_, _, _, divisor]) if zero(divisor) => {
                Some(("%", "an integer is divided by 0".to_owned()))
            }
            (op @ (Op::ShiftLeftLogical | Op::ShiftRightLogical | Op::ShiftRightArithmetic), [ty, _, _, shift]) => {
                let width = *self.widths.get(ty)?;
                let by = lanes(shift)?.iter().copied().find(|by| *by >= f64::from(width))?;
                let sign = if op == Op::ShiftLeftLogical { "<<" } else { ">>" };
                Some((sign, format!("an integer of {width} bits is shifted by {}", signed(by))))
            }
            (Op::BitFieldInsert, [ty, _, _, _, offset, count]) => self.field("bitfieldInsert", *ty, *offset, *count),
            (Op::BitFieldSExtract | Op::BitFieldUExtract, [ty, _, _, offset, count]) => {
                self.field("bitfieldExtract", *ty, *offset, *count)
            }
            _ => None,
        }
    }

    /// A field of bits that leaves its integer.
    fn field(&self, operation: &'static str, ty: u32, offset: u32, count: u32) -> Option<(&'static str, String)> {
        let width = *self.widths.get(&ty)?;
        let one = |id: u32| self.lanes.get(&id).and_then(|lanes| lanes.first()).copied();
        let (offset, count) = (one(offset)?, one(count)?);
        (offset + count > f64::from(width))
            .then(|| (operation, format!("{count} bits from bit {offset} on leave an integer of {width} bits")))
    }
}

/// A number as the shader has it: a fraction that came from 32 bits has no more digits than those bits hold.
#[expect(clippy::cast_possible_truncation, reason = "whether the number survives the cast is what is asked")]
fn shown(number: f64) -> String {
    let narrow = number as f32;
    if number.fract() != 0.0 && f64::from(narrow).to_bits() == number.to_bits() {
        narrow.to_string()
    } else {
        number.to_string()
    }
}

/// A literal string: bytes in words, the first byte lowest, ended by a zero (section 2.2.1).
fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
